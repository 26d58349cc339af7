//! Reading values out of the tree with errors that say where: every reader of a table names the keys it knows.

use crate::error::SceneError;
use crate::schema::{Default, Kind, MAX_LENGTH};
use crate::tree::{Node, Value};

/// A table of the scene that is being read, with its dotted path. [`crate::check`] has seen it: what is asked for here by
/// its key is of its kind and within its range, or is left out.
pub struct Table<'a> {
    kind: &'static Kind,
    path: String,
    entries: &'a [(String, Node)],
    line: Option<usize>,
}

/// `a`, `b` and `c`.
pub fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [init @ .., last] => format!("{} and {last}", init.join(", ")),
    }
}

/// The known name that is near a given one.
pub fn nearest<'a>(given: &str, known: &[&'a str]) -> Option<&'a str> {
    // A name that long is near to none, and the distance costs the product of the lengths.
    let candidates = if given.len() > 100 { &[] } else { known };
    // `fov` for `fov_deg`: the unit forgotten.
    let longer = candidates.iter().find(|name| given.len() >= 3 && name.starts_with(given));
    let near = candidates
        .iter()
        .map(|name| (strsim::damerau_levenshtein(given, name), name))
        .filter(|(distance, name)| *distance <= 1 + name.len().max(given.len()) / 3)
        .min();
    longer.or(near.map(|(_, name)| name)).copied()
}

/// `; did you mean "x"?` where a known name is near, else a list of all.
pub fn suggestion(given: &str, known: &[&str]) -> String {
    match nearest(given, known) {
        Some(name) => format!("; did you mean \"{name}\"?"),
        None => format!("; known here: {}", listed(known)),
    }
}

/// The complaint about a value: `camera.fov_deg must be ..., got 200`.
pub fn wrong(node: &Node, path: &str, allowed: &str) -> SceneError {
    SceneError::new(format!("{path} must be {allowed}, got {}", node.describe())).at(path, node.line)
}

/// The complaint about a key that is left out.
pub fn missing(path: &str, line: Option<usize>, key: &str) -> SceneError {
    let place = if path.is_empty() { "the scene" } else { path };
    SceneError::new(format!("{place} needs the key \"{key}\"")).at(join(path, key), line)
}

impl<'a> Table<'a> {
    /// The table of a kind at `path`.
    pub fn new(node: &'a Node, kind: &'static Kind, path: impl Into<String>) -> Result<Table<'a>, SceneError> {
        let path = path.into();
        match &node.value {
            Value::Table(entries) => Ok(Table { kind, path, entries, line: node.line }),
            _ => Err(no_table(node, kind, &path)),
        }
    }

    /// The dotted path of one of its keys.
    pub fn path(&self, key: &str) -> String {
        join(&self.path, key)
    }

    /// The line of one of its keys, or its own.
    pub fn line(&self, key: &str) -> Option<usize> {
        self.get(key).and_then(|node| node.line).or(self.line)
    }

    /// A value, if it is there.
    pub fn get(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }

    /// A value that must be there.
    pub fn need(&self, key: &str) -> Result<&'a Node, SceneError> {
        self.get(key).ok_or_else(|| missing(&self.path, self.line, key))
    }

    /// The one of its alternatives that is there.
    pub fn choice(&self) -> Result<(&'static str, &'a Node), SceneError> {
        let choices = self.kind.choices();
        let found = choices.iter().find_map(|key| self.get(key).map(|node| (*key, node)));
        found.ok_or_else(|| missing(&self.path, self.line, &listed(&choices)))
    }

    /// A complaint about one of its keys.
    pub fn wrong(&self, key: &str, allowed: &str) -> SceneError {
        let given = self.get(key).map_or("nothing".to_owned(), Node::describe);
        SceneError::new(format!("{} must be {allowed}, got {given}", self.path(key))).at(self.path(key), self.line(key))
    }

    fn default(&self, key: &str) -> Default {
        self.kind.key(key).map_or(Default::Needed, |key| key.default)
    }

    /// A finite number, or its default.
    pub fn number(&self, key: &str) -> Result<f64, SceneError> {
        match (self.get(key).map(as_number), self.default(key)) {
            (Some(Some(value)), _) | (None, Default::Number(value)) => Ok(value),
            (Some(None), _) => Err(self.wrong(key, "a number")),
            (None, _) => Err(missing(&self.path, self.line, key)),
        }
    }

    /// A finite number, if it is there.
    pub fn number_if_given(&self, key: &str) -> Result<Option<f64>, SceneError> {
        self.get(key).map(|_| self.number(key)).transpose()
    }

    /// A whole number, or its default.
    pub fn whole(&self, key: &str) -> Result<u64, SceneError> {
        match (self.get(key).map(as_whole), self.default(key)) {
            (Some(Some(value)), _) | (None, Default::Whole(value)) => Ok(value),
            (Some(None), _) => Err(self.wrong(key, "a whole number")),
            (None, _) => Err(missing(&self.path, self.line, key)),
        }
    }

    /// Three coordinates, or their default.
    pub fn triple(&self, key: &str) -> Result<[f64; 3], SceneError> {
        match (self.get(key).map(as_triple), self.default(key)) {
            (Some(Some(value)), _) | (None, Default::Triple(value)) => Ok(value),
            (Some(None), _) => Err(self.wrong(key, "three numbers")),
            (None, _) => Err(missing(&self.path, self.line, key)),
        }
    }

    /// A text, or its default.
    pub fn text(&self, key: &str) -> Result<&'a str, SceneError> {
        match (self.get(key).map(|node| &node.value), self.default(key)) {
            (Some(Value::Text(text)), _) => Ok(text),
            (Some(_), _) => Err(self.wrong(key, "a text")),
            (None, Default::Text(text)) => Ok(text),
            (None, _) => Err(missing(&self.path, self.line, key)),
        }
    }

    /// A value of any kind, or its default as a value: a number, a text, or a table of one kind with its own defaults.
    pub fn node(&self, key: &str) -> Result<Node, SceneError> {
        match (self.get(key), self.default(key)) {
            (Some(node), _) => Ok(node.clone()),
            (None, Default::Number(value)) => Ok(Node::number(value)),
            (None, Default::Text(text)) => Ok(Node::text(text)),
            (None, Default::Table(kind)) => Ok(Node::table([(kind, Node::table([]))])),
            (None, _) => Err(missing(&self.path, self.line, key)),
        }
    }

    /// A list, empty where it is left out.
    pub fn list(&self, key: &str) -> &'a [Node] {
        match self.get(key).map(|node| &node.value) {
            Some(Value::List(items)) => items,
            _ => &[],
        }
    }
}

/// What is no table where one is to be.
pub fn no_table(node: &Node, kind: &Kind, path: &str) -> SceneError {
    let name = if path.is_empty() { "a scene" } else { path };
    let keys = if kind.alternatives.is_empty() || kind.is_optional { kind.names() } else { kind.choices() };
    SceneError::new(format!("{name} must be a table with the keys {}, got {}", listed(&keys), node.describe()))
        .at(path, node.line)
}

/// Where a key stands, for a message: with a line beside it, the path inside the object says enough.
pub fn place(path: &str, line: Option<usize>) -> &str {
    let inside = path.strip_prefix("object.").and_then(|rest| rest.split_once('.')).map(|(_name, inside)| inside);
    inside.filter(|_| line.is_some()).unwrap_or(path)
}

/// `a.b`, or `b` at the root.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// A number of either kind.
pub fn as_number(node: &Node) -> Option<f64> {
    match node.value {
        Value::Int(i) => Some(i as f64),
        Value::Float(f) => Some(f),
        _ => None,
    }
}

/// A whole number of 64 bits, of either kind.
pub fn as_whole(node: &Node) -> Option<u64> {
    match node.value {
        Value::Int(i) => u64::try_from(i).ok(),
        Value::Float(f) if f.fract() == 0.0 && (0.0..1.8e19).contains(&f) => Some(f as u64),
        _ => None,
    }
}

/// Numbers of a list.
pub fn as_numbers(node: &Node) -> Option<Vec<f64>> {
    match &node.value {
        Value::List(items) => items.iter().map(as_number).collect(),
        _ => None,
    }
}

/// Three numbers.
pub fn as_triple(node: &Node) -> Option<[f64; 3]> {
    as_numbers(node)?.try_into().ok()
}

/// A node as factors along the three axes, none of them 0.
pub fn as_scales(node: &Node) -> Option<[f64; 3]> {
    let factors = match as_number(node) {
        Some(all) => [all; 3],
        None => as_triple(node)?,
    };
    let within = |factor: f64| (1.0 / MAX_LENGTH..=MAX_LENGTH).contains(&factor.abs());
    factors.iter().all(|&factor| within(factor)).then_some(factors)
}

/// A node as three rows of four numbers; a fourth one must be 0 0 0 1.
pub fn as_matrix(node: &Node) -> Option<[[f64; 4]; 3]> {
    let Value::List(rows) = &node.value else { return None };
    let rows: Vec<[f64; 4]> = rows.iter().map(|row| as_numbers(row)?.try_into().ok()).collect::<Option<_>>()?;
    let rows: [[f64; 4]; 3] = match rows.as_slice() {
        [rest @ .., last] if rows.len() == 4 && *last == [0.0, 0.0, 0.0, 1.0] => rest.try_into().ok()?,
        three => three.try_into().ok()?,
    };
    rows.iter().flatten().all(|v| v.abs() <= MAX_LENGTH).then_some(rows)
}
