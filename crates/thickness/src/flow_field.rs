//! A film that has flowed, as a field that is smooth between its cells.

use iridesce_numerics::interpolation::catmull_rom;

use crate::black_edge::BlackEdge;
use crate::map::ThicknessMap;

/// A film that has flowed, over a whole sphere or a plane that repeats across.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowField {
    map: ThicknessMap,
    is_globe: bool,
    max_nm: f64,
    edge: Option<BlackEdge>,
}

/// Between which cells a place lies: of the four rows and columns around it the second, counted from two before the first
/// cell, and the weights of the four.
struct Between {
    column: usize,
    row: usize,
    across: [f64; 4],
    down: [f64; 4],
}

impl FlowField {
    /// A grid over longitude and latitude (`is_globe`) or over a plane; it repeats across.
    pub fn new(map: ThicknessMap, is_globe: bool) -> FlowField {
        let max_nm = map.max_nm();
        FlowField { map, is_globe, max_nm, edge: None }
    }

    /// The same, with black film where it is thinner than `below_nm`, which ends at an edge: on either side of it lies the
    /// thickness of that side alone. The edge is the smoothest that leaves the middle of every cell on its side.
    ///
    /// ```
    /// use iridesce_thickness::{FlowField, ThicknessMap};
    /// let map = ThicknessMap::new(4, 1, vec![12.0, 12.0, 300.0, 300.0])?;
    /// let at = |field: &FlowField, u: f64| field.sample(u, 0.5);
    /// let smooth = FlowField::new(map.clone(), false);
    /// let edged = FlowField::with_black_film(map, false, 55.0);
    /// assert_eq!((at(&smooth, 0.49).round(), at(&smooth, 0.51).round()), (142.0, 170.0));
    /// assert_eq!((at(&edged, 0.49).round(), at(&edged, 0.51).round()), (12.0, 300.0));
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn with_black_film(map: ThicknessMap, is_globe: bool, below_nm: f64) -> FlowField {
        let edge = BlackEdge::find(map.thickness_nm(), map.width(), is_globe, below_nm);
        FlowField { edge, ..FlowField::new(map, is_globe) }
    }

    /// The same where it is known what share of each cell is black film, which is `black_nm` thick: the edge goes where
    /// the share is a half.
    ///
    /// ```
    /// use iridesce_thickness::{FlowField, ThicknessMap};
    /// // A quarter of the third cell is black.
    /// let map = ThicknessMap::new(4, 1, vec![12.0, 12.0, 228.0, 300.0])?;
    /// let field = FlowField::with_black_share(map, false, &[1.0, 1.0, 0.25, 0.0], 12.0);
    /// assert_eq!((field.sample(0.50, 0.5).round(), field.sample(0.625, 0.5).round()), (12.0, 300.0));
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn with_black_share(map: ThicknessMap, is_globe: bool, share: &[f64], black_nm: f64) -> FlowField {
        let edge = BlackEdge::of_shares(map.thickness_nm(), map.width(), is_globe, share, black_nm);
        let max_nm = edge.as_ref().map_or(0.0, |edge| edge.rest.iter().copied().fold(0.0, f64::max));
        let plain = FlowField::new(map, is_globe);
        FlowField { edge, max_nm: plain.max_nm.max(max_nm), ..plain }
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
        let turn = if u.is_finite() { u - u.floor() } else { 0.0 };
        let across = turn * width as f64 + 0.5;
        let down = (1.0 - v.clamp(0.0, 1.0)) * height as f64 + 0.5;
        // Of the neighbour before: the first of the four is one before that.
        let (column, row) = (across as usize, down as usize);
        let place =
            Between { column, row, across: catmull_rom(across - column as f64), down: catmull_rom(down - row as f64) };
        let values = match &self.edge {
            Some(edge) if edge.passes(self.four(&place)) => {
                if self.cubic(&edge.level, &place) < 0.0 {
                    &edge.black
                } else {
                    &edge.rest
                }
            }
            _ => self.map.thickness_nm(),
        };
        self.cubic(values, &place).clamp(0.0, self.max_nm)
    }

    /// The four cells around a place; near an edge of a grid those that are there.
    fn four(&self, place: &Between) -> [usize; 4] {
        let (width, height) = (self.map.width(), self.map.height());
        std::array::from_fn(|k| {
            let row = (place.row + k / 2).clamp(1, height) - 1;
            // From 0, the one before the first, to one after the last: no division here.
            let column = place.column + k % 2;
            let column = if column == 0 { width } else { column };
            row * width + if column > width { 0 } else { column - 1 }
        })
    }

    fn cubic(&self, values: &[f64], place: &Between) -> f64 {
        let (width, height) = (self.map.width(), self.map.height());
        let Between { column, row, across, down } = *place;
        // Renders ask for millions of places: away from the edges the sixteen cells lie where they are counted.
        if column >= 2 && column + 1 < width && row >= 2 && row + 1 < height {
            let first = (row - 2) * width + column - 2;
            let rows = &values[first..first + 3 * width + 4];
            let along = |k: usize| {
                let line = &rows[k * width..k * width + 4];
                let [a, b, c, d] = [line[0], line[1], line[2], line[3]];
                across[0] * a + across[1] * b + (across[2] * c + across[3] * d)
            };
            // Four values without a loop: the compiler keeps them, and all weights, in registers.
            let [a, b, c, d] = [along(0), along(1), along(2), along(3)];
            return down[0] * a + down[1] * b + down[2] * c + down[3] * d;
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
        for (k, weight) in down.into_iter().enumerate() {
            let below = row + k;
            let beyond = below < 2 || below >= height + 2;
            let along = |i: usize, columns: [usize; 4]| {
                let line = &values[i * width..(i + 1) * width];
                let [a, b, c, d] = columns.map(|j| line[j]);
                across[0] * a + across[1] * b + (across[2] * c + across[3] * d)
            };
            let value = if !beyond {
                along(below - 2, columns)
            } else if self.is_globe {
                // Beyond a pole lies the other side.
                let i = if below < 2 { 1 - below } else { (2 * height + 1).saturating_sub(below) };
                let half = columns.map(|j| if j + width / 2 < width { j + width / 2 } else { j + width / 2 - width });
                along(i.min(height - 1), half)
            } else {
                along(if below < 2 { 0 } else { height - 1 }, columns)
            };
            sum += weight * value;
        }
        sum
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

    /// A round black film somewhere on a globe, in film that is thicker further out; its cells are those whose middles lie
    /// within. How far from the circle, in rows, its edge is met on ways out from its middle: the mean, the rms about it,
    /// and the rms of its slope against the circle.
    fn circle(from_pole: f64, radius: f64, drawn: impl Fn(ThicknessMap) -> FlowField) -> [f64; 3] {
        const WIDTH: usize = 384;
        const HEIGHT: usize = 192;
        let row = std::f64::consts::PI / HEIGHT as f64;
        let (sin, cos) = from_pole.sin_cos();
        let away = |k: usize| {
            let polar = (k / WIDTH) as f64 * row + row / 2.0;
            let turn = ((k % WIDTH) as f64 + 0.5) / WIDTH as f64 * std::f64::consts::TAU - std::f64::consts::PI;
            (polar.sin() * turn.sin() * sin + polar.cos() * cos).clamp(-1.0, 1.0).acos()
        };
        let thickness = |away: f64| if away < radius { 12.0 } else { 60.0 + 300.0 * (away - radius) };
        let values = (0..WIDTH * HEIGHT).map(|k| thickness(away(k))).collect();
        let field = drawn(ThicknessMap::new(WIDTH, HEIGHT, values).unwrap());
        let off: Vec<f64> = (0..720)
            .map(|way| {
                let (b, a) = (f64::from(way) / 360.0 * std::f64::consts::PI).sin_cos();
                let at = |off: f64| {
                    let (s, c) = (radius + off * row).sin_cos();
                    let x = [c * sin + s * a * cos, c * cos - s * a * sin, s * b];
                    let u = 0.5 + x[0].atan2(x[2]) / std::f64::consts::TAU;
                    field.sample(u, 0.5 + x[1].clamp(-1.0, 1.0).asin() / std::f64::consts::PI)
                };
                (-300..300).map(|k| f64::from(k) / 100.0).find(|&off| at(off) >= 50.0).unwrap()
            })
            .collect();
        let mean = off.iter().sum::<f64>() / 720.0;
        let rms = |values: &mut dyn Iterator<Item = f64>| (values.map(|v| v * v).sum::<f64>() / 720.0).sqrt();
        let step = std::f64::consts::PI / 360.0 * radius.sin() / row;
        let slope = rms(&mut (0..720).map(|k| (off[(k + 1) % 720] - off[k]) / step));
        [mean, rms(&mut off.iter().map(|off| off - mean)), slope]
    }

    #[test]
    fn the_edge_of_black_film_has_no_stairs() {
        for (from_pole, radius) in [(0.2, 0.35), (0.9, 0.3), (1.4, 0.15)] {
            let plain = circle(from_pole, radius, |map| FlowField::new(map, true));
            let edged = circle(from_pole, radius, |map| FlowField::with_black_film(map, true, 55.0));
            println!("circle of {radius} at {from_pole}: mean, rms, slope {plain:.3?}, with an edge {edged:.3?}");
            assert!(edged[0].abs() < 0.16 && edged[1] < 0.13 && edged[2] < 0.1, "{edged:?}");
            assert!(plain[0] > 0.15 && plain[2] > 0.3, "the corners of cells show: {plain:?}");
        }
    }

    /// A share that falls off as the flow leaves it, within one and a half rows: its edge is met to a few hundredths of a row.
    #[test]
    fn the_edge_of_a_share_is_round() {
        for (from_pole, radius) in [(0.2_f64, 0.35), (0.9, 0.3), (1.4, 0.15)] {
            let shares = |map: ThicknessMap| {
                let row = std::f64::consts::PI / 192.0;
                // The thickness of `circle` tells how far beyond the edge a cell lies; within it, it does not.
                let (sin, cos) = from_pole.sin_cos();
                let share: Vec<f64> = (0..map.thickness_nm().len())
                    .map(|k| {
                        let polar = (k / 384) as f64 * row + row / 2.0;
                        let turn = ((k % 384) as f64 + 0.5) / 384.0 * std::f64::consts::TAU - std::f64::consts::PI;
                        let away = (polar.sin() * turn.sin() * sin + polar.cos() * cos).clamp(-1.0, 1.0).acos();
                        1.0 / (1.0 + ((away - radius) / (0.35 * row)).exp())
                    })
                    .collect();
                let mean =
                    map.thickness_nm().iter().zip(&share).map(|(&nm, phi)| 12.0 * phi + nm.max(60.0) * (1.0 - phi));
                let map = ThicknessMap::new(384, 192, mean.collect()).unwrap();
                FlowField::with_black_share(map, true, &share, 12.0)
            };
            let [mean, rms, slope] = circle(from_pole, radius, shares);
            println!(
                "circle of {radius} at {from_pole} by its share: mean, rms, slope {mean:.3}, {rms:.3}, {slope:.3}"
            );
            assert!(mean.abs() < 0.06 && rms < 0.04 && slope < 0.12, "{mean} {rms} {slope}");
        }
    }

    #[test]
    fn an_edge_changes_nothing_that_is_far_from_it_and_no_middle_of_a_cell_changes_sides() {
        // Black film at a pole, over the seam, as a line one cell wide, and one cell alone.
        let (width, height) = (48, 24);
        let black = |i: usize, j: usize| i < 4 && j > 20 || (i == 12 && !(3..40).contains(&j)) || (i, j) == (18, 30);
        let at = |k: usize| {
            let (i, j) = (k / width, k % width);
            if black(i, j) { 12.0 + (j % 3) as f64 } else { 200.0 + 30.0 * ((i * j) as f64).sin() }
        };
        let map = ThicknessMap::new(width, height, (0..width * height).map(at).collect()).unwrap();
        for is_globe in [true, false] {
            let plain = FlowField::new(map.clone(), is_globe);
            let edged = FlowField::with_black_film(map.clone(), is_globe, 55.0);
            let (mut same, mut sides) = (0, [0; 2]);
            for k in 0..width * height {
                let (u, v) = ((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
                let place = |u: f64, v: f64| (u / width as f64, 1.0 - v / height as f64);
                let (a, b) = place(u, v);
                assert!((edged.sample(a, b) - at(k)).abs() < 1e-9, "{k}");
                let (a, b) = place(u + 0.3, v + 0.4);
                same += usize::from(edged.sample(a, b) == plain.sample(a, b));
                // One side or the other, nothing between them.
                let value = edged.sample(a, b);
                assert!(!(20.0..=150.0).contains(&value), "{value}");
                sides[usize::from(value > 100.0)] += 1;
            }
            assert!(same > width * height / 2 && sides[0] > 80, "{same} {sides:?}");
        }
        // All black, or none: nothing to draw.
        for below_nm in [1.0, 1000.0] {
            assert_eq!(FlowField::with_black_film(map.clone(), true, below_nm), FlowField::new(map.clone(), true));
        }
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
