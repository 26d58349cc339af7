//! A grid of thicknesses, which every model can give.

use crate::error::{ThicknessError, check_nm};

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
            let allowed = format!("{width} x {height} values");
            return Err(ThicknessError::new("thickness_nm", allowed, thickness_nm.len()));
        }
        for (i, &value) in thickness_nm.iter().enumerate() {
            check_nm("thickness_nm", value).map_err(|e| e.at(format!("at row {}, column {}", i / width, i % width)))?;
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

    /// The largest value, nm.
    pub fn max_nm(&self) -> f64 {
        self.thickness_nm.iter().copied().fold(0.0, f64::max)
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
        self.sample_with(u, v, [false, false])
    }

    /// The same where the grid goes round: across (`repeats[0]`), up (`repeats[1]`) or both, its two edges are
    /// neighbours and whole numbers of turns change nothing.
    ///
    /// ```
    /// use iridesce_thickness::ThicknessMap;
    /// let map = ThicknessMap::new(2, 1, vec![0.0, 100.0]).unwrap();
    /// assert_eq!(map.sample_with(1.0, 0.5, [true, false]), 50.0);
    /// assert_eq!(map.sample_with(-1.75, 0.5, [true, false]), 0.0);
    /// ```
    pub fn sample_with(&self, u: f64, v: f64, repeats: [bool; 2]) -> f64 {
        if u.is_nan() || v.is_nan() {
            return f64::NAN;
        }
        let (left, right, across) = cell(u, self.width, repeats[0]);
        let (above, below, down) = cell(1.0 - v, self.height, repeats[1]);
        let at = |row: usize, column: usize| self.thickness_nm[row * self.width + column];
        let top = mix(at(above, left), at(above, right), across);
        let bottom = mix(at(below, left), at(below, right), across);
        mix(top, bottom, down)
    }
}

/// The two cells around a coordinate, which counts from 0 to 1 over all cells, and how far from the first to the second
/// it lies.
fn cell(coordinate: f64, cells: usize, repeats: bool) -> (usize, usize, f64) {
    if !repeats {
        let last = (cells - 1) as f64;
        let place = (coordinate * cells as f64 - 0.5).clamp(0.0, last);
        let first = place.floor();
        return (first as usize, (first as usize + 1).min(cells - 1), place - first);
    }
    // Infinitely many turns have no end: any place does.
    let turn = if coordinate.is_finite() { coordinate - coordinate.floor() } else { 0.0 };
    // From half a cell before the first middle, which is half a cell after the last.
    let place = turn * cells as f64 + 0.5;
    let first = place.floor();
    ((first as usize + cells - 1) % cells, first as usize % cells, place - first)
}

/// `a` for 0 and `b` for 1, exactly, and never outside the two.
pub(crate) fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

pub(crate) fn check_size(width: usize, height: usize) -> Result<(), ThicknessError> {
    for (key, value) in [("width", width), ("height", height)] {
        if value == 0 {
            return Err(ThicknessError::new(key, "at least 1 cell", 0));
        }
    }
    match width.checked_mul(height) {
        Some(cells) if cells <= MAX_CELLS => Ok(()),
        _ => {
            let allowed = format!("such that width x height is at most {MAX_CELLS} cells");
            Err(ThicknessError::new("width", allowed, format!("{width} x {height}")))
        }
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
    fn grids_that_go_round_have_no_seam() {
        let values = [10.0, 20.0, 40.0, 80.0, 15.0, 25.0, 45.0, 85.0];
        let map = ThicknessMap::new(4, 2, values.to_vec()).unwrap();
        // Half-way between the last column and the first, whatever the turn.
        for u in [0.0, 1.0, -3.0, 7.0] {
            assert_eq!(map.sample_with(u, 1.0, [true, false]), 45.0);
        }
        assert_eq!(map.sample_with(1.0, 1.0, [false, false]), 80.0, "and held where it does not go round");
        // Half-way between the last row and the first.
        assert_eq!(map.sample_with(0.125, 0.0, [false, true]), 12.5);
        for i in -40..=40 {
            for j in -40..=40 {
                let (u, v) = (f64::from(i) / 16.0, f64::from(j) / 16.0);
                let here = map.sample_with(u, v, [true, true]);
                assert_eq!(here, map.sample_with(u + 1.0, v - 2.0, [true, true]));
                if (0.125..=0.875).contains(&u) && (0.25..=0.75).contains(&v) {
                    assert_eq!(here, map.sample(u, v), "the same away from the edges");
                }
            }
        }
        // The largest number below one turn, and what has no place on a circle.
        for u in [1.0 - f64::EPSILON / 2.0, -1e-300, 1e300, f64::INFINITY, f64::NEG_INFINITY] {
            assert!((10.0..=85.0).contains(&map.sample_with(u, u, [true, true])), "{u}");
        }
        assert!(map.sample_with(f64::NAN, 0.5, [true, true]).is_nan());
    }

    #[test]
    fn impossible_grids_are_refused() {
        let key = |width, height, values: &[f64]| ThicknessMap::new(width, height, values.to_vec()).unwrap_err();
        assert_eq!(key(0, 2, &[]).argument, "width");
        assert_eq!(key(2, 0, &[]).argument, "height");
        assert_eq!(key(usize::MAX, 2, &[]).argument, "width");
        assert!(key(2, 2, &[1.0; 3]).to_string().contains("2 x 2 values, got 3"));
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(key(2, 2, &[1.0, 1.0, 1.0, bad]).place, "at row 1, column 1");
        }
        assert_eq!(check_size(1 << 20, 1 << 20).unwrap_err().argument, "width");
    }
}
