//! From a validated scene to flat arrays that the integrator walks: nothing here depends on a ray.

use iridesce_numerics::Vec3;
use iridesce_scene::{DeltaKind, Light, ResolvedScene, Texture};

use crate::camera::{Ray, RayCamera};
use crate::enclosing::enclosing_media;
use crate::floors::{Bodies, Floors};
use crate::framebuffer::{RenderError, RenderOptions};
use crate::geometry::{Geometry, Hit};
use crate::integrator::extras::Extras;
use crate::levels::{Lit, Spectra, levels_for, spectra};
use crate::lights::chooser::Extent;
use crate::lights::seeds::Seeds;
use crate::lights::{EmittingObject, EnvironmentLight};
use crate::materials::{CoatedSurface, DiffuseColor, Material, materials, shown_index};
use crate::medium_stack::{Media, MediumStack, SURROUNDING};
use crate::spectral::Probes;
use crate::tiles::Rect;

/// Most films that a straight way to a light crosses. Between two that lie in one place it would go to and fro for ever.
pub const MOST_FILMS: usize = 10_000;

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
    pub floors: Floors,
    /// The picture may end early: the samples of a pixel share branches that hardly count.
    pub is_sparse: bool,
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
    /// Their indices at [`crate::materials::SHOWN_NM`].
    pub shown_indices: Vec<f64>,
    /// What the camera is within.
    camera_media: MediumStack,
    /// Its rays start at different places, which may lie within different media.
    is_camera_wide: bool,
    /// Of the whole picture, in pixels.
    pub size: [u32; 2],
    /// Where mirrors and lenses throw the light of small lamps, if anywhere ([`crate::caustics`]).
    pub seeds: Option<Seeds>,
    /// Nothing is absorbed anywhere: whatever the camera sends out comes to the lights.
    pub is_clear: bool,
    /// Path difference up to which the lights of the scene show fringes of films, nm; beyond it their mean counts.
    pub seen_nm: f64,
    /// The same spectra ever finer: a pixel takes the coarsest that resolves the fringes it shows.
    pub levels: Vec<Spectra>,
}

impl Prepared {
    pub fn new(resolved: &ResolvedScene, options: &RenderOptions) -> Result<Prepared, RenderError> {
        let scene = &resolved.recipe;
        let [width, height] = options.size.unwrap_or(scene.camera.resolution);
        let mut media = Media::new();
        let materials = materials(resolved, &mut media)?;
        let geometry = Geometry::new(resolved);
        let around = EnvironmentLight::new(&resolved.environments, materials.list.iter().any(Material::scatters));
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
        let samples = options.samples.unwrap_or(scene.render.samples);
        let has = |counts: fn(&CoatedSurface) -> bool| {
            materials.list.iter().any(|own| matches!(own, Material::Coating(coating) if counts(coating)))
        };
        let kinds = match (has(|_| true), has(CoatedSurface::is_glass)) {
            (false, _) => Bodies::None,
            (true, false) => Bodies::Other,
            (true, true) => Bodies::Glass,
        };
        Ok(Prepared {
            camera,
            part: options.part([width, height]),
            extras: Extras::count(options.stokes, probes.len()),
            stokes: options.stokes,
            wavelengths: probes.len(),
            has_alpha: !scene.render.has_backdrop,
            samples,
            seed: options.seed.unwrap_or(scene.render.seed),
            max_depth: scene.render.max_depth,
            // (What ends once it has settled has few samples, whatever it may take.)
            floors: Floors::new(if options.settled.is_some() { 1 } else { samples }, kinds),
            is_sparse: options.settled.is_some(),
            camera_media,
            bodies,
            has_priorities: scene.objects.iter().any(|object| object.priority != 0),
            priorities: scene.objects.iter().map(|object| object.priority).collect(),
            is_camera_wide: kinds != Bodies::None && camera.is_wide(),
            geometry,
            expected_shares: (materials.list.iter().map(|own| own.expected_share(&materials.diffuse)))
                .chain([1.0])
                .collect(),
            reflectance_maps: materials.diffuse.iter().map(DiffuseColor::map).collect(),
            is_clear: (materials.list.iter()).all(|own| own.is_clear(&materials.diffuse))
                && levels.iter().all(Spectra::is_clear),
            names: scene.objects.iter().map(|object| object.name.clone()).collect(),
            shown_indices: media.list().iter().map(shown_index).collect::<Result<_, _>>()?,
            media,
            materials: materials.list,
            size: [width, height],
            seeds: None,
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
        self.media_at(ray.origin)
    }

    /// The media around a place.
    pub fn media_at(&self, place: Vec3) -> MediumStack {
        enclosing_media(&self.geometry, &self.bodies, |medium| self.media.priority(medium), place)
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

    /// What a ray from a surface meets next, straight through surfaces that a stronger medium hides; `medium` becomes what
    /// is around it there.
    #[inline(always)]
    pub fn next_that_is_there(&self, from: &Hit, direction: Vec3, medium: &mut MediumStack) -> Option<Hit> {
        let mut next = self.geometry.nearest(&Ray { origin: from.point, direction }, Some(from));
        if self.has_priorities {
            let mut crossed = 0;
            while crossed < MOST_FILMS
                && let Some(hit) = next
                && let Some(behind) = self.behind_hidden(&hit, direction, *medium)
            {
                crossed += 1;
                *medium = behind;
                next = self.geometry.nearest(&Ray { origin: hit.point, direction }, Some(&hit));
                // As far as from the surface.
                next = next.map(|beyond| Hit { distance: beyond.distance + hit.distance, ..beyond });
            }
        }
        next
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
