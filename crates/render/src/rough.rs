//! How rough an object is at every place of it, and in which frame its facets lie.

use iridesce_numerics::Vec3;
use iridesce_scene::{Chart, Object, Roughness, Shape, Texture};

use crate::geometry::{Geometry, Hit, frame};
use crate::microfacet::Microfacets;

/// The roughness of an object that is no mirror.
pub struct RoughSurface {
    spread: Spread,
    /// How u runs where a point of the world tells; `None`: the geometry is asked.
    chart: Option<Chart>,
}

enum Spread {
    Even(Microfacets),
    Map(Texture),
}

impl RoughSurface {
    /// `None` for a mirror.
    pub fn new(map: Option<&Texture>, object: &Object) -> Option<RoughSurface> {
        let spread = match (&object.roughness, map) {
            (_, Some(texture)) => Spread::Map(texture.clone()),
            (Roughness::Uniform([0.0, 0.0]), None) => return None,
            (Roughness::Uniform(along), None) => Spread::Even(Microfacets::new(*along)),
            (Roughness::Map { .. }, None) => unreachable!("a scene is resolved with its maps"),
        };
        let is_told = object.placement.is_plain()
            && !matches!(object.shape, Shape::Mesh(_))
            && !map.is_some_and(Texture::needs_place);
        Some(RoughSurface { spread, chart: is_told.then(|| Chart::new(&object.shape)) })
    }

    /// What facets there are where a ray that travels along `direction` has met the object; the hit bears the normal by
    /// which it is shaded.
    #[inline(always)]
    pub fn at(&self, geometry: &Geometry, hit: &Hit, direction: Vec3) -> RoughPlace {
        let own = if geometry.is_shaded(hit.object) { geometry.normal_at(hit) } else { hit.normal };
        let is_from_front = direction.dot(own) < 0.0;
        let (facing, normal) = if is_from_front { (own, hit.normal) } else { (-own, -hit.normal) };
        let (facets, along_u) = match &self.chart {
            Some(chart) => {
                let point = hit.point.to_array();
                (self.facets(|texture| texture.at(point)), Vec3::from(chart.along_u(point)))
            }
            None => self.asked(geometry, &Hit { normal: own, ..*hit }),
        };
        RoughPlace { facets, frame: Frame::new(along_u, normal), facing }
    }

    /// How facets are spread, and the direction of u, by all that the geometry knows of the place.
    #[inline(never)]
    fn asked(&self, geometry: &Geometry, hit: &Hit) -> (Microfacets, Vec3) {
        let met = geometry.interaction(hit);
        (self.facets(|texture| texture.at_uv([met.u, met.v])), met.frame[0])
    }

    #[inline(always)]
    fn facets(&self, roughness: impl Fn(&Texture) -> [f64; 3]) -> Microfacets {
        match &self.spread {
            Spread::Even(facets) => *facets,
            Spread::Map(texture) => {
                let [both, ..] = roughness(texture);
                Microfacets::new([both; 2])
            }
        }
    }
}

/// The facets of a place.
pub struct RoughPlace {
    /// How they are spread.
    pub facets: Microfacets,
    /// The frame in which they lie: along u, along v, and the normal by which the place is shaded, on the side of the path.
    pub frame: Frame,
    /// The normal of the surface itself on that side.
    pub facing: Vec3,
}

/// Three directions at right angles, of length 1.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    x: Vec3,
    y: Vec3,
    pub z: Vec3,
}

impl Frame {
    /// About a normal, by the direction of u.
    #[inline(always)]
    fn new(u: Vec3, normal: Vec3) -> Frame {
        let along = u - normal * u.dot(normal);
        // At a pole any direction is as good.
        let x = if along.length_squared() > 1e-18 * u.length_squared() && u.length_squared() > 0.0 {
            along.normalized()
        } else {
            frame(normal).0
        };
        Frame { x, y: normal.cross(x), z: normal }
    }

    /// Along u, along v, and the normal.
    #[inline(always)]
    pub fn axes(&self) -> [Vec3; 3] {
        [self.x, self.y, self.z]
    }

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
