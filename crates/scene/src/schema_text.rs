//! The schema for others to read: JSON Schema for editors, a table of keys for the docs.

use std::fmt::Write;

use iridesce_files::quoted;
use serde_json::{Map, Value, json};

use crate::schema::{Also, Default, KINDS, Key, Kind, MAX_LENGTH, MAX_SIDE, Range, SCENE, THICKNESS, Takes};

/// The scene language as a JSON Schema (draft 2020-12), for editors and for programs that write scenes. What only several
/// keys together can tell (a camera that looks at itself) it does not hold.
///
/// ```
/// let schema = iridesce_scene::json_schema();
/// assert_eq!(schema["$defs"]["camera"]["properties"]["fov_deg"]["default"], 35.0);
/// ```
pub fn json_schema() -> Value {
    let kinds: Map<String, Value> = KINDS.iter().map(|kind| (kind.name.to_owned(), table(kind))).collect();
    let mut root = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "a scene of iridesce",
        "$defs": kinds,
    });
    root["$ref"] = reference(&SCENE);
    root
}

fn reference(kind: &Kind) -> Value {
    format!("#/$defs/{}", kind.name).into()
}

fn table(kind: &Kind) -> Value {
    let properties: Map<String, Value> = kind.keys.iter().map(|key| (key.name.to_owned(), property(key))).collect();
    let needed: Vec<&str> =
        kind.keys.iter().filter(|key| matches!(key.default, Default::Needed)).map(|key| key.name).collect();
    let mut table = json!({
        "type": "object",
        "description": kind.words,
        "properties": properties,
        "additionalProperties": false,
    });
    if !needed.is_empty() {
        table["required"] = json!(needed);
    }
    let choices = kind.choices();
    if kind.is_optional {
        table["not"] = json!({ "required": choices });
    } else if !choices.is_empty() {
        table["oneOf"] = choices.iter().map(|choice| json!({ "required": [choice] })).collect();
    }
    // What goes with one of the alternatives goes with no other.
    let companions: Map<String, Value> = kind
        .alternatives
        .iter()
        .flat_map(|keys| keys[1..].iter().map(|key| ((*key).to_owned(), json!([keys[0]]))))
        .collect();
    if !companions.is_empty() {
        table["dependentRequired"] = companions.into();
    }
    table
}

fn property(key: &Key) -> Value {
    let mut property = takes(key.takes);
    let words = match (key.words, key.unit) {
        (words, "") => words.to_owned(),
        ("", unit) => unit.to_owned(),
        (words, unit) => format!("{words}; {unit}"),
    };
    if !words.is_empty() {
        property["description"] = words.into();
    }
    if key.name == "version" {
        property = json!({ "const": 1, "description": key.words });
    }
    match key.default {
        Default::Number(value) => property["default"] = value.into(),
        Default::Whole(value) => property["default"] = value.into(),
        Default::Triple(value) => property["default"] = json!(value),
        Default::Text(value) => property["default"] = value.into(),
        Default::Sides(value) => property["default"] = json!(value),
        Default::Table(kind) => property["default"] = json!({ kind: {} }),
        Default::Needed | Default::Alternative | Default::Words(_) => {}
    }
    property
}

fn takes(takes: Takes) -> Value {
    let coordinate = json!({ "type": "number", "minimum": -MAX_LENGTH, "maximum": MAX_LENGTH });
    let share = json!({ "type": "number", "minimum": 0, "maximum": 1 });
    let text = json!({ "type": "string", "minLength": 1 });
    match takes {
        Takes::Number(range) => number(range),
        Takes::Whole(from, to) => json!({ "type": "integer", "minimum": from, "maximum": to }),
        Takes::Point | Takes::Vector => json!({ "type": "array", "items": coordinate, "minItems": 3, "maxItems": 3 }),
        Takes::Sides => {
            let side = json!({ "type": "integer", "minimum": 1, "maximum": MAX_SIDE });
            json!({ "type": "array", "items": side, "minItems": 2, "maxItems": 2 })
        }
        Takes::Name => json!({ "type": "string", "pattern": "^[\\p{L}\\p{N}_-]{1,100}$" }),
        Takes::Choice(names, _) | Takes::Builtin(names) => json!({ "enum": names }),
        Takes::Medium => {
            let index = json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1000 });
            let pair = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 });
            json!({ "anyOf": [text, index, pair] })
        }
        Takes::Illuminant | Takes::File | Takes::Text => text,
        Takes::Reflectance(kind) => {
            let rgb = json!({ "type": "array", "items": share, "minItems": 3, "maxItems": 3 });
            json!({ "anyOf": [share, rgb, { "$ref": reference(kind) }] })
        }
        Takes::Roughness(kind) => {
            let pair = json!({ "type": "array", "items": share, "minItems": 2, "maxItems": 2 });
            json!({ "anyOf": [share, pair, { "$ref": reference(kind) }] })
        }
        Takes::Thickness(kind) => {
            json!({ "anyOf": [number(THICKNESS), { "const": "vertex" }, { "$ref": reference(kind) }] })
        }
        Takes::Bool => json!({ "type": "boolean" }),
        Takes::Scale => {
            let factor = json!({ "type": "number" });
            json!({ "anyOf": [factor, { "type": "array", "items": factor, "minItems": 3, "maxItems": 3 }] })
        }
        Takes::Pair(range) => json!({ "type": "array", "items": number(range), "minItems": 2, "maxItems": 2 }),
        Takes::Matrix => {
            let row = json!({ "type": "array", "items": coordinate, "minItems": 4, "maxItems": 4 });
            json!({ "type": "array", "items": row, "minItems": 3, "maxItems": 4 })
        }
        Takes::Integer(from, to) => json!({ "type": "integer", "minimum": from, "maximum": to }),
        Takes::Instances(one, file, most) => {
            let list = json!({ "type": "array", "items": { "$ref": reference(one) }, "minItems": 1, "maxItems": most });
            json!({ "anyOf": [list, { "$ref": reference(file) }] })
        }
        Takes::Table(kind) => json!({ "$ref": reference(kind) }),
        Takes::List(kind, least, most) => {
            json!({ "type": "array", "items": { "$ref": reference(kind) }, "minItems": least, "maxItems": most })
        }
    }
}

fn number(range: Range) -> Value {
    let within = |from: f64, to: f64| {
        let mut within = json!({ "type": "number" });
        if from > f64::MIN {
            within["minimum"] = from.into();
        }
        if to < f64::MAX {
            within["maximum"] = to.into();
        }
        within
    };
    match range.also {
        Also::Nothing => within(range.from, range.to),
        Also::Zero => json!({ "anyOf": [{ "const": 0 }, within(range.from, range.to)] }),
        Also::Negative => json!({ "anyOf": [within(range.from, range.to), within(-range.to, -range.from)] }),
    }
}

/// Every key in Markdown: a table a kind, as `docs/reference/scenes.md` holds them.
pub fn key_tables() -> String {
    let mut out = String::new();
    for kind in KINDS {
        let _ = writeln!(out, "### `{}`: {}\n", kind.name, kind.words);
        out.push_str("| key | takes | default | |\n|---|---|---|---|\n");
        for key in kind.keys {
            let _ = writeln!(out, "| `{}` | {} | {} | {} |", key.name, allowed(key), default(key), key.words);
        }
        out.push('\n');
    }
    out
}

fn allowed(key: &Key) -> String {
    let unit = |words: &str| match key.unit {
        "" => words.to_owned(),
        unit if words.contains(unit) => words.to_owned(),
        unit => format!("{words}; {unit}"),
    };
    match key.takes {
        Takes::Number(range) => unit(range.words),
        Takes::Whole(from, u64::MAX) => format!("a whole number from {from} to 2^64 - 1"),
        Takes::Whole(from, to) => unit(&format!("a whole number from {from} to {to}")),
        Takes::Point => unit("three numbers"),
        Takes::Vector => unit("three numbers, a direction"),
        Takes::Sides => unit("two whole numbers"),
        Takes::Name => "1 to 100 letters, digits, - and _".to_owned(),
        Takes::Choice(names, _) | Takes::Builtin(names) => {
            names.iter().map(|name| format!("`{}`", quoted(name))).collect::<Vec<_>>().join(", ")
        }
        Takes::Medium => "a medium: a name, a number or `[n, k]`".to_owned(),
        Takes::Illuminant => "an illuminant: a name or a CSV file".to_owned(),
        Takes::File => "a file".to_owned(),
        Takes::Text => "a text".to_owned(),
        Takes::Reflectance(kind) => format!("a number from 0 to 1, or three, or a table `{}`", kind.name),
        Takes::Roughness(kind) => format!("a number from 0 to 1, or two, or a table `{}`", kind.name),
        Takes::Thickness(kind) => format!("{}, or a table `{}`", THICKNESS.words, kind.name),
        Takes::Table(kind) => format!("a table `{}`", kind.name),
        Takes::Bool => "`true` or `false`".to_owned(),
        Takes::Scale => "a factor other than 0, or three".to_owned(),
        Takes::Pair(range) => format!("two numbers, {}", range.words),
        Takes::Matrix => "three rows of four numbers".to_owned(),
        Takes::Integer(from, to) => format!("a whole number from {from} to {to}"),
        Takes::Instances(one, file, most) => format!("1 to {most} tables `{}`, or a table `{}`", one.name, file.name),
        Takes::List(kind, 0, most) => format!("at most {most} tables `{}`", kind.name),
        Takes::List(kind, least, most) => format!("{least} to {most} tables `{}`", kind.name),
    }
}

fn default(key: &Key) -> String {
    match key.default {
        Default::Needed => "needed".to_owned(),
        Default::Alternative => String::new(),
        Default::Words(words) => words.to_owned(),
        Default::Number(value) => format!("`{value:?}`"),
        Default::Whole(value) => format!("`{value}`"),
        Default::Triple(value) => format!("`{value:?}`"),
        Default::Text(text) => format!("`{}`", quoted(text)),
        Default::Table(kind) => format!("`{{ {kind} = {{}} }}`"),
        Default::Sides(value) => format!("`{value:?}`"),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::{Node, Origin, Scene};

    const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/scenes.md");
    const MARKS: [&str; 2] = ["<!-- keys: from crates/scene/src/schema.rs -->\n", "<!-- keys end -->"];

    /// `IRIDESCE_BLESS=1` writes the tables anew.
    #[test]
    fn the_docs_hold_the_table_of_keys() {
        let text = std::fs::read_to_string(DOCS).unwrap();
        let (before, rest) = text.split_once(MARKS[0]).unwrap();
        let (held, after) = rest.split_once(MARKS[1]).unwrap();
        let wanted = format!("\n{}", key_tables());
        if std::env::var_os("IRIDESCE_BLESS").is_some() {
            std::fs::write(DOCS, [before, MARKS[0], &wanted, MARKS[1], after].concat()).unwrap();
        } else {
            assert_eq!(held, wanted);
        }
    }

    #[test]
    fn kinds_have_names_of_their_own_and_keys_one_place_each() {
        let names: HashSet<&str> = KINDS.iter().map(|kind| kind.name).collect();
        assert_eq!(names.len(), KINDS.len());
        for kind in KINDS {
            let keys: HashSet<&str> = kind.names().into_iter().collect();
            assert_eq!(keys.len(), kind.keys.len(), "{}", kind.name);
            for key in kind.alternatives.iter().flat_map(|keys| keys.iter()) {
                assert!(keys.contains(key) || kind.later.contains(key), "{} {key}", kind.name);
            }
        }
    }

    /// A scene that states every default of the schema is the scene that states none.
    #[test]
    fn defaults_that_are_stated_change_nothing() {
        fn filled(node: &mut Node, kind: &Kind) {
            let crate::tree::Value::Table(entries) = &mut node.value else { return };
            for key in kind.keys {
                let value = match key.default {
                    Default::Number(value) if key.name != "fov_deg" => Node::number(value),
                    Default::Triple(value) => Node::numbers(&value),
                    Default::Text(text) => Node::text(text),
                    Default::Whole(value) => crate::tree::Value::Int(value.into()).into(),
                    _ => continue,
                };
                if !entries.iter().any(|(name, _)| name == key.name) {
                    entries.push((key.name.to_owned(), value));
                }
            }
            for (name, value) in entries {
                match (kind.key(name).map(|key| key.takes), &mut value.value) {
                    (Some(Takes::Table(kind) | Takes::Thickness(kind)), _) => filled(value, kind),
                    (Some(Takes::List(kind, ..)), crate::tree::Value::List(items)) => {
                        items.iter_mut().for_each(|item| filled(item, kind));
                    }
                    _ => {}
                }
            }
        }
        for name in crate::builtin_names() {
            let plain = Scene::builtin(name).unwrap();
            let mut node = Node::from_toml(crate::builtin_text(name).unwrap()).unwrap();
            filled(&mut node, &SCENE);
            let full = Scene::from_node(&node, Origin::default()).unwrap();
            assert_eq!(format!("{:?}", plain.objects), format!("{:?}", full.objects), "{name}");
            assert_eq!((&plain.camera.position, plain.render), (&full.camera.position, full.render), "{name}");
        }
    }
}
