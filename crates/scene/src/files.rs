//! Files that a scene names: found beside it, read whole, refused with a reason.

use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::error::SceneError;
use crate::grid::{self, Grid, MAX_GRID_BYTES};
use crate::map::decode;
use crate::model::{EnvironmentMap, Origin};
use crate::tree::quoted;

/// Largest radiance, as a factor and in a map: their product, summed over any number of samples and wavelengths, stays
/// within the range of the renderer's single precision (1e38).
pub const MAX_RADIANCE: f64 = 1e12;
/// Largest file of a map: the largest map in single precision, and then some.
const MAX_MAP_BYTES: u64 = 4 << 30;

/// The maps that a scene has read, so that changing one of its values does not read them again.
#[derive(Debug, Clone, Default)]
pub struct Maps {
    environments: Vec<(PathBuf, Arc<EnvironmentMap>)>,
    thicknesses: Vec<(PathBuf, Grid)>,
}

impl Maps {
    /// The environment map in the file at `path`, which the scene calls `name`.
    pub fn environment(&mut self, path: &Path, name: &str) -> Result<Arc<EnvironmentMap>, SceneError> {
        read_once(&mut self.environments, path, || {
            read_whole(path, MAX_MAP_BYTES)
                .and_then(|bytes| decode(&bytes).map(Arc::new))
                .map_err(|why| cannot_be_used(name, "an environment map", &why))
        })
    }

    /// The thickness map in the file at `path`, which the scene calls `name`.
    pub fn thickness(&mut self, path: &Path, name: &str) -> Result<Grid, SceneError> {
        read_once(&mut self.thicknesses, path, || {
            read_whole(path, MAX_GRID_BYTES)
                .and_then(|bytes| grid::decode(&bytes))
                .map_err(|why| cannot_be_used(name, "a thickness map", &why))
        })
    }
}

/// What is known of a file, or what `read` finds there.
fn read_once<T: Clone>(
    known: &mut Vec<(PathBuf, T)>,
    path: &Path,
    read: impl FnOnce() -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    if let Some((_, value)) = known.iter().find(|(known, _)| known == path) {
        return Ok(value.clone());
    }
    let value = read()?;
    known.push((path.to_path_buf(), value.clone()));
    Ok(value)
}

fn cannot_be_used(name: &str, what: &str, why: &str) -> SceneError {
    SceneError::new(format!("{} cannot be used as {what}: {why}", quoted(name)))
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

/// The bytes of an ordinary file of at most `limit` bytes, or why there are none.
pub fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    // Asked before opening: a named pipe would wait for ever, a device may have no end.
    let metadata = std::fs::metadata(path).map_err(|e| reason(&e))?;
    if metadata.is_dir() {
        return Err("it is a folder".into());
    }
    if !metadata.is_file() {
        return Err("it is no ordinary file".into());
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(|e| reason(&e))?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|e| reason(&e))?;
    if bytes.len() as u64 > limit {
        return Err(format!("it has more than {limit} bytes"));
    }
    Ok(bytes)
}

/// The system's reason without its error number.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}
