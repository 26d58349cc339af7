//! What light does to films, and what eyes do with the light: media, Fresnel, single films,
//! multilayers, colour. All `f64`, no file I/O (texts are parsed, files are the caller's).
//!
//! The modules depend on one another in one direction only:
//! `error -> spectrum -> medium -> incidence -> fresnel -> mueller -> film -> stack -> coherence -> color`.
//! Conventions (units, signs, polarisation names) are written once, in `docs/reference/conventions.md`.

pub mod coherence;
pub mod color;
pub mod error;
pub mod film;
pub mod fresnel;
pub mod incidence;
pub mod medium;
pub mod mueller;
pub mod spectrum;
pub mod stack;

pub use error::OpticsError;
pub use medium::{Beyond, Medium};
pub use num_complex::Complex64;
pub use stack::{Layer, Polarization, Stack};
