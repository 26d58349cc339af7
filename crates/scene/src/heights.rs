//! Bump maps: heights over u and v.

use std::sync::Arc;

use iridesce_thickness::ThicknessMap;

/// Heights in scene units over u and v; they repeat.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    /// Shares of the height.
    grid: Arc<ThicknessMap>,
    height: f64,
}

impl Heights {
    /// A grid of shares, 1 being this height.
    pub fn new(grid: Arc<ThicknessMap>, height: f64) -> Heights {
        Heights { grid, height }
    }

    /// The height at a place.
    pub fn at(&self, [u, v]: [f64; 2]) -> f64 {
        self.height * self.grid.sample_with(u, v, [true, true])
    }

    /// How fast it grows along u and along v: over one cell, from the middle of a half cell to each side.
    pub fn slopes(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (step_u, step_v) = (0.5 / self.grid.width() as f64, 0.5 / self.grid.height() as f64);
        [
            (self.at([u + step_u, v]) - self.at([u - step_u, v])) / (2.0 * step_u),
            (self.at([u, v + step_v]) - self.at([u, v - step_v])) / (2.0 * step_v),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_has_the_slope_it_has() {
        let cells = (0..64).map(|i| f64::from(i % 8) / 8.0).collect();
        let heights = Heights::new(Arc::new(ThicknessMap::new(8, 8, cells).unwrap()), 0.25);
        let [along_u, along_v] = heights.slopes([0.5, 0.3]);
        assert!((along_u - 0.25).abs() < 1e-12 && along_v == 0.0, "{along_u} {along_v}");
        assert_eq!(heights.at([0.5, 0.5]), heights.at([3.5, -1.5]), "it repeats");
    }
}
