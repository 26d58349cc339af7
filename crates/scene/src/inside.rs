//! On which side of a closed mesh a ball lies.

use std::f64::consts::TAU;

use iridesce_files::Mesh;
use iridesce_numerics::vector::{along, cross, difference, dot, length};

/// Where a ball lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// All of it inside.
    Inside,
    /// All of it outside.
    Outside,
    /// Neither, or it cannot be told.
    Unknown,
}

impl Side {
    /// What is known.
    pub fn of(is_inside: bool, is_outside: bool) -> Side {
        match (is_inside, is_outside) {
            (true, _) => Side::Inside,
            (_, true) => Side::Outside,
            _ => Side::Unknown,
        }
    }
}

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
pub struct Box3 {
    low: [f64; 3],
    high: [f64; 3],
}

impl Box3 {
    /// The least box around points.
    pub fn around(points: &[[f64; 3]]) -> Box3 {
        let mut all = Box3 { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for point in points {
            for ((low, high), &at) in all.low.iter_mut().zip(&mut all.high).zip(point) {
                // (`f64::min` minds NaN, of which a mesh has none, and takes longer.)
                *low = if at < *low { at } else { *low };
                *high = if at > *high { at } else { *high };
            }
        }
        all
    }

    /// How far a point lies outside; 0 within.
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        length(std::array::from_fn(|i| (self.low[i] - point[i]).max(point[i] - self.high[i]).max(0.0)))
    }

    /// Middle and radius of the ball around it.
    pub fn ball(&self) -> ([f64; 3], f64) {
        let middle = std::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]));
        (middle, length(difference(self.high, middle)))
    }
}

/// On which side of a mesh, if it is closed, a ball lies.
///
/// The solid angles of the triangles, as seen from its middle and with their signs, add up to a whole number of spheres: how often the
/// mesh winds around. Where that is not 0, every way out meets the mesh, however it crosses itself.
pub fn side_of_mesh(mesh: &Mesh, middle: [f64; 3], radius: f64) -> Side {
    let corners = |corners: &[u32; 3]| corners.map(|corner| difference(mesh.positions[corner as usize], middle));
    let turns = mesh.triangles.iter().map(|t| half_solid_angle(corners(t))).sum::<f64>() / TAU;
    // Of an open mesh they need not; of a closed one, rounding takes off far less.
    if turns.is_nan() || (turns - turns.round()).abs() > 0.1 {
        return Side::Unknown;
    }
    // A point on the very face, too, is on neither side.
    if mesh.triangles.iter().any(|t| distance_to_origin(corners(t)) <= radius) {
        return Side::Unknown;
    }
    if turns.round() == 0.0 { Side::Outside } else { Side::Inside }
}

/// Half the solid angle of a triangle as seen from the origin, from -pi to pi (A. Van Oosterom, J. Strackee, IEEE Transactions on
/// Biomedical Engineering 30, 125, 1983).
fn half_solid_angle([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(length);
    dot(a, cross(b, c)).atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
}

/// How far a triangle is from the origin.
fn distance_to_origin([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let normal = cross(difference(b, a), difference(c, a));
    let edges = [(a, b), (b, c), (c, a)];
    // The foot of the plumb line lies within where it is on the inner side of all edges.
    if edges.iter().all(|&(from, to)| dot(cross(difference(to, from), from), normal) <= 0.0) {
        return dot(a, normal).abs() / length(normal);
    }
    edges.iter().map(|&(from, to)| distance_to_edge(from, to)).fold(f64::INFINITY, f64::min)
}

fn distance_to_edge(from: [f64; 3], to: [f64; 3]) -> f64 {
    let way = difference(to, from);
    let share = (-dot(from, way) / dot(way, way)).clamp(0.0, 1.0);
    // From an end to itself: that end.
    length(along(from, way, if share.is_nan() { 0.0 } else { share }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube from -1 to 1, its faces outwards.
    fn cube() -> Mesh {
        let positions = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
        let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    #[test]
    fn a_ball_is_inside_outside_or_neither() {
        let mesh = cube();
        assert_eq!(mesh.open_edge(), None);
        for (middle, radius, side) in [
            ([0.0; 3], 0.0, Side::Inside),
            ([0.9, -0.9, 0.9], 0.0, Side::Inside),
            ([0.9, -0.9, 0.9], 0.099, Side::Inside),
            ([0.9, -0.9, 0.9], 0.101, Side::Unknown),
            ([0.0; 3], 0.999, Side::Inside),
            ([0.0; 3], 1.001, Side::Unknown),
            ([1.1, 0.3, 0.2], 0.0, Side::Outside),
            ([1.1, 0.3, 0.2], 0.099, Side::Outside),
            ([1.1, 0.3, 0.2], 0.101, Side::Unknown),
            // Beside an edge and a corner, of which the planes of the faces are nearer.
            ([1.1, 1.1, 0.0], 0.141, Side::Outside),
            ([1.1, 1.1, 0.0], 0.142, Side::Unknown),
            ([1.1, 1.1, 1.1], 0.173, Side::Outside),
            ([1.1, 1.1, 1.1], 0.174, Side::Unknown),
            // Nowhere: moved beyond all numbers.
            ([f64::NAN, 0.0, 0.0], 0.0, Side::Unknown),
            // On a face, an edge, a corner.
            ([1.0, 0.3, 0.2], 0.0, Side::Unknown),
            ([1.0, 1.0, 0.2], 0.0, Side::Unknown),
            ([1.0, 1.0, 1.0], 0.0, Side::Unknown),
        ] {
            assert_eq!(side_of_mesh(&mesh, middle, radius), side, "{middle:?}, {radius}");
        }
    }

    #[test]
    fn which_way_the_faces_look_does_not_matter() {
        let mut mesh = cube();
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert_eq!(side_of_mesh(&mesh, [0.1, 0.2, 0.3], 0.0), Side::Inside);
        assert_eq!(side_of_mesh(&mesh, [0.1, 0.2, 1.3], 0.0), Side::Outside);
    }

    #[test]
    fn a_box_knows_its_distance_and_its_ball() {
        let around = Box3::around(&cube().positions);
        assert_eq!([[0.0; 3], [4.0, 0.0, 0.0], [4.0, 5.0, 0.0]].map(|p| around.distance(p)), [0.0, 3.0, 5.0]);
        assert_eq!(around.ball(), ([0.0; 3], 3.0_f64.sqrt()));
    }
}
