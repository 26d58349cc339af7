//! PNG.

mod write;

pub use write::{BitDepth, png_bytes, write_png};
