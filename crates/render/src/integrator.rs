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
//! luminance; after `max_depth` hits with probability 1/2; and where two go on after `max_depth`, one is chosen in
//! proportion to luminance. Every such choice is made against the scene's mean light: what the branch would find if
//! its surroundings had their mean radiance is added for certain, and only the difference from that is left to
//! chance. In a uniform environment nothing at all is.

use fearless_simd::{Simd, f32x16, prelude::*};

use crate::camera::Ray;
use crate::film::{Beam, Mueller};
use crate::geometry::{Hit, nearest};
use crate::lanes::Lanes;
use crate::prepare::{Prepared, SURROUNDING};
use crate::sampler::Choices;
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
    /// U and V are zero (and their storage is stale).
    in_plane: bool,
}

/// What becomes of a branch.
#[derive(Clone, Copy)]
enum Fate {
    /// It meets another film.
    GoesOn(Hit),
    /// It leaves the scene and finds this linear Rec.709 radiance in the maps (and the uniform lights).
    Leaves([f32; 3]),
}

impl Fate {
    #[inline(always)]
    fn leaves(&self) -> (bool, [f32; 3]) {
        match *self {
            Fate::GoesOn(_) => (false, [0.0; 3]),
            Fate::Leaves(rgb) => (true, rgb),
        }
    }
}

/// Sums of X, Y, Z over a block's lanes.
struct Sums<S: Simd>([f32x16<S>; 3]);

/// Working memory of one thread.
pub struct Tracer<'a> {
    scene: &'a Prepared,
    /// Spectra by slot: s, p, u, v, each `blocks` long.
    arena: Vec<Lanes>,
    blocks: usize,
    waiting: Vec<Path>,
    free: Vec<usize>,
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
        }
    }

    /// XYZ that arrives at the camera along a ray.
    #[inline(always)]
    pub fn radiance<S: Simd>(&mut self, simd: S, ray: Ray, choices: &mut Choices) -> [f32; 3] {
        let scene = self.scene;
        let Some(hit) = nearest(&scene.spheres, &ray, None) else {
            return scene.lights.xyz(ray.direction);
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
            in_plane: true,
        };
        let zero = f32x16::splat(simd, 0.0);
        let mut sums = Sums([zero; 3]);
        loop {
            if !self.meet_film(simd, &mut path, &mut sums, choices) {
                self.free.push(path.slot);
                match self.waiting.pop() {
                    Some(next) => path = next,
                    None => {
                        let [x, y, z] = sums.0;
                        // Not `map`: closures are not compiled for the wider instructions.
                        return [x.reduce_sum(), y.reduce_sum(), z.reduce_sum()];
                    }
                }
            }
        }
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
        let (slot, both_go_on) = (path.slot, matches!((passed, mirrored), (Fate::GoesOn(_), Fate::GoesOn(_))));
        let other = if both_go_on { self.free.pop().expect("one slot a level") } else { slot };
        let (mirrored_y, passed_y) = if path.in_plane && film.table.is_plain() {
            self.split_plain(simd, path, cos_theta, thickness_nm, [other, slot], [mirrored, passed], sums)
        } else {
            self.split_any(simd, path, cos_theta, thickness_nm, [other, slot], [mirrored, passed], sums)
        };

        match (mirrored, passed) {
            (Fate::Leaves(_), Fate::Leaves(_)) => false,
            (Fate::GoesOn(hit), Fate::Leaves(_)) => {
                (path.direction, path.hit) = (mirror, hit);
                self.survives(simd, path, mirrored_y, sums, choices)
            }
            (Fate::Leaves(_), Fate::GoesOn(hit)) => {
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
            None => Fate::Leaves(self.scene.lights.map_rgb(direction)),
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
        let deep = path.hits >= self.scene.max_depth;
        if luminance >= FAINT && !deep {
            return true;
        }
        // A branch without luminance (or, by rounding, below zero) may still carry colour: the odds have a floor.
        let odds = (luminance / FAINT).clamp(1e-3, if deep { 0.5 } else { 1.0 });
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
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            xyz = self.scene.lights.add(simd, block, (s + p) * factor, self.scene.lights.mean_rgb, xyz);
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

    /// A lossless film while all planes of incidence coincide. Branches are in the order mirrored, passed; one that
    /// goes on is stored in its slot of `to`, one that leaves is added to `sums`. Gives the luminance of those that go on.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one flat hot loop, called from one place")]
    fn split_plain<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        cos_theta: f32,
        thickness_nm: f32,
        to: [usize; 2],
        fates: [Fate; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let scene = self.scene;
        let table = &scene.films[path.hit.object].table;
        let zero = f32x16::splat(simd, 0.0);
        let (mut mirrored_y, mut passed_y) = (zero, zero);
        // Sums and fates are kept in registers; left behind references, they go through memory at every block.
        let mut xyz = sums.0;
        let (mirrored_leaves, mirrored_rgb) = fates[0].leaves();
        let (passed_leaves, passed_rgb) = fates[1].leaves();
        for block in 0..self.blocks {
            let [r_s, r_p] = table.reflectance(simd, block, cos_theta, thickness_nm);
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            let (back_s, back_p) = (s * r_s, p * r_p);
            let (through_s, through_p) = (s - back_s, p - back_p);
            let weight = scene.importance[block].load(simd);
            if mirrored_leaves {
                xyz = scene.lights.add(simd, block, back_s + back_p, mirrored_rgb, xyz);
            } else {
                self.store(to[0], block, back_s, back_p);
                mirrored_y = weight.mul_add(back_s + back_p, mirrored_y);
            }
            if passed_leaves {
                xyz = scene.lights.add(simd, block, through_s + through_p, passed_rgb, xyz);
            } else {
                self.store(to[1], block, through_s, through_p);
                passed_y = weight.mul_add(through_s + through_p, passed_y);
            }
        }
        sums.0 = xyz;
        (mirrored_y.reduce_sum(), passed_y.reduce_sum())
    }

    /// [`Tracer::split_plain`] for any film and any planes.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one flat hot loop, called from one place")]
    fn split_any<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        cos_theta: f32,
        thickness_nm: f32,
        to: [usize; 2],
        fates: [Fate; 2],
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
                if let (true, rgb) = fates[branch].leaves() {
                    xyz = scene.lights.add(simd, block, out.s + out.p, rgb, xyz);
                    continue;
                }
                self.store(to[branch], block, out.s, out.p);
                if !path.in_plane {
                    let (u_at, v_at) = (self.at(to[branch], 2, block), self.at(to[branch], 3, block));
                    self.arena[u_at].store(out.u);
                    self.arena[v_at].store(out.v);
                }
                luminance[branch] = scene.importance[block].load(simd).mul_add(out.s + out.p, luminance[branch]);
            }
        }
        sums.0 = xyz;
        (luminance[0].reduce_sum(), luminance[1].reduce_sum())
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, slot: usize, block: usize, s: f32x16<S>, p: f32x16<S>) {
        let (s_at, p_at) = (self.at(slot, 0, block), self.at(slot, 1, block));
        self.arena[s_at].store(s);
        self.arena[p_at].store(p);
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
