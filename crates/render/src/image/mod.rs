//! From linear XYZ to encoded RGB. Knows nothing of scenes or light; files are written by `iridesce-files`.
//!
//! The XYZ planes themselves are never changed: nothing is denoised, nothing clamped.

mod develop;

pub use develop::{Developed, Development, auto_exposure, develop};
