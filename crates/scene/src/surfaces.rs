//! Surfaces: what objects are made of.

use crate::context::Reading;
use crate::error::SceneError;
use crate::lights::illuminant;
use crate::medium::medium;
use crate::model::{Coating, CoatingLayer, Emitter, Film, Shape, Surface, Thickness};
use crate::reader::{Table, as_number, as_numbers};
use crate::schema::{self, Kind, MAX_THICKNESS_NM};
use crate::thickness::{most_nm, thickness};
use crate::tree::{Node, Value};

/// A surface on a shape, and its tree with every default.
pub fn surface(node: &Node, path: &str, shape: &Shape, context: &Reading<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, &schema::SURFACE, path)?;
    let (kind, inner) = table.choice()?;
    let path = table.path(kind);
    let (surface, tree) = match kind {
        "film" => film(inner, path, shape, context)?,
        "coating" => coating(inner, path, shape, context)?,
        "dielectric" => {
            let (medium, tree) = bare(inner, path, &schema::DIELECTRIC)?;
            (Surface::Dielectric(medium), tree)
        }
        "metal" => {
            let (medium, tree) = bare(inner, path, &schema::METAL)?;
            (Surface::Metal(medium), tree)
        }
        "diffuse" => diffuse(inner, path)?,
        _ => emitter(inner, path, context)?,
    };
    Ok((surface, Node::table([(kind, tree)])))
}

/// The medium of a key.
fn medium_of(table: &Table<'_>, key: &str) -> Result<(iridesce_optics::Medium, Node), SceneError> {
    medium(&table.node(key)?, &table.path(key))
}

fn film(node: &Node, path: String, shape: &Shape, context: &Reading<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, &schema::FILM, path)?;
    let (medium, medium_tree) = medium_of(&table, "medium")?;
    let (thickness, thickness_tree) = field(&table, shape, context)?;
    // Whether a ray can be in that medium, the scene as a whole decides.
    let (outside, outside_tree) = medium_of(&table, "outside")?;
    let tree = Node::table([("medium", medium_tree), ("thickness_nm", thickness_tree), ("outside", outside_tree)]);
    Ok((Surface::Film(Film { medium, thickness, outside }), tree))
}

/// What stands under `thickness_nm`, for this shape.
fn field(table: &Table<'_>, shape: &Shape, context: &Reading<'_>) -> Result<(Thickness, Node), SceneError> {
    thickness(table.get("thickness_nm"), &table.path("thickness_nm"), shape, context)
}

fn coating(node: &Node, path: String, shape: &Shape, context: &Reading<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, &schema::COATING, path)?;
    let (mut layers, mut trees, mut total_nm) = (Vec::new(), Vec::new(), 0.0);
    for (i, item) in table.list("layers").iter().enumerate() {
        let layer = Table::new(item, &schema::LAYER, format!("{}.{i}", table.path("layers")))?;
        let (medium, medium_tree) = medium_of(&layer, "medium")?;
        let (thickness, thickness_tree) = field(&layer, shape, context)?;
        total_nm += most_nm(&thickness);
        layers.push(CoatingLayer { medium, thickness });
        trees.push(Node::table([("medium", medium_tree), ("thickness_nm", thickness_tree)]));
    }
    if total_nm > MAX_THICKNESS_NM {
        let key = table.path("layers");
        let message = format!("{key} must be at most 1e7 nm thick in all, got {total_nm:?}");
        return Err(SceneError::new(message).at(key, table.line("layers")));
    }
    let (substrate, substrate_tree) = medium_of(&table, "substrate")?;
    let tree = Node::table([("layers", Value::List(trees).into()), ("substrate", substrate_tree)]);
    Ok((Surface::Coating(Coating { layers, substrate }), tree))
}

/// The one medium of a bare surface.
fn bare(node: &Node, path: String, kind: &'static Kind) -> Result<(iridesce_optics::Medium, Node), SceneError> {
    let (medium, tree) = medium_of(&Table::new(node, kind, path)?, "medium")?;
    Ok((medium, Node::table([("medium", tree)])))
}

fn diffuse(node: &Node, path: String) -> Result<(Surface, Node), SceneError> {
    let given = Table::new(node, &schema::DIFFUSE, path)?.node("reflectance")?;
    let rgb = match as_numbers(&given).as_deref() {
        Some(&[grey]) => [grey; 3],
        Some(&[r, g, b]) => [r, g, b],
        _ => [as_number(&given).unwrap_or_default(); 3],
    };
    Ok((Surface::Diffuse(rgb), Node::table([("reflectance", given.without_lines())])))
}

fn emitter(node: &Node, path: String, context: &Reading<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, &schema::EMITTER, path)?;
    let (name, radiance) = (table.text("illuminant")?, table.number("radiance")?);
    let illuminant =
        illuminant(name, context.origin).map_err(|e| e.at(table.path("illuminant"), table.line("illuminant")))?;
    let polarized_deg = table.number_if_given("polarized_deg")?;
    let mut entries = vec![("illuminant", Node::text(name)), ("radiance", Node::number(radiance))];
    entries.extend(polarized_deg.map(|angle| ("polarized_deg", Node::number(angle))));
    Ok((Surface::Emitter(Emitter { illuminant, radiance, polarized_deg }), Node::table(entries)))
}
