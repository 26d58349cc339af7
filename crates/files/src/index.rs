//! Refractive indices from files: pages of refractiveindex.info, and tables of n, of n and k, or of a permittivity.

use iridesce_optics::medium::MAX_TEXT_BYTES;
use iridesce_optics::{Complex64, Medium, OpticsError};

use crate::axis::{AxisUnit, find_axis, wavelengths};
use crate::report::ReadReport;
use crate::rows::Rows;
use crate::text::decode_text;
use crate::words::quoted;

/// Most columns: a wavelength, n, k. (A header may hold more words than a row.)
const MOST_COLUMNS: usize = 3;

/// What the columns after the wavelength hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    N,
    K,
    /// Real part of the relative permittivity.
    E1,
    /// Imaginary part of the relative permittivity.
    E2,
}

/// The medium in the bytes of a file, its text, and how it was understood. `label` names it, also in errors.
///
/// YAML where a line starts with `DATA:` or the label ends in `.yml` or `.yaml`, otherwise a table: wavelength, n and perhaps
/// k, in any order under their names; without names in that order and in nm. Columns of a permittivity (`e1`, `e2`) become
/// n + ik = sqrt(e1 + i e2). Any other name is refused: another quantity read as n would give a wrong colour without a word.
pub fn read_medium(bytes: &[u8], label: &str) -> Result<(Medium, String, ReadReport), String> {
    if bytes.len() > MAX_TEXT_BYTES {
        return Err(format!("{label}: longer than {} MiB, which no table of an index needs", MAX_TEXT_BYTES >> 20));
    }
    let (text, encoding) = decode_text(bytes).map_err(|why| format!("{label}: {why}"))?;
    let (medium, report) = read_text(&text, label, encoding)?;
    Ok((medium, text, report))
}

fn read_text(text: &str, label: &str, encoding: &str) -> Result<(Medium, ReadReport), String> {
    let lower = label.to_ascii_lowercase();
    let is_yaml =
        lower.ends_with(".yml") || lower.ends_with(".yaml") || text.lines().any(|line| line.starts_with("DATA:"));
    if is_yaml {
        let medium = Medium::from_yaml(text, label).map_err(|error| error.to_string())?;
        let mut report = ReadReport::new(format!("YAML of refractiveindex.info, {encoding}"));
        report.take("wavelength", "DATA", "um", "as these pages have it");
        return Ok((medium, report));
    }
    if let Some(blocks) = blocks(text) {
        return from_blocks(&blocks, label, encoding);
    }
    let rows = Rows::read(text, 1).map_err(|why| match why.contains("no table") {
        true => format!("{label}: holds no rows of nm, n [, k]"),
        false => format!("{label}: {why}"),
    })?;
    let mut report = ReadReport::new(format!("text, {}, {encoding}", rows.dialect));
    strict(&rows, label)?;
    let (table, has_k) = table(&rows, label, &mut report)?;
    let medium =
        Medium::from_rows(&table, has_k, label, &rows.comment).map_err(|error: OpticsError| error.to_string())?;
    Ok((medium, report))
}

/// A table of an index is whole: no gaps, no remarks, nothing behind it.
fn strict(rows: &Rows, label: &str) -> Result<(), String> {
    let at = |line: usize, why: String| Err(format!("{label}:{line}: {why}"));
    let count = rows.names.len();
    if let Some((line, word)) =
        rows.first_missing.as_ref().or(rows.garbage.as_ref()).filter(|(_, word)| !word.is_empty())
    {
        return at(*line, format!("{} is not a finite number", quoted(word)));
    }
    if count > MOST_COLUMNS {
        return at(rows.lines[0], format!("a row holds nm, n and perhaps k: 2 or 3 numbers, got {count}"));
    }
    if let Some((line, cells)) = rows.ragged {
        return at(line, format!("{cells} numbers in this row, but {count} in line {}", rows.lines[0]));
    }
    if let Some((line, _)) = &rows.first_missing {
        return at(*line, format!("a row holds nm, n and perhaps k: a value is missing among {count}"));
    }
    if let Some((line, words)) = &rows.trailer {
        let word =
            words.split([',', ';', '\t', ' ']).find(|word| !word.trim().parse::<f64>().is_ok_and(f64::is_finite));
        return match word {
            Some(word) => at(*line, format!("{} is not a finite number", quoted(word))),
            None => at(*line, "a row holds nm, n and perhaps k: 2 or 3 numbers, got 1".into()),
        };
    }
    Ok(())
}

/// Tables that end before it without saying a unit are more likely in micrometres (up to 20 um) than of soft X-rays.
const SHORTEST_NM: f64 = 20.0;

/// Line, wavelength in nm, n and k of each row, and whether k was given.
type IndexRows = (Vec<(usize, f64, f64, f64)>, bool);

fn table(rows: &Rows, label: &str, report: &mut ReadReport) -> Result<IndexRows, String> {
    let in_file = |why: String| format!("{label}:{}: {why}", rows.lines[0].saturating_sub(1).max(1));
    let axis = find_axis(rows, None).map_err(in_file)?;
    // `wl` heads the tables that index web sites offer for download, which are in micrometres.
    let fallback =
        if rows.names[axis.0].eq_ignore_ascii_case("wl") { AxisUnit::Micrometre } else { AxisUnit::Nanometre };
    if let Some(wrong) = rows.columns[axis.0].iter().position(|value| *value <= 0.0) {
        let value = rows.columns[axis.0][wrong];
        return Err(format!("{label}:{}: a wavelength must be > 0, got {value}", rows.lines[wrong]));
    }
    let nm = wavelengths(rows, axis, None, Some(fallback), report).map_err(in_file)?;
    let longest = nm.iter().copied().fold(0.0, f64::max);
    if longest < SHORTEST_NM && AxisUnit::said(&rows.names[axis.0]).map_err(in_file)?.is_none() {
        return Err(in_file(format!(
            "the wavelengths end at {longest} without a unit; name it in the header, as in \"um,n,k\" or \"nm,n,k\""
        )));
    }
    let (parts, named) = parts(rows, axis.0).map_err(in_file)?;
    let column = |wanted: Part| parts.iter().find(|(part, _)| *part == wanted).map(|&(_, place)| place);
    let line_of = |i: usize| rows.lines[i];
    let why = if named { "its own name" } else { "the order nm, n, k" };
    match [Part::N, Part::K, Part::E1, Part::E2].map(column) {
        [Some(n), k, None, None] => {
            report.take("n", &rows.called(n), "", why);
            if let Some(k) = k {
                report.take("k", &rows.called(k), "", why);
            }
            let row = |i: usize| (line_of(i), nm[i], rows.columns[n][i], k.map_or(0.0, |k| rows.columns[k][i]));
            Ok(((0..nm.len()).map(row).collect(), k.is_some()))
        }
        [None, None, Some(e1), e2] => {
            report.take("permittivity, real part", &rows.called(e1), "", why);
            if let Some(e2) = e2 {
                report.take("permittivity, imaginary part", &rows.called(e2), "", why);
            }
            report.note("n + ik = sqrt(e1 + i e2): the index is computed from the permittivity");
            let row = |i: usize| {
                let index = Complex64::new(rows.columns[e1][i], e2.map_or(0.0, |e2| rows.columns[e2][i])).sqrt();
                (line_of(i), nm[i], index.re, index.im)
            };
            let table: Vec<_> = (0..nm.len()).map(row).collect();
            let has_k = table.iter().any(|row| row.3 != 0.0);
            Ok((table, has_k))
        }
        _ => Err(in_file(format!("the columns must be nm, n and perhaps k; there are {}", rows.list()))),
    }
}

/// What each column beside the axis is, and whether its name says so rather than its place.
fn parts(rows: &Rows, axis: usize) -> Result<(Vec<(Part, usize)>, bool), String> {
    let others: Vec<usize> = (0..rows.names.len()).filter(|&place| place != axis).collect();
    let named = others.iter().any(|&place| !rows.names[place].is_empty());
    let mut parts: Vec<(Part, usize)> = Vec::new();
    for (order, &place) in others.iter().enumerate() {
        let part = match named {
            true => part(&rows.names[place]),
            false => Some(if order == 0 { Part::N } else { Part::K }),
        };
        let Some(part) = part else {
            return Err(format!(
                "the column {} is neither n nor k (nor e1, e2 of a permittivity); the columns must be nm, n and perhaps k",
                quoted(&rows.called(place))
            ));
        };
        if parts.iter().any(|(known, _)| *known == part) {
            return Err(format!("two columns are {}", quoted(&rows.called(place))));
        }
        parts.push((part, place));
    }
    Ok((parts, named))
}

/// What a column is by its name.
fn part(name: &str) -> Option<Part> {
    let lower = name.to_lowercase();
    let word: String = lower.chars().filter(|c| c.is_alphanumeric() || *c == '\'').collect();
    match word.as_str() {
        "n" | "index" | "ri" | "refractiveindex" | "refractiveindexn" | "nindex" | "ren" | "brechzahl" => Some(Part::N),
        "k" | "kappa" | "extinction" | "extinctioncoefficient" | "extinctioncoefficientk" | "imn" => Some(Part::K),
        "e1" | "eps1" | "epsilon1" | "er" | "epsr" | "reeps" | "reepsilon" | "e'" | "ε1" => Some(Part::E1),
        "e2" | "eps2" | "epsilon2" | "ei" | "epsi" | "imeps" | "imepsilon" | "e''" | "ε2" => Some(Part::E2),
        _ => None,
    }
}

/// Rows under `wl,n` and, further down, under `wl,k`: line, wavelength, value, all as they stand.
struct Blocks<'a> {
    n: Vec<(usize, &'a str, f64)>,
    k: Vec<(usize, &'a str, f64)>,
}

/// The blocks of a download of an index web site; `None` for any other file.
fn blocks(text: &str) -> Option<Blocks<'_>> {
    let mut blocks = Blocks { n: Vec::new(), k: Vec::new() };
    let mut part = None;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        let heads = line.to_lowercase().replace(['\t', ';'], ",");
        match heads.as_str() {
            "" => {}
            "wl,n" => part = Some(Part::N),
            "wl,k" => part = Some(Part::K),
            _ => {
                let (x, y) = line.split_once([',', '\t', ';'])?;
                let y = y.trim().parse::<f64>().ok().filter(|value| value.is_finite())?;
                x.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0)?;
                match part? {
                    Part::N => blocks.n.push((index + 1, x.trim(), y)),
                    _ => blocks.k.push((index + 1, x.trim(), y)),
                }
            }
        }
    }
    (!blocks.n.is_empty() && !blocks.k.is_empty()).then_some(blocks)
}

fn from_blocks(blocks: &Blocks<'_>, label: &str, encoding: &str) -> Result<(Medium, ReadReport), String> {
    // At the wavelengths of n; where the blocks stand on different ones, k lies linearly between its own.
    let nm = |text: &str| AxisUnit::Micrometre.to_nm(text.parse().unwrap_or(f64::NAN));
    let mut k: Vec<(f64, f64)> = blocks.k.iter().map(|&(_, x, value)| (nm(x), value)).collect();
    k.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut outside = 0;
    let table: Vec<(usize, f64, f64, f64)> = blocks
        .n
        .iter()
        .filter_map(|&(line, x, n)| {
            let x = nm(x);
            let above = k.partition_point(|pair| pair.0 < x);
            let value = match (k.get(above), above.checked_sub(1).map(|below| k[below])) {
                (Some(&(at, value)), _) if at == x => value,
                (Some(&(right, b)), Some((left, a))) => a + (b - a) * (x - left) / (right - left),
                _ => {
                    outside += 1;
                    return None;
                }
            };
            Some((line, x, n, value))
        })
        .collect();
    let mut report = ReadReport::new(format!("text, blocks wl,n and wl,k, {encoding}"));
    report.take("wavelength", "wl", "um", "as downloads of refractiveindex.info have it");
    report.take("n", "n", "", "its own name");
    report.take("k", "k", "", "its own name");
    if outside > 0 {
        report.drop(format!("{outside} rows of n outside the range of k"));
    }
    let medium = Medium::from_rows(&table, true, label, "").map_err(|error| error.to_string())?;
    Ok((medium, report))
}

#[cfg(test)]
mod tests;
