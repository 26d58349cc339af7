//! Films that flow: gravity, elasticity, viscosity, air, evaporation, black film and marginal regeneration on a sphere,
//! a dome or a vertical plane. Numerics only, no light; the equations and their tests are in `docs/guide/living-films.md`.

/// Compiles an expression once for each kind of processor and runs the one for this: plain loops over slices in
/// functions that are always inlined become vector instructions. No sum is reordered and nothing is fused, so all
/// kinds give the same bytes.
macro_rules! wide {
    ($what:expr) => {
        fearless_simd::dispatch!(iridesce_numerics::simd::level_or_best(), _simd => $what)
    };
}

mod carry;
mod chance;
mod checkpoint;
mod error;
mod events;
mod film;
mod films;
mod grid;
mod near;
mod parameters;
mod polar;
mod share;
mod spectral;
mod start;
mod tension;
mod transport;
mod viscosity;

// They stand with the tests, and are of the crate: they set states that no user may set.
#[cfg(test)]
#[path = "../tests/laws/mod.rs"]
mod laws;

pub use error::FlowError;
pub use film::{Books, Film, State, Summary};
pub use films::{FilmRun, Films, MOST_SECONDS};
pub use grid::{Shape, Sides};
pub use parameters::{CHANGEABLE, PRESETS, Parameters};
