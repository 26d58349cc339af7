//! Walls of bubbles: the part of a sphere or a plane where no other bubble has a better claim.
//!
//! Bubble i claims a point by f_i = (|p - c_i|^2 - r_i^2) / r_i: what is below zero is inside, and the least rules. Two
//! claims are equal on a sphere through the common circle, the wall between the two where surface tension is in balance
//! (d^2 = r_1^2 + r_2^2 - r_1 r_2): its curvature is 1/r_1 - 1/r_2. A lone pair out of balance keeps that curvature.

use iridesce_numerics::Vec3;
use iridesce_scene::Ball;

use super::Shape;
use super::bounds::Bounds;
use crate::camera::Ray;

/// a |p|^2 + b . p + c, of a point from the cluster's middle.
#[derive(Debug, Clone, Copy)]
struct Quadric {
    a: f64,
    b: Vec3,
    c: f64,
}

impl Quadric {
    /// f of a ball.
    fn claim(ball: &Ball, middle: Vec3) -> Quadric {
        let (center, per) = (Vec3::from(ball.center) - middle, 1.0 / ball.radius);
        Quadric { a: per, b: center * (-2.0 * per), c: (center.length_squared() - ball.radius * ball.radius) * per }
    }

    fn less(&self, other: &Quadric) -> Quadric {
        Quadric { a: self.a - other.a, b: self.b - other.b, c: self.c - other.c }
    }

    fn at(&self, p: Vec3) -> f64 {
        self.a * p.length_squared() + self.b.dot(p) + self.c
    }
}

/// A wall.
#[derive(Debug, Clone)]
pub struct Patch {
    carrier: Shape,
    middle: Vec3,
    /// It is where all of these are at least zero.
    keeps: Vec<Quadric>,
    /// Between two bubbles.
    pub is_inner: bool,
    bounds: Bounds,
}

impl Patch {
    /// The nearest crossing ahead.
    pub fn nearest(&self, ray: &Ray, is_leaving: bool) -> Option<f64> {
        let mut found = None;
        self.carrier.crossings(ray, is_leaving, |distance| {
            let point = ray.origin + ray.direction * distance - self.middle;
            let is_kept = distance > 0.0 && self.keeps.iter().all(|keep| keep.at(point) >= 0.0);
            if is_kept && found.is_none_or(|d| distance < d) {
                found = Some(distance);
            }
        });
        found
    }

    /// A point put onto it, and its unit normal.
    pub fn at(&self, ray: &Ray, distance: f64) -> (Vec3, Vec3) {
        self.carrier.at(ray, distance)
    }

    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

/// How two balls lie to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pair {
    /// They have no common circle.
    Apart,
    Overlap,
}

fn pair(a: &Ball, b: &Ball) -> Pair {
    let distance = (Vec3::from(a.center) - Vec3::from(b.center)).length_squared().sqrt();
    let overlap = distance < a.radius + b.radius && distance > (a.radius - b.radius).abs();
    if overlap { Pair::Overlap } else { Pair::Apart }
}

/// All walls of a cluster: the outsides first, then what is shared.
pub fn patches(balls: &[Ball]) -> Vec<Patch> {
    let count = balls.len();
    let middle = balls.iter().fold(Vec3::default(), |sum, ball| sum + Vec3::from(ball.center)) * (1.0 / count as f64);
    let claims: Vec<Quadric> = balls.iter().map(|ball| Quadric::claim(ball, middle)).collect();
    // By box along x: a cluster of a thousand has few neighbours each.
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); count];
    for i in 0..count {
        for j in 0..i {
            if pair(&balls[i], &balls[j]) == Pair::Overlap {
                neighbours[i].push(j);
                neighbours[j].push(i);
            }
        }
    }
    let mut all = Vec::new();
    for i in 0..count {
        let Ball { center, radius } = balls[i];
        let Some(carrier) = Shape::of_scene(&iridesce_scene::Shape::Sphere { center, radius }) else { continue };
        let Some(bounds) = carrier.bounds() else { continue };
        let keeps = neighbours[i].iter().map(|&k| claims[k]).collect();
        all.push(Patch { carrier, middle, keeps, is_inner: false, bounds });
    }
    for i in 0..count {
        for &j in neighbours[i].iter().filter(|&&j| j > i) {
            let crowd: Vec<usize> = neighbours[i].iter().copied().filter(|k| neighbours[j].contains(k)).collect();
            all.extend(wall(&balls[i], &balls[j], [&claims[i], &claims[j]], &crowd, &claims, middle));
        }
    }
    all
}

/// The wall between two balls that overlap.
fn wall(
    one: &Ball,
    other: &Ball,
    [f_one, f_other]: [&Quadric; 2],
    crowd: &[usize],
    claims: &[Quadric],
    middle: Vec3,
) -> Option<Patch> {
    let (small, large) = if one.radius <= other.radius { (one, other) } else { (other, one) };
    let (c_small, c_large) = (Vec3::from(small.center), Vec3::from(large.center));
    let way = c_large - c_small;
    let distance = way.length_squared().sqrt();
    let axis = way * (1.0 / distance);
    // The common circle: its distance from the smaller centre, and its radius.
    let along = 0.5 * (distance + (small.radius - large.radius) * (small.radius + large.radius) / distance);
    let circle2 = (small.radius - along) * (small.radius + along);
    if circle2 <= 0.0 {
        return None;
    }
    let circle = circle2.sqrt();
    let ring = c_small + axis * along;
    let is_crowded = !crowd.is_empty();
    let difference = large.radius - small.radius;
    let flat = difference <= 1e-12 * large.radius;
    let mut keeps: Vec<Quadric> = crowd.iter().map(|&k| claims[k].less(f_one)).collect();
    let zero = Quadric { a: 0.0, b: Vec3::default(), c: 0.0 };
    let scene_disk = |center: Vec3| iridesce_scene::Shape::Disk {
        center: center.to_array(),
        normal: axis.to_array(),
        radius: circle,
    };
    let (carrier, bounds) = if flat {
        let shape = Shape::of_scene(&scene_disk(ring))?;
        let bounds = shape.bounds()?;
        (shape, bounds)
    } else if is_crowded {
        // Where the two claims are equal.
        let apart = f_one.less(f_other);
        let center = apart.b * (-0.5 / apart.a);
        let radius = (center.length_squared() - apart.c / apart.a).max(0.0).sqrt();
        keeps.push(zero.less(f_one));
        let shape = Shape::of_scene(&iridesce_scene::Shape::Sphere { center: (center + middle).to_array(), radius })?;
        let inside = Bounds::of([c_small.to_array()]);
        let reach = [small.radius; 3];
        let ball = Bounds {
            min: std::array::from_fn(|k| inside.min[k] - reach[k]),
            max: std::array::from_fn(|k| inside.max[k] + reach[k]),
        };
        let bounds = shape.bounds()?.overlap(&ball);
        (shape, bounds)
    } else {
        let radius = small.radius * large.radius / difference;
        let sag = circle2 / (radius + ((radius - circle) * (radius + circle)).max(0.0).sqrt());
        let shape = Shape::of_scene(&iridesce_scene::Shape::Cap {
            center: (ring + axis * sag).to_array(),
            axis: axis.to_array(),
            radius_of_curvature: radius,
            aperture_radius: circle.min(radius),
        })?;
        let bounds = shape.bounds()?;
        (shape, bounds)
    };
    Some(Patch { carrier, middle, keeps, is_inner: true, bounds })
}

#[cfg(test)]
mod tests {
    use iridesce_numerics::noise::SplitMix64;
    use iridesce_scene::{Scene, Shape as SceneShape};

    use super::*;

    /// The walls of a cluster as they are drawn.
    struct Cluster {
        balls: Vec<Ball>,
        pairs: Vec<[usize; 2]>,
        patches: Vec<Patch>,
    }

    impl Cluster {
        fn new(balls: &[Ball]) -> Cluster {
            let pairs: Vec<[usize; 2]> = (0..balls.len())
                .flat_map(|i| (i + 1..balls.len()).map(move |j| [i, j]))
                .filter(|&[i, j]| pair(&balls[i], &balls[j]) == Pair::Overlap)
                .collect();
            let patches = patches(balls);
            assert_eq!(patches.len(), balls.len() + pairs.len(), "an outside each and a wall for each pair");
            Cluster { balls: balls.to_vec(), pairs, patches }
        }

        fn center(&self, ball: usize) -> Vec3 {
            self.balls[ball].center.into()
        }

        /// The wall between two, if they share one.
        fn wall(&self, i: usize, j: usize) -> Option<&Patch> {
            let at = self.pairs.iter().position(|pair| *pair == [i.min(j), i.max(j)])?;
            Some(&self.patches[self.balls.len() + at])
        }

        /// The normal of a patch at a place on its edge, `None` where it is not drawn.
        fn normal(patch: &Patch, p: Vec3) -> Option<Vec3> {
            let (on_it, normal) = patch.at(&Ray { origin: p, direction: Vec3::new(1.0, 0.0, 0.0) }, 0.0);
            let is_kept = patch.keeps.iter().all(|keep| keep.at(p - patch.middle) > -1e-9);
            (is_kept && (on_it - p).length_squared() < 1e-18).then_some(normal)
        }

        /// Of which way a claim grows at a place.
        fn growth(&self, ball: usize, p: Vec3) -> Vec3 {
            (p - self.center(ball)) * (2.0 / self.balls[ball].radius)
        }
    }

    /// Along a sheet, away from the edge along `edge`, to the side where `way` points.
    fn along_sheet(normal: Vec3, edge: Vec3, way: Vec3) -> Vec3 {
        let along = normal.cross(edge).normalized();
        if along.dot(way) > 0.0 { along } else { -along }
    }

    fn worst_from_120(sheets: [Vec3; 3]) -> f64 {
        [(0, 1), (1, 2), (2, 0)]
            .map(|(a, b)| (sheets[a].dot(sheets[b]).clamp(-1.0, 1.0).acos().to_degrees() - 120.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Along the circle of each touching pair two outsides meet their wall; along the line that three bubbles share, their three walls.
    #[test]
    fn the_films_of_twenty_bubbles_meet_at_120_degrees() {
        let scene = Scene::builtin("bubble-cluster").unwrap();
        let SceneShape::Bubbles(balls) = &scene.objects[0].shape else { panic!("a cluster") };
        assert_eq!(balls.len(), 20);
        let (off, circles, lines) = worst_of(balls);
        println!("{circles} circles, {lines} lines, {off:e} degrees");
        assert!(off < 1.0, "{off} degrees");
        assert!(circles >= 19 && lines >= 10, "{circles} circles, {lines} lines");
        let mut moved = balls.to_vec();
        moved[2].center[0] += 0.05 * moved[2].radius;
        assert!(worst_of(&moved).0 > 1.0, "what is out of balance would not be seen");
    }

    /// The largest deviation from 120 degrees, and how many circles and lines are drawn.
    fn worst_of(balls: &[Ball]) -> (f64, usize, usize) {
        let cluster = Cluster::new(balls);
        let (mut worst, mut circles, mut lines) = (0.0_f64, 0, 0);
        for &[i, j] in &cluster.pairs {
            let seen = on_circle(&cluster, i, j);
            circles += usize::from(!seen.is_empty());
            worst = seen.into_iter().fold(worst, f64::max);
            for k in j + 1..balls.len() {
                let seen = on_line(&cluster, [i, j, k]);
                lines += usize::from(!seen.is_empty());
                worst = seen.into_iter().fold(worst, f64::max);
            }
        }
        (worst, circles, lines)
    }

    /// Degrees from 120 at places of a pair's circle that are drawn.
    fn on_circle(cluster: &Cluster, i: usize, j: usize) -> Vec<f64> {
        let (a, b) = (cluster.center(i), cluster.center(j));
        let (r_a, r_b) = (cluster.balls[i].radius, cluster.balls[j].radius);
        let distance = (b - a).length_squared().sqrt();
        let axis = (b - a) * (1.0 / distance);
        let along = 0.5 * (distance + (r_a - r_b) * (r_a + r_b) / distance);
        let radius = (r_a * r_a - along * along).sqrt();
        let [across, up]: [Vec3; 2] = super::super::frame(axis).into();
        let at = |turn: usize| {
            let (sin, cos) = (turn as f64 / 64.0 * std::f64::consts::TAU).sin_cos();
            let p = a + axis * along + (across * cos + up * sin) * radius;
            let edge = up * cos - across * sin;
            let normals =
                [&cluster.patches[i], &cluster.patches[j], cluster.wall(i, j)?].map(|sheet| Cluster::normal(sheet, p));
            let [n_i, n_j, n_wall] = normals;
            let sheets = [(n_i?, p - b), (n_j?, p - a), (n_wall?, a - p)];
            Some(worst_from_120(sheets.map(|(normal, way)| along_sheet(normal, edge, way))))
        };
        (0..64).filter_map(at).collect()
    }

    /// The same on the line where three claims are equal, found by Newton's method from places all around.
    fn on_line(cluster: &Cluster, balls: [usize; 3]) -> Vec<f64> {
        let [i, j, k] = balls;
        let claim = |ball: usize, p: Vec3| {
            let radius = cluster.balls[ball].radius;
            ((p - cluster.center(ball)).length_squared() - radius * radius) / radius
        };
        let mut noise = SplitMix64::new(5);
        let middle = balls.iter().fold(Vec3::default(), |sum, &ball| sum + cluster.center(ball)) * (1.0 / 3.0);
        let mut at = || {
            let mut p = middle + Vec3::from([0; 3].map(|_| 4.0 * noise.unit() - 2.0));
            for _ in 0..40 {
                // The least step that makes both differences zero.
                let off = [claim(i, p) - claim(j, p), claim(j, p) - claim(k, p)];
                let g = [cluster.growth(i, p) - cluster.growth(j, p), cluster.growth(j, p) - cluster.growth(k, p)];
                let (aa, ab, bb) = (g[0].dot(g[0]), g[0].dot(g[1]), g[1].dot(g[1]));
                let det = aa * bb - ab * ab;
                let (x, y) = ((off[0] * bb - off[1] * ab) / det, (off[1] * aa - off[0] * ab) / det);
                p = p - g[0] * x - g[1] * y;
            }
            let walls = [[i, j, k], [j, k, i], [k, i, j]].map(|[a, b, other]| {
                let normal = Cluster::normal(cluster.wall(a, b)?, p)?;
                Some((normal, cluster.growth(other, p) - cluster.growth(a, p)))
            });
            let [Some(first), Some(second), Some(third)] = walls else { return None };
            let edge = first.0.cross(second.0).normalized();
            Some(worst_from_120([first, second, third].map(|(normal, way)| along_sheet(normal, edge, way))))
        };
        (0..40).filter_map(|_| at()).collect()
    }
}
