//! Diffuse surfaces: the lights are sampled (next event estimation), and one branch goes on in a cosine-weighted
//! direction.
//!
//! What both techniques can find is shared out between them by the balance heuristic, in proportion to their densities
//! per solid angle
//! (E. Veach, L. J. Guibas, "Optimally combining sampling techniques for Monte Carlo rendering", SIGGRAPH 1995). Films do not bend light, so a diffuse point sees the lights straight through them: both techniques count
//! such a film as part of the way. A sun is found by light sampling
//! only; in mirrors, by BSDF sampling only.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;

use super::escape::Share;
use super::{Continuation, FAINT, LATE_SURVIVAL, Path, Scattered, Sums, Target, Tracer};
use crate::camera::Ray;
use crate::failure::PathFailure;
use crate::geometry::{Hit, cone_direction, frame, nearest};
use crate::prepare::Material;
use crate::sampler::Choices;

/// After a diffuse hit a branch survives for certain down to this share of its luminance: its direction was a matter of
/// chance, so that what follows need not be followed to the last detail.
const FLOOR_SHARE: f32 = 0.25;

/// Most emitters that are all sampled at every diffuse hit; of more, one is.
const ALL_EMITTERS: usize = 4;

/// A light that is sampled from a diffuse point.
#[derive(Clone, Copy)]
enum LightKind {
    Maps,
    Sun(usize),
    Emitter(usize),
}

impl Tracer<'_> {
    /// What a path finds at a diffuse surface; it goes on as `path`, or not at all.
    #[inline(always)]
    pub(super) fn scatter_diffuse<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        number: usize,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let hit = path.hit;
        path.hits += 1;
        let mut luminance = self.reflect_diffusely(simd, path, number);
        if path.hits > self.scene.max_depth {
            path.floor = luminance / LATE_SURVIVAL;
        }
        if !self.survives(simd, path, luminance, sums, choices) {
            return false;
        }
        luminance = luminance.max(path.floor);
        if path.hits <= self.scene.max_depth {
            path.floor = (FLOOR_SHARE * luminance).max(FAINT);
        }
        let facing = if path.direction.dot(hit.normal) < 0.0 { hit.normal } else { -hit.normal };
        let is_dark = self.is_dark(path.medium);
        if !is_dark {
            self.sample_lights(simd, path, facing, sums, choices);
        }

        let (a, b) = choices.pair();
        let (across, up) = frame(facing);
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let (radius, height) = (a.sqrt(), (1.0 - a).sqrt());
        let direction = (across * (radius * cos) + up * (radius * sin) + facing * height).normalized();
        // In a medium that absorbs the lights were not sampled: whatever the branch finds is its own.
        let density = height * std::f64::consts::FRAC_1_PI;
        let scattered = (!is_dark).then_some(Scattered { origin: hit.point, density });
        let continuation = self.continuation(&hit, direction, path.medium, scattered);
        if let Continuation::Surface(next) = continuation {
            (path.hit, path.direction, path.axis) = (next, direction, frame(direction).0);
            path.is_scattered = scattered.is_some();
            self.scattered[path.slot] = scattered.unwrap_or_default();
            return true;
        }
        self.make_room(simd, 1);
        let to = self.target(continuation, path.slot, direction, scattered);
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let weight = self.arena[self.at(path.slot, 0, block)].load(simd);
            xyz = self.splat(simd, to, block, weight, weight, xyz);
        }
        sums.0 = xyz;
        false
    }

    /// Light from a diffuse surface is unpolarised, whatever fell on it. Gives the luminance.
    #[inline(always)]
    fn reflect_diffusely<S: Simd>(&mut self, simd: S, path: &mut Path, number: usize) -> f32 {
        let mut luminance = f32x16::splat(simd, 0.0);
        for block in 0..self.blocks {
            let (s_at, p_at) = (self.at(path.slot, 0, block), self.at(path.slot, 1, block));
            let both = self.arena[s_at].load(simd) + self.arena[p_at].load(simd);
            let out = both * self.spectra.diffuse[number][block].load(simd) * 0.5;
            self.arena[s_at].store(out);
            self.arena[p_at].store(out);
            luminance = self.spectra.importance[block].load(simd).mul_add(out + out, luminance);
        }
        path.in_plane = true;
        path.is_unpolarized = true;
        luminance.reduce_sum()
    }

    /// Samples every light: how much of it arrives here straight.
    #[inline(always)]
    fn sample_lights<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facing: Vec3,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let spectra = self.spectra;
        let lights = &spectra.lights;
        for sun in 0..lights.suns.len() {
            let disc = &lights.suns[sun];
            let (direction, density) = cone_direction(disc.direction, disc.cos_radius, choices.pair());
            let cos = direction.dot(facing);
            self.connect(simd, path, LightKind::Sun(sun), direction, cos * std::f64::consts::FRAC_1_PI / density, sums);
        }
        if let Some(sampler) = &lights.sampler {
            let (direction, density) = sampler.draw(choices.pair());
            let scattered = direction.dot(facing) * std::f64::consts::FRAC_1_PI;
            self.connect(simd, path, LightKind::Maps, direction, balance(scattered, density), sums);
        }
        let count = lights.area_lights.len();
        let (first, sampled) = match count {
            0..=ALL_EMITTERS => (0, count),
            _ => (((choices.next() * count as f32) as usize).min(count - 1), 1),
        };
        for emitter in first..first + sampled {
            let object = lights.area_lights[emitter].object;
            let drawn = self.scene.shapes[object].draw(path.hit.point, choices.pair());
            let Some((direction, density)) = drawn else { continue };
            let density = density * sampled as f64 / count as f64;
            let scattered = direction.dot(facing) * std::f64::consts::FRAC_1_PI;
            self.connect(simd, path, LightKind::Emitter(emitter), direction, balance(scattered, density), sums);
        }
    }

    /// Adds `factor` times the light that arrives from a direction, if nothing but films stands before it.
    #[inline(always)]
    fn connect<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        light: LightKind,
        direction: Vec3,
        factor: f64,
        sums: &mut Sums<S>,
    ) {
        if !(factor > 0.0 && factor < f64::INFINITY) {
            return;
        }
        let scene = self.scene;
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut way = Path { direction, axis: frame(direction).0, ..*path };
        loop {
            let from = Ray { origin: way.hit.point, direction };
            let next = nearest(&scene.shapes, &from, Some(way.hit.object));
            let material = next.map(|next| &scene.materials[next.object]);
            match (next, material, light) {
                (None, _, LightKind::Maps | LightKind::Sun(_)) => {
                    self.contribute(simd, &way, light, factor as f32, sums);
                    break;
                }
                (_, Some(Material::Emitter(emitter)), LightKind::Emitter(sampled)) if *emitter == sampled => {
                    self.contribute(simd, &way, light, factor as f32, sums);
                    break;
                }
                (Some(next), Some(Material::Film(_)), _) => {
                    if !self.pass_film(simd, &mut way, next, slot) {
                        break;
                    }
                }
                _ => break,
            }
        }
        self.free.push(slot);
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
        let sampled = chance * self.scene.shapes[next.object].density(origin, next.point);
        (density / (density + sampled)) as f32
    }

    /// The same for the maps.
    #[inline(always)]
    pub(super) fn environment_mis_weight(&self, Scattered { density, .. }: Scattered, direction: Vec3) -> f32 {
        let sampled = self.spectra.lights.sampler.as_ref().map_or(0.0, |sampler| sampler.density(direction));
        (density / (density + sampled)) as f32
    }
}

/// What a sampled light counts: its contribution `scattered / density` times the balance heuristic's share. Nothing where
/// the light is behind the surface.
#[inline(always)]
fn balance(scattered: f64, density: f64) -> f64 {
    if scattered > 0.0 { scattered / (density + scattered) } else { 0.0 }
}
