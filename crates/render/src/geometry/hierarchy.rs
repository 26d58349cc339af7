//! A hierarchy of boxes with eight children a node, and the walk of a ray through it.
//!
//! Boxes are f32, relative to the middle of the whole; each is padded by more than single precision loses of the ray, so
//! that a box is never missed whose content double precision would meet. What lies in the leaves is the caller's.

use fearless_simd::{Simd, f32x8, prelude::*};
use iridesce_numerics::Vec3;
use rayon::prelude::*;

use super::beam::Beam;
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
const SHALLOW: usize = 32;

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

    /// Where all boxes are counted from.
    #[inline(always)]
    pub fn middle(&self) -> [f64; 3] {
        self.center.to_array()
    }

    /// A beam around rays, to be held against the boxes.
    pub fn beam(&self, rays: &[Ray]) -> Option<Beam> {
        Beam::new(rays, self.middle(), self.reach, &self.bounds)
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
        let mut walk = Walk::default();
        if !walk.begin(self, ray, limit) {
            return;
        }
        loop {
            if let Some((first, count)) = walk.look(simd, self) {
                let closer = visit.leaf(simd, first, count, walk.limit);
                walk.shorten(closer);
            }
            if !walk.choose(self) {
                return;
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

/// A ray on its way through a hierarchy, from one node or leaf to the next: [`Walk::look`], then [`Walk::choose`], until that says
/// that there is none. Between the two of one ray there may be those of others.
pub struct Walk {
    /// Where the ray comes near, from the middle of the whole.
    origin: [f32; 3],
    rate: [f32; 3],
    /// Which end of a box along each axis is the far one.
    signs: [usize; 3],
    /// How far along the ray that is.
    start: f64,
    limit: f64,
    near_limit: f32,
    /// The node or leaf that is next.
    current: u32,
    /// Which children of the node under work are met, as bits, and how far away each begins.
    met: u32,
    distances: [f32; WIDTH],
    stack: Stack,
}

impl Default for Walk {
    #[inline(always)]
    fn default() -> Walk {
        Walk {
            origin: [0.0; 3],
            rate: [0.0; 3],
            signs: [0; 3],
            start: 0.0,
            limit: 0.0,
            near_limit: 0.0,
            current: 0,
            met: 0,
            distances: [0.0; WIDTH],
            stack: Stack::default(),
        }
    }
}

impl Walk {
    /// Sends a ray on its way, as far as `limit`; false where it meets nothing there.
    #[inline(always)]
    pub fn begin(&mut self, hierarchy: &Hierarchy, ray: &Ray, limit: f64) -> bool {
        if hierarchy.nodes.is_empty() {
            return false;
        }
        // From where the ray comes near: a camera far away would cost the boxes their precision.
        let start = hierarchy.entry(ray);
        if start > limit || start == f64::INFINITY {
            return false;
        }
        let Vec3 { x, y, z } = ray.origin + ray.direction * start - hierarchy.center;
        self.origin = [x as f32, y as f32, z as f32];
        let Vec3 { x, y, z } = ray.direction;
        self.rate = [rate(x), rate(y), rate(z)];
        let sign = |along: f64| usize::from(along.is_sign_negative());
        self.signs = [sign(x), sign(y), sign(z)];
        self.start = start;
        (self.limit, self.near_limit) = (limit, self.in_single(limit));
        self.current = 0;
        self.stack.len = 0;
        true
    }

    /// How far the ray still looks.
    #[inline(always)]
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Something was met nearer than [`Walk::limit`].
    #[inline(always)]
    pub fn shorten(&mut self, limit: f64) {
        if limit < self.limit {
            (self.limit, self.near_limit) = (limit, self.in_single(limit));
        }
    }

    #[inline(always)]
    fn in_single(&self, limit: f64) -> f32 {
        ((limit - self.start) * 1.000_001) as f32 + f32::MIN_POSITIVE
    }

    /// Reads something of each part of what is next, so that it is near when it is asked; of a leaf the caller knows what that is.
    /// What comes out has no meaning, but has been read.
    #[inline(always)]
    pub fn touch(&self, hierarchy: &Hierarchy, leaf: impl FnOnce(usize) -> u64) -> u64 {
        if self.current & IS_LEAF != 0 {
            return leaf((self.current & FIRST) as usize);
        }
        let Node { bounds, children } = &hierarchy.nodes[self.current as usize];
        let [x, y, z] = [bounds[0][0][0], bounds[1][0][0], bounds[2][0][0]];
        u64::from(x.to_bits() ^ y.to_bits() ^ z.to_bits() ^ children[WIDTH - 1])
    }

    /// The things of what is next, if that is a leaf: `first` and how many.
    #[inline(always)]
    fn at_leaf(&mut self) -> Option<(usize, usize)> {
        let current = self.current;
        if current & IS_LEAF == 0 {
            return None;
        }
        self.met = 0;
        Some(((current & FIRST) as usize, (current >> COUNT_AT & 7) as usize + 1))
    }

    /// Looks which children of the next node are met; of a leaf gives the things in it, `first` and how many, for the caller to meet
    /// and to [`Walk::shorten`] the way by.
    #[inline(always)]
    pub fn look<S: Simd>(&mut self, simd: S, hierarchy: &Hierarchy) -> Option<(usize, usize)> {
        if let Some(leaf) = self.at_leaf() {
            return Some(leaf);
        }
        let current = self.current;
        let splat = |value: f32| f32x8::splat(simd, value);
        // Not by `map` over the axes, which is a call of its own here.
        let [o_x, o_y, o_z] = [splat(self.origin[0]), splat(self.origin[1]), splat(self.origin[2])];
        let [r_x, r_y, r_z] = [splat(self.rate[0]), splat(self.rate[1]), splat(self.rate[2])];
        let [x, y, z] = &hierarchy.nodes[current as usize].bounds;
        let [n_x, n_y, n_z] = [self.signs[0] & 1, self.signs[1] & 1, self.signs[2] & 1];
        let enter = slab(simd, &x[n_x], o_x, r_x)
            .max(slab(simd, &y[n_y], o_y, r_y))
            .max(slab(simd, &z[n_z], o_z, r_z).max(splat(0.0)));
        let leave = slab(simd, &x[1 - n_x], o_x, r_x).min(slab(simd, &y[1 - n_y], o_y, r_y)).min(slab(
            simd,
            &z[1 - n_z],
            o_z,
            r_z,
        )) * splat(1.0 + f32::EPSILON * 8.0);
        let within = leave.min(splat(self.near_limit));
        self.met = simd.to_bitmask_mask32x8(enter.simd_le(within)) as u32;
        self.distances = enter.into();
        None
    }

    /// Sends a beam on its way, as far along it as `limit`; false where that is nowhere.
    #[inline(always)]
    pub fn begin_beam(&mut self, hierarchy: &Hierarchy, limit: f32) -> bool {
        (self.current, self.stack.len, self.near_limit) = (0, 0, limit);
        !hierarchy.nodes.is_empty() && limit >= 0.0
    }

    /// A beam is to go no farther than this.
    #[inline(always)]
    pub fn shorten_beam(&mut self, limit: f32) {
        self.near_limit = limit;
    }

    /// [`Walk::look`] of a beam.
    #[inline(always)]
    pub fn look_along<S: Simd>(&mut self, simd: S, hierarchy: &Hierarchy, beam: &Beam) -> Option<(usize, usize)> {
        if let Some(leaf) = self.at_leaf() {
            return Some(leaf);
        }
        let Node { bounds, .. } = &hierarchy.nodes[self.current as usize];
        (self.met, self.distances) = beam.meets(simd, bounds, self.near_limit);
        None
    }

    /// Goes on to the nearest of what was seen to be met and what waits; false at the end.
    #[inline(always)]
    pub fn choose(&mut self, hierarchy: &Hierarchy) -> bool {
        let mut met = self.met;
        if met != 0 {
            let (children, distances) = (&hierarchy.nodes[self.current as usize].children, &self.distances);
            let first = self.stack.len;
            let nearest = met.trailing_zeros() as usize % WIDTH;
            let (mut next, mut distance) = (children[nearest], distances[nearest]);
            met &= met - 1;
            // The nearest one does not go through memory.
            while met != 0 {
                let at = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                let other = (children[at], distances[at]);
                let farther = if other.1 < distance { (next, distance) } else { other };
                (next, distance) = if other.1 < distance { other } else { (next, distance) };
                self.stack.push_sorted(first, farther.0, farther.1);
            }
            self.current = next;
            return true;
        }
        // The nearest that is still within reach.
        while let Some((next, distance)) = self.stack.pop() {
            if distance <= self.near_limit {
                self.current = next;
                return true;
            }
        }
        false
    }
}

/// How much farther a ray is along itself for each step along an axis. No zero: zero times infinity would be no number.
#[inline(always)]
fn rate(along: f64) -> f32 {
    if along.abs() < 1e-30 { 1e30_f32.copysign(along as f32) } else { (1.0 / along) as f32 }
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
