//! The colour of a stack: the full spectral sum at every point of an array of thicknesses and angles.

mod at_angle;
mod fringes;
mod levels;
#[cfg(test)]
mod tests;

use iridesce_numerics::{ANGLE_DEG, THICKNESS_NM, Watch};
use rayon::prelude::*;

use super::request::ColorRequest;
use crate::OpticsError;
use at_angle::{AtAngle, Found};
use levels::Levels;

pub use at_angle::Forced;
pub use fringes::{FRINGE_STEPS, fringe_parts};

/// Points a task: enough to share what an angle needs, few enough for their sums to stay in the second cache.
const CHUNK: usize = 512;

/// A request made ready: weights, and the indices of all media at every wavelength.
#[derive(Debug)]
pub struct StackColor {
    sums: Levels,
}

/// Colours, and what the user should hear about them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Colors {
    /// One colour a point.
    pub values: Vec<[f64; 3]>,
    /// Points outside the gamut (where a gamut mapping was asked for).
    pub out_of_gamut: u64,
    /// The point whose fringes need the finest steps, on a grid the user forced.
    pub forced: Forced,
}

impl StackColor {
    /// Checks the request and reads all indices at the wavelengths of the sum.
    pub fn new(request: ColorRequest) -> Result<StackColor, OpticsError> {
        Ok(StackColor { sums: Levels::new(request)? })
    }

    /// Names of the media whose stated extension beyond their data was used.
    pub fn extended(&self) -> Vec<String> {
        self.sums.extended()
    }

    /// Colours of many points: `thickness_nm` holds one row of layers a point, `angle_deg` one angle a point.
    /// All cores work at it; the answer does not depend on how many there are.
    pub fn colors(&self, thickness_nm: &[f64], angle_deg: &[f64]) -> Result<Colors, OpticsError> {
        self.colors_watched(thickness_nm, angle_deg, &Watch::new())
    }

    /// The same, until the watch is stopped ([`OpticsError::Stopped`]).
    pub fn colors_watched(
        &self,
        thickness_nm: &[f64],
        angle_deg: &[f64],
        watch: &Watch,
    ) -> Result<Colors, OpticsError> {
        let (points, layers) = (angle_deg.len(), self.sums.request.coherent.len());
        if thickness_nm.len() != points * layers {
            let message = format!("{points} points of {layers} layers need {} thicknesses", points * layers);
            return Err(OpticsError::Argument(format!("{message}, got {}", thickness_nm.len())));
        }
        if let Some(i) = ANGLE_DEG.first_outside(angle_deg) {
            return Err(ANGLE_DEG.refuse(angle_deg[i]).at(format!("at point {i}")).into());
        }
        if let Some(i) = THICKNESS_NM.first_outside(thickness_nm) {
            return Err(THICKNESS_NM.refuse(thickness_nm[i]).at(format!("at point {}", i / layers)).into());
        }
        // Points of one angle share all that does not depend on thickness: visit them together.
        let mut order: Vec<usize> = (0..points).collect();
        if angle_deg.windows(2).any(|pair| pair[0] != pair[1]) {
            order.par_sort_unstable_by(|&a, &b| angle_deg[a].total_cmp(&angle_deg[b]).then(a.cmp(&b)));
        }
        let visited = order
            .par_chunks((32 * CHUNK / (layers + 31)).max(1))
            .map(|chunk| {
                let runs = chunk.chunk_by(|&a, &b| angle_deg[a].to_bits() == angle_deg[b].to_bits());
                let mut found = Vec::with_capacity(chunk.len());
                for run in runs {
                    AtAngle::new(&self.sums, angle_deg[run[0]], watch)?.colors(run, thickness_nm, &mut found)?;
                }
                Ok(found)
            })
            .collect::<Result<Vec<Vec<Found>>, OpticsError>>()?;
        let mut colors = Colors { values: vec![[0.0; 3]; points], ..Colors::default() };
        for found in visited.into_iter().flatten() {
            colors.values[found.point] = found.value;
            colors.out_of_gamut += u64::from(found.outside);
            if found.forced.steps > colors.forced.steps {
                colors.forced = found.forced;
            }
        }
        Ok(colors)
    }

    /// XYZ of the light on the grid of the sum, Y = 1.
    pub fn white(&self) -> Result<[f64; 3], OpticsError> {
        Ok(self.sums.level(0)?.weights.white)
    }
}
