//! All that rays can meet, and which of it a ray meets first.

use iridesce_numerics::Vec3;
use iridesce_scene::{ResolvedScene, Surface};

use super::area::AreaSampler;
use super::bounds::Bounds;
use super::charts::Charts;
use super::parts::{Kind, Tree, placed};
use super::{Hit, Interaction, Shape};
use crate::camera::Ray;

/// So many shapes are asked one after the other; more of them stand in a hierarchy. (Eleven in a room: 5 % faster than by their boxes.)
const FEW: usize = 16;

/// All that rays can meet.
pub struct Geometry {
    /// Of object i at index i, where there are few and all are simple.
    shapes: Vec<Shape>,
    /// Where there are many, or others.
    tree: Option<Tree>,
    charts: Charts,
    /// Of emitters whose shape has no direction of its own to draw.
    areas: Vec<Option<AreaSampler>>,
    /// Objects that a medium fills: their meshes were seen to be closed.
    fills: Vec<bool>,
}

impl Geometry {
    /// The geometry of a scene.
    pub fn new(scene: &ResolvedScene) -> Geometry {
        let objects = &scene.recipe.objects;
        let charts = Charts::new(scene);
        let fills: Vec<bool> = objects
            .iter()
            .map(|object| matches!(object.surface, Surface::Dielectric(_) | Surface::Coating(_)))
            .collect();
        let simple: Option<Vec<Shape>> = (objects.len() <= FEW)
            .then(|| {
                objects
                    .iter()
                    .enumerate()
                    .map(|(number, object)| match scene.placements(number) {
                        [only] => placed(&object.shape, only),
                        _ => None,
                    })
                    .collect()
            })
            .flatten();
        if let Some(shapes) = simple {
            let areas = shapes.iter().map(|_| None).collect();
            return Geometry { shapes, tree: None, charts, areas, fills };
        }
        let tree = Tree::of_scene(scene);
        let areas = objects
            .iter()
            .enumerate()
            .map(|(number, object)| match object.surface {
                Surface::Emitter(_) => AreaSampler::new(&tree, number as u32),
                _ => None,
            })
            .collect();
        Geometry { shapes: Vec::new(), tree: Some(tree), charts, areas, fills }
    }

    /// Of shapes, with a hierarchy where there are more than `few`.
    #[cfg(test)]
    pub fn of_shapes(shapes: Vec<Shape>, few: usize) -> Geometry {
        let areas = shapes.iter().map(|_| None).collect();
        let (charts, fills) = (Charts::default(), vec![true; shapes.len()]);
        if shapes.len() <= few {
            return Geometry { shapes, tree: None, charts, areas, fills };
        }
        use super::parts::{Part, STAYS};
        let part = |number| Part { object: number, kind: number, instance: 0, placement: STAYS };
        let parts = (0..shapes.len() as u32).map(part).collect();
        let tree = Tree::new(parts, shapes.into_iter().map(Kind::Shape).collect(), Vec::new());
        Geometry { shapes: Vec::new(), tree: Some(tree), charts, areas, fills }
    }

    /// The nearest hit of a ray; `leaving` is where it starts, if that is on a surface.
    #[inline(always)]
    pub fn nearest(&self, ray: &Ray, leaving: Option<&Hit>) -> Option<Hit> {
        if let Some(tree) = &self.tree {
            return tree.nearest(ray, leaving, None);
        }
        self.nearest_of_few(ray, leaving.map(|hit| hit.part), |_| true)
    }

    /// What rays walk through, which are quicker together, if there is any such.
    #[inline(always)]
    pub fn tree(&self) -> Option<&Tree> {
        self.tree.as_ref()
    }

    /// [`Geometry::nearest`] among some of the objects only.
    pub fn nearest_of(&self, ray: &Ray, leaving: Option<&Hit>, counts: &dyn Fn(usize) -> bool) -> Option<Hit> {
        match &self.tree {
            Some(tree) => tree.nearest(ray, leaving, Some(counts)),
            None => self.nearest_of_few(ray, leaving.map(|hit| hit.part), counts),
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
        best.map(|(object, distance)| {
            let (point, normal) = self.shapes[object].at(ray, distance);
            Hit { object, part: object as u32, primitive: 0, distance, point, normal }
        })
    }

    /// All that is known of a place that a ray has met: what maps, bumps and rough surfaces ask.
    pub fn interaction(&self, hit: &Hit) -> Interaction {
        self.charts.interaction(self.tree.as_ref(), hit)
    }

    /// Whether a place is on a wall between bubbles.
    pub fn is_inner(&self, hit: &Hit) -> bool {
        self.tree.as_ref().is_some_and(|tree| {
            let kind = tree.parts[hit.part as usize].kind as usize;
            matches!(&tree.kinds[kind], Kind::Patch(patch) if patch.is_inner)
        })
    }

    /// The unit normal of the surface itself where a hit may bear the shading normal.
    pub fn normal_at(&self, hit: &Hit) -> Vec3 {
        let Some(tree) = &self.tree else {
            let ray = Ray { origin: hit.point, direction: hit.normal };
            return self.shapes[hit.object].at(&ray, 0.0).1;
        };
        let part = &tree.parts[hit.part as usize];
        let by = tree.to_object.get(part.placement as usize);
        let point = by.map_or(hit.point, |by| by.moved(hit.point));
        let ray = Ray { origin: point, direction: hit.normal };
        let normal = match &tree.kinds[part.kind as usize] {
            Kind::Shape(shape) => shape.at(&ray, 0.0).1,
            Kind::Cylinder(cylinder) => cylinder.at(point, hit.primitive).1,
            Kind::Patch(patch) => patch.at(&ray, 0.0).1,
            Kind::Mesh(mesh) => mesh.normal(hit.primitive),
        };
        by.map_or(normal, |by| Vec3::from(by.transposed(normal.to_array())).normalized())
    }

    /// Whether shading normals of an object differ from its own.
    #[inline(always)]
    pub fn is_shaded(&self, object: usize) -> bool {
        self.charts.is_shaded(object)
    }

    /// A direction from `origin` to a random place of an object, and its probability per solid angle. `None` for what is
    /// not drawn from: planes and caps, and spheres from within.
    #[inline(always)]
    pub fn draw(&self, object: usize, origin: Vec3, pair: (f64, f64)) -> Option<(Vec3, f64)> {
        let Some(tree) = &self.tree else { return self.shapes[object].draw(origin, pair) };
        if let Some(area) = &self.areas[object] {
            let direction = (area.point(tree, pair) - origin).normalized();
            let density = self.density_by_area((tree, area), object, origin, direction);
            return (density > 0.0).then_some((direction, density));
        }
        tree.only_shape(object)?.draw(origin, pair)
    }

    /// The probability per solid angle with which [`Geometry::draw`] finds a place of the object, 0 where it never does.
    #[inline(always)]
    pub fn density(&self, object: usize, origin: Vec3, place: Vec3) -> f64 {
        let Some(tree) = &self.tree else { return self.shapes[object].density(origin, place) };
        match &self.areas[object] {
            Some(area) => self.density_by_area((tree, area), object, origin, (place - origin).normalized()),
            None => tree.only_shape(object).map_or(0.0, |shape| shape.density(origin, place)),
        }
    }

    /// Every place of the object along a direction leads to it: their densities add.
    fn density_by_area(
        &self,
        (tree, area): (&Tree, &AreaSampler),
        object: usize,
        origin: Vec3,
        direction: Vec3,
    ) -> f64 {
        let (mut ray, mut from, mut so_far, mut sum) = (Ray { origin, direction }, None, 0.0, 0.0);
        // No more crossings than any closed surface of a lamp has; of others a few are left out, in both techniques alike.
        for _ in 0..64 {
            let Some(hit) = self.nearest_of(&ray, from.as_ref(), &|other| other == object) else { break };
            so_far += hit.distance;
            let cos = direction.dot(hit.normal).abs();
            if cos > 1e-9 {
                sum += so_far * so_far / cos * area.density(tree, &hit);
            }
            (ray.origin, from) = (hit.point, Some(hit));
        }
        sum
    }

    /// The shape of an object that is one simple shape in the world.
    pub fn simple_shape(&self, object: usize) -> Option<&Shape> {
        match &self.tree {
            None => self.shapes.get(object),
            Some(tree) => tree.only_shape(object),
        }
    }

    /// Of an emitter whose places are drawn by area: its middle, the square of its radius, its area.
    pub fn spread(&self, object: usize) -> Option<(Vec3, f64, f64)> {
        let (area, tree) = (self.areas[object].as_ref()?, self.tree.as_ref()?);
        let places: Vec<Vec3> = (0..64)
            .map(|i| area.point(tree, ((f64::from(i) + 0.5) / 64.0, (f64::from(i) * 0.618_034).fract())))
            .collect();
        let middle = places.iter().fold(Vec3::default(), |sum, place| sum + *place) * (1.0 / places.len() as f64);
        let radius2 = places.iter().map(|place| (*place - middle).length_squared()).fold(0.0, f64::max);
        Some((middle, radius2, area.total()))
    }

    /// A ball around an object; `None` of what has no end.
    pub fn ball(&self, object: usize) -> Option<(Vec3, f64)> {
        if let Some(&Shape::Sphere { center, radius, .. }) = self.simple_shape(object) {
            return Some((center, radius));
        }
        let bounds = match &self.tree {
            None => self.shapes[object].bounds()?,
            Some(tree) => {
                let parts = tree.parts_of(object as u32);
                if parts.is_empty() {
                    return None;
                }
                parts.map(|part| tree.bounds(part)).try_fold(Bounds::EMPTY, |all, own| Some(all.union(&own?)))?
            }
        };
        let [min, max] = [bounds.min, bounds.max].map(Vec3::from);
        Some(((min + max) * 0.5, (max - min).length_squared().sqrt() * 0.5))
    }

    /// The normals of the planes among the objects that count.
    pub fn plane_normals(&self, counts: impl Fn(usize) -> bool) -> Vec<Vec3> {
        let normal = |(object, shape): (usize, &Shape)| match shape {
            Shape::Plane { normal, .. } if counts(object) => Some(*normal),
            _ => None,
        };
        match &self.tree {
            None => self.shapes.iter().enumerate().filter_map(normal).collect(),
            Some(tree) => tree.unbounded.iter().filter_map(|&part| tree.simple(part)).filter_map(normal).collect(),
        }
    }

    /// Whether an object has an inside by itself. (A mesh that a medium fills was seen to be closed.)
    pub fn is_closed(&self, object: usize) -> bool {
        let is_closed = |kind: &Kind| match kind {
            Kind::Shape(shape) => matches!(shape, Shape::Sphere { .. } | Shape::Plane { .. }),
            Kind::Cylinder(cylinder) => !cylinder.is_open,
            Kind::Mesh(_) => self.fills[object],
            Kind::Patch(_) => false,
        };
        match &self.tree {
            None => matches!(self.shapes[object], Shape::Sphere { .. } | Shape::Plane { .. }),
            Some(tree) => tree.first_part(object).is_some_and(|part| is_closed(&tree.kinds[part.kind as usize])),
        }
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
        let (flat, tree) = (Geometry::of_shapes(shapes.clone(), usize::MAX), Geometry::of_shapes(shapes, 8));
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
