//! Reading values out of the tree with errors that say where: every reader of a table names the keys it knows.

use crate::error::SceneError;
use crate::shape::length;
use crate::tree::{Node, Value, quoted};

/// Largest coordinate, scene units, and one over the smallest length: squares and their products stay within the range
/// of the renderer's single precision (1e38).
const MAX_LENGTH: f64 = 1e9;

/// A table of the scene that is being read, with its dotted path.
pub struct Table<'a> {
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

/// `; did you mean "x"?` where a known name is near, else a list of all.
pub fn suggestion(given: &str, known: &[&str]) -> String {
    // A name that long is near to none, and the distance costs the product of the lengths.
    let candidates = if given.len() > 100 { &[] } else { known };
    // `fov` for `fov_deg`: the unit forgotten.
    let longer = candidates.iter().find(|name| given.len() >= 3 && name.starts_with(given));
    let near = candidates
        .iter()
        .map(|name| (strsim::damerau_levenshtein(given, name), name))
        .filter(|(distance, name)| *distance <= 1 + name.len().max(given.len()) / 3)
        .min();
    match longer.or(near.map(|(_, name)| name)) {
        Some(name) => format!("; did you mean \"{name}\"?"),
        None => format!("; known here: {}", listed(known)),
    }
}

impl<'a> Table<'a> {
    /// The table at `path`, whose keys must be among `known`. Keys in `later` exist in the scene language but not in
    /// this version.
    pub fn new(
        node: &'a Node,
        path: impl Into<String>,
        known: &[&str],
        later: &[&str],
    ) -> Result<Table<'a>, SceneError> {
        let path = path.into();
        let Value::Table(entries) = &node.value else {
            let name = if path.is_empty() { "a scene" } else { path.as_str() };
            return Err(SceneError::new(format!(
                "{name} must be a table with the keys {}, got {}",
                listed(known),
                node.describe()
            ))
            .at(&path, node.line));
        };
        for (key, value) in entries {
            if known.contains(&key.as_str()) {
                continue;
            }
            let inside = match place(&path, value.line) {
                "" => String::new(),
                place => format!(" in {place}"),
            };
            let message = if later.contains(&key.as_str()) {
                format!("{}{inside} is not available in this version; available: {}", quoted(key), listed(known))
            } else {
                format!("unknown key {}{inside}{}", quoted(key), suggestion(key, known))
            };
            return Err(SceneError::new(message).at(join(&path, key), value.line));
        }
        Ok(Table { path, entries, line: node.line })
    }

    /// The dotted path of one of its keys.
    pub fn path(&self, key: &str) -> String {
        join(&self.path, key)
    }

    /// A value, if it is there.
    pub fn get(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }

    /// A value that must be there.
    pub fn need(&self, key: &str) -> Result<&'a Node, SceneError> {
        self.get(key).ok_or_else(|| {
            let place = if self.path.is_empty() { "the scene".to_owned() } else { self.path.clone() };
            SceneError::new(format!("{place} needs the key \"{key}\"")).at(self.path(key), self.line)
        })
    }

    /// Exactly one of these keys.
    pub fn one_of(&self, keys: &[&'static str]) -> Result<(&'static str, &'a Node), SceneError> {
        let given: Vec<(&'static str, &'a Node)> =
            keys.iter().filter_map(|key| self.get(key).map(|node| (*key, node))).collect();
        match given.as_slice() {
            [one] => Ok(*one),
            [] => {
                let needs =
                    if let [only] = keys { format!("the key \"{only}\"") } else { format!("one of {}", listed(keys)) };
                Err(SceneError::new(format!("{} needs {needs}", self.path)).at(&self.path, self.line))
            }
            [(first, _), (second, node), ..] => Err(SceneError::new(format!(
                "{} takes one of {}, got both {first} and {second}",
                self.path,
                listed(keys)
            ))
            .at(self.path(second), node.line)),
        }
    }

    /// A complaint about one of its keys: `camera.fov_deg must be ..., got 200`.
    pub fn wrong(&self, key: &str, allowed: &str) -> SceneError {
        let node = self.get(key);
        let given = node.map_or("nothing".to_owned(), Node::describe);
        SceneError::new(format!("{} must be {allowed}, got {given}", self.path(key)))
            .at(self.path(key), node.and_then(|n| n.line).or(self.line))
    }

    /// A finite number in a range (which `allowed` puts into words), or its default.
    pub fn number(
        &self,
        key: &str,
        default: f64,
        allowed: &str,
        check: impl Fn(f64) -> bool,
    ) -> Result<f64, SceneError> {
        if self.get(key).is_some() { self.needed_number(key, allowed, check) } else { Ok(default) }
    }

    /// A finite number in a range that must be there.
    pub fn needed_number(&self, key: &str, allowed: &str, check: impl Fn(f64) -> bool) -> Result<f64, SceneError> {
        match as_number(self.need(key)?) {
            Some(value) if value.is_finite() && check(value) => Ok(value),
            _ => Err(self.wrong(key, allowed)),
        }
    }

    /// A length in scene units that single precision can square, or its default.
    pub fn length(&self, key: &str, default: f64) -> Result<f64, SceneError> {
        self.number(key, default, "a length > 0, from 1e-9 to 1e9", |v| (1.0 / MAX_LENGTH..=MAX_LENGTH).contains(&v))
    }

    /// A whole number in a range, or its default.
    pub fn whole(&self, key: &str, default: u64, from: u64, to: u64) -> Result<u64, SceneError> {
        let Some(node) = self.get(key) else { return Ok(default) };
        let value = match node.value {
            Value::Int(i) => u64::try_from(i).ok(),
            Value::Float(f) if f.fract() == 0.0 && (0.0..1.8e19).contains(&f) => Some(f as u64),
            _ => None,
        };
        value
            .filter(|v| (from..=to).contains(v))
            .ok_or_else(|| self.wrong(key, &format!("a whole number from {from} to {to}")))
    }

    /// Three coordinates, or their default.
    pub fn triple(&self, key: &str, default: [f64; 3]) -> Result<[f64; 3], SceneError> {
        let Some(node) = self.get(key) else { return Ok(default) };
        let numbers: Option<Vec<f64>> = match &node.value {
            Value::List(items) if items.len() == 3 => items.iter().map(as_number).collect(),
            _ => None,
        };
        match numbers.as_deref() {
            Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.abs() <= MAX_LENGTH) => Ok([x, y, z]),
            _ => Err(self.wrong(key, "three finite numbers, at most 1e9 either way")),
        }
    }

    /// Three coordinates with a direction, or their default.
    pub fn vector(&self, key: &str, default: [f64; 3]) -> Result<[f64; 3], SceneError> {
        let vector = self.triple(key, default)?;
        if (1.0 / MAX_LENGTH..=2.0 * MAX_LENGTH).contains(&length(vector)) {
            return Ok(vector);
        }
        Err(self.wrong(key, "a vector of a length > 0, from 1e-9 to 1e9"))
    }

    /// A text, if it is there.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>, SceneError> {
        match self.get(key).map(|node| &node.value) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(self.wrong(key, "a text")),
        }
    }

    /// A text that must be there.
    pub fn needed_text(&self, key: &str) -> Result<&'a str, SceneError> {
        self.need(key)?;
        Ok(self.text(key)?.unwrap_or_default())
    }

    /// A list of tables with at least one entry.
    pub fn list(&self, key: &str) -> Result<&'a [Node], SceneError> {
        match &self.need(key)?.value {
            Value::List(items) if !items.is_empty() => Ok(items),
            Value::List(_) => Err(self.wrong(key, "at least one table")),
            _ => Err(self.wrong(key, &format!("a list of tables (write [[{key}]])"))),
        }
    }
}

/// Where a key stands, for a message: with a line beside it, the path inside the object says enough.
fn place(path: &str, line: Option<usize>) -> &str {
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
