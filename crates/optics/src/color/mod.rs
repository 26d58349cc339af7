//! From spectra to colour: observers, illuminants, XYZ, colour spaces, colour differences, gamut mapping.
//!
//! Tristimulus values are relative: the perfect white reflector has Y = 1. Sums are plain sums over a uniform grid of
//! vacuum wavelengths, 360..830 nm at 1 nm unless another is given; true lines are added as lines.

mod basis;
mod illuminant;
mod observer;
mod table;

pub use basis::rgb_basis;
pub use illuminant::{Illuminant, illuminant_names};
pub use observer::{FIRST_NM, LAST_NM, Observer};
