//! Surfaces: what objects are made of.

use crate::context::Reading;
use crate::error::SceneError;
use crate::files::map_file;
use crate::lights::illuminant;
use crate::medium::medium;
use crate::model::{Coating, CoatingLayer, Emitter, Film, Reflectance, Roughness, Shape, Surface, Thickness};
use crate::reader::{Table, as_number, as_numbers};
use crate::schema::{self, Kind, MAX_THICKNESS_NM};
use crate::thickness::{most_nm, thickness};
use crate::tree::{Node, Value};

/// A surface on a shape, how rough it is, and its tree with every default.
pub fn surface(
    node: &Node,
    path: &str,
    shape: &Shape,
    context: &Reading<'_>,
) -> Result<(Surface, Roughness, Node), SceneError> {
    let table = Table::new(node, &schema::SURFACE, path)?;
    let (kind, inner) = table.choice()?;
    let path = table.path(kind);
    let (spec, (surface, mut tree)) = match kind {
        "film" => (&schema::FILM, film(inner, path.clone(), shape, context)?),
        "coating" => (&schema::COATING, coating(inner, path.clone(), shape, context)?),
        "dielectric" => {
            let (medium, tree) = bare(inner, path.clone(), &schema::DIELECTRIC)?;
            (&schema::DIELECTRIC, (Surface::Dielectric(medium), tree))
        }
        "metal" => {
            let (medium, tree) = bare(inner, path.clone(), &schema::METAL)?;
            (&schema::METAL, (Surface::Metal(medium), tree))
        }
        "diffuse" => (&schema::DIFFUSE, diffuse(inner, path.clone(), context)?),
        _ => (&schema::EMITTER, emitter(inner, path.clone(), context)?),
    };
    let given = Table::new(inner, spec, path)?;
    let mut roughness = Roughness::SMOOTH;
    // A smooth surface is not said to be so unless it was.
    if given.get("roughness").is_some() {
        let (read, node) = rough(&given, context)?;
        roughness = read;
        if let Value::Table(entries) = &mut tree.value {
            entries.push(("roughness".to_owned(), node));
        }
    }
    Ok((surface, roughness, Node::table([(kind, tree)])))
}

fn rough(surface: &Table<'_>, context: &Reading<'_>) -> Result<(Roughness, Node), SceneError> {
    let given = surface.node("roughness")?;
    match as_number(&given).map(|both| vec![both]).or(as_numbers(&given)).as_deref() {
        Some(&[both]) => return Ok((Roughness::Uniform([both; 2]), given.without_lines())),
        Some(&[u, v]) => return Ok((Roughness::Uniform([u, v]), given.without_lines())),
        _ => {}
    }
    let table = Table::new(&given, &schema::ROUGHNESS, surface.path("roughness"))?;
    let name = table.text("map")?;
    let (min, max) = (table.number("min")?, table.number("max")?);
    let file = map_file(context.origin, name).map_err(|e| e.at(table.path("map"), table.line("map")))?;
    let tree = Node::table([("map", Node::text(name)), ("min", Node::number(min)), ("max", Node::number(max))]);
    Ok((Roughness::Map { file, min, max }, tree))
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
    let mut entries = vec![("medium", medium_tree), ("thickness_nm", thickness_tree), ("outside", outside_tree)];
    let inner_thickness = match table.get("inner_thickness_nm") {
        None => None,
        Some(_) if !matches!(shape, Shape::Bubbles(_)) => {
            return Err(table.wrong("inner_thickness_nm", "left out: only the shape bubbles has walls inside"));
        }
        given => {
            let (inner, tree) = crate::thickness::thickness(given, &table.path("inner_thickness_nm"), shape, context)?;
            entries.push(("inner_thickness_nm", tree));
            Some(inner)
        }
    };
    Ok((Surface::Film(Film { medium, thickness, outside, inner_thickness }), Node::table(entries)))
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

fn diffuse(node: &Node, path: String, context: &Reading<'_>) -> Result<(Surface, Node), SceneError> {
    let surface = Table::new(node, &schema::DIFFUSE, path)?;
    let given = surface.node("reflectance")?;
    let (reflectance, tree) = match as_numbers(&given).or(as_number(&given).map(|grey| vec![grey])).as_deref() {
        Some(&[grey]) => (Reflectance::Rgb([grey; 3]), given.without_lines()),
        Some(&[r, g, b]) => (Reflectance::Rgb([r, g, b]), given.without_lines()),
        _ => {
            let table = Table::new(&given, &schema::REFLECTANCE, surface.path("reflectance"))?;
            let (kind, _) = table.choice()?;
            let name = table.text(kind)?;
            let file = map_file(context.origin, name).map_err(|e| e.at(table.path(kind), table.line(kind)))?;
            let tree = Node::table([(kind, Node::text(name))]);
            (if kind == "map" { Reflectance::Map(file) } else { Reflectance::Spectrum(file) }, tree)
        }
    };
    Ok((Surface::Diffuse(reflectance), Node::table([("reflectance", tree)])))
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
