//! Spectra in JCAMP-DX, the text format of infrared spectrometers, its plain-number forms.
//!
//! Source: R. S. McDonald, P. A. Wilks, Applied Spectroscopy 42, 151 (1988): labels `##NAME= value`, then XYPOINTS or PEAK
//! TABLE as pairs, or `XYDATA=(X++(Y..Y))` as lines of one x and many y of even steps. The compressed forms (letters in place
//! of digits) are refused by name.

use crate::rows::Rows;
use crate::words::quoted;

/// Most points of a spectrum.
const MOST_POINTS: usize = 1 << 24;

/// Whether the file says it is one.
pub fn is_jcamp(text: &str) -> bool {
    let start = text.trim_start().get(..12).unwrap_or("").to_uppercase().replace(' ', "");
    start.starts_with("##TITLE=") || start.starts_with("##JCAMP-DX") || start.starts_with("##JCAMPDX")
}

/// The labels of a file before its table, the form of the table (`(X++(Y..Y))`, `(XY..XY)`), and the table's lines by number.
struct Labelled<'a> {
    facts: Vec<(String, String)>,
    form: String,
    lines: Vec<(usize, &'a str)>,
}

impl<'a> Labelled<'a> {
    /// The first table of a text and what stands before it.
    fn read(text: &'a str) -> Result<Self, String> {
        let mut facts: Vec<(String, String)> = Vec::new();
        let mut form = String::new();
        let mut lines: Vec<(usize, &str)> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.split("$$").next().unwrap_or("").trim();
            if let Some((name, value)) = line.strip_prefix("##").and_then(|rest| rest.split_once('=')) {
                if !form.is_empty() {
                    break;
                }
                let name: String =
                    name.to_uppercase().chars().filter(|c| !c.is_whitespace() && !"-/_".contains(*c)).collect();
                if ["XYDATA", "XYPOINTS", "PEAKTABLE"].contains(&name.as_str()) {
                    form = value.to_uppercase().split_whitespace().collect();
                    if form.is_empty() {
                        form = name;
                    }
                } else if !facts.iter().any(|(known, _)| *known == name) {
                    facts.push((name, value.trim().to_owned()));
                }
            } else if !form.is_empty() && !line.is_empty() {
                lines.push((index + 1, line));
            }
        }
        if lines.is_empty() {
            return Err("this JCAMP-DX file holds no XYDATA or XYPOINTS".into());
        }
        // One pseudo-digit of the compressed forms: squeezed, difference and duplicate digits.
        let is_packed = |c: char| matches!(c, '@' | 'A'..='D' | 'F'..='Z' | 'a'..='d' | 'f'..='z' | '%');
        if let Some((line, _)) = lines.iter().find(|(_, line)| line.contains(is_packed)) {
            return Err(format!(
                "line {line}: the numbers of this JCAMP-DX file are compressed; export it as plain numbers (AFFN) or CSV"
            ));
        }
        Ok(Self { facts, form, lines })
    }

    fn word(&self, name: &str) -> Option<&str> {
        self.facts.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        let Some(value) = self.word(name) else { return Ok(None) };
        value
            .replace(',', ".")
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
            .map(Some)
            .ok_or_else(|| format!("{name} of this JCAMP-DX file must be a number, got {}", quoted(value)))
    }

    /// The numbers of each line, with its own.
    fn rows(&self) -> impl Iterator<Item = Result<(usize, Vec<f64>), String>> {
        self.lines.iter().map(|(line, words)| {
            let numbers =
                numbers(words).ok_or_else(|| format!("line {line}: {} is no row of numbers", quoted(words)))?;
            Ok((*line, numbers))
        })
    }

    /// `(X++(Y..Y))`: lines of one x and many y. The x of the first line alone is exact, the others are rounded: even steps
    /// from FIRSTX to LASTX.
    fn even_steps(&self) -> Result<Points, String> {
        let y_factor = self.number("YFACTOR")?.unwrap_or(1.0);
        let (mut y, mut lines, mut start) = (Vec::new(), Vec::new(), None);
        for row in self.rows() {
            let (line, numbers) = row?;
            start = start.or(numbers.first().copied());
            for value in numbers.iter().skip(1) {
                y.push(value * y_factor);
                lines.push(line);
            }
            if y.len() > MOST_POINTS {
                return Err(format!("more than {MOST_POINTS} points"));
            }
        }
        let count = y.len();
        let x_factor = self.number("XFACTOR")?.unwrap_or(1.0);
        let first = self.number("FIRSTX")?.or(start.map(|x| x * x_factor)).unwrap_or(0.0);
        let step = self.number("DELTAX")?.unwrap_or(f64::NAN);
        let last = self.number("LASTX")?.unwrap_or(first + step * (count as f64 - 1.0));
        if self.number("NPOINTS")?.unwrap_or(count as f64) != count as f64 || !(last - first).is_finite() {
            return Err(format!("this JCAMP-DX file holds {count} points, and NPOINTS, FIRSTX, LASTX say otherwise"));
        }
        let x = (0..count).map(|i| first + (last - first) * i as f64 / (count.max(2) - 1) as f64).collect();
        Ok(Points { x, y, lines })
    }

    /// `(XY..XY)`: pairs, over the ends of lines.
    fn pairs(&self) -> Result<Points, String> {
        let (x_factor, y_factor) = (self.number("XFACTOR")?.unwrap_or(1.0), self.number("YFACTOR")?.unwrap_or(1.0));
        let mut flat = Vec::new();
        for row in self.rows() {
            let (line, numbers) = row?;
            flat.extend(numbers.into_iter().map(|value| (value, line)));
        }
        if !flat.len().is_multiple_of(2) {
            return Err("the pairs of this JCAMP-DX file are not complete".into());
        }
        let mut points = Points::default();
        for pair in flat.chunks_exact(2) {
            points.x.push(pair[0].0 * x_factor);
            points.y.push(pair[1].0 * y_factor);
            points.lines.push(pair[0].1);
        }
        let count = points.x.len();
        if self.number("NPOINTS")?.is_some_and(|told| told != count as f64) {
            return Err(format!("this JCAMP-DX file holds {count} points, and NPOINTS says otherwise"));
        }
        Ok(points)
    }
}

/// The points of a table, each with the line it stands on.
#[derive(Default)]
struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    lines: Vec<usize>,
}

/// The first table of a file: x, y, named by their units.
pub fn read(text: &str) -> Result<Rows, String> {
    let file = Labelled::read(text)?;
    let Points { x, y, lines } = if file.form.contains("X++") { file.even_steps()? } else { file.pairs()? };
    if x.len() < 2 {
        return Err(format!("this JCAMP-DX file holds {} points", x.len()));
    }
    let unit = |name: &str| file.word(name).unwrap_or_default().to_owned();
    Ok(Rows {
        names: vec![unit("XUNITS"), unit("YUNITS")],
        columns: vec![x, y],
        lines,
        header: Vec::new(),
        dialect: "JCAMP-DX",
        missing: 0,
        first_missing: None,
        trailer: None,
        garbage: None,
        ragged: None,
        others: Vec::new(),
        comment: String::new(),
    })
}

/// The numbers of a line: parted by blanks, commas or semicolons, or by their signs alone (`400.1+42+44`).
fn numbers(line: &str) -> Option<Vec<f64>> {
    let mut words: Vec<String> = vec![String::new()];
    let mut last = ' ';
    for letter in line.chars() {
        let starts = matches!(letter, '+' | '-') && !matches!(last, 'e' | 'E');
        if letter.is_whitespace() || matches!(letter, ',' | ';') || starts {
            words.push(String::new());
        }
        if !(letter.is_whitespace() || matches!(letter, ',' | ';'))
            && let Some(word) = words.last_mut()
        {
            word.push(letter);
        }
        last = letter;
    }
    words
        .iter()
        .filter(|word| !word.is_empty())
        .map(|word| word.parse::<f64>().ok().filter(|value| value.is_finite()))
        .collect()
}
