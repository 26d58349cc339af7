//! Files: read whole within limits, decoded, encoded, written whole or not at all. Knows no scenes and draws nothing.

mod color_table;
mod environment;
mod error;
mod exr;
mod facts;
mod grid;
mod icc;
mod limits;
mod png;
mod space;
mod whole;
mod words;

pub use color_table::{ReadTable, read_color_tables, write_color_tables};
pub use environment::{EnvironmentMap, MAX_RADIANCE, decode as decode_environment};
pub use error::{FileError, Stop};
pub use exr::{Planes, Table, read_tables, write_exr, write_tables};
pub use facts::{Fact, Facts};
pub use grid::{Grid, MAX_GRID_BYTES, decode as decode_thickness, read_thickness_map, thickness_exr};
pub use limits::check_size;
pub use png::{BitDepth, png_bytes, write_png};
pub use space::OutputSpace;
pub use whole::{check_ordinary, check_output, read_whole, reason, write_bytes, write_whole};
pub use words::quoted;
