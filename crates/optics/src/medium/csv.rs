//! Tables `nm, n [, k]` as users write them.

use super::number::plain;
use super::rows::{Columns, Repeated, Row, tables};
use super::{Data, MAX_TEXT_BYTES, Medium, Real};
use crate::OpticsError;

/// A row has three fields; a header may hold a sentence.
const MAX_FIELDS: usize = 256;

pub(super) fn read(text: &str, label: &str) -> Result<Medium, OpticsError> {
    let fail = |line: usize, why: String| OpticsError::Data(format!("{label}:{line}: {why}"));
    if text.len() > MAX_TEXT_BYTES {
        return Err(OpticsError::Data(too_long(label)));
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut rows: Vec<Row> = Vec::new();
    let mut columns: Option<(Columns, usize)> = None;
    let mut header_seen = false;
    let mut comments: Vec<&str> = Vec::new();
    for (index, raw) in text.lines().enumerate() {
        let line = index + 1;
        let content = raw.split_once('#').map_or(raw, |(before, _)| before).trim();
        if content.is_empty() {
            if let (Some(comment), true) = (raw.trim().strip_prefix('#'), rows.is_empty()) {
                comments.push(comment.trim());
            }
            continue;
        }
        let fields = fields(content).map_err(|why| fail(line, why))?;
        let numbers: Vec<Option<f64>> = fields.iter().map(|field| plain(field)).collect();
        if rows.is_empty() && !header_seen && numbers.iter().all(Option::is_none) {
            check_header(&fields).map_err(|why| fail(line, why))?;
            header_seen = true;
            continue;
        }
        let mut row = Vec::with_capacity(numbers.len());
        for (field, number) in fields.iter().zip(numbers) {
            let shown: String = field.chars().take(40).collect();
            row.push(number.ok_or_else(|| fail(line, format!("{shown:?} is not a finite number")))?);
        }
        let kind = match row.len() {
            2 => Columns::N,
            3 => Columns::NK,
            count => return Err(fail(line, format!("a row holds nm, n and perhaps k: 2 or 3 numbers, got {count}"))),
        };
        match columns {
            None => columns = Some((kind, line)),
            Some((first, _)) if first == kind => {}
            Some((first, first_line)) => {
                let (now, before) = (kind.count(), first.count());
                return Err(fail(line, format!("{now} numbers in this row, but {before} in line {first_line}")));
            }
        }
        rows.push(Row::new(line, kind, &row).map_err(|why| fail(line, why))?);
    }
    let Some((kind, _)) = columns else {
        return Err(OpticsError::Data(format!("{label}: holds no rows of nm, n [, k]")));
    };
    let (n, k, _) = tables(rows, Repeated::Refuse, label)?;
    let k = (kind == Columns::NK).then_some(k);
    let data = Data { n: Real::Table(n), k, source: format!("file {label}"), note: comments.join(" ") };
    Medium::from_data(data, label)
}

pub(super) fn too_long(label: &str) -> String {
    format!("{label}: longer than {} MiB, which no table of an index needs", MAX_TEXT_BYTES >> 20)
}

/// The fields of a line: parted by commas, else semicolons, else tabs or spaces; empty ones at the end dropped.
fn fields(content: &str) -> Result<Vec<&str>, String> {
    let mut fields: Vec<&str> = if content.contains(';') {
        if content.contains(',') {
            return Err("holds both ';' and ','; write decimal points, not decimal commas".to_owned());
        }
        content.split(';').collect()
    } else if content.contains(',') {
        content.split(',').collect()
    } else {
        content.split_whitespace().collect()
    };
    if fields.len() > MAX_FIELDS {
        return Err(format!("{} fields in one row, at most {MAX_FIELDS} are read", fields.len()));
    }
    for field in &mut fields {
        *field = field.trim().trim_matches('"').trim();
    }
    while fields.last().is_some_and(|field| field.is_empty()) {
        fields.pop();
    }
    Ok(fields)
}

/// A header may say anything but that the columns are others than nm, n, k: reading micrometres as
/// nanometres, or k as n, would give a wrong colour without a word.
fn check_header(fields: &[&str]) -> Result<(), String> {
    let lower: Vec<String> = fields.iter().map(|field| field.to_lowercase()).collect();
    let first = lower.first().map_or("", String::as_str);
    let words: Vec<&str> = first.split(|c: char| !c.is_alphanumeric()).collect();
    let other_unit = ["um", "µm", "μm", "micron", "microns", "micrometer", "micrometre", "micrometers", "micrometres"]
        .iter()
        .chain(&["ev", "angstrom", "å", "cm", "thz", "m", "mm"])
        .any(|unit| words.contains(unit));
    if other_unit && !words.contains(&"nm") {
        return Err(format!("the first column must be the vacuum wavelength in nm, the header says {:?}", fields[0]));
    }
    if first == "wl" {
        // The heading of the tables that refractiveindex.info offers for download, which are in micrometres.
        return Err("the header \"wl\" marks a download of refractiveindex.info in micrometres; \
             write the wavelengths in nm under the header \"nm\", or take the page's YAML file"
            .to_owned());
    }
    for (place, wrong) in [(1, "k"), (2, "n")] {
        if lower.get(place).is_some_and(|field| field == wrong) {
            return Err(format!("the columns must be nm, n and perhaps k; the header says {}", fields.join(", ")));
        }
    }
    Ok(())
}
