//! Rough coatings, dielectrics and metals: a walk among microscopic facets ([`crate::microfacet`]), each of which answers as
//! the exact stack at its own angle, polarised.
//!
//! The whole spectrum goes the same way. At every facet the lights are sampled as if it were the last one; then one way is
//! drawn, mirrored or refracted, in proportion to luminance, until the ray gets out. Light sampling and what the
//! outgoing branch finds are shared out by the balance heuristic given the walk so far: densities there may be any, as long
//! as both techniques tell the same, so the share of mirrored light in them is that of a bare surface.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;

use super::direct::Scatters;
use super::{Continuation, FAINT, LATE_SURVIVAL, Path, Scattered, Since, Sums, Tracer};
use crate::coating::{IndexTable, LayersAt, Sequence};
use crate::film::{Beam, FilmTable, Phase, Response};
use crate::materials::CoatedSurface;
use crate::medium_stack::MediumStack;
use crate::microfacet::{Microfacets, Wanderer};
use crate::refraction::{bare_reflectance, is_parted, ratio};
use crate::rough::{Frame, RoughPlace, RoughSurface};
use crate::sampler::Choices;

/// After a rough hit a branch survives for certain down to this share of its luminance, as after a diffuse one.
const FLOOR_SHARE: f32 = 0.25;

/// Facets after which a walk is given up: at the roughest, half of what is left gets out at each.
pub(super) const MOST_FACETS: u32 = 64;

/// Least probability of either way at a facet that mirrors and refracts: a way without luminance may carry colour.
const LEAST_CHANCE: f32 = 0.02;

/// What light meets at a facet.
#[derive(Clone, Copy)]
pub(super) enum Stack<'b> {
    Film { table: &'b FilmTable, thickness_nm: f64, phase: Phase },
    Layers { media: [&'b IndexTable; 2], layers: LayersAt<'b>, is_reversed: bool, rate: &'b [Lanes] },
}

impl<'b> Stack<'b> {
    /// The layers as they are met from the side of the path or from beyond; `None` for a free film.
    #[inline(always)]
    fn sequence(&self, is_below: bool) -> Option<Sequence<'b>> {
        let Stack::Layers { media: [outer, exit], layers, is_reversed, rate } = *self else { return None };
        let (outer, exit) = if is_below { (exit, outer) } else { (outer, exit) };
        Some(Sequence { outer, layers, is_reversed: is_reversed != is_below, exit, rate })
    }

    /// What a facet does to a block of nodes, met from the side of the path or from beyond.
    #[inline(always)]
    pub(super) fn response<S: Simd>(&self, simd: S, is_below: bool, block: usize, cos_theta: f32) -> Response<S> {
        match (self, self.sequence(is_below)) {
            (_, Some(sequence)) => sequence.response(simd, block, cos_theta),
            (Stack::Film { table, thickness_nm, phase: Phase::Single }, _) => {
                table.response(simd, block, cos_theta, *thickness_nm as f32)
            }
            (Stack::Film { table, thickness_nm, phase }, _) => simd.vectorize(
                #[inline(always)]
                || table.long_response(simd, block, f64::from(cos_theta), *thickness_nm, *phase),
            ),
            (Stack::Layers { .. }, None) => unreachable!("layers have a sequence"),
        }
    }
}

/// A place of a rough surface that a ray has come to, among its facets.
#[derive(Clone, Copy)]
pub(super) struct Facets<'b> {
    pub ray: Wanderer,
    pub spread: Microfacets,
    pub frame: Frame,
    /// The normal of the surface itself, on the side of the path.
    pub facing: Vec3,
    pub stack: Stack<'b>,
    /// The index on the path's side over that beyond; `None` where nothing gets through.
    pub ratio: Option<f64>,
    /// The media on the two sides, and whether light that arrives there from a lamp would be absorbed on its way.
    pub media: [MediumStack; 2],
    pub is_dark: [bool; 2],
    /// What of the spectrum is refracted together.
    pub thinned: Option<&'b [Lanes]>,
}

impl Facets<'_> {
    /// The index before a facet over that beyond it.
    #[inline(always)]
    fn ratio(&self) -> Option<f64> {
        self.ratio.map(|ratio| if self.ray.is_below { 1.0 / ratio } else { ratio })
    }

    /// The facet, in the world, that sends the ray into a direction: its probability density given that it mirrors or
    /// refracts, and whether it mirrors.
    #[inline(always)]
    fn towards(&self, direction: Vec3) -> Option<(Vec3, f64, bool)> {
        let local = self.frame.local(direction);
        let side = usize::from(local.z < 0.0);
        // A direction that only the shading normal takes for one of this side does not leave the surface.
        let is_through = (direction.dot(self.facing) < 0.0) != (side == 1);
        if is_through || self.is_dark[side] {
            return None;
        }
        let is_mirrored = (side == 1) == self.ray.is_below;
        let (h, density) = if is_mirrored {
            self.ray.mirror_density(&self.spread, local)?
        } else {
            self.ray.refract_density(&self.spread, local, self.ratio()?)?
        };
        Some((self.frame.world(h), density, is_mirrored))
    }
}

impl Scatters for Facets<'_> {
    #[inline(always)]
    fn facing(&self) -> Vec3 {
        self.facing
    }

    #[inline(always)]
    fn density(&self, direction: Vec3) -> f64 {
        let Some((h, density, is_mirrored)) = self.towards(direction) else { return 0.0 };
        let Some(ratio) = self.ratio() else { return density };
        let cos = -self.frame.world(self.ray.direction).dot(h);
        let share = bare_reflectance(cos, ratio).clamp(0.02, 0.98);
        density * if is_mirrored { share } else { 1.0 - share }
    }

    #[inline(always)]
    fn evaluate<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64> {
        // One copy of it in the program, however many lamps ask.
        simd.vectorize(
            #[inline(always)]
            || self.send(simd, tracer, onward, direction, slot),
        )
    }
}

impl Facets<'_> {
    /// [`Scatters::evaluate`].
    #[inline(always)]
    fn send<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64> {
        let (h, density, is_mirrored) = self.towards(direction)?;
        tracer.copy_slot(onward, slot);
        tracer.rotate_stokes_frame_to(simd, onward, h);
        let cos_theta = (-onward.direction.dot(h)).clamp(0.0, 1.0) as f32;
        for block in 0..tracer.blocks {
            let response = self.stack.response(simd, self.ray.is_below, block, cos_theta);
            let matrix = if is_mirrored { &response.reflect } else { &response.transmit };
            let mut out = matrix.carry(&tracer.beam(simd, onward, block));
            if let (false, Some(weights)) = (is_mirrored, self.thinned) {
                out = scaled(&out, weights[block].load(simd));
            }
            tracer.store_beam(onward, block, &out);
        }
        onward.direction = direction;
        onward.is_unpolarized = false;
        onward.medium = self.media[usize::from(direction.dot(self.facing) < 0.0)];
        Some(density)
    }
}

#[inline(always)]
fn scaled<S: Simd>(beam: &Beam<S>, factor: f32x16<S>) -> Beam<S> {
    Beam { s: beam.s * factor, p: beam.p * factor, u: beam.u * factor, v: beam.v * factor }
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
        if !self.take_thicknesses(coating, &hit) {
            return false;
        }
        path.hits += 1;
        let thicknesses = std::mem::take(&mut self.thicknesses);
        let media = [&spectra.media[usize::from(medium.innermost())], &spectra.media[usize::from(sides.exit)]];
        let RoughPlace { facets: spread, frame, facing } = rough.at(&self.scene.geometry, &hit, path.direction);
        let bands = &spectra.bands;
        let (mut band, mut thinned) = (path.band, None);
        let mut weights = std::mem::take(&mut self.thinned);
        if !coating.is_opaque && band.is_none() && is_parted(bands, std::f64::consts::FRAC_1_SQRT_2, media) {
            let chosen = bands.choose(choices.pair());
            bands.weigh(chosen, &mut weights);
            band = Some(chosen);
            thinned = Some(&weights[..]);
        }
        let place = band.unwrap_or(bands.middle);
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
            thinned,
        };
        let found = self.walk(simd, path, &mut facets, band, sums, choices);
        let side = usize::from(facets.ray.is_below);
        (self.thicknesses, self.thinned) = (thicknesses, weights);
        let Some((luminance, density)) = found else { return false };
        path.medium = [medium, sides.beyond][side];
        let scattered = (density > 0.0).then_some(Scattered { origin: hit.point, density });
        self.leave_rough(simd, path, (facing, luminance), scattered, sums, choices)
    }

    /// From facet to facet until the ray gets out: the luminance that it carries then, and the density of its direction, 0
    /// where no lamp was sampled that way. `None` where nothing of it is left.
    #[inline(always)]
    fn walk<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        facets: &mut Facets<'_>,
        band: Option<f64>,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> Option<(f32, f64)> {
        let Some(spare) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut found = None;
        let mut luminance = 0.0;
        let mut density = 0.0;
        for _ in 0..MOST_FACETS {
            if !facets.ray.meets_facet(&facets.spread, choices.next().into()) {
                found = Some((luminance, density));
                break;
            }
            self.light_facet(simd, path, facets, sums, choices);
            if self.failure.is_some() {
                break;
            }
            let local = facets.ray.facet(&facets.spread, choices.pair());
            let h = facets.frame.world(local);
            self.rotate_stokes_frame_to(simd, path, h);
            path.is_unpolarized = false;
            let cos = (-path.direction.dot(h)).clamp(0.0, 1.0);
            let [mirrored_y, passed_y, passed] = self.split_at_facet(simd, path, facets, cos as f32, spare);
            let ratio = facets.ratio().filter(|_| passed > 0.0);
            let chance = match ratio {
                Some(_) => (mirrored_y / (mirrored_y + passed_y)).clamp(LEAST_CHANCE, 1.0 - LEAST_CHANCE),
                None => 1.0,
            };
            // NaN where there is no luminance at all.
            let chance = if chance.is_nan() { 0.5 } else { chance };
            let before = *facets;
            if let Some(ratio) = ratio
                && choices.next() >= chance
            {
                luminance = self.take_passed(simd, path, spare, facets.thinned.take(), 1.0 / (1.0 - chance), sums);
                path.band = band;
                let cosine2 = 1.0 - ratio * ratio * (1.0 - cos * cos);
                if cosine2 <= 0.0 {
                    // A little may pass at other nodes than the one that tells the direction: it finds the mean light.
                    self.add_mean_of(simd, path, sums);
                    break;
                }
                let direction = facets.ray.direction * ratio + local * (ratio * cos - cosine2.sqrt());
                facets.ray = facets.ray.passed(direction.normalized());
            } else {
                if chance < 1.0 {
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
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.direct_light(simd, path, facets, sums, choices),
        );
    }

    /// What a facet mirrors stays in the path's slot, what it passes goes to another: the luminances of both, and whether
    /// anything passes.
    #[inline(always)]
    fn split_at_facet<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        cos_theta: f32,
        passed: usize,
    ) -> [f32; 3] {
        let zero = f32x16::splat(simd, 0.0);
        let [mut mirrored_y, mut passed_y, mut any] = [zero; 3];
        let through = Path { slot: passed, ..*path };
        let Some(sequence) = facets.stack.sequence(facets.ray.is_below) else { return [0.0; 3] };
        for block in 0..self.blocks {
            let response = sequence.response(simd, block, cos_theta);
            let before = self.beam(simd, path, block);
            let (back, on) = (response.reflect.carry(&before), response.transmit.carry(&before));
            self.store_beam(path, block, &back);
            self.store_beam(&through, block, &on);
            let weight = self.spectra.importance[block].load(simd);
            mirrored_y = weight.mul_add(back.s + back.p, mirrored_y);
            passed_y = weight.mul_add(on.s + on.p, passed_y);
            any += on.s.abs() + on.p.abs();
        }
        [mirrored_y.reduce_sum(), passed_y.reduce_sum(), any.reduce_sum()]
    }

    /// Goes on with what has passed a facet, or with one band of it; gives the luminance.
    #[inline(always)]
    fn take_passed<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        passed: usize,
        thinned: Option<&[Lanes]>,
        factor: f32,
        sums: &mut Sums<S>,
    ) -> f32 {
        let mut luminance = f32x16::splat(simd, 0.0);
        let mut xyz = sums.0;
        let through = Path { slot: passed, ..*path };
        for block in 0..self.blocks {
            let mut on = scaled(&self.beam(simd, &through, block), f32x16::splat(simd, factor));
            if let Some(weights) = thinned {
                // What the other bands are expected to find is added for certain, whatever this one finds.
                let all = on.s + on.p;
                on = scaled(&on, weights[block].load(simd));
                xyz = self.add_mean(simd, block, all - (on.s + on.p), xyz);
            }
            self.store_beam(path, block, &on);
            luminance = self.spectra.importance[block].load(simd).mul_add(on.s + on.p, luminance);
        }
        sums.0 = xyz;
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

    /// A path that has got out from among facets: what it comes to.
    #[inline(always)]
    pub(super) fn leave_rough<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        (facing, luminance): (Vec3, f32),
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
            path.floor = (FLOOR_SHARE * luminance.max(path.floor)).max(FAINT);
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

    /// What a path carries in a block of nodes.
    #[inline(always)]
    pub(super) fn beam<S: Simd>(&self, simd: S, path: &Path, block: usize) -> Beam<S> {
        let zero = f32x16::splat(simd, 0.0);
        let mut beam = Beam {
            s: self.arena[self.at(path.slot, 0, block)].load(simd),
            p: self.arena[self.at(path.slot, 1, block)].load(simd),
            u: zero,
            v: zero,
        };
        if !path.in_plane {
            beam.u = self.arena[self.at(path.slot, 2, block)].load(simd);
            beam.v = self.arena[self.at(path.slot, 3, block)].load(simd);
        }
        beam
    }

    #[inline(always)]
    pub(super) fn store_beam<S: Simd>(&mut self, path: &Path, block: usize, beam: &Beam<S>) {
        let first = self.at(path.slot, 0, block);
        self.arena[first].store(beam.s);
        self.arena[first + self.blocks].store(beam.p);
        if !path.in_plane {
            self.arena[first + 2 * self.blocks].store(beam.u);
            self.arena[first + 3 * self.blocks].store(beam.v);
        }
    }

    /// Gives a path a slot of its own, with all that it carries.
    #[inline(always)]
    pub(super) fn copy_slot(&mut self, path: &mut Path, slot: usize) {
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        let (from, to) = (self.at(path.slot, 0, 0), self.at(slot, 0, 0));
        self.arena.copy_within(from..from + count, to);
        path.slot = slot;
    }
}
