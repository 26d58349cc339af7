//! How thick a film is, where. Lengths and grids only, no light.

mod black_edge;
mod error;
mod flow_field;
mod gradient;
mod lens_gap;
mod map;
mod model;
mod sampled;
mod swirls;
mod wedge;

pub use error::ThicknessError;
pub use flow_field::FlowField;
pub use gradient::Gradient;
pub use lens_gap::LensGap;
pub use map::ThicknessMap;
pub use model::ThicknessModel;
pub use swirls::swirls;
pub use wedge::Wedge;
