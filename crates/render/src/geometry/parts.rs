//! What objects are made of, and which of it a ray meets first.

use fearless_simd::{Level, Simd, dispatch};
use iridesce_numerics::{Vec3, simd};

use super::hierarchy::{Hierarchy, Visit};
use super::{Hit, Shape};
use crate::camera::Ray;

/// So many shapes are asked one after the other; more of them stand in a hierarchy. Measured: `docs/evidence/performance.md`.
const FEW: usize = 8;

/// All that rays can meet.
pub struct Geometry {
    /// Of object i at index i.
    shapes: Vec<Shape>,
    /// Where there are many.
    tree: Option<Tree>,
}

/// Parts in a hierarchy.
struct Tree {
    level: Level,
    hierarchy: Hierarchy,
    /// Parts in the order of the hierarchy's leaves.
    order: Vec<u32>,
    /// Parts without an end.
    unbounded: Vec<u32>,
}

impl Geometry {
    pub fn new(shapes: Vec<Shape>) -> Geometry {
        Geometry::of_shapes(shapes, FEW)
    }

    /// With a hierarchy where there are more than `few` shapes.
    pub fn of_shapes(shapes: Vec<Shape>, few: usize) -> Geometry {
        let tree = (shapes.len() > few).then(|| Tree::new(&shapes));
        Geometry { shapes, tree }
    }

    /// The nearest hit of a ray; `leaving` is where it starts, if that is on a surface.
    #[inline(always)]
    pub fn nearest(&self, ray: &Ray, leaving: Option<&Hit>) -> Option<Hit> {
        let part = leaving.map(|hit| hit.part);
        if let Some(tree) = &self.tree {
            return tree.nearest(&self.shapes, ray, part, None);
        }
        self.nearest_of_few(ray, part, |_| true)
    }

    /// [`Geometry::nearest`] among some of the objects only.
    pub fn nearest_of(&self, ray: &Ray, leaving: Option<&Hit>, counts: &dyn Fn(usize) -> bool) -> Option<Hit> {
        let part = leaving.map(|hit| hit.part);
        match &self.tree {
            Some(tree) => tree.nearest(&self.shapes, ray, part, Some(counts)),
            None => self.nearest_of_few(ray, part, counts),
        }
    }

    #[inline(always)]
    fn nearest_of_few(&self, ray: &Ray, leaving: Option<u32>, counts: impl Fn(usize) -> bool) -> Option<Hit> {
        let mut best: Option<(usize, f64)> = None;
        for (object, shape) in self.shapes.iter().enumerate() {
            if counts(object)
                && let Some(distance) = shape.distance(ray, leaving == Some(object as u32))
                && best.is_none_or(|(_, d)| distance < d)
            {
                best = Some((object, distance));
            }
        }
        best.map(|(object, distance)| hit_of(&self.shapes, object, ray, distance))
    }

    /// A direction from `origin` to a random place of an object, and its probability per solid angle. `None` for what is
    /// not drawn from: planes and caps, and spheres from within.
    #[inline(always)]
    pub fn draw(&self, object: usize, origin: Vec3, pair: (f64, f64)) -> Option<(Vec3, f64)> {
        self.shapes[object].draw(origin, pair)
    }

    /// The probability per solid angle with which [`Geometry::draw`] finds a place of the object, 0 where it never does.
    #[inline(always)]
    pub fn density(&self, object: usize, origin: Vec3, place: Vec3) -> f64 {
        self.shapes[object].density(origin, place)
    }

    /// The normals of the planes among the objects that count.
    pub fn plane_normals(&self, counts: impl Fn(usize) -> bool) -> Vec<Vec3> {
        let normal = |(object, shape): (usize, &Shape)| match shape {
            Shape::Plane { normal, .. } if counts(object) => Some(*normal),
            _ => None,
        };
        self.shapes.iter().enumerate().filter_map(normal).collect()
    }

    /// Whether an object has an inside by itself.
    pub fn is_closed(&self, object: usize) -> bool {
        matches!(self.shapes[object], Shape::Sphere { .. } | Shape::Plane { .. })
    }
}

#[inline(always)]
fn hit_of(shapes: &[Shape], object: usize, ray: &Ray, distance: f64) -> Hit {
    let (point, normal) = shapes[object].at(ray, distance);
    Hit { object, part: object as u32, distance, point, normal }
}

impl Tree {
    fn new(shapes: &[Shape]) -> Tree {
        let (mut boxes, mut bounded, mut unbounded) = (Vec::new(), Vec::new(), Vec::new());
        for (part, shape) in shapes.iter().enumerate() {
            match shape.bounds() {
                Some(bounds) => {
                    boxes.push(bounds);
                    bounded.push(part as u32);
                }
                None => unbounded.push(part as u32),
            }
        }
        let mut order = Vec::with_capacity(bounded.len());
        let hierarchy = Hierarchy::new(boxes.into_iter(), |numbers| {
            let first = order.len();
            order.extend(numbers.iter().map(|&number| bounded[number as usize]));
            (first, numbers.len())
        });
        Tree { level: simd::level_or_best(), hierarchy, order, unbounded }
    }

    #[inline(never)]
    fn nearest(
        &self,
        shapes: &[Shape],
        ray: &Ray,
        leaving: Option<u32>,
        counts: Option<&dyn Fn(usize) -> bool>,
    ) -> Option<Hit> {
        let mut search = Search { tree: self, shapes, ray, leaving, counts, best: None };
        let limit = self.unbounded.iter().fold(f64::INFINITY, |limit, &part| search.meet(part, limit));
        dispatch!(self.level, simd => self.hierarchy.walk(simd, ray, limit, &mut search));
        search.best.map(|(part, distance)| hit_of(shapes, part as usize, ray, distance))
    }
}

/// The nearest so far.
struct Search<'a> {
    tree: &'a Tree,
    shapes: &'a [Shape],
    ray: &'a Ray,
    leaving: Option<u32>,
    counts: Option<&'a dyn Fn(usize) -> bool>,
    best: Option<(u32, f64)>,
}

impl Search<'_> {
    /// Meets one part; of two at the same distance the first of the scene is nearer, whatever the order here.
    #[inline(always)]
    fn meet(&mut self, part: u32, limit: f64) -> f64 {
        if self.counts.is_some_and(|counts| !counts(part as usize)) {
            return limit;
        }
        match self.shapes[part as usize].distance(self.ray, self.leaving == Some(part)) {
            Some(distance)
                if distance < limit
                    || distance == limit && self.best.is_some_and(|(best, d)| d == distance && part < best) =>
            {
                self.best = Some((part, distance));
                distance
            }
            _ => limit,
        }
    }
}

impl Visit for Search<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, _: S, first: usize, count: usize, mut limit: f64) -> f64 {
        for at in first..first + count {
            limit = self.meet(self.tree.order[at], limit);
        }
        limit
    }
}

#[cfg(test)]
mod tests {
    use iridesce_numerics::noise::SplitMix64;

    use super::*;

    /// The hierarchy answers as the list does, to the last digit, from outside, from within and from surfaces.
    #[test]
    fn a_hierarchy_and_a_list_are_one() {
        let mut noise = SplitMix64::new(7);
        let mut draw = move || 2.0 * noise.unit() - 1.0;
        let mut point = |reach: f64| Vec3::new(reach * draw(), reach * draw(), reach * draw());
        let mut shapes: Vec<Shape> = Vec::new();
        for i in 0..400 {
            let center = point(10.0).to_array();
            let other = point(1.0).normalized().to_array();
            shapes.push(Shape::new(&match i % 4 {
                0 => iridesce_scene::Shape::Sphere { center, radius: 0.3 + other[0].abs() },
                1 => iridesce_scene::Shape::Disk { center, normal: other, radius: 0.8 },
                2 => {
                    iridesce_scene::Shape::Cap { center, axis: other, radius_of_curvature: -2.0, aperture_radius: 1.5 }
                }
                _ => iridesce_scene::Shape::Rectangle { center, u: other, v: [other[1], -other[0], 0.1] },
            }));
        }
        let ground = iridesce_scene::Shape::Plane { point: [0.0, -9.0, 0.0], normal: [0.0, 1.0, 0.0] };
        shapes.insert(200, Shape::new(&ground));
        let (flat, tree) = (Geometry::of_shapes(shapes.clone(), usize::MAX), Geometry::new(shapes));
        let (mut hits, mut far) = (0, 0);
        for i in 0..4000 {
            // Some from very far away, some along an axis.
            let reach = if i % 5 == 0 { 1e7 } else { 12.0 };
            let (origin, target) = (point(reach), point(9.0));
            let direction = if i % 7 == 0 { Vec3::new(0.0, 0.0, -1.0) } else { (target - origin).normalized() };
            let (mut ray, mut from) = (Ray { origin, direction }, None);
            for _ in 0..20 {
                let (a, b) = (flat.nearest(&ray, from.as_ref()), tree.nearest(&ray, from.as_ref()));
                let key = |hit: &Hit| (hit.object, hit.distance.to_bits(), hit.point.to_array().map(f64::to_bits));
                assert_eq!(a.as_ref().map(key), b.as_ref().map(key));
                let Some(hit) = a else { break };
                hits += 1;
                far += usize::from(reach > 1e6);
                (ray.origin, from) = (hit.point, Some(hit));
            }
        }
        assert!(hits > 5000 && far > 1000, "{hits} {far}");
    }
}
