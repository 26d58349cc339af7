//! Files that a scene names: found beside it and asked whether they are ordinary ones; read whole, and once, when the
//! scene is resolved.

use std::path::PathBuf;
use std::sync::Arc;

use iridesce_files::{
    EnvironmentMap, Grid, MAX_ENVIRONMENT_BYTES, MAX_GRID_BYTES, MAX_MESH_BYTES, MAX_PHOTOGRAPH_BYTES,
    MAX_SPECTRUM_BYTES, MapChoice, MapOf, Mesh, MeshFormat, NoAnswer, OpenEdge, aside, check_ordinary, decode_mesh,
    decode_transforms, quoted, read_environment, read_grid, read_photograph, read_whole_watched,
};
use iridesce_numerics::Watch;
use iridesce_thickness::ThicknessMap;

use crate::affine::Affine;
use crate::builtin::builtin_file;
use crate::cache::Cache;
use crate::error::SceneError;
use crate::model::{MapFile, Origin, Unit};
use crate::texture::{Planes, reflectance_planes, reflectance_spectrum, roughness_plane};

/// The file that a scene calls `name`: it is there, an ordinary one, and where the scene may read, or comes with the
/// program. Nothing of it is read.
pub fn map_file(origin: &Origin, name: &str) -> Result<MapFile, SceneError> {
    let path = match builtin_file(name) {
        Some(found) => found.map(|_| PathBuf::from(name))?,
        None => {
            let path = origin.resolve(name)?;
            check_ordinary(&path)
                .map_err(|why| SceneError::new(format!("{} cannot be used as a map: {why}", quoted(name))))?;
            path
        }
    };
    Ok(MapFile { name: name.to_owned(), path, channel: None, page: None })
}

/// What is in a file that a scene names.
fn content(file: &MapFile, most: u64, watch: &Watch) -> Result<Vec<u8>, String> {
    match builtin_file(&file.name) {
        Some(found) => found.map(<[u8]>::to_vec).map_err(|e| e.message),
        None => read_whole_watched(&file.path, most, watch),
    }
}

/// The maps that scenes have read, so that changing a value of a scene does not read them again.
#[derive(Debug, Default)]
pub struct Maps {
    environments: Cache<MapFile, Arc<EnvironmentMap>>,
    grids: Cache<(MapFile, MapOf), Grid>,
    swirls: Cache<[u64; 3], Arc<ThicknessMap>>,
    reflectances: Cache<MapFile, Planes>,
    meshes: Cache<(MapFile, Unit), Arc<Mesh>>,
    open_edges: Cache<(MapFile, Unit), Option<OpenEdge>>,
    transforms: Cache<MapFile, Arc<[Affine]>>,
}

impl Maps {
    /// From now on older maps may be forgotten.
    pub fn next_question(&self) {
        self.environments.next_question();
        self.grids.next_question();
        self.swirls.next_question();
        self.reflectances.next_question();
        self.meshes.next_question();
        self.open_edges.next_question();
        self.transforms.next_question();
    }

    /// The environment map in a file.
    pub fn environment(&self, file: &MapFile, watch: &Watch) -> Result<Arc<EnvironmentMap>, SceneError> {
        self.environments.get(file, || {
            content(file, MAX_ENVIRONMENT_BYTES, watch)
                .and_then(|bytes| read_environment(&bytes, file.channel.as_deref(), watch))
                .map(|(map, _)| (size_of_val(map.rgb.as_slice()), Arc::new(map)))
                .map_err(|why| cannot_be_used(file, "an environment map", &why))
        })
    }

    /// The map of thickness, roughness or heights in a file.
    pub fn grid(&self, file: &MapFile, of: MapOf, watch: &Watch) -> Result<Grid, SceneError> {
        let choice = MapChoice { channel: file.channel.as_deref(), page: file.page };
        self.grids.get(&(file.clone(), of), || {
            content(file, MAX_GRID_BYTES, watch)
                .and_then(|bytes| read_grid(of, &bytes, &choice, watch))
                .map(|grid| (grid.bytes(), grid))
                .map_err(|why| cannot_be_used(file, of.map(), &why))
        })
    }

    /// The roughness in a file, of which 0 means `min` and 1 `max`.
    pub fn roughness(&self, file: &MapFile, min: f64, max: f64, watch: &Watch) -> Result<Planes, SceneError> {
        let grid = self.grid(file, MapOf::Roughness, watch)?;
        roughness_plane(&grid, min, max).map_err(|why| cannot_be_used(file, MapOf::Roughness.map(), &why))
    }

    /// The reflectance map in a file.
    pub fn reflectance(&self, file: &MapFile, watch: &Watch) -> Result<Planes, SceneError> {
        self.reflectances.get(file, || {
            content(file, MAX_PHOTOGRAPH_BYTES, watch)
                .and_then(|bytes| read_photograph(&bytes, &MapChoice::default(), watch))
                .and_then(|picture| Ok((picture.width * picture.height * 24, reflectance_planes(&picture)?)))
                .map_err(|why| cannot_be_used(file, "a reflectance map", &why))
        })
    }

    /// The reflectances in a spectrometer's file.
    pub fn spectrum(&self, file: &MapFile, watch: &Watch) -> Result<Arc<[(f64, f64)]>, SceneError> {
        content(file, MAX_SPECTRUM_BYTES, watch).and_then(|bytes| reflectance_spectrum(&bytes)).map_err(|why| {
            SceneError::new(format!("{} cannot be used as a reflectance spectrum: {why}", quoted(&file.name)))
        })
    }

    /// The mesh in a file, in scene units.
    pub fn mesh(&self, file: &MapFile, unit: Unit, origin: &Origin, watch: &Watch) -> Result<Arc<Mesh>, SceneError> {
        let folder = file.path.parent().map(std::path::Path::to_path_buf);
        // Buffers lie beside the file that names them, and where the scene may read.
        let (root, own_watch) = (origin.clone(), watch.clone());
        let beside = move |name: &str| {
            let own = Origin { file: None, folder: folder.clone(), allow_outside: false };
            let path = own.resolve(name).map_err(|e| e.message)?;
            root.resolve(&path.to_string_lossy()).map_err(|e| e.message)?;
            read_whole_watched(&path, MAX_MESH_BYTES, &own_watch)
        };
        self.meshes.get(&(file.clone(), unit), || {
            MeshFormat::of(&file.path)
                .and_then(|format| {
                    let bytes = content(file, MAX_MESH_BYTES, watch)?;
                    let part = file.channel.clone();
                    let decoded = move || decode_mesh(&bytes, format, part.as_deref(), &beside);
                    aside(watch, decoded).unwrap_or_else(|none| Err(none.to_string()))
                })
                .map(|mut mesh| {
                    if mesh.is_in_metres {
                        let per_metre = 1000.0 / unit.millimetres();
                        mesh.positions.iter_mut().flatten().for_each(|c| *c *= per_metre);
                    }
                    (mesh.bytes(), Arc::new(mesh))
                })
                .map_err(|why| cannot_be_used(file, "a mesh", &why))
        })
    }

    /// The first edge that keeps a mesh from being closed.
    pub fn open_edge(
        &self,
        file: &MapFile,
        unit: Unit,
        mesh: &Arc<Mesh>,
        watch: &Watch,
    ) -> Result<Option<OpenEdge>, NoAnswer> {
        self.open_edges.get(&(file.clone(), unit), || {
            let mesh = mesh.clone();
            aside(watch, move || mesh.open_edge()).map(|edge| (size_of::<OpenEdge>(), edge))
        })
    }

    /// The transforms in a file.
    pub fn transforms(&self, file: &MapFile, watch: &Watch) -> Result<Arc<[Affine]>, SceneError> {
        self.transforms.get(file, || {
            content(file, MAX_GRID_BYTES, watch)
                .and_then(|bytes| decode_transforms(&bytes))
                .map(|rows| {
                    let all: Arc<[Affine]> = rows.into_iter().map(|rows| Affine { rows }).collect();
                    (size_of_val(&*all), all)
                })
                .map_err(|why| cannot_be_used(file, "a list of transforms", &why))
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
