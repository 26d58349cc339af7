//! Random places of surfaces that shine: meshes, cylinders, and simple shapes that are there more than once.

use iridesce_numerics::Vec3;
use iridesce_scene::Affine;

use super::mesh::{self, TriangleMesh};
use super::parts::{Kind, Part, STAYS, Tree};
use super::{Hit, Shape};

/// Places of an object: all equally likely by area where its parts are alike but for their size, and each with a density that is
/// known where they are stretched.
pub struct AreaSampler {
    /// The first part of the object: its parts follow one another.
    first: usize,
    pieces: Vec<Piece>,
    /// Areas of the triangles of meshes, each with all before it.
    tables: Vec<Vec<f64>>,
}

/// A part of an object.
#[derive(Clone, Copy)]
struct Piece {
    /// The area of all up to and with it, in the world.
    sum: f64,
    /// Of a mesh, which of the tables it is drawn by; else [`WHOLE`].
    table: u32,
    /// Its table knows its triangles by other shares than they have in the world.
    is_stretched: bool,
}

/// Of parts that are drawn from without a table.
const WHOLE: u32 = u32::MAX;

impl AreaSampler {
    /// Of an object; `None` where its shape draws directions itself, or is not drawn from.
    pub fn new(tree: &Tree, object: u32) -> Option<AreaSampler> {
        let range = tree.parts_of(object);
        let mut all = AreaSampler { first: range.start, pieces: Vec::with_capacity(range.len()), tables: Vec::new() };
        // By the kind: instances share theirs, which is in the space of the mesh.
        let mut tables: Vec<(u32, u32)> = Vec::new();
        let mut sum = 0.0;
        for number in range.clone() {
            let part = &tree.parts[number];
            let there = placement(tree, part);
            let (area, table, is_stretched) = match &tree.kinds[part.kind as usize] {
                Kind::Mesh(mesh) => {
                    let known = tables.iter().find(|(kind, _)| *kind == part.kind);
                    let table = known.map(|(_, table)| *table).unwrap_or_else(|| {
                        let by = if range.len() == 1 { there } else { Affine::IDENTITY };
                        let number = all.tables.len() as u32;
                        all.tables.push(areas(mesh, &by));
                        tables.push((part.kind, number));
                        number
                    });
                    let own = all.tables[table as usize].last().copied().unwrap_or(0.0);
                    match (range.len(), there.similarity()) {
                        (1, _) => (own, table, false),
                        (_, Some(scale)) => (own * scale * scale, table, false),
                        (_, None) => (areas(mesh, &there).last().copied().unwrap_or(0.0), table, true),
                    }
                }
                // Moved and turned it has the area it had; stretched, its places would not be equally likely.
                Kind::Cylinder(cylinder) => {
                    let scale = there.similarity()?;
                    (cylinder.area() * scale * scale, WHOLE, false)
                }
                Kind::Shape(Shape::Rectangle { u, v, .. }) if range.len() > 1 && part.placement == STAYS => {
                    (4.0 * u.cross(*v).length_squared().sqrt(), WHOLE, false)
                }
                Kind::Shape(Shape::Disk { radius2, .. }) if range.len() > 1 && part.placement == STAYS => {
                    (std::f64::consts::PI * radius2, WHOLE, false)
                }
                Kind::Shape(Shape::Sphere { radius, .. }) if range.len() > 1 && part.placement == STAYS => {
                    (4.0 * std::f64::consts::PI * radius * radius, WHOLE, false)
                }
                Kind::Shape(_) | Kind::Patch(_) => return None,
            };
            sum += area;
            all.pieces.push(Piece { sum, table, is_stretched });
        }
        (sum > 0.0 && sum.is_finite()).then_some(all)
    }

    pub fn total(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.sum)
    }

    /// The probability per area with which a place that a ray has met is drawn.
    pub fn density(&self, tree: &Tree, hit: &Hit) -> f64 {
        let even = 1.0 / self.total();
        let at = hit.part as usize - self.first;
        let piece = &self.pieces[at];
        let part = &tree.parts[hit.part as usize];
        let Kind::Mesh(mesh) = &tree.kinds[part.kind as usize] else { return even };
        if !piece.is_stretched {
            return even;
        }
        let there = placement(tree, part);
        let before = if at == 0 { 0.0 } else { self.pieces[at - 1].sum };
        let corners = mesh.corners(hit.primitive).map(Vec3::to_array);
        let share = mesh::area(corners) / self.tables[piece.table as usize].last().copied().unwrap_or(1.0);
        (piece.sum - before) * even * share / mesh::area(corners.map(|corner| there.point(corner)))
    }

    /// A random point in the world.
    pub fn point(&self, tree: &Tree, (a, b): (f64, f64)) -> Vec3 {
        let (at, a) = drawn(self.pieces.len(), |at| self.pieces[at].sum, a);
        let (number, piece) = (self.first + at, &self.pieces[at]);
        let part = &tree.parts[number];
        let own = match &tree.kinds[part.kind as usize] {
            Kind::Mesh(mesh) => {
                let table = &self.tables[piece.table as usize];
                let (primitive, a) = drawn(table.len(), |at| table[at], a);
                let [first, second, third] = mesh.corners(primitive as u32);
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

/// Which of some things is drawn that have these sums of all up to and with each, and what the choice has left of the number, which
/// serves again.
fn drawn(count: usize, sum: impl Fn(usize) -> f64, a: f64) -> (usize, f64) {
    let wanted = a * sum(count - 1);
    let (mut at, mut end) = (0, count - 1);
    while at < end {
        let middle = (at + end) / 2;
        if sum(middle) <= wanted {
            at = middle + 1;
        } else {
            end = middle;
        }
    }
    let before = if at == 0 { 0.0 } else { sum(at - 1) };
    (at, ((wanted - before) / (sum(at) - before)).clamp(0.0, 1.0))
}

/// Areas of the triangles of a mesh where a map puts them, each with all before it.
fn areas(mesh: &TriangleMesh, by: &Affine) -> Vec<f64> {
    let triangles = 0..mesh.source.triangles.len() as u32;
    let mut sum = 0.0;
    let area = |triangle| {
        sum += mesh::area(mesh.corners(triangle).map(|corner| by.point(corner.to_array())));
        sum
    };
    triangles.map(area).collect()
}

/// From the space of a part to the world.
fn placement(tree: &Tree, part: &Part) -> Affine {
    tree.to_object.get(part.placement as usize).and_then(Affine::inverse).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use iridesce_files::Mesh;
    use iridesce_numerics::noise::SplitMix64;

    use super::*;
    use crate::camera::Ray;

    /// Four unequal triangles in a row of boxes along x, so that a place tells of its triangle; stretched, each grows otherwise.
    fn mesh() -> Kind {
        let mut positions = Vec::new();
        for (at, size) in [0.2, 0.5, 0.9, 0.4].into_iter().enumerate() {
            let x = at as f64;
            let [y, z] = if at % 2 == 0 { [size, 0.3 * size] } else { [0.1 * size, size] };
            positions.extend([[x, 0.0, 0.0], [x + size, 0.1 * y, 0.1 * z], [x + 0.1, y, z]]);
        }
        let triangles = (0..4).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let mesh = Mesh {
            positions,
            normals: None,
            uv: None,
            thickness_nm: None,
            triangles,
            is_in_metres: false,
            notes: Vec::new(),
        };
        Kind::Mesh(TriangleMesh::new(Arc::new(mesh)))
    }

    /// Instances along z, one beside the other.
    fn tree(scales: &[[f64; 3]]) -> Tree {
        let back = |(at, scale): (usize, &[f64; 3])| {
            let there = Affine::placed(*scale, [0.0; 3], [0.0, 0.0, 10.0 * at as f64]);
            there.inverse().unwrap()
        };
        let part = |at| Part { object: 0, kind: 0, instance: at, placement: at };
        let parts = (0..scales.len() as u32).map(part).collect();
        Tree::new(parts, vec![mesh()], scales.iter().enumerate().map(back).collect())
    }

    /// Places are drawn as often as their density says, which adds up to 1 over the whole.
    #[test]
    fn places_have_the_density_that_is_told() {
        for scales in
            [vec![[1.0; 3], [2.0; 3]], vec![[1.0; 3], [3.0, 1.0, 0.5], [0.7, 0.7, 2.0]], vec![[1.0, 4.0, 0.2]]]
        {
            let tree = tree(&scales);
            let area = AreaSampler::new(&tree, 0).unwrap();
            let mut shares = Vec::new();
            for number in 0..tree.parts.len() {
                let there = placement(&tree, &tree.parts[number]);
                let Kind::Mesh(mesh) = &tree.kinds[0] else { unreachable!() };
                for primitive in 0..4 {
                    let corners = mesh.corners(primitive).map(|corner| there.point(corner.to_array()));
                    let hit = Hit { part: number as u32, primitive, ..Hit::on(0, Vec3::default(), Vec3::default()) };
                    shares.push(area.density(&tree, &hit) * mesh::area(corners));
                }
            }
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
            let (mut noise, count) = (SplitMix64::new(3), 40_000);
            let mut seen = vec![0.0; shares.len()];
            for _ in 0..count {
                let place = area.point(&tree, (noise.unit(), noise.unit()));
                let number = (place.z / 10.0).round() as usize;
                let own = tree.to_object[number].moved(place);
                seen[4 * number + own.x.floor() as usize] += 1.0 / f64::from(count);
            }
            for (seen, share) in seen.iter().zip(&shares) {
                let deviation = (share * (1.0 - share) / f64::from(count)).sqrt();
                assert!((seen - share).abs() < 5.0 * deviation, "{seen} {share} {scales:?}");
            }
        }
    }

    /// Of a mesh that stands once, and of instances that are scaled alike in every direction, all places are equally likely.
    #[test]
    fn places_of_unstretched_instances_are_even() {
        for scales in [vec![[1.0; 3], [2.0; 3], [0.1; 3]], vec![[1.0, 4.0, 0.2]]] {
            let tree = tree(&scales);
            let area = AreaSampler::new(&tree, 0).unwrap();
            for number in 0..scales.len() as u32 {
                let hit = Hit { part: number, primitive: 2, ..Hit::on(0, Vec3::default(), Vec3::default()) };
                assert_eq!(area.density(&tree, &hit), 1.0 / area.total());
            }
        }
    }

    /// The place and the normal that a ray is told are those of the file's corners, to the last digit.
    #[test]
    fn a_hit_is_closed_by_the_corners_of_its_triangle() {
        let tree =
            Tree::new(vec![Part { object: 0, kind: 0, instance: 0, placement: STAYS }], vec![mesh()], Vec::new());
        let Kind::Mesh(mesh) = &tree.kinds[0] else { unreachable!() };
        let mut met = [0; 4];
        let mut noise = SplitMix64::new(5);
        for round in 0..4000 {
            let [a, b, c] = mesh.corners(round % 4);
            let (second, third) = (0.5 * noise.unit(), 0.5 * noise.unit());
            let origin = Vec3::new(4.0 * noise.unit(), noise.unit(), 2.0 + noise.unit());
            let direction = (a + (b - a) * second + (c - a) * third - origin).normalized();
            let ray = Ray { origin, direction };
            let Some(hit) = tree.nearest(&ray, None, None) else { continue };
            met[hit.primitive as usize] += 1;
            let [a, b, c] = mesh.corners(hit.primitive);
            let [second, third] = mesh.shares(hit.primitive, origin + direction * hit.distance);
            assert_eq!(hit.normal, mesh.normal(hit.primitive));
            assert_eq!(hit.point, a + (b - a) * second + (c - a) * third);
        }
        assert!(met.iter().all(|count| *count > 900), "{met:?}");
    }
}
