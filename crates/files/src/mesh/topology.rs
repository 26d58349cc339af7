//! Whether a mesh bounds a body: along every edge as many triangles run one way as the other.

use std::collections::HashMap;

use super::triangles::Mesh;

/// An edge along which triangles do not meet in pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenEdge {
    /// Its ends.
    pub ends: [[f64; 3]; 2],
    /// A triangle that has it.
    pub triangle: usize,
}

impl Mesh {
    /// The first edge, in the order of the triangles, that keeps the mesh from being closed. Vertices at the same place
    /// count as one, however often a file states them.
    pub fn open_edge(&self) -> Option<OpenEdge> {
        let welded = self.welded();
        let mut balance: HashMap<(u32, u32), i32> = HashMap::with_capacity(3 * self.triangles.len() / 2);
        for (_, _, key, step) in edges(&self.triangles, &welded) {
            *balance.entry(key).or_insert(0) += step;
        }
        let (triangle, corners, _, _) = edges(&self.triangles, &welded).find(|(_, _, key, _)| balance[key] != 0)?;
        Some(OpenEdge { ends: corners.map(|corner| self.positions[corner as usize]), triangle })
    }

    /// A number for each vertex, the same for vertices at the same place.
    fn welded(&self) -> Vec<u32> {
        let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(self.positions.len());
        let number = |position: &[f64; 3]| {
            let next = places.len() as u32;
            // The sum makes 0.0 of -0.0.
            *places.entry(position.map(|c| (c + 0.0).to_bits())).or_insert(next)
        };
        self.positions.iter().map(number).collect()
    }
}

/// Triangle, ends, the edge whichever way it runs, and the way it runs.
fn edges<'a>(
    triangles: &'a [[u32; 3]],
    welded: &'a [u32],
) -> impl Iterator<Item = (usize, [u32; 2], (u32, u32), i32)> + 'a {
    triangles.iter().enumerate().flat_map(move |(triangle, corners)| {
        (0..3).filter_map(move |k| {
            let ends = [corners[k], corners[(k + 1) % 3]];
            let [a, b] = ends.map(|corner| welded[corner as usize]);
            (a != b).then_some((triangle, ends, (a.min(b), a.max(b)), if a < b { 1 } else { -1 }))
        })
    })
}
