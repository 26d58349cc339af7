//! Whether a mesh bounds a body: along every edge as many triangles run one way as the other.

use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};

use iridesce_numerics::noise::mix64;

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
        // Vertices that become one add the balances of their edges up: where each is in balance as it stands, all are.
        if is_balanced(&self.triangles) {
            return None;
        }
        let welded = self.welded();
        let open = unbalanced(&self.triangles, &welded);
        let (triangle, corners, _, _) = edges(&self.triangles, &welded).find(|(_, _, key, _)| open.contains(key))?;
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

/// Whether along every edge as many triangles run one way as the other, vertices being those of the file.
///
/// Every edge has a number of 128 bits as if drawn at random, added where a triangle runs along it one way and taken off where one runs
/// the other: of a mesh in balance nothing is left, of another by chance once in 2^128. So no edge needs to be found again.
fn is_balanced(triangles: &[[u32; 3]]) -> bool {
    let mut left = [0_u64; 2];
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (low, high) = (from.min(to), from.max(to));
            let key = u64::from(low) << 32 | u64::from(high);
            let numbers = [mix64(key ^ 0x9E37_79B9_7F4A_7C15), mix64(mix64(key) ^ 0xD1B5_4A32_D192_ED03)];
            for (left, number) in left.iter_mut().zip(numbers) {
                // An edge from a vertex to itself is none.
                *left = match from.cmp(&to) {
                    Ordering::Less => left.wrapping_add(number),
                    Ordering::Equal => *left,
                    Ordering::Greater => left.wrapping_sub(number),
                };
            }
        }
    }
    left == [0; 2]
}

/// The edges along which not as many triangles run one way as the other; vertices count as `numbers` tells, each below their count.
fn unbalanced(triangles: &[[u32; 3]], numbers: &[u32]) -> HashSet<(u32, u32)> {
    // Edges by their lower end, side by side: a list of a few for most vertices, where a table of all of them would be met at random.
    let mut starts = vec![0_usize; numbers.len() + 1];
    for (_, _, (low, _), _) in edges(triangles, numbers) {
        starts[low as usize + 1] += 1;
    }
    for at in 1..starts.len() {
        starts[at] += starts[at - 1];
    }
    let mut next = starts.clone();
    // The upper end, and which way.
    let mut ends = vec![(0_u32, false); starts[numbers.len()]];
    for (_, _, (low, high), step) in edges(triangles, numbers) {
        ends[next[low as usize]] = (high, step > 0);
        next[low as usize] += 1;
    }
    let mut open = HashSet::new();
    for (low, range) in starts.windows(2).enumerate() {
        let own = &mut ends[range[0]..range[1]];
        own.sort_unstable();
        for same in own.chunk_by(|a, b| a.0 == b.0) {
            let upwards = same.iter().filter(|end| end.1).count();
            if 2 * upwards != same.len() {
                open.insert((low as u32, same[0].0));
            }
        }
    }
    open
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
