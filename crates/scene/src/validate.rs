//! From the tree to a [`Scene`]: the rules of the scene as a whole, its camera and its render settings.

use std::collections::HashSet;

use iridesce_optics::{Complex64, Medium};

use crate::context::Context;
use crate::defaults;
use crate::error::SceneError;
use crate::files::Maps;
use crate::lights::light;
use crate::model::{Camera, Lens, Object, Origin, Projection, RenderSettings, Scene, Surface, Unit};
use crate::objects::object;
use crate::reader::{Table, as_number};
use crate::shape::{cross, difference, length};
use crate::tree::{Node, Value};

/// Largest side of a picture, pixels.
const MAX_SIDE: u64 = 1 << 20;
/// Most pixels of a picture: 64 GiB of planes. What the machine at hand can hold, the renderer asks.
const MAX_PIXELS: u64 = 1 << 31;
/// Most camera rays per pixel.
const MAX_SAMPLES: u64 = 1 << 20;
/// Largest number of hits along which paths branch.
const MAX_DEPTH: u64 = 1024;
/// Most objects.
const MAX_OBJECTS: usize = 10_000;
/// Most lights.
const MAX_LIGHTS: usize = 256;

/// The scene that a tree describes.
pub fn build(node: &Node, origin: Origin, mut maps: Maps) -> Result<Scene, SceneError> {
    if matches!(&node.value, Value::Table(entries) if entries.is_empty()) {
        return Err(SceneError::new(
            "the scene is empty; it needs version, camera, at least one object and at least one light",
        ));
    }
    let root = Table::new(node, "", &["version", "unit", "camera", "render", "object", "light"], &[])?;
    root.need("version")?;
    if root.whole("version", 1, 0, u64::MAX)? != 1 {
        return Err(root.wrong("version", "1 (this program reads no other)"));
    }
    let unit = match root.text("unit")? {
        None => defaults::UNIT,
        Some(name) => Unit::named(name).ok_or_else(|| root.wrong("unit", "\"m\", \"cm\" or \"mm\""))?,
    };
    let (camera, camera_tree) = camera(root.need("camera")?)?;
    let (render, render_tree) = settings(root.get("render"))?;

    let items = root.list("object")?;
    if items.len() > MAX_OBJECTS {
        return Err(root.wrong("object", &format!("a list of at most {MAX_OBJECTS} tables")));
    }
    let (mut objects, mut object_trees, mut names) = (Vec::new(), Vec::new(), HashSet::new());
    let mut context = Context { unit, origin: &origin, maps: &mut maps };
    for (i, item) in items.iter().enumerate() {
        let (object, tree) = object(item, i, &mut context)?;
        if !names.insert(object.name.clone()) {
            let line = item.get("name").map_or(item.line, |name| name.line);
            return Err(SceneError::new(format!("two objects are named \"{}\"; names must differ", object.name))
                .at(format!("object.{i}.name"), line));
        }
        objects.push(object);
        object_trees.push(tree);
    }
    check_outsides(&objects, items)?;
    let (mut lights, mut light_trees) = (Vec::new(), Vec::new());
    let items = root.list("light")?;
    if items.len() > MAX_LIGHTS {
        return Err(root.wrong("light", &format!("a list of at most {MAX_LIGHTS} tables")));
    }
    for (i, item) in items.iter().enumerate() {
        let (light, tree) = light(item, i, &origin, &mut maps)?;
        lights.push(light);
        light_trees.push(tree);
    }
    let tree = Node::table([
        ("version", Value::Int(1).into()),
        ("unit", Node::text(unit.name())),
        ("camera", camera_tree),
        ("render", render_tree),
        ("object", Value::List(object_trees).into()),
        ("light", Value::List(light_trees).into()),
    ]);
    Ok(Scene { unit, camera, render, objects, lights, tree, origin, maps })
}

fn camera(node: &Node) -> Result<(Camera, Node), SceneError> {
    let table = Table::new(
        node,
        "camera",
        &[
            "position",
            "target",
            "up",
            "fov_deg",
            "orthographic_height",
            "aperture_radius",
            "focus_distance",
            "resolution",
        ],
        &[],
    )?;
    let position = table.triple("position", defaults::POSITION)?;
    let target = table.triple("target", defaults::TARGET)?;
    let up = table.triple("up", defaults::UP)?;
    let view = difference(target, position);
    let (view_length, up_length) = (length(view), length(up));
    if view_length <= 1e-12 * (1.0 + length(position)) {
        return Err(SceneError::new(format!(
            "the camera looks at itself: camera.position and camera.target must differ, both are {target:?}"
        ))
        .at("camera.target", table.get("target").and_then(|n| n.line).or(node.line)));
    }
    let across = cross(view, up);
    if length(across) <= 1e-9 * view_length * up_length {
        return Err(SceneError::new(format!(
            "camera.up must not be zero or along the view from position to target, got {up:?}"
        ))
        .at("camera.up", table.get("up").and_then(|n| n.line).or(node.line)));
    }
    // One of the two, or neither: then the default.
    let views = ["fov_deg", "orthographic_height"];
    let view_key = if views.iter().any(|key| table.get(key).is_some()) { table.one_of(&views)?.0 } else { "fov_deg" };
    let (projection, view_entry) = if view_key == "fov_deg" {
        let allowed = "an angle between 0 and 180 degrees (from 1e-6 to 179.9)";
        let fov_deg = table.number("fov_deg", defaults::FOV_DEG, allowed, |v| (1e-6..=179.9).contains(&v))?;
        (Projection::Perspective { fov_deg }, ("fov_deg", Node::number(fov_deg)))
    } else {
        // The default is never used: the key is there.
        let height = table.length("orthographic_height", 1.0)?;
        (Projection::Orthographic { height }, ("orthographic_height", Node::number(height)))
    };
    let resolution = resolution(&table)?;
    let mut entries = vec![
        ("position", Node::numbers(&position)),
        ("target", Node::numbers(&target)),
        ("up", Node::numbers(&up)),
        view_entry,
    ];
    let lens = lens(&table, view_length, &mut entries)?;
    entries.push(("resolution", Value::List(resolution.iter().map(|&v| Value::Int(v.into()).into()).collect()).into()));
    Ok((Camera { position, target, up, projection, lens, resolution }, Node::table(entries)))
}

/// The camera's lens, if it has one. A pinhole writes no more of it than was given.
fn lens(
    table: &Table<'_>,
    to_target: f64,
    entries: &mut Vec<(&'static str, Node)>,
) -> Result<Option<Lens>, SceneError> {
    let aperture_radius = table.number(
        "aperture_radius",
        defaults::APERTURE_RADIUS,
        "a length, 0 (a pinhole) or from 1e-9 to 1e9",
        |v| v == 0.0 || (1e-9..=1e9).contains(&v),
    )?;
    let focus_distance = table.length("focus_distance", to_target)?;
    let is_lens = aperture_radius > 0.0;
    if is_lens || table.get("aperture_radius").is_some() {
        entries.push(("aperture_radius", Node::number(aperture_radius)));
    }
    if is_lens || table.get("focus_distance").is_some() {
        entries.push(("focus_distance", Node::number(focus_distance)));
    }
    Ok(is_lens.then_some(Lens { aperture_radius, focus_distance }))
}

/// A film's `outside` is the surrounding n = 1, or a medium that fills the space behind some surface: whether a ray is
/// in it where it meets the film, only the ray can say.
fn check_outsides(objects: &[Object], items: &[Node]) -> Result<(), SceneError> {
    let fills = |medium: &Medium| {
        objects.iter().any(|object| match &object.surface {
            Surface::Dielectric(behind) => behind == medium,
            Surface::Coating(coating) => coating.substrate == *medium,
            _ => false,
        })
    };
    for (object, item) in objects.iter().zip(items) {
        let Surface::Film(film) = &object.surface else { continue };
        if film.outside.constant_index() == Some(Complex64::new(1.0, 0.0)) || fills(&film.outside) {
            continue;
        }
        let path = format!("object.{}.surface.film.outside", object.name);
        let given = ["surface", "film", "outside"].iter().try_fold(item, |node, key| node.get(key));
        let text = given.map_or_else(|| film.outside.name().to_owned(), Node::describe);
        return Err(SceneError::new(format!(
            "{path} must be the medium that the film lies in, here air (n = 1), got {text}"
        ))
        .at(path, given.and_then(|n| n.line)));
    }
    Ok(())
}

fn resolution(table: &Table<'_>) -> Result<[u32; 2], SceneError> {
    let Some(node) = table.get("resolution") else { return Ok(defaults::RESOLUTION) };
    let sides: Option<Vec<f64>> = match &node.value {
        Value::List(items) if items.len() == 2 => items.iter().map(as_number).collect(),
        _ => None,
    };
    let Some(&[width, height]) = sides.as_deref() else {
        return Err(table.wrong("resolution", "two whole numbers, width and height"));
    };
    let whole = |v: f64| v.is_finite() && v.fract() == 0.0 && v >= 1.0;
    if !whole(width) || !whole(height) {
        return Err(SceneError::new(format!(
            "camera.resolution must be two whole numbers of at least 1 pixel, got {}",
            node.describe()
        ))
        .at("camera.resolution", node.line));
    }
    if width.max(height) > MAX_SIDE as f64 || width * height > MAX_PIXELS as f64 {
        let mut error = SceneError::new(format!(
            "camera.resolution must be at most {MAX_SIDE} pixels each way and {MAX_PIXELS} in all, got {}",
            node.describe()
        ))
        .at("camera.resolution", node.line);
        error.is_resource = true;
        return Err(error);
    }
    Ok([width as u32, height as u32])
}

fn settings(node: Option<&Node>) -> Result<(RenderSettings, Node), SceneError> {
    let empty = Value::Table(Vec::new()).into();
    let table = Table::new(node.unwrap_or(&empty), "render", &["samples", "seed", "max_depth"], &[])?;
    let RenderSettings { samples, seed, max_depth } = defaults::RENDER;
    let samples = table.whole("samples", samples.into(), 1, MAX_SAMPLES)?;
    let seed = table.whole("seed", seed, 0, u64::MAX)?;
    let max_depth = table.whole("max_depth", max_depth.into(), 1, MAX_DEPTH)?;
    let tree = Node::table([
        ("samples", Value::Int(samples.into()).into()),
        ("seed", Value::Int(seed.into()).into()),
        ("max_depth", Value::Int(max_depth.into()).into()),
    ]);
    Ok((RenderSettings { samples: samples as u32, seed, max_depth: max_depth as u32 }, tree))
}
