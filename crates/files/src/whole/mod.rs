//! Whole files: read at once within a limit, written beside the name and renamed.

mod read;
mod write;

pub use read::{check_ordinary, read_whole, reason};
pub use write::{check_output, write_bytes, write_whole};
