//! The note's three comparisons (Cline 2023, figures 4 to 7) on the built-in scenes, in touched tiles.

use crate::cube::CubeMap;
use crate::engine::tex_subject::{TexEngine, TexSubject};
use crate::engine::{Progress, Rendering};
use crate::error::InputError;
use crate::planar::PlanarMap;
use crate::policy::ConeMetric;
use crate::scene::SceneOptions;
use crate::scene::tex::build;
use crate::unit::{ReferenceAxis, UnitSpec};

/// One way to render a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// What it is called.
    pub label: &'static str,
    /// Scene.
    pub scene: &'static str,
    /// Which footprint its requests take.
    pub metric: ConeMetric,
    /// Cones of a ray.
    pub cones: u32,
    /// Tiles of the note's figure, where it gives them.
    pub note: Option<u32>,
}

/// Two ways against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Comparison {
    /// Name of the pair, and of its picture.
    pub name: &'static str,
    /// First the one that ought to need fewer tiles, or, for `concave`, that is sharper.
    pub variants: [Variant; 2],
}

const fn variant(
    label: &'static str,
    scene: &'static str,
    metric: ConeMetric,
    cones: u32,
    note: Option<u32>,
) -> Variant {
    Variant { label, scene, metric, cones, note }
}

/// Every comparison.
pub const COMPARISONS: [Comparison; 4] = [
    Comparison {
        name: "convex",
        variants: [
            variant("cones", "convex", ConeMetric::Cone, 2, Some(425)),
            variant("distance", "convex", ConeMetric::Distance, 2, Some(1564)),
        ],
    },
    Comparison {
        name: "concave",
        variants: [
            variant("cones", "concave", ConeMetric::Cone, 2, None),
            variant("distance", "concave", ConeMetric::Distance, 2, None),
        ],
    },
    Comparison {
        name: "thin-lens",
        variants: [
            variant("two cones", "thin-lens", ConeMetric::Cone, 2, Some(841)),
            variant("one cone", "thin-lens", ConeMetric::Cone, 1, Some(6180)),
        ],
    },
    Comparison {
        name: "vases",
        variants: [
            variant("lined", "vases-lined", ConeMetric::Cone, 2, Some(704)),
            variant("glazed", "vases", ConeMetric::Cone, 2, Some(1249)),
        ],
    },
];

/// What a variant took.
#[derive(Clone, Debug)]
pub struct Taken {
    /// Picture, levels, tiles.
    pub rendering: Rendering,
    /// Requests to textures and to the environment.
    pub requests: u64,
}

impl Taken {
    /// Tiles of all textures, and of level 0 alone.
    #[must_use]
    pub fn tiles(&self) -> [usize; 2] {
        let tiles = self.rendering.texture_use.iter().flat_map(|u| &u.tiles);
        tiles.fold([0; 2], |sum, t| {
            let finest = t.counts().first().copied().unwrap_or(0);
            [sum[0] + t.total(), sum[1] + finest]
        })
    }
}

/// Renders a variant by the integer model.
pub fn render(
    variant: &Variant,
    spec: &UnitSpec,
    options: &SceneOptions,
    (floor, sky): (Option<&PlanarMap>, &CubeMap),
    progress: Progress<'_>,
) -> Result<Taken, InputError> {
    let mut spec = spec.clone();
    spec.config.policy.cone.metric = variant.metric;
    spec.config.policy.cone.count = variant.cones;
    let scene = build(variant.scene, options, floor.cloned())?;
    let subject = TexSubject::new(scene, sky.clone());
    let engine = TexEngine::new(&spec, &subject)?;
    let settings = spec.settings(ReferenceAxis::Exact);
    Ok(Taken { requests: subject.requests, rendering: subject.rtl(&engine, &settings, progress) })
}
