//! What a film starts from: thickness by chance, or a given field brought onto the grid.

use iridesce_thickness::ThicknessMap;
use rayon::prelude::*;

use crate::chance::{self, Purpose};
use crate::grid::{Grid, Shape};
use crate::parameters::Parameters;

/// Waves in the thickness at the start.
const WAVES: u64 = 240;

/// Smooth noise, exactly of the mean and the spread that are asked for, and nowhere less than a fifth of the mean, m.
pub fn noise(grid: &Grid, p: &Parameters) -> Vec<f64> {
    let waves = chance::waves(grid, p.seed, Purpose::Thickness, WAVES, p.noise_longest_m, p.noise_shortest_m);
    let n = grid.columns;
    let mut h: Vec<f64> =
        (0..grid.cells()).into_par_iter().map(|k| chance::sum(&waves, grid.place(k / n, k % n))).collect();
    let area = grid.total_area();
    let mean = grid.integral(&h) / area;
    let squares: Vec<f64> = h.iter().map(|x| (x - mean).powi(2)).collect();
    let spread = (grid.integral(&squares) / area).sqrt().max(1e-12);
    h.iter_mut().for_each(|x| *x = p.thickness_m * (1.0 + p.noise * (*x - mean) / spread).max(0.2));
    let scale = p.thickness_m / (grid.integral(&h) / area);
    h.iter_mut().for_each(|x| *x *= scale);
    h
}

impl Parameters {
    /// The same film from a given thickness: `thickness_m` is its mean, and `noise` is none.
    pub fn starting_from(self, initial: &ThicknessMap) -> Parameters {
        Parameters { thickness_m: mean_nm(self.shape, initial) * 1e-9, noise: 0.0, ..self }
    }
}

/// Mean of a field over the shape that it covers from top to bottom, nm.
pub fn mean_nm(shape: Shape, field: &ThicknessMap) -> f64 {
    let rows = edges(shape, field.height());
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let values = field.thickness_nm().chunks_exact(field.width());
    let sums = values.zip(rows.windows(2)).map(|(row, side)| row.iter().sum::<f64>() * (side[1] - side[0]));
    sums.sum::<f64>() / field.width() as f64 / (last - first)
}

/// A field in nm on the cells of a grid, in m: each cell holds what lies over it, so that the volume is kept. Between
/// its own cells the field is linear, with van Leer's limits: it stays within its range.
pub fn resampled(grid: &Grid, field: &ThicknessMap) -> Vec<f64> {
    let (width, height, n) = (field.width(), field.height(), grid.columns);
    let values = field.thickness_nm();
    if (width, height) == (n, grid.rows) {
        return values.iter().map(|nm| nm * 1e-9).collect();
    }
    let across = Overlaps::new(&even(width), &even(n), grid.closes());
    let down = Overlaps::new(&edges(grid.shape, height), &edges(grid.shape, grid.rows), false);
    let narrow: Vec<f64> = values.par_chunks_exact(width).flat_map_iter(|row| across.of(row)).collect();
    let columns: Vec<Vec<f64>> = (0..n)
        .into_par_iter()
        .map(|j| down.of(&(0..height).map(|i| narrow[i * n + j]).collect::<Vec<f64>>()))
        .collect();
    (0..grid.cells()).map(|k| columns[k % n][k / n] * 1e-9).collect()
}

/// Where cells of a width lie, as shares of it.
fn even(count: usize) -> Vec<f64> {
    (0..=count).map(|k| k as f64 / count as f64).collect()
}

/// Where rows lie, in a measure of area from the top.
fn edges(shape: Shape, rows: usize) -> Vec<f64> {
    match shape {
        Shape::Plane { .. } => even(rows),
        // 1 - cos without cancellation at the pole.
        Shape::Sphere { rim_deg, .. } => {
            even(rows).into_iter().map(|share| 2.0 * (share * rim_deg.to_radians() / 2.0).sin().powi(2)).collect()
        }
    }
}

/// From one division of a line to another.
struct Overlaps {
    from: Vec<f64>,
    to: Vec<f64>,
    /// Whether the line closes on itself.
    closes: bool,
}

impl Overlaps {
    fn new(from: &[f64], to: &[f64], closes: bool) -> Overlaps {
        Overlaps { from: from.to_vec(), to: to.to_vec(), closes }
    }

    /// Means over the cells of the second division.
    fn of(&self, values: &[f64]) -> Vec<f64> {
        let Overlaps { from, to, .. } = self;
        let slopes: Vec<f64> = (0..values.len()).map(|k| self.slope(values, k)).collect();
        let mut k = 0;
        to.windows(2)
            .map(|side| {
                let (mut sum, mut at) = (0.0, side[0]);
                loop {
                    let last = k + 1 == values.len();
                    let end = if last { side[1] } else { side[1].min(from[k + 1]) };
                    let middle = (from[k] + from[k + 1]) / 2.0;
                    sum += (end - at) * (values[k] + slopes[k] * ((at + end) / 2.0 - middle));
                    at = end;
                    if last || from[k + 1] > side[1] {
                        break;
                    }
                    k += 1;
                }
                sum / (side[1] - side[0])
            })
            .collect()
    }

    /// Steepest line through a cell's mean that stays between its neighbours at the cell's ends.
    fn slope(&self, values: &[f64], k: usize) -> f64 {
        let (from, count) = (&self.from, values.len());
        let width = |k: usize| from[k + 1] - from[k];
        let neighbour = |beyond: bool, inner: usize, outer: usize| match (beyond, self.closes) {
            (false, _) => Some(inner),
            (true, true) => Some(outer),
            (true, false) => None,
        };
        let (Some(before), Some(after)) =
            (neighbour(k == 0, k.wrapping_sub(1), count - 1), neighbour(k + 1 == count, k + 1, 0))
        else {
            return 0.0;
        };
        let (left, right) = (values[k] - values[before], values[after] - values[k]);
        if left * right <= 0.0 {
            return 0.0;
        }
        let central = (left + right) / ((width(before) + width(after)) / 2.0 + width(k));
        let most = 2.0 * left.abs().min(right.abs()) / width(k);
        central.abs().min(most).copysign(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Sides;

    const DOME: Shape = Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 };

    fn field(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> ThicknessMap {
        let at = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
        let values = (0..width * height).map(|k| value(at(k % width, width), at(k / width, height))).collect();
        ThicknessMap::new(width, height, values).unwrap()
    }

    #[test]
    fn volume_and_range_are_kept_and_fields_that_are_smooth_stay_so() {
        let value = |x: f64, y: f64| 500.0 + 200.0 * (std::f64::consts::TAU * x).cos() * (3.0 * y).sin();
        for shape in [DOME, Shape::Plane { width_m: 0.1, height_m: 0.06, sides: Sides::Periodic }] {
            for (width, height) in [(300, 70), (64, 16), (37, 201), (1, 1)] {
                let grid = Grid::new(shape, 128, 48);
                let field = field(width, height, value);
                let h = resampled(&grid, &field);
                let mean = grid.integral(&h) / grid.total_area() * 1e9;
                assert!((mean / mean_nm(shape, &field) - 1.0).abs() < 1e-13, "{width} x {height}: {mean}");
                let (low, high) = field.thickness_nm().iter().fold((f64::MAX, 0.0), |(a, b), &v| (v.min(a), v.max(b)));
                assert!(h.iter().all(|h| (low - 1e-9..=high + 1e-9).contains(&(h * 1e9))), "{width} x {height}");
                if width > 1 {
                    let there =
                        |k: usize| value((k % 128) as f64 / 128.0 + 0.5 / 128.0, (k / 128) as f64 / 48.0 + 0.5 / 48.0);
                    let off = h.iter().enumerate().map(|(k, h)| (h * 1e9 - there(k)).abs()).fold(0.0, f64::max);
                    // The first and last rows are flat: half of one times the slope of 600 nm. Elsewhere lines are
                    // followed (steps of half a column of 37 would be 17 nm) but for crests.
                    let allowed = 300.0 / height as f64 + 3.0;
                    assert!(off < allowed, "{width} x {height}: off by {off} nm, {allowed} nm allowed");
                }
            }
        }
    }

    #[test]
    fn a_field_of_the_grid_s_own_size_is_taken_as_it_is() {
        let grid = Grid::new(DOME, 32, 8);
        let field = field(32, 8, |x, y| 300.0 + x + 10.0 * y);
        let same = resampled(&grid, &field).iter().zip(field.thickness_nm()).all(|(h, nm)| *h == nm * 1e-9);
        assert!(same);
    }
}
