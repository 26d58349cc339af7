//! iridesce: interference colour, from film to picture. This facade re-exports the stages in order.
//!
//! ```text
//! numerics -> optics; thickness -> flow; optics, thickness -> files; all of them -> scene -> render; numerics -> inverse
//! ```
pub use iridesce_files as files;
pub use iridesce_flow as flow;
pub use iridesce_inverse as inverse;
pub use iridesce_numerics as numerics;
pub use iridesce_optics as optics;
pub use iridesce_render as render;
pub use iridesce_scene as scene;
pub use iridesce_thickness as thickness;
