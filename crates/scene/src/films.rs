//! Films that come with the program, so that a built-in scene need not let its film flow first.
//!
//! Each is what its preset gives after its time, kept as whole steps of a tenth of a nanometre; `tools/data/stored_films.py`
//! makes them anew, and a test compares them with films that flow.

use std::sync::Arc;

use iridesce_files::decode_thickness;
use iridesce_flow::{FilmRun, Parameters};
use iridesce_thickness::FlowField;

/// What one step of a stored film is worth, nm.
const STEP_NM: f64 = 0.1;

/// Preset, time in s, seed, and the grid as a grey picture of 16 bits.
const STORED: [(&str, f64, u64, &[u8]); 3] = [
    ("free-bubble", 0.8, 1, include_bytes!("../films/free-bubble.png")),
    ("bubble-on-bath", 4.0, 1, include_bytes!("../films/bubble-on-bath.png")),
    ("vertical-film", 4.0, 1, include_bytes!("../films/vertical-film.png")),
];

/// The stored film of a preset after `time_s` seconds, if there is one.
pub fn stored(film: &FilmRun, time_s: f64) -> Option<Arc<FlowField>> {
    let parameters = film.parameters();
    let wanted = (film.preset(), time_s, parameters.seed);
    let (preset, _, _, png) = STORED.iter().find(|(name, time, seed, _)| (*name, *time, *seed) == wanted)?;
    read(preset, png).filter(|field| field.map().width() == parameters.columns).map(Arc::new)
}

fn read(preset: &str, png: &[u8]) -> Option<FlowField> {
    let most_nm = f64::from(u16::MAX) * STEP_NM;
    let map = decode_thickness(png).ok()?.in_range(Some(0.0), Some(most_nm)).ok()?;
    Some(Parameters::preset(preset).ok()?.field((*map).clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_films_can_be_read() {
        for (preset, time_s, seed, png) in STORED {
            let film = read(preset, png).unwrap();
            let parameters = Parameters::preset(preset).unwrap();
            assert_eq!(film.map().width(), parameters.columns, "{preset}");
            let mean = film.map().thickness_nm().iter().sum::<f64>() / film.map().thickness_nm().len() as f64;
            let start_nm = parameters.thickness_m * 1e9;
            assert!((0.5 * start_nm..1.2 * start_nm).contains(&mean), "{preset}: {mean} nm of {start_nm}");
            let run = |columns| FilmRun::new(preset, seed, columns).unwrap();
            assert_eq!(*stored(&run(None), time_s).unwrap(), film);
            assert!(stored(&run(Some(400)), time_s).is_none() && stored(&run(None), time_s + 1.0).is_none());
        }
    }
}
