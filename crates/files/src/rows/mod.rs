//! Tables of numbers as text: one reader for spectra, lamps and index files, whatever program wrote them.
//!
//! The table is the longest run of rows of one width; what stands above is its header, what stands below a trailer. The
//! dialect (separator and decimal sign) is chosen over the whole file, never line by line: a wrong split nearly always
//! breaks the order of the first column or doubles the width.

mod dialect;
mod names;

use crate::words::quoted;
use dialect::{Cell, DIALECTS, Dialect, parse, split};

/// Most columns of a table.
const MOST_COLUMNS: usize = 16_384;
/// Most numbers in a table: 512 MiB of them.
const MOST_NUMBERS: usize = 1 << 26;

/// A table of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Name of each column, unit lines included (`Wave [nm]`); empty where there is none.
    pub names: Vec<String>,
    /// Columns of equal length; NaN where a value is missing.
    pub columns: Vec<Vec<f64>>,
    /// The line that each row stands on, from 1.
    pub lines: Vec<usize>,
    /// Lines above the table that are not blank.
    pub header: Vec<String>,
    /// Separator and decimal sign in words.
    pub dialect: &'static str,
    /// Values that are missing: blanks, `NaN`, `---`, `over` and their kind.
    pub missing: usize,
    /// The first value that is missing after the first cell: its line, and the cell.
    pub first_missing: Option<(usize, String)>,
    /// The first line under the table that is no comment.
    pub trailer: Option<(usize, String)>,
    /// The first cell that is neither a number nor a word for a missing one: its line, and the cell.
    pub garbage: Option<(usize, String)>,
    /// The first row that is longer or shorter than the others: its line and how many cells it has.
    pub ragged: Option<(usize, usize)>,
    /// Tables after the first and longest: the line where each begins, and its rows.
    pub others: Vec<(usize, usize)>,
    /// A comment in front of the table, without its marks.
    pub comment: String,
}

/// A row as one dialect reads it.
struct Parsed {
    line: usize,
    cells: Vec<Cell>,
}

/// One dialect's reading of the file.
struct Reading {
    dialect: Dialect,
    rows: Vec<Parsed>,
    width: usize,
    names: Vec<String>,
    others: Vec<(usize, usize)>,
}

impl Rows {
    /// The table in a text of at least `least` rows. The error says what was found instead.
    pub fn read(text: &str, least: usize) -> Result<Rows, String> {
        let lines: Vec<&str> = text.lines().collect();
        thousands(&lines)?;
        let mut readings: Vec<Reading> = Vec::new();
        for dialect in DIALECTS {
            if let Some(reading) = read_as(dialect, &lines)? {
                readings.push(reading);
            }
        }
        let order = |reading: &Reading| {
            let garbage = reading.rows.iter().flat_map(|row| &row.cells).filter(|cell| cell.is_garbage()).count();
            let named = reading.names.iter().any(|name| !name.is_empty());
            let known = reading.rows.iter().filter(|row| row.cells[1..].iter().any(|cell| cell.is_number())).count();
            (
                known > 0,
                reading.rows.len() >= 2 && is_monotone(reading),
                named,
                std::cmp::Reverse(garbage.min(reading.rows.len())),
                known,
                std::cmp::Reverse(reading.dialect.order),
            )
        };
        // Pairs under one comma each are taken only where the names say so; otherwise the file is ambiguous.
        let (pairs, single): (Vec<Reading>, Vec<Reading>) =
            readings.into_iter().partition(|reading| reading.dialect.is_both_commas());
        let pairs = pairs.into_iter().find(|reading| reading.rows.len() >= least && is_monotone(reading));
        let best = single.into_iter().filter(|reading| reading.rows.len() >= least).max_by_key(order);
        let chosen = match (pairs, best) {
            (Some(pairs), Some(best)) => {
                let fits = |reading: &Reading| reading.names.iter().any(|name| !name.is_empty());
                if fits(&pairs) && !fits(&best) {
                    Some(pairs)
                } else if !is_strict(&best) {
                    return Err(format!(
                        "commas both separate and mark decimals ({} fields in line {}); save it with \";\" or with points",
                        best.width, best.rows[0].line
                    ));
                } else {
                    Some(best)
                }
            }
            (Some(pairs), None) if pairs.names.iter().any(|name| !name.is_empty()) => Some(pairs),
            (_, best) => best,
        };
        let reading = chosen.ok_or_else(|| nothing(&lines))?;
        finish(reading, &lines)
    }

    /// What column `place` is called, in words: its name, or its number.
    pub fn called(&self, place: usize) -> String {
        match self.names[place].as_str() {
            "" => format!("column {}", place + 1),
            name => name.to_owned(),
        }
    }

    /// The place of a column that a user named by number (from 1) or by name: exactly, or else by a part that only one
    /// has; letter case does not matter. `option` is what the user's choice is called.
    pub fn place(&self, asked: &str, option: &str) -> Result<usize, String> {
        let asked = asked.trim();
        let width = self.names.len();
        if let Ok(number) = asked.parse::<usize>() {
            return match number {
                1.. if number <= width => Ok(number - 1),
                _ => Err(format!("{option} must be 1 to {width}, got {number}")),
            };
        }
        let wanted = asked.to_lowercase();
        let lower: Vec<String> = self.names.iter().map(|name| name.to_lowercase()).collect();
        let exact: Vec<usize> = (0..width).filter(|&place| lower[place] == wanted).collect();
        let part: Vec<usize> = (0..width).filter(|&place| lower[place].contains(&wanted)).collect();
        match (exact.as_slice(), part.as_slice()) {
            (&[place], _) | ([], &[place]) if !wanted.is_empty() => Ok(place),
            (exact, part) => Err(format!(
                "{} columns are named {}; there are {} ({option} takes a number, too)",
                if exact.is_empty() { part.len() } else { exact.len() },
                quoted(asked),
                self.list()
            )),
        }
    }

    /// All columns in words.
    pub fn list(&self) -> String {
        let called: Vec<String> = (0..self.names.len()).map(|place| self.called(place)).collect();
        crate::words::listed(called.iter().map(String::as_str))
    }
}

/// Whether no two rows begin with the same number.
fn is_strict(reading: &Reading) -> bool {
    is_monotone(reading) && reading.rows.windows(2).all(|pair| pair[0].cells[0] != pair[1].cells[0])
}

/// Whether the first column only rises or only falls (or, where rows are numbered, whether it counts).
fn is_monotone(reading: &Reading) -> bool {
    let first: Vec<f64> = reading.rows.iter().map(|row| row.cells[0].value()).collect();
    let rises = first.windows(2).all(|pair| pair[1] >= pair[0]);
    let falls = first.windows(2).all(|pair| pair[1] <= pair[0]);
    let varies = first.first() != first.last() || first.len() < 2;
    // Repeated wavelengths happen; a column of which half are repeated is a wrong split.
    let repeated = first.windows(2).filter(|pair| pair[0] == pair[1]).count();
    (rises || falls) && varies && 2 * repeated <= first.len()
}

fn read_as(dialect: Dialect, lines: &[&str]) -> Result<Option<Reading>, String> {
    // Runs of rows; blank lines and comments do not end one.
    let mut runs: Vec<Vec<Parsed>> = vec![Vec::new()];
    let mut count = 0;
    for (index, line) in lines.iter().enumerate() {
        match parse(line, dialect) {
            Some(cells) => {
                count += cells.len();
                if cells.len() > MOST_COLUMNS || count > MOST_NUMBERS {
                    return Err(format!(
                        "line {}: more than {MOST_COLUMNS} columns or {MOST_NUMBERS} numbers",
                        index + 1
                    ));
                }
                let parsed = Parsed { line: index + 1, cells };
                if let Some(run) = runs.last_mut() {
                    run.push(parsed);
                }
            }
            None if line.trim().is_empty() || line.trim_start().starts_with(['#', '!', '%']) => {}
            None => {
                if runs.last().is_some_and(|run| !run.is_empty()) {
                    runs.push(Vec::new());
                }
            }
        }
    }
    runs.retain(|run| !run.is_empty());
    let Some(longest) = (0..runs.len()).rev().max_by_key(|&place| runs[place].len()) else { return Ok(None) };
    let others = (0..runs.len())
        .filter(|&place| place != longest && runs[place].len() >= 3)
        .map(|place| (runs[place][0].line, runs[place].len()))
        .collect();
    let rows = runs.swap_remove(longest);
    let width = common_width(&rows);
    if width < 2 {
        return Ok(None);
    }
    let names = names::above(lines, rows[0].line, width, dialect);
    Ok(Some(Reading { dialect, rows, width, names, others }))
}

/// The commonest number of cells, trailing blanks counted.
fn common_width(rows: &[Parsed]) -> usize {
    let mut counts: Vec<(usize, usize)> = Vec::new();
    for row in rows {
        match counts.iter_mut().find(|(width, _)| *width == row.cells.len()) {
            Some((_, count)) => *count += 1,
            None => counts.push((row.cells.len(), 1)),
        }
    }
    // (Of equals the first.)
    counts.into_iter().rev().max_by_key(|&(_, count)| count).map_or(0, |(width, _)| width)
}

fn finish(reading: Reading, lines: &[&str]) -> Result<Rows, String> {
    let Reading { dialect, rows, width: all, mut names, others } = reading;
    let width = without_blank_ends(&rows, all, &names);
    if width < all {
        names.truncate(width);
    }
    let above = &lines[..rows[0].line - 1];
    let header: Vec<String> =
        above.iter().filter(|line| !line.trim().is_empty()).map(|&line| line.to_owned()).collect();
    let comments: Vec<&str> = header.iter().filter_map(|line| line.trim().strip_prefix('#')).map(str::trim).collect();
    let comment = comments.join(" ");
    let trailer = trailer(lines, rows[rows.len() - 1].line);
    let mut table = Rows {
        names,
        columns: vec![Vec::with_capacity(rows.len()); width],
        lines: Vec::with_capacity(rows.len()),
        header,
        dialect: dialect.words,
        missing: 0,
        first_missing: None,
        trailer,
        garbage: None,
        ragged: None,
        others,
        comment,
    };
    for row in rows {
        table.push(row);
    }
    Ok(table)
}

fn is_blank(cell: &Cell) -> bool {
    matches!(cell, Cell::Missing(word) if word.is_empty())
}

/// The width without columns that have neither a name nor a value: a separator at the end of every row is no column.
fn without_blank_ends(rows: &[Parsed], mut width: usize, names: &[String]) -> usize {
    let is_unused = |place: usize| {
        names.get(place).is_none_or(String::is_empty)
            && rows.iter().all(|row| row.cells.get(place).is_none_or(is_blank))
    };
    while width > 2 && is_unused(width - 1) {
        width -= 1;
    }
    width
}

/// The first line under the table, whose last line is `last_line`, that is no comment.
fn trailer(lines: &[&str], last_line: usize) -> Option<(usize, String)> {
    let is_said = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let below = lines[last_line..].iter().enumerate();
    below.map(|(place, line)| (last_line + place + 1, line)).find(|(_, line)| is_said(line)).map(|(number, line)| {
        let words = line.trim().to_owned();
        (number, words)
    })
}

impl Rows {
    fn push(&mut self, row: Parsed) {
        let width = self.columns.len();
        let used = row.cells.iter().rposition(|cell| !is_blank(cell)).map_or(0, |last| last + 1);
        if (used > width || row.cells.len() < width) && self.ragged.is_none() {
            self.ragged = Some((row.line, used));
        }
        self.lines.push(row.line);
        let mut cells = row.cells.into_iter();
        for column in &mut self.columns {
            let cell = cells.next().unwrap_or(Cell::Missing(String::new()));
            if !cell.is_number() {
                self.missing += 1;
            }
            column.push(cell.value());
            match cell {
                Cell::Garbage(word) if self.garbage.is_none() => self.garbage = Some((row.line, word)),
                Cell::Missing(word) if self.first_missing.is_none() => self.first_missing = Some((row.line, word)),
                _ => {}
            }
        }
    }
}

/// A number with both marks, `1,234.5` or `1.234,5`, groups thousands: which is which cannot be told safely. So does `1,234`
/// in a row whose other numbers have decimal points.
///
/// A row without blanks, `446,987.25`, is one such number or a wavelength and its counts. Where a table has other rows that no
/// grouped number can be, `444,1023.5`, or where what stands before the comma goes up or down from row to row, it is a table.
fn thousands(lines: &[&str]) -> Result<(), String> {
    let of_pairs = are_pairs(lines);
    for (index, line) in lines.iter().enumerate() {
        let has_both = line.contains(',') && line.contains('.');
        let is_row = line.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '"');
        if !has_both || !is_row {
            continue;
        }
        let separators: &[char] = if line.contains(';') {
            &[';']
        } else if line.contains('\t') {
            &['\t']
        } else if line.contains('"') {
            &['"']
        } else {
            &[' ']
        };
        let words: Vec<&str> = line.split(separators).map(str::trim).collect();
        // `400.5, 123,456` are three numbers between commas.
        let are_cells = !words.iter().any(|word| word.ends_with(','));
        let has_points = are_cells && words.iter().any(|word| word.contains('.') && !word.contains(','));
        if words.len() == 1 && of_pairs {
            continue;
        }
        let grouped = words.iter().find(|word| is_grouped(word) || has_points && has_groups(word, ','));
        if let Some(word) = grouped {
            // `400,0.1` is two numbers between commas, not one with groups.
            return Err(format!(
                "line {}: {} groups its thousands; save the numbers without thousands marks",
                index + 1,
                quoted(word)
            ));
        }
    }
    Ok(())
}

/// Whether rows of two numbers between commas are such pairs, though some of them look like one number with groups: others do
/// not, or all begin with wavelengths, numbers of three digits that go one way.
fn are_pairs(lines: &[&str]) -> bool {
    let number = |word: &str| word.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let (firsts, grouped): (Vec<f64>, Vec<bool>) = lines
        .iter()
        .filter_map(|line| {
            let (first, second) = line.split_once(',')?;
            number(second)?;
            Some((number(first)?, is_grouped(line.trim())))
        })
        .unzip();
    let goes_one_way = [f64::lt, f64::gt].iter().any(|comes_before| {
        firsts.windows(2).all(|two| comes_before(&two[0], &two[1])) && firsts.iter().all(|value| *value >= 100.0)
    });
    grouped.contains(&false) || (firsts.len() > 2 && goes_one_way)
}

/// `1,234.5`, `12.345.678,9`: groups of three digits between one mark, then the other mark once.
fn is_grouped(word: &str) -> bool {
    let body = word.trim_start_matches(['+', '-']);
    [(',', '.'), ('.', ',')].into_iter().any(|(group, decimal)| {
        let Some((whole, fraction)) = body.split_once(decimal) else { return false };
        has_groups(whole, group) && is_digits(fraction)
    })
}

/// `1,234`, `12,345,678`: groups of three digits behind one to three that do not begin with a nought.
fn has_groups(whole: &str, group: char) -> bool {
    let mut groups = whole.trim_start_matches(['+', '-']).split(group);
    let first = groups.next().unwrap_or("");
    let rest: Vec<&str> = groups.collect();
    is_digits(first)
        && !first.starts_with('0')
        && first.len() <= 3
        && !rest.is_empty()
        && rest.iter().all(|part| part.len() == 3 && is_digits(part))
}

fn is_digits(part: &str) -> bool {
    !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit())
}

/// What a text without a table holds instead.
fn nothing(lines: &[&str]) -> String {
    let words = "holds no table of two or more columns of numbers (wavelength, value)";
    let one_column = lines.iter().filter(|line| line.trim().parse::<f64>().is_ok()).count();
    if one_column >= 2 {
        return format!("{words}: {one_column} lines of one number each were found");
    }
    if let Some(wide) = lines.iter().find(|line| split(line, DIALECTS[0]).len() > 30 || line.split(',').count() > 30) {
        return format!("{words}: one row of {} cells was found; transposed?", wide.split([',', '\t', ';']).count());
    }
    words.to_owned()
}

#[cfg(test)]
mod tests;
