//! Where mirrors and lenses are known to throw the light of a lamp: triangles of light on the surfaces that catch it.
//!
//! Each is the landing of three neighbouring rays that left a lamp and went the same way; from a place within it, the light
//! comes from about where these rays left the last mirror or lens.

use iridesce_numerics::Vec3;

use super::chooser::LightId;
use crate::chain::Chain;

/// By how much of itself a triangle reaches beyond its sides: neighbours overlap a little, and the edges of a caustic lie between
/// rays.
const MARGIN: f64 = 0.1;

/// How far a place may lie off a triangle, of its longest side.
const BULGE: f64 = 0.05;

/// Least area of a triangle, of the square of its longest side, whose inside is told from its outside.
const LEAST_AREA: f64 = 1e-6;

/// Triangles of a leaf.
const LEAF: usize = 4;

/// Where a ray from a lamp has landed.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    pub point: Vec3,
    /// Where it left the last mirror or lens.
    pub left: Vec3,
}

/// Three neighbouring rays of one lamp that went the same way.
#[derive(Debug, Clone, Copy)]
pub struct Seed {
    pub light: LightId,
    /// What a path does that comes to the lamp from there.
    pub chain: Chain,
    pub corners: [u32; 3],
    /// About the Y of the irradiance that they make on what faces them.
    pub irradiance: f32,
}

/// What is known of a place.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub light: LightId,
    pub chain: Chain,
    pub irradiance: f64,
    corners: [u32; 3],
    /// How near the place lies to each corner.
    shares: [f64; 3],
    /// The triangle is seen from its back: beyond a fold of the caustic the same chain leads to another place of the lamp.
    pub is_folded: bool,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    min: [f64; 3],
    max: [f64; 3],
    /// First seed of a leaf, or the second child; the first child comes next.
    at: u32,
    /// Of a leaf.
    count: u32,
}

/// Seeds found by place.
struct Boxes {
    seeds: Vec<Seed>,
    /// The box of each, both ends, side by side: most seeds of a leaf do not hold a place, and their corners lie apart in memory.
    own: Vec<[[f32; 3]; 2]>,
    nodes: Vec<Node>,
}

/// The seeds of a scene.
pub struct Seeds {
    /// Those of chains that carry much of their lamp's light, and the others.
    strengths: [Boxes; 2],
    landings: Vec<Landing>,
    faint: Vec<(LightId, Chain)>,
    /// Lights that have any.
    lights: Vec<LightId>,
    /// Some medium of the scene has an index that varies over the spectrum.
    pub disperses: bool,
}

/// How much of its lamp's light a chain carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strength {
    Bright,
    Faint,
}

impl Seeds {
    /// `None` without any. `faint`: chains that carry little.
    pub fn new(
        seeds: Vec<Seed>,
        landings: Vec<Landing>,
        faint: Vec<(LightId, Chain)>,
        disperses: bool,
    ) -> Option<Seeds> {
        if seeds.is_empty() {
            return None;
        }
        let mut lights: Vec<LightId> = Vec::new();
        for seed in &seeds {
            if !lights.contains(&seed.light) {
                lights.push(seed.light);
            }
        }
        let (dim, bright): (Vec<Seed>, Vec<Seed>) =
            seeds.into_iter().partition(|seed| faint.contains(&(seed.light, seed.chain)));
        let strengths = [Boxes::new(bright, &landings), Boxes::new(dim, &landings)];
        Some(Seeds { strengths, landings, faint, lights, disperses })
    }

    /// Whether the caustics of a light are known.
    #[inline(always)]
    pub fn has(&self, light: LightId) -> bool {
        self.lights.contains(&light)
    }

    /// Of a chain to a light.
    pub fn strength(&self, light: LightId, chain: Chain) -> Strength {
        if self.faint.contains(&(light, chain)) { Strength::Faint } else { Strength::Bright }
    }

    /// What is known of a place, of all lights, in an order that depends on the seeds alone.
    pub fn find(&self, place: Vec3, strength: Strength, found: &mut Vec<Candidate>) {
        found.clear();
        let Boxes { seeds, own, nodes } = &self.strengths[usize::from(strength == Strength::Faint)];
        if nodes.is_empty() {
            return;
        }
        let point = place.to_array();
        let mut waiting = [0_u32; 64];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let at = waiting[count] as usize;
            let node = &nodes[at];
            if (0..3).any(|i| point[i] < node.min[i] || point[i] > node.max[i]) {
                continue;
            }
            if node.count == 0 {
                (waiting[count], waiting[count + 1]) = (node.at, at as u32 + 1);
                count += 2;
                continue;
            }
            let leaf = node.at as usize..(node.at + node.count) as usize;
            for (seed, [min, max]) in seeds[leaf.clone()].iter().zip(&own[leaf]) {
                if (0..3).all(|i| point[i] >= f64::from(min[i]) && point[i] <= f64::from(max[i])) {
                    found.extend(self.within(seed, place));
                }
            }
        }
    }

    /// What a seed tells of a place within it.
    #[inline(always)]
    fn within(&self, seed: &Seed, place: Vec3) -> Option<Candidate> {
        let corners = seed.corners.map(|corner| &self.landings[corner as usize]);
        let [a, b, c] = corners.map(|corner| corner.point);
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let (area2, size2) = (normal.length_squared(), u.length_squared().max(v.length_squared()));
        let mut shares = [1.0 / 3.0; 3];
        let light = (a - corners[0].left).normalized();
        let slope = light.dot(normal);
        if area2 > LEAST_AREA * LEAST_AREA * size2 * size2 {
            // Along the light onto the plane of the triangle, then by areas.
            let lift = (place - a).dot(normal);
            if slope == 0.0 || (lift / slope) * (lift / slope) > BULGE * BULGE * size2 {
                return None;
            }
            let from_a = place - light * (lift / slope) - a;
            let second = from_a.cross(v).dot(normal) / area2;
            let third = u.cross(from_a).dot(normal) / area2;
            shares = [1.0 - second - third, second, third];
            if shares.iter().any(|share| *share < -MARGIN) {
                return None;
            }
        }
        Some(Candidate {
            light: seed.light,
            chain: seed.chain,
            irradiance: f64::from(seed.irradiance),
            corners: seed.corners,
            shares,
            is_folded: slope < 0.0,
        })
    }

    /// Where the light of what is known of a place comes from, about, and the square of the angle over which it does within the triangle.
    /// (Most of it is never asked: this is not worked out before.)
    #[inline(always)]
    pub fn seen(&self, candidate: &Candidate, place: Vec3) -> Option<(Vec3, f64)> {
        let left = candidate.corners.map(|corner| self.landings[corner as usize].left);
        let shares = candidate.shares;
        let away = left[0] * shares[0] + left[1] * shares[1] + left[2] * shares[2] - place;
        let side = |i: usize, j: usize| (left[i] - left[j]).length_squared();
        let spread2 = side(0, 1).max(side(1, 2)).max(side(2, 0)) / away.length_squared();
        (away.length_squared() > 0.0).then(|| (away.normalized(), spread2))
    }
}

impl Boxes {
    fn new(seeds: Vec<Seed>, landings: &[Landing]) -> Boxes {
        let mut boxes: Vec<Boxed> = seeds
            .into_iter()
            .map(|seed| {
                let (min, max) = around(landings, &seed);
                Boxed { min, max, seed }
            })
            .collect();
        let mut nodes = Vec::new();
        if !boxes.is_empty() {
            build(&mut boxes, 0, &mut nodes);
        }
        let own = boxes
            .iter()
            .map(|own| [own.min.map(|end| (end as f32).next_down()), own.max.map(|end| (end as f32).next_up())])
            .collect();
        Boxes { seeds: boxes.into_iter().map(|own| own.seed).collect(), own, nodes }
    }
}

/// A seed in its box.
struct Boxed {
    min: [f64; 3],
    max: [f64; 3],
    seed: Seed,
}

/// The corners of the box of a seed, a little larger than its triangle.
fn around(landings: &[Landing], seed: &Seed) -> ([f64; 3], [f64; 3]) {
    let points = seed.corners.map(|corner| landings[corner as usize].point.to_array());
    let side = |i: usize, j: usize| (0..3).map(|k| (points[i][k] - points[j][k]).powi(2)).sum::<f64>();
    // What catches the light may bulge between the corners.
    let bulge = BULGE * side(0, 1).max(side(1, 2)).max(side(2, 0)).sqrt();
    let least: [f64; 3] =
        std::array::from_fn(|k| points.iter().fold(f64::INFINITY, |least, point| least.min(point[k])));
    let most: [f64; 3] =
        std::array::from_fn(|k| points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(point[k])));
    let slack = |k: usize| 2.0 * MARGIN * (most[k] - least[k]) + bulge;
    (std::array::from_fn(|k| least[k] - slack(k)), std::array::from_fn(|k| most[k] + slack(k)))
}

/// Nodes over boxes, which are put in the order of the leaves: halves along the longest side of their middles.
fn build(boxes: &mut [Boxed], first: usize, nodes: &mut Vec<Node>) {
    let fold =
        |start: f64, pick: &dyn Fn(&Boxed) -> f64, join: fn(f64, f64) -> f64| boxes.iter().map(pick).fold(start, join);
    let min: [f64; 3] = std::array::from_fn(|k| fold(f64::INFINITY, &|own| own.min[k], f64::min));
    let max: [f64; 3] = std::array::from_fn(|k| fold(f64::NEG_INFINITY, &|own| own.max[k], f64::max));
    let own = nodes.len();
    nodes.push(Node { min, max, at: first as u32, count: boxes.len() as u32 });
    if boxes.len() <= LEAF {
        return;
    }
    let middle = |own: &Boxed, k: usize| own.min[k] + own.max[k];
    let spread: [f64; 3] = std::array::from_fn(|k| {
        fold(f64::NEG_INFINITY, &|own| middle(own, k), f64::max) - fold(f64::INFINITY, &|own| middle(own, k), f64::min)
    });
    let axis = (0..3).fold(0, |best, k| if spread[k] > spread[best] { k } else { best });
    let half = boxes.len() / 2;
    boxes.select_nth_unstable_by(half, |a, b| middle(a, axis).total_cmp(&middle(b, axis)));
    let (low, high) = boxes.split_at_mut(half);
    build(low, first, nodes);
    nodes[own].count = 0;
    nodes[own].at = nodes.len() as u32;
    build(high, first + half, nodes);
}
