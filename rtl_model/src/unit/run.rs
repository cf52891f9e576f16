//! Running a unit: each stage over a block, and all of them.

use core::ops::Range;

use lanes::{Scalar, Simd, Vector as _};

use super::Unit;
use super::block::{Inputs, NO_FLAGS, Results, State};
use crate::lanes::{Fast, Place, Writes};
use crate::stages::filter::{Corner, block};
use crate::stages::jacobian::normal_derivative;
use crate::stages::{
    Sink, address, bump, covariance, cube_face, eigen, filter, footprint, jacobian, local_frame,
    reflect, roughness,
};
use crate::tap::{NoTapStandard, Tap};
use crate::texture::{Texels, Texture};

/// Stages over the lanes of a block: each from a row that reads what the stage takes and names the place of its result.
///
/// Where nobody listens to a standard unit, several lanes go at a time, and those that leave the plain case once
/// more one by one; else all do.
macro_rules! stages {
    ($($(#[$doc:meta])*
        $name:ident($unit:ident, $state:ident, $at:ident, $sink:ident) $(if $used:expr)?
            => $place:ident: $out:ty = $run:expr;)+) => {$(
        $(#[$doc])*
        #[inline(always)]
        pub fn $name<S: Simd, const N: usize, T: Tap>(
            &self,
            simd: S,
            state: &mut State<N>,
            tap: &mut T,
        ) {
            #[inline(always)]
            fn run<S: Simd, const N: usize>(
                $unit: &Unit,
                $state: &State<N>,
                $at: At<S>,
                $sink: &mut impl Writes<S::I>,
            ) -> $out {
                $run
            }

            #[cold]
            #[inline(never)]
            fn one_by_one<const N: usize, T: Tap>(
                unit: &Unit,
                state: &mut State<N>,
                lanes: Range<usize>,
                tap: &mut T,
            ) {
                for lane in lanes {
                    let mut flags = state.flags[lane];
                    let mut sink = Sink { lane, flags: &mut flags, tap: &mut *tap };
                    let out = run(unit, state, At(Scalar, lane), &mut sink);
                    Place::<Scalar>::store(&mut state.$place, lane, out);
                    state.flags[lane] = flags;
                }
            }

            let $unit = self;
            let _ = $unit;
            $(if !$used {
                return;
            })?
            let len = state.len.min(N);
            if !T::STANDARD || T::ACTIVE || S::I::LEN == 1 {
                return one_by_one(self, state, 0..len, tap);
            }
            let mut lane = 0;
            while lane < len {
                let mut sink = Fast::new(simd);
                let out = run(self, state, At(simd, lane), &mut sink);
                Place::<S>::store(&mut state.$place, lane, out);
                let after = lane + S::I::LEN;
                if sink.beyond() {
                    one_by_one(self, state, lane..after.min(len), tap);
                }
                lane = after;
            }
        }
    )+};
}

/// The lanes of a vector in a block.
#[derive(Clone, Copy)]
struct At<S>(S, usize);

/// The numbers of `$from` at these lanes.
macro_rules! get {
    ($at:ident, $from:expr) => {
        $from.load($at.0, $at.1)
    };
}

impl Unit {
    stages! {
        /// The ports: n, v and h normalised, everything else written to its register.
        ports(unit, state, at, sink) => input: Inputs<S::I> =
            unit.through(&get!(at, state.words), sink);

        /// `local_frame`, if the scene needs it.
        local_frame(unit, state, at, sink) if unit.frame.is_some()
            => frame: local_frame::Out<S::I> = {
            match &unit.frame {
                Some(cfg) => local_frame::local_frame(cfg, &unit.roms, &get!(at, state.input), sink),
                None => get!(at, state.frame),
            }
        };

        /// `bump`, if the scene needs it.
        bump(unit, state, at, sink) if unit.bump.is_some() => bumped: bump::Out<S::I> = {
            match &unit.bump {
                Some(cfg) => bump::bump(cfg, &get!(at, state.input), &get!(at, state.frame), sink),
                None => get!(at, state.bumped),
            }
        };

        /// `reflect`.
        reflect(unit, state, at, sink) => reflected: reflect::Out<S::I> = {
            let input: Inputs<S::I> = get!(at, state.input);
            // Without a bump but with a frame the port's format is the frame's: normalise once more.
            let (n, frac) = match (&unit.bump, &unit.frame) {
                (Some(_), _) => (get!(at, state.bumped.n_mod), Some(unit.bump_frac)),
                (None, Some(frame)) => (input.n, Some(frame.n.block_frac())),
                (None, None) => (input.n, None),
            };
            reflect::reflect(&unit.reflect, &input, n, frac, sink)
        };

        /// `cube_face`.
        cube_face(unit, state, at, sink) => face: cube_face::Out<S::I> = {
            let (input, r): (Inputs<S::I>, reflect::Out<S::I>) =
                (get!(at, state.input), get!(at, state.reflected));
            let exp = input.v_exp + (input.n_exp + r.n_lift).up(1);
            cube_face::cube_face(&unit.face, &unit.roms, (r.v_r, r.v_r_frac, exp), sink)
        };

        /// The first step of `jacobian`: the derivative of the modified normal.
        normal_derivative(unit, state, at, sink) => dn_mod: normal_derivative::Out<S::I> = {
            let frame: local_frame::Out<S::I> = get!(at, state.frame);
            let (cfg, lift) = (&unit.normal, get!(at, state.reflected.n_lift));
            let frame = unit.bump.as_ref().map(|_| &frame);
            normal_derivative::normal_derivative(
                cfg, &unit.roms, &get!(at, state.input), lift, frame, sink,
            )
        };

        /// `jacobian`, from the derivative of the modified normal on.
        jacobian(unit, state, at, sink) => d: jacobian::Out<S::I> = jacobian::jacobian(
            &unit.jacobian,
            &get!(at, state.input),
            &get!(at, state.dn_mod.dn_mod),
            &get!(at, state.reflected),
            &get!(at, state.face),
            sink,
        );

        /// `roughness`, if the scene needs it.
        roughness(unit, state, at, sink) if unit.roughness.is_some()
            => b: roughness::Out<S::I> = {
            match &unit.roughness {
                Some(cfg) => roughness::roughness(
                    cfg,
                    &get!(at, state.input),
                    &get!(at, state.frame),
                    &get!(at, state.reflected),
                    &get!(at, state.face),
                    sink,
                ),
                None => get!(at, state.b),
            }
        };

        /// `covariance`.
        covariance(unit, state, at, sink) => k: covariance::Out<S::I> = {
            let (b, exp) = (get!(at, state.b.b), get!(at, state.d_exp));
            let b = unit.roughness.as_ref().map(|_| &b);
            let exp = unit.block_d.then_some(exp);
            covariance::covariance(&unit.covariance, &get!(at, state.d.d), b, exp, sink)
        };

        /// `eigen`.
        eigen(unit, state, at, sink) => axes: eigen::Out<S::I> =
            eigen::eigen(&unit.eigen, &unit.roms, &get!(at, state.k), sink);

        /// `footprint`.
        footprint(unit, state, at, sink) => line: footprint::Out<S::I> =
            footprint::footprint(&unit.footprint, &unit.roms, &get!(at, state.axes), sink);
    }

    /// The texture request of one lane.
    #[inline(always)]
    #[must_use]
    pub fn request<const N: usize>(&self, state: &State<N>, lane: usize) -> filter::In {
        filter::In {
            line: address::In {
                face: state.face_of(lane),
                center: [state.face.u[lane], state.face.v[lane]],
                step: [state.line.step[0][lane], state.line.step[1][lane]],
                step_frac: self.step_frac,
                count: state.line.count[lane],
            },
            lod: state.line.lod[lane],
        }
    }

    /// `address` and `filter`, or without a texture the probe counts and flags.
    #[inline(always)]
    pub fn back<S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        state: &State<N>,
        texture: Option<&Texture>,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        let Some(texture) = texture else {
            out.probes = state.line.count;
            out.flags = state.flags;
            return;
        };
        if S::I::LEN > 1
            && T::STANDARD
            && !T::ACTIVE
            && self.filter.plain()
            && let Texels::Half(texels) = &texture.texels
            && let Some(address) = self.address.block(&texture.levels)
        {
            out.flags = state.flags;
            out.probes = state.line.count;
            let requests = block::Requests {
                len: state.len,
                face: &state.face.face,
                center: [&state.face.u, &state.face.v],
                step: &state.line.step,
                step_frac: self.step_frac,
                count: &state.line.count,
                lod: &state.line.lod,
            };
            let Results { color, texels: read, flags, .. } = out;
            let mut filtered = block::Filtered { color, texels: read, flags };
            let cfg = (&self.filter, &address, &self.roms);
            return block::filter(simd, cfg, (&texture.levels, texels), &requests, &mut filtered);
        }
        for lane in 0..state.len.min(N) {
            let request = self.request(state, lane);
            out.flags[lane] = state.flags[lane];
            let mut sink = Sink { lane, flags: &mut out.flags[lane], tap: &mut *tap };
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

    /// The first texel of each bilinear footprint of a lane.
    #[inline(always)]
    pub(super) fn corners<const N: usize>(
        &self,
        state: &State<N>,
        lane: usize,
        texture: &Texture,
        each: &mut dyn FnMut(Corner),
    ) {
        let request = self.request(state, lane);
        let mut flags = NO_FLAGS;
        let mut sink = Sink { lane, flags: &mut flags, tap: &mut NoTapStandard };
        let (cfg, address) = (&self.filter, &self.address);
        filter::footprints(cfg, address, &self.roms, texture, &request, &mut sink, each);
    }
}
