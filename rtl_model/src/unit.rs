//! The unit: stages wired for the needs of a scene, over blocks of lanes.

mod block;
mod hit;
mod operation;
mod ports;
mod run;
mod steps;
mod tex;
mod wires;

pub use block::{Block, Inputs, Needs, Ports, Results, State, Words};
pub use hit::{HitFront, HitUnit, HitWords};
pub use operation::{BlockOf, Finish, Memory, Operation};
pub use tex::{Tangents, TexFront, TexUnit, TexWords};
pub use wires::{Wire, WireKind};

use crate::config::{Config, ConfigError, ROTATION_FRAC, SCALE_FRAC};
use crate::fx::Quantizer;
use crate::regs::{Kind, Reg};
use crate::stage::Stage;
use crate::stages::jacobian::normal_derivative;
use crate::stages::{
    Roms, address, bump, covariance, cube_face, eigen, filter, footprint, jacobian, local_frame,
    reflect, roughness,
};

/// A block of ENV.
pub type EnvBlock<const N: usize> = Block<(), N>;
/// A block of HIT.
pub type HitBlock<const N: usize> = Block<HitFront<N>, N>;
/// A block of TEX.
pub type TexBlock<const N: usize> = Block<TexFront<N>, N>;

/// A unit compiled for a scene's needs and a face size.
#[derive(Clone, Debug)]
pub struct Unit {
    /// The stages that were built.
    pub needs: Needs,
    /// Tables.
    pub roms: Roms,
    frame: Option<local_frame::Cfg>,
    bump: Option<bump::Cfg>,
    reflect: reflect::Cfg,
    face: cube_face::Cfg,
    normal: normal_derivative::Cfg,
    jacobian: jacobian::Cfg,
    roughness: Option<roughness::Cfg>,
    covariance: covariance::Cfg,
    eigen: eigen::Cfg,
    footprint: footprint::Cfg,
    address: address::Cfg,
    filter: filter::Cfg,
    /// Whether D comes with powers of two of its own.
    block_d: bool,
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
    const SPLIT: [Reg; 4] = [Reg::JacNIdotDn, Reg::JacPerpDotE, Reg::JacVdotDn, Reg::JacNdotDn];
    // Factors that are doubled first.
    const DOUBLED: [Reg; 3] = [Reg::ReflectV, Reg::ReflectN, Reg::ReflectNdotV];
    // Stages that work on one fragment at a time.
    const BY_FRAGMENT: [Stage; 4] =
        [Stage::Hit, Stage::SurfaceFootprint, Stage::Address, Stage::Filter];
    let most = |reg: &Reg| if DOUBLED.contains(reg) { 30 } else { 31 };
    Reg::ALL
        .iter()
        .filter(|reg| {
            let stage = reg.info().stage;
            // Of `hit`'s registers only the direction that is looked up goes through lanes, of
            // `surface_footprint`'s only D. A step is multiplied by no stage before `address`.
            let by_lanes =
                !BY_FRAGMENT.contains(&stage) || [Reg::HitTo, Reg::SurfJac].contains(reg);
            let factor = **reg != Reg::FootStep;
            by_lanes && factor && !SPLIT.contains(reg)
        })
        .all(|reg| config.format(*reg).magnitude_bits() <= most(reg))
}

impl Unit {
    /// Compiles a configuration; refuses by name what could not be exact inside.
    pub fn new(config: &Config, needs: Needs, face_size: u32) -> Result<Self, ConfigError> {
        Self::compile(config, needs, Reg::JacD, |config| {
            Ok((footprint::Cfg::new(config, face_size)?, address::Cfg::new(config)?))
        })
    }

    /// The stages behind `surface_footprint` for a texture of `size` columns and rows.
    fn planar(config: &Config, size: [u32; 2]) -> Result<Self, ConfigError> {
        Self::compile(config, tex::NEEDS, Reg::SurfJac, |config| {
            Ok((footprint::Cfg::planar(config, size)?, address::Cfg::planar(config)?))
        })
    }

    /// `source` holds D; `lines` compiles what depends on the texture.
    fn compile(
        config: &Config,
        needs: Needs,
        source: Reg,
        lines: impl Fn(&Config) -> Result<(footprint::Cfg, address::Cfg), ConfigError>,
    ) -> Result<Self, ConfigError> {
        for reg in Reg::ALL {
            let bits = config.format(*reg).magnitude_bits();
            let expected = if !(1..=58).contains(&bits) {
                "1 to 58 bits without the sign"
            } else if reg.info().kind == Kind::Block && bits > 31 {
                "mantissas of 1 to 31 bits"
            } else {
                continue;
            };
            return Err(ConfigError {
                path: alloc::format!("registers.{reg}"),
                expected: expected.into(),
                found: alloc::format!("{bits}"),
            });
        }
        check_ranges(config)?;
        let (footprint, address) = lines(config)?;
        Ok(Self {
            needs,
            roms: Roms::new(config)?,
            frame: if needs.frame() { Some(local_frame::Cfg::new(config)?) } else { None },
            bump: if needs.bump { Some(bump::Cfg::new(config)?) } else { None },
            reflect: reflect::Cfg::new(config)?,
            face: cube_face::Cfg::new(config)?,
            normal: normal_derivative::Cfg::new(config, needs.bump)?,
            jacobian: jacobian::Cfg::new(config)?,
            roughness: if needs.rough { Some(roughness::Cfg::new(config)?) } else { None },
            covariance: covariance::Cfg::new(config, source, needs.rough)?,
            eigen: eigen::Cfg::new(config)?,
            footprint,
            address,
            filter: filter::Cfg::new(config)?,
            block_d: source == Reg::SurfJac,
            bump_frac: i64::from(config.format(Reg::BumpN).frac),
            step_frac: i64::from(config.format(Reg::FootStep).frac),
            standard: config.formats.iter().all(|f| Quantizer::is_standard(*f))
                && has_narrow_products(config),
        })
    }
}
