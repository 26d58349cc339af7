//! A film in time.

use iridesce_numerics::Watch;
use iridesce_thickness::{ThicknessError, ThicknessMap};
use rayon::prelude::*;

use crate::carry::Carry;
use crate::chance::{self, Purpose, Wave};
use crate::events::{self, Clock, Spot};
use crate::grid::{Edge, Grid, Shape};
use crate::parameters::Parameters;
use crate::spectral::{Spectral, Task, Tridiagonal};
use crate::tension::Tension;
use crate::transport::{MOST_SUBSTEPS, Transport};
use crate::viscosity::Viscosity;

mod live;

/// Why a run cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// A number stopped being one.
    #[error("{field} is {value} at step {step}, {time_s} s, row {row}, column {column}; a shorter step_s may help")]
    NotFinite {
        /// Which field.
        field: &'static str,
        /// What it is.
        value: f64,
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        column: usize,
    },
    /// The film moves so fast that a step would need too many sub-steps.
    #[error(
        "step_s, {dt} s, is too long at step {step}, {time_s} s: {needed} sub-steps would be needed, {most} are allowed"
    )]
    StepTooLong {
        /// Step, s.
        dt: f64,
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
        /// Sub-steps that it would take.
        needed: f64,
        /// Most of them.
        most: f64,
    },
    /// The tension was not found.
    #[error(
        "the tension of the film is not found at step {step}, {time_s} s; a shorter step_s or a larger air_mass may help"
    )]
    Tension {
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
    },
    /// A parameter is not possible.
    #[error(transparent)]
    Parameter(#[from] ThicknessError),
    /// Whoever watches said so.
    #[error("the film was stopped")]
    Stopped,
    /// A checkpoint cannot be used.
    #[error("the checkpoint {0}")]
    Checkpoint(String),
}

/// Where liquid went, m3. Together with the film's own volume it stays what it was at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Books {
    /// Film at the start.
    pub start: f64,
    /// Into the air.
    pub evaporated: f64,
    /// Into the meniscus, by marginal regeneration.
    pub swallowed: f64,
    /// Out of film that turned black.
    pub blackened: f64,
    /// Down between the faces, out at the rim.
    pub drained: f64,
}

impl Books {
    /// All that left the film, m3.
    pub fn gone(&self) -> f64 {
        self.evaporated + self.swallowed + self.blackened + self.drained
    }
}

/// All that changes in time; see [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Thickness at the middles of cells, m.
    pub h: Vec<f64>,
    /// ln(Gamma / Gamma_0) of the surfactant, at the middles of cells.
    pub s: Vec<f64>,
    /// Velocity down through the upper sides of cells, one row more, m/s.
    pub down: Vec<f64>,
    /// Velocity across through the right sides of cells, m/s.
    pub across: Vec<f64>,
    /// Last solution of the tension.
    pub(super) q: Vec<f64>,
    /// Steps so far.
    pub step: u64,
    /// Time, s.
    pub time_s: f64,
    /// Where liquid went.
    pub books: Books,
    /// Surfactant in all, in areas at Gamma_0, m2.
    pub(super) surfactant: f64,
    pub(super) patch_clock: Clock,
    pub(super) spot_clock: Clock,
    pub(super) patches: Vec<Spot>,
    pub(super) spots: Vec<Spot>,
    /// When the film burst, s.
    pub ruptured_s: Option<f64>,
}

/// A film of liquid that flows. All numbers are f64 and do not depend on the number of threads.
///
/// ```
/// use iridesce_flow::{Film, Parameters};
/// let mut parameters = Parameters::preset("late")?.with_columns(64);
/// parameters.regeneration = 0.0; // 64 columns are too coarse for patches
/// let mut film = Film::new(parameters)?;
/// film.advance_to(0.02)?;
/// assert_eq!(film.state().step, 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Film {
    parameters: Parameters,
    grid: Grid,
    state: State,
    carry: Carry,
    transport: Transport,
    tension: Tension,
    viscosity: Viscosity,
    diffusion: Spectral,
    /// Wind, on upper and right sides, m/s.
    wind: [Vec<f64>; 2],
    /// Eddies: fields that come and go at rates of their own, rad/s, from phases of their own.
    eddies: Vec<([Vec<f64>; 2], f64, f64)>,
    /// Sub-steps of the last step.
    substeps: usize,
    /// Iterations of the last step.
    iterations: usize,
    /// Time that parts of all steps took so far, s.
    clock: Option<fn() -> f64>,
    spent: [f64; PARTS.len()],
}

/// Parts of a step whose time is told apart.
const PARTS: [&str; 6] = ["thickness", "sources", "trace and carry", "forces", "tension", "viscosity"];

/// Waves in the thickness at the start.
const NOISE_WAVES: u64 = 240;
/// Fields that eddies are made of, and waves in each.
const EDDY_FIELDS: u64 = 4;
const EDDY_WAVES: u64 = 12;

/// Tells the times of parts of a step apart, where somebody gave a clock: a film in a browser has none.
struct Stopwatch {
    clock: Option<fn() -> f64>,
    last_s: f64,
}

impl Stopwatch {
    fn new(clock: Option<fn() -> f64>) -> Stopwatch {
        Stopwatch { clock, last_s: clock.map_or(0.0, |clock| clock()) }
    }

    fn lap(&mut self, place: &mut f64) {
        if let Some(clock) = self.clock {
            let now_s = clock();
            *place += now_s - self.last_s;
            self.last_s = now_s;
        }
    }
}

impl Film {
    /// A film at rest, with its thickness drawn by chance and its surfactant in balance with its mean weight.
    pub fn new(parameters: Parameters) -> Result<Film, ThicknessError> {
        parameters.check()?;
        let p = &parameters;
        let grid = Grid::new(p.shape, p.columns, p.rows);
        let longest = p.noise_length_m[0];
        let noise = chance::waves(&grid, p.seed, Purpose::Thickness, NOISE_WAVES, longest, p.noise_length_m[1]);
        let mut h = at_cells(&grid, |place| chance::sum(&noise, place));
        // Exactly the mean and the spread that were asked for, and nowhere less than a fifth of the mean.
        let area = grid.total_area();
        let mean = grid.integral(&h) / area;
        let squares: Vec<f64> = h.iter().map(|x| (x - mean).powi(2)).collect();
        let spread = (grid.integral(&squares) / area).sqrt().max(1e-12);
        h.iter_mut().for_each(|x| *x = p.thickness_m * (1.0 + p.noise * (*x - mean) / spread).max(0.2));
        let scale = p.thickness_m / (grid.integral(&h) / area);
        h.iter_mut().for_each(|x| *x *= scale);
        let weight = if p.elasticity.is_finite() { p.density * p.weight() * p.thickness_m / p.elasticity } else { 0.0 };
        let mean_height = grid.height.iter().zip(&grid.area).map(|(z, a)| z * a).sum::<f64>() * p.columns as f64 / area;
        let s = (0..grid.cells()).map(|k| -weight * (grid.height[k / p.columns] - mean_height)).collect();
        let cells = grid.cells();
        let state = State {
            h,
            s,
            down: vec![0.0; cells + p.columns],
            across: vec![0.0; cells],
            q: vec![0.0; cells],
            step: 0,
            time_s: 0.0,
            books: Books::default(),
            surfactant: 0.0,
            patch_clock: Clock::new(p.seed, Purpose::Patch),
            spot_clock: Clock::new(p.seed, Purpose::Spot),
            patches: Vec::new(),
            spots: Vec::new(),
            ruptured_s: None,
        };
        Ok(Film::from_state(parameters, state))
    }

    /// A film as it is at some time; its liquid and its surfactant are counted afresh if this is its start.
    pub(super) fn from_state(parameters: Parameters, mut state: State) -> Film {
        let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
        if state.step == 0 {
            state.books = Books { start: grid.integral(&state.h), ..Books::default() };
            state.surfactant = surfactant(&grid, &state.s);
        }
        let (wind, eddies) = (wind(&grid, &parameters), eddies(&grid, &parameters));
        Film {
            carry: Carry::new(&grid),
            transport: Transport::new(&grid),
            tension: Tension::new(&grid),
            viscosity: Viscosity::new(&grid),
            diffusion: Spectral::new(grid.columns, grid.rows),
            wind,
            eddies,
            substeps: 0,
            iterations: 0,
            clock: None,
            spent: [0.0; PARTS.len()],
            parameters,
            grid,
            state,
        }
    }

    /// What it is made of.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// How it is now.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Sub-steps of transport and iterations of the tension in the last step.
    pub fn effort(&self) -> (usize, usize) {
        (self.substeps, self.iterations)
    }

    /// Has the parts of each step timed by a clock that shows seconds.
    #[doc(hidden)]
    pub fn time_with(&mut self, clock: fn() -> f64) {
        self.clock = Some(clock);
    }

    /// What all steps so far took, part by part, s; zero unless a clock was given.
    #[doc(hidden)]
    pub fn spent(&self) -> [(&'static str, f64); PARTS.len()] {
        std::array::from_fn(|k| (PARTS[k], self.spent[k]))
    }

    /// Volume of the film, m3.
    pub fn volume(&self) -> f64 {
        self.grid.integral(&self.state.h)
    }

    /// Thickness now, nm, row 0 on top.
    pub fn thickness_nm(&self) -> Vec<f64> {
        self.state.h.iter().map(|h| h * 1e9).collect()
    }

    /// Thickness now as a map for a whole sphere: a dome is mirrored below its rim, as in the bath it stands on.
    pub fn map(&self) -> Result<ThicknessMap, ThicknessError> {
        let own = self.thickness_nm();
        let (n, rows) = (self.grid.columns, self.grid.rows);
        let Shape::Sphere { rim_deg, .. } = self.parameters.shape else {
            return ThicknessMap::new(n, rows, own);
        };
        if rim_deg == 180.0 {
            return ThicknessMap::new(n, rows, own);
        }
        let total = (rows as f64 * 180.0 / rim_deg).round() as usize;
        let row = |i: usize| if i < rows { i } else { (2 * rows - 1).saturating_sub(i) };
        let values = (0..total).flat_map(|i| own[row(i) * n..(row(i) + 1) * n].iter().copied()).collect();
        ThicknessMap::new(n, total, values)
    }

    /// Steps until `time_s`, in steps of one length that is at most the parameters' own; less if the film bursts.
    pub fn advance_to(&mut self, time_s: f64) -> Result<(), FlowError> {
        self.advance_watched(time_s, &Watch::new())
    }

    /// The same; `watch` hears of every step, in the stage `flowing`. Stopped, the film stands after some whole step.
    pub fn advance_watched(&mut self, time_s: f64, watch: &Watch) -> Result<(), FlowError> {
        let start = self.state.time_s;
        if !(time_s.is_finite() && time_s >= start) {
            let message = format!("must be a finite time, at least the film's own, {start:?} s, got {time_s:?}");
            return Err(FlowError::Parameter(ThicknessError { key: "time_s", message }));
        }
        let count = ((time_s - start) / self.parameters.step_s - 1e-9).ceil().max(0.0) as u64;
        watch.begin("flowing", count);
        for k in 0..count {
            if self.state.ruptured_s.is_some() {
                return Ok(());
            }
            watch.check().map_err(|_| FlowError::Stopped)?;
            let dt = (time_s - start) / count as f64;
            self.step(dt)?;
            self.state.time_s = if k + 1 == count { time_s } else { start + (k + 1) as f64 * dt };
            watch.add(1);
        }
        Ok(())
    }

    fn step(&mut self, dt: f64) -> Result<(), FlowError> {
        let time = self.state.time_s;
        let step = self.state.step + 1;
        let mut watch = Stopwatch::new(self.clock);
        let Film { parameters: p, grid, state, carry, transport, tension, viscosity, .. } = self;
        let n = grid.columns;
        fill_poles(grid, &mut state.down);

        // Where it flows, liquid goes with it.
        let needed = Transport::substeps(grid, &state.down, &state.across, dt);
        if needed.is_nan() {
            return Err(self.first_not_finite(step));
        }
        if needed > MOST_SUBSTEPS {
            return Err(FlowError::StepTooLong { dt, step, time_s: time, needed, most: MOST_SUBSTEPS });
        }
        for _ in 0..needed as usize {
            transport.step(grid, &mut state.h, &state.down, &state.across, dt / needed);
        }
        self.substeps = needed as usize;
        watch.lap(&mut self.spent[0]);

        // Gains and losses.
        let books = &mut state.books;
        books.swallowed +=
            events::regenerate(grid, p, &mut state.patch_clock, &mut state.patches, &mut state.h, time, dt);
        move_spots(grid, &mut state.spots, &state.down, &state.across, dt);
        books.blackened += events::open_spots(grid, p, &mut state.spot_clock, &mut state.spots, &mut state.h, time, dt);
        let (evaporated, blackened) = thin(grid, p, &mut state.h, dt);
        books.evaporated += evaporated;
        books.blackened += blackened;
        if p.drains_inside {
            books.drained += drain_inside(grid, p, &mut state.h, dt);
        }

        watch.lap(&mut self.spent[1]);

        // Velocity and surfactant are carried, pushed, and held together by the tension.
        carry.trace(grid, &state.down, &state.across, dt);
        let drag = drag(grid, p, &state.down, &state.across);
        carry.velocity(grid, &mut state.down, &mut state.across);
        let finite = p.elasticity.is_finite();
        if finite {
            carry.scalar(grid, &mut state.s);
        }
        watch.lap(&mut self.spent[2]);
        let air = air(&self.wind, &self.eddies, p, time + dt);
        push(grid, p, state, &drag, &air, [time, dt], tension);
        let mut right_side = vec![0.0; grid.cells()];
        let (down, across, s) = (&state.down, &state.across, &state.s);
        right_side.par_chunks_exact_mut(n).enumerate().with_min_len(8).for_each(|(i, out)| {
            let sides = [&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]];
            let weight = if finite { grid.area[i] / dt } else { 0.0 };
            let lengths = [grid.side[i], grid.side[i + 1], grid.dy];
            wide!(gathering(sides, &across[i * n..(i + 1) * n], lengths, &s[i * n..(i + 1) * n], weight, out));
        });
        let stiffness = if finite { 1.0 / (dt * dt * p.elasticity) } else { 0.0 };
        let diagonal: Vec<f64> = grid.area.iter().map(|area| area * stiffness).collect();
        watch.lap(&mut self.spent[3]);
        let solved = tension.solve(grid, &mut state.q, &diagonal, &mut right_side, p.tolerance);
        let Some(iterations) = solved else {
            return Err(self.first_failure(step));
        };
        self.iterations = iterations;
        watch.lap(&mut self.spent[4]);
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
        let spread: Vec<f64> = state
            .h
            .par_chunks_exact(n)
            .with_min_len(16)
            .map(|row| {
                let h = wide!(sum(row)) / n as f64;
                dt * (p.viscosity * h + 2.0 * p.surface_viscosity) / (p.density * h + p.air_mass)
            })
            .collect();
        watch.lap(&mut self.spent[3]);
        viscosity.step(grid, &mut state.down, &mut state.across, &spread);
        watch.lap(&mut self.spent[5]);
        if finite {
            let scale = 1.0 / (dt * p.elasticity);
            state.s.par_iter_mut().with_min_len(4096).zip(&state.q).for_each(|(s, q)| *s = q * scale);
            self.exchange(dt);
        }
        self.state.step = step;
        self.check(step)?;
        if self.parameters.rupture_m > 0.0 && self.state.h.iter().any(|&h| h <= self.parameters.rupture_m) {
            self.state.ruptured_s = Some(time + dt);
        }
        watch.lap(&mut self.spent[3]);
        Ok(())
    }

    /// Surfactant: none is lost on its way (a change of all of s alike, which pulls nothing); it diffuses; it comes and
    /// goes between the faces and the liquid.
    fn exchange(&mut self, dt: f64) {
        let Film { parameters: p, grid, state, .. } = self;
        let correction = (state.surfactant / surfactant(grid, &state.s)).ln();
        state.s.par_iter_mut().with_min_len(4096).for_each(|s| *s += correction);
        if p.surfactant_diffusivity > 0.0 {
            let n = grid.columns;
            let spread = dt * p.surfactant_diffusivity;
            let part = |i: usize| if i == 0 || i == grid.rows { 0.0 } else { spread * grid.side[i] / grid.dy };
            let above: Vec<f64> = (0..grid.rows).map(part).collect();
            let below: Vec<f64> = (0..grid.rows).map(|i| part(i + 1)).collect();
            let system = Tridiagonal::new(n, above, below, |i, turn| {
                grid.area[i] + part(i) + part(i + 1) + spread * grid.dy / grid.width[i] * turn
            });
            let mut amount: Vec<f64> = state.s.iter().enumerate().map(|(k, s)| s.exp() * grid.area[k / n]).collect();
            self.diffusion.solve(&mut amount, &Task::Solve(&system), false);
            state.s.iter_mut().zip(&amount).for_each(|(s, gamma)| *s = gamma.ln());
        }
        if p.surfactant_exchange_s.is_finite() {
            let kept = (-dt / p.surfactant_exchange_s).exp();
            state.s.iter_mut().for_each(|s| *s = (1.0 + (s.exp() - 1.0) * kept).ln());
            state.surfactant = surfactant(grid, &state.s);
        }
    }

    /// Surfactant in all, in areas at Gamma_0, m2.
    pub fn surfactant(&self) -> f64 {
        surfactant(&self.grid, &self.state.s)
    }

    fn check(&self, step: u64) -> Result<(), FlowError> {
        let state = &self.state;
        // Nothing times a number is nothing, unless the number is none.
        let whole = |values: &[f64]| values.par_chunks(4096).all(|part| wide!(none(part)) == 0.0);
        let fine = whole(&state.h) && whole(&state.down) && whole(&state.across) && whole(&state.s);
        if fine { Ok(()) } else { Err(self.first_not_finite(step)) }
    }

    fn first_not_finite(&self, step: u64) -> FlowError {
        let state = &self.state;
        let fields = [
            ("the thickness", &state.h),
            ("the velocity down", &state.down),
            ("the velocity across", &state.across),
            ("the surfactant", &state.s),
        ];
        for (field, values) in fields {
            if let Some(k) = values.iter().position(|v| !v.is_finite()) {
                let (row, column) = (k / self.grid.columns, k % self.grid.columns);
                return FlowError::NotFinite { field, value: values[k], step, time_s: state.time_s, row, column };
            }
        }
        FlowError::Tension { step, time_s: state.time_s }
    }

    fn first_failure(&self, step: u64) -> FlowError {
        self.first_not_finite(step)
    }
}

fn surfactant(grid: &Grid, s: &[f64]) -> f64 {
    let rows: Vec<f64> =
        s.par_chunks_exact(grid.columns).with_min_len(8).map(|row| row.iter().map(|s| s.exp()).sum()).collect();
    rows.iter().zip(&grid.area).map(|(sum, area)| sum * area).sum()
}

fn at_cells(grid: &Grid, value: impl Fn([f64; 3]) -> f64 + Sync) -> Vec<f64> {
    let n = grid.columns;
    (0..grid.cells()).into_par_iter().map(|k| value(grid.place(k / n, k % n))).collect()
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

/// Drag of the air on both faces at the middles of cells, kg/(m2 s): `2 rho_a sqrt(nu_a U / L)`.
fn drag(grid: &Grid, p: &Parameters, down: &[f64], across: &[f64]) -> Vec<f64> {
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
fn push(
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
            // All but the last, whose neighbour is the first.
            let m = n - 1;
            wide!(push_row(
                &pushed,
                [&h[..m], &h[1..]],
                [&drag[..m], &drag[1..]],
                &air[..m],
                &mut across[..m],
                &mut right[..m]
            ));
            let last = |values: &[f64]| [values[m], values[0]];
            let ([a, b], [c, d]) = (last(h), last(drag));
            push_row(&pushed, [&[a], &[b]], [&[c], &[d]], &air[m..], &mut across[m..], &mut right[m..]);
        });
}

/// What pushes a row of sides.
struct Pushed {
    density: f64,
    air_mass: f64,
    dt: f64,
    gravity: f64,
    /// Air that comes down upon a frame that is shaken, m/s.
    coming: f64,
    coupling: f64,
}

#[inline(always)]
fn push_row(p: &Pushed, h: [&[f64]; 2], drag: [&[f64]; 2], air: &[f64], u: &mut [f64], inverse: &mut [f64]) {
    let n = u.len();
    let ([a, b], [c, d], air) = (h.map(|h| &h[..n]), drag.map(|drag| &drag[..n]), &air[..n]);
    let inverse = &mut inverse[..n];
    for j in 0..n {
        let weight = p.density * (a[j] + b[j]) * 0.5;
        let (mass, c) = (weight + p.air_mass, (c[j] + d[j]) * 0.5);
        let one = 1.0 / (mass + p.dt * c);
        u[j] = (mass * u[j] + p.dt * (weight * p.gravity + c * (air[j] + p.coming))) * one;
        inverse[j] = p.coupling * one;
    }
}

/// `weight s` less what leaves each cell of a row; lengths of the upper, the lower and the right side.
#[inline(always)]
fn gathering(sides: [&[f64]; 2], right: &[f64], lengths: [f64; 3], s: &[f64], weight: f64, out: &mut [f64]) {
    let n = out.len();
    let ([above, below], right, s) = (sides.map(|side| &side[..n]), &right[..n], &s[..n]);
    let [upper, lower, high] = lengths;
    out[0] = weight * s[0] - (lower * below[0] - upper * above[0] + high * (right[0] - right[n - 1]));
    for j in 1..n {
        out[j] = weight * s[j] - (lower * below[j] - upper * above[j] + high * (right[j] - right[j - 1]));
    }
}

#[inline(always)]
fn pull(out: &mut [f64], before: &[f64], after: &[f64], coupling: &[f64], scale: f64) {
    let n = out.len();
    let (before, after, coupling) = (&before[..n], &after[..n], &coupling[..n]);
    for j in 0..n {
        out[j] -= (after[j] - before[j]) * coupling[j] * scale;
    }
}

/// Sum in an order of its own: eight at a time.
#[inline(always)]
fn sum(values: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (whole, rest) = values.as_chunks::<8>();
    for part in whole {
        for k in 0..8 {
            sums[k] += part[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

/// Zero, unless one of the values is no number.
#[inline(always)]
fn none(values: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (whole, rest) = values.as_chunks::<8>();
    for part in whole {
        for k in 0..8 {
            sums[k] += 0.0 * part[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|value| 0.0 * value).sum::<f64>()
}

#[inline(always)]
fn drag_of(sides: [&[f64]; 2], right: &[f64], stress: f64, least: f64, out: &mut [f64]) {
    let n = out.len();
    let ([above, below], right) = (sides.map(|side| &side[..n]), &right[..n]);
    let one = |v: f64, u: f64| {
        let speed = (0.25 * (v * v + u * u)).sqrt();
        stress * if speed > least { speed } else { least }.sqrt()
    };
    out[0] = one(above[0] + below[0], right[0] + right[n - 1]);
    for j in 1..n {
        out[j] = one(above[j] + below[j], right[j] + right[j - 1]);
    }
}

/// Evaporation, down to black film; thin film turns black. Returns what went either way, m3.
fn thin(grid: &Grid, p: &Parameters, h: &mut [f64], dt: f64) -> (f64, f64) {
    let (loss, kept) = (p.evaporation * dt, (-dt / p.black_s).exp());
    let rows: Vec<(f64, f64)> = h
        .par_chunks_exact_mut(grid.columns)
        .with_min_len(8)
        .map(|row| wide!(thin_row(row, loss, kept, [p.black_m, p.black_below_m])))
        .collect();
    rows.iter().zip(&grid.area).fold((0.0, 0.0), |(a, b), ((dry, black), area)| (a + dry * area, b + black * area))
}

#[inline(always)]
fn thin_row(row: &mut [f64], loss: f64, kept: f64, [black_m, below_m]: [f64; 2]) -> (f64, f64) {
    let (mut dry, mut black) = ([0.0; 8], [0.0; 8]);
    let one = |h: &mut f64, dry: &mut f64, black: &mut f64| {
        let room = *h - black_m;
        let room = if room > 0.0 { room } else { 0.0 };
        let taken = if loss < room { loss } else { room };
        let left = *h - taken;
        let turned = black_m + (left - black_m) * kept;
        let new = if left < below_m { turned } else { left };
        *dry += taken;
        *black += left - new;
        *h = new;
    };
    let (whole, rest) = row.as_chunks_mut::<8>();
    for part in whole {
        for k in 0..8 {
            one(&mut part[k], &mut dry[k], &mut black[k]);
        }
    }
    for h in rest {
        one(h, &mut dry[0], &mut black[0]);
    }
    (dry.iter().sum(), black.iter().sum())
}

/// Liquid that runs down between faces that stand still, `rho g h^3 / (12 mu)` per length, upwind. Returns what leaves
/// at the lower wall, m3.
pub fn drain_inside(grid: &Grid, p: &Parameters, h: &mut [f64], dt: f64) -> f64 {
    let n = grid.columns;
    let strength = p.density * p.weight() / (12.0 * p.viscosity);
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

fn move_spots(grid: &Grid, spots: &mut [Spot], down: &[f64], across: &[f64], dt: f64) {
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
        let j = (column.floor() as isize).rem_euclid(n as isize) as usize;
        let v = (down[i * n + j] + down[(i + 1) * n + j]) / 2.0 * dt / grid.radius;
        let u = (across[i * n + j] + across[i * n + (j + n - 1) % n]) / 2.0 * dt / grid.radius;
        let [sin, cos] = turn;
        spot.place = if grid.is_plane() {
            let width = grid.width[0] * n as f64;
            [(x[0] + u).rem_euclid(width), 0.0, x[2] - v]
        } else {
            let y = [x[0] + v * x[2] * cos - u * sin, x[1] + v * x[2] * sin + u * cos, x[2] - v * s];
            let scale = 1.0 / y.iter().map(|y| y * y).sum::<f64>().sqrt();
            y.map(|y| y * scale)
        };
    }
}

/// Velocity of the air at the upper and the right sides of cells.
fn air(wind: &[Vec<f64>; 2], eddies: &[([Vec<f64>; 2], f64, f64)], p: &Parameters, time: f64) -> [Vec<f64>; 2] {
    let mut out = wind.clone();
    if p.eddies > 0.0 {
        let heights: Vec<f64> = eddies.iter().map(|(_, rate, phase)| p.eddies * (rate * time + phase).cos()).collect();
        for (part, out) in out.iter_mut().enumerate() {
            out.par_chunks_mut(4096).enumerate().for_each(|(block, out)| {
                for ((field, ..), height) in eddies.iter().zip(&heights) {
                    let field = &field[part][block * 4096..];
                    wide!(out.iter_mut().zip(field).for_each(|(out, field)| *out += height * field));
                }
            });
        }
    }
    out
}

/// A vector field at the sides of cells: its part down through the upper ones, across through the right ones.
fn at_sides(grid: &Grid, field: impl Fn([f64; 3]) -> [f64; 3] + Sync) -> [Vec<f64>; 2] {
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
fn wind(grid: &Grid, p: &Parameters) -> [Vec<f64>; 2] {
    let (low, high) = match p.shape {
        Shape::Sphere { rim_deg, .. } => (rim_deg.to_radians().cos(), 1.0),
        Shape::Plane { height_m, .. } => (0.0, height_m),
    };
    at_sides(grid, |place| [p.wind * (place[2] - low) / (high - low), 0.0, 0.0])
}

/// Fields without divergence of mean square speed 1 / (half their number), each as n x grad of smooth noise.
fn eddies(grid: &Grid, p: &Parameters) -> Vec<([Vec<f64>; 2], f64, f64)> {
    if p.eddies == 0.0 {
        return Vec::new();
    }
    let size = match p.shape {
        Shape::Sphere { radius_m, .. } => radius_m,
        Shape::Plane { width_m, height_m } => width_m.min(height_m) / 2.0,
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
