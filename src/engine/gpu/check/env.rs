//! The checks of the ENV operation's stages.

use super::behind::{Behind, Footing};
use super::{
    Bounded, CHUNK, Case, Checker, Register, StageChecks, Station, bits, float, handed, handed_on,
    ports, recorded, whole,
};
use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::Progress;
use crate::fragment::PixelFragment;
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::policy::Policy;
use crate::gpu::{Gpu, GpuError};
use crate::reference::bump::bump;
use crate::reference::cube_face::{Facing, cube_face};
use crate::reference::jacobian::{Derivatives, Surface, jacobian};
use crate::reference::local_frame::{Frame, local_frame};
use crate::reference::reflect::{Reflection, reflect};
use crate::reference::roughness::roughness;
use crate::settings::Settings;
use crate::stage::Stage;

const LOCAL_FRAME: &[Register] = &[
    float("h", 3),
    float("cross", 3),
    float("inv_length", 1),
    float("e1", 3),
    float("e2", 3),
    whole("flags"),
];
const BUMP: &[Register] = &[float("n_mod", 3)];
const REFLECT: &[Register] = &[float("n_dot_v", 1), float("n_dot_n", 1), float("v_r", 3)];
pub(super) const CUBE_FACE: &[Register] = &[
    float("rotated", 3),
    float("inv_ma", 1),
    float("u", 1),
    float("v", 1),
    whole("face"),
    whole("flags"),
];
const JACOBIAN: &[Register] = &[
    float("along", 2),
    float("dn_mod", 6),
    float("n_dot_dv", 2),
    float("v_dot_dn", 2),
    float("n_dot_dn", 2),
    float("dv_r", 6),
    float("numerator", 4),
    float("d", 4),
];
const ROUGHNESS: &[Register] = &[
    float("d_scaled", 3),
    float("v_dot_e", 2),
    float("n_dot_e", 2),
    float("dv_r", 6),
    float("numerator", 4),
    float("e", 4),
    float("b", 4),
];

/// The stages before `covariance`, in order.
const FRONT: [(Stage, &[Register]); 6] = [
    (Stage::LocalFrame, LOCAL_FRAME),
    (Stage::Bump, BUMP),
    (Stage::Reflect, REFLECT),
    (Stage::CubeFace, CUBE_FACE),
    (Stage::Jacobian, JACOBIAN),
    (Stage::Roughness, ROUGHNESS),
];

/// The rotation as the kernels have it.
pub(super) type Rotation = Option<[[Bounded; 3]; 3]>;

pub(super) fn rotation(settings: &Settings) -> Rotation {
    (settings.rotation != crate::settings::IDENTITY).then(|| settings.rotation.map(ports))
}

/// A facing's words as an operand.
fn facing_words(facing: &Facing<Bounded>) -> Vec<u32> {
    let face = num::u32(facing.face);
    let mut words = vec![face];
    words.extend(bits(&[facing.inv_ma, facing.u, facing.v]));
    words
}

/// The case of `cube_face`, and the facing as the next stage gets it.
pub(super) fn facing_case(
    direction: [Bounded; 3],
    rotation: &Rotation,
    pixel: [u32; 2],
) -> (Case, Facing<Bounded>) {
    let (facing, mut recorder, undecided) =
        recorded(|tap, flags| cube_face(direction, rotation.as_ref(), flags, tap));
    recorder.add("face", num::u32(facing.face));
    if rotation.is_none() {
        // Without a rotation the reference has no such register.
        for (c, x) in direction.iter().enumerate() {
            recorder.put.push(("rotated", c, x.value, 0.0));
        }
    }
    let case = Case {
        pixel,
        operands: bits(&direction).collect(),
        expected: recorder.expected(CUBE_FACE),
        undecided,
    };
    let facing = Facing {
        face: facing.face,
        inv_ma: handed_on(facing.inv_ma),
        u: handed_on(facing.u),
        v: handed_on(facing.v),
    };
    (case, facing)
}

/// The cases of one fragment, by `FRONT`, and what stands behind them.
fn fragment_cases(
    settings: &Settings,
    rotation: &Rotation,
    PixelFragment { pixel, fragment: f }: &PixelFragment,
    cases: &mut [Vec<Case>; 6],
) -> Footing {
    let pixel = *pixel;
    let mut put =
        |at: usize, operands: Vec<u32>, (recorder, undecided): (super::Recorder, bool)| {
            cases[at].push(Case {
                pixel,
                operands,
                expected: recorder.expected(FRONT[at].1),
                undecided,
            });
        };
    let (v, n) = (ports(f.v), ports(f.n));
    let used = f.h.filter(|_| f.bump.is_some() || f.rough.is_some());
    let frame = used.map(|h| {
        let h = ports(h);
        let (frame, recorder, undecided) = recorded(|tap, flags| local_frame(n, h, flags, tap));
        put(0, bits(&n).chain(bits(&h)).collect(), (recorder, undecided));
        Frame {
            h: handed(frame.h),
            direction: handed(frame.direction),
            inv_length: handed_on(frame.inv_length),
            n_length: handed_on(frame.n_length),
            e1: handed(frame.e1),
            e2: handed(frame.e2),
        }
    });
    let bumped = frame.zip(f.bump.map(ports));
    let mut n_mod = n;
    if let Some((frame, b)) = &bumped {
        let (found, recorder, undecided) = recorded(|tap, _| bump(n, frame, *b, tap));
        let words = bits(&n).chain(bits(&frame.e1)).chain(bits(&frame.e2)).chain(bits(b));
        put(1, words.collect(), (recorder, undecided));
        n_mod = handed(found);
    }
    let (found, recorder, undecided) = recorded(|tap, _| reflect(v, n_mod, tap));
    put(2, bits(&v).chain(bits(&n_mod)).collect(), (recorder, undecided));
    let reflection = Reflection {
        v_r: handed(found.v_r),
        n_dot_v: handed_on(found.n_dot_v),
        n_dot_n: handed_on(found.n_dot_n),
    };
    let (case, facing) = facing_case(reflection.v_r, rotation, pixel);
    let facing_operands = facing_words(&facing);
    let surface = Surface { v, n, n_mod, bump: bumped, reflection, facing };
    let derivatives =
        Derivatives { dv: [ports(f.dv_dx), ports(f.dv_dy)], dn: [ports(f.dn_dx), ports(f.dn_dy)] };
    let (found, recorder, undecided) = recorded(|tap, _| {
        jacobian(&surface, &derivatives, settings.policy.jacobian.dnmod, rotation.as_ref(), tap)
    });
    let nothing = ([Bounded::exact(0.0); 3], Bounded::exact(0.0));
    let (h, direction, inv_length, n_length) = bumped
        .map_or((nothing.0, nothing.0, nothing.1, nothing.1), |(frame, _)| {
            (frame.h, frame.direction, frame.inv_length, frame.n_length)
        });
    let b = bumped.map_or([nothing.1; 2], |(_, b)| b);
    let mut words: Vec<u32> = [v, n, n_mod, h, direction].iter().flat_map(|x| bits(x)).collect();
    words.extend(bits(&[inv_length, n_length, b[0], b[1]]));
    words.extend(bits(&[reflection.n_dot_v, reflection.n_dot_n]));
    words.extend(&facing_operands);
    words.extend(bits(derivatives.dv.as_flattened()).chain(bits(derivatives.dn.as_flattened())));
    put(4, words, (recorder, undecided));
    let d = found.d.map(handed);
    let rough = frame.zip(f.rough).map(|(frame, factors)| {
        let factors = ports(factors);
        let [scale] = ports([settings.roughness_scale]);
        let (found, recorder, undecided) =
            recorded(|tap, _| roughness(&surface, &frame, factors, scale, rotation.as_ref(), tap));
        let vectors = [v, n_mod, frame.e1, frame.e2];
        let mut words: Vec<u32> = vectors.iter().flat_map(|x| bits(x)).collect();
        words.extend(bits(&[reflection.n_dot_v]));
        words.extend(&facing_operands);
        words.extend(bits(&factors));
        put(5, words, (recorder, undecided));
        found.b.map(handed)
    });
    cases[3].push(case);
    Footing {
        pixel,
        face: surface.facing.face,
        centre: [surface.facing.u, surface.facing.v],
        d,
        rough,
    }
}

/// Checks every register of every stage of the ENV operation over fragments that all have what the first one has.
///
/// # Errors
///
/// What the driver reports.
pub fn check_env(
    gpu: &Gpu,
    settings: &Settings,
    map: &CubeMap,
    fragments: &[PixelFragment],
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let mut behind = Behind::cube(gpu, settings, map)?;
    let first = fragments.first().map(|f| &f.fragment);
    let policy: Policy = crate::engine::gpu::with_needs(behind.policy.clone(), first);
    behind.policy = policy;
    let maps = Maps::none(gpu)?;
    let rotation = rotation(settings);
    let mut checker = Checker::new(gpu);
    for chunk in fragments.chunks(CHUNK) {
        let mut cases: [Vec<Case>; 6] = Default::default();
        let footings: Vec<Footing> = chunk
            .iter()
            .map(|fragment| fragment_cases(settings, &rotation, fragment, &mut cases))
            .collect();
        for ((stage, registers), cases) in FRONT.into_iter().zip(&mut cases) {
            let station = Station {
                kernel: Kernel::Stage(stage),
                maps: &maps,
                policy: &behind.policy,
                registers,
            };
            checker.stage(&station, cases, &|_, _| {})?;
        }
        behind.check(&mut checker, &footings)?;
        checker.found.fragments += num::u64(chunk.len());
        progress(num::u64(chunk.len()));
    }
    Ok(checker.found)
}
