//! A film that has flowed, as a field that is smooth between its cells.

use iridesce_numerics::interpolation::catmull_rom;

use crate::map::ThicknessMap;

/// A film that has flowed, over a whole sphere or a plane that repeats across.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowField {
    map: ThicknessMap,
    is_globe: bool,
    max_nm: f64,
}

impl FlowField {
    /// A grid over longitude and latitude (`is_globe`) or over a plane; it repeats across.
    pub fn new(map: ThicknessMap, is_globe: bool) -> FlowField {
        let max_nm = map.max_nm();
        FlowField { map, is_globe, max_nm }
    }

    /// The grid.
    pub fn map(&self) -> &ThicknessMap {
        &self.map
    }

    /// Whether it goes around a sphere.
    pub fn is_globe(&self) -> bool {
        self.is_globe
    }

    /// The largest thickness, nm.
    pub fn max_nm(&self) -> f64 {
        self.max_nm
    }

    /// Thickness in nm at `u` (once around) and `v` (0 at the bottom, 1 on top): cubic between the middles of the cells,
    /// smooth also over the poles of a globe, and never outside 0 and the largest value. Cells of a thickness that varies
    /// by whole orders of colour would show as facets if they were joined by straight lines.
    pub fn sample(&self, u: f64, v: f64) -> f64 {
        if u.is_nan() || v.is_nan() {
            return f64::NAN;
        }
        let (width, height) = (self.map.width(), self.map.height());
        let values = self.map.thickness_nm();
        let turn = if u.is_finite() { u - u.floor() } else { 0.0 };
        let across = turn * width as f64 + 0.5;
        let down = (1.0 - v.clamp(0.0, 1.0)) * height as f64 + 0.5;
        // Of the neighbour before: the first of the four is one before that.
        let (column, row) = (across as usize, down as usize);
        let (weights_across, weights_down) = (catmull_rom(across - column as f64), catmull_rom(down - row as f64));
        // Renders ask for millions of places: away from the edges the sixteen cells lie where they are counted.
        if column >= 2 && column + 1 < width && row >= 2 && row + 1 < height {
            let first = (row - 2) * width + column - 2;
            let mut sum = 0.0;
            for (k, weight) in weights_down.into_iter().enumerate() {
                let line = &values[first + k * width..first + k * width + 4];
                let [a, b, c, d] = [line[0], line[1], line[2], line[3]];
                let value =
                    weights_across[0] * a + weights_across[1] * b + (weights_across[2] * c + weights_across[3] * d);
                sum += weight * value;
            }
            return sum.clamp(0.0, self.max_nm);
        }
        // No division here either. Narrow grids alone wrap more than once.
        let wrapped = |k: usize| {
            let j = column + k + width - 2;
            if j < width {
                j
            } else if j < 2 * width {
                j - width
            } else {
                j % width
            }
        };
        let columns = [wrapped(0), wrapped(1), wrapped(2), wrapped(3)];
        let mut sum = 0.0;
        for (k, weight) in weights_down.into_iter().enumerate() {
            let below = row + k;
            let beyond = below < 2 || below >= height + 2;
            let along = |i: usize, columns: [usize; 4]| {
                let line = &values[i * width..(i + 1) * width];
                let [a, b, c, d] = columns.map(|j| line[j]);
                weights_across[0] * a + weights_across[1] * b + (weights_across[2] * c + weights_across[3] * d)
            };
            let value = if !beyond {
                along(below - 2, columns)
            } else if self.is_globe {
                // Beyond a pole lies the other side.
                let i = if below < 2 { 1 - below } else { 2 * height + 1 - below };
                let half = columns.map(|j| if j + width / 2 < width { j + width / 2 } else { j + width / 2 - width });
                along(i.min(height - 1), half)
            } else {
                along(if below < 2 { 0 } else { height - 1 }, columns)
            };
            sum += weight * value;
        }
        sum.clamp(0.0, self.max_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_fields_are_met_to_third_order_also_over_the_poles() {
        let place = |u: f64, v: f64| {
            let (longitude, latitude) = ((u - 0.5) * std::f64::consts::TAU, (v - 0.5) * std::f64::consts::PI);
            [latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos()]
        };
        let wave = |[x, y, z]: [f64; 3]| 500.0 + 100.0 * (2.0 * x + 3.0 * y - z).sin();
        let error = |n: usize| {
            let cell = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
            let at = |k: usize| wave(place(cell(k % n, n), 1.0 - cell(k / n, n / 2)));
            let field = FlowField::new(ThicknessMap::new(n, n / 2, (0..n * n / 2).map(at).collect()).unwrap(), true);
            (0..4000).fold(0.0_f64, |worst, i| {
                let (u, v) = ((f64::from(i) * 0.618).fract(), (f64::from(i) + 0.5) / 4000.0);
                worst.max((field.sample(u, v) - wave(place(u, v))).abs())
            })
        };
        let (coarse, fine) = (error(64), error(128));
        assert!(fine < 0.05 && coarse / fine > 6.0, "{coarse} {fine}");
    }

    #[test]
    fn no_cell_is_passed_by() {
        let map = ThicknessMap::new(4, 2, vec![0.0, 100.0, 0.0, 100.0, 50.0, 0.0, 0.0, 100.0]).unwrap();
        for is_globe in [false, true] {
            let field = FlowField::new(map.clone(), is_globe);
            for i in -50..=50 {
                for k in -3..=13 {
                    let value = field.sample(f64::from(i) / 25.0, f64::from(k) / 10.0);
                    assert!((0.0..=100.0).contains(&value));
                    let turned = field.sample(f64::from(i) / 25.0 + 1.0, f64::from(k) / 10.0);
                    assert!((turned - value).abs() < 1e-9);
                }
            }
            assert_eq!(field.sample(0.375, 0.75), 100.0);
            assert!(field.sample(f64::NAN, 0.5).is_nan() && field.sample(f64::INFINITY, 0.5).is_finite());
        }
    }
}
