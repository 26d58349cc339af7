//! What files say of objects beside their layers: meshes, places, bumps.

use std::sync::Arc;

use iridesce_files::{MapOf, Mesh, quoted};
use iridesce_numerics::Watch;

use crate::affine::Affine;
use crate::error::{ResolveError, SceneError};
use crate::files::Maps;
use crate::heights::Heights;
use crate::model::{Instances, Object, Scene, Shape, Surface};

/// What files say of objects beside their layers.
#[derive(Default)]
pub struct Bodies {
    pub meshes: Vec<Option<Arc<Mesh>>>,
    pub placements: Vec<Arc<[Affine]>>,
    pub bumps: Vec<Option<Heights>>,
    pub notes: Vec<String>,
}

impl Bodies {
    /// Reads what an object's shape and placement name, and adds it.
    pub fn read(&mut self, scene: &Scene, object: &Object, maps: &Maps, watch: &Watch) -> Result<(), ResolveError> {
        let path = |key: &str| format!("object.{}.{key}", object.name);
        let at = |error: SceneError, key: &str| {
            let key = path(key);
            let line = scene.line_of(&key);
            error.at(key, line)
        };
        let mesh = match &object.shape {
            Shape::Mesh(file) => {
                let mesh = maps.mesh(file, scene.unit, &scene.origin, watch);
                watch.check()?;
                let mesh = mesh.map_err(|e| at(e, "shape.mesh.file"))?;
                let fills = matches!(object.surface, Surface::Dielectric(_) | Surface::Coating(_));
                let open = if fills { maps.open_edge(file, scene.unit, &mesh, watch) } else { Ok(None) };
                watch.check()?;
                let open = open.map_err(|none| at(SceneError::new(none.to_string()), "shape.mesh.file"))?;
                if let Some(edge) = open {
                    let [a, b] = edge.ends;
                    let message = format!(
                        "{} must be closed, since a medium fills it: the edge from {a:?} to {b:?} of triangle {} is open",
                        quoted(&file.name),
                        edge.triangle
                    );
                    return Err(at(SceneError::new(message), "shape.mesh.file").into());
                }
                for note in &mesh.notes {
                    let note = format!("{}: {note}", quoted(&file.name));
                    if !self.notes.contains(&note) {
                        self.notes.push(note);
                    }
                }
                if object.bump.is_some() && mesh.uv.is_none() {
                    let message =
                        format!("{} cannot be a map on this mesh, whose file has no texture coordinates", path("bump"));
                    return Err(at(SceneError::new(message), "bump").into());
                }
                Some(mesh)
            }
            _ => None,
        };
        self.meshes.push(mesh);
        let own = &object.placement.transform;
        let all: Arc<[Affine]> = match &object.placement.instances {
            Instances::Once => Arc::new([*own]),
            Instances::List(list) => list.iter().map(|by| by.after(own)).collect(),
            Instances::File(file) => {
                let list = maps.transforms(file, watch);
                watch.check()?;
                let list = list.map_err(|e| at(e, "instances.file"))?;
                // Those of a million are not held twice.
                if *own == Affine::IDENTITY { list } else { list.iter().map(|by| by.after(own)).collect() }
            }
        };
        if let Some(flat) = all.iter().position(|by| by.inverse().is_none()) {
            let message = format!("{} must have an inverse: that of instance {flat} has none", path("instances"));
            return Err(at(SceneError::new(message), "instances").into());
        }
        self.placements.push(all);
        let bump = match &object.bump {
            None => None,
            Some(bump) => {
                let grid = maps.grid(&bump.file, MapOf::Height, watch);
                watch.check()?;
                let grid = grid.map_err(|e| at(e, "bump.map"))?;
                Some(Heights::new(grid.shares(), bump.height))
            }
        };
        self.bumps.push(bump);
        Ok(())
    }
}
