//! Which media a place lies within, before any ray has told.
//!
//! A straight line from the place out of the scene tells: the surfaces that it leaves through without having entered
//! there bound what the place lies within. Spheres are closed, so for them any line will do; the lines are taken along
//! the normals of the planes, both ways, and the one that leaves most media counts, since a half space that it stays in
//! for ever it never leaves. Rectangles, disks and caps bound nothing by themselves and count for nothing here.

use iridesce_numerics::Vec3;

use crate::camera::Ray;
use crate::geometry::Geometry;
use crate::medium_stack::MediumStack;

/// Most surfaces on one line.
const MOST_SURFACES: usize = 100_000;

/// The media around a point; `bodies` are the media behind the shapes, where there are any.
pub fn enclosing_media(
    geometry: &Geometry,
    bodies: &[Option<u8>],
    priority: impl Fn(u8) -> i32,
    point: Vec3,
) -> MediumStack {
    let up = Vec3::new(0.0, 1.0, 0.0);
    let normals = geometry.plane_normals(|object| bodies[object].is_some()).into_iter();
    let mut most = Vec::new();
    for direction in std::iter::once(up).chain(normals.flat_map(|normal| [normal, -normal])) {
        let left = left_along(geometry, bodies, Ray { origin: point, direction });
        if left.len() > most.len() {
            most = left;
        }
    }
    // The innermost was left first; of several the strongest is the innermost.
    most.reverse();
    most.sort_by_key(|&medium| priority(medium));
    most.iter().try_fold(MediumStack::default(), |stack, &medium| stack.entered(medium)).unwrap_or_default()
}

/// The media that a straight line leaves without having entered them, in that order.
fn left_along(geometry: &Geometry, bodies: &[Option<u8>], mut ray: Ray) -> Vec<u8> {
    let (mut left, mut entered, mut from) = (Vec::new(), Vec::new(), None);
    let is_body = |object: usize| bodies[object].is_some() && geometry.is_closed(object);
    // No line meets more surfaces, or it goes round and round.
    for _ in 0..MOST_SURFACES {
        let Some(hit) = geometry.nearest_of(&ray, from.as_ref(), &is_body) else { break };
        if let Some(medium) = bodies[hit.object] {
            if ray.direction.dot(hit.normal) < 0.0 {
                entered.push(medium);
            } else if entered.pop().is_none() {
                left.push(medium);
            }
        }
        (ray.origin, from) = (hit.point, Some(hit));
    }
    left
}

#[cfg(test)]
mod tests {
    use iridesce_scene::Shape as SceneShape;

    use super::*;
    use crate::geometry::Shape;

    const WATER: u8 = 3;
    const GLASS: u8 = 5;

    fn plane(y: f64, up: f64) -> Shape {
        Shape::new(&SceneShape::Plane { point: [0.0, y, 0.0], normal: [0.0, up, 0.0] })
    }

    fn media(shapes: &[Shape], bodies: &[u8], y: f64) -> Vec<u8> {
        let bodies: Vec<Option<u8>> = bodies.iter().map(|&medium| Some(medium)).collect();
        let mut medium =
            enclosing_media(&Geometry::of_shapes(shapes.to_vec(), 8), &bodies, |_| 0, Vec3::new(0.1, y, 0.0));
        let mut found = Vec::new();
        while medium != MediumStack::default() {
            found.push(medium.innermost());
            medium = medium.left();
        }
        found
    }

    #[test]
    fn slabs_are_between_their_planes() {
        let slab = [plane(1.0, 1.0), plane(-1.0, -1.0)];
        assert_eq!([2.0, 0.0, -2.0].map(|y| media(&slab, &[GLASS; 2], y)), [vec![], vec![GLASS], vec![]]);
        // A slab lying deep in the sea.
        let sea = [plane(5.0, 1.0), slab[0], slab[1]];
        let bodies = [WATER, GLASS, GLASS];
        assert!(media(&sea, &bodies, 6.0).is_empty());
        assert_eq!(media(&sea, &bodies, 2.0), [WATER]);
        assert_eq!(media(&sea, &bodies, 0.0), [GLASS, WATER]);
        assert_eq!(media(&sea, &bodies, -2.0), [WATER]);
    }

    #[test]
    fn half_spaces_and_spheres_within_them() {
        let ball = Shape::new(&SceneShape::Sphere { center: [0.0, -3.0, 0.0], radius: 1.0 });
        let shapes = [ball, plane(0.0, 1.0)];
        assert!(media(&shapes, &[GLASS, WATER], 1.0).is_empty());
        assert_eq!(media(&shapes, &[GLASS, WATER], -1.0), [WATER]);
        assert_eq!(media(&shapes, &[GLASS, WATER], -3.5), [GLASS, WATER]);
        let disk = Shape::new(&SceneShape::Disk { center: [0.0; 3], normal: [0.0, 1.0, 0.0], radius: 9.0 });
        assert!(media(&[disk], &[GLASS], -1.0).is_empty(), "an open shape bounds nothing by itself");
    }
}
