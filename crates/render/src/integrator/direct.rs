//! Light that arrives straight at a surface that scatters it: the lights are sampled (next event estimation).
//!
//! What a branch that the surface sends on can find as well is shared out between the two techniques by the balance
//! heuristic, in proportion to their densities per solid angle
//! (E. Veach, L. J. Guibas, "Optimally combining sampling techniques for Monte Carlo rendering", SIGGRAPH 1995). Films do not bend light, so a point sees the lights straight through them: both techniques count
//! such a film as part of the way. Mirrors find lights by BSDF sampling only, and those without size not at all; what they throw onto
//! surfaces that scatter is sampled in `caustics.rs`.
//!
//! A few lights are all sampled; of many, two are, in proportion to what is expected of them ([`crate::lights::chooser`]). The
//! maps are always sampled, and by that alone: of thirty-two directions, half by the light of the maps and half as the surface itself would
//! go on, one is taken in proportion to light times what the surface makes of it, and only that one's spectrum and way are looked at
//! (J. F. Talbot, D. Cline, P. Egbert, "Importance resampling for global illumination", EGSR 2005). The branch that the surface sends on
//! finds what is not infinitely far away.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

use super::Tracer;
use super::escaped::Share;
use super::path::{Path, Scattered, Since, Sums, Target};
use crate::chain::Chain;
use crate::failure::PathFailure;
use crate::film::Phase;
use crate::geometry::{Hit, cone_density, cone_direction};
use crate::lights::Source;
use crate::lights::chooser::{FEW, LightId, PICKS, pick};
use crate::materials::Material;
use crate::prepare::MOST_FILMS;
use crate::refraction::shading_normal;
use crate::sampler::Choices;

/// Density of a surface's own branch, over that of light sampling, below which it does not look for a sun at all: a diffuse
/// one would find it once in thousands of times, and then count for little.
const LOOKS_FOR_SUN: f64 = 0.01;

/// What many directions are drawn by together.
pub(super) trait Draws {
    /// Sixteen directions that are as likely as [`Draws::lanes`] tells, from points of the unit square; where it fails, ways that
    /// the surface does not go.
    fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES], choices: &mut Choices) -> [f32x16<S>; 3];

    /// Of sixteen directions how likely each is drawn, per solid angle, and what is in proportion to about the light that goes on from
    /// there: more than 0 wherever there is any.
    fn lanes<S: Simd>(&self, simd: S, ways: &[f32x16<S>; 3]) -> [f32x16<S>; 2];
}

/// What sends a path on.
pub(super) trait Sends {
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

/// A surface, at the place where a path has met it, that sends light on in more than single directions.
pub(super) trait Scatters: Draws + Sends {
    /// Probability per solid angle with which the surface itself sends its branch on in a direction; more than 0 wherever
    /// [`Sends::evaluate`] gives anything.
    fn density(&self, direction: Vec3) -> f64;

    /// The normal of the surface itself on the side from which the path has come.
    fn facing(&self) -> Vec3;
}

/// A light that was sampled: where it is seen, how far away, and its contribution's divisor: the probability per solid angle
/// with which it was found there, by all techniques that share it.
pub(super) struct Sampled {
    light: LightId,
    pub(super) direction: Vec3,
    distance: f64,
    pub(super) density: f64,
}

/// One of the directions that were looked at together.
pub(super) struct Chosen {
    pub(super) sampled: Sampled,
    /// Its lane, and what [`Draws::lanes`] has told of it.
    pub(super) lane: usize,
    pub(super) target: f64,
}

impl Tracer<'_> {
    /// Samples the lights: how much of them arrives here straight. Nothing does within a medium that absorbs, where only
    /// what the surface's own branch finds counts.
    #[inline(always)]
    pub(super) fn direct_light<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        scatters: &impl Scatters,
        with_maps: bool,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let lights = &self.spectra.lights;
        let (count, suns) = (lights.count(), lights.suns.len());
        let is_few = count <= FEW;
        let mut expected = std::mem::take(&mut self.expected);
        let mut random = 0.0;
        if !is_few {
            lights.add_up_expected(path.hit.point, &mut expected);
            // The picks are spread out: one random number for all of them.
            random = choices.pair().0;
        }
        // One loop for all kinds: what is in it is compiled in place, once.
        for k in 0..1 + if is_few { count } else { PICKS } {
            let (light, picks) = match is_few {
                true if k < suns => (lights.id(k), 1.0),
                true if k == suns => (LightId::Maps, 1.0),
                true => (lights.id(k - 1), 1.0),
                false if k == PICKS => (LightId::Maps, 1.0),
                false => {
                    let (at, picks) = pick(&expected, (random + k as f64) / PICKS as f64);
                    (lights.id(at), picks)
                }
            };
            let sampled = if light != LightId::Maps {
                let sampled = self.sample_light(path.hit.point, scatters, light, picks, choices);
                sampled.filter(|sampled| scatters.density(sampled.direction) > 0.0)
            } else if with_maps {
                let chosen = simd.vectorize(
                    #[inline(always)]
                    || self.sample_maps(simd, scatters, choices),
                );
                chosen.map(|chosen| chosen.sampled)
            } else {
                None
            };
            if let Some(sampled) = sampled {
                self.connect(simd, path, scatters, &sampled, sums, choices);
            }
        }
        self.expected = expected;
        if self.scene.seeds.is_some() {
            simd.vectorize(
                #[inline(always)]
                || self.caustic_light(simd, path, scatters, sums, choices),
            );
        }
    }

    /// Samples the maps: one of thirty-two directions, by their light and the surface.
    #[inline(always)]
    pub(super) fn sample_maps<S: Simd>(&self, simd: S, draws: &impl Draws, choices: &mut Choices) -> Option<Chosen> {
        let lights = &self.spectra.lights;
        let sampler = lights.sampler.as_ref()?;
        let drawn = sampler.draw_lanes(simd, &choices.pairs(LANES as u32).points());
        let own = draws.draw_lanes(simd, &lattice(choices.pair()), choices);
        let halves = [drawn, own].map(|ways| (ways, sampler.around(simd, &ways)));
        let (zero, each) = (f32x16::splat(simd, 0.0), 1.0 / LANES as f32);
        let [mut targets, mut parts] = [[zero; 2]; 2];
        for (half, (ways, around)) in halves.iter().enumerate() {
            let [density, target] = draws.lanes(simd, ways);
            // Every colour counts: what is seen may have gone through a filter.
            targets[half] = target.max(zero) * around.lights;
            parts[half] = targets[half] * each / (density + around.densities);
        }
        let all = parts.map(|part| part.reduce_sum());
        // The surface's own lie in order: the samples of a pixel, whose numbers here are spread out, take from all of them.
        let mut taken = (all[0] + all[1]) * choices.pair().0 as f32;
        let half = usize::from(taken >= all[0]);
        taken -= if half == 0 { 0.0 } else { all[0] };
        let lane = lane_of(&parts[half].to_array(), taken)?;
        let [x, y, z] = halves[half].0.map(|lanes| f64::from(lanes.to_array()[lane]));
        let target = targets[half].to_array()[lane];
        let sampled = Sampled {
            light: LightId::Maps,
            direction: Vec3::new(x, y, z).normalized(),
            distance: f64::INFINITY,
            density: f64::from(target) / f64::from(all[0] + all[1]),
        };
        Some(Chosen { sampled, lane, target: f64::from(target / halves[half].1.lights.to_array()[lane]) })
    }

    /// Samples a light that is sampled so many times on average.
    #[inline(always)]
    fn sample_light(
        &self,
        from: Vec3,
        scatters: &impl Scatters,
        light: LightId,
        picks: f64,
        choices: &mut Choices,
    ) -> Option<Sampled> {
        let lights = &self.spectra.lights;
        let mut distance = f64::INFINITY;
        let (direction, density) = match light {
            LightId::Maps => return None,
            LightId::Sun(sun) => {
                let disc = &lights.suns[sun];
                let (direction, density) = cone_direction(disc.direction, disc.cos_radius, choices.pair());
                let (density, scattered) = (density * picks, scatters.density(direction));
                (direction, if looks_for_sun(scattered, density) { density + scattered } else { density })
            }
            LightId::Emitter(emitter) => {
                let object = lights.area_lights[emitter].object;
                let (direction, density) = self.scene.geometry.draw(object, from, choices.pair())?;
                (direction, density * picks + scatters.density(direction))
            }
            LightId::Delta(delta) => {
                let seen = lights.deltas[delta].source.seen(from)?;
                distance = seen.distance;
                (seen.direction, picks / seen.irradiance)
            }
        };
        Some(Sampled { light, direction, distance, density })
    }

    /// Adds the light that arrives from a direction over its density, if nothing but films stands before it.
    #[inline(always)]
    pub(super) fn connect<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        sends: &impl Sends,
        sampled: &Sampled,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let &Sampled { light, direction, distance, density } = sampled;
        if !(density > 0.0 && density < f64::INFINITY) {
            return;
        }
        let scene = self.scene;
        let mut left = distance;
        let mut medium = path.medium;
        let mut next = scene.next_that_is_there(&path.hit, direction, &mut medium);
        // Not before it is known that anything at all comes from there; beyond the surface others may be hidden.
        let mut arrives = self.may_arrive(next.as_ref(), light, left);
        if !arrives && !scene.has_priorities {
            return;
        }
        let Some(slot) = self.free.pop() else { unreachable!("one slot is kept for this") };
        let mut way = *path;
        if let Some(value) = sends.evaluate(simd, self, &mut way, direction, slot) {
            if scene.has_priorities {
                if way.medium != path.medium {
                    // It passed the surface: what is hidden from there may be another.
                    medium = way.medium;
                    next = scene.next_that_is_there(&path.hit, direction, &mut medium);
                    arrives = self.may_arrive(next.as_ref(), light, left);
                }
                way.medium = medium;
            }
            let mut crossed = 0;
            while arrives {
                match next {
                    Some(film) if film.distance < left && self.is_film(&film) => {
                        left -= film.distance;
                        crossed += 1;
                        if crossed > MOST_FILMS {
                            self.failure = Some(PathFailure::SamePlace { object: film.object });
                            break;
                        }
                        if !self.pass_film(simd, &mut way, film, slot, choices) {
                            break;
                        }
                    }
                    _ => {
                        self.contribute(simd, &way, light, (value / density) as f32, sums);
                        break;
                    }
                }
                let from = way.hit;
                next = scene.next_that_is_there(&from, direction, &mut way.medium);
                arrives = self.may_arrive(next.as_ref(), light, left);
            }
        }
        self.free.push(slot);
    }

    #[inline(always)]
    fn is_film(&self, hit: &Hit) -> bool {
        matches!(self.scene.materials[hit.object], Material::Film(_))
    }

    /// Whether what a ray towards a light, at this distance, meets next is that light, or lets it through.
    #[inline(always)]
    fn may_arrive(&self, next: Option<&Hit>, light: LightId, distance: f64) -> bool {
        let Some(next) = next else { return !matches!(light, LightId::Emitter(_)) };
        match (&self.scene.materials[next.object], light) {
            (Material::Film(_), _) => true,
            (Material::Emitter(emitter), LightId::Emitter(sampled)) => *emitter == sampled,
            (_, LightId::Delta(_)) => next.distance >= distance,
            _ => false,
        }
    }

    /// Takes a path straight through a film; its spectra then stand in `slot`. False if the pixel cannot be finished.
    #[inline(always)]
    fn pass_film<S: Simd>(&mut self, simd: S, way: &mut Path, next: Hit, slot: usize, choices: &mut Choices) -> bool {
        let Material::Film(film) = &self.scene.materials[next.object] else { return false };
        if way.medium.innermost() != film.outside && !self.scene.media.are_one(way.medium.innermost(), film.outside) {
            let (is_in, expected) = (way.medium.innermost(), film.outside);
            self.failure = Some(PathFailure::WrongMedium { object: next.object, is_in, expected });
            return false;
        }
        let thickness = film.layer.thickness_nm(&self.scene.geometry, &next);
        let Some(phase) = self.phase(film.layer.path_nm(thickness)) else { return false };
        if way.slot != slot {
            let (from, to) = (self.at(way.slot, 0, 0), self.at(slot, 0, 0));
            self.arena.copy_within(from..from + 2 * self.blocks, to);
            way.slot = slot;
        }
        way.hit = next;
        if self.scene.geometry.is_shaded(next.object) {
            // As what goes on by the surface's own branch meets it.
            way.hit.normal = shading_normal(&self.scene.geometry, &way.hit, way.direction);
        }
        if let Some(rough) = &film.rough {
            return simd.vectorize(
                #[inline(always)]
                || self.pass_rough_film(simd, way, (film, rough), choices),
            );
        }
        self.rotate_stokes_frame(simd, way);
        self.take_branch_of_film(simd, way, film.number, (thickness, phase), false);
        way.is_unpolarized = false;
        true
    }

    /// Makes of what a path carries what a film mirrors of it, or passes.
    #[inline(always)]
    pub(super) fn take_branch_of_film<S: Simd>(
        &mut self,
        simd: S,
        way: &Path,
        film: usize,
        (thickness, phase): (f64, Phase),
        mirrors: bool,
    ) {
        let cos_theta = way.direction.dot(way.hit.normal).abs().min(1.0);
        let mut to = [Target::Nowhere; 2];
        to[usize::from(!mirrors)] = Target::Slot(way.slot);
        // The other branch is not looked at: that goes its own way.
        let mut unused = Sums([f32x16::splat(simd, 0.0); 3]);
        if phase == Phase::Single {
            self.split_film(simd, way, film, cos_theta as f32, thickness as f32, to, &mut unused);
        } else {
            simd.vectorize(
                #[inline(always)]
                || self.split_long_film(simd, way, film, (cos_theta, thickness, phase), to, &mut unused),
            );
        }
    }

    #[inline(always)]
    pub(super) fn contribute<S: Simd>(&mut self, simd: S, way: &Path, light: LightId, factor: f32, sums: &mut Sums<S>) {
        if light == LightId::Maps {
            self.make_room(simd, 1);
            let out = self.escaped.push(way.direction, Share { maps: 1.0, sun: None });
            for block in 0..self.blocks {
                let s = self.arena[self.at(way.slot, 0, block)].load(simd);
                let p = self.arena[self.at(way.slot, 1, block)].load(simd);
                self.escaped.carried[out * self.blocks + block].store((s + p) * factor);
            }
            return;
        }
        self.add_light(simd, way, light, factor, sums);
    }

    /// Adds a share of a light that a path has come to straight.
    #[inline(always)]
    pub(super) fn add_light<S: Simd>(&mut self, simd: S, way: &Path, light: LightId, share: f32, sums: &mut Sums<S>) {
        let lights = &self.spectra.lights;
        let stokes = lights.linear(light).filter(|_| !way.is_unpolarized);
        let stokes = stokes.map(|linear| linear.stokes(-way.direction, way.axis).map(|v| v as f32));
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(way.slot, 0, block)].load(simd);
            let p = self.arena[self.at(way.slot, 1, block)].load(simd);
            let mut carried = s + p;
            if let Some([q, u]) = stokes {
                // Twice w_I + q w_Q + u w_U.
                carried += (s - p) * q;
                if !way.in_plane {
                    carried += self.arena[self.at(way.slot, 2, block)].load(simd) * (2.0 * u);
                }
            }
            xyz = lights.add_light(simd, light, block, carried * share, xyz);
            self.tell(Source::Light(light), block, carried * share);
        }
        sums.0 = xyz;
    }

    /// Adds what a path finds that has left the scene where suns overlap or are polarised.
    #[inline(always)]
    pub(super) fn add_beyond<S: Simd>(&mut self, simd: S, path: &Path, sums: &mut Sums<S>) {
        let lights = &self.spectra.lights;
        let scattered = self.scattered(path);
        let is_backdrop = path.since == Since::Camera;
        for sun in 0..lights.suns.len() {
            if lights.suns[sun].is_at(path.direction) && !(is_backdrop && lights.suns[sun].is_of_sky) {
                let mut share = self.sun_mis_weight(sun, scattered);
                if path.since == Since::Bend && path.chain != Chain::UNTOLD {
                    share *= self.caustic_mis_weight(path, path.chain, LightId::Sun(sun));
                }
                self.add_light(simd, path, LightId::Sun(sun), share, sums);
            }
        }
        if is_backdrop {
            for block in 0..self.blocks {
                let s = self.arena[self.at(path.slot, 0, block)].load(simd);
                let p = self.arena[self.at(path.slot, 1, block)].load(simd);
                self.add_share(simd, block, s + p);
            }
            return;
        }
        let maps = self.environment_mis_weight(scattered);
        self.make_room(simd, 1);
        let out = self.escaped.push(path.direction, Share { maps, sun: None });
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            self.escaped.carried[out * self.blocks + block].store(s + p);
            xyz = lights.add_uniform(simd, block, s + p, xyz);
            self.tell(Source::Uniform, block, s + p);
        }
        sums.0 = xyz;
    }

    /// The weight of an emitter that a scattered branch meets, by the balance heuristic: light sampling finds the rest.
    #[inline(always)]
    pub(super) fn emitter_mis_weight(&self, scattered: Option<Scattered>, next: &Hit) -> f32 {
        let Some(Scattered { origin, density }) = scattered else { return 1.0 };
        let Material::Emitter(emitter) = self.scene.materials[next.object] else { return 1.0 };
        let picks = self.spectra.lights.expected_picks(LightId::Emitter(emitter), origin);
        let sampled = picks * self.scene.geometry.density(next.object, origin, next.point);
        (density / (density + sampled)) as f32
    }

    /// The same for a sun, which branches that would hardly ever find it do not look for.
    #[inline(always)]
    pub(super) fn sun_mis_weight(&self, sun: usize, scattered: Option<Scattered>) -> f32 {
        let Some(Scattered { origin, density }) = scattered else { return 1.0 };
        let lights = &self.spectra.lights;
        let picks = lights.expected_picks(LightId::Sun(sun), origin);
        let sampled = picks * cone_density(lights.suns[sun].cos_radius);
        if looks_for_sun(density, sampled) { (density / (density + sampled)) as f32 } else { 0.0 }
    }

    /// The same for the maps, which scattered branches leave to light sampling.
    #[inline(always)]
    pub(super) fn environment_mis_weight(&self, scattered: Option<Scattered>) -> f32 {
        if scattered.is_some() && self.spectra.lights.sampler.is_some() { 0.0 } else { 1.0 }
    }
}

/// A lattice of sixteen points, moved about, in the order of their second numbers: each of them is anywhere, and together they lie evenly.
#[inline(always)]
pub(super) fn lattice((a, b): (f64, f64)) -> [(f64, f64); LANES] {
    let count = LANES as f64;
    let lowest = LANES - (b * count) as usize;
    std::array::from_fn(|i| {
        let number = (lowest + i) % LANES;
        // The bits of the number in the other order, and in theirs.
        let bits = (number as u8).reverse_bits() >> 4;
        (wrapped(a + f64::from(bits) / count), wrapped(b + number as f64 / count))
    })
}

/// Which of sixteen parts a number falls into that is below their sum; the last of them where rounding leads beyond. `None` where there are
/// none.
#[inline(always)]
pub(super) fn lane_of(parts: &[f32; LANES], number: f32) -> Option<usize> {
    let mut sum = 0.0;
    let found = parts.iter().position(|part| {
        sum += part;
        sum > number
    });
    found.or_else(|| parts.iter().rposition(|part| *part > 0.0))
}

/// Into [0, 1).
#[inline(always)]
fn wrapped(value: f64) -> f64 {
    if value >= 1.0 { value - 1.0 } else { value }
}

/// Whether a surface's own branch shares in finding a sun, by its density and that of light sampling.
#[inline(always)]
fn looks_for_sun(scattered: f64, sampled: f64) -> bool {
    scattered > LOOKS_FOR_SUN * sampled
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In each sixteenth of either number one point, and the second numbers rise.
    #[test]
    fn lattices_lie_evenly_and_in_order() {
        for shift in [(0.0, 0.0), (0.99, 0.03), (0.3, 0.0625), (0.51, 0.999_999_999)] {
            let points = lattice(shift);
            let strip = |value: f64| (value * LANES as f64) as usize;
            let mut first: Vec<usize> = points.iter().map(|point| strip(point.0)).collect();
            first.sort_unstable();
            let second: Vec<usize> = points.iter().map(|point| strip(point.1)).collect();
            let all: Vec<usize> = (0..LANES).collect();
            assert_eq!([first, second], [all.clone(), all], "{shift:?}");
        }
    }
}
