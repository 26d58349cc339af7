//! What one camera ray brings home.
//!
//! A path is traced from the camera and carries, at every spectral node, the adjoint Stokes vector: the row
//! vector w with "measured = w . (Stokes vector of light arriving against the path)". It starts as (1, 0, 0, 0)
//! and is multiplied by rotations and Mueller matrices as the path meets films (docs/reference/theory.md). Instead of I and
//! Q it holds the weights of s and p light, w_I + w_Q and w_I - w_Q, which a film multiplies by R_s and R_p;
//! U and V stay untouched zeros as long as all planes of incidence coincide.
//!
//! At a film, a coating or a bare surface both branches are followed (`specular.rs`); at a diffuse surface one goes on
//! (`diffuse.rs`) and the lights are sampled (`direct.rs`). A branch that leaves the scene is added up on the spot; one that goes on
//! may be left out only by Russian roulette, never dropped (`roulette.rs`): below `Floors::faint` it survives with probability in
//! proportion to its luminance; after `max_depth` hits below the luminance it had there; and where two go on after
//! `max_depth`, one is chosen in proportion to luminance. So no weight ever grows, and the walk ends. In a uniform
//! environment where nothing absorbs nothing at all is left to chance.

#[cfg(test)]
mod agreement;
mod arena;
mod caustics;
mod diffuse;
mod direct;
mod escape;
mod escaped;
pub mod extras;
mod facets;
mod fan;
mod found;
mod fringes;
mod onward;
mod parted;
mod path;
mod rough;
mod rough_film;
mod roulette;
mod specular;
#[cfg(test)]
mod tests;

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::lanes::Singles as Lanes;

use self::escaped::Escaped;
use self::extras::Extras;
use self::path::{Continuation, Lot, Path, Scattered, Since, Sums};
use crate::camera::Ray;
use crate::caustics::Memory;
use crate::chain::Chain;
use crate::failure::PathFailure;
use crate::film::Phase;
use crate::geometry::{Hit, frame};
use crate::levels::Spectra;
use crate::lights::chooser::LightId;
use crate::materials::Material;
use crate::prepare::{MOST_FILMS, Prepared};
use crate::refraction::shading_normal;
use crate::sampler::Choices;
use crate::variance::MOST_BATCHES;

/// Luminance below which a branch goes on in one of [`GROUP`] samples alone, with their weight, where a picture may end early.
/// What it finds varies little within a pixel, so that this makes less noise than chance would at that luminance.
const SPARSE: f32 = 2e-3;

/// Samples of a pixel that share a sparse branch: four of the net lie evenly, and each of them anywhere.
pub const GROUP: u32 = 4;

/// Probability to survive at hits beyond `max_depth` where hardly anything may be lost, diffuse ones and those of very long walks:
/// without it a walk among perfect whites, or within perfect mirrors, would never end.
const LATE_SURVIVAL: f32 = 0.95;

/// Most branches that an opaque rough surface sends on of a path that comes to it unscattered ([`fan`]).
const BRANCHES: usize = 3;

/// Planes of incidence closer than this (sine of the angle between them) count as one: the second-order error is 1e-10.
const SAME_PLANE: f64 = 1e-5;

/// What the rays of a pixel came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finished {
    Whole,
    /// It shows finer fringes than its spectra resolve: it starts again with those of this level.
    NeedsLevel(usize),
}

/// Working memory of one thread.
pub struct Tracer<'a> {
    scene: &'a Prepared,
    spectra: &'a Spectra,
    level: usize,
    /// Spectra by slot: s, p, u, v, each `blocks` long.
    arena: Vec<Lanes>,
    blocks: usize,
    waiting: Vec<Path>,
    free: Vec<usize>,
    escaped: Escaped,
    /// Camera rays that meet nothing.
    bare: Escaped,
    /// X, Y, Z of the pixel so far, and the share of its rays that nothing bent or stopped (for pictures without their
    /// backdrop), by batches of samples.
    batches: Vec<[f64; 4]>,
    /// The batch of the samples that are traced.
    batch: usize,
    /// What is added up beside them, if anything was asked for.
    extras: Option<Extras>,
    failure: Option<PathFailure>,
    /// The level of the spectra that the pixel asks for, if its own are too coarse.
    finer: Option<usize>,
    /// A ray of the pixel has met a surface.
    has_met_surface: bool,
    /// Hits of all branches of the sample under work so far.
    hits: u32,
    /// Whether the sample under work carries the sparse branches of its group; `None` where each sample carries its own.
    carries_sparse: Option<bool>,
    /// Where paths were scattered last, by slot.
    scattered: Vec<Scattered>,
    /// Thicknesses of the layers at the hit under work, nm.
    thicknesses: Vec<f32>,
    /// What is expected of the lights at the hit under work.
    expected: Vec<f64>,
    /// Weights of the nodes at the place in the spectrum that was chosen at the hit under work.
    thinned: Vec<Lanes>,
    caustics: Memory,
    /// X, Y, Z of each emitter that nothing lies before, once one is seen.
    emission: Vec<Option<[f64; 3]>>,
}

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a Prepared, level: usize) -> Tracer<'a> {
        // Every hit leaves at most one more path waiting, and none after max_depth; a diffuse hit takes one while it samples
        // the lights, a rough one another for what its facets pass, and a rough film on the way to a light one more. Once on each path
        // a rough hit leaves several.
        let slots = scene.max_depth as usize + 5 + BRANCHES;
        let spectra = &scene.levels[level];
        let blocks = spectra.importance.len();
        Tracer {
            scene,
            spectra,
            level,
            arena: vec![Lanes::ZERO; slots * 4 * blocks],
            blocks,
            waiting: Vec::with_capacity(slots),
            free: (0..slots).rev().collect(),
            escaped: Escaped::new(blocks),
            bare: Escaped::new(0),
            batches: vec![[0.0; 4]; MOST_BATCHES + 1],
            batch: 0,
            extras: Extras::new(&spectra.nodes),
            failure: None,
            finer: None,
            has_met_surface: false,
            hits: 0,
            carries_sparse: None,
            scattered: vec![Scattered::default(); slots],
            thicknesses: Vec::new(),
            expected: Vec::new(),
            thinned: Vec::new(),
            caustics: Memory::new(slots),
            emission: vec![None; spectra.lights.area_lights.len()],
        }
    }

    /// Which batch the rays from now on belong to, at most [`MOST_BATCHES`].
    #[inline(always)]
    pub fn begin_batch(&mut self, batch: usize) {
        if batch != self.batch
            && let Some(extras) = &mut self.extras
        {
            extras.end_batch();
        }
        self.batch = batch;
        (self.escaped.batch, self.bare.batch) = (batch, batch);
    }

    /// How the rays from now on deal with branches below [`SPARSE`]: each carries its own (`None`), or one of [`GROUP`] samples
    /// carries those of all.
    #[inline(always)]
    pub fn begin_sample(&mut self, carries_sparse: Option<bool>) {
        self.carries_sparse = carries_sparse;
    }

    /// Ends a pixel: what each batch came to can then be taken, or there is nothing. Either way it starts afresh.
    #[inline(always)]
    pub fn finish<S: Simd>(&mut self, simd: S) -> Result<Finished, PathFailure> {
        self.add_environment(simd);
        self.add_environment_unscattered(simd);
        if self.is_given_up() {
            self.batches.fill([0.0; 4]);
            if let Some(extras) = &mut self.extras {
                extras.clear();
            }
        }
        match (self.failure.take(), self.finer.take()) {
            (Some(failure), _) => Err(failure),
            (None, Some(level)) => Ok(Finished::NeedsLevel(level)),
            (None, None) => Ok(Finished::Whole),
        }
    }

    /// Whether the paths under work lead nowhere: the scene fails there, or the pixel starts again with finer spectra.
    #[inline(always)]
    fn is_given_up(&self) -> bool {
        self.failure.is_some() || self.finer.is_some()
    }

    /// Whether any of the rays since this was asked last has met a surface.
    #[inline(always)]
    pub fn has_met_surface(&mut self) -> bool {
        std::mem::take(&mut self.has_met_surface)
    }

    /// The sums of a batch over its rays.
    #[inline(always)]
    pub fn take_batch(&mut self, batch: usize) -> [f64; 4] {
        std::mem::take(&mut self.batches[batch])
    }

    /// Adds what a pixel came to beside X, Y, Z: S1, S2, S3 of X, Y, Z, then all components at each wavelength.
    pub fn take_extras(&mut self, into: &mut [f64]) {
        if let Some(extras) = &mut self.extras {
            extras.take(into);
        }
    }

    /// Adds what arrives along a ray from the camera that meets an emitter first, where that is the same for all rays; false where it
    /// may not be: [`Tracer::trace`] tells.
    #[inline(always)]
    pub fn sees_emitter<S: Simd>(&mut self, simd: S, ray: &Ray, object: usize) -> bool {
        let scene = self.scene;
        let Some(Material::Emitter(emitter)) = scene.materials.get(object) else { return false };
        if self.extras.is_some()
            || scene.has_priorities
            || scene.camera.polarizer(ray.direction).is_some()
            || self.is_dark(scene.enclosing_media(ray))
        {
            return false;
        }
        let xyz = match self.emission[*emitter] {
            Some(known) => known,
            None => simd.vectorize(
                #[inline(always)]
                || self.emission_of(simd, *emitter),
            ),
        };
        self.has_met_surface = true;
        for (total, part) in self.batches[self.batch].iter_mut().zip(xyz) {
            *total += part;
        }
        true
    }

    /// X, Y, Z of an emitter that nothing lies before.
    #[inline(always)]
    fn emission_of<S: Simd>(&mut self, simd: S, emitter: usize) -> [f64; 3] {
        let mut sums = [f32x16::splat(simd, 0.0); 3];
        for block in 0..self.blocks {
            sums = self.spectra.lights.add_emission(simd, emitter, block, f32x16::splat(simd, 2.0), sums);
        }
        let [x, y, z] = sums;
        let xyz = [f64::from(x.reduce_sum()), f64::from(y.reduce_sum()), f64::from(z.reduce_sum())];
        self.emission[emitter] = Some(xyz);
        xyz
    }

    /// Adds what arrives at the camera along a ray, of which it is known what it meets first; false once the pixel cannot be finished.
    #[inline(always)]
    pub fn trace<S: Simd>(&mut self, simd: S, ray: Ray, hit: Option<Hit>, choices: &mut Choices) -> bool {
        let scene = self.scene;
        let polarizer = scene.camera.polarizer(ray.direction);
        let Some(hit) = hit else {
            if !self.is_dark(scene.enclosing_media(&ray)) {
                self.add_unscattered(simd, ray.direction, polarizer);
            }
            return true;
        };
        self.has_met_surface = true;
        self.hits = 0;
        let Some(slot) = self.free.pop() else { unreachable!("all slots are free between camera rays") };
        let start = slot * 4 * self.blocks;
        let has_stokes = self.extras.as_ref().is_some_and(Extras::has_stokes);
        if let Some(extras) = &self.extras {
            extras.start(&mut self.arena[start..start + 4 * self.blocks], polarizer.is_some());
        } else {
            self.arena[start..start + 2 * self.blocks].fill(Lanes::ONE);
            if polarizer.is_some() {
                // Along the polariser all, across it nothing.
                self.arena[start + self.blocks..start + 2 * self.blocks].fill(Lanes::ZERO);
            }
        }
        let axis = match polarizer {
            // With Stokes vectors what passes the polariser is made of all of them.
            _ if has_stokes => scene.camera.upright(ray.direction),
            Some(axis) => axis,
            None => frame(ray.direction).0,
        };
        let mut path = Path {
            direction: ray.direction,
            hit,
            axis,
            slot,
            hits: 0,
            floor: scene.floors.faint,
            is_whole: true,
            is_sparse: false,
            lot: if scene.floors.are_even { Lot::EVEN } else { Lot::SINGLE },
            medium: scene.enclosing_media(&ray),
            in_plane: !has_stokes,
            is_unpolarized: polarizer.is_none() && !has_stokes,
            band: None,
            since: if scene.has_alpha { Since::Camera } else { Since::Bend },
            chain: Chain::UNTOLD,
        };
        let mut sums = Sums([f32x16::splat(simd, 0.0); 3]);
        loop {
            if !self.scatter(simd, &mut path, &mut sums, choices) {
                self.free.push(path.slot);
                match self.waiting.pop() {
                    Some(next) => path = next,
                    None => break,
                }
            }
            if self.is_given_up() {
                self.free.push(path.slot);
                while let Some(next) = self.waiting.pop() {
                    self.free.push(next.slot);
                }
                return false;
            }
        }
        self.add(self.batch, &sums);
        true
    }

    /// What a path finds at the surface it meets. It continues as `path` (false: nothing of it is left).
    #[inline(always)]
    fn scatter<S: Simd>(&mut self, simd: S, path: &mut Path, sums: &mut Sums<S>, choices: &mut Choices) -> bool {
        let scene = self.scene;
        self.hits += 1;
        self.attenuate(simd, path);
        if scene.has_priorities && !self.pass_hidden(simd, path, sums) {
            return false;
        }
        if scene.geometry.is_shaded(path.hit.object) {
            path.hit.normal = shading_normal(&scene.geometry, &path.hit, path.direction);
        }
        // Calls through `vectorize` are functions of their own: in one piece the compiler takes minutes over them.
        match scene.materials.get(path.hit.object) {
            Some(Material::Film(film)) => match &film.rough {
                None => self.scatter_film(simd, path, film, sums, choices),
                Some(rough) => simd.vectorize(
                    #[inline(always)]
                    || self.scatter_rough_film(simd, path, (film, rough), sums, choices),
                ),
            },
            Some(Material::Coating(coating)) => match &coating.rough {
                None => simd.vectorize(
                    #[inline(always)]
                    || self.scatter_coating(simd, path, coating, sums, choices),
                ),
                Some(rough) => simd.vectorize(
                    #[inline(always)]
                    || self.scatter_rough(simd, path, (coating, rough), sums, choices),
                ),
            },
            Some(Material::Diffuse { is_black: true, .. }) => false,
            Some(Material::Diffuse { number, .. }) => self.scatter_diffuse(simd, path, *number, sums, choices),
            Some(Material::Emitter(emitter)) => {
                let mut share = self.emitter_mis_weight(self.scattered(path), &path.hit);
                if path.since == Since::Bend && path.chain != Chain::UNTOLD {
                    share *= self.caustic_mis_weight(path, path.chain, LightId::Emitter(*emitter));
                }
                self.add_light(simd, path, LightId::Emitter(*emitter), share, sums);
                false
            }
            None => {
                simd.vectorize(
                    #[inline(always)]
                    || self.add_beyond(simd, path, sums),
                );
                false
            }
        }
    }

    /// Takes a path straight through surfaces that are not there, since a stronger medium rules where they lie. False if it
    /// ends behind them.
    #[inline(never)]
    fn pass_hidden<S: Simd>(&mut self, simd: S, path: &mut Path, sums: &mut Sums<S>) -> bool {
        let mut crossed = 0;
        while let Some(behind) = self.scene.behind_hidden(&path.hit, path.direction, path.medium) {
            crossed += 1;
            if crossed > MOST_FILMS {
                self.failure = Some(PathFailure::SamePlace { object: path.hit.object });
                return false;
            }
            path.medium = behind;
            let scattered = self.scattered(path);
            let continuation = self.straight_on(path);
            if let Continuation::Surface(next) = continuation {
                path.hit = next;
                self.attenuate(simd, path);
                continue;
            }
            self.make_room(simd, 1);
            let to = self.target(continuation, path.slot, path.direction, scattered);
            let mut xyz = sums.0;
            for block in 0..self.blocks {
                let s = self.arena[self.at(path.slot, 0, block)].load(simd);
                let p = self.arena[self.at(path.slot, 1, block)].load(simd);
                xyz = self.splat(simd, to, block, s, p, xyz);
            }
            sums.0 = xyz;
            return false;
        }
        true
    }

    /// Asks for finer spectra if these do not resolve the fringes of a path difference; true if the pixel must wait.
    #[inline(always)]
    fn is_too_coarse(&mut self, path_difference_nm: f64) -> bool {
        if path_difference_nm <= self.spectra.resolved_nm {
            return false;
        }
        let finer = self.scene.levels[self.level..].iter().position(|level| path_difference_nm <= level.resolved_nm);
        // The last level resolves everything that the scene's thicknesses allow.
        self.finer = Some(self.level + finer.unwrap_or(0).max(1));
        true
    }

    /// How the phase of a film of this path difference is told; `None` if the pixel must wait for finer spectra.
    #[inline(always)]
    fn phase(&mut self, path_nm: f64) -> Option<Phase> {
        let phase = Phase::of(path_nm, self.scene.seen_nm);
        if phase != Phase::Averaged && self.is_too_coarse(path_nm) {
            return None;
        }
        Some(phase)
    }
}
