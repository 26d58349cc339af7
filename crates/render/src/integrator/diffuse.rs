//! Diffuse surfaces: the lights are sampled (`direct.rs`), and one branch goes on in a cosine-weighted direction.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

use super::direct::{Draws, Scatters, Sends};
use super::path::{Continuation, Path, Scattered, Since, Sums};
use super::{LATE_SURVIVAL, Tracer};
use crate::facet_lanes::{cosine_lanes, dot, single_points, world_lanes};
use crate::geometry::frame;
use crate::sampler::Choices;

impl Tracer<'_> {
    /// What a path finds at a diffuse surface; it goes on as `path`, or not at all.
    #[inline(always)]
    pub(super) fn scatter_diffuse<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        number: usize,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let hit = path.hit;
        path.hits += 1;
        let luminances = self.reflect_diffusely(simd, path, number);
        if path.hits > self.scene.max_depth {
            path.floor = luminances[1] / LATE_SURVIVAL;
        }
        if !self.survives_scattering(simd, path, luminances, sums, choices) {
            return false;
        }
        if path.hits <= self.scene.max_depth {
            self.raise_floor(path, luminances[1]);
        }
        let facing = if path.direction.dot(hit.normal) < 0.0 { hit.normal } else { -hit.normal };
        let is_dark = self.is_dark(path.medium);
        if !is_dark {
            self.direct_light(simd, path, &Lambertian { facing }, true, sums, choices);
        }

        let (direction, height) = Lambertian { facing }.direction(choices.pair());
        // In a medium that absorbs the lights were not sampled: whatever the branch finds is its own.
        let density = height * std::f64::consts::FRAC_1_PI;
        let scattered = (!is_dark).then_some(Scattered { origin: hit.point, density });
        let continuation = self.continuation(&hit, direction, path.medium, scattered);
        self.depart(path, facing, direction, scattered);
        if let Continuation::Surface(next) = continuation {
            (path.hit, path.direction, path.axis) = (next, direction, frame(direction).0);
            path.since = Since::scattering(scattered);
            self.scattered[path.slot] = scattered.unwrap_or_default();
            return true;
        }
        self.make_room(simd, 1);
        let to = self.target(continuation, path.slot, direction, scattered);
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let weight = self.arena[self.at(path.slot, 0, block)].load(simd);
            xyz = self.splat(simd, to, block, weight, weight, xyz);
        }
        sums.0 = xyz;
        false
    }

    /// Light from a diffuse surface is unpolarised, whatever fell on it. Gives the luminances before and now.
    #[inline(always)]
    fn reflect_diffusely<S: Simd>(&mut self, simd: S, path: &mut Path, number: usize) -> [f32; 2] {
        let [mut before, mut now] = [f32x16::splat(simd, 0.0); 2];
        let rgb = self.scene.reflectance_at(number, &path.hit);
        let rgb = rgb.map(|rgb| rgb.map(|value| f32x16::splat(simd, value as f32)));
        for block in 0..self.blocks {
            let (s_at, p_at) = (self.at(path.slot, 0, block), self.at(path.slot, 1, block));
            let both = self.arena[s_at].load(simd) + self.arena[p_at].load(simd);
            let reflectance = match rgb {
                None => self.spectra.diffuse[number][block].load(simd),
                Some([r, g, b]) => {
                    let [red, green, blue] = &self.spectra.rgb_basis;
                    let sum = blue[block].load(simd) * b;
                    red[block].load(simd).mul_add(r, green[block].load(simd).mul_add(g, sum))
                }
            };
            let out = both * reflectance * 0.5;
            self.arena[s_at].store(out);
            self.arena[p_at].store(out);
            let weight = self.spectra.importance[block].load(simd);
            before = weight.mul_add(both, before);
            now = weight.mul_add(out + out, now);
        }
        path.in_plane = true;
        path.is_unpolarized = true;
        [before.reduce_sum(), now.reduce_sum()]
    }
}

/// What is left of a path at a diffuse surface: unpolarised light, the same from everywhere before it.
struct Lambertian {
    facing: Vec3,
}

impl Lambertian {
    /// A direction in proportion to its cosine, and that.
    #[inline(always)]
    fn direction(&self, (a, b): (f64, f64)) -> (Vec3, f64) {
        let (across, up) = frame(self.facing);
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let (radius, height) = (a.sqrt(), (1.0 - a).sqrt());
        ((across * (radius * cos) + up * (radius * sin) + self.facing * height).normalized(), height)
    }
}

impl Draws for Lambertian {
    #[inline(always)]
    fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES], _: &mut Choices) -> [f32x16<S>; 3] {
        let (across, up) = frame(self.facing);
        world_lanes(&cosine_lanes(single_points(simd, points)), [across, up, self.facing])
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, ways: &[f32x16<S>; 3]) -> [f32x16<S>; 2] {
        let density = dot(ways, self.facing) * std::f32::consts::FRAC_1_PI;
        [density.max(f32x16::splat(simd, 0.0)); 2]
    }
}

impl Sends for Lambertian {
    #[inline(always)]
    fn evaluate<S: Simd>(&self, _: S, _: &mut Tracer<'_>, onward: &mut Path, direction: Vec3, _: usize) -> Option<f64> {
        (onward.direction, onward.axis) = (direction, frame(direction).0);
        let density = self.density(direction);
        (density > 0.0).then_some(density)
    }
}

impl Scatters for Lambertian {
    #[inline(always)]
    fn density(&self, direction: Vec3) -> f64 {
        direction.dot(self.facing) * std::f64::consts::FRAC_1_PI
    }

    #[inline(always)]
    fn facing(&self) -> Vec3 {
        self.facing
    }
}
