//! Rough free films: one sheet with parallel faces. It mirrors roughly; what a facet passes goes straight on, the mean over
//! the facets seen from there, and so does, without its polarisation, what is mirrored at one facet and passes another.
//!
//! Both branches are followed, and nothing is lost: what the facets of a walk mirror, pass and absorb makes one.

use fearless_simd::{Simd, f32x16, prelude::*};

use super::Tracer;
use super::direct::Scatters;
use super::facets::{Facets, Stack};
use super::path::{Continuation, Path, Scattered, Since, Sums};
use super::rough::MOST_FACETS;
use crate::chain::Chain;
use crate::failure::PathFailure;
use crate::film::Beam;
use crate::geometry::Hit;
use crate::materials::FilmSurface;
use crate::microfacet::Wanderer;
use crate::rough::{RoughPlace, RoughSurface};
use crate::sampler::Choices;

impl<'a> Tracer<'a> {
    /// Splits a path at a rough film.
    #[inline(always)]
    pub(super) fn scatter_rough_film<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        (film, rough): (&FilmSurface, &RoughSurface),
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let Some(mut facets) = self.film_facets(path, &path.hit, film, rough) else { return false };
        path.hits += 1;
        let arriving = self.luminance(simd, path);
        if !self.survives_scattering(simd, path, [arriving; 2], sums, choices) {
            return false;
        }
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        // What passes is gathered in the path's own slot, the ray among the facets carries another.
        let mut mirrored = *path;
        self.copy_slot(&mut mirrored, slot);
        let (mut luminance, mut density, mut gets_out) = (0.0, 0.0, false);
        for number in 0..MOST_FACETS {
            if !facets.ray.meets_facet(&facets.spread, choices.next().into()) {
                gets_out = true;
                break;
            }
            self.light_facet(simd, &mirrored, &facets, true, sums, choices);
            let before = facets;
            luminance = self.film_facet(simd, &mut mirrored, path, &mut facets, number == 0, choices);
            density = before.density(mirrored.direction);
        }
        if self.is_given_up() {
            self.free.push(mirrored.slot);
            return false;
        }
        gets_out &= mirrored.direction.dot(facets.facing) > 0.0;

        let passed_from = self.scattered(path);
        let passed = self.straight_on(path);
        let scattered = (density > 0.0).then_some(Scattered { origin: path.hit.point, density });
        let reflected = match gets_out {
            true => self.continuation(&path.hit, mirrored.direction, mirrored.medium, scattered),
            false => Continuation::Absorbed,
        };
        mirrored.since = Since::scattering(scattered);
        let direction = mirrored.direction;
        self.depart(&mut mirrored, facets.facing, direction, scattered);
        // Caustics are not looked for through it.
        path.chain = Chain::UNTOLD;
        self.scattered[mirrored.slot] = scattered.unwrap_or_default();
        self.raise_floor(&mut mirrored, luminance);
        let passed_y = self.luminance(simd, path);
        match (reflected, passed) {
            (Continuation::Surface(back), Continuation::Surface(next)) => {
                (mirrored.hit, path.hit) = (back, next);
                self.follow_both(simd, path, mirrored, [luminance, passed_y], sums, choices)
            }
            (Continuation::Surface(back), _) => {
                self.deliver(simd, path, passed, passed_from, sums);
                self.free.push(path.slot);
                *path = mirrored;
                path.hit = back;
                self.survives(simd, path, luminance, sums, choices)
            }
            (_, Continuation::Surface(next)) => {
                self.deliver(simd, &mirrored, reflected, scattered, sums);
                self.free.push(mirrored.slot);
                path.hit = next;
                self.survives(simd, path, passed_y, sums, choices)
            }
            _ => {
                self.deliver(simd, &mirrored, reflected, scattered, sums);
                self.free.push(mirrored.slot);
                self.deliver(simd, path, passed, passed_from, sums);
                false
            }
        }
    }

    /// Takes a path, whose spectra stand in a slot of its own, straight through a rough film. False if the pixel cannot be
    /// finished.
    #[inline(always)]
    pub(super) fn pass_rough_film<S: Simd>(
        &mut self,
        simd: S,
        way: &mut Path,
        (film, rough): (&FilmSurface, &RoughSurface),
        choices: &mut Choices,
    ) -> bool {
        let Some(mut facets) = self.film_facets(way, &way.hit, film, rough) else { return false };
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut mirrored = *way;
        self.copy_slot(&mut mirrored, slot);
        for number in 0..MOST_FACETS {
            if !facets.ray.meets_facet(&facets.spread, choices.next().into()) {
                break;
            }
            self.film_facet(simd, &mut mirrored, way, &mut facets, number == 0, choices);
        }
        self.free.push(slot);
        true
    }

    /// The facets of a film where a path meets it.
    #[inline(always)]
    fn film_facets(&mut self, path: &Path, hit: &Hit, film: &FilmSurface, rough: &RoughSurface) -> Option<Facets<'a>> {
        let is_in = path.medium.innermost();
        if is_in != film.outside && !self.scene.media.are_one(is_in, film.outside) {
            self.failure = Some(PathFailure::WrongMedium { object: hit.object, is_in, expected: film.outside });
            return None;
        }
        let thickness = film.layer.thickness_nm(&self.scene.geometry, hit);
        let phase = self.phase(film.layer.path_nm(thickness))?;
        let RoughPlace { facets: spread, frame, facing } = rough.at(&self.scene.geometry, hit, path.direction);
        let table = &self.spectra.films[film.number];
        Some(Facets {
            ray: Wanderer::new(frame.local(path.direction)),
            spread,
            frame,
            facing,
            stack: Stack::Film { table, thickness_nm: thickness, phase },
            ratio: None,
            media: [path.medium; 2],
            is_dark: [self.is_dark(path.medium), true],
            parted: None,
            lines: None,
        })
    }

    /// One facet: what it passes is added to `passed`, what it mirrors stays with `mirrored`, whose luminance is given back.
    #[inline(always)]
    fn film_facet<S: Simd>(
        &mut self,
        simd: S,
        mirrored: &mut Path,
        passed: &mut Path,
        facets: &mut Facets<'_>,
        is_first: bool,
        choices: &mut Choices,
    ) -> f32 {
        let local = facets.ray.facet(&facets.spread, choices.pair());
        let h = facets.frame.world(local);
        self.rotate_stokes_frame_to(simd, mirrored, h);
        mirrored.is_unpolarized = false;
        if is_first {
            (passed.axis, passed.in_plane, passed.is_unpolarized) = (mirrored.axis, mirrored.in_plane, false);
        }
        let cos_theta = (-mirrored.direction.dot(h)).clamp(0.0, 1.0) as f32;
        let mut luminance = f32x16::splat(simd, 0.0);
        for block in 0..self.blocks {
            let response = facets.stack.response(simd, false, block, cos_theta);
            let before = self.beam(simd, mirrored, block);
            let (back, on) = (response.reflect.carry(&before), response.transmit.carry(&before));
            self.store_beam(mirrored, block, &back);
            if is_first {
                self.store_beam(passed, block, &on);
            } else {
                let each = (on.s + on.p) * 0.5;
                let sum = self.beam(simd, passed, block);
                self.store_beam(passed, block, &Beam { s: sum.s + each, p: sum.p + each, ..sum });
            }
            luminance = self.spectra.importance[block].load(simd).mul_add(back.s + back.p, luminance);
        }
        facets.ray = facets.ray.mirrored(local);
        mirrored.direction = facets.frame.world(facets.ray.direction).normalized();
        luminance.reduce_sum()
    }

    /// Luminance of what a path carries.
    #[inline(always)]
    pub(super) fn luminance<S: Simd>(&self, simd: S, path: &Path) -> f32 {
        let mut luminance = f32x16::splat(simd, 0.0);
        for block in 0..self.blocks {
            let beam = self.beam(simd, path, block);
            luminance = self.spectra.importance[block].load(simd).mul_add(beam.s + beam.p, luminance);
        }
        luminance.reduce_sum()
    }
}
