//! From a place to a lamp along a chain of surfaces, by Newton's method.

use iridesce_numerics::Vec3;

use super::lobe::{Lobe, solve};
use crate::camera::Ray;
use crate::chain::Chain;
use crate::geometry::{Hit, frame};
use crate::levels::Spectra;
use crate::lights::chooser::LightId;
use crate::lights::delta::DeltaSource;
use crate::medium_stack::MediumStack;
use crate::prepare::Prepared;
use crate::specular_ray::SpecularRay;

/// By how much a direction turns where derivatives are taken, radians.
const TURN: f64 = 1e-5;

/// Steps of Newton's method.
const STEPS: u32 = 12;

/// How far from a lamp's middle a solution may miss it, of its radius; of lights without size, of the way to them.
const MISS: [f64; 2] = [0.1, 1e-9];

/// Where a light is.
#[derive(Debug, Clone, Copy)]
pub enum Place {
    At(Vec3),
    /// Infinitely far away in this direction.
    Beyond(Vec3),
}

/// Of a light whose caustics are looked for.
#[derive(Debug, Clone, Copy)]
pub struct Aim {
    pub place: Place,
    /// As far as a ray may miss its middle: a length, or of lights far away the sine of an angle. 0 of lights without size.
    pub radius: f64,
}

impl Aim {
    /// `None` of lights that are not aimed at.
    pub fn of(spectra: &Spectra, light: LightId) -> Option<Aim> {
        let lights = &spectra.lights;
        Some(match light {
            LightId::Maps => return None,
            LightId::Sun(sun) => {
                let disc = &lights.suns[sun];
                let sine = (1.0 - disc.cos_radius * disc.cos_radius).max(0.0).sqrt();
                Aim { place: Place::Beyond(disc.direction), radius: sine }
            }
            LightId::Emitter(emitter) => {
                let (middle, radius) = lights.area_lights[emitter].around()?;
                Aim { place: Place::At(middle), radius }
            }
            LightId::Delta(delta) => match lights.deltas[delta].source {
                DeltaSource::Directional(direction) => Aim { place: Place::Beyond(direction), radius: 0.0 },
                DeltaSource::Point(position) | DeltaSource::Spot { position, .. } => {
                    Aim { place: Place::At(position), radius: 0.0 }
                }
            },
        })
    }

    /// The square of its radius seen from a place, as a sine.
    pub fn width2(&self, from: Vec3) -> f64 {
        match self.place {
            Place::At(middle) => self.radius * self.radius / (middle - from).length_squared(),
            Place::Beyond(_) => self.radius * self.radius,
        }
    }

    /// By how much a ray misses it, at right angles to the ray; `None` if it runs away from it.
    #[inline(always)]
    fn miss(&self, ray: &Ray) -> Option<Vec3> {
        match self.place {
            Place::At(middle) => {
                let away = middle - ray.origin;
                let along = away.dot(ray.direction);
                (along > 0.0).then(|| ray.direction * along - away)
            }
            Place::Beyond(direction) => {
                let along = direction.dot(ray.direction);
                (along > 0.0).then(|| ray.direction - direction * along)
            }
        }
    }

    /// How far a solution may miss it.
    fn tolerance(&self, from: Vec3) -> f64 {
        if self.radius > 0.0 {
            return MISS[0] * self.radius;
        }
        MISS[1]
            * match self.place {
                Place::At(middle) => (middle - from).length_squared().sqrt(),
                Place::Beyond(_) => 1.0,
            }
    }
}

/// A place that light is scattered from.
#[derive(Debug, Clone, Copy)]
pub struct Departure {
    pub hit: Hit,
    pub medium: MediumStack,
    /// The normal of the surface on the side where paths leave.
    pub facing: Vec3,
    /// The place in the spectrum of a path that was parted before.
    pub band: Option<f64>,
}

/// What looks for lamps.
pub struct Search<'a> {
    pub scene: &'a Prepared,
    pub spectra: &'a Spectra,
    pub from: &'a Departure,
    /// Where in the spectrum, once wavelengths are parted.
    pub chosen: f64,
}

impl Search<'_> {
    /// Adds the lobe that is found from a direction, unless it is there already.
    pub fn add(&self, light: LightId, chain: Chain, direction: Vec3, lobes: &mut Vec<Lobe>) {
        if let Some(lobe) = self.lobe(light, chain, direction)
            && !lobes.iter().any(|other| lobe.is(other))
        {
            lobes.push(lobe);
        }
    }

    /// Newton's method from a direction.
    fn lobe(&self, light: LightId, chain: Chain, start: Vec3) -> Option<Lobe> {
        let aim = Aim::of(self.spectra, light)?;
        let tolerance = aim.tolerance(self.from.hit.point);
        let (mut axis, mut end) = (start, self.end(chain, start)?);
        let mut missed = aim.miss(&end)?;
        for _ in 0..STEPS {
            let (across, up) = frame(axis);
            let to = match aim.place {
                Place::At(_) => frame(end.direction),
                Place::Beyond(direction) => frame(direction),
            };
            let on = |missed: Vec3| [missed.dot(to.0), missed.dot(to.1)];
            let miss = on(missed);
            let beside = |turned: Vec3| Some(on(aim.miss(&self.end(chain, (axis + turned * TURN).normalized())?)?));
            let (by_across, by_up) = (beside(across)?, beside(up)?);
            let turn = [0, 1].map(|i| [(by_across[i] - miss[i]) / TURN, (by_up[i] - miss[i]) / TURN]);
            let determinant = (turn[0][0] * turn[1][1] - turn[0][1] * turn[1][0]).abs();
            if !(determinant > 0.0 && determinant < f64::INFINITY) {
                return None;
            }
            if missed.length_squared() <= tolerance * tolerance {
                return (axis.dot(self.from.facing) > 0.0).then_some(Lobe {
                    light,
                    chain,
                    axis,
                    across,
                    up,
                    turn,
                    miss,
                    determinant,
                    radius: aim.radius,
                });
            }
            let step = solve(&turn, miss);
            let length = (step[0] * step[0] + step[1] * step[1]).sqrt();
            let mut share = 1.0_f64.min(0.2 / length);
            // Back towards where it stood until it misses by less.
            loop {
                let there = (axis - across * (share * step[0]) - up * (share * step[1])).normalized();
                if let Some(ray) = self.end(chain, there)
                    && let Some(less) = aim.miss(&ray)
                    && less.length_squared() < missed.length_squared()
                {
                    (axis, end, missed) = (there, ray, less);
                    break;
                }
                share *= 0.5;
                if share < 0.05 {
                    return None;
                }
            }
        }
        None
    }

    /// The ray that leaves the chain's last surface.
    #[inline(always)]
    fn end(&self, chain: Chain, direction: Vec3) -> Option<Ray> {
        let from = self.from;
        let mut along = SpecularRay { hit: from.hit, direction, medium: from.medium, band: from.band, is_bent: false };
        for mirrors in chain.events() {
            along.step(self.scene, self.spectra, mirrors, self.chosen)?;
        }
        Some(Ray { origin: along.hit.point, direction: along.direction })
    }
}
