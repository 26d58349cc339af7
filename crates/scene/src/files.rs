//! Files that a scene names: found beside it, read whole, refused with a reason.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use iridesce_files::{EnvironmentMap, Grid, MAX_GRID_BYTES, decode_environment, decode_thickness, quoted, read_whole};

use crate::error::SceneError;

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
                .and_then(|bytes| decode_environment(&bytes).map(Arc::new))
                .map_err(|why| cannot_be_used(name, "an environment map", &why))
        })
    }

    /// The thickness map in the file at `path`, which the scene calls `name`.
    pub fn thickness(&mut self, path: &Path, name: &str) -> Result<Grid, SceneError> {
        read_once(&mut self.thicknesses, path, || {
            read_whole(path, MAX_GRID_BYTES)
                .and_then(|bytes| decode_thickness(&bytes))
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
