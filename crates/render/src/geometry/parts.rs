//! What objects are made of, and which of it a ray meets first.

use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch};
use iridesce_numerics::{Vec3, simd};
use iridesce_scene::{Affine, ResolvedScene, Shape as SceneShape};

use super::bounds::Bounds;
use super::cylinder::Cylinder;
use super::hierarchy::{Hierarchy, Visit};
use super::mesh::{self, Start, TriangleMesh};
use super::patch::{Patch, patches};
use super::{Hit, Shape};
use crate::camera::Ray;

/// Something that a ray meets, in the space of its object.
pub enum Kind {
    Shape(Shape),
    Cylinder(Cylinder),
    Patch(Patch),
    Mesh(TriangleMesh),
}

/// One of the things of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    pub object: u32,
    pub kind: u32,
    /// Which instance of its object.
    pub instance: u32,
    /// Where it is put, among the placements; [`STAYS`] for what stays where it is.
    pub placement: u32,
}

/// Of parts that are in the world already.
pub const STAYS: u32 = u32::MAX;

/// Parts in a hierarchy.
pub struct Tree {
    pub(super) level: Level,
    pub(super) hierarchy: Hierarchy,
    /// Parts in the order of the hierarchy's leaves.
    pub(super) order: Vec<u32>,
    /// Parts without an end.
    pub unbounded: Vec<u32>,
    pub parts: Vec<Part>,
    pub kinds: Vec<Kind>,
    /// From the world to the space of the object.
    pub to_object: Vec<Affine>,
}

/// A simple shape where a map puts it, if it is one of the same kind there.
pub fn placed(shape: &SceneShape, by: &Affine) -> Option<Shape> {
    if *by == Affine::IDENTITY {
        return Shape::of_scene(shape);
    }
    let back = by.inverse()?;
    let turned = |normal: [f64; 3]| Vec3::from(back.transposed(normal)).normalized().to_array();
    match *shape {
        SceneShape::Sphere { center, radius } => {
            Shape::of_scene(&SceneShape::Sphere { center: by.point(center), radius: radius * by.similarity()? })
        }
        SceneShape::Rectangle { center, u, v } => {
            let moved = SceneShape::Rectangle { center: by.point(center), u: by.vector(u), v: by.vector(v) };
            let mut shape = Shape::of_scene(&moved)?;
            if let Shape::Rectangle { normal, .. } = &mut shape
                && by.determinant() < 0.0
            {
                // The front stays the front in a mirror.
                *normal = -*normal;
            }
            Some(shape)
        }
        SceneShape::Disk { center, normal, radius } => Shape::of_scene(&SceneShape::Disk {
            center: by.point(center),
            normal: turned(normal),
            radius: radius * by.similarity()?,
        }),
        SceneShape::Plane { point, normal } => {
            Shape::of_scene(&SceneShape::Plane { point: by.point(point), normal: turned(normal) })
        }
        SceneShape::Cap { center, axis, radius_of_curvature, aperture_radius } => {
            let scale = by.similarity()?;
            Shape::of_scene(&SceneShape::Cap {
                center: by.point(center),
                axis: turned(axis),
                radius_of_curvature: radius_of_curvature * scale,
                aperture_radius: aperture_radius * scale,
            })
        }
        _ => None,
    }
}

impl Tree {
    pub fn of_scene(scene: &ResolvedScene) -> Tree {
        let (mut parts, mut kinds, mut to_object) = (Vec::new(), Vec::new(), Vec::new());
        let mut meshes: Vec<(*const iridesce_files::Mesh, u32)> = Vec::new();
        for (number, object) in scene.recipe.objects.iter().enumerate() {
            let first = kinds.len() as u32;
            // What all instances of it share, made when it is needed.
            let mut own: Option<Vec<u32>> = None;
            for (instance, by) in scene.placements(number).iter().enumerate() {
                let mut add = |kind: u32, placement: u32| {
                    parts.push(Part { object: number as u32, kind, instance: instance as u32, placement });
                };
                if let Some(shape) = placed(&object.shape, by) {
                    kinds.push(Kind::Shape(shape));
                    add(kinds.len() as u32 - 1, STAYS);
                    continue;
                }
                let shared = own.get_or_insert_with(|| match &object.shape {
                    SceneShape::Mesh(_) => {
                        let Some(mesh) = scene.mesh(number) else { return Vec::new() };
                        let address = Arc::as_ptr(mesh);
                        if let Some((_, kind)) = meshes.iter().find(|(known, _)| *known == address) {
                            return vec![*kind];
                        }
                        kinds.push(Kind::Mesh(TriangleMesh::new(mesh.clone())));
                        meshes.push((address, kinds.len() as u32 - 1));
                        vec![kinds.len() as u32 - 1]
                    }
                    SceneShape::Bubbles(balls) => {
                        kinds.extend(patches(balls).into_iter().map(Kind::Patch));
                        (first..kinds.len() as u32).collect()
                    }
                    SceneShape::Cylinder { center, axis, radius, height, is_open } => {
                        kinds.push(Kind::Cylinder(Cylinder {
                            center: (*center).into(),
                            axis: (*axis).into(),
                            radius: *radius,
                            half_height: 0.5 * height,
                            is_open: *is_open,
                        }));
                        vec![kinds.len() as u32 - 1]
                    }
                    simple => {
                        kinds.extend(Shape::of_scene(simple).map(Kind::Shape));
                        (first..kinds.len() as u32).collect()
                    }
                });
                let placement = if *by == Affine::IDENTITY {
                    STAYS
                } else {
                    // A map without a way back was refused with the scene.
                    to_object.push(by.inverse().unwrap_or_default());
                    to_object.len() as u32 - 1
                };
                for &kind in shared.iter() {
                    add(kind, placement);
                }
            }
        }
        Tree::new(parts, kinds, to_object)
    }

    pub fn new(parts: Vec<Part>, kinds: Vec<Kind>, to_object: Vec<Affine>) -> Tree {
        let (mut boxes, mut bounded, mut unbounded) = (Vec::new(), Vec::new(), Vec::new());
        for (number, part) in parts.iter().enumerate() {
            let Some(own) = bounds(part, &kinds, &to_object) else {
                unbounded.push(number as u32);
                continue;
            };
            boxes.push(own);
            bounded.push(number as u32);
        }
        let mut order = Vec::with_capacity(bounded.len());
        let hierarchy = Hierarchy::new(
            boxes.len(),
            |at| boxes[at],
            |numbers| {
                let first = order.len();
                order.extend(numbers.iter().map(|&number| bounded[number as usize]));
                (first, numbers.len())
            },
        );
        Tree { level: simd::level_or_best(), hierarchy, order, unbounded, parts, kinds, to_object }
    }

    /// The box of a part in the world; `None` without an end.
    pub fn bounds(&self, part: usize) -> Option<Bounds> {
        bounds(&self.parts[part], &self.kinds, &self.to_object)
    }

    #[inline(never)]
    pub fn nearest(&self, ray: &Ray, leaving: Option<&Hit>, counts: Option<&dyn Fn(usize) -> bool>) -> Option<Hit> {
        let mut search = Search { counts, ..Search::new(self, ray, leaving) };
        dispatch!(self.level, simd => search.run(simd));
        search.best.map(|best| self.hit(ray, &best))
    }

    /// Whether it has one part with an end: its own box is all that is needed.
    #[inline(always)]
    pub(super) fn is_single(&self) -> bool {
        self.order.len() == 1
    }

    /// The object of what a search has found.
    #[inline(always)]
    pub fn object(&self, best: &Best) -> usize {
        self.parts[best.part as usize].object as usize
    }

    /// The hit that a search has found.
    pub fn hit(&self, ray: &Ray, best: &Best) -> Hit {
        let part = &self.parts[best.part as usize];
        let to_object = self.to_object.get(part.placement as usize);
        let (own, distance) = match to_object {
            None => (*ray, best.distance),
            Some(by) => in_object(ray, by, best.distance),
        };
        let point = own.origin + own.direction * distance;
        let (point, normal) = match &self.kinds[part.kind as usize] {
            Kind::Shape(shape) => shape.at(&own, distance),
            Kind::Cylinder(cylinder) => cylinder.at(point, best.primitive),
            Kind::Patch(patch) => patch.at(&own, distance),
            Kind::Mesh(mesh) => mesh.close(best.seat, point),
        };
        let (point, normal) = match to_object {
            None => (point, normal),
            Some(by) => {
                let there = by.inverse().unwrap_or_default();
                (there.moved(point), Vec3::from(by.transposed(normal.to_array())).normalized())
            }
        };
        Hit {
            object: part.object as usize,
            part: best.part,
            primitive: best.primitive,
            distance: best.distance,
            point,
            normal,
        }
    }

    pub fn first_part(&self, object: usize) -> Option<&Part> {
        // Parts stand in the order of their objects.
        let at = self.parts.partition_point(|part| (part.object as usize) < object);
        self.parts.get(at).filter(|part| part.object as usize == object)
    }

    /// The parts of an object.
    pub fn parts_of(&self, object: u32) -> std::ops::Range<usize> {
        self.parts.partition_point(|part| part.object < object)
            ..self.parts.partition_point(|part| part.object <= object)
    }

    /// The shape of an object that is one simple shape in the world.
    pub fn only_shape(&self, object: usize) -> Option<&Shape> {
        let range = self.parts_of(object as u32);
        if range.len() != 1 {
            return None;
        }
        self.simple(range.start as u32).map(|(_, shape)| shape)
    }

    pub fn simple(&self, part: u32) -> Option<(usize, &Shape)> {
        let part = &self.parts[part as usize];
        match &self.kinds[part.kind as usize] {
            Kind::Shape(shape) if part.placement == STAYS => Some((part.object as usize, shape)),
            _ => None,
        }
    }
}

/// The box of a part in the world; `None` without an end.
fn bounds(part: &Part, kinds: &[Kind], to_object: &[Affine]) -> Option<Bounds> {
    let own = match &kinds[part.kind as usize] {
        Kind::Shape(shape) => shape.bounds()?,
        Kind::Cylinder(cylinder) => cylinder.bounds(),
        Kind::Patch(patch) => patch.bounds(),
        Kind::Mesh(mesh) => *mesh.bounds(),
    };
    let back = to_object.get(part.placement as usize).and_then(Affine::inverse);
    Some(back.map_or(own, |by| Bounds::of(own.corners().map(|corner| by.point(corner)))))
}

/// A ray and a distance along it, as an object sees them.
#[inline(always)]
fn in_object(ray: &Ray, by: &Affine, distance: f64) -> (Ray, f64) {
    let direction = by.turned(ray.direction);
    let scale = direction.length_squared().sqrt();
    (Ray { origin: by.moved(ray.origin), direction: direction * (1.0 / scale) }, distance * scale)
}

/// The nearest so far.
#[derive(Debug, Clone, Copy)]
pub struct Best {
    part: u32,
    primitive: u32,
    /// Of a triangle, where it stands among those of its mesh.
    seat: u32,
    distance: f64,
}

/// How a ray meets a part.
pub(super) enum Meeting<'a> {
    /// Not at all, or here: the distance as the object sees it, and the primitive.
    Told(Option<(f64, u32)>),
    /// By a walk through the mesh, as far as a limit there.
    Walk(mesh::Search<'a>, f64),
}

/// A ray that looks for what it meets first.
pub struct Search<'a> {
    pub(super) tree: &'a Tree,
    pub(super) ray: &'a Ray,
    leaving: Option<&'a Hit>,
    counts: Option<&'a dyn Fn(usize) -> bool>,
    pub best: Option<Best>,
}

impl<'a> Search<'a> {
    pub fn new(tree: &'a Tree, ray: &'a Ray, leaving: Option<&'a Hit>) -> Search<'a> {
        Search { tree, ray, leaving, counts: None, best: None }
    }

    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S) {
        let tree = self.tree;
        let limit = self.meet_unbounded();
        if tree.is_single() {
            self.meet(simd, tree.order[0], limit);
            return;
        }
        tree.hierarchy.walk(simd, self.ray, limit, self);
    }

    /// Meets the parts without an end, of which none is a mesh.
    #[inline(always)]
    pub(super) fn meet_unbounded(&mut self) -> f64 {
        let mut limit = f64::INFINITY;
        for &part in &self.tree.unbounded {
            if let Meeting::Told(Some((distance, primitive))) = self.meeting(part, limit) {
                limit = self.take(part, limit, Some((distance, primitive, 0)));
            }
        }
        limit
    }

    /// Meets one part.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, number: u32, limit: f64) -> f64 {
        let found = match self.meeting(number, limit) {
            Meeting::Told(found) => found.map(|(distance, primitive)| (distance, primitive, 0)),
            Meeting::Walk(mut search, own_limit) => {
                search.run(simd, own_limit);
                search.best.map(|met| (met.distance, met.triangle, met.seat))
            }
        };
        self.take(number, limit, found)
    }

    /// How the ray meets a part.
    #[inline(always)]
    pub(super) fn meeting(&self, number: u32, limit: f64) -> Meeting<'a> {
        let tree = self.tree;
        let part = &tree.parts[number as usize];
        if self.counts.is_some_and(|counts| !counts(part.object as usize)) {
            return Meeting::Told(None);
        }
        let leaving = self.leaving.filter(|hit| hit.part == number).map(|hit| hit.primitive);
        let to_object = tree.to_object.get(part.placement as usize);
        let (own, own_limit) = match to_object {
            None => (*self.ray, limit),
            // A little more: what comes back is compared here.
            Some(by) => in_object(self.ray, by, limit * (1.0 + 4.0 * f64::EPSILON)),
        };
        Meeting::Told(match &tree.kinds[part.kind as usize] {
            Kind::Shape(shape) => shape.distance(&own, leaving.is_some()).map(|distance| (distance, 0)),
            Kind::Cylinder(cylinder) => cylinder.nearest(&own, leaving),
            Kind::Patch(patch) => patch.nearest(&own, leaving.is_some()).map(|distance| (distance, 0)),
            Kind::Mesh(mesh) => {
                let start = leaving.map(|triangle| {
                    // What the way from the world costs in digits.
                    let size = to_object.map_or(0.0, |by| {
                        let most = |v: [f64; 3]| v.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
                        by.stretch() * most(self.ray.origin.to_array()) + most(by.rows.map(|row| row[3]))
                    });
                    Start { triangle, slack: mesh.slack(size) }
                });
                return Meeting::Walk(mesh.search(own, start), own_limit);
            }
        })
    }

    /// Takes what was found of a part, if it is nearer; of two at the same distance the first of the scene is nearer, whatever the order
    /// here. Gives how far the ray still looks.
    #[inline(always)]
    pub(super) fn take(&mut self, number: u32, limit: f64, found: Option<(f64, u32, u32)>) -> f64 {
        let Some((distance, primitive, seat)) = found else { return limit };
        let tree = self.tree;
        let distance = match tree.to_object.get(tree.parts[number as usize].placement as usize) {
            None => distance,
            Some(by) => distance / by.turned(self.ray.direction).length_squared().sqrt(),
        };
        let is_nearer = distance < limit
            || distance == limit && self.best.is_some_and(|best| best.distance == distance && number < best.part);
        if !is_nearer {
            return limit;
        }
        self.best = Some(Best { part: number, primitive, seat, distance });
        distance
    }
}

impl Visit for Search<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, first: usize, count: usize, mut limit: f64) -> f64 {
        for at in first..first + count {
            limit = self.meet(simd, self.tree.order[at], limit);
        }
        limit
    }
}
