//! PNG.

mod write;

pub use write::{BitDepth, Packing, png_bytes, write_png};
