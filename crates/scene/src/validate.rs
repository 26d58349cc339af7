//! From the tree to a [`Scene`]: every rule and every default of the scene language stands here, once.

use std::collections::HashSet;
use std::path::Path;

use iridesce_optics::color::{Illuminant, illuminant_names};
use iridesce_optics::{Complex64, Medium, medium};
use iridesce_thickness::ThicknessModel;

use crate::error::SceneError;
use crate::files::{read_map, reason};
use crate::model::{
    Camera, Environment, EnvironmentSource, Film, Light, Object, Origin, Projection, RenderSettings, Scene, Shape,
    Surface, Unit,
};
use crate::reader::{Table, as_number, suggestion};
use crate::studio::studio;
use crate::tree::{Node, Value};

/// Largest scene file; a scene is text and names its images.
const MAX_FILE_BYTES: u64 = 16 << 20;
/// Largest side of a picture, pixels.
const MAX_SIDE: u64 = 1 << 20;
/// Most camera rays per pixel.
const MAX_SAMPLES: u64 = 1 << 20;
/// Largest number of hits along which paths branch.
const MAX_DEPTH: u64 = 1024;
/// Most objects.
const MAX_OBJECTS: usize = 10_000;

impl Scene {
    /// Reads a scene file, TOML or (by its ending) JSON.
    pub fn load(path: &Path, allow_outside: bool) -> Result<Scene, SceneError> {
        let in_file = |e: SceneError| e.in_file(Some(path));
        let metadata = std::fs::metadata(path)
            .map_err(|e| in_file(SceneError::new(format!("cannot open the scene: {}", reason(&e)))))?;
        if metadata.is_dir() {
            return Err(in_file(SceneError::new("cannot open the scene: it is a folder")));
        }
        if metadata.len() > MAX_FILE_BYTES {
            return Err(in_file(SceneError::new(format!(
                "a scene file has at most {MAX_FILE_BYTES} bytes, this one has {}",
                metadata.len()
            ))));
        }
        let bytes = std::fs::read(path)
            .map_err(|e| in_file(SceneError::new(format!("cannot read the scene: {}", reason(&e)))))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            in_file(SceneError::new(format!("not a text: byte {} is not UTF-8", e.utf8_error().valid_up_to())))
        })?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).map(Path::to_path_buf);
        let origin = Origin { file: Some(path.to_path_buf()), folder, allow_outside };
        let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let node = if is_json { Node::from_json(&text) } else { Node::from_toml(&text) }.map_err(in_file)?;
        Scene::from_node(&node, origin)
    }

    /// Validates a tree.
    pub fn from_node(node: &Node, origin: Origin) -> Result<Scene, SceneError> {
        let file = origin.file.clone();
        build(node, origin).map_err(|e| e.in_file(file.as_deref()))
    }

    /// The tree with every default filled in: reading it gives the same scene.
    pub fn tree(&self) -> &Node {
        &self.tree
    }

    /// Names of media whose data stop inside 360..830 nm, so that renders continue them by their stated extension.
    pub fn extended_media(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for object in &self.objects {
            let Surface::Film(film) = &object.surface;
            let ends = [360.0, 830.0].map(|nm| film.medium.index_extended(nm));
            if ends.iter().any(|end| matches!(end, Ok((_, true)))) && !names.iter().any(|n| n == film.medium.name()) {
                names.push(film.medium.name().to_owned());
            }
        }
        names
    }

    /// Where it came from.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }
}

fn build(node: &Node, origin: Origin) -> Result<Scene, SceneError> {
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
    let (unit, unit_name) = match root.text("unit")? {
        None | Some("cm") => (Unit::Cm, "cm"),
        Some("m") => (Unit::M, "m"),
        Some("mm") => (Unit::Mm, "mm"),
        Some(_) => return Err(root.wrong("unit", "\"m\", \"cm\" or \"mm\"")),
    };
    let (camera, camera_tree) = camera(root.need("camera")?)?;
    let (render, render_tree) = settings(root.get("render"))?;

    let items = root.list("object")?;
    if items.len() > MAX_OBJECTS {
        return Err(root.wrong("object", &format!("a list of at most {MAX_OBJECTS} tables")));
    }
    let (mut objects, mut object_trees, mut names) = (Vec::new(), Vec::new(), HashSet::new());
    for (i, item) in items.iter().enumerate() {
        let (object, tree) = object(item, i)?;
        if !names.insert(object.name.clone()) {
            return Err(SceneError::new(format!("two objects are named \"{}\"; names must differ", object.name))
                .at(format!("object.{}.name", object.name), item.line));
        }
        objects.push(object);
        object_trees.push(tree);
    }
    let (mut lights, mut light_trees) = (Vec::new(), Vec::new());
    for (i, item) in root.list("light")?.iter().enumerate() {
        let (light, tree) = light(item, i, &origin)?;
        lights.push(light);
        light_trees.push(tree);
    }
    let tree = Node::table([
        ("version", Value::Int(1).into()),
        ("unit", Node::text(unit_name)),
        ("camera", camera_tree),
        ("render", render_tree),
        ("object", Value::List(object_trees).into()),
        ("light", Value::List(light_trees).into()),
    ]);
    Ok(Scene { unit, camera, render, objects, lights, tree, origin })
}

fn camera(node: &Node) -> Result<(Camera, Node), SceneError> {
    let table = Table::new(
        node,
        "camera",
        &["position", "target", "up", "fov_deg", "orthographic_height", "resolution"],
        &["aperture_radius", "focus_distance"],
    )?;
    let position = table.triple("position", Some([0.0, 0.0, 16.0]))?;
    let target = table.triple("target", Some([0.0; 3]))?;
    let up = table.triple("up", Some([0.0, 1.0, 0.0]))?;
    let view: [f64; 3] = std::array::from_fn(|i| target[i] - position[i]);
    let (view_length, up_length) = (length(view), length(up));
    if !(view_length.is_finite() && view_length > 1e-12 * (1.0 + length(position))) {
        return Err(SceneError::new(format!(
            "the camera looks at itself: camera.position and camera.target must differ, both are {target:?}"
        ))
        .at("camera.target", table.get("target").and_then(|n| n.line).or(node.line)));
    }
    let across =
        [view[1] * up[2] - view[2] * up[1], view[2] * up[0] - view[0] * up[2], view[0] * up[1] - view[1] * up[0]];
    if !(length(across) > 1e-9 * view_length * up_length) {
        return Err(SceneError::new(format!(
            "camera.up must not be zero or along the view from position to target, got {up:?}"
        ))
        .at("camera.up", table.get("up").and_then(|n| n.line).or(node.line)));
    }
    let (projection, view_entry) = match (table.get("fov_deg"), table.get("orthographic_height")) {
        (Some(_), Some(_)) => {
            table.one_of(&["fov_deg", "orthographic_height"])?;
            unreachable!("both were given");
        }
        (_, None) => {
            let fov_deg =
                table.number("fov_deg", Some(35.0), "an angle between 0 and 180 degrees", |v| 1e-6 < v && v < 179.9)?;
            (Projection::Perspective { fov_deg }, ("fov_deg", Node::number(fov_deg)))
        }
        (None, Some(_)) => {
            let height = table.number("orthographic_height", None, "a finite height > 0", |v| v > 0.0)?;
            (Projection::Orthographic { height }, ("orthographic_height", Node::number(height)))
        }
    };
    let resolution = resolution(&table)?;
    let tree = Node::table([
        ("position", Node::numbers(&position)),
        ("target", Node::numbers(&target)),
        ("up", Node::numbers(&up)),
        view_entry,
        ("resolution", Value::List(resolution.iter().map(|&v| Value::Int(v.into()).into()).collect()).into()),
    ]);
    Ok((Camera { position, target, up, projection, resolution }, tree))
}

fn resolution(table: &Table<'_>) -> Result<[u32; 2], SceneError> {
    let Some(node) = table.get("resolution") else { return Ok([512, 512]) };
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
            "camera.resolution must be two whole numbers of at least 1 pixel, got {width} x {height}"
        ))
        .at("camera.resolution", node.line));
    }
    if width > MAX_SIDE as f64 || height > MAX_SIDE as f64 {
        let mut error = SceneError::new(format!(
            "camera.resolution must be at most {MAX_SIDE} pixels each way, got {width} x {height}"
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
    let samples = table.whole("samples", 64, 1, MAX_SAMPLES)?;
    let seed = table.whole("seed", 1, 0, u64::MAX)?;
    let max_depth = table.whole("max_depth", 16, 1, MAX_DEPTH)?;
    let tree = Node::table([
        ("samples", Value::Int(samples.into()).into()),
        ("seed", Value::Int(seed.into()).into()),
        ("max_depth", Value::Int(max_depth.into()).into()),
    ]);
    Ok((RenderSettings { samples: samples as u32, seed, max_depth: max_depth as u32 }, tree))
}

fn object(node: &Node, number: usize) -> Result<(Object, Node), SceneError> {
    // The name first, so that every later complaint can use it.
    let name = match node.get("name").map(|n| (&n.value, n.line)) {
        None => format!("object-{}", number + 1),
        Some((Value::Text(name), _)) if is_name(name) => name.clone(),
        Some((_, line)) => {
            return Err(SceneError::new(format!(
                "the name of object {} must be a text of letters, digits, - and _, got {}",
                number + 1,
                node.get("name").map_or_else(String::new, Node::describe)
            ))
            .at(format!("object.{number}.name"), line));
        }
    };
    let path = format!("object.{name}");
    let table = Table::new(node, &path, &["name", "shape", "surface"], &[])?;
    let (shape, shape_tree) = shape(table.need("shape")?, &table.path("shape"))?;
    let (surface, surface_tree) = surface(table.need("surface")?, &table.path("surface"))?;
    let tree = Node::table([("name", Node::text(&name)), ("shape", shape_tree), ("surface", surface_tree)]);
    Ok((Object { name, shape, surface }, tree))
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.len() <= 100 && name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_')
}

fn shape(node: &Node, path: &str) -> Result<(Shape, Node), SceneError> {
    let table = Table::new(node, path, &["sphere"], &["rectangle", "disk", "plane", "cap", "mesh"])?;
    let (kind, inner) = table.one_of(&["sphere"])?;
    let sphere = Table::new(inner, table.path(kind), &["center", "radius"], &[])?;
    let center = sphere.triple("center", Some([0.0; 3]))?;
    let radius = sphere.number("radius", None, "a finite length > 0", |v| v > 0.0)?;
    let tree = Node::table([("center", Node::numbers(&center)), ("radius", Node::number(radius))]);
    Ok((Shape::Sphere { center, radius }, Node::table([(kind, tree)])))
}

fn surface(node: &Node, path: &str) -> Result<(Surface, Node), SceneError> {
    let table = Table::new(node, path, &["film"], &["coating", "dielectric", "metal", "diffuse", "emitter"])?;
    let (kind, inner) = table.one_of(&["film"])?;
    let film = Table::new(inner, table.path(kind), &["medium", "thickness_nm", "outside"], &[])?;
    let (medium, medium_tree) = read_medium(film.need("medium")?, &film.path("medium"))?;
    let (thickness, thickness_tree) = thickness(film.need("thickness_nm")?, &film.path("thickness_nm"))?;
    let air = Node::text("air");
    let outside_node = film.get("outside").unwrap_or(&air);
    let (outside, outside_tree) = read_medium(outside_node, &film.path("outside"))?;
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
fn read_medium(node: &Node, path: &str) -> Result<(Medium, Node), SceneError> {
    let wrong = |message: String| SceneError::new(format!("{path}: {message}")).at(path, node.line);
    let constant = |n: f64, k: f64| {
        if k < 0.0 {
            return Err(wrong(format!("k must be >= 0 in a scene, got {k}")));
        }
        Medium::constant(Complex64::new(n, k)).map_err(|e| wrong(e.to_string()))
    };
    let allowed = "must be a medium: a name, a number or [n, k]";
    let found = match &node.value {
        Value::Text(name) => Medium::named(name)
            .map_err(|_| wrong(format!("unknown medium \"{name}\"{}", suggestion(name, medium::names()))))?,
        Value::Int(_) | Value::Float(_) => constant(as_number(node).unwrap_or(f64::NAN), 0.0)?,
        Value::List(items) => match items.iter().map(as_number).collect::<Option<Vec<f64>>>().as_deref() {
            Some(&[n, k]) => constant(n, k)?,
            _ => return Err(wrong(format!("{allowed}, got {}", node.describe()))),
        },
        _ => return Err(wrong(format!("{allowed}, got {}", node.describe()))),
    };
    for nm in [360.0, 830.0] {
        found.index_extended(nm).map_err(|e| wrong(e.to_string()))?;
    }
    Ok((found, Node { value: node.value.clone(), line: None }))
}

fn thickness(node: &Node, path: &str) -> Result<(ThicknessModel, Node), SceneError> {
    if let Some(thickness_nm) = as_number(node) {
        let model = ThicknessModel::uniform(thickness_nm)
            .map_err(|e| SceneError::new(format!("{path} {}", e.message)).at(path, node.line))?;
        return Ok((model, Node::number(thickness_nm)));
    }
    if !matches!(node.value, Value::Table(_)) {
        return Err(SceneError::new(format!("{path} must be a number or a thickness model, got {}", node.describe()))
            .at(path, node.line));
    }
    let table = Table::new(node, path, &["gradient"], &["lens_gap", "wedge", "map", "flow"])?;
    let (kind, inner) = table.one_of(&["gradient"])?;
    let gradient = Table::new(inner, table.path(kind), &["top", "bottom", "exponent"], &[])?;
    let any = |_: f64| true;
    let top = gradient.number("top", None, "a finite thickness in nm, >= 0", any)?;
    let bottom = gradient.number("bottom", None, "a finite thickness in nm, >= 0", any)?;
    let exponent = gradient.number("exponent", Some(1.0), "a finite exponent > 0", any)?;
    let model = ThicknessModel::gradient(top, bottom, exponent).map_err(|e| {
        SceneError::new(format!("{} {}", gradient.path(e.key), e.message))
            .at(gradient.path(e.key), gradient.get(e.key).and_then(|n| n.line).or(inner.line))
    })?;
    let tree = Node::table([
        ("top", Node::number(top)),
        ("bottom", Node::number(bottom)),
        ("exponent", Node::number(exponent)),
    ]);
    Ok((model, Node::table([(kind, tree)])))
}

fn light(node: &Node, number: usize, origin: &Origin) -> Result<(Light, Node), SceneError> {
    let path = format!("light.{number}");
    let table = Table::new(node, &path, &["environment"], &[])?;
    let (environment, tree) = environment(table.need("environment")?, &table.path("environment"), origin)?;
    Ok((Light::Environment(environment), Node::table([("environment", tree)])))
}

fn environment(node: &Node, path: &str, origin: &Origin) -> Result<(Environment, Node), SceneError> {
    let table = Table::new(node, path, &["map", "illuminant", "builtin", "rotation_deg", "radiance"], &[])?;
    let (kind, source_node) = table.one_of(&["map", "illuminant", "builtin"])?;
    let at = |e: SceneError| SceneError { line: source_node.line, key: Some(table.path(kind)), ..e };
    let name = table.text(kind)?.unwrap_or_default();
    let source = match kind {
        "map" => EnvironmentSource::Map(origin.resolve(name).and_then(|path| read_map(&path)).map_err(at)?),
        "illuminant" => EnvironmentSource::Uniform(illuminant(name, origin).map_err(at)?),
        _ if name == "studio" => EnvironmentSource::Map(studio()),
        _ if name == "sky" => {
            return Err(at(SceneError::new(
                "the environment \"sky\" is not available in this version; available: studio",
            )));
        }
        _ => {
            let hint = suggestion(name, &["studio"]);
            return Err(at(SceneError::new(format!("no built-in environment \"{name}\"{hint}"))));
        }
    };
    let rotation_deg = table.number("rotation_deg", Some(0.0), "a finite angle in degrees", |_| true)?;
    let radiance = table.number("radiance", Some(1.0), "a finite radiance >= 0", |v| (0.0..=1e30).contains(&v))?;
    let mut entries = vec![(kind, Node::text(name))];
    if kind != "illuminant" || table.get("rotation_deg").is_some() {
        entries.push(("rotation_deg", Node::number(rotation_deg)));
    }
    entries.push(("radiance", Node::number(radiance)));
    Ok((Environment { source, rotation_deg, radiance }, Node::table(entries)))
}

/// An illuminant by name, or a CSV file of the scene's.
fn illuminant(name: &str, origin: &Origin) -> Result<Illuminant, SceneError> {
    if name.to_lowercase().ends_with(".csv") {
        let path = origin.resolve(name)?;
        let text = std::fs::read_to_string(&path)
            .map_err(|e| SceneError::new(format!("cannot read \"{}\": {}", path.display(), reason(&e))))?;
        return Illuminant::from_csv(&text, name).map_err(|e| SceneError::new(e.to_string()));
    }
    Illuminant::named(name).map_err(|e| {
        let names: Vec<&str> = illuminant_names().collect();
        match suggestion(name, &names) {
            near if near.contains("did you mean") => SceneError::new(format!("unknown illuminant \"{name}\"{near}")),
            _ => SceneError::new(e.to_string()),
        }
    })
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
