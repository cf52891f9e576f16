//! The fingerprint of the device that is there.

use std::sync::OnceLock;

use tapline::fingerprint::aniso::Width;
use tapline::fingerprint::levels::Log;
use tapline::fingerprint::model::{Corner, Line, Seam};
use tapline::fingerprint::rho::{Projection, Rho};
use tapline::fingerprint::steps::{Rounding, Steps};
use tapline::fingerprint::{Fingerprint, fingerprint, honours};
use tapline::gpu::Gpu;
use tapline::gpu::sampling::DeviceSampler;
use tapline::sampler::{Format, Source};

pub(crate) use support::gpu::device as gpu;

/// The device's fingerprint, taken once for all tests.
fn of(gpu: &Gpu) -> &'static Fingerprint {
    static FOUND: OnceLock<Fingerprint> = OnceLock::new();
    FOUND.get_or_init(|| {
        fingerprint(&mut DeviceSampler::new(gpu), &|_| {}).expect("the device does its work")
    })
}

#[test]
fn the_device_keeps_the_rules_that_every_api_demands() {
    let Some(gpu) = gpu() else { return };
    let found = of(&gpu);
    for w in &found.weights {
        // The four weights of a look-up sum to 1; of 8-bit colours each of the four may be rounded by half a step.
        let limit = if w.format == Format::Unorm8 { 2.0 / 255.0 } else { 1.0 / 256.0 };
        assert!(w.sum <= limit, "{}: {}", w.format.name(), w.sum);
        assert!(w.axes.iter().all(|s| s.rising), "{}", w.format.name());
        assert!(w.axes.iter().all(|s| s.distinct > 32), "{}", w.format.name());
    }
    assert!(found.coordinates.clamps);
    assert!(found.coordinates.edge.iter().all(|w| (w - 1.0).abs() < 1e-6));
    // Vulkan asks for at least 4 bits of the level of detail.
    assert!(found.mips.distinct > 16);
    assert!(honours(found.neighbours[0].1), "clamp 1: {:?}", found.neighbours[0]);
    assert!(found.curve.repeats < 1.0 / 64.0);
}

#[test]
fn debian_12_lavapipe_is_described_and_every_look_up_is_predicted() {
    let Some(gpu) = gpu() else { return };
    let facts = gpu.adapter();
    if !(facts.name.starts_with("llvmpipe") && facts.driver_info.starts_with("Mesa 22.3")) {
        eprintln!("skipped: {} is not lavapipe 22.3", facts.title());
        return;
    }
    let found = of(&gpu);
    for w in &found.weights {
        let bytes = w.format == Format::Unorm8;
        let eight = Steps::Bits { bits: 8, rounding: Rounding::NearestEven };
        let steps = if bytes { eight } else { Steps::Smooth };
        assert!(w.axes.iter().all(|s| (s.steps, s.off) == (steps, 0)), "{}", w.format.name());
    }
    assert_eq!(found.curve.logs[0].rule, Log::MantissaOfSquare);
    assert_eq!(found.rho[0].rule, Rho::Longer);
    assert_eq!(found.cube_rho[0].rule, (Projection::Exact, Rho::Longer));
    assert_eq!(found.seams.rule, (Seam::Neighbour, Corner::Mean));
    assert_eq!(found.ties.expected, found.ties.seen.len());
    // Given gradients count at clamp 1 alone: differences between invocations take their place.
    for (clamp, lods) in &found.neighbours {
        assert_eq!(honours(*lods), *clamp == 1, "clamp {clamp}: {lods:?}");
    }
    for f in &found.filters {
        let ignored = f.rule.source == Source::Gradient;
        assert_eq!(f.rule.lod.width == Width::Zero, ignored, "{:?}", f.rule);
        assert_eq!(f.rule.line, Line::Ellipse(Seam::Clamped), "{:?}", f.rule);
    }
    for group in &found.checks {
        assert!(group.look_ups > 1500, "{group:?}");
        assert_eq!(group.within, group.look_ups, "{group:?}");
        // The ellipse's table of weights has 1024 entries: at an entry's border f32 and f64 may take neighbours.
        assert!(group.exact * 100 >= group.look_ups * 98, "{group:?}");
    }
}
