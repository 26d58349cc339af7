//! Light that arrives straight at a surface that scatters it: the lights are sampled (next event estimation).
//!
//! What a branch that the surface sends on can find as well is shared out between the two techniques by the balance
//! heuristic, in proportion to their densities per solid angle
//! (E. Veach, L. J. Guibas, "Optimally combining sampling techniques for Monte Carlo rendering", SIGGRAPH 1995). Films do not bend light, so a point sees the lights straight through them: both techniques count
//! such a film as part of the way. A sun is found by light sampling
//! only; in mirrors, by BSDF sampling only.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;

use super::escape::Share;
use super::{Path, Scattered, Sums, Target, Tracer};
use crate::camera::Ray;
use crate::failure::PathFailure;
use crate::geometry::{Hit, cone_direction};
use crate::prepare::Material;
use crate::sampler::Choices;

/// Most emitters that are all sampled at every hit; of more, one is.
const ALL_EMITTERS: usize = 4;

/// A surface, at the place where a path has met it, that sends light on in more than single directions.
pub(super) trait Scatters {
    /// Probability per solid angle with which the surface itself sends its branch on in a direction; more than 0 wherever
    /// [`Scatters::evaluate`] gives anything.
    fn density(&self, direction: Vec3) -> f64;

    /// Makes of `onward`, a copy of the path at the surface, the path that goes on in `direction`, and gives the factor by
    /// which all its weights are still to be multiplied: both together are BSDF times cosine.
    /// `None` where nothing goes there.
    ///
    /// Weights that differ from those of the path by more than the factor go to `slot`, which then is `onward.slot`; the slot
    /// of the path is only read. `direction`, `axis` (the s direction of its Stokes vector), `in_plane`, `is_unpolarized`
    /// and `medium` of `onward` are set too; its `hit` stays.
    fn evaluate<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64>;
}

/// A light that is sampled from a point.
#[derive(Clone, Copy)]
enum LightKind {
    Maps,
    Sun(usize),
    Emitter(usize),
}

/// A light that was sampled: where it stands, and the probability per solid angle with which it was found there, by
/// all techniques that share it.
struct Sampled {
    light: LightKind,
    direction: Vec3,
    density: f64,
}

impl Tracer<'_> {
    /// Samples every light: how much of it arrives here straight.
    #[inline(always)]
    pub(super) fn direct_light<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let spectra = self.spectra;
        let lights = &spectra.lights;
        for sun in 0..lights.suns.len() {
            let disc = &lights.suns[sun];
            let (direction, density) = cone_direction(disc.direction, disc.cos_radius, choices.pair());
            if scatters.density(direction) > 0.0 {
                self.connect(simd, path, scatters, &Sampled { light: LightKind::Sun(sun), direction, density }, sums);
            }
        }
        if let Some(sampler) = &lights.sampler {
            let (direction, density) = sampler.draw(choices.pair());
            self.connect_shared(simd, path, scatters, Sampled { light: LightKind::Maps, direction, density }, sums);
        }
        let count = lights.area_lights.len();
        let (first, sampled) = match count {
            0..=ALL_EMITTERS => (0, count),
            _ => (((choices.next() * count as f32) as usize).min(count - 1), 1),
        };
        for emitter in first..first + sampled {
            let object = lights.area_lights[emitter].object;
            let drawn = self.scene.geometry.draw(object, path.hit.point, choices.pair());
            let Some((direction, density)) = drawn else { continue };
            let density = density * sampled as f64 / count as f64;
            let light = LightKind::Emitter(emitter);
            self.connect_shared(simd, path, scatters, Sampled { light, direction, density }, sums);
        }
    }

    /// [`Tracer::connect`] to a light that the surface's own branch may find as well, by the balance heuristic.
    #[inline(always)]
    fn connect_shared<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        mut sampled: Sampled,
        sums: &mut Sums<S>,
    ) {
        let scattered = scatters.density(sampled.direction);
        if scattered > 0.0 {
            sampled.density += scattered;
            self.connect(simd, path, scatters, &sampled, sums);
        }
    }

    /// Adds the light that arrives from a direction over its density, if nothing but films stands before it.
    #[inline(always)]
    fn connect<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        sampled: &Sampled,
        sums: &mut Sums<S>,
    ) {
        let &Sampled { light, direction, density } = sampled;
        if !(density > 0.0 && density < f64::INFINITY) {
            return;
        }
        let scene = self.scene;
        let mut next = scene.geometry.nearest(&Ray { origin: path.hit.point, direction }, Some(&path.hit));
        // Not before it is known that anything at all comes from there.
        if !self.may_arrive(next.as_ref(), light) {
            return;
        }
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut way = *path;
        if let Some(value) = scatters.evaluate(simd, self, &mut way, direction, slot) {
            loop {
                match next {
                    Some(film) if matches!(scene.materials[film.object], Material::Film(_)) => {
                        if !self.pass_film(simd, &mut way, film, slot) {
                            break;
                        }
                    }
                    _ => {
                        self.contribute(simd, &way, light, (value / density) as f32, sums);
                        break;
                    }
                }
                next = scene.geometry.nearest(&Ray { origin: way.hit.point, direction }, Some(&way.hit));
                if !self.may_arrive(next.as_ref(), light) {
                    break;
                }
            }
        }
        self.free.push(slot);
    }

    /// Whether what a ray towards a light meets next is that light, or lets it through.
    #[inline(always)]
    fn may_arrive(&self, next: Option<&Hit>, light: LightKind) -> bool {
        let Some(next) = next else { return matches!(light, LightKind::Maps | LightKind::Sun(_)) };
        match (&self.scene.materials[next.object], light) {
            (Material::Film(_), _) => true,
            (Material::Emitter(emitter), LightKind::Emitter(sampled)) => *emitter == sampled,
            _ => false,
        }
    }

    /// Takes a path straight through a film; its spectra then stand in `slot`. False if the pixel cannot be finished.
    #[inline(always)]
    fn pass_film<S: Simd>(&mut self, simd: S, way: &mut Path, next: Hit, slot: usize) -> bool {
        let Material::Film(film) = &self.scene.materials[next.object] else { return false };
        if way.medium.innermost() != film.outside {
            let (is_in, expected) = (way.medium.innermost(), film.outside);
            self.failure = Some(PathFailure::WrongMedium { object: next.object, is_in, expected });
            return false;
        }
        let thickness = film.layer.thickness_nm(next.point);
        if self.is_too_coarse(film.layer.path_nm(thickness)) {
            return false;
        }
        if way.slot != slot {
            let (from, to) = (self.at(way.slot, 0, 0), self.at(slot, 0, 0));
            self.arena.copy_within(from..from + 2 * self.blocks, to);
            way.slot = slot;
        }
        way.hit = next;
        self.rotate_stokes_frame(simd, way);
        let cos_theta = way.direction.dot(next.normal).abs().min(1.0) as f32;
        let to = [Target::Nowhere, Target::Slot(slot)];
        // What it would be mirrored to is not looked at: the other branch does that.
        let mut unused = Sums([f32x16::splat(simd, 0.0); 3]);
        self.split_film(simd, way, film.number, cos_theta, thickness as f32, to, &mut unused);
        way.is_unpolarized = false;
        true
    }

    #[inline(always)]
    fn contribute<S: Simd>(&mut self, simd: S, way: &Path, light: LightKind, factor: f32, sums: &mut Sums<S>) {
        let out = match light {
            LightKind::Maps => {
                self.make_room(simd, 1);
                self.escaped.push(way.direction, Share { maps: 1.0, sun: None })
            }
            _ => 0,
        };
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(way.slot, 0, block)].load(simd);
            let p = self.arena[self.at(way.slot, 1, block)].load(simd);
            let carried = (s + p) * factor;
            match light {
                LightKind::Maps => self.escaped.carried[out * self.blocks + block].store(carried),
                LightKind::Sun(sun) => xyz = self.spectra.lights.add_sun(simd, sun, block, carried, xyz),
                LightKind::Emitter(emitter) => {
                    xyz = self.spectra.lights.add_emission(simd, emitter, block, carried, xyz)
                }
            }
        }
        sums.0 = xyz;
    }

    /// The weight of an emitter that a scattered branch meets, by the balance heuristic: light sampling finds the rest.
    #[inline(always)]
    pub(super) fn emitter_mis_weight(&self, scattered: Option<Scattered>, next: &Hit) -> f32 {
        let Some(Scattered { origin, density }) = scattered else { return 1.0 };
        let count = self.spectra.lights.area_lights.len();
        let chance = if count <= ALL_EMITTERS { 1.0 } else { 1.0 / count as f64 };
        let sampled = chance * self.scene.geometry.density(next.object, origin, next.point);
        (density / (density + sampled)) as f32
    }

    /// The same for the maps.
    #[inline(always)]
    pub(super) fn environment_mis_weight(&self, Scattered { density, .. }: Scattered, direction: Vec3) -> f32 {
        let sampled = self.spectra.lights.sampler.as_ref().map_or(0.0, |sampler| sampler.density(direction));
        (density / (density + sampled)) as f32
    }
}
