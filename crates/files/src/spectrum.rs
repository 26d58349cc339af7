//! Spectra as spectrometers write them: which column, in which units, and everything that was decided on the way.

use crate::axis::{find_axis, is_counted, wavelengths};
use crate::jcamp;
use crate::report::ReadReport;
use crate::role::{Role, roles};
use crate::rows::Rows;
use crate::text::decode_text;
use crate::words::{harmless, listed, quoted};

/// Largest file of a spectrum, bytes.
pub const MAX_SPECTRUM_BYTES: u64 = 64 << 20;
/// Values beyond this are no counts of any detector: a damaged digit.
const MOST_COUNTS: f64 = 1e12;
/// Points side by side at the greatest count from which on a detector is taken as saturated.
const SATURATED: usize = 3;

/// What a user decides about a spectrum; `None`: as the file tells.
#[derive(Debug, Clone, Default)]
pub struct SpectrumChoice<'a> {
    /// Name (a part of it) or number, from 1, of the measurement.
    pub column: Option<&'a str>,
    /// Name or number of the axis.
    pub wavelength_column: Option<&'a str>,
    /// Unit of the axis: `nm`, `um`, `angstrom`, `cm-1`, `ev`.
    pub unit: Option<&'a str>,
    /// Unit of the values: `ratio`, `percent`, `counts`, `absorbance`.
    pub unit_y: Option<&'a str>,
    /// `reflectance` or `transmittance`: which column to prefer.
    pub quantity: &'a str,
    /// The part that will be used, nm: what tells percent from ratios.
    pub range_nm: Option<(f64, f64)>,
}

/// A spectrum from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Ascending, nm.
    pub wavelength_nm: Vec<f64>,
    /// Ratios, or counts; NaN where a value is missing.
    pub values: Vec<f64>,
    /// Name of the column.
    pub column: String,
    /// How the file was understood.
    pub report: ReadReport,
}

/// Unit of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ValueUnit {
    Ratio,
    Percent,
    Counts,
    Absorbance,
}

/// The spectrum in the bytes of a file.
pub fn read_spectrum(bytes: &[u8], choice: &SpectrumChoice<'_>) -> Result<Spectrum, String> {
    let (text, encoding) = decode_text(bytes)?;
    read(&text, encoding, choice).map_err(|why| harmless_long(&why))
}

/// Messages here list columns: longer than others, and as harmless.
fn harmless_long(why: &str) -> String {
    let mut rest: Vec<char> = why.chars().collect();
    let is_cut = rest.len() > 300;
    rest.truncate(300);
    let mut clean: String = rest.chunks(150).map(|part| harmless(&part.iter().collect::<String>())).collect();
    if is_cut {
        clean.push_str("...");
    }
    clean
}

fn read(text: &str, encoding: &str, choice: &SpectrumChoice<'_>) -> Result<Spectrum, String> {
    let (rows, mut report) = if jcamp::is_jcamp(text) {
        (jcamp::read(text)?, ReadReport::new(format!("JCAMP-DX, {encoding}")))
    } else {
        let rows = Rows::read(text, 2)?;
        let report = ReadReport::new(format!("text, {}, {encoding}", rows.dialect));
        (rows, report)
    };
    let axis = find_axis(&rows, choice.wavelength_column)?;
    let nm = wavelengths(&rows, axis, choice.unit, None, &mut report)?;
    let (column, values, unit) = measurement(&rows, axis.0, choice, &mut report)?;
    let values = in_ratios(&nm, values, unit, choice, &column, &mut report)?;
    let (wavelength_nm, values) = in_order(nm, values, &mut report);
    if !values.iter().any(|value| value.is_finite()) {
        return Err(format!("column {} holds no number", quoted(&column)));
    }
    for (line, count) in &rows.others {
        report.drop(format!("a second table of {count} rows from line {line} on"));
    }
    if rows.missing > 0 {
        report.drop(format!("{} values of the table are missing", rows.missing));
    }
    Ok(Spectrum { wavelength_nm, values, column, report })
}

/// The name of a column, its numbers, and its unit with what says it, where something does.
type ValueColumn = (String, Vec<f64>, Option<(ValueUnit, &'static str)>);

/// What the columns beside the axis are.
struct Columns<'a> {
    rows: &'a Rows,
    axis: usize,
    roles: Vec<Role>,
    others: Vec<usize>,
}

/// Where the measurement is.
enum Found {
    /// In a column, and why in that one.
    Column(usize, &'static str),
    /// In counts of the dark, the lamp and the sample.
    Counts([usize; 3]),
}

impl<'a> Columns<'a> {
    fn new(rows: &'a Rows, axis: usize) -> Self {
        let is_other = |&place: &usize| place != axis && !(place == 0 && is_counted(rows, axis));
        let others = (0..rows.names.len()).filter(is_other).collect();
        Self { rows, axis, roles: roles(&rows.names, axis), others }
    }

    fn having(&self, role: Role) -> Vec<usize> {
        self.others.iter().copied().filter(|&place| self.roles[place] == role).collect()
    }

    fn list(&self, places: &[usize]) -> String {
        let names: Vec<String> = places.iter().map(|&place| self.rows.called(place)).collect();
        listed(names.iter().map(String::as_str))
    }

    /// The column that was asked for.
    fn asked(&self, asked: &str) -> Result<Found, String> {
        let place = self.rows.place(asked, "column").map_err(|why| why.replace("must be 1 to", "must be 2 to"))?;
        if place == self.axis {
            return Err(format!("column must be 2 to {}, got {asked}: that is the axis", self.rows.names.len()));
        }
        Ok(Found::Column(place, "column="))
    }

    /// The column that the names tell.
    fn by_name(&self, quantity: &str) -> Result<Found, String> {
        let wanted = if quantity == "transmittance" { Role::Transmittance } else { Role::Reflectance };
        match self.having(wanted).as_slice() {
            &[place] => Ok(Found::Column(place, "its own name")),
            [] => match (&*self.having(Role::Dark), &*self.having(Role::Lamp), &*self.having(Role::Sample)) {
                (&[dark], &[lamp], &[sample]) => Ok(Found::Counts([dark, lamp, sample])),
                _ => self.by_what_is_left(wanted, quantity),
            },
            several => Err(format!(
                "which column is the {quantity}? {} are named so; column= takes a name or a number",
                self.list(several)
            )),
        }
    }

    /// No column has the name that is wanted: one of another name, where only one can be meant.
    fn by_what_is_left(&self, wanted: Role, quantity: &str) -> Result<Found, String> {
        let (other, other_name) = match wanted {
            Role::Transmittance => (Role::Reflectance, "reflectance"),
            _ => (Role::Transmittance, "transmittance"),
        };
        let called = |place: usize| quoted(&self.rows.called(place));
        match (&*self.having(Role::Absorbance), &*self.having(other), &*self.others) {
            (&[place], _, _) if wanted == Role::Transmittance => Ok(Found::Column(place, "its own name")),
            (&[place], [], _) => Err(format!(
                "{} is absorbance; a {quantity} cannot be had from it (quantity=\"transmittance\" converts it, column= \
                 takes another)",
                called(place)
            )),
            (_, &[place], _) => Err(format!(
                "its column {} is no {quantity}; quantity=\"{other_name}\" takes it (column= another)",
                called(place)
            )),
            (_, _, &[place]) => Ok(Found::Column(place, "the only one beside the axis")),
            _ => match (&*self.having(Role::Sample), &*self.having(Role::Unknown)) {
                (&[place], _) | ([], &[place]) => Ok(Found::Column(place, "the only one that can be it")),
                _ => Err(format!(
                    "which column is the {quantity}? there are {}; column= takes a name or a number",
                    self.list(&self.others)
                )),
            },
        }
    }

    /// The unit of a column, where its name says it.
    fn unit(&self, place: usize) -> Option<ValueUnit> {
        let lower = self.rows.names[place].to_lowercase();
        let is_percent = ["%", "percent", "prozent"].into_iter().any(|word| lower.contains(word));
        match self.roles[place] {
            _ if is_percent => Some(ValueUnit::Percent),
            Role::Absorbance => Some(ValueUnit::Absorbance),
            Role::Dark | Role::Lamp | Role::Sample => Some(ValueUnit::Counts),
            _ => None,
        }
    }
}

/// The measurement.
fn measurement(
    rows: &Rows,
    axis: usize,
    choice: &SpectrumChoice<'_>,
    report: &mut ReadReport,
) -> Result<ValueColumn, String> {
    let columns = Columns::new(rows, axis);
    let found = match choice.column {
        Some(asked) => columns.asked(asked)?,
        None => columns.by_name(choice.quantity)?,
    };
    let (place, why) = match found {
        Found::Counts(places) => return Ok(ratio_of_counts(rows, places, choice.quantity, report)),
        Found::Column(place, why) => (place, why),
    };
    let name = rows.called(place);
    let column = rows.columns[place].clone();
    if let Some((line, word)) = &rows.garbage
        && column.iter().zip(&rows.lines).any(|(value, at)| at == line && value.is_nan())
    {
        report.drop(format!("line {line}: {} is no number", quoted(word)));
    }
    let unused: Vec<usize> = columns.others.iter().copied().filter(|&other| other != place).collect();
    if !unused.is_empty() {
        report.note(format!("column {} of {} is used: {}", place + 1, rows.names.len(), quoted(&name)));
        report.drop(format!("the columns {}", columns.list(&unused)));
    }
    report.take(choice.quantity, &name, "", why);
    Ok((name, column, columns.unit(place).map(|unit| (unit, "its own name"))))
}

/// (sample - dark) / (reference - dark).
fn ratio_of_counts(
    rows: &Rows,
    [dark, lamp, sample]: [usize; 3],
    quantity: &str,
    report: &mut ReadReport,
) -> (String, Vec<f64>, Option<(ValueUnit, &'static str)>) {
    let top = rows.columns[sample].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let saturated = saturated(&rows.columns[sample], top);
    let ratio = (0..rows.lines.len())
        .map(|i| {
            let [dark, lamp, sample] = [dark, lamp, sample].map(|place| rows.columns[place][i]);
            let light = lamp - dark;
            if light > 0.0 && !saturated[i] { (sample - dark) / light } else { f64::NAN }
        })
        .collect();
    let [dark, lamp, sample] = [dark, lamp, sample].map(|place| quoted(&rows.called(place)));
    let words = format!("({sample} - {dark}) / ({lamp} - {dark})");
    report.note(format!(
        "no column is named {quantity}: {words} is taken, relative to what the reference is (reference_stack= says it)"
    ));
    report.take(quantity, &words.replace('"', ""), "", "computed from counts");
    ("(sample - dark) / (reference - dark)".into(), ratio, Some((ValueUnit::Ratio, "computed from counts")))
}

/// Which points belong to a run of equal greatest counts.
fn saturated(values: &[f64], top: f64) -> Vec<bool> {
    let mut found = vec![false; values.len()];
    let mut start = 0;
    for end in 0..=values.len() {
        if end < values.len() && values[end] == top {
            continue;
        }
        if end - start >= SATURATED && values[start] == top {
            found[start..end].fill(true);
        }
        start = end + 1;
    }
    found
}

/// The unit that was asked for.
fn asked_unit(asked: Option<&str>) -> Result<Option<ValueUnit>, String> {
    match asked {
        None => Ok(None),
        Some("ratio") => Ok(Some(ValueUnit::Ratio)),
        Some("percent" | "%") => Ok(Some(ValueUnit::Percent)),
        Some("counts") => Ok(Some(ValueUnit::Counts)),
        Some("absorbance") => Ok(Some(ValueUnit::Absorbance)),
        Some(other) => {
            Err(format!("unit_y must be \"ratio\", \"percent\", \"counts\" or \"absorbance\", got {}", quoted(other)))
        }
    }
}

/// The unit that the sizes of the values tell, and by what: those of the range that will be used.
fn unit_of_sizes(
    (nm, values): (&[f64], &[f64]),
    range_nm: Option<(f64, f64)>,
    column: &str,
    report: &mut ReadReport,
) -> Result<(ValueUnit, &'static str), String> {
    let inside = |nm: f64| range_nm.is_none_or(|(low, high)| (low..=high).contains(&nm));
    let used = nm.iter().zip(values).filter(|&(&nm, value)| inside(nm) && value.is_finite());
    let mut used: Vec<f64> = used.map(|(_, &value)| value).collect();
    used.sort_by(f64::total_cmp);
    let share = |part: f64| used.get(((used.len().max(1) - 1) as f64 * part).round() as usize).copied().unwrap_or(0.0);
    let (low, high) = (share(0.05), share(0.95));
    if high <= 1.0 {
        Ok((ValueUnit::Ratio, "no value says otherwise"))
    } else if high <= 1.5 {
        Ok((ValueUnit::Ratio, "95 % of the values lie below 1.5"))
    } else if high <= 2.5 {
        Err(format!(
            "{}: values reach {high:.4}: percent, or a ratio above 1? unit_y=\"percent\" or unit_y=\"ratio\"",
            quoted(column)
        ))
    } else if high <= 130.0 && low > -10.0 {
        report.note(format!("values reach {high:.4}: taken as percent"));
        Ok((ValueUnit::Percent, "the size of 95 % of the values"))
    } else {
        report.note(format!("values reach {high:.4}: counts; only their shape is used"));
        Ok((ValueUnit::Counts, "the size of the values"))
    }
}

/// The values in ratios where they are a reflectance or a transmittance.
fn in_ratios(
    nm: &[f64],
    mut values: Vec<f64>,
    said: Option<(ValueUnit, &'static str)>,
    choice: &SpectrumChoice<'_>,
    column: &str,
    report: &mut ReadReport,
) -> Result<Vec<f64>, String> {
    let broken = values.iter().filter(|value| value.abs() > MOST_COUNTS).count();
    if broken > 0 {
        report.drop(format!("{broken} values beyond {MOST_COUNTS:e}, which no detector gives"));
        values.iter_mut().filter(|value| value.abs() > MOST_COUNTS).for_each(|value| *value = f64::NAN);
    }
    let (unit, why) = match (asked_unit(choice.unit_y)?, said) {
        (Some(unit), _) => (unit, "unit_y="),
        (None, Some(said)) => said,
        (None, None) => unit_of_sizes((nm, &values), choice.range_nm, column, report)?,
    };
    let word = match unit {
        ValueUnit::Ratio => "ratio",
        ValueUnit::Percent => {
            values.iter_mut().for_each(|value| *value /= 100.0);
            if why == "its own name" {
                report.note("values are in percent, as the header says");
            }
            "percent"
        }
        ValueUnit::Absorbance => {
            if choice.quantity != "transmittance" {
                return Err(format!(
                    "{} is absorbance; a {} cannot be had from it (quantity=\"transmittance\" converts it)",
                    quoted(column),
                    choice.quantity
                ));
            }
            report.note("T = 10^-A: the transmittance is computed from the absorbance");
            values.iter_mut().for_each(|value| *value = 10_f64.powf(-*value));
            "absorbance"
        }
        ValueUnit::Counts => {
            drop_saturated(&mut values, report);
            "counts"
        }
    };
    if let Some(taken) = report.taken.iter_mut().find(|taken| taken.role == choice.quantity) {
        word.clone_into(&mut taken.unit);
        if why != "its own name" && why != taken.why {
            taken.why = format!("{}; {word}: {why}", taken.why);
        }
    }
    Ok(values)
}

/// Counts at the top of the detector are missing, unless they are half of all.
fn drop_saturated(values: &mut [f64], report: &mut ReadReport) {
    let top = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let flat = saturated(values, top);
    let count = flat.iter().filter(|flat| **flat).count();
    if count > 0 && count < values.len() / 2 {
        report.drop(format!("{count} values at the greatest count {top}: the detector was saturated"));
        values.iter_mut().zip(flat).filter(|(_, flat)| *flat).for_each(|(value, _)| *value = f64::NAN);
    }
}

/// Ascending wavelengths, one value each.
fn in_order(nm: Vec<f64>, values: Vec<f64>, report: &mut ReadReport) -> (Vec<f64>, Vec<f64>) {
    let falls = nm.windows(2).all(|pair| pair[1] <= pair[0]);
    let rises = nm.windows(2).all(|pair| pair[1] >= pair[0]);
    let mut pairs: Vec<(f64, f64)> = nm.into_iter().zip(values).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    if falls && !rises {
        report.note("the wavelengths descend; they have been turned");
    } else if !rises {
        report.note("the wavelengths were not in order; they have been sorted");
    }
    let count = pairs.len();
    let (mut x, mut y) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for same in pairs.chunk_by(|a, b| a.0 == b.0) {
        let known: Vec<f64> = same.iter().map(|pair| pair.1).filter(|value| value.is_finite()).collect();
        x.push(same[0].0);
        y.push(known.iter().sum::<f64>() / known.len() as f64);
    }
    if x.len() < count {
        report.note(format!("{} repeated wavelengths: their values have been averaged", count - x.len()));
    }
    (x, y)
}

#[cfg(test)]
mod tests;
