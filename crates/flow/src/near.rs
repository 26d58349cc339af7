//! Tracing in latitude and longitude, for all rows but those next to a pole.
//!
//! On the unit sphere a point at the polar angle t that goes the way (a, b), down and across, with l^2 = 1 - a^2 - b^2,
//! comes to `sin(t' - t) = a + cos(t) (sqrt(k^2 + b^2) - k)` and `tan(f' - f) = b / k`, `k = l sin(t) + a cos(t)`; a
//! vector carried along is turned by `2 atan(tan((f' - f) / 2) (cos t - sin t tan((t' - t) / 2)))` (Napier). All of it is
//! exact; with ways of less than [`LONGEST`] the arcs are short series, so that a row is computed without one branch.

use iridesce_numerics::interpolation::lagrange;

use crate::grid::{PAD, Padded};

/// Points that are traced side by side.
pub const BLOCK: usize = 32;
/// Longest way in radii, and largest tangent of the turn about the axis: the series are then good to 1e-10.
pub const LONGEST: f64 = 0.17;
pub const MOST_TURN: f64 = 0.3;

/// The points of a row: where they are, in rows and columns from the upper left corner, and on the sphere.
#[derive(Clone, Copy)]
pub struct Site {
    pub row: f64,
    /// Of the first.
    pub column: f64,
    /// Sine and cosine of the polar angle.
    pub polar: [f64; 2],
}

/// What holds for all rows.
#[derive(Clone, Copy)]
pub struct Scale {
    pub plane: bool,
    pub rows: f64,
    pub columns: f64,
    /// Whether the last column's neighbour is the first.
    pub closes: bool,
    /// Rows and columns in one radius, or in one metre of a plane.
    pub each: [f64; 2],
}

/// Displacements of a row's points, in rows and columns.
pub struct Ways<'a> {
    pub down: &'a [f64],
    pub across: &'a [f64],
}

/// Ends of the ways of a block of points: where, and the tangent of half the turn of a vector.
pub struct Ends {
    pub row: [f64; BLOCK],
    pub column: [f64; BLOCK],
    pub turn: [f64; BLOCK],
}

/// Tangent of half an angle of sine `y`.
#[inline(always)]
fn half_tangent(y: f64) -> f64 {
    let s = y * y;
    y * (0.5 + s * (0.125 + s * (0.0625 + s * (5.0 / 128.0 + s * (7.0 / 256.0 + s * (21.0 / 1024.0))))))
}

/// The angle of sine `y`.
#[inline(always)]
fn arc_sine(y: f64) -> f64 {
    let s = y * y;
    let far = 15.0 / 336.0 + s * (105.0 / 3456.0 + s * (945.0 / 42240.0));
    y * (1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * far)))
}

/// The angle of tangent `t`.
#[inline(always)]
fn arc_tangent(t: f64) -> f64 {
    let s = t * t;
    let far = 1.0 / 9.0 - s * (1.0 / 11.0 - s * (1.0 / 13.0 - s * (1.0 / 15.0 - s * (1.0 / 17.0))));
    t * (1.0 - s * (1.0 / 3.0 - s * (1.0 / 5.0 - s * (1.0 / 7.0 - s * far))))
}

/// The tangent of an angle of at most 0.2.
#[inline(always)]
fn tangent(x: f64) -> f64 {
    let s = x * x;
    let far = 62.0 / 2835.0 + s * (1382.0 / 155_925.0 + s * (21844.0 / 6_081_075.0));
    x * (1.0 + s * (1.0 / 3.0 + s * (2.0 / 15.0 + s * (17.0 / 315.0 + s * far))))
}

/// The way (a, b) of length^2 1 - l^2 from a point: rows, columns, tangent of half the turn.
#[inline(always)]
fn way(site: &Site, scale: &Scale, a: f64, b: f64, l: f64) -> [f64; 3] {
    if scale.plane {
        return [a * scale.each[0], b * scale.each[1], 0.0];
    }
    let [s, c] = site.polar;
    let k = l * s + a * c;
    let t = b / k;
    let root = (1.0 + t * t).sqrt();
    let half = t / (1.0 + root);
    let y = a + c * k * t * half;
    [arc_sine(y) * scale.each[0], arc_tangent(t) * scale.each[1], half * (c - s * half_tangent(y))]
}

/// `l` of a way, sqrt(1 - a^2 - b^2).
#[inline(always)]
fn rest(a: f64, b: f64) -> f64 {
    (1.0 - a * a - b * b).sqrt()
}

/// The two parts of a vector of the far end, seen from the near end.
#[inline(always)]
fn turned(v: f64, u: f64, turn: f64) -> [f64; 2] {
    let scale = 1.0 / (1.0 + turn * turn);
    let (cos, sin) = ((1.0 - turn * turn) * scale, 2.0 * turn * scale);
    [v * cos - u * sin, v * sin + u * cos]
}

/// Whole part, as a number and as an index, of numbers below 2^31.
#[inline(always)]
pub fn whole(x: f64) -> (f64, usize) {
    // Adding and taking away 1.5 * 2^52 rounds to the nearest whole number, whose bits are then the lowest.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let near = (x + ROUND) - ROUND;
    let below = if near > x { near - 1.0 } else { near };
    (below, (below + ROUND).to_bits() as u32 as usize)
}

/// Row, kept within the grid, and column, too, or brought back into the first turn.
#[inline(always)]
pub fn within(scale: &Scale, row: f64, column: f64) -> [f64; 2] {
    let row = if row < 0.0 { 0.0 } else { row };
    let row = if row > scale.rows { scale.rows } else { row };
    if !scale.closes {
        let column = if column < 0.0 { 0.0 } else { column };
        return [row, if column > scale.columns { scale.columns } else { column }];
    }
    let turns = whole(column * (1.0 / scale.columns)).0;
    let column = column - turns * scale.columns;
    [row, if column > scale.columns { scale.columns } else { column }]
}

/// Displacements over the time of two halves from the middles of a row of cells: `half` is half the time over the radius,
/// `velocity` (down, across) has [`PAD`] ghosts all around.
#[inline(always)]
pub fn trace(site: &Site, scale: &Scale, velocity: &[[f64; 2]], half: f64, down: &mut [f64], across: &mut [f64]) {
    let n = down.len();
    let stride = n + 2 * PAD;
    let own = (site.row as usize + PAD) * stride + PAD;
    let here = &velocity[own..own + n];
    for first in (0..n).step_by(BLOCK) {
        let count = BLOCK.min(n - first);
        let (mut a, mut b) = ([0.0; BLOCK], [0.0; BLOCK]);
        for k in 0..count {
            [a[k], b[k]] = here[first + k].map(|v| -half * v);
        }
        for _ in 0..2 {
            let (mut turn, mut f, mut g) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
            let mut start = [0; BLOCK];
            for k in 0..BLOCK {
                let [rows, columns, t] = way(site, scale, a[k], b[k], rest(a[k], b[k]));
                let [row, column] = within(scale, site.row + rows, site.column + (first + k) as f64 + columns);
                // Ghosts keep both above zero.
                let (i, row_index) = whole(row - 0.5 + PAD as f64);
                let (j, column_index) = whole(column - 0.5 + PAD as f64);
                f[k] = row - 0.5 + PAD as f64 - i;
                g[k] = column - 0.5 + PAD as f64 - j;
                start[k] = row_index * stride + column_index;
                turn[k] = t;
            }
            let (mut v, mut u) = ([0.0; BLOCK], [0.0; BLOCK]);
            for k in 0..count {
                let (upper, lower) =
                    (&velocity[start[k]..start[k] + 2], &velocity[start[k] + stride..start[k] + stride + 2]);
                let mix = |part: usize| {
                    let above = upper[0][part] + g[k] * (upper[1][part] - upper[0][part]);
                    let below = lower[0][part] + g[k] * (lower[1][part] - lower[0][part]);
                    above + f[k] * (below - above)
                };
                (v[k], u[k]) = (mix(0), mix(1));
            }
            for k in 0..BLOCK {
                [a[k], b[k]] = turned(v[k], u[k], turn[k]).map(|v| -half * v);
            }
        }
        let (mut rows, mut columns) = ([0.0; BLOCK], [0.0; BLOCK]);
        for k in 0..BLOCK {
            // Twice as far along the same great circle.
            let l = if scale.plane { 1.0 } else { rest(a[k], b[k]) };
            [rows[k], columns[k], _] = way(site, scale, 2.0 * l * a[k], 2.0 * l * b[k], 2.0 * l * l - 1.0);
        }
        down[first..first + count].copy_from_slice(&rows[..count]);
        across[first..first + count].copy_from_slice(&columns[..count]);
    }
}

/// Where points between those of `ways` came from.
#[inline(always)]
fn ends(site: &Site, scale: &Scale, ways: [Ways<'_>; 2], first: usize) -> Ends {
    let count = BLOCK.min(ways[0].down.len() - first);
    let mut out = Ends { row: [0.0; BLOCK], column: [0.0; BLOCK], turn: [0.0; BLOCK] };
    let part = |values: &'_ [f64]| -> [f64; BLOCK] {
        let mut part = [0.0; BLOCK];
        part[..count].copy_from_slice(&values[first..first + count]);
        part
    };
    let [[da, aa], [db, ab]] = ways.map(|way| [part(way.down), part(way.across)]);
    for k in 0..BLOCK {
        let (rows, columns) = (0.5 * (da[k] + db[k]), 0.5 * (aa[k] + ab[k]));
        [out.row[k], out.column[k]] = within(scale, site.row + rows, site.column + (first + k) as f64 + columns);
        if !scale.plane {
            let [s, c] = site.polar;
            let half = |cells: f64, each: f64| tangent(0.5 * cells * (1.0 / each));
            out.turn[k] = half(columns, scale.each[1]) * (c - s * half(rows, scale.each[0]));
        }
    }
    out
}

/// Cubic interpolation of a block of points; `shift` is where the first value lies, in rows and columns.
#[inline(always)]
pub fn cubic(field: &Padded, ends: &Ends, shift: [f64; 2], count: usize) -> [f64; BLOCK] {
    let stride = field.stride;
    let (mut start, mut across, mut down) = ([0; BLOCK], [[0.0; BLOCK]; 4], [[0.0; BLOCK]; 4]);
    for k in 0..BLOCK {
        let (row, column) = (ends.row[k] - shift[0] + PAD as f64, ends.column[k] - shift[1] + PAD as f64);
        let ((i, row_index), (j, column_index)) = (whole(row), whole(column));
        start[k] = (row_index - 1) * stride + column_index - 1;
        let (wi, wj) = (lagrange(row - i), lagrange(column - j));
        for part in 0..4 {
            (down[part][k], across[part][k]) = (wi[part], wj[part]);
        }
    }
    let mut out = [0.0; BLOCK];
    for k in 0..count {
        let taps = &field.data[start[k]..start[k] + 3 * stride + 4];
        let mut columns = [0.0; 4];
        for row in 0..4 {
            let line = &taps[row * stride..row * stride + 4];
            for (sum, tap) in columns.iter_mut().zip(line) {
                *sum += down[row][k] * tap;
            }
        }
        out[k] = (columns[0] * across[0][k] + columns[1] * across[1][k])
            + (columns[2] * across[2][k] + columns[3] * across[3][k]);
    }
    out
}

/// Carries a number of the middles of a row of cells.
#[inline(always)]
pub fn scalar(site: &Site, scale: &Scale, field: &Padded, ways: [Ways<'_>; 2], out: &mut [f64]) {
    let ways = ways.map(|way| [way.down, way.across]);
    for first in (0..out.len()).step_by(BLOCK) {
        let count = BLOCK.min(out.len() - first);
        let ends = ends(site, scale, ways.map(|[down, across]| Ways { down, across }), first);
        let values = cubic(field, &ends, [0.5, 0.5], count);
        out[first..first + count].copy_from_slice(&values[..count]);
    }
}

/// Carries the velocity to a row of sides; `part` is 0 for the one down, 1 for the one across.
#[inline(always)]
pub fn velocity(site: &Site, scale: &Scale, fields: [&Padded; 2], ways: [Ways<'_>; 2], part: usize, out: &mut [f64]) {
    let ways = ways.map(|way| [way.down, way.across]);
    for first in (0..out.len()).step_by(BLOCK) {
        let count = BLOCK.min(out.len() - first);
        let ends = ends(site, scale, ways.map(|[down, across]| Ways { down, across }), first);
        let mut values = [0.0; BLOCK];
        if scale.plane {
            // Nothing turns: the other part is not felt.
            values = cubic(fields[part], &ends, [[0.0, 0.5], [0.5, 1.0]][part], count);
        } else {
            let v = cubic(fields[0], &ends, [0.0, 0.5], count);
            let u = cubic(fields[1], &ends, [0.5, 1.0], count);
            for k in 0..BLOCK {
                values[k] = turned(v[k], u[k], ends.turn[k])[part];
            }
        }
        out[first..first + count].copy_from_slice(&values[..count]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against points and vectors of three parts, and the library's arc tangents.
    #[test]
    fn ways_agree_with_points_of_space() {
        let scale = Scale { plane: false, rows: 0.0, columns: 0.0, closes: true, each: [1.0; 2] };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let frame = |t: f64, f: f64| {
            let ((s, c), (sp, cp)) = (t.sin_cos(), f.sin_cos());
            [[s * cp, s * sp, c], [c * cp, c * sp, -s], [-sp, cp, 0.0]]
        };
        for k in 0..1000 {
            let share = |m: u32| f64::from((k * 7919 + m * 104_729) % 1000) / 1000.0;
            // As near to the pole as the turn allows.
            let (length, heading) = (LONGEST * share(1), 6.3 * share(2));
            let polar = (length * (1.0 + 1.0 / MOST_TURN)).asin() + 0.8 * share(3) + 1e-3;
            let (a, b) = (length * heading.cos(), length * heading.sin());
            let site = Site { row: 0.0, column: 0.0, polar: [polar.sin(), polar.cos()] };
            let [rows, columns, turn] = way(&site, &scale, a, b, rest(a, b));
            let [r, down, across] = frame(polar, 0.0);
            let end: [f64; 3] = std::array::from_fn(|k| rest(a, b) * r[k] + a * down[k] + b * across[k]);
            assert!((end[0].hypot(end[1]).atan2(end[2]) - polar - rows).abs() < 1e-10);
            assert!((end[1].atan2(end[0]) - columns).abs() < 1e-10);
            // A vector at the end, carried back along the great circle.
            let (v, u) = (share(4), share(5));
            let [there, south, east] = frame(polar + rows, columns);
            let w: [f64; 3] = std::array::from_fn(|k| v * south[k] + u * east[k]);
            let part = dot(w, r) / (1.0 + dot(r, there));
            let back: [f64; 3] = std::array::from_fn(|k| w[k] - part * (r[k] + there[k]));
            let [v, u] = turned(v, u, turn);
            assert!((dot(back, down) - v).abs() < 1e-9 && (dot(back, across) - u).abs() < 1e-9);
            // The same turn from the displacements alone.
            let again = tangent(columns / 2.0) * (site.polar[1] - site.polar[0] * tangent(rows / 2.0));
            assert!((again - turn).abs() < 1e-9);
        }
    }
}
