//! Light that is not quite coherent: averages over the width of a spectral line, over the spread of a thickness, and over the
//! phases of slabs.

mod average;
mod damped;
mod rules;
mod slabs;

pub use average::{AverageRequest, Averaged, MOST_NODES, averaged};
pub use damped::damped;
pub use rules::{LineShape, legendre};
pub use slabs::{Direction, MOST_SLABS, mueller};
