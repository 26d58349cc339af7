//! What an opaque rough surface sends on of a path that has not been scattered before, where the lights of the maps have been sampled: what
//! others mirror of each other, and what two of its own facets mirror one after the other.
//!
//! Sixteen facets that lie evenly are looked at together. What they mirror at once leaves by few branches, since most of these leave the
//! scene, where they find nothing. Where a second facet is in the way, the maps are asked of all sixteen pairs, and one of them is followed
//! by chance; either is done more often than light meets a second facet, and weighs as much less. A facet is taken in proportion to
//! how much of its light goes that way, and carries what all sixteen send there (resampling:
//! J. F. Talbot, D. Cline, P. Egbert, "Importance resampling for global illumination", EGSR 2005).

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

use super::direct::{Chosen, Draws, Sends, lane_of};
use super::facets::Facets;
use super::path::{Path, Sums};
use super::rough::First;
use super::{BRANCHES, Tracer};
use crate::camera::Ray;
use crate::facet_lanes::{RayLanes, dot, escapes, escapes_after, single_points, world_lanes};
use crate::geometry::Hit;
use crate::sampler::Choices;

/// Most branches that get out at once; one more meets a second facet.
const OUT: usize = BRANCHES - 1;

/// How many times as often as light meets a second facet that is followed, and its light from far away is looked for: where a rough mesh
/// is most efficient (docs/evidence/performance.md, "Maps and rough surfaces").
const FOLLOWED: f32 = 4.0;
const LIT: f32 = 16.0;

/// Sixteen facets of one place, each of them anywhere by itself.
struct Fan {
    /// Their normals, of any length, and the directions into which they mirror the ray, in the frame of the surface.
    facets: [[f32; LANES]; 3],
    ways: [[f32; LANES]; 3],
    /// The probability that what each mirrors gets out at once.
    escape: [f32; LANES],
    log2_height: f64,
}

impl Fan {
    #[inline(always)]
    fn new<S: Simd>(simd: S, facets: &Facets<'_>, points: &[(f64, f64); LANES]) -> Fan {
        let points = single_points(simd, points);
        let (ray, log2_height) = (facets.ray.lanes(points[0], &facets.spread), facets.ray.log2_height());
        let h = ray.facets(&facets.spread, points);
        let ways = ray.mirrored(&h);
        let escape = escapes(&facets.spread, log2_height, &ways).min(f32x16::splat(simd, 1.0)).to_array();
        Fan { facets: h.map(|along| along.to_array()), ways: ways.map(|along| along.to_array()), escape, log2_height }
    }

    /// One of the facets, of length 1.
    #[inline(always)]
    fn facet(&self, lane: usize) -> Vec3 {
        let [x, y, z] = self.facets.map(|along| f64::from(along[lane]));
        let h = Vec3::new(x, y, z);
        if h.length_squared() > 0.0 { h.normalized() } else { Vec3::new(0.0, 0.0, 1.0) }
    }
}

/// A second facet after each of a fan.
struct Seconds<'a> {
    facets: &'a Facets<'a>,
    fan: &'a Fan,
}

impl Draws for Seconds<'_> {
    #[inline(always)]
    fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES], _: &mut Choices) -> [f32x16<S>; 3] {
        let ray = self.rays(simd);
        let local = ray.mirrored(&ray.facets(&self.facets.spread, single_points(simd, points)));
        world_lanes(&local, self.facets.frame.axes())
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, ways: &[f32x16<S>; 3]) -> [f32x16<S>; 2] {
        let (spread, local) = (&self.facets.spread, self.facets.frame.local_lanes(ways));
        let first = self.fan.ways.map(|along| f32x16::from_slice(simd, &along));
        let density = self.rays(simd).densities(spread, &local);
        let sent = escapes_after(spread, self.fan.log2_height, &first, &local);
        [density, (density * sent).copysign(dot(ways, self.facets.facing)).max(f32x16::splat(simd, 0.0))]
    }
}

impl Seconds<'_> {
    #[inline(always)]
    fn rays<S: Simd>(&self, simd: S) -> RayLanes<f32x16<S>> {
        RayLanes::new(&self.facets.spread, self.fan.ways.map(|along| -f32x16::from_slice(simd, &along)))
    }
}

/// A way by two facets.
struct Pair<'a> {
    facets: &'a Facets<'a>,
    /// The first, in the frame of the surface.
    first: Vec3,
    /// What part of the light goes it, per solid angle.
    density: f64,
}

impl Sends for Pair<'_> {
    #[inline(always)]
    fn evaluate<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64> {
        let facets = self.facets;
        tracer.copy_slot(onward, slot);
        let between = facets.frame.world(facets.ray.mirrored(self.first).direction).normalized();
        let second = (direction - between).normalized();
        for (h, out) in [(facets.frame.world(self.first), between), (second, direction)] {
            tracer.rotate_stokes_frame_to(simd, onward, h);
            facets.respond(simd, tracer, onward, h, true);
            onward.direction = out;
            onward.is_unpolarized = false;
        }
        Some(self.density)
    }
}

impl Tracer<'_> {
    /// Whether a path is followed by a [`Fan`] and not by one branch. (Where they find light far away, too, more cost more than
    /// they win: four made `beetle` take 1.4 times the time for 0.85 of the variance.)
    #[inline(always)]
    pub(super) fn looks_closely(&self, path: &Path) -> bool {
        self.spectra.lights.are_all_sampled() && path.is_whole && path.hits < self.scene.max_depth
    }

    /// Sends branches of a path on that carries so much; they wait.
    #[inline(always)]
    pub(super) fn send_fan<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        luminance: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let fan = simd.vectorize(
            #[inline(always)]
            || Fan::new(simd, facets, &choices.pairs(LANES as u32).points()),
        );
        let blocked = fan.escape.map(|escape| 1.0 - escape);
        let [out, inside] = [&fan.escape, &blocked].map(|shares| shares.iter().sum::<f32>());
        // Which way out, whether second facets are lit, which is followed, and how high that lies.
        let ((lit, place), (at, height)) = (choices.pair(), choices.pair());

        let branches = ((OUT as f32 * luminance).ceil() as usize).clamp(1, OUT);
        let share = out / (LANES * branches) as f32;
        for branch in 0..branches {
            let Some(lane) = lane_of(&fan.escape, out * (branch as f32 + place as f32) / branches as f32) else {
                break;
            };
            let facet = fan.facet(lane);
            if self.meets_something(&path.hit, facets, facet) {
                let first = First { facet, random: 0.0, second_is_lit: false };
                self.send(simd, path, facets, first, share, sums, choices);
            }
        }

        let share = inside / LANES as f32;
        // (What carries no luminance may still carry colour.)
        let seen = share * luminance.max(1e-3);
        let odds = (LIT * seen).min(1.0);
        if odds > 0.0 && !facets.is_dark[0] && lit < f64::from(odds) {
            simd.vectorize(
                #[inline(always)]
                || self.light_seconds(simd, path, facets, (&fan, odds), sums, choices),
            );
        }
        let odds = (FOLLOWED * seen).min(1.0);
        if odds > 0.0
            && at < f64::from(odds)
            && let Some(lane) = lane_of(&blocked, inside * (at as f32 / odds))
        {
            let facet = fan.facet(lane);
            let random = facets.ray.mirrored(facet).blocking(&facets.spread, height);
            let first = First { facet, random, second_is_lit: true };
            self.send(simd, path, facets, first, share / odds, sums, choices);
        }
    }

    /// The light of the maps that second facets see, of what a fan comes to with these odds.
    #[inline(always)]
    fn light_seconds<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        (fan, odds): (&Fan, f32),
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let seconds = Seconds { facets, fan };
        let Some(Chosen { mut sampled, lane, target }) = self.sample_maps(simd, &seconds, choices) else { return };
        sampled.density *= f64::from(odds);
        let pair = Pair { facets, first: fan.facet(lane), density: target };
        self.connect(simd, path, &pair, &sampled, sums, choices);
    }

    /// Whether what a facet mirrors meets an object: of the light far away the lights have told.
    #[inline(always)]
    fn meets_something(&self, hit: &Hit, facets: &Facets<'_>, h: Vec3) -> bool {
        let direction = facets.frame.world(facets.ray.mirrored(h).direction).normalized();
        direction.dot(facets.facing) > 0.0
            && self.scene.geometry.nearest(&Ray { origin: hit.point, direction }, Some(hit)).is_some()
    }

    /// Sends one of them on.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    fn send<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        first: First,
        share: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) {
        let Some(slot) = self.free.pop() else { unreachable!("slots are kept for these") };
        let mut branch = *path;
        self.copy_slot(&mut branch, slot);
        self.scale(simd, &branch, share);
        match self.send_one(simd, &mut branch, *facets, first, share, sums, choices) {
            true => self.waiting.push(branch),
            false => self.free.push(branch.slot),
        }
    }
}
