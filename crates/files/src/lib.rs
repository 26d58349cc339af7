//! Files: read whole within limits, decoded, encoded, written whole or not at all. Knows no scenes and draws nothing.

mod aside;
mod axis;
mod color_table;
mod environment;
mod error;
mod exr;
mod facts;
mod grid;
mod hdr;
mod icc;
mod icc_in;
mod index;
mod input;
mod jcamp;
mod journal;
mod lamp;
mod limits;
mod mesh;
mod orient;
mod photograph;
mod png;
mod report;
mod role;
mod rows;
mod space;
mod spectrum;
mod text;
mod whole;
mod words;

pub use aside::{NoAnswer, aside};
pub use color_table::{ReadTable, color_tables_bytes, read_color_tables, write_color_tables};
pub use environment::{
    EnvironmentMap, MAX_ENVIRONMENT_BYTES, MAX_RADIANCE, decode as read_environment, decode_environment,
};
pub use error::{FileError, Stop};
pub use exr::open_exr;
pub use exr::{Channel, OpenExr, Picture, Plane, Table, Values, read_tables, write_exr, write_tables};
pub use facts::{Fact, Facts};
pub use grid::{
    Grid, MAX_GRID_BYTES, MapChoice, MapOf, decode_of as read_grid, decode_thickness, decode_transforms,
    read_thickness_map, thickness_exr,
};
pub use index::read_medium;
pub use journal::{Journal, Record};
pub use lamp::{MAX_LAMP_BYTES, read_lamp};
pub use limits::check_size;
pub use mesh::{MAX_MESH_BYTES, MAX_TRIANGLES, Mesh, MeshFormat, OpenEdge, decode_mesh};
pub use photograph::{MAX_PHOTOGRAPH_BYTES, Photograph, photograph_size, read_photograph};
pub use png::{BitDepth, Packing, png_bytes, write_png};
pub use report::{ReadReport, Taken};
pub use space::OutputSpace;
pub use spectrum::{MAX_SPECTRUM_BYTES, Spectrum, SpectrumChoice, read_spectrum};
pub use text::decode_text;
pub use whole::{
    check_ordinary, check_output, check_picture, read_whole, read_whole_watched, reason, write_bytes, write_whole,
};
pub use words::{harmless, quoted};
