//! Any image as named planes of floats, and how colours are found among them.

use crate::error::InputError;

/// The meaning of an `envmap` attribute for a file's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvLayout {
    /// Latitude-longitude, samples on the poles and on both ends of a row.
    LatLong,
    /// Six faces stacked vertically, samples on the faces' edges.
    Cube,
}

/// An image as named planes: row by row from the top left, one f32 per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Planar {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Name and samples of each channel, in the file's order (EXR: alphabetical).
    ///
    /// PNG and JPEG have `R G B` or `Y` (and `A` where stored), as raw code values 0..1.
    pub channels: Vec<(String, Vec<f32>)>,
    /// False where the samples are code values on the sRGB curve (PNG, JPEG); alpha never is.
    pub linear: bool,
    /// The file's `envmap` attribute.
    pub envmap: Option<EnvLayout>,
}

/// Which planes make up a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Indices of red, green and blue.
    Rgb([usize; 3]),
    /// One plane for all three.
    Grey(usize),
}

impl Planar {
    /// The samples of a channel.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, samples)| samples.as_slice())
    }

    /// The channels' names for a message, the first twelve.
    #[must_use]
    pub fn channel_list(&self) -> String {
        let names: Vec<&str> = self.channels.iter().map(|(n, _)| n.as_str()).collect();
        list(&names)
    }

    /// Finds the colour planes.
    ///
    /// `R G B` of the unnamed layer; else a lone `Y`, or a lone channel of any name apart from alpha,
    /// as grey; else the only named layer that has all of `R G B` (`diffuse.R` …).
    ///
    /// # Errors
    ///
    /// Luminance with chroma (`RY BY`), two of the three colours, or several candidates.
    pub fn colour(&self, subject: &str) -> Result<Colour, InputError> {
        let position = |name: &str| self.channels.iter().position(|(n, _)| n == name);
        if let (Some(r), Some(g), Some(b)) = (position("R"), position("G"), position("B")) {
            return Ok(Colour::Rgb([r, g, b]));
        }
        let names: Vec<&str> = self.channels.iter().map(|(n, _)| n.as_str()).collect();
        let error = |found: String| {
            Err(InputError::new(
                subject,
                "channels R, G and B, or a single channel",
                found,
                "convert the image to RGB",
            )
            .at("channels"))
        };
        if position("RY").is_some() || position("BY").is_some() {
            return error("luminance with chroma (Y, RY, BY)".to_owned());
        }
        let plain: Vec<usize> =
            (0..names.len()).filter(|&i| names[i] != "A" && !names[i].contains('.')).collect();
        if let Some(y) = position("Y") {
            return Ok(Colour::Grey(y));
        }
        if let [only] = plain[..] {
            return Ok(Colour::Grey(only));
        }
        let layers: Vec<[usize; 3]> = names
            .iter()
            .filter_map(|name| name.strip_suffix(".R"))
            .filter_map(|layer| {
                let of = |c: &str| position(&format!("{layer}.{c}"));
                Some([of("R")?, of("G")?, of("B")?])
            })
            .collect();
        if let (true, [only]) = (plain.is_empty(), &layers[..]) {
            return Ok(Colour::Rgb(*only));
        }
        error(list(&names))
    }
}

/// Channel names for a message, the first twelve.
fn list(names: &[&str]) -> String {
    let mut text: String = names
        .iter()
        .take(12)
        .map(|n| n.chars().filter(|c| !c.is_control()).take(40).collect())
        .collect::<Vec<String>>()
        .join(", ");
    if names.len() > 12 {
        text += ", …";
    }
    if text.is_empty() {
        text = "no channel".to_owned();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planar(names: &[&str]) -> Planar {
        Planar {
            width: 1,
            height: 1,
            channels: names.iter().map(|n| ((*n).to_owned(), vec![0.0])).collect(),
            linear: true,
            envmap: None,
        }
    }

    #[test]
    fn colours_are_found_by_name() {
        let of = |names: &[&str]| planar(names).colour("f").ok();
        assert_eq!(of(&["A", "B", "G", "R"]), Some(Colour::Rgb([3, 2, 1])));
        assert_eq!(
            of(&["B", "G", "R", "diffuse.B", "diffuse.G", "diffuse.R"]),
            Some(Colour::Rgb([2, 1, 0]))
        );
        assert_eq!(of(&["A", "Y"]), Some(Colour::Grey(1)));
        assert_eq!(of(&["G"]), Some(Colour::Grey(0)));
        assert_eq!(of(&["v.B", "v.G", "v.R"]), Some(Colour::Rgb([2, 1, 0])));
        assert_eq!(of(&["BY", "RY", "Y"]), None);
        assert_eq!(of(&["G", "R"]), None);
        assert_eq!(of(&[]), None);
        let two = ["v.B", "v.G", "v.R", "w.B", "w.G", "w.R"];
        assert_eq!(of(&two), None);
    }
}
