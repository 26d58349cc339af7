//! Caustics: light of small lamps that mirrors, lenses and films throw onto surfaces that scatter it.
//!
//! A branch from the surface meets a small lamp behind glass about once in a million times, one without size never. So before
//! the picture is drawn, rays are followed from the lamps over all that mirrors or refracts, and where three neighbours land
//! together stands a triangle of light ([`crate::lights::seeds`]). A place within it looks for the lamp from there by
//! Newton's method along the same chain of surfaces (J. Hanika, M. Droske, L. Fascione, "Manifold next event estimation",
//! Computer Graphics Forum 34(4), 87 (2015); T. Zeltner, I. Georgiev, W. Jakob, "Specular manifold sampling", ACM Trans.
//! Graph. 39(4), 149 (2020)), and what it finds, the direction and how the ray moves across the lamp when that turns, is a lobe
//! of directions that lead to the lamp ([`Lobe`]).
//!
//! The lobes of a place are the same whenever it is asked, so their density is known in closed form: unlike with specular manifold
//! sampling no reciprocal of a probability is estimated, and what no lobe covers is still found by the surface's own branch.

mod emission;
mod lobe;
mod search;

use iridesce_numerics::Vec3;

pub use self::emission::seeds;
pub use self::lobe::Lobe;
pub use self::search::{Departure, Search};
use crate::lights::seeds::Candidate;

/// A place that a branch has left, where caustics were sampled, and how.
#[derive(Debug, Clone, Copy)]
pub struct Told {
    pub from: Departure,
    pub direction: Vec3,
    /// Probability per solid angle of the direction.
    pub density: f64,
    /// The place in the spectrum at which caustics were looked for.
    pub chosen: f64,
}

/// Working memory of one thread.
#[derive(Default)]
pub struct Memory {
    pub candidates: Vec<Candidate>,
    pub lobes: Vec<Lobe>,
    /// By slot.
    pub told: Vec<Option<Told>>,
    /// The place in the spectrum at which caustics were looked for last.
    pub chosen: f64,
}

impl Memory {
    pub fn new(slots: usize) -> Memory {
        Memory { told: vec![None; slots], ..Memory::default() }
    }
}
