//! What can be wrong with a question.

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InverseError {
    /// An argument, its value and what is allowed.
    #[error("{0}")]
    Argument(String),
    /// The caller asked to stop.
    #[error(transparent)]
    Stopped(#[from] iridesce_numerics::Stopped),
}
