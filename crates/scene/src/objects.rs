//! Objects: their names and shapes.

use crate::context::Context;
use crate::defaults;
use crate::error::SceneError;
use crate::model::{Object, Shape};
use crate::reader::Table;
use crate::shape::{cross, length, scaled};
use crate::surfaces::surface;
use crate::tree::{Node, Value};

/// Sine of the smallest angle between the edges of a rectangle.
const PARALLEL: f64 = 1e-6;

/// The object at `number`, and its tree with every default.
pub fn object(node: &Node, number: usize, context: &mut Context<'_>) -> Result<(Object, Node), SceneError> {
    // The name first, so that every later complaint can use it.
    let name = match node.get("name") {
        None => defaults::name(number),
        Some(Node { value: Value::Text(name), .. }) if is_object_name(name) => name.clone(),
        Some(given) => {
            return Err(SceneError::new(format!(
                "object.{number}.name must be 1 to 100 letters, digits, - and _, got {}",
                given.describe()
            ))
            .at(format!("object.{number}.name"), given.line));
        }
    };
    let table = Table::new(node, format!("object.{name}"), &["name", "shape", "surface"], &[])?;
    let (shape, shape_tree) = shape(&default_to(table.get("shape"), "sphere"), &table.path("shape"))?;
    let (surface, surface_tree) =
        surface(&default_to(table.get("surface"), "film"), &table.path("surface"), &shape, context)?;
    let tree = Node::table([("name", Node::text(&name)), ("shape", shape_tree), ("surface", surface_tree)]);
    Ok((Object { name, shape, surface }, tree))
}

/// What was given, or a table of the default kind with nothing but defaults.
fn default_to(given: Option<&Node>, kind: &'static str) -> Node {
    given.cloned().unwrap_or_else(|| Node::table([(kind, Node::table([]))]))
}

/// Names go into dotted paths.
fn is_object_name(name: &str) -> bool {
    !name.is_empty() && name.len() <= 100 && name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_')
}

fn shape(node: &Node, path: &str) -> Result<(Shape, Node), SceneError> {
    const KINDS: [&str; 5] = ["sphere", "rectangle", "disk", "plane", "cap"];
    let table = Table::new(node, path, &KINDS, &["mesh"])?;
    let (kind, inner) = table.one_of(&KINDS)?;
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
    let table = Table::new(node, path, &["center", "radius"], &[])?;
    let center = table.triple("center", defaults::CENTER)?;
    let radius = table.length("radius", defaults::RADIUS)?;
    let tree = Node::table([("center", Node::numbers(&center)), ("radius", Node::number(radius))]);
    Ok((Shape::Sphere { center, radius }, tree))
}

fn rectangle(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, path, &["center", "u", "v"], &[])?;
    let center = table.triple("center", defaults::CENTER)?;
    let u = table.vector("u", defaults::HALF_EDGE_U)?;
    let v = table.vector("v", defaults::HALF_EDGE_V)?;
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
    let table = Table::new(node, path, &["center", "normal", "radius"], &[])?;
    let center = table.triple("center", defaults::CENTER)?;
    let normal = table.vector("normal", defaults::NORMAL)?;
    let radius = table.length("radius", defaults::RADIUS)?;
    let tree = Node::table([
        ("center", Node::numbers(&center)),
        ("normal", Node::numbers(&normal)),
        ("radius", Node::number(radius)),
    ]);
    Ok((Shape::Disk { center, normal: unit_vector(normal), radius }, tree))
}

fn plane(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, path, &["point", "normal"], &[])?;
    let point = table.triple("point", defaults::CENTER)?;
    let normal = table.vector("normal", defaults::PLANE_NORMAL)?;
    let tree = Node::table([("point", Node::numbers(&point)), ("normal", Node::numbers(&normal))]);
    Ok((Shape::Plane { point, normal: unit_vector(normal) }, tree))
}

fn cap(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, path, &["center", "axis", "radius_of_curvature", "aperture_radius"], &[])?;
    let center = table.triple("center", defaults::CENTER)?;
    let axis = table.vector("axis", defaults::NORMAL)?;
    let radius_of_curvature = table.number(
        "radius_of_curvature",
        defaults::RADIUS_OF_CURVATURE,
        "a length other than 0, from 1e-9 to 1e9 either way (> 0 bulges towards the axis)",
        |v| (1e-9..=1e9).contains(&v.abs()),
    )?;
    let aperture_radius = table.length("aperture_radius", defaults::RADIUS)?;
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

/// Its direction at length 1; `Table::vector` refuses what has none.
fn unit_vector(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|x| x / length)
}
