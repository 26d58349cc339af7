//! A hierarchy of boxes with eight children a node, and the walk of a ray through it.
//!
//! Boxes are f32, relative to the middle of the whole; each is padded by more than single precision loses of the ray, so
//! that a box is never missed whose content double precision would meet. What lies in the leaves is the caller's.

use fearless_simd::{Simd, f32x8, prelude::*};
use iridesce_numerics::Vec3;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::build::{Item, LEAF, PARALLEL, Tree};
use crate::camera::Ray;

const WIDTH: usize = 8;
/// Set in the number of a child that is a leaf; then three bits for its count less one, and its first item.
const IS_LEAF: u32 = 1 << 31;
const COUNT_AT: u32 = 28;
const FIRST: u32 = (1 << COUNT_AT) - 1;
/// Share of the whole's reach by which boxes are padded: eight times what the rounding of a ray to f32 may take.
const PAD: f64 = 1.0 / (1 << 20) as f64;
/// Entries of a walk's stack that need no memory of their own.
const SHALLOW: usize = 64;

/// Bounds of eight children by axis: all lower ends, all upper ends.
#[derive(Debug, Clone)]
struct Node {
    bounds: [[[f32; WIDTH]; 2]; 3],
    children: [u32; WIDTH],
}

/// Boxes over things that are known by their place in an order.
#[derive(Debug, Clone)]
pub struct Hierarchy {
    nodes: Vec<Node>,
    center: Vec3,
    reach: f64,
    bounds: Bounds,
}

/// What a walk does at a leaf.
pub trait Visit {
    /// Meets the things `first..first + count` of the order; gives how far the ray still looks.
    fn leaf<S: Simd>(&mut self, simd: S, first: usize, count: usize, limit: f64) -> f64;
}

impl Hierarchy {
    /// Over so many things of which the boxes are asked, more than once. `at_leaf` gives the place of a leaf, of which it is told the
    /// numbers of its things, and how many entries it takes.
    pub fn new(
        count: usize,
        bounds_of: impl Fn(usize) -> Bounds + Sync,
        mut at_leaf: impl FnMut(&[u32]) -> (usize, usize),
    ) -> Hierarchy {
        let bounds = match count {
            0 => Bounds { min: [0.0; 3], max: [0.0; 3] },
            _ => (0..count)
                .into_par_iter()
                .with_min_len(PARALLEL)
                .map(&bounds_of)
                .reduce(|| Bounds::EMPTY, |all, own| all.union(&own)),
        };
        let (low, high) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
        let half = (high - low) * 0.5;
        let mut hierarchy = Hierarchy {
            nodes: Vec::new(),
            center: low + half,
            reach: half.x.max(half.y).max(half.z).max(f64::MIN_POSITIVE),
            bounds,
        };
        let center = hierarchy.center.to_array();
        let relative = |ends: [f64; 3]| std::array::from_fn(|axis| (ends[axis] - center[axis]) as f32);
        let item = |number: usize| {
            let own = bounds_of(number);
            Item::new(relative(own.min), relative(own.max), number as u32)
        };
        let mut items: Vec<Item> = (0..count).into_par_iter().with_min_len(PARALLEL).map(item).collect();
        let tree = Tree::new(&mut items);
        let order: Vec<u32> = items.iter().map(|item| item.number()).collect();
        drop(items);
        if let Some(tree) = tree {
            hierarchy.add(&[&tree], &order, &mut at_leaf);
        }
        hierarchy
    }

    /// The box around all.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn add(&mut self, of: &[&Tree], order: &[u32], at_leaf: &mut impl FnMut(&[u32]) -> (usize, usize)) -> u32 {
        let mut children: Vec<&Tree> = of.to_vec();
        while children.len() < WIDTH {
            let largest = children
                .iter()
                .enumerate()
                .filter(|(_, child)| matches!(child, Tree::Inner { .. }))
                .max_by(|a, b| a.1.bounds().half_area().total_cmp(&b.1.bounds().half_area()).then(b.0.cmp(&a.0)))
                .map(|(at, _)| at);
            let Some(at) = largest else { break };
            if let Tree::Inner { children: pair, .. } = children[at] {
                children[at] = &pair[0];
                children.insert(at + 1, &pair[1]);
            }
        }
        let number = self.nodes.len();
        self.nodes.push(Node {
            bounds: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
            children: [IS_LEAF; WIDTH],
        });
        for (at, child) in children.into_iter().enumerate() {
            let (bounds, pad) = (child.bounds(), PAD * self.reach);
            for (axis, into) in self.nodes[number].bounds.iter_mut().enumerate() {
                into[0][at] = (f64::from(bounds.min[axis]) - pad) as f32;
                into[1][at] = (f64::from(bounds.max[axis]) + pad) as f32;
            }
            self.nodes[number].children[at] = match child {
                Tree::Leaf { first, count, .. } => {
                    debug_assert!(*count <= LEAF);
                    let (first, count) = at_leaf(&order[*first..first + count]);
                    IS_LEAF | (count as u32 - 1) << COUNT_AT | first as u32
                }
                Tree::Inner { children, .. } => {
                    let pair = [&children[0], &children[1]];
                    self.add(&pair, order, at_leaf)
                }
            };
        }
        number as u32
    }

    /// Walks a ray through the boxes, the near ones first, as far as `limit`.
    #[inline(always)]
    pub fn walk<S: Simd>(&self, simd: S, ray: &Ray, limit: f64, visit: &mut impl Visit) {
        if self.nodes.is_empty() {
            return;
        }
        // From where the ray comes near: a camera far away would cost the boxes their precision.
        let start = self.entry(ray);
        if start > limit || start == f64::INFINITY {
            return;
        }
        let origin = ray.origin + ray.direction * start - self.center;
        let direction = ray.direction.to_array();
        // No zero: zero times infinity would be no number.
        let per = direction.map(|d| if d.abs() < 1e-30 { 1e30_f32.copysign(d as f32) } else { (1.0 / d) as f32 });
        let signs = direction.map(|d| usize::from(d.is_sign_negative()));
        let origin = origin.to_array().map(|c| f32x8::splat(simd, c as f32));
        let rate = per.map(|r| f32x8::splat(simd, r));
        let longer = f32x8::splat(simd, 1.0 + f32::EPSILON * 8.0);
        let zero = f32x8::splat(simd, 0.0);
        let as_limit = |limit: f64| ((limit - start) * 1.000_001) as f32 + f32::MIN_POSITIVE;
        let (mut limit, mut near_limit) = (limit, as_limit(limit));
        let mut stack = Stack::default();
        let mut current = 0_u32;
        loop {
            if current & IS_LEAF != 0 {
                let (first, count) = ((current & FIRST) as usize, (current >> COUNT_AT & 7) as usize + 1);
                let closer = visit.leaf(simd, first, count, limit);
                if closer < limit {
                    (limit, near_limit) = (closer, as_limit(closer));
                }
            } else {
                let node = &self.nodes[current as usize];
                let [x, y, z] = &node.bounds;
                let enter = slab(simd, &x[signs[0]], origin[0], rate[0])
                    .max(slab(simd, &y[signs[1]], origin[1], rate[1]))
                    .max(slab(simd, &z[signs[2]], origin[2], rate[2]).max(zero));
                let leave = slab(simd, &x[1 - signs[0]], origin[0], rate[0])
                    .min(slab(simd, &y[1 - signs[1]], origin[1], rate[1]))
                    .min(slab(simd, &z[1 - signs[2]], origin[2], rate[2]))
                    * longer;
                let within = leave.min(f32x8::splat(simd, near_limit));
                let mut met = simd.to_bitmask_mask32x8(enter.simd_le(within)) as u32;
                if met != 0 {
                    let distances: [f32; WIDTH] = enter.into();
                    let first = stack.len;
                    let nearest = met.trailing_zeros() as usize;
                    let (mut next, mut distance) = (node.children[nearest], distances[nearest]);
                    met &= met - 1;
                    // The nearest one does not go through memory.
                    while met != 0 {
                        let at = met.trailing_zeros() as usize;
                        met &= met - 1;
                        let other = (node.children[at], distances[at]);
                        let farther = if other.1 < distance { (next, distance) } else { other };
                        (next, distance) = if other.1 < distance { other } else { (next, distance) };
                        stack.push_sorted(first, farther.0, farther.1);
                    }
                    current = next;
                    continue;
                }
            }
            // The nearest that is still within reach.
            loop {
                let Some((next, distance)) = stack.pop() else { return };
                if distance <= near_limit {
                    current = next;
                    break;
                }
            }
        }
    }

    /// How far along a ray the box around all begins; infinite where it is missed by far.
    #[inline(always)]
    fn entry(&self, ray: &Ray) -> f64 {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let pad = PAD * self.reach;
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let (low, high) = (self.bounds.min[axis] - pad, self.bounds.max[axis] + pad);
            if direction[axis] == 0.0 {
                if origin[axis] < low || origin[axis] > high {
                    return f64::INFINITY;
                }
                continue;
            }
            let per = 1.0 / direction[axis];
            let (a, b) = ((low - origin[axis]) * per, (high - origin[axis]) * per);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        if enter <= leave * (1.0 + 1e-12) { enter } else { f64::INFINITY }
    }
}

/// Distances to eight planes.
#[inline(always)]
fn slab<S: Simd>(simd: S, planes: &[f32; WIDTH], origin: f32x8<S>, rate: f32x8<S>) -> f32x8<S> {
    (f32x8::from_slice(simd, planes) - origin) * rate
}

/// Nodes that wait, the nearest on top.
struct Stack {
    shallow: [(u32, f32); SHALLOW],
    deep: Vec<(u32, f32)>,
    len: usize,
}

impl Default for Stack {
    #[inline(always)]
    fn default() -> Stack {
        Stack { shallow: [(0, 0.0); SHALLOW], deep: Vec::new(), len: 0 }
    }
}

impl Stack {
    #[inline(always)]
    fn get(&self, at: usize) -> (u32, f32) {
        if at < SHALLOW { self.shallow[at] } else { self.deep[at - SHALLOW] }
    }

    #[inline(always)]
    fn set(&mut self, at: usize, entry: (u32, f32)) {
        match self.shallow.get_mut(at) {
            Some(place) => *place = entry,
            None => self.deep[at - SHALLOW] = entry,
        }
    }

    /// Puts a node among those from `first` on, which are sorted, the farthest lowest.
    #[inline(always)]
    fn push_sorted(&mut self, first: usize, node: u32, distance: f32) {
        if self.len >= SHALLOW {
            self.deep.resize(self.len + 1 - SHALLOW, (0, 0.0));
        }
        let mut at = self.len;
        self.len += 1;
        while at > first && self.get(at - 1).1 < distance {
            self.set(at, self.get(at - 1));
            at -= 1;
        }
        self.set(at, (node, distance));
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(u32, f32)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.get(self.len))
    }
}
