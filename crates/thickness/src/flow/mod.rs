//! Films that flow: gravity, elasticity, viscosity, air, evaporation, black film and marginal regeneration on a sphere,
//! a dome or a vertical plane. Numerics only, no light; the equations and their tests are in `docs/living-films.md`.

mod carry;
mod chance;
mod checkpoint;
mod events;
mod field;
mod film;
mod grid;
mod parameters;
mod spectral;
mod tension;
mod transport;
mod viscosity;

#[cfg(test)]
mod laws;

pub use field::{MOST_SECONDS, field};
pub use film::{Books, Film, FlowError, State};
pub use grid::Shape;
pub use parameters::{PRESETS, Parameters};
