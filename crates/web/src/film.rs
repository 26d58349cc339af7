//! Where a film is how thick: flowing films, swirls, the gap under a lens.

use iridesce_flow::{Film, PRESETS, Parameters};
use iridesce_thickness::{LensGap, swirls as swirled};

use crate::face::Face;

fn film(face: &mut Face) -> Result<&mut Film, String> {
    face.film.as_mut().ok_or_else(|| "no film flows yet".to_owned())
}

/// Message: names of the presets.
pub fn presets(face: &mut Face) -> Result<(), String> {
    face.message = PRESETS.join("\n");
    Ok(())
}

/// Text: a preset, then `name=value` lines. Numbers: columns (0: the preset's own), seed. The film that flowed before goes.
pub fn start(face: &mut Face) -> Result<(), String> {
    let text = String::from_utf8(face.text.clone()).map_err(|_| "the text must be UTF-8".to_owned())?;
    let [columns, seed] = face.numbers[..] else {
        return Err("a film needs columns and a seed".to_owned());
    };
    let mut lines = text.lines();
    let mut parameters = Parameters::preset(lines.next().unwrap_or_default()).map_err(|e| e.to_string())?;
    if columns > 0.0 {
        parameters = parameters.with_columns(columns as usize);
    }
    parameters.seed = seed as u64;
    for line in lines.filter(|line| !line.is_empty()) {
        let (name, value) = line.split_once('=').ok_or_else(|| format!("a change is name=value, got {line:?}"))?;
        if name == "sides" {
            parameters.set_sides(value).map_err(|e| e.to_string())?;
            continue;
        }
        let value = value.parse().map_err(|_| format!("{name} must be a number, got {value:?}"))?;
        parameters.set(name, value).map_err(|e| e.to_string())?;
    }
    face.film = None; // its memory first
    face.film = Some(Film::new(parameters).map_err(|e| e.to_string())?);
    tell(face)
}

/// Numbers: a time in s. The film goes on to it.
pub fn advance(face: &mut Face) -> Result<(), String> {
    let [time_s] = face.numbers[..] else {
        return Err("a film goes on to one time".to_owned());
    };
    film(face)?.advance_to(time_s).map_err(|e| e.to_string())?;
    tell(face)
}

/// Text: the name of a parameter. Numbers: its value. What flows goes on from where it is.
pub fn change(face: &mut Face) -> Result<(), String> {
    let [name] = face.lines()?;
    let [value] = face.numbers[..] else {
        return Err(format!("{name} takes one number"));
    };
    film(face)?.change(&name, value).map_err(|e| e.to_string())
}

/// Numbers: row and column of the middle (cells, fractions allowed), speed down and across in m/s, radius in m: air that
/// drags the film along there, for as long as one step.
pub fn stir(face: &mut Face) -> Result<(), String> {
    let [row, column, down, across, radius_m] = face.numbers[..] else {
        return Err("stirring takes row, column, two speeds and a radius".to_owned());
    };
    film(face)?.stir([row, column], [down, across], radius_m).map_err(|e| e.to_string())
}

/// Result: time in s, columns, rows, shares of the first volume (still film, evaporated, swallowed, blackened, drained),
/// when it burst (NaN: not yet), then the thicknesses in nm, row 0 on top.
fn tell(face: &mut Face) -> Result<(), String> {
    let film = film(face)?;
    let (state, parameters) = (film.state(), film.parameters());
    let books = state.books;
    let mut result = vec![state.time_s, parameters.columns as f64, parameters.rows as f64];
    let volumes = [film.volume(), books.evaporated, books.swallowed, books.blackened, books.drained];
    result.extend(volumes.map(|volume| volume / books.start));
    result.push(state.ruptured_s.unwrap_or(f64::NAN));
    result.extend(film.thickness_nm());
    face.result = result;
    Ok(())
}

/// Numbers: least and greatest thickness in nm, seed. Result: a map of 512 x 512, row 0 on top, that repeats both ways.
pub fn swirls(face: &mut Face) -> Result<(), String> {
    let [min_nm, max_nm, seed] = face.numbers[..] else {
        return Err("swirls take two thicknesses and a seed".to_owned());
    };
    let map = swirled(min_nm, max_nm, seed as u64).map_err(|e| e.to_string())?;
    face.result = map.thickness_nm().to_vec();
    Ok(())
}

/// Numbers: radius of the lens in mm, gap at its middle in nm, then distances from the axis in mm. Result: gaps in nm.
pub fn lens_gap(face: &mut Face) -> Result<(), String> {
    let [radius_mm, contact_gap_nm, distances @ ..] = &face.numbers[..] else {
        return Err("a gap takes the radius of its lens and its width at the middle".to_owned());
    };
    let gap = LensGap::new(*radius_mm, *contact_gap_nm).map_err(|e| e.to_string())?;
    face.result = distances.iter().map(|&mm| gap.at_radius(mm)).collect();
    Ok(())
}
