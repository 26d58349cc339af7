//! Which lights a point samples: all of a few, of many those that are expected to give most.

use iridesce_numerics::Vec3;

use crate::geometry::Shape;

/// Most lights that are all sampled at every hit.
pub const FEW: usize = 8;

/// So many of more lights are.
pub const PICKS: usize = 2;

/// What share of the picks goes to all lights alike: what is expected of a light is a guess.
const EQUALLY: f64 = 0.1;

/// A light that is sampled from a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightId {
    Maps,
    Sun(usize),
    Emitter(usize),
    Delta(usize),
}

/// The size of an emitter: its middle, the radius of a sphere around it, and its area; for flat ones the normal, too.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    center: Vec3,
    radius2: f64,
    area: f64,
    normal: Option<Vec3>,
}

impl Extent {
    /// `None` for shapes that are not drawn from.
    pub fn of(shape: &Shape) -> Option<Extent> {
        const PI: f64 = std::f64::consts::PI;
        match *shape {
            // The area that is seen: its disc.
            Shape::Sphere { center, radius, .. } => {
                Some(Extent { center, radius2: radius * radius, area: PI * radius * radius, normal: None })
            }
            Shape::Rectangle { center, u, v, normal, .. } => Some(Extent {
                center,
                radius2: u.length_squared() + v.length_squared(),
                area: 4.0 * u.cross(v).length_squared().sqrt(),
                normal: Some(normal),
            }),
            Shape::Disk { center, normal, radius2 } => {
                Some(Extent { center, radius2, area: PI * radius2, normal: Some(normal) })
            }
            _ => None,
        }
    }

    /// Of a surface of any shape: its middle, the square of its radius, its area, of which about a quarter is seen.
    pub fn around((center, radius2, area): (Vec3, f64, f64)) -> Extent {
        Extent { center, radius2, area: 0.25 * area, normal: None }
    }

    /// Its middle, and the radius of a sphere around it.
    pub fn ball(&self) -> (Vec3, f64) {
        (self.center, self.radius2.sqrt())
    }

    /// About the irradiance that radiance 1 makes at a place on what faces it.
    #[inline(always)]
    pub fn irradiance(&self, from: Vec3) -> f64 {
        let away = self.center - from;
        let distance2 = away.length_squared().max(self.radius2);
        let facing = self.normal.map_or(1.0, |normal| {
            // An edge-on lamp that is near is still seen from the side.
            let sine2 = (self.radius2 / distance2).min(1.0);
            (normal.dot(away).powi(2) / distance2 + 0.25 * sine2).sqrt().min(1.0)
        });
        (self.area * facing / distance2).min(std::f64::consts::PI)
    }
}

/// The light that a random number in [0, 1) picks, and how often it is picked on average. `sums`: what is expected of
/// every light, each added to all before it.
#[inline(always)]
pub fn pick(sums: &[f64], random: f64) -> (usize, f64) {
    let (count, total) = (sums.len(), sums[sums.len() - 1]);
    let at = if total <= 0.0 {
        ((random * count as f64) as usize).min(count - 1)
    } else if random < EQUALLY {
        ((random / EQUALLY * count as f64) as usize).min(count - 1)
    } else {
        let place = (random - EQUALLY) / (1.0 - EQUALLY) * total;
        sums.partition_point(|&sum| sum <= place).min(count - 1)
    };
    let before = if at > 0 { sums[at - 1] } else { 0.0 };
    (at, expected_picks(sums[at] - before, total, count))
}

/// How often a light is picked, on average, of which so much is expected and of all `count` so much in `total`.
#[inline(always)]
pub fn expected_picks(expected: f64, total: f64, count: usize) -> f64 {
    let chance =
        if total > 0.0 { EQUALLY / count as f64 + (1.0 - EQUALLY) * expected / total } else { 1.0 / count as f64 };
    PICKS as f64 * chance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever is expected, a light over the number of its picks comes out right on average: all that makes the choice fair.
    #[test]
    fn lights_are_picked_as_often_as_is_said() {
        for expected in [&[1.0, 0.0, 3.0, 1e-6, 2.0][..], &[0.0; 6], &[5.0]] {
            let mut sums = Vec::new();
            let mut total = 0.0;
            for value in expected {
                total += value;
                sums.push(total);
            }
            let mut found = vec![0.0; expected.len()];
            let draws = 200_000;
            for i in 0..draws {
                let (at, picks) = pick(&sums, (f64::from(i) + 0.5) / f64::from(draws));
                found[at] += PICKS as f64 / (picks * f64::from(draws));
            }
            assert!(found.iter().all(|mean| (mean - 1.0).abs() < 1e-3), "{expected:?}: {found:?}");
        }
    }
}
