//! Viscosity of the film and its faces, implicit: vorticity spreads as `(1 - nu dt (lap + 2 / R^2)) z' = z`, and the
//! velocity follows it without any divergence. The mean flow around the axis takes the strain form
//! `d/dy (w^3 d/dy (u / w)) / w^2`, which leaves a turning sphere alone. Walls take no shear.

use rayon::prelude::*;

use crate::grid::Grid;
use crate::spectral::{Ends, Spectral, Task, Tridiagonal};

pub struct Viscosity {
    spectral: Spectral,
    corners: Vec<f64>,
}

impl Viscosity {
    pub fn new(grid: &Grid) -> Viscosity {
        let rows = grid.rows - 1;
        let ends = if grid.closes() { Ends::Closed } else { Ends::Odd };
        Viscosity { spectral: Spectral::new(grid.columns, rows, ends), corners: vec![0.0; rows * grid.columns] }
    }

    /// `spread` is nu dt by row, m2.
    pub fn step(&mut self, grid: &Grid, down: &mut [f64], across: &mut [f64], spread: &[f64]) {
        let n = grid.columns;
        // Vorticity at the corners between rows i and i + 1, right of column j.
        self.corners.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let (above, below) = (&across[i * n..(i + 1) * n], &across[(i + 1) * n..(i + 2) * n]);
            let v = &down[(i + 1) * n..(i + 2) * n];
            let (wide, wider, scale) = (grid.width[i], grid.width[i + 1], 1.0 / grid.corner_area[i + 1]);
            for j in 0..n {
                let right = v[if j + 1 == n { 0 } else { j + 1 }];
                out[j] = (wider * below[j] - wide * above[j] - grid.dy * (right - v[j])) * scale;
            }
            if !grid.closes() {
                // The film slips along its borders.
                out[n - 1] = 0.0;
            }
        });
        // The Laplacian on corners: above, below, and across for each wave.
        let rows = grid.rows - 1;
        let above: Vec<f64> = (0..rows).map(|i| grid.width[i] / (grid.dy * grid.corner_area[i + 1])).collect();
        let below: Vec<f64> = (0..rows).map(|i| grid.width[i + 1] / (grid.dy * grid.corner_area[i + 1])).collect();
        let across_of = |i: usize, turn: f64| grid.dy / (grid.side[i + 1] * grid.corner_area[i + 1]) * turn;
        let at_corner = |i: usize| (spread[i] + spread[i + 1]) / 2.0;
        let scaled = |values: &[f64]| values.iter().enumerate().map(|(i, value)| at_corner(i) * value).collect();
        let spreading = Tridiagonal::new(grid.period(), scaled(&above), scaled(&below), |i, turn| {
            1.0 + at_corner(i) * (above[i] + below[i] + across_of(i, turn) - 2.0 * grid.curvature)
        });
        // Minus the Laplacian, so that its stream function comes with the other sign.
        let (up, low) = (above.clone(), below.clone());
        let laplacian = Tridiagonal::new(grid.period(), up, low, |i, turn| above[i] + below[i] + across_of(i, turn));
        self.spectral.solve(&mut self.corners, &Task::SolveChange(&spreading, &laplacian), true);

        if grid.closes() {
            self.mean_flow(grid, across, spread);
        }

        // The stream function is zero at both ends: there no wave has a place, or no liquid passes.
        let stream = &self.corners;
        let zeros = vec![0.0; n];
        let line = |i: usize| if i == 0 || i == grid.rows { &zeros[..] } else { &stream[(i - 1) * n..i * n] };
        across.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let (above, below) = (line(i), line(i + 1));
            let scale = 1.0 / grid.dy;
            for j in 0..n {
                out[j] -= (below[j] - above[j]) * scale;
            }
        });
        down[n..grid.rows * n].par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let here = line(i + 1);
            let scale = 1.0 / grid.side[i + 1];
            for j in 0..n {
                let left = here[if j == 0 { n - 1 } else { j - 1 }];
                out[j] += (here[j] - left) * scale;
            }
        });
    }

    fn mean_flow(&self, grid: &Grid, across: &mut [f64], spread: &[f64]) {
        let (n, rows) = (grid.columns, grid.rows);
        let mean: Vec<f64> = across.chunks_exact(n).map(|row| row.iter().sum::<f64>() / n as f64).collect();
        // Sides at the ends bear no stress: their strain is zero.
        let stress = |i: usize| {
            if i == 0 || i == rows { 0.0 } else { grid.side[i].powi(3) / (grid.dy * grid.dy) }
        };
        let mut eliminated: Vec<(f64, f64)> = Vec::with_capacity(rows);
        for i in 0..rows {
            let w = grid.width[i];
            let rate = spread[i] / (w * w);
            let (above, below) = (rate * stress(i), rate * stress(i + 1));
            let diagonal = 1.0 + (above + below) / w;
            let (lower, upper) =
                (if i > 0 { above / grid.width[i - 1] } else { 0.0 }, below / grid.width[(i + 1).min(rows - 1)]);
            let (last_upper, last) = eliminated.last().copied().unwrap_or((0.0, 0.0));
            let pivot = 1.0 / (diagonal - lower * last_upper);
            eliminated.push((upper * pivot, (mean[i] + lower * last) * pivot));
        }
        let mut next = 0.0;
        for i in (0..rows).rev() {
            next = eliminated[i].1 + eliminated[i].0 * next;
            let change = next - mean[i];
            across[i * n..(i + 1) * n].iter_mut().for_each(|u| *u += change);
        }
    }
}
