//! A scene as it was written: one tree for TOML, JSON and Python dicts, with the line of every value that has one.

use crate::error::SceneError;
pub use iridesce_files::quoted;

/// Deepest nesting of tables and lists; scenes need eight.
pub const MAX_DEPTH: usize = 64;

/// A value and the line it stands on.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Its line, counted from 1; `None` where the scene was no text.
    pub line: Option<usize>,
}

/// What a scene may hold.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// True or false.
    Bool(bool),
    /// A whole number.
    Int(i128),
    /// Any other number, NaN and infinities included: the validator names the place.
    Float(f64),
    /// A text.
    Text(String),
    /// A list.
    List(Vec<Node>),
    /// A table, in the order it was written.
    Table(Vec<(String, Node)>),
    /// What no scene holds (a date, a null, an object of another language), in words: the validator names the place.
    Other(String),
}

impl From<Value> for Node {
    fn from(value: Value) -> Node {
        Node { value, line: None }
    }
}

impl Node {
    /// A table of named values.
    pub fn table(entries: impl IntoIterator<Item = (&'static str, Node)>) -> Node {
        Value::Table(entries.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()).into()
    }

    /// A number.
    pub fn number(value: f64) -> Node {
        Value::Float(value).into()
    }

    /// A list of numbers.
    pub fn numbers(values: &[f64]) -> Node {
        Value::List(values.iter().map(|&v| Node::number(v)).collect()).into()
    }

    /// A text.
    pub fn text(value: impl Into<String>) -> Node {
        Value::Text(value.into()).into()
    }

    /// The same values without the lines they came from.
    pub fn without_lines(&self) -> Node {
        let value = match &self.value {
            Value::List(items) => Value::List(items.iter().map(Node::without_lines).collect()),
            Value::Table(entries) => {
                Value::Table(entries.iter().map(|(k, v)| (k.clone(), v.without_lines())).collect())
            }
            plain => plain.clone(),
        };
        value.into()
    }

    /// The child of a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|(k, _)| k == key).map(|(_, v)| v),
            _ => None,
        }
    }

    /// What to call it in a message: `"abc"`, `3.5`, `[1.0, NaN]`, `a table with top and bottom`.
    pub fn describe(&self) -> String {
        let plain = |node: &Node| !matches!(node.value, Value::List(_) | Value::Table(_));
        match &self.value {
            Value::Bool(b) => b.to_string(),
            Value::Int(i) => i.to_string(),
            Value::Float(f) => format!("{f:?}"),
            Value::Text(t) => quoted(t),
            Value::List(l) if l.is_empty() => "an empty list".into(),
            Value::List(l) if l.len() <= 4 && l.iter().all(plain) => {
                format!("[{}]", l.iter().map(Node::describe).collect::<Vec<_>>().join(", "))
            }
            Value::List(l) => format!("a list of {}", l.len()),
            Value::Table(t) if t.is_empty() => "an empty table".into(),
            Value::Table(t) => {
                let keys: Vec<String> = t.iter().map(|(k, _)| quoted(k)).take(4).collect();
                format!("a table with {}", keys.join(", "))
            }
            Value::Other(words) => words.clone(),
        }
    }

    /// Reads TOML.
    pub fn from_toml(text: &str) -> Result<Node, SceneError> {
        let lines = LineIndex::new(text);
        let table = toml::de::DeTable::parse(text).map_err(|e| {
            let line = e.span().map(|span| lines.line(span.start));
            let mut error = SceneError::new(format!("not valid TOML: {}", e.message().trim()));
            error.line = line;
            error
        })?;
        from_toml_table(table.get_ref(), Some(1), &lines, 0)
    }

    /// Reads JSON.
    pub fn from_json(text: &str) -> Result<Node, SceneError> {
        let value: serde_json::Value = serde_json::from_str(text).map_err(|e| {
            let mut error = SceneError::new(format!("not valid JSON: {e}"));
            error.line = Some(e.line());
            error
        })?;
        from_json_value(value, 0)
    }

    /// The same tree as JSON; what JSON cannot hold becomes null, and does not occur in a validated scene.
    pub fn to_json(&self) -> serde_json::Value {
        match &self.value {
            Value::Bool(b) => (*b).into(),
            Value::Int(i) => match (i64::try_from(*i), u64::try_from(*i)) {
                (Ok(i), _) => i.into(),
                (_, Ok(u)) => u.into(),
                _ => (*i as f64).into(),
            },
            Value::Float(f) => (*f).into(),
            Value::Text(t) => t.clone().into(),
            Value::List(l) => l.iter().map(Node::to_json).collect(),
            Value::Table(t) => serde_json::Value::Object(t.iter().map(|(k, v)| (k.clone(), v.to_json())).collect()),
            Value::Other(_) => serde_json::Value::Null,
        }
    }
}

/// A deep nesting is refused, not recursed into.
fn check_depth(depth: usize, line: Option<usize>) -> Result<(), SceneError> {
    if depth > MAX_DEPTH {
        let mut error = SceneError::new(format!("nested deeper than {MAX_DEPTH} levels"));
        error.line = line;
        return Err(error);
    }
    Ok(())
}

fn from_toml_table(
    table: &toml::de::DeTable<'_>,
    line: Option<usize>,
    lines: &LineIndex,
    depth: usize,
) -> Result<Node, SceneError> {
    check_depth(depth, line)?;
    let mut entries: Vec<(usize, String, Node)> = Vec::new();
    for (key, value) in table {
        let node = from_toml_value(value, Some(lines.line(key.span().start)), lines, depth + 1)?;
        entries.push((key.span().start, key.get_ref().to_string(), node));
    }
    entries.sort_by_key(|(start, ..)| *start);
    Ok(Node { value: Value::Table(entries.into_iter().map(|(_, k, v)| (k, v)).collect()), line })
}

fn from_toml_value(
    value: &toml::Spanned<toml::de::DeValue<'_>>,
    line: Option<usize>,
    lines: &LineIndex,
    depth: usize,
) -> Result<Node, SceneError> {
    use toml::de::DeValue;
    check_depth(depth, line)?;
    let wrong = |message: String| {
        let mut error = SceneError::new(message);
        error.line = line;
        error
    };
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Boolean(b) => Value::Bool(*b),
        DeValue::Integer(i) => Value::Int(
            i128::from_str_radix(i.as_str(), i.radix())
                .map_err(|_| wrong(format!("a whole number beyond 128 bits: {}", quoted(i.as_str()))))?,
        ),
        DeValue::Float(f) => {
            Value::Float(f.as_str().parse().map_err(|_| wrong(format!("not a number: {}", quoted(f.as_str()))))?)
        }
        DeValue::Datetime(date) => Value::Other(format!("the date {date}")),
        DeValue::Array(array) => {
            let items: Result<Vec<Node>, SceneError> = array
                .iter()
                .map(|item| from_toml_value(item, Some(lines.line(item.span().start)), lines, depth + 1))
                .collect();
            Value::List(items?)
        }
        DeValue::Table(table) => return from_toml_table(table, line, lines, depth),
    };
    Ok(Node { value, line })
}

fn from_json_value(value: serde_json::Value, depth: usize) -> Result<Node, SceneError> {
    use serde_json::Value as Json;
    check_depth(depth, None)?;
    let value = match value {
        Json::Null => Value::Other("null".to_owned()),
        Json::Bool(b) => Value::Bool(b),
        Json::Number(n) => match (n.as_i64(), n.as_u64()) {
            (Some(i), _) => Value::Int(i.into()),
            (_, Some(u)) => Value::Int(u.into()),
            _ => Value::Float(n.as_f64().unwrap_or(f64::NAN)),
        },
        Json::String(s) => Value::Text(s),
        Json::Array(items) => {
            Value::List(items.into_iter().map(|item| from_json_value(item, depth + 1)).collect::<Result<_, _>>()?)
        }
        Json::Object(entries) => Value::Table(
            entries
                .into_iter()
                .map(|(key, item)| Ok((key, from_json_value(item, depth + 1)?)))
                .collect::<Result<_, SceneError>>()?,
        ),
    };
    Ok(value.into())
}

/// Byte offset to line number.
struct LineIndex {
    starts: Vec<usize>,
}

impl LineIndex {
    fn new(text: &str) -> LineIndex {
        let newlines = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        LineIndex { starts: std::iter::once(0).chain(newlines).collect() }
    }

    fn line(&self, offset: usize) -> usize {
        self.starts.partition_point(|&start| start <= offset)
    }
}
