//! Pages of the refractiveindex.info database.
//!
//! The YAML itself is read by `saphyr-parser`, event by event, so that nesting is bounded here and neither a deep
//! nor a self-referring document can exhaust the stack or the memory.

use saphyr_parser::{Event, Parser, ScalarStyle, Span, StrInput};

use super::formula::Formula;
use super::number::{plain, shifted};
use super::page::{self, Node};
use super::rows::{Columns, Repeated, Row, tables};
use super::value::{Data, Medium, Real};
use crate::OpticsError;

/// Micrometres to nanometres: three decimal places.
const UM_TO_NM: i32 = 3;

/// Longest text a reader accepts, bytes: a table of about half a million rows.
pub const MAX_TEXT_BYTES: usize = 16 << 20;

/// A page nests five levels at most.
const MAX_DEPTH: usize = 32;

/// A page has five keys; its longest mapping or list holds about twenty entries.
const MAX_KEYS: usize = 256;

/// Line and message of what is wrong.
type Wrong = (usize, String);

pub(super) fn read(text: &str, label: &str) -> Result<Medium, OpticsError> {
    if text.len() > MAX_TEXT_BYTES {
        return Err(OpticsError::Data(format!(
            "{label}: longer than {} MiB, which no table of an index needs",
            MAX_TEXT_BYTES >> 20
        )));
    }
    let page = parse(text).map_err(|(line, why)| OpticsError::Data(format!("{label}:{line}: {why}")))?;
    medium(&page, label)
}

/// A page that comes with this crate.
pub(super) fn read_own(text: &str, label: &str) -> Result<Medium, OpticsError> {
    medium(&page::tree(text), label)
}

fn medium(page: &Node, label: &str) -> Result<Medium, OpticsError> {
    let fail = |(line, why): Wrong| OpticsError::Data(format!("{label}:{line}: {why}"));
    let no_data = || {
        OpticsError::Data(format!(
            "{label}: is no page of the refractiveindex.info database: it holds no list under the key DATA"
        ))
    };
    let Some(Node::List(entries, _)) = page.get("DATA") else { return Err(no_data()) };

    let (mut n, mut k): (Option<Real>, Option<crate::spectrum::Tabulated>) = (None, None);
    let mut conflicts = 0;
    for entry in entries {
        match part(entry).map_err(fail)? {
            Part::Formula(real) => n = Some(real),
            Part::Rows(columns, rows) => {
                let (table_n, table_k, repeated) = tables(rows, Repeated::Mean, label)?;
                conflicts += repeated;
                if columns != Columns::K {
                    n = Some(Real::Table(table_n));
                }
                if columns != Columns::N {
                    k = Some(table_k);
                }
            }
        }
    }
    let Some(n) = n else {
        return Err(OpticsError::Data(format!(
            "{label}: holds no refractive index n (DATA needs \"formula 1\" to \"formula 9\", \"tabulated n\" or \
             \"tabulated nk\")"
        )));
    };
    let prose = |key: &str| page.get(key).and_then(Node::text).map(plain_prose).unwrap_or_default();
    let mut note = prose("COMMENTS");
    if conflicts > 0 {
        let space = if note.is_empty() { "" } else { " " };
        note += &format!("{space}[Wavelengths listed more than once, mean taken: {conflicts}.]");
    }
    Medium::from_data(Data { n, k, source: prose("REFERENCES"), note }, label)
}

/// One entry of DATA.
enum Part {
    Formula(Real),
    Rows(Columns, Vec<Row>),
}

fn part(entry: &Node) -> Result<Part, Wrong> {
    let wanted = |key: &str| {
        let node = entry.get(key).ok_or_else(|| (entry.line(), format!("an entry of DATA needs the key {key:?}")))?;
        node.text().map(|text| (text, node.line())).ok_or_else(|| (node.line(), format!("{key:?} must be text")))
    };
    let (kind, line) = wanted("type")?;
    let columns = match kind.split_whitespace().collect::<Vec<_>>()[..] {
        ["tabulated", "n"] => Columns::N,
        ["tabulated", "k"] => Columns::K,
        ["tabulated", "nk"] => Columns::NK,
        ["formula", number] => {
            let number = number.parse().map_err(|_| (line, unknown_type(kind)))?;
            let (coefficients, line) = wanted("coefficients")?;
            let formula = Formula::new(number, numbers(coefficients, 0).map_err(|why| (line, why))?);
            let formula = formula.map_err(|why| (line, why))?;
            let key = if entry.get("wavelength_range").is_some() { "wavelength_range" } else { "range" };
            let (range, line) = match wanted(key) {
                Err((line, _)) => return Err((line, "a formula needs the key \"wavelength_range\"".to_owned())),
                found => found?,
            };
            let range = numbers(range, UM_TO_NM).map_err(|why| (line, why))?;
            return match range[..] {
                [from, to] if 0.0 < from && from <= to => {
                    Ok(Part::Formula(Real::Formula { formula, range_nm: (from, to) }))
                }
                _ => Err((line, "a wavelength range is two ascending wavelengths > 0 in um".to_owned())),
            };
        }
        _ => return Err((line, unknown_type(kind))),
    };
    let (data, first_line) = wanted("data")?;
    let mut rows = Vec::new();
    for (offset, text) in data.lines().enumerate() {
        let line = first_line + offset;
        if text.trim().is_empty() {
            continue;
        }
        let mut row = numbers(text, 0).map_err(|why| (line, why))?;
        // Read once more with the decimal exponent shifted: see `shifted`.
        if let Some(nm) = text.split_whitespace().next().and_then(|first| shifted(first, UM_TO_NM)) {
            row[0] = nm;
        }
        rows.push(Row::new(line, columns, &row).map_err(|why| (line, why))?);
    }
    if rows.is_empty() {
        return Err((first_line, "the table holds no rows".to_owned()));
    }
    Ok(Part::Rows(columns, rows))
}

fn unknown_type(kind: &str) -> String {
    let shown: String = kind.chars().take(60).collect();
    format!("the type must be \"formula 1\" to \"formula 9\" or \"tabulated n\", \"k\" or \"nk\", got {shown:?}")
}

/// The numbers of a line, their decimal point shifted.
fn numbers(text: &str, shift: i32) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        let value = if shift == 0 { plain(word) } else { shifted(word, shift) };
        let shown: String = word.chars().take(40).collect();
        value.ok_or_else(|| format!("{shown:?} is not a finite number"))
    };
    text.split_whitespace().map(number).collect()
}

/// The document as a tree; the first document of a stream counts.
fn parse(text: &str) -> Result<Node, Wrong> {
    let mut parser = Parser::new_from_str(text);
    loop {
        match next(&mut parser)? {
            (Event::StreamStart | Event::DocumentStart(_) | Event::Nothing, _) => {}
            (Event::StreamEnd | Event::DocumentEnd, span) => return Err((span.start.line(), "is empty".to_owned())),
            (event, span) => return node(&mut parser, event, span, 0),
        }
    }
}

type Events<'a> = Parser<'a, StrInput<'a>>;

fn next<'a>(parser: &mut Events<'a>) -> Result<(Event<'a>, Span), Wrong> {
    match parser.next_event() {
        Some(Ok(event)) => Ok(event),
        Some(Err(error)) => Err((error.marker().line(), format!("not YAML: {}", error.info()))),
        None => Err((0, "not YAML: it ends too early".to_owned())),
    }
}

fn node(parser: &mut Events<'_>, event: Event<'_>, span: Span, depth: usize) -> Result<Node, Wrong> {
    let line = span.start.line();
    if depth > MAX_DEPTH {
        return Err((line, format!("nested deeper than {MAX_DEPTH} levels")));
    }
    match event {
        Event::Scalar(text, style, ..) => {
            // A literal block is said to start at its first line that is not empty.
            let empty = text.lines().take_while(|line| line.is_empty()).count();
            let line = if style == ScalarStyle::Literal { line.saturating_sub(empty) } else { line };
            Ok(Node::Scalar(text.into_owned(), line))
        }
        Event::SequenceStart(..) => {
            let mut items = Vec::new();
            loop {
                let (event, span) = next(parser)?;
                if event == Event::SequenceEnd {
                    return Ok(Node::List(items, line));
                }
                if items.len() >= MAX_KEYS {
                    return Err((span.start.line(), format!("more than {MAX_KEYS} entries in one list")));
                }
                items.push(node(parser, event, span, depth + 1)?);
            }
        }
        Event::MappingStart(..) => {
            let mut entries: Vec<(String, Node)> = Vec::new();
            loop {
                let (event, span) = next(parser)?;
                if event == Event::MappingEnd {
                    return Ok(Node::Map(entries, line));
                }
                let Node::Scalar(key, key_line) = node(parser, event, span, depth + 1)? else {
                    return Err((span.start.line(), "a key must be a word".to_owned()));
                };
                if entries.len() >= MAX_KEYS {
                    return Err((key_line, format!("more than {MAX_KEYS} keys in one mapping")));
                }
                if entries.iter().any(|(name, _)| *name == key) {
                    return Err((key_line, format!("the key {key:?} stands twice")));
                }
                let (event, span) = next(parser)?;
                entries.push((key, node(parser, event, span, depth + 1)?));
            }
        }
        Event::Alias(_) => Err((line, "aliases (*name) have no place in a page of indices".to_owned())),
        _ => Err((line, "not YAML: it ends too early".to_owned())),
    }
}

/// Prose without HTML tags, on one line.
fn plain_prose(html: &str) -> String {
    let mut text = String::with_capacity(html.len());
    let mut rest = html;
    while let Some(open) = rest.find('<') {
        text.push_str(&rest[..open]);
        // "<" before anything but a letter or "/" is a sign of comparison, not a tag.
        let tag = rest[open + 1..].starts_with(|c: char| c.is_ascii_alphabetic() || c == '/');
        if !tag {
            text.push('<');
            rest = &rest[open + 1..];
            continue;
        }
        let Some(close) = rest[open..].find('>') else {
            rest = &rest[open..];
            break;
        };
        if rest[open..].starts_with("<br") {
            text.push(' ');
        }
        rest = &rest[open + close + 1..];
    }
    text.push_str(rest);
    for (entity, sign) in [("&lt;", "<"), ("&gt;", ">"), ("&nbsp;", " "), ("&deg;", "°"), ("&amp;", "&")] {
        text = text.replace(entity, sign);
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::plain_prose;

    #[test]
    fn prose_loses_its_tags() {
        let html = "A. Author.<br>\n  <a href=\"x\"><i>Opt.</i> <b>4</b>, 1-2</a> n < 2 &amp; TiO<sub>2</sub>";
        assert_eq!(plain_prose(html), "A. Author. Opt. 4, 1-2 n < 2 & TiO2");
        assert_eq!(plain_prose("cut <a href"), "cut <a href");
    }
}
