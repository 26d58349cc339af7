//! OpenEXR.

mod open;
mod picture;
mod table;

pub use open::{Channel, OpenExr, open_exr};
pub use picture::{Picture, Plane, Values, write_exr};
pub use table::{Table, read_tables, tables_bytes, write_tables};
