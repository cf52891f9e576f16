//! The unit: stages wired for what a scene needs, over blocks of lanes.

mod block;
mod run;

pub use block::{Needs, Ports, Results, State, Words};

use crate::config::{Config, ConfigError, ROTATION_FRAC, SCALE_FRAC};
use crate::fx::{Flags, Quantizer};
use crate::port;
use crate::regs::{Event, Reg};
use crate::stages::jacobian::normal;
use crate::stages::{
    Roms, address, bump, covariance, cube_face, eigen, filter, footprint, jacobian, local_frame,
    reflect, roughness, store,
};
use crate::tap::Tap;

/// A unit compiled for a scene's needs and a face size.
#[derive(Clone, Debug)]
pub struct Unit {
    /// What was built.
    pub needs: Needs,
    /// Tables.
    pub roms: Roms,
    frame: Option<local_frame::Cfg>,
    bump: Option<bump::Cfg>,
    reflect: reflect::Cfg,
    face: cube_face::Cfg,
    normal: normal::Cfg,
    jacobian: jacobian::Cfg,
    roughness: Option<roughness::Cfg>,
    covariance: covariance::Cfg,
    eigen: eigen::Cfg,
    footprint: footprint::Cfg,
    address: address::Cfg,
    filter: filter::Cfg,
    bump_frac: i64,
    step_frac: i64,
    standard: bool,
}

/// Refuses constants beyond the words that the stages' checks count on.
fn check_ranges(config: &Config) -> Result<(), ConfigError> {
    let one = 1i64 << ROTATION_FRAC;
    for entry in config.rotation.iter().flatten().flatten() {
        if !(-one..=one).contains(entry) {
            return Err(ConfigError {
                path: "transform.rotation".into(),
                expected: "entries from -1 to 1".into(),
                found: alloc::format!("{entry}/2^{ROTATION_FRAC}"),
            });
        }
    }
    let scale = config.roughness_scale;
    if !(0..16 << SCALE_FRAC).contains(&scale) {
        return Err(ConfigError {
            path: "roughness.scale".into(),
            expected: "at least 0 and below 16".into(),
            found: alloc::format!("{scale}/2^{SCALE_FRAC}"),
        });
    }
    Ok(())
}

/// Whether every product of the stages before `address` has operands of at most 32 bits with their sign.
///
/// Four inner products may be wider: where they are multiplied they are split.
fn has_narrow_products(config: &Config) -> bool {
    const SPLIT: [Reg; 4] = [
        Reg::JacNIdotDn,
        Reg::JacPerpDotE,
        Reg::JacVdotDn,
        Reg::JacNdotDn,
    ];
    Reg::ALL
        .iter()
        .filter(|reg| !["address", "filter"].contains(&reg.info().stage) && !SPLIT.contains(reg))
        .all(|reg| config.format(*reg).magnitude_bits() <= 31)
}

impl Unit {
    /// Compiles a configuration; refuses by name what could not be exact inside.
    pub fn new(config: &Config, needs: Needs, face_size: u32) -> Result<Self, ConfigError> {
        for reg in Reg::ALL {
            let format = config.format(*reg);
            if format.magnitude_bits() == 0 || format.magnitude_bits() > 58 {
                let info = reg.info();
                return Err(ConfigError {
                    path: alloc::format!("registers.{}.{}", info.stage, info.name),
                    expected: "1 to 58 bits without the sign".into(),
                    found: alloc::format!("{}", format.magnitude_bits()),
                });
            }
            if reg.info().kind == crate::regs::Kind::Block && format.magnitude_bits() > 31 {
                let info = reg.info();
                return Err(ConfigError {
                    path: alloc::format!("registers.{}.{}", info.stage, info.name),
                    expected: "mantissas of 1 to 31 bits".into(),
                    found: alloc::format!("{}", format.magnitude_bits()),
                });
            }
        }
        check_ranges(config)?;
        Ok(Self {
            needs,
            roms: Roms::new(config)?,
            frame: if needs.frame() {
                Some(local_frame::Cfg::new(config)?)
            } else {
                None
            },
            bump: if needs.bump {
                Some(bump::Cfg::new(config)?)
            } else {
                None
            },
            reflect: reflect::Cfg::new(config)?,
            face: cube_face::Cfg::new(config)?,
            normal: normal::Cfg::new(config, needs.bump)?,
            jacobian: jacobian::Cfg::new(config)?,
            roughness: if needs.rough {
                Some(roughness::Cfg::new(config)?)
            } else {
                None
            },
            covariance: covariance::Cfg::new(config, needs.rough)?,
            eigen: eigen::Cfg::new(config)?,
            footprint: footprint::Cfg::new(config, face_size)?,
            address: address::Cfg::new(config)?,
            filter: filter::Cfg::new(config)?,
            bump_frac: i64::from(config.format(Reg::BumpN).frac),
            step_frac: i64::from(config.format(Reg::FootStep).frac),
            standard: config.formats.iter().all(|f| Quantizer::is_standard(*f))
                && has_narrow_products(config),
        })
    }

    /// Passes one fragment through the ports into lane `ports.len`, which must be below `N`.
    #[inline(always)]
    pub fn load<const N: usize, T: Tap>(&self, ports: &mut Ports<N>, words: &Words, tap: &mut T) {
        let lane = ports.len;
        if lane >= N {
            return;
        }
        ports.len += 1;
        let mut flags = Flags::default();
        let mut all_finite = true;
        let (v, finite) = port::vector(T::STANDARD, &self.reflect.v, words.v);
        all_finite &= finite;
        let width = |q: &Quantizer| i64::from(q.format.magnitude_bits()) - 1;
        let v_exp = width(&self.reflect.v) - v.frac;
        let (n_port, n_reg) = match &self.frame {
            Some(frame) => (&frame.n, Reg::FrameN),
            None => (&self.reflect.n, Reg::ReflectN),
        };
        let (n, finite) = port::vector(T::STANDARD, n_port, words.n);
        all_finite &= finite;
        let n_exp = width(n_port) - n.frac;
        for c in 0..3 {
            tap.put(lane, Reg::ReflectV, c, v.m[c], v.frac);
            tap.put(lane, n_reg, c, n.m[c], n.frac);
        }
        store(&mut ports.v, lane, v.m);
        store(&mut ports.n, lane, n.m);
        ports.v_exp[lane] = v_exp;
        ports.n_exp[lane] = n_exp;
        let mut scalar = |q: &Quantizer, reg: Reg, c: usize, word: u64, exponent: i64| {
            let (code, over, finite) = port::scalar(T::STANDARD, q, word, exponent);
            flags.register(reg, over);
            all_finite &= finite;
            tap.put(lane, reg, c, code, i64::from(q.format.frac) - exponent);
            code
        };
        for col in 0..2 {
            let dv = [Reg::JacDvDx, Reg::JacDvDy][col];
            let dn = [Reg::JacDnDx, Reg::JacDnDy][col];
            for c in 0..3 {
                ports.dv[3 * col + c][lane] =
                    scalar(&self.jacobian.dv[col], dv, c, words.dv[col][c], v_exp);
                ports.dn[3 * col + c][lane] =
                    scalar(&self.normal.dn[col], dn, c, words.dn[col][c], n_exp);
            }
        }
        if let Some(bump) = &self.bump {
            for c in 0..2 {
                ports.b[c][lane] = scalar(&bump.b, Reg::BumpB, c, words.b[c], 0);
            }
        }
        if let Some(rough) = &self.roughness {
            for c in 0..3 {
                ports.d[c][lane] = scalar(&rough.d, Reg::RoughD, c, words.d[c], 0);
            }
        }
        if let Some(frame) = &self.frame {
            let (h, finite) = port::vector(T::STANDARD, &frame.h, words.h);
            all_finite &= finite;
            for c in 0..3 {
                tap.put(lane, Reg::FrameH, c, h.m[c], h.frac);
            }
            store(&mut ports.h, lane, h.m);
            ports.h_exp[lane] = width(&frame.h) - h.frac;
        }
        flags.event(Event::InputNotFinite, !all_finite);
        ports.flags[lane] = flags;
    }
}
