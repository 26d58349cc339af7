//! From a place on the picture to a ray.

use iridesce_numerics::Vec3;
use iridesce_scene::{Camera, Lens, Projection};

use crate::lights::polarization::{Linear, upright};
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
    /// The same of length 1.
    along: [Vec3; 2],
    orthographic: bool,
    size: [f64; 2],
    lens: Option<Lens>,
    /// The sine up to which the rays of a microscope spread, and how far its plane in focus is.
    pupil: Option<(f64, f64)>,
    polarizer: Option<Linear>,
}

impl RayCamera {
    /// A validated scene camera at a picture size (which may differ from the scene's own).
    pub fn new(camera: &Camera, width: u32, height: u32) -> RayCamera {
        let position = Vec3::from(camera.position);
        let view = Vec3::from(camera.target) - position;
        let forward = view.normalized();
        let right = forward.cross(Vec3::from(camera.up)).normalized();
        let up = right.cross(forward);
        let (half_height, orthographic, sine) = match camera.projection {
            Projection::Perspective { fov_deg } => ((0.5 * fov_deg.to_radians()).tan(), false, 0.0),
            Projection::Orthographic { height, numerical_aperture } => (0.5 * height, true, numerical_aperture),
        };
        let half_width = half_height * f64::from(width) / f64::from(height);
        let (right, up) = (right * half_width, up * half_height);
        RayCamera {
            position,
            forward,
            right,
            up,
            along: [right.normalized(), up.normalized()],
            orthographic,
            size: [f64::from(width), f64::from(height)],
            lens: camera.lens,
            pupil: (sine > 0.0).then(|| (sine, view.length_squared().sqrt())),
            polarizer: camera.polarizer_deg.map(Linear::new),
        }
    }

    /// The direction of the fields that the polariser before the camera passes from a ray, if there is one.
    #[inline(always)]
    pub fn polarizer(&self, direction: Vec3) -> Option<Vec3> {
        self.polarizer.map(|linear| linear.field(-direction, upright(self.up, direction)))
    }

    /// Its upright, as a ray sees it: across the ray.
    pub fn upright(&self, direction: Vec3) -> Vec3 {
        upright(self.up, direction)
    }

    /// What share of the Stokes components of light (S0 to S3, by the signs of pictures) it passes.
    pub fn passes(&self) -> [f64; 4] {
        match &self.polarizer {
            None => [1.0, 0.0, 0.0, 0.0],
            Some(linear) => linear.passes(),
        }
    }

    /// One over the share of natural light that it passes.
    pub fn bare_share(&self) -> f64 {
        1.0 / self.passes()[0]
    }

    /// Whether its rays start at different places.
    pub fn is_wide(&self) -> bool {
        self.orthographic || self.lens.is_some()
    }

    /// Whether its rays to one place in the picture differ.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some() || self.pupil.is_some()
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
        if let Some((sine, distance)) = self.pupil {
            return self.ray_through_pupil(&central, sine, distance, choices);
        }
        let Some(lens) = self.lens else { return central };
        let (a, b) = choices.pair();
        let radius = lens.aperture_radius * a.sqrt();
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let offset = self.along[0] * (radius * cos) + self.along[1] * (radius * sin);
        let to_focus = lens.focus_distance / central.direction.dot(self.forward);
        Ray { origin: central.origin + offset, direction: (central.direction * to_focus - offset).normalized() }
    }

    /// A ray of a microscope: even over its pupil, where a ray at the angle theta passes at sin(theta) from the middle (Abbe's
    /// sine condition; Born & Wolf, Principles of Optics, 7th ed., 4.5).
    #[inline(always)]
    fn ray_through_pupil(&self, central: &Ray, sine: f64, distance: f64, choices: &mut Choices) -> Ray {
        let (a, b) = choices.pair();
        let across = sine * a.sqrt();
        let along = (1.0 - across * across).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let aside = self.along[0] * (across * cos) + self.along[1] * (across * sin);
        let direction = (self.forward * along + aside).normalized();
        let in_focus = central.origin + self.forward * distance;
        Ray { origin: in_focus - direction * (distance / along), direction }
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
            polarizer_deg: None,
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
        let rays =
            RayCamera::new(&camera(Projection::Orthographic { height: 10.0, numerical_aperture: 0.0 }), 200, 100);
        let corner = rays.ray(0.0, 0.0);
        assert_eq!((corner.origin.x, corner.origin.y), (-10.0, 5.0));
        assert_eq!(corner.direction.z, -1.0);
    }

    #[test]
    fn rays_through_the_lens_meet_in_focus() {
        let lens = Lens { aperture_radius: 0.5, focus_distance: 10.0 };
        for projection in [
            Projection::Perspective { fov_deg: 35.0 },
            Projection::Orthographic { height: 10.0, numerical_aperture: 0.0 },
        ] {
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

    /// Rays of a microscope meet in the plane of the target, start where the camera is, and lie evenly in the square of their
    /// sine.
    #[test]
    fn rays_of_a_microscope_are_even_over_its_pupil() {
        let projection = Projection::Orthographic { height: 10.0, numerical_aperture: 0.8 };
        let rays = RayCamera::new(&camera(projection), 200, 100);
        let sampler = crate::sampler::PixelSampler::new(1, 2);
        let (count, mut sum, mut most) = (4096, 0.0, 0.0_f64);
        for sample in 0..count {
            let ray = rays.ray_through_lens(31.0, 17.0, &mut sampler.choices(sample));
            let there = ray.origin + ray.direction * (ray.origin.z / -ray.direction.z);
            let middle = rays.ray(31.0, 17.0).origin;
            assert!((there.x - middle.x).abs() < 1e-12 && (there.y - middle.y).abs() < 1e-12);
            assert!((ray.origin.z - 16.0).abs() < 1e-12);
            let sine2 = 1.0 - ray.direction.z * ray.direction.z;
            sum += sine2;
            most = most.max(sine2);
        }
        // Even from 0 to 0.64: the mean is 0.32, give or take 0.64 / sqrt(12 x 4096) = 0.003.
        assert!((sum / f64::from(count) - 0.32).abs() < 0.01 && (0.62..0.64).contains(&most), "{most}");
    }

    /// A polariser at 30 degrees passes fields that lean to the right in the picture.
    #[test]
    fn polarisers_turn_clockwise_in_the_picture() {
        let projection = Projection::Orthographic { height: 10.0, numerical_aperture: 0.0 };
        let rays = RayCamera::new(&Camera { polarizer_deg: Some(30.0), ..camera(projection) }, 200, 100);
        let field = rays.polarizer(Vec3::new(0.0, 0.0, -1.0)).unwrap();
        assert!((field.x - 0.5).abs() < 1e-15 && (field.y - 0.75_f64.sqrt()).abs() < 1e-15);
    }
}
