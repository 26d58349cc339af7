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
