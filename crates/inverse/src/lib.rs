//! From a measured spectrum, a photograph or a colour back to films: one engine of likelihoods.
//!
//! Whatever was measured is a vector of channels, a film is a row of a table of what these channels would be, and the
//! unknowns that enter linearly (gain, lamp, stray light) are integrated out in closed form instead of fitted. The answers
//! are probabilities of explanations, no film among them.
//!
//! The modules depend on one another in one direction only: `error -> cholesky -> tridiagonal -> response -> evidence` for spectra,
//! `error -> pixels -> blocks -> lines -> exposure -> neighbours -> regions -> photograph` for pictures.

mod blocks;
mod cholesky;
mod error;
mod evidence;
mod exposure;
mod lines;
mod neighbours;
mod photograph;
mod pixels;
mod regions;
mod response;
mod tridiagonal;

pub use error::InverseError;
pub use evidence::{Explained, Measured, Nuisance, explain, log_evidences};
pub use exposure::{FilmChannels, Fitted, Sample, agreement, exposures};
pub use lines::Slope;
pub use neighbours::{Neighbourhood, neighbourhood, noise};
pub use photograph::{Map, Prior, Question, TOLD, map_thickness};
pub use pixels::{Exposure, Photograph, PixelTable};
pub use regions::Tie;
pub use response::{Fine, SmoothCurves};
