//! Lights: environments from maps, illuminants, the built-in studio and sky; suns, and lights without size.

use iridesce_files::{MAX_LAMP_BYTES, quoted, read_lamp, read_whole};
use iridesce_numerics::vector::{difference, length};
use iridesce_optics::color::{Illuminant, illuminant_names};

use crate::error::SceneError;
use crate::files::map_file;
use crate::model::{DeltaKind, DeltaLight, Environment, EnvironmentSource, Light, MapFile, Origin, Sun};
use crate::reader::{Table, suggestion};
use crate::schema;
use crate::tree::Node;

/// Longest name of an illuminant: a list of lines can be some hundred letters long.
const MAX_NAME: usize = 10_000;

/// The light at `path`, and its tree with every default.
pub fn light(node: &Node, path: &str, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let table = Table::new(node, &schema::LIGHT, path)?;
    let (kind, inner) = table.choice()?;
    let path = table.path(kind);
    let (light, tree) = match kind {
        "environment" => {
            let (environment, tree) = environment(inner, &path, origin)?;
            (Light::Environment(environment), tree)
        }
        "sun" => sun(&Table::new(inner, &schema::SUN, path)?, origin)?,
        "directional" => directional(&Table::new(inner, &schema::DIRECTIONAL, path)?, origin)?,
        "point" => point(&Table::new(inner, &schema::POINT, path)?, origin)?,
        _ => spot(&Table::new(inner, &schema::SPOT, path)?, origin)?,
    };
    Ok((light, Node::table([(kind, tree)])))
}

/// What the lights beside environments have in common, and its part of the tree.
struct Lamp {
    illuminant: Illuminant,
    power: f64,
    polarized_deg: Option<f64>,
    entries: Vec<(&'static str, Node)>,
}

/// `power`: the key that says how strong it is.
fn lamp(table: &Table<'_>, power: &'static str, origin: &Origin) -> Result<Lamp, SceneError> {
    let name = table.text("illuminant")?;
    let illuminant = illuminant(name, origin).map_err(|e| e.at(table.path("illuminant"), table.line("illuminant")))?;
    let strength = table.number(power)?;
    let polarized_deg = table.number_if_given("polarized_deg")?;
    let mut entries = vec![("illuminant", Node::text(name)), (power, Node::number(strength))];
    entries.extend(polarized_deg.map(|angle| ("polarized_deg", Node::number(angle))));
    Ok(Lamp { illuminant, power: strength, polarized_deg, entries })
}

impl Lamp {
    /// Its tree, after the keys that say where it is.
    fn tree(self, place: Vec<(&'static str, Node)>) -> Node {
        Node::table(place.into_iter().chain(self.entries))
    }

    fn delta(self, kind: DeltaKind, place: Vec<(&'static str, Node)>) -> (Light, Node) {
        let light = DeltaLight {
            kind,
            illuminant: self.illuminant.clone(),
            power: self.power,
            polarized_deg: self.polarized_deg,
        };
        (Light::Delta(light), self.tree(place))
    }
}

fn sun(table: &Table<'_>, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let (direction, diameter) = (table.triple("direction")?, table.number("angular_diameter_deg")?);
    let lamp = lamp(table, "irradiance", origin)?;
    let angular_radius_deg = 0.5 * diameter;
    let sun = Sun {
        direction: unit(direction),
        angular_radius_deg,
        illuminant: lamp.illuminant.clone(),
        // A disc of radiance L around the normal makes the irradiance pi L sin^2 of its angular radius.
        radiance: lamp.power / (std::f64::consts::PI * angular_radius_deg.to_radians().sin().powi(2)),
        polarized_deg: lamp.polarized_deg,
    };
    let place = vec![("direction", Node::numbers(&direction)), ("angular_diameter_deg", Node::number(diameter))];
    Ok((Light::Sun(sun), lamp.tree(place)))
}

fn directional(table: &Table<'_>, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let direction = table.triple("direction")?;
    let kind = DeltaKind::Directional { direction: unit(direction) };
    Ok(lamp(table, "irradiance", origin)?.delta(kind, vec![("direction", Node::numbers(&direction))]))
}

fn point(table: &Table<'_>, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let position = table.triple("position")?;
    let place = vec![("position", Node::numbers(&position))];
    Ok(lamp(table, "intensity", origin)?.delta(DeltaKind::Point { position }, place))
}

fn spot(table: &Table<'_>, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let (position, target) = (table.triple("position")?, table.triple("target")?);
    let (cone_deg, soft_deg) = (table.number("cone_deg")?, table.number("soft_deg")?);
    let view = difference(target, position);
    if length(view) <= 1e-12 * (1.0 + length(position)) {
        let key = table.path("target");
        let message = format!("the spot points at itself: {key} and its position must differ, both are {target:?}");
        return Err(SceneError::new(message).at(key, table.line("target")));
    }
    let kind = DeltaKind::Spot { position, axis: unit(view), cone_deg, soft_deg };
    let place = vec![
        ("position", Node::numbers(&position)),
        ("target", Node::numbers(&target)),
        ("cone_deg", Node::number(cone_deg)),
        ("soft_deg", Node::number(soft_deg)),
    ];
    Ok(lamp(table, "intensity", origin)?.delta(kind, place))
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|x| x / length)
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
