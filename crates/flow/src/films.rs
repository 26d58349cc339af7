//! Films at given times, laid out to be looked at: what a scene asks for.
//!
//! Films step by their preset's full step from time 0, whatever times are asked for, and a time between two steps is
//! interpolated between them; so a film at a time is the same whether or not other times were asked for before. [`Films`]
//! keeps films where they stand: a later time goes on from there, which is what an animation needs.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use iridesce_numerics::Watch;
use iridesce_thickness::{FlowField, ThicknessError, ThicknessMap};

use crate::error::FlowError;
use crate::film::Film;
use crate::parameters::Parameters;

/// Longest run that a scene may ask for, s.
pub const MOST_SECONDS: f64 = 600.0;
/// Share of a step that is rounding.
const ROUNDING: f64 = 1e-9;
/// What is kept of films that the last question did not ask for, bytes.
const MOST_KEPT: usize = 512 << 20;
/// What a film that can go on takes, bytes a cell: its state and what its solvers have prepared.
const FILM_BYTES: usize = 280;

/// Which film: a preset, a seed and a grid; checked.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmRun {
    preset: String,
    parameters: Box<Parameters>,
}

impl FilmRun {
    /// The film of a preset on the preset's own grid or on one of `columns` columns. Nothing flows yet.
    ///
    /// ```
    /// use iridesce_flow::FilmRun;
    /// assert_eq!(FilmRun::new("late", 7, None)?.parameters().columns, 384);
    /// assert_eq!(FilmRun::new("late", 7, Some(7)).unwrap_err().argument, "columns");
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn new(preset: &str, seed: u64, columns: Option<usize>) -> Result<FilmRun, ThicknessError> {
        let mut parameters = Parameters::preset(preset)?;
        if let Some(columns) = columns {
            parameters = parameters.with_columns(columns);
        }
        parameters.seed = seed;
        parameters.check()?;
        Ok(FilmRun { preset: preset.to_owned(), parameters: Box::new(parameters) })
    }

    /// The preset's name.
    pub fn preset(&self) -> &str {
        &self.preset
    }

    /// All numbers that it follows.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn which(&self) -> Which {
        (self.preset.clone(), self.parameters.seed, self.parameters.columns)
    }

    /// The steps before and at or after a time, and how far between them it lies.
    fn steps(&self, time_s: f64) -> Place {
        let place = time_s / self.parameters.step_s;
        let whole = (place + ROUNDING).floor();
        let share = (place - whole).max(0.0);
        Place { first: whole as u64, last: whole as u64 + u64::from(share > ROUNDING), share }
    }
}

/// A preset, a seed and columns.
type Which = (String, u64, usize);

struct Place {
    first: u64,
    last: u64,
    share: f64,
}

/// A film after a whole number of steps, and its thickness and its share of black film one step before.
struct Standing {
    film: Film,
    steps: u64,
    before: Option<(ThicknessMap, Option<Vec<f64>>)>,
}

/// Something kept, and the question that used it last.
struct Kept<T> {
    value: T,
    bytes: usize,
    used: u64,
}

/// What one film is asked for: places in the question, their times in order, and the steps that it takes.
struct Plan {
    which: Which,
    asked: Vec<usize>,
    standing: Option<Standing>,
    steps: u64,
}

#[derive(Default)]
struct Known {
    /// Counts the questions.
    questions: u64,
    fields: BTreeMap<(Which, u64), Kept<Arc<FlowField>>>,
    films: BTreeMap<Which, Kept<Standing>>,
}

/// Films where they stand and fields that were asked for. A scene or an animation has one of its own; clones of an
/// [`Arc`] of it may be asked from several threads.
///
/// What the last question used is kept, whatever it takes; of older things, the latest, up to 512 MiB.
///
/// ```
/// use iridesce_flow::{FilmRun, Films};
/// use iridesce_numerics::Watch;
/// let films = Films::default();
/// let film = FilmRun::new("late", 7, None)?;
/// let field = films.field(&film, 0.0, &Watch::new())?;
/// let map = field.map();
/// assert!((map.thickness_nm().iter().sum::<f64>() / (map.width() * map.height()) as f64 - 260.0).abs() < 30.0);
/// # Ok::<(), iridesce_flow::FlowError>(())
/// ```
#[derive(Default)]
pub struct Films {
    known: Mutex<Known>,
}

impl std::fmt::Debug for Films {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let known = self.known();
        write!(f, "Films {{ fields: {}, films: {} }}", known.fields.len(), known.films.len())
    }
}

impl Films {
    /// A film after `time_s` seconds, 0 to [`MOST_SECONDS`]; as [`Films::fields`].
    pub fn field(&self, film: &FilmRun, time_s: f64, watch: &Watch) -> Result<Arc<FlowField>, FlowError> {
        let mut fields = self.fields(&[(film.clone(), time_s)], watch).map_err(|(_, error)| error)?;
        Ok(fields.remove(0))
    }

    /// Films after so many seconds each, 0 to [`MOST_SECONDS`], in the order in which they are asked for. It takes as
    /// long as the runs take, from where the films stand; `watch` hears of every step, in the stage `flowing`, and may
    /// stop them. Stopped films are kept where they are. The error says which of the films it is about.
    pub fn fields(&self, wanted: &[(FilmRun, f64)], watch: &Watch) -> Result<Vec<Arc<FlowField>>, (usize, FlowError)> {
        if let Some(at) = wanted.iter().position(|(_, time_s)| !(0.0..=MOST_SECONDS).contains(time_s)) {
            let allowed = format!("from 0 to {MOST_SECONDS} s");
            return Err((at, ThicknessError::new("time_s", allowed, format!("{:?}", wanted[at].1)).into()));
        }
        let mut found: Vec<Option<Arc<FlowField>>> = vec![None; wanted.len()];
        let (question, runs) = self.known().ask(wanted, &mut found);
        let plans: Vec<Plan> = runs.into_iter().map(|(which, asked)| self.plan(which, asked, wanted)).collect();
        let total = plans.iter().map(|plan| plan.steps).sum();
        if total > 0 {
            watch.begin("flowing", total);
        }
        let mut told = Ok(());
        for mut plan in plans {
            if told.is_ok() {
                told = self.follow(&mut plan, wanted, &mut found, (question, watch));
            }
            if let Some(standing) = plan.standing {
                let parameters = &wanted[plan.asked[0]].0.parameters;
                let bytes = FILM_BYTES * parameters.columns * parameters.rows;
                self.known().films.insert(plan.which, Kept { value: standing, bytes, used: question });
            }
        }
        self.known().forget(question);
        told.map(|()| found.into_iter().flatten().collect())
    }

    /// Takes out the film that goes on: whoever asks for the same film meanwhile lets one of its own flow.
    fn plan(&self, which: Which, mut asked: Vec<usize>, wanted: &[(FilmRun, f64)]) -> Plan {
        asked.sort_by(|a, b| wanted[*a].1.total_cmp(&wanted[*b].1));
        let film = &wanted[asked[0]].0;
        let start = film.steps(wanted[asked[0]].1);
        let taken = self.known().films.remove(&which).map(|kept| kept.value);
        let standing = taken.filter(|standing| standing.reaches(start.first, start.last));
        let end = film.steps(wanted[asked[asked.len() - 1]].1).last;
        let steps = end.saturating_sub(standing.as_ref().map_or(0, |standing| standing.steps));
        Plan { which, asked, standing, steps }
    }

    /// Lets a film flow to all times that it is asked for, and keeps what it is there.
    fn follow(
        &self,
        plan: &mut Plan,
        wanted: &[(FilmRun, f64)],
        found: &mut [Option<Arc<FlowField>>],
        (question, watch): (u64, &Watch),
    ) -> Result<(), (usize, FlowError)> {
        let run = &wanted[plan.asked[0]].0;
        let standing = match &mut plan.standing {
            Some(standing) => standing,
            none => {
                let film = Film::new(run.parameters().clone()).map_err(|error| (plan.asked[0], error.into()))?;
                none.insert(Standing { film, steps: 0, before: None })
            }
        };
        for &at in &plan.asked {
            let time_s = wanted[at].1;
            let field = Arc::new(standing.field(run, time_s, watch).map_err(|error| (at, error))?);
            let bytes = size_of_val(field.map().thickness_nm());
            let key = (plan.which.clone(), time_s.to_bits());
            self.known().fields.insert(key, Kept { value: field.clone(), bytes, used: question });
            found[at] = Some(field);
        }
        Ok(())
    }

    /// A film where it stands now, so that another process can go on with it; `None` if it never flowed here.
    pub fn standing(&self, film: &FilmRun) -> Option<Vec<u8>> {
        self.known().films.get(&film.which()).map(|kept| kept.value.film.checkpoint())
    }

    /// Goes on with a film that [`Films::standing`] gave.
    pub fn stand(&self, film: &FilmRun, bytes: &[u8]) -> Result<(), FlowError> {
        let resumed = Film::resume(film.parameters().clone(), bytes)?;
        let steps = resumed.state().step;
        let bytes = FILM_BYTES * film.parameters.columns * film.parameters.rows;
        let mut known = self.known();
        let used = known.questions;
        let value = Standing { film: resumed, steps, before: None };
        known.films.insert(film.which(), Kept { value, bytes, used });
        Ok(())
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Known {
    /// Counts a question, finds the fields that are known, and sorts the others by film: one run passes through all its times.
    fn ask(
        &mut self,
        wanted: &[(FilmRun, f64)],
        found: &mut [Option<Arc<FlowField>>],
    ) -> (u64, BTreeMap<Which, Vec<usize>>) {
        self.questions += 1;
        let question = self.questions;
        let mut runs: BTreeMap<Which, Vec<usize>> = BTreeMap::new();
        for (at, (film, time_s)) in wanted.iter().enumerate() {
            let which = film.which();
            match self.fields.get_mut(&(which.clone(), time_s.to_bits())) {
                Some(kept) => {
                    kept.used = question;
                    found[at] = Some(kept.value.clone());
                }
                None => runs.entry(which.clone()).or_default().push(at),
            }
            if let Some(kept) = self.films.get_mut(&which) {
                kept.used = question;
            }
        }
        (question, runs)
    }

    /// Drops what has not been used longest, until what is left of older questions fits.
    fn forget(&mut self, question: u64) {
        loop {
            let fields = self.fields.values().map(|kept| (kept.used, kept.bytes));
            let films = self.films.values().map(|kept| (kept.used, kept.bytes));
            let old: Vec<(u64, usize)> = fields.chain(films).filter(|(used, _)| *used < question).collect();
            let Some(oldest) = old.iter().map(|(used, _)| *used).min() else { return };
            if old.iter().map(|(_, bytes)| bytes).sum::<usize>() <= MOST_KEPT {
                return;
            }
            self.fields.retain(|_, kept| kept.used != oldest);
            self.films.retain(|_, kept| kept.used != oldest);
        }
    }
}

impl Standing {
    /// Whether it can tell its thickness after `first` and `last` steps, one or two neighbouring numbers.
    fn reaches(&self, first: u64, last: u64) -> bool {
        self.steps <= first || (self.steps == last && self.before.is_some())
    }

    /// The film at a time that it reaches, in a mixture of two steps if need be.
    fn field(&mut self, run: &FilmRun, time_s: f64, watch: &Watch) -> Result<FlowField, FlowError> {
        let Place { first, last, share } = run.steps(time_s);
        self.advance(last, run.parameters.step_s, watch)?;
        let (now, black) = (self.film.map()?, self.film.black_share());
        let Some((before, black_before)) = self.before.as_ref().filter(|_| last > first) else {
            return Ok(run.parameters.field(now, black));
        };
        let between = |before: &[f64], now: &[f64]| -> Vec<f64> {
            before.iter().zip(now).map(|(a, b)| a + (b - a) * share).collect()
        };
        let map = ThicknessMap::new(now.width(), now.height(), between(before.thickness_nm(), now.thickness_nm()))?;
        let black = black.map(|black| match black_before {
            Some(before) => between(before, &black),
            None => between(&vec![0.0; black.len()], &black),
        });
        Ok(run.parameters.field(map, black))
    }

    fn advance(&mut self, steps: u64, step_s: f64, watch: &Watch) -> Result<(), FlowError> {
        while self.steps < steps {
            if watch.is_stopped() {
                return Err(FlowError::Stopped);
            }
            if self.steps + 1 == steps {
                self.before = Some((self.film.map()?, self.film.black_share()));
            }
            self.film.advance_to((self.steps + 1) as f64 * step_s)?;
            self.steps += 1;
            watch.add(1);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn late(seed: u64) -> FilmRun {
        FilmRun::new("late", seed, None).unwrap()
    }

    fn at(films: &Films, time_s: f64) -> Arc<FlowField> {
        films.field(&late(5), time_s, &Watch::new()).unwrap()
    }

    #[test]
    fn a_film_at_a_time_does_not_depend_on_the_times_before() {
        let straight = at(&Films::default(), 0.042);
        let films = Films::default();
        for time_s in [0.0, 0.011, 0.0396, 0.04] {
            at(&films, time_s);
        }
        assert_eq!(at(&films, 0.042), straight);
        // Between two steps.
        let (first, last) = (at(&films, 0.04), at(&films, 0.045));
        let pairs = first.map().thickness_nm().iter().zip(last.map().thickness_nm());
        for ((a, b), now) in pairs.zip(straight.map().thickness_nm()) {
            assert!((a + 0.4 * (b - a) - now).abs() < 1e-9);
        }
        // And in another process.
        let bytes = films.standing(&late(5)).unwrap();
        let later = at(&films, 0.06);
        let others = Films::default();
        assert_eq!(others.standing(&late(5)), None);
        others.stand(&late(5), &bytes).unwrap();
        assert_eq!(at(&others, 0.06), later);
        assert!(others.stand(&late(6), &bytes).is_err());
    }

    #[test]
    fn many_times_of_many_films_take_one_run_each() {
        let wanted: Vec<(FilmRun, f64)> =
            [(5, 0.042), (6, 0.01), (5, 0.01), (5, 0.041), (5, 0.045), (6, 0.0)].map(|(s, t)| (late(s), t)).to_vec();
        let (films, watch) = (Films::default(), Watch::new());
        let fields = films.fields(&wanted, &watch).unwrap();
        let progress = watch.progress();
        assert_eq!((progress.stage, progress.done, progress.total), ("flowing", 9 + 2, 9 + 2));
        for ((film, time_s), field) in wanted.iter().zip(&fields) {
            assert_eq!(Films::default().field(film, *time_s, &Watch::new()).unwrap(), *field, "{time_s}");
        }
        // Asked again, nothing flows.
        let watch = Watch::new();
        let again = films.fields(&wanted, &watch).unwrap();
        assert!(watch.progress().total == 0 && again.iter().zip(&fields).all(|(a, b)| Arc::ptr_eq(a, b)));
    }

    #[test]
    fn a_stopped_film_stays_where_it_is_and_a_wrong_time_is_named() {
        let (films, watch) = (Films::default(), Watch::new());
        watch.stop();
        let wanted = [(late(5), 0.0), (late(5), 0.05)];
        assert_eq!(films.fields(&wanted, &watch).unwrap_err(), (1, FlowError::Stopped));
        assert!(films.standing(&late(5)).is_some());
        assert_eq!(at(&films, 0.05), at(&Films::default(), 0.05));
        let (place, error) = films.fields(&[(late(5), 0.0), (late(5), 601.0)], &Watch::new()).unwrap_err();
        assert!(place == 1 && error.to_string().contains("0 to 600 s, got 601.0"), "{error}");
    }

    #[test]
    fn what_the_last_question_used_is_kept_and_of_the_rest_the_latest() {
        let mut known = Known::default();
        let bytes = MOST_KEPT / 2;
        let field = at(&Films::default(), 0.0);
        for used in 1..=5 {
            let key = (("late".to_owned(), used, 384), 0);
            known.fields.insert(key, Kept { value: field.clone(), bytes, used: used.min(4) });
        }
        known.forget(4);
        // Questions 2 and 3 fill the room; 1 is dropped, both of 4 stay.
        let left: Vec<u64> = known.fields.keys().map(|((_, seed, _), _)| *seed).collect();
        assert_eq!(left, [2, 3, 4, 5]);
    }
}
