//! From a file or a tree to a [`Scene`], and what a scene says about itself.

use std::path::Path;

use iridesce_files::read_whole;
use iridesce_optics::medium::VISIBLE_NM;

use crate::error::SceneError;
use crate::model::{Origin, Scene};
use crate::tree::{Node, Value};
use crate::validate::build;

/// Largest scene file; a scene is text and names its images.
const MAX_FILE_BYTES: u64 = 16 << 20;

impl Scene {
    /// Reads a scene file, TOML or (by its ending) JSON.
    pub fn load(path: &Path, allow_outside: bool) -> Result<Scene, SceneError> {
        let in_file = |e: SceneError| e.in_file(Some(path));
        let bytes = read_whole(path, MAX_FILE_BYTES)
            .map_err(|why| in_file(SceneError::new(format!("cannot read the scene: {why}"))))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            in_file(SceneError::new(format!("not a text: byte {} is not UTF-8", e.utf8_error().valid_up_to())))
        })?;
        // Absolute, so that the scene means the same files after the program has changed its folder.
        let folder = std::path::absolute(path).ok().and_then(|p| p.parent().map(Path::to_path_buf));
        let origin = Origin { file: Some(path.to_path_buf()), folder, allow_outside };
        let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let node = if is_json { Node::from_json(&text) } else { Node::from_toml(&text) }.map_err(in_file)?;
        Scene::from_node(&node, origin)
    }

    /// Reads a scene that is no file, TOML; its paths start from `origin.folder`.
    ///
    /// ```
    /// use iridesce_scene::{Origin, Scene};
    /// let text = "version = 1\n[camera]\n[[object]]\n[[light]]\nenvironment = { illuminant = \"D65\" }";
    /// let scene = Scene::from_toml(text, Origin::default())?;
    /// assert_eq!(scene.camera.resolution, [512, 512]);
    /// # Ok::<(), iridesce_scene::SceneError>(())
    /// ```
    pub fn from_toml(text: &str, origin: Origin) -> Result<Scene, SceneError> {
        let node = Node::from_toml(text).map_err(|e| e.in_file(origin.file.as_deref()))?;
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

    /// [`Scene::tree`] as JSON.
    pub fn to_json(&self) -> serde_json::Value {
        self.tree.to_json()
    }

    /// Names of media whose data stop inside the visible range, so that renders continue them by their stated extension.
    pub fn extended_media(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for object in &self.objects {
            for medium in object.surface.media() {
                let ends = [VISIBLE_NM.0, VISIBLE_NM.1].map(|nm| medium.index_extended(nm));
                if ends.iter().any(|end| matches!(end, Ok((_, true)))) && !names.iter().any(|n| n == medium.name()) {
                    names.push(medium.name().to_owned());
                }
            }
        }
        names
    }

    /// The line of a key in the text that the scene was read from; objects by their names.
    pub(crate) fn line_of(&self, key: &str) -> Option<usize> {
        let mut node = &self.source;
        for part in key.split('.') {
            node = match &node.value {
                Value::List(items) => {
                    let named = self.objects.iter().position(|object| object.name == part);
                    items.get(part.parse().ok().or(named)?)?
                }
                _ => node.get(part)?,
            };
        }
        node.line
    }

    /// Where it came from.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }
}
