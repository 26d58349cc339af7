//! Rays along chains of mirrors, clear surfaces and films, without their light.

use iridesce_numerics::Vec3;

use crate::geometry::Hit;
use crate::levels::Spectra;
use crate::materials::{CoatedSurface, Material};
use crate::medium_stack::MediumStack;
use crate::prepare::Prepared;
use crate::refraction::{is_parted, refracted_direction, shading_normal};

/// A ray that has left a surface.
#[derive(Debug, Clone, Copy)]
pub struct SpecularRay {
    pub hit: Hit,
    pub direction: Vec3,
    pub medium: MediumStack,
    /// The place in the spectrum at which it goes on, once a prism has parted the wavelengths.
    pub band: Option<f64>,
    /// Something has bent it.
    pub is_bent: bool,
}

impl SpecularRay {
    /// Goes on to the next surface, and mirrors or passes there. `chosen`: the place in the spectrum at which it goes on where
    /// wavelengths are parted. `None` where it cannot.
    #[inline(always)]
    pub fn step(&mut self, scene: &Prepared, spectra: &Spectra, mirrors: bool, chosen: f64) -> Option<()> {
        self.hit = scene.next_that_is_there(&self.hit, self.direction, &mut self.medium)?;
        self.turn(scene, spectra, mirrors, chosen)
    }

    /// Mirrors or passes at the hit, as [`SpecularRay::step`] does; exactly as paths of light do there.
    #[inline(always)]
    pub fn turn(&mut self, scene: &Prepared, spectra: &Spectra, mirrors: bool, chosen: f64) -> Option<()> {
        let material = &scene.materials[self.hit.object];
        if scene.geometry.is_shaded(self.hit.object) {
            self.hit.normal = shading_normal(&scene.geometry, &self.hit, self.direction);
        }
        let along = self.direction.dot(self.hit.normal);
        match material {
            Material::Film(film) if film.rough.is_none() && !mirrors => return Some(()),
            Material::Film(film) if film.rough.is_none() => {}
            Material::Coating(coating) if coating.rough.is_none() && mirrors => {}
            Material::Coating(coating) if coating.rough.is_none() && !coating.is_opaque => {
                let beyond = beyond(coating, self.medium, along < 0.0)?;
                let media = [self.medium, beyond].map(|medium| &spectra.media[usize::from(medium.innermost())]);
                let cos_theta = along.abs().min(1.0);
                if self.band.is_none() && is_parted(&spectra.bands, cos_theta, media) {
                    self.band = Some(chosen);
                }
                let facing = if along < 0.0 { self.hit.normal } else { -self.hit.normal };
                let place = self.band.unwrap_or(spectra.bands.middle);
                let direction = refracted_direction(self.direction, facing, cos_theta, media, place)?;
                (self.medium, self.direction, self.is_bent) = (beyond, direction, true);
                return self.is_on_its_side(scene);
            }
            _ => return None,
        }
        (self.direction, self.is_bent) = (self.direction - self.hit.normal * (2.0 * along), true);
        self.is_on_its_side(scene)
    }

    /// Not mirrored or refracted by the shading normal to the side of the surface where it cannot be.
    #[inline(always)]
    fn is_on_its_side(&self, scene: &Prepared) -> Option<()> {
        let hit = &self.hit;
        (!scene.geometry.is_shaded(hit.object)
            || self.direction.dot(hit.normal) * self.direction.dot(scene.geometry.normal_at(hit)) > 0.0)
            .then_some(())
    }
}

/// The media beyond a clear surface; `None` where a path fails there.
#[inline(always)]
pub fn beyond(coating: &CoatedSurface, medium: MediumStack, is_from_front: bool) -> Option<MediumStack> {
    if is_from_front {
        return medium.entered(coating.substrate);
    }
    (medium.innermost() == coating.substrate).then(|| medium.left())
}
