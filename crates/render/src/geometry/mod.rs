//! Where a ray meets the scene: one list of parts, and one question, which of them is nearest.
//!
//! A few shapes that formulas meet are asked one after the other; more of them, and anything else, stand in a hierarchy.
//! A ray that starts on a surface leaves by its part and primitive: no offset, no lost or doubled hits.

mod bounds;
mod build;
mod hierarchy;
mod parts;
mod shape;

use iridesce_numerics::Vec3;

pub use self::parts::Geometry;
pub use self::shape::{Shape, cone_density, cone_direction, frame};

/// A place where a ray meets an object.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Which object.
    pub object: usize,
    /// Which of the parts that objects are made of: an instance, a wall.
    pub part: u32,
    /// Distance along the ray.
    pub distance: f64,
    pub point: Vec3,
    /// Unit normal of the surface itself; it points to the front (out of a sphere).
    pub normal: Vec3,
}

#[cfg(test)]
impl Hit {
    /// A place on the one part of an object.
    pub fn on(object: usize, point: Vec3, normal: Vec3) -> Hit {
        Hit { object, part: object as u32, distance: 1.0, point, normal }
    }
}
