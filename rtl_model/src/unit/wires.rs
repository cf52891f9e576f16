//! One stage alone: its input wires, by name, and a run on their contents.
//!
//! For test benches and co-simulation. A wire carries the results of the stage before from the block's state: codes in the
//! nominal scale, mantissas, powers of two. Any codes within a wire's format are legal.

use core::array::from_mut;

use lanes::Scalar;

use super::Unit;
use super::block::{NO_FLAGS, Results, State, Words};
use crate::config::Config;
use crate::fx::{Flags, Format};
use crate::policy::Axis;
use crate::regs::Reg;
use crate::stage::Stage;
use crate::stages::block_frac;
use crate::tap::Tap;
use crate::texture::Texture;

/// The contents of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireKind {
    /// Codes of fixed registers, the components shared out evenly.
    Codes(&'static [Reg]),
    /// Mantissas of a block whose largest component lies in [1, 2).
    Mantissas(Reg),
    /// Mantissas of a block; another wire holds their fraction bits in the nominal scale.
    Floating(Reg),
    /// A power of two, or fraction bits.
    Power,
    /// Face 0…5.
    Face,
    /// 0 or 1.
    Bit,
    /// Probes.
    Count,
}

macro_rules! wires {
    ($($variant:ident: $name:literal [$n:literal] $kind:expr, $meaning:literal, |$s:ident| $place:expr, $power:expr;)+) => {
        /// A wire between the stages of ENV.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Wire { $(#[doc = $meaning] $variant),+ }

        impl Wire {
            /// Every wire, in pipeline order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// Its name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// Numbers that it carries.
            #[must_use]
            pub const fn components(self) -> usize {
                match self { $(Self::$variant => $n),+ }
            }

            /// What they are.
            #[must_use]
            pub const fn kind(self) -> WireKind {
                match self { $(Self::$variant => $kind),+ }
            }

            /// One sentence.
            #[must_use]
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning),+ }
            }

            /// Where its numbers lie.
            fn place(self, state: &mut State<1>) -> &mut [[i64; 1]] {
                match self { $(Self::$variant => { let $s = state; $place })+ }
            }

            /// Power of two of the nominal scale in true units; of floating mantissas less their fraction bits.
            fn power(self, state: &State<1>) -> i64 {
                match self { $(Self::$variant => { let $s = state; let _ = $s; $power })+ }
            }
        }
    };
}

/// Power of two of n_mod.
fn n_mod(s: &State<1>) -> i64 {
    s.input.n_exp[0] + s.reflected.n_lift[0]
}

/// Power of two of v_r.
fn v_r(s: &State<1>) -> i64 {
    s.input.v_exp[0] + 2 * n_mod(s)
}

wires! {
    V: "v"[3] WireKind::Mantissas(Reg::ReflectV), "direction to the eye", |s| &mut s.input.v, s.input.v_exp[0];
    VExp: "v_exp"[1] WireKind::Power, "power of two that was taken out of v", |s| from_mut(&mut s.input.v_exp), 0;
    N: "n"[3] WireKind::Mantissas(Reg::ReflectN), "interpolated normal", |s| &mut s.input.n, s.input.n_exp[0];
    FrameN: "n"[3] WireKind::Mantissas(Reg::FrameN), "interpolated normal", |s| &mut s.input.n, s.input.n_exp[0];
    NExp: "n_exp"[1] WireKind::Power, "power of two that was taken out of n", |s| from_mut(&mut s.input.n_exp), 0;
    H: "h"[3] WireKind::Mantissas(Reg::FrameH), "main direction", |s| &mut s.input.h, s.input.h_exp[0];
    HExp: "h_exp"[1] WireKind::Power, "power of two that was taken out of h", |s| from_mut(&mut s.input.h_exp), 0;
    Dv: "dv"[6] WireKind::Codes(&[Reg::JacDvDx, Reg::JacDvDy]), "∂v by x then by y, shifted with v", |s| &mut s.input.dv, s.input.v_exp[0];
    Dn: "dn"[6] WireKind::Codes(&[Reg::JacDnDx, Reg::JacDnDy]), "∂n by x then by y, shifted with n", |s| &mut s.input.dn, s.input.n_exp[0];
    B: "b"[2] WireKind::Codes(&[Reg::BumpB]), "bump offsets", |s| &mut s.input.b, 0;
    Rough: "d"[3] WireKind::Codes(&[Reg::RoughD]), "d1, d2, d3 of the roughness", |s| &mut s.input.d, 0;
    E1: "e1"[3] WireKind::Codes(&[Reg::FrameE1]), "first tangent vector", |s| &mut s.frame.e1, s.input.n_exp[0];
    E2: "e2"[3] WireKind::Codes(&[Reg::FrameE2]), "second tangent vector", |s| &mut s.frame.e2, s.input.n_exp[0];
    Bumped: "n_mod"[3] WireKind::Codes(&[Reg::BumpN]), "modified normal, shifted with n", |s| &mut s.bumped.n_mod, s.input.n_exp[0];
    Reflecting: "n_reflect"[3] WireKind::Mantissas(Reg::ReflectN), "normal that reflects", |s| &mut s.reflected.n, n_mod(s);
    NLift: "n_lift"[1] WireKind::Power, "power of two of the reflecting normal less that of n", |s| from_mut(&mut s.reflected.n_lift), 0;
    NdotV: "n_dot_v"[1] WireKind::Codes(&[Reg::ReflectNdotV]), "⟨n, v⟩", |s| from_mut(&mut s.reflected.n_dot_v), s.input.v_exp[0] + n_mod(s);
    NdotN: "n_dot_n"[1] WireKind::Codes(&[Reg::ReflectNdotN]), "⟨n, n⟩", |s| from_mut(&mut s.reflected.n_dot_n), 2 * n_mod(s);
    Vr: "v_r"[3] WireKind::Floating(Reg::ReflectVr), "reflected direction", |s| &mut s.reflected.v_r, v_r(s) - s.reflected.v_r_frac[0];
    VrFrac: "v_r_frac"[1] WireKind::Power, "fraction bits of v_r", |s| from_mut(&mut s.reflected.v_r_frac), 0;
    Face: "face"[1] WireKind::Face, "face 0…5 for +x −x +y −y +z −z", |s| from_mut(&mut s.face.face), 0;
    Zero: "zero"[1] WireKind::Bit, "whether v_r is zero", |s| from_mut(&mut s.face.zero), 0;
    InvMa: "inv_ma"[1] WireKind::Floating(Reg::FaceInvMa), "1/|ma|", |s| from_mut(&mut s.face.inv_ma), -v_r(s) - s.face.inv_ma_frac[0];
    InvMaFrac: "inv_ma_frac"[1] WireKind::Power, "fraction bits of inv_ma", |s| from_mut(&mut s.face.inv_ma_frac), 0;
    U: "u"[1] WireKind::Codes(&[Reg::FaceU]), "u on the face", |s| from_mut(&mut s.face.u), 0;
    Vv: "v_face"[1] WireKind::Codes(&[Reg::FaceV]), "v on the face", |s| from_mut(&mut s.face.v), 0;
    D: "jacobian"[4] WireKind::Codes(&[Reg::JacD]), "D row by row", |s| &mut s.d.d, 0;
    RoughB: "rough_b"[4] WireKind::Codes(&[Reg::RoughB]), "s·B' row by row", |s| &mut s.b.b, 0;
    K: "k"[3] WireKind::Floating(Reg::CovK), "a, b, c of K", |s| &mut s.k.k, -s.k.frac[0];
    KFrac: "k_frac"[1] WireKind::Power, "fraction bits of K", |s| from_mut(&mut s.k.frac), 0;
    Lambda: "lambda"[2] WireKind::Codes(&[Reg::EigenLambda]), "λ1 ≥ λ2", |s| &mut s.axes.lambda, s.axes.exp[0];
    LambdaExp: "lambda_exp"[1] WireKind::Power, "power of two of λ", |s| from_mut(&mut s.axes.exp), 0;
    Axis: "axis"[2] WireKind::Codes(&[Reg::EigenAxis]), "unit vector of the major axis", |s| &mut s.axes.axis, 0;
    Count: "count"[1] WireKind::Count, "probes", |s| from_mut(&mut s.line.count), 0;
    Lod: "lod"[1] WireKind::Codes(&[Reg::FootLod]), "level of detail", |s| from_mut(&mut s.line.lod), 0;
    Step: "step"[2] WireKind::Codes(&[Reg::FootStep]), "half the spacing of the probes", |s| &mut s.line.step, 0;
}

impl Wire {
    /// The format of a component's register; `None` if there is no register.
    #[must_use]
    pub fn format(self, config: &Config, component: usize) -> Option<Format> {
        self.register(component).map(|(reg, _)| config.format(reg))
    }

    /// The register of a component, and the component's number in it.
    #[must_use]
    pub fn register(self, component: usize) -> Option<(Reg, usize)> {
        match self.kind() {
            WireKind::Codes(regs) => {
                let each = self.components() / regs.len();
                regs.get(component / each).map(|reg| (*reg, component % each))
            }
            WireKind::Mantissas(reg) | WireKind::Floating(reg) => Some((reg, component)),
            WireKind::Power | WireKind::Face | WireKind::Bit | WireKind::Count => None,
        }
    }

    /// Reads the wire into `out`.
    pub fn get(self, state: &mut State<1>, out: &mut [i64]) {
        for (out, [value]) in out.iter_mut().zip(self.place(state)) {
            *out = *value;
        }
    }

    /// Drives the wire.
    pub fn set(self, state: &mut State<1>, values: &[i64]) {
        for ([to], value) in self.place(state).iter_mut().zip(values) {
            *to = match self {
                Self::Face => (*value).clamp(0, 5),
                Self::Zero => i64::from(*value != 0),
                _ => *value,
            };
        }
    }

    /// Tells a tap the contents of the wire, in true units, as the stage that drives it does.
    pub fn put<T: Tap>(self, config: &Config, state: &mut State<1>, tap: &mut T) {
        let power = self.power(state);
        for c in 0..self.components() {
            let Some((reg, component)) = self.register(c) else {
                return;
            };
            let frac = match self.kind() {
                WireKind::Mantissas(reg) => block_frac(config, reg),
                WireKind::Floating(_) => 0,
                _ => i64::from(config.format(reg).frac),
            };
            let code = self.place(state).get(c).map_or(0, |[code]| *code);
            tap.put(0, reg, component, code, frac - power);
        }
    }
}

impl Unit {
    /// The wires that a stage reads in this unit; none where the unit is built without it, or where it reads what no
    /// wire carries (`footprint.axis = "longer-derivative"` takes a column of D past `covariance`).
    #[must_use]
    pub fn wires(&self, config: &Config, stage: Stage) -> &'static [&'static [Wire]] {
        use Wire as W;
        const V: &[Wire] = &[W::V, W::VExp];
        const N: &[Wire] = &[W::N, W::NExp];
        const FRAME_N: &[Wire] = &[W::FrameN, W::NExp];
        const FACING: &[Wire] = &[
            W::Reflecting,
            W::NLift,
            W::NdotV,
            W::NdotN,
            W::Face,
            W::Zero,
            W::InvMa,
            W::InvMaFrac,
            W::U,
            W::Vv,
        ];
        const DERIVATIVES: &[Wire] = &[W::Dv, W::Dn];
        const TANGENTS: &[Wire] = &[W::E1, W::E2];
        let (bump, frame) = (self.bump.is_some(), self.frame.is_some());
        match stage {
            Stage::LocalFrame if frame => &[FRAME_N, &[W::H, W::HExp]],
            Stage::Bump if bump => &[FRAME_N, TANGENTS, &[W::B]],
            Stage::Reflect if bump => &[V, &[W::NExp, W::Bumped]],
            Stage::Reflect if frame => &[V, FRAME_N],
            Stage::Reflect => &[V, N],
            Stage::CubeFace => &[&[W::VExp, W::NExp, W::NLift, W::Vr, W::VrFrac]],
            Stage::Jacobian if bump => {
                &[V, FRAME_N, &[W::H, W::HExp], TANGENTS, &[W::B], DERIVATIVES, FACING]
            }
            Stage::Jacobian => &[V, &[W::NExp], DERIVATIVES, FACING],
            Stage::Roughness if self.roughness.is_some() => {
                &[V, &[W::NExp], TANGENTS, &[W::Rough], FACING]
            }
            Stage::Covariance if self.roughness.is_some() => &[&[W::D, W::RoughB]],
            Stage::Covariance => &[&[W::D]],
            Stage::Eigen if config.policy.footprint.axis != Axis::LongerDerivative => {
                &[&[W::K, W::KFrac]]
            }
            Stage::Footprint => &[&[W::Lambda, W::LambdaExp, W::Axis]],
            Stage::Address | Stage::Filter => &[&[W::Face, W::U, W::Vv, W::Count, W::Lod, W::Step]],
            Stage::LocalFrame | Stage::Bump | Stage::Roughness | Stage::Eigen => &[],
            Stage::RayCone | Stage::Hit | Stage::SurfaceFootprint => &[],
        }
    }

    /// Every stage up to `before`, or all, for one fragment; the flags of all that ran.
    pub fn one<T: Tap>(
        &self,
        words: &Words,
        before: Option<Stage>,
        texture: Option<&Texture>,
        state: &mut State<1>,
        out: &mut Results<1>,
        tap: &mut T,
    ) -> Flags {
        self.put_words(words, &mut state.words, 0);
        (state.len, state.flags) = (1, [NO_FLAGS]);
        self.ports(Scalar, state, tap);
        let mut flags = state.flags();
        for stage in Stage::ALL.into_iter().take_while(|stage| Some(*stage) != before) {
            // `filter` runs both.
            if stage == Stage::Address {
                continue;
            }
            let more = self.alone(stage, state, texture, out, tap);
            flags.overflow |= more.overflow;
            flags.events |= more.events;
        }
        flags
    }

    /// Runs one stage from the wires in `state`; its flags alone are set afterwards. `address` and `filter` run together
    /// and need a texture; what is no stage of ENV does nothing.
    #[inline(never)]
    pub fn alone<T: Tap>(
        &self,
        stage: Stage,
        state: &mut State<1>,
        texture: Option<&Texture>,
        out: &mut Results<1>,
        tap: &mut T,
    ) -> Flags {
        (state.len, state.flags) = (1, [NO_FLAGS]);
        match stage {
            Stage::LocalFrame => self.local_frame(Scalar, state, tap),
            Stage::Bump => self.bump(Scalar, state, tap),
            Stage::Reflect => self.reflect(Scalar, state, tap),
            Stage::CubeFace => self.cube_face(Scalar, state, tap),
            Stage::Jacobian => {
                self.normal_derivative(Scalar, state, tap);
                self.jacobian(Scalar, state, tap);
            }
            Stage::Roughness => self.roughness(Scalar, state, tap),
            Stage::Covariance => self.covariance(Scalar, state, tap),
            Stage::Eigen => self.eigen(Scalar, state, tap),
            Stage::Footprint => self.footprint(Scalar, state, tap),
            Stage::RayCone | Stage::Hit | Stage::SurfaceFootprint => {}
            Stage::Address | Stage::Filter => {
                self.back(Scalar, state, texture, out, tap);
                return out.flags[0];
            }
        }
        state.flags[0]
    }
}
