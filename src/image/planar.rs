//! Any image as named planes of floats, and how colours are found among them.

use super::colours;
use super::curve::Curve;
use super::window::Windows;
use crate::error::InputError;

pub use super::colours::Colour;

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
    /// The curve between samples and light, which alpha never has, and what says so.
    pub curve: (Curve, &'static str),
    /// The file's `envmap` attribute.
    pub envmap: Option<EnvLayout>,
    /// The windows of an EXR file.
    pub windows: Option<Windows>,
    /// The name of the part that was read, where the file has several.
    pub part: Option<String>,
    /// The layer or channel that was asked for.
    pub layer: Option<String>,
    /// What the reader has to say about the file.
    pub remarks: Vec<String>,
}

impl Planar {
    /// Planes of light without any declaration.
    pub(super) fn plain(width: usize, height: usize, channels: Vec<(String, Vec<f32>)>) -> Self {
        Self {
            width,
            height,
            channels,
            curve: (Curve::Linear, ""),
            envmap: None,
            windows: None,
            part: None,
            layer: None,
            remarks: Vec::new(),
        }
    }

    /// The samples of a channel.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, samples)| samples.as_slice())
    }

    /// Whether samples are light by the file's own word.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.curve.0 == Curve::Linear
    }

    /// The channels' names for a message, the first twelve.
    #[must_use]
    pub fn channel_list(&self) -> String {
        list(&self.names())
    }

    fn names(&self) -> Vec<&str> {
        self.channels.iter().map(|(n, _)| n.as_str()).collect()
    }

    /// Finds the colour planes, see [`Colour`].
    ///
    /// # Errors
    ///
    /// Luminance with chroma (`RY BY`), two of the three colours, depth alone, or several candidates.
    pub fn colour(&self, subject: &str) -> Result<Colour, InputError> {
        colours::find(&self.names(), self.layer.as_deref()).map_err(|found| {
            InputError::new(
                subject,
                "channels R, G and B, or a single channel of light",
                found,
                "name a part, layer or channel as in FILE.exr:NAME, or convert the image to RGB",
            )
            .at("channels")
        })
    }

    /// What of the file was read, in words: `channels R G B of part "rgb"`.
    #[must_use]
    pub fn source(&self, colour: Colour) -> String {
        let name = |i: usize| shown(&self.channels[i].0);
        let channels = match colour {
            Colour::Rgb(rgb) => format!("channels {}", rgb.map(name).join(" ")),
            Colour::Grey(y) => format!("channel {} as grey", name(y)),
        };
        match &self.part {
            None => channels,
            Some(part) => format!("{channels} of part \"{}\"", shown(part)),
        }
    }
}

/// A name from a file for a message: printable, at most 40 characters.
pub(super) fn shown(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// Names for a message, the first twelve.
pub(super) fn list(names: &[&str]) -> String {
    let first: Vec<String> = names.iter().take(12).map(|n| shown(n)).collect();
    let mut text = first.join(", ");
    if names.len() > 12 {
        text += ", …";
    }
    if text.is_empty() {
        text = "no channel".to_owned();
    }
    text
}
