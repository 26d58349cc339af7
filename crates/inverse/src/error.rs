//! What can be wrong with a question.

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InverseError {
    /// An argument, its value and what is allowed.
    #[error("{0}")]
    Argument(String),
    /// So many bytes cannot be had.
    #[error("it needs {} MiB of memory more, which this process cannot have", .0.div_ceil(1 << 20))]
    Memory(usize),
    /// The caller asked to stop.
    #[error(transparent)]
    Stopped(#[from] iridesce_numerics::Stopped),
}
