//! A preset's film at one time, as a map: what a scene asks for.

use std::sync::{Arc, Mutex, PoisonError};

use super::film::{Film, FlowError};
use super::parameters::Parameters;
use crate::error::ThicknessError;
use crate::map::ThicknessMap;

/// Longest run that a scene may ask for, s.
pub const MOST_SECONDS: f64 = 600.0;
/// Maps that are remembered: a scene is read several times while it is changed.
const REMEMBERED: usize = 8;

type Key = (String, u64, u64);

static LAST: Mutex<Vec<(Key, Arc<ThicknessMap>)>> = Mutex::new(Vec::new());

/// The film of a preset after `time_s` seconds (0 to [`MOST_SECONDS`]), over a whole sphere. It takes as long as the run
/// takes; the last few maps are remembered.
///
/// ```
/// let map = iridesce_thickness::flow::field("late", 0.0, 7)?;
/// assert!((map.thickness_nm().iter().sum::<f64>() / (map.width() * map.height()) as f64 - 260.0).abs() < 30.0);
/// # Ok::<(), iridesce_thickness::flow::FlowError>(())
/// ```
pub fn field(preset: &str, time_s: f64, seed: u64) -> Result<Arc<ThicknessMap>, FlowError> {
    let mut parameters = Parameters::preset(preset)?;
    if !(0.0..=MOST_SECONDS).contains(&time_s) {
        let message = format!("must be from 0 to {MOST_SECONDS} s, got {time_s:?}");
        return Err(ThicknessError { key: "time_s", message }.into());
    }
    parameters.seed = seed;
    let key = (preset.to_string(), time_s.to_bits(), seed);
    let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, map)) = last().iter().find(|(other, _)| *other == key) {
        return Ok(map.clone());
    }
    let mut film = Film::new(parameters)?;
    film.advance_to(time_s)?;
    let map = Arc::new(film.map()?);
    let mut last = last();
    if last.len() == REMEMBERED {
        last.remove(0);
    }
    last.push((key, map.clone()));
    Ok(map)
}
