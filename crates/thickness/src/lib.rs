//! How thick a film is, where. Lengths and grids only, no light.

mod map;
mod model;

pub use map::ThicknessMap;
pub use model::{ThicknessError, ThicknessModel};
