//! Rays on their way side by side.
//!
//! A ray waits for memory at nearly every node and leaf, one after the other. Here rays that do not depend on each other take turns, a
//! node or leaf each, and what all of them need next is asked for before any of it is looked at: they wait together.

use std::ops::Range;

use fearless_simd::{Simd, dispatch};

use iridesce_numerics::Vec3;

use super::Hit;
use super::bundle;
use super::hierarchy::Walk;
use super::mesh::{self, TriangleMesh};
use super::parts::{Best, Kind, Meeting, Search, Tree};
use crate::camera::{MOST_TOGETHER, Ray};

/// How many rays are on their way at a time: enough for the waits, few enough that their ways stay in the first cache.
const RING: usize = 16;

impl Tree {
    /// What each of some rays, [`MOST_TOGETHER`] at most, meets first; `leaving` is where all of them start, if that is on a surface.
    #[inline(never)]
    pub fn nearest_each(&self, rays: &[Ray], leaving: Option<&Hit>, found: &mut [Option<Best>]) {
        found.fill(None);
        dispatch!(self.level, simd => run(simd, self, rays, leaving, found));
    }

    /// The same for rays of which each meets nearly what the one before has met: that is near already. False where they are so far from
    /// each other, beside what they meet, that it would have been quicker to say so at once (`as_bundle`).
    #[inline(never)]
    pub fn nearest_each_alike(
        &self,
        rays: &[Ray],
        leaving: Option<&Hit>,
        as_bundle: bool,
        found: &mut [Option<Best>],
    ) -> bool {
        let is_bundle = as_bundle && rays.len() >= bundle::LEAST && leaving.is_none();
        let mut was_quick = true;
        dispatch!(self.level, simd => {
            if is_bundle {
                was_quick = self.nearest_of_bundle(simd, rays, found);
            }
            if !(is_bundle && was_quick) {
                for (ray, found) in rays.iter().zip(found) {
                    let mut search = Search::new(self, ray, leaving);
                    search.run(simd);
                    *found = search.best;
                }
            }
        });
        was_quick
    }

    /// What each ray of a bundle meets first, where one mesh is all that has an end; false where they are better asked one by one.
    #[inline(always)]
    fn nearest_of_bundle<S: Simd>(&self, simd: S, rays: &[Ray], found: &mut [Option<Best>]) -> bool {
        let Some((part, mesh)) = self.only_mesh() else { return false };
        let mut own = [Ray { origin: Vec3::default(), direction: Vec3::default() }; MOST_TOGETHER];
        let (mut limits, mut own_limits) = ([0.0; MOST_TOGETHER], [0.0; MOST_TOGETHER]);
        for (number, ray) in rays.iter().enumerate() {
            let mut search = Search::new(self, ray, None);
            limits[number] = search.meet_unbounded();
            found[number] = search.best;
            let Meeting::Walk(inside, limit) = search.meeting(part, limits[number]) else { return false };
            (own[number], own_limits[number]) = (inside.ray, limit);
        }
        let mut met = [None; MOST_TOGETHER];
        if !mesh.nearest_of_bundle(simd, &own[..rays.len()], &own_limits[..rays.len()], &mut met) {
            return false;
        }
        for (number, ray) in rays.iter().enumerate() {
            let mut search = Search::new(self, ray, None);
            search.best = found[number];
            let met = met[number].map(|met| (met.distance, met.triangle, met.seat));
            search.take(part, limits[number], met);
            found[number] = search.best;
        }
        true
    }

    /// The part that is one mesh, if nothing else has an end.
    #[inline(always)]
    fn only_mesh(&self) -> Option<(u32, &TriangleMesh)> {
        if !self.is_single() {
            return None;
        }
        match &self.kinds[self.parts[self.order[0] as usize].kind as usize] {
            Kind::Mesh(mesh) => Some((self.order[0], mesh)),
            _ => None,
        }
    }
}

/// One ray on its way.
struct Flight<'a> {
    /// Which ray.
    number: usize,
    search: Search<'a>,
    limit: f64,
    /// Through the parts, where there are several.
    outer: Walk,
    /// Those of the leaf under work that are not met yet, as places in the tree's order.
    parts: Range<usize>,
    /// The mesh under work, which part it is, and the way through it.
    inside: Option<(u32, mesh::Search<'a>)>,
    inner: Walk,
}

impl<'a> Flight<'a> {
    /// Sends the first of the rays that wait on its way that is not over at once; false where there is none.
    #[inline(always)]
    fn begin_any(
        &mut self,
        waiting: &mut impl Iterator<Item = (usize, &'a Ray)>,
        leaving: Option<&'a Hit>,
        found: &mut [Option<Best>],
    ) -> bool {
        let tree = self.search.tree;
        for (number, ray) in waiting.by_ref() {
            (self.number, self.search, self.inside) = (number, Search::new(tree, ray, leaving), None);
            self.limit = self.search.meet_unbounded();
            let is_under_way = if tree.is_single() {
                self.parts = 0..1;
                self.meet_parts()
            } else {
                self.parts = 0..0;
                self.outer.begin(&tree.hierarchy, ray, self.limit)
            };
            if is_under_way {
                return true;
            }
            found[number] = self.search.best;
        }
        false
    }

    /// Reads what is next.
    #[inline(always)]
    fn touch(&self) -> u64 {
        let tree = self.search.tree;
        match &self.inside {
            Some((_, mesh)) => mesh.touch(&self.inner),
            None => self.outer.touch(&tree.hierarchy, |first| u64::from(tree.order[first])),
        }
    }

    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S) {
        match &mut self.inside {
            Some((_, mesh)) => mesh.look(simd, &mut self.inner),
            None => {
                if let Some((first, count)) = self.outer.look(simd, &self.search.tree.hierarchy) {
                    self.parts = first..first + count;
                }
            }
        }
    }

    /// Goes on to the next node or leaf; false at the end.
    #[inline(always)]
    fn choose(&mut self) -> bool {
        if let Some((part, mesh)) = &self.inside {
            if mesh.choose(&mut self.inner) {
                return true;
            }
            let found = mesh.best.map(|met| (met.distance, met.triangle, met.seat));
            self.limit = self.search.take(*part, self.limit, found);
            self.inside = None;
            return self.meet_parts();
        }
        self.meet_parts()
    }

    /// Meets the parts of a leaf up to one that takes a walk, and goes on when there are no more.
    #[inline(always)]
    fn meet_parts(&mut self) -> bool {
        let tree = self.search.tree;
        for at in self.parts.by_ref() {
            let part = tree.order[at];
            match self.search.meeting(part, self.limit) {
                Meeting::Told(found) => {
                    let found = found.map(|(distance, primitive)| (distance, primitive, 0));
                    self.limit = self.search.take(part, self.limit, found);
                }
                Meeting::Walk(mesh, limit) => {
                    if mesh.begin(&mut self.inner, limit) {
                        self.inside = Some((part, mesh));
                        return true;
                    }
                }
            }
        }
        if tree.is_single() {
            return false;
        }
        self.outer.shorten(self.limit);
        self.outer.choose(&tree.hierarchy)
    }
}

#[inline(always)]
fn run<'a, S: Simd>(simd: S, tree: &'a Tree, rays: &'a [Ray], leaving: Option<&'a Hit>, found: &mut [Option<Best>]) {
    let Some(any) = rays.first() else { return };
    let mut flights: [Flight<'a>; RING] = std::array::from_fn(|_| Flight {
        number: 0,
        search: Search::new(tree, any, leaving),
        limit: 0.0,
        outer: Walk::default(),
        parts: 0..0,
        inside: None,
        inner: Walk::default(),
    });
    // The flights that are under way stand first.
    let mut slots: [usize; RING] = std::array::from_fn(|slot| slot);
    let mut waiting = rays.iter().enumerate();
    let mut active = 0;
    while active < RING && flights[active].begin_any(&mut waiting, leaving, found) {
        active += 1;
    }
    while active > 0 {
        let read = slots[..active].iter().fold(0, |read, &slot| read ^ flights[slot].touch());
        std::hint::black_box(read);
        for &slot in &slots[..active] {
            flights[slot].look(simd);
        }
        let mut at = 0;
        while at < active {
            let flight = &mut flights[slots[at]];
            if !flight.choose() {
                found[flight.number] = flight.search.best;
                if !flight.begin_any(&mut waiting, leaving, found) {
                    active -= 1;
                    slots.swap(at, active);
                    continue;
                }
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use iridesce_files::Mesh;
    use iridesce_numerics::Vec3;
    use iridesce_numerics::noise::SplitMix64;
    use iridesce_scene::{Affine, Shape as SceneShape};

    use super::super::Shape;
    use super::super::cylinder::Cylinder;
    use super::super::mesh::TriangleMesh;
    use super::super::parts::{Kind, Part, STAYS};
    use super::*;

    /// Triangles here and there in a cube of half edge 1, all of them near each other in threes.
    fn mesh(triangles: u32, size: f64, noise: &mut SplitMix64) -> Kind {
        let mut draw = || 2.0 * noise.unit() - 1.0;
        let mut positions = Vec::new();
        for _ in 0..triangles {
            let middle: [f64; 3] = std::array::from_fn(|_| draw());
            positions.extend((0..3).map(|_| middle.map(|along| along + size * draw())));
        }
        let triangles = (0..triangles).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        Kind::Mesh(TriangleMesh::new(Arc::new(Mesh { positions, triangles, ..Mesh::default() })))
    }

    /// Rays from around, from within and from far away, some along an axis, so many that a ring is filled more than once.
    fn rays(noise: &mut SplitMix64) -> Vec<Ray> {
        let mut point = |reach: f64| {
            let [x, y, z] = std::array::from_fn(|_| reach * (2.0 * noise.unit() - 1.0));
            Vec3::new(x, y, z)
        };
        let ray = |number: usize| {
            let origin = point([3.0, 0.5, 1e6][number % 3]);
            let target = point(2.0);
            let direction =
                if number.is_multiple_of(7) { Vec3::new(0.0, -1.0, 0.0) } else { (target - origin).normalized() };
            Ray { origin, direction }
        };
        (0..200).map(ray).collect()
    }

    /// What a hit is, to the last digit.
    fn key(hit: &Hit) -> (usize, u32, u32, [u64; 7]) {
        let [x, y, z] = hit.point.to_array().map(f64::to_bits);
        let [a, b, c] = hit.normal.to_array().map(f64::to_bits);
        (hit.object, hit.part, hit.primitive, [hit.distance.to_bits(), x, y, z, a, b, c])
    }

    /// Holds rays together against the same one by one, from outside and on from each of some hits; gives how many met something.
    fn held_against_single_rays(tree: &Tree, noise: &mut SplitMix64) -> usize {
        let mut met = 0;
        let mut from: Vec<Option<Hit>> = vec![None];
        while let Some(leaving) = from.pop() {
            let mut rays = rays(noise);
            if let Some(hit) = &leaving {
                rays.iter_mut().for_each(|ray| ray.origin = hit.point);
            }
            let single: Vec<Option<Hit>> = rays.iter().map(|ray| tree.nearest(ray, leaving.as_ref(), None)).collect();
            for (each, rays) in rays.chunks(MOST_TOGETHER).enumerate() {
                let single = &single[each * MOST_TOGETHER..][..rays.len()];
                for are_alike in [false, true] {
                    let mut found = [None; MOST_TOGETHER];
                    if are_alike {
                        tree.nearest_each_alike(rays, leaving.as_ref(), false, &mut found);
                    } else {
                        tree.nearest_each(rays, leaving.as_ref(), &mut found);
                    }
                    for ((found, ray), single) in found.iter().zip(rays).zip(single) {
                        let hit = found.as_ref().map(|best| tree.hit(ray, best));
                        assert_eq!(hit.as_ref().map(key), single.as_ref().map(key));
                    }
                }
            }
            met += single.iter().flatten().count();
            if leaving.is_none() {
                from.extend(single.into_iter().flatten().take(12).map(Some));
            }
        }
        met
    }

    #[test]
    fn rays_together_meet_what_they_meet_one_by_one() {
        let mut noise = SplitMix64::new(11);
        let part = |object: u32, kind: u32, placement: u32| Part { object, kind, instance: 0, placement };
        let turned = |scale: [f64; 3], degrees: f64, x: f64| {
            Affine::placed(scale, [degrees, 20.0, 0.0], [x, 0.1, -0.2]).inverse().unwrap()
        };
        let plane = Kind::Shape(Shape::new(&SceneShape::Plane { point: [0.0, -1.5, 0.0], normal: [0.0, 1.0, 0.0] }));
        let ball = Kind::Shape(Shape::new(&SceneShape::Sphere { center: [0.8, 0.3, 0.0], radius: 0.5 }));
        let cylinder = Kind::Cylinder(Cylinder {
            center: Vec3::new(-0.5, 0.0, 0.4),
            axis: Vec3::new(0.0, 1.0, 0.0),
            radius: 0.3,
            half_height: 0.7,
            is_open: false,
        });
        // One mesh alone, one of a single leaf, one that is put somewhere else, over a plane.
        let alone = |kind, by: Option<Affine>| {
            let placement = if by.is_some() { 0 } else { STAYS };
            Tree::new(vec![part(0, 0, placement)], vec![kind], by.into_iter().collect())
        };
        let many = mesh(900, 0.2, &mut noise);
        assert!(held_against_single_rays(&alone(many, None), &mut noise) > 1000);
        let few = mesh(3, 2.0, &mut noise);
        assert!(held_against_single_rays(&alone(few, None), &mut noise) > 10);
        let parts = vec![part(0, 0, STAYS), part(1, 1, 0)];
        let over = vec![plane, mesh(300, 0.3, &mut noise)];
        let over = Tree::new(parts, over, vec![turned([1.0, 2.0, 0.5], 30.0, 0.4)]);
        assert!(held_against_single_rays(&over, &mut noise) > 300);
        // Two meshes, each in several places that overlap, among shapes.
        let kinds = vec![mesh(200, 0.3, &mut noise), mesh(2000, 0.05, &mut noise), ball, cylinder];
        let placements =
            (0..6).map(|at| turned([0.5, 0.7, 0.4 + 0.1 * f64::from(at)], 50.0 * f64::from(at), 0.3)).collect();
        let mut parts: Vec<Part> = (0..6).map(|at| part(at % 2, at % 2, at)).collect();
        parts.sort_by_key(|part| part.object);
        parts.extend([part(2, 2, STAYS), part(3, 3, STAYS), part(4, 0, STAYS)]);
        let nested = Tree::new(parts, kinds, placements);
        assert!(held_against_single_rays(&nested, &mut noise) > 300);
        // None at all.
        let nothing = Tree::new(Vec::new(), Vec::new(), Vec::new());
        assert_eq!(held_against_single_rays(&nothing, &mut noise), 0);
    }

    /// Rays of a pixel of this width at distance 1, from a point, or side by side.
    fn bundle(origin: Vec3, towards: Vec3, width: f64, are_parallel: bool, noise: &mut SplitMix64) -> Vec<Ray> {
        let count = 1 + noise.bits() as usize % MOST_TOGETHER;
        let mut ray = |_| {
            let aside = Vec3::from([0; 3].map(|_| width * (2.0 * noise.unit() - 1.0)));
            if are_parallel {
                return Ray { origin: origin + aside, direction: towards };
            }
            Ray { origin, direction: (towards + aside).normalized() }
        };
        (0..count).map(&mut ray).collect()
    }

    /// Holds bundles against single rays; gives how many of them went as bundles and how many did not, and how many rays met something.
    fn bundles_held_against_single_rays(tree: &Tree, noise: &mut SplitMix64) -> [usize; 3] {
        let mut told = [0; 3];
        for number in 0..600 {
            let mut point = |reach: f64| Vec3::from([0; 3].map(|_| reach * (2.0 * noise.unit() - 1.0)));
            let origin = point([3.0, 0.5, 1e6, 30.0][number % 4]);
            let towards = match number % 5 {
                0 => Vec3::new(0.0, -1.0, 0.0),
                1 => Vec3::new(0.0, 0.6, 0.8),
                _ => (point(0.9) - origin).normalized(),
            };
            let origin = if number % 5 < 2 { point(0.9) - towards * 3.0 } else { origin };
            let width = [1e-9, 1e-4, 1e-3, 0.02, 0.3, 3.0][number / 20 % 6];
            let rays = bundle(origin, towards, width, number % 3 == 0, noise);
            let mut found = [None; MOST_TOGETHER];
            let went = tree.nearest_each_alike(&rays, None, true, &mut found);
            told[usize::from(!went)] += 1;
            for (found, ray) in found.iter().zip(&rays) {
                let hit = found.as_ref().map(|best| tree.hit(ray, best));
                assert_eq!(hit.as_ref().map(key), tree.nearest(ray, None, None).as_ref().map(key), "{number}");
                told[2] += usize::from(hit.is_some());
            }
        }
        told
    }

    #[test]
    fn bundles_meet_what_their_rays_meet_one_by_one() {
        let mut noise = SplitMix64::new(12);
        let part = |object: u32, placement: u32| Part { object, kind: object, instance: 0, placement };
        let turned = Affine::placed([1.0, 2.0, 0.5], [30.0, 20.0, 0.0], [0.4, 0.1, -0.2]).inverse().unwrap();
        let plane = Kind::Shape(Shape::new(&SceneShape::Plane { point: [0.0, -1.5, 0.0], normal: [0.0, 1.0, 0.0] }));
        let few = Tree::new(vec![part(0, STAYS)], vec![mesh(300, 0.4, &mut noise)], Vec::new());
        let many = Tree::new(vec![part(0, STAYS)], vec![mesh(20_000, 0.03, &mut noise)], Vec::new());
        let kinds = vec![plane, mesh(2000, 0.1, &mut noise)];
        let over = Tree::new(vec![part(0, STAYS), part(1, 0)], kinds, vec![turned]);
        for tree in [few, many, over] {
            let [bundles, others, hits] = bundles_held_against_single_rays(&tree, &mut noise);
            assert!(bundles > 200 && others > 30 && hits > 3000, "{bundles} {others} {hits}");
        }
    }
}
