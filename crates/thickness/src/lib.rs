//! How thick a film is, where. Lengths and grids only, no light.

mod model;

pub use model::{ThicknessError, ThicknessModel};
