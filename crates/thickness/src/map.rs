//! A grid of thicknesses, which every model can give.

use crate::error::{ThicknessError, check_nm};
use crate::model::ThicknessModel;

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
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

fn check_size(width: usize, height: usize) -> Result<(), ThicknessError> {
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

/// Samples at the middles of the cells of a grid over an extent `[left, right, bottom, top]`, row 0 on top.
fn sampled(
    width: usize,
    height: usize,
    extent: [f64; 4],
    at: impl Fn(f64, f64) -> f64,
) -> Result<ThicknessMap, ThicknessError> {
    check_size(width, height)?;
    let [left, right, bottom, top] = extent;
    if !extent.iter().all(|x| x.is_finite()) || left == right || bottom == top {
        let allowed = "four finite numbers, left, right, bottom and top, with an area";
        return Err(ThicknessError::new("extent", allowed, format!("{extent:?}")));
    }
    let mut thickness_nm = Vec::with_capacity(width * height);
    for row in 0..height {
        let y = mix(top, bottom, (row as f64 + 0.5) / height as f64);
        thickness_nm.extend((0..width).map(|column| at(mix(left, right, (column as f64 + 0.5) / width as f64), y)));
    }
    ThicknessMap::new(width, height, thickness_nm)
}

impl ThicknessModel {
    /// The model on a grid, sampled at the middles of its cells.
    ///
    /// A gradient's grid spans its relative height, a map's its own; both take no extent. A wedge and a lens's gap need
    /// one, `[left, right, bottom, top]`: for a wedge in x and y of the scene, at z = 0; for a gap in mm from the point
    /// where it is narrowest.
    pub fn map(&self, width: usize, height: usize, extent: Option<[f64; 4]>) -> Result<ThicknessMap, ThicknessError> {
        let wrong = |allowed: &'static str| Err(ThicknessError::new("extent", allowed, format!("{extent:?}")));
        let extent = match (self, extent) {
            (ThicknessModel::Wedge(_) | ThicknessModel::LensGap(_), Some(extent)) => extent,
            (ThicknessModel::Wedge(_), None) => {
                return wrong("the part of the scene to show, left, right, bottom and top in x and y");
            }
            (ThicknessModel::LensGap(_), None) => {
                return wrong("the part of the gap to show, left, right, bottom and top in mm from its middle");
            }
            (_, None) => [0.0, 1.0, 0.0, 1.0],
            (_, Some(_)) => {
                return wrong("left out: it is for a wedge or a lens's gap; this model spans the whole object");
            }
        };
        sampled(width, height, extent, |x, y| match self {
            ThicknessModel::Uniform { thickness_nm } => *thickness_nm,
            ThicknessModel::Gradient(gradient) => gradient.at_height(y),
            ThicknessModel::Wedge(wedge) => wedge.at_point([x, y, 0.0]),
            ThicknessModel::LensGap(gap) => gap.at_square(x * x + y * y),
            ThicknessModel::Map(map) => map.sample(x, y),
            ThicknessModel::Flow(field) => field.sample(x, y),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Gradient, LensGap, Wedge};

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
        let gradient = Gradient::new(20.0, 900.0, 0.7).unwrap();
        let map = ThicknessModel::Gradient(gradient).map(3, 50, None).unwrap();
        assert_eq!((map.width(), map.height(), map.thickness_nm().len()), (3, 50, 150));
        assert_eq!(map.thickness_nm()[0], gradient.at_height(0.99));
        assert_eq!(map.thickness_nm()[149], gradient.at_height(0.01));
        // Linear interpolation of t = 900 - 880 s^0.7 errs by at most h^2 / 8 |t''|, largest towards s = 0.
        for i in 10..=98 {
            let s = f64::from(i) / 100.0;
            let bound = 0.02 * 0.02 / 8.0 * 880.0 * 0.21 * (s - 0.02).powf(-1.3) + 1e-9;
            assert!((map.sample(0.3, s) - gradient.at_height(s)).abs() <= bound, "{s}");
        }
        let uniform = ThicknessModel::uniform(320.0).unwrap().map(2, 1, None).unwrap();
        assert_eq!(uniform.into_thickness_nm(), [320.0, 320.0]);
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
    fn wedges_and_gaps_need_an_extent_and_others_take_none() {
        let wedge = ThicknessModel::Wedge(Wedge::new([0.0; 3], [4.0, 0.0, 0.0], 0.0, 400.0).unwrap());
        let map = wedge.map(4, 1, Some([0.0, 4.0, -1.0, 1.0])).unwrap();
        assert_eq!(map.thickness_nm(), [50.0, 150.0, 250.0, 350.0]);
        let up = ThicknessModel::Wedge(Wedge::new([0.0; 3], [0.0, 1.0, 0.0], 0.0, 400.0).unwrap());
        assert_eq!(up.map(1, 2, Some([0.0, 1.0, 0.0, 1.0])).unwrap().thickness_nm(), [300.0, 100.0], "row 0 on top");
        let gap = LensGap::new(1000.0, 10.0).unwrap();
        let map = ThicknessModel::LensGap(gap).map(3, 3, Some([-3.0, 3.0, -3.0, 3.0])).unwrap();
        let (side, corner) = (gap.at_radius(2.0), gap.at_square(8.0));
        assert_eq!(map.thickness_nm(), [corner, side, corner, side, 10.0, side, corner, side, corner]);
        let grid = ThicknessModel::Map(Arc::new(ThicknessMap::new(2, 1, vec![0.0, 100.0]).unwrap()));
        assert_eq!(grid.map(4, 1, None).unwrap().thickness_nm(), [0.0, 25.0, 75.0, 100.0]);
        for model in [&wedge, &ThicknessModel::LensGap(gap)] {
            assert_eq!(model.map(2, 2, None).unwrap_err().argument, "extent");
            for bad in [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 2.0, 2.0], [0.0, f64::NAN, 0.0, 1.0]] {
                assert_eq!(model.map(2, 2, Some(bad)).unwrap_err().argument, "extent");
            }
        }
        for model in [&grid, &ThicknessModel::uniform(1.0).unwrap()] {
            assert_eq!(model.map(2, 2, Some([0.0, 1.0, 0.0, 1.0])).unwrap_err().argument, "extent");
        }
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
        assert!(ThicknessModel::uniform(1.0).unwrap().map(1 << 20, 1 << 20, None).is_err());
    }
}
