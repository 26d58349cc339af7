//! What one camera ray brings home.
//!
//! A path is traced from the camera and carries, at every spectral node, the adjoint Stokes vector: the row
//! vector w with "measured = w . (Stokes vector of light arriving against the path)". It starts as (1, 0, 0, 0)
//! and is multiplied by rotations and Mueller matrices as the path meets films (docs/theory.md). Instead of I and
//! Q it holds the weights of s and p light, w_I + w_Q and w_I - w_Q, which a film multiplies by R_s and R_p;
//! U and V stay untouched zeros as long as all planes of incidence coincide.
//!
//! At a film both branches are followed. What is left out is left out by chance, never dropped: below
//! [`FAINT`] a branch survives with probability in proportion to its luminance, and from `max_depth` hits on one
//! branch is chosen in proportion to luminance, which leaves the luminance of the path as it was.

use fearless_simd::{Simd, f32x16, prelude::*};

use crate::camera::Ray;
use crate::film::Beam;
use crate::geometry::{Hit, nearest};
use crate::lanes::Lanes;
use crate::prepare::{Prepared, PreparedLight, Radiance, SURROUNDING};
use crate::sampler::Choices;
use crate::vector::Vec3;

/// Luminance (of 1 at the camera) below which a branch survives only by chance. The noise that this makes is
/// at most FAINT / 2 of a light's radiance for one branch of one sample.
const FAINT: f32 = 4e-5;

/// Hits after which even a path that loses nothing (a ray caught at grazing angles) goes on with probability 1/2 only.
const PATIENCE: u32 = 4096;

/// Planes of incidence closer than this (sine of the angle between them) count as one: the second-order error is 1e-10.
const SAME_PLANE: f64 = 1e-5;

/// A path that waits to be continued; its spectra stand in the arena under `slot`.
#[derive(Clone, Copy)]
struct Path {
    ray: Ray,
    leaving: Option<usize>,
    /// The s direction of the plane that the Stokes vector refers to; meaningless before the first hit.
    axis: Vec3,
    slot: usize,
    hits: u32,
    medium: u16,
    /// U and V are zero (and their storage is stale).
    in_plane: bool,
}

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
            return bare(&scene.lights, ray.direction);
        };
        let mut sum = [0.0; 3];
        let slot = self.free.pop().expect("all slots are free between camera rays");
        let start = slot * 4 * self.blocks;
        self.arena[start..start + 2 * self.blocks].fill(Lanes::ONE);
        let mut path =
            Path { ray, leaving: None, axis: Vec3::default(), slot, hits: 0, medium: SURROUNDING, in_plane: true };
        let mut hit = Some(hit);
        loop {
            let goes_on = match hit {
                Some(hit) => self.meet_film(simd, &mut path, &hit, choices),
                None => {
                    let xyz = self.arrive(simd, &path);
                    for c in 0..3 {
                        sum[c] += xyz[c];
                    }
                    false
                }
            };
            if !goes_on {
                self.free.push(path.slot);
                match self.waiting.pop() {
                    Some(next) => path = next,
                    None => return sum,
                }
            }
            hit = nearest(&scene.spheres, &path.ray, path.leaving);
        }
    }

    /// Splits a path at a film. It continues as `path` (false: nothing of it is left); a second branch waits.
    #[inline(always)]
    fn meet_film<S: Simd>(&mut self, simd: S, path: &mut Path, hit: &Hit, choices: &mut Choices) -> bool {
        let scene = self.scene;
        let film = &scene.films[hit.object];
        debug_assert_eq!(path.medium, film.outside, "a film must lie in the medium that the ray is in");
        let thickness_nm = film.thickness_nm(hit.point) as f32;
        let direction = path.ray.direction;
        let along = direction.dot(hit.normal);
        let cos_theta = along.abs().min(1.0) as f32;

        self.turn_to_plane(simd, path, hit);
        path.hits += 1;

        let other = self.free.pop().expect("one slot a level");
        let (reflected_y, transmitted_y) = if path.in_plane && film.table.is_plain() {
            self.split_plain(simd, path.slot, other, hit.object, cos_theta, thickness_nm)
        } else {
            self.split_any(simd, path.in_plane, path.slot, other, hit.object, cos_theta, thickness_nm)
        };
        let passed = Path { ray: Ray { origin: hit.point, direction }, leaving: Some(hit.object), ..*path };
        let mirrored = Path {
            ray: Ray { origin: hit.point, direction: (direction - hit.normal * (2.0 * along)).normalized() },
            leaving: Some(hit.object),
            slot: other,
            ..*path
        };

        let (mut reflected_y, mut transmitted_y) = (reflected_y, transmitted_y);
        let (mut keep_passed, mut keep_mirrored) = (true, true);
        if path.hits >= scene.max_depth {
            let sum = reflected_y + transmitted_y;
            let share = if sum > 0.0 { (reflected_y / sum).clamp(0.0, 1.0) } else { 0.0 };
            keep_mirrored = sum > 0.0 && choices.next() < share;
            keep_passed = sum > 0.0 && !keep_mirrored;
            let (kept, probability) = if keep_mirrored { (&mirrored, share) } else { (&passed, 1.0 - share) };
            self.scale(simd, kept, 1.0 / probability);
            (reflected_y, transmitted_y) = (sum, sum);
            if path.hits > PATIENCE {
                let survives = choices.next() < 0.5;
                keep_mirrored &= survives;
                keep_passed &= survives;
                self.scale(simd, kept, 2.0);
            }
        }
        let alive = |this: &mut Self, path: &Path, luminance: f32, choices: &mut Choices| {
            if luminance >= FAINT {
                return true;
            }
            // A faint branch whose luminance is not even positive (rounding) still may carry colour: floor the odds.
            let odds = (luminance / FAINT).max(1e-3);
            let survives = choices.next() < odds;
            if survives {
                this.scale(simd, path, 1.0 / odds);
            }
            survives
        };
        keep_mirrored = keep_mirrored && alive(self, &mirrored, reflected_y, choices);
        keep_passed = keep_passed && alive(self, &passed, transmitted_y, choices);

        match (keep_mirrored, keep_passed) {
            (true, true) => {
                self.waiting.push(mirrored);
                *path = passed;
                true
            }
            (true, false) => {
                self.free.push(path.slot);
                *path = mirrored;
                true
            }
            (false, keep) => {
                self.free.push(other);
                *path = passed;
                keep
            }
        }
    }

    /// Refers the path's Stokes vector to the plane of incidence of its next film.
    #[inline(always)]
    fn turn_to_plane<S: Simd>(&mut self, simd: S, path: &mut Path, hit: &Hit) {
        let direction = path.ray.direction;
        let across = hit.normal.cross(direction);
        let sine2 = across.length_squared();
        // Light travels against the path.
        let light = -direction;
        if path.hits == 0 {
            path.axis = if sine2 > 1e-20 { across * (1.0 / sine2.sqrt()) } else { any_across(direction) };
            return;
        }
        if sine2 < 1e-12 {
            // Near the normal s and p are alike and every plane is as good: keep the one at hand.
            return;
        }
        let axis = across * (1.0 / sine2.sqrt());
        let cos = axis.dot(path.axis);
        let sin = axis.dot(light.cross(path.axis));
        path.axis = axis;
        if path.in_plane && sin.abs() < SAME_PLANE {
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

    /// A lossless film while all planes of incidence coincide: `slot` becomes what passes, `other` what is reflected.
    #[inline(always)]
    fn split_plain<S: Simd>(
        &mut self,
        simd: S,
        slot: usize,
        other: usize,
        object: usize,
        cos_theta: f32,
        thickness_nm: f32,
    ) -> (f32, f32) {
        let table = &self.scene.films[object].table;
        let (mut reflected_y, mut all_y) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 0.0));
        for block in 0..self.blocks {
            let [r_s, r_p] = table.reflectance(simd, block, cos_theta, thickness_nm);
            let (s_at, p_at) = (slot * 4 * self.blocks + block, (slot * 4 + 1) * self.blocks + block);
            let (s, p) = (self.arena[s_at].load(simd), self.arena[p_at].load(simd));
            let (back_s, back_p) = (s * r_s, p * r_p);
            self.arena[s_at].store(s - back_s);
            self.arena[p_at].store(p - back_p);
            self.arena[other * 4 * self.blocks + block].store(back_s);
            self.arena[(other * 4 + 1) * self.blocks + block].store(back_p);
            let weight = self.scene.importance[block].load(simd);
            reflected_y = weight.mul_add(back_s + back_p, reflected_y);
            all_y = weight.mul_add(s + p, all_y);
        }
        let reflected_y = reflected_y.reduce_sum();
        (reflected_y, all_y.reduce_sum() - reflected_y)
    }

    /// Any film, any planes.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "twin of split_plain with the plane's state")]
    fn split_any<S: Simd>(
        &mut self,
        simd: S,
        in_plane: bool,
        slot: usize,
        other: usize,
        object: usize,
        cos_theta: f32,
        thickness_nm: f32,
    ) -> (f32, f32) {
        let table = &self.scene.films[object].table;
        let zero = f32x16::splat(simd, 0.0);
        let (mut reflected_y, mut transmitted_y) = (zero, zero);
        let at = |slot: usize, component: usize, block: usize| (slot * 4 + component) * self.blocks + block;
        for block in 0..self.blocks {
            let response = table.response(simd, block, cos_theta, thickness_nm);
            let mut w = Beam {
                s: self.arena[at(slot, 0, block)].load(simd),
                p: self.arena[at(slot, 1, block)].load(simd),
                u: zero,
                v: zero,
            };
            if !in_plane {
                w.u = self.arena[at(slot, 2, block)].load(simd);
                w.v = self.arena[at(slot, 3, block)].load(simd);
            }
            let weight = self.scene.importance[block].load(simd);
            for (matrix, to, y) in
                [(&response.reflect, other, &mut reflected_y), (&response.transmit, slot, &mut transmitted_y)]
            {
                let out = matrix.carry(&w);
                self.arena[at(to, 0, block)].store(out.s);
                self.arena[at(to, 1, block)].store(out.p);
                if !in_plane {
                    self.arena[at(to, 2, block)].store(out.u);
                    self.arena[at(to, 3, block)].store(out.v);
                }
                *y = weight.mul_add(out.s + out.p, *y);
            }
        }
        (reflected_y.reduce_sum(), transmitted_y.reduce_sum())
    }

    #[inline(always)]
    fn scale<S: Simd>(&mut self, simd: S, path: &Path, factor: f32) {
        let start = path.slot * 4 * self.blocks;
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        for lanes in &mut self.arena[start..start + count] {
            lanes.store(lanes.load(simd) * factor);
        }
    }

    /// XYZ of the light that a path finds where it leaves the scene.
    #[inline(always)]
    fn arrive<S: Simd>(&self, simd: S, path: &Path) -> [f32; 3] {
        let start = path.slot * 4 * self.blocks;
        let s = &self.arena[start..start + self.blocks];
        let p = &self.arena[start + self.blocks..start + 2 * self.blocks];
        let mut xyz = [0.0; 3];
        for light in &self.scene.lights {
            let [x_weights, y_weights, z_weights] = &light.weights;
            let zero = f32x16::splat(simd, 0.0);
            let (mut x, mut y, mut z) = (zero, zero, zero);
            let mut add = |block: usize, carried: f32x16<S>| {
                x = x_weights[block].load(simd).mul_add(carried, x);
                y = y_weights[block].load(simd).mul_add(carried, y);
                z = z_weights[block].load(simd).mul_add(carried, z);
            };
            match &light.radiance {
                Radiance::Uniform { .. } => {
                    for block in 0..self.blocks {
                        add(block, s[block].load(simd) + p[block].load(simd));
                    }
                }
                Radiance::Map { lookup, factor, .. } => {
                    let [r, g, b] = lookup.rgb(path.ray.direction).map(|v| v * factor);
                    let [red, green, blue] = &self.scene.basis;
                    for block in 0..self.blocks {
                        let colour =
                            red[block].load(simd) * r + green[block].load(simd) * g + blue[block].load(simd) * b;
                        add(block, (s[block].load(simd) + p[block].load(simd)) * colour);
                    }
                }
            }
            for (total, part) in xyz.iter_mut().zip([x, y, z]) {
                *total += part.reduce_sum();
            }
        }
        xyz
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

/// XYZ of the lights themselves in a direction.
#[inline(always)]
fn bare(lights: &[PreparedLight], direction: Vec3) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for light in lights {
        match &light.radiance {
            Radiance::Uniform { xyz } => {
                for c in 0..3 {
                    sum[c] += xyz[c];
                }
            }
            Radiance::Map { lookup, factor, rgb_to_xyz } => {
                let rgb = lookup.rgb(direction);
                for (value, column) in rgb.iter().zip(rgb_to_xyz) {
                    for c in 0..3 {
                        sum[c] += value * factor * column[c];
                    }
                }
            }
        }
    }
    sum
}

/// Some unit vector across a direction.
fn any_across(direction: Vec3) -> Vec3 {
    let other = if direction.x.abs() < 0.5 { Vec3::new(1.0, 0.0, 0.0) } else { Vec3::new(0.0, 1.0, 0.0) };
    direction.cross(other).normalized()
}
