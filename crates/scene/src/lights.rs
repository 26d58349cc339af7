//! Lights: environments from maps, illuminants, the built-in studio and sky.

use iridesce_files::{MAX_RADIANCE, read_whole};
use iridesce_optics::color::{Illuminant, illuminant_names};

use crate::defaults;
use crate::error::SceneError;
use crate::files::Maps;
use crate::model::{Environment, EnvironmentSource, Light, Origin};
use crate::reader::{Table, suggestion};
use crate::sky::sky;
use crate::studio::studio;
use crate::tree::{Node, quoted};

/// Largest table of an illuminant; one of 0.1 nm steps has 100 KiB.
const MAX_CSV_BYTES: u64 = 16 << 20;
/// Longest name of an illuminant: a list of lines can be some hundred letters long.
const MAX_NAME: usize = 10_000;

/// The light at `number`, and its tree with every default.
pub fn light(node: &Node, number: usize, origin: &Origin, maps: &mut Maps) -> Result<(Light, Node), SceneError> {
    let table = Table::new(node, format!("light.{number}"), &["environment"], &[])?;
    let (environment, tree) = environment(table.need("environment")?, &table.path("environment"), origin, maps)?;
    Ok((Light::Environment(environment), Node::table([("environment", tree)])))
}

fn environment(node: &Node, path: &str, origin: &Origin, maps: &mut Maps) -> Result<(Environment, Node), SceneError> {
    let table = Table::new(node, path, &["map", "illuminant", "builtin", "rotation_deg", "radiance"], &[])?;
    let (kind, source_node) = table.one_of(&["map", "illuminant", "builtin"])?;
    let name = table.needed_text(kind)?;
    // The cheap checks first: a map can take seconds to read.
    let rotation_deg = table.number("rotation_deg", defaults::ROTATION_DEG, "a finite angle in degrees", |_| true)?;
    let radiance = radiance(&table)?;
    let source = match kind {
        "map" => origin.resolve(name).and_then(|path| maps.environment(&path, name)).map(EnvironmentSource::Map),
        "illuminant" => illuminant(name, origin).map(EnvironmentSource::Uniform),
        _ => builtin(name),
    }
    .map_err(|e| e.at(table.path(kind), source_node.line))?;
    let mut entries = vec![(kind, Node::text(name))];
    // A uniform light looks the same however it is turned: the key is read there, but not written unless it was given.
    if kind != "illuminant" || table.get("rotation_deg").is_some() {
        entries.push(("rotation_deg", Node::number(rotation_deg)));
    }
    entries.push(("radiance", Node::number(radiance)));
    Ok((Environment { source, rotation_deg, radiance }, Node::table(entries)))
}

/// The radiance that a table of a light or an emitter states.
pub fn radiance(table: &Table<'_>) -> Result<f64, SceneError> {
    let is_radiance = |v| (0.0..=MAX_RADIANCE).contains(&v);
    table.number("radiance", defaults::RADIANCE, "a radiance >= 0, at most 1e12", is_radiance)
}

/// Environments made by code.
fn builtin(name: &str) -> Result<EnvironmentSource, SceneError> {
    match name {
        "studio" => Ok(EnvironmentSource::Map(studio())),
        "sky" => {
            let (map, sun) = sky().map_err(|e| SceneError::new(e.to_string()))?;
            Ok(EnvironmentSource::Sky(map, sun))
        }
        _ => {
            let near = suggestion(name, &["studio", "sky"]);
            Err(SceneError::new(format!("no built-in environment {}{near}", quoted(name))))
        }
    }
}

/// An illuminant by name, or a CSV file of the scene's.
pub fn illuminant(name: &str, origin: &Origin) -> Result<Illuminant, SceneError> {
    if name.to_lowercase().ends_with(".csv") {
        let bad = |why: String| SceneError::new(format!("{} cannot be used as an illuminant: {why}", quoted(name)));
        let bytes = read_whole(&origin.resolve(name)?, MAX_CSV_BYTES).map_err(bad)?;
        let text = String::from_utf8(bytes).map_err(|_| bad("it is not a text".to_owned()))?;
        return Illuminant::from_csv(&text, name).map_err(|e| SceneError::new(e.to_string()));
    }
    if name.len() > MAX_NAME {
        return Err(SceneError::new(format!("no illuminant is called {}", quoted(name))));
    }
    Illuminant::named(name).map_err(|e| {
        let names: Vec<&str> = illuminant_names().collect();
        match suggestion(name, &names) {
            near if near.contains("did you mean") => {
                SceneError::new(format!("unknown illuminant {}{near}", quoted(name)))
            }
            _ => SceneError::new(e.to_string()),
        }
    })
}
