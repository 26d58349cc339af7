//! Every file in `scenes/` is read and written again unchanged; every file in `scenes/bad/` is refused with exactly
//! the message of its first line.

use std::path::{Path, PathBuf};

use iridesce_numerics::Watch;
use iridesce_scene::{
    Context, Environment, EnvironmentSource, Light, Node, Origin, ResolveError, Scene, builtin_names, resolve,
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == ending)).collect();
    files.sort();
    files
}

/// The validated values, not the trees they came from.
fn assert_same(a: &Scene, b: &Scene) {
    assert_eq!((a.unit, &a.camera, a.render), (b.unit, &b.camera, b.render));
    assert_eq!(format!("{:?}", a.objects), format!("{:?}", b.objects));
    assert_eq!(a.lights.len(), b.lights.len());
    for pair in a.lights.iter().zip(&b.lights) {
        let (Light::Environment(a), Light::Environment(b)) = pair else {
            assert_eq!(format!("{:?}", pair.0), format!("{:?}", pair.1));
            continue;
        };
        let values = |e: &Environment| (e.rotation_deg, e.radiance);
        assert_eq!(values(a), values(b));
        match (&a.source, &b.source) {
            (EnvironmentSource::Map(a), EnvironmentSource::Map(b)) => assert_eq!(a, b),
            (EnvironmentSource::Uniform(a), EnvironmentSource::Uniform(b)) => {
                assert_eq!((a.name(), a.lines(), a.power(555.0)), (b.name(), b.lines(), b.power(555.0)));
            }
            (EnvironmentSource::Sky, EnvironmentSource::Sky)
            | (EnvironmentSource::Studio, EnvironmentSource::Studio) => {}
            pair => panic!("two kinds of light: {pair:?}"),
        }
    }
}

fn assert_round_trip(scene: &Scene) {
    let origin = Origin { file: None, ..scene.origin().clone() };
    let again = Scene::from_node(scene.tree(), origin.clone()).unwrap();
    assert_same(scene, &again);
    assert_eq!(scene.tree(), again.tree());
    let text = scene.to_json().to_string();
    let from_json = Scene::from_node(&Node::from_json(&text).unwrap(), origin).unwrap();
    assert_same(scene, &from_json);
    assert_eq!(from_json.to_json().to_string(), text);
}

#[test]
fn good_scenes_are_read_and_written_unchanged() {
    let scenes = [files("scenes", "toml"), files("scenes", "json")].concat();
    assert!(scenes.len() >= 11, "{scenes:?}");
    for path in scenes {
        let scene = Scene::load(&path, false).unwrap_or_else(|e| panic!("{e}"));
        assert_round_trip(&scene);
        resolve(&scene, &Context::default(), &Watch::new()).unwrap_or_else(|e| panic!("{e}"));
    }
    for name in builtin_names() {
        assert_round_trip(&Scene::builtin(name).unwrap());
    }
}

#[test]
fn toml_and_json_are_one_language() {
    let [toml, json] =
        ["toml", "json"].map(|e| Scene::load(&root().join(format!("scenes/furnace.{e}")), false).unwrap());
    assert_eq!(toml.camera, json.camera);
    assert_eq!(toml.objects[0].name, json.objects[0].name);
}

/// `# scenes/bad/x.toml:5: message`, and nothing else. `IRIDESCE_BLESS=1` rewrites the lines: read every change.
#[test]
fn bad_scenes_are_refused_with_their_message() {
    std::env::set_current_dir(root()).unwrap();
    let bad = files("scenes/bad", "toml");
    assert!(bad.len() >= 90, "{bad:?}");
    let mut wrong = Vec::new();
    for path in bad {
        let relative = path.strip_prefix(root()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
        // What is in the files that a scene names is told when it is resolved.
        let error = match Scene::load(relative, false) {
            Ok(scene) => match resolve(&scene, &Context::default(), &Watch::new()) {
                Err(ResolveError::Scene(error)) => error,
                _ => panic!("{} was read without complaint", relative.display()),
            },
            Err(error) => error,
        };
        assert_eq!(error.file.as_deref(), Some(relative));
        assert_eq!(error.is_resource, relative.ends_with("monstrous-image.toml"));
        let said = format!("# {error}");
        if std::env::var_os("IRIDESCE_BLESS").is_some() {
            std::fs::write(&path, format!("{said}\n{rest}")).unwrap();
        } else if said != first {
            wrong.push(format!("expected {first}\n     got {said}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
