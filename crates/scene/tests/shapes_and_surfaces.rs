//! Shapes, surfaces, thickness models and lenses: what is read, with which defaults, and how edits change it. The
//! messages are tested file by file in `scenes/bad/`.

use std::path::Path;

use iridesce_numerics::Watch;
use iridesce_scene::{
    Context, EnvironmentSource, Light, Node, Origin, Reflectance, ResolvedSource, Scene, SceneError, Shape, Surface,
    Thickness, ThicknessField, Value, resolve,
};

const LEAST: &str = "version = 1\n[camera]\n[[object]]\n[[light]]\nenvironment = { illuminant = \"D65\" }\n";

fn read(text: &str) -> Result<Scene, SceneError> {
    Scene::from_toml(text, Origin::default())
}

fn object(inside: &str) -> Result<Scene, SceneError> {
    read(&LEAST.replace("[[object]]", &format!("[[object]]\n{inside}")))
}

fn shape(inside: &str) -> Shape {
    let surface = "surface = { film = { thickness_nm = 300.0 } }";
    object(&format!("shape = {inside}\n{surface}")).unwrap().objects[0].shape.clone()
}

fn surface(inside: &str) -> Result<Surface, SceneError> {
    object(&format!("surface = {inside}")).map(|scene| scene.objects[0].surface.clone())
}

/// The thickness of the first object's first layer.
fn field(scene: &Scene) -> ThicknessField {
    field_in(&Context::default(), scene)
}

fn field_in(context: &Context, scene: &Scene) -> ThicknessField {
    resolve(scene, context, &Watch::new()).unwrap().layers(0)[0].clone()
}

#[test]
fn shapes_have_their_stated_defaults() {
    assert_eq!(
        shape("{ rectangle = {} }"),
        Shape::Rectangle { center: [0.0; 3], u: [4.0, 0.0, 0.0], v: [0.0, 4.0, 0.0] }
    );
    assert_eq!(shape("{ disk = {} }"), Shape::Disk { center: [0.0; 3], normal: [0.0, 0.0, 1.0], radius: 4.0 });
    assert_eq!(shape("{ plane = {} }"), Shape::Plane { point: [0.0; 3], normal: [0.0, 1.0, 0.0] });
    assert_eq!(
        shape("{ cap = {} }"),
        Shape::Cap { center: [0.0; 3], axis: [0.0, 0.0, 1.0], radius_of_curvature: 8.0, aperture_radius: 4.0 }
    );
}

#[test]
fn normals_have_length_one_and_are_written_as_given() {
    let given = object("shape = { plane = { normal = [0.0, 3.0, 4.0] } }\nsurface = { diffuse = {} }").unwrap();
    assert_eq!(given.objects[0].shape, Shape::Plane { point: [0.0; 3], normal: [0.0, 0.6, 0.8] });
    assert_eq!(given.to_json()["object"][0]["shape"]["plane"]["normal"], serde_json::json!([0.0, 3.0, 4.0]));
    let Shape::Disk { normal, .. } = shape("{ disk = { normal = [1e-9, 0.0, 0.0] } }") else { panic!() };
    assert_eq!(normal, [1.0, 0.0, 0.0]);
    // A cap as wide as its sphere is a hemisphere.
    shape("{ cap = { radius_of_curvature = -2.0, aperture_radius = 2.0 } }");
}

#[test]
fn surfaces_have_their_stated_defaults() {
    let Surface::Dielectric(glass) = surface("{ dielectric = {} }").unwrap() else { panic!() };
    let Surface::Metal(metal) = surface("{ metal = {} }").unwrap() else { panic!() };
    assert_eq!((glass.name(), metal.name()), ("N-BK7", "Al"));
    let diffuse = |text: &str| match surface(text).unwrap() {
        Surface::Diffuse(Reflectance::Rgb(rgb)) => rgb,
        other => panic!("{other:?}"),
    };
    assert_eq!(diffuse("{ diffuse = {} }"), [0.5; 3]);
    assert_eq!(diffuse("{ diffuse = { reflectance = 0 } }"), [0.0; 3]);
    assert_eq!(diffuse("{ diffuse = { reflectance = [1, 0.25, 0.0] } }"), [1.0, 0.25, 0.0]);
    let Surface::Emitter(emitter) = surface("{ emitter = {} }").unwrap() else { panic!() };
    assert_eq!((emitter.illuminant.name(), emitter.radiance), ("D65", 1.0));
    let Surface::Coating(bare) = surface("{ coating = { substrate = \"Si\" } }").unwrap() else { panic!() };
    assert!(bare.layers.is_empty() && bare.substrate.name() == "Si");
}

#[test]
fn coatings_are_read_from_outside_inwards() {
    let text = "{ coating = { layers = [{ medium = \"MgF2\", thickness_nm = 95.0 }, { medium = [2.1, 0.01], \
                thickness_nm = { gradient = { top = 10.0, bottom = 60.0 } } }], substrate = 1.52 } }";
    let Surface::Coating(coating) = surface(text).unwrap() else { panic!() };
    let names: Vec<&str> = coating.layers.iter().map(|layer| layer.medium.name()).collect();
    assert_eq!((names[0], coating.substrate.name()), ("MgF2", "1.52"));
    let Thickness::Law(field) = &coating.layers[1].thickness else { panic!("no law") };
    assert_eq!(field.max_nm(), 60.0);
    let media = surface(text).unwrap().media().len();
    assert_eq!(media, 3);
    let many = |count: usize| {
        let layers = vec!["{ medium = 1.5, thickness_nm = 1.0 }"; count].join(", ");
        surface(&format!("{{ coating = {{ layers = [{layers}], substrate = 1.5 }} }}"))
    };
    assert!(many(1000).is_ok());
    assert!(many(1001).unwrap_err().message.contains("at most 1000 layers, got a list of 1001"));
}

#[test]
fn films_may_lie_in_a_medium_that_fills_something() {
    let with = |other: &str| {
        read(&LEAST.replace(
            "[[object]]",
            &format!("[[object]]\nsurface = {{ film = {{ medium = \"air\", outside = \"water\" }} }}\n{other}"),
        ))
    };
    let sphere = |surface: &str| with(&format!("[[object]]\nsurface = {surface}"));
    assert!(sphere("{ dielectric = { medium = \"water\" } }").is_ok());
    assert!(sphere("{ coating = { layers = [], substrate = \"water\" } }").is_ok());
    for not in [
        "",
        "[[object]]\nsurface = { dielectric = { medium = \"N-BK7\" } }",
        "[[object]]\nsurface = { metal = { medium = \"water\" } }",
        "[[object]]\nsurface = { coating = { layers = [{ medium = \"water\", thickness_nm = 5 }], substrate = 1.5 } }",
    ] {
        let error = with(not).unwrap_err();
        assert_eq!(error.key.as_deref(), Some("object.bubble.surface.film.outside"), "{not}");
        assert!(error.message.contains("must be the medium that the film lies in, here air (n = 1), got \"water\""));
    }
}

#[test]
fn a_lens_has_an_aperture_and_a_focus() {
    let camera = |inside: &str| {
        let text = format!("[camera]\nposition = [0.0, 3.0, 4.0]\n{inside}");
        read(&LEAST.replace("[camera]", &text)).unwrap()
    };
    assert_eq!(camera("").camera.lens, None);
    assert_eq!(camera("aperture_radius = 0").camera.lens, None);
    let lens = camera("aperture_radius = 0.2").camera.lens.unwrap();
    assert_eq!((lens.aperture_radius, lens.focus_distance), (0.2, 5.0), "sharp at the target");
    assert_eq!(camera("aperture_radius = 0.2\nfocus_distance = 12").camera.lens.unwrap().focus_distance, 12.0);
    // A pinhole writes no more than was given; a lens writes both.
    assert_eq!(camera("").to_json()["camera"].get("aperture_radius"), None);
    assert_eq!(camera("aperture_radius = 0.2").to_json()["camera"]["focus_distance"], 5.0);
    let kept = camera("focus_distance = 7.0").with_value("camera.aperture_radius", Node::number(0.1)).unwrap();
    assert_eq!(kept.camera.lens.unwrap().focus_distance, 7.0);
}

#[test]
fn the_sky_is_a_map_and_a_sun() {
    let scene = read(&LEAST.replace("illuminant = \"D65\"", "builtin = \"sky\", rotation_deg = 30")).unwrap();
    let Light::Environment(light) = &scene.lights[0] else { panic!("no environment") };
    assert!(matches!(light.source, EnvironmentSource::Sky));
    let resolved = resolve(&scene, &Context::default(), &Watch::new()).unwrap();
    let ResolvedSource::Sky(map, sun) = &resolved.environments[0].source else { panic!("no sky") };
    assert_eq!((map.width, map.height, light.rotation_deg), (1024, 512, 30.0));
    assert_eq!((sun.angular_radius_deg, sun.illuminant.name()), (0.266, "daylight:5500"));
}

// --- thickness over shapes

fn laid(shape: &str, thickness: &str, unit: &str) -> Scene {
    let text = LEAST.replace("version = 1", &format!("version = 1\nunit = \"{unit}\""));
    let object = format!("[[object]]\nshape = {shape}\nsurface = {{ film = {{ thickness_nm = {thickness} }} }}");
    read(&text.replace("[[object]]", &object)).unwrap_or_else(|e| panic!("{shape} {thickness}: {e}"))
}

#[test]
fn gradients_span_the_shape_in_world_height() {
    let gradient = "{ gradient = { top = 100.0, bottom = 500.0 } }";
    for (shape, bottom, top) in [
        ("{ sphere = { center = [0.0, 1.0, 0.0], radius = 2.0 } }", -1.0, 3.0),
        ("{ rectangle = { center = [0.0, 1.0, 0.0], u = [1.0, 1.0, 0.0], v = [0.0, -2.0, 0.0] } }", -2.0, 4.0),
        ("{ disk = { center = [0.0, 1.0, 0.0], normal = [5.0, 0.0, 0.0], radius = 2.0 } }", -1.0, 3.0),
        ("{ cap = { axis = [0.0, 1.0, 0.0], radius_of_curvature = 2.0, aperture_radius = 2.0 } }", -2.0, 0.0),
        ("{ cap = { axis = [0.0, 1.0, 0.0], radius_of_curvature = -2.0, aperture_radius = 2.0 } }", 0.0, 2.0),
    ] {
        let scene = laid(shape, gradient, "cm");
        let at = |y: f64| field(&scene).thickness_nm([0.3, y, -0.2]);
        assert!((at(bottom) - 500.0).abs() < 1e-9 && (at(top) - 100.0).abs() < 1e-9, "{shape}");
        assert!((at(0.5 * (bottom + top)) - 300.0).abs() < 1e-9, "{shape}");
    }
}

#[test]
fn gaps_follow_the_distance_in_millimetres() {
    let exact = |r_mm: f64| 20.0 + 1e6 * r_mm * r_mm / (1000.0 + f64::sqrt(1e6 - r_mm * r_mm));
    for (unit, mm) in [("mm", 1.0), ("cm", 10.0), ("m", 1000.0)] {
        let gap = "{ lens_gap = { radius_mm = 1000.0, contact_gap_nm = 20.0 } }";
        let size = 15.0 / mm;
        for shape in [
            format!("{{ disk = {{ center = [1.0, 2.0, 3.0], radius = {size} }} }}"),
            format!("{{ rectangle = {{ center = [1.0, 2.0, 3.0], u = [{size}, 0.0, 0.0], v = [0.0, {size}, 0.0] }} }}"),
            format!(
                "{{ cap = {{ center = [1.0, 2.0, 3.0], radius_of_curvature = {}, aperture_radius = {size} }} }}",
                2.0 * size
            ),
        ] {
            let scene = laid(&shape, gap, unit);
            for r_mm in [0.0, 1e-3, 1.0, 10.0] {
                let (x, y) = (1.0 + 0.6 * r_mm / mm, 2.0 - 0.8 * r_mm / mm);
                let found = field(&scene).thickness_nm([x, y, 3.0]);
                assert!((found / exact(r_mm) - 1.0).abs() < 1e-9, "{shape} {unit} {r_mm}: {found}");
            }
            // On a cap the distance counts from its axis, not from its middle.
            let high = field(&scene).thickness_nm([1.0 + 10.0 / mm, 2.0, 3.0 - 2.0 / mm]);
            let expected = if shape.contains("cap") { exact(10.0) } else { exact(f64::sqrt(104.0)) };
            assert!((high / expected - 1.0).abs() < 1e-9, "{shape} {unit}");
            let reach: f64 = if shape.contains("rectangle") { 15.0 * f64::sqrt(2.0) } else { 15.0 };
            assert!((field(&scene).max_nm() / exact(reach) - 1.0).abs() < 1e-9, "{shape} {unit}");
        }
    }
    // As wide as the sphere itself, and no wider.
    laid("{ disk = { radius = 0.1 } }", "{ lens_gap = { radius_mm = 1.0 } }", "cm");
}

#[test]
fn wedges_run_between_two_points_of_the_scene() {
    let wedge = "{ wedge = { from = [0.0, 0.0, 0.0], to = [0.0, 0.0, 4.0], start_nm = 0.0, end_nm = 800.0 } }";
    let scene = laid("{ plane = {} }", wedge, "cm");
    for (z, nm) in [(-3.0, 0.0), (0.0, 0.0), (1.0, 200.0), (4.0, 800.0), (1e6, 800.0)] {
        assert_eq!(field(&scene).thickness_nm([17.0, 0.0, z]), nm);
    }
    assert_eq!(field(&scene).max_nm(), 800.0);
}

// --- maps

fn maps() -> Origin {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Origin { file: None, folder: Some(folder), allow_outside: false }
}

fn with_map(shape: &str, thickness: &str) -> Scene {
    let object = format!("[[object]]\nshape = {shape}\nsurface = {{ film = {{ thickness_nm = {thickness} }} }}");
    Scene::from_toml(&LEAST.replace("[[object]]", &object), maps()).unwrap()
}

#[test]
fn maps_lie_on_shapes_by_u_and_v() {
    // 0 to 800 nm from left to right, 32 columns; 400 nm in rows and columns 4 to 9, upper left.
    let scene = with_map("{ rectangle = { u = [2.0, 0.0, 0.0], v = [0.0, 2.0, 0.0] } }", "{ map = \"maps/ramp.tif\" }");
    let at = |x: f64, y: f64| field(&scene).thickness_nm([x, y, 0.0]);
    assert!((at(0.0, 0.0) - 400.0).abs() < 0.1 && (at(2.0, -1.0) - 800.0).abs() < 1e-3);
    assert!((at(-1.125, 1.125) - 400.0).abs() < 1e-3, "the block");
    assert!((at(-1.125, -1.125) - 167.7).abs() < 1.0, "none below");
    assert_eq!(field(&scene).max_nm(), 800.0);
    // A globe goes round: half-way across its seam between 0 and 800 nm.
    let globe = with_map("{ sphere = { radius = 2.0 } }", "{ map = \"maps/ramp.tif\" }");
    let seam = field(&globe).thickness_nm([0.0, 0.0, -2.0]);
    assert!((seam - 400.0).abs() < 1e-3, "{seam}");
    // A plane repeats the map every unit.
    let plane = with_map("{ plane = { normal = [0.0, 0.0, 1.0] } }", "{ map = \"maps/ramp.tif\" }");
    let at = |x: f64, y: f64| field(&plane).thickness_nm([x, y, 0.0]);
    // u = 0.6 lies 18.7 columns after the first middle, of 31 to the last.
    assert!((at(0.1, -0.3) - at(5.1, 7.7)).abs() < 1e-6);
    assert!((at(0.1, -0.3) - 18.7 / 31.0 * 800.0).abs() < 0.06, "{}", at(0.1, -0.3));
    // All kinds of file hold the same.
    for name in ["ramp.npy", "ramp.exr"] {
        let other = with_map("{ plane = { normal = [0.0, 0.0, 1.0] } }", &format!("{{ map = \"maps/{name}\" }}"));
        assert_eq!(field(&other), field(&plane), "{name}");
    }
}

#[test]
fn channel_and_page_say_which_part_of_a_file_is_the_map() {
    let shape = "{ rectangle = { u = [2.0, 0.0, 0.0], v = [0.0, 2.0, 0.0] } }";
    let plain = with_map(shape, "{ map = \"maps/ramp.exr\" }");
    let named = with_map(shape, "{ map = \"maps/ramp.exr\", channel = \"thickness_nm\" }");
    assert_eq!(field(&plain), field(&named));
    let page = with_map(shape, "{ map = \"maps/ramp.tif\", page = 1 }");
    assert_eq!(field(&plain), field(&page));
    // They are kept in the tree, and what is not there is refused at the map's key.
    let tree = &named.to_json()["object"][0]["surface"]["film"]["thickness_nm"];
    assert_eq!(tree["channel"], "thickness_nm");
    for (part, words) in [("channel = \"depth\"", "no channel \"depth\""), ("page = 2", "page must be 1")] {
        let scene = with_map(shape, &format!("{{ map = \"maps/ramp.exr\", {part} }}"));
        let error = resolve(&scene, &Context::default(), &Watch::new()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_map_is_read_once_and_its_range_can_change() {
    let root = tempfile::tempdir().unwrap();
    let file = root.path().join("steps.png");
    std::fs::copy(maps().folder.unwrap().join("maps/steps.png"), &file).unwrap();
    let object =
        "[[object]]\nsurface = { film = { thickness_nm = { map = \"steps.png\", min_nm = 0, max_nm = 100 } } }";
    let origin = Origin { file: None, folder: Some(root.path().to_path_buf()), allow_outside: false };
    let scene = Scene::from_toml(&LEAST.replace("[[object]]", object), origin).unwrap();
    let context = Context::default();
    assert_eq!(field_in(&context, &scene).max_nm(), 100.0);
    std::fs::write(&file, b"no longer a picture").unwrap();
    let path = "object.bubble.surface.film.thickness_nm.max_nm";
    let wider = scene.with_value(path, Node::number(300.0)).unwrap();
    assert_eq!(field_in(&context, &wider).max_nm(), 300.0);
    let unread = scene.with_value("object.bubble.surface.film.thickness_nm.map", Node::text("other.png"));
    assert!(unread.unwrap_err().message.contains("no such file"));
}

// --- edits

#[test]
fn values_inside_models_and_layers_are_set_by_path() {
    let gap = "{ lens_gap = { radius_mm = 1000.0 } }";
    let scene = laid("{ disk = { radius = 1.0 } }", gap, "cm");
    let path = "object.bubble.surface.film.thickness_nm";
    let changed = scene.with_value(&format!("{path}.lens_gap.radius_mm"), Node::number(500.0)).unwrap();
    assert!((field(&changed).max_nm() - 100_010.002).abs() < 1e-3, "{}", field(&changed).max_nm());
    // One model replaces another, with what belongs to it.
    let ends = [("top", Node::number(0.0)), ("bottom", Node::number(50.0))];
    let gradient = changed.with_value(&format!("{path}.gradient"), Node::table(ends)).unwrap();
    assert_eq!(gradient.to_json()["object"][0]["surface"]["film"]["thickness_nm"].as_object().unwrap().len(), 1);
    let mapped = with_map("{ disk = {} }", "{ map = \"maps/steps.png\", min_nm = 0, max_nm = 100 }");
    let number = mapped.with_value(&format!("{path}.lens_gap.radius_mm"), Node::number(1e4)).unwrap();
    let tree = &number.to_json()["object"][0]["surface"]["film"]["thickness_nm"];
    assert_eq!(
        tree.as_object().unwrap().keys().collect::<Vec<_>>(),
        ["lens_gap"],
        "min_nm and max_nm went with the map"
    );

    let text = "shape = { disk = {} }\nsurface = { coating = { layers = [{ medium = \"SiO2\", thickness_nm = 5.0 }, \
                { medium = \"TiO2\", thickness_nm = 6.0 }], substrate = \"Si\" } }";
    let plate = object(text).unwrap();
    let layers = "object.bubble.surface.coating.layers";
    let changed = plate.with_value(&format!("{layers}.0.thickness_nm"), Node::number(77.0)).unwrap();
    assert_eq!(field(&changed).max_nm(), 77.0);
    let changed = plate.with_value(&format!("{layers}.1.medium"), Node::text("Ag")).unwrap();
    assert_eq!(changed.objects[0].surface.media()[1].name(), "Ag");
    let bare = plate.with_value(layers, Value::List(Vec::new()).into()).unwrap();
    assert_eq!(bare.objects[0].surface.media().len(), 1);
    let error = plate.with_value(&format!("{layers}.2.thickness_nm"), Node::number(7.0)).unwrap_err();
    assert!(error.message.contains("numbers from 0 to 1"), "{error}");
    // Another surface or shape takes the place of the old one.
    let metal = plate.with_value("object.bubble.surface.metal.medium", Node::text("Au")).unwrap();
    assert!(matches!(metal.objects[0].surface, Surface::Metal(_)));
    let ball = plate.with_value("object.bubble.shape.sphere.radius", Node::number(2.0)).unwrap();
    assert_eq!(ball.objects[0].shape, Shape::Sphere { center: [0.0; 3], radius: 2.0 });
}
