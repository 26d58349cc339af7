//! Objects: their shapes, surfaces, media and thicknesses.

use iridesce_optics::{Complex64, Medium};
use iridesce_thickness::ThicknessModel;

use crate::defaults;
use crate::error::SceneError;
use crate::model::{Film, Object, Shape, Surface, ThicknessField, Unit};
use crate::reader::{Table, as_number};
use crate::tree::{Node, Value};

/// Thickest film: 1 cm. Its phase has 10^5 turns, of which single precision still tells hundredths apart.
const MAX_THICKNESS_NM: f64 = 1e7;
const THICKNESS: &str = "a thickness in nm, from 0 to 1e7";
/// Largest n and k: beyond any metal's, and their fourth powers stay within the range of single precision.
const MAX_INDEX: f64 = 1e3;

/// The object at `number`, and its tree with every default.
pub fn object(node: &Node, number: usize, unit: Unit) -> Result<(Object, Node), SceneError> {
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
        surface(&default_to(table.get("surface"), "film"), &table.path("surface"), &shape, unit)?;
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
    let table = Table::new(node, path, &["sphere"], &["rectangle", "disk", "plane", "cap", "mesh"])?;
    let (kind, inner) = table.one_of(&["sphere"])?;
    let sphere = Table::new(inner, table.path(kind), &["center", "radius"], &[])?;
    let center = sphere.triple("center", defaults::CENTER)?;
    let radius = sphere.length("radius", defaults::RADIUS)?;
    let tree = Node::table([("center", Node::numbers(&center)), ("radius", Node::number(radius))]);
    Ok((Shape::Sphere { center, radius }, Node::table([(kind, tree)])))
}

fn surface(node: &Node, path: &str, shape: &Shape, unit: Unit) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["film"], &["coating", "dielectric", "metal", "diffuse", "emitter"])?;
    let (kind, inner) = table.one_of(&["film"])?;
    let film = Table::new(inner, table.path(kind), &["medium", "thickness_nm", "outside"], &[])?;
    let or_text = |key: &str, default: &str| film.get(key).cloned().unwrap_or_else(|| Node::text(default));
    let (medium, medium_tree) = medium(&or_text("medium", defaults::MEDIUM), &film.path("medium"))?;
    let (thickness, thickness_tree) = thickness(film.get("thickness_nm"), &film.path("thickness_nm"))?;
    let thickness = ThicknessField::new(thickness, shape, unit).map_err(|why| {
        let line = film.get("thickness_nm").and_then(|n| n.line);
        SceneError::new(format!("{} {why}", film.path("thickness_nm"))).at(film.path("thickness_nm"), line)
    })?;
    let outside_node = or_text("outside", defaults::OUTSIDE);
    let (outside, outside_tree) = self::medium(&outside_node, &film.path("outside"))?;
    // A ray must already be in the medium that a film lies in, and so far nothing leads out of the surrounding n = 1.
    if outside.constant_index() != Some(Complex64::new(1.0, 0.0)) {
        return Err(SceneError::new(format!(
            "{} must be the medium that the film lies in, here air (n = 1), got {}",
            film.path("outside"),
            outside_node.describe()
        ))
        .at(film.path("outside"), outside_node.line));
    }
    let tree = Node::table([("medium", medium_tree), ("thickness_nm", thickness_tree), ("outside", outside_tree)]);
    Ok((Surface::Film(Film { medium, thickness, outside }), Node::table([(kind, tree)])))
}

/// A medium is a name, a number or `[n, k]`.
fn medium(node: &Node, path: &str) -> Result<(Medium, Node), SceneError> {
    let wrong = |message: String| SceneError::new(format!("{path} {message}")).at(path, node.line);
    let constant = |n: f64, k: f64| {
        if !(n > 0.0 && n <= MAX_INDEX && (0.0..=MAX_INDEX).contains(&k)) {
            return Err(wrong(format!(
                "must have 0 < n <= 1000 and 0 <= k <= 1000 in a scene, got {}",
                node.describe()
            )));
        }
        Medium::constant(Complex64::new(n, k)).map_err(|e| wrong(format!("cannot be used: {e}")))
    };
    let other = || wrong(format!("must be a medium: a name, a number or [n, k], got {}", node.describe()));
    let found = match &node.value {
        // Longer than any name: not to be repeated in a message.
        Value::Text(name) if name.len() > 100 => return Err(other()),
        Value::Text(name) => Medium::named(name).map_err(|e| wrong(format!("cannot be used: {e}")))?,
        Value::Int(_) | Value::Float(_) => constant(as_number(node).ok_or_else(other)?, 0.0)?,
        Value::List(items) => match items.iter().map(as_number).collect::<Option<Vec<f64>>>().as_deref() {
            Some(&[n, k]) => constant(n, k)?,
            _ => return Err(other()),
        },
        _ => return Err(other()),
    };
    for nm in [360.0, 830.0] {
        found.index_extended(nm).map_err(|e| wrong(format!("cannot be used: {e}")))?;
    }
    Ok((found, node.without_lines()))
}

fn thickness(given: Option<&Node>, path: &str) -> Result<(ThicknessModel, Node), SceneError> {
    let default = || {
        let ends = [("top", Node::number(defaults::TOP_NM)), ("bottom", Node::number(defaults::BOTTOM_NM))];
        Node::table([("gradient", Node::table(ends))])
    };
    let node = &given.cloned().unwrap_or_else(default);
    let is_thickness = |v: f64| (0.0..=MAX_THICKNESS_NM).contains(&v);
    let at = |key: String, line| move |why: String| SceneError::new(format!("{key} {why}")).at(key, line);
    if let Some(thickness_nm) = as_number(node) {
        let wrong = at(path.to_owned(), node.line);
        if !is_thickness(thickness_nm) {
            return Err(wrong(format!("must be {THICKNESS}, got {}", node.describe())));
        }
        let model = ThicknessModel::uniform(thickness_nm).map_err(|e| wrong(e.message))?;
        return Ok((model, Node::number(thickness_nm)));
    }
    if !matches!(node.value, Value::Table(_)) {
        return Err(at(path.to_owned(), node.line)(format!(
            "must be a number or a thickness model, got {}",
            node.describe()
        )));
    }
    let table = Table::new(node, path, &["gradient"], &["lens_gap", "wedge", "map", "flow"])?;
    let (kind, inner) = table.one_of(&["gradient"])?;
    let gradient = Table::new(inner, table.path(kind), &["top", "bottom", "exponent"], &[])?;
    let top = gradient.needed_number("top", THICKNESS, is_thickness)?;
    let bottom = gradient.needed_number("bottom", THICKNESS, is_thickness)?;
    let exponent = gradient.number("exponent", defaults::EXPONENT, "an exponent > 0", |v| v > 0.0)?;
    let model = ThicknessModel::gradient(top, bottom, exponent).map_err(|e| {
        let line = gradient.get(e.key).and_then(|n| n.line).or(inner.line);
        at(gradient.path(e.key), line)(e.message)
    })?;
    let tree = Node::table([
        ("top", Node::number(top)),
        ("bottom", Node::number(bottom)),
        ("exponent", Node::number(exponent)),
    ]);
    Ok((model, Node::table([(kind, tree)])))
}
