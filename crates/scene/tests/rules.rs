//! Rules, defaults, edits and paths of the scene language. The messages are tested file by file in `scenes/bad/`.

use std::path::{Path, PathBuf};

use iridesce_numerics::Watch;
use iridesce_scene::{
    Context, EnvironmentSource, Light, Node, Origin, Projection, ResolvedSource, Scene, SceneError, Shape, Surface,
    Thickness, Unit, Value, builtin_text, resolve,
};
use iridesce_thickness::ThicknessModel;

const LEAST: &str = "version = 1\n[camera]\n[[object]]\n[[light]]\nenvironment = { illuminant = \"D65\" }\n";

fn read(text: &str) -> Result<Scene, SceneError> {
    Scene::from_toml(text, Origin::default())
}

fn law(thickness: &Thickness) -> &ThicknessModel {
    let Thickness::Law(field) = thickness else { panic!("{thickness:?}") };
    field.model()
}

fn least() -> Scene {
    read(LEAST).unwrap()
}

fn number(value: f64) -> Node {
    Node::number(value)
}

fn set(path: &str, value: f64) -> Result<Scene, SceneError> {
    least().with_value(path, number(value))
}

#[test]
fn what_is_left_out_has_the_stated_default() {
    let scene = least();
    assert_eq!(scene.unit, Unit::Cm);
    assert_eq!((scene.camera.position, scene.camera.target), ([0.0, 0.0, 16.0], [0.0; 3]));
    assert_eq!((scene.camera.up, scene.camera.resolution), ([0.0, 1.0, 0.0], [512, 512]));
    assert_eq!(scene.camera.projection, Projection::Perspective { fov_deg: 35.0 });
    assert_eq!((scene.render.samples, scene.render.seed, scene.render.max_depth), (64, 1, 16));
    assert_eq!(scene.objects[0].name, "bubble");
    assert_eq!(scene.objects[0].shape, Shape::Sphere { center: [0.0; 3], radius: 4.0 });
    let Surface::Film(film) = &scene.objects[0].surface else { panic!("no film") };
    assert_eq!((film.medium.name(), film.outside.name()), ("soap", "air"));
    assert_eq!(law(&film.thickness), &ThicknessModel::gradient(0.0, 800.0, 1.0).unwrap());
    let Light::Environment(light) = &scene.lights[0] else { panic!("no environment") };
    assert_eq!((light.rotation_deg, light.radiance), (0.0, 1.0));
    let two = read(&LEAST.replace("[[light]]", "[[object]]\n[[light]]")).unwrap();
    assert_eq!(two.objects[1].name, "bubble-2");
}

#[test]
fn numbers_are_held_to_what_single_precision_can_square() {
    for (path, good, bad) in [
        (
            "object.bubble.shape.sphere.radius",
            &[1e-9, 1e9][..],
            &[0.0, 9e-10, 1.1e9, 1e300, f64::NAN, f64::INFINITY][..],
        ),
        ("camera.orthographic_height", &[1e-9, 1e9], &[0.0, -1.0, 1e10, f64::NAN]),
        ("camera.fov_deg", &[1e-6, 179.9], &[0.0, -1.0, 180.0, f64::NAN, f64::NEG_INFINITY]),
        ("camera.position.0", &[-1e9, 1e9], &[1.1e9, f64::NAN, f64::INFINITY]),
        ("object.bubble.surface.film.medium", &[1e-6, 1e3], &[0.0, -1.0, 1.1e3, f64::NAN]),
        ("object.bubble.surface.film.thickness_nm", &[0.0, 1e7], &[-1e-9, 1.1e7, f64::NAN, f64::INFINITY]),
        ("object.bubble.surface.film.thickness_nm.gradient.top", &[0.0, 1e7], &[-1.0, 1.1e7, f64::NAN]),
        ("object.bubble.surface.film.thickness_nm.gradient.exponent", &[1e-6, 1e6], &[0.0, -1.0, f64::INFINITY]),
        ("light.0.environment.radiance", &[0.0, 1e12], &[-1e-9, 1.1e12, f64::NAN, f64::INFINITY]),
        ("light.0.environment.rotation_deg", &[-1e6, 720.0], &[f64::NAN, f64::INFINITY]),
        ("render.samples", &[1.0, 1_048_576.0], &[0.0, -1.0, 0.5, 1_048_577.0, 1e300, f64::NAN]),
        ("render.seed", &[0.0, 9.0e15], &[-1.0, 0.5, 1e300, f64::NAN]),
        ("render.max_depth", &[1.0, 1024.0], &[0.0, 1025.0, f64::NAN]),
    ] {
        for value in good {
            set(path, *value).unwrap_or_else(|e| panic!("{path} = {value}: {e}"));
        }
        for value in bad {
            let error = set(path, *value).err().unwrap_or_else(|| panic!("{path} = {value} was read"));
            let key = error.key.clone().unwrap();
            assert!(path.starts_with(&key), "{path}: {key}");
            assert!(!error.is_resource && error.message.contains(&format!("{value:?}")), "{path} = {value}: {error}");
        }
    }
}

#[test]
fn every_seed_of_64_bits_is_read_and_written() {
    let scene = least().with_value("render.seed", Value::Int(u64::MAX.into()).into()).unwrap();
    assert_eq!(scene.render.seed, u64::MAX);
    assert_eq!(scene.to_json()["render"]["seed"], u64::MAX);
    assert!(least().with_value("render.seed", Value::Int(i128::from(u64::MAX) + 1).into()).is_err());
    assert!(read(&LEAST.replace("[camera]", &format!("[render]\nseed = {}\n[camera]", "9".repeat(60)))).is_err());
}

#[test]
fn pictures_no_machine_can_hold_are_a_matter_of_resources() {
    for (width, height, is_resource) in
        [(1 << 20, 1 << 11, None), (1 << 20, 1 << 12, Some(true)), (1 << 21, 1, Some(true)), (0, 1, Some(false))]
    {
        let size = Value::List(vec![Value::Int(width).into(), Value::Int(height).into()]).into();
        let outcome = least().with_value("camera.resolution", size);
        assert_eq!(outcome.err().map(|e| e.is_resource), is_resource, "{width} x {height}");
    }
}

#[test]
fn cameras_must_be_able_to_look() {
    let at = |position: [f64; 3], target: [f64; 3], up: [f64; 3]| {
        let text = format!("[camera]\nposition = {position:?}\ntarget = {target:?}\nup = {up:?}\n");
        read(&LEAST.replace("[camera]\n", &text)).map_err(|e| e.key.unwrap())
    };
    let up = [0.0, 1.0, 0.0];
    assert!(at([0.0, 0.0, 1e-6], [0.0; 3], up).is_ok());
    assert!(at([1e9, 0.0, 0.0], [-1e9, 0.0, 0.0], up).is_ok());
    assert_eq!(at([3.0; 3], [3.0; 3], up).unwrap_err(), "camera.target");
    assert_eq!(at([1.0, 0.0, 0.0], [1.0 + 1e-14, 0.0, 0.0], up).unwrap_err(), "camera.target");
    assert_eq!(at([0.0, 5.0, 0.0], [0.0; 3], up).unwrap_err(), "camera.up");
    assert_eq!(at([0.0, 5.0, 1e-12], [0.0; 3], up).unwrap_err(), "camera.up");
    assert_eq!(at([0.0, 0.0, 5.0], [0.0; 3], [0.0; 3]).unwrap_err(), "camera.up");
}

#[test]
fn media_are_names_numbers_or_pairs() {
    let film = |medium: &str| {
        read(&LEAST.replace(
            "[[object]]\n",
            &format!("[[object]]\nsurface = {{ film = {{ medium = {medium}, thickness_nm = 1.0 }} }}\n"),
        ))
    };
    for good in ["\"Ag\"", "1.5", "2", "[1.5, 0.0]", "[0.05, 4]"] {
        film(good).unwrap_or_else(|e| panic!("{good}: {e}"));
    }
    for bad in [
        "\"silver\"",
        "\"\"",
        "true",
        "[1.5]",
        "[1.5, 0.1, 0.2]",
        "[1.5, \"k\"]",
        "{ n = 1.5 }",
        "0",
        "[0, 1]",
        "[1.5, -0.1]",
        "[nan, 0]",
    ] {
        let error = film(bad).err().unwrap_or_else(|| panic!("{bad} was read"));
        assert_eq!(error.key.as_deref(), Some("object.bubble.surface.film.medium"), "{bad}");
        assert_eq!(error.line, Some(4), "{bad}");
    }
}

#[test]
fn a_film_lies_in_the_surrounding_medium() {
    let outside = |medium: &str| least().with_value("object.bubble.surface.film.outside", Node::text(medium));
    assert!(outside("air").is_ok() && outside("vacuum").is_ok());
    assert!(set("object.bubble.surface.film.outside", 1.0).is_ok());
    for bad in ["water", "air-ciddor"] {
        assert_eq!(outside(bad).unwrap_err().key.as_deref(), Some("object.bubble.surface.film.outside"));
    }
    assert!(set("object.bubble.surface.film.outside", 1.0003).is_err());
}

#[test]
fn media_whose_data_stop_inside_the_visible_are_told() {
    let with = |medium| least().with_value("object.bubble.surface.film.medium", Node::text(medium)).unwrap();
    assert!(with("water").extended_media().is_empty());
    assert_eq!(with("TiO2").extended_media(), ["TiO2"]);
}

#[test]
fn clear_bodies_that_nothing_closes_are_told() {
    let notes = |objects: &str| {
        let scene = format!("version = 1\n[camera]\n{objects}[[light]]\nenvironment = {{ illuminant = \"D65\" }}\n");
        read(&scene).unwrap().notes()
    };
    let object = |shape: &str, surface: &str| format!("[[object]]\nshape = {{ {shape} }}\nsurface = {{ {surface} }}\n");
    let disk = "disk = { center = [0, 0, 0], normal = [0, 1, 0], radius = 4.0 }";
    let oil = |substrate: &str| {
        format!("coating = {{ layers = [{{ medium = 1.47, thickness_nm = 300 }}], substrate = {substrate} }}")
    };
    let told = notes(&object(disk, &oil("\"water\"")));
    assert_eq!(told.len(), 1);
    assert!(
        told[0].contains("\"water\" lies behind a disk") && told[0].contains("make the surface a plane"),
        "{told:?}"
    );
    assert_eq!(notes(&object(disk, "dielectric = { medium = \"water\" }")).len(), 1);
    // What has no edge, lets nothing through, or may be closed by another.
    for objects in [
        object("plane = { point = [0, 0, 0], normal = [0, 1, 0] }", &oil("\"water\"")),
        object("sphere = { radius = 4.0 }", "dielectric = { medium = \"water\" }"),
        object(disk, &oil("\"Si\"")),
        object(disk, "film = { medium = \"soap\", thickness_nm = 300 }"),
        object(disk, &oil("\"water\"")) + &object("sphere = { radius = 4.0 }", "dielectric = { medium = \"water\" }"),
    ] {
        assert!(notes(&objects).is_empty(), "{objects}");
    }
}

// --- edits

#[test]
fn films_that_cross_are_told() {
    let notes = |second: &str| {
        let film = "surface = { film = { medium = \"soap\", thickness_nm = 300 } }";
        let ball = |name: &str, shape: &str| format!("[[object]]\nname = \"{name}\"\nshape = {{ {shape} }}\n{film}\n");
        let objects = ball("left", "sphere = { radius = 3.0 }") + &ball("right", second);
        let light = "[[light]]\nenvironment = { illuminant = \"D65\" }\n";
        read(&format!("version = 1\n[camera]\n{objects}{light}")).unwrap().notes()
    };
    let told = notes("sphere = { center = [3.0, 0.0, 0.0], radius = 1.0 }");
    assert_eq!(told.len(), 1);
    assert!(told[0].contains("\"left\" and \"right\" cross") && told[0].contains("bubbles ="), "{told:?}");
    // What lies beside, within, or only touches.
    for apart in ["center = [9.0, 0.0, 0.0], radius = 1.0", "radius = 1.0", "center = [0.0, 5.0, 0.0], radius = 2.0"] {
        assert!(notes(&format!("sphere = {{ {apart} }}")).is_empty(), "{apart}");
    }
}

#[test]
fn values_are_set_by_path() {
    let scene = Scene::builtin("soap-bubble").unwrap();
    let scene = scene.with_value("object.bubble.surface.film.thickness_nm", number(400.0)).unwrap();
    let Surface::Film(film) = &scene.objects[0].surface else { panic!("no film") };
    assert_eq!(law(&film.thickness), &ThicknessModel::Uniform { thickness_nm: 400.0 });
    let scene = scene.with_value("object.0.shape.sphere.center.1", number(2.5)).unwrap();
    assert_eq!(scene.objects[0].shape, Shape::Sphere { center: [0.0, 2.5, 0.0], radius: 4.0 });
    let scene = scene.with_value("render", Node::table([("samples", number(2.0))])).unwrap();
    assert_eq!((scene.render.samples, scene.render.max_depth), (2, 16));
    assert_eq!(scene.with_value("object.bubble.name", Node::text("b")).unwrap().objects[0].name, "b");
}

#[test]
fn setting_one_of_several_keys_removes_the_others() {
    let scene = set("camera.orthographic_height", 9.0).unwrap();
    assert_eq!(scene.camera.projection, Projection::Orthographic { height: 9.0, numerical_aperture: 0.0 });
    assert!(scene.tree().get("camera").unwrap().get("fov_deg").is_none());
    let scene = scene.with_value("light.0.environment.builtin", Node::text("studio")).unwrap();
    let Light::Environment(light) = &scene.lights[0] else { panic!("no environment") };
    assert!(matches!(light.source, EnvironmentSource::Studio));
    let scene = scene.with_value("light.0.environment.illuminant", Node::text("A")).unwrap();
    let Light::Environment(light) = &scene.lights[0] else { panic!("no environment") };
    assert!(matches!(light.source, EnvironmentSource::Uniform(_)));
}

#[test]
fn paths_that_lead_nowhere_suggest_where_to_go() {
    for (path, key, hint) in [
        ("camera.fov", "camera.fov", "did you mean \"fov_deg\""),
        ("rendr.samples", "rendr", "did you mean \"render\""),
        ("object.buble.shape", "object.buble", "did you mean \"bubble\""),
        ("object.1.shape", "object.1", "known here: bubble"),
        ("light.1.environment", "light.1", "numbers from 0 to 0"),
        ("camera.position.3", "camera.position.3", "numbers from 0 to 2"),
        ("object.bubble.surface.film.thicknes_nm", "object.bubble.surface.film.thicknes_nm", "thickness_nm"),
        ("camera.fov_deg.value", "camera.fov_deg", "must be an angle"),
        ("object.bubble.surface.coating", "object.bubble.surface.coating", "must be a table with the keys layers"),
        ("", "", "camera.fov_deg"),
        ("camera..fov_deg", "camera..fov_deg", "is no path"),
        (".", ".", "is no path"),
    ] {
        let error = set(path, 30.0).err().unwrap_or_else(|| panic!("{path} was set"));
        assert_eq!(error.key.as_deref(), Some(key), "{error}");
        assert!(error.message.contains(hint), "{path}: {error}");
    }
}

// --- hostile texts

#[test]
fn paths_without_end_are_refused() {
    let error = set("a.".repeat(93_000).trim_end_matches('.'), 1.0).unwrap_err();
    assert!(error.message.contains("it has 93000 keys"), "{}", error.message);
    assert!(error.message.len() < 300);
}

#[test]
fn nesting_without_end_is_refused() {
    let n = 200_000;
    for text in [
        format!("a = {}{}", "[".repeat(n), "]".repeat(n)),
        format!("a = {}1{}", "{ a = ".repeat(n), " }".repeat(n)),
        format!("a{} = 1", ".a".repeat(n)),
        format!("[a{}]", ".a".repeat(n)),
        format!("[[a{}]]", ".a".repeat(n)),
        "a = [".repeat(n),
    ] {
        let error = read(&text).unwrap_err();
        assert!(error.message.len() < 1000, "{}", error.message.len());
    }
    for text in ["[".repeat(n), "{\"a\":".repeat(n), format!("{}{}", "[".repeat(n), "]".repeat(n))] {
        assert!(Node::from_json(&text).is_err());
    }
    let mut deep = number(1.0);
    for _ in 0..2000 {
        deep = Node::table([("a", deep)]);
    }
    assert!(least().with_value("camera.position", deep).is_err());
}

#[test]
fn messages_carry_no_control_characters_and_stay_short() {
    let long = "x".repeat(1_000_000);
    for text in [
        format!("{LEAST}\"\\u001b[31m\" = 1"),
        format!("{LEAST}{long} = 1"),
        LEAST.replace("D65", &long),
        LEAST.replace("D65", "\\u001b[2J"),
        LEAST.replace("[[object]]", &format!("[[object]]\nsurface = {{ film = {{ medium = \"{long}\" }} }}")),
        LEAST.replace("[[object]]", "[[object]]\nsurface = { film = { medium = \"\\u001b[2J\\u0007\\u001b\" } }"),
        LEAST.replace("D65", "blackbody:\\u001b[2J"),
        LEAST.replace("[[object]]", &format!("[[object]]\nname = \"\\u001b]0;{long}\"")),
    ] {
        let message = read(&text).unwrap_err().to_string();
        assert!(!message.contains('\u{1b}'), "{message:?}");
        assert!(message.len() < 2000, "{}", message.len());
    }
}

// --- files

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("scene/maps")).unwrap();
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/maps/two-windows.exr");
    for name in ["scene/a.exr", "scene/maps/b.exr", "outside.exr"] {
        std::fs::copy(&map, folder.path().join(name)).unwrap();
    }
    folder
}

fn with_map(folder: &Path, map: &str, allow_outside: bool) -> Result<Scene, SceneError> {
    let text = LEAST.replace("illuminant = \"D65\"", &format!("map = {map:?}"));
    let origin = Origin { file: None, folder: Some(folder.to_path_buf()), allow_outside };
    Scene::from_toml(&text, origin)
}

#[test]
fn paths_may_not_leave_the_folder_unless_allowed() {
    let root = folder();
    let inside = root.path().join("scene");
    let absolute = |name: &str| root.path().join(name).display().to_string();
    let mut outside = vec!["../outside.exr".to_owned(), "maps/../../outside.exr".into(), absolute("outside.exr")];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(root.path().join("outside.exr"), inside.join("link.exr")).unwrap();
        std::os::unix::fs::symlink(root.path(), inside.join("door")).unwrap();
        outside.extend(["link.exr".to_owned(), "door/outside.exr".to_owned()]);
    }
    for name in ["a.exr", "maps/b.exr", "./maps/../a.exr", &absolute("scene/a.exr")] {
        with_map(&inside, name, false).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    for name in &outside {
        let error = with_map(&inside, name, false).err().unwrap_or_else(|| panic!("{name} was read"));
        assert!(error.message.contains("allow_outside=True"), "{error}");
        assert_eq!(error.key.as_deref(), Some("light.0.environment.map"));
        with_map(&inside, name, true).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    // Whether a file outside exists is not told.
    assert!(with_map(&inside, "../no-such.exr", false).unwrap_err().message.contains("lies outside"));
    for (name, why) in [("no-such.exr", "no such file"), ("maps", "it is a folder"), ("a.exr/b.exr", "cannot open")] {
        let error = with_map(&inside, name, false).unwrap_err();
        assert!(error.message.contains(why), "{error}");
    }
}

#[test]
fn maps_are_read_once() {
    let root = folder();
    let inside = root.path().join("scene");
    let scene = with_map(&inside, "a.exr", false).unwrap();
    let context = Context::default();
    let map = |scene: &Scene, watch: &Watch| {
        let resolved = resolve(scene, &context, watch).unwrap();
        let ResolvedSource::Map(map) = &resolved.environments[0].source else { panic!("no map") };
        map.clone()
    };
    let watch = Watch::new();
    let before = map(&scene, &watch);
    assert_eq!((watch.progress().stage, watch.progress().done), ("reading", 1));
    std::fs::remove_file(inside.join("a.exr")).unwrap();
    std::fs::copy(inside.join("maps/b.exr"), inside.join("a.exr")).unwrap();
    let changed = scene.with_value("light.0.environment.radiance", number(2.0)).unwrap();
    assert!(std::sync::Arc::ptr_eq(&before, &map(&changed, &Watch::new())));
    watch.stop();
    assert_eq!(resolve(&scene, &Context::default(), &watch).unwrap_err().to_string(), "stopped");
}

#[test]
fn scene_files_are_ordinary_texts_of_a_bounded_size() {
    let root = tempfile::tempdir().unwrap();
    let load = |name: &str, content: &[u8]| -> SceneError {
        let path = root.path().join(name);
        std::fs::write(&path, content).unwrap();
        let error = Scene::load(&path, false).unwrap_err();
        assert_eq!(error.file.as_deref(), Some(path.as_path()));
        error
    };
    assert!(load("a.toml", b"").message.contains("the scene is empty"));
    assert!(load("a.json", b"{}").message.contains("the scene is empty"));
    assert!(load("a.json", b"[]").message.contains("a scene must be a table"));
    assert_eq!(load("a.json", b"{\n\"version\": 1,\n}").line, Some(3));
    assert!(load("a.json", b"{\"version\": null}").message.contains("got null"));
    assert!(load("a.toml", b"version = 1\n\xFF").message.contains("byte 12 is not UTF-8"));
    assert!(load("a.toml", &[0; 100]).message.contains("not valid TOML"));
    assert!(load("a.toml", &vec![b'#'; (16 << 20) + 1]).message.contains("longer than 16 MiB"));
    let load = |path: PathBuf| Scene::load(&path, false).unwrap_err().message;
    assert!(load(root.path().join("no-such.toml")).contains("no such file"));
    assert!(load(root.path().to_path_buf()).contains("it is a folder"));
    #[cfg(unix)]
    assert!(load("/dev/zero".into()).contains("no ordinary file"));
    assert!(load(root.path().join("nul\0.toml")).contains("cannot read the scene"));
}

#[test]
fn an_illuminant_may_be_a_table_beside_the_scene() {
    let root = tempfile::tempdir().unwrap();
    std::fs::write(root.path().join("lamp.csv"), "nm,power\n360,1\n830,3\n").unwrap();
    std::fs::write(root.path().join("bad.csv"), "red,green\n").unwrap();
    let lamp = |name: &str| {
        let origin = Origin { file: None, folder: Some(root.path().to_path_buf()), allow_outside: false };
        Scene::from_toml(&LEAST.replace("D65", name), origin)
    };
    let scene = lamp("lamp.csv").unwrap();
    let Light::Environment(light) = &scene.lights[0] else { panic!("no environment") };
    let EnvironmentSource::Uniform(illuminant) = &light.source else { panic!("{light:?}") };
    assert!((illuminant.power(595.0) / illuminant.power(360.0) - 2.0).abs() < 1e-12);
    for (name, said) in [("bad.csv", "bad.csv"), ("no-such.csv", "no such file"), ("../lamp.csv", "lies outside")] {
        assert!(lamp(name).unwrap_err().message.contains(said), "{name}");
    }
}

#[test]
fn files_of_the_program_are_there_for_every_scene() {
    let with = |map: &str| {
        let text = format!(
            "version = 1\n[camera]\n[[object]]\nbump = {{ map = \"{map}\", height = 0.1 }}\n[[light]]\nenvironment = {{ illuminant = \"E\" }}"
        );
        let nowhere = Origin { folder: Some("no/such/folder".into()), ..Origin::default() };
        Scene::from_toml(&text, nowhere)
    };
    let scene = with("builtin:asphalt.png").unwrap();
    assert!(resolve(&scene, &Context::default(), &Watch::new()).is_ok());
    let error = with("builtin:asphalt.pgn").unwrap_err();
    assert_eq!(error.key.as_deref(), Some("object.bubble.bump.map"));
    assert!(error.message.contains("did you mean \"asphalt.png\""), "{error}");
    let error = with("./builtin:asphalt.png").unwrap_err();
    assert!(error.message.starts_with("cannot open"), "{error}");
}

#[test]
fn built_in_scenes_are_texts_to_start_from() {
    assert!(builtin_text("soap-bubble").unwrap().contains("builtin = \"studio\""));
    assert!(builtin_text("soap-buble").unwrap_err().message.contains("did you mean \"soap-bubble\""));
    assert!(Scene::builtin("kaleidoscope").unwrap_err().message.contains("soap-bubble"));
    for name in iridesce_scene::builtin_names() {
        let scene = Scene::builtin(name).unwrap();
        resolve(&scene, &Context::default(), &Watch::new()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let again = Scene::from_node(scene.tree(), Origin::default()).unwrap();
        assert_eq!(scene.to_json(), again.to_json(), "{name}");
    }
}
