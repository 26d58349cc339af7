//! How thick a film is, where. Lengths and grids only, no light.

pub mod flow;
mod gradient;
mod lens_gap;
mod map;
mod model;
mod swirls;
mod wedge;

pub use gradient::Gradient;
pub use lens_gap::LensGap;
pub use map::ThicknessMap;
pub use model::{ThicknessError, ThicknessModel};
pub use swirls::swirls;
pub use wedge::Wedge;
