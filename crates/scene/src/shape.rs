//! Where on a shape a point lies: its height, its distance from the middle, its u and v.

use std::f64::consts::{PI, TAU};

use iridesce_numerics::turns::atan2_fast;
use iridesce_numerics::vector::{cross, difference, dot, length, scaled};

use crate::model::{Ball, Shape};

/// Sine of the angle to +y below which a normal counts as vertical: the direction that +y has in the surface is then
/// rounding alone.
const VERTICAL: f64 = 1e-6;

impl Shape {
    /// The world y of its lowest and its highest point; `None` for an unbounded shape.
    pub fn heights(&self) -> Option<[f64; 2]> {
        let around = |y: f64, half: f64| Some([y - half, y + half]);
        match *self {
            Shape::Sphere { center, radius } => around(center[1], radius),
            Shape::Rectangle { center, u, v } => around(center[1], u[1].abs() + v[1].abs()),
            Shape::Disk { center, normal, radius } => around(center[1], radius * normal[0].hypot(normal[2])),
            Shape::Plane { .. } => None,
            Shape::Cap { center, axis, radius_of_curvature, aperture_radius } => {
                // From the sphere's centre outwards to the vertex; the rim lies `sag` behind the vertex along it.
                let out = scaled(axis, radius_of_curvature.signum());
                let radius = radius_of_curvature.abs();
                let square = aperture_radius.powi(2);
                let to_rim = (radius * radius - square).max(0.0).sqrt();
                let sag = square / (radius + to_rim);
                let sine = out[0].hypot(out[2]);
                let rim = center[1] - sag * out[1];
                let reach = aperture_radius * sine;
                // The sphere's own highest and lowest points, where the cap holds them.
                let holds = |up: f64| up >= 0.0 && radius * sine <= aperture_radius;
                let top = if holds(out[1]) { center[1] + radius * (1.0 - out[1]) } else { rim + reach };
                let bottom = if holds(-out[1]) { center[1] - radius * (1.0 + out[1]) } else { rim - reach };
                Some([bottom, top])
            }
            _ => self.span([0.0, 1.0, 0.0]),
        }
    }

    /// The farthest that it reaches from its middle, scene units, for a cap from its axis; `None` for an unbounded
    /// shape.
    pub fn reach(&self) -> Option<f64> {
        match *self {
            Shape::Sphere { radius, .. } | Shape::Disk { radius, .. } => Some(radius),
            Shape::Rectangle { u, v, .. } => Some(length(difference(u, v)).max(length(difference(u, scaled(v, -1.0))))),
            Shape::Plane { .. } => None,
            Shape::Cap { aperture_radius, .. } => Some(aperture_radius),
            Shape::Cylinder { radius, height, .. } => Some(radius.hypot(0.5 * height)),
            Shape::Bubbles(ref balls) => {
                let middle = middle(balls);
                let far = balls.iter().map(|ball| length(difference(ball.center, middle)) + ball.radius);
                Some(far.fold(0.0, f64::max))
            }
            Shape::Mesh(_) => None,
        }
    }

    /// The least and the largest of `along . p` over its points; `None` for an unbounded shape, and for a mesh, of which only
    /// its file can tell.
    pub fn span(&self, along: [f64; 3]) -> Option<[f64; 2]> {
        let size = length(along);
        let around = |center: [f64; 3], half: f64| {
            let middle = dot(along, center);
            Some([middle - half, middle + half])
        };
        let across = |axis: [f64; 3]| (size * size - dot(along, axis).powi(2)).max(0.0).sqrt();
        match *self {
            Shape::Sphere { center, radius } => around(center, radius * size),
            Shape::Rectangle { center, u, v } => around(center, dot(along, u).abs() + dot(along, v).abs()),
            Shape::Disk { center, normal, radius } => around(center, radius * across(normal)),
            Shape::Plane { .. } | Shape::Mesh(_) => None,
            Shape::Cap { center, axis, radius_of_curvature, aperture_radius } => {
                // Turned so that the way counts upwards: a cap's heights hang on the angle between axis and up alone.
                let up = if size > 0.0 { dot(along, axis) / size } else { 0.0 };
                let turned = Shape::Cap {
                    center: [0.0; 3],
                    axis: [(1.0 - up * up).max(0.0).sqrt(), up, 0.0],
                    radius_of_curvature,
                    aperture_radius,
                };
                let [low, high] = turned.heights()?;
                let middle = dot(along, center);
                Some([middle + low * size, middle + high * size])
            }
            Shape::Cylinder { center, axis, radius, height, .. } => {
                around(center, 0.5 * height * dot(along, axis).abs() + radius * across(axis))
            }
            Shape::Bubbles(ref balls) => balls
                .iter()
                .map(|ball| {
                    [dot(along, ball.center) - ball.radius * size, dot(along, ball.center) + ball.radius * size]
                })
                .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]),
        }
    }

    /// Its middle, from which a lens's gap is measured, and the axis through it, if the gap goes by that.
    pub fn middle(&self) -> ([f64; 3], Option<[f64; 3]>) {
        match *self {
            Shape::Sphere { center, .. } | Shape::Rectangle { center, .. } | Shape::Disk { center, .. } => {
                (center, None)
            }
            Shape::Cap { center, axis, .. } => (center, Some(axis)),
            Shape::Plane { point, .. } => (point, None),
            Shape::Cylinder { center, .. } => (center, None),
            Shape::Bubbles(ref balls) => (middle(balls), None),
            Shape::Mesh(_) => ([0.0; 3], None),
        }
    }

    /// Where a map laid over the shape lies at a point of it: u and v, in general 0 to 1. `docs/reference/conventions.md` says how
    /// they run on every shape.
    ///
    /// ```
    /// use iridesce_scene::Shape;
    /// let disk = Shape::Disk { center: [0.0; 3], normal: [0.0, 0.0, 1.0], radius: 2.0 };
    /// assert_eq!(disk.uv([1.0, -2.0, 0.0]), [0.75, 0.0]);
    /// ```
    pub fn uv(&self, point: [f64; 3]) -> [f64; 2] {
        Chart::new(self).uv(point)
    }

    /// The direction in which u grows at a point of the shape, of any length; none at the poles of a sphere.
    ///
    /// ```
    /// use iridesce_scene::Shape;
    /// let sphere = Shape::Sphere { center: [0.0; 3], radius: 2.0 };
    /// assert_eq!(sphere.along_u([0.0, 0.0, 2.0]), [2.0, 0.0, -0.0]);
    /// ```
    pub fn along_u(&self, point: [f64; 3]) -> [f64; 3] {
        Chart::new(self).along_u(point)
    }
}

fn middle(balls: &[Ball]) -> [f64; 3] {
    let sum = balls.iter().fold([0.0; 3], |sum, ball| std::array::from_fn(|i| sum[i] + ball.center[i]));
    scaled(sum, 1.0 / balls.len().max(1) as f64)
}

/// How u and v run over a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chart {
    /// Longitude and latitude around a centre.
    Globe {
        /// The centre.
        center: [f64; 3],
    },
    /// Linear in place: `u = 1/2 + across . (point - center)`, v the same with `up`.
    Flat {
        /// Where both are 1/2.
        center: [f64; 3],
        /// How u grows, per scene unit.
        across: [f64; 3],
        /// How v grows, per scene unit.
        up: [f64; 3],
        /// Whether the map repeats.
        repeats: bool,
    },
    /// Around an axis and along it.
    Tube {
        /// Where u is 1/2 and v is 1/2 seen from the axis.
        center: [f64; 3],
        /// Along v, length 1.
        axis: [f64; 3],
        /// Towards u = 1/2, length 1.
        front: [f64; 3],
        /// Along it v goes from 0 to 1.
        height: f64,
    },
}

impl Chart {
    /// The chart of a shape.
    pub fn new(shape: &Shape) -> Chart {
        let facing = |center, normal, per_unit: f64, repeats| {
            let (across, up) = axes(normal);
            Chart::Flat { center, across: scaled(across, per_unit), up: scaled(up, per_unit), repeats }
        };
        match *shape {
            Shape::Sphere { center, .. } => Chart::Globe { center },
            Shape::Rectangle { center, u, v } => {
                // The reciprocal basis: also right where u and v are not at right angles.
                let normal = cross(u, v);
                let half = 0.5 / dot(normal, normal);
                let (across, up) = (scaled(cross(v, normal), half), scaled(cross(normal, u), half));
                Chart::Flat { center, across, up, repeats: false }
            }
            Shape::Disk { center, normal, radius } => facing(center, normal, 0.5 / radius, false),
            Shape::Plane { point, normal } => facing(point, normal, 1.0, true),
            Shape::Cap { center, axis, aperture_radius, .. } => facing(center, axis, 0.5 / aperture_radius, false),
            Shape::Cylinder { center, axis, height, .. } => {
                // u = 1/2 faces +z, as on a globe; of an axis along z, +y.
                let wanted = if axis[0].hypot(axis[1]) < VERTICAL { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
                let front = difference(wanted, scaled(axis, dot(wanted, axis)));
                Chart::Tube { center, axis, front: scaled(front, 1.0 / length(front)), height }
            }
            Shape::Bubbles(ref balls) => Chart::Globe { center: middle(balls) },
            // Of a mesh without coordinates of its own; maps are refused there.
            Shape::Mesh(_) => facing([0.0; 3], [0.0, 0.0, 1.0], 1.0, true),
        }
    }

    /// u and v of a point.
    pub fn uv(&self, point: [f64; 3]) -> [f64; 2] {
        match *self {
            Chart::Globe { center } => {
                // Renders ask for millions of places: the library's exact functions took a sixth of a picture of a bubble.
                let [x, y, z] = difference(point, center);
                [0.5 + atan2_fast(x, z) / TAU, 0.5 + atan2_fast(y, (x * x + z * z).sqrt()) / PI]
            }
            Chart::Flat { center, across, up, .. } => {
                let way = difference(point, center);
                [0.5 + dot(way, across), 0.5 + dot(way, up)]
            }
            Chart::Tube { center, axis, front, height } => {
                let way = difference(point, center);
                let side = cross(axis, front);
                [0.5 + dot(way, side).atan2(dot(way, front)) / TAU, 0.5 + dot(way, axis) / height]
            }
        }
    }

    /// How a point of the surface moves with u, and with v.
    pub fn tangents(&self, point: [f64; 3]) -> [[f64; 3]; 2] {
        match *self {
            Chart::Globe { center } => {
                let [x, y, z] = difference(point, center);
                let round = x.hypot(z);
                // At the poles any direction will do.
                let (sin, cos) = if round > 0.0 { (x / round, z / round) } else { (0.0, 1.0) };
                [scaled([round * cos, 0.0, -round * sin], TAU), scaled([-y * sin, round, -y * cos], PI)]
            }
            Chart::Flat { across, up, .. } => {
                let normal = cross(across, up);
                let per = 1.0 / dot(normal, normal);
                [scaled(cross(up, normal), per), scaled(cross(normal, across), per)]
            }
            Chart::Tube { center, axis, height, .. } => {
                [scaled(cross(axis, difference(point, center)), TAU), scaled(axis, height)]
            }
        }
    }

    /// The direction in which u grows at a point, of any length.
    pub fn along_u(&self, point: [f64; 3]) -> [f64; 3] {
        match *self {
            Chart::Globe { center } => {
                let [x, _, z] = difference(point, center);
                [z, 0.0, -x]
            }
            // Where v stays: in a sheared chart not where u grows fastest.
            Chart::Flat { across, up, .. } => cross(up, cross(across, up)),
            Chart::Tube { center, axis, .. } => cross(axis, difference(point, center)),
        }
    }

    /// Whether the left edge of a map meets its right edge, and its bottom its top.
    pub fn repeats(&self) -> [bool; 2] {
        match *self {
            Chart::Globe { .. } | Chart::Tube { .. } => [true, false],
            Chart::Flat { repeats, .. } => [repeats; 2],
        }
    }
}

/// The directions of u and v in a surface that faces `normal`: v is the world's +y as it lies in the surface, or -z where
/// the normal is along y; u is at right angles, to the right of who looks at the front.
fn axes(normal: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let wanted = if normal[0].hypot(normal[2]) < VERTICAL { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
    let along = difference(wanted, scaled(normal, dot(wanted, normal)));
    let up = scaled(along, 1.0 / length(along));
    (cross(up, normal), up)
}

#[cfg(test)]
mod tests {
    use super::*;

    const O: [f64; 3] = [0.0; 3];

    fn unit(v: [f64; 3]) -> [f64; 3] {
        scaled(v, 1.0 / length(v))
    }

    /// The fast arc tangent is off by 2e-11 at most, of which v is the part over pi.
    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).abs() < 2e-11 / PI && (a[1] - b[1]).abs() < 2e-11 / PI
    }

    #[test]
    fn a_sphere_is_a_globe() {
        let sphere = Shape::Sphere { center: [1.0, 2.0, 3.0], radius: 2.0 };
        let at = |x: f64, y: f64, z: f64| sphere.uv([1.0 + x, 2.0 + y, 3.0 + z]);
        assert!(near(at(0.0, 0.0, 2.0), [0.5, 0.5]), "the middle faces +z");
        assert!(near(at(2.0, 0.0, 0.0), [0.75, 0.5]), "u grows towards +x");
        assert!(near(at(-2.0, 0.0, 0.0), [0.25, 0.5]));
        assert!(near(at(1e-12, 0.0, -2.0), [1.0, 0.5]) && near(at(-1e-12, 0.0, -2.0), [0.0, 0.5]), "the seam is at -z");
        let [top, bottom] = [at(0.0, 2.0, 0.0)[1], at(0.0, -2.0, 0.0)[1]];
        let inside = |from_pole: f64| (0.0..2e-11 / PI).contains(&from_pole);
        assert!(inside(1.0 - top) && inside(bottom), "the poles are never beyond the map, which repeats there");
        let half = 2.0 * f64::sqrt(0.5);
        assert!(near(at(0.0, half, half), [0.5, 0.75]), "v is an angle, not a height");
    }

    #[test]
    fn rectangles_are_measured_along_their_edges() {
        let (center, u, v) = ([1.0, 0.0, -2.0], [2.0, 0.0, 1.0], [1.0, 3.0, 0.0]);
        let shape = Shape::Rectangle { center, u, v };
        for (a, b) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (0.3, -0.8)] {
            let point = std::array::from_fn(|i| center[i] + a * u[i] + b * v[i]);
            assert!(near(shape.uv(point), [0.5 + a / 2.0, 0.5 + b / 2.0]), "{a} {b}");
        }
    }

    #[test]
    fn on_disks_caps_and_planes_v_is_up() {
        for (normal, right, up) in [
            ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
            ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
            ([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
            ([1e-9, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
            (unit([0.0, 1.0, 1.0]), [1.0, 0.0, 0.0], unit([0.0, 1.0, -1.0])),
        ] {
            let center = [3.0, -1.0, 2.0];
            let step = |a: f64, b: f64| std::array::from_fn(|i| center[i] + a * right[i] + b * up[i]);
            let disk = Shape::Disk { center, normal, radius: 2.0 };
            let cap = Shape::Cap { center, axis: normal, radius_of_curvature: -5.0, aperture_radius: 2.0 };
            let plane = Shape::Plane { point: center, normal };
            for (a, b) in [(0.0, 0.0), (2.0, 0.0), (-1.0, 0.5), (0.0, -2.0)] {
                for shape in [disk.clone(), cap.clone()] {
                    let uv = shape.uv(step(a, b));
                    assert!((uv[0] - 0.5 - a / 4.0).abs() < 1e-8 && (uv[1] - 0.5 - b / 4.0).abs() < 1e-8, "{normal:?}");
                }
                let uv = plane.uv(step(a, b));
                assert!((uv[0] - 0.5 - a).abs() < 1e-8 && (uv[1] - 0.5 - b).abs() < 1e-8, "one unit a repeat");
            }
            assert_eq!(Chart::new(&plane).repeats(), [true, true]);
            assert_eq!(Chart::new(&disk).repeats(), [false, false]);
        }
    }

    /// Every shape's lowest and highest point, against many points of it.
    #[test]
    fn heights_are_those_of_the_points() {
        let center = [0.5, -1.5, 2.0];
        let directions =
            [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.1], [0.2, -0.9, 0.5], [1.0, 0.2, -0.4]];
        for axis in directions.map(unit) {
            let (across, up) = axes(axis);
            for (radius, rim) in [(5.0, 2.0), (-5.0, 2.0), (2.0, 2.0), (-2.0, 2.0), (1e6, 3.0)] {
                let shape = Shape::Cap { center, axis, radius_of_curvature: radius, aperture_radius: rim };
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for i in 0..=400 {
                    let r = rim * f64::from(i) / 400.0;
                    let sag = r * r / (f64::abs(radius) + (radius * radius - r * r).max(0.0).sqrt());
                    for j in 0..720 {
                        let (sin, cos) = (f64::from(j) / 720.0 * TAU).sin_cos();
                        let y = center[1] + r * (cos * across[1] + sin * up[1]) - radius.signum() * sag * axis[1];
                        (low, high) = (low.min(y), high.max(y));
                    }
                }
                let [bottom, top] = shape.heights().unwrap();
                assert!(bottom <= low + 1e-9 && high <= top + 1e-9, "{axis:?} {radius}");
                assert!(low - bottom < 1e-3 && top - high < 1e-3, "{axis:?} {radius}: {bottom} {low} {high} {top}");
            }
            let disk = Shape::Disk { center, normal: axis, radius: 2.0 }.heights().unwrap();
            let rim = (0..720).map(|j| {
                let (sin, cos) = (f64::from(j) / 720.0 * TAU).sin_cos();
                center[1] + 2.0 * (cos * across[1] + sin * up[1])
            });
            assert!((rim.fold(f64::NEG_INFINITY, f64::max) - disk[1]).abs() < 1e-4);
        }
        let rectangle = Shape::Rectangle { center, u: [1.0, 2.0, 0.0], v: [0.0, -3.0, 1.0] };
        assert_eq!(rectangle.heights(), Some([-6.5, 3.5]));
        assert_eq!(Shape::Sphere { center, radius: 2.0 }.heights(), Some([-3.5, 0.5]));
        assert_eq!(Shape::Plane { point: O, normal: [0.0, 1.0, 0.0] }.heights(), None);
    }

    #[test]
    fn shapes_reach_to_their_farthest_point() {
        let rectangle = |u, v| Shape::Rectangle { center: O, u, v }.reach().unwrap();
        assert_eq!(rectangle([3.0, 0.0, 0.0], [0.0, 4.0, 0.0]), 5.0);
        // A parallelogram: its longer diagonal.
        assert_eq!(rectangle([3.0, 0.0, 0.0], [3.0, 1.0, 0.0]), f64::sqrt(37.0));
        assert_eq!(rectangle([3.0, 0.0, 0.0], [-3.0, 1.0, 0.0]), f64::sqrt(37.0));
        let cap = Shape::Cap { center: O, axis: [0.0, 1.0, 0.0], radius_of_curvature: 9.0, aperture_radius: 2.0 };
        assert_eq!(cap.reach(), Some(2.0));
        assert_eq!(Shape::Plane { point: O, normal: [0.0, 1.0, 0.0] }.reach(), None);
    }
}
