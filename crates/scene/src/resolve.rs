//! From the recipe to a scene that can be looked at: maps are read, films flow. The one step of this crate that takes time.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use iridesce_files::{EnvironmentMap, MapOf, Mesh};
use iridesce_flow::{FilmRun, Films, FlowError};
use iridesce_numerics::Watch;
use iridesce_optics::color::Illuminant;
use iridesce_thickness::{FlowField, ThicknessError, ThicknessModel};

use crate::affine::Affine;
use crate::bodies::Bodies;
use crate::error::{ResolveError, SceneError};
use crate::field::{Ground, ThicknessField};
use crate::files::Maps;
use crate::films::stored;
use crate::heights::Heights;
use crate::model::{EnvironmentSource, Film, Instances, Light, MapFile, Object, Scene, Shape, Sun, Surface, Thickness};
use crate::schema::MAX_THICKNESS_NM;
use crate::shut_in::{Read, shut_in_lights};
use crate::sky::sky;
use crate::studio::studio;
use crate::surface_files::{SurfaceFiles, read_surface_files, surface_files};
use crate::texture::{ResolvedReflectance, Texture};
use crate::thickness::too_thick;

/// What has been read and has flowed: maps, and films where they stand. Scenes that are resolved with the same context
/// do not do it again, and films go on from where they are; a scene and all that is derived from it share one, and so do
/// the frames of an animation. What the last scene used is kept, and of older things up to 512 MiB of each kind.
#[derive(Debug, Default)]
pub struct Context {
    maps: Maps,
    films: Films,
}

/// The mesh of an object, if its shape is one, and where the object is put, once for each instance.
pub type Body = (Option<Arc<Mesh>>, Arc<[Affine]>);

impl Context {
    /// The films, to keep their states or to let them go on elsewhere.
    pub fn films(&self) -> &Films {
        &self.films
    }

    /// The mesh of an object, in scene units, if its shape is one, and where the object is put, once for each instance:
    /// what geometry needs, without the maps and the films.
    pub fn body(&self, scene: &Scene, object: usize, watch: &Watch) -> Result<Body, ResolveError> {
        let mut bodies = Bodies::default();
        bodies.read(scene, &scene.objects[object], &self.maps, watch).map_err(|error| match error {
            ResolveError::Scene(error) => ResolveError::Scene(error.in_file(scene.origin.file.as_deref())),
            stopped => stopped,
        })?;
        Ok((bodies.meshes.pop().flatten(), bodies.placements.pop().unwrap_or_default()))
    }

    /// A film at a time: a stored one, or else one that flows now.
    pub fn film(&self, film: &FilmRun, time_s: f64, watch: &Watch) -> Result<Arc<FlowField>, FlowError> {
        match stored(film, time_s) {
            Some(field) => Ok(field),
            None => self.films.field(film, time_s, watch),
        }
    }
}

/// A scene with all that it names: ready to be rendered.
#[derive(Debug, Clone)]
pub struct ResolvedScene {
    /// The scene.
    pub recipe: Scene,
    /// The environments, in the order of `recipe.lights`; all other lights are ready there.
    pub environments: Vec<ResolvedEnvironment>,
    /// The thicknesses of each object's layers.
    layers: Vec<Vec<ThicknessField>>,
    /// What the files of each object's surface say.
    files: Vec<SurfaceFiles>,
    /// What the files of meshes hold, by object.
    meshes: Vec<Option<Arc<Mesh>>>,
    /// Where each object is put, once for each instance.
    placements: Vec<Arc<[Affine]>>,
    /// Heights of bumps, by object.
    bumps: Vec<Option<Heights>>,
    /// Films that are layers of another object's face, by that object.
    on_faces: HashMap<usize, usize>,
    /// What was left out of files, and what only files tell of the scene, a sentence each.
    pub notes: Vec<String>,
}

impl ResolvedScene {
    /// The mesh of an object, in scene units, if its shape is one.
    pub fn mesh(&self, object: usize) -> Option<&Arc<Mesh>> {
        self.meshes[object].as_ref()
    }

    /// Where an object is put: from the space of its shape to the world, once for each instance. Nowhere, if it is a film on the
    /// face of another object.
    pub fn placements(&self, object: usize) -> &[Affine] {
        &self.placements[object]
    }

    /// The heights of an object's bump map.
    pub fn bump(&self, object: usize) -> Option<&Heights> {
        self.bumps[object].as_ref()
    }

    /// The thicknesses of an object's layers, from outside inwards: one of a film, any number of a coating, none of
    /// other surfaces.
    pub fn layers(&self, object: usize) -> &[ThicknessField] {
        &self.layers[object]
    }

    /// The film that lies on the face of an object, and its thickness: one layer more outside all of the object's own.
    pub fn film_on_face(&self, object: usize) -> Option<(&Film, &ThicknessField)> {
        let film = *self.on_faces.get(&object)?;
        match &self.recipe.objects[film].surface {
            Surface::Film(layer) => Some((layer, self.layers[film].first()?)),
            _ => None,
        }
    }

    /// The map of an object's roughness, if it has one.
    pub fn roughness(&self, object: usize) -> Option<&Texture> {
        self.files[object].roughness.as_ref()
    }

    /// What an object reflects, if a file tells.
    pub fn reflectance(&self, object: usize) -> Option<&ResolvedReflectance> {
        self.files[object].reflectance.as_ref()
    }
}

/// Light from all around, with its map.
#[derive(Debug, Clone)]
pub struct ResolvedEnvironment {
    /// What it looks like.
    pub source: ResolvedSource,
    /// Turns the map from +z towards +x about +y, degrees.
    pub rotation_deg: f64,
    /// Plain factor for maps; the Y of the light for an illuminant.
    pub radiance: f64,
}

/// What an environment looks like.
#[derive(Debug, Clone)]
pub enum ResolvedSource {
    /// A latitude-longitude map.
    Map(Arc<EnvironmentMap>),
    /// The same in every direction.
    Uniform(Illuminant),
    /// A map and a sun in front of it.
    Sky(Arc<EnvironmentMap>, Sun),
}

/// Reads a scene's maps and lets its films flow, or takes from `context` what is there already.
///
/// `watch` hears of two stages: `reading`, in files, and `flowing`, in steps of all films together.
///
/// ```
/// use iridesce_numerics::Watch;
/// use iridesce_scene::{Context, Scene, resolve};
/// let scene = resolve(&Scene::builtin("soap-bubble")?, &Context::default(), &Watch::new())?;
/// assert_eq!(scene.layers(0).len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn resolve(scene: &Scene, context: &Context, watch: &Watch) -> Result<ResolvedScene, ResolveError> {
    context.maps.next_question();
    Reader { scene, context, watch }.read()
}

/// What a scene is read with. Every error is told with its file, its key and its line.
#[derive(Clone, Copy)]
struct Reader<'a> {
    scene: &'a Scene,
    context: &'a Context,
    watch: &'a Watch,
}

impl Reader<'_> {
    fn read(self) -> Result<ResolvedScene, ResolveError> {
        let (scene, watch) = (self.scene, self.watch);
        let files = self.files();
        if files > 0 {
            watch.begin("reading", files as u64);
        }
        let environments = self.environments()?;
        let mut bodies = Bodies::default();
        for object in &scene.objects {
            watch.check()?;
            bodies.read(scene, object, &self.context.maps, watch).map_err(|error| match error {
                ResolveError::Scene(error) => ResolveError::Scene(self.in_file(error)),
                stopped => stopped,
            })?;
        }
        bodies.notes.extend(self.shut_in(&bodies));
        watch.check()?;
        let mut flowing = Flowing::default();
        let mut layers = Vec::new();
        for number in 0..scene.objects.len() {
            layers.push(self.layers(number, &bodies, &mut flowing)?);
        }
        let mut files = Vec::new();
        for (object, mesh) in scene.objects.iter().zip(&bodies.meshes) {
            files.push(read_surface_files(scene, object, mesh.as_deref(), &self.context.maps, watch)?);
        }
        // After all that is quick: a map that cannot be used is told before anything flows.
        self.flow(&bodies, &flowing, &mut layers)?;
        let layers: Vec<Vec<ThicknessField>> =
            layers.into_iter().map(|fields| fields.into_iter().flatten().collect()).collect();
        let on_faces = scene.films_on_faces().into_iter().map(|lies| (lies.body, lies.film)).collect();
        self.check_totals(&layers, &on_faces)?;
        let Bodies { meshes, mut placements, bumps, notes } = bodies;
        for film in on_faces.values() {
            placements[*film] = Arc::new([]);
        }
        let recipe = scene.clone();
        Ok(ResolvedScene { recipe, environments, layers, files, meshes, placements, bumps, on_faces, notes })
    }

    /// Lights of which only files tell that they are shut in.
    fn shut_in(self, bodies: &Bodies) -> Vec<String> {
        let has_file = |object: &Object| {
            matches!(object.shape, Shape::Mesh(_)) || matches!(object.placement.instances, Instances::File(_))
        };
        if !self.scene.objects.iter().any(has_file) {
            return Vec::new();
        }
        let is_closed = |object: usize| match (&self.scene.objects[object].shape, &bodies.meshes[object]) {
            (Shape::Mesh(file), Some(mesh)) => {
                let open = self.context.maps.open_edge(file, self.scene.unit, mesh, self.watch);
                open.is_ok_and(|edge| edge.is_none())
            }
            _ => false,
        };
        let mut notes = shut_in_lights(self.scene, Some(Read { bodies, is_closed: &is_closed }));
        if !notes.is_empty() {
            let told = shut_in_lights(self.scene, None);
            notes.retain(|note| !told.contains(note));
        }
        notes
    }

    fn in_file(self, error: SceneError) -> SceneError {
        error.in_file(self.scene.origin.file.as_deref())
    }

    fn at(self, error: SceneError, key: &str) -> SceneError {
        self.in_file(error.at(key, self.scene.line_of(key)))
    }

    /// How many files the scene names.
    fn files(self) -> usize {
        let objects = &self.scene.objects;
        objects.iter().flat_map(layers_of).filter(|layer| matches!(layer, Thickness::Map { .. })).count()
            + self.scene.lights.iter().filter(|light| light_file(light).is_some()).count()
            + objects.iter().map(|object| surface_files(object).count()).sum::<usize>()
    }

    fn environments(self) -> Result<Vec<ResolvedEnvironment>, ResolveError> {
        let mut environments = Vec::new();
        for (i, light) in self.scene.lights.iter().enumerate() {
            self.watch.check()?;
            let Light::Environment(light) = light else { continue };
            let key = format!("light.{i}.environment");
            let source = match &light.source {
                EnvironmentSource::Map(file) => {
                    let key = format!("{key}.map");
                    let map = self.context.maps.environment(file, self.watch);
                    self.watch.check()?;
                    let map = map.map_err(|e| self.at(e, &key))?;
                    self.watch.add(1);
                    ResolvedSource::Map(map)
                }
                EnvironmentSource::Uniform(illuminant) => ResolvedSource::Uniform(illuminant.clone()),
                EnvironmentSource::Studio => ResolvedSource::Map(studio()),
                EnvironmentSource::Sky => {
                    let wrong = |e: &dyn fmt::Display| self.in_file(SceneError::new(e.to_string()).at(&key, None));
                    let (map, sun) = sky().map_err(|e| wrong(&e))?;
                    ResolvedSource::Sky(map, sun)
                }
            };
            environments.push(ResolvedEnvironment {
                source,
                rotation_deg: light.rotation_deg,
                radiance: light.radiance,
            });
        }
        Ok(environments)
    }

    /// The thicknesses of an object's layers; nothing yet where a film has to flow first, which then stands in `flowing`.
    fn layers(
        self,
        number: usize,
        bodies: &Bodies,
        flowing: &mut Flowing,
    ) -> Result<Vec<Option<ThicknessField>>, ResolveError> {
        let object = &self.scene.objects[number];
        let mut fields = Vec::new();
        for (place, thickness) in layers_of(object).into_iter().enumerate() {
            self.watch.check()?;
            let key = layer_key(object, place);
            let model = match thickness {
                Thickness::Law(field) => {
                    fields.push(Some(field.clone()));
                    continue;
                }
                Thickness::Model(model) => model.clone(),
                Thickness::Vertex => {
                    if let Some(mesh) = &bodies.meshes[number] {
                        fields.push(Some(self.of_vertices(mesh, &key)?));
                    }
                    continue;
                }
                Thickness::Map { file, min_nm, max_nm } => self.map(file, [*min_nm, *max_nm], &key)?,
                Thickness::Swirls { min_nm, max_nm, seed } => {
                    let swirls = self.context.maps.swirls(*min_nm, *max_nm, *seed);
                    ThicknessModel::Map(swirls.map_err(|e| self.at(e, &key))?)
                }
                Thickness::Flow { film, time_s } => match stored(film, *time_s) {
                    Some(field) => ThicknessModel::Flow(field),
                    None => {
                        flowing.wanted.push((film.clone(), *time_s));
                        flowing.places.push((number, place));
                        fields.push(None);
                        continue;
                    }
                },
            };
            fields.push(Some(laid(self.scene, bodies, number, place, model)?));
        }
        Ok(fields)
    }

    fn of_vertices(self, mesh: &Mesh, key: &str) -> Result<ThicknessField, ResolveError> {
        let wrong = |why: &str| self.at(SceneError::new(format!("{key} {why}")), key);
        let field = ThicknessField::of_vertices(mesh).map_err(|why| wrong(&why.to_string()))?;
        if field.max_nm() > MAX_THICKNESS_NM {
            return Err(wrong(&too_thick(field.max_nm())).into());
        }
        Ok(field)
    }

    fn map(
        self,
        file: &MapFile,
        [min_nm, max_nm]: [Option<f64>; 2],
        key: &str,
    ) -> Result<ThicknessModel, ResolveError> {
        let grid = self.context.maps.grid(file, MapOf::Thickness, self.watch);
        self.watch.check()?;
        let grid = grid.map_err(|e| self.at(e, &format!("{key}.map")))?;
        self.watch.add(1);
        let at_end = |e: ThicknessError| {
            let end = format!("{key}.{}", e.argument);
            let line = self.scene.line_of(&end).or(self.scene.line_of(key));
            self.in_file(SceneError::new(format!("{end} {}", e.rule())).at(end, line))
        };
        let map = grid.in_range_watched(min_nm, max_nm, self.watch);
        self.watch.check()?;
        Ok(ThicknessModel::Map(map.map_err(at_end)?))
    }

    /// Lets all films flow that have to, and lays them where they belong.
    fn flow(
        self,
        bodies: &Bodies,
        flowing: &Flowing,
        layers: &mut [Vec<Option<ThicknessField>>],
    ) -> Result<(), ResolveError> {
        let flowed = self.context.films.fields(&flowing.wanted, self.watch).map_err(|(which, error)| {
            let (number, place) = flowing.places[which];
            let key = format!("{}.flow", layer_key(&self.scene.objects[number], place));
            match error {
                FlowError::Stopped => ResolveError::Stopped,
                other => ResolveError::Scene(self.at(SceneError::new(other.to_string()), &key)),
            }
        })?;
        for (field, &(number, place)) in flowed.into_iter().zip(&flowing.places) {
            layers[number][place] = Some(laid(self.scene, bodies, number, place, ThicknessModel::Flow(field))?);
        }
        Ok(())
    }

    fn check_totals(self, layers: &[Vec<ThicknessField>], on_faces: &HashMap<usize, usize>) -> Result<(), SceneError> {
        for (number, (object, fields)) in self.scene.objects.iter().zip(layers).enumerate() {
            let film = on_faces.get(&number).map(|film| &layers[*film]);
            let total_nm: f64 = fields.iter().chain(film.into_iter().flatten()).map(ThicknessField::max_nm).sum();
            if total_nm > MAX_THICKNESS_NM {
                let key = format!("object.{}.surface.coating.layers", object.name);
                let message = format!("{key} must be at most 1e7 nm thick in all, got {total_nm:?}");
                return Err(self.at(SceneError::new(message), &key));
            }
        }
        Ok(())
    }
}

/// Films that have to flow, and where they lie: object and layer.
#[derive(Default)]
struct Flowing {
    wanted: Vec<(FilmRun, f64)>,
    places: Vec<(usize, usize)>,
}

/// A model that took time to make, over the shape of its object.
fn laid(
    scene: &Scene,
    bodies: &Bodies,
    number: usize,
    place: usize,
    model: ThicknessModel,
) -> Result<ThicknessField, SceneError> {
    let object = &scene.objects[number];
    let key = layer_key(object, place);
    let wrong = |why: String| {
        let error = SceneError::new(format!("{key} {why}")).at(&key, scene.line_of(&key));
        error.in_file(scene.origin.file.as_deref())
    };
    let ground = Ground {
        shape: &object.shape,
        mesh: bodies.meshes[number].as_deref(),
        placements: &bodies.placements[number],
        uv: object.uv,
    };
    let field = ThicknessField::over(model, &ground, scene.unit).map_err(wrong)?;
    if field.max_nm() > MAX_THICKNESS_NM {
        return Err(wrong(too_thick(field.max_nm())));
    }
    Ok(field)
}

fn layers_of(object: &Object) -> Vec<&Thickness> {
    match &object.surface {
        Surface::Film(film) => std::iter::once(&film.thickness).chain(&film.inner_thickness).collect(),
        Surface::Coating(coating) => coating.layers.iter().map(|layer| &layer.thickness).collect(),
        Surface::Dielectric(_) | Surface::Metal(_) | Surface::Diffuse(_) | Surface::Emitter(_) => Vec::new(),
    }
}

/// The dotted path of a layer's thickness.
fn layer_key(object: &Object, place: usize) -> String {
    match &object.surface {
        Surface::Coating(_) => format!("object.{}.surface.coating.layers.{place}.thickness_nm", object.name),
        _ if place > 0 => format!("object.{}.surface.film.inner_thickness_nm", object.name),
        _ => format!("object.{}.surface.film.thickness_nm", object.name),
    }
}

fn light_file(light: &Light) -> Option<&MapFile> {
    let Light::Environment(environment) = light else { return None };
    match &environment.source {
        EnvironmentSource::Map(file) => Some(file),
        _ => None,
    }
}
