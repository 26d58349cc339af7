//! Surfaces: what objects are made of.

use crate::context::Context;
use crate::defaults;
use crate::error::SceneError;
use crate::lights::{illuminant, radiance};
use crate::medium::{medium, medium_or};
use crate::model::{Coating, CoatingLayer, Emitter, Film, Shape, Surface, ThicknessField};
use crate::reader::{Table, as_number};
use crate::thickness::{MAX_THICKNESS_NM, thickness};
use crate::tree::{Node, Value};

/// Most layers of a coating.
const MAX_LAYERS: usize = 1000;

/// A surface on a shape, and its tree with every default.
pub fn surface(
    node: &Node,
    path: &str,
    shape: &Shape,
    context: &mut Context<'_>,
) -> Result<(Surface, Node), SceneError> {
    const KINDS: [&str; 6] = ["film", "coating", "dielectric", "metal", "diffuse", "emitter"];
    let table = Table::new(node, path, &KINDS, &[])?;
    let (kind, inner) = table.one_of(&KINDS)?;
    let path = table.path(kind);
    let (surface, tree) = match kind {
        "film" => film(inner, path, shape, context)?,
        "coating" => coating(inner, path, shape, context)?,
        "dielectric" => {
            let (medium, tree) = bare(inner, path, defaults::DIELECTRIC)?;
            (Surface::Dielectric(medium), tree)
        }
        "metal" => {
            let (medium, tree) = bare(inner, path, defaults::METAL)?;
            (Surface::Metal(medium), tree)
        }
        "diffuse" => diffuse(inner, path)?,
        _ => emitter(inner, path, context)?,
    };
    Ok((surface, Node::table([(kind, tree)])))
}

fn film(node: &Node, path: String, shape: &Shape, context: &mut Context<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["medium", "thickness_nm", "outside"], &[])?;
    let (medium, medium_tree) = medium_or(&table, "medium", defaults::MEDIUM)?;
    let (thickness, thickness_tree) = field(&table, shape, context)?;
    // Whether a ray can be in that medium, the scene as a whole decides.
    let (outside, outside_tree) = medium_or(&table, "outside", defaults::OUTSIDE)?;
    let tree = Node::table([("medium", medium_tree), ("thickness_nm", thickness_tree), ("outside", outside_tree)]);
    Ok((Surface::Film(Film { medium, thickness, outside }), tree))
}

/// What stands under `thickness_nm`, laid over the shape.
fn field(table: &Table<'_>, shape: &Shape, context: &mut Context<'_>) -> Result<(ThicknessField, Node), SceneError> {
    let given = table.get("thickness_nm");
    let path = table.path("thickness_nm");
    let (model, tree) = thickness(given, &path, context)?;
    let wrong = |why: String| SceneError::new(format!("{path} {why}")).at(&path, given.and_then(|n| n.line));
    let field = ThicknessField::new(model, shape, context.unit).map_err(&wrong)?;
    if field.max_nm() > MAX_THICKNESS_NM {
        return Err(wrong(format!(
            "must be a thickness in nm, at most 1e7 all over the shape, got {:?}",
            field.max_nm()
        )));
    }
    Ok((field, tree))
}

fn coating(node: &Node, path: String, shape: &Shape, context: &mut Context<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["layers", "substrate"], &[])?;
    let given: &[Node] = match table.get("layers").map(|n| &n.value) {
        None => &[],
        Some(Value::List(items)) if items.len() <= MAX_LAYERS => items,
        Some(Value::List(_)) => return Err(table.wrong("layers", &format!("a list of at most {MAX_LAYERS} layers"))),
        Some(_) => return Err(table.wrong("layers", "a list of tables with medium and thickness_nm")),
    };
    let (mut layers, mut trees, mut total_nm) = (Vec::new(), Vec::new(), 0.0);
    for (i, item) in given.iter().enumerate() {
        let layer = Table::new(item, format!("{}.{i}", table.path("layers")), &["medium", "thickness_nm"], &[])?;
        let (medium, medium_tree) = medium(layer.need("medium")?, &layer.path("medium"))?;
        layer.need("thickness_nm")?;
        let (thickness, thickness_tree) = field(&layer, shape, context)?;
        total_nm += thickness.max_nm();
        layers.push(CoatingLayer { medium, thickness });
        trees.push(Node::table([("medium", medium_tree), ("thickness_nm", thickness_tree)]));
    }
    if total_nm > MAX_THICKNESS_NM {
        let line = table.get("layers").and_then(|n| n.line);
        return Err(SceneError::new(format!(
            "{} must be at most 1e7 nm thick in all, got {total_nm:?}",
            table.path("layers")
        ))
        .at(table.path("layers"), line));
    }
    let (substrate, substrate_tree) = medium(table.need("substrate")?, &table.path("substrate"))?;
    let tree = Node::table([("layers", Value::List(trees).into()), ("substrate", substrate_tree)]);
    Ok((Surface::Coating(Coating { layers, substrate }), tree))
}

/// The one medium of a bare surface.
fn bare(node: &Node, path: String, default: &str) -> Result<(iridesce_optics::Medium, Node), SceneError> {
    let table = Table::new(node, path, &["medium"], &[])?;
    let (medium, tree) = medium_or(&table, "medium", default)?;
    Ok((medium, Node::table([("medium", tree)])))
}

fn diffuse(node: &Node, path: String) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["reflectance"], &[])?;
    let grey = Node::number(defaults::REFLECTANCE);
    let given = table.get("reflectance").unwrap_or(&grey);
    let numbers: Option<Vec<f64>> = match &given.value {
        Value::List(items) if items.len() == 3 => items.iter().map(as_number).collect(),
        _ => as_number(given).map(|value| vec![value]),
    };
    let rgb = match numbers.as_deref() {
        Some(&[grey]) => [grey; 3],
        Some(&[r, g, b]) => [r, g, b],
        _ => [f64::NAN; 3],
    };
    if !rgb.iter().all(|v| (0.0..=1.0).contains(v)) {
        return Err(table.wrong("reflectance", "a number from 0 to 1, or three of them (linear Rec.709)"));
    }
    Ok((Surface::Diffuse(rgb), Node::table([("reflectance", given.without_lines())])))
}

fn emitter(node: &Node, path: String, context: &mut Context<'_>) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["illuminant", "radiance"], &[])?;
    let name = table.text("illuminant")?.unwrap_or(defaults::ILLUMINANT);
    let radiance = radiance(&table)?;
    let line = table.get("illuminant").and_then(|n| n.line);
    let illuminant = illuminant(name, context.origin).map_err(|e| e.at(table.path("illuminant"), line))?;
    let tree = Node::table([("illuminant", Node::text(name)), ("radiance", Node::number(radiance))]);
    Ok((Surface::Emitter(Emitter { illuminant, radiance }), tree))
}
