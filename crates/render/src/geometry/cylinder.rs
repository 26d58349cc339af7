//! The side of a cylinder, with its ends or without.

use iridesce_numerics::Vec3;

use super::bounds::Bounds;
use crate::camera::Ray;

/// A cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Cylinder {
    pub center: Vec3,
    /// Length 1.
    pub axis: Vec3,
    pub radius: f64,
    pub half_height: f64,
    pub is_open: bool,
}

/// Its parts: the side, the end along the axis, the other one.
const SIDE: u32 = 0;
const TOP: u32 = 1;

impl Cylinder {
    /// The nearest crossing ahead and the part that is met; `leaving` is the part that the ray starts on.
    pub fn nearest(&self, ray: &Ray, leaving: Option<u32>) -> Option<(f64, u32)> {
        let from = ray.origin - self.center;
        let (height, rise) = (from.dot(self.axis), ray.direction.dot(self.axis));
        let (from, way) = (from - self.axis * height, ray.direction - self.axis * rise);
        let mut best: Option<(f64, u32)> = None;
        let mut take = |distance: f64, part: u32| {
            if distance > 0.0 && distance < f64::INFINITY && best.is_none_or(|(d, _)| distance < d) {
                best = Some((distance, part));
            }
        };
        let (square, half_b) = (way.length_squared(), from.dot(way));
        if square > 0.0 {
            let is_within = |distance: f64| (height + rise * distance).abs() <= self.half_height;
            if leaving == Some(SIDE) {
                // One crossing is at zero, and passed.
                let far = -2.0 * half_b / square;
                if is_within(far) {
                    take(far, SIDE);
                }
            } else {
                let across = from - way * (half_b / square);
                let reach = self.radius * self.radius - across.length_squared();
                if reach >= 0.0 {
                    let half_chord = (reach / square).sqrt();
                    for distance in [-half_b / square - half_chord, -half_b / square + half_chord] {
                        if is_within(distance) {
                            take(distance, SIDE);
                        }
                    }
                }
            }
        }
        if !self.is_open && rise != 0.0 {
            for (part, side) in [(TOP, 1.0), (TOP + 1, -1.0)] {
                let distance = (side * self.half_height - height) / rise;
                if leaving != Some(part) && (from + way * distance).length_squared() <= self.radius * self.radius {
                    take(distance, part);
                }
            }
        }
        best
    }

    /// A point put onto a part, and its unit normal, outwards.
    pub fn at(&self, point: Vec3, part: u32) -> (Vec3, Vec3) {
        let from = point - self.center;
        let height = from.dot(self.axis);
        let out = from - self.axis * height;
        match part {
            SIDE => {
                let normal = out.normalized();
                (self.center + self.axis * height + normal * self.radius, normal)
            }
            TOP => (self.center + self.axis * self.half_height + out, self.axis),
            _ => (self.center - self.axis * self.half_height + out, -self.axis),
        }
    }

    pub fn bounds(&self) -> Bounds {
        let (center, axis) = (self.center.to_array(), self.axis.to_array());
        let half = axis.map(|a| self.half_height * a.abs() + self.radius * (1.0 - a * a).max(0.0).sqrt());
        Bounds { min: std::array::from_fn(|i| center[i] - half[i]), max: std::array::from_fn(|i| center[i] + half[i]) }
    }

    pub fn area(&self) -> f64 {
        let ends = if self.is_open { 0.0 } else { self.radius };
        std::f64::consts::TAU * self.radius * (2.0 * self.half_height + ends)
    }

    /// A random point, all equally likely.
    pub fn point(&self, (a, b): (f64, f64)) -> Vec3 {
        let (across, up) = super::frame(self.axis);
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let out = across * cos + up * sin;
        let side = 2.0 * self.half_height;
        let place = a * self.area() / (std::f64::consts::TAU * self.radius);
        if place < side || self.is_open {
            return self.center + self.axis * (place.min(side) - self.half_height) + out * self.radius;
        }
        // What is left runs over both ends, each half a radius long.
        let rest = 2.0 * (place - side) / self.radius;
        let (end, share) = if rest < 1.0 { (1.0, rest) } else { (-1.0, rest - 1.0) };
        self.center + self.axis * (end * self.half_height) + out * (self.radius * share.clamp(0.0, 1.0).sqrt())
    }
}
