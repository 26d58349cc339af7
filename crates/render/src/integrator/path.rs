//! A path on its way from the camera, and what becomes of a branch of it.

use iridesce_numerics::Vec3;

use super::Tracer;
use crate::camera::Ray;
use crate::chain::Chain;
use crate::geometry::Hit;
use crate::materials::Material;
use crate::medium_stack::MediumStack;

/// A path that is about to meet a surface; its spectra stand in the arena under `slot`.
#[derive(Clone, Copy)]
pub(super) struct Path {
    pub(super) direction: Vec3,
    pub(super) hit: Hit,
    /// The s direction of the plane that the Stokes vector refers to; meaningless before the first hit.
    pub(super) axis: Vec3,
    pub(super) slot: usize,
    pub(super) hits: u32,
    /// The luminance below which it survives only by chance.
    pub(super) floor: f32,
    /// It stands for those of all samples of its group.
    pub(super) is_sparse: bool,
    pub(super) medium: MediumStack,
    /// U and V are zero (and their storage is stale).
    pub(super) in_plane: bool,
    /// It has met nothing that polarises since the camera or a diffuse surface.
    pub(super) is_unpolarized: bool,
    /// The place in the spectrum at which it goes on, once a prism has parted the wavelengths.
    pub(super) band: Option<f64>,
    /// What it has come from straight, through films or nothing.
    pub(super) since: Since,
    /// What it has done since it was scattered, where caustics are sampled.
    pub(super) chain: Chain,
}

/// What a path has come from straight and unbent, with nothing but films in between.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Since {
    /// The camera, in a picture without its backdrop.
    Camera,
    /// A surface that scattered it; where, stands by its slot.
    Scattering,
    /// A surface that mirrored or refracted it; or it does not matter what.
    Bend,
}

impl Since {
    /// Left by a surface that sampled the lights, or did not.
    #[inline(always)]
    pub(super) fn scattering(scattered: Option<Scattered>) -> Since {
        if scattered.is_some() { Since::Scattering } else { Since::Bend }
    }
}

/// A diffuse point that a path left in a sampled direction.
#[derive(Clone, Copy, Default)]
pub(super) struct Scattered {
    pub(super) origin: Vec3,
    /// Probability per solid angle of the direction.
    pub(super) density: f64,
}

/// What becomes of a branch.
#[derive(Clone, Copy)]
pub(super) enum Continuation {
    /// It meets another surface.
    Surface(Hit),
    /// It leaves the scene.
    Escapes,
    /// It leaves the scene straight from the camera, in a picture without its backdrop; the sun that it meets there, if any.
    Backdrop(Option<usize>),
    /// It meets an emitter; this is its weight in multiple importance sampling.
    Emitter(usize, f32),
    /// It is absorbed.
    Absorbed,
}

impl Tracer<'_> {
    /// Where a path was scattered, if it has come straight from there.
    #[inline(always)]
    pub(super) fn scattered(&self, path: &Path) -> Option<Scattered> {
        (path.since == Since::Scattering).then(|| self.scattered[path.slot])
    }

    /// What the branch of a path comes to that goes straight on from a hit.
    #[inline(always)]
    pub(super) fn straight_on(&self, path: &Path) -> Continuation {
        match self.continuation(&path.hit, path.direction, path.medium, self.scattered(path)) {
            Continuation::Escapes if path.since == Since::Camera => {
                Continuation::Backdrop(self.bare_sun(path.direction))
            }
            continuation => continuation,
        }
    }

    /// The only sun in a direction, unless it belongs to a sky.
    #[inline(always)]
    pub(super) fn bare_sun(&self, direction: Vec3) -> Option<usize> {
        let lights = &self.spectra.lights;
        lights.sun_at(direction).map(|(sun, _)| sun).filter(|sun| !lights.suns[*sun].is_of_sky)
    }

    /// Nothing comes from infinitely far away within a medium that absorbs.
    #[inline(always)]
    pub(super) fn is_dark(&self, medium: MediumStack) -> bool {
        self.spectra.attenuation[usize::from(medium.innermost())].is_some()
    }

    /// What a branch that starts at a hit comes to.
    #[inline(always)]
    pub(super) fn continuation(
        &self,
        hit: &Hit,
        direction: Vec3,
        medium: MediumStack,
        scattered: Option<Scattered>,
    ) -> Continuation {
        let scene = self.scene;
        if scene.geometry.is_shaded(hit.object)
            && direction.dot(hit.normal) * direction.dot(scene.geometry.normal_at(hit)) <= 0.0
        {
            // Mirrored or refracted by the shading normal to the side of the surface where it cannot be.
            return Continuation::Absorbed;
        }
        let Some(next) = scene.geometry.nearest(&Ray { origin: hit.point, direction }, Some(hit)) else {
            return match self.spectra.lights.sun_at(direction) {
                _ if self.is_dark(medium) => Continuation::Absorbed,
                // Its whole Stokes vector is needed, or more than one share: it goes on as if to a last surface.
                Some((_, false)) => Continuation::Surface(Hit { object: scene.materials.len(), distance: 0.0, ..*hit }),
                _ => Continuation::Escapes,
            };
        };
        match &scene.materials[next.object] {
            Material::Diffuse { is_black: true, .. } => Continuation::Absorbed,
            Material::Emitter(emitter) if !self.is_dark(medium) && self.is_natural(*emitter) => {
                Continuation::Emitter(*emitter, self.emitter_mis_weight(scattered, &next))
            }
            _ => Continuation::Surface(next),
        }
    }

    /// Whether an emitter is unpolarised: of others the whole Stokes vector is needed, by a path that comes to them.
    #[inline(always)]
    pub(super) fn is_natural(&self, emitter: usize) -> bool {
        self.spectra.lights.area_lights[emitter].linear.is_none()
    }
}
