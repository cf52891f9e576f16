//! The checks of the ENV operation's stages.

use super::back_end::{BackEnd, FilterInput};
use super::cases::{Cases, ports};
use super::{Bounded, CHUNK, Checker, StageChecks};
use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::Progress;
use crate::fragment::PixelFragment;
use crate::gpu::{Gpu, GpuError};
use crate::reference::bump::bump;
use crate::reference::cube_face::{Facing, cube_face};
use crate::reference::jacobian::{Derivatives, Surface, jacobian};
use crate::reference::local_frame::{Frame, local_frame};
use crate::reference::reflect::reflect;
use crate::reference::roughness::roughness;
use crate::settings::Settings;
use crate::stage::Stage;

/// The rotation as the kernels have it.
pub(super) type Rotation = Option<[[Bounded; 3]; 3]>;

pub(super) fn rotation(settings: &Settings) -> Rotation {
    (settings.rotation != crate::settings::IDENTITY).then(|| settings.rotation.map(ports))
}

/// The case of `cube_face`.
pub(super) fn facing(
    cases: &mut Cases,
    direction: [Bounded; 3],
    rotation: &Rotation,
) -> Facing<Bounded> {
    cases.stage(Stage::CubeFace, direction, |tap, flags| {
        let facing = cube_face(direction, rotation.as_ref(), flags, tap);
        tap.add("face", num::u32(facing.face));
        if rotation.is_none() {
            // Without a rotation the reference has no such register.
            for (c, x) in direction.iter().enumerate() {
                tap.put.push(("rotated", c, x.value, 0.0));
            }
        }
        facing
    })
}

/// The operands of a kernel where a fragment has no frame.
fn no_frame() -> Frame<Bounded> {
    let (zero, vector) = (Bounded::exact(0.0), ports([0.0; 3]));
    let (inv_length, n_length) = (zero, zero);
    Frame { h: vector, direction: vector, inv_length, n_length, e1: vector, e2: vector }
}

/// The cases of one fragment.
fn fragment(
    cases: &mut Cases,
    back: &BackEnd<'_>,
    rotation: &Rotation,
    PixelFragment { pixel, fragment: f }: &PixelFragment,
) -> FilterInput {
    cases.pixel = *pixel;
    let (v, n) = (ports(f.v), ports(f.n));
    let used = f.h.filter(|_| f.bump.is_some() || f.rough.is_some()).map(ports);
    let frame = used.map(|h| {
        cases.stage(Stage::LocalFrame, (n, h), |tap, flags| local_frame(n, h, flags, tap))
    });
    let bumped = frame.zip(f.bump.map(ports));
    let n_mod = bumped.map_or(n, |(frame, b)| {
        let operands = (n, frame.e1, frame.e2, b);
        cases.stage(Stage::Bump, operands, |tap, _| bump(n, &frame, b, tap))
    });
    let reflection = cases.stage(Stage::Reflect, (v, n_mod), |tap, _| reflect(v, n_mod, tap));
    let facing = facing(cases, reflection.v_r, rotation);
    let surface = Surface { v, n, n_mod, bump: bumped, reflection, facing };
    let derivatives =
        Derivatives { dv: [ports(f.dv_dx), ports(f.dv_dy)], dn: [ports(f.dn_dx), ports(f.dn_dy)] };
    let bump = bumped.unwrap_or((no_frame(), ports([0.0; 2])));
    let operands = ([v, n, n_mod], bump, reflection, facing, derivatives.dv, derivatives.dn);
    let (dnmod, rotation) = (back.settings.policy.jacobian.dnmod, rotation.as_ref());
    let d = cases.stage(Stage::Jacobian, operands, |tap, _| {
        jacobian(&surface, &derivatives, dnmod, rotation, tap).d
    });
    let rough = frame.zip(f.rough.map(ports)).map(|(frame, factors)| {
        let [scale] = ports([back.settings.roughness_scale]);
        let operands = ([v, n_mod, frame.e1, frame.e2], reflection.n_dot_v, facing, factors);
        cases.stage(Stage::Roughness, operands, |tap, _| {
            roughness(&surface, &frame, factors, scale, rotation, tap).b
        })
    });
    back.fragment(cases, facing.face, [facing.u, facing.v], &d, rough.as_ref())
}

/// Checks every register of every stage of the ENV operation over fragments that all have what the first one has.
pub fn check_env(
    gpu: &Gpu,
    settings: &Settings,
    map: &CubeMap,
    fragments: &[PixelFragment],
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let mut back = BackEnd::cube(gpu, settings, map)?;
    let first = fragments.first().map(|f| &f.fragment);
    back.maps.policy = crate::engine::gpu::with_needs(back.maps.policy, first);
    let rotation = rotation(settings);
    let mut checker = Checker::default();
    for chunk in fragments.chunks(CHUNK) {
        let mut cases = Cases::default();
        let inputs: Vec<FilterInput> =
            chunk.iter().map(|f| fragment(&mut cases, &back, &rotation, f)).collect();
        back.check(&mut checker, cases, &inputs)?;
        checker.found.fragments += num::u64(chunk.len());
        progress(num::u64(chunk.len()));
    }
    Ok(checker.found)
}
