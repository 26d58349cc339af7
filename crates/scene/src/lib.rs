//! Scenes: read, validate, resolve. Knows films and thickness, nothing of rendering.
//!
//! ```text
//! TOML, JSON, dict -> tree (with lines) -> validate -> Scene (every default filled in, every name resolved)
//! ```

mod builtin;
mod context;
mod defaults;
mod disk;
mod edit;
mod error;
mod field;
mod files;
mod films;
mod lights;
mod load;
mod medium;
mod model;
mod objects;
mod reader;
mod shape;
mod sky;
mod studio;
mod surfaces;
mod thickness;
mod tree;
mod validate;

pub use builtin::{builtin_names, builtin_text};
pub use error::SceneError;
pub use films::field as flow_field;
pub use model::*;
pub use tree::{Node, Value};
