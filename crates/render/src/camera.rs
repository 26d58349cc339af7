//! From a place on the picture to a ray.

use iridesce_numerics::Vec3;
use iridesce_scene::{Camera, Lens, Projection};

use crate::lights::polarization::{Linear, upright};
use crate::sampler::Choices;

/// Most rays that are made together, and asked for together what they meet.
pub const MOST_TOGETHER: usize = 64;

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
        if self.orthographic {
            Ray { origin: self.position + self.across(x, y), direction: self.forward }
        } else {
            Ray { origin: self.position, direction: self.central_direction(x, y) }
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
        self.aside(&lens, &central, on_disc(lens.aperture_radius, choices.pair()))
    }

    /// [`RayCamera::ray_through_lens`] of neighbouring samples of a pixel, [`MOST_TOGETHER`] at most, side by side.
    #[inline(always)]
    pub fn rays_through_lens(&self, x: &[f64], y: &[f64], choices: &mut [Choices], rays: &mut Vec<Ray>) {
        let count = x.len().min(y.len()).min(choices.len()).min(MOST_TOGETHER);
        if self.orthographic || self.pupil.is_some() {
            rays.extend((0..count).map(|i| self.ray_through_lens(x[i], y[i], &mut choices[i])));
            return;
        }
        let (mut o, mut d) = ([[0.0; MOST_TOGETHER]; 3], [[0.0; MOST_TOGETHER]; 3]);
        for i in 0..count {
            let direction = self.central_direction(x[i], y[i]);
            (d[0][i], d[1][i], d[2][i]) = (direction.x, direction.y, direction.z);
        }
        let Some(lens) = self.lens else {
            let direction = |i: usize| Vec3::new(d[0][i], d[1][i], d[2][i]);
            rays.extend((0..count).map(|i| Ray { origin: self.position, direction: direction(i) }));
            return;
        };
        let (mut a, mut b) = ([0.0; MOST_TOGETHER], [0.0; MOST_TOGETHER]);
        Choices::pair_each(&mut choices[..count], &mut a[..count], &mut b[..count]);
        for i in 0..count {
            [a[i], b[i]] = on_disc(lens.aperture_radius, (a[i], b[i]));
        }
        for i in 0..count {
            let central = Ray { origin: self.position, direction: Vec3::new(d[0][i], d[1][i], d[2][i]) };
            let Ray { origin, direction } = self.aside(&lens, &central, [a[i], b[i]]);
            (o[0][i], o[1][i], o[2][i]) = (origin.x, origin.y, origin.z);
            (d[0][i], d[1][i], d[2][i]) = (direction.x, direction.y, direction.z);
        }
        let at = |rows: &[[f64; MOST_TOGETHER]; 3], i: usize| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
        rays.extend((0..count).map(|i| Ray { origin: at(&o, i), direction: at(&d, i) }));
    }

    /// The ray that passes a place of the lens, of which the central one passes its middle.
    #[inline(always)]
    fn aside(&self, lens: &Lens, central: &Ray, [along, up]: [f64; 2]) -> Ray {
        let offset = self.along[0] * along + self.along[1] * up;
        let to_focus = lens.focus_distance / central.direction.dot(self.forward);
        Ray { origin: central.origin + offset, direction: (central.direction * to_focus - offset).normalized() }
    }

    /// The direction of [`RayCamera::ray`] of a camera with a view angle.
    #[inline(always)]
    fn central_direction(&self, x: f64, y: f64) -> Vec3 {
        (self.forward + self.across(x, y)).normalized()
    }

    /// From the middle of the picture plane to a place in the picture.
    #[inline(always)]
    fn across(&self, x: f64, y: f64) -> Vec3 {
        self.right * (2.0 * x / self.size[0] - 1.0) + self.up * (1.0 - 2.0 * y / self.size[1])
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

/// A place on a disc, all of it equally likely, from a point of the unit square.
#[inline(always)]
fn on_disc(radius: f64, (a, b): (f64, f64)) -> [f64; 2] {
    let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
    let away = radius * a.sqrt();
    [away * cos, away * sin]
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

    #[test]
    fn rays_side_by_side_are_those_one_by_one() {
        let lens = Some(Lens { aperture_radius: 0.5, focus_distance: 10.0 });
        let perspective = Projection::Perspective { fov_deg: 35.0 };
        let flat = |numerical_aperture: f64| Projection::Orthographic { height: 10.0, numerical_aperture };
        for (projection, lens) in [(perspective, None), (perspective, lens), (flat(0.0), lens), (flat(0.3), None)] {
            let camera = Camera { lens, target: [1.0, 2.0, 3.0], ..camera(projection) };
            let (camera, sampler) = (RayCamera::new(&camera, 200, 100), crate::sampler::PixelSampler::new(1, 2));
            let x: Vec<f64> = (0..50).map(|i| 3.7 * f64::from(i)).collect();
            let y: Vec<f64> = (0..50).map(|i| 99.0 - 1.3 * f64::from(i)).collect();
            let mut choices: Vec<Choices> = (7..57).map(|sample| sampler.choices(sample)).collect();
            let mut rays = Vec::new();
            camera.rays_through_lens(&x, &y, &mut choices, &mut rays);
            assert_eq!(rays.len(), 50);
            for i in 0..50 {
                let mut own = sampler.choices(7 + i as u32);
                let ray = camera.ray_through_lens(x[i], y[i], &mut own);
                assert_eq!((rays[i].origin, rays[i].direction), (ray.origin, ray.direction));
                assert_eq!(choices[i].pair(), own.pair());
            }
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
