// Stage `ray_cone`: the changes of a ray cone along a path (Cline 2023).

/// x: full angle in radians, positive where the cone diverges; y: full width in world units.
alias Cone = vec2f;

const STEP_PROPAGATE: u32 = 0u;
const STEP_REFLECT: u32 = 1u;
const STEP_REFRACT: u32 = 2u;
const STEP_SCATTER: u32 = 3u;

/// Greatest spread of one scatter, and OptiX Toolkit's limit of an angle.
const S_MAX: f32 = 0.25;
const INVERSE_PI: f32 = 0.31830987;

/// One operation: the distance; the curvature; the curvature, the index before and behind; the BSDF's value.
struct ConeStep {
    kind: u32,
    operand: vec3f,
}

/// A quotient, the largest number of the right sign where the divisor is 0, and 0 for 0/0.
fn total_quotient(above: f32, below: f32) -> f32 {
    if below == 0.0 {
        return sign(above) * MOST;
    }
    return above / below;
}

/// The cone after one operation.
fn ray_cone(cone: Cone, step: ConeStep) -> Cone {
    let angle = cone.x;
    let width = cone.y;
    let otk = policy.cone_rules == CONE_RULES_OTK;
    if otk && step.kind != STEP_PROPAGATE && angle >= S_MAX {
        return cone;
    }
    switch step.kind {
        case 0u: {
            let moved = width + angle * step.operand.x;
            if angle < 0.0 && moved < 0.0 {
                return Cone(-angle, -moved);
            }
            return Cone(angle, moved);
        }
        case 1u: {
            return Cone(angle + (2.0 * step.operand.x) * abs(width), width);
        }
        case 2u: {
            let bend = step.operand.x * abs(width);
            let outside = step.operand.y;
            let inside = step.operand.z;
            if inside != 0.0 && outside == inside {
                return cone;
            }
            let through = outside * (angle + bend);
            if inside == 0.0 {
                return Cone(select(total_quotient(through, inside), -bend, through == 0.0), width);
            }
            return Cone(through / inside - bend, width);
        }
        default: {
            let bsdf = step.operand.x;
            var spread = S_MAX;
            if bsdf > INVERSE_PI {
                spread = S_MAX * INVERSE_PI / bsdf;
            }
            let away = otk && angle < 0.0;
            let turned = angle + select(spread, -spread, away);
            if otk && abs(turned) >= S_MAX {
                if policy.cone_set_diffuse == CONE_SET_DIFFUSE_ANGLE {
                    return Cone(S_MAX, abs(width));
                }
                return Cone(abs(width), S_MAX);
            }
            return Cone(turned, width);
        }
    }
}

/// A pixel's width on the image plane, 2·min(|U|/columns, |V|/rows).
fn pixel_width() -> f32 {
    let across = 2.0 * length_of(policy.camera_u.xyz) / f32(policy.columns);
    let down = 2.0 * length_of(policy.camera_v.xyz) / f32(policy.rows);
    return min(across, down);
}

/// ⟨D,W⟩/⟨W,W⟩; 0 where W is 0.
fn per_distance(direction: vec3f) -> f32 {
    let w = policy.camera_w.xyz;
    let square = dot3(w, w);
    if square == 0.0 {
        return 0.0;
    }
    return dot3(direction, w) / square;
}

/// α = 2 min(|U|/columns, |V|/rows)·⟨D,W⟩/⟨W,W⟩, w = 0.
fn pinhole(direction: vec3f) -> Cone {
    return Cone(pixel_width() * per_distance(direction), 0.0);
}

/// α = −w_lens⟨D,W⟩/⟨W,W⟩, w = w_lens.
fn thin_lens(direction: vec3f, lens_width: f32) -> Cone {
    return Cone(-(lens_width * per_distance(direction)), lens_width);
}

/// α = 0, w = a pixel's width on the image plane.
fn orthographic() -> Cone {
    return Cone(0.0, pixel_width());
}

/// The two cones of a ray from the camera: a thin lens's and a pinhole's, or a pinhole's or an orthographic camera's and
/// that of a lens of one pixel's width.
fn camera_cones(direction: vec3f) -> array<Cone, 2> {
    if policy.cone_metric == CONE_METRIC_DISTANCE {
        return array<Cone, 2>(pinhole(direction), pinhole(direction));
    }
    switch policy.lens {
        case 0u: { return array<Cone, 2>(pinhole(direction), thin_lens(direction, pixel_width())); }
        case 1u: { return array<Cone, 2>(thin_lens(direction, policy.camera_w.w), pinhole(direction)); }
        default: { return array<Cone, 2>(orthographic(), thin_lens(direction, pixel_width())); }
    }
}

/// A ray's cones after the `count` steps that start at `first` in `steps`, four words each, and the one of the two that a
/// look-up takes: that of the larger width, or of the larger angle for the environment.
///
/// At the first hit of a pinhole or an orthographic camera the first cone counts alone.
fn walk(direction: vec3f, first: u32, count: u32, by_angle: bool) -> Cone {
    var cones = camera_cones(direction);
    var bounced = false;
    for (var i = 0u; i < count; i++) {
        let at = first + 4u * i;
        let operand = vec3f(steps[at + 1u], steps[at + 2u], steps[at + 3u]);
        let step = ConeStep(u32(steps[at]), operand);
        let bounce = step.kind != STEP_PROPAGATE;
        bounced = bounced || bounce;
        if bounce && policy.cone_metric == CONE_METRIC_DISTANCE {
            continue;
        }
        cones[0] = ray_cone(cones[0], step);
        cones[1] = ray_cone(cones[1], step);
    }
    let single = policy.cone_metric == CONE_METRIC_DISTANCE || policy.cone_count < 2u;
    let alone = single || (policy.lens != LENS_THIN && !bounced);
    return choose(cones, by_angle, alone);
}

/// The cone of two that a look-up takes; the first one on ties, and where it is `alone`.
fn choose(cones: array<Cone, 2>, by_angle: bool, alone: bool) -> Cone {
    let first = select(abs(cones[0].y), abs(cones[0].x), by_angle);
    let second = select(abs(cones[1].y), abs(cones[1].x), by_angle);
    if alone || first >= second {
        return cones[0];
    }
    return cones[1];
}
