//! Colour sums: the wavelengths they run over and the weights of X, Y, Z there.

use iridesce_numerics::{Argument, WAVELENGTH_NM, index_place};

use super::illuminant::Illuminant;
use super::observer::{FIRST_NM, LAST_NM, Observer};
use crate::OpticsError;

/// Uniform vacuum wavelengths `first_nm + i step_nm`, `i < count`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// First wavelength, nm, > 0.
    pub first_nm: f64,
    /// Step, nm, > 0.
    pub step_nm: f64,
    /// Number of wavelengths, >= 2.
    pub count: usize,
}

impl Default for Grid {
    /// 360..830 nm at 1 nm.
    fn default() -> Grid {
        Grid { first_nm: FIRST_NM, step_nm: 1.0, count: (LAST_NM - FIRST_NM) as usize + 1 }
    }
}

impl Grid {
    /// The uniform grid through the given wavelengths; they may miss it by 1e-6 of a step (rounding of the caller's).
    pub fn through(wavelength_nm: &[f64]) -> Result<Grid, OpticsError> {
        let bad = |message: String| Err(OpticsError::Argument(message));
        let count = wavelength_nm.len();
        if count < 2 {
            return Err(Argument::new("wavelength_nm", "two wavelengths at least", count).into());
        }
        if let Some(i) = WAVELENGTH_NM.first_outside(wavelength_nm) {
            return Err(WAVELENGTH_NM.refuse(wavelength_nm[i]).at(index_place(i, &[count])).into());
        }
        if let Some(i) = wavelength_nm.windows(2).position(|w| w[0] >= w[1]) {
            return bad(format!(
                "wavelength_nm must ascend, got {} after {} at index ({},)",
                wavelength_nm[i + 1],
                wavelength_nm[i],
                i + 1
            ));
        }
        let first_nm = wavelength_nm[0];
        let step_nm = (wavelength_nm[count - 1] - first_nm) / (count - 1) as f64;
        let grid = Grid { first_nm, step_nm, count };
        // The last term is the rounding of the wavelengths themselves, which a very small step could fall below.
        let slack = 1e-6 * step_nm + 4.0 * f64::EPSILON * wavelength_nm[count - 1];
        if let Some(i) = (0..count).find(|&i| (wavelength_nm[i] - grid.at(i)).abs() > slack) {
            return bad(format!(
                "wavelength_nm must be a uniform grid: with a step of {step_nm} nm index ({i},) would be {}, got {}",
                grid.at(i),
                wavelength_nm[i]
            ));
        }
        Ok(grid)
    }

    /// The wavelength of one index, nm.
    pub fn at(&self, index: usize) -> f64 {
        self.first_nm + self.step_nm * index as f64
    }

    /// The grid with every step divided into `parts`, the ends unchanged.
    pub fn divided(&self, parts: usize) -> Grid {
        let step_nm = self.step_nm / parts as f64;
        Grid { first_nm: self.first_nm, step_nm, count: (self.count - 1) * parts + 1 }
    }
}

/// What a spectrum of reflectances is multiplied by and summed to give XYZ; only wavelengths that count are listed.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Vacuum wavelengths, nm: those of the grid, then those of the lines.
    pub wavelength_nm: Vec<f64>,
    /// Weights of X, Y, Z at each of them.
    pub xyz: Vec<[f64; 3]>,
    /// Index of each wavelength in the grid; `None` for a line.
    pub grid_index: Vec<Option<usize>>,
    /// XYZ of the perfect reflector (Y = 1): the white of this light on this grid.
    pub white: [f64; 3],
}

impl Weights {
    /// k step power cmf on the grid and k power cmf at the lines, with k such that the perfect reflector has Y = 1.
    pub fn new(grid: &Grid, illuminant: &Illuminant, observer: Observer) -> Result<Weights, OpticsError> {
        let mut weights =
            Weights { wavelength_nm: Vec::new(), xyz: Vec::new(), grid_index: Vec::new(), white: [0.0; 3] };
        let mut add = |nm: f64, power: f64, index: Option<usize>| {
            let xyz = observer.at(nm).map(|v| v * power);
            if xyz != [0.0; 3] {
                weights.wavelength_nm.push(nm);
                weights.xyz.push(xyz);
                weights.grid_index.push(index);
                for (sum, v) in weights.white.iter_mut().zip(xyz) {
                    *sum += v;
                }
            }
        };
        if illuminant.has_continuum() {
            for index in 0..grid.count {
                let nm = grid.at(index);
                add(nm, illuminant.power(nm) * grid.step_nm, Some(index));
            }
        }
        for &(nm, power) in illuminant.lines() {
            add(nm, power, None);
        }
        let total = weights.white[1];
        if !(total > 0.0 && total.is_finite()) {
            return Err(OpticsError::Argument(format!(
                "illuminant {:?} gives the observer no light at {}..{} nm",
                illuminant.name(),
                grid.first_nm,
                grid.at(grid.count - 1)
            )));
        }
        for xyz in &mut weights.xyz {
            *xyz = xyz.map(|v| v / total);
        }
        weights.white = [weights.white[0] / total, 1.0, weights.white[2] / total];
        Ok(weights)
    }

    /// XYZ of one spectrum given on the grid these weights were made for, linear between its entries at the lines.
    /// A line outside the grid is an error; `values` has one entry a grid wavelength.
    pub fn sum(&self, grid: &Grid, values: &[f64]) -> Result<[f64; 3], OpticsError> {
        let mut xyz = [0.0; 3];
        for ((nm, weight), index) in self.wavelength_nm.iter().zip(&self.xyz).zip(&self.grid_index) {
            let value = match index {
                Some(i) => values[*i],
                None => interpolate(grid, values, *nm)?,
            };
            for (sum, w) in xyz.iter_mut().zip(weight) {
                *sum += value * w;
            }
        }
        Ok(xyz)
    }
}

fn interpolate(grid: &Grid, values: &[f64], nm: f64) -> Result<f64, OpticsError> {
    let (first, last) = (grid.first_nm, grid.at(grid.count - 1));
    if !(first..=last).contains(&nm) {
        return Err(OpticsError::Argument(format!(
            "the illuminant has a line at {nm} nm, outside wavelength_nm ({first}..{last} nm)"
        )));
    }
    let place = (nm - first) / grid.step_nm;
    let below = (place as usize).min(grid.count - 2);
    let share = place - below as f64;
    Ok(values[below] * (1.0 - share) + values[below + 1] * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(name: &str) -> Illuminant {
        Illuminant::named(name).unwrap()
    }

    #[test]
    fn whites_of_the_reference_file() {
        let grid = Grid { first_nm: 380.0, step_nm: 1.0, count: 401 };
        for (name, wanted) in [
            ("C", [0.980594139753, 1.0, 1.18163796804]),
            ("D65", [0.950422817629, 1.0, 1.08861009241]),
            ("A", [1.09847886503, 1.0, 0.355873460626]),
            ("E", [0.999987450688, 1.0, 0.999903198651]),
        ] {
            let white = Weights::new(&grid, &light(name), Observer::Cie1931).unwrap().white;
            for i in 0..3 {
                assert!((white[i] - wanted[i]).abs() < 1e-11, "{name} {white:?}");
            }
        }
    }

    #[test]
    fn perfect_reflector_is_white_and_sums_are_linear() {
        let grid = Grid::default();
        for name in ["D65", "FL2", "blackbody:3000", "lines:546.1*2,435.8"] {
            let weights = Weights::new(&grid, &light(name), Observer::Cie1964).unwrap();
            let xyz = weights.sum(&grid, &[0.5; 471]).unwrap();
            for (value, white) in xyz.iter().zip(weights.white) {
                assert!((value - 0.5 * white).abs() < 1e-14, "{name}");
            }
        }
    }

    #[test]
    fn a_line_reads_the_spectrum_where_it_is() {
        let grid = Grid { first_nm: 500.0, step_nm: 10.0, count: 11 };
        let values: Vec<f64> = (0..11).map(f64::from).collect();
        let weights = Weights::new(&grid, &light("laser:547.5"), Observer::Cie1931).unwrap();
        assert!((weights.sum(&grid, &values).unwrap()[1] - 4.75).abs() < 1e-13);
        let outside = Weights::new(&grid, &light("laser:632.99"), Observer::Cie1931).unwrap();
        assert!(outside.sum(&grid, &values).unwrap_err().to_string().contains("632.99"));
    }

    #[test]
    fn grids() {
        assert_eq!(Grid::through(&[400.0, 405.0, 410.0]).unwrap(), Grid { first_nm: 400.0, step_nm: 5.0, count: 3 });
        let thirds: Vec<f64> = (0..=300).map(|i| 400.0 + f64::from(i) / 3.0).collect();
        assert_eq!(Grid::through(&thirds).unwrap().count, 301);
        assert_eq!(Grid::default().divided(4), Grid { first_nm: 360.0, step_nm: 0.25, count: 1881 });
        for (wavelengths, wanted) in [
            (&[][..], "two wavelengths"),
            (&[500.0], "two wavelengths"),
            (&[500.0, f64::NAN], "index (1,)"),
            (&[-500.0, 500.0], "-500.0 at index (0,)"),
            (&[500.0, 490.0], "ascend"),
            (&[500.0, 500.0], "ascend"),
            (&[500.0, 510.0, 525.0], "uniform"),
        ] {
            let message = Grid::through(wavelengths).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
    }

    #[test]
    fn no_light_no_colour() {
        let grid = Grid { first_nm: 1000.0, step_nm: 1.0, count: 10 };
        let message = Weights::new(&grid, &light("D65"), Observer::Cie1931).unwrap_err().to_string();
        assert!(message.contains("no light at 1000..1009 nm"), "{message}");
    }
}
