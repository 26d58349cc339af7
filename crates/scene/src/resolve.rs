//! From the recipe to a scene that can be looked at: maps are read, films flow. The one step of this crate that takes time.

use std::fmt;
use std::sync::Arc;

use iridesce_files::EnvironmentMap;
use iridesce_flow::{FilmRun, Films, FlowError};
use iridesce_numerics::{Stopped, Watch};
use iridesce_optics::color::Illuminant;
use iridesce_thickness::{FlowField, ThicknessError, ThicknessModel};

use crate::error::SceneError;
use crate::field::ThicknessField;
use crate::files::Maps;
use crate::films::stored;
use crate::model::{EnvironmentSource, Light, MapFile, Object, Reflectance, Roughness, Scene, Sun, Surface, Thickness};
use crate::schema::MAX_THICKNESS_NM;
use crate::sky::sky;
use crate::studio::studio;
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

impl Context {
    /// The films, to keep their states or to let them go on elsewhere.
    pub fn films(&self) -> &Films {
        &self.films
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
}

/// What the files of a surface say, where it has any.
#[derive(Debug, Clone, Default)]
struct SurfaceFiles {
    roughness: Option<Texture>,
    reflectance: Option<ResolvedReflectance>,
}

impl ResolvedScene {
    /// The thicknesses of an object's layers, from outside inwards: one of a film, any number of a coating, none of
    /// other surfaces.
    pub fn layers(&self, object: usize) -> &[ThicknessField] {
        &self.layers[object]
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

/// Why a scene was not resolved.
#[derive(Debug, Clone, PartialEq)]
pub enum ResolveError {
    /// Whoever watches said so.
    Stopped,
    /// A map cannot be used, or a film does not flow.
    Scene(SceneError),
}

impl fmt::Display for ResolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ResolveError::Stopped => Stopped.fmt(f),
            ResolveError::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ResolveError {}

impl From<SceneError> for ResolveError {
    fn from(error: SceneError) -> ResolveError {
        ResolveError::Scene(error)
    }
}

impl From<Stopped> for ResolveError {
    fn from(_: Stopped) -> ResolveError {
        ResolveError::Stopped
    }
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
    let in_file = |error: SceneError| error.in_file(scene.origin.file.as_deref());
    let files = scene.objects.iter().flat_map(layers_of).filter(|layer| matches!(layer, Thickness::Map { .. })).count()
        + scene.lights.iter().filter(|light| light_file(light).is_some()).count()
        + scene.objects.iter().map(|object| surface_files(object).count()).sum::<usize>();
    if files > 0 {
        watch.begin("reading", files as u64);
    }
    let mut environments = Vec::new();
    for (i, light) in scene.lights.iter().enumerate() {
        watch.check()?;
        let Light::Environment(light) = light else { continue };
        let key = format!("light.{i}.environment");
        let source = match &light.source {
            EnvironmentSource::Map(file) => {
                let key = format!("{key}.map");
                let map = context.maps.environment(file, watch);
                watch.check()?;
                let map = map.map_err(|e| in_file(e.at(&key, scene.line_of(&key))))?;
                watch.add(1);
                ResolvedSource::Map(map)
            }
            EnvironmentSource::Uniform(illuminant) => ResolvedSource::Uniform(illuminant.clone()),
            EnvironmentSource::Studio => ResolvedSource::Map(studio()),
            EnvironmentSource::Sky => {
                let wrong = |e: &dyn fmt::Display| in_file(SceneError::new(e.to_string()).at(&key, None));
                let (map, sun) = sky().map_err(|e| wrong(&e))?;
                ResolvedSource::Sky(map, sun)
            }
        };
        environments.push(ResolvedEnvironment { source, rotation_deg: light.rotation_deg, radiance: light.radiance });
    }
    let mut layers = Vec::new();
    let mut flowing = Flowing::default();
    for (number, object) in scene.objects.iter().enumerate() {
        let mut fields = Vec::new();
        for (place, thickness) in layers_of(object).iter().enumerate() {
            watch.check()?;
            let key = layer_key(object, place);
            let at = |e: SceneError, key: &str| in_file(e.at(key, scene.line_of(key)));
            let model = match thickness {
                Thickness::Law(field) => {
                    fields.push(Some(field.clone()));
                    continue;
                }
                Thickness::Map { file, min_nm, max_nm } => {
                    let map_key = format!("{key}.map");
                    let grid = context.maps.thickness(file, watch);
                    watch.check()?;
                    let grid = grid.map_err(|e| at(e, &map_key))?;
                    watch.add(1);
                    let at_end = |e: ThicknessError| {
                        let end = format!("{key}.{}", e.key);
                        let line = scene.line_of(&end).or(scene.line_of(&key));
                        in_file(SceneError::new(format!("{end} {}", e.message)).at(end, line))
                    };
                    ThicknessModel::Map(grid.in_range(*min_nm, *max_nm).map_err(at_end)?)
                }
                Thickness::Swirls { min_nm, max_nm, seed } => {
                    let swirls = context.maps.swirls(*min_nm, *max_nm, *seed);
                    ThicknessModel::Map(swirls.map_err(|e| at(e, &key))?)
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
            fields.push(Some(laid(scene, number, place, model)?));
        }
        layers.push(fields);
    }
    let mut files = Vec::new();
    for object in &scene.objects {
        files.push(read_surface_files(scene, object, context, watch)?);
    }
    // After all that is quick: a map that cannot be used is told before anything flows.
    let flowed = context.films.fields(&flowing.wanted, watch).map_err(|(which, error)| {
        let (number, place) = flowing.places[which];
        let key = format!("{}.flow", layer_key(&scene.objects[number], place));
        match error {
            FlowError::Stopped => ResolveError::Stopped,
            other => ResolveError::Scene(in_file(SceneError::new(other.to_string()).at(&key, scene.line_of(&key)))),
        }
    })?;
    for (field, &(number, place)) in flowed.into_iter().zip(&flowing.places) {
        layers[number][place] = Some(laid(scene, number, place, ThicknessModel::Flow(field))?);
    }
    let layers: Vec<Vec<ThicknessField>> =
        layers.into_iter().map(|fields| fields.into_iter().flatten().collect()).collect();
    for (object, fields) in scene.objects.iter().zip(&layers) {
        let total_nm: f64 = fields.iter().map(ThicknessField::max_nm).sum();
        if total_nm > MAX_THICKNESS_NM {
            let key = format!("object.{}.surface.coating.layers", object.name);
            let message = format!("{key} must be at most 1e7 nm thick in all, got {total_nm:?}");
            return Err(in_file(SceneError::new(message).at(&key, scene.line_of(&key))).into());
        }
    }
    Ok(ResolvedScene { recipe: scene.clone(), environments, layers, files })
}

/// What stands in files of an object's surface, thicknesses aside.
fn surface_files(object: &Object) -> impl Iterator<Item = &MapFile> {
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

fn read_surface_files(
    scene: &Scene,
    object: &Object,
    context: &Context,
    watch: &Watch,
) -> Result<SurfaceFiles, ResolveError> {
    let mut files = SurfaceFiles::default();
    let at = |error: SceneError, key: &str| {
        let key = format!("object.{}.surface.{key}", object.name);
        error.at(&key, scene.line_of(&key)).in_file(scene.origin.file.as_deref())
    };
    if let Roughness::Map { file, min, max } = &object.roughness {
        let planes = context.maps.roughness(file, *min, *max, watch);
        watch.check()?;
        let kind = object.surface.kind();
        let planes = planes.map_err(|e| at(e, &format!("{kind}.roughness.map")))?;
        watch.add(1);
        files.roughness = Some(Texture::new(planes, &object.shape));
    }
    match &object.surface {
        Surface::Diffuse(Reflectance::Map(file)) => {
            let planes = context.maps.reflectance(file, watch);
            watch.check()?;
            let planes = planes.map_err(|e| at(e, "diffuse.reflectance.map"))?;
            watch.add(1);
            files.reflectance = Some(ResolvedReflectance::Map(Texture::new(planes, &object.shape)));
        }
        Surface::Diffuse(Reflectance::Spectrum(file)) => {
            let table = context.maps.spectrum(file, watch);
            watch.check()?;
            let table = table.map_err(|e| at(e, "diffuse.reflectance.spectrum"))?;
            watch.add(1);
            files.reflectance = Some(ResolvedReflectance::Spectrum(table));
        }
        _ => {}
    }
    Ok(files)
}

/// Films that have to flow, and where they lie: object and layer.
#[derive(Default)]
struct Flowing {
    wanted: Vec<(FilmRun, f64)>,
    places: Vec<(usize, usize)>,
}

/// A model that took time to make, over the shape of its object.
fn laid(scene: &Scene, number: usize, place: usize, model: ThicknessModel) -> Result<ThicknessField, SceneError> {
    let object = &scene.objects[number];
    let key = layer_key(object, place);
    let wrong = |why: String| {
        let error = SceneError::new(format!("{key} {why}")).at(&key, scene.line_of(&key));
        error.in_file(scene.origin.file.as_deref())
    };
    let field = ThicknessField::new(model, &object.shape, scene.unit).map_err(wrong)?;
    if field.max_nm() > MAX_THICKNESS_NM {
        return Err(wrong(too_thick(field.max_nm())));
    }
    Ok(field)
}

fn layers_of(object: &Object) -> Vec<&Thickness> {
    match &object.surface {
        Surface::Film(film) => vec![&film.thickness],
        Surface::Coating(coating) => coating.layers.iter().map(|layer| &layer.thickness).collect(),
        Surface::Dielectric(_) | Surface::Metal(_) | Surface::Diffuse(_) | Surface::Emitter(_) => Vec::new(),
    }
}

/// The dotted path of a layer's thickness.
fn layer_key(object: &Object, place: usize) -> String {
    match &object.surface {
        Surface::Coating(_) => format!("object.{}.surface.coating.layers.{place}.thickness_nm", object.name),
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
