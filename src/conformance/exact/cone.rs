//! Rules of `ray_cone`: one rounding of the exact result.

use rtl_model::cone::{SmallFloat, StoreRounding};

use super::Case;
use super::sheet::Sheet;
use crate::base::num;
use crate::engine::tex::value;
use crate::reference::ray_cone::{Angle, Cone, Step, Width, ray_cone as exact_cone};

/// The operation of a case in doubles.
fn step(case: &Case<'_>) -> Option<Step> {
    let operand = |k: usize| {
        let word = case.input("operand", k)?;
        Some(f64::from_bits(word.cast_unsigned()))
    };
    Some(match case.input("operation", 0)? {
        0 => Step::Propagate(operand(0)?),
        1 => Step::Reflect(operand(0)?),
        2 => Step::Refract { curvature: operand(0)?, outside: operand(1)?, inside: operand(2)? },
        _ => Step::Scatter(operand(0)?),
    })
}

/// A code against the exact number, in ulp of the number's own binade.
fn code(sheet: &mut Sheet<'_>, format: SmallFloat, name: &'static str, code: i64, exact: f64) {
    let Ok(bits) = u32::try_from(code) else {
        return;
    };
    let held = value(format.unpack(bits).0);
    let largest = value(format.unpack(format.largest()).0);
    let want = exact.clamp(-largest, largest);
    let mantissa = i64::from(format.mantissa_bits);
    let place = if want == 0.0 {
        format.lowest_exponent()
    } else {
        (i64::from(libm::ilogb(want)) - mantissa).max(format.lowest_exponent())
    };
    let lsb = libm::ldexp(1.0, num::i32(place));
    let own = match sheet.config.policy.cone.rounding {
        StoreRounding::Rne => 0.5,
        StoreRounding::Truncate | StoreRounding::Stochastic => 1.0,
    };
    // The reference's own error.
    let slack = 1e-15 * (want / lsb).abs();
    sheet.number(name, code, [want / lsb, ((held - want) / lsb).abs(), own + slack]);
}

/// The stage.
pub(super) fn ray_cone(sheet: &mut Sheet<'_>, case: &Case<'_>) {
    let format = sheet.config.policy.cone.format.float();
    let input = |name: &str| {
        let bits = u32::try_from(case.input(name, 0)?).ok()?;
        Some(value(format.unpack(bits).0))
    };
    let (Some(angle), Some(width), Some(step)) = (input("angle_in"), input("width_in"), step(case))
    else {
        return;
    };
    let cone = Cone { angle: Angle(angle), width: Width(width) };
    let (rules, diffuse) = (sheet.config.policy.cone.rules, sheet.config.policy.cone.set_diffuse);
    let exact = exact_cone(cone, step, rules, diffuse);
    if let (Some(angle), Some(width)) = (case.output("angle"), case.output("width")) {
        code(sheet, format, "angle", angle, exact.angle.0);
        code(sheet, format, "width", width, exact.width.0);
    }
}
