//! Names of columns: the header lines right above a table, names over units, as many words as it has columns.

use super::dialect::{Dialect, Separator, split};

/// Most header lines that make up the names.
const MOST_LINES: usize = 4;
/// Labels of the axis and of the values in formats that write one fact a line (JASCO).
const AXIS_LABELS: [&str; 2] = ["XUNITS", "YUNITS"];

/// The names of `width` columns over the table whose first row stands on `first_line`; empty ones where there are none.
pub fn above(lines: &[&str], first_line: usize, width: usize, dialect: Dialect) -> Vec<String> {
    let mut names = vec![String::new(); width];
    let mut found: Vec<Vec<String>> = Vec::new();
    let mut is_comment = None;
    for line in lines[..first_line - 1].iter().rev() {
        if line.trim().is_empty() {
            if found.is_empty() {
                continue;
            }
            break;
        }
        // A comment over a line of names is a comment, however many words it has.
        let starts_comment = line.trim_start().starts_with(['#', '!', '%']);
        if !found.is_empty() && is_comment != Some(starts_comment) {
            break;
        }
        is_comment = Some(starts_comment);
        match words(line, width, dialect) {
            // Over names stand names: `Nr. 7; 25 ms` is a remark.
            Some(words)
                if !found.is_empty() && words.iter().any(|word| word.starts_with(|c: char| c.is_ascii_digit())) =>
            {
                break;
            }
            Some(words) if found.len() < MOST_LINES => found.push(words),
            // Between names and table some programs write one more line: a marker, a remark.
            None if found.is_empty() && is_marker(line) => {}
            _ => break,
        }
    }
    for words in found.into_iter().rev() {
        for (name, word) in names.iter_mut().zip(words) {
            *name = format!("{name} {word}").trim().to_owned();
        }
    }
    if width == 2 && names.iter().all(String::is_empty) {
        names = facts(&lines[..first_line - 1]).unwrap_or(names);
    }
    names
}

/// The words of a line of names; `None` for a line that is none.
fn words(line: &str, width: usize, dialect: Dialect) -> Option<Vec<String>> {
    let line = line.trim_start_matches(['#', '!', '%', ' ']);
    let mut words = split(line, dialect);
    if dialect.separator == Separator::Blanks {
        // Names may hold single blanks; wider gaps part them.
        let wide: Vec<String> = line
            .split("  ")
            .flat_map(|part| part.split('\t'))
            .map(|part| part.trim().to_owned())
            .filter(|part| !part.is_empty())
            .collect();
        words = if wide.len() == width { wide } else { joined(words) };
    }
    while words.len() > width && words.last().is_some_and(String::is_empty) {
        words.pop();
    }
    let is_number = |word: &String| word.replace(',', ".").parse::<f64>().is_ok();
    // `Integration time: 100` and `Fiber<tab>400` say a fact, not names.
    let is_fact = words.first().is_some_and(|word| word.ends_with([':', '=']))
        || (words.len() == 2 && is_number(&words[1]))
        || words.first().is_some_and(is_number);
    let has_letters = words.iter().any(|word| word.chars().any(|letter| letter.is_alphabetic() || letter == '%'));
    (words.len() == width && has_letters && !is_fact).then_some(words)
}

/// `wavelength (um) R`: a unit in brackets belongs to the word before it.
fn joined(words: Vec<String>) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    for word in words {
        match joined.last_mut() {
            Some(last) if word.starts_with(['(', '[']) => *last = format!("{last} {word}"),
            _ => joined.push(word),
        }
    }
    joined
}

/// `>>>>>Begin Spectral Data<<<<<`, `#DATA`, `XYDATA`.
fn is_marker(line: &str) -> bool {
    let line = line.trim().trim_start_matches(['#', '>', '<', '-', '=', '*', ' ']);
    line.to_lowercase().starts_with("begin")
        || line.eq_ignore_ascii_case("data")
        || line.eq_ignore_ascii_case("xydata")
        || line.is_empty()
}

/// Two columns whose units stand in lines of their own: `nm` over `%R`, or `XUNITS nm` and `YUNITS %R`.
fn facts(header: &[&str]) -> Option<Vec<String>> {
    let labelled = AXIS_LABELS.map(|label| {
        header.iter().find_map(|line| {
            let rest = line.trim().strip_prefix(label)?;
            Some(rest.trim_matches([' ', '\t', '=', ':', ',', ';']).to_owned())
        })
    });
    if let [Some(x), y] = labelled {
        return Some(vec![x, y.unwrap_or_default()]);
    }
    let is_axis = |word: &str| {
        ["nm", "um", "µm", "cm-1", "1/cm", "ev", "nanometers", "nanometres", "micrometers"]
            .contains(&word.to_lowercase().as_str())
    };
    let pair = header.windows(2).rev().find(|pair| is_axis(pair[0].trim()) && !pair[1].trim().is_empty())?;
    Some(vec![pair[0].trim().to_owned(), pair[1].trim().to_owned()])
}
