//! Chance that hangs on a seed and a number alone, never on the step or on threads; smooth random fields made of it.

use std::f64::consts::{LN_2, TAU};

use iridesce_numerics::noise::{SplitMix64, mix64};

use crate::grid::Grid;

/// What a draw is for; each purpose has a sequence of its own.
#[derive(Debug, Clone, Copy)]
pub enum Purpose {
    Thickness = 1,
    Patch = 2,
    Spot = 3,
    Eddy = 4,
    Rupture = 5,
}

/// A sequence of draws for one event.
pub struct Draws {
    random: SplitMix64,
}

impl Draws {
    pub fn new(seed: u64, purpose: Purpose, event: u64) -> Draws {
        Draws { random: SplitMix64::new(mix64(mix64(seed ^ (purpose as u64) << 56) ^ event)).skip() }
    }

    /// Above 0 and at most 1.
    pub fn share(&mut self) -> f64 {
        self.random.above_zero()
    }

    /// Of the exponential distribution of mean 1.
    pub fn exponential(&mut self) -> f64 {
        -self.share().ln()
    }

    /// Of the normal distribution of variance 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (2.0 * self.exponential()).sqrt();
        radius * (TAU * self.share()).cos()
    }

    /// A direction in space, all alike.
    pub fn direction(&mut self) -> [f64; 3] {
        let z = 2.0 * self.share() - 1.0;
        let (sin, cos) = (TAU * self.share()).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        [radius * cos, radius * sin, z]
    }
}

/// One plane wave; a sum of many is smooth noise of mean 0 and variance 1, on a sphere without a pole or a grid.
#[derive(Debug, Clone, Copy)]
pub struct Wave {
    /// Per unit of place: radii on a sphere, m on a plane.
    vector: [f64; 3],
    phase: f64,
    height: f64,
}

/// Waves whose lengths (as 1/k) run from `longest` to `shortest`, evenly over octaves, in m.
pub fn waves(grid: &Grid, seed: u64, purpose: Purpose, count: u64, longest: f64, shortest: f64) -> Vec<Wave> {
    let octaves = (longest / shortest).ln() / LN_2;
    let scale = (2.0 / count as f64).sqrt();
    (0..count)
        .map(|event| {
            let mut draws = Draws::new(seed, purpose, event);
            let length = longest / (octaves * draws.share()).exp2();
            let phase = TAU * draws.share();
            let k = grid.radius / length;
            let direction = draws.direction();
            let mut vector = [direction[0] * k, direction[1] * k, direction[2] * k];
            if grid.is_plane() {
                // Whole waves across, so that the plane repeats.
                let unit = TAU / (grid.width[0] * grid.columns as f64);
                let angle = TAU * draws.share();
                vector = [(k * angle.cos() / unit).round() * unit, 0.0, k * angle.sin()];
            }
            Wave { vector, phase, height: scale }
        })
        .collect()
}

/// Sum of waves at a place.
pub fn sum(waves: &[Wave], place: [f64; 3]) -> f64 {
    waves.iter().map(|w| w.height * w.argument(place).cos()).sum()
}

/// Gradient of that sum, per unit of place.
pub fn slope(waves: &[Wave], place: [f64; 3]) -> [f64; 3] {
    let mut total = [0.0; 3];
    for w in waves {
        let s = -w.height * w.argument(place).sin();
        (0..3).for_each(|k| total[k] += s * w.vector[k]);
    }
    total
}

impl Wave {
    fn argument(&self, place: [f64; 3]) -> f64 {
        self.vector[0] * place[0] + self.vector[1] * place[1] + self.vector[2] * place[2] + self.phase
    }
}
