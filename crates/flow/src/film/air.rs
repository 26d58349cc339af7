//! The air around a film: wind, and eddies that come and go.

use rayon::prelude::*;

use crate::chance::{self, Purpose, Wave};
use crate::grid::Grid;
use crate::grid::Shape;
use crate::parameters::Parameters;

/// Fields that eddies are made of, and waves in each.
const EDDY_FIELDS: u64 = 4;
const EDDY_WAVES: u64 = 12;

/// Velocity of the air at the upper and the right sides of cells.
pub fn air(wind: &[Vec<f64>; 2], eddies: &[([Vec<f64>; 2], f64, f64)], p: &Parameters, time: f64) -> [Vec<f64>; 2] {
    let mut out = [0, 1].map(|part| vec![0.0; wind[part].len()]);
    let blowing = if p.eddies > 0.0 { eddies } else { &[] };
    let heights: Vec<f64> = blowing.iter().map(|(_, rate, phase)| p.eddies * (rate * time + phase).cos()).collect();
    for (part, out) in out.iter_mut().enumerate() {
        // All that blows on a block of sides while it is in the cache.
        out.par_chunks_mut(4096).zip(wind[part].par_chunks(4096)).enumerate().for_each(|(block, (out, wind))| {
            out.copy_from_slice(wind);
            for ((field, ..), height) in blowing.iter().zip(&heights) {
                let field = &field[part][block * 4096..];
                wide!(out.iter_mut().zip(field).for_each(|(out, field)| *out += height * field));
            }
        });
    }
    out
}

/// A vector field at the sides of cells: its part down through the upper ones, across through the right ones.
pub fn at_sides(grid: &Grid, field: impl Fn([f64; 3]) -> [f64; 3] + Sync) -> [Vec<f64>; 2] {
    let n = grid.columns;
    let part = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let down = (0..grid.cells() + n)
        .into_par_iter()
        .map(|k| {
            let (i, j) = (k / n, k % n);
            let ([s, c], [sp, cp]) = (grid.polar_side[i], grid.azimuth[j]);
            let axis = if grid.is_plane() { [0.0, 0.0, -1.0] } else { [c * cp, c * sp, -s] };
            part(field(grid.place_above(i, j)), axis)
        })
        .collect();
    let across = (0..grid.cells())
        .into_par_iter()
        .map(|k| {
            let (i, j) = (k / n, k % n);
            let [sp, cp] = grid.azimuth_side[j];
            let axis = if grid.is_plane() { [1.0, 0.0, 0.0] } else { [-sp, cp, 0.0] };
            part(field(grid.place_right(i, j)), axis)
        })
        .collect();
    [down, across]
}

/// Wind along x that grows with height from none at the lowest place, as over ground. A wind alike at all heights would
/// press, not turn: along a sphere it is the slope of x, and the tension takes it up whole.
pub fn wind(grid: &Grid, p: &Parameters) -> [Vec<f64>; 2] {
    let (low, high) = match p.shape {
        Shape::Sphere { rim_deg, .. } => (rim_deg.to_radians().cos(), 1.0),
        Shape::Plane { height_m, .. } => (0.0, height_m),
    };
    at_sides(grid, |place| [p.wind * (place[2] - low) / (high - low), 0.0, 0.0])
}

/// Fields without divergence of mean square speed 1 / (half their number), each as n x grad of smooth noise.
pub fn eddies(grid: &Grid, p: &Parameters) -> Vec<([Vec<f64>; 2], f64, f64)> {
    if p.eddies == 0.0 {
        return Vec::new();
    }
    let size = match p.shape {
        Shape::Sphere { radius_m, .. } => radius_m,
        Shape::Plane { width_m, height_m, .. } => width_m.min(height_m) / 2.0,
    };
    (0..EDDY_FIELDS)
        .map(|k| {
            let mut draws = chance::Draws::new(p.seed, Purpose::Eddy, k);
            let seed = (draws.share() * 1e15) as u64;
            let waves: Vec<Wave> = chance::waves(grid, seed, Purpose::Eddy, EDDY_WAVES, size / 2.0, size / 5.0);
            let [down, across] = at_sides(grid, |x| {
                let g = chance::slope(&waves, x);
                if grid.is_plane() {
                    [g[2], 0.0, -g[0]]
                } else {
                    [x[1] * g[2] - x[2] * g[1], x[2] * g[0] - x[0] * g[2], x[0] * g[1] - x[1] * g[0]]
                }
            });
            let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
            let scale = (2.0 / EDDY_FIELDS as f64 / (square(&down) + square(&across))).sqrt();
            let scaled = |values: Vec<f64>| values.into_iter().map(|v| v * scale).collect();
            // Eddies turn over in about a second.
            let rate = std::f64::consts::TAU * (0.3 + draws.share());
            ([scaled(down), scaled(across)], rate, std::f64::consts::TAU * draws.share())
        })
        .collect()
}
