//! Films that come with the program, so that a built-in scene need not let its film flow first.
//!
//! Each is what its preset gives after its time, kept as whole steps of a tenth of a nanometre and, where it has black
//! film, the share of that in each cell, in 255 steps; `tools/data/stored_films.py` makes them anew, and a test compares
//! them with films that flow.

use std::sync::Arc;

use iridesce_files::decode_thickness;
use iridesce_flow::{FilmRun, Parameters};
use iridesce_thickness::FlowField;

/// What one step of a stored film is worth, nm.
const STEP_NM: f64 = 0.1;

/// A film that comes along.
struct Stored {
    preset: &'static str,
    time_s: f64,
    seed: u64,
    /// The grid as a grey picture of 16 bits.
    thickness: &'static [u8],
    /// The share of black film as one of 8 bits, where there is some.
    black: Option<&'static [u8]>,
}

const STORED: [Stored; 3] = [
    Stored {
        preset: "free-bubble",
        time_s: 0.8,
        seed: 1,
        thickness: include_bytes!("../films/free-bubble.png"),
        black: None,
    },
    Stored {
        preset: "bubble-on-bath",
        time_s: 4.0,
        seed: 1,
        thickness: include_bytes!("../films/bubble-on-bath.png"),
        black: Some(include_bytes!("../films/bubble-on-bath-black.png")),
    },
    Stored {
        preset: "vertical-film",
        time_s: 4.0,
        seed: 1,
        thickness: include_bytes!("../films/vertical-film.png"),
        black: None,
    },
];

/// The stored film of a preset after `time_s` seconds, if there is one.
pub fn stored(film: &FilmRun, time_s: f64) -> Option<Arc<FlowField>> {
    let parameters = film.parameters();
    let wanted = (film.preset(), time_s, parameters.seed);
    let stored = STORED.iter().find(|stored| (stored.preset, stored.time_s, stored.seed) == wanted)?;
    read(stored).filter(|field| field.map().width() == parameters.columns).map(Arc::new)
}

fn read(stored: &Stored) -> Option<FlowField> {
    let values = |png: &[u8], most: f64| decode_thickness(png).ok()?.in_range(Some(0.0), Some(most)).ok();
    let map = values(stored.thickness, f64::from(u16::MAX) * STEP_NM)?;
    let black = match stored.black {
        Some(png) => Some(values(png, 1.0)?.thickness_nm().to_vec()),
        None => None,
    };
    Some(Parameters::preset(stored.preset).ok()?.field((*map).clone(), black))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_films_can_be_read() {
        for stored_film in STORED {
            let Stored { preset, time_s, seed, .. } = stored_film;
            let film = read(&stored_film).unwrap();
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
