//! A film in time: its state, and the step that changes it.

use iridesce_numerics::{Watch, simd};
use iridesce_thickness::{ThicknessError, ThicknessMap};
use rayon::prelude::*;

use crate::carry::Carry;
use crate::chance::Purpose;
use crate::error::FlowError;
use crate::events::{self, Clock};
use crate::grid::{Edge, Grid};
use crate::parameters::Parameters;
use crate::share::Sharing;
use crate::spectral::{Ends, Spectral, Task, Tridiagonal};
use crate::start;
use crate::tension::Tension;
use crate::transport::{MOST_SUBSTEPS, Transport};
use crate::viscosity::Viscosity;

mod air;
mod black;
mod forces;
mod live;
mod memory;
mod rows;
mod shown;
mod sources;
mod state;

use air::{air, eddies, wind};
pub use forces::fill_poles;
use memory::Second;
use rows::none;
pub use sources::drain_inside;
pub(crate) use state::Memory;
pub use state::{Books, State, Summary};

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
    sharing: Option<Box<Sharing>>,
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
        simd::level().map_err(|error| error.argument())?;
        let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
        let h = start::noise(&grid, &parameters);
        Ok(Film::from_thickness(parameters, &grid, h))
    }

    /// A film at rest whose thickness is given: row 0 on top, the last at the bottom or the rim, columns from one side
    /// to the other or around. It is brought onto the grid with its volume kept; `thickness_m` and `noise` give way to it
    /// ([`Parameters::starting_from`]).
    ///
    /// ```
    /// use iridesce_flow::{Film, Parameters};
    /// use iridesce_thickness::ThicknessMap;
    /// let wedge = ThicknessMap::new(1, 3, vec![200.0, 300.0, 400.0])?;
    /// let film = Film::starting_from(Parameters::preset("vertical-film-preview")?, &wedge)?;
    /// assert!((film.parameters().thickness_m - 300e-9).abs() < 1e-20);
    /// assert!((film.volume() / (0.1 * 0.06 * 300e-9) - 1.0).abs() < 1e-12);
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn starting_from(parameters: Parameters, initial: &ThicknessMap) -> Result<Film, ThicknessError> {
        let parameters = parameters.starting_from(initial);
        parameters.check()?;
        simd::level().map_err(|error| error.argument())?;
        let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
        let h = start::resampled(&grid, initial);
        Ok(Film::from_thickness(parameters, &grid, h))
    }

    /// A film at rest, with its surfactant in balance with its mean weight.
    fn from_thickness(parameters: Parameters, grid: &Grid, h: Vec<f64>) -> Film {
        let p = &parameters;
        let area = grid.total_area();
        let weight = if p.elasticity.is_finite() { p.density * p.weight() * p.thickness_m / p.elasticity } else { 0.0 };
        let mean_height = grid.height.iter().zip(&grid.area).map(|(z, a)| z * a).sum::<f64>() * p.columns as f64 / area;
        let s = (0..grid.cells()).map(|k| -weight * (grid.height[k / p.columns] - mean_height)).collect();
        let cells = grid.cells();
        let state = State {
            h,
            black: Vec::new(),
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
            rupture_clock: Clock::new(p.seed, Purpose::Rupture),
            patches: Vec::new(),
            spots: Vec::new(),
            ruptured_s: None,
            memory: None,
        };
        Film::from_state(parameters, state)
    }

    /// A film as it is at some time; its liquid and its surfactant are counted afresh if this is its start.
    pub(crate) fn from_state(parameters: Parameters, mut state: State) -> Film {
        let grid = Grid::new(parameters.shape, parameters.columns, parameters.rows);
        if state.step == 0 {
            state.books = Books { start: grid.integral(&state.h), ..Books::default() };
            state.surfactant = surfactant(&grid, &state.s);
            sources::find_black(&parameters, &mut state);
        }
        let (wind, eddies) = (wind(&grid, &parameters), eddies(&grid, &parameters));
        Film {
            carry: Carry::new(&grid),
            transport: Transport::new(&grid),
            sharing: None,
            tension: Tension::new(&grid),
            viscosity: Viscosity::new(&grid),
            diffusion: Spectral::new(grid.columns, grid.rows, if grid.closes() { Ends::Closed } else { Ends::Even }),
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

    /// Steps until `time_s`, in steps of one length that is at most the parameters' own; less if the film bursts.
    pub fn advance_to(&mut self, time_s: f64) -> Result<(), FlowError> {
        self.advance_watched(time_s, &Watch::new())
    }

    /// The same; `watch` hears of every step, in the stage `flowing`. Stopped, the film stands after some whole step.
    pub fn advance_watched(&mut self, time_s: f64, watch: &Watch) -> Result<(), FlowError> {
        let start = self.state.time_s;
        if !(time_s.is_finite() && time_s >= start) {
            let allowed = format!("a finite time, at least the film's own, {start:?} s");
            return Err(ThicknessError::new("time_s", allowed, format!("{time_s:?}")).into());
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
        let (time, step) = (self.state.time_s, self.state.step + 1);
        let mut watch = Stopwatch::new(self.clock);
        fill_poles(&self.grid, &mut self.state.down);
        let mut second = (self.parameters.time_order == 2.0).then(|| Second::begin(&mut self.state, dt));
        // How long the forces at its end act.
        let part = second.as_ref().map_or(dt, |second| second.part);

        // Where it flows, liquid goes with it.
        self.transport(step, dt)?;
        watch.lap(&mut self.spent[0]);
        self.gain_and_lose(time, dt);
        watch.lap(&mut self.spent[1]);

        // Velocity and surfactant are carried, pushed, and held together by the tension.
        let drag = self.carry(dt, second.as_mut());
        watch.lap(&mut self.spent[2]);
        let air = air(&self.wind, &self.eddies, &self.parameters, time + dt);
        let when = if part < dt { time + dt - part / 2.0 } else { time };
        forces::push(&self.grid, &self.parameters, &mut self.state, &drag, &air, [when, part], &mut self.tension);
        let mut right_side = forces::gathered(&self.grid, &self.state, self.parameters.elasticity.is_finite(), part);
        watch.lap(&mut self.spent[3]);
        self.solve_tension(step, part, &mut right_side)?;
        watch.lap(&mut self.spent[4]);
        forces::pulled(&self.grid, &mut self.state, &self.tension);
        let spread = forces::viscous_spread(&self.grid, &self.parameters, &self.state.h, part);
        watch.lap(&mut self.spent[3]);
        self.viscosity.step(&self.grid, &mut self.state.down, &mut self.state.across, &spread);
        watch.lap(&mut self.spent[5]);
        self.strain(part);
        self.state.memory = second.map(|second| second.end(&self.state, dt));
        if self.parameters.elasticity.is_finite() {
            self.exchange(dt);
        }

        self.state.step = step;
        self.check(step)?;
        let Film { parameters: p, grid, state, .. } = self;
        state.ruptured_s = events::rupture(grid, p, &mut state.rupture_clock, [&state.h, &state.black], time, dt);
        watch.lap(&mut self.spent[3]);
        Ok(())
    }

    /// The thickness, carried along in as many sub-steps as it takes.
    fn transport(&mut self, step: u64, dt: f64) -> Result<(), FlowError> {
        let Film { parameters: p, grid, state, transport, sharing, .. } = self;
        let needed = Transport::substeps(grid, &state.down, &state.across, dt);
        if needed.is_nan() {
            return Err(self.first_not_finite(step));
        }
        if needed > MOST_SUBSTEPS {
            return Err(FlowError::StepTooLong { dt, step, time_s: state.time_s, needed, most: MOST_SUBSTEPS });
        }
        let dt = dt / needed;
        for _ in 0..needed as usize {
            let State { h, black, down, across, .. } = state;
            if black.is_empty() {
                transport.step(grid, h, down, across, dt);
                continue;
            }
            let (sharing, black_m) = (sharing.get_or_insert_with(|| Box::new(Sharing::new(grid))), p.black_film_m());
            sharing.carry(grid, transport, [h, black], [down, across], (dt, black_m));
            sharing.sharpen(grid, black_m, h, black);
        }
        self.substeps = needed as usize;
        Ok(())
    }

    /// Patches rise, spots open, film dries and turns black, liquid runs down between the faces.
    fn gain_and_lose(&mut self, time: f64, dt: f64) {
        let Film { parameters: p, grid, state, .. } = self;
        let books = &mut state.books;
        books.swallowed += events::regenerate(
            grid,
            p,
            &mut state.patch_clock,
            &mut state.patches,
            (&mut state.h, &state.black),
            time,
            dt,
        );
        sources::move_spots(grid, &mut state.spots, &state.down, &state.across, dt);
        let fields = (&mut state.h[..], &mut state.black);
        books.blackened += events::open_spots(grid, p, &mut state.spot_clock, &mut state.spots, fields, time, dt);
        let (evaporated, blackened) = sources::thin(grid, p, &mut state.h, &mut state.black, dt);
        books.evaporated += evaporated;
        books.blackened += blackened;
        if p.drains_inside {
            books.drained += drain_inside(grid, p, &mut state.h, dt);
        }
    }

    /// Velocity and surfactant, carried along; the drag of the air before that, kg/(m2 s).
    fn carry(&mut self, dt: f64, second: Option<&mut Second>) -> Vec<f64> {
        let Film { parameters: p, grid, state, carry, .. } = self;
        carry.trace(grid, &state.down, &state.across, dt);
        if let Some(second) = second {
            return second.carry(grid, p, state, carry);
        }
        let drag = forces::drag(grid, p, &state.down, &state.across);
        carry.velocity(grid, &mut state.down, &mut state.across);
        if p.elasticity.is_finite() {
            carry.scalar(grid, &mut state.s);
        }
        drag
    }

    fn solve_tension(&mut self, step: u64, dt: f64, right_side: &mut [f64]) -> Result<(), FlowError> {
        let Film { parameters: p, grid, state, tension, .. } = self;
        let stiffness = if p.elasticity.is_finite() { 1.0 / (dt * dt * p.elasticity) } else { 0.0 };
        let diagonal: Vec<f64> = grid.area.iter().map(|area| area * stiffness).collect();
        match tension.solve(grid, &mut state.q, &diagonal, right_side, p.tolerance) {
            Some(iterations) => {
                self.iterations = iterations;
                Ok(())
            }
            None => Err(self.first_not_finite(step)),
        }
    }

    /// The surfactant follows the tension of forces that acted so long, s.
    fn strain(&mut self, part: f64) {
        let Film { parameters: p, state, .. } = self;
        if p.elasticity.is_finite() {
            let scale = 1.0 / (part * p.elasticity);
            state.s.par_iter_mut().with_min_len(4096).zip(&state.q).for_each(|(s, q)| *s = q * scale);
        }
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
            let system = Tridiagonal::new(grid.period(), above, below, |i, turn| {
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
        let fine =
            whole(&state.h) && whole(&state.black) && whole(&state.down) && whole(&state.across) && whole(&state.s);
        if fine { Ok(()) } else { Err(self.first_not_finite(step)) }
    }

    fn first_not_finite(&self, step: u64) -> FlowError {
        let state = &self.state;
        let fields = [
            ("the thickness", &state.h),
            ("the share of black film", &state.black),
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
}

fn surfactant(grid: &Grid, s: &[f64]) -> f64 {
    let rows: Vec<f64> =
        s.par_chunks_exact(grid.columns).with_min_len(8).map(|row| row.iter().map(|s| s.exp()).sum()).collect();
    rows.iter().zip(&grid.area).map(|(sum, area)| sum * area).sum()
}
