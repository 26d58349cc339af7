//! The one error type of this crate. Every message says what was wrong, what was given and what is allowed.

use iridesce_numerics::Argument;

/// What can go wrong in optics; `Display` is the whole message a user sees.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// What does not go together, as a sentence.
    #[error("{0}")]
    Argument(String),
    /// A number or name outside what the function allows, in parts.
    #[error(transparent)]
    Parts(Box<Argument>),
    /// No medium or illuminant of that name.
    #[error("{0}")]
    Unknown(String),
    /// A wavelength outside the data of a medium.
    #[error("{0}")]
    OutsideData(String),
    /// Something that cannot fit into memory.
    #[error("{0}")]
    Resource(String),
    /// Long work was asked to stop, and did.
    #[error("stopped")]
    Stopped,
    /// A text (CSV, YAML) that does not hold what it should.
    #[error("{0}")]
    Data(String),
}

impl OpticsError {
    /// The same with the place where it arose: `at index (3, 7)`.
    #[must_use]
    pub fn at(self, place: &str) -> OpticsError {
        match self {
            OpticsError::Parts(argument) => OpticsError::Parts(Box::new(argument.at(place))),
            error if place.is_empty() => error,
            error => OpticsError::Argument(format!("{error} {place}")),
        }
    }
}

impl From<Argument> for OpticsError {
    fn from(argument: Argument) -> OpticsError {
        OpticsError::Parts(Box::new(argument))
    }
}

impl From<iridesce_numerics::simd::SimdError> for OpticsError {
    fn from(error: iridesce_numerics::simd::SimdError) -> OpticsError {
        OpticsError::Argument(error.to_string())
    }
}
