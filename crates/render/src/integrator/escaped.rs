//! Paths that have left the scene, side by side.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;

/// Weights of a path in multiple importance sampling: what of the light out there is its own, where light sampling finds
/// the rest.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Of the maps.
    pub maps: f32,
    /// The sun that it adds, if any, and what of it.
    pub sun: Option<(usize, f32)>,
}

/// Paths that have escaped from the scene.
pub struct Escaped {
    pub(super) directions: [Lanes; 3],
    pub(super) shares: [Share; LANES],
    /// Sum of s and p weights: spectrum of path i from `i * blocks`. Empty for paths that met nothing.
    pub carried: Vec<Lanes>,
    pub count: usize,
    /// The batch of samples that paths from now on belong to, and that of each path.
    pub batch: usize,
    pub(super) batches: [usize; LANES],
}

impl Escaped {
    pub fn new(blocks: usize) -> Escaped {
        // Unused lanes look somewhere harmless.
        Escaped {
            directions: [Lanes::ZERO, Lanes::ONE, Lanes::ZERO],
            shares: [Share { maps: 1.0, sun: None }; LANES],
            carried: vec![Lanes::ZERO; blocks * LANES],
            count: 0,
            batch: 0,
            batches: [0; LANES],
        }
    }

    #[inline(always)]
    pub fn push(&mut self, direction: Vec3, share: Share) -> usize {
        let at = self.count;
        let [x, y, z] = &mut self.directions;
        (x.0[at], y.0[at], z.0[at]) = (direction.x as f32, direction.y as f32, direction.z as f32);
        (self.shares[at], self.batches[at]) = (share, self.batch);
        self.count += 1;
        at
    }
}
