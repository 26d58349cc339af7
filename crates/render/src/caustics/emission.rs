//! From the lamps: rays over all that mirrors or refracts, and where neighbours land together.

use iridesce_numerics::Vec3;
use rayon::prelude::*;

use super::search::{Aim, Place};
use crate::camera::Ray;
use crate::chain::Chain;
use crate::geometry::frame;
use crate::levels::Spectra;
use crate::lights::chooser::LightId;
use crate::lights::seeds::{Landing, Seed, Seeds};
use crate::materials::Material;
use crate::prepare::Prepared;
use crate::refraction::{bare_reflectance, ratio};
use crate::specular_ray::{SpecularRay, beyond};

/// Rays from all lamps over all that mirrors or refracts.
const RAYS: usize = 40_000;

/// Rays across one such surface, at least and at most.
const SIDE: [usize; 2] = [12, 96];

/// Rays across, times the radius of the lamp seen from the surface, radians: what a lamp blurs need not be told more finely.
const SIDE_BY_WIDTH: f64 = 4.0;

/// Where the outermost rays meet a ball, of its radius: they must not miss it.
const RIM: f64 = 1.0 - 1e-9;

/// So many rays across and down the picture tell what it shows.
const SHOWN: u32 = 8;

/// Pairs of a lamp and a surface, the brightest ones.
const MOST_PAIRS: usize = 64;

/// Lights, and surfaces that mirror or refract, of which pairs are made.
const MOST_LIGHTS: usize = 64;
const MOST_CASTERS: usize = 1024;

/// Surfaces between a lamp and a place.
const MOST_EVENTS: u32 = 8;

/// Share of a ray's light that is still followed.
const LEAST_SHARE: f64 = 1e-5;

/// Share of what a lamp's strongest chain carries below which one is faint.
const FAINT: f64 = 0.02;

/// Irradiance below which a caustic is faint, of that of all lamps with nothing in between: looked for in one sample of sixteen (sixty-four
/// of a lamp with a size), it makes a place this times sqrt(15) noisier than its light (sqrt(63)). A sun and a lamp without size have no other noise; of one with a size,
/// shadows and what surfaces throw on each other have more.
const FAINT_SHARE: f64 = 0.005;
const FAINT_SHARE_OF_EMITTERS: f64 = 0.02;

/// Least irradiance of a caustic, of that of all lamps with nothing in between, that is looked for.
const LEAST_IRRADIANCE: f64 = 1e-4;

/// Least noise of a caustic that branches find by chance, for it to be looked for: variance of a sample over the square of the light
/// of all lamps. A cosine-weighted branch finds the lamp, R L W bright in irradiance over a solid angle W, with probability W / pi; of
/// lamps alone that irradiance is L pi r^2 / d^2, so the noise is the caustic's share of it times R d^2 / r^2.
const LEAST_NOISE: f64 = 0.01;

/// How near a lamp is taken to come to a surface whose ball it lies in, in radii of that ball.
const NEAR: f64 = 0.1;

/// Radius of the lamps that are looked for, seen from the surface that bends their light, radians: larger ones are found.
const LARGEST: f64 = 0.15;

/// A ball around a surface that mirrors or refracts, or around all that is shown where the surface has no end.
#[derive(Debug, Clone, Copy)]
struct Caster {
    /// `None`: any.
    object: Option<usize>,
    center: Vec3,
    radius: f64,
}

/// A small lamp and what may bend its light.
#[derive(Debug, Clone, Copy)]
struct Pair {
    light: LightId,
    caster: Caster,
    /// How much light that is.
    flux: f64,
    /// Most rays across.
    most: usize,
}

/// Where a ray has landed, by what it did on its way.
struct Landed {
    /// The events on its way, the first one lowest, and their number; and the surfaces, in one number.
    events: (u32, u32),
    surfaces: u64,
    place: u32,
    share: f64,
}

/// The seeds of a scene; `None` if nothing throws light of small lamps onto what scatters it.
pub fn seeds(scene: &Prepared) -> Option<Seeds> {
    let spectra = &scene.levels[0];
    let bends = |material: &Material| match material {
        Material::Film(film) => film.rough.is_none(),
        Material::Coating(coating) => coating.rough.is_none(),
        Material::Diffuse { .. } | Material::Emitter(_) => false,
    };
    let casters: Vec<usize> = (0..scene.materials.len()).filter(|&object| bends(&scene.materials[object])).collect();
    if casters.is_empty() || !scene.materials.iter().any(scatters) {
        return None;
    }
    let mut pairs = pairs(scene, &casters);
    if pairs.is_empty() {
        return None;
    }
    // The brightest ones; of equals the first.
    pairs.sort_by(|a, b| b.flux.total_cmp(&a.flux));
    pairs.truncate(MOST_PAIRS);
    let side = (((RAYS / pairs.len()) as f64).sqrt() as usize).clamp(SIDE[0], SIDE[1]);
    let shine = |pair: &Pair| {
        let mut emission = Emission { scene, spectra, landings: Vec::new(), seeds: Vec::new(), fluxes: Vec::new() };
        emission.shine(pair.light, &pair.caster, side.min(pair.most));
        emission
    };
    let mut parts: Vec<Emission<'_>> = pairs.par_iter().map(shine).collect();
    let mut emission = parts.remove(0);
    for part in parts {
        emission.append(part);
    }
    let bands = &spectra.bands;
    let disperses = spectra.media.iter().any(|medium| medium.n_at(bands.ends[0]) != medium.n_at(bands.ends[1]));
    let faint = faint(&emission.fluxes);
    for seed in &mut emission.seeds {
        seed.is_faint |= faint.contains(&(seed.light, seed.chain));
    }
    Seeds::new(emission.seeds, emission.landings, disperses)
}

/// Chains that carry little of what the strongest of their lamp carries.
fn faint(fluxes: &[(LightId, Chain, f64)]) -> Vec<(LightId, Chain)> {
    let most = |light: LightId| fluxes.iter().filter(|own| own.0 == light).fold(0.0_f64, |most, own| most.max(own.2));
    fluxes.iter().filter(|own| own.2 < FAINT * most(own.0)).map(|own| (own.0, own.1)).collect()
}

/// Small lamps and what may bend their light.
fn pairs(scene: &Prepared, casters: &[usize]) -> Vec<Pair> {
    let spectra = &scene.levels[0];
    let all = extent(scene);
    let mut pairs = Vec::new();
    let width = |aim: &Aim, caster: &Caster| match aim.place {
        Place::Beyond(_) => aim.radius,
        Place::At(middle) => {
            let distance = ((caster.center - middle).length_squared().sqrt() - caster.radius).max(NEAR * caster.radius);
            // Of what is all around it nobody knows how near it comes.
            let distance = if caster.object.is_none() { all.1 } else { distance };
            aim.radius / distance
        }
    };
    let mut is_endless = false;
    let mut balls = Vec::new();
    for &object in casters {
        match scene.geometry.ball(object) {
            Some((center, radius)) => balls.push(Caster { object: Some(object), center, radius }),
            None => is_endless = true,
        }
    }
    if is_endless {
        balls.push(Caster { object: None, center: all.0, radius: all.1 });
    }
    // Of very many the brightest and the largest: as many pairs as there are would take for ever to list.
    let mut lights: Vec<LightId> = (0..spectra.lights.count()).map(|at| spectra.lights.id(at)).collect();
    if lights.len() > MOST_LIGHTS {
        let expected = |light: &LightId| spectra.lights.expected(*light, all.0);
        lights.sort_by(|a, b| expected(b).total_cmp(&expected(a)));
        lights.truncate(MOST_LIGHTS);
    }
    if balls.len() > MOST_CASTERS {
        balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
        balls.truncate(MOST_CASTERS);
    }
    for light in lights {
        let Some(aim) = Aim::of(spectra, light) else { continue };
        for caster in &balls {
            let width = width(&aim, caster);
            if width < LARGEST {
                let irradiance = spectra.lights.expected(light, caster.center);
                let most = (SIDE_BY_WIDTH / width).clamp(SIDE[0] as f64, SIDE[1] as f64) as usize;
                pairs.push(Pair { light, caster: *caster, flux: irradiance * caster.radius * caster.radius, most });
            }
        }
    }
    pairs
}

/// A ball around what the picture shows, straight through all that is smooth, and twice as large: light may come aslant.
fn extent(scene: &Prepared) -> (Vec3, f64) {
    let mut places = Vec::new();
    for i in 0..SHOWN * SHOWN {
        let [x, y] = [i % SHOWN, i / SHOWN].map(|k| (f64::from(k) + 0.5) / f64::from(SHOWN));
        let mut ray = scene.camera.ray(x * f64::from(scene.size[0]), y * f64::from(scene.size[1]));
        let mut from = None;
        for _ in 0..MOST_EVENTS {
            let Some(hit) = scene.geometry.nearest(&ray, from.as_ref()) else { break };
            places.push(hit.point);
            if scatters(&scene.materials[hit.object]) {
                break;
            }
            (ray.origin, from) = (hit.point, Some(hit));
        }
    }
    let middle = places.iter().fold(Vec3::default(), |sum, place| sum + *place) * (1.0 / places.len().max(1) as f64);
    let radius2 = places.iter().map(|place| (*place - middle).length_squared()).fold(0.0, f64::max);
    (middle, if radius2 > 0.0 { 2.0 * radius2.sqrt() } else { 1.0 })
}

/// Whether light is scattered there.
fn scatters(material: &Material) -> bool {
    match material {
        Material::Diffuse { is_black, .. } => !is_black,
        Material::Film(film) => film.rough.is_some(),
        Material::Coating(coating) => coating.rough.is_some(),
        Material::Emitter(_) => false,
    }
}

struct Emission<'a> {
    scene: &'a Prepared,
    spectra: &'a Spectra,
    landings: Vec<Landing>,
    seeds: Vec<Seed>,
    /// What chains carry.
    fluxes: Vec<(LightId, Chain, f64)>,
}

impl Emission<'_> {
    fn append(&mut self, other: Emission<'_>) {
        let first = self.landings.len() as u32;
        self.landings.extend(other.landings);
        self.seeds.extend(
            other.seeds.into_iter().map(|seed| Seed { corners: seed.corners.map(|corner| first + corner), ..seed }),
        );
        for (light, chain, flux) in other.fluxes {
            self.carries(light, chain, flux);
        }
    }

    /// Adds to what a chain carries.
    fn carries(&mut self, light: LightId, chain: Chain, flux: f64) {
        match self.fluxes.iter_mut().find(|own| (own.0, own.1) == (light, chain)) {
            Some(own) => own.2 += flux,
            None => self.fluxes.push((light, chain, flux)),
        }
    }

    /// Follows a grid of rays from a light over a surface.
    fn shine(&mut self, light: LightId, caster: &Caster, side: usize) {
        let Some(aim) = Aim::of(self.spectra, light) else { return };
        let rays: Vec<Option<Ray>> = (0..=side)
            .flat_map(|j| (0..=side).map(move |i| (i, j)))
            .map(|(i, j)| {
                let [s, t] = [i, j].map(|k| 2.0 * k as f64 / side as f64 - 1.0);
                ray(&aim, caster, [s, t])
            })
            .collect();
        let landed: Vec<Vec<Landed>> = rays.iter().map(|ray| self.follow(light, caster, ray.as_ref())).collect();
        let at = |i: usize, j: usize| j * (side + 1) + i;
        for j in 0..side {
            for i in 0..side {
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                for three in [[0, 1, 2], [0, 2, 3]] {
                    self.join(light, &aim, three.map(|k| corners[k]), &rays, &landed);
                }
            }
        }
    }

    /// Makes seeds of what three neighbouring rays have in common.
    fn join(&mut self, light: LightId, aim: &Aim, three: [usize; 3], rays: &[Option<Ray>], landed: &[Vec<Landed>]) {
        let [Some(a), Some(b), Some(c)] = three.map(|k| rays[k]) else { return };
        for first in &landed[three[0]] {
            let same = |other: &&Landed| other.events == first.events && other.surfaces == first.surfaces;
            let (Some(second), Some(third)) = (landed[three[1]].iter().find(same), landed[three[2]].iter().find(same))
            else {
                continue;
            };
            let corners = [first.place, second.place, third.place];
            let [p, q, r] = corners.map(|corner| self.landings[corner as usize].point);
            let light_comes = (p - self.landings[corners[0] as usize].left).normalized();
            let area = 0.5 * (q - p).cross(r - p).dot(light_comes).abs();
            let share = (first.share + second.share + third.share) / 3.0;
            let flux = match aim.place {
                // Solid angle, of a light whose intensity is what it gives at a distance of 1.
                Place::At(middle) => {
                    let angle =
                        0.5 * (b.direction - a.direction).cross(c.direction - a.direction).length_squared().sqrt();
                    let away = p - middle;
                    let far2 = away.length_squared();
                    let there = middle + a.direction * far2.sqrt();
                    angle * far2 * self.spectra.lights.expected(light, there)
                }
                Place::Beyond(direction) => {
                    0.5 * (b.origin - a.origin).cross(c.origin - a.origin).dot(direction).abs()
                        * self.spectra.lights.expected(light, p)
                }
            };
            let lights = &self.spectra.lights;
            let direct = if lights.count() > MOST_LIGHTS { lights.expected(light, p) } else { lights.all_expected(p) };
            // Where rays cross, as much as a good lens makes.
            let irradiance = (share * flux / area.max(1e-300)).min(1e6 * direct);
            let noise = irradiance / direct * share * lights.expected(light, p) / direct / aim.width2(p);
            if irradiance > LEAST_IRRADIANCE * direct && noise > LEAST_NOISE {
                let (events, count) = first.events;
                let chain = Chain::reversed(events, count);
                self.carries(light, chain, share * flux);
                let least = match light {
                    LightId::Emitter(_) => FAINT_SHARE_OF_EMITTERS,
                    _ => FAINT_SHARE,
                };
                let is_faint = irradiance < least * direct;
                self.seeds.push(Seed { light, chain, corners, irradiance: irradiance as f32, is_faint });
            }
        }
    }

    /// Where a ray lands, on all its ways.
    fn follow(&mut self, light: LightId, caster: &Caster, ray: Option<&Ray>) -> Vec<Landed> {
        let mut found = Vec::new();
        let Some(ray) = ray else { return found };
        let own = match light {
            LightId::Emitter(emitter) => self.spectra.lights.area_lights[emitter].object,
            _ => usize::MAX,
        };
        let scene = self.scene;
        let Some(first) = scene.geometry.nearest_of(ray, None, &|object| object != own) else { return found };
        // Of one without an end, what is not a surface with one.
        if caster.object != Some(first.object)
            && (caster.object.is_some() || scene.geometry.ball(first.object).is_some())
        {
            return found;
        }
        let medium = scene.media_at(ray.origin);
        if scene.has_priorities && scene.behind_hidden(&first, ray.direction, medium).is_some() {
            return found;
        }
        struct Way {
            along: SpecularRay,
            events: (u32, u32),
            surfaces: u64,
            share: f64,
        }
        let start = SpecularRay { hit: first, direction: ray.direction, medium, band: None, is_bent: false };
        let mut ways = vec![Way { along: start, events: (0, 0), surfaces: 0, share: 1.0 }];
        while let Some(way) = ways.pop() {
            let (number, count) = way.events;
            let material = &scene.materials[way.along.hit.object];
            if count == MOST_EVENTS {
                continue;
            }
            for mirrors in [true, false] {
                let mut along = way.along;
                let share = way.share * answer(self.spectra, &along, material, mirrors);
                if share <= LEAST_SHARE || along.turn(scene, self.spectra, mirrors, self.spectra.bands.middle).is_none()
                {
                    continue;
                }
                let left = along.hit.point;
                let Some(next) = scene.next_that_is_there(&along.hit, along.direction, &mut along.medium) else {
                    continue;
                };
                let events = (number | u32::from(mirrors) << count, count + 1);
                let surfaces = way.surfaces.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(along.hit.part.into());
                along.hit = next;
                if scatters(&scene.materials[next.object]) {
                    if along.is_bent {
                        let surfaces = surfaces.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(next.part.into());
                        let place = self.landings.len() as u32;
                        self.landings.push(Landing { point: next.point, left });
                        found.push(Landed { events, surfaces, place, share });
                    }
                } else {
                    ways.push(Way { along, events, surfaces, share });
                }
            }
        }
        found
    }
}

/// About the share of light that a surface mirrors or passes.
fn answer(spectra: &Spectra, along: &SpecularRay, material: &Material, mirrors: bool) -> f64 {
    let cos = along.direction.dot(along.hit.normal);
    let mirrored = match material {
        Material::Film(_) => 0.1,
        Material::Coating(coating) if coating.is_opaque => 0.7,
        Material::Coating(coating) => {
            let Some(beyond) = beyond(coating, along.medium, cos < 0.0) else { return 0.0 };
            let media = [along.medium, beyond].map(|medium| &spectra.media[usize::from(medium.innermost())]);
            bare_reflectance(cos.abs().min(1.0), ratio(media, spectra.bands.middle)).max(1e-3)
        }
        Material::Diffuse { .. } | Material::Emitter(_) => return 0.0,
    };
    if mirrors { mirrored } else { 1.0 - mirrored }
}

/// A place of the disc that a ball is seen as, from one of the square around it: the rim is met on the rim, and rays that a ball mirrors lie
/// evenly, since their angles of incidence do. (The square by concentric squares and circles: P. Shirley, K. Chiu, "A low distortion
/// map between disk and square", Journal of Graphics Tools 2(3), 45 (1997).)
fn over_ball([s, t]: [f64; 2]) -> [f64; 2] {
    let rho = s.abs().max(t.abs());
    if rho == 0.0 {
        return [0.0, 0.0];
    }
    let radius = (std::f64::consts::FRAC_PI_2 * rho).sin() * RIM;
    let along = |long: f64, short: f64| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * short / long).sin_cos();
        [cos, sin].map(|part| part * radius * long.signum())
    };
    if s.abs() >= t.abs() {
        along(s, t)
    } else {
        let [y, x] = along(t, s);
        [x, y]
    }
}

/// A ray from a light over a ball, at a place of the square around it.
fn ray(aim: &Aim, caster: &Caster, [s, t]: [f64; 2]) -> Option<Ray> {
    let reach = caster.radius;
    let square = [s, t];
    let [s, t] = over_ball(square);
    match aim.place {
        Place::Beyond(direction) => {
            let (across, up) = frame(direction);
            // From beyond all of it.
            let origin = caster.center + across * (s * reach) + up * (t * reach) + direction * (1e3 * reach);
            Some(Ray { origin, direction: -direction })
        }
        Place::At(middle) => {
            let away = caster.center - middle;
            let sine2 = reach * reach / away.length_squared();
            if sine2 < 0.75 {
                let axis = away.normalized();
                let (across, up) = frame(axis);
                let tangent = (sine2 / (1.0 - sine2)).sqrt();
                let direction = (axis + across * (s * tangent) + up * (t * tangent)).normalized();
                return Some(Ray { origin: middle, direction });
            }
            let [s, t] = square;
            // All around: a square folded over a sphere (an octahedron opened).
            let height = 1.0 - s.abs() - t.abs();
            let (x, z) =
                if height >= 0.0 { (s, t) } else { ((1.0 - t.abs()).copysign(s), (1.0 - s.abs()).copysign(t)) };
            Some(Ray { origin: middle, direction: Vec3::new(x, height, z).normalized() })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares become circles, without a jump and without a fold; the rim is met, and angles of incidence lie evenly.
    #[test]
    fn rays_over_a_ball_reach_its_rim() {
        let side = 64;
        let at = |i: i32, j: i32| over_ball([i, j].map(|k| f64::from(k) / f64::from(side)));
        for i in -side..=side {
            for j in -side..=side {
                let [x, y] = at(i, j);
                let ring = f64::from(i.abs().max(j.abs())) / f64::from(side);
                let incidence = (x.hypot(y) / RIM).min(1.0).asin();
                assert!((incidence - std::f64::consts::FRAC_PI_2 * ring).abs() < 1e-6, "{i} {j}");
                if i < side && j < side {
                    let ([a, b], [c, d]) = (at(i + 1, j), at(i, j + 1));
                    assert!((a - x) * (d - y) - (b - y) * (c - x) > 0.0, "folded at {i} {j}");
                    assert!((a - x).hypot(b - y).max((c - x).hypot(d - y)) < 3.5 / f64::from(side), "torn at {i} {j}");
                }
            }
        }
    }
}
