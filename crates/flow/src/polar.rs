//! Tracing in space, for the rows next to a pole: there a way may lead over the pole, which latitude and longitude cannot
//! follow. With the long steps of previews these are all rows of a dome. As in [`crate::near`] a block of points is
//! computed side by side, without a branch.

use iridesce_numerics::turns::atan2_fast;

use crate::grid::{PAD, Padded};
use crate::near::{BLOCK, Ends, Scale, cubic, whole, within};

/// Points or vectors of a block, part by part.
type Points = [[f64; BLOCK]; 3];

/// Displacements of a row's points, part by part, in radii.
pub type Displacements<'a> = [&'a [f64]; 3];

/// A row of points on the unit sphere.
#[derive(Clone, Copy)]
pub struct Circle<'a> {
    /// Sine and cosine of the polar angle.
    pub polar: [f64; 2],
    /// Those of the azimuths.
    pub azimuth: &'a [[f64; 2]],
}

impl Circle<'_> {
    /// A block of its points and how many they are; the rest of the block repeats the first.
    #[inline(always)]
    fn points(&self, first: usize) -> (Points, usize) {
        let ([s, c], count) = (self.polar, BLOCK.min(self.azimuth.len() - first));
        let (mut x, mut y) = ([0.0; BLOCK], [0.0; BLOCK]);
        for k in 0..BLOCK {
            let [sin, cos] = self.azimuth[first + if k < count { k } else { 0 }];
            (x[k], y[k]) = (s * cos, s * sin);
        }
        ([x, y, [c; BLOCK]], count)
    }
}

#[inline(always)]
fn dot(a: &Points, b: &Points) -> [f64; BLOCK] {
    let mut out = [0.0; BLOCK];
    for k in 0..BLOCK {
        out[k] = a[0][k] * b[0][k] + a[1][k] * b[1][k] + a[2][k] * b[2][k];
    }
    out
}

/// `a + factor b`, made as long as a radius.
#[inline(always)]
fn ahead(a: &Points, b: &Points, factor: f64) -> Points {
    let mut out = [[0.0; BLOCK]; 3];
    for k in 0..BLOCK {
        let (x, y, z) = (a[0][k] + factor * b[0][k], a[1][k] + factor * b[1][k], a[2][k] + factor * b[2][k]);
        let scale = 1.0 / (x * x + y * y + z * z).sqrt();
        (out[0][k], out[1][k], out[2][k]) = (x * scale, y * scale, z * scale);
    }
    out
}

/// Where points lie among the cells.
#[inline(always)]
fn cells(scale: &Scale, points: &Points) -> Ends {
    let mut out = Ends { row: [0.0; BLOCK], column: [0.0; BLOCK], turn: [0.0; BLOCK] };
    let [x, y, z] = points;
    for k in 0..BLOCK {
        let (x, y, z) = (x[k], y[k], z[k]);
        let (polar, azimuth) = (atan2_fast((x * x + y * y).sqrt(), z), atan2_fast(y, x));
        [out.row[k], out.column[k]] = within(scale, polar * scale.each[0], azimuth * scale.each[1]);
    }
    out
}

/// Means of the displacements of the points to either side.
#[inline(always)]
fn between(ways: [Displacements<'_>; 2], first: usize, count: usize) -> Points {
    let mut mean = [[0.0; BLOCK]; 3];
    for part in 0..3 {
        let (a, b) = (&ways[0][part][first..first + count], &ways[1][part][first..first + count]);
        for ((mean, a), b) in mean[part].iter_mut().zip(a).zip(b) {
            *mean = 0.5 * (a + b);
        }
    }
    mean
}

/// Displacements over the time of two halves from a row of middles of cells: `half` is half the time over the radius,
/// `velocity` in space has [`PAD`] ghosts all around.
#[inline(always)]
pub fn trace(row: usize, circle: &Circle<'_>, scale: &Scale, velocity: &[[f64; 3]], half: f64, out: [&mut [f64]; 3]) {
    let stride = circle.azimuth.len() + 2 * PAD;
    let here = &velocity[(row + PAD) * stride + PAD..];
    for first in (0..circle.azimuth.len()).step_by(BLOCK) {
        let (x, count) = circle.points(first);
        let mut v = [[0.0; BLOCK]; 3];
        for (k, here) in here[first..first + count].iter().enumerate() {
            (v[0][k], v[1][k], v[2][k]) = (here[0], here[1], here[2]);
        }
        let mut middle = ahead(&x, &v, -half);
        for _ in 0..2 {
            let at = cells(scale, &middle);
            let (mut start, mut f, mut g) = ([0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
            for k in 0..BLOCK {
                // Ghosts keep both above zero.
                let (row, column) = (at.row[k] - 0.5 + PAD as f64, at.column[k] - 0.5 + PAD as f64);
                let ((i, row_index), (j, column_index)) = (whole(row), whole(column));
                (f[k], g[k], start[k]) = (row - i, column - j, row_index * stride + column_index);
            }
            for k in 0..count {
                let (upper, lower) =
                    (&velocity[start[k]..start[k] + 2], &velocity[start[k] + stride..start[k] + stride + 2]);
                for (part, v) in v.iter_mut().enumerate() {
                    let above = upper[0][part] + g[k] * (upper[1][part] - upper[0][part]);
                    let below = lower[0][part] + g[k] * (lower[1][part] - lower[0][part]);
                    v[k] = above + f[k] * (below - above);
                }
            }
            middle = ahead(&x, &v, -half);
        }
        // Twice as far along the same great circle.
        let turn = dot(&x, &middle);
        for part in 0..3 {
            for (k, out) in out[part][first..first + count].iter_mut().enumerate() {
                *out = 2.0 * turn[k] * middle[part][k] - 2.0 * x[part][k];
            }
        }
    }
}

/// Carries a number of the middles of a row of cells.
#[inline(always)]
pub fn scalar(circle: &Circle<'_>, scale: &Scale, field: &Padded, way: Displacements<'_>, out: &mut [f64]) {
    for first in (0..out.len()).step_by(BLOCK) {
        let (x, count) = circle.points(first);
        let ends = cells(scale, &ahead(&x, &between([way, way], first, count), 1.0));
        let values = cubic(field, &ends, [0.5, 0.5], count);
        out[first..first + count].copy_from_slice(&values[..count]);
    }
}

/// Carries the velocity to a row of sides; `part` is 0 for the one down, 1 for the one across. Vectors are turned along
/// the great circle of their way.
#[inline(always)]
pub fn velocity(
    circle: &Circle<'_>,
    scale: &Scale,
    fields: [&Padded; 2],
    ways: [Displacements<'_>; 2],
    part: usize,
    out: &mut [f64],
) {
    let [s, c] = circle.polar;
    for first in (0..out.len()).step_by(BLOCK) {
        let (x, count) = circle.points(first);
        let p = ahead(&x, &between(ways, first, count), 1.0);
        let ends = cells(scale, &p);
        let (v, u) = (cubic(fields[0], &ends, [0.0, 0.5], count), cubic(fields[1], &ends, [0.5, 1.0], count));
        let mut w = [[0.0; BLOCK]; 3];
        for k in 0..BLOCK {
            let over = 1.0 / (p[0][k] * p[0][k] + p[1][k] * p[1][k]).sqrt();
            let (cos, sin) = (p[0][k] * over, p[1][k] * over);
            w[0][k] = v[k] * p[2][k] * cos - u[k] * sin;
            w[1][k] = v[k] * p[2][k] * sin + u[k] * cos;
            w[2][k] = -v[k] * (p[0][k] * cos + p[1][k] * sin);
        }
        let (along, between) = (dot(&w, &x), dot(&p, &x));
        for (k, out) in out[first..first + count].iter_mut().enumerate() {
            let share = along[k] / (1.0 + between[k]);
            let back = |part: usize| w[part][k] - share * (p[part][k] + x[part][k]);
            let [sin, cos] = circle.azimuth[first + k];
            *out = if part == 0 {
                c * (back(0) * cos + back(1) * sin) - s * back(2)
            } else {
                back(1) * cos - back(0) * sin
            };
        }
    }
}
