//! What pushes a film: gravity, the drag of the air, the tension, viscosity.

use rayon::prelude::*;

use super::rows::{Pushed, drag_of, gathering, pull, push_row, sum};
use super::state::State;
use crate::grid::{Edge, Grid};
use crate::parameters::Parameters;
use crate::tension::Tension;

/// Drag of the air on both faces at the middles of cells, kg/(m2 s): `2 rho_a sqrt(nu_a U / L)`.
pub fn drag(grid: &Grid, p: &Parameters, down: &[f64], across: &[f64]) -> Vec<f64> {
    let n = grid.columns;
    let mut out = vec![0.0; grid.cells()];
    out.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
        let sides = [&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]];
        let stress = 2.0 * p.air_density * (p.air_viscosity / p.air_length_m).sqrt();
        wide!(drag_of(sides, &across[i * n..(i + 1) * n], stress, p.air_speed, out));
    });
    out
}

/// Gravity and air; also the weights of the tension.
pub fn push(
    grid: &Grid,
    p: &Parameters,
    state: &mut State,
    drag: &[f64],
    air: &[Vec<f64>; 2],
    [time, dt]: [f64; 2],
    tension: &mut Tension,
) {
    let [shaken, coming] = if p.shake > 0.0 { p.shaken(time, dt) } else { [0.0; 2] };
    let n = grid.columns;
    let h = &state.h;
    tension.up.par_chunks_exact_mut(n).zip(state.down.par_chunks_exact_mut(n)).enumerate().with_min_len(8).for_each(
        |(i, (up, down))| {
            if i == 0 || i == grid.rows {
                up.fill(0.0);
                return;
            }
            // From the heights themselves, so that a film of one thickness stays at rest to the last digit.
            let slope = (grid.height[i - 1] - grid.height[i]) / grid.dy;
            let gravity = (p.weight() + shaken) * slope;
            let (a, b) = ((i - 1) * n..i * n, i * n..(i + 1) * n);
            let pushed = Pushed {
                density: p.density,
                air_mass: p.air_mass,
                dt,
                gravity,
                coming: coming * slope,
                coupling: grid.side[i] / grid.dy,
            };
            let (h, drag) = ([&h[a.clone()], &h[b.clone()]], [&drag[a], &drag[b.clone()]]);
            wide!(push_row(&pushed, h, drag, &air[0][b], down, up));
        },
    );
    tension
        .right
        .par_chunks_exact_mut(n)
        .zip(state.across.par_chunks_exact_mut(n))
        .enumerate()
        .with_min_len(8)
        .for_each(|(i, (right, across))| {
            let row = i * n..(i + 1) * n;
            let coupling = grid.dy / grid.width[i];
            let pushed = Pushed { density: p.density, air_mass: p.air_mass, dt, gravity: 0.0, coming: 0.0, coupling };
            let (h, drag, air) = (&h[row.clone()], &drag[row.clone()], &air[1][row]);
            // All but the last, whose neighbour is the first, or a border that nothing passes.
            let m = n - 1;
            wide!(push_row(
                &pushed,
                [&h[..m], &h[1..]],
                [&drag[..m], &drag[1..]],
                &air[..m],
                &mut across[..m],
                &mut right[..m]
            ));
            if !grid.closes() {
                (across[m], right[m]) = (0.0, 0.0);
                return;
            }
            let last = |values: &[f64]| [values[m], values[0]];
            let ([a, b], [c, d]) = (last(h), last(drag));
            push_row(&pushed, [&[a], &[b]], [&[c], &[d]], &air[m..], &mut across[m..], &mut right[m..]);
        });
}

/// What the tension must answer for: `stiffness s` less what leaves each cell.
pub fn gathered(grid: &Grid, state: &State, stiff: bool, dt: f64) -> Vec<f64> {
    let n = grid.columns;
    let mut right_side = vec![0.0; grid.cells()];
    let (down, across, s) = (&state.down, &state.across, &state.s);
    right_side.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
        let sides = [&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]];
        let weight = if stiff { grid.area[i] / dt } else { 0.0 };
        let lengths = [grid.side[i], grid.side[i + 1], grid.dy];
        wide!(gathering(sides, &across[i * n..(i + 1) * n], lengths, &s[i * n..(i + 1) * n], weight, out));
    });
    right_side
}

/// The tension pulls.
pub fn pulled(grid: &Grid, state: &mut State, tension: &Tension) {
    let n = grid.columns;
    let q = &state.q;
    let (up, right) = (&tension.up, &tension.right);
    state.down[n..grid.rows * n].par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
        let i = i + 1;
        let (above, here) = (&q[(i - 1) * n..i * n], &q[i * n..(i + 1) * n]);
        wide!(pull(out, above, here, &up[i * n..(i + 1) * n], 1.0 / grid.side[i]));
    });
    state.across.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
        let (here, right) = (&q[i * n..(i + 1) * n], &right[i * n..(i + 1) * n]);
        let scale = 1.0 / grid.dy;
        wide!(pull(&mut out[..n - 1], &here[..n - 1], &here[1..], &right[..n - 1], scale));
        out[n - 1] -= (here[0] - here[n - 1]) * right[n - 1] * scale;
    });
}

/// How far viscosity spreads the velocity of each row in a step, m2.
pub fn viscous_spread(grid: &Grid, p: &Parameters, h: &[f64], dt: f64) -> Vec<f64> {
    let n = grid.columns;
    h.par_chunks_exact(n)
        .with_min_len(16)
        .map(|row| {
            let h = wide!(sum(row)) / n as f64;
            dt * (p.viscosity * h + 2.0 * p.surface_viscosity) / (p.density * h + p.air_mass)
        })
        .collect()
}

/// At a pole the sides of cells have no length, but what flows over it is felt: the velocity of the nearest row.
pub fn fill_poles(grid: &Grid, down: &mut [f64]) {
    let n = grid.columns;
    for (edge, pole, nearest) in [(grid.top, 0, 1), (grid.bottom, grid.rows, grid.rows - 1)] {
        if edge == Edge::Wall {
            down[pole * n..(pole + 1) * n].fill(0.0);
            continue;
        }
        let (mut a, mut b) = (0.0, 0.0);
        for j in 0..n {
            let [sin, cos] = grid.azimuth[j];
            a += down[nearest * n + j] * cos * 2.0 / n as f64;
            b += down[nearest * n + j] * sin * 2.0 / n as f64;
        }
        for j in 0..n {
            let [sin, cos] = grid.azimuth[j];
            down[pole * n + j] = a * cos + b * sin;
        }
    }
}
