//! What every stage computes with, and no physics: numbers and vectors of them, and how long work is watched.
//!
//! ```text
//! simd (which instructions) | number (scalar, f64 lanes, f32 lanes) -> turns, complex, interpolation; lanes (storage)
//! sums, vector, latlong (maps of directions), noise, watch, argument (what is wrong with one)
//! ```

pub mod argument;
pub mod complex;
pub mod interpolation;
pub mod lanes;
pub mod latlong;
pub mod noise;
pub mod number;
pub mod simd;
pub mod sums;
pub mod turns;
pub mod vector;
pub mod watch;

pub use argument::{ANGLE_DEG, Argument, Bounds, THICKNESS_NM, WAVELENGTH_NM, index_place, place_of, shown};
pub use lanes::{Doubles, Lanes, Singles};
pub use number::{F32s, F64s, Number, Precision, Wide};
pub use vector::Vec3;
pub use watch::{Progress, Stopped, Watch};
