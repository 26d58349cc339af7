//! From spectra to colour: observers, illuminants, XYZ, colour spaces, colour differences, gamut mapping.
//!
//! Tristimulus values are relative: the perfect white reflector has Y = 1. Sums are plain sums over a uniform grid of
//! vacuum wavelengths, 360..830 nm at 1 nm unless another is given; true lines are added as lines.

mod basis;
mod color_table;
mod dias;
mod difference;
pub mod gamut;
mod illuminant;
mod jacobian;
mod matrix;
mod observer;
mod request;
mod space;
mod stack_color;
mod sums;
mod table;
mod two_beam;

pub use basis::rgb_basis;
pub use color_table::{ColorTable, ColorTableRequest, ColorTableShape, MOST_NODES};
pub use dias::{Dias1991, DiasMatrix, DiasTable, PRINTED_MATRIX, dias1991_wavelengths};
pub use difference::ciede2000;
pub use illuminant::{Illuminant, illuminant_names};
pub use matrix::Matrix;
pub use observer::{FIRST_NM, LAST_NM, Observer};
pub use request::{ColorRequest, Model, Quantity};
pub use space::{ACES_XY, Adaptation, C_XY, D50_XY, D65_XY, REC709_LUMINANCE, SPACES, Space, bradford, xyz_of_xy};
pub use stack_color::{Colors, FRINGE_STEPS, Forced, StackColor, fringe_parts};
pub use sums::{Grid, Weights};
