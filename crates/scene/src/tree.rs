//! A scene as it was written: one tree for TOML, JSON and Python dicts, with the line of every value that has one.

use crate::error::SceneError;

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

    /// A number: whole numbers up to 2^53 are written without a point.
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

    /// The child of a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|(k, _)| k == key).map(|(_, v)| v),
            _ => None,
        }
    }

    /// What to call it in a message: `a table`, `the text "abc"`, `3.5`.
    pub fn describe(&self) -> String {
        match &self.value {
            Value::Bool(b) => b.to_string(),
            Value::Int(i) => i.to_string(),
            Value::Float(f) => format!("{f}"),
            Value::Text(t) if t.chars().count() > 60 => format!("\"{}...\"", t.chars().take(57).collect::<String>()),
            Value::Text(t) => format!("\"{t}\""),
            Value::List(l)
                if l.len() <= 4 && !l.iter().any(|item| matches!(item.value, Value::List(_) | Value::Table(_))) =>
            {
                format!("[{}]", l.iter().map(Node::describe).collect::<Vec<_>>().join(", "))
            }
            Value::List(l) => format!("a list of {}", l.len()),
            Value::Table(t) if t.is_empty() => "an empty table".into(),
            Value::Table(t) => {
                let keys: Vec<&str> = t.iter().map(|(k, _)| k.as_str()).take(4).collect();
                format!("a table with {}", keys.join(", "))
            }
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

    /// The same tree as JSON; numbers that JSON cannot hold do not occur in a validated scene.
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
                .map_err(|_| wrong(format!("not a whole number: {}", i.as_str())))?,
        ),
        DeValue::Float(f) => {
            Value::Float(f.as_str().parse().map_err(|_| wrong(format!("not a number: {}", f.as_str())))?)
        }
        DeValue::Datetime(_) => return Err(wrong("a scene holds no dates".into())),
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
        Json::Null => return Err(SceneError::new("a scene holds no null; leave the key out to take its default")),
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
