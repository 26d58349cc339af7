//! Random places of surfaces that shine: meshes, cylinders, and simple shapes that are there more than once.

use iridesce_numerics::Vec3;
use iridesce_scene::Affine;

use super::parts::{Kind, Part, STAYS, Tree};
use super::{Shape, mesh};

/// Places of an object, all equally likely by area.
pub struct AreaSampler {
    /// Part, primitive, and the area of all up to and with it.
    pieces: Vec<(u32, u32, f64)>,
}

impl AreaSampler {
    /// Of an object; `None` where its shape draws directions itself, or is not drawn from.
    pub fn new(tree: &Tree, object: u32) -> Option<AreaSampler> {
        let range = tree.parts_of(object);
        let (mut pieces, mut sum) = (Vec::new(), 0.0);
        let mut add = |part: usize, primitive: u32, area: f64| {
            sum += area;
            pieces.push((part as u32, primitive, sum));
        };
        for number in range.clone() {
            let part = &tree.parts[number];
            let there = placement(tree, part);
            match &tree.kinds[part.kind as usize] {
                Kind::Mesh(mesh) => {
                    for triangle in 0..mesh.source.triangles.len() as u32 {
                        let corners = mesh.corners(triangle).map(|corner| there.point(corner.to_array()));
                        add(number, triangle, mesh::area(corners));
                    }
                }
                // Moved and turned it has the area it had; stretched, its places would not be equally likely.
                Kind::Cylinder(cylinder) => {
                    let scale = there.similarity()?;
                    add(number, 0, cylinder.area() * scale * scale);
                }
                Kind::Shape(Shape::Rectangle { u, v, .. }) if range.len() > 1 && part.placement == STAYS => {
                    add(number, 0, 4.0 * u.cross(*v).length_squared().sqrt());
                }
                Kind::Shape(Shape::Disk { radius2, .. }) if range.len() > 1 && part.placement == STAYS => {
                    add(number, 0, std::f64::consts::PI * radius2);
                }
                Kind::Shape(Shape::Sphere { radius, .. }) if range.len() > 1 && part.placement == STAYS => {
                    add(number, 0, 4.0 * std::f64::consts::PI * radius * radius);
                }
                Kind::Shape(_) | Kind::Patch(_) => return None,
            }
        }
        (sum > 0.0 && sum.is_finite()).then_some(AreaSampler { pieces })
    }

    pub fn total(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.2)
    }

    /// A random point in the world.
    pub fn point(&self, tree: &Tree, (a, b): (f64, f64)) -> Vec3 {
        let wanted = a * self.total();
        let at = self.pieces.partition_point(|piece| piece.2 <= wanted).min(self.pieces.len() - 1);
        let before = if at == 0 { 0.0 } else { self.pieces[at - 1].2 };
        let (part, primitive, sum) = self.pieces[at];
        // What the choice has left of the first number serves again.
        let a = ((wanted - before) / (sum - before)).clamp(0.0, 1.0);
        let part = &tree.parts[part as usize];
        let own = match &tree.kinds[part.kind as usize] {
            Kind::Mesh(mesh) => {
                let [first, second, third] = mesh.corners(primitive);
                let root = a.sqrt();
                first * (1.0 - root) + second * (root * (1.0 - b)) + third * (root * b)
            }
            Kind::Cylinder(cylinder) => cylinder.point((a, b)),
            Kind::Shape(Shape::Rectangle { center, u, v, .. }) => *center + *u * (2.0 * a - 1.0) + *v * (2.0 * b - 1.0),
            Kind::Shape(Shape::Disk { center, normal, radius2 }) => {
                let (across, up) = super::frame(*normal);
                let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
                *center + (across * cos + up * sin) * (a * radius2).sqrt()
            }
            Kind::Shape(Shape::Sphere { center, radius, .. }) => {
                let (height, (sin, cos)) = (1.0 - 2.0 * a, (std::f64::consts::TAU * b).sin_cos());
                let round = (1.0 - height * height).max(0.0).sqrt();
                *center + Vec3::new(round * cos, height, round * sin) * *radius
            }
            Kind::Shape(_) | Kind::Patch(_) => Vec3::default(),
        };
        placement(tree, part).moved(own)
    }
}

/// From the space of a part to the world.
fn placement(tree: &Tree, part: &Part) -> Affine {
    tree.to_object.get(part.placement as usize).and_then(Affine::inverse).unwrap_or_default()
}
