//! Rays of one pixel as one bundle: boxes are met once for all of them, triangles by eight rays at a time.

use fearless_simd::{Simd, f64x8, prelude::*};
use iridesce_numerics::lanes::{DOUBLES, Doubles, Lanes};

use super::beam::Beam;
use super::build::LEAF;
use super::hierarchy::Walk;
use super::mesh::{Met, OVERLAP, TriangleMesh, crossing, is_nearer};
use crate::camera::{MOST_TOGETHER, Ray};

/// Fewer rays are as quick one by one.
pub const LEAST: usize = 8;
/// A bundle that has met so many leaves is wide beside the triangles: its rays are quicker one by one.
const MOST_LEAVES: u32 = 16;

const GROUPS: usize = MOST_TOGETHER / DOUBLES;

/// Rays side by side that look for their nearest crossings with a mesh.
struct Bundle {
    origin: [[Doubles; GROUPS]; 3],
    direction: [[Doubles; GROUPS]; 3],
    limit: [Doubles; GROUPS],
}

impl TriangleMesh {
    /// The nearest crossing of each of some rays that start on no triangle, as far as its limit. False, and nothing of use, where they
    /// are better looked for one by one.
    #[inline(always)]
    pub fn nearest_of_bundle<S: Simd>(
        &self,
        simd: S,
        rays: &[Ray],
        limits: &[f64],
        best: &mut [Option<Met>; MOST_TOGETHER],
    ) -> bool {
        let Some(beam) = self.hierarchy.beam(rays) else { return false };
        let mut bundle = Bundle::new(rays, limits);
        let mut walk = Walk::default();
        if !walk.begin_beam(&self.hierarchy, beam.in_single(bundle.reach(&beam, rays, self.hierarchy.middle()))) {
            return true;
        }
        let mut leaves = 0;
        loop {
            if let Some((first, _)) = walk.look_along(simd, &self.hierarchy, &beam) {
                leaves += 1;
                if leaves > MOST_LEAVES {
                    return false;
                }
                if bundle.meet(simd, self, first, rays.len().div_ceil(DOUBLES), best) {
                    walk.shorten_beam(beam.in_single(bundle.reach(&beam, rays, self.hierarchy.middle())));
                }
            }
            if !walk.choose(&self.hierarchy) {
                return true;
            }
        }
    }
}

impl Bundle {
    #[inline(always)]
    fn new(rays: &[Ray], limits: &[f64]) -> Bundle {
        let mut bundle = Bundle {
            origin: [[Doubles::ZERO; GROUPS]; 3],
            direction: [[Doubles::ZERO; GROUPS]; 3],
            // No crossing is so near: lanes without a ray.
            limit: [Lanes([f64::NEG_INFINITY; DOUBLES]); GROUPS],
        };
        for (number, (ray, limit)) in rays.iter().zip(limits).enumerate() {
            let (group, lane) = (number / DOUBLES, number % DOUBLES);
            let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
            for axis in 0..3 {
                bundle.origin[axis][group].0[lane] = origin[axis];
                bundle.direction[axis][group].0[lane] = direction[axis];
            }
            bundle.limit[group].0[lane] = *limit;
        }
        bundle
    }

    /// How far along their beam any of the rays still looks.
    #[inline(always)]
    fn reach(&self, beam: &Beam, rays: &[Ray], middle: [f64; 3]) -> f64 {
        let limits = self.limit.iter().flat_map(|group| group.0);
        rays.iter().zip(limits).fold(f64::NEG_INFINITY, |most, (ray, limit)| most.max(beam.along(ray, middle, limit)))
    }

    /// Meets the triangles of a leaf; whether any is the nearest of a ray so far.
    #[inline(always)]
    fn meet<S: Simd>(
        &mut self,
        simd: S,
        mesh: &TriangleMesh,
        leaf: usize,
        groups: usize,
        best: &mut [Option<Met>; MOST_TOGETHER],
    ) -> bool {
        let block = &mesh.blocks[leaf];
        let splat = |value: f64| f64x8::splat(simd, value);
        let least = splat(-OVERLAP);
        let mut any = false;
        for lane in 0..LEAF {
            let triangle = block.triangles[lane];
            if triangle == u32::MAX {
                break;
            }
            let at = |rows: &[[f64; 4]; 3]| [splat(rows[0][lane]), splat(rows[1][lane]), splat(rows[2][lane])];
            let (corner, first, second) = (at(&block.corner), at(&block.first), at(&block.second));
            for group in 0..groups.min(GROUPS) {
                let load = |rows: &[[Doubles; GROUPS]; 3]| {
                    [rows[0][group].load_all(simd), rows[1][group].load_all(simd), rows[2][group].load_all(simd)]
                };
                let (b, c, volume, per) =
                    crossing(load(&self.origin), load(&self.direction), corner, first, second, splat(1.0));
                let distance = volume * per;
                let met = b.simd_ge(least)
                    & c.simd_ge(least)
                    & (b + c).simd_le(splat(1.0 + OVERLAP))
                    & distance.simd_gt(splat(0.0))
                    & distance.simd_le(self.limit[group].load_all(simd));
                let mut met = simd.to_bitmask_mask64x8(met);
                if met == 0 {
                    continue;
                }
                let distances: [f64; 8] = distance.into();
                while met != 0 {
                    let ray = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let (distance, limit) = (distances[ray], &mut self.limit[group].0[ray]);
                    let best = &mut best[group * DOUBLES + ray];
                    if is_nearer(best, *limit, distance, triangle) {
                        *best = Some(Met { triangle, distance, seat: (leaf * LEAF + lane) as u32 });
                        *limit = distance;
                        any = true;
                    }
                }
            }
        }
        any
    }
}
