//! Films that come with the program, so that a built-in scene need not let its film flow first.
//!
//! Each is what its preset gives after its time, kept as whole steps of a tenth of a nanometre; `tools/data/stored_films.py`
//! makes them anew, and a test compares them with films that flow.

use std::sync::Arc;

use iridesce_files::decode_thickness;
use iridesce_flow::{self as flow, FlowError, Parameters, Shape};
use iridesce_thickness::FlowField;

/// What one step of a stored film is worth, nm.
const STEP_NM: f64 = 0.1;

/// Preset, time in s, seed, and the grid as a grey picture of 16 bits.
const STORED: [(&str, f64, u64, &[u8]); 3] = [
    ("free-bubble", 0.8, 1, include_bytes!("../films/free-bubble.png")),
    ("bubble-on-bath", 4.0, 1, include_bytes!("../films/bubble-on-bath.png")),
    ("vertical-film", 4.0, 1, include_bytes!("../films/vertical-film.png")),
];

/// The film of a preset after `time_s` seconds: a stored one, or else one that flows now.
pub fn field(preset: &str, time_s: f64, seed: u64, columns: Option<usize>) -> Result<Arc<FlowField>, FlowError> {
    let stored = STORED.iter().find(|(name, time, number, _)| (*name, *time, *number) == (preset, time_s, seed));
    if let Some((_, _, _, png)) = stored
        && let Some(field) = read(preset, png)
        && columns.is_none_or(|columns| columns == field.map().width())
    {
        return Ok(Arc::new(field));
    }
    flow::field(preset, time_s, seed, columns)
}

fn read(preset: &str, png: &[u8]) -> Option<FlowField> {
    let most_nm = f64::from(u16::MAX) * STEP_NM;
    let map = decode_thickness(png).ok()?.in_range(Some(0.0), Some(most_nm)).ok()?;
    let is_globe = matches!(Parameters::preset(preset).ok()?.shape, Shape::Sphere { .. });
    Some(FlowField::new((*map).clone(), is_globe))
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
            assert_eq!(*field(preset, time_s, seed, None).unwrap(), film);
        }
    }
}
