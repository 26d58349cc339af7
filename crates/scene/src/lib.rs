//! Scenes: read and validate, in milliseconds; resolve, which reads maps and lets films flow. Knows films and thickness, nothing of rendering.
//!
//! ```text
//! TOML, JSON, dict -> tree (with lines) -> check (against the schema) -> validate -> Scene (a recipe: every default filled in, every name known)
//! Scene, Context (maps read, films where they stand), Watch -> resolve -> ResolvedScene
//! ```

mod affine;
mod bodies;
mod builtin;
mod cache;
mod check;
mod context;
mod edit;
mod error;
mod faces;
mod field;
mod files;
mod films;
mod heights;
mod inside;
mod lights;
mod load;
mod medium;
mod model;
mod notes;
mod objects;
mod origin;
mod placement;
mod reader;
mod resolve;
mod schema;
mod schema_text;
mod shape;
mod shut_in;
mod sky;
mod studio;
mod surface_files;
mod surfaces;
mod texture;
mod thickness;
mod tree;
mod validate;

pub use affine::Affine;
pub use builtin::{builtin_names, builtin_text};
pub use error::{ResolveError, SceneError};
pub use faces::FilmOnFace;
pub use medium::OPAQUE_K;
pub use model::*;
pub use resolve::{Body, Context, ResolvedEnvironment, ResolvedScene, ResolvedSource, resolve};
pub use schema_text::{json_schema, key_tables};
pub use texture::{ResolvedReflectance, Texture, held};
pub use tree::{Node, Value};
