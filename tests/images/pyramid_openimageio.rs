//! The roughness pyramid against files whose mip chains OpenImageIO made.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use exr::image::{FlatSamples, Levels};
use exr::prelude::{ReadChannels as _, ReadLayers as _, read};
use tapline::policy::{Curvature, RoughnessInterpolation};
use tapline::scene::bump::BumpMap;
use tapline::scene::pyramid::Pyramid;

/// One channel: a plane for each level.
type Channel = Vec<Vec<f64>>;

/// The stored levels of slopes and slope moments: dhds, dhdt, dhds², dhdt², dhds·dhdt; and whether the
/// file holds half floats.
fn stored(path: &Path) -> ([Channel; 5], bool) {
    let image = read()
        .no_deep_data()
        .all_resolution_levels()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let mut half = false;
    let planes = ["b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"].map(|name| {
        let channel = channels.iter().find(|c| c.name.to_string() == name).unwrap();
        let levels = match &channel.sample_data {
            Levels::Mip { level_data, .. } => level_data,
            Levels::Singular(_) | Levels::Rip { .. } => panic!("{name} has no mip chain"),
        };
        levels
            .iter()
            .map(|level| match level {
                FlatSamples::F16(values) => {
                    half = true;
                    values.iter().map(|v| f64::from(v.to_f32())).collect()
                }
                FlatSamples::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
                FlatSamples::U32(_) => panic!("{name} holds integers"),
            })
            .collect()
    });
    (planes, half)
}

fn folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/bump");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: {} is not there; nothing was compared", folder.display());
    None
}

#[test]
fn covariances_agree_with_openimageio_at_every_level() {
    let Some(folder) = folder() else { return };
    for name in ["oiio-bumpslope.exr", "oiio-bumpslope-central.exr", "oiio-bumpslope-normal.exr"] {
        let (planes, half) = stored(&folder.join(name));
        let size = planes[0][0].len().isqrt();
        // Slopes up to 10 and more: an eighth of them keeps offsets short, and is exact.
        let values: Vec<[f32; 2]> =
            (0..size * size).map(|i| [0, 1].map(|c| narrow(-planes[c][0][i] / 8.0))).collect();
        let map = BumpMap::from_offsets(size, size, &values).unwrap();
        assert_eq!(map.cleaned(), 0);
        let pyramid =
            Pyramid::new(Arc::new(map), Curvature::Pyramid, RoughnessInterpolation::Moments);
        assert_eq!(pyramid.levels(), planes[0].len(), "{name}");
        let stored_at = |c: usize, level: usize, i: usize| planes[c][level][i];
        let mut worst = 0.0f64;
        let mut rough = 0;
        for level in 1..pyramid.levels() {
            let [width, height] = pyramid.size(level);
            // Units of rounding of the file, u. Its level 0 is rounded (relative u for b, so 2u for a
            // square) while its upper levels may come from numbers before that rounding, are averaged
            // in single (at most 4 roundings a level, u_single each) and rounded again. So a mean is off
            // by at most 2u·E|b|, a second moment by 3u·E[b²], and cov = m2 − m1² by (3 + 4)u·E[b²]
            // plus averaging, twice (once in m2, once in m1²).
            let unit = if half { 1.0 / 2048.0 } else { 1.0 / 16_777_216.0 };
            let averaging = 3.0 * 4.0 * level as f64 / 16_777_216.0;
            for y in 0..height {
                for x in 0..width {
                    let i = y * width + x;
                    let at = |c| stored_at(c, level, i);
                    let theirs =
                        [at(2) - at(0) * at(0), at(4) - at(0) * at(1), at(3) - at(1) * at(1)];
                    let got = pyramid.texel(level, x, y).covariance.map(|c| 64.0 * c);
                    let squares = [at(2), (at(2) * at(3)).sqrt(), at(3)];
                    for k in 0..3 {
                        let bound = (7.0 * unit + averaging) * squares[k];
                        let error = (theirs[k] - got[k]).abs();
                        worst = worst.max(error / bound);
                        assert!(
                            error <= bound,
                            "{name} level {level} texel {x}, {y} entry {k}: {} against {} within {bound}",
                            got[k],
                            theirs[k]
                        );
                        rough += usize::from(got[k].abs() > 16.0 * bound);
                    }
                }
            }
        }
        eprintln!("{name}: worst error {worst:.3} of its bound, {rough} entries above 16 bounds");
        assert!(rough > 1000, "{name}: the covariances compared are not trivial");
    }
}

/// Half and single are both exact in single, and so is an eighth of them.
#[expect(clippy::cast_possible_truncation, reason = "exact, see above")]
fn narrow(value: f64) -> f32 {
    value as f32
}

#[test]
fn slopes_of_their_heights_are_theirs() {
    // Their slopes are Sobel sums over 8 times 64, and central differences over 2, of heights that are
    // stored too; both away from the border of two texels, where their wrap differs. The sign of b1 is
    // against the slope; rows grow against e2, so b2 has the slope's sign.
    let Some(folder) = folder() else { return };
    use tapline::scene::bump::Difference::{Central, Sobel};
    for (name, difference, scale) in
        [("oiio-bumpslope.exr", Sobel, 64.0), ("oiio-bumpslope-central.exr", Central, 1.0)]
    {
        let path = folder.join(name);
        let (planes, half) = stored(&path);
        let heights = stored_heights(&path);
        let size = heights.len().isqrt();
        let map = BumpMap::from_height_by(size, size, &heights, scale / 8.0, difference).unwrap();
        // Half: heights below 1 are wrong by 2^-12 at most, two of them halved; the slope is
        // rounded too. Single: at most 8 roundings of sums of 4·|height| ≤ 4, over 8, times 64.
        let bound = |slope: f64| {
            if half {
                slope.abs() / 2048.0 + 1.0 / 4096.0
            } else {
                slope.abs() / 16_777_216.0 + 8.0 * 4.0 / 8.0 * 64.0 / 16_777_216.0
            }
        };
        for y in 2..size - 2 {
            for x in 2..size - 2 {
                let i = y * size + x;
                let [b1, b2] = map.texel(x, y).map(|b| 8.0 * b);
                let (ds, dt) = (planes[0][0][i], planes[1][0][i]);
                assert!((b1 + ds).abs() <= bound(ds), "{name} {x}, {y}: {b1} against −{ds}");
                assert!((b2 - dt).abs() <= bound(dt), "{name} {x}, {y}: {b2} against {dt}");
            }
        }
    }
}

/// Level 0 of the height channel.
fn stored_heights(path: &Path) -> Vec<f32> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let list = &image.layer_data[0].channel_data.list;
    let channel = list.iter().find(|c| c.name.to_string() == "b0_h").unwrap();
    channel.sample_data.values_as_f32().collect()
}
