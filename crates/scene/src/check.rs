//! Holds a tree against the schema: structure, names and ranges, all that is wrong at once. No map is read and no film
//! flows.

use iridesce_files::quoted;
use iridesce_numerics::vector::length;

use crate::error::SceneError;
use crate::files::map_file;
use crate::lights::illuminant;
use crate::medium::medium;
use crate::model::Origin;
use crate::objects::{is_object_name, name_or_number};
use crate::reader::{
    as_matrix, as_number, as_numbers, as_scales, as_triple, as_whole, join, listed, missing, nearest, no_table, place,
    suggestion, wrong,
};
use crate::schema::{Default, Key, Kind, MAX_LENGTH, MAX_SIDE, Range, THICKNESS, Takes};
use crate::tree::{Node, Value};

/// Most pixels of a picture: 64 GiB of planes. What the machine at hand can hold, the renderer asks.
const MAX_PIXELS: u64 = 1 << 31;
/// Most complaints about one scene.
const MOST_FAULTS: usize = 1000;

/// What is wrong with a scene so far.
pub struct Checker<'a> {
    /// What paths are relative to.
    pub origin: &'a Origin,
    /// All complaints, in the order of reading.
    pub faults: Vec<SceneError>,
}

impl Checker<'_> {
    /// Notes a complaint.
    pub fn complain(&mut self, fault: SceneError) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(fault);
        }
    }

    /// Checks a value; if it is sound, reads it, which finds what only its parts together can tell.
    pub fn part<T>(
        &mut self,
        node: &Node,
        kind: &'static Kind,
        path: &str,
        read: impl FnOnce() -> Result<T, SceneError>,
    ) -> Option<T> {
        let before = self.faults.len();
        self.table(node, kind, path);
        if self.faults.len() > before {
            return None;
        }
        read().map_err(|fault| self.complain(fault)).ok()
    }

    fn table(&mut self, node: &Node, kind: &'static Kind, path: &str) {
        for (key, value) in self.keys(node, kind, path) {
            if let Some(spec) = kind.key(key) {
                self.value(value, spec, &join(path, key));
            }
        }
    }

    /// The entries of a table; which of them do not belong there, and which are missing.
    pub fn keys<'n>(&mut self, node: &'n Node, kind: &'static Kind, path: &str) -> &'n [(String, Node)] {
        let Value::Table(entries) = &node.value else {
            self.complain(no_table(node, kind, path));
            return &[];
        };
        let known = kind.names();
        // What an unknown key was meant to be is not missing too.
        let mut meant = Vec::new();
        for (key, value) in entries.iter().filter(|(key, _)| !known.contains(&key.as_str())) {
            let inside = match place(path, value.line) {
                "" => String::new(),
                place => format!(" in {place}"),
            };
            let message = if kind.later.contains(&key.as_str()) {
                meant.extend(kind.choices());
                let available = listed(&kind.choices());
                format!("{}{inside} is not available in this version; available: {available}", quoted(key))
            } else {
                meant.extend(nearest(key, &known));
                format!("unknown key {}{inside}{}", quoted(key), suggestion(key, &known))
            };
            self.complain(SceneError::new(message).at(join(path, key), value.line));
        }
        self.alternatives(entries, kind, path, node.line, &meant);
        for key in kind.keys {
            let is_there = entries.iter().any(|(name, _)| name == key.name);
            if matches!(key.default, Default::Needed) && !is_there && !meant.contains(&key.name) {
                self.complain(missing(path, node.line, key.name));
            }
        }
        entries
    }

    fn alternatives(
        &mut self,
        entries: &[(String, Node)],
        kind: &Kind,
        path: &str,
        line: Option<usize>,
        meant: &[&str],
    ) {
        let choices = kind.choices();
        let given: Vec<&(String, Node)> =
            choices.iter().filter_map(|choice| entries.iter().find(|(name, _)| name == choice)).collect();
        match given.as_slice() {
            [] if kind.is_optional || choices.is_empty() || choices.iter().any(|choice| meant.contains(choice)) => {}
            [] => {
                let needs = format!("{path} needs one of {}", listed(&choices));
                self.complain(SceneError::new(needs).at(path, line));
            }
            [(chosen, _)] => {
                let rivals = kind.alternatives.iter().filter(|keys| keys[0] != chosen.as_str());
                for keys in rivals {
                    let Some((key, node)) = entries.iter().find(|(name, _)| keys[1..].contains(&name.as_str())) else {
                        continue;
                    };
                    let key = join(path, key);
                    let message = format!("{key} goes with a {}, not with a {chosen}", keys[0]);
                    self.complain(SceneError::new(message).at(key, node.line));
                }
            }
            [(first, _), (second, node), ..] => {
                let message = format!("{path} takes one of {}, got both {first} and {second}", listed(&choices));
                self.complain(SceneError::new(message).at(join(path, second), node.line));
            }
        }
    }

    fn value(&mut self, node: &Node, key: &Key, path: &str) {
        let checked = match (key.takes, &node.value) {
            (Takes::Table(kind), _)
            | (Takes::Reflectance(kind) | Takes::Roughness(kind) | Takes::Thickness(kind), Value::Table(_))
            | (Takes::Instances(_, kind, _), Value::Table(_)) => {
                self.table(node, kind, path);
                Ok(())
            }
            (Takes::List(kind, least, most), _) => self.list(node, (kind, least, most), path),
            (Takes::Instances(kind, _, most), Value::List(_)) => self.list(node, (kind, 1, most), path),
            (takes, _) => self.leaf(node, takes, path),
        };
        if let Err(fault) = checked {
            self.complain(fault);
        }
    }

    /// A value that holds no keys of its own.
    fn leaf(&self, node: &Node, takes: Takes, path: &str) -> Result<(), SceneError> {
        let must = |is: bool, what: &str| if is { Ok(()) } else { Err(wrong(node, path, what)) };
        match takes {
            Takes::Number(range) => number(node, range, path),
            Takes::Whole(from, to) => must(
                as_whole(node).is_some_and(|value| (from..=to).contains(&value)),
                &format!("a whole number from {from} to {to}"),
            ),
            Takes::Integer(from, to) => must(
                matches!(node.value, Value::Int(value) if (i128::from(from)..=i128::from(to)).contains(&value)),
                &format!("a whole number from {from} to {to}"),
            ),
            Takes::Bool => must(matches!(node.value, Value::Bool(_)), "true or false"),
            Takes::Point => point(node, path).map(drop),
            Takes::Vector => vector(node, path),
            Takes::Sides => sides(node, path),
            Takes::Name => must(
                matches!(&node.value, Value::Text(name) if is_object_name(name)),
                "1 to 100 letters, digits, - and _",
            ),
            Takes::Choice(names, words) => {
                let is_known = matches!(&node.value, Value::Text(text) if names.contains(&text.as_str()));
                let listed = format!("one of {}", names.join(", "));
                must(is_known, if words.is_empty() { &listed } else { words })
            }
            Takes::Medium => medium(node, path).map(drop),
            Takes::Illuminant => named(node, path, |name| illuminant(name, self.origin).map(drop)),
            Takes::Text => text(node, path).map(drop),
            Takes::File => named(node, path, |name| map_file(self.origin, name).map(drop)),
            Takes::Builtin(names) => named(node, path, |name| builtin(name, names)),
            Takes::Reflectance(_) => {
                must(are_shares(node, 3), "a number from 0 to 1, or three of them (linear Rec.709)")
            }
            Takes::Roughness(_) => {
                must(are_shares(node, 2), "a number from 0 to 1, two of them (along u and along v) or a map")
            }
            Takes::Thickness(_) => match &node.value {
                Value::Int(_) | Value::Float(_) => number(node, THICKNESS, path),
                value => must(matches!(value, Value::Text(word) if word == "vertex"), "a number or a thickness model"),
            },
            Takes::Scale => must(
                matches!(one_or_more(node).len(), 1 | 3) && as_scales(node).is_some(),
                "a factor other than 0, or three of them, from 1e-9 to 1e9 either way",
            ),
            Takes::Pair(range) => must(
                matches!(as_numbers(node).as_deref(), Some([a, b]) if range.holds(*a) && range.holds(*b)),
                &format!("two numbers, of u and of v, each {}", range.words),
            ),
            Takes::Matrix => must(
                as_matrix(node).is_some(),
                "three rows of four finite numbers, at most 1e9 either way, the last of each what is added",
            ),
            Takes::Instances(..) => must(false, "a list of transforms, or { file = an NPY file of n x 3 x 4 numbers }"),
            // Keys of their own: `value` has them.
            Takes::Table(_) | Takes::List(..) => Ok(()),
        }
    }

    /// The entries of a list are checked where their parts are read; those of a list inside an object here.
    fn list(
        &mut self,
        node: &Node,
        (kind, least, most): (&'static Kind, usize, usize),
        path: &str,
    ) -> Result<(), SceneError> {
        let items = list_of(node, kind, least, most, path)?;
        for (number, item) in items.iter().enumerate() {
            self.table(item, kind, &format!("{path}.{number}"));
        }
        Ok(())
    }
}

/// The items of a list of tables.
pub fn list_of<'n>(
    node: &'n Node,
    kind: &Kind,
    least: usize,
    most: usize,
    path: &str,
) -> Result<&'n [Node], SceneError> {
    match &node.value {
        Value::List(items) if items.len() < least => Err(wrong(node, path, "at least one table")),
        Value::List(items) if items.len() > most => {
            let what = if least > 0 { "table" } else { kind.name };
            Err(wrong(node, path, &format!("a list of at most {most} {what}s")))
        }
        Value::List(items) => Ok(items),
        _ if least > 0 => Err(wrong(node, path, &format!("a list of tables (write [[{path}]])"))),
        _ => Err(wrong(node, path, &format!("a list of tables with {}", listed(&kind.names())))),
    }
}

/// The path of the object at `number`.
pub fn object_path(node: &Node, number: usize) -> String {
    format!("object.{}", name_or_number(node, number))
}

fn number(node: &Node, range: Range, path: &str) -> Result<(), SceneError> {
    match as_number(node) {
        Some(value) if range.holds(value) => Ok(()),
        _ => Err(wrong(node, path, range.words)),
    }
}

fn point(node: &Node, path: &str) -> Result<[f64; 3], SceneError> {
    as_triple(node)
        .filter(|point| point.iter().all(|v| v.abs() <= MAX_LENGTH))
        .ok_or_else(|| wrong(node, path, "three finite numbers, at most 1e9 either way"))
}

fn vector(node: &Node, path: &str) -> Result<(), SceneError> {
    let lengths = 1.0 / MAX_LENGTH..=2.0 * MAX_LENGTH;
    match lengths.contains(&length(point(node, path)?)) {
        true => Ok(()),
        false => Err(wrong(node, path, "a vector of a length > 0, from 1e-9 to 1e9")),
    }
}

/// The numbers of a list, or a number by itself.
fn one_or_more(node: &Node) -> Vec<f64> {
    as_number(node).map(|one| vec![one]).or(as_numbers(node)).unwrap_or_default()
}

/// One share by itself, or a list of so many: a list of one is half a pair.
fn are_shares(node: &Node, count: usize) -> bool {
    let numbers = one_or_more(node);
    let has_all = as_number(node).is_some() || numbers.len() == count;
    has_all && numbers.iter().all(|share| (0.0..=1.0).contains(share))
}

fn text<'n>(node: &'n Node, path: &str) -> Result<&'n str, SceneError> {
    match &node.value {
        Value::Text(text) => Ok(text),
        _ => Err(wrong(node, path, "a text")),
    }
}

/// The name of something that `known` knows.
fn named(node: &Node, path: &str, known: impl FnOnce(&str) -> Result<(), SceneError>) -> Result<(), SceneError> {
    known(text(node, path)?).map_err(|error| error.at(path, node.line))
}

fn builtin(name: &str, names: &[&str]) -> Result<(), SceneError> {
    if names.contains(&name) {
        return Ok(());
    }
    Err(SceneError::new(format!("no built-in environment {}{}", quoted(name), suggestion(name, names))))
}

fn sides(node: &Node, path: &str) -> Result<(), SceneError> {
    let Some([width, height]) = as_numbers(node).and_then(|sides| <[f64; 2]>::try_from(sides).ok()) else {
        return Err(wrong(node, path, "two whole numbers, width and height"));
    };
    let whole = |v: f64| v.is_finite() && v.fract() == 0.0 && v >= 1.0;
    if !whole(width) || !whole(height) {
        return Err(wrong(node, path, "two whole numbers of at least 1 pixel"));
    }
    if width.max(height) > MAX_SIDE as f64 || width * height > MAX_PIXELS as f64 {
        let most = format!("at most {MAX_SIDE} pixels each way and {MAX_PIXELS} in all");
        return Err(SceneError { is_resource: true, ..wrong(node, path, &most) });
    }
    Ok(())
}
