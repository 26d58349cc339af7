//! The one error type of this crate.

use std::path::{Path, PathBuf};

use iridesce_numerics::Argument;

/// Asked now and then during long work: `true` stops it with [`FileError::Cancelled`] and leaves no file behind.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Why there is no picture file; `Display` is the whole message a user sees.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A number, a name or a shape outside what is allowed.
    #[error("{0}")]
    Argument(String),
    /// An argument outside what is allowed, in parts.
    #[error(transparent)]
    Parts(#[from] Argument),
    /// The file could not be written; what was there before is still there.
    #[error("cannot write {}: {source}", .path.display())]
    Write {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system said, or what is wrong with the place.
        source: std::io::Error,
    },
    /// The caller asked to stop.
    #[error("saving was cancelled")]
    Cancelled,
}

impl FileError {
    pub(crate) fn write(path: &Path, source: std::io::Error) -> FileError {
        FileError::Write { path: path.to_owned(), source }
    }
}
