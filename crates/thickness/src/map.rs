//! A grid of thicknesses, which every model can give.

use crate::model::{ThicknessError, ThicknessModel, check_nm};

/// Most cells of a grid: 8 GiB.
const MAX_CELLS: usize = 1 << 30;

/// Thicknesses on a grid, nm; row 0 on top, values at the middles of the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct ThicknessMap {
    width: usize,
    height: usize,
    thickness_nm: Vec<f64>,
}

impl ThicknessMap {
    /// A grid of `width` columns from its values, row after row; each finite and >= 0.
    pub fn new(width: usize, height: usize, thickness_nm: Vec<f64>) -> Result<ThicknessMap, ThicknessError> {
        check_size(width, height)?;
        if thickness_nm.len() != width * height {
            let message = format!("must hold {width} x {height} values, got {}", thickness_nm.len());
            return Err(ThicknessError { key: "thickness_nm", message });
        }
        for (i, &value) in thickness_nm.iter().enumerate() {
            check_nm("thickness_nm", value).map_err(|e| ThicknessError {
                message: format!("{} at row {}, column {}", e.message, i / width, i % width),
                ..e
            })?;
        }
        Ok(ThicknessMap { width, height, thickness_nm })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The values, row after row, nm.
    pub fn thickness_nm(&self) -> &[f64] {
        &self.thickness_nm
    }

    /// The values alone.
    pub fn into_thickness_nm(self) -> Vec<f64> {
        self.thickness_nm
    }

    /// Thickness in nm at `u` (0 left, 1 right) and `v` (0 bottom, 1 top): bilinear between the middles of the cells,
    /// the outermost values beyond them. NaN where a coordinate is.
    ///
    /// ```
    /// use iridesce_thickness::ThicknessMap;
    /// let map = ThicknessMap::new(2, 2, vec![0.0, 100.0, 200.0, 300.0]).unwrap();
    /// assert_eq!(map.sample(0.25, 0.75), 0.0);
    /// assert_eq!(map.sample(0.5, 0.5), 150.0);
    /// ```
    pub fn sample(&self, u: f64, v: f64) -> f64 {
        if u.is_nan() || v.is_nan() {
            return f64::NAN;
        }
        let (left, right, across) = cell(u, self.width);
        let (above, below, down) = cell(1.0 - v, self.height);
        let at = |row: usize, column: usize| self.thickness_nm[row * self.width + column];
        let top = mix(at(above, left), at(above, right), across);
        let bottom = mix(at(below, left), at(below, right), across);
        mix(top, bottom, down)
    }
}

/// The two cells around a coordinate in 0..1, and how far from the first to the second it lies.
fn cell(coordinate: f64, cells: usize) -> (usize, usize, f64) {
    let last = (cells - 1) as f64;
    let place = (coordinate * cells as f64 - 0.5).clamp(0.0, last);
    let first = place.floor();
    (first as usize, (first as usize + 1).min(cells - 1), place - first)
}

/// `a` for 0 and `b` for 1, exactly, and never outside the two.
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

fn check_size(width: usize, height: usize) -> Result<(), ThicknessError> {
    for (key, value) in [("width", width), ("height", height)] {
        if value == 0 {
            return Err(ThicknessError { key, message: "must be at least 1 cell, got 0".into() });
        }
    }
    match width.checked_mul(height) {
        Some(cells) if cells <= MAX_CELLS => Ok(()),
        _ => Err(ThicknessError {
            key: "width",
            message: format!("x height must be at most {MAX_CELLS} cells, got {width} x {height}"),
        }),
    }
}

impl ThicknessModel {
    /// The model on a grid, sampled at the middles of its cells; `v` of the grid is relative height.
    pub fn map(&self, width: usize, height: usize) -> Result<ThicknessMap, ThicknessError> {
        check_size(width, height)?;
        let mut thickness_nm = Vec::with_capacity(width * height);
        for row in 0..height {
            let value = self.at_height(1.0 - (row as f64 + 0.5) / height as f64);
            thickness_nm.resize(thickness_nm.len() + width, value);
        }
        Ok(ThicknessMap { width, height, thickness_nm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_meet_the_middles_and_stay_between() {
        let values: Vec<f64> = (0..12).map(|i| f64::from(i * i)).collect();
        let map = ThicknessMap::new(4, 3, values.clone()).unwrap();
        for row in 0..3 {
            for column in 0..4 {
                let (u, v) = ((column as f64 + 0.5) / 4.0, 1.0 - (row as f64 + 0.5) / 3.0);
                assert!((map.sample(u, v) - values[4 * row + column]).abs() < 1e-10);
            }
        }
        for i in -10..=20 {
            for j in -10..=20 {
                let value = map.sample(f64::from(i) / 10.0, f64::from(j) / 10.0);
                assert!((0.0..=121.0).contains(&value));
            }
        }
        // Beyond the outermost middles the value holds.
        assert_eq!((map.sample(-5.0, 9.0), map.sample(9.0, -5.0)), (0.0, 121.0));
        assert_eq!(map.sample(f64::NEG_INFINITY, f64::INFINITY), 0.0);
        assert!(map.sample(f64::NAN, 0.5).is_nan());
        // Half-way between four middles: their mean.
        assert!((map.sample(0.25, 1.0 - 1.0 / 3.0) - (0.0 + 1.0 + 16.0 + 25.0) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn models_give_maps_that_agree_with_them() {
        let model = ThicknessModel::gradient(20.0, 900.0, 0.7).unwrap();
        let map = model.map(3, 50).unwrap();
        assert_eq!((map.width(), map.height(), map.thickness_nm().len()), (3, 50, 150));
        assert_eq!(map.thickness_nm()[0], model.at_height(0.99));
        assert_eq!(map.thickness_nm()[149], model.at_height(0.01));
        // Linear interpolation of t = 900 - 880 s^0.7 errs by at most h^2 / 8 |t''|, largest towards s = 0.
        for i in 10..=98 {
            let s = f64::from(i) / 100.0;
            let bound = 0.02 * 0.02 / 8.0 * 880.0 * 0.21 * (s - 0.02).powf(-1.3) + 1e-9;
            assert!((map.sample(0.3, s) - model.at_height(s)).abs() <= bound, "{s}");
        }
        let uniform = ThicknessModel::uniform(320.0).unwrap().map(2, 1).unwrap();
        assert_eq!(uniform.into_thickness_nm(), [320.0, 320.0]);
    }

    #[test]
    fn impossible_grids_are_refused() {
        let key = |width, height, values: &[f64]| ThicknessMap::new(width, height, values.to_vec()).unwrap_err();
        assert_eq!(key(0, 2, &[]).key, "width");
        assert_eq!(key(2, 0, &[]).key, "height");
        assert_eq!(key(usize::MAX, 2, &[]).key, "width");
        assert!(key(2, 2, &[1.0; 3]).message.contains("2 x 2 values, got 3"));
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(key(2, 2, &[1.0, 1.0, 1.0, bad]).message.contains("at row 1, column 1"));
        }
        assert!(ThicknessModel::uniform(1.0).unwrap().map(1 << 20, 1 << 20).is_err());
    }
}
