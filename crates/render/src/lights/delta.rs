//! Lights without size: directional, point and spot. Light sampling alone finds them.

use iridesce_numerics::Vec3;
use iridesce_scene::DeltaKind;

/// A light without size, as seen from some place.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Towards it, length 1.
    pub direction: Vec3,
    /// How far away it is.
    pub distance: f64,
    /// Its irradiance there on what faces it, for a power of 1.
    pub irradiance: f64,
}

/// Where a light without size comes from.
#[derive(Debug, Clone, Copy)]
pub enum DeltaSource {
    Directional(Vec3),
    Point(Vec3),
    /// Angles in radians: of full intensity up to `full`, none from `full + soft` on.
    Spot {
        position: Vec3,
        axis: Vec3,
        full: f64,
        soft: f64,
    },
}

impl DeltaSource {
    pub fn new(kind: &DeltaKind) -> DeltaSource {
        match *kind {
            DeltaKind::Directional { direction } => DeltaSource::Directional(direction.into()),
            DeltaKind::Point { position } => DeltaSource::Point(position.into()),
            DeltaKind::Spot { position, axis, cone_deg, soft_deg } => DeltaSource::Spot {
                position: position.into(),
                axis: axis.into(),
                full: 0.5 * cone_deg.to_radians(),
                soft: soft_deg.to_radians(),
            },
        }
    }

    /// What is seen of it from a place; nothing at the place where it stands.
    #[inline(always)]
    pub fn seen(&self, from: Vec3) -> Option<Seen> {
        let position = match *self {
            DeltaSource::Directional(direction) => {
                return Some(Seen { direction, distance: f64::INFINITY, irradiance: 1.0 });
            }
            DeltaSource::Point(position) | DeltaSource::Spot { position, .. } => position,
        };
        let away = position - from;
        let distance2 = away.length_squared();
        if distance2 <= 0.0 {
            return None;
        }
        let distance = distance2.sqrt();
        let direction = away * (1.0 / distance);
        let share = match *self {
            DeltaSource::Spot { axis, full, soft, .. } => cone_share(-direction, axis, full, soft),
            _ => 1.0,
        };
        Some(Seen { direction, distance, irradiance: share / distance2 })
    }
}

/// 1 within the cone, 0 outside, 3 s^2 - 2 s^3 between.
#[inline(always)]
fn cone_share(light: Vec3, axis: Vec3, full: f64, soft: f64) -> f64 {
    // Not acos: it is poor for narrow cones.
    let angle = light.cross(axis).length_squared().sqrt().atan2(light.dot(axis));
    if angle <= full {
        1.0
    } else if angle >= full + soft {
        0.0
    } else {
        let s = (full + soft - angle) / soft;
        s * s * (3.0 - 2.0 * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_fall_to_nothing_over_their_soft_edge() {
        let spot = DeltaSource::new(&DeltaKind::Spot {
            position: [0.0, 2.0, 0.0],
            axis: [0.0, -1.0, 0.0],
            cone_deg: 60.0,
            soft_deg: 10.0,
        });
        let at = |degrees: f64| {
            let x = 2.0 * degrees.to_radians().tan();
            let seen = spot.seen(Vec3::new(x, 0.0, 0.0)).unwrap();
            seen.irradiance * seen.distance * seen.distance
        };
        for (degrees, share) in
            [(0.0, 1.0), (29.999, 1.0), (32.5, 0.84375), (35.0, 0.5), (37.5, 0.15625), (40.001, 0.0)]
        {
            assert!((at(degrees) - share).abs() < 1e-9, "{degrees}: {}", at(degrees));
        }
        assert!(spot.seen(Vec3::new(0.0, 2.0, 0.0)).is_none());
    }
}
