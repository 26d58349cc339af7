//! iridesce: interference colour, from film to picture. This facade re-exports the stages in order.
//!
//! ```text
//! optics -> thickness -> scene -> render
//! ```
pub use iridesce_optics as optics;
pub use iridesce_render as render;
pub use iridesce_scene as scene;
pub use iridesce_thickness as thickness;
