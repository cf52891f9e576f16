//! The unit: stages wired for what a scene needs, over blocks of lanes.

use crate::config::{Config, ConfigError, ROTATION_FRAC, SCALE_FRAC};
use crate::fx::{Flags, Quantizer};
use crate::port;
use crate::regs::{Event, Reg};
use crate::stages::jacobian::normal;
use crate::stages::{
    Lanes, Roms, Sink, address, bump, covariance, cube_face, eigen, filter, footprint, jacobian,
    local_frame, reflect, roughness, store,
};
use crate::tap::Tap;
use crate::texture::Texture;

/// Which parts of the ENV operation a scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Needs {
    /// Bump offsets: `local_frame`, `bump`.
    pub bump: bool,
    /// Roughness: `local_frame`, `roughness`.
    pub rough: bool,
}

impl Needs {
    /// Whether the tangent vectors are needed.
    #[must_use]
    pub const fn frame(self) -> bool {
        self.bump || self.rough
    }
}

/// One fragment as binary64 words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Words {
    /// Direction to the eye.
    pub v: [u64; 3],
    /// Interpolated normal.
    pub n: [u64; 3],
    /// ∂v/∂x, ∂v/∂y.
    pub dv: [[u64; 3]; 2],
    /// ∂n/∂x, ∂n/∂y.
    pub dn: [[u64; 3]; 2],
    /// Main direction.
    pub h: [u64; 3],
    /// b1, b2.
    pub b: [u64; 2],
    /// d1, d2, d3.
    pub d: [u64; 3],
}

/// Up to `N` fragments behind their ports.
#[derive(Clone, Debug)]
pub struct Ports<const N: usize> {
    /// Lanes in use.
    pub len: usize,
    v: Lanes<N, 3>,
    v_exp: [i64; N],
    n: Lanes<N, 3>,
    n_exp: [i64; N],
    h: Lanes<N, 3>,
    h_exp: [i64; N],
    dv: Lanes<N, 6>,
    dn: Lanes<N, 6>,
    b: Lanes<N, 2>,
    d: Lanes<N, 3>,
    flags: [Flags; N],
}

impl<const N: usize> Default for Ports<N> {
    fn default() -> Self {
        Self {
            len: 0,
            v: [[0; N]; 3],
            v_exp: [0; N],
            n: [[0; N]; 3],
            n_exp: [0; N],
            h: [[0; N]; 3],
            h_exp: [0; N],
            dv: [[0; N]; 6],
            dn: [[0; N]; 6],
            b: [[0; N]; 2],
            d: [[0; N]; 3],
            flags: [Flags {
                overflow: 0,
                events: 0,
            }; N],
        }
    }
}

/// What the front end hands to the back end.
#[derive(Clone, Debug)]
pub struct Front<const N: usize> {
    /// Where the directions meet the cube.
    pub face: cube_face::Out<N>,
    /// Probe lines.
    pub footprint: footprint::Out<N>,
}

/// Results of up to `N` fragments.
#[derive(Clone, Debug)]
pub struct Results<const N: usize> {
    /// RGB with the fraction bits of `filter.color`.
    pub color: [[i64; 3]; N],
    /// Probes.
    pub probes: [i64; N],
    /// Texels read.
    pub texels: [u64; N],
    /// Sticky flags.
    pub flags: [Flags; N],
}

impl<const N: usize> Default for Results<N> {
    fn default() -> Self {
        Self {
            color: [[0; 3]; N],
            probes: [0; N],
            texels: [0; N],
            flags: [Flags {
                overflow: 0,
                events: 0,
            }; N],
        }
    }
}

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
        })
    }

    /// Passes one fragment through the ports into lane `ports.len`, which must be below `N`.
    pub fn load<const N: usize, T: Tap>(&self, ports: &mut Ports<N>, words: &Words, tap: &mut T) {
        let lane = ports.len;
        if lane >= N {
            return;
        }
        ports.len += 1;
        let mut flags = Flags::default();
        let mut all_finite = true;
        let (v, finite) = port::vector(&self.reflect.v, words.v);
        all_finite &= finite;
        let width = |q: &Quantizer| i64::from(q.format.magnitude_bits()) - 1;
        let v_exp = width(&self.reflect.v) - v.frac;
        let (n_port, n_reg) = match &self.frame {
            Some(frame) => (&frame.n, Reg::FrameN),
            None => (&self.reflect.n, Reg::ReflectN),
        };
        let (n, finite) = port::vector(n_port, words.n);
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
            let (code, over, finite) = port::scalar(q, word, exponent);
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
            let (h, finite) = port::vector(&frame.h, words.h);
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

    /// The stages from the local frame to the footprint.
    #[inline(always)]
    pub fn front<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        flags: &mut [Flags; N],
        tap: &mut T,
    ) -> Front<N> {
        flags.copy_from_slice(&ports.flags);
        let flags = &mut flags[..ports.len];
        let mut frame = local_frame::Out::<N>::default();
        if let Some(cfg) = &self.frame {
            let input = local_frame::In {
                n: &ports.n,
                n_exp: &ports.n_exp,
                h: &ports.h,
                h_exp: &ports.h_exp,
            };
            local_frame::local_frame(cfg, &self.roms, input, &mut frame, flags, tap);
        }
        let mut bumped = bump::Out::<N>::default();
        if let Some(cfg) = &self.bump {
            let input = bump::In {
                n: &ports.n,
                n_exp: &ports.n_exp,
                e1: &frame.e1,
                e2: &frame.e2,
                b: &ports.b,
            };
            bump::bump(cfg, input, &mut bumped, flags, tap);
        }
        // Without a bump but with a frame the port's format is the frame's: normalise once more.
        let n_mod_frac = match (&self.bump, &self.frame) {
            (Some(_), _) => Some(self.bump_frac),
            (None, Some(frame)) => Some(i64::from(frame.n.format.magnitude_bits()) - 1),
            (None, None) => None,
        };
        let mut reflected = reflect::Out::<N>::default();
        let input = reflect::In {
            v: &ports.v,
            v_exp: &ports.v_exp,
            n: if self.bump.is_some() {
                &bumped.n_mod
            } else {
                &ports.n
            },
            n_exp: &ports.n_exp,
            n_mod_frac,
        };
        reflect::reflect(&self.reflect, input, &mut reflected, flags, tap);
        let mut exp = [0; N];
        for (lane, e) in exp.iter_mut().enumerate() {
            *e = ports.v_exp[lane] + 2 * (ports.n_exp[lane] + reflected.n_lift[lane]);
        }
        let mut face = cube_face::Out::<N>::default();
        let input = cube_face::In {
            v_r: &reflected.v_r,
            v_r_frac: &reflected.v_r_frac,
            exp: &exp,
        };
        cube_face::cube_face(&self.face, &self.roms, input, &mut face, flags, tap);
        let mut dn_mod = [[0; N]; 6];
        let input = normal::In {
            dn: &ports.dn,
            n_exp: &ports.n_exp,
            n_lift: &reflected.n_lift,
            bumped: self.bump.as_ref().map(|_| normal::Bumped {
                n: &ports.n,
                h: &ports.h,
                e1: &frame.e1,
                e2: &frame.e2,
                b: &ports.b,
            }),
        };
        normal::normal(&self.normal, &self.roms, input, &mut dn_mod, flags, tap);
        let mut d = jacobian::Out::<N>::default();
        let input = jacobian::In {
            v: &ports.v,
            v_exp: &ports.v_exp,
            n_exp: &ports.n_exp,
            dv: &ports.dv,
            dn_mod: &dn_mod,
            reflect: &reflected,
            face: &face,
        };
        jacobian::jacobian(&self.jacobian, input, &mut d, flags, tap);
        let mut b = roughness::Out::<N>::default();
        if let Some(cfg) = &self.roughness {
            let input = roughness::In {
                v: &ports.v,
                v_exp: &ports.v_exp,
                n_exp: &ports.n_exp,
                e1: &frame.e1,
                e2: &frame.e2,
                d: &ports.d,
                reflect: &reflected,
                face: &face,
            };
            roughness::roughness(cfg, input, &mut b, flags, tap);
        }
        let mut k = covariance::Out::<N>::default();
        let input = covariance::In {
            d: &d.d,
            b: self.roughness.as_ref().map(|_| &b.b),
        };
        covariance::covariance(&self.covariance, input, &mut k, flags, tap);
        let mut axes = eigen::Out::<N>::default();
        eigen::eigen(
            &self.eigen,
            &self.roms,
            eigen::In { covariance: &k },
            &mut axes,
            flags,
            tap,
        );
        let mut line = footprint::Out::<N>::default();
        footprint::footprint(
            &self.footprint,
            &self.roms,
            footprint::In { eigen: &axes },
            &mut line,
            flags,
            tap,
        );
        Front {
            face,
            footprint: line,
        }
    }

    /// What one lane asks of the texture.
    #[inline(always)]
    #[must_use]
    pub fn request<const N: usize>(&self, front: &Front<N>, lane: usize) -> filter::In {
        filter::In {
            line: address::In {
                face: front.face.face[lane],
                center: [front.face.u[lane], front.face.v[lane]],
                step: [front.footprint.step[0][lane], front.footprint.step[1][lane]],
                step_frac: self.step_frac,
                count: front.footprint.count[lane],
            },
            lod: front.footprint.lod[lane],
        }
    }

    /// `address` and `filter` for all lanes.
    #[inline(always)]
    pub fn back<const N: usize, T: Tap>(
        &self,
        front: &Front<N>,
        len: usize,
        texture: &Texture,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        for lane in 0..len {
            let request = self.request(front, lane);
            let mut sink = Sink {
                lane,
                flags: &mut out.flags[lane],
                tap: &mut *tap,
            };
            let filtered = filter::filter(
                &self.filter,
                &self.address,
                &self.roms,
                texture,
                &request,
                &mut sink,
            );
            out.color[lane] = filtered.color;
            out.texels[lane] = filtered.texels;
            out.probes[lane] = request.line.count;
        }
    }

    /// The whole operation; without a texture everything but the colour.
    #[inline(always)]
    pub fn env<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        texture: Option<&Texture>,
        out: &mut Results<N>,
        tap: &mut T,
    ) -> Front<N> {
        let front = self.front(ports, &mut out.flags, tap);
        match texture {
            Some(texture) => self.back(&front, ports.len, texture, out, tap),
            None => out.probes = front.footprint.count,
        }
        front
    }
}
