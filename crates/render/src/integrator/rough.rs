//! Rough coatings, dielectrics and metals: a walk among microscopic facets ([`crate::microfacet`]), each of which answers as
//! the exact stack at its own angle, polarised.
//!
//! The whole spectrum goes the same way. At every facet the lights are sampled as if it were the last one; then one way is
//! drawn, mirrored or refracted, in proportion to luminance, until the ray gets out. Where refraction parts the wavelengths one of them
//! tells the direction, and all go there, each by the density of the facets that send it there over the mean of all of them
//! (A. Wilkie et al., "Hero wavelength spectral sampling", CGF 33(4), 2014): a lobe wider than the dispersion shows no colour noise. Light sampling and what the
//! outgoing branch finds are shared out by the balance heuristic given the walk so far: densities there may be any, as long
//! as both techniques tell the same, so the share of mirrored light in them is that of a bare surface.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;

use super::direct::Scatters;
use super::facets::{Facets, Stack, scaled};
use super::path::{Continuation, Path, Scattered, Since, Sums};
use super::{LATE_SURVIVAL, Tracer};
use crate::coating::LayersAt;
use crate::materials::{CoatedSurface, SHOWN_NM};
use crate::microfacet::Wanderer;
use crate::refraction::{is_parted, ratio};
use crate::rough::{RoughPlace, RoughSurface};
use crate::sampler::Choices;

/// Facets after which a walk is given up: at the roughest, half of what is left gets out at each.
pub(super) const MOST_FACETS: u32 = 64;

/// Least probability of either way at a facet that mirrors and refracts: a way without luminance may carry colour.
const LEAST_CHANCE: f32 = 0.02;

/// How a walk begins, at a facet that the lights have been asked of.
#[derive(Clone, Copy)]
pub(super) struct First {
    /// The normal of the facet, in the frame of the surface.
    pub(super) facet: Vec3,
    /// The random number by which the ray gets out from there, or meets a second one.
    pub(super) random: f64,
    /// The maps have been asked of second facets.
    pub(super) second_is_lit: bool,
}

impl<'a> Tracer<'a> {
    /// What a path finds at a rough coated or bare surface; it goes on as `path`, or not at all.
    #[inline(always)]
    pub(super) fn scatter_rough<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        (coating, rough): (&CoatedSurface, &RoughSurface),
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let spectra = self.spectra;
        let Path { hit, medium, .. } = *path;
        let Some(sides) = self.sides(path, coating) else { return false };
        let Some(path_nm) = self.take_thicknesses(coating, &hit) else { return false };
        path.hits += 1;
        let arriving = self.luminance(simd, path);
        if !self.survives_scattering(simd, path, [arriving; 2], sums, choices) {
            return false;
        }
        let thicknesses = std::mem::take(&mut self.thicknesses);
        let media = [&spectra.media[usize::from(medium.innermost())], &spectra.media[usize::from(sides.exit)]];
        let RoughPlace { facets: spread, frame, facing } = rough.at(&self.scene.geometry, &hit, path.direction);
        let bands = &spectra.bands;
        let is_parted =
            !coating.is_opaque && path.band.is_none() && is_parted(bands, std::f64::consts::FRAC_1_SQRT_2, media);
        let place = path.band.unwrap_or(bands.middle);
        let mut facets = Facets {
            ray: Wanderer::new(frame.local(path.direction)),
            spread,
            frame,
            facing,
            stack: Stack::Layers {
                media,
                layers: LayersAt { tables: &spectra.coatings[coating.number], thickness_nm: &thicknesses },
                is_reversed: sides.is_reversed,
                rate: &spectra.rate,
            },
            ratio: (!coating.is_opaque).then(|| ratio(media, place)),
            media: [medium, sides.beyond],
            is_dark: [self.is_dark(medium), self.is_dark(sides.beyond)],
            parted: is_parted.then_some((media, &bands.chances[..])),
            lines: spectra.lines.as_ref().filter(|_| coating.is_opaque && path_nm > SHOWN_NM).map(|lines| {
                let stack = Stack::Layers {
                    media: [&lines.media[usize::from(medium.innermost())], &lines.media[usize::from(sides.exit)]],
                    layers: LayersAt { tables: &lines.coatings[coating.number], thickness_nm: &thicknesses },
                    is_reversed: sides.is_reversed,
                    rate: &lines.rate,
                };
                (stack, &lines.importance[..])
            }),
        };
        facets.ray.meets_facet(&facets.spread, choices.next().into());
        self.light_facet(simd, path, &facets, true, sums, choices);
        let goes_on = if coating.is_opaque && self.looks_closely(path) {
            self.send_fan(simd, path, &facets, arriving, sums, choices);
            false
        } else {
            let facet = self.draw_facet(simd, path, &facets, choices);
            let first = First { facet, random: choices.next().into(), second_is_lit: false };
            self.send_one(simd, path, facets, first, 1.0, sums, choices)
        };
        self.thicknesses = thicknesses;
        goes_on
    }

    /// Sends a branch on from the first facet of a walk, which the lights have been asked of, with the random number by which it gets out
    /// from there; it carries this share of the light.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    pub(super) fn send_one<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        mut facets: Facets<'_>,
        first: First,
        share: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        // One copy of it in the program.
        let walked = simd.vectorize(
            #[inline(always)]
            || self.walk(simd, path, &mut facets, first, sums, choices),
        );
        let Some((luminance, density)) = walked else { return false };
        path.medium = facets.media[usize::from(facets.ray.is_below)];
        let scattered = (density > 0.0).then_some(Scattered { origin: path.hit.point, density });
        self.leave_rough(simd, path, (facets.facing, luminance), share, scattered, sums, choices)
    }

    /// From the first facet, which the lights have been asked of and which is drawn, with the random number by which the ray gets out from
    /// there, to others until the ray gets out: the luminance that it carries then, and the density of its direction, 0
    /// where no lamp was sampled that way. `None` where nothing of it is left.
    #[inline(always)]
    fn walk<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        facets: &mut Facets<'_>,
        first: First,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> Option<(f32, f64)> {
        let Some(spare) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut found = None;
        let mut luminance = 0.0;
        let mut density = 0.0;
        for number in 0..MOST_FACETS {
            if number > 0 {
                let random = if number == 1 { first.random } else { choices.next().into() };
                if !facets.ray.meets_facet(&facets.spread, random) {
                    found = Some((luminance, density));
                    break;
                }
                // What a second one sends on may be known already.
                self.light_facet(simd, path, facets, number > 1 || !first.second_is_lit, sums, choices);
            }
            if self.is_given_up() {
                break;
            }
            let local = if number == 0 { first.facet } else { self.draw_facet(simd, path, facets, choices) };
            let h = facets.frame.world(local);
            self.rotate_stokes_frame_to(simd, path, h);
            path.is_unpolarized = false;
            let cos = (-path.direction.dot(h)).clamp(0.0, 1.0);
            let [mirrored_y, passed_y, passed] = self.split_at_facet(simd, path, facets, cos as f32, spare);
            let is_parted = facets.parted.is_some();
            let ratio = facets.ratio().filter(|_| passed > 0.0);
            let chance = match ratio {
                Some(_) => (mirrored_y / (mirrored_y + passed_y)).clamp(LEAST_CHANCE, 1.0 - LEAST_CHANCE),
                None => 1.0,
            };
            // NaN where there is no luminance at all.
            let chance = if chance.is_nan() { 0.5 } else { chance };
            let before = *facets;
            if let Some(middle) = ratio
                && choices.next() >= chance
            {
                let node = is_parted.then(|| self.spectra.bands.choose_node(choices.next().into()));
                let ratio = node.map_or(middle, |node| facets.ratio_at(node));
                let cosine2 = 1.0 - ratio * ratio * (1.0 - cos * cos);
                let direction = facets.ray.direction * ratio + local * (ratio * cos - cosine2.max(0.0).sqrt());
                let direction = direction.normalized();
                let factor = 1.0 / (1.0 - chance);
                if is_parted {
                    let mixed = facets.mixed_density(direction);
                    if cosine2 <= 0.0 || mixed <= 0.0 {
                        // Other wavelengths go where this one cannot.
                        break;
                    }
                    luminance = facets.refract_by_node(simd, self, path, direction, factor / mixed as f32);
                } else {
                    luminance = self.take_other(simd, path, spare, factor);
                    if cosine2 <= 0.0 {
                        // A little may pass at other nodes than the one that tells the direction: it finds the mean light.
                        self.add_mean_of(simd, path, sums);
                        break;
                    }
                }
                facets.ray = facets.ray.passed(direction);
            } else {
                if is_parted {
                    self.take_other(simd, path, spare, 1.0 / chance);
                } else if chance < 1.0 {
                    self.scale(simd, path, 1.0 / chance);
                }
                luminance = mirrored_y / chance;
                facets.ray = facets.ray.mirrored(local);
            }
            path.direction = facets.frame.world(facets.ray.direction).normalized();
            density = before.density(path.direction);
        }
        self.free.push(spare);
        // What only the shading normal takes to get out on one side goes into the surface on the other.
        found.filter(|_| (path.direction.dot(facets.facing) < 0.0) == facets.ray.is_below)
    }

    /// The lights that a facet sees.
    #[inline(always)]
    pub(super) fn light_facet<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        with_maps: bool,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.direct_light(simd, path, facets, with_maps, sums, choices),
        );
    }

    /// What a facet mirrors stays in the path's slot, what it passes goes to another; where the wavelengths part the path's slot stays
    /// as it is, and what is mirrored goes to the other. Gives the luminances of both, and whether anything passes.
    #[inline(always)]
    fn split_at_facet<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        cos_theta: f32,
        other: usize,
    ) -> [f32; 3] {
        let zero = f32x16::splat(simd, 0.0);
        let [mut mirrored_y, mut passed_y, mut any] = [zero; 3];
        let beside = Path { slot: other, ..*path };
        let Some(sequence) = facets.stack.sequence(facets.ray.is_below) else { return [0.0; 3] };
        for block in 0..self.blocks {
            let before = self.beam(simd, path, block);
            let weight = self.spectra.importance[block].load(simd);
            if facets.ratio.is_none() {
                // What passes is not worked out where nothing goes on.
                let back = sequence.response(simd, block, cos_theta).reflect.carry(&before);
                self.store_beam(path, block, &back);
                mirrored_y = weight.mul_add(back.s + back.p, mirrored_y);
                continue;
            }
            let response = sequence.response(simd, block, cos_theta);
            let (back, on) = (response.reflect.carry(&before), response.transmit.carry(&before));
            if facets.parted.is_some() {
                self.store_beam(&beside, block, &back);
            } else {
                self.store_beam(path, block, &back);
                self.store_beam(&beside, block, &on);
            }
            mirrored_y = weight.mul_add(back.s + back.p, mirrored_y);
            passed_y = weight.mul_add(on.s + on.p, passed_y);
            any += on.s.abs() + on.p.abs();
        }
        [mirrored_y.reduce_sum(), passed_y.reduce_sum(), any.reduce_sum()]
    }

    /// Goes on with what stands in another slot, times a factor; gives the luminance.
    #[inline(always)]
    fn take_other<S: Simd>(&mut self, simd: S, path: &Path, other: usize, factor: f32) -> f32 {
        let mut luminance = f32x16::splat(simd, 0.0);
        let beside = Path { slot: other, ..*path };
        for block in 0..self.blocks {
            let on = scaled(&self.beam(simd, &beside, block), f32x16::splat(simd, factor));
            self.store_beam(path, block, &on);
            luminance = self.spectra.importance[block].load(simd).mul_add(on.s + on.p, luminance);
        }
        luminance.reduce_sum()
    }

    /// The mean light for what a path carries.
    #[inline(always)]
    fn add_mean_of<S: Simd>(&self, simd: S, path: &Path, sums: &mut Sums<S>) {
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let beam = self.beam(simd, path, block);
            xyz = self.add_mean(simd, block, beam.s + beam.p, xyz);
        }
        sums.0 = xyz;
    }

    /// A path that has got out from among facets, with this share of the light: what it comes to.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    pub(super) fn leave_rough<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        (facing, luminance): (Vec3, f32),
        share: f32,
        scattered: Option<Scattered>,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let direction = path.direction;
        self.depart(path, facing, direction, scattered);
        let continuation = self.continuation(&path.hit, path.direction, path.medium, scattered);
        let Continuation::Surface(next) = continuation else {
            self.deliver(simd, path, continuation, scattered, sums);
            return false;
        };
        path.hit = next;
        self.scattered[path.slot] = scattered.unwrap_or_default();
        path.since = Since::scattering(scattered);
        if path.hits > self.scene.max_depth {
            path.floor = luminance / LATE_SURVIVAL;
        }
        if !self.survives(simd, path, luminance, sums, choices) {
            return false;
        }
        if path.hits <= self.scene.max_depth {
            // All of them together are looked at as closely as one.
            self.raise_floor(path, luminance / share);
        }
        true
    }

    /// Adds what a branch finds that meets no further surface.
    #[inline(always)]
    pub(super) fn deliver<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        continuation: Continuation,
        scattered: Option<Scattered>,
        sums: &mut Sums<S>,
    ) {
        self.make_room(simd, 1);
        let to = self.target(continuation, path.slot, path.direction, scattered);
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let beam = self.beam(simd, path, block);
            xyz = self.splat(simd, to, block, beam.s, beam.p, xyz);
        }
        sums.0 = xyz;
    }
}
