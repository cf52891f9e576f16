//! What an input file was taken for, in the words that stderr, headers, JSON and pages share.

use std::fmt;

/// One input and everything that was decided about it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// The option that named it, such as `--env`.
    pub option: &'static str,
    /// The file.
    pub file: String,
    /// What it is, and what says so: `lat-long 1024x512 by its shape`.
    pub kind: String,
    /// What of the file was read: part, layer, channels.
    pub from: String,
    /// How samples become light or numbers: `linear`, `sRGB curve`.
    pub transfer: String,
    /// The data window, where it is not the display window.
    pub window: String,
    /// What else is worth a word: what was ignored, repaired or filled.
    pub remarks: Vec<String>,
    /// The flags that decide otherwise.
    pub flags: &'static [&'static str],
}

impl Taken {
    /// The parts of the line behind the option and the file, without the empty ones.
    fn words(&self) -> String {
        let parts = [&self.kind, &self.from, &self.transfer, &self.window];
        let parts = parts.into_iter().chain(&self.remarks);
        let parts: Vec<&str> = parts.map(String::as_str).filter(|p| !p.is_empty()).collect();
        parts.join("; ")
    }

    /// The flags, as a phrase.
    #[must_use]
    pub fn decides(&self) -> String {
        self.flags.join(", ")
    }
}

impl fmt::Display for Taken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}: {}", self.option, self.file, self.words())?;
        if !self.flags.is_empty() {
            write!(f, " (otherwise: {})", self.decides())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_leaves_out_what_is_empty_and_ends_with_the_flags() {
        let taken = Taken {
            option: "--env",
            file: "a.exr".into(),
            kind: "lat-long 8x4 by its shape".into(),
            from: "channels R G B".into(),
            remarks: vec!["gamma ignored".into()],
            flags: &["--env-layout", "--transfer"],
            ..Taken::default()
        };
        assert_eq!(
            taken.to_string(),
            "--env a.exr: lat-long 8x4 by its shape; channels R G B; gamma ignored \
             (otherwise: --env-layout, --transfer)"
        );
    }
}
