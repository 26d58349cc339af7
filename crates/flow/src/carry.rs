//! Semi-Lagrangian transport of velocity and surfactant: where did what is here now come from?
//!
//! One trace from the middles of cells serves every field. Points on sides take the mean of the *displacements* of the
//! two middles next to them: the mean of the departure points would shift each of them by an eighth of a cell's turn
//! squared. Vectors are turned along the great circle on their way.

use std::f64::consts::TAU;

use iridesce_numerics::vector::along;
use rayon::prelude::*;

use crate::grid::{Edge, Grid, Kind, PAD, Padded};
use crate::near::{self, LONGEST, MOST_TURN, Scale, Site, Ways};
use crate::polar::{self, Circle, Displacements};

/// Room for a trace.
pub struct Carry {
    down: Padded,
    across: Padded,
    scalar: Padded,
    /// Velocity at the middles of cells, down and across, m/s, with ghosts.
    local: Vec<[f64; 2]>,
    /// From the middles of cells to where they came from, in rows and in columns.
    ways: [Vec<f64>; 2],
    /// Velocity near the poles, Cartesian, m/s, with ghosts.
    velocity: Vec<[f64; 3]>,
    /// From the middles of cells near the poles to where they came from, in radii, part by part.
    displacement: [Vec<f64>; 3],
    /// Rows next to either pole that are traced there, above and below.
    caps: [usize; 2],
    scale: Scale,
}

impl Carry {
    pub fn new(grid: &Grid) -> Carry {
        let stride = grid.columns + 2 * PAD;
        let each = if grid.is_plane() {
            [1.0 / grid.dy, 1.0 / grid.width[0]]
        } else {
            [grid.radius / grid.dy, grid.columns as f64 / TAU]
        };
        let sphere = if grid.is_plane() { 0 } else { 1 };
        Carry {
            down: Padded::new(grid, Kind::Down),
            across: Padded::new(grid, Kind::Across),
            scalar: Padded::new(grid, Kind::Scalar),
            local: vec![[0.0; 2]; (grid.rows + 2 * PAD) * stride],
            ways: [vec![0.0; grid.cells()], vec![0.0; grid.cells()]],
            velocity: vec![[0.0; 3]; sphere * (grid.rows + 2 * PAD) * stride],
            displacement: std::array::from_fn(|_| vec![0.0; sphere * grid.cells()]),
            caps: [0; 2],
            scale: Scale {
                plane: grid.is_plane(),
                rows: grid.rows as f64,
                columns: grid.columns as f64,
                closes: grid.closes(),
                each,
            },
        }
    }

    /// Traces back over `dt` seconds in a velocity that is steady meanwhile.
    pub fn trace(&mut self, grid: &Grid, down: &[f64], across: &[f64], dt: f64) {
        self.down.fill(grid, Kind::Down, down);
        self.across.fill(grid, Kind::Across, across);
        let fastest = self.fill_middles(grid, down, across);
        let half = dt / 2.0 / grid.radius;
        self.caps = caps(grid, 2.0 * half * fastest * 1.001);
        self.trace_in_the_grid(grid, half);
        if self.caps != [0; 2] {
            // Rows that those next to the poles may reach.
            let reach = (dt * fastest / grid.dy).min(grid.rows as f64) as usize + PAD + 2;
            self.trace_in_space(grid, half, reach);
        }
    }

    /// Velocity at the middles of cells, with ghosts; the fastest, m/s.
    fn fill_middles(&mut self, grid: &Grid, down: &[f64], across: &[f64]) -> f64 {
        let n = grid.columns;
        let stride = n + 2 * PAD;
        let fastest: Vec<f64> = self.local[PAD * stride..(PAD + grid.rows) * stride]
            .par_chunks_exact_mut(stride)
            .enumerate()
            .with_min_len(8)
            .map(|(i, out)| {
                let (above, below) = (&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]);
                let square = wide!(middles(above, below, &across[i * n..(i + 1) * n], out));
                for k in 0..PAD {
                    let [(left, _), (right, _)] = grid.beyond(Kind::Scalar, k);
                    let turned = |[v, u]: [f64; 2]| if grid.closes() { [v, u] } else { [v, -u] };
                    out[PAD - 1 - k] = turned(out[PAD + left]);
                    out[PAD + n + k] = turned(out[PAD + right]);
                }
                square
            })
            .collect();
        // Only one ghost beyond a wall is ever used: there the film slips along a mirror. Poles have caps.
        let (head, body) = self.local.split_at_mut(PAD * stride);
        let last = grid.rows * stride;
        for k in 0..stride {
            let [v, u] = body[k];
            head[(PAD - 1) * stride + k] = [-v, u];
            let [v, u] = body[last - stride + k];
            body[last + k] = [-v, u];
        }
        fastest.into_iter().fold(0.0, f64::max).sqrt()
    }

    /// Traces all rows but those next to the poles, in rows and columns.
    fn trace_in_the_grid(&mut self, grid: &Grid, half: f64) {
        let n = grid.columns;
        let [top, bottom] = self.caps;
        let lower = grid.rows - bottom;
        let (local, scale) = (&self.local, self.scale);
        let [ways_down, ways_across] = &mut self.ways;
        ways_down
            .par_chunks_exact_mut(n)
            .zip(ways_across.par_chunks_exact_mut(n))
            .enumerate()
            .with_min_len(4)
            .for_each(|(i, (down, across))| {
                if (top..lower).contains(&i) {
                    let site = Site { row: i as f64 + 0.5, column: 0.5, polar: grid.polar[i] };
                    wide!(near::trace(&site, &scale, local, half, down, across));
                }
            });
    }

    /// Traces the rows next to the poles in space, where velocities within `reach` rows of them are wanted.
    fn trace_in_space(&mut self, grid: &Grid, half: f64, reach: usize) {
        let n = grid.columns;
        let stride = n + 2 * PAD;
        let [top, bottom] = self.caps;
        let lower = grid.rows - bottom;
        let near_pole = |i: usize, more: usize| (top > 0 && i <= top + more) || (bottom > 0 && i + more + 1 >= lower);
        let local = &self.local;
        self.velocity[PAD * stride..(PAD + grid.rows) * stride]
            .par_chunks_exact_mut(stride)
            .enumerate()
            .with_min_len(8)
            .for_each(|(i, out)| {
                if !near_pole(i, reach) {
                    return;
                }
                for (out, [v, u], j) in out
                    .iter_mut()
                    .zip(&local[(i + PAD) * stride..])
                    .enumerate()
                    .map(|(k, (o, l))| (o, l, (k + n - PAD) % n))
                {
                    let ([s, c], [sp, cp]) = (grid.polar[i], grid.azimuth[j]);
                    *out = [v * c * cp - u * sp, v * c * sp + u * cp, -v * s];
                }
            });
        self.fill_ghosts(grid);
        let (velocity, scale) = (&self.velocity, self.scale);
        let [x, y, z] = &mut self.displacement;
        x.par_chunks_exact_mut(n)
            .zip(y.par_chunks_exact_mut(n))
            .zip(z.par_chunks_exact_mut(n))
            .enumerate()
            .with_min_len(4)
            .for_each(|(i, ((x, y), z))| {
                if near_pole(i, 0) {
                    let circle = Circle { polar: grid.polar[i], azimuth: &grid.azimuth };
                    wide!(polar::trace(i, &circle, &scale, velocity, half, [&mut x[..], &mut y[..], &mut z[..]]));
                }
            });
    }

    /// The rows of velocity beyond the edges: across a pole they are rows of the grid, beyond a wall a straight line.
    fn fill_ghosts(&mut self, grid: &Grid) {
        let stride = grid.columns + 2 * PAD;
        for (edge, below) in [(grid.top, false), (grid.bottom, true)] {
            for k in 0..PAD {
                let ghost = if below { PAD + grid.rows + k } else { PAD - 1 - k };
                let row = |k: usize| if below { PAD + grid.rows - 1 - k } else { PAD + k };
                for j in 0..stride {
                    self.velocity[ghost * stride + j] = match edge {
                        Edge::Pole => {
                            let across = (j + grid.columns - PAD + grid.columns / 2) % grid.columns;
                            self.velocity[row(k) * stride + PAD + across]
                        }
                        Edge::Wall => {
                            let (first, second) =
                                (self.velocity[row(0) * stride + j], self.velocity[row(1) * stride + j]);
                            let reach = (k + 1) as f64;
                            along(along([0.0; 3], first, 1.0 + reach), second, -reach)
                        }
                    };
                }
            }
        }
    }

    /// Carries a number at the middles of cells along the last trace.
    pub fn scalar(&mut self, grid: &Grid, values: &mut [f64]) {
        self.scalar.fill(grid, Kind::Scalar, values);
        let Carry { scalar: field, scale, .. } = &*self;
        let n = grid.columns;
        let lower = grid.rows - self.caps[1];
        values.par_chunks_exact_mut(n).enumerate().with_min_len(4).for_each(|(i, out)| {
            if (self.caps[0]..lower).contains(&i) {
                let site = Site { row: i as f64 + 0.5, column: 0.5, polar: grid.polar[i] };
                wide!(near::scalar(&site, scale, field, [self.way(i, n), self.way(i, n)], out));
                return;
            }
            let circle = Circle { polar: grid.polar[i], azimuth: &grid.azimuth };
            wide!(polar::scalar(&circle, scale, field, self.displaced(i, n), out));
        });
    }

    fn way(&self, row: usize, columns: usize) -> Ways<'_> {
        let [down, across] = &self.ways;
        Ways { down: &down[row * columns..(row + 1) * columns], across: &across[row * columns..(row + 1) * columns] }
    }

    fn displaced(&self, row: usize, columns: usize) -> Displacements<'_> {
        self.displacement.each_ref().map(|part| &part[row * columns..(row + 1) * columns])
    }

    /// Another velocity to be carried along the last trace.
    pub fn take(&mut self, grid: &Grid, down: &[f64], across: &[f64]) {
        self.down.fill(grid, Kind::Down, down);
        self.across.fill(grid, Kind::Across, across);
    }

    /// Carries the velocity of the last trace along itself.
    pub fn velocity(&self, grid: &Grid, down: &mut [f64], across: &mut [f64]) {
        let n = grid.columns;
        let Carry { down: v, across: u, scale, .. } = self;
        let [top, bottom] = self.caps;
        let lower = grid.rows - bottom;
        down[n..grid.rows * n].par_chunks_exact_mut(n).enumerate().with_min_len(4).for_each(|(i, out)| {
            let i = i + 1;
            if i > top && i < lower || scale.plane {
                let site = Site { row: i as f64, column: 0.5, polar: grid.polar_side[i] };
                wide!(near::velocity(&site, scale, [v, u], [self.way(i - 1, n), self.way(i, n)], 0, out));
                return;
            }
            let circle = Circle { polar: grid.polar_side[i], azimuth: &grid.azimuth };
            wide!(polar::velocity(&circle, scale, [v, u], [self.displaced(i - 1, n), self.displaced(i, n)], 0, out));
        });
        across.par_chunks_exact_mut(n).enumerate().with_min_len(4).for_each_init(
            || std::array::from_fn::<Vec<f64>, 3, _>(|_| vec![0.0; n]),
            |next, (i, out)| {
                let shift = |next: &mut [f64], own: &[f64]| {
                    next[..n - 1].copy_from_slice(&own[1..]);
                    next[n - 1] = own[0];
                };
                if (top..lower).contains(&i) {
                    let own = self.way(i, n);
                    let [down, across, _] = next;
                    shift(down, own.down);
                    shift(across, own.across);
                    let site = Site { row: i as f64 + 0.5, column: 1.0, polar: grid.polar[i] };
                    wide!(near::velocity(&site, scale, [v, u], [own, Ways { down, across }], 1, out));
                    if !grid.closes() {
                        out[n - 1] = 0.0;
                    }
                    return;
                }
                let own = self.displaced(i, n);
                next.iter_mut().zip(own).for_each(|(next, own)| shift(next, own));
                let circle = Circle { polar: grid.polar[i], azimuth: &grid.azimuth_side };
                let next: Displacements<'_> = next.each_ref().map(|next| &next[..]);
                wide!(polar::velocity(&circle, scale, [v, u], [own, next], 1, out));
            },
        );
    }
}

/// Rows next to either pole from which a way of at most `longest` radii could come too near to it.
fn caps(grid: &Grid, longest: f64) -> [usize; 2] {
    if grid.is_plane() {
        return [0; 2];
    }
    if longest.is_nan() || longest > LONGEST {
        return [grid.rows, 0];
    }
    let far = |sine: f64| sine >= longest * (1.0 + 1.0 / MOST_TURN);
    let count = |edge: Edge, row: &dyn Fn(usize) -> usize| match edge {
        Edge::Wall => 0,
        Edge::Pole => (0..grid.rows).take_while(|&k| !far(grid.polar[row(k)][0])).count().max(PAD),
    };
    let (top, bottom) = (count(grid.top, &|k| k), count(grid.bottom, &|k| grid.rows - 1 - k));
    if top + bottom + 2 > grid.rows { [grid.rows, 0] } else { [top, bottom] }
}

/// Velocity at the middles of a row of cells, and the greatest square of its speed.
#[inline(always)]
fn middles(above: &[f64], below: &[f64], right: &[f64], out: &mut [[f64; 2]]) -> f64 {
    let n = right.len();
    let (above, below, out) = (&above[..n], &below[..n], &mut out[PAD..PAD + n]);
    let mut most = [0.0_f64; 8];
    for j in 0..n {
        let v = (above[j] + below[j]) * 0.5;
        let u = (right[j] + right[if j == 0 { n - 1 } else { j - 1 }]) * 0.5;
        out[j] = [v, u];
        let square = v * v + u * u;
        most[j % 8] = if square > most[j % 8] { square } else { most[j % 8] };
    }
    most.into_iter().fold(0.0, f64::max)
}
