//! Light of small lamps that comes to a surface over mirrors and through lenses: directions are sampled that lead there
//! ([`crate::caustics`]), and only what they were sampled for counts, a lamp at the end of its chain.
//!
//! The surface's own branch finds that lamp along that chain too: both are weighted by the balance heuristic, for which a
//! branch remembers the place it left and what it did since. Chains of which little is expected are looked for now and then.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;

use super::Tracer;
use super::direct::Scatters;
use super::path::{Continuation, Found, Path, Scattered, Since, Sums, Target};
use super::specular::{Expected, Sides};
use crate::caustics::{Departure, Lobe, Search, Told};
use crate::chain::Chain;
use crate::coating::{LayersAt, Sequence};
use crate::failure::PathFailure;
use crate::lights::chooser::LightId;
use crate::lights::seeds::{Candidate, Strength};
use crate::materials::{CoatedSurface, FilmSurface, Material};
use crate::refraction::shading_normal;
use crate::sampler::Choices;
use crate::specular_ray::SpecularRay;

/// Share of a place's light below which a chain is not always looked for.
const FAINT_CHAIN: f64 = 0.1;

/// Probability with which chains are looked for that carry little light there: of suns and lamps without size, which make no other noise,
/// and of lamps with a size, whose shadows make more.
const FAINT_PICKS: f64 = 1.0 / 16.0;
const FAINT_PICKS_OF_EMITTERS: f64 = 1.0 / 64.0;

/// Least probability with which it is.
const LEAST_PICKS: f64 = 0.1;

/// Square of the distance from a direction that was found, in sizes of its triangle, within which another is the same one.
const NEIGHBOUR: f64 = 0.1;

/// Places within the triangles of a chain from which a lamp is looked for.
const TRIES: usize = 8;

/// How often a chain of a light is looked for that carries little there.
#[inline(always)]
fn faint_picks(light: LightId) -> f64 {
    if matches!(light, LightId::Emitter(_)) { FAINT_PICKS_OF_EMITTERS } else { FAINT_PICKS }
}

/// How often a chain is looked for, on average; of a bright one so much is expected, `of` all light.
#[inline(always)]
fn picks(light: LightId, strength: Strength, expected: f64, of: f64) -> f64 {
    if strength == Strength::Faint {
        return faint_picks(light);
    }
    (expected / (FAINT_CHAIN * of)).clamp(LEAST_PICKS, 1.0)
}

/// What candidates of one light and one chain promise together.
fn irradiance(group: &[Candidate]) -> f64 {
    group.iter().map(|candidate| candidate.irradiance).sum()
}

impl Tracer<'_> {
    /// Remembers the place that a branch leaves, if caustics are sampled there.
    #[inline(always)]
    pub(super) fn depart(&mut self, path: &mut Path, facing: Vec3, direction: Vec3, scattered: Option<Scattered>) {
        path.chain = Chain::UNTOLD;
        if let (Some(_), Some(Scattered { density, .. })) = (&self.scene.seeds, scattered) {
            let from = Departure { hit: path.hit, medium: path.medium, facing, band: path.band };
            self.caustics.told[path.slot] = Some(Told { from, direction, density, chosen: self.caustics.chosen });
            path.chain = Chain::START;
        }
    }

    /// A branch takes another slot.
    #[inline(always)]
    pub(super) fn copy_told(&mut self, from: usize, to: usize) {
        if self.scene.seeds.is_some() {
            self.caustics.told[to] = self.caustics.told[from];
        }
    }

    /// What a branch that a surface mirrors or passes comes to, with its weight among the techniques.
    #[inline(always)]
    pub(super) fn shared(&self, found: Continuation, path: &Path, mirrors: bool) -> Continuation {
        match found {
            Continuation::Emitter(emitter, share) if path.chain != Chain::UNTOLD => {
                let light = LightId::Emitter(emitter);
                Continuation::Emitter(emitter, share * self.caustic_mis_weight(path, path.chain.then(mirrors), light))
            }
            found => found,
        }
    }

    /// The same for the sun that it leaves the scene for.
    #[inline(always)]
    pub(super) fn share_sun(&mut self, target: Target, path: &Path, mirrors: bool) {
        if path.chain == Chain::UNTOLD {
            return;
        }
        if let Target::Out(out) | Target::Told(Found::Out(out)) = target
            && let Some((sun, share)) = self.escaped.shares[out].sun
        {
            let weight = self.caustic_mis_weight(path, path.chain.then(mirrors), LightId::Sun(sun));
            self.escaped.shares[out].sun = Some((sun, share * weight));
        }
    }

    /// The weight of a light that a path has come to over mirrors and through lenses, by the balance heuristic.
    #[inline(never)]
    pub(super) fn caustic_mis_weight(&self, path: &Path, chain: Chain, light: LightId) -> f32 {
        let (Some(seeds), Some(told)) = (&self.scene.seeds, &self.caustics.told[path.slot]) else { return 1.0 };
        if chain == Chain::UNTOLD || !seeds.has(light) || told.direction.dot(told.from.facing) <= 0.0 {
            return 1.0;
        }
        let mut candidates = Vec::new();
        let is_own = |candidate: &Candidate| candidate.light == light && candidate.chain == chain;
        let Some(strength) = [Strength::Bright, Strength::Faint].into_iter().find(|strength| {
            seeds.find(told.from.hit.point, *strength, &mut candidates);
            candidates.iter().any(is_own)
        }) else {
            return 1.0;
        };
        let of = irradiance(&candidates) + self.spectra.lights.all_expected(told.from.hit.point);
        candidates.retain(is_own);
        let picks = picks(light, strength, irradiance(&candidates), of);
        // Of wavelengths that were parted on the way the place is known; else the one that was looked at.
        let chosen = path.band.unwrap_or(told.chosen);
        let mut lobes = Vec::new();
        self.find_lobes(&told.from, chosen, &candidates, &mut lobes);
        let sampled: f64 = lobes.iter().map(|lobe| lobe.density(told.direction)).sum();
        (told.density / (told.density + picks * sampled)) as f32
    }

    /// The lobes of one light and one chain.
    fn find_lobes(&self, from: &Departure, chosen: f64, group: &[Candidate], lobes: &mut Vec<Lobe>) {
        let search = Search { scene: self.scene, spectra: self.spectra, from, chosen };
        lobes.clear();
        // All over the group where it is larger.
        let tries = group.len().min(TRIES);
        let mut folded = [false; TRIES];
        for k in 0..tries {
            let candidate = &group[k * group.len() / tries];
            let seen = self.scene.seeds.as_ref().and_then(|seeds| seeds.seen(candidate, from.hit.point));
            let Some((direction, spread2)) = seen else { continue };
            // Where triangles overlap, the neighbour has found it.
            let is_found = lobes.iter().zip(folded).any(|(lobe, is_folded)| {
                is_folded == candidate.is_folded && (lobe.axis - direction).length_squared() < NEIGHBOUR * spread2
            });
            if !is_found {
                folded[lobes.len()] = candidate.is_folded;
                search.add(candidate.light, candidate.chain, direction, lobes);
            }
        }
    }

    /// Samples the caustics: how much of the light of small lamps arrives over mirrors and through lenses.
    #[inline(always)]
    pub(super) fn caustic_light<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let Some(seeds) = &self.scene.seeds else { return };
        let bands = &self.spectra.bands;
        self.caustics.chosen = match path.band {
            Some(band) => band,
            None if seeds.disperses => bands.choose(choices.pair()),
            None => bands.middle,
        };
        let mut candidates = std::mem::take(&mut self.caustics.candidates);
        let mut pair = None;
        for strength in [Strength::Bright, Strength::Faint] {
            let taken = if strength == Strength::Faint { f64::from(choices.next()) } else { 0.0 };
            if taken >= seeds.lights.iter().map(|light| faint_picks(*light)).fold(0.0, f64::max) {
                continue;
            }
            seeds.find(path.hit.point, strength, &mut candidates);
            if candidates.is_empty() {
                continue;
            }
            candidates.sort_by_key(|candidate| (candidate.light, candidate.chain));
            let of = irradiance(&candidates) + self.spectra.lights.all_expected(path.hit.point);
            let from = Departure { hit: path.hit, medium: path.medium, facing: scatters.facing(), band: path.band };
            let pair = *pair.get_or_insert_with(|| choices.pair());
            let mut lobes = std::mem::take(&mut self.caustics.lobes);
            for group in candidates.chunk_by(|a, b| a.light == b.light && a.chain == b.chain) {
                let picks = picks(group[0].light, strength, irradiance(group), of);
                if taken >= picks || strength == Strength::Bright && picks < 1.0 && f64::from(choices.next()) >= picks {
                    continue;
                }
                self.find_lobes(&from, self.caustics.chosen, group, &mut lobes);
                for (number, lobe) in lobes.iter().enumerate() {
                    // One pair for all: turned for each, it is as even.
                    let turned = [0.618_033_988_749_895, 0.754_877_666_246_693].map(|turn| turn * number as f64);
                    let pair = ((pair.0 + turned[0]).fract(), (pair.1 + turned[1]).fract());
                    self.connect_lobe(simd, path, scatters, (lobe, &lobes, picks), pair, sums);
                }
            }
            self.caustics.lobes = lobes;
        }
        self.caustics.candidates = candidates;
    }

    /// Samples a lobe.
    #[inline(always)]
    fn connect_lobe<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        (lobe, lobes, picks): (&Lobe, &[Lobe], f64),
        pair: (f64, f64),
        sums: &mut Sums<S>,
    ) {
        let is_delta = matches!(lobe.light, LightId::Delta(_));
        let direction = if is_delta { lobe.axis } else { lobe.draw(pair) };
        let own = scatters.density(direction);
        if !(own > 0.0 && direction.dot(scatters.facing()) > 0.0) {
            return;
        }
        let density = if is_delta {
            picks / lobe.irradiance()
        } else {
            own + picks * lobes.iter().map(|lobe| lobe.density(direction)).sum::<f64>()
        };
        if !(density > 0.0 && density < f64::INFINITY) {
            return;
        }
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut way = *path;
        if let Some(value) = scatters.evaluate(simd, self, &mut way, direction, slot) {
            let (chain, light) = (lobe.chain, lobe.light);
            simd.vectorize(
                #[inline(always)]
                || {
                    if let Some(share) = self.carry(simd, &mut way, chain, light, slot) {
                        self.contribute(simd, &way, light, (value * share / density) as f32, sums);
                    }
                },
            );
        }
        self.free.push(slot);
    }

    /// Takes a path along a chain to a light; its spectra then stand in `slot`. The share of the light that it sends there,
    /// `None` if it does not come to it.
    #[inline(always)]
    fn carry<S: Simd>(&mut self, simd: S, way: &mut Path, chain: Chain, light: LightId, slot: usize) -> Option<f64> {
        let (scene, spectra, chosen) = (self.scene, self.spectra, self.caustics.chosen);
        if way.slot != slot {
            let (from, to) = (self.at(way.slot, 0, 0), self.at(slot, 0, 0));
            self.arena.copy_within(from..from + 2 * self.blocks, to);
            way.slot = slot;
        }
        let mut is_bent = false;
        for mirrors in chain.events() {
            way.hit = scene.next_that_is_there(&way.hit, way.direction, &mut way.medium)?;
            self.attenuate(simd, way);
            let mut along =
                SpecularRay { hit: way.hit, direction: way.direction, medium: way.medium, band: way.band, is_bent };
            along.turn(scene, spectra, mirrors, chosen)?;
            if scene.geometry.is_shaded(way.hit.object) {
                way.hit.normal = shading_normal(&scene.geometry, &way.hit, way.direction);
            }
            match &scene.materials[way.hit.object] {
                Material::Film(film) => self.carry_over_film(simd, way, film, mirrors)?,
                Material::Coating(coating) => {
                    let is_parted = way.band.is_none() && along.band.is_some();
                    self.carry_over_coating(simd, way, coating, mirrors, is_parted)?;
                }
                Material::Diffuse { .. } | Material::Emitter(_) => return None,
            }
            (way.direction, way.medium, way.band, is_bent) = (along.direction, along.medium, along.band, along.is_bent);
            way.is_unpolarized = false;
        }
        // What comes straight is found otherwise.
        if !is_bent {
            return None;
        }
        way.since = Since::Bend;
        let next = scene.next_that_is_there(&way.hit, way.direction, &mut way.medium);
        match light {
            LightId::Emitter(emitter) => {
                way.hit = next.filter(
                    |next| matches!(scene.materials[next.object], Material::Emitter(there) if there == emitter),
                )?;
                self.attenuate(simd, way);
                Some(1.0)
            }
            _ if self.is_dark(way.medium) => None,
            LightId::Sun(sun) => (next.is_none() && spectra.lights.suns[sun].is_at(way.direction)).then_some(1.0),
            LightId::Delta(delta) => {
                let seen = spectra.lights.deltas[delta].source.seen(way.hit.point)?;
                if next.is_some_and(|next| next.distance < seen.distance) {
                    return None;
                }
                let far2 = seen.distance * seen.distance;
                Some(if far2.is_finite() { seen.irradiance * far2 } else { seen.irradiance })
            }
            LightId::Maps => None,
        }
    }

    /// Mirrors or passes a film.
    #[inline(always)]
    fn carry_over_film<S: Simd>(&mut self, simd: S, way: &mut Path, film: &FilmSurface, mirrors: bool) -> Option<()> {
        let is_in = way.medium.innermost();
        if is_in != film.outside && !self.scene.media.are_one(is_in, film.outside) {
            let (object, expected) = (way.hit.object, film.outside);
            self.failure = Some(PathFailure::WrongMedium { object, is_in, expected });
            return None;
        }
        let thickness = film.layer.thickness_nm(&self.scene.geometry, &way.hit);
        let phase = self.phase(film.layer.path_nm(thickness))?;
        self.rotate_stokes_frame(simd, way);
        self.take_branch_of_film(simd, way, film.number, (thickness, phase), mirrors);
        Some(())
    }

    /// Mirrors or passes a coated or bare surface. `is_parted`: one place in the spectrum goes on.
    #[inline(always)]
    fn carry_over_coating<S: Simd>(
        &mut self,
        simd: S,
        way: &mut Path,
        coating: &CoatedSurface,
        mirrors: bool,
        is_parted: bool,
    ) -> Option<()> {
        let spectra = self.spectra;
        let Sides { exit, is_reversed, .. } = self.sides(way, coating)?;
        self.take_thicknesses(coating, &way.hit)?;
        self.rotate_stokes_frame(simd, way);
        let (thicknesses, mut weights) = (std::mem::take(&mut self.thicknesses), std::mem::take(&mut self.thinned));
        if is_parted {
            spectra.bands.weigh(self.caustics.chosen, &mut weights);
        }
        let sequence = Sequence {
            outer: &spectra.media[usize::from(way.medium.innermost())],
            layers: LayersAt { tables: &spectra.coatings[coating.number], thickness_nm: &thicknesses },
            is_reversed,
            exit: &spectra.media[usize::from(exit)],
            rate: &spectra.rate,
        };
        let cos_theta = way.direction.dot(way.hit.normal).abs().min(1.0) as f32;
        let mut to = [Target::Nowhere; 2];
        to[usize::from(!mirrors)] = Target::Slot(way.slot);
        // What the other wavelengths find is not looked at: their own paths do that.
        let thinned = is_parted.then_some((&weights[..], Expected::Nothing));
        let mut unused = Sums([f32x16::splat(simd, 0.0); 3]);
        self.split_coating(simd, way, &sequence, cos_theta, to, thinned, &mut unused);
        (self.thicknesses, self.thinned) = (thicknesses, weights);
        Some(())
    }
}
