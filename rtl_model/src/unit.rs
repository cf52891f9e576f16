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
use crate::tap::{NoTapStandard, Tap};
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
            flags: [NO_FLAGS; N],
        }
    }
}

/// What the stages have written for a block of lanes; kept from block to block.
#[derive(Clone, Debug)]
pub struct State<const N: usize> {
    flags: [Flags; N],
    frame: local_frame::Out<N>,
    bumped: bump::Out<N>,
    reflected: reflect::Out<N>,
    /// Where the directions meet the cube.
    pub face: cube_face::Out<N>,
    dn_mod: Lanes<N, 6>,
    d: jacobian::Out<N>,
    b: roughness::Out<N>,
    k: covariance::Out<N>,
    axes: eigen::Out<N>,
    /// Probe lines.
    pub line: footprint::Out<N>,
}

impl<const N: usize> Default for State<N> {
    fn default() -> Self {
        Self {
            flags: [NO_FLAGS; N],
            frame: Default::default(),
            bumped: Default::default(),
            reflected: Default::default(),
            face: Default::default(),
            dn_mod: [[0; N]; 6],
            d: Default::default(),
            b: Default::default(),
            k: Default::default(),
            axes: Default::default(),
            line: Default::default(),
        }
    }
}

const NO_FLAGS: Flags = Flags {
    overflow: 0,
    events: 0,
};

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
            flags: [NO_FLAGS; N],
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
            standard: config.formats.iter().all(|f| Quantizer::is_standard(*f)),
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

    /// The stages from the local frame to the footprint.
    #[inline(always)]
    pub fn front<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        state.flags.copy_from_slice(&ports.flags);
        self.local_frame(ports, state, tap);
        self.bump(ports, state, tap);
        self.reflect(ports, state, tap);
        self.cube_face(ports, state, tap);
        self.normal(ports, state, tap);
        self.jacobian(ports, state, tap);
        self.roughness(ports, state, tap);
        self.covariance(ports, state, tap);
        self.eigen(ports, state, tap);
        self.footprint(ports, state, tap);
    }

    /// `local_frame`, if the scene needs it.
    #[inline(always)]
    pub fn local_frame<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let Some(cfg) = &self.frame else { return };
        let input = local_frame::In {
            n: &ports.n,
            n_exp: &ports.n_exp,
            h: &ports.h,
            h_exp: &ports.h_exp,
        };
        local_frame::local_frame(
            cfg,
            &self.roms,
            input,
            &mut state.frame,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `bump`, if the scene needs it.
    #[inline(always)]
    pub fn bump<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let Some(cfg) = &self.bump else { return };
        let input = bump::In {
            n: &ports.n,
            n_exp: &ports.n_exp,
            e1: &state.frame.e1,
            e2: &state.frame.e2,
            b: &ports.b,
        };
        bump::bump(
            cfg,
            input,
            &mut state.bumped,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `reflect`.
    #[inline(always)]
    pub fn reflect<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        // Without a bump but with a frame the port's format is the frame's: normalise once more.
        let n_mod_frac = match (&self.bump, &self.frame) {
            (Some(_), _) => Some(self.bump_frac),
            (None, Some(frame)) => Some(i64::from(frame.n.format.magnitude_bits()) - 1),
            (None, None) => None,
        };
        let input = reflect::In {
            v: &ports.v,
            v_exp: &ports.v_exp,
            n: if self.bump.is_some() {
                &state.bumped.n_mod
            } else {
                &ports.n
            },
            n_exp: &ports.n_exp,
            n_mod_frac,
        };
        reflect::reflect(
            &self.reflect,
            input,
            &mut state.reflected,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `cube_face`.
    #[inline(always)]
    pub fn cube_face<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let mut exp = [0; N];
        for (lane, e) in exp.iter_mut().enumerate().take(ports.len) {
            *e = ports.v_exp[lane] + 2 * (ports.n_exp[lane] + state.reflected.n_lift[lane]);
        }
        let input = cube_face::In {
            v_r: &state.reflected.v_r,
            v_r_frac: &state.reflected.v_r_frac,
            exp: &exp,
        };
        cube_face::cube_face(
            &self.face,
            &self.roms,
            input,
            &mut state.face,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// The first step of `jacobian`: the derivative of the modified normal.
    #[inline(always)]
    pub fn normal<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let input = normal::In {
            dn: &ports.dn,
            n_exp: &ports.n_exp,
            n_lift: &state.reflected.n_lift,
            bumped: self.bump.as_ref().map(|_| normal::Bumped {
                n: &ports.n,
                h: &ports.h,
                e1: &state.frame.e1,
                e2: &state.frame.e2,
                b: &ports.b,
            }),
        };
        normal::normal(
            &self.normal,
            &self.roms,
            input,
            &mut state.dn_mod,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `jacobian`, from the derivative of the modified normal on.
    #[inline(always)]
    pub fn jacobian<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let input = jacobian::In {
            v: &ports.v,
            v_exp: &ports.v_exp,
            n_exp: &ports.n_exp,
            dv: &ports.dv,
            dn_mod: &state.dn_mod,
            reflect: &state.reflected,
            face: &state.face,
        };
        jacobian::jacobian(
            &self.jacobian,
            input,
            &mut state.d,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `roughness`, if the scene needs it.
    #[inline(always)]
    pub fn roughness<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let Some(cfg) = &self.roughness else { return };
        let input = roughness::In {
            v: &ports.v,
            v_exp: &ports.v_exp,
            n_exp: &ports.n_exp,
            e1: &state.frame.e1,
            e2: &state.frame.e2,
            d: &ports.d,
            reflect: &state.reflected,
            face: &state.face,
        };
        roughness::roughness(cfg, input, &mut state.b, &mut state.flags[..ports.len], tap);
    }

    /// `covariance`.
    #[inline(always)]
    pub fn covariance<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let input = covariance::In {
            d: &state.d.d,
            b: self.roughness.as_ref().map(|_| &state.b.b),
        };
        covariance::covariance(
            &self.covariance,
            input,
            &mut state.k,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `eigen`.
    #[inline(always)]
    pub fn eigen<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let input = eigen::In {
            covariance: &state.k,
        };
        eigen::eigen(
            &self.eigen,
            &self.roms,
            input,
            &mut state.axes,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// `footprint`.
    #[inline(always)]
    pub fn footprint<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        state: &mut State<N>,
        tap: &mut T,
    ) {
        let input = footprint::In { eigen: &state.axes };
        footprint::footprint(
            &self.footprint,
            &self.roms,
            input,
            &mut state.line,
            &mut state.flags[..ports.len],
            tap,
        );
    }

    /// What one lane asks of the texture.
    #[inline(always)]
    #[must_use]
    pub fn request<const N: usize>(&self, state: &State<N>, lane: usize) -> filter::In {
        filter::In {
            line: address::In {
                face: state.face.face[lane],
                center: [state.face.u[lane], state.face.v[lane]],
                step: [state.line.step[0][lane], state.line.step[1][lane]],
                step_frac: self.step_frac,
                count: state.line.count[lane],
            },
            lod: state.line.lod[lane],
        }
    }

    /// `address` and `filter` for `len` lanes.
    #[inline(always)]
    pub fn back<const N: usize, T: Tap>(
        &self,
        state: &State<N>,
        len: usize,
        texture: &Texture,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        for lane in 0..len.min(N) {
            let request = self.request(state, lane);
            out.flags[lane] = state.flags[lane];
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

    /// The addresses alone: what a texel cache would see, and the floor of a speed comparison.
    #[inline(always)]
    pub fn touch<const N: usize>(&self, state: &State<N>, len: usize, texture: &Texture) -> u64 {
        let mut sum = 0;
        let mut flags = NO_FLAGS;
        for lane in 0..len.min(N) {
            let request = self.request(state, lane);
            let mut sink = Sink {
                lane,
                flags: &mut flags,
                tap: &mut NoTapStandard,
            };
            sum += filter::touch(
                &self.filter,
                &self.address,
                &self.roms,
                texture,
                &request,
                &mut sink,
            );
        }
        sum
    }

    /// The whole operation; without a texture everything but the colour.
    #[inline(always)]
    pub fn env<const N: usize, T: Tap>(
        &self,
        ports: &Ports<N>,
        texture: Option<&Texture>,
        state: &mut State<N>,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        self.front(ports, state, tap);
        match texture {
            Some(texture) => self.back(state, ports.len, texture, out, tap),
            None => {
                out.probes = state.line.count;
                out.flags = state.flags;
            }
        }
    }

    /// Whether every register rounds half-even and saturates, so that the unit may run with a tap
    /// whose `STANDARD` is true.
    #[must_use]
    pub fn is_standard(&self) -> bool {
        self.standard
    }
}
