//! Running a unit: each stage over a block, and all of them.

use super::Unit;
use super::block::{NO_FLAGS, Results, State};
use crate::stages::filter::Corner;
use crate::stages::jacobian::normal_derivative;
use crate::stages::{
    Sink, address, bump, covariance, cube_face, eigen, filter, footprint, jacobian, local_frame,
    reflect, roughness,
};
use crate::tap::{NoTapStandard, Tap};
use crate::texture::Texture;

impl Unit {
    /// `local_frame`, if the scene needs it.
    #[inline(always)]
    pub fn local_frame<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let Some(cfg) = &self.frame else { return };
        let input = local_frame::In {
            n: &state.input.n,
            n_exp: &state.input.n_exp,
            h: &state.input.h,
            h_exp: &state.input.h_exp,
        };
        local_frame::local_frame(
            cfg,
            &self.roms,
            input,
            &mut state.frame,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// `bump`, if the scene needs it.
    #[inline(always)]
    pub fn bump<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let Some(cfg) = &self.bump else { return };
        let input = bump::In {
            n: &state.input.n,
            n_exp: &state.input.n_exp,
            e1: &state.frame.e1,
            e2: &state.frame.e2,
            b: &state.input.b,
        };
        bump::bump(cfg, input, &mut state.bumped, &mut state.flags[..state.len], tap);
    }

    /// `reflect`.
    #[inline(always)]
    pub fn reflect<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        // Without a bump but with a frame the port's format is the frame's: normalise once more.
        let n_mod_frac = match (&self.bump, &self.frame) {
            (Some(_), _) => Some(self.bump_frac),
            (None, Some(frame)) => Some(frame.n.block_frac()),
            (None, None) => None,
        };
        let input = reflect::In {
            v: &state.input.v,
            v_exp: &state.input.v_exp,
            n: if self.bump.is_some() { &state.bumped.n_mod } else { &state.input.n },
            n_exp: &state.input.n_exp,
            n_mod_frac,
        };
        reflect::reflect(
            &self.reflect,
            input,
            &mut state.reflected,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// `cube_face`.
    #[inline(always)]
    pub fn cube_face<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let mut exp = [0; N];
        for (lane, e) in exp.iter_mut().enumerate().take(state.len) {
            *e = state.input.v_exp[lane]
                + 2 * (state.input.n_exp[lane] + state.reflected.n_lift[lane]);
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
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// The first step of `jacobian`: the derivative of the modified normal.
    #[inline(always)]
    pub fn normal_derivative<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let input = normal_derivative::In {
            dn: &state.input.dn,
            n_exp: &state.input.n_exp,
            n_lift: &state.reflected.n_lift,
            bumped: self.bump.as_ref().map(|_| normal_derivative::Bumped {
                n: &state.input.n,
                h: &state.input.h,
                e1: &state.frame.e1,
                e2: &state.frame.e2,
                b: &state.input.b,
            }),
        };
        normal_derivative::normal_derivative(
            &self.normal,
            &self.roms,
            input,
            &mut state.dn_mod,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// `jacobian`, from the derivative of the modified normal on.
    #[inline(always)]
    pub fn jacobian<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let input = jacobian::In {
            v: &state.input.v,
            v_exp: &state.input.v_exp,
            n_exp: &state.input.n_exp,
            dv: &state.input.dv,
            dn_mod: &state.dn_mod,
            reflect: &state.reflected,
            face: &state.face,
        };
        jacobian::jacobian(&self.jacobian, input, &mut state.d, &mut state.flags[..state.len], tap);
    }

    /// `roughness`, if the scene needs it.
    #[inline(always)]
    pub fn roughness<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let Some(cfg) = &self.roughness else { return };
        let input = roughness::In {
            v: &state.input.v,
            v_exp: &state.input.v_exp,
            n_exp: &state.input.n_exp,
            e1: &state.frame.e1,
            e2: &state.frame.e2,
            d: &state.input.d,
            reflect: &state.reflected,
            face: &state.face,
        };
        roughness::roughness(cfg, input, &mut state.b, &mut state.flags[..state.len], tap);
    }

    /// `covariance`.
    #[inline(always)]
    pub fn covariance<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let input = covariance::In {
            d: &state.d.d,
            b: self.roughness.as_ref().map(|_| &state.b.b),
            exp: self.block_d.then_some(&state.d_exp),
        };
        covariance::covariance(
            &self.covariance,
            input,
            &mut state.k,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// `eigen`.
    #[inline(always)]
    pub fn eigen<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let input = eigen::In { covariance: &state.k };
        eigen::eigen(
            &self.eigen,
            &self.roms,
            input,
            &mut state.axes,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// `footprint`.
    #[inline(always)]
    pub fn footprint<const N: usize, T: Tap>(&self, state: &mut State<N>, tap: &mut T) {
        let input = footprint::In { eigen: &state.axes };
        footprint::footprint(
            &self.footprint,
            &self.roms,
            input,
            &mut state.line,
            &mut state.flags[..state.len],
            tap,
        );
    }

    /// The texture request of one lane.
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

    /// `address` and `filter`, or without a texture the probe counts and flags.
    #[inline(always)]
    pub fn back<const N: usize, T: Tap>(
        &self,
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
