//! The scenes that come with the program.

use crate::error::SceneError;
use crate::model::{Origin, Scene};
use crate::reader::suggestion;
use crate::tree::quoted;

const SCENES: [(&str, &str); 10] = [
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
];

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
