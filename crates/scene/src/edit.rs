//! Changing one value of a scene by its dotted path.

use crate::error::SceneError;
use crate::model::Scene;
use crate::reader::{join, suggestion};
use crate::schema::KINDS;
use crate::tree::{MAX_DEPTH, Node, Value, quoted};

/// Whether a table that is given `key` must lose its entry `other`: of the keys of which a kind takes one, setting one
/// removes the others.
fn is_rival(key: &str, other: &str) -> bool {
    // `map` stands among lights and among thicknesses; neither table holds a key of the other.
    KINDS.iter().any(|kind| {
        let place = |name: &str| kind.alternatives.iter().position(|keys| keys.contains(&name));
        place(key).zip(place(other)).is_some_and(|(a, b)| a != b)
    })
}

impl Scene {
    /// The scene with one value replaced, validated anew.
    ///
    /// `path` is dotted; objects are addressed by name or number, lights by number:
    /// `object.bubble.surface.film.thickness_nm`, `light.0.environment.radiance`, `camera.fov_deg`. Where a table takes
    /// one of several keys, setting one removes the others. No map is read and no film flows.
    pub fn with_value(&self, path: &str, value: Node) -> Result<Scene, SceneError> {
        let mut tree = self.tree.clone();
        set(&mut tree, path, value).map_err(|e| e.in_file(self.origin.file.as_deref()))?;
        Scene::from_node(&tree, self.origin.clone())
    }
}

fn set(tree: &mut Node, path: &str, value: Node) -> Result<(), SceneError> {
    let keys: Vec<&str> = path.split('.').collect();
    if keys.iter().any(|key| key.is_empty()) {
        return Err(SceneError::new(format!(
            "{} is no path into a scene; write for example camera.fov_deg or object.bubble.surface.film.thickness_nm",
            quoted(path)
        ))
        .at(path, None));
    }
    // A tree that deep could not even be taken down again: whatever walks it calls itself.
    if keys.len() > MAX_DEPTH {
        return Err(SceneError::new(format!(
            "{} is no path into a scene: it has {} keys, and nothing is nested deeper than {MAX_DEPTH} levels",
            quoted(path),
            keys.len()
        )));
    }
    let mut node = tree;
    let mut done = String::new();
    for key in keys {
        node = child(node, key, &done)?;
        done = join(&done, key);
    }
    *node = value;
    Ok(())
}

/// What stands under `key` of a node whose path is `done`.
fn child<'n>(node: &'n mut Node, key: &str, done: &str) -> Result<&'n mut Node, SceneError> {
    if !matches!(node.value, Value::Table(_) | Value::List(_)) {
        // A number where a table is to be: `thickness_nm = 300` becomes `thickness_nm.gradient.top = ..`.
        node.value = Value::Table(Vec::new());
    }
    match &mut node.value {
        Value::Table(entries) => Ok(entry(entries, key)),
        Value::List(items) => item(items, key, done),
        _ => unreachable!("made a table above"),
    }
}

/// The entry of a table, which loses the rivals of `key`. A key that is not there yet may still be a valid one: the validator
/// decides.
fn entry<'n>(entries: &'n mut Vec<(String, Node)>, key: &str) -> &'n mut Node {
    entries.retain(|(name, _)| !is_rival(key, name));
    let at = entries.iter().position(|(name, _)| name == key).unwrap_or_else(|| {
        entries.push((key.to_owned(), Value::Table(Vec::new()).into()));
        entries.len() - 1
    });
    &mut entries[at].1
}

/// The item of a list by its name or else by its number.
fn item<'n>(items: &'n mut [Node], key: &str, done: &str) -> Result<&'n mut Node, SceneError> {
    let names: Vec<String> = items.iter().filter_map(item_name).collect();
    let named = names.iter().position(|name| name == key);
    let at = named.or_else(|| key.parse::<usize>().ok().filter(|at| *at < items.len()));
    let Some(at) = at else {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let hint = if known.is_empty() {
            format!("; numbers from 0 to {}", items.len().saturating_sub(1))
        } else {
            suggestion(key, &known)
        };
        return Err(SceneError::new(format!("{done} has no entry {}{hint}", quoted(key))).at(join(done, key), None));
    };
    Ok(&mut items[at])
}

fn item_name(item: &Node) -> Option<String> {
    match &item.get("name")?.value {
        Value::Text(name) => Some(name.clone()),
        _ => None,
    }
}
