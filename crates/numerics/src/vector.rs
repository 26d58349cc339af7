//! Vectors of three numbers: as arrays, and as a type with operators for long formulas.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// a . b
#[inline(always)]
pub fn dot<T: Copy + Add<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline(always)]
pub fn cross<T: Copy + Sub<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a - b
#[inline(always)]
pub fn difference<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// factor a
#[inline(always)]
pub fn scaled<T: Copy + Mul<Output = T>>(a: [T; 3], factor: T) -> [T; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// a + factor b
#[inline(always)]
pub fn along<T: Copy + Add<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3], factor: T) -> [T; 3] {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

/// |a|
#[inline(always)]
pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// a / |a|
#[inline(always)]
pub fn unit(a: [f64; 3]) -> [f64; 3] {
    scaled(a, 1.0 / length(a))
}

/// A point or direction in space.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vec3 {
    /// To the right.
    pub x: f64,
    /// Up.
    pub y: f64,
    /// Towards the viewer.
    pub z: f64,
}

impl Vec3 {
    /// From its parts.
    #[inline(always)]
    pub const fn new(x: f64, y: f64, z: f64) -> Vec3 {
        Vec3 { x, y, z }
    }

    /// As an array.
    #[inline(always)]
    pub const fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Vec3) -> f64 {
        dot(self.to_array(), other.to_array())
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Vec3) -> Vec3 {
        cross(self.to_array(), other.to_array()).into()
    }

    /// The square of its length.
    #[inline(always)]
    pub fn length_squared(self) -> f64 {
        self.dot(self)
    }

    /// Of length 1.
    #[inline(always)]
    pub fn normalized(self) -> Vec3 {
        unit(self.to_array()).into()
    }
}

impl From<[f64; 3]> for Vec3 {
    #[inline(always)]
    fn from([x, y, z]: [f64; 3]) -> Vec3 {
        Vec3::new(x, y, z)
    }
}

impl Add for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn add(self, other: Vec3) -> Vec3 {
        Vec3::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Vec3 {
    #[inline(always)]
    fn add_assign(&mut self, other: Vec3) {
        *self = *self + other;
    }
}

impl Sub for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn sub(self, other: Vec3) -> Vec3 {
        difference(self.to_array(), other.to_array()).into()
    }
}

impl Mul<f64> for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn mul(self, factor: f64) -> Vec3 {
        scaled(self.to_array(), factor).into()
    }
}

impl Neg for Vec3 {
    type Output = Vec3;
    #[inline(always)]
    fn neg(self) -> Vec3 {
        Vec3::new(-self.x, -self.y, -self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_are_one() {
        let (a, b) = ([1.0, 2.0, -3.0], [0.5, -1.0, 4.0]);
        let (v, w) = (Vec3::from(a), Vec3::from(b));
        assert_eq!(v.dot(w), -13.5);
        assert_eq!(v.cross(w).to_array(), [5.0, -5.5, -2.0]);
        assert_eq!(dot(cross(a, b), a), 0.0);
        assert_eq!((v + w * 2.0).to_array(), along(a, b, 2.0));
        assert!((v.normalized().length_squared() - 1.0).abs() < 1e-15);
    }
}
