//! The implicit half of a step: the tension that keeps a film from being stretched.
//!
//! `(A / (dt^2 E)) q - div(M^-1 grad q) = (A / dt) s - div u` over cells of area A, for `q = dt E s`, by conjugate
//! gradients. The preconditioner takes the mean of 1/M along each row, so that a layered film is solved at once.
//! Without the first term (E infinite) the film is incompressible and q is determined but for a constant.

use rayon::prelude::*;

use super::grid::Grid;
use super::spectral::{Spectral, Task, Tridiagonal};

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
            spectral: Spectral::new(grid.columns, grid.rows),
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
        let (up, right) = (row_mean(&self.up), row_mean(&self.right));
        let rows = grid.rows;
        let system = Tridiagonal::new(n, up[..rows].to_vec(), up[1..].to_vec(), |row, turn| {
            diagonal[row] + up[row] + up[row + 1] + right[row] * turn
        });

        let wanted = tolerance * dot(n, right_side, right_side).sqrt();
        let Tension { spectral, up, right, residual, direction, applied, preconditioned } = self;
        apply(n, diagonal, up, right, q, residual);
        residual.par_iter_mut().zip(&*right_side).for_each(|(r, b)| *r = b - *r);
        let mut rho = 0.0;
        for iteration in 0..MOST {
            let left = dot(n, residual, residual).sqrt();
            if !left.is_finite() {
                return None;
            }
            if left <= wanted {
                if singular {
                    let mean = grid.integral(q) / grid.total_area();
                    q.iter_mut().for_each(|value| *value -= mean);
                }
                return Some(iteration);
            }
            preconditioned.copy_from_slice(residual);
            spectral.solve(preconditioned, &Task::Solve(&system), false);
            if singular {
                let mean = mean_of(preconditioned);
                preconditioned.iter_mut().for_each(|value| *value -= mean);
            }
            let new = dot(n, residual, preconditioned);
            let share = if iteration == 0 { 0.0 } else { new / rho };
            rho = new;
            direction.par_iter_mut().zip(&*preconditioned).for_each(|(d, z)| *d = z + share * *d);
            apply(n, diagonal, up, right, direction, applied);
            let length = rho / dot(n, direction, applied);
            q.par_iter_mut().zip(&*direction).for_each(|(q, d)| *q += length * d);
            residual.par_iter_mut().zip(&*applied).for_each(|(r, a)| *r -= length * a);
        }
        None
    }
}

/// Sum of products; its order does not depend on threads.
fn dot(columns: usize, a: &[f64], b: &[f64]) -> f64 {
    let rows: Vec<f64> = a
        .par_chunks_exact(columns)
        .zip(b.par_chunks_exact(columns))
        .with_min_len(16)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>())
        .collect();
    rows.iter().sum()
}

fn apply(n: usize, diagonal: &[f64], up: &[f64], right: &[f64], q: &[f64], out: &mut [f64]) {
    let rows = diagonal.len();
    out.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(row, out)| {
        let line = |row: usize| &q[row * n..(row + 1) * n];
        let here = line(row);
        // No side at the ends couples, so any row will do beyond them.
        let (above, below) = (line(row.saturating_sub(1)), line((row + 1).min(rows - 1)));
        let (up, down) = (&up[row * n..(row + 1) * n], &up[(row + 1) * n..(row + 2) * n]);
        let right = &right[row * n..(row + 1) * n];
        for j in 0..n {
            let (before, after) = (if j == 0 { n - 1 } else { j - 1 }, if j + 1 == n { 0 } else { j + 1 });
            out[j] = diagonal[row] * here[j]
                + up[j] * (here[j] - above[j])
                + down[j] * (here[j] - below[j])
                + right[j] * (here[j] - here[after])
                + right[before] * (here[j] - here[before]);
        }
    });
}
