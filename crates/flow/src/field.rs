//! A preset's film at one time, laid out to be looked at: what a scene asks for.
//!
//! Films step by their preset's full step from time 0, whatever times are asked for, and a time between two steps is
//! interpolated between them; so a film at a time is the same whether or not other times were asked for before. The last
//! few films are kept where they are: a later time goes on from there, which is what an animation needs.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use iridesce_thickness::{FlowField, ThicknessError, ThicknessMap};

use crate::film::{Film, FlowError};
use crate::grid::Shape;
use crate::parameters::Parameters;

/// Longest run that a scene may ask for, s.
pub const MOST_SECONDS: f64 = 600.0;
/// Fields that are remembered: a scene is read several times while it is changed.
const REMEMBERED: usize = 8;
/// Films that stand ready to go on.
const STANDING: usize = 4;
/// Share of a step that is rounding.
const ROUNDING: f64 = 1e-9;

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
/// let field = iridesce_flow::field("late", 0.0, 7, None)?;
/// let map = field.map();
/// assert!((map.thickness_nm().iter().sum::<f64>() / (map.width() * map.height()) as f64 - 260.0).abs() < 30.0);
/// # Ok::<(), iridesce_flow::FlowError>(())
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
}
