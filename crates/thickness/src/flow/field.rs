//! A preset's film at one time, laid out to be looked at: what a scene asks for.
//!
//! Films step by their preset's full step from time 0, whatever times are asked for, and a time between two steps is
//! interpolated between them; so a film at a time is the same whether or not other times were asked for before. The last
//! few films are kept where they are: a later time goes on from there, which is what an animation needs.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::film::{Film, FlowError};
use super::grid::Shape;
use super::parameters::Parameters;
use crate::error::ThicknessError;
use crate::map::ThicknessMap;

/// Longest run that a scene may ask for, s.
pub const MOST_SECONDS: f64 = 600.0;
/// Fields that are remembered: a scene is read several times while it is changed.
const REMEMBERED: usize = 8;
/// Films that stand ready to go on.
const STANDING: usize = 4;
/// Share of a step that is rounding.
const ROUNDING: f64 = 1e-9;

/// A film that has flowed, over a whole sphere or a plane that repeats across.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowField {
    map: ThicknessMap,
    is_globe: bool,
    max_nm: f64,
}

impl FlowField {
    /// A grid over longitude and latitude (`is_globe`) or over a plane; it repeats across.
    pub fn new(map: ThicknessMap, is_globe: bool) -> FlowField {
        let max_nm = map.max_nm();
        FlowField { map, is_globe, max_nm }
    }

    /// The grid.
    pub fn map(&self) -> &ThicknessMap {
        &self.map
    }

    /// Whether it goes around a sphere.
    pub fn is_globe(&self) -> bool {
        self.is_globe
    }

    /// The largest thickness, nm.
    pub fn max_nm(&self) -> f64 {
        self.max_nm
    }

    /// Thickness in nm at `u` (once around) and `v` (0 at the bottom, 1 on top): cubic between the middles of the cells,
    /// smooth also over the poles of a globe, and never outside 0 and the largest value. Cells of a thickness that varies
    /// by whole orders of colour would show as facets if they were joined by straight lines.
    pub fn sample(&self, u: f64, v: f64) -> f64 {
        if u.is_nan() || v.is_nan() {
            return f64::NAN;
        }
        let (width, height) = (self.map.width(), self.map.height());
        let values = self.map.thickness_nm();
        let turn = if u.is_finite() { u - u.floor() } else { 0.0 };
        let across = turn * width as f64 + 0.5;
        let down = (1.0 - v.clamp(0.0, 1.0)) * height as f64 + 0.5;
        // Of the neighbour before: the first of the four is one before that.
        let (column, row) = (across as usize, down as usize);
        let (weights_across, weights_down) = (catmull_rom(across - column as f64), catmull_rom(down - row as f64));
        // No division here: renders ask for millions of places. Narrow grids alone wrap more than once.
        let wrapped = |k: usize| {
            let j = column + k + width - 2;
            if j < width {
                j
            } else if j < 2 * width {
                j - width
            } else {
                j % width
            }
        };
        let columns = [wrapped(0), wrapped(1), wrapped(2), wrapped(3)];
        let mut sum = 0.0;
        for (k, weight) in weights_down.into_iter().enumerate() {
            let below = row + k;
            let beyond = below < 2 || below >= height + 2;
            let along = |i: usize, columns: [usize; 4]| {
                let line = &values[i * width..(i + 1) * width];
                let [a, b, c, d] = columns.map(|j| line[j]);
                weights_across[0] * a + weights_across[1] * b + (weights_across[2] * c + weights_across[3] * d)
            };
            let value = if !beyond {
                along(below - 2, columns)
            } else if self.is_globe {
                // Beyond a pole lies the other side.
                let i = if below < 2 { 1 - below } else { 2 * height + 1 - below };
                let half = columns.map(|j| if j + width / 2 < width { j + width / 2 } else { j + width / 2 - width });
                along(i.min(height - 1), half)
            } else {
                along(if below < 2 { 0 } else { height - 1 }, columns)
            };
            sum += weight * value;
        }
        sum.clamp(0.0, self.max_nm)
    }
}

/// Weights of the four neighbours of a place a share `f` behind the second of them.
fn catmull_rom(f: f64) -> [f64; 4] {
    let (g, h) = (f * f, f * f * f);
    [0.5 * (-h + 2.0 * g - f), 0.5 * (3.0 * h - 5.0 * g + 2.0), 0.5 * (-3.0 * h + 4.0 * g + f), 0.5 * (h - g)]
}

/// Hears of each step as (time reached, time asked for), in s, and says whether to go on.
pub type Watch = fn(f64, f64) -> bool;

static WATCH: OnceLock<Watch> = OnceLock::new();

/// Has `watch` asked between the steps of every film that [`field`] lets flow: a front end hears its user there. Only the
/// first call counts.
pub fn watch_fields(watch: Watch) {
    let _ = WATCH.set(watch);
}

/// A preset, a seed and columns.
type Which = (String, u64, usize);

/// A film after a whole number of steps, and its thickness one step before.
struct Standing {
    which: Which,
    film: Film,
    steps: u64,
    before: Option<ThicknessMap>,
}

#[derive(Default)]
struct Known {
    fields: Vec<((Which, u64), Arc<FlowField>)>,
    films: Vec<Standing>,
}

static KNOWN: Mutex<Known> = Mutex::new(Known { fields: Vec::new(), films: Vec::new() });

fn known() -> std::sync::MutexGuard<'static, Known> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a scene means by a preset, a seed and perhaps a number of columns.
fn read(preset: &str, seed: u64, columns: Option<usize>) -> Result<(Parameters, Which), ThicknessError> {
    let mut parameters = Parameters::preset(preset)?;
    if let Some(columns) = columns {
        parameters = parameters.with_columns(columns);
    }
    parameters.seed = seed;
    parameters.check()?;
    let which = (preset.to_string(), seed, parameters.columns);
    Ok((parameters, which))
}

/// The film of a preset after `time_s` seconds (0 to [`MOST_SECONDS`]), on the preset's own grid or on one of `columns`
/// columns. It takes as long as the run takes.
///
/// ```
/// let field = iridesce_thickness::flow::field("late", 0.0, 7, None)?;
/// let map = field.map();
/// assert!((map.thickness_nm().iter().sum::<f64>() / (map.width() * map.height()) as f64 - 260.0).abs() < 30.0);
/// # Ok::<(), iridesce_thickness::flow::FlowError>(())
/// ```
pub fn field(preset: &str, time_s: f64, seed: u64, columns: Option<usize>) -> Result<Arc<FlowField>, FlowError> {
    let (parameters, which) = read(preset, seed, columns)?;
    if !(0.0..=MOST_SECONDS).contains(&time_s) {
        let message = format!("must be from 0 to {MOST_SECONDS} s, got {time_s:?}");
        return Err(ThicknessError { key: "time_s", message }.into());
    }
    let key = (which.clone(), time_s.to_bits());
    if let Some((_, field)) = known().fields.iter().find(|(other, _)| *other == key) {
        return Ok(field.clone());
    }
    let step_s = parameters.step_s;
    let is_globe = matches!(parameters.shape, Shape::Sphere { .. });
    let place = time_s / step_s;
    let whole = (place + ROUNDING).floor();
    let share = (place - whole).max(0.0);
    let (first, last) = (whole as u64, whole as u64 + u64::from(share > ROUNDING));
    let mut standing = {
        let mut known = known();
        let at = known.films.iter().position(|film| film.which == which && film.reaches(first, last));
        match at {
            Some(at) => known.films.remove(at),
            None => Standing { which, film: Film::new(parameters)?, steps: 0, before: None },
        }
    };
    let done = standing.advance(last, step_s, time_s);
    let map = done.and_then(|()| {
        let now = standing.film.map()?;
        Ok(match standing.before.as_ref().filter(|_| last > first) {
            None => now,
            Some(before) => {
                let pairs = before.thickness_nm().iter().zip(now.thickness_nm());
                ThicknessMap::new(now.width(), now.height(), pairs.map(|(a, b)| a + (b - a) * share).collect())?
            }
        })
    });
    let mut known = known();
    // Also a film that was stopped is kept where it stands.
    if known.films.len() == STANDING {
        known.films.remove(0);
    }
    known.films.push(standing);
    let field = Arc::new(FlowField::new(map?, is_globe));
    if known.fields.len() == REMEMBERED {
        known.fields.remove(0);
    }
    known.fields.push((key, field.clone()));
    Ok(field)
}

impl Standing {
    /// Whether it can tell its thickness after `first` and `last` steps, one or two neighbouring numbers.
    fn reaches(&self, first: u64, last: u64) -> bool {
        self.steps <= first || (self.steps == last && self.before.is_some())
    }

    fn advance(&mut self, steps: u64, step_s: f64, asked_s: f64) -> Result<(), FlowError> {
        let watch = WATCH.get();
        while self.steps < steps {
            if watch.is_some_and(|goes_on| !goes_on(self.steps as f64 * step_s, asked_s)) {
                return Err(FlowError::Stopped);
            }
            if self.steps + 1 == steps {
                self.before = Some(self.film.map()?);
            }
            self.film.advance_to((self.steps + 1) as f64 * step_s)?;
            self.steps += 1;
        }
        Ok(())
    }
}

/// The film of a preset where it stands now, so that another process can go on with it; `None` if it never flowed here, or
/// was forgotten.
pub fn standing(preset: &str, seed: u64, columns: Option<usize>) -> Result<Option<Vec<u8>>, FlowError> {
    let (_, which) = read(preset, seed, columns)?;
    Ok(known().films.iter().rev().find(|film| film.which == which).map(|film| film.film.checkpoint()))
}

/// Goes on with a film that [`standing`] gave.
pub fn stand(preset: &str, seed: u64, columns: Option<usize>, bytes: &[u8]) -> Result<(), FlowError> {
    let (parameters, which) = read(preset, seed, columns)?;
    let film = Film::resume(parameters, bytes)?;
    let steps = film.state().step;
    let mut known = known();
    known.films.retain(|film| film.which != which);
    known.films.push(Standing { which, film, steps, before: None });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_at_a_time_does_not_depend_on_the_times_before() {
        let at = |time_s: f64| field("late", time_s, 5, None).unwrap();
        let straight = at(0.042);
        known().fields.clear();
        known().films.clear();
        for time_s in [0.0, 0.011, 0.0396, 0.04] {
            at(time_s);
        }
        assert_eq!(at(0.042), straight);
        // Between two steps.
        let (first, last) = (at(0.04), at(0.045));
        let pairs = first.map().thickness_nm().iter().zip(last.map().thickness_nm());
        for ((a, b), now) in pairs.zip(straight.map().thickness_nm()) {
            assert!((a + 0.4 * (b - a) - now).abs() < 1e-9);
        }
        // And in another process.
        let bytes = standing("late", 5, None).unwrap().unwrap();
        let later = at(0.06);
        known().fields.clear();
        known().films.clear();
        assert_eq!(standing("late", 5, None).unwrap(), None);
        stand("late", 5, None, &bytes).unwrap();
        assert_eq!(at(0.06), later);
        assert!(stand("late", 6, None, &bytes).is_err());
    }

    #[test]
    fn smooth_fields_are_met_to_third_order_also_over_the_poles() {
        let place = |u: f64, v: f64| {
            let (longitude, latitude) = ((u - 0.5) * std::f64::consts::TAU, (v - 0.5) * std::f64::consts::PI);
            [latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos()]
        };
        let wave = |[x, y, z]: [f64; 3]| 500.0 + 100.0 * (2.0 * x + 3.0 * y - z).sin();
        let error = |n: usize| {
            let cell = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
            let at = |k: usize| wave(place(cell(k % n, n), 1.0 - cell(k / n, n / 2)));
            let field = FlowField::new(ThicknessMap::new(n, n / 2, (0..n * n / 2).map(at).collect()).unwrap(), true);
            (0..4000).fold(0.0_f64, |worst, i| {
                let (u, v) = ((f64::from(i) * 0.618).fract(), (f64::from(i) + 0.5) / 4000.0);
                worst.max((field.sample(u, v) - wave(place(u, v))).abs())
            })
        };
        let (coarse, fine) = (error(64), error(128));
        assert!(fine < 0.05 && coarse / fine > 6.0, "{coarse} {fine}");
    }

    #[test]
    fn no_cell_is_passed_by() {
        let map = ThicknessMap::new(4, 2, vec![0.0, 100.0, 0.0, 100.0, 50.0, 0.0, 0.0, 100.0]).unwrap();
        for is_globe in [false, true] {
            let field = FlowField::new(map.clone(), is_globe);
            for i in -50..=50 {
                for k in -3..=13 {
                    let value = field.sample(f64::from(i) / 25.0, f64::from(k) / 10.0);
                    assert!((0.0..=100.0).contains(&value));
                    let turned = field.sample(f64::from(i) / 25.0 + 1.0, f64::from(k) / 10.0);
                    assert!((turned - value).abs() < 1e-9);
                }
            }
            assert_eq!(field.sample(0.375, 0.75), 100.0);
            assert!(field.sample(f64::NAN, 0.5).is_nan() && field.sample(f64::INFINITY, 0.5).is_finite());
        }
    }
}
