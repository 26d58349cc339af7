//! From a measured spectrum, a photograph or a colour back to films: one engine of likelihoods.
//!
//! Whatever was measured is a vector of channels, a film is a row of a table of what these channels would be, and the
//! unknowns that enter linearly (gain, lamp, stray light) are integrated out in closed form instead of fitted. The answers
//! are probabilities of explanations, no film among them.
//!
//! The modules depend on one another in one direction only: `error -> cholesky -> response -> evidence`.

mod cholesky;
mod error;
mod evidence;
mod response;

pub use error::InverseError;
pub use evidence::{Explained, Measured, Nuisance, explain, log_evidences};
pub use response::SmoothCurves;
