//! The implicit half of a step: the tension that keeps a film from being stretched.
//!
//! `(A / (dt^2 E)) q - div(M^-1 grad q) = (A / dt) s - div u` over cells of area A, for `q = dt E s`, by conjugate
//! gradients. The preconditioner takes the mean of 1/M along each row, so that a layered film is solved at once.
//! Without the first term (E infinite) the film is incompressible and q is determined but for a constant.

use rayon::prelude::*;

use crate::grid::Grid;
use crate::spectral::{Ends, Spectral, Task, Tridiagonal};

/// Most iterations: what is needed is a few.
const MOST: usize = 500;

pub struct Tension {
    spectral: Spectral,
    /// What couples a cell to the one above (by upper side) and to the one on its right, m2/kg.
    pub up: Vec<f64>,
    pub right: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    applied: Vec<f64>,
    preconditioned: Vec<f64>,
}

impl Tension {
    pub fn new(grid: &Grid) -> Tension {
        let zeros = || vec![0.0; grid.cells()];
        Tension {
            spectral: Spectral::new(grid.columns, grid.rows, if grid.closes() { Ends::Closed } else { Ends::Even }),
            up: vec![0.0; grid.cells() + grid.columns],
            right: zeros(),
            residual: zeros(),
            direction: zeros(),
            applied: zeros(),
            preconditioned: zeros(),
        }
    }

    /// Solves for `q`, which holds a first guess; `diagonal` is A / (dt^2 E) by row, all zero if incompressible;
    /// `right_side` by cell. Returns the iterations, or none if it does not get there.
    pub fn solve(
        &mut self,
        grid: &Grid,
        q: &mut [f64],
        diagonal: &[f64],
        right_side: &mut [f64],
        tolerance: f64,
    ) -> Option<usize> {
        let n = grid.columns;
        let singular = diagonal[0] == 0.0;
        let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        if singular {
            let mean = mean_of(right_side);
            right_side.iter_mut().for_each(|value| *value -= mean);
        }
        let row_mean = |values: &[f64]| values.chunks_exact(n).map(mean_of).collect::<Vec<f64>>();
        let (up, mut right) = (row_mean(&self.up), row_mean(&self.right));
        if !grid.closes() {
            // The borders couple nothing: one side less than cells.
            right.iter_mut().for_each(|mean| *mean *= n as f64 / (n - 1) as f64);
        }
        let rows = grid.rows;
        let system = Tridiagonal::new(grid.period(), up[..rows].to_vec(), up[1..].to_vec(), |row, turn| {
            diagonal[row] + up[row] + up[row + 1] + right[row] * turn
        });

        let wanted =
            tolerance * total(right_side.par_chunks_exact(n).with_min_len(16).map(|row| wide!(dot(row, row)))).sqrt();
        let Tension { spectral, up, right, residual, direction, applied, preconditioned } = self;
        let around = |row: usize| Around::new(row, n, rows, diagonal, up, right);
        let guess = &*q;
        let first = residual.par_chunks_exact_mut(n).enumerate().with_min_len(8).map(|(row, out)| {
            let b = &right_side[row * n..(row + 1) * n];
            wide!({
                apply(&around(row), guess, out);
                out.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
                dot(out, out)
            })
        });
        let mut square = total(first);
        let mut rho = 0.0;
        for iteration in 0..MOST {
            if !square.is_finite() {
                return None;
            }
            if square.sqrt() <= wanted {
                if singular {
                    let mean = grid.integral(q) / grid.total_area();
                    q.iter_mut().for_each(|value| *value -= mean);
                }
                return Some(iteration);
            }
            spectral.solve_from(residual, preconditioned, &Task::Solve(&system), false);
            if singular {
                let mean = mean_of(preconditioned);
                preconditioned.iter_mut().for_each(|value| *value -= mean);
            }
            let pairs = residual.par_chunks_exact(n).zip(preconditioned.par_chunks_exact(n)).with_min_len(16);
            let new = total(pairs.map(|(r, z)| wide!(dot(r, z))));
            let share = if iteration == 0 { 0.0 } else { new / rho };
            rho = new;
            direction.par_chunks_exact_mut(n).zip(preconditioned.par_chunks_exact(n)).with_min_len(16).for_each(
                |(d, z)| {
                    wide!(d.iter_mut().zip(z).for_each(|(d, z)| *d = z + share * *d));
                },
            );
            let along = &*direction;
            let lengths = applied.par_chunks_exact_mut(n).enumerate().with_min_len(8).map(|(row, out)| {
                wide!({
                    apply(&around(row), along, out);
                    dot(out, &along[row * n..(row + 1) * n])
                })
            });
            let length = rho / total(lengths);
            let rows = q.par_chunks_exact_mut(n).zip(residual.par_chunks_exact_mut(n)).enumerate().with_min_len(16);
            square = total(rows.map(|(row, (q, r))| {
                let (d, a) = (&along[row * n..(row + 1) * n], &applied[row * n..(row + 1) * n]);
                wide!({
                    q.iter_mut().zip(d).for_each(|(q, d)| *q += length * d);
                    r.iter_mut().zip(a).for_each(|(r, a)| *r -= length * a);
                    dot(r, r)
                })
            }));
        }
        None
    }
}

/// Sum over rows, in their order whatever the threads.
fn total(rows: impl IndexedParallelIterator<Item = f64>) -> f64 {
    rows.collect::<Vec<f64>>().iter().sum()
}

/// Sum of products of a row, eight side by side.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// A row and what couples it.
struct Around<'a> {
    n: usize,
    /// It, the one above and the one below. No side at the ends couples, so any row will do beyond them.
    rows: [usize; 3],
    diagonal: f64,
    up: &'a [f64],
    down: &'a [f64],
    right: &'a [f64],
}

impl<'a> Around<'a> {
    fn new(row: usize, n: usize, rows: usize, diagonal: &[f64], up: &'a [f64], right: &'a [f64]) -> Around<'a> {
        Around {
            n,
            rows: [row, row.saturating_sub(1), (row + 1).min(rows - 1)],
            diagonal: diagonal[row],
            up: &up[row * n..(row + 1) * n],
            down: &up[(row + 1) * n..(row + 2) * n],
            right: &right[row * n..(row + 1) * n],
        }
    }
}

/// What the matrix makes of a row of `q`.
#[inline(always)]
fn apply(around: &Around<'_>, q: &[f64], out: &mut [f64]) {
    let n = around.n;
    let [here, above, below] = around.rows.map(|row| &q[row * n..(row + 1) * n]);
    let (up, down, right, out) = (&around.up[..n], &around.down[..n], &around.right[..n], &mut out[..n]);
    let one = |j: usize, before: usize, after: usize| {
        around.diagonal * here[j]
            + up[j] * (here[j] - above[j])
            + down[j] * (here[j] - below[j])
            + right[j] * (here[j] - here[after])
            + right[before] * (here[j] - here[before])
    };
    out[0] = one(0, n - 1, 1);
    for (j, out) in out.iter_mut().enumerate().take(n - 1).skip(1) {
        *out = one(j, j - 1, j + 1);
    }
    out[n - 1] = one(n - 1, n - 2, 0);
}
