//! How rough an object is at every place of it, and in which frame its facets lie.

use iridesce_numerics::Vec3;
use iridesce_scene::{Roughness, Shape, Texture};

use crate::geometry::frame;
use crate::microfacet::Microfacets;

/// The roughness of an object that is no mirror.
pub struct RoughSurface {
    spread: Spread,
    shape: Shape,
}

enum Spread {
    Even(Microfacets),
    Map(Texture),
}

impl RoughSurface {
    /// `None` for a mirror.
    pub fn new(roughness: &Roughness, map: Option<&Texture>, shape: &Shape) -> Option<RoughSurface> {
        let spread = match (roughness, map) {
            (_, Some(texture)) => Spread::Map(texture.clone()),
            (Roughness::Uniform([0.0, 0.0]), None) => return None,
            (Roughness::Uniform(along), None) => Spread::Even(Microfacets::new(*along)),
            (Roughness::Map { .. }, None) => unreachable!("a scene is resolved with its maps"),
        };
        Some(RoughSurface { spread, shape: *shape })
    }

    /// How facets are spread at a point.
    #[inline(always)]
    pub fn facets(&self, point: Vec3) -> Microfacets {
        match &self.spread {
            Spread::Even(facets) => *facets,
            Spread::Map(texture) => {
                let [both, ..] = texture.at(point.to_array());
                Microfacets::new([both; 2])
            }
        }
    }

    /// The frame in which they lie: along u, along v, and the normal.
    #[inline(always)]
    pub fn frame(&self, point: Vec3, normal: Vec3) -> Frame {
        let u = Vec3::from(self.shape.along_u(point.to_array()));
        let along = u - normal * u.dot(normal);
        // At a pole any direction is as good.
        let x = if along.length_squared() > 1e-18 * u.length_squared() && u.length_squared() > 0.0 {
            along.normalized()
        } else {
            frame(normal).0
        };
        Frame { x, y: normal.cross(x), z: normal }
    }
}

/// Three directions at right angles, of length 1.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    x: Vec3,
    y: Vec3,
    pub z: Vec3,
}

impl Frame {
    /// A vector of the world in it.
    #[inline(always)]
    pub fn local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// A vector of it in the world.
    #[inline(always)]
    pub fn world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
