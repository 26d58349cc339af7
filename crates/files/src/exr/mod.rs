//! OpenEXR.

mod open;
mod picture;
mod table;

pub use open::{Channel, OpenExr, open_exr};
pub use picture::{Planes, write_exr};
pub use table::{Table, read_tables, tables_bytes, write_tables};
