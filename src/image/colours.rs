//! The planes of an image that are light, found by their names.

use super::planar::list;

/// Which planes make up a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Indices of red, green and blue.
    Rgb([usize; 3]),
    /// One plane for all three.
    Grey(usize),
}

impl Colour {
    /// The planes, grey three times.
    #[must_use]
    pub const fn planes(self) -> [usize; 3] {
        match self {
            Self::Rgb(rgb) => rgb,
            Self::Grey(y) => [y; 3],
        }
    }
}

/// Single channels that are no light: depths, places, coverage, numbers of things.
const NO_LIGHT: [&str; 14] = [
    "a", "alpha", "z", "zback", "depth", "distance", "dist", "x", "u", "v", "id", "ry", "by",
    "mask",
];

/// Last words of layers that hold the finished picture.
const WHOLE_PICTURE: [&str; 7] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "final"];

/// A channel's layer and its own name in lower case; `red` is `r`.
fn split(name: &str) -> (&str, String) {
    let (layer, own) = name.rsplit_once('.').unwrap_or(("", name));
    let own = own.to_lowercase();
    let short = match own.as_str() {
        "red" => "r",
        "green" => "g",
        "blue" => "b",
        _ => return (layer, own),
    };
    (layer, short.to_owned())
}

/// The colour planes of these channels, in the layer or channel of that name where one is given.
///
/// The order: R, G and B without a layer; Y without one; the only layer that has all three, or the
/// only one whose name says that it is the whole picture (`View.Combined`); the only layer with a Y;
/// a lone channel that is no depth, place or coverage. Y beside X, RY or BY is no luminance.
///
/// # Errors
/// What was found, where no rule or more than one layer fits.
pub(super) fn find(names: &[&str], chosen: Option<&str>) -> Result<Colour, String> {
    let split: Vec<(&str, String)> = names.iter().map(|n| split(n)).collect();
    let of = |layer: &str, own: &str| split.iter().position(|(l, o)| *l == layer && o == own);
    let rgb = |layer: &str| Some(Colour::Rgb([of(layer, "r")?, of(layer, "g")?, of(layer, "b")?]));
    let grey = |layer: &str| {
        let coloured = ["x", "ry", "by"].iter().any(|own| of(layer, own).is_some());
        of(layer, "y").filter(|_| !coloured).map(Colour::Grey)
    };
    let lone = |layer: Option<&str>, strict: bool| {
        let mut light = (0..split.len()).filter(|i| {
            let (l, own) = &split[*i];
            layer.is_none_or(|layer| layer == *l)
                && !(own == "a" || own == "alpha")
                && !(strict && NO_LIGHT.contains(&own.as_str()))
        });
        let first = light.next()?;
        let mut others =
            (0..split.len()).filter(|i| *i != first && layer.is_none_or(|l| l == split[*i].0));
        let alone = others.all(|i| split[i].1 == "a" || split[i].1 == "alpha");
        alone.then_some(Colour::Grey(first))
    };
    if let Some(chosen) = chosen {
        let exact = || names.iter().position(|n| *n == chosen).map(Colour::Grey);
        let found = rgb(chosen).or_else(|| grey(chosen)).or_else(|| lone(Some(chosen), false));
        return found.or_else(exact).ok_or_else(|| list(names));
    }
    let mut layers: Vec<&str> = split.iter().map(|(l, _)| *l).filter(|l| !l.is_empty()).collect();
    layers.dedup();
    layers.sort_unstable();
    layers.dedup();
    if let Some(plain) = rgb("").or_else(|| grey("")) {
        return Ok(plain);
    }
    let full: Vec<&str> = layers.iter().copied().filter(|l| rgb(l).is_some()).collect();
    let whole: Vec<&str> = full.iter().copied().filter(|l| says_whole(l)).collect();
    match (&full[..], &whole[..]) {
        ([only], _) | (_, [only]) => return rgb(only).ok_or_else(|| list(names)),
        ([], _) => {}
        _ => return Err(format!("several layers with colours: {}", list(&full))),
    }
    let luminances: Vec<Colour> = layers.iter().filter_map(|l| grey(l)).collect();
    match luminances[..] {
        [only] => Ok(only),
        _ => lone(None, true).ok_or_else(|| list(names)),
    }
}

/// The planes of vectors: R G, X Y or X Y Z of one layer where no colour is there; two or three.
pub(super) fn vector(names: &[&str], chosen: Option<&str>) -> Option<Vec<usize>> {
    let split: Vec<(&str, String)> = names.iter().map(|n| split(n)).collect();
    let of = |layer: &str, own: &str| split.iter().position(|(l, o)| *l == layer && o == own);
    let in_layer = |layer: &str| {
        let all = |set: &[&str]| set.iter().map(|own| of(layer, own)).collect::<Option<Vec<_>>>();
        [&["r", "g", "b"][..], &["x", "y", "z"], &["x", "y"], &["r", "g"]].into_iter().find_map(all)
    };
    match chosen {
        Some(chosen) => in_layer(chosen),
        None => split.iter().find_map(|(layer, _)| in_layer(layer)),
    }
}

/// Whether a layer's last word says that it is the whole picture.
fn says_whole(layer: &str) -> bool {
    let last = layer.rsplit('.').next().unwrap_or(layer).to_lowercase();
    WHOLE_PICTURE.contains(&last.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_found_by_name_and_depth_is_never_light() {
        let of = |names: &[&str]| find(names, None).ok();
        let rgb = Colour::Rgb;
        assert_eq!(of(&["A", "B", "G", "R"]), Some(rgb([3, 2, 1])));
        assert_eq!(of(&["b", "g", "r", "Z"]), Some(rgb([2, 1, 0])));
        assert_eq!(of(&["blue", "green", "Red"]), Some(rgb([2, 1, 0])));
        assert_eq!(of(&["B", "G", "R", "v.B", "v.G", "v.R"]), Some(rgb([2, 1, 0])));
        assert_eq!(of(&["v.B", "v.G", "v.R"]), Some(rgb([2, 1, 0])));
        let blender = ["L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Depth.Z"];
        assert_eq!(of(&blender), Some(rgb([2, 1, 0])));
        let passes = [&blender[..], &["L.Emit.B", "L.Emit.G", "L.Emit.R"]].concat();
        assert_eq!(of(&passes), Some(rgb([2, 1, 0])));
        assert_eq!(find(&passes, Some("L.Emit")), Ok(rgb([6, 5, 4])));
        assert_eq!(find(&passes, Some("L.Depth.Z")), Ok(Colour::Grey(3)));
        assert_eq!(of(&["A", "Y"]), Some(Colour::Grey(1)));
        assert_eq!(of(&["Y", "Z"]), Some(Colour::Grey(0)));
        assert_eq!(of(&["L.Y"]), Some(Colour::Grey(0)));
        assert_eq!(of(&["G"]), Some(Colour::Grey(0)));
        assert_eq!(of(&["A", "height"]), Some(Colour::Grey(1)));
        for none in [
            &["Z"][..],
            &["depth"],
            &["L.Depth.Z"],
            &["X", "Y", "Z"],
            &["N.X", "N.Y", "N.Z"],
            &["BY", "RY", "Y"],
            &["G", "R"],
            &["A"],
            &[],
            &["v.B", "v.G", "v.R", "w.B", "w.G", "w.R"],
        ] {
            assert_eq!(of(none), None, "{none:?}");
        }
    }
}
