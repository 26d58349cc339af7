//! The wavelength axis of a table: which column, in which unit, and why.

use crate::report::ReadReport;
use crate::rows::Rows;
use crate::words::quoted;

/// Wavelengths that any table of ours can mean, nm: from the vacuum ultraviolet to the far infrared.
pub const PLAUSIBLE_NM: (f64, f64) = (100.0, 50_000.0);
/// nm in a cm.
const PER_CM_NM: f64 = 1e7;
/// h c in eV nm, CODATA 2018 (exact by the definition of the SI).
const EV_NM: f64 = 1_239.841_984;

/// Unit of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisUnit {
    /// Nanometres.
    Nanometre,
    /// Micrometres.
    Micrometre,
    /// Ångström, 0.1 nm.
    Angstrom,
    /// Metres.
    Metre,
    /// Wavenumbers, 1/cm.
    PerCentimetre,
    /// Photon energies, eV.
    Electronvolt,
}

impl AxisUnit {
    /// The unit that a user asks for.
    pub fn named(name: &str) -> Result<AxisUnit, String> {
        let plain = name.trim().to_lowercase().replace(['\u{b5}', '\u{3bc}'], "u");
        match plain.as_str() {
            "nm" => Ok(AxisUnit::Nanometre),
            "um" => Ok(AxisUnit::Micrometre),
            "angstrom" => Ok(AxisUnit::Angstrom),
            "cm-1" | "1/cm" | "cm^-1" => Ok(AxisUnit::PerCentimetre),
            "ev" => Ok(AxisUnit::Electronvolt),
            _ => Err(format!("unit must be \"nm\", \"um\", \"angstrom\", \"cm-1\" or \"ev\", got {}", quoted(name))),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            AxisUnit::Nanometre => "nm",
            AxisUnit::Micrometre => "um",
            AxisUnit::Angstrom => "angstrom",
            AxisUnit::Metre => "m",
            AxisUnit::PerCentimetre => "cm-1",
            AxisUnit::Electronvolt => "ev",
        }
    }

    /// A number of this unit in nm.
    pub fn to_nm(self, value: f64) -> f64 {
        match self {
            AxisUnit::Nanometre => value,
            AxisUnit::Micrometre => shifted(value, 3),
            AxisUnit::Angstrom => shifted(value, -1),
            AxisUnit::Metre => shifted(value, 9),
            AxisUnit::PerCentimetre => PER_CM_NM / value,
            AxisUnit::Electronvolt => EV_NM / value,
        }
    }

    /// The unit that a column's own name says; an error where it names one that is none of an axis.
    pub fn said(name: &str) -> Result<Option<AxisUnit>, String> {
        let lower = name.to_lowercase().replace(['\u{b5}', '\u{3bc}'], "u");
        let tight: String = lower.chars().filter(|letter| !letter.is_whitespace() && *letter != '^').collect();
        let words: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let starts = |starts: &[&str]| words.iter().any(|word| starts.iter().any(|start| word.starts_with(start)));
        let is = |names: &[&str]| words.iter().any(|word| names.contains(word));
        if tight.contains("cm-1")
            || tight.contains("1/cm")
            || tight.contains("cm\u{207b}\u{b9}")
            || tight.contains("wavenumber")
            || tight.contains("wellenzahl")
        {
            return Ok(Some(AxisUnit::PerCentimetre));
        }
        if is(&["um"]) || starts(&["micron", "micromet", "mikromet"]) {
            return Ok(Some(AxisUnit::Micrometre));
        }
        if is(&["nm"]) || starts(&["nanomet"]) {
            return Ok(Some(AxisUnit::Nanometre));
        }
        if is(&["ev"]) || starts(&["electronvolt"]) || lower.contains("photon energy") {
            return Ok(Some(AxisUnit::Electronvolt));
        }
        if lower.contains(['\u{e5}', '\u{212b}'])
            || starts(&["angstr"])
            || tight.contains("(a)")
            || tight.contains("[a]")
        {
            return Ok(Some(AxisUnit::Angstrom));
        }
        if tight == "m" || tight.contains("(m)") || tight.contains("[m]") {
            return Ok(Some(AxisUnit::Metre));
        }
        // A unit in brackets that is none of these is no wavelength.
        if let Some(inside) = lower.split(['[', '(']).nth(1).and_then(|rest| rest.split([']', ')']).next())
            && ["mm", "cm", "thz", "ghz", "hz", "s", "ps", "fs", "ms", "deg", "pixel", "px", "kev", "mev"]
                .contains(&inside.trim())
        {
            return Err(format!(
                "the axis {} is in {}; wavelengths in nm, um, angstrom, cm-1 or ev are read (unit=)",
                quoted(name),
                quoted(inside.trim())
            ));
        }
        Ok(None)
    }
}

/// Whether a column's name says that it is the axis.
pub fn is_axis_name(name: &str) -> bool {
    let lower = name.to_lowercase();
    let first = lower.split(|c: char| !c.is_alphanumeric()).find(|word| !word.is_empty()).unwrap_or("");
    ["wl", "wvl", "lambda", "λ", "nm", "um", "energy", "photon", "ev", "nanometers", "nanometres", "micrometers"]
        .contains(&first)
        || ["wave", "wellen", "longitud", "longueur", "lunghezza", "vlnova", "nanomet"]
            .iter()
            .any(|start| first.starts_with(start))
}

/// Whether the first column only numbers the rows beside that axis.
pub fn is_counted(rows: &Rows, axis: usize) -> bool {
    axis > 0 && rows.names.len() > 2 && numbers_rows(rows, 0)
}

/// Whether a column only numbers the rows: 0, 1, 2, ... without a name or with one that says so.
fn numbers_rows(rows: &Rows, place: usize) -> bool {
    let name = rows.names[place].to_lowercase();
    let is_counter_name = name.is_empty()
        || ["#", "no", "no.", "nr", "nr.", "index", "row", "point", "pixel", "unnamed: 0", "id"]
            .contains(&name.as_str());
    let values = &rows.columns[place];
    let first = values[0];
    is_counter_name
        && (first == 0.0 || first == 1.0)
        && values.len() >= 2
        && values.iter().enumerate().all(|(i, value)| *value == first + i as f64)
}

/// The place of the axis, and why it is that.
pub fn find_axis(rows: &Rows, asked: Option<&str>) -> Result<(usize, &'static str), String> {
    if let Some(asked) = asked {
        return Ok((rows.place(asked, "wavelength_column")?, "wavelength_column="));
    }
    if let Some(place) = rows.names.iter().position(|name| is_axis_name(name)) {
        return Ok((place, "its own name"));
    }
    if rows.names.len() > 2 && numbers_rows(rows, 0) {
        return Ok((1, "the first column only numbers the rows"));
    }
    Ok((0, "the first column"))
}

/// The column at `place` in nm; what was taken goes into the report. `fallback` is the unit of nameless axes of this kind of
/// file, where it has one; otherwise the size of the numbers decides, or the answer is a question.
pub fn wavelengths(
    rows: &Rows,
    (place, found): (usize, &str),
    unit: Option<&str>,
    fallback: Option<AxisUnit>,
    report: &mut ReadReport,
) -> Result<Vec<f64>, String> {
    let name = rows.called(place);
    let values = &rows.columns[place];
    let (unit, why) = match unit {
        Some(unit) => (AxisUnit::named(unit)?, "unit="),
        None => match (AxisUnit::said(&rows.names[place])?, fallback) {
            (Some(unit), _) => (unit, "its own name"),
            (None, Some(unit)) => (unit, "as this kind of file has it"),
            (None, None) => {
                let unit = guessed(values, &name, is_axis_name(&rows.names[place]))?;
                report.note(format!("wavelengths are taken as {}: a guess by the size of the numbers", unit.name()));
                (unit, "a guess by the size of the numbers")
            }
        },
    };
    let nm: Vec<f64> = values.iter().map(|&value| unit.to_nm(value)).collect();
    let (low, high) = extent(&nm);
    if fallback.is_none() && !(PLAUSIBLE_NM.0 <= low && high <= PLAUSIBLE_NM.1) {
        return Err(format!(
            "wavelengths {low:.6} to {high:.6} nm after {} ({why}) in {}; is that the axis's unit? unit=\"nm\", \"um\", \
             \"angstrom\", \"cm-1\", \"ev\"; or another column is the axis: wavelength_column=",
            quoted(unit.name()),
            quoted(&name)
        ));
    }
    if unit != AxisUnit::Nanometre {
        report.note(format!("wavelengths are in {}", unit.name()));
    }
    report.take("wavelength", &name, unit.name(), if why == "its own name" { found } else { why });
    Ok(nm)
}

/// A number times ten to the `shift`, rounded once: 0.1879 um times 1000 would be 187.89999999999998 nm, so that 187.9 nm
/// would fall outside a table that begins there.
fn shifted(value: f64, shift: i32) -> f64 {
    format!("{value}e{shift}").parse().unwrap_or(f64::NAN)
}

fn extent(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)))
}

/// The unit by the size of the numbers, where only one is plausible.
fn guessed(values: &[f64], name: &str, is_named: bool) -> Result<AxisUnit, String> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Err(format!("{} holds no numbers", quoted(name)));
    };
    let middle = sorted[sorted.len() / 2];
    let falls = values.first() > values.last();
    let ask = |what: &str| {
        Err(format!(
            "{} runs from {low} to {high} without a unit: {what}? say the unit: nm, um, angstrom, cm-1 or ev (unit=); or \
             another column is the axis (wavelength_column=)",
            quoted(name)
        ))
    };
    if (100.0..=3000.0).contains(&middle) {
        // Infrared spectra run from 4000 down to 400 1/cm.
        return if !is_named && falls && low >= 300.0 && high >= 3000.0 {
            ask("1/cm or nm")
        } else {
            Ok(AxisUnit::Nanometre)
        };
    }
    if (0.1..=20.0).contains(&middle) {
        return if !is_named && low >= 1.0 && high <= 7.0 { ask("um or ev") } else { Ok(AxisUnit::Micrometre) };
    }
    if middle > 0.0 && middle < 1e-4 {
        return Ok(AxisUnit::Metre);
    }
    if (3000.0..=100_000.0).contains(&middle) {
        return ask(if middle < 12_000.0 { "angstrom, 1/cm or nm" } else { "1/cm or nm" });
    }
    Err(format!(
        "its column {}, around {middle}, is no wavelength in nm or um; say the unit: nm, um, angstrom, cm-1, ev (unit=), or \
         which column is the axis (wavelength_column=)",
        quoted(name)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_said_by_the_columns_own_name() {
        for (name, unit) in [
            ("Wave [nm]", Some(AxisUnit::Nanometre)),
            ("Wellenlänge nm.", Some(AxisUnit::Nanometre)),
            ("Wellenlänge [µm]", Some(AxisUnit::Micrometre)),
            ("lambda (micron)", Some(AxisUnit::Micrometre)),
            ("lambda (Angstrom)", Some(AxisUnit::Angstrom)),
            ("wl (A)", Some(AxisUnit::Angstrom)),
            ("Wavenumber", Some(AxisUnit::PerCentimetre)),
            ("k [cm^-1]", Some(AxisUnit::PerCentimetre)),
            ("Photon energy (eV)", Some(AxisUnit::Electronvolt)),
            ("x (m)", Some(AxisUnit::Metre)),
            ("wavelength", None),
            ("", None),
        ] {
            assert_eq!(AxisUnit::said(name), Ok(unit), "{name}");
        }
        assert!(AxisUnit::said("f [THz]").unwrap_err().contains("\"thz\""));
    }

    #[test]
    fn what_two_units_explain_is_asked() {
        let run = |from: f64, to: f64| (0..50).map(|i| from + (to - from) * f64::from(i) / 49.0).collect::<Vec<_>>();
        assert_eq!(guessed(&run(400.0, 900.0), "", false), Ok(AxisUnit::Nanometre));
        assert_eq!(guessed(&run(2500.0, 190.0), "", false), Ok(AxisUnit::Nanometre));
        assert!(guessed(&run(4000.0, 400.0), "x", false).unwrap_err().contains("1/cm or nm?"));
        assert!(guessed(&run(25_000.0, 11_000.0), "x", false).unwrap_err().contains("say the unit"));
        assert_eq!(guessed(&run(0.4, 0.9), "", false), Ok(AxisUnit::Micrometre));
        assert!(guessed(&run(1.5, 4.0), "x", false).unwrap_err().contains("um or ev?"));
        assert_eq!(guessed(&run(1.5, 4.0), "wavelength", true), Ok(AxisUnit::Micrometre));
        assert_eq!(guessed(&run(4e-7, 9e-7), "", false), Ok(AxisUnit::Metre));
        assert!(guessed(&run(1e6, 2e6), "x", false).unwrap_err().contains("no wavelength in nm or um"));
    }
}
