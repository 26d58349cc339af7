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
mod caustics;
mod diffuse;
mod direct;
mod escape;
pub mod extras;
mod parted;
mod rough;
mod rough_film;
mod roulette;
mod specular;
#[cfg(test)]
mod tests;

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::turns::exp2;

use self::escape::{Escaped, Share};
use self::extras::Extras;
use crate::camera::Ray;
use crate::caustics::Memory;
use crate::chain::Chain;
use crate::failure::PathFailure;
use crate::film::Phase;
use crate::geometry::{Hit, frame};
use crate::levels::Spectra;
use crate::lights::Source;
use crate::lights::chooser::LightId;
use crate::materials::Material;
use crate::medium_stack::MediumStack;
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

/// Most branches that an opaque surface sends on of a path that comes to it unscattered: what others mirror of each other is looked for by
/// them alone, and most leave the scene.
const BRANCHES: usize = 4;

/// Planes of incidence closer than this (sine of the angle between them) count as one: the second-order error is 1e-10.
const SAME_PLANE: f64 = 1e-5;

/// A path that is about to meet a surface; its spectra stand in the arena under `slot`.
#[derive(Clone, Copy)]
struct Path {
    direction: Vec3,
    hit: Hit,
    /// The s direction of the plane that the Stokes vector refers to; meaningless before the first hit.
    axis: Vec3,
    slot: usize,
    hits: u32,
    /// The luminance below which it survives only by chance.
    floor: f32,
    /// It stands for those of all samples of its group.
    is_sparse: bool,
    medium: MediumStack,
    /// U and V are zero (and their storage is stale).
    in_plane: bool,
    /// It has met nothing that polarises since the camera or a diffuse surface.
    is_unpolarized: bool,
    /// The place in the spectrum at which it goes on, once a prism has parted the wavelengths.
    band: Option<f64>,
    /// What it has come from straight, through films or nothing.
    since: Since,
    /// What it has done since it was scattered, where caustics are sampled.
    chain: Chain,
}

/// What a path has come from straight and unbent, with nothing but films in between.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Since {
    /// The camera, in a picture without its backdrop.
    Camera,
    /// A surface that scattered it; where, stands by its slot.
    Scattering,
    /// A surface that mirrored or refracted it; or it does not matter what.
    Bend,
}

impl Since {
    /// Left by a surface that sampled the lights, or did not.
    #[inline(always)]
    fn scattering(scattered: Option<Scattered>) -> Since {
        if scattered.is_some() { Since::Scattering } else { Since::Bend }
    }
}

/// A diffuse point that a path left in a sampled direction.
#[derive(Clone, Copy, Default)]
struct Scattered {
    origin: Vec3,
    /// Probability per solid angle of the direction.
    density: f64,
}

/// What becomes of a branch.
#[derive(Clone, Copy)]
enum Continuation {
    /// It meets another surface.
    Surface(Hit),
    /// It leaves the scene.
    Escapes,
    /// It leaves the scene straight from the camera, in a picture without its backdrop; the sun that it meets there, if any.
    Backdrop(Option<usize>),
    /// It meets an emitter; this is its weight in multiple importance sampling.
    Emitter(usize, f32),
    /// It is absorbed.
    Absorbed,
}

/// Where the spectra of a branch are written.
#[derive(Clone, Copy)]
enum Target {
    /// Into the arena: the branch goes on.
    Slot(usize),
    /// Among the paths that leave for lights that depend on direction.
    Out(usize),
    /// Nowhere: it finds the uniform lights only.
    Uniform,
    /// Nowhere: it finds this share of an emitter.
    Emitter(usize, f32),
    /// As these, and to the sums beside those of the picture.
    Told(Found),
    /// Nowhere at all.
    Nowhere,
}

/// What a branch finds whose light is told to the sums beside those of the picture, too.
#[derive(Clone, Copy)]
enum Found {
    /// [`Target::Out`].
    Out(usize),
    /// [`Target::Uniform`].
    Uniform,
    /// [`Target::Emitter`].
    Emitter(usize, f32),
    /// [`Continuation::Backdrop`]: the sums of the picture hear of the sun alone.
    Backdrop(Option<usize>),
}

/// Sums of X, Y, Z over a block's lanes.
struct Sums<S: Simd>([f32x16<S>; 3]);

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
    /// A ray of the pixel has met a surface.
    has_met_surface: bool,
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
            has_met_surface: false,
            carries_sparse: None,
            scattered: vec![Scattered::default(); slots],
            thicknesses: Vec::new(),
            expected: Vec::new(),
            thinned: Vec::new(),
            caustics: Memory::new(slots),
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

    /// Ends a pixel: what each batch came to can then be taken; or tells why there is nothing. Either way it starts afresh.
    #[inline(always)]
    pub fn finish<S: Simd>(&mut self, simd: S) -> Result<(), PathFailure> {
        self.add_environment(simd);
        self.add_environment_unscattered(simd);
        match self.failure.take() {
            None => Ok(()),
            Some(failure) => {
                self.batches.fill([0.0; 4]);
                if let Some(extras) = &mut self.extras {
                    extras.clear();
                }
                Err(failure)
            }
        }
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

    /// Adds what arrives at the camera along a ray; false once the pixel cannot be finished.
    #[inline(always)]
    pub fn trace<S: Simd>(&mut self, simd: S, ray: Ray, choices: &mut Choices) -> bool {
        let scene = self.scene;
        let polarizer = scene.camera.polarizer(ray.direction);
        let Some(hit) = scene.geometry.nearest(&ray, None) else {
            if !self.is_dark(scene.enclosing_media(&ray)) {
                self.add_unscattered(simd, ray.direction, polarizer);
            }
            return true;
        };
        self.has_met_surface = true;
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
            is_sparse: false,
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
            if self.failure.is_some() {
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

    /// Takes off what the medium absorbs on the way to the hit.
    #[inline(always)]
    fn attenuate<S: Simd>(&mut self, simd: S, path: &Path) {
        let Some(rate) = &self.spectra.attenuation[usize::from(path.medium.innermost())] else { return };
        let distance = path.hit.distance as f32;
        let components = if path.in_plane { 2 } else { 4 };
        for (block, rate) in rate.iter().enumerate() {
            let passes = exp2(rate.load(simd) * -distance);
            for component in 0..components {
                let at = self.at(path.slot, component, block);
                let left = self.arena[at].load(simd) * passes;
                self.arena[at].store(left);
            }
        }
    }

    /// Where a path was scattered, if it has come straight from there.
    #[inline(always)]
    fn scattered(&self, path: &Path) -> Option<Scattered> {
        (path.since == Since::Scattering).then(|| self.scattered[path.slot])
    }

    /// What the branch of a path comes to that goes straight on from a hit.
    #[inline(always)]
    fn straight_on(&self, path: &Path) -> Continuation {
        match self.continuation(&path.hit, path.direction, path.medium, self.scattered(path)) {
            Continuation::Escapes if path.since == Since::Camera => {
                Continuation::Backdrop(self.bare_sun(path.direction))
            }
            continuation => continuation,
        }
    }

    /// The only sun in a direction, unless it belongs to a sky.
    #[inline(always)]
    fn bare_sun(&self, direction: Vec3) -> Option<usize> {
        let lights = &self.spectra.lights;
        lights.sun_at(direction).map(|(sun, _)| sun).filter(|sun| !lights.suns[*sun].is_of_sky)
    }

    /// Nothing comes from infinitely far away within a medium that absorbs.
    #[inline(always)]
    fn is_dark(&self, medium: MediumStack) -> bool {
        self.spectra.attenuation[usize::from(medium.innermost())].is_some()
    }

    /// What a branch that starts at a hit comes to.
    #[inline(always)]
    fn continuation(
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
    fn is_natural(&self, emitter: usize) -> bool {
        self.spectra.lights.area_lights[emitter].linear.is_none()
    }

    /// Where the spectra of a branch are written.
    #[inline(always)]
    fn target(
        &mut self,
        continuation: Continuation,
        slot: usize,
        direction: Vec3,
        scattered: Option<Scattered>,
    ) -> Target {
        let lights = &self.spectra.lights;
        let target = match continuation {
            Continuation::Surface(_) => Target::Slot(slot),
            Continuation::Escapes if lights.depend_on_direction() => {
                let sun = lights.sun_at(direction).map(|(sun, _)| (sun, self.sun_mis_weight(sun, scattered)));
                let share =
                    Share { maps: self.environment_mis_weight(scattered), sun: sun.filter(|(_, share)| *share > 0.0) };
                if share.maps == 0.0 && share.sun.is_none() {
                    Target::Uniform
                } else {
                    Target::Out(self.escaped.push(direction, share))
                }
            }
            Continuation::Escapes => Target::Uniform,
            Continuation::Emitter(emitter, share) => Target::Emitter(emitter, share),
            Continuation::Backdrop(sun) => Target::Told(Found::Backdrop(sun)),
            Continuation::Absorbed => Target::Nowhere,
        };
        match target {
            Target::Out(path) if self.extras.is_some() => Target::Told(Found::Out(path)),
            Target::Uniform if self.extras.is_some() => Target::Told(Found::Uniform),
            Target::Emitter(emitter, share) if self.extras.is_some() => Target::Told(Found::Emitter(emitter, share)),
            target => target,
        }
    }

    /// Writes a block of a branch to where it goes; one that meets lights whose weights are known finds them at once.
    ///
    /// Sums go in and out by value: behind a reference they pass through memory at every block.
    #[inline(always)]
    fn splat<S: Simd>(
        &mut self,
        simd: S,
        to: Target,
        block: usize,
        s: f32x16<S>,
        p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        match to {
            Target::Slot(slot) => {
                let (s_at, p_at) = (self.at(slot, 0, block), self.at(slot, 1, block));
                self.arena[s_at].store(s);
                self.arena[p_at].store(p);
                return xyz;
            }
            Target::Out(path) => self.escaped.carried[path * self.blocks + block].store(s + p),
            Target::Uniform => {}
            Target::Emitter(emitter, share) => {
                return self.spectra.lights.add_emission(simd, emitter, block, (s + p) * share, xyz);
            }
            Target::Told(found) => {
                return simd.vectorize(
                    #[inline(always)]
                    || self.splat_told(simd, found, block, s + p, xyz),
                );
            }
            Target::Nowhere => return xyz,
        }
        self.spectra.lights.add_uniform(simd, block, s + p, xyz)
    }

    /// [`Tracer::splat`] of light that the sums beside those of the picture are told of.
    #[inline(always)]
    fn splat_told<S: Simd>(
        &mut self,
        simd: S,
        found: Found,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        match found {
            Found::Out(path) => self.escaped.carried[path * self.blocks + block].store(s_and_p),
            Found::Uniform => {}
            Found::Emitter(emitter, share) => {
                self.tell(Source::Light(LightId::Emitter(emitter)), block, s_and_p * share);
                return self.spectra.lights.add_emission(simd, emitter, block, s_and_p * share, xyz);
            }
            Found::Backdrop(sun) => {
                self.add_share(simd, block, s_and_p);
                let Some(sun) = sun.map(LightId::Sun) else { return xyz };
                self.tell(Source::Light(sun), block, s_and_p);
                return self.spectra.lights.add_light(simd, sun, block, s_and_p, xyz);
            }
        }
        self.tell(Source::Uniform, block, s_and_p);
        self.spectra.lights.add_uniform(simd, block, s_and_p, xyz)
    }

    /// Adds what the backdrop would shine through by, of all that a block carries straight to it.
    #[inline(always)]
    fn add_share<S: Simd>(&mut self, simd: S, block: usize, s_and_p: f32x16<S>) {
        let share = self.spectra.lights.white(simd, block) * s_and_p;
        self.batches[self.batch][3] += f64::from(share.reduce_sum()) * self.scene.camera.bare_share();
    }

    /// Tells the sums beside those of the picture of light that is found.
    #[inline(always)]
    fn tell<S: Simd>(&self, source: Source, block: usize, carried: f32x16<S>) {
        if let Some(extras) = &self.extras {
            let mut lanes = Lanes::ZERO;
            lanes.store(carried);
            extras.receive(&self.spectra.lights, source, block, &lanes.0);
        }
    }

    /// Adds what a block would find if the lights had their mean radiance everywhere.
    #[inline(always)]
    fn add_mean<S: Simd>(&self, simd: S, block: usize, s_and_p: f32x16<S>, xyz: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        self.add_around(simd, block, s_and_p, self.spectra.lights.mean_rgb, xyz)
    }

    /// Adds what a block would find if all maps had one radiance everywhere.
    #[inline(always)]
    fn add_around<S: Simd>(
        &self,
        simd: S,
        block: usize,
        s_and_p: f32x16<S>,
        rgb: [f32; 3],
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let lights = &self.spectra.lights;
        self.tell(Source::Uniform, block, s_and_p);
        if lights.has_maps() {
            self.tell(Source::Map(rgb), block, s_and_p);
        }
        let xyz = lights.add_uniform(simd, block, s_and_p, xyz);
        if lights.has_maps() { lights.add_map(simd, block, s_and_p, rgb, xyz) } else { xyz }
    }

    /// Asks for finer spectra if these do not resolve the fringes of a path difference; true if the pixel must wait.
    #[inline(always)]
    fn is_too_coarse(&mut self, path_difference_nm: f64) -> bool {
        if path_difference_nm <= self.spectra.resolved_nm {
            return false;
        }
        let finer = self.scene.levels[self.level..].iter().position(|level| path_difference_nm <= level.resolved_nm);
        // The last level resolves everything that the scene's thicknesses allow.
        self.failure = Some(PathFailure::NeedsLevel(self.level + finer.unwrap_or(0).max(1)));
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

    /// Not `map`: closures are not compiled for the wider instructions.
    #[inline(always)]
    fn add<S: Simd>(&mut self, batch: usize, sums: &Sums<S>) {
        let [x, y, z] = sums.0;
        let total = &mut self.batches[batch];
        total[0] += f64::from(x.reduce_sum());
        total[1] += f64::from(y.reduce_sum());
        total[2] += f64::from(z.reduce_sum());
    }

    #[inline(always)]
    fn at(&self, slot: usize, component: usize, block: usize) -> usize {
        (slot * 4 + component) * self.blocks + block
    }
}
