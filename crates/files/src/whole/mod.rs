//! Whole files: read at once within a limit, written beside the name and renamed.

mod frame;
mod read;
mod write;

pub use frame::check_picture;
pub use read::{check_ordinary, read_whole, read_whole_watched, reason};
pub use write::{check_output, write_bytes, write_whole};
