//! Lights: environments from maps, illuminants, the built-in studio and sky.

use iridesce_files::{MAX_LAMP_BYTES, quoted, read_lamp, read_whole};
use iridesce_optics::color::{Illuminant, illuminant_names};

use crate::error::SceneError;
use crate::files::map_file;
use crate::model::{Environment, EnvironmentSource, Light, MapFile, Origin};
use crate::reader::{Table, suggestion};
use crate::schema;
use crate::tree::Node;

/// Longest name of an illuminant: a list of lines can be some hundred letters long.
const MAX_NAME: usize = 10_000;

/// The light at `path`, and its tree with every default.
pub fn light(node: &Node, path: &str, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let table = Table::new(node, &schema::LIGHT, path)?;
    let (environment, tree) = environment(table.need("environment")?, &table.path("environment"), origin)?;
    Ok((Light::Environment(environment), Node::table([("environment", tree)])))
}

fn environment(node: &Node, path: &str, origin: &Origin) -> Result<(Environment, Node), SceneError> {
    let table = Table::new(node, &schema::ENVIRONMENT, path)?;
    let (kind, source_node) = table.choice()?;
    let name = table.text(kind)?;
    let (rotation_deg, radiance) = (table.number("rotation_deg")?, table.number("radiance")?);
    let layer = table.get("layer").map(|_| table.text("layer")).transpose()?.map(str::to_owned);
    let mut entries = vec![(kind, Node::text(name))];
    entries.extend(layer.as_deref().map(|layer| ("layer", Node::text(layer))));
    let source = match (kind, name) {
        ("map", _) => map_file(origin, name).map(|file| EnvironmentSource::Map(MapFile { channel: layer, ..file })),
        ("illuminant", _) => illuminant(name, origin).map(EnvironmentSource::Uniform),
        (_, "studio") => Ok(EnvironmentSource::Studio),
        _ => Ok(EnvironmentSource::Sky),
    }
    .map_err(|e| e.at(table.path(kind), source_node.line))?;
    // A uniform light looks the same however it is turned: the key is read there, but not written unless it was given.
    if kind != "illuminant" || table.get("rotation_deg").is_some() {
        entries.push(("rotation_deg", Node::number(rotation_deg)));
    }
    entries.push(("radiance", Node::number(radiance)));
    Ok((Environment { source, rotation_deg, radiance }, Node::table(entries)))
}

/// An illuminant by name, or a CSV file of the scene's.
pub fn illuminant(name: &str, origin: &Origin) -> Result<Illuminant, SceneError> {
    if name.to_lowercase().ends_with(".csv") {
        let bad = |why: String| SceneError::new(format!("{} cannot be used as an illuminant: {why}", quoted(name)));
        let bytes = read_whole(&origin.resolve(name)?, MAX_LAMP_BYTES).map_err(bad)?;
        return read_lamp(&bytes, name).map(|(lamp, _)| lamp).map_err(SceneError::new);
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
