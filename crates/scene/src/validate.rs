//! From the tree to a [`Scene`]: all that is wrong with it, or the recipe.

use std::collections::HashSet;

use iridesce_numerics::vector::{cross, difference, length};
use iridesce_optics::{Complex64, Medium};

use crate::check::{Checker, list_of, object_path};
use crate::context::Reading;
use crate::error::SceneError;
use crate::faces::check_faces;
use crate::lights::light;
use crate::model::{Camera, Lens, Light, Object, Origin, Projection, RenderSettings, Scene, Surface, Unit};
use crate::objects::object;
use crate::reader::{Table, as_numbers, as_whole, join, wrong};
use crate::schema::{self, Default, Takes};
use crate::tree::{Node, Value};

/// The scene that a tree describes. The error holds every complaint about it.
pub fn build(node: &Node, origin: Origin) -> Result<Scene, SceneError> {
    if matches!(&node.value, Value::Table(entries) if entries.is_empty()) {
        return Err(SceneError::new(
            "the scene is empty; it needs version, camera, at least one object and at least one light",
        ));
    }
    if let Some(version) = node.get("version")
        && as_whole(version) != Some(1)
    {
        // Of another language, of which nothing else can be told.
        return Err(wrong(version, "version", "1 (this program reads no other)"));
    }
    let mut checker = Checker { origin: &origin, faults: Vec::new() };
    let parts = read(node, &mut checker);
    match (SceneError::of_all(checker.faults), parts) {
        (Some(error), _) => Err(error),
        (None, Some(Parts { unit, camera, render, objects, lights, tree })) => {
            Ok(Scene { unit, camera, render, objects, lights, tree, source: node.clone(), origin })
        }
        (None, None) => Err(SceneError::new("the scene cannot be read")),
    }
}

struct Parts {
    unit: Unit,
    camera: Camera,
    render: RenderSettings,
    objects: Vec<Object>,
    lights: Vec<Light>,
    tree: Node,
}

/// Every part that is sound; what is not, `checker` has noted.
fn read(node: &Node, checker: &mut Checker<'_>) -> Option<Parts> {
    checker.keys(node, &schema::SCENE, "");
    let root = Table::new(node, &schema::SCENE, "").ok()?;
    let unit = unit(&root, checker);
    // Where the unit is wrong, all else is read as if it were the usual one, to be checked.
    let reading = Reading { unit: unit.unwrap_or_default(), origin: checker.origin, is_placed: false };
    let camera = root.get("camera").and_then(|node| {
        checker.part(node, &schema::CAMERA, "camera", || camera(&Table::new(node, &schema::CAMERA, "camera")?))
    });
    let empty = Node::table([]);
    let render = root.get("render").unwrap_or(&empty);
    let render =
        checker.part(render, &schema::RENDER, "render", || settings(&Table::new(render, &schema::RENDER, "render")?));

    let (objects, object_trees) = objects(&root, &reading, checker);
    let (lights, light_trees) = lights(&root, &reading, checker);
    let (unit, (camera, camera_tree), (render, render_tree)) = (unit?, camera?, render?);
    let tree = Node::table([
        ("version", Value::Int(1).into()),
        ("unit", Node::text(unit.name())),
        ("camera", camera_tree),
        ("render", render_tree),
        ("object", Value::List(object_trees).into()),
        ("light", Value::List(light_trees).into()),
    ]);
    Some(Parts { unit, camera, render, objects, lights, tree })
}

fn unit(root: &Table<'_>, checker: &mut Checker<'_>) -> Option<Unit> {
    let unit = root.text("unit").ok().and_then(Unit::named);
    if unit.is_none() {
        checker.complain(root.wrong("unit", "\"m\", \"cm\" or \"mm\""));
    }
    unit
}

fn objects(root: &Table<'_>, reading: &Reading<'_>, checker: &mut Checker<'_>) -> (Vec<Object>, Vec<Node>) {
    let items = items(root, "object", checker);
    let mut names = HashSet::new();
    let mut sound = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let path = object_path(item, i);
        let read = checker.part(item, &schema::OBJECT, &path, || object(item, i, reading));
        // Also of an object that is wrong elsewhere.
        let name = match (item.get("name"), &read) {
            (Some(Node { value: Value::Text(name), line }), _) => Some((name.clone(), *line)),
            (None, Some((object, _))) => Some((object.name.clone(), item.line)),
            _ => None,
        };
        if let Some((name, line)) = name
            && !names.insert(name.clone())
        {
            let message = format!("two objects are named \"{name}\"; names must differ");
            checker.complain(SceneError::new(message).at(format!("object.{i}.name"), line));
        }
        sound.extend(read);
    }
    let (objects, trees): (Vec<Object>, Vec<Node>) = sound.into_iter().unzip();
    if objects.len() == items.len() {
        check_outsides(&objects, items, checker);
        check_faces(&objects, |film, keys, message| {
            let given = keys.iter().try_fold(&items[film], |node, key| node.get(key)).unwrap_or(&items[film]);
            let path = keys.iter().fold(format!("object.{}", objects[film].name), |path, key| join(&path, key));
            checker.complain(SceneError::new(message).at(path, given.line));
        });
    }
    (objects, trees)
}

fn lights(root: &Table<'_>, reading: &Reading<'_>, checker: &mut Checker<'_>) -> (Vec<Light>, Vec<Node>) {
    let mut sound = Vec::new();
    for (i, item) in items(root, "light", checker).iter().enumerate() {
        let path = format!("light.{i}");
        sound.extend(checker.part(item, &schema::LIGHT, &path, || light(item, &path, reading.origin)));
    }
    sound.into_iter().unzip()
}

/// The tables of one of the scene's lists; none where it is no such list.
fn items<'n>(root: &Table<'n>, key: &str, checker: &mut Checker<'_>) -> &'n [Node] {
    let Some(Takes::List(kind, least, most)) = schema::SCENE.key(key).map(|key| key.takes) else { return &[] };
    let Some(node) = root.get(key) else { return &[] };
    list_of(node, kind, least, most, key).unwrap_or_else(|fault| {
        checker.complain(fault);
        &[]
    })
}

fn camera(table: &Table<'_>) -> Result<(Camera, Node), SceneError> {
    let position = table.triple("position")?;
    let target = table.triple("target")?;
    let up = table.triple("up")?;
    let view = difference(target, position);
    let (view_length, up_length) = (length(view), length(up));
    if view_length <= 1e-12 * (1.0 + length(position)) {
        return Err(SceneError::new(format!(
            "the camera looks at itself: camera.position and camera.target must differ, both are {target:?}"
        ))
        .at("camera.target", table.line("target")));
    }
    let across = cross(view, up);
    if length(across) <= 1e-9 * view_length * up_length {
        return Err(SceneError::new(format!(
            "camera.up must not be zero or along the view from position to target, got {up:?}"
        ))
        .at("camera.up", table.line("up")));
    }
    let (projection, view_entry) = match table.number_if_given("orthographic_height")? {
        Some(height) => {
            let numerical_aperture = table.number_if_given("numerical_aperture")?.unwrap_or(0.0);
            (Projection::Orthographic { height, numerical_aperture }, ("orthographic_height", Node::number(height)))
        }
        None => {
            let fov_deg = table.number("fov_deg")?;
            (Projection::Perspective { fov_deg }, ("fov_deg", Node::number(fov_deg)))
        }
    };
    let resolution = resolution(table);
    let mut entries = vec![
        ("position", Node::numbers(&position)),
        ("target", Node::numbers(&target)),
        ("up", Node::numbers(&up)),
        view_entry,
    ];
    if let Some(aperture) = table.number_if_given("numerical_aperture")? {
        if matches!(projection, Projection::Perspective { .. }) {
            let message =
                "camera.numerical_aperture needs camera.orthographic_height: a microscope's view is a parallel one";
            return Err(SceneError::new(message).at("camera.numerical_aperture", table.line("numerical_aperture")));
        }
        entries.push(("numerical_aperture", Node::number(aperture)));
    }
    let lens = lens(table, view_length, &mut entries)?;
    if let (Some(Lens { aperture_radius, .. }), Projection::Orthographic { numerical_aperture, .. }) =
        (lens, projection)
        && numerical_aperture > 0.0
    {
        let message = format!(
            "camera.aperture_radius and camera.numerical_aperture exclude each other, got {aperture_radius:?} and {numerical_aperture:?}"
        );
        return Err(SceneError::new(message).at("camera.aperture_radius", table.line("aperture_radius")));
    }
    let polarizer_deg = table.number_if_given("polarizer_deg")?;
    entries.extend(polarizer_deg.map(|angle| ("polarizer_deg", Node::number(angle))));
    entries.push(("resolution", Value::List(resolution.iter().map(|&v| Value::Int(v.into()).into()).collect()).into()));
    Ok((Camera { position, target, up, projection, lens, polarizer_deg, resolution }, Node::table(entries)))
}

/// The camera's lens, if it has one. A pinhole writes no more of it than was given.
fn lens(
    table: &Table<'_>,
    to_target: f64,
    entries: &mut Vec<(&'static str, Node)>,
) -> Result<Option<Lens>, SceneError> {
    let aperture_radius = table.number("aperture_radius")?;
    let focus_distance = table.number_if_given("focus_distance")?.unwrap_or(to_target);
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
fn check_outsides(objects: &[Object], items: &[Node], checker: &mut Checker<'_>) {
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
        let message = format!("{path} must be the medium that the film lies in, here air (n = 1), got {text}");
        checker.complain(SceneError::new(message).at(path, given.and_then(|n| n.line)));
    }
}

/// Width and height, which the check has seen to be whole and small enough.
fn resolution(table: &Table<'_>) -> [u32; 2] {
    let given = table.get("resolution").and_then(as_numbers);
    match (given.as_deref(), schema::CAMERA.key("resolution").map(|key| key.default)) {
        (Some(&[width, height]), _) => [width as u32, height as u32],
        (_, Some(Default::Sides(sides))) => sides,
        _ => [1, 1],
    }
}

fn settings(table: &Table<'_>) -> Result<(RenderSettings, Node), SceneError> {
    let (samples, seed, max_depth) = (table.whole("samples")?, table.whole("seed")?, table.whole("max_depth")?);
    let has_backdrop = !matches!(table.get("backdrop").map(|node| &node.value), Some(Value::Bool(false)));
    let mut entries = vec![
        ("samples", Value::Int(samples.into()).into()),
        ("seed", Value::Int(seed.into()).into()),
        ("max_depth", Value::Int(max_depth.into()).into()),
    ];
    if !has_backdrop {
        entries.push(("backdrop", Value::Bool(false).into()));
    }
    let settings = RenderSettings { samples: samples as u32, seed, max_depth: max_depth as u32, has_backdrop };
    Ok((settings, Node::table(entries)))
}
