//! How one program writes a row: separator, decimal sign, words for what is missing.

/// Words that stand for a missing value.
const MISSING: [&str; 16] = [
    "", "nan", "na", "n/a", "-", "--", "---", "null", "none", "#n/a", "inf", "-inf", "+inf", "over", "overflow", "sat",
];

/// What parts the cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    Letter(char),
    /// Any run of blanks.
    Blanks,
    /// A comma that also marks decimals: the fields of a row come in pairs.
    EverySecondComma,
}

/// Separator and decimal sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dialect {
    pub separator: Separator,
    pub decimal: char,
    /// The least ambiguous first.
    pub order: usize,
    pub words: &'static str,
}

const fn dialect(order: usize, separator: Separator, decimal: char, words: &'static str) -> Dialect {
    Dialect { separator, decimal, order, words }
}

/// Separators with the decimal sign they leave free, the least ambiguous first.
pub const DIALECTS: [Dialect; 8] = [
    dialect(0, Separator::Letter('\t'), '.', "tabs, decimal points"),
    dialect(1, Separator::Letter('\t'), ',', "tabs, decimal commas"),
    dialect(2, Separator::Letter(';'), '.', "semicolons, decimal points"),
    dialect(3, Separator::Letter(';'), ',', "semicolons, decimal commas"),
    dialect(4, Separator::Letter(','), '.', "commas, decimal points"),
    dialect(5, Separator::Blanks, '.', "blanks, decimal points"),
    dialect(6, Separator::Blanks, ',', "blanks, decimal commas"),
    dialect(7, Separator::EverySecondComma, ',', "commas, decimal commas"),
];

impl Dialect {
    pub fn is_both_commas(self) -> bool {
        self.separator == Separator::EverySecondComma
    }
}

/// One cell of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    Number(f64),
    /// A word for nothing.
    Missing(String),
    Garbage(String),
}

impl Cell {
    pub fn is_number(&self) -> bool {
        matches!(self, Cell::Number(_))
    }

    pub fn is_garbage(&self) -> bool {
        matches!(self, Cell::Garbage(_))
    }

    /// NaN where there is none.
    pub fn value(&self) -> f64 {
        match self {
            Cell::Number(value) => *value,
            _ => f64::NAN,
        }
    }
}

/// The words of a line, blanks and quotation marks around them removed.
pub fn split(line: &str, dialect: Dialect) -> Vec<String> {
    let bare = |word: &str| word.trim().trim_matches(['"', '\'']).trim().to_owned();
    match dialect.separator {
        Separator::Blanks => line.split_whitespace().map(bare).collect(),
        Separator::Letter(letter) => cells(line, letter).iter().map(|word| bare(word)).collect(),
        Separator::EverySecondComma if line.contains('"') => cells(line, ',').iter().map(|word| bare(word)).collect(),
        Separator::EverySecondComma => line.split(',').map(bare).collect(),
    }
}

/// The cells between separators that stand outside quotation marks.
fn cells(line: &str, separator: char) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for letter in line.chars() {
        if letter == '"' {
            quoted = !quoted;
        } else if letter == separator && !quoted {
            cells.push(String::new());
            continue;
        }
        if let Some(cell) = cells.last_mut() {
            cell.push(letter);
        }
    }
    cells
}

/// The cells of a row that begins with a number; `None` for a line that is none.
pub fn parse(line: &str, dialect: Dialect) -> Option<Vec<Cell>> {
    let line = without_comment(line).trim_end_matches(['\n', ' ']);
    if dialect.separator != Separator::Letter('\t') && line.trim().is_empty()
        || line.trim_start().starts_with(['#', '!', '%'])
    {
        return None;
    }
    let mut words = split(line, dialect);
    if dialect.is_both_commas() && !line.contains('"') {
        if line.contains('.') || !words.len().is_multiple_of(2) {
            return None;
        }
        words = words.chunks_exact(2).map(|pair| pair.join(",")).collect();
    }
    if words.len() < 2 {
        return None;
    }
    let mut cells = Vec::with_capacity(words.len());
    for (place, word) in words.into_iter().enumerate() {
        let cell = match number(&word, dialect.decimal) {
            Some(value) => Cell::Number(value),
            None if place > 0
                && (MISSING.contains(&word.to_lowercase().as_str()) || word.bytes().all(|b| b == b'*')) =>
            {
                Cell::Missing(word)
            }
            // The first two cells of a row are numbers or missing; what follows may be a remark.
            None if place < 2 => return None,
            None => Cell::Garbage(word),
        };
        cells.push(cell);
    }
    Some(cells)
}

/// A line up to its `#`, which starts a comment, unless it is `#N/A`.
fn without_comment(line: &str) -> &str {
    let mut from = 0;
    while let Some(found) = line[from..].find('#') {
        let at = from + found;
        if !line[at..].to_ascii_lowercase().starts_with("#n/a") {
            return &line[..at];
        }
        from = at + 1;
    }
    line
}

/// A finite number in plain or scientific writing with that decimal sign.
pub fn number(word: &str, decimal: char) -> Option<f64> {
    let other = if decimal == ',' { '.' } else { ',' };
    let is_plain = !word.is_empty()
        && word.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b',' | b'e' | b'E' | b'd' | b'D'))
        // A point beside a decimal comma could only group thousands.
        && !word.contains(other);
    if !is_plain || !word.bytes().any(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let plain: String = word
        .chars()
        .map(|letter| match letter {
            ',' => '.',
            // Fortran's double precision.
            'd' | 'D' => 'e',
            other => other,
        })
        .collect();
    plain.parse::<f64>().ok().filter(|value| value.is_finite())
}
