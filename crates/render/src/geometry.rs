//! Where a ray meets the scene.

use crate::camera::Ray;
use crate::vector::Vec3;

/// A sphere ready for intersection.
#[derive(Debug, Clone, Copy)]
pub struct Sphere {
    center: Vec3,
    radius: f64,
    per_radius: f64,
}

/// A place where a ray meets an object.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Which object.
    pub object: usize,
    /// Distance along the ray.
    pub distance: f64,
    pub point: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
}

impl Sphere {
    pub fn new(center: Vec3, radius: f64) -> Sphere {
        Sphere { center, radius, per_radius: 1.0 / radius }
    }

    /// Distance to the nearest crossing ahead; `leaving` says that the ray starts on this very sphere,
    /// whose crossing at zero then counts as passed (no offset, no lost or doubled hits).
    #[inline(always)]
    fn distance(&self, ray: &Ray, leaving: bool) -> Option<f64> {
        let from_center = ray.origin - self.center;
        let half_b = from_center.dot(ray.direction);
        if leaving {
            return (half_b < 0.0).then_some(-2.0 * half_b);
        }
        // Distance of the line from the centre by components: b^2 - c would cancel for far cameras.
        let across = from_center - ray.direction * half_b;
        let reach = self.radius * self.radius - across.length_squared();
        if reach < 0.0 {
            return None;
        }
        let half_chord = reach.sqrt();
        let near = -half_b - half_chord;
        if near > 0.0 {
            return Some(near);
        }
        let far = -half_b + half_chord;
        (far > 0.0).then_some(far)
    }
}

/// The nearest hit of a ray among all spheres; `leaving` is the object it starts on, if any.
#[inline(always)]
pub fn nearest(spheres: &[Sphere], ray: &Ray, leaving: Option<usize>) -> Option<Hit> {
    let mut best: Option<(usize, f64)> = None;
    for (object, sphere) in spheres.iter().enumerate() {
        if let Some(distance) = sphere.distance(ray, leaving == Some(object))
            && best.is_none_or(|(_, d)| distance < d)
        {
            best = Some((object, distance));
        }
    }
    best.map(|(object, distance)| {
        let sphere = &spheres[object];
        let outward = (ray.origin + ray.direction * distance - sphere.center) * sphere.per_radius;
        // Back onto the sphere, from which rounding left it: one Newton step of 1 / length instead of a square root.
        let normal = outward * (1.5 - 0.5 * outward.length_squared());
        Hit { object, distance, point: sphere.center + normal * sphere.radius, normal }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Sphere {
        Sphere::new(Vec3::default(), 1.0)
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
        let far = Sphere::new(Vec3::new(0.0, 0.0, -5.0), 1.0);
        let ray = Ray { origin: Vec3::new(0.0, 0.0, 3.0), direction: Vec3::new(0.0, 0.0, -1.0) };
        assert_eq!(nearest(&[far, unit()], &ray, None).unwrap().object, 1);
        assert_eq!(
            nearest(&[far, unit()], &Ray { origin: Vec3::new(0.0, 0.0, -1.0), ..ray }, Some(1)).unwrap().object,
            0
        );
    }
}
