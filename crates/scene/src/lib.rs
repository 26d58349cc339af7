//! Scenes: read, validate, resolve. Knows films and thickness, nothing of rendering.

mod model;

pub use model::*;
