//! Files that a scene names: found beside it and asked whether they are ordinary ones; read whole, and once, when the
//! scene is resolved.

use std::sync::Arc;

use iridesce_files::{
    EnvironmentMap, Grid, MAX_ENVIRONMENT_BYTES, MAX_GRID_BYTES, MAX_PHOTOGRAPH_BYTES, MAX_SPECTRUM_BYTES, MapChoice,
    check_ordinary, quoted, read_environment, read_grid, read_photograph, read_whole_watched,
};
use iridesce_numerics::Watch;
use iridesce_thickness::ThicknessMap;

use crate::cache::Cache;
use crate::error::SceneError;
use crate::model::{MapFile, Origin};
use crate::texture::{Planes, reflectance_planes, reflectance_spectrum, roughness_plane};

/// The file that a scene calls `name`: it is there, an ordinary one, and where the scene may read. Nothing of it is read.
pub fn map_file(origin: &Origin, name: &str) -> Result<MapFile, SceneError> {
    let path = origin.resolve(name)?;
    check_ordinary(&path).map_err(|why| SceneError::new(format!("{} cannot be used as a map: {why}", quoted(name))))?;
    Ok(MapFile { name: name.to_owned(), path, channel: None, page: None })
}

/// The maps that scenes have read, so that changing a value of a scene does not read them again.
#[derive(Debug, Default)]
pub struct Maps {
    environments: Cache<MapFile, Arc<EnvironmentMap>>,
    thicknesses: Cache<MapFile, Grid>,
    swirls: Cache<[u64; 3], Arc<ThicknessMap>>,
    reflectances: Cache<MapFile, Planes>,
}

impl Maps {
    /// From now on older maps may be forgotten.
    pub fn next_question(&self) {
        self.environments.next_question();
        self.thicknesses.next_question();
        self.swirls.next_question();
        self.reflectances.next_question();
    }

    /// The environment map in a file.
    pub fn environment(&self, file: &MapFile, watch: &Watch) -> Result<Arc<EnvironmentMap>, SceneError> {
        self.environments.get(file, || {
            read_whole_watched(&file.path, MAX_ENVIRONMENT_BYTES, watch)
                .and_then(|bytes| read_environment(&bytes, file.channel.as_deref(), watch))
                .map(|(map, _)| (size_of_val(map.rgb.as_slice()), Arc::new(map)))
                .map_err(|why| cannot_be_used(file, "an environment map", &why))
        })
    }

    /// The thickness map in a file.
    pub fn thickness(&self, file: &MapFile, watch: &Watch) -> Result<Grid, SceneError> {
        let choice = MapChoice { channel: file.channel.as_deref(), page: file.page };
        self.thicknesses.get(file, || {
            read_whole_watched(&file.path, MAX_GRID_BYTES, watch)
                .and_then(|bytes| read_grid(&bytes, &choice, watch))
                .map(|grid| (grid.bytes(), grid))
                .map_err(|why| cannot_be_used(file, "a thickness map", &why))
        })
    }

    /// The roughness in a file, of which 0 means `min` and 1 `max`.
    pub fn roughness(&self, file: &MapFile, min: f64, max: f64, watch: &Watch) -> Result<Planes, SceneError> {
        let grid = self.thickness(file, watch)?;
        roughness_plane(&grid, min, max).map_err(|why| cannot_be_used(file, "a roughness map", &why))
    }

    /// The reflectance map in a file.
    pub fn reflectance(&self, file: &MapFile, watch: &Watch) -> Result<Planes, SceneError> {
        self.reflectances.get(file, || {
            read_whole_watched(&file.path, MAX_PHOTOGRAPH_BYTES, watch)
                .and_then(|bytes| read_photograph(&bytes, &MapChoice::default(), watch))
                .and_then(|picture| Ok((picture.width * picture.height * 24, reflectance_planes(&picture)?)))
                .map_err(|why| cannot_be_used(file, "a reflectance map", &why))
        })
    }

    /// The reflectances in a spectrometer's file.
    pub fn spectrum(&self, file: &MapFile, watch: &Watch) -> Result<Arc<[(f64, f64)]>, SceneError> {
        read_whole_watched(&file.path, MAX_SPECTRUM_BYTES, watch)
            .and_then(|bytes| reflectance_spectrum(&bytes))
            .map_err(|why| {
                SceneError::new(format!("{} cannot be used as a reflectance spectrum: {why}", quoted(&file.name)))
            })
    }

    /// Swirls between two thicknesses in nm.
    pub fn swirls(&self, min_nm: f64, max_nm: f64, seed: u64) -> Result<Arc<ThicknessMap>, SceneError> {
        self.swirls.get(&[min_nm.to_bits(), max_nm.to_bits(), seed], || {
            iridesce_thickness::swirls(min_nm, max_nm, seed)
                .map(|map| (size_of_val(map.thickness_nm()), map))
                .map_err(|e| SceneError::new(e.to_string()))
        })
    }
}

fn cannot_be_used(file: &MapFile, what: &str, why: &str) -> SceneError {
    SceneError::new(format!("{} cannot be used as {what}: {why}", quoted(&file.name)))
}
