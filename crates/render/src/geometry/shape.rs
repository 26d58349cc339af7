//! Shapes that a formula meets: spheres, rectangles, disks, planes, caps.

use iridesce_numerics::Vec3;
use iridesce_scene::Shape as SceneShape;

use super::bounds::Bounds;
use crate::camera::Ray;

/// A shape ready for intersection.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    Sphere {
        center: Vec3,
        radius: f64,
        per_radius: f64,
    },
    /// `across` and `up` are reciprocal to the half edges: their products with a place tell where it lies, from -1 to 1.
    Rectangle {
        center: Vec3,
        normal: Vec3,
        across: Vec3,
        up: Vec3,
        u: Vec3,
        v: Vec3,
    },
    Disk {
        center: Vec3,
        normal: Vec3,
        radius2: f64,
    },
    Plane {
        point: Vec3,
        normal: Vec3,
    },
    /// The part of a sphere whose height over `center`, along `bulge`, is at least `rim`. `side` is 1 where the normal
    /// points away from the centre and -1 where it points to it.
    Cap {
        center: Vec3,
        radius: f64,
        per_radius: f64,
        bulge: Vec3,
        rim: f64,
        side: f64,
    },
}

impl Shape {
    /// A shape of a scene that formulas meet; `None` for the others.
    pub fn of_scene(shape: &SceneShape) -> Option<Shape> {
        Some(match *shape {
            SceneShape::Cylinder { .. } | SceneShape::Mesh(_) | SceneShape::Bubbles(_) => return None,
            SceneShape::Sphere { center, radius } => {
                Shape::Sphere { center: center.into(), radius, per_radius: 1.0 / radius }
            }
            SceneShape::Rectangle { center, u, v } => {
                let (u, v) = (Vec3::from(u), Vec3::from(v));
                let area = u.cross(v);
                let per_area2 = 1.0 / area.length_squared();
                Shape::Rectangle {
                    center: center.into(),
                    normal: area.normalized(),
                    across: v.cross(area) * per_area2,
                    up: area.cross(u) * per_area2,
                    u,
                    v,
                }
            }
            SceneShape::Disk { center, normal, radius } => {
                Shape::Disk { center: center.into(), normal: Vec3::from(normal).normalized(), radius2: radius * radius }
            }
            SceneShape::Plane { point, normal } => {
                Shape::Plane { point: point.into(), normal: Vec3::from(normal).normalized() }
            }
            SceneShape::Cap { center, axis, radius_of_curvature, aperture_radius } => {
                let (axis, side) = (Vec3::from(axis).normalized(), radius_of_curvature.signum());
                let radius = radius_of_curvature.abs();
                Shape::Cap {
                    center: Vec3::from(center) - axis * radius_of_curvature,
                    radius,
                    per_radius: 1.0 / radius,
                    bulge: axis * side,
                    rim: (radius - aperture_radius).mul_add(radius + aperture_radius, 0.0).max(0.0).sqrt(),
                    side,
                }
            }
        })
    }

    /// [`Shape::of_scene`] of a shape that is one.
    #[cfg(test)]
    pub fn new(shape: &SceneShape) -> Shape {
        Shape::of_scene(shape).unwrap()
    }

    /// A direction from `origin` to a random place of the shape, and its probability per solid angle. `None` for what
    /// is not drawn from: planes and caps, and spheres from within.
    #[inline(always)]
    pub fn draw(&self, origin: Vec3, (a, b): (f64, f64)) -> Option<(Vec3, f64)> {
        match self {
            Shape::Sphere { .. } => {
                let (axis, cos_rim) = self.cone(origin)?;
                let (direction, density) = cone_direction(axis, cos_rim, (a, b));
                Some((direction, density))
            }
            Shape::Rectangle { center, u, v, .. } => {
                self.towards(origin, *center + *u * (2.0 * a - 1.0) + *v * (2.0 * b - 1.0))
            }
            Shape::Disk { center, normal, radius2 } => {
                let (across, up) = frame(*normal);
                let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
                let radius = (a * radius2).sqrt();
                self.towards(origin, *center + across * (radius * cos) + up * (radius * sin))
            }
            Shape::Plane { .. } | Shape::Cap { .. } => None,
        }
    }

    /// The probability per solid angle with which [`Shape::draw`] finds a place of the shape, 0 where it never does.
    #[inline(always)]
    pub fn density(&self, origin: Vec3, place: Vec3) -> f64 {
        match self {
            Shape::Sphere { .. } => self.cone(origin).map_or(0.0, |(_, cos_rim)| cone_density(cos_rim)),
            Shape::Rectangle { .. } | Shape::Disk { .. } => self.towards(origin, place).map_or(0.0, |found| found.1),
            Shape::Plane { .. } | Shape::Cap { .. } => 0.0,
        }
    }

    /// Direction to a place of a flat shape, and the probability per solid angle if places are equally likely.
    #[inline(always)]
    fn towards(&self, origin: Vec3, place: Vec3) -> Option<(Vec3, f64)> {
        let (normal, area) = match self {
            Shape::Rectangle { normal, u, v, .. } => (*normal, 4.0 * u.cross(*v).length_squared().sqrt()),
            Shape::Disk { normal, radius2, .. } => (*normal, std::f64::consts::PI * radius2),
            _ => return None,
        };
        let away = place - origin;
        let distance2 = away.length_squared();
        let direction = away.normalized();
        let cos = direction.dot(normal).abs();
        (cos > 1e-9 && distance2 > 0.0).then(|| (direction, distance2 / (cos * area)))
    }

    /// The cone in which a sphere is seen from outside: its axis, and the cosine of its half angle.
    #[inline(always)]
    fn cone(&self, origin: Vec3) -> Option<(Vec3, f64)> {
        let Shape::Sphere { center, radius, .. } = self else { return None };
        let away = *center - origin;
        let sine2 = radius * radius / away.length_squared();
        (sine2 < 1.0).then(|| (away.normalized(), (1.0 - sine2).sqrt()))
    }

    /// Distance to the nearest crossing ahead; `leaving` says that the ray starts on this very shape, whose crossing
    /// at zero then counts as passed (no offset, no lost or doubled hits).
    #[inline(always)]
    pub fn distance(&self, ray: &Ray, leaving: bool) -> Option<f64> {
        match self {
            Shape::Sphere { center, radius, .. } => {
                let [near, far] = chord(*center, *radius, ray, leaving)?;
                if near > 0.0 {
                    return Some(near);
                }
                (far > 0.0).then_some(far)
            }
            Shape::Cap { center, radius, bulge, rim, .. } => {
                let crossings = chord(*center, *radius, ray, leaving)?;
                crossings.into_iter().find(|&distance| {
                    distance > 0.0 && (ray.origin + ray.direction * distance - *center).dot(*bulge) >= *rim
                })
            }
            _ if leaving => None,
            Shape::Rectangle { center, normal, across, up, .. } => {
                let distance = level(*center, *normal, ray)?;
                let place = ray.origin + ray.direction * distance - *center;
                (place.dot(*across).abs() <= 1.0 && place.dot(*up).abs() <= 1.0).then_some(distance)
            }
            Shape::Disk { center, normal, radius2 } => {
                let distance = level(*center, *normal, ray)?;
                let place = ray.origin + ray.direction * distance - *center;
                (place.length_squared() <= *radius2).then_some(distance)
            }
            Shape::Plane { point, normal } => level(*point, *normal, ray),
        }
    }

    /// All crossings of spheres, caps and disks, ahead or behind; the one at zero of a ray that leaves is behind.
    pub fn crossings(&self, ray: &Ray, leaving: bool, mut found: impl FnMut(f64)) {
        match self {
            Shape::Sphere { center, radius, .. } => {
                chord(*center, *radius, ray, leaving).into_iter().flatten().for_each(found);
            }
            Shape::Cap { center, radius, bulge, rim, .. } => {
                for distance in chord(*center, *radius, ray, leaving).into_iter().flatten() {
                    if (ray.origin + ray.direction * distance - *center).dot(*bulge) >= *rim {
                        found(distance);
                    }
                }
            }
            _ => self.distance(ray, leaving).into_iter().for_each(found),
        }
    }

    /// The point at a distance along a ray, put back onto the shape, and the unit normal of its front.
    #[inline(always)]
    pub fn at(&self, ray: &Ray, distance: f64) -> (Vec3, Vec3) {
        let point = ray.origin + ray.direction * distance;
        match self {
            Shape::Sphere { center, radius, per_radius } => {
                let normal = back_onto_sphere((point - *center) * *per_radius);
                (*center + normal * *radius, normal)
            }
            Shape::Cap { center, radius, per_radius, side, .. } => {
                let outward = back_onto_sphere((point - *center) * *per_radius);
                (*center + outward * *radius, outward * *side)
            }
            Shape::Rectangle { normal, .. } | Shape::Disk { normal, .. } | Shape::Plane { normal, .. } => {
                (point, *normal)
            }
        }
    }

    /// The corners of a box around it, along the world's axes; `None` for what has no end.
    pub fn bounds(&self) -> Option<Bounds> {
        let around = |center: Vec3, half: [f64; 3]| {
            let center = center.to_array();
            Some(Bounds {
                min: std::array::from_fn(|i| center[i] - half[i]),
                max: std::array::from_fn(|i| center[i] + half[i]),
            })
        };
        let disk = |normal: Vec3, radius: f64| normal.to_array().map(|n| radius * (1.0 - n * n).max(0.0).sqrt());
        match self {
            Shape::Sphere { center, radius, .. } => around(*center, [*radius; 3]),
            Shape::Rectangle { center, u, v, .. } => {
                let (u, v) = (u.to_array(), v.to_array());
                around(*center, std::array::from_fn(|i| u[i].abs() + v[i].abs()))
            }
            Shape::Disk { center, normal, radius2 } => around(*center, disk(*normal, radius2.sqrt())),
            Shape::Plane { .. } => None,
            // Of the whole sphere at most; of a shallow cap its rim, and what lies between that and the vertex.
            Shape::Cap { center, radius, bulge, rim, .. } => {
                let half = disk(*bulge, (radius * radius - rim * rim).max(0.0).sqrt());
                let ring = around(*center + *bulge * *rim, half)?;
                let lid = around(*center + *bulge * *radius, half)?;
                around(*center, [*radius; 3]).map(|ball| ball.overlap(&ring.union(&lid)))
            }
        }
    }
}

/// A direction within a cone, all of them equally likely, and its probability per solid angle.
#[inline(always)]
pub fn cone_direction(axis: Vec3, cos_rim: f64, (a, b): (f64, f64)) -> (Vec3, f64) {
    let (across, up) = frame(axis);
    // 1 - cos is kept for itself: it is all there is of a narrow cone.
    let less = (1.0 - cos_rim) * a;
    let sine = (less * (2.0 - less)).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
    (axis * (1.0 - less) + across * (sine * cos) + up * (sine * sin), cone_density(cos_rim))
}

/// Probability per solid angle of the directions within a cone.
#[inline(always)]
pub fn cone_density(cos_rim: f64) -> f64 {
    1.0 / (std::f64::consts::TAU * (1.0 - cos_rim))
}

/// Two unit vectors at right angles to a unit vector and to each other.
#[inline(always)]
pub fn frame(axis: Vec3) -> (Vec3, Vec3) {
    let other = if axis.x.abs() < 0.5 { Vec3::new(1.0, 0.0, 0.0) } else { Vec3::new(0.0, 1.0, 0.0) };
    let across = axis.cross(other).normalized();
    (across, across.cross(axis))
}

/// Where a line crosses a sphere. A ray that leaves this very sphere has one crossing at zero: it is put behind.
#[inline(always)]
fn chord(center: Vec3, radius: f64, ray: &Ray, leaving: bool) -> Option<[f64; 2]> {
    let from_center = ray.origin - center;
    let half_b = from_center.dot(ray.direction);
    if leaving {
        return (half_b < 0.0).then_some([-1.0, -2.0 * half_b]);
    }
    // Distance of the line from the centre by components: b^2 - c would cancel for far cameras.
    let across = from_center - ray.direction * half_b;
    let reach = radius * radius - across.length_squared();
    if reach < 0.0 {
        return None;
    }
    let half_chord = reach.sqrt();
    Some([-half_b - half_chord, -half_b + half_chord])
}

/// Distance ahead to a plane.
#[inline(always)]
fn level(point: Vec3, normal: Vec3, ray: &Ray) -> Option<f64> {
    let distance = (point - ray.origin).dot(normal) / ray.direction.dot(normal);
    // Also false for the NaN of a ray within the plane.
    (distance > 0.0 && distance < f64::INFINITY).then_some(distance)
}

/// A unit vector from one that is so but for rounding: one Newton step of 1 / length instead of a square root.
#[inline(always)]
fn back_onto_sphere(outward: Vec3) -> Vec3 {
    outward * (1.5 - 0.5 * outward.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Hit};

    fn nearest(shapes: &[Shape], ray: &Ray, leaving: Option<usize>) -> Option<Hit> {
        let leaving = leaving.map(|object| Hit::on(object, ray.origin, ray.direction));
        let flat = Geometry::of_shapes(shapes.to_vec(), usize::MAX).nearest(ray, leaving.as_ref());
        let tree = Geometry::of_shapes(shapes.to_vec(), 0).nearest(ray, leaving.as_ref());
        assert_eq!(flat.map(|hit| (hit.object, hit.point)), tree.map(|hit| (hit.object, hit.point)));
        flat
    }

    fn unit() -> Shape {
        Shape::new(&SceneShape::Sphere { center: [0.0; 3], radius: 1.0 })
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: Vec3::from(direction).normalized() }
    }

    #[test]
    fn from_outside_from_inside_and_from_itself() {
        let ray = Ray { origin: Vec3::new(0.0, 0.0, 3.0), direction: Vec3::new(0.0, 0.0, -1.0) };
        let hit = nearest(&[unit()], &ray, None).unwrap();
        assert!((hit.distance - 2.0).abs() < 1e-15 && hit.normal.z > 0.0);
        let inside = Ray { origin: hit.point, direction: ray.direction };
        let second = nearest(&[unit()], &inside, Some(0)).unwrap();
        assert!((second.distance - 2.0).abs() < 1e-15 && second.normal.z < 0.0);
        let outside = Ray { origin: second.point, direction: ray.direction };
        assert!(nearest(&[unit()], &outside, Some(0)).is_none());
        let middle = Ray { origin: Vec3::default(), direction: ray.direction };
        assert!((nearest(&[unit()], &middle, None).unwrap().distance - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_nearest_of_two() {
        let far = Shape::new(&SceneShape::Sphere { center: [0.0, 0.0, -5.0], radius: 1.0 });
        let ray = Ray { origin: Vec3::new(0.0, 0.0, 3.0), direction: Vec3::new(0.0, 0.0, -1.0) };
        assert_eq!(nearest(&[far, unit()], &ray, None).unwrap().object, 1);
        assert_eq!(
            nearest(&[far, unit()], &Ray { origin: Vec3::new(0.0, 0.0, -1.0), ..ray }, Some(1)).unwrap().object,
            0
        );
    }

    #[test]
    fn flat_shapes_end_at_their_edges() {
        let sheared = SceneShape::Rectangle { center: [1.0, 0.0, 0.0], u: [2.0, 0.0, 0.0], v: [1.0, 1.0, 0.0] };
        let shape = Shape::new(&sheared);
        let meets = |x: f64, y: f64| shape.distance(&ray([x, y, 5.0], [0.0, 0.0, -1.0]), false).is_some();
        // At v = 0.9: x from 1 + 0.9 - 2 to 1 + 0.9 + 2.
        assert!(meets(3.89, 0.9) && !meets(3.91, 0.9) && meets(-0.09, 0.9) && !meets(-0.11, 0.9));
        assert!(!meets(1.0, 1.01) && !meets(1.0, -1.01));
        let hit = nearest(&[shape], &ray([1.0, 0.0, 5.0], [0.0, 0.0, -1.0]), None).unwrap();
        assert!(hit.normal.z == 1.0 && (hit.distance - 5.0).abs() < 1e-15);
        let disk = Shape::new(&SceneShape::Disk { center: [0.0; 3], normal: [0.0, 2.0, 0.0], radius: 2.0 });
        let meets = |x: f64| disk.distance(&ray([x, 3.0, 0.0], [0.0, -1.0, 0.0]), false).is_some();
        assert!(meets(1.999) && !meets(2.001));
        assert!(disk.distance(&ray([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), false).is_none(), "a ray within the plane");
        assert!(disk.distance(&ray([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]), true).is_none(), "a ray that leaves it");
        let plane = Shape::new(&SceneShape::Plane { point: [0.0, -1.0, 0.0], normal: [0.0, 1.0, 0.0] });
        let hit = nearest(&[plane], &ray([0.0, 2.0, 0.0], [4.0, -3.0, 0.0]), None).unwrap();
        assert!((hit.point.x - 4.0).abs() < 1e-14 && (hit.point.y + 1.0).abs() < 1e-14 && hit.normal.y == 1.0);
    }

    /// A cap bulges towards its axis, a hollow one away from it; both have their normal along the axis at the vertex.
    #[test]
    fn caps_are_parts_of_spheres_around_their_vertex() {
        for radius_of_curvature in [5.0, -5.0] {
            let cap = Shape::new(&SceneShape::Cap {
                center: [0.0, 1.0, 0.0],
                axis: [0.0, 1.0, 0.0],
                radius_of_curvature,
                aperture_radius: 3.0,
            });
            // A sphere of radius 5 sinks by 1 at 3 from its axis.
            for (x, sag) in [(0.0, 0.0), (2.999_999, 1.0)] {
                let hit = nearest(&[cap], &ray([x, 9.0, 0.0], [0.0, -1.0, 0.0]), None).unwrap();
                assert!((hit.point.y - (1.0 - radius_of_curvature.signum() * sag)).abs() < 1e-5, "{hit:?}");
                assert!(hit.normal.y > 0.79 && (hit.normal.length_squared() - 1.0).abs() < 1e-14);
                assert!(hit.normal.x * radius_of_curvature >= 0.0);
            }
            assert!(nearest(&[cap], &ray([3.000_001, 9.0, 0.0], [0.0, -1.0, 0.0]), None).is_none());
            // From below it is met from its back, and the far side of the sphere is not there.
            let hit = nearest(&[cap], &ray([0.5, -20.0, 0.0], [0.0, 1.0, 0.0]), None).unwrap();
            assert!((hit.point.y - 1.0).abs() < 0.1 && hit.normal.y > 0.9);
            // A ray that leaves it does not meet the place it left; within the hollow it may meet the other side.
            let away = Ray { origin: hit.point, direction: Vec3::new(0.0, 1.0, 0.0) };
            assert!(nearest(&[cap], &away, Some(0)).is_none());
            let start = nearest(&[cap], &ray([2.9, 9.0, 0.0], [0.0, -1.0, 0.0]), None).unwrap();
            let across = Ray { origin: start.point, direction: Vec3::new(-1.0, 0.0, 0.0) };
            let other = nearest(&[cap], &across, Some(0)).expect("the other side at the same height");
            assert!((other.point.x + 2.9).abs() < 1e-9);
        }
    }
}
