//! From a validated scene to flat arrays that the integrator walks: nothing here depends on a ray.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::color::{Illuminant, rgb_basis};
use iridesce_optics::{Medium, OpticsError};
use iridesce_scene::{
    DeltaKind, Light, Place, Reflectance, ResolvedReflectance, ResolvedScene, ResolvedSource, Shape, Surface, Texture,
    ThicknessField, Unit, held,
};

use crate::camera::{Ray, RayCamera};
use crate::coating::IndexTable;
use crate::coherence::{LEAST_SEEN_NM, longest_seen_nm};
use crate::enclosing::enclosing_media;
use crate::film::FilmTable;
use crate::framebuffer::{RenderError, RenderOptions};
use crate::geometry::{Geometry, Hit};
use crate::integrator::extras::Extras;
use crate::lights::chooser::Extent;
use crate::lights::{EmittingObject, EnvironmentLight, Lights};
use crate::medium_stack::{Media, MediumStack, SURROUNDING, indices, visible};
use crate::rough::RoughSurface;
use crate::spectral::{Bands, FROM_NM, LEAST_NODES, MAX_NODES, Nodes, Probes, TO_NM, node_count, resolved_nm};
use crate::tiles::Rect;

/// Where the path difference of the film that a pixel shows is told, nm: the middle of what eyes see.
pub const SHOWN_NM: f64 = 560.0;

/// So many rays across and down the picture tell where lights are compared.
const PLACES: u32 = 8;

/// A scene ready to render.
pub struct Prepared {
    pub camera: RayCamera,
    /// The part of the picture that is drawn.
    pub part: Rect,
    /// How many numbers a pixel has beside X, Y, Z.
    pub extras: usize,
    /// Whether Stokes vectors are among them, and how many wavelengths.
    pub stokes: bool,
    pub wavelengths: usize,
    /// The picture has a plane of what its backdrop would shine through.
    pub has_alpha: bool,
    pub samples: u32,
    pub seed: u64,
    pub max_depth: u32,
    pub geometry: Geometry,
    /// Of object i at index i.
    pub materials: Vec<Material>,
    /// What share of the mean light is expected from each object; the last is what lies beyond them all.
    pub expected_shares: Vec<f32>,
    /// Of the diffuse surfaces that a picture is laid over.
    reflectance_maps: Vec<Option<Texture>>,
    /// Some media are stronger than others.
    pub has_priorities: bool,
    /// Of the objects.
    priorities: Vec<i32>,
    /// The media behind the shapes.
    bodies: Vec<Option<u8>>,
    /// Names of objects, for messages.
    pub names: Vec<String>,
    pub media: Media,
    /// Their indices at [`SHOWN_NM`].
    pub shown_indices: Vec<f64>,
    /// What the camera is within.
    camera_media: MediumStack,
    /// Its rays start at different places, which may lie within different media.
    is_camera_wide: bool,
    /// Path difference up to which the lights of the scene show fringes of films, nm; beyond it their mean counts.
    pub seen_nm: f64,
    /// The same spectra ever finer: a pixel takes the coarsest that resolves the fringes it shows.
    pub levels: Vec<Spectra>,
}

/// What a surface does to light.
#[expect(clippy::large_enum_variant, reason = "one an object, not one a hit: a box would only be in the way")]
pub enum Material {
    Film(FilmSurface),
    Coating(CoatedSurface),
    /// Number among the reflectances.
    Diffuse {
        number: usize,
        is_black: bool,
    },
    /// Number among the emitters.
    Emitter(usize),
}

/// A layer whose thickness is known at every point.
pub struct LayerSurface {
    thickness: ThicknessField,
    /// Of walls between bubbles, if that is another.
    inner: Option<ThicknessField>,
    is_on_mesh: bool,
    /// A point of the world alone does not tell it.
    needs_place: bool,
    /// Largest 2 n over the visible range: optical path difference per thickness.
    path_per_nm: f64,
    /// n at [`SHOWN_NM`].
    pub shown_index: f64,
}

impl LayerSurface {
    /// Thickness in nm where a ray has met the object.
    #[inline(always)]
    pub fn thickness_nm(&self, geometry: &Geometry, hit: &Hit) -> f64 {
        if self.needs_place {
            return self.thickness_by_place(geometry, hit);
        }
        self.thickness.thickness_nm([hit.point.x, hit.point.y, hit.point.z])
    }

    #[inline(never)]
    fn thickness_by_place(&self, geometry: &Geometry, hit: &Hit) -> f64 {
        let field = self.inner.as_ref().filter(|_| geometry.is_inner(hit)).unwrap_or(&self.thickness);
        if !field.needs_place() {
            return field.thickness_nm(hit.point.to_array());
        }
        let met = geometry.interaction(hit);
        let place = Place {
            point: hit.point.to_array(),
            local: met.local.to_array(),
            uv: [met.u, met.v],
            instance: met.instance as usize,
            vertex_nm: met.thickness_nm,
        };
        field.thickness_at(&place, self.is_on_mesh)
    }

    /// Optical path difference in nm that a thickness makes, at most.
    #[inline(always)]
    pub fn path_nm(&self, thickness_nm: f64) -> f64 {
        self.path_per_nm * thickness_nm
    }

    fn new(thickness: &ThicknessField, medium: &Medium, shape: &Shape) -> Result<LayerSurface, OpticsError> {
        let most = indices(medium, visible())?.iter().fold(0.0_f64, |most, n| most.max(n.re));
        Ok(LayerSurface {
            thickness: thickness.clone(),
            inner: None,
            is_on_mesh: matches!(shape, Shape::Mesh(_)),
            needs_place: thickness.needs_place(),
            path_per_nm: 2.0 * most,
            shown_index: shown_index(medium)?,
        })
    }

    fn longest_path_nm(&self) -> f64 {
        let inner = self.inner.as_ref().map_or(0.0, ThicknessField::max_nm);
        self.path_nm(self.thickness.max_nm().max(inner))
    }
}

/// A free film on an object.
pub struct FilmSurface {
    /// Number among the film tables.
    pub number: usize,
    pub layer: LayerSurface,
    /// The medium on both sides.
    pub outside: u8,
    /// `None`: a mirror.
    pub rough: Option<RoughSurface>,
}

/// A coated, or bare, surface of a medium.
pub struct CoatedSurface {
    /// Number among the coatings.
    pub number: usize,
    pub layers: Vec<LayerSurface>,
    pub substrate: u8,
    /// What enters the substrate is absorbed.
    pub is_opaque: bool,
    /// `None`: a mirror.
    pub rough: Option<RoughSurface>,
}

impl Material {
    /// The medium that fills the space behind.
    fn body(&self) -> Option<u8> {
        match self {
            Material::Coating(coating) => Some(coating.substrate),
            Material::Film(_) | Material::Diffuse { .. } | Material::Emitter(_) => None,
        }
    }

    /// What share of the scene's mean light is expected from a surface: the estimate against which choices are made.
    /// Any would do, the better it is the less noise they make.
    fn expected_share(&self, reflectances: &[DiffuseColor<'_>]) -> f32 {
        match self {
            Material::Diffuse { number, .. } => reflectances[*number].mean() as f32,
            Material::Coating(coating) if coating.is_opaque => 0.5,
            Material::Emitter(_) => 0.0,
            Material::Film(_) | Material::Coating(_) => 1.0,
        }
    }

    fn longest_path_nm(&self) -> f64 {
        match self {
            Material::Film(film) => film.layer.longest_path_nm(),
            Material::Coating(coating) => coating.layers.iter().map(LayerSurface::longest_path_nm).sum(),
            Material::Diffuse { .. } | Material::Emitter(_) => 0.0,
        }
    }
}

/// Everything that depends on wavelength, at one choice of nodes.
pub struct Spectra {
    pub nodes: Nodes,
    /// Longest optical path difference whose fringes the nodes resolve, nm.
    pub resolved_nm: f64,
    /// 2 / lambda, per nm.
    pub rate: Vec<Lanes>,
    pub films: Vec<FilmTable>,
    /// Layers of the coatings, in order.
    pub coatings: Vec<Vec<IndexTable>>,
    pub media: Vec<IndexTable>,
    /// By what the media attenuate: powers of 1/2 per scene unit. `None` for clear ones.
    pub attenuation: Vec<Option<Vec<Lanes>>>,
    /// Reflectances of the diffuse surfaces.
    pub diffuse: Vec<Vec<Lanes>>,
    /// Reflectance of red, green and blue.
    pub rgb_basis: [Vec<Lanes>; 3],
    pub lights: Lights,
    /// Luminance of a path's s and p weights; sums to 1/2.
    pub importance: Vec<Lanes>,
    pub bands: Bands,
}

/// What the objects are made of, in the order of their numbers.
#[derive(Default)]
struct Materials<'a> {
    list: Vec<Material>,
    films: Vec<(&'a Medium, u8)>,
    coatings: Vec<Vec<&'a Medium>>,
    diffuse: Vec<DiffuseColor<'a>>,
    emitters: Vec<(usize, &'a iridesce_scene::Emitter)>,
}

/// What a diffuse surface reflects.
enum DiffuseColor<'a> {
    Rgb([f64; 3]),
    Map(&'a Texture),
    Spectrum(&'a [(f64, f64)]),
}

impl DiffuseColor<'_> {
    /// At a wavelength in nm; of a picture, in the mean.
    fn at(&self, nm: f64) -> f64 {
        let of = |rgb: [f64; 3]| rgb_basis(nm).iter().zip(rgb).map(|(f, v)| f * v).sum();
        match self {
            DiffuseColor::Rgb(rgb) => of(*rgb),
            DiffuseColor::Map(texture) => of(texture.mean()),
            DiffuseColor::Spectrum(table) => held(table, nm),
        }
    }

    fn map(&self) -> Option<Texture> {
        match self {
            DiffuseColor::Map(texture) => Some((*texture).clone()),
            _ => None,
        }
    }

    fn mean(&self) -> f64 {
        match self {
            DiffuseColor::Rgb(rgb) => rgb.iter().sum::<f64>() / 3.0,
            DiffuseColor::Map(texture) => texture.mean().iter().sum::<f64>() / 3.0,
            DiffuseColor::Spectrum(table) => held(table, 560.0),
        }
    }
}

impl Prepared {
    pub fn new(resolved: &ResolvedScene, options: &RenderOptions) -> Result<Prepared, RenderError> {
        let scene = &resolved.recipe;
        let [width, height] = options.size.unwrap_or(scene.camera.resolution);
        let mut media = Media::new();
        let materials = materials(resolved, &mut media)?;
        let geometry = Geometry::new(resolved);
        let around = EnvironmentLight::new(&resolved.environments, !materials.diffuse.is_empty());
        let camera = RayCamera::new(&scene.camera, width, height);
        let bodies: Vec<Option<u8>> = materials.list.iter().map(Material::body).collect();
        check_lights(resolved, &media, |place| {
            enclosing_media(&geometry, &bodies, |medium| media.priority(medium), place)
        })?;
        let lit = Lit {
            around,
            emitters: (materials.emitters.iter())
                .map(|&(object, emitter)| EmittingObject {
                    object,
                    emitter,
                    extent: match geometry.simple_shape(object) {
                        Some(shape) => Extent::of(shape),
                        None => geometry.spread(object).map(Extent::around),
                    },
                })
                .collect(),
            places: places(&camera, [width, height], scene.camera.target.into(), |ray| geometry.nearest(ray, None)),
        };
        let mut levels = Vec::new();
        let probes = Probes::new(&options.spectral_nm);
        let rows = if options.stokes { 4 } else { 1 };
        let (seen_nm, choices) = levels_for(resolved, &materials)?;
        for nodes in choices {
            let nodes = nodes.with_extras(&probes, rows);
            let mut level = spectra(resolved, &nodes, &media, &materials, &lit)?;
            if options.stokes {
                level.lights.polarize(camera.passes());
            }
            levels.push(level);
        }
        if let Some(finest) = levels.last_mut() {
            finest.resolved_nm = f64::INFINITY;
        }
        let camera_media =
            enclosing_media(&geometry, &bodies, |medium| media.priority(medium), scene.camera.position.into());
        let has_media = materials.list.iter().any(|material| matches!(material, Material::Coating(_)));
        Ok(Prepared {
            camera,
            part: options.part([width, height]),
            extras: Extras::count(options.stokes, probes.len()),
            stokes: options.stokes,
            wavelengths: probes.len(),
            has_alpha: !scene.render.has_backdrop,
            samples: options.samples.unwrap_or(scene.render.samples),
            seed: options.seed.unwrap_or(scene.render.seed),
            max_depth: scene.render.max_depth,
            camera_media,
            bodies,
            has_priorities: scene.objects.iter().any(|object| object.priority != 0),
            priorities: scene.objects.iter().map(|object| object.priority).collect(),
            is_camera_wide: has_media && camera.is_wide(),
            geometry,
            expected_shares: (materials.list.iter().map(|own| own.expected_share(&materials.diffuse)))
                .chain([1.0])
                .collect(),
            reflectance_maps: materials.diffuse.iter().map(DiffuseColor::map).collect(),
            names: scene.objects.iter().map(|object| object.name.clone()).collect(),
            shown_indices: media.list().iter().map(shown_index).collect::<Result<_, _>>()?,
            media,
            materials: materials.list,
            seen_nm,
            levels,
        })
    }
}

impl Prepared {
    /// The media that a camera ray starts in.
    #[inline(always)]
    pub fn enclosing_media(&self, ray: &Ray) -> MediumStack {
        if !self.is_camera_wide {
            return self.camera_media;
        }
        enclosing_media(&self.geometry, &self.bodies, |medium| self.media.priority(medium), ray.origin)
    }

    /// Linear Rec.709 of a diffuse surface where a ray has met it, if a picture is laid over it.
    #[inline(always)]
    pub fn reflectance_at(&self, number: usize, hit: &Hit) -> Option<[f64; 3]> {
        let map = self.reflectance_maps[number].as_ref()?;
        if map.needs_place() {
            let met = self.geometry.interaction(hit);
            return Some(map.at_uv([met.u, met.v]));
        }
        Some(map.at(hit.point.to_array()))
    }

    /// What a path is within behind a surface that is not there, since a stronger medium rules; `None` where it is there.
    #[inline(never)]
    pub fn behind_hidden(&self, hit: &Hit, direction: Vec3, medium: MediumStack) -> Option<MediumStack> {
        let ruling = medium.innermost();
        match self.materials.get(hit.object)? {
            Material::Coating(coating) => {
                let enters = direction.dot(hit.normal) < 0.0;
                medium.behind_hidden(coating.substrate, enters, |number| self.media.priority(number))
            }
            // A film that pokes out of a stronger body is not in it.
            Material::Film(film) => {
                let is_weaker = self.priorities[hit.object] < self.media.priority(ruling);
                (is_weaker && medium != MediumStack::default() && !self.media.are_one(ruling, film.outside))
                    .then_some(medium)
            }
            Material::Diffuse { .. } | Material::Emitter(_) => None,
        }
    }
}

/// What of the light is the same whatever the nodes are.
struct Lit<'a> {
    around: EnvironmentLight,
    /// In the order of their numbers.
    emitters: Vec<EmittingObject<'a>>,
    /// Places of the scene that the picture shows, where lights are compared.
    places: Vec<Vec3>,
}

/// What some rays all over the picture meet; the camera's target where none meets anything.
fn places(
    camera: &RayCamera,
    [width, height]: [u32; 2],
    target: Vec3,
    nearest: impl Fn(&Ray) -> Option<Hit>,
) -> Vec<Vec3> {
    let mut places = Vec::new();
    for i in 0..PLACES * PLACES {
        let [x, y] = [i % PLACES, i / PLACES].map(|k| (f64::from(k) + 0.5) / f64::from(PLACES));
        places.extend(nearest(&camera.ray(x * f64::from(width), y * f64::from(height))).map(|hit| hit.point));
    }
    if places.is_empty() {
        places.push(target);
    }
    places
}

/// Lights without size within a medium that bends light: what leaves it cannot be found, so they are refused.
fn check_lights(
    scene: &ResolvedScene,
    media: &Media,
    enclosing: impl Fn(Vec3) -> MediumStack,
) -> Result<(), RenderError> {
    for (i, light) in scene.recipe.lights.iter().enumerate() {
        let Light::Delta(delta) = light else { continue };
        let Some(position) = delta.kind.position() else { continue };
        let within = enclosing(position.into()).innermost();
        if within != SURROUNDING {
            let kind = if matches!(delta.kind, DeltaKind::Spot { .. }) { "spot" } else { "point" };
            let key = format!("light.{i}.{kind}.position");
            return Err(RenderError::Scene {
                message: format!(
                    "{key} lies within {}, whose surface bends what leaves it: nothing finds a light without size there, got {position:?}; use \
                     an object with the surface emitter, or a place outside",
                    media.name(within)
                ),
                key,
            });
        }
    }
    Ok(())
}

fn materials<'a>(scene: &'a ResolvedScene, media: &mut Media) -> Result<Materials<'a>, RenderError> {
    let mut all = Materials::default();
    for (object, described) in scene.recipe.objects.iter().enumerate() {
        let thicknesses = scene.layers(object);
        let rough = RoughSurface::new(scene.roughness(object), described);
        let mut coated = |layers: Vec<LayerSurface>, of: Vec<&'a Medium>, substrate: &Medium, is_metal, rough| {
            let substrate = number_of(media, substrate, described.priority)?;
            all.coatings.push(of);
            Ok::<_, RenderError>(Material::Coating(CoatedSurface {
                number: all.coatings.len() - 1,
                layers,
                substrate,
                is_opaque: is_metal || media.is_opaque(substrate),
                rough,
            }))
        };
        let material = match &described.surface {
            Surface::Film(film) => {
                let outside = number_of(media, &film.outside, 0)?;
                all.films.push((&film.medium, outside));
                Material::Film(FilmSurface {
                    number: all.films.len() - 1,
                    layer: film_layer(thicknesses, &film.medium, &described.shape)?,
                    outside,
                    rough,
                })
            }
            Surface::Coating(coating) => {
                let layers = coating
                    .layers
                    .iter()
                    .zip(thicknesses)
                    .map(|(layer, thickness)| LayerSurface::new(thickness, &layer.medium, &described.shape))
                    .collect::<Result<_, _>>()?;
                let of = coating.layers.iter().map(|layer| &layer.medium).collect();
                coated(layers, of, &coating.substrate, false, rough)?
            }
            Surface::Dielectric(medium) => coated(Vec::new(), Vec::new(), medium, false, rough)?,
            Surface::Metal(medium) => coated(Vec::new(), Vec::new(), medium, true, rough)?,
            Surface::Diffuse(reflectance) => {
                let color = match (reflectance, scene.reflectance(object)) {
                    (_, Some(ResolvedReflectance::Map(texture))) => DiffuseColor::Map(texture),
                    (_, Some(ResolvedReflectance::Spectrum(table))) => DiffuseColor::Spectrum(table),
                    (Reflectance::Rgb(rgb), None) => DiffuseColor::Rgb(*rgb),
                    _ => unreachable!("a scene is resolved with its files"),
                };
                all.diffuse.push(color);
                Material::Diffuse {
                    number: all.diffuse.len() - 1,
                    is_black: matches!(reflectance, Reflectance::Rgb([0.0, 0.0, 0.0])),
                }
            }
            Surface::Emitter(emitter) => {
                all.emitters.push((object, emitter));
                Material::Emitter(all.emitters.len() - 1)
            }
        };
        all.list.push(material);
    }
    Ok(all)
}

fn shown_index(medium: &Medium) -> Result<f64, OpticsError> {
    Ok(indices(medium, std::iter::once(SHOWN_NM))?[0].re)
}

/// The layer of a free film; of bubbles with walls of their own.
fn film_layer(thicknesses: &[ThicknessField], medium: &Medium, shape: &Shape) -> Result<LayerSurface, OpticsError> {
    let mut layer = LayerSurface::new(&thicknesses[0], medium, shape)?;
    layer.inner = thicknesses.get(1).cloned();
    layer.needs_place |= layer.inner.is_some();
    Ok(layer)
}

fn number_of(media: &mut Media, medium: &Medium, priority: i32) -> Result<u8, RenderError> {
    media.number(medium, priority)?.ok_or_else(|| {
        RenderError::Resource(format!(
            "the scene fills space with more than 255 different media, one of them \"{}\"",
            medium.name()
        ))
    })
}

/// Up to which path difference fringes of films are seen, nm, and the choices of nodes, ever finer, until those of the
/// thickest layer are resolved.
fn levels_for(scene: &ResolvedScene, materials: &Materials<'_>) -> Result<(f64, Vec<Nodes>), RenderError> {
    let mut lines = Vec::new();
    let mut continuous = Vec::new();
    // What shines through is told of white light.
    let is_continuous = !scene.recipe.render.has_backdrop;
    let mut see = |illuminant: &Illuminant, radiance: f64| {
        if radiance > 0.0 {
            lines.extend(illuminant.lines().iter().map(|line| line.0));
            if (FROM_NM as u32..=TO_NM as u32).any(|nm| illuminant.power(f64::from(nm)) > 0.0) {
                continuous.push(illuminant.clone());
            }
        }
    };
    let mut has_map = false;
    for environment in &scene.environments {
        match &environment.source {
            ResolvedSource::Uniform(illuminant) => see(illuminant, environment.radiance),
            ResolvedSource::Map(_) | ResolvedSource::Sky(..) => has_map = true,
        }
    }
    for light in &scene.recipe.lights {
        match light {
            Light::Environment(_) => {}
            Light::Sun(sun) => see(&sun.illuminant, sun.radiance),
            Light::Delta(delta) => see(&delta.illuminant, delta.power),
        }
    }
    for (_, emitter) in &materials.emitters {
        see(&emitter.illuminant, emitter.radiance);
    }
    // Under lines alone nothing between them is seen, however fine the fringes are.
    if continuous.is_empty() && !(is_continuous || has_map || lines.is_empty()) {
        return Ok((f64::INFINITY, vec![Nodes::new(0, &lines)]));
    }
    let is_film = |material: &&Material| matches!(material, Material::Film(_));
    let thickest = materials.list.iter().filter(is_film).map(Material::longest_path_nm).fold(0.0, f64::max);
    let mut seen_nm = f64::INFINITY;
    if thickest > LEAST_SEEN_NM {
        continuous.push(Illuminant::named("D65")?);
        seen_nm = longest_seen_nm(&continuous);
    }
    let mut longest_nm = 0.0_f64;
    for (object, material) in scene.recipe.objects.iter().zip(&materials.list) {
        let own_nm = material.longest_path_nm();
        let path_nm = if is_film(&material) { own_nm.min(seen_nm) } else { own_nm };
        let wanted = node_count(path_nm);
        if wanted > MAX_NODES {
            return Err(RenderError::Resource(format!(
                "the layers of object \"{}\" make optical path differences up to {path_nm:.0} nm; under a continuous spectrum a render resolves the \
                 fringes of at most {:.0} nm",
                object.name,
                resolved_nm(MAX_NODES)
            )));
        }
        longest_nm = longest_nm.max(path_nm);
    }
    let finest = node_count(longest_nm);
    let mut counts = vec![LEAST_NODES];
    while counts[counts.len() - 1] < finest {
        // 32, 48, 64, 96, 128, ..
        let last = counts[counts.len() - 1];
        counts.push(if last.is_power_of_two() { last / 2 * 3 } else { last / 3 * 4 });
    }
    Ok((seen_nm, counts.into_iter().map(|count| Nodes::new(count, &lines)).collect()))
}

fn spectra(
    scene: &ResolvedScene,
    nodes: &Nodes,
    media: &Media,
    materials: &Materials<'_>,
    lit: &Lit<'_>,
) -> Result<Spectra, OpticsError> {
    let at_nodes = |medium: &Medium| indices(medium, nodes.wavelength_nm.iter().copied());
    let mut films = Vec::new();
    for (medium, outside) in &materials.films {
        let outer: Vec<f64> = at_nodes(&media.list()[usize::from(*outside)])?.iter().map(|n| n.re).collect();
        films.push(FilmTable::new(nodes, &at_nodes(medium)?, &outer));
    }
    let table = |medium: &Medium| at_nodes(medium).map(|n| IndexTable::new(&n));
    let mut coatings = Vec::new();
    for layers in &materials.coatings {
        coatings.push(layers.iter().map(|medium| table(medium)).collect::<Result<Vec<_>, _>>()?);
    }
    let nm_per_unit = match scene.recipe.unit {
        Unit::M => 1e9,
        Unit::Cm => 1e7,
        Unit::Mm => 1e6,
    };
    let mut attenuation = Vec::new();
    for medium in media.list() {
        let n = at_nodes(medium)?;
        // exp(-4 pi k x / lambda) as a power of 1/2.
        let per_unit = n
            .iter()
            .zip(&nodes.wavelength_nm)
            .map(|(n, nm)| 4.0 * std::f64::consts::PI * n.im / nm * nm_per_unit * std::f64::consts::LOG2_E);
        attenuation.push(n.iter().any(|n| n.im > 0.0).then(|| blocks(per_unit)));
    }
    let diffuse = materials.diffuse.iter().map(|color| blocks(nodes.wavelength_nm.iter().map(|&nm| color.at(nm))));
    let basis = |channel: usize| blocks(nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[channel]));
    let lights = Lights::new(scene, nodes, &lit.around, &lit.emitters)?;
    let importance = lights.importance(&lit.places);
    Ok(Spectra {
        nodes: nodes.clone(),
        resolved_nm: resolved_nm(nodes.uniform()),
        rate: blocks(nodes.wavelength_nm.iter().map(|nm| 2.0 / nm)),
        films,
        coatings,
        media: media.list().iter().map(table).collect::<Result<_, _>>()?,
        attenuation,
        diffuse: diffuse.collect(),
        rgb_basis: [basis(0), basis(1), basis(2)],
        bands: Bands::new(nodes, &lights.color_importance(&lit.places)),
        importance,
        lights,
    })
}
