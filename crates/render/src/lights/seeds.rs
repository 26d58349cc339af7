//! Where mirrors and lenses are known to throw the light of a lamp: triangles of light on the surfaces that catch it.
//!
//! Each is the landing of three neighbouring rays that left a lamp and went the same way; from a place within it, the light
//! comes from about where these rays left the last mirror or lens.

use iridesce_numerics::Vec3;

use super::chooser::LightId;
use crate::chain::Chain;
use crate::geometry::{Box32, Item, MOST_LEVELS, Tree};

/// By how much of itself a triangle reaches beyond its sides: neighbours overlap a little, and the edges of a caustic lie between
/// rays.
const MARGIN: f64 = 0.1;

/// How far a place may lie off a triangle, of its longest side.
const BULGE: f64 = 0.05;

/// Least area of a triangle, of the square of its longest side, whose inside is told from its outside.
const LEAST_AREA: f64 = 1e-6;

/// Nodes that a search has yet to look at: one a level, and two of the lowest.
const MOST_WAITING: usize = MOST_LEVELS + 2;

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
    /// That is little, and is looked for now and then where no bright one of its chain is.
    pub is_faint: bool,
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

/// Boxes are in single precision, rounded outwards; a place within one in double precision is within it when rounded, too.
#[derive(Debug, Clone, Copy)]
struct Node {
    min: [f32; 3],
    max: [f32; 3],
    /// First seed of a leaf, or the second child; the first child comes next.
    at: u32,
    /// Of a leaf.
    count: u32,
}

/// Where a place lies in a triangle: all that does not depend on the place is worked out once.
#[derive(Debug, Clone, Copy)]
struct Chart {
    /// The first corner.
    from: Vec3,
    /// Shares of the second and third corner where the light through a place meets the plane of the triangle, and how far
    /// that is along the light, each per unit of the way from the first corner. All 0 where a triangle has no inside.
    second: Vec3,
    third: Vec3,
    lift: Vec3,
    /// The farthest that a place may lie off, in both directions; below 0 of a triangle whose plane the light lies in.
    farthest: f64,
    /// The shares of a triangle without an inside.
    even: f64,
    is_folded: bool,
}

/// Seeds found by place.
struct Boxes {
    seeds: Vec<Seed>,
    /// The box of each, both ends, side by side: most seeds of a leaf do not hold a place, and their corners lie apart in memory.
    own: Vec<[[f32; 3]; 2]>,
    /// Where a place lies in each.
    charts: Vec<Chart>,
    nodes: Vec<Node>,
}

/// The seeds of a scene.
pub struct Seeds {
    bright: Boxes,
    /// Faint ones of chains that are bright elsewhere.
    beside: Boxes,
    /// Those of chains that are bright nowhere.
    faint: Boxes,
    landings: Vec<Landing>,
    /// Lights that have any.
    pub lights: Vec<LightId>,
    /// Some medium of the scene has an index that varies over the spectrum.
    pub disperses: bool,
}

/// How much light comes to a place over a chain: much where a bright seed of it holds the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strength {
    Bright,
    Faint,
}

impl Seeds {
    /// `None` without any.
    pub fn new(seeds: Vec<Seed>, landings: Vec<Landing>, disperses: bool) -> Option<Seeds> {
        if seeds.is_empty() {
            return None;
        }
        let mut lights: Vec<LightId> = Vec::new();
        for seed in &seeds {
            if !lights.contains(&seed.light) {
                lights.push(seed.light);
            }
        }
        let (faint, bright): (Vec<Seed>, Vec<Seed>) = seeds.into_iter().partition(|seed| seed.is_faint);
        let mut chains: Vec<(LightId, Chain)> = bright.iter().map(|seed| (seed.light, seed.chain)).collect();
        chains.sort_unstable();
        chains.dedup();
        let is_bright = |seed: &Seed| chains.binary_search(&(seed.light, seed.chain)).is_ok();
        let (beside, faint) = faint.into_iter().partition(is_bright);
        let [bright, beside, faint] = [bright, beside, faint].map(|seeds| Boxes::new(seeds, &landings));
        Some(Seeds { bright, beside, faint, landings, lights, disperses })
    }

    /// Whether the caustics of a light are known.
    #[inline(always)]
    pub fn has(&self, light: LightId) -> bool {
        self.lights.contains(&light)
    }

    /// What is known of a place, of all lights, in an order that depends on the seeds alone: of chains of one strength there.
    pub fn find(&self, place: Vec3, strength: Strength, found: &mut Vec<Candidate>) {
        found.clear();
        let same = |a: &Candidate, b: &Candidate| a.light == b.light && a.chain == b.chain;
        match strength {
            Strength::Bright => {
                self.bright.find(place, found);
                let bright = found.len();
                if bright > 0 {
                    // All directions of a chain are sampled by one technique.
                    self.beside.find(place, found);
                    let mut kept = bright;
                    for i in bright..found.len() {
                        if found[..bright].iter().any(|bright| same(bright, &found[i])) {
                            found[kept] = found[i];
                            kept += 1;
                        }
                    }
                    found.truncate(kept);
                }
            }
            Strength::Faint => {
                self.beside.find(place, found);
                let beside = found.len();
                if beside > 0 {
                    self.bright.find(place, found);
                    let mut kept = 0;
                    for i in 0..beside {
                        if !found[beside..].iter().any(|bright| same(bright, &found[i])) {
                            found[kept] = found[i];
                            kept += 1;
                        }
                    }
                    found.truncate(kept);
                }
                self.faint.find(place, found);
            }
        }
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

impl Chart {
    fn new(seed: &Seed, landings: &[Landing]) -> Chart {
        let corners = seed.corners.map(|corner| &landings[corner as usize]);
        let [a, b, c] = corners.map(|corner| corner.point);
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let (area2, size2) = (normal.length_squared(), u.length_squared().max(v.length_squared()));
        let light = (a - corners[0].left).normalized();
        let slope = light.dot(normal);
        let zero = Vec3::new(0.0, 0.0, 0.0);
        let mut chart = Chart {
            from: a,
            second: zero,
            third: zero,
            lift: zero,
            farthest: f64::INFINITY,
            even: 1.0 / 3.0,
            is_folded: slope < 0.0,
        };
        if area2 > LEAST_AREA * LEAST_AREA * size2 * size2 {
            chart.even = 0.0;
            // Along the light onto the plane of the triangle, then by areas. A plane that the light lies in is met nowhere.
            (chart.lift, chart.farthest) =
                if slope == 0.0 { (zero, -1.0) } else { (normal * (1.0 / slope), BULGE * size2.sqrt()) };
            // (way - light (way . lift)) . across = way . (across - lift (light . across))
            let per_way = |across: Vec3| across - chart.lift * light.dot(across);
            (chart.second, chart.third) =
                (per_way(v.cross(normal) * (1.0 / area2)), per_way(normal.cross(u) * (1.0 / area2)));
        }
        chart
    }

    /// What a seed tells of a place within it.
    #[inline(always)]
    fn within(&self, seed: &Seed, place: Vec3) -> Option<Candidate> {
        let way = place - self.from;
        let (second, third) = (way.dot(self.second) + self.even, way.dot(self.third) + self.even);
        let shares = [1.0 - second - third, second, third];
        let is_within = way.dot(self.lift).abs() <= self.farthest && shares.iter().all(|share| *share >= -MARGIN);
        is_within.then(|| Candidate {
            light: seed.light,
            chain: seed.chain,
            irradiance: f64::from(seed.irradiance),
            corners: seed.corners,
            shares,
            is_folded: self.is_folded,
        })
    }
}

impl Boxes {
    fn new(seeds: Vec<Seed>, landings: &[Landing]) -> Boxes {
        let around: Vec<[[f32; 3]; 2]> = seeds.iter().map(|seed| around(landings, seed)).collect();
        let mut items: Vec<Item> =
            (0_u32..).zip(&around).map(|(number, [min, max])| Item::new(*min, *max, number)).collect();
        let mut nodes = Vec::new();
        // Large triangles and small ones lie over each other: halves by their number would make every place search most of them.
        if let Some(tree) = Tree::new(&mut items) {
            flatten(&tree, &mut nodes);
        }
        let numbers = || items.iter().map(|item| item.number() as usize);
        Boxes {
            own: numbers().map(|i| around[i]).collect(),
            charts: numbers().map(|i| Chart::new(&seeds[i], landings)).collect(),
            seeds: numbers().map(|i| seeds[i]).collect(),
            nodes,
        }
    }

    /// Adds those that hold a place.
    fn find(&self, place: Vec3, found: &mut Vec<Candidate>) {
        let Boxes { seeds, own, charts, nodes } = self;
        if nodes.is_empty() {
            return;
        }
        let point = place.to_array().map(|x| x as f32);
        let holds = |min: &[f32; 3], max: &[f32; 3]| (0..3).all(|i| point[i] >= min[i] && point[i] <= max[i]);
        let mut waiting = [0_u32; MOST_WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let at = waiting[count] as usize;
            let node = &nodes[at];
            if !holds(&node.min, &node.max) {
                continue;
            }
            if node.count == 0 {
                (waiting[count], waiting[count + 1]) = (node.at, at as u32 + 1);
                count += 2;
                continue;
            }
            let leaf = node.at as usize..(node.at + node.count) as usize;
            for i in leaf {
                let [min, max] = &own[i];
                if holds(min, max) {
                    found.extend(charts[i].within(&seeds[i], place));
                }
            }
        }
    }
}

/// The corners of the box of a seed, a little larger than its triangle.
fn around(landings: &[Landing], seed: &Seed) -> [[f32; 3]; 2] {
    let points = seed.corners.map(|corner| landings[corner as usize].point.to_array());
    let side = |i: usize, j: usize| (0..3).map(|k| (points[i][k] - points[j][k]).powi(2)).sum::<f64>();
    // What catches the light may bulge between the corners.
    let bulge = BULGE * side(0, 1).max(side(1, 2)).max(side(2, 0)).sqrt();
    let least: [f64; 3] =
        std::array::from_fn(|k| points.iter().fold(f64::INFINITY, |least, point| least.min(point[k])));
    let most: [f64; 3] =
        std::array::from_fn(|k| points.iter().fold(f64::NEG_INFINITY, |most, point| most.max(point[k])));
    let slack = |k: usize| 2.0 * MARGIN * (most[k] - least[k]) + bulge;
    [
        std::array::from_fn(|k| ((least[k] - slack(k)) as f32).next_down()),
        std::array::from_fn(|k| ((most[k] + slack(k)) as f32).next_up()),
    ]
}

/// The nodes of a tree, the first child of each next to it.
fn flatten(tree: &Tree, nodes: &mut Vec<Node>) {
    let ends = |box32: &Box32| {
        let three = |[x, y, z, _]: [f32; 4]| [x, y, z];
        [three(box32.min), three(box32.max)]
    };
    let [min, max] = ends(tree.bounds());
    match tree {
        Tree::Leaf { first, count, .. } => {
            nodes.push(Node { min, max, at: *first as u32, count: *count as u32 });
        }
        Tree::Inner { children, .. } => {
            let own = nodes.len();
            nodes.push(Node { min, max, at: 0, count: 0 });
            flatten(&children[0], nodes);
            nodes[own].at = nodes.len() as u32;
            flatten(&children[1], nodes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Choices, PixelSampler};

    /// In the unit cube.
    fn anywhere(choices: &mut Choices) -> Vec3 {
        let [x, y, z] = std::array::from_fn(|_| f64::from(choices.next()));
        Vec3::new(x, y, z)
    }

    /// Triangles of any size and place under lamps anywhere, some without an inside.
    fn some(count: u32) -> (Vec<Seed>, Vec<Landing>) {
        let mut choices = PixelSampler::new(3, 5).choices(0);
        let mut point = |reach: f64| anywhere(&mut choices) * reach;
        let mut landings = Vec::new();
        let seeds = (0..count).map(|i| {
            let (at, reach) = (point(1.0), if i % 5 == 0 { 1.0 } else { 0.1 });
            for _ in 0..3 {
                let point = if i % 7 == 0 { at } else { at + point(reach) };
                landings.push(Landing { point, left: Vec3::new(0.5, 0.5, 3.0) });
            }
            let corners = [3 * i, 3 * i + 1, 3 * i + 2];
            // A chain that is bright everywhere, one that is nowhere, and some that are both.
            let (chain, light) = (Chain::reversed(i % 6, 3), LightId::Emitter(i as usize % 2));
            let is_faint = match i % 6 {
                0 => false,
                1 => true,
                _ => i % 5 > 0,
            };
            Seed { light, chain, corners, irradiance: i as f32, is_faint }
        });
        (seeds.collect(), landings)
    }

    /// By the corners alone: along the light onto the plane, then by areas.
    fn shares(corners: [&Landing; 3], place: Vec3) -> Option<[f64; 3]> {
        let [a, b, c] = corners.map(|corner| corner.point);
        let normal = (b - a).cross(c - a);
        if normal.length_squared() == 0.0 {
            return Some([1.0 / 3.0; 3]);
        }
        let light = (a - corners[0].left).normalized();
        let lift = (place - a).dot(normal) / light.dot(normal);
        let longest = (b - a).length_squared().max((c - a).length_squared()).sqrt();
        let foot = place - light * lift;
        let area = |p: Vec3, q: Vec3| (p - foot).cross(q - foot).dot(normal) / normal.length_squared();
        let shares = [area(b, c), area(c, a), area(a, b)];
        (lift.abs() <= BULGE * longest && shares.iter().all(|share| *share >= -MARGIN)).then_some(shares)
    }

    #[test]
    fn a_search_finds_the_triangles_that_hold_a_place_of_chains_as_bright_there_as_asked() {
        let (seeds, landings) = some(400);
        let found_by = Seeds::new(seeds.clone(), landings.clone(), false).expect("some");
        let (mut all, mut flat) = ([0; 2], 0);
        let mut choices = PixelSampler::new(4, 1).choices(0);
        for k in 0..2000 {
            // Anywhere, or on a corner.
            let place = if k % 2 == 0 { landings[k % landings.len()].point } else { anywhere(&mut choices) };
            let mut holding = Vec::new();
            for seed in &seeds {
                let corners = seed.corners.map(|corner| &landings[corner as usize]);
                let Some(shares) = shares(corners, place) else { continue };
                // A triangle that is a point holds that point alone.
                let is_flat = shares == [1.0 / 3.0; 3];
                if !is_flat || (corners[0].point - place).length_squared() < 1e-12 {
                    holding.push((seed, shares));
                    flat += usize::from(is_flat);
                }
            }
            let is_bright_there = |own: &Seed| {
                holding.iter().any(|(seed, _)| !seed.is_faint && (seed.light, seed.chain) == (own.light, own.chain))
            };
            for (k, strength) in [Strength::Bright, Strength::Faint].into_iter().enumerate() {
                let mut found = Vec::new();
                found_by.find(place, strength, &mut found);
                found.sort_by(|a, b| a.irradiance.total_cmp(&b.irradiance));
                let is_asked = |seed: &Seed| is_bright_there(seed) == (strength == Strength::Bright);
                let expected: Vec<_> = holding.iter().filter(|(seed, _)| is_asked(seed)).collect();
                assert_eq!(found.len(), expected.len(), "{place:?} {strength:?}");
                for (found, (seed, shares)) in found.iter().zip(&expected) {
                    assert_eq!(found.irradiance as f32, seed.irradiance);
                    assert_eq!((found.light, found.chain), (seed.light, seed.chain));
                    for (own, wanted) in found.shares.iter().zip(shares) {
                        assert!(
                            (own - wanted).abs() < 1e-9 * (1.0 + wanted.abs()),
                            "{place:?}: {:?} {shares:?}",
                            found.shares
                        );
                    }
                }
                all[k] += found.len();
            }
        }
        assert!(all.iter().all(|all| *all > 500) && flat > 50, "{all:?} triangles, {flat} of them points");
    }
}
