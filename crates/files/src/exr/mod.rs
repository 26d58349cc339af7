//! OpenEXR.

mod open;
mod picture;
mod table;

pub use open::open_exr;
pub use picture::{Planes, write_exr};
pub use table::{Table, read_tables, write_tables};
