//! What thins a film or moves its spots: evaporation, black film, liquid between the faces.

use rayon::prelude::*;

use super::black::Turning;
use super::rows::{thin_mixed_row, thin_row};
use super::state::State;
use crate::events::Spot;
use crate::grid::{Edge, Grid};
use crate::parameters::Parameters;

/// A film that begins with film as thin as black film has black film there.
pub fn find_black(p: &Parameters, state: &mut State) {
    let black_m = p.black_film_m();
    if p.black_below_m > 0.0 && state.black.is_empty() && state.h.iter().any(|&h| h <= black_m) {
        state.black = state.h.iter().map(|&h| f64::from(u8::from(h <= black_m))).collect();
    }
}

/// Evaporation, down to black film; thin film turns black. Returns what went either way, m3.
pub fn thin(grid: &Grid, p: &Parameters, h: &mut [f64], share: &mut Vec<f64>, dt: f64) -> (f64, f64) {
    let (loss, kept) = (p.speed * p.evaporation * dt, (-dt * p.speed / p.black_s).exp());
    let turning = (p.salt > 0.0).then(|| Turning::new(p, dt));
    let below = p.black_below_m;
    if share.is_empty() && h.par_chunks(4096).any(|part| wide!(part.iter().any(|&h| h - loss < below))) {
        share.resize(h.len(), 0.0);
    }
    let n = grid.columns;
    let rows: Vec<(f64, f64)> = if share.is_empty() {
        h.par_chunks_exact_mut(n)
            .with_min_len(8)
            .map(|row| match &turning {
                Some(turning) => turning.thin_row(row, loss),
                None => wide!(thin_row(row, loss, kept, [p.black_m, below])),
            })
            .collect()
    } else {
        h.par_chunks_exact_mut(n)
            .zip(share.par_chunks_exact_mut(n))
            .with_min_len(8)
            .map(|(row, share)| match &turning {
                Some(turning) => turning.thin_mixed_row(row, share, loss),
                None => wide!(thin_mixed_row(row, share, loss, kept, [p.black_m, below])),
            })
            .collect()
    };
    rows.iter().zip(&grid.area).fold((0.0, 0.0), |(a, b), ((dry, black), area)| (a + dry * area, b + black * area))
}

/// Liquid that runs down between faces that stand still, `rho g h^3 / (12 mu)` per length, upwind. Returns what leaves
/// at the lower wall, m3.
pub fn drain_inside(grid: &Grid, p: &Parameters, h: &mut [f64], dt: f64) -> f64 {
    let n = grid.columns;
    let strength = p.speed * p.density * p.weight() / (12.0 * p.viscosity);
    let thickest = h
        .par_chunks(4096)
        .map(|part| wide!(part.iter().fold(0.0, |a: f64, &b| if b > a { b } else { a })))
        .reduce(|| 0.0, f64::max);
    // A wave of thickness moves at three times the mean speed; it must not pass half a cell.
    let count = (3.0 * strength * thickest * thickest * dt / grid.dy / 0.5).ceil().clamp(1.0, 1e6);
    let mut drained = 0.0;
    for _ in 0..count as usize {
        let mut above = vec![0.0; n];
        for i in 0..grid.rows {
            let slope = match (i + 1 < grid.rows, grid.bottom) {
                (true, _) => (grid.height[i] - grid.height[i + 1]) / grid.dy,
                // The rim of a dome or plane: as steep as there.
                (false, Edge::Wall) => grid.polar_side[grid.rows][0],
                (false, Edge::Pole) => 0.0,
            };
            let scale = strength * slope * grid.side[i + 1] * dt / count;
            let area = grid.area[i];
            for (cell, above) in h[i * n..(i + 1) * n].iter_mut().zip(&mut above) {
                let leaving = scale * cell.powi(3);
                *cell += (*above - leaving) / area;
                *above = leaving;
            }
        }
        drained += above.iter().sum::<f64>();
    }
    drained
}

/// Black spots are carried along.
pub fn move_spots(grid: &Grid, spots: &mut [Spot], down: &[f64], across: &[f64], dt: f64) {
    let n = grid.columns;
    for spot in spots {
        let x = spot.place;
        let (row, column, s, turn) = if grid.is_plane() {
            let height = grid.height[0] + grid.dy / 2.0;
            ((height - x[2]) / grid.dy, x[0] / grid.width[0], 1.0, [0.0, 1.0])
        } else {
            let s = x[0].hypot(x[1]);
            let azimuth = x[1].atan2(x[0]);
            (
                s.atan2(x[2]) * grid.radius / grid.dy,
                azimuth / std::f64::consts::TAU * n as f64,
                s,
                [azimuth.sin(), azimuth.cos()],
            )
        };
        let i = (row.max(0.0) as usize).min(grid.rows - 1);
        let j = column.floor() as isize;
        let j = if grid.closes() { j.rem_euclid(n as isize) } else { j.clamp(0, n as isize - 1) } as usize;
        let v = (down[i * n + j] + down[(i + 1) * n + j]) / 2.0 * dt / grid.radius;
        let u = (across[i * n + j] + across[i * n + (j + n - 1) % n]) / 2.0 * dt / grid.radius;
        let [sin, cos] = turn;
        spot.place = if grid.is_plane() {
            let width = grid.width[0] * n as f64;
            let x = x[0] + u;
            [if grid.closes() { x.rem_euclid(width) } else { x.clamp(0.0, width) }, 0.0, spot.place[2] - v]
        } else {
            let y = [x[0] + v * x[2] * cos - u * sin, x[1] + v * x[2] * sin + u * cos, x[2] - v * s];
            let scale = 1.0 / y.iter().map(|y| y * y).sum::<f64>().sqrt();
            y.map(|y| y * scale)
        };
    }
}
