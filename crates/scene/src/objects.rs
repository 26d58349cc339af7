//! Objects: their names and shapes.

use iridesce_numerics::vector::{cross, length, scaled};

use crate::context::Reading;
use crate::error::SceneError;
use crate::model::{Object, Shape};
use crate::reader::{Table, wrong};
use crate::schema;
use crate::surfaces::surface;
use crate::tree::{Node, Value};

/// Sine of the smallest angle between the edges of a rectangle.
const PARALLEL: f64 = 1e-6;

/// The object at `number`, and its tree with every default.
pub fn object(node: &Node, number: usize, context: &Reading<'_>) -> Result<(Object, Node), SceneError> {
    let name = match node.get("name") {
        None => default_name(number),
        Some(Node { value: Value::Text(name), .. }) => name.clone(),
        Some(given) => return Err(wrong(given, "name", "a text")),
    };
    let table = Table::new(node, &schema::OBJECT, format!("object.{name}"))?;
    let (shape, shape_tree) = shape(&table.node("shape")?, &table.path("shape"))?;
    let (surface, roughness, surface_tree) = surface(&table.node("surface")?, &table.path("surface"), &shape, context)?;
    let tree = Node::table([("name", Node::text(&name)), ("shape", shape_tree), ("surface", surface_tree)]);
    Ok((Object { name, shape, surface, roughness }, tree))
}

/// What the object at `number` (from 0) is called where it has no name.
fn default_name(number: usize) -> String {
    if number == 0 { "bubble".to_owned() } else { format!("bubble-{}", number + 1) }
}

/// What complaints call the object at `number`: its name, or its number where that is no name.
pub fn name_or_number(node: &Node, number: usize) -> String {
    match node.get("name").map(|node| &node.value) {
        None => default_name(number),
        Some(Value::Text(name)) if is_object_name(name) => name.clone(),
        Some(_) => number.to_string(),
    }
}

/// Names go into dotted paths.
pub fn is_object_name(name: &str) -> bool {
    !name.is_empty() && name.len() <= 100 && name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_')
}

fn shape(node: &Node, path: &str) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::SHAPE, path)?;
    let (kind, inner) = table.choice()?;
    let read = match kind {
        "sphere" => sphere,
        "rectangle" => rectangle,
        "disk" => disk,
        "plane" => plane,
        _ => cap,
    };
    let (shape, tree) = read(inner, table.path(kind))?;
    Ok((shape, Node::table([(kind, tree)])))
}

fn sphere(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::SPHERE, path)?;
    let (center, radius) = (table.triple("center")?, table.number("radius")?);
    let tree = Node::table([("center", Node::numbers(&center)), ("radius", Node::number(radius))]);
    Ok((Shape::Sphere { center, radius }, tree))
}

fn rectangle(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::RECTANGLE, path)?;
    let (center, u, v) = (table.triple("center")?, table.triple("u")?, table.triple("v")?);
    if length(cross(scaled(u, 1.0 / length(u)), scaled(v, 1.0 / length(v)))) < PARALLEL {
        let line = table.get("v").or(table.get("u")).and_then(|n| n.line);
        return Err(SceneError::new(format!(
            "{} must not be parallel to the other half edge, got u = {u:?} and v = {v:?}",
            table.path("v")
        ))
        .at(table.path("v"), line));
    }
    let tree = Node::table([("center", Node::numbers(&center)), ("u", Node::numbers(&u)), ("v", Node::numbers(&v))]);
    Ok((Shape::Rectangle { center, u, v }, tree))
}

fn disk(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::DISK, path)?;
    let (center, normal, radius) = (table.triple("center")?, table.triple("normal")?, table.number("radius")?);
    let tree = Node::table([
        ("center", Node::numbers(&center)),
        ("normal", Node::numbers(&normal)),
        ("radius", Node::number(radius)),
    ]);
    Ok((Shape::Disk { center, normal: unit_vector(normal), radius }, tree))
}

fn plane(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::PLANE, path)?;
    let (point, normal) = (table.triple("point")?, table.triple("normal")?);
    let tree = Node::table([("point", Node::numbers(&point)), ("normal", Node::numbers(&normal))]);
    Ok((Shape::Plane { point, normal: unit_vector(normal) }, tree))
}

fn cap(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::CAP, path)?;
    let (center, axis) = (table.triple("center")?, table.triple("axis")?);
    let radius_of_curvature = table.number("radius_of_curvature")?;
    let aperture_radius = table.number("aperture_radius")?;
    if aperture_radius > radius_of_curvature.abs() {
        return Err(table.wrong(
            "aperture_radius",
            &format!("at most the radius of the sphere, |radius_of_curvature| = {:?}", radius_of_curvature.abs()),
        ));
    }
    let tree = Node::table([
        ("center", Node::numbers(&center)),
        ("axis", Node::numbers(&axis)),
        ("radius_of_curvature", Node::number(radius_of_curvature)),
        ("aperture_radius", Node::number(aperture_radius)),
    ]);
    Ok((Shape::Cap { center, axis: unit_vector(axis), radius_of_curvature, aperture_radius }, tree))
}

/// Its direction at length 1; the check refuses what has none.
fn unit_vector(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|x| x / length)
}
