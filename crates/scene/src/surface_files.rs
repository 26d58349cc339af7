//! What files say of a surface, thicknesses aside: maps of roughness, maps and spectra of reflectance.

use iridesce_files::Mesh;
use iridesce_numerics::Watch;

use crate::error::{ResolveError, SceneError};
use crate::files::Maps;
use crate::model::{MapFile, Object, Reflectance, Roughness, Scene, Surface};
use crate::texture::{ResolvedReflectance, Texture};

/// What the files of a surface say, where it has any.
#[derive(Debug, Clone, Default)]
pub struct SurfaceFiles {
    /// How rough it is, where a map tells.
    pub roughness: Option<Texture>,
    /// What it reflects, where a map or a spectrum tells.
    pub reflectance: Option<ResolvedReflectance>,
}

/// What stands in files of an object's surface, thicknesses aside.
pub fn surface_files(object: &Object) -> impl Iterator<Item = &MapFile> {
    let roughness = match &object.roughness {
        Roughness::Map { file, .. } => Some(file),
        Roughness::Uniform(_) => None,
    };
    let reflectance = match &object.surface {
        Surface::Diffuse(Reflectance::Map(file) | Reflectance::Spectrum(file)) => Some(file),
        _ => None,
    };
    roughness.into_iter().chain(reflectance)
}

/// Reads them. (A map needs the texture coordinates of a mesh.)
pub fn read_surface_files(
    scene: &Scene,
    object: &Object,
    mesh: Option<&Mesh>,
    maps: &Maps,
    watch: &Watch,
) -> Result<SurfaceFiles, ResolveError> {
    let mut files = SurfaceFiles::default();
    let at = |error: SceneError, key: &str| {
        let key = format!("object.{}.surface.{key}", object.name);
        error.at(&key, scene.line_of(&key)).in_file(scene.origin.file.as_deref())
    };
    if let Some(Mesh { uv: None, .. }) = mesh {
        let kind = object.surface.kind();
        let asked = match (&object.roughness, &object.surface) {
            (Roughness::Map { .. }, _) => Some((format!("{kind}.roughness"), "be a map")),
            (Roughness::Uniform([u, v]), _) if u != v => Some((format!("{kind}.roughness"), "differ along u and v")),
            (_, Surface::Diffuse(Reflectance::Map(_))) => Some(("diffuse.reflectance".to_owned(), "be a map")),
            _ => None,
        };
        if let Some((key, what)) = asked {
            let message = format!(
                "object.{}.surface.{key} cannot {what} on this mesh, whose file has no texture coordinates",
                object.name
            );
            return Err(at(SceneError::new(message), &key).into());
        }
    }
    if let Roughness::Map { file, min, max } = &object.roughness {
        let planes = maps.roughness(file, *min, *max, watch);
        watch.check()?;
        let kind = object.surface.kind();
        let planes = planes.map_err(|e| at(e, &format!("{kind}.roughness.map")))?;
        watch.add(1);
        files.roughness = Some(Texture::new(planes, object));
    }
    match &object.surface {
        Surface::Diffuse(Reflectance::Map(file)) => {
            let planes = maps.reflectance(file, watch);
            watch.check()?;
            let planes = planes.map_err(|e| at(e, "diffuse.reflectance.map"))?;
            watch.add(1);
            files.reflectance = Some(ResolvedReflectance::Map(Texture::new(planes, object)));
        }
        Surface::Diffuse(Reflectance::Spectrum(file)) => {
            let table = maps.spectrum(file, watch);
            watch.check()?;
            let table = table.map_err(|e| at(e, "diffuse.reflectance.spectrum"))?;
            watch.add(1);
            files.reflectance = Some(ResolvedReflectance::Spectrum(table));
        }
        _ => {}
    }
    Ok(files)
}
