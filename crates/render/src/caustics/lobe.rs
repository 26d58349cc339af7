//! Directions that lead to a lamp over mirrors and through lenses.

use iridesce_numerics::Vec3;

use crate::chain::Chain;
use crate::lights::chooser::LightId;

/// A lobe is even within the lamp's disc, where it is seen undistorted, and falls off around it as powers of the square of
/// the distance: steeply, and for the ends of what is bent out of shape in a share of its directions slowly. No step at the rim:
/// what lies just outside it would weigh too much.
const FALLS: [f64; 2] = [8.0, 2.0];

/// The share of directions that fall off slowly.
const SLOWLY: f64 = 0.1;

/// Directions from a place that lead to a lamp along a chain of surfaces.
///
/// Around `axis` a direction is a plane's worth of two numbers (its tangents), of which where it comes to beside the lamp's
/// middle is nearly a linear function: `miss + turn * tangents`.
#[derive(Debug, Clone, Copy)]
pub struct Lobe {
    pub light: LightId,
    pub chain: Chain,
    pub axis: Vec3,
    pub across: Vec3,
    pub up: Vec3,
    pub turn: [[f64; 2]; 2],
    pub miss: [f64; 2],
    pub determinant: f64,
    pub radius: f64,
}

impl Lobe {
    /// A place beside the lamp's middle, in its radii, where a direction comes to; and the cube of the cosine to the axis.
    #[inline(always)]
    fn place(&self, direction: Vec3) -> Option<([f64; 2], f64)> {
        let cos = direction.dot(self.axis);
        if cos <= 0.0 {
            return None;
        }
        let tangents = [direction.dot(self.across) / cos, direction.dot(self.up) / cos];
        let place = [0, 1]
            .map(|i| (self.miss[i] + self.turn[i][0] * tangents[0] + self.turn[i][1] * tangents[1]) / self.radius);
        Some((place, cos * cos * cos))
    }

    /// The probability per solid angle of a direction.
    #[inline(always)]
    pub fn density(&self, direction: Vec3) -> f64 {
        let Some(([x, y], cos3)) = self.place(direction) else { return 0.0 };
        let r2 = x * x + y * y;
        let of = |power: f64| (power - 1.0) / power * r2.max(1.0).powf(-power);
        let [steep, slow] = FALLS.map(of);
        let density = (1.0 - SLOWLY) * steep + SLOWLY * slow;
        density * self.determinant / (std::f64::consts::PI * self.radius * self.radius * cos3)
    }

    /// A random direction.
    #[inline(always)]
    pub fn draw(&self, (a, b): (f64, f64)) -> Vec3 {
        // What the choice has left of the first number serves again.
        let (power, a) = if a < SLOWLY { (FALLS[1], a / SLOWLY) } else { (FALLS[0], (a - SLOWLY) / (1.0 - SLOWLY)) };
        let within = (power - 1.0) / power;
        let r2 = if a < within { a / within } else { ((1.0 - a) * power).powf(-1.0 / (power - 1.0)) };
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let r = r2.sqrt() * self.radius;
        let tangents = self.solve([r * cos - self.miss[0], r * sin - self.miss[1]]);
        (self.axis + self.across * tangents[0] + self.up * tangents[1]).normalized()
    }

    /// The tangents that come to a place.
    #[inline(always)]
    fn solve(&self, place: [f64; 2]) -> [f64; 2] {
        solve(&self.turn, place)
    }

    /// Irradiance of a light without size, of intensity 1 (or of irradiance 1 if it is far away), on what faces it.
    #[inline(always)]
    pub fn irradiance(&self) -> f64 {
        1.0 / self.determinant
    }

    /// Whether another is the same one, found again.
    pub fn is(&self, other: &Lobe) -> bool {
        if self.radius == 0.0 {
            return (self.axis - other.axis).length_squared() < 1e-12;
        }
        self.place(other.axis).is_some_and(|([x, y], _)| x * x + y * y < 0.25)
            && other.place(self.axis).is_some_and(|([x, y], _)| x * x + y * y < 0.25)
    }
}

/// x of m x = right; infinite where there is none.
#[inline(always)]
pub fn solve(m: &[[f64; 2]; 2], right: [f64; 2]) -> [f64; 2] {
    let scale = 1.0 / (m[0][0] * m[1][1] - m[0][1] * m[1][0]);
    [(m[1][1] * right[0] - m[0][1] * right[1]) * scale, (m[0][0] * right[1] - m[1][0] * right[0]) * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions are drawn as densely as is said: the mean of a function over the density is its integral over all directions.
    #[test]
    fn density_is_that_of_the_draws() {
        let lobe = Lobe {
            light: LightId::Emitter(0),
            chain: Chain::START,
            axis: Vec3::new(0.0, 0.0, 1.0),
            across: Vec3::new(1.0, 0.0, 0.0),
            up: Vec3::new(0.0, 1.0, 0.0),
            turn: [[3.0, 0.4], [-0.2, 1.5]],
            miss: [0.02, -0.05],
            determinant: 3.0 * 1.5 + 0.4 * 0.2,
            radius: 0.3,
        };
        let (mut sums, count) = ([0.0; 2], 400_000);
        for i in 0..count {
            let pair = ((f64::from(i) + 0.5) / f64::from(count), (f64::from(i) * 0.618_033_988_749_895).fract());
            let direction = lobe.draw(pair);
            assert!((direction.length_squared() - 1.0).abs() < 1e-12);
            let density = lobe.density(direction);
            // Of cos^4 over the hemisphere 2 pi / 5, of 1 near the axis the solid angle of a cone.
            sums[0] += direction.z.powi(4) / density;
            sums[1] += if direction.z > 0.98 { 1.0 / density } else { 0.0 };
        }
        let wanted = [std::f64::consts::TAU / 5.0, std::f64::consts::TAU * 0.02];
        for (sum, wanted) in sums.iter().zip(wanted) {
            let mean = sum / f64::from(count);
            assert!((mean / wanted - 1.0).abs() < 0.01, "{mean} for {wanted}");
        }
    }
}
