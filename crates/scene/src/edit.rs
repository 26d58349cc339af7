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
    for (i, key) in keys.iter().enumerate() {
        let is_last = i + 1 == keys.len();
        let here = join(&done, key);
        if !matches!(node.value, Value::Table(_) | Value::List(_)) {
            // A number where a table is to be: `thickness_nm = 300` becomes `thickness_nm.gradient.top = ..`.
            node.value = Value::Table(Vec::new());
        }
        match &mut node.value {
            Value::Table(entries) => {
                entries.retain(|(name, _)| !is_rival(key, name));
                let at = match entries.iter().position(|(name, _)| name == key) {
                    Some(at) => at,
                    None => {
                        // A key that is not there yet may still be a valid one: the validator decides.
                        entries.push(((*key).to_owned(), Value::Table(Vec::new()).into()));
                        entries.len() - 1
                    }
                };
                node = &mut entries[at].1;
            }
            Value::List(items) => {
                let names: Vec<String> = items.iter().filter_map(item_name).collect();
                let at = match names.iter().position(|name| name == key) {
                    Some(at) => at,
                    None => key.parse::<usize>().ok().filter(|at| *at < items.len()).ok_or_else(|| {
                        let known: Vec<&str> = names.iter().map(String::as_str).collect();
                        let hint = if known.is_empty() {
                            format!("; numbers from 0 to {}", items.len().saturating_sub(1))
                        } else {
                            suggestion(key, &known)
                        };
                        SceneError::new(format!("{done} has no entry {}{hint}", quoted(key))).at(&here, None)
                    })?,
                };
                node = &mut items[at];
            }
            _ => unreachable!("made a table above"),
        }
        if is_last {
            *node = value;
            return Ok(());
        }
        done = here;
    }
    Ok(())
}

fn item_name(item: &Node) -> Option<String> {
    match &item.get("name")?.value {
        Value::Text(name) => Some(name.clone()),
        _ => None,
    }
}
