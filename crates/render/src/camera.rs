//! From a place on the picture to a ray.

use iridesce_numerics::Vec3;
use iridesce_scene::{Camera, Lens, Projection};

use crate::sampler::Choices;

/// A ray; `direction` has length 1.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
}

/// A camera ready to make rays: row 0 of the picture is on top.
#[derive(Debug, Clone, Copy)]
pub struct RayCamera {
    position: Vec3,
    forward: Vec3,
    /// From the middle of the picture to its right edge, on the picture plane at distance 1 (or in world units).
    right: Vec3,
    up: Vec3,
    orthographic: bool,
    size: [f64; 2],
    lens: Option<Lens>,
}

impl RayCamera {
    /// A validated scene camera at a picture size (which may differ from the scene's own).
    pub fn new(camera: &Camera, width: u32, height: u32) -> RayCamera {
        let position = Vec3::from(camera.position);
        let forward = (Vec3::from(camera.target) - position).normalized();
        let right = forward.cross(Vec3::from(camera.up)).normalized();
        let up = right.cross(forward);
        let (half_height, orthographic) = match camera.projection {
            Projection::Perspective { fov_deg } => ((0.5 * fov_deg.to_radians()).tan(), false),
            Projection::Orthographic { height } => (0.5 * height, true),
        };
        let half_width = half_height * f64::from(width) / f64::from(height);
        RayCamera {
            position,
            forward,
            right: right * half_width,
            up: up * half_height,
            orthographic,
            size: [f64::from(width), f64::from(height)],
            lens: camera.lens,
        }
    }

    /// Whether its rays start at different places.
    pub fn is_wide(&self) -> bool {
        self.orthographic || self.lens.is_some()
    }

    /// The ray through (`x`, `y`) in pixels, (0, 0) the top left corner of the picture; it passes the middle of the lens.
    #[inline(always)]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let across = self.right * (2.0 * x / self.size[0] - 1.0) + self.up * (1.0 - 2.0 * y / self.size[1]);
        if self.orthographic {
            Ray { origin: self.position + across, direction: self.forward }
        } else {
            Ray { origin: self.position, direction: (self.forward + across).normalized() }
        }
    }

    /// [`RayCamera::ray`] through a random place of the lens, all of them equally likely: rays through one point of the
    /// picture meet in the plane that is in focus.
    #[inline(always)]
    pub fn ray_through_lens(&self, x: f64, y: f64, choices: &mut Choices) -> Ray {
        let central = self.ray(x, y);
        let Some(lens) = self.lens else { return central };
        let (a, b) = choices.pair();
        let radius = lens.aperture_radius * a.sqrt();
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let offset = self.right.normalized() * (radius * cos) + self.up.normalized() * (radius * sin);
        let to_focus = lens.focus_distance / central.direction.dot(self.forward);
        Ray { origin: central.origin + offset, direction: (central.direction * to_focus - offset).normalized() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera {
            position: [0.0, 0.0, 16.0],
            target: [0.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            projection,
            lens: None,
            resolution: [200, 100],
        }
    }

    #[test]
    fn field_of_view_is_the_full_vertical_angle() {
        let rays = RayCamera::new(&camera(Projection::Perspective { fov_deg: 35.0 }), 200, 100);
        let top = rays.ray(100.0, 0.0).direction;
        let bottom = rays.ray(100.0, 100.0).direction;
        assert!((top.dot(bottom) - 35.0_f64.to_radians().cos()).abs() < 1e-14);
        assert!(top.y > 0.0 && bottom.y < 0.0, "row 0 is on top");
        assert!(rays.ray(200.0, 50.0).direction.x > 0.0, "columns grow to the right, +x for a camera on +z");
        let corner = rays.ray(200.0, 50.0).direction;
        assert!((corner.x / -corner.z - 2.0 * 17.5_f64.to_radians().tan()).abs() < 1e-14, "square pixels");
    }

    #[test]
    fn orthographic_height_is_the_full_height() {
        let rays = RayCamera::new(&camera(Projection::Orthographic { height: 10.0 }), 200, 100);
        let corner = rays.ray(0.0, 0.0);
        assert_eq!((corner.origin.x, corner.origin.y), (-10.0, 5.0));
        assert_eq!(corner.direction.z, -1.0);
    }

    #[test]
    fn rays_through_the_lens_meet_in_focus() {
        let lens = Lens { aperture_radius: 0.5, focus_distance: 10.0 };
        for projection in [Projection::Perspective { fov_deg: 35.0 }, Projection::Orthographic { height: 10.0 }] {
            let rays = RayCamera::new(&Camera { lens: Some(lens), ..camera(projection) }, 200, 100);
            let at_focus = |ray: Ray| ray.origin + ray.direction * ((6.0 - ray.origin.z) / ray.direction.z);
            let (middle, sampler) = (at_focus(rays.ray(31.0, 17.0)), crate::sampler::PixelSampler::new(1, 2));
            let mut widest = 0.0_f64;
            for sample in 0..256 {
                let ray = rays.ray_through_lens(31.0, 17.0, &mut sampler.choices(sample));
                assert!((at_focus(ray) - middle).length_squared() < 1e-24);
                widest = widest.max((ray.origin - rays.ray(31.0, 17.0).origin).length_squared().sqrt());
            }
            assert!((0.45..=0.5).contains(&widest), "{widest}");
        }
    }
}
