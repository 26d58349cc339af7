//! The scenes that come with the program, and the files that they name.

use crate::error::SceneError;
use crate::model::{Origin, Scene};
use crate::reader::suggestion;
use crate::tree::quoted;

const SCENES: [(&str, &str); 14] = [
    ("soap-bubble", include_str!("../scenes/soap-bubble.toml")),
    ("double-bubble", include_str!("../scenes/double-bubble.toml")),
    ("bubble-cluster", include_str!("../scenes/bubble-cluster.toml")),
    ("soap-dome", include_str!("../scenes/soap-dome.toml")),
    ("soap-film-frame", include_str!("../scenes/soap-film-frame.toml")),
    ("newtons-rings", include_str!("../scenes/newtons-rings.toml")),
    ("newtons-rings-sodium", include_str!("../scenes/newtons-rings-sodium.toml")),
    ("oil-slick", include_str!("../scenes/oil-slick.toml")),
    ("titanium", include_str!("../scenes/titanium.toml")),
    ("wafer", include_str!("../scenes/wafer.toml")),
    ("burnt-steel", include_str!("../scenes/burnt-steel.toml")),
    ("beetle", include_str!("../scenes/beetle.toml")),
    ("coated-lens", include_str!("../scenes/coated-lens.toml")),
    ("wet-asphalt", include_str!("../scenes/wet-asphalt.toml")),
];

/// What the name of a file begins with that comes with the program.
const MARK: &str = "builtin:";

/// Files that any scene may name, made by `tools/data/scene_files.py`.
const FILES: [(&str, &[u8]); 12] = [
    ("asphalt.png", include_bytes!("../files/asphalt.png")),
    ("barrel.ply", include_bytes!("../files/barrel.ply")),
    ("chitin.png", include_bytes!("../files/chitin.png")),
    ("elytron.ply", include_bytes!("../files/elytron.ply")),
    ("iris.ply", include_bytes!("../files/iris.ply")),
    ("limbs.ply", include_bytes!("../files/limbs.ply")),
    ("oil.png", include_bytes!("../files/oil.png")),
    ("overcast.hdr", include_bytes!("../files/overcast.hdr")),
    ("punctures.png", include_bytes!("../files/punctures.png")),
    ("scratches.png", include_bytes!("../files/scratches.png")),
    ("temper.png", include_bytes!("../files/temper.png")),
    ("thorax.ply", include_bytes!("../files/thorax.ply")),
];

/// The content of a file that comes with the program, if `name` means one.
pub fn builtin_file(name: &str) -> Option<Result<&'static [u8], SceneError>> {
    let inner = name.strip_prefix(MARK)?;
    Some(FILES.iter().find(|(known, _)| *known == inner).map(|(_, bytes)| *bytes).ok_or_else(|| {
        let names = FILES.map(|(known, _)| known);
        SceneError::new(format!("no built-in file {}{}", quoted(inner), suggestion(inner, &names)))
    }))
}

/// Names of the built-in scenes.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, _)| *name)
}

/// The text of a built-in scene, to start one's own from.
pub fn builtin_text(name: &str) -> Result<&'static str, SceneError> {
    SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text).ok_or_else(|| {
        let names: Vec<&str> = builtin_names().collect();
        SceneError::new(format!("no built-in scene {}{}", quoted(name), suggestion(name, &names)))
    })
}

impl Scene {
    /// A built-in scene by name.
    pub fn builtin(name: &str) -> Result<Scene, SceneError> {
        Scene::from_toml(builtin_text(name)?, Origin::default())
    }
}
