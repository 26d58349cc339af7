//! Transport of thickness in flux form: what leaves a cell enters its neighbour, so that no liquid is lost.
//!
//! The scheme of Lin and Rood (Monthly Weather Review 124, 2046, 1996): one flux each way, each of a field that has
//! been carried half a step the other way, so that a constant stays constant in a flow without divergence. Fluxes are
//! of the piecewise parabolic method (Colella and Woodward, J. Comput. Phys. 54, 174, 1984); around the parallels they
//! reach over any number of cells.

use rayon::prelude::*;

use super::grid::{Grid, Kind, PAD, Padded, floor};

/// Furthest way down in one sub-step, cells; also how much neighbouring columns may close up.
const MOST_CELLS: f64 = 0.45;
/// Most sub-steps of a step.
pub const MOST_SUBSTEPS: f64 = 400.0;

pub struct Transport {
    half_across: Padded,
    half_down: Vec<f64>,
    scalar: Padded,
    flux_across: Vec<f64>,
    flux_down: Vec<f64>,
}

impl Transport {
    pub fn new(grid: &Grid) -> Transport {
        Transport {
            half_across: Padded::new(grid, Kind::Scalar),
            half_down: vec![0.0; grid.cells()],
            scalar: Padded::new(grid, Kind::Scalar),
            flux_across: vec![0.0; grid.cells()],
            flux_down: vec![0.0; grid.cells() + grid.columns],
        }
    }

    /// How many sub-steps a step of `dt` seconds takes, as a number that may be too large.
    pub fn substeps(grid: &Grid, down: &[f64], across: &[f64], dt: f64) -> f64 {
        let n = grid.columns;
        let fastest: Vec<f64> = across
            .par_chunks_exact(n)
            .enumerate()
            .with_min_len(16)
            .map(|(i, row)| {
                let rate = dt / grid.width[i];
                let closing = (0..n).map(|j| (row[j] - row[if j == 0 { n - 1 } else { j - 1 }]).abs());
                let down = down[i * n..(i + 2) * n].iter().map(|v| v.abs()).fold(0.0, f64::max);
                (closing.fold(0.0, f64::max) * rate).max(down * dt / grid.dy)
            })
            .collect();
        (fastest.into_iter().fold(0.0, f64::max) / MOST_CELLS).ceil().max(1.0)
    }

    /// Carries `h` over `dt` seconds in one sub-step.
    pub fn step(&mut self, grid: &Grid, h: &mut [f64], down: &[f64], across: &[f64], dt: f64) {
        let n = grid.columns;
        self.scalar.fill(grid, Kind::Scalar, h);
        let Transport { half_across, half_down, scalar, flux_across, flux_down } = self;

        // Half a step across (`half_down` holds it until its ghosts are made), by the velocity at the middles of cells.
        half_down.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let row = &h[i * n..(i + 1) * n];
            let u = &across[i * n..(i + 1) * n];
            let rate = dt / grid.width[i] / 2.0;
            for j in 0..n {
                let c = (u[j] + u[if j == 0 { n - 1 } else { j - 1 }]) * rate;
                let from = j as f64 - c;
                let left = floor(from);
                let share = from - left;
                let left = (left as isize).rem_euclid(n as isize) as usize;
                let right = if left + 1 == n { 0 } else { left + 1 };
                out[j] = 0.5 * (row[j] + row[left] * (1.0 - share) + row[right] * share);
            }
        });
        half_across.fill(grid, Kind::Scalar, half_down);
        // Half a step down.
        half_down.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let line = |k: isize| &scalar.row(i as isize + k)[PAD..PAD + n];
            let (above, here, below) = (line(-1), line(0), line(1));
            let (v, w) = (&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]);
            let rate = dt / grid.dy / 2.0;
            for j in 0..n {
                let c = (v[j] + w[j]) * rate;
                let from = if c > 0.0 { above[j] } else { below[j] };
                out[j] = here[j] - 0.5 * c.abs() * (here[j] - from);
            }
        });
        // Liquid through the right sides, and through the upper ones, m3.
        flux_across.par_chunks_exact_mut(n).enumerate().with_min_len(4).for_each_init(
            Row::default,
            |room, (i, out)| {
                let u = &across[i * n..(i + 1) * n];
                room.flux(&half_down[i * n..(i + 1) * n], u, dt / grid.width[i], out);
                let whole = grid.dy * grid.width[i];
                out.iter_mut().for_each(|flux| *flux *= whole);
            },
        );
        let half_across = &*half_across;
        flux_down[n..grid.rows * n].par_chunks_exact_mut(n).enumerate().with_min_len(4).for_each(|(i, out)| {
            let i = i as isize + 1;
            let line = |k: isize| &half_across.row(i + k)[PAD..PAD + n];
            let [a, b, c, d, e, f] = [line(-3), line(-2), line(-1), line(0), line(1), line(2)];
            let v = &down[i as usize * n..(i as usize + 1) * n];
            let (rate, whole) = (dt / grid.dy, grid.side[i as usize] * dt);
            for j in 0..n {
                let courant = v[j] * rate;
                let held = if courant > 0.0 {
                    mean_leaving([a[j], b[j], c[j], d[j], e[j]], courant)
                } else {
                    // The same seen from below.
                    mean_leaving([f[j], e[j], d[j], c[j], b[j]], -courant)
                };
                out[j] = v[j] * whole * held;
            }
        });
        h.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, row)| {
            let (above, below) = (&flux_down[i * n..(i + 1) * n], &flux_down[(i + 1) * n..(i + 2) * n]);
            let right = &flux_across[i * n..(i + 1) * n];
            let scale = 1.0 / grid.area[i];
            for j in 0..n {
                let left = right[if j == 0 { n - 1 } else { j - 1 }];
                row[j] -= (right[j] - left + below[j] - above[j]) * scale;
            }
        });
    }
}

/// Mean over the last `share` of the middle of five cells, of the parabola through it.
#[inline]
fn mean_leaving(cells: [f64; 5], share: f64) -> f64 {
    let [a, b, c, d, e] = cells;
    let (left, right) = limited(b, c, d, edge(a, b, c, d), edge(b, c, d, e));
    leaving(c, left, right, share)
}

/// The value between `b` and `c` of four cells, never outside these two.
#[inline]
fn edge(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let value = (7.0 * (b + c) - a - d) / 12.0;
    value.max(b.min(c)).min(b.max(c))
}

/// Ends of a parabola of mean `c`, such that it stays between its neighbours.
#[inline]
fn limited(b: f64, c: f64, d: f64, left: f64, right: f64) -> (f64, f64) {
    if (c - b) * (d - c) <= 0.0 {
        return (c, c);
    }
    let change = right - left;
    let bend = 6.0 * (c - 0.5 * (left + right));
    if change * bend > change * change {
        (3.0 * c - 2.0 * right, right)
    } else if change * bend < -change * change {
        (left, 3.0 * c - 2.0 * left)
    } else {
        (left, right)
    }
}

#[inline]
fn leaving(c: f64, left: f64, right: f64, share: f64) -> f64 {
    let bend = 6.0 * (c - 0.5 * (left + right));
    right - 0.5 * share * (right - left - (1.0 - 2.0 / 3.0 * share) * bend)
}

/// Room for fluxes around one parallel.
#[derive(Default)]
struct Row {
    /// The row with two ghosts on either side.
    cells: Vec<f64>,
    edges: Vec<f64>,
    ends: Vec<(f64, f64)>,
    /// Sums of the first cells.
    sums: Vec<f64>,
}

impl Row {
    /// What passes the right side of each cell, in thickness times cells.
    fn flux(&mut self, row: &[f64], u: &[f64], rate: f64, out: &mut [f64]) {
        let n = row.len();
        self.cells.clear();
        self.cells.extend_from_slice(&row[n - 2..]);
        self.cells.extend_from_slice(row);
        self.cells.extend_from_slice(&row[..2]);
        let c = &self.cells;
        // Edge k lies on the left of cell k.
        self.edges.clear();
        self.edges.extend((0..=n).map(|k| edge(c[k], c[k + 1], c[k + 2], c[k + 3])));
        let edges = &self.edges;
        self.ends.clear();
        self.ends.extend((0..n).map(|k| limited(c[k + 1], c[k + 2], c[k + 3], edges[k], edges[k + 1])));
        let far = u.iter().fold(0.0_f64, |most, u| most.max(u.abs())) * rate >= 1.0;
        if far {
            self.sums.clear();
            self.sums.push(0.0);
            let mut sum = 0.0;
            for value in row {
                sum += value;
                self.sums.push(sum);
            }
        }
        let total = self.sums.last().copied().unwrap_or(0.0);
        // Sum of the cells from `a` to before `b`, which may lie any number of turns away.
        let sums = &self.sums;
        let up_to = |k: isize| total * k.div_euclid(n as isize) as f64 + sums[k.rem_euclid(n as isize) as usize];
        for j in 0..n {
            let courant = u[j] * rate;
            let whole = floor(courant.abs());
            let share = courant.abs() - whole;
            let cells = whole as isize;
            // The first cell that is not passed whole.
            let (k, forward) = if courant > 0.0 { (j as isize - cells, true) } else { (j as isize + 1 + cells, false) };
            let at = if cells == 0 && k < n as isize { k as usize } else { k.rem_euclid(n as isize) as usize };
            let (left, right) = self.ends[at];
            let (from, to) = if forward { (left, right) } else { (right, left) };
            let mut passed = share * leaving(row[at], from, to, share);
            if cells > 0 {
                let j = j as isize;
                passed += if forward { up_to(j + 1) - up_to(k + 1) } else { up_to(k) - up_to(j + 1) };
            }
            out[j] = if forward { passed } else { -passed };
        }
    }
}
