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
        let body = Body { scene, object, maps, watch };
        let mesh = body.mesh()?;
        for note in
            mesh.iter().flat_map(|(file, mesh)| mesh.notes.iter().map(|note| format!("{}: {note}", quoted(file))))
        {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        self.meshes.push(mesh.map(|(_, mesh)| mesh));
        self.placements.push(body.placements()?);
        self.bumps.push(body.bump()?);
        Ok(())
    }
}

/// One object, and where its files are read.
struct Body<'a> {
    scene: &'a Scene,
    object: &'a Object,
    maps: &'a Maps,
    watch: &'a Watch,
}

impl<'a> Body<'a> {
    fn path(&self, key: &str) -> String {
        format!("object.{}.{key}", self.object.name)
    }

    /// The same error, at a key of the object.
    fn at(&self, error: SceneError, key: &str) -> SceneError {
        let key = self.path(key);
        let line = self.scene.line_of(&key);
        error.at(key, line)
    }

    fn wrong(&self, message: String, key: &str) -> ResolveError {
        self.at(SceneError::new(message), key).into()
    }

    /// What was read, unless the watch said stop meanwhile; an error stands at `key`.
    fn read<T>(&self, read: Result<T, SceneError>, key: &str) -> Result<T, ResolveError> {
        self.watch.check()?;
        read.map_err(|error| self.at(error, key).into())
    }

    /// The mesh with the name of its file: closed if a medium fills it, with texture coordinates if a map lies on it.
    fn mesh(&self) -> Result<Option<(&'a str, Arc<Mesh>)>, ResolveError> {
        let Body { scene, object, maps, watch } = *self;
        let Shape::Mesh(file) = &object.shape else { return Ok(None) };
        let key = "shape.mesh.file";
        let mesh = self.read(maps.mesh(file, scene.unit, &scene.origin, watch), key)?;
        let fills = matches!(object.surface, Surface::Dielectric(_) | Surface::Coating(_));
        let open = if fills { maps.open_edge(file, scene.unit, &mesh, watch) } else { Ok(None) };
        let open = self.read(open.map_err(|none| SceneError::new(none.to_string())), key)?;
        if let Some(edge) = open {
            let [a, b] = edge.ends;
            let message = format!(
                "{} must be closed, since a medium fills it: the edge from {a:?} to {b:?} of triangle {} is open",
                quoted(&file.name),
                edge.triangle
            );
            return Err(self.wrong(message, key));
        }
        if object.bump.is_some() && mesh.uv.is_none() {
            let bump = self.path("bump");
            let message = format!("{bump} cannot be a map on this mesh, whose file has no texture coordinates");
            return Err(self.wrong(message, "bump"));
        }
        Ok(Some((&file.name, mesh)))
    }

    /// Where the object stands, once or many times.
    fn placements(&self) -> Result<Arc<[Affine]>, ResolveError> {
        let placement = &self.object.placement;
        let own = &placement.transform;
        let all: Arc<[Affine]> = match &placement.instances {
            Instances::Once => Arc::new([*own]),
            Instances::List(list) => list.iter().map(|by| by.after(own)).collect(),
            Instances::File(file) => {
                let list = self.read(self.maps.transforms(file, self.watch), "instances.file")?;
                // Those of a million are not held twice.
                if *own == Affine::IDENTITY { list } else { list.iter().map(|by| by.after(own)).collect() }
            }
        };
        match all.iter().position(|by| by.inverse().is_none()) {
            None => Ok(all),
            Some(flat) => {
                let path = self.path("instances");
                let message = format!("{path} must have an inverse: that of instance {flat} has none");
                Err(self.wrong(message, "instances"))
            }
        }
    }

    fn bump(&self) -> Result<Option<Heights>, ResolveError> {
        let Some(bump) = &self.object.bump else { return Ok(None) };
        let grid = self.read(self.maps.grid(&bump.file, MapOf::Height, self.watch), "bump.map")?;
        Ok(Some(Heights::new(grid.shares(), bump.height)))
    }
}
