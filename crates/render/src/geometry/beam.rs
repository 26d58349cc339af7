//! Where all rays of a bundle pass: between planes through an axis, which boxes are held against once for all of them.

use fearless_simd::{Simd, f32x8, prelude::*};

use super::bounds::Bounds;
use crate::camera::Ray;

/// Least part of a direction along the axis of its beam: the largest part of the first ray's is 0.57 or more.
const LEAST_ALONG: f64 = 0.5;
/// By how much a beam is wider than its rays, of the reach of all boxes: single precision takes less than this and the boxes' padding.
const SLACK: f64 = 1.0 / (1 << 19) as f64;

/// Part of space that holds some rays from where they come near. Positions count along and across one axis from the middle of all boxes.
pub struct Beam {
    /// The axis along which the rays go, and those across it.
    axis: usize,
    across: [usize; 2],
    /// It goes down along its axis.
    is_down: bool,
    /// Where it begins along its axis.
    start: f64,
    /// Across the axis: where the rays are at the start, from and to, and how far aside they go for a step along it.
    from: [f32; 2],
    to: [f32; 2],
    from_slope: [f32; 2],
    to_slope: [f32; 2],
    slack: f64,
}

impl Beam {
    /// Around rays that go the same way, with boxes around a middle, up to `reach` from it; `None` where they go too different ways.
    pub fn new(rays: &[Ray], middle: [f64; 3], reach: f64, bounds: &Bounds) -> Option<Beam> {
        let ways = rays.first()?.direction.to_array();
        let axis = (0..3).max_by(|&a, &b| ways[a].abs().total_cmp(&ways[b].abs()))?;
        let (across, is_down) = ([(axis + 1) % 3, (axis + 2) % 3], ways[axis] < 0.0);
        let sign = if is_down { -1.0 } else { 1.0 };
        let near = if is_down { bounds.max[axis] } else { bounds.min[axis] };
        let slack = SLACK * reach;
        let box_start = sign * (near - middle[axis]) - slack;
        let mut first = f64::INFINITY;
        for ray in rays {
            first = first.min(sign * (ray.origin.to_array()[axis] - middle[axis]));
            // False of what is no number, too.
            let goes_along = sign * ray.direction.to_array()[axis] >= LEAST_ALONG;
            if !goes_along {
                return None;
            }
        }
        let start = box_start.max(first);
        let (mut from, mut to) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut from_slope, mut to_slope) = (from, to);
        for ray in rays {
            let (origin, way) = (ray.origin.to_array(), ray.direction.to_array());
            let per = 1.0 / (sign * way[axis]);
            let steps = start - sign * (origin[axis] - middle[axis]);
            for (side, &other) in across.iter().enumerate() {
                let slope = way[other] * per;
                let place = origin[other] - middle[other] + slope * steps;
                (from[side], to[side]) = (from[side].min(place), to[side].max(place));
                (from_slope[side], to_slope[side]) = (from_slope[side].min(slope), to_slope[side].max(slope));
            }
        }
        Some(Beam {
            axis,
            across,
            is_down,
            start,
            from: from.map(|place| (place - slack) as f32),
            to: to.map(|place| (place + slack) as f32),
            from_slope: from_slope.map(|slope| slope as f32),
            to_slope: to_slope.map(|slope| slope as f32),
            slack,
        })
    }

    /// How far along the beam a ray is at a distance of its own, from the start on.
    #[inline(always)]
    pub fn along(&self, ray: &Ray, middle: [f64; 3], distance: f64) -> f64 {
        let sign = if self.is_down { -1.0 } else { 1.0 };
        let origin = sign * (ray.origin.to_array()[self.axis] - middle[self.axis]);
        origin + sign * ray.direction.to_array()[self.axis] * distance - self.start
    }

    /// Such a place in single precision, by rounding no nearer.
    #[inline(always)]
    pub fn in_single(&self, along: f64) -> f32 {
        (along * 1.000_001 + self.slack) as f32
    }

    /// Which of eight boxes it meets, as bits, and how far along it they begin.
    #[inline(always)]
    pub fn meets<S: Simd>(&self, simd: S, bounds: &[[[f32; 8]; 2]; 3], limit: f32) -> (u32, [f32; 8]) {
        let splat = |value: f32| f32x8::splat(simd, value);
        let load = |planes: &[f32; 8]| f32x8::from_slice(simd, planes);
        let along = &bounds[self.axis % 3];
        let (low, high) = (load(&along[0]), load(&along[1]));
        let start = self.start as f32;
        let (near, far) = if self.is_down {
            (splat(-start) - high, splat(-start) - low)
        } else {
            (low - splat(start), high - splat(start))
        };
        let near = near.max(splat(0.0));
        let mut met = near.simd_le(far.min(splat(limit)));
        for side in 0..2 {
            let boxes = &bounds[self.across[side] % 3];
            let (from, to) = (self.from_slope[side], self.to_slope[side]);
            // Its edge is farthest out where a box begins or where it ends, by whether it goes there: one of the two has no part in it.
            let from = splat(self.from[side]) + near * splat(from.max(0.0)) + far * splat(from.min(0.0));
            let to = splat(self.to[side]) + near * splat(to.min(0.0)) + far * splat(to.max(0.0));
            met = met & load(&boxes[0]).simd_le(to) & load(&boxes[1]).simd_ge(from);
        }
        (simd.to_bitmask_mask32x8(met) as u32, near.into())
    }
}
