//! Triangles in a hierarchy of their own, in the space of their file.
//!
//! Boxes are f32, triangles f64, four side by side: the nearest crossing is exact enough to be the final point, and
//! neighbours overlap by less than rounding shows, so that no ray slips between them.
//! T. Moeller, B. Trumbore, "Fast, minimum storage ray-triangle intersection", J. Graphics Tools 2 (1997).

use std::ops::{Add, Div, Mul, Sub};
use std::sync::Arc;

use fearless_simd::{Simd, f64x4, prelude::*};
use iridesce_files::Mesh;
use iridesce_numerics::Vec3;
use iridesce_numerics::vector::{cross, difference, length};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::build::{LEAF, PARALLEL};
use super::hierarchy::{Hierarchy, Visit, Walk};
use crate::camera::Ray;

/// By how much triangles reach beyond their edges, in their own coordinates: some hundred times the rounding of a crossing.
pub(super) const OVERLAP: f64 = 1e-13;

/// Four triangles: a corner and the edges from it, by axis.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) corner: [[f64; 4]; 3],
    pub(super) first: [[f64; 4]; 3],
    pub(super) second: [[f64; 4]; 3],
    pub(super) triangles: [u32; 4],
}

/// A mesh that rays meet.
#[derive(Debug, Clone)]
pub struct TriangleMesh {
    pub source: Arc<Mesh>,
    pub(super) hierarchy: Hierarchy,
    pub(super) blocks: Vec<Block>,
    /// Largest coordinate.
    reach: f64,
}

/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Met {
    pub triangle: u32,
    pub distance: f64,
    /// Where the triangle stands among the leaves of the hierarchy.
    pub seat: u32,
}

/// A triangle that a ray starts on, and how far rounding may have put the start from it.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    pub triangle: u32,
    pub slack: f64,
}

impl TriangleMesh {
    pub fn new(source: Arc<Mesh>) -> TriangleMesh {
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| source.positions[corner as usize]);
        let mut leaves: Vec<[u32; LEAF]> = Vec::new();
        let box_of = |triangle: usize| Bounds::of(corners(&source.triangles[triangle]));
        let hierarchy = Hierarchy::new(source.triangles.len(), box_of, |numbers| {
            let mut triangles = [u32::MAX; LEAF];
            triangles[..numbers.len()].copy_from_slice(numbers);
            leaves.push(triangles);
            (leaves.len() - 1, 1)
        });
        let block = |triangles: &[u32; LEAF]| {
            let mut block =
                Block { corner: [[0.0; 4]; 3], first: [[0.0; 4]; 3], second: [[0.0; 4]; 3], triangles: *triangles };
            for (lane, &number) in triangles.iter().enumerate().filter(|(_, number)| **number != u32::MAX) {
                let [a, b, c] = corners(&source.triangles[number as usize]);
                for axis in 0..3 {
                    block.corner[axis][lane] = a[axis];
                    block.first[axis][lane] = b[axis] - a[axis];
                    block.second[axis][lane] = c[axis] - a[axis];
                }
            }
            block
        };
        let blocks = leaves.par_iter().with_min_len(PARALLEL).map(block).collect();
        let reach = source.positions.iter().flatten().fold(0.0_f64, |most, c| most.max(c.abs()));
        TriangleMesh { source, hierarchy, blocks, reach }
    }

    /// The box around it.
    pub fn bounds(&self) -> &Bounds {
        self.hierarchy.bounds()
    }

    /// How far rounding may put a point from its triangle, where it came here from coordinates of a size.
    pub fn slack(&self, size: f64) -> f64 {
        16.0 * f64::EPSILON * (size + self.reach)
    }

    /// A search for the nearest crossing; of equally near ones that of the first triangle.
    #[inline(always)]
    pub fn search(&self, ray: Ray, start: Option<Start>) -> Search<'_> {
        Search { mesh: self, ray, start, best: None }
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.source.triangles[triangle as usize].map(|corner| self.source.positions[corner as usize].into())
    }

    /// The unit normal of a triangle.
    pub fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        normal(b - a, c - a)
    }

    /// The shares of the second and the third corner at a point of a triangle.
    pub fn shares(&self, triangle: u32, point: Vec3) -> [f64; 2] {
        let [a, b, c] = self.corners(triangle);
        shares(b - a, c - a, point - a)
    }

    /// A point of a ray put onto the triangle of a seat, which the ray meets there, and its unit normal: from what the search has just
    /// read, not from the corners of the file, which lie far away in memory.
    #[inline(always)]
    pub fn close(&self, seat: u32, point: Vec3) -> (Vec3, Vec3) {
        let (block, lane) = (&self.blocks[seat as usize / LEAF], seat as usize % LEAF);
        let at = |rows: &[[f64; 4]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
        let (corner, first, second) = (at(&block.corner), at(&block.first), at(&block.second));
        let [share, other] = shares(first, second, point - corner);
        (corner + first * share + second * other, normal(first, second))
    }
}

/// The unit normal of a triangle of which these are two edges.
#[inline(always)]
fn normal(first: Vec3, second: Vec3) -> Vec3 {
    // By the longest edge's size: squares of squares of small lengths would be zero.
    let size = first.length_squared().max(second.length_squared()).sqrt();
    (first * (1.0 / size)).cross(second * (1.0 / size)).normalized()
}

/// The shares of the ends of two edges at a place of their triangle, to which a way leads from the corner of both.
#[inline(always)]
fn shares(first: Vec3, second: Vec3, way: Vec3) -> [f64; 2] {
    let n = first.cross(second);
    let per = 1.0 / n.length_squared();
    let (b, c) = (way.cross(second).dot(n) * per, first.cross(way).dot(n) * per);
    let (b, c) = (b.clamp(0.0, 1.0), c.clamp(0.0, 1.0));
    let sum = (b + c).max(1.0);
    [b / sum, c / sum]
}

/// A ray that looks for its nearest crossing with a mesh.
pub struct Search<'a> {
    mesh: &'a TriangleMesh,
    pub(super) ray: Ray,
    start: Option<Start>,
    pub best: Option<Met>,
}

impl Search<'_> {
    /// Looks through the whole mesh, as far as `limit`.
    #[inline(always)]
    pub fn run<S: Simd>(&mut self, simd: S, limit: f64) {
        let (mesh, ray) = (self.mesh, self.ray);
        mesh.hierarchy.walk(simd, &ray, limit, self);
    }

    /// Sends the ray on a way through the mesh that goes on by [`Search::look`] and [`Search::choose`]; false where it meets nothing.
    #[inline(always)]
    pub fn begin(&self, walk: &mut Walk, limit: f64) -> bool {
        walk.begin(&self.mesh.hierarchy, &self.ray, limit)
    }

    /// [`Walk::touch`] of what is next in the mesh.
    #[inline(always)]
    pub fn touch(&self, walk: &Walk) -> u64 {
        walk.touch(&self.mesh.hierarchy, |block| {
            let Block { corner, first, second, triangles } = &self.mesh.blocks[block];
            let (a, b, c) = (corner[0][0].to_bits(), corner[2][0].to_bits(), first[1][0].to_bits());
            let (d, e) = (second[0][0].to_bits(), second[2][0].to_bits());
            a ^ b ^ c ^ d ^ e ^ u64::from(triangles[LEAF - 1])
        })
    }

    /// [`Walk::look`], the leaf met if it is one.
    #[inline(always)]
    pub fn look<S: Simd>(&mut self, simd: S, walk: &mut Walk) {
        if let Some((first, count)) = walk.look(simd, &self.mesh.hierarchy) {
            let closer = self.leaf(simd, first, count, walk.limit());
            walk.shorten(closer);
        }
    }

    /// [`Walk::choose`].
    #[inline(always)]
    pub fn choose(&self, walk: &mut Walk) -> bool {
        walk.choose(&self.mesh.hierarchy)
    }

    /// Whether a crossing is where the ray starts: on the triangle that it leaves, or on a neighbour of which it starts no
    /// farther than rounding.
    fn is_start(&self, block: &Block, lane: usize, volume: f64) -> bool {
        let Some(start) = self.start else { return false };
        if block.triangles[lane] == start.triangle {
            return true;
        }
        let edge = |edges: &[[f64; 4]; 3]| [edges[0][lane], edges[1][lane], edges[2][lane]];
        volume.abs() <= start.slack * length(cross(edge(&block.first), edge(&block.second)))
    }
}

impl Visit for Search<'_> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, first: usize, _: usize, mut limit: f64) -> f64 {
        let block = &self.mesh.blocks[first];
        let load = |v: &[f64; 4]| f64x4::from_slice(simd, v);
        let splat = |v: f64| f64x4::splat(simd, v);
        let (o, d) = (self.ray.origin, self.ray.direction);
        let corner = [load(&block.corner[0]), load(&block.corner[1]), load(&block.corner[2])];
        let (b, c, volume, per) = crossing(
            [splat(o.x), splat(o.y), splat(o.z)],
            [splat(d.x), splat(d.y), splat(d.z)],
            corner,
            [load(&block.first[0]), load(&block.first[1]), load(&block.first[2])],
            [load(&block.second[0]), load(&block.second[1]), load(&block.second[2])],
            splat(1.0),
        );
        let distance = volume * per;
        let least = splat(-OVERLAP);
        // False for the no numbers of a triangle that is not there, or that a ray lies in.
        let met = b.simd_ge(least)
            & c.simd_ge(least)
            & (b + c).simd_le(splat(1.0 + OVERLAP))
            & distance.simd_gt(splat(0.0))
            & distance.simd_le(splat(limit));
        let mut met = simd.to_bitmask_mask64x4(met);
        if met == 0 {
            return limit;
        }
        let (distances, volumes): ([f64; 4], [f64; 4]) = (distance.into(), volume.into());
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let (distance, triangle) = (distances[lane], block.triangles[lane]);
            if is_nearer(&self.best, limit, distance, triangle) && !self.is_start(block, lane, volumes[lane]) {
                self.best = Some(Met { triangle, distance, seat: (first * LEAF + lane) as u32 });
                limit = distance;
            }
        }
        limit
    }
}

/// Rays against the planes of triangles, side by side: the shares of the second and the third corner there, six times the volume between
/// origin and triangle, and what makes a distance of it.
#[inline(always)]
pub(super) fn crossing<V>(
    [o_x, o_y, o_z]: [V; 3],
    [d_x, d_y, d_z]: [V; 3],
    corner: [V; 3],
    [e_x, e_y, e_z]: [V; 3],
    [f_x, f_y, f_z]: [V; 3],
    one: V,
) -> (V, V, V, V)
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V> + Div<Output = V>,
{
    let (t_x, t_y, t_z) = (o_x - corner[0], o_y - corner[1], o_z - corner[2]);
    let (p_x, p_y, p_z) = (d_y * f_z - d_z * f_y, d_z * f_x - d_x * f_z, d_x * f_y - d_y * f_x);
    let per = one / (e_x * p_x + e_y * p_y + e_z * p_z);
    let b = (t_x * p_x + t_y * p_y + t_z * p_z) * per;
    let (q_x, q_y, q_z) = (t_y * e_z - t_z * e_y, t_z * e_x - t_x * e_z, t_x * e_y - t_y * e_x);
    let c = (d_x * q_x + d_y * q_y + d_z * q_z) * per;
    (b, c, f_x * q_x + f_y * q_y + f_z * q_z, per)
}

/// Whether a crossing comes before all others so far, which reach to a limit; of equally near ones the first triangle does.
#[inline(always)]
pub(super) fn is_nearer(best: &Option<Met>, limit: f64, distance: f64, triangle: u32) -> bool {
    distance < limit || best.is_some_and(|best| best.distance == distance && triangle < best.triangle)
}

/// The area of a triangle.
pub fn area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    0.5 * length(cross(difference(b, a), difference(c, a)))
}
