//! Where a ray meets the scene: one list of parts, and one question, which of them is nearest.
//!
//! A few shapes that formulas meet are asked one after the other; more of them, and anything else, stand in a hierarchy.
//! A ray that starts on a surface leaves by its part and primitive: no offset, no lost or doubled hits.

mod area;
mod beam;
mod bounds;
mod build;
mod bundle;
mod charts;
mod cylinder;
mod hierarchy;
mod mesh;
mod parts;
mod patch;
mod ring;
mod shape;
mod world;

use iridesce_numerics::Vec3;

pub use self::build::{Box32, Item, MOST_LEVELS, Tree};
pub use self::parts::{Best, Tree as PartTree};
pub use self::shape::{Shape, cone_density, cone_direction, frame};
pub use self::world::Geometry;

/// A place where a ray meets an object.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Which object.
    pub object: usize,
    /// Which of the parts that objects are made of: an instance, a wall.
    pub part: u32,
    /// Which primitive of it: a triangle of a mesh, an end of a cylinder; else 0.
    pub primitive: u32,
    /// Distance along the ray.
    pub distance: f64,
    pub point: Vec3,
    /// Unit normal of the surface itself; it points to the front (out of a sphere).
    pub normal: Vec3,
}

/// What maps, bumps and rough surfaces ask of a place that a ray has met, beside its [`Hit`].
#[derive(Debug, Clone, Copy)]
pub struct Interaction {
    /// Which instance of its object.
    pub instance: u32,
    /// The place in the space of the object's shape.
    pub local: Vec3,
    /// Unit normal by which light is mirrored and refracted, on the side of the surface's own.
    pub shading_normal: Vec3,
    /// Unit vectors along u and at right angles to it; with the shading normal a right-handed frame.
    pub frame: [Vec3; 2],
    /// As maps are asked.
    pub u: f64,
    /// As maps are asked.
    pub v: f64,
    /// What the vertices around say of the film, nm; NaN where they say nothing.
    pub thickness_nm: f64,
}

#[cfg(test)]
impl Hit {
    /// A place on the one part of an object.
    pub fn on(object: usize, point: Vec3, normal: Vec3) -> Hit {
        Hit { object, part: object as u32, primitive: 0, distance: 1.0, point, normal }
    }
}
