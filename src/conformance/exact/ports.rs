//! Rules of ENV's input ports: one rounding from a binary64 word to a register.

use rtl_model::port::unpack;
use rtl_model::regs::Reg;

use super::Case;
use super::sheet::Sheet;
use crate::reference::wide::Wide;

/// The number that a port takes from a word.
pub(super) fn word(case: &Case<'_>, name: &str, component: usize) -> Option<Wide> {
    let word = case.input(name, component)?.cast_unsigned();
    let (m, e, _) = unpack(word);
    Some(Wide::code(m, -e))
}

/// Three words, a vector whose mantissas share an exponent.
pub(super) fn vector(sheet: &mut Sheet<'_>, case: &Case<'_>, reg: Reg, name: &str) {
    if let [Some(x), Some(y), Some(z)] = [0, 1, 2].map(|i| word(case, name, i)) {
        sheet.block(reg, 0, [x, y, z]);
    }
}

/// Words of fixed registers.
fn scalars(sheet: &mut Sheet<'_>, case: &Case<'_>, reg: Reg, name: &str) {
    for c in 0..reg.info().components {
        if let Some(x) = word(case, name, c) {
            sheet.fixed(reg, c, x);
        }
    }
}

/// The rules.
pub(super) fn ports(sheet: &mut Sheet<'_>, case: &Case<'_>) {
    use crate::stage::Stage;
    sheet.stage = Stage::Reflect;
    vector(sheet, case, Reg::ReflectV, "v");
    if case.input("h", 0).is_some() {
        sheet.stage = Stage::LocalFrame;
        vector(sheet, case, Reg::FrameN, "n");
        vector(sheet, case, Reg::FrameH, "h");
    } else {
        vector(sheet, case, Reg::ReflectN, "n");
    }
    sheet.stage = Stage::Jacobian;
    scalars(sheet, case, Reg::JacDvDx, "dv_dx");
    scalars(sheet, case, Reg::JacDvDy, "dv_dy");
    scalars(sheet, case, Reg::JacDnDx, "dn_dx");
    scalars(sheet, case, Reg::JacDnDy, "dn_dy");
    sheet.stage = Stage::Bump;
    scalars(sheet, case, Reg::BumpB, "b");
    sheet.stage = Stage::Roughness;
    scalars(sheet, case, Reg::RoughD, "d");
}
