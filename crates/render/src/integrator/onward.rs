//! Where the branches of a path lead.

use iridesce_numerics::Vec3;

use super::Tracer;
use super::path::{Continuation, Path, Scattered, Since};
use crate::camera::Ray;
use crate::geometry::Hit;
use crate::materials::Material;
use crate::medium_stack::MediumStack;

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
