//! The laws that a flowing film must obey, each against what it should be. `docs/guide/living-films.md` tabulates what
//! `cargo test -p iridesce-flow laws -- --nocapture` prints.

mod ageing;
mod borders;
mod kernels;
mod motion;
mod share;
mod sources;

use crate::film::{Film, State};
use crate::grid::{Grid, Shape, Sides};
use crate::parameters::Parameters;

/// A film that nothing acts on: neither weight nor air nor friction nor losses.
fn bare(shape: Shape, columns: usize, rows: usize) -> Parameters {
    Parameters {
        shape,
        columns,
        rows,
        step_s: 5e-3,
        thickness_m: 1e-6,
        noise: 0.0,
        gravity: 0.0,
        viscosity: 1e-15,
        surface_viscosity: 0.0,
        elasticity: f64::INFINITY,
        air_density: 0.0,
        air_mass: 0.0,
        evaporation: 0.0,
        drains_inside: false,
        regeneration: 0.0,
        black_below_m: 0.0,
        black_m: 0.0,
        rupture_m: 0.0,
        tolerance: 1e-8,
        wind: 0.0,
        eddies: 0.0,
        ..Parameters::preset("bubble-on-bath").expect("a preset")
    }
}

const BUBBLE: Shape = Shape::Sphere { radius_m: 0.025, rim_deg: 180.0 };

/// A film whose start is changed.
fn film(parameters: Parameters, change: impl FnOnce(&Grid, &mut State)) -> Film {
    let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
    let mut state = Film::new(parameters.clone()).expect("parameters that are possible").state().clone();
    change(&grid, &mut state);
    Film::from_state(parameters, state)
}

/// On one thread of a pool of its own: from outside, each pass of each short step would wait for the pool to wake.
fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread").install(work)
}

/// Velocity from a stream function of the polar angle and the azimuth (or height and x), at corners: no divergence.
fn stream(grid: &Grid, state: &mut State, psi: impl Fn(f64, f64) -> f64) {
    let n = grid.columns;
    let at = |i: usize, j: usize| match grid.shape {
        Shape::Sphere { radius_m, .. } => {
            psi(i as f64 * grid.dy / radius_m, (j as f64 + 1.0) / n as f64 * std::f64::consts::TAU)
        }
        Shape::Plane { height_m, .. } => psi(height_m - i as f64 * grid.dy, (j as f64 + 1.0) * grid.width[0]),
    };
    for i in 0..grid.rows {
        for j in 0..n {
            state.across[i * n + j] = (at(i + 1, j) - at(i, j)) / grid.dy;
            if i > 0 {
                state.down[i * n + j] = -(at(i, j) - at(i, (j + n - 1) % n)) / grid.side[i];
            }
        }
    }
    super::film::fill_poles(grid, &mut state.down);
}

/// Cosine and sine part of the velocity across, of wave `m`, in a row.
fn wave(grid: &Grid, across: &[f64], row: usize, m: usize) -> (f64, f64) {
    let n = grid.columns;
    let (mut a, mut b) = (0.0, 0.0);
    for j in 0..n {
        let (sin, cos) = ((m * (j + 1)) as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
        a += across[row * n + j] * cos * 2.0 / n as f64;
        b += across[row * n + j] * sin * 2.0 / n as f64;
    }
    (a, b)
}

/// What went wrong by halving the cells, as a power of the cell.
fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}
