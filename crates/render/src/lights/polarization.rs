//! Linear polarisation of lights, and of the light that a polariser passes.

use iridesce_numerics::Vec3;

/// The sine below which a ray counts as vertical.
const VERTICAL: f64 = 1e-9;

/// An angle from the upright of a ray, anticlockwise for who looks the way that the light goes: clockwise in a picture.
#[derive(Debug, Clone, Copy)]
pub struct Linear {
    cos: f64,
    sin: f64,
}

impl Linear {
    pub fn new(degrees: f64) -> Linear {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Linear { cos, sin }
    }

    /// The direction, length 1, of the fields of light that travels along `light` and has this `upright`, at right angles to it.
    #[inline(always)]
    pub fn field(&self, light: Vec3, upright: Vec3) -> Vec3 {
        upright * self.cos + upright.cross(light) * self.sin
    }

    /// What it passes, as a polariser, of the Stokes components of light: S1 > 0 along the upright, S2 > 0 at 45 degrees.
    pub fn passes(&self) -> [f64; 4] {
        let (q, u) = (self.cos * self.cos - self.sin * self.sin, 2.0 * self.sin * self.cos);
        [0.5, 0.5 * q, 0.5 * u, 0.0]
    }

    /// Q and U, for I = 1, of a lamp's light that travels along `light`, in the frame whose s direction is `axis` and whose
    /// p direction is `light` x `axis`.
    #[inline(always)]
    pub fn stokes(&self, light: Vec3, axis: Vec3) -> [f64; 2] {
        let field = self.field(light, upright(Vec3::new(0.0, 1.0, 0.0), light));
        let (cos, sin) = (field.dot(axis), field.dot(light.cross(axis)));
        [cos * cos - sin * sin, 2.0 * cos * sin]
    }
}

/// `up` made perpendicular to a ray; where they run along each other, -z.
#[inline(always)]
pub fn upright(up: Vec3, ray: Vec3) -> Vec3 {
    let across = up - ray * up.dot(ray);
    if across.length_squared() > VERTICAL * VERTICAL {
        return across.normalized();
    }
    let back = Vec3::new(0.0, 0.0, -1.0);
    (back - ray * back.dot(ray)).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that comes to the camera along +z, out of the picture: upright is y, and right in the picture is x.
    #[test]
    fn angles_grow_clockwise_in_the_picture() {
        let light = Vec3::new(0.0, 0.0, 1.0);
        let field = Linear::new(30.0).field(light, upright(Vec3::new(0.0, 1.0, 0.0), light));
        assert!((field.x - 0.5).abs() < 1e-15 && (field.y - 0.75_f64.sqrt()).abs() < 1e-15 && field.z == 0.0);
    }

    #[test]
    fn stokes_vectors_are_those_of_the_frame() {
        let light = Vec3::new(0.3, -0.4, 0.5).normalized();
        let up = upright(Vec3::new(0.0, 1.0, 0.0), light);
        let [q, u] = Linear::new(0.0).stokes(light, up);
        assert!((q - 1.0).abs() < 1e-14 && u.abs() < 1e-14, "along the axis");
        let [q, u] = Linear::new(90.0).stokes(light, up);
        assert!((q + 1.0).abs() < 1e-14 && u.abs() < 1e-14, "across it");
        // p is anticlockwise for who looks against the light: the other way round than the angle.
        let [q, u] = Linear::new(45.0).stokes(light, up);
        assert!(q.abs() < 1e-14 && (u + 1.0).abs() < 1e-14, "half way");
    }

    #[test]
    fn vertical_rays_have_an_upright_too() {
        for y in [1.0, -1.0] {
            let up = upright(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, y, 0.0));
            assert_eq!((up.x, up.y, up.z), (0.0, 0.0, -1.0));
        }
    }
}
