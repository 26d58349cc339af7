//! Objects: their names and shapes.

use std::sync::Arc;

use iridesce_files::{MeshFormat, quoted};
use iridesce_numerics::vector::{cross, difference, length, scaled};

use crate::context::Reading;
use crate::error::SceneError;
use crate::files::map_file;
use crate::model::{Ball, Object, Shape, Surface};
use crate::placement::{bump, placement, uv};
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
    let (shape, shape_tree) = shape(&table.node("shape")?, &table.path("shape"), context)?;
    let mut entries = Vec::new();
    let placement = placement(&table, context, &mut entries)?;
    let uv = uv(&table, &mut entries)?;
    let bump = bump(&table, context, &mut entries)?;
    let priority = match table.get("priority").map(|node| &node.value) {
        Some(Value::Int(priority)) => i32::try_from(*priority).unwrap_or_default(),
        _ => 0,
    };
    if table.get("priority").is_some() {
        entries.push(("priority", Value::Int(priority.into()).into()));
    }
    let context = &Reading { is_placed: !placement.is_plain(), ..*context };
    let (surface, roughness, surface_tree) = surface(&table.node("surface")?, &table.path("surface"), &shape, context)?;
    if matches!(shape, Shape::Bubbles(_)) && !matches!(surface, Surface::Film(_)) {
        return Err(SceneError::new(format!(
            "{} must be a film: the walls of bubbles are films",
            table.path("surface")
        ))
        .at(table.path("surface"), table.line("surface")));
    }
    let all = [("name", Node::text(&name)), ("shape", shape_tree), ("surface", surface_tree)];
    let tree = Node::table(all.into_iter().chain(entries));
    Ok((Object { name, shape, surface, roughness, placement, uv, bump, priority }, tree))
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

fn shape(node: &Node, path: &str, context: &Reading<'_>) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::SHAPE, path)?;
    let (kind, inner) = table.choice()?;
    let read = match kind {
        "sphere" => sphere,
        "rectangle" => rectangle,
        "disk" => disk,
        "plane" => plane,
        "cap" => cap,
        "cylinder" => cylinder,
        "bubbles" => bubbles,
        _ => return mesh(inner, table.path(kind), context),
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

fn cylinder(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::CYLINDER, path)?;
    let (center, axis) = (table.triple("center")?, table.triple("axis")?);
    let (radius, height) = (table.number("radius")?, table.number("height")?);
    let is_open = !matches!(table.get("open").map(|node| &node.value), Some(Value::Bool(false)));
    let tree = Node::table([
        ("center", Node::numbers(&center)),
        ("axis", Node::numbers(&axis)),
        ("radius", Node::number(radius)),
        ("height", Node::number(height)),
        ("open", Value::Bool(is_open).into()),
    ]);
    Ok((Shape::Cylinder { center, axis: unit_vector(axis), radius, height, is_open }, tree))
}

fn mesh(node: &Node, path: String, context: &Reading<'_>) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::MESH, path)?;
    let name = table.text("file")?;
    let at = |error: SceneError| error.at(table.path("file"), table.line("file"));
    let mut file = map_file(context.origin, name).map_err(at)?;
    file.channel = table.get("part").map(|_| table.text("part")).transpose()?.map(str::to_owned);
    MeshFormat::of(std::path::Path::new(name))
        .map_err(|why| at(SceneError::new(format!("{} cannot be used as a mesh: {why}", quoted(name)))))?;
    let mut entries = vec![("file", Node::text(name))];
    entries.extend(file.channel.as_deref().map(|part| ("part", Node::text(part))));
    let tree = Node::table([("mesh", Node::table(entries))]);
    Ok((Shape::Mesh(file), tree))
}

fn bubbles(node: &Node, path: String) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, &schema::BUBBLES, path)?;
    let (mut balls, mut trees) = (Vec::new(), Vec::new());
    for (i, item) in table.list("spheres").iter().enumerate() {
        let ball = Table::new(item, &schema::BALL, format!("{}.{i}", table.path("spheres")))?;
        let (center, radius) = (ball.triple("center")?, ball.number("radius")?);
        balls.push(Ball { center, radius });
        trees.push(Node::table([("center", Node::numbers(&center)), ("radius", Node::number(radius))]));
    }
    if let Some((number, by)) = swallowed(&balls) {
        let path = format!("{}.{number}", table.path("spheres"));
        let line = table.list("spheres").get(number).and_then(|node| node.line);
        let message = format!(
            "{path} is wholly swallowed by bubble {by}, got center {:?} and radius {:?}; let it come out, or lie free within it",
            balls[number].center, balls[number].radius
        );
        return Err(SceneError::new(message).at(path, line));
    }
    Ok((Shape::Bubbles(Arc::from(balls)), Node::table([("spheres", Value::List(trees).into())])))
}

/// A ball that touches another from within, or is it.
fn swallowed(balls: &[Ball]) -> Option<(usize, usize)> {
    let touches = |a: &Ball, b: &Ball| {
        let distance = length(difference(a.center, b.center));
        a.radius <= b.radius && (distance + a.radius - b.radius).abs() <= 1e-12 * b.radius
    };
    (0..balls.len()).find_map(|i| {
        let by = (0..balls.len()).find(|&j| j != i && touches(&balls[i], &balls[j]))?;
        Some((i, by))
    })
}

/// Its direction at length 1; the check refuses what has none.
fn unit_vector(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|x| x / length)
}
