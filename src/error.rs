//! The one shape of an error in a user's input.

use std::fmt;

/// An error in an input: its place, its cause and the remedy. The command exits with status 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    /// The file, flag or stream that is wrong.
    pub subject: String,
    /// Line, column, key, channel or byte inside it, where that is known.
    pub place: Option<String>,
    /// What a correct input has there.
    pub expected: String,
    /// What was found.
    pub found: String,
    /// What the user can do.
    pub remedy: String,
}

impl InputError {
    /// An error in `subject` as a whole.
    pub fn new(
        subject: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            subject: subject.into(),
            place: None,
            expected: expected.into(),
            found: found.into(),
            remedy: remedy.into(),
        }
    }

    /// The same error at a place inside the subject.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> Self {
        self.place = Some(place.into());
        self
    }
}

impl std::error::Error for InputError {}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.subject)?;
        if let Some(place) = &self.place {
            write!(f, ", {place}")?;
        }
        write!(f, ": expected {}, found {}", self.expected, self.found)?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        Ok(())
    }
}
