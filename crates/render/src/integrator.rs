//! What one camera ray brings home.
//!
//! A path is traced from the camera and carries, at every spectral node, the adjoint Stokes vector: the row
//! vector w with "measured = w . (Stokes vector of light arriving against the path)". It starts as (1, 0, 0, 0)
//! and is multiplied by rotations and Mueller matrices as the path meets films (docs/theory.md). Instead of I and
//! Q it holds the weights of s and p light, w_I + w_Q and w_I - w_Q, which a film multiplies by R_s and R_p;
//! U and V stay untouched zeros as long as all planes of incidence coincide.
//!
//! At a film both branches are followed. One that leaves the scene is added up on the spot; one that goes on may be
//! left out only by chance, never dropped: below [`FAINT`] it survives with probability in proportion to its
//! luminance; after `max_depth` hits below the luminance it had there; and where two go on after `max_depth`, one is
//! chosen in proportion to luminance. So no weight ever grows, and the walk ends. Every such choice is made against the scene's mean light: what the branch would find if
//! its surroundings had their mean radiance is added for certain, and only the difference from that is left to
//! chance. In a uniform environment nothing at all is.

use fearless_simd::{Simd, f32x16, prelude::*};

use crate::camera::Ray;
use crate::film::{Beam, Mueller};
use crate::geometry::{Hit, nearest};
use crate::lanes::Lanes;
use crate::prepare::{Prepared, SURROUNDING};
use crate::sampler::Choices;
use crate::spectral::LANES;
use crate::vector::Vec3;

/// Luminance (of 1 at the camera) below which a branch survives only by chance. One such choice makes noise of at most
/// half of this times the deviation of the light from its mean; docs/performance.md has the trade against time.
const FAINT: f32 = 2e-4;

/// Planes of incidence closer than this (sine of the angle between them) count as one: the second-order error is 1e-10.
const SAME_PLANE: f64 = 1e-5;

/// A path that is about to meet a film; its spectra stand in the arena under `slot`.
#[derive(Clone, Copy)]
struct Path {
    direction: Vec3,
    hit: Hit,
    /// The s direction of the plane that the Stokes vector refers to; meaningless before the first hit.
    axis: Vec3,
    slot: usize,
    hits: u32,
    medium: u16,
    /// The luminance below which it survives only by chance.
    floor: f32,
    /// U and V are zero (and their storage is stale).
    in_plane: bool,
}

/// What becomes of a branch.
#[derive(Clone, Copy)]
enum Fate {
    /// It meets another film.
    GoesOn(Hit),
    /// It leaves the scene.
    Leaves,
}

/// Where the spectra of a branch are written.
#[derive(Clone, Copy)]
enum Target {
    /// Into the arena: the branch goes on.
    Slot(usize),
    /// Among the paths that leave for the maps.
    Out(usize),
    /// Nowhere: there are uniform lights only.
    Nowhere,
}

/// Sums of X, Y, Z over a block's lanes.
struct Sums<S: Simd>([f32x16<S>; 3]);

/// Paths on their way out to the maps, sixteen at a time.
struct Leaving {
    directions: [Lanes; 3],
    /// Sum of s and p weights: spectrum of path i from `i * blocks`. Empty for paths that met nothing.
    carried: Vec<Lanes>,
    count: usize,
}

impl Leaving {
    fn new(blocks: usize) -> Leaving {
        // Unused lanes look somewhere harmless.
        Leaving {
            directions: [Lanes::ZERO, Lanes::ONE, Lanes::ZERO],
            carried: vec![Lanes::ZERO; blocks * LANES],
            count: 0,
        }
    }

    #[inline(always)]
    fn push(&mut self, direction: Vec3) -> usize {
        let at = self.count;
        let [x, y, z] = &mut self.directions;
        (x.0[at], y.0[at], z.0[at]) = (direction.x as f32, direction.y as f32, direction.z as f32);
        self.count += 1;
        at
    }
}

/// Working memory of one thread.
pub struct Tracer<'a> {
    scene: &'a Prepared,
    /// Spectra by slot: s, p, u, v, each `blocks` long.
    arena: Vec<Lanes>,
    blocks: usize,
    waiting: Vec<Path>,
    free: Vec<usize>,
    leaving: Leaving,
    /// Camera rays that meet nothing.
    bare: Leaving,
    /// XYZ of the pixel so far.
    xyz: [f64; 3],
}

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a Prepared) -> Tracer<'a> {
        // Every hit leaves at most one more path waiting, and none after max_depth.
        let slots = scene.max_depth as usize + 2;
        let blocks = scene.importance.len();
        Tracer {
            scene,
            arena: vec![Lanes::ZERO; slots * 4 * blocks],
            blocks,
            waiting: Vec::with_capacity(slots),
            free: (0..slots).rev().collect(),
            leaving: Leaving::new(blocks),
            bare: Leaving::new(0),
            xyz: [0.0; 3],
        }
    }

    /// The sum of XYZ over all rays since the last call.
    #[inline(always)]
    pub fn take_xyz<S: Simd>(&mut self, simd: S) -> [f64; 3] {
        self.reach_maps(simd);
        self.reach_maps_bare(simd);
        std::mem::take(&mut self.xyz)
    }

    /// Adds what arrives at the camera along a ray.
    #[inline(always)]
    pub fn trace<S: Simd>(&mut self, simd: S, ray: Ray, choices: &mut Choices) {
        let scene = self.scene;
        let Some(hit) = nearest(&scene.spheres, &ray, None) else {
            for c in 0..3 {
                self.xyz[c] += scene.lights.uniform_xyz[c];
            }
            if scene.lights.has_maps() {
                self.bare.push(ray.direction);
                if self.bare.count == LANES {
                    self.reach_maps_bare(simd);
                }
            }
            return;
        };
        let slot = self.free.pop().expect("all slots are free between camera rays");
        let start = slot * 4 * self.blocks;
        self.arena[start..start + 2 * self.blocks].fill(Lanes::ONE);
        let mut path = Path {
            direction: ray.direction,
            hit,
            axis: any_across(ray.direction),
            slot,
            hits: 0,
            medium: SURROUNDING,
            floor: FAINT,
            in_plane: true,
        };
        let mut sums = Sums([f32x16::splat(simd, 0.0); 3]);
        loop {
            if !self.meet_film(simd, &mut path, &mut sums, choices) {
                self.free.push(path.slot);
                match self.waiting.pop() {
                    Some(next) => path = next,
                    None => break,
                }
            }
        }
        self.add(&sums);
    }

    /// Not `map`: closures are not compiled for the wider instructions.
    #[inline(always)]
    fn add<S: Simd>(&mut self, sums: &Sums<S>) {
        let [x, y, z] = sums.0;
        self.xyz[0] += f64::from(x.reduce_sum());
        self.xyz[1] += f64::from(y.reduce_sum());
        self.xyz[2] += f64::from(z.reduce_sum());
    }

    /// Looks up the maps for the paths that have left.
    #[inline(always)]
    fn reach_maps<S: Simd>(&mut self, simd: S) {
        if self.leaving.count == 0 {
            return;
        }
        let lights = &self.scene.lights;
        let [red, green, blue] = lights.map_rgb(simd, &self.leaving.directions);
        let mut xyz = [f32x16::splat(simd, 0.0); 3];
        for path in 0..self.leaving.count {
            let rgb = [red[path], green[path], blue[path]];
            for block in 0..self.blocks {
                let carried = self.leaving.carried[path * self.blocks + block].load(simd);
                xyz = lights.add_map(simd, block, carried, rgb, xyz);
            }
        }
        self.leaving.count = 0;
        self.add(&Sums(xyz));
    }

    /// The same for camera rays that met nothing.
    #[inline(always)]
    fn reach_maps_bare<S: Simd>(&mut self, simd: S) {
        if self.bare.count == 0 {
            return;
        }
        let rgb = self.scene.lights.map_rgb(simd, &self.bare.directions);
        let mut sum = [0.0_f64; 3];
        for ray in 0..self.bare.count {
            for c in 0..3 {
                sum[c] += f64::from(rgb[c][ray]);
            }
        }
        for (total, part) in self.xyz.iter_mut().zip(self.scene.lights.xyz(sum)) {
            *total += part;
        }
        self.bare.count = 0;
    }

    /// Splits a path at a film. It continues as `path` (false: nothing of it is left); a second branch waits.
    #[inline(always)]
    fn meet_film<S: Simd>(&mut self, simd: S, path: &mut Path, sums: &mut Sums<S>, choices: &mut Choices) -> bool {
        let scene = self.scene;
        let Path { hit, direction, .. } = *path;
        let film = &scene.films[hit.object];
        debug_assert_eq!(path.medium, film.outside, "a film must lie in the medium that the ray is in");
        let thickness_nm = film.thickness_nm(hit.point) as f32;
        let along = direction.dot(hit.normal);
        let cos_theta = along.abs().min(1.0) as f32;

        self.turn_to_plane(simd, path);
        path.hits += 1;

        let mirror = direction - hit.normal * (2.0 * along);
        let passed = self.fate(&hit, direction);
        let mirrored = self.fate(&hit, mirror);
        if self.leaving.count + 2 > LANES {
            self.reach_maps(simd);
        }
        let (slot, both_go_on) = (path.slot, matches!((passed, mirrored), (Fate::GoesOn(_), Fate::GoesOn(_))));
        let other = if both_go_on { self.free.pop().expect("one slot a level") } else { slot };
        let to = [self.target(mirrored, other, mirror), self.target(passed, slot, direction)];
        let (mirrored_y, passed_y) = if path.in_plane && film.table.is_plain() {
            self.split_plain(simd, path, cos_theta, thickness_nm, to, sums)
        } else {
            self.split_any(simd, path, cos_theta, thickness_nm, to, sums)
        };

        match (mirrored, passed) {
            (Fate::Leaves, Fate::Leaves) => false,
            (Fate::GoesOn(hit), Fate::Leaves) => {
                (path.direction, path.hit) = (mirror, hit);
                self.survives(simd, path, mirrored_y, sums, choices)
            }
            (Fate::Leaves, Fate::GoesOn(hit)) => {
                path.hit = hit;
                self.survives(simd, path, passed_y, sums, choices)
            }
            (Fate::GoesOn(mirrored_hit), Fate::GoesOn(passed_hit)) => {
                let mut mirrored = Path { direction: mirror, hit: mirrored_hit, slot: other, ..*path };
                path.hit = passed_hit;
                if path.hits >= scene.max_depth {
                    return self.choose(simd, path, mirrored, [mirrored_y, passed_y], sums, choices);
                }
                let mirrored_survives = self.survives(simd, &mut mirrored, mirrored_y, sums, choices);
                let passed_survives = self.survives(simd, path, passed_y, sums, choices);
                match (mirrored_survives, passed_survives) {
                    (true, true) => self.waiting.push(mirrored),
                    (true, false) => {
                        self.free.push(path.slot);
                        *path = mirrored;
                    }
                    (false, _) => self.free.push(other),
                }
                mirrored_survives || passed_survives
            }
        }
    }

    /// Where a branch that starts at a hit goes.
    #[inline(always)]
    fn fate(&self, hit: &Hit, direction: Vec3) -> Fate {
        match nearest(&self.scene.spheres, &Ray { origin: hit.point, direction }, Some(hit.object)) {
            Some(next) => Fate::GoesOn(next),
            None => Fate::Leaves,
        }
    }

    /// Where the spectra of a branch are written.
    #[inline(always)]
    fn target(&mut self, fate: Fate, slot: usize, direction: Vec3) -> Target {
        match fate {
            Fate::GoesOn(_) => Target::Slot(slot),
            Fate::Leaves if self.scene.lights.has_maps() => Target::Out(self.leaving.push(direction)),
            Fate::Leaves => Target::Nowhere,
        }
    }

    /// Of two branches that both go on, keeps one with probability in proportion to luminance.
    #[inline(always)]
    fn choose<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        mirrored: Path,
        [mirrored_y, passed_y]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        self.add_mean_light(simd, &mirrored, 1.0, sums);
        self.add_mean_light(simd, path, 1.0, sums);
        let sum = mirrored_y + passed_y;
        let share = if sum > 0.0 { (mirrored_y / sum).clamp(0.0, 1.0) } else { 0.5 };
        let probability = if choices.next() < share {
            self.free.push(path.slot);
            *path = mirrored;
            share
        } else {
            self.free.push(mirrored.slot);
            1.0 - share
        };
        self.scale(simd, path, 1.0 / probability);
        self.add_mean_light(simd, path, -1.0, sums);
        self.survives(simd, path, sum, sums, choices)
    }

    /// Whether a branch of this luminance goes on; if it does so by luck, its weight makes up for it.
    #[inline(always)]
    fn survives<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        luminance: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        if path.hits == self.scene.max_depth {
            // From here on the walk is a game of chance at the luminance it has now. A fixed chance would not do: at
            // grazing angles hardly anything is lost at a hit, and weights would grow without bound.
            path.floor = luminance.max(FAINT);
        }
        if luminance >= path.floor {
            return true;
        }
        // A branch without luminance (or, by rounding, below zero) may still carry colour: the odds have a least value.
        let odds = (luminance / path.floor).max(1e-3);
        self.add_mean_light(simd, path, 1.0, sums);
        let survives = choices.next() < odds;
        if survives {
            self.scale(simd, path, 1.0 / odds);
            self.add_mean_light(simd, path, -1.0, sums);
        }
        survives
    }

    /// Adds what a path would find if the lights had their mean radiance everywhere.
    #[inline(always)]
    fn add_mean_light<S: Simd>(&self, simd: S, path: &Path, factor: f32, sums: &mut Sums<S>) {
        let lights = &self.scene.lights;
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            let carried = (s + p) * factor;
            xyz = lights.add_uniform(simd, block, carried, xyz);
            if lights.has_maps() {
                xyz = lights.add_map(simd, block, carried, lights.mean_rgb, xyz);
            }
        }
        sums.0 = xyz;
    }

    /// Refers the path's Stokes vector to the plane of incidence of the film it meets.
    #[inline(always)]
    fn turn_to_plane<S: Simd>(&mut self, simd: S, path: &mut Path) {
        let across = path.hit.normal.cross(path.direction);
        let sine2 = across.length_squared();
        if sine2 < 1e-12 {
            // Near the normal s and p are alike and every plane is as good: keep the one at hand.
            return;
        }
        // Light travels against the path.
        let p_axis = (-path.direction).cross(path.axis);
        let along_p = across.dot(p_axis);
        if path.in_plane && along_p * along_p < SAME_PLANE * SAME_PLANE * sine2 {
            return;
        }
        let scale = 1.0 / sine2.sqrt();
        let (cos, sin) = (across.dot(path.axis) * scale, along_p * scale);
        path.axis = across * scale;
        if path.hits == 0 {
            // Natural importance looks the same in every frame.
            return;
        }
        let (cos2, sin2) = ((cos * cos - sin * sin) as f32, (2.0 * cos * sin) as f32);
        let blocks = self.blocks;
        let [s, p, u, v] = components(&mut self.arena, path.slot, blocks);
        if path.in_plane {
            u.fill(Lanes::ZERO);
            v.fill(Lanes::ZERO);
            path.in_plane = false;
        }
        for block in 0..blocks {
            let (w_s, w_p, w_u) = (s[block].load(simd), p[block].load(simd), u[block].load(simd));
            let (w_i, w_q) = ((w_s + w_p) * 0.5, (w_s - w_p) * 0.5);
            let turned_q = w_q * cos2 + w_u * sin2;
            s[block].store(w_i + turned_q);
            p[block].store(w_i - turned_q);
            u[block].store(w_u * cos2 - w_q * sin2);
        }
    }

    /// A lossless film while all planes of incidence coincide. `to` tells where the mirrored and the passed branch go;
    /// the luminance of both is given back.
    #[inline(always)]
    fn split_plain<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        cos_theta: f32,
        thickness_nm: f32,
        to: [Target; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let scene = self.scene;
        let table = &scene.films[path.hit.object].table;
        let zero = f32x16::splat(simd, 0.0);
        let (mut mirrored_y, mut all_y) = (zero, zero);
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let [r_s, r_p] = table.reflectance(simd, block, cos_theta, thickness_nm);
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            let (back_s, back_p) = (s * r_s, p * r_p);
            xyz = self.put(simd, to[0], block, back_s, back_p, xyz);
            xyz = self.put(simd, to[1], block, s - back_s, p - back_p, xyz);
            let weight = scene.importance[block].load(simd);
            mirrored_y = weight.mul_add(back_s + back_p, mirrored_y);
            all_y = weight.mul_add(s + p, all_y);
        }
        sums.0 = xyz;
        let mirrored_y = mirrored_y.reduce_sum();
        (mirrored_y, all_y.reduce_sum() - mirrored_y)
    }

    /// [`Tracer::split_plain`] for any film and any planes.
    #[inline(always)]
    fn split_any<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        cos_theta: f32,
        thickness_nm: f32,
        to: [Target; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let scene = self.scene;
        let table = &scene.films[path.hit.object].table;
        let zero = f32x16::splat(simd, 0.0);
        let mut luminance = [zero; 2];
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let response = table.response(simd, block, cos_theta, thickness_nm);
            let mut w = Beam {
                s: self.arena[self.at(path.slot, 0, block)].load(simd),
                p: self.arena[self.at(path.slot, 1, block)].load(simd),
                u: zero,
                v: zero,
            };
            if !path.in_plane {
                w.u = self.arena[self.at(path.slot, 2, block)].load(simd);
                w.v = self.arena[self.at(path.slot, 3, block)].load(simd);
            }
            let matrices: [&Mueller<S>; 2] = [&response.reflect, &response.transmit];
            for branch in 0..2 {
                let out = matrices[branch].carry(&w);
                xyz = self.put(simd, to[branch], block, out.s, out.p, xyz);
                if let (Target::Slot(slot), false) = (to[branch], path.in_plane) {
                    let (u_at, v_at) = (self.at(slot, 2, block), self.at(slot, 3, block));
                    self.arena[u_at].store(out.u);
                    self.arena[v_at].store(out.v);
                }
                luminance[branch] = scene.importance[block].load(simd).mul_add(out.s + out.p, luminance[branch]);
            }
        }
        sums.0 = xyz;
        (luminance[0].reduce_sum(), luminance[1].reduce_sum())
    }

    /// Writes a block of a branch to where it goes; one that leaves finds the uniform lights at once.
    ///
    /// Sums go in and out by value: behind a reference they pass through memory at every block.
    #[inline(always)]
    fn put<S: Simd>(
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
            Target::Out(path) => self.leaving.carried[path * self.blocks + block].store(s + p),
            Target::Nowhere => {}
        }
        self.scene.lights.add_uniform(simd, block, s + p, xyz)
    }

    #[inline(always)]
    fn at(&self, slot: usize, component: usize, block: usize) -> usize {
        (slot * 4 + component) * self.blocks + block
    }

    #[inline(always)]
    fn scale<S: Simd>(&mut self, simd: S, path: &Path, factor: f32) {
        let start = self.at(path.slot, 0, 0);
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        for lanes in &mut self.arena[start..start + count] {
            lanes.store(lanes.load(simd) * factor);
        }
    }
}

/// The four components of a slot.
#[inline(always)]
fn components(arena: &mut [Lanes], slot: usize, blocks: usize) -> [&mut [Lanes]; 4] {
    let own = &mut arena[slot * 4 * blocks..(slot + 1) * 4 * blocks];
    let (s, rest) = own.split_at_mut(blocks);
    let (p, rest) = rest.split_at_mut(blocks);
    let (u, v) = rest.split_at_mut(blocks);
    [s, p, u, v]
}

/// Some unit vector across a direction.
#[inline(always)]
fn any_across(direction: Vec3) -> Vec3 {
    let other = if direction.x.abs() < 0.5 { Vec3::new(1.0, 0.0, 0.0) } else { Vec3::new(0.0, 1.0, 0.0) };
    direction.cross(other).normalized()
}
