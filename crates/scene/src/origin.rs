//! The folder that a scene's files lie in.

use std::path::{Component, Path, PathBuf};

use iridesce_files::reason;

use crate::error::SceneError;
use crate::tree::quoted;

/// Where a scene came from: what its paths are relative to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// The file, for messages.
    pub file: Option<PathBuf>,
    /// The folder that paths start from and may not leave; `None` is the current folder.
    pub folder: Option<PathBuf>,
    /// The user said that paths may leave the folder.
    pub allow_outside: bool,
}

impl Origin {
    /// The file that a scene means by `name`: relative to the scene's folder, inside it unless the user allowed more.
    pub fn resolve(&self, name: &str) -> Result<PathBuf, SceneError> {
        let wrong = |e: &std::io::Error| SceneError::new(format!("cannot open {}: {}", quoted(name), reason(e)));
        let folder = self.folder.clone().unwrap_or_else(|| PathBuf::from("."));
        let root = std::fs::canonicalize(&folder).map_err(|e| wrong(&e))?;
        let outside = || {
            SceneError::new(format!(
                "{} lies outside the scene's folder; a scene may name only files in its own folder or below, unless you \
                 allow it (allow_outside=True, --allow-outside)",
                quoted(name)
            ))
        };
        // By its letters first: whether a file outside exists is nobody's business.
        if !self.allow_outside && leaves(Path::new(name), &[&root, &folder]) {
            return Err(outside());
        }
        let found = std::fs::canonicalize(folder.join(name)).map_err(|e| wrong(&e))?;
        // Then with every link followed.
        if !self.allow_outside && !found.starts_with(&root) {
            return Err(outside());
        }
        Ok(found)
    }
}

/// Whether a path leads out of the folder it starts from, links not followed. An absolute path is inside where it
/// starts with one of `roots`.
fn leaves(path: &Path, roots: &[&Path]) -> bool {
    let inside = match roots.iter().find_map(|root| path.strip_prefix(root).ok()) {
        Some(inside) => inside,
        None if path.is_absolute() => return true,
        None => path,
    };
    let mut depth = 0_i64;
    inside.components().any(|part| {
        depth += match part {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            Component::RootDir | Component::Prefix(_) => i64::MIN / 2,
        };
        depth < 0
    })
}
