//! Which media a place lies within, before any ray has told.
//!
//! A straight line from the place out of the scene tells: the surfaces that it leaves through without having entered
//! there bound what the place lies within. Spheres are closed, so for them any line will do; the lines are taken along
//! the normals of the planes, both ways, and the one that leaves most media counts, since a half space that it stays in
//! for ever it never leaves. Rectangles, disks and caps bound nothing by themselves and count for nothing here.

use crate::camera::Ray;
use crate::geometry::{Shape, nearest_of};
use crate::media::Within;
use crate::prepare::Material;
use crate::vector::Vec3;

/// The media around a point.
pub fn within(shapes: &[Shape], materials: &[Material], point: Vec3) -> Within {
    let up = Vec3::new(0.0, 1.0, 0.0);
    let normals = shapes.iter().zip(materials).filter_map(|(shape, material)| match (shape, material) {
        (Shape::Plane { normal, .. }, Material::Coating(_)) => Some(*normal),
        _ => None,
    });
    let mut most = Vec::new();
    for direction in std::iter::once(up).chain(normals.flat_map(|normal| [normal, -normal])) {
        let left = left_along(shapes, materials, Ray { origin: point, direction });
        if left.len() > most.len() {
            most = left;
        }
    }
    // The innermost was left first.
    most.iter().rev().try_fold(Within::default(), |within, &medium| within.entered(medium)).unwrap_or_default()
}

/// The media that a straight line leaves without having entered them, in that order.
fn left_along(shapes: &[Shape], materials: &[Material], mut ray: Ray) -> Vec<u8> {
    let (mut left, mut entered, mut from) = (Vec::new(), Vec::new(), None);
    let is_body = |object: usize| {
        matches!(
            (&shapes[object], &materials[object]),
            (Shape::Sphere { .. } | Shape::Plane { .. }, Material::Coating(_))
        )
    };
    // A line meets no shape more than twice.
    for _ in 0..2 * shapes.len() {
        let Some(hit) = nearest_of(shapes, &ray, from, is_body) else { break };
        if let Material::Coating(coating) = &materials[hit.object] {
            if ray.direction.dot(hit.normal) < 0.0 {
                entered.push(coating.substrate);
            } else if entered.pop().is_none() {
                left.push(coating.substrate);
            }
        }
        (ray.origin, from) = (hit.point, Some(hit.object));
    }
    left
}
