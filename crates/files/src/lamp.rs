//! Lamps: relative spectral power against wavelength, as anyone measured it.

use iridesce_optics::color::Illuminant;

use crate::axis::{find_axis, wavelengths};
use crate::report::ReadReport;
use crate::rows::Rows;
use crate::text::decode_text;
use crate::words::{listed, quoted};

/// Largest file of a lamp, bytes; one of 0.1 nm steps has 100 KiB.
pub const MAX_LAMP_BYTES: u64 = 16 << 20;
/// Power below 0 down to this share of the greatest is noise of the spectrometer, and counts as 0.
const NOISE: f64 = 0.05;
/// Greatest power that sums over wavelengths hold; tables beyond it are divided by their greatest value.
const MOST_POWER: f64 = 1e100;

/// What a column says that is named by a reflectance or a transmittance.
const NO_LIGHT: &str = "says what becomes of light, and is no light";
/// Parts of a column's name that say it holds no power per wavelength, and what is to be done.
const OTHER_QUANTITIES: [(&[&str], &str); 6] = [
    (
        &["photon", "quanta", "quantum", "ppfd", "mol/"],
        "counts photons; divide each value by its wavelength, which makes power of it",
    ),
    (&["count", "cts", "adu"], "holds counts of a detector; divide them by its response to a known lamp"),
    (&["db"], "is in decibels; save it as linear power"),
    (
        &["/ev", "per ev", "/thz", "/hz", "per hz", "/cm-1", "per cm-1", "(cm-1", "wavenumber"],
        "is power per energy or frequency; divide each value by the square of its wavelength",
    ),
    (&["transmit", "transmission", "reflect", "absorb", "absorption", "response", "efficiency"], NO_LIGHT),
    (
        &["lumen", "candela", "luminous", "luminance", "illuminance", "lux", "lm", "lx", "cd"],
        "is weighted by what an eye sees; divide it by the eye's sensitivity V, which makes power of it",
    ),
];

/// What a column of that name holds instead of power per wavelength, where its name says so.
fn other_quantity(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    let words: Vec<&str> = name.split(|c: char| !c.is_alphanumeric()).collect();
    // R, %R, T (%): a letter alone. (A is the CIE's lamp as well as an absorbance.)
    if matches!(words.iter().filter(|word| !word.is_empty()).collect::<Vec<_>>()[..], [&"r"] | [&"t"]) {
        return Some(NO_LIGHT);
    }
    OTHER_QUANTITIES.iter().find_map(|(parts, meaning)| {
        let is_said = |part: &&str| match *part {
            // Short words stand alone: "db" is in "feedback" too.
            "db" => words.iter().any(|word| word.starts_with("db") && word.len() <= 3),
            // ("flux" is a word for power, too.)
            "cts" | "adu" | "lux" | "lm" | "lx" | "cd" => words.contains(part),
            part => name.contains(part),
        };
        parts.iter().any(is_said).then_some(*meaning)
    })
}

/// The lamp in the bytes of a file; `label` names it, also in errors.
pub fn read_lamp(bytes: &[u8], label: &str) -> Result<(Illuminant, ReadReport), String> {
    let in_file = |why: String| format!("{label}: {why}");
    let (text, encoding) = decode_text(bytes).map_err(in_file)?;
    let rows = Rows::read(&text, 1).map_err(|why| {
        if why.contains("no table") {
            format!("{label}: an illuminant needs two rows wavelength_nm,power at least: it {why}")
        } else {
            in_file(why)
        }
    })?;
    let mut report = ReadReport::new(format!("text, {}, {encoding}", rows.dialect));
    only_numbers(&rows, label)?;
    let axis = find_axis(&rows, None).map_err(in_file)?;
    let place = only_other(&rows, axis.0, label)?;
    if let Some(at_row) = rows.columns[axis.0].iter().position(|value| *value <= 0.0) {
        let (line, value) = (rows.lines[at_row], rows.columns[axis.0][at_row]);
        return Err(format!("{label}:{line}: wavelengths must be > 0, got {value}"));
    }
    let nm = wavelengths(&rows, axis, None, None, &mut report).map_err(in_file)?;
    if let Some(meaning) = other_quantity(&rows.names[place]) {
        let name = quoted(&rows.called(place));
        return Err(format!("{label}: the column {name} {meaning}; a lamp is power per wavelength, in any unit"));
    }
    report.take("power", &rows.called(place), "relative", "the only column beside the axis");
    let power = cleaned(&rows, place, label, &mut report)?;
    let (nm, power) = ascending(nm, power, &rows.lines, label, &mut report)?;
    let made = Illuminant::from_table(nm, power, label).map_err(|error| error.to_string())?;
    Ok((made, report))
}

/// Refuses rows with words or gaps in them, and what looks like further rows.
fn only_numbers(rows: &Rows, label: &str) -> Result<(), String> {
    let starts_a_number = |words: &str| words.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'));
    let trailer = rows.trailer.as_ref().filter(|(_, words)| starts_a_number(words));
    match rows.first_missing.as_ref().or(rows.garbage.as_ref()).or(trailer) {
        None => Ok(()),
        Some((line, word)) => {
            Err(format!("{label}:{line}: expected two finite numbers (wavelength_nm, power), got {}", quoted(word)))
        }
    }
}

/// The one column beside the axis.
fn only_other(rows: &Rows, axis: usize, label: &str) -> Result<usize, String> {
    let others: Vec<usize> = (0..rows.names.len()).filter(|&place| place != axis).collect();
    if let &[place] = others.as_slice() {
        return Ok(place);
    }
    let names: Vec<String> = others.iter().map(|&place| rows.called(place)).collect();
    Err(format!(
        "{label}:{}: expected two numbers a row (wavelength_nm, power), there are {}: {}",
        rows.lines[0],
        rows.names.len(),
        listed(names.iter().map(String::as_str))
    ))
}

/// Power >= 0, small enough for sums.
fn cleaned(rows: &Rows, place: usize, label: &str, report: &mut ReadReport) -> Result<Vec<f64>, String> {
    let mut power = rows.columns[place].clone();
    let top = power.iter().copied().fold(0.0, f64::max);
    let negative: Vec<usize> = (0..power.len()).filter(|&i| power[i] < 0.0).collect();
    if let Some(&deep) = negative.iter().find(|&&i| power[i] < -NOISE * top) {
        return Err(format!("{label}:{}: power must be >= 0, got {}", rows.lines[deep], power[deep]));
    }
    if !negative.is_empty() {
        report.note(format!("{} values below 0, within 5 % of the greatest, count as 0", negative.len()));
        negative.iter().for_each(|&i| power[i] = 0.0);
    }
    if top > MOST_POWER {
        report.note("the values are divided by their greatest, so that their sums stay finite");
        power.iter_mut().for_each(|power| *power /= top);
    }
    Ok(power)
}

/// Every wavelength once, in order. `lines` are those they stand on.
fn ascending(
    nm: Vec<f64>,
    power: Vec<f64>,
    lines: &[usize],
    label: &str,
    report: &mut ReadReport,
) -> Result<(Vec<f64>, Vec<f64>), String> {
    let mut pairs: Vec<(f64, f64, usize)> =
        nm.into_iter().zip(power).zip(lines).map(|((nm, power), &line)| (nm, power, line)).collect();
    if pairs.windows(2).any(|pair| pair[1].0 < pair[0].0) {
        report.note("the wavelengths did not ascend; they have been sorted");
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(pair) = pairs.windows(2).find(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1) {
        let (first, second) = (pair[0].2.min(pair[1].2), pair[0].2.max(pair[1].2));
        let nm = pair[0].0;
        return Err(format!("{label}:{second}: the wavelength {nm} nm stands on line {first} too, with another power"));
    }
    pairs.dedup_by(|a, b| a.0 == b.0);
    Ok(pairs.into_iter().map(|(nm, power, _)| (nm, power)).unzip())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<(Illuminant, ReadReport), String> {
        read_lamp(text.as_bytes(), "lamp.csv")
    }

    #[test]
    fn lamps_in_any_dialect() {
        for text in [
            "\u{feff}nm;power\n# lamp\n400;1\n500;3 # peak\n\n600;0\n",
            "nm;power\n600;0,0\n500;3,0\n400;1,0\n",
            "um\tpower\n0.4\t1\n0.5\t3\n0.6\t0\n",
            "nm,A\n400,1\n500,3\n600,0\n",
            "400,1\n500,3\n600,-0.01\n",
            "nm,feedback lamp W/m2/nm\n400,1\n500,3\n600,0\n",
            // Three places behind the point and a whole power are two numbers, and no thousands.
            "0.400,1\n0.500,3\n0.600,0\n",
        ] {
            let (light, _) = read(text).unwrap();
            assert_eq!((light.power(450.0), light.power(399.0), light.name()), (2.0, 0.0, "lamp.csv"), "{text:?}");
            assert_eq!(light.power(600.0), 0.0);
        }
        assert!(read("400,1\n500,3\n600,-0.01\n").unwrap().1.to_string().contains("count as 0"));
    }

    #[test]
    fn one_enormous_value_leaves_a_finite_white() {
        let (light, report) = read("400,1\n500,1e308\n600,1\n700,1\n").unwrap();
        let white = light.white(iridesce_optics::color::Observer::Cie1931);
        assert!(white.iter().all(|value| value.is_finite() && *value > 0.0), "{white:?}");
        assert!(report.to_string().contains("divided by their greatest"));
    }

    #[test]
    fn what_is_no_lamp_is_refused_with_its_line() {
        for (text, wanted) in [
            ("", "two rows"),
            ("400,1", "two rows"),
            ("400,1\n400,2", "lamp.csv:2"),
            ("400,1\n500,-2", "lamp.csv:2: power must be >= 0"),
            ("400,1\n500,x", "lamp.csv:2"),
            ("400,1\n500,nan", "finite"),
            ("400,1\n500,", "two finite numbers"),
            ("400,1,2\n500,1,2", "two numbers"),
            ("0,1\n500,2", "> 0"),
            ("100,1\n200,2", "no visible light"),
            ("400,0\n500,0", "no visible light"),
            ("nm,photon flux\n400,1\n500,2", "counts photons"),
            ("nm,umol/m2/s\n400,1\n500,2", "counts photons"),
            ("nm,Sample (counts)\n400,1\n500,2", "counts of a detector"),
            ("nm,level [dBm]\n400,1\n500,2", "decibels"),
            ("nm,lm\n400,1\n500,2", "weighted by what an eye sees"),
            ("nm,illuminance (lux)\n400,1\n500,2", "weighted by what an eye sees"),
            ("eV,W/m2/eV\n2,1\n3,2", "per energy or frequency"),
            ("nm,Transmittance\n400,1\n500,2", "no light"),
            ("nm,R\n400,1\n500,2", "no light"),
            ("nm,%T\n400,1\n500,2", "no light"),
            ("f [THz],power\n400,1\n500,2", "\"thz\""),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(wanted), "{text:?}: {message}");
        }
    }
}
