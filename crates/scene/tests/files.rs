//! Every scene file of the repository: good ones round-trip, bad ones give exactly the message in `scenes/bad/expected.txt`.

use std::path::{Path, PathBuf};

use iridesce_scene::{Node, Origin, Scene, builtin_names};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn toml_files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn good_scenes_round_trip() {
    let files = toml_files(&scenes());
    assert!(files.len() >= 3, "{files:?}");
    let mut loaded: Vec<Scene> = files.iter().map(|file| Scene::load(file, false).unwrap()).collect();
    loaded.extend(builtin_names().map(|name| Scene::builtin(name).unwrap()));
    for scene in loaded {
        let json = scene.tree().to_json().to_string();
        let again = Scene::from_node(&Node::from_json(&json).unwrap(), Origin::default()).unwrap();
        assert_eq!(again.tree().to_json(), scene.tree().to_json());
        assert_eq!(again.camera, scene.camera);
        assert_eq!(again.render, scene.render);
        assert_eq!(again.objects.len(), scene.objects.len());
    }
}

/// One line a file: `name.toml:LINE: message` (or `name.toml: message` where no line is known).
#[test]
fn bad_scenes_give_exactly_their_message() {
    let folder = scenes().join("bad");
    let mut found = String::new();
    for file in toml_files(&folder) {
        let error = Scene::load(&file, false).expect_err(&format!("{} is accepted", file.display()));
        assert_eq!(error.file.as_deref(), Some(file.as_path()));
        let message = error.to_string().replace(&format!("{}/", folder.display()), "");
        found.push_str(&message);
        found.push('\n');
    }
    let expected = std::fs::read_to_string(folder.join("expected.txt")).unwrap_or_default();
    assert_eq!(found, expected, "messages differ from scenes/bad/expected.txt; found:\n{found}");
}

#[test]
fn values_are_set_by_path() {
    let scene = Scene::builtin("soap-bubble").unwrap();
    let changed = scene.with_value("object.bubble.surface.film.thickness_nm", Node::number(400.0)).unwrap();
    let film = changed.tree().to_json()["object"][0]["surface"]["film"]["thickness_nm"].clone();
    assert_eq!(film, 400.0);
    let flat = scene.with_value("camera.orthographic_height", Node::number(9.0)).unwrap();
    assert!(flat.tree().get("camera").unwrap().get("fov_deg").is_none(), "the alternative gives way");
    assert!(scene.with_value("light.0.environment.illuminant", Node::text("D50")).is_ok());
    for (path, hint) in [
        ("object.bubbel.shape", "did you mean \"bubble\"?"),
        ("camera.fov", "did you mean \"fov_deg\"?"),
        ("camera..fov_deg", "no path"),
        ("light.3.environment", "numbers from 0 to 0"),
    ] {
        let error = scene.with_value(path, Node::number(1.0)).unwrap_err();
        assert!(error.to_string().contains(hint), "{path}: {error}");
        assert!(error.key.is_some());
    }
}

#[test]
fn deep_nesting_is_refused_and_not_recursed_into() {
    let deep = "[".repeat(100_000);
    assert!(Node::from_toml(&format!("a = {deep}")).is_err());
    assert!(Node::from_json(&deep).is_err());
    let table = format!("{}1{}", "{a=".repeat(5000), "}".repeat(5000));
    assert!(Node::from_toml(&format!("a = {table}")).is_err());
}

#[test]
fn files_that_are_no_scenes_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let message = |path: &Path| Scene::load(path, false).unwrap_err().to_string();
    assert!(message(&path).contains("no such file"));
    assert!(message(folder.path()).contains("folder"));
    std::fs::write(&path, [0xFF, 0xFE, 0x00, 0x01]).unwrap();
    assert!(message(&path).contains("not UTF-8"));
    std::fs::write(&path, "").unwrap();
    assert!(message(&path).contains("empty"));
}

#[test]
fn maps_are_read_whole_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |name: &str, allow_outside: bool| {
        let text = format!(
            "version = 1\n[camera]\n[[object]]\nshape = {{ sphere = {{ radius = 1.0 }} }}\nsurface = {{ film = {{ medium = 1.3, thickness_nm = 1 }} }}\n[[light]]\nenvironment = {{ map = \"{name}\" }}\n"
        );
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        Scene::load(&path, allow_outside)
    };
    let pixels = |at: (usize, usize)| (at.0 as f32, at.1 as f32 * 0.5, 0.25);
    let map = folder.path().join("map.exr");
    exr::prelude::write_rgb_file(&map, 8, 4, |x, y| pixels((x, y))).unwrap();
    assert!(scene("map.exr", false).is_ok());
    let bytes = std::fs::read(&map).unwrap();
    std::fs::write(folder.path().join("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    assert!(scene("cut.exr", false).unwrap_err().to_string().contains("damaged"));
    exr::prelude::write_rgb_file(folder.path().join("nan.exr"), 8, 4, |x, y| {
        (if (x, y) == (5, 2) { f32::NAN } else { 1.0 }, 1.0, 1.0)
    })
    .unwrap();
    let error = scene("nan.exr", false).unwrap_err().to_string();
    assert!(error.contains("column 5, row 2") && error.contains("red"), "{error}");
    let other = tempfile::tempdir().unwrap();
    let outside = other.path().join("map.exr");
    std::fs::copy(&map, &outside).unwrap();
    let name = outside.display().to_string();
    assert!(scene(&name, false).unwrap_err().to_string().contains("outside the scene's folder"));
    assert!(scene(&name, true).is_ok());
    let link = folder.path().join("link.exr");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, &link).unwrap();
        assert!(scene("link.exr", false).unwrap_err().to_string().contains("outside"), "links are followed first");
    }
}
