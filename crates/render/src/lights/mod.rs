//! All the light of a scene, added up: uniform lights are one set of spectral weights, maps one RGB radiance.
//!
//! Suns, emitters and lights without size ([`delta`]) are sampled one by one or by what is expected of them ([`chooser`]).

pub mod chooser;
pub mod delta;
pub mod polarization;
pub mod seeds;

use std::sync::Arc;

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::OpticsError;
use iridesce_optics::color::{Illuminant, Observer, REC709_LUMINANCE, rgb_basis};
use iridesce_scene::{Emitter, Light, ResolvedEnvironment, ResolvedScene, ResolvedSource, Sun};

use self::chooser::{Extent, FEW, LightId, expected_picks};
use self::delta::DeltaSource;
use self::polarization::Linear;
use crate::environment::{MapLookup, MapSampler};
use crate::spectral::Nodes;

/// Light that a path finds.
#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// All lights that are the same in every direction.
    Uniform,
    /// The maps, where they have this linear Rec.709 radiance.
    Map([f32; 3]),
    /// A light that is sampled.
    Light(LightId),
}

/// What a light emits at a block of nodes, halved as [`Weights`] are.
pub struct Emitted {
    pub weights: [[f32; LANES]; 3],
    /// Spectral radiance ([`Nodes::radiance`]).
    pub radiance: [f32; LANES],
}

/// Weights of X, Y, Z at a block of nodes. They are halved because they meet the sum of s and p weights.
type Weights = [Lanes; 3];

/// Spectra and weights of the maps at a block of nodes, side by side in memory as they are read.
#[derive(Clone, Copy)]
struct MapBlock {
    /// Spectra of linear Rec.709 red, green and blue relative to D65; their sum is 1.
    basis: [Lanes; 3],
    /// D65, by which the radiance of a map is meant.
    weights: Weights,
}

/// What lights of a scene look like by direction: the same whatever the nodes are.
pub struct EnvironmentLight {
    maps: Arc<Vec<(MapLookup, f32)>>,
    mean_rgb: [f32; 3],
    least_rgb: [f32; 3],
    /// The density by which diffuse and rough surfaces sample the maps.
    sampler: Option<Arc<MapSampler>>,
}

impl EnvironmentLight {
    /// `is_sampled`: diffuse or rough surfaces will sample the maps.
    pub fn new(environments: &[ResolvedEnvironment], is_sampled: bool) -> EnvironmentLight {
        let mut maps = Vec::new();
        for environment in environments {
            if let ResolvedSource::Map(map) | ResolvedSource::Sky(map, _) = &environment.source {
                maps.push((MapLookup::new(map.clone(), environment.rotation_deg), environment.radiance as f32));
            }
        }
        let [mut mean_rgb, mut least_rgb] = [[0.0; 3]; 2];
        for (lookup, factor) in &maps {
            for (sum, mean) in mean_rgb.iter_mut().zip(lookup.mean_rgb()) {
                *sum += factor * mean;
            }
            for (sum, least) in least_rgb.iter_mut().zip(lookup.least_rgb()) {
                *sum += factor * least;
            }
        }
        let sampler = (is_sampled && !maps.is_empty()).then(|| Arc::new(MapSampler::new(&maps)));
        EnvironmentLight { maps: Arc::new(maps), mean_rgb, least_rgb, sampler }
    }
}

/// A disc of light, infinitely far away.
pub struct SunDisc {
    pub direction: Vec3,
    pub cos_radius: f64,
    weights: Vec<Weights>,
    radiance: Vec<Lanes>,
    /// Its XYZ with nothing in between.
    pub xyz: [f64; 3],
    pub linear: Option<Linear>,
    /// It belongs to a sky.
    pub is_of_sky: bool,
}

impl SunDisc {
    /// The Y of its irradiance on what faces it.
    #[inline(always)]
    pub fn irradiance(&self) -> f64 {
        self.xyz[1] * std::f64::consts::PI * (1.0 - self.cos_radius * self.cos_radius)
    }

    /// Whether it is seen in a direction.
    #[inline(always)]
    pub fn is_at(&self, direction: Vec3) -> bool {
        direction.dot(self.direction) >= self.cos_radius
    }
}

/// A surface that emits.
pub struct AreaLight {
    pub object: usize,
    weights: Vec<Weights>,
    radiance: Vec<Lanes>,
    pub linear: Option<Linear>,
    /// The Y of its radiance.
    power: f64,
    extent: Option<Extent>,
}

impl AreaLight {
    /// The middle of a surface, and the radius of a sphere around it; `None` of what is not drawn from.
    pub fn around(&self) -> Option<(Vec3, f64)> {
        self.extent.map(|extent| extent.ball())
    }
}

/// A light without size.
pub struct DeltaLamp {
    pub source: DeltaSource,
    weights: Vec<Weights>,
    radiance: Vec<Lanes>,
    linear: Option<Linear>,
    power: f64,
}

/// The lights of a scene. Light is linear, so any number of environments costs no more than these.
pub struct Lights {
    /// Sum of all lights that are the same in every direction.
    uniform: Vec<Weights>,
    uniform_radiance: Vec<Lanes>,
    /// Its XYZ with nothing in between.
    pub uniform_xyz: [f64; 3],
    maps: Arc<Vec<(MapLookup, f32)>>,
    map_blocks: Vec<MapBlock>,
    map_radiance: Vec<Lanes>,
    /// One over the share of natural light that the picture's weights stand for.
    whole: f32,
    /// Mean of all maps over the sphere.
    pub mean_rgb: [f32; 3],
    /// What of all maps is there in every direction.
    pub least_rgb: [f32; 3],
    pub sampler: Option<Arc<MapSampler>>,
    /// XYZ of a map's bare red, green and blue.
    rgb_to_xyz: [[f64; 3]; 3],
    pub suns: Vec<SunDisc>,
    /// In the order of their numbers.
    pub area_lights: Vec<AreaLight>,
    pub deltas: Vec<DeltaLamp>,
}

/// Direction, cosine of the radius, weights and radiance of a sun at the nodes.
type SkySun = (Vec3, f64, [Vec<f64>; 3], Vec<f64>);

/// An object that emits.
pub struct EmittingObject<'a> {
    pub object: usize,
    pub emitter: &'a Emitter,
    pub extent: Option<Extent>,
}

impl Lights {
    /// `emitters`: in the order of their numbers.
    pub fn new(
        scene: &ResolvedScene,
        nodes: &Nodes,
        around: &EnvironmentLight,
        emitters: &[EmittingObject<'_>],
    ) -> Result<Lights, OpticsError> {
        let map_weights = halved(&Illuminant::named("D65")?, nodes);
        let basis: [Vec<f64>; 3] =
            std::array::from_fn(|rgb| nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[rgb]).collect());
        let rgb_to_xyz = std::array::from_fn(|rgb| {
            std::array::from_fn(|c| map_weights[c].iter().zip(&basis[rgb]).map(|(w, f)| 2.0 * w * f).sum::<f64>())
        });
        let mut uniform: Option<[Vec<f64>; 3]> = None;
        let mut uniform_radiance = vec![0.0; nodes.row_len()];
        let mut suns: Vec<SkySun> = Vec::new();
        let radiance_of = |illuminant: &Illuminant, power: f64| -> Vec<f64> {
            // Halved, as all weights are; of renders without spectra nobody asks.
            let has_spectra = nodes.probes().len() > 0;
            let values = if has_spectra { nodes.radiance(illuminant) } else { vec![0.0; nodes.row_len()] };
            values.into_iter().map(|value| 0.5 * power * value).collect()
        };
        let radiance_blocks = |illuminant: &Illuminant, power: f64| blocks(radiance_of(illuminant, power).into_iter());
        let cos_radius = |sun: &Sun| sun.angular_radius_deg.to_radians().cos();
        for environment in &scene.environments {
            match &environment.source {
                ResolvedSource::Map(_) => {}
                ResolvedSource::Sky(_, sun) => {
                    let weights = scaled(&halved(&sun.illuminant, nodes), environment.radiance * sun.radiance);
                    let direction = turned(sun.direction.into(), environment.rotation_deg).normalized();
                    let cos_radius = cos_radius(sun);
                    // Two skies have one sun, of both radiances: a place of the sky is looked up in one disc.
                    let radiance = radiance_of(&sun.illuminant, environment.radiance * sun.radiance);
                    match suns.iter_mut().find(|(there, cos, ..)| (*there, *cos) == (direction, cos_radius)) {
                        Some((_, _, sum, total)) => {
                            add_to(sum, &weights);
                            total.iter_mut().zip(radiance).for_each(|(total, own)| *total += own);
                        }
                        None => suns.push((direction, cos_radius, weights, radiance)),
                    }
                }
                ResolvedSource::Uniform(illuminant) => {
                    let own = scaled(&halved(illuminant, nodes), environment.radiance);
                    let sum = uniform.get_or_insert_with(|| std::array::from_fn(|_| vec![0.0; nodes.len()]));
                    add_to(sum, &own);
                    let radiance = radiance_of(illuminant, environment.radiance);
                    uniform_radiance.iter_mut().zip(radiance).for_each(|(total, own)| *total += own);
                }
            }
        }
        let sun_disc = |(direction, cos_radius, weights, radiance): SkySun, linear, is_of_sky| SunDisc {
            direction,
            cos_radius,
            xyz: sums(&weights),
            weights: in_blocks(weights),
            radiance: blocks(radiance.into_iter()),
            linear,
            is_of_sky,
        };
        let mut suns: Vec<SunDisc> = suns.into_iter().map(|disc| sun_disc(disc, None, true)).collect();
        let mut deltas = Vec::new();
        for light in &scene.recipe.lights {
            match light {
                Light::Environment(_) => {}
                Light::Sun(sun) => {
                    let weights = scaled(&halved(&sun.illuminant, nodes), sun.radiance);
                    let radiance = radiance_of(&sun.illuminant, sun.radiance);
                    let disc = (sun.direction.into(), cos_radius(sun), weights, radiance);
                    suns.push(sun_disc(disc, sun.polarized_deg.map(Linear::new), false));
                }
                Light::Delta(delta) => deltas.push(DeltaLamp {
                    source: DeltaSource::new(&delta.kind),
                    weights: in_blocks(scaled(&halved(&delta.illuminant, nodes), delta.power)),
                    radiance: radiance_blocks(&delta.illuminant, delta.power),
                    linear: delta.polarized_deg.map(Linear::new),
                    power: delta.power,
                }),
            }
        }
        let area_light = |&EmittingObject { object, emitter, extent }: &EmittingObject<'_>| AreaLight {
            object,
            weights: in_blocks(scaled(&halved(&emitter.illuminant, nodes), emitter.radiance)),
            radiance: radiance_blocks(&emitter.illuminant, emitter.radiance),
            linear: emitter.polarized_deg.map(Linear::new),
            power: emitter.radiance,
            extent,
        };
        Ok(Lights {
            uniform_xyz: uniform.as_ref().map_or([0.0; 3], sums),
            uniform: uniform.map(in_blocks).unwrap_or_default(),
            uniform_radiance: blocks(uniform_radiance.into_iter()),
            map_radiance: radiance_blocks(&Illuminant::named("D65")?, 1.0),
            whole: 1.0,
            maps: around.maps.clone(),
            mean_rgb: around.mean_rgb,
            least_rgb: around.least_rgb,
            sampler: around.sampler.clone(),
            map_blocks: in_blocks(map_weights)
                .into_iter()
                .zip(in_blocks(basis))
                .map(|(weights, basis)| MapBlock { basis, weights })
                .collect(),
            rgb_to_xyz,
            suns,
            area_lights: emitters.iter().map(area_light).collect(),
            deltas,
        })
    }

    /// Weights of Y at a block of nodes for D65, whatever the lights are; halved.
    #[inline(always)]
    pub fn white<S: Simd>(&self, simd: S, block: usize) -> f32x16<S> {
        self.map_blocks[block].weights[1].load(simd)
    }

    /// How many lights are sampled, the maps apart.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.suns.len() + self.area_lights.len() + self.deltas.len()
    }

    /// The lights in the order in which they are sampled.
    #[inline(always)]
    pub fn id(&self, at: usize) -> LightId {
        let (suns, emitters) = (self.suns.len(), self.area_lights.len());
        if at < suns {
            LightId::Sun(at)
        } else if at < suns + emitters {
            LightId::Emitter(at - suns)
        } else {
            LightId::Delta(at - suns - emitters)
        }
    }

    /// About the Y of the irradiance that a light makes at a place on what faces it.
    #[inline(always)]
    pub fn expected(&self, light: LightId, from: Vec3) -> f64 {
        match light {
            LightId::Maps => 0.0,
            LightId::Sun(sun) => self.suns[sun].irradiance(),
            LightId::Emitter(emitter) => {
                let light = &self.area_lights[emitter];
                light.power * light.extent.map_or(0.0, |extent| extent.irradiance(from))
            }
            LightId::Delta(delta) => {
                let light = &self.deltas[delta];
                light.power * light.source.seen(from).map_or(0.0, |seen| seen.irradiance)
            }
        }
    }

    /// About the Y of the irradiance that all sampled lights make at a place on what faces them, the maps apart.
    pub fn all_expected(&self, from: Vec3) -> f64 {
        (0..self.count()).map(|at| self.expected(self.id(at), from)).sum()
    }

    /// What is expected of every light at a place, each added to all before it.
    #[inline(always)]
    pub fn add_up_expected(&self, from: Vec3, sums: &mut Vec<f64>) {
        sums.clear();
        let mut sum = 0.0;
        for at in 0..self.count() {
            sum += self.expected(self.id(at), from);
            sums.push(sum);
        }
    }

    /// How often a light is sampled from a place, on average.
    #[inline(always)]
    pub fn expected_picks(&self, light: LightId, from: Vec3) -> f64 {
        let count = self.count();
        if count <= FEW {
            return 1.0;
        }
        let total = (0..count).map(|at| self.expected(self.id(at), from)).sum();
        expected_picks(self.expected(light, from), total, count)
    }

    /// The mean radiance Y, over all directions and some places, that a light is worth there.
    fn mean_radiance(&self, light: LightId, places: &[Vec3]) -> f64 {
        let sum: f64 = places.iter().map(|place| self.expected(light, *place)).sum();
        sum / (places.len() as f64 * std::f64::consts::PI)
    }

    /// By what a path's s and p weights are judged: the Y weights of the lights, each by how much light it is expected to
    /// give at `places` of the scene, scaled to a sum of 1/2.
    ///
    /// They are kept even where a cardinal spline dips below zero: choices in proportion to exactly the luminance
    /// that the picture shows are what keeps a white furnace white.
    pub fn importance(&self, places: &[Vec3]) -> Vec<Lanes> {
        self.mixture(places, [0.0, 1.0, 0.0])
    }

    /// By what places in the spectrum are chosen: X and Z of the lights count too. By Y alone one choice in fifty is blue, and
    /// stands for fifty times its light.
    pub fn color_importance(&self, places: &[Vec3]) -> Vec<Lanes> {
        self.mixture(places, [0.25, 0.5, 0.25])
    }

    /// Weights of the lights, of X, Y, Z in these shares, each light by how much Y it is expected to give.
    fn mixture(&self, places: &[Vec3], shares: [f32; 3]) -> Vec<Lanes> {
        let of = |weights: &[Weights], shares: [f32; 3]| -> Vec<Lanes> {
            let sum = |[x, y, z]: &Weights, at: usize| x.0[at] * shares[0] + y.0[at] * shares[1] + z.0[at] * shares[2];
            weights.iter().map(|w| iridesce_numerics::lanes::Lanes(std::array::from_fn(|at| sum(w, at)))).collect()
        };
        let y = |weights: &[Weights]| -> Vec<Lanes> { of(weights, [0.0, 1.0, 0.0]) };
        let total = |weights: &[Lanes]| weights.iter().flat_map(|l| l.0).map(f64::from).sum::<f64>();
        let maps: Vec<Weights> = self.map_blocks.iter().map(|block| block.weights).collect();
        let map_y: f64 = self.mean_rgb.iter().zip(REC709_LUMINANCE).map(|(v, y)| f64::from(*v) * y).sum();
        // The sun of a sky is of the sky's own colour, and counts with it.
        let suns = self.suns.iter().map(|sun| if sun.is_of_sky { &[] } else { &sun.weights[..] });
        let single = suns
            .chain(self.area_lights.iter().map(|light| &light.weights[..]))
            .chain(self.deltas.iter().map(|light| &light.weights[..]))
            .enumerate()
            .map(|(at, weights)| (weights, self.mean_radiance(self.id(at), places)));
        let uniform_y = 2.0 * total(&y(&self.uniform));
        let has_maps = self.has_maps();
        let kinds: Vec<(Vec<Lanes>, f64, f64)> =
            [(&self.uniform[..], uniform_y), (&maps[..], if has_maps { map_y } else { 0.0 })]
                .into_iter()
                .chain(single)
                .map(|(weights, worth)| (of(weights, shares), total(&y(weights)), worth))
                .filter(|(_, total, worth)| *worth > 0.0 && *total > 0.0)
                .collect();
        let mut sum = vec![0.0; self.map_blocks.len() * LANES];
        for (weights, total, worth) in &kinds {
            // One alone keeps exactly its own weights.
            let scale = if kinds.len() == 1 { 1.0 } else { worth / total };
            for (sum, weight) in sum.iter_mut().zip(weights.iter().flat_map(|l| l.0)) {
                *sum += scale * f64::from(weight);
            }
        }
        if kinds.is_empty() {
            sum.fill(1.0);
        }
        let all: f64 = sum.iter().sum();
        blocks(sum.into_iter().map(|w| 0.5 * w / all))
    }

    /// Sets what a polariser before the camera passes of each Stokes component, where a path carries a row for each: the
    /// picture's colours are then the sum of the rows in these shares. For all lights, and after their importance is known.
    pub fn polarize(&mut self, passes: [f64; 4]) {
        let spread = |weights: &mut Vec<Weights>| {
            let base = weights.len() / passes.len();
            for at in base..weights.len() {
                let passes = passes[at / base];
                weights[at] = weights[at % base].map(|lanes| scaled_lanes(lanes, passes));
            }
            for weights in &mut weights[..base] {
                *weights = weights.map(|lanes| scaled_lanes(lanes, passes[0]));
            }
        };
        spread(&mut self.uniform);
        self.suns.iter_mut().for_each(|sun| spread(&mut sun.weights));
        self.area_lights.iter_mut().for_each(|light| spread(&mut light.weights));
        self.deltas.iter_mut().for_each(|light| spread(&mut light.weights));
        let mut maps: Vec<Weights> = self.map_blocks.iter().map(|block| block.weights).collect();
        spread(&mut maps);
        self.map_blocks.iter_mut().zip(maps).for_each(|(block, weights)| block.weights = weights);
        self.whole = (1.0 / passes[0]) as f32;
    }

    /// What a light emits at a block of the first row, for sums beside those of the picture.
    pub fn emitted(&self, source: Source, block: usize) -> Emitted {
        let plain = |weights: Option<&Weights>, radiance: &[Lanes]| Emitted {
            weights: weights.map_or([[0.0; LANES]; 3], |own| own.map(|lanes| lanes.0.map(|w| w * self.whole))),
            radiance: radiance[block].0,
        };
        let single = |weights: &[Weights], radiance: &[Lanes]| plain(weights.get(block), radiance);
        match source {
            Source::Uniform => single(&self.uniform, &self.uniform_radiance),
            Source::Light(LightId::Sun(sun)) => single(&self.suns[sun].weights, &self.suns[sun].radiance),
            Source::Light(LightId::Emitter(emitter)) => {
                single(&self.area_lights[emitter].weights, &self.area_lights[emitter].radiance)
            }
            Source::Light(LightId::Delta(delta)) => single(&self.deltas[delta].weights, &self.deltas[delta].radiance),
            Source::Light(LightId::Maps) => unreachable!("maps are found with their radiance"),
            Source::Map(rgb) => {
                let MapBlock { basis, weights } = &self.map_blocks[block];
                let mut emitted = plain(Some(weights), &self.map_radiance);
                for lane in 0..LANES {
                    let spectrum: f32 = (0..3).map(|c| rgb[c] * basis[c].0[lane]).sum();
                    emitted.radiance[lane] *= spectrum;
                    emitted.weights.iter_mut().for_each(|channel| channel[lane] *= spectrum);
                }
                emitted
            }
        }
    }

    /// Whether any light far away depends on direction.
    #[inline(always)]
    pub fn depend_on_direction(&self) -> bool {
        !self.maps.is_empty() || !self.suns.is_empty()
    }

    /// Whether all light from far away is that of maps that surfaces which scatter sample, and by that alone.
    #[inline(always)]
    pub fn are_all_sampled(&self) -> bool {
        self.sampler.is_some() && self.uniform.is_empty() && self.suns.is_empty()
    }

    /// Whether there are maps.
    #[inline(always)]
    pub fn has_maps(&self) -> bool {
        !self.maps.is_empty()
    }

    /// The sun in this direction, and whether that is all of it: one sun, of natural light.
    #[inline(always)]
    pub fn sun_at(&self, direction: Vec3) -> Option<(usize, bool)> {
        let mut there = self.suns.iter().enumerate().filter(|(_, sun)| sun.is_at(direction));
        let (first, sun) = there.next()?;
        Some((first, sun.linear.is_none() && there.next().is_none()))
    }

    /// The polarisation of a light.
    #[inline(always)]
    pub fn linear(&self, light: LightId) -> Option<Linear> {
        match light {
            LightId::Maps => None,
            LightId::Sun(sun) => self.suns[sun].linear,
            LightId::Emitter(emitter) => self.area_lights[emitter].linear,
            LightId::Delta(delta) => self.deltas[delta].linear,
        }
    }

    /// Adds the light of a sun, an emitter or a light without size, found by a path that carries `s_and_p` at a block of nodes.
    #[inline(always)]
    pub fn add_light<S: Simd>(
        &self,
        simd: S,
        light: LightId,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let weights = match light {
            LightId::Maps => return xyz,
            LightId::Sun(sun) => &self.suns[sun].weights,
            LightId::Emitter(emitter) => &self.area_lights[emitter].weights,
            LightId::Delta(delta) => &self.deltas[delta].weights,
        };
        add_weighted(simd, &weights[block], s_and_p, xyz)
    }

    /// Adds an emitter's light found by a path that carries `s_and_p` at a block of nodes.
    #[inline(always)]
    pub fn add_emission<S: Simd>(
        &self,
        simd: S,
        emitter: usize,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        add_weighted(simd, &self.area_lights[emitter].weights[block], s_and_p, xyz)
    }

    /// Linear Rec.709 radiance of all maps from sixteen directions.
    #[inline(always)]
    pub fn map_rgb<S: Simd>(&self, simd: S, directions: &[Lanes; 3]) -> [[f32; LANES]; 3] {
        let [x, y, z] = directions;
        let mut sum = [[0.0; LANES]; 3];
        for (lookup, factor) in self.maps.iter() {
            let rgb = lookup.rgb([x.load(simd), y.load(simd), z.load(simd)]);
            for c in 0..3 {
                for lane in 0..LANES {
                    sum[c][lane] += factor * rgb[c][lane];
                }
            }
        }
        sum
    }

    /// XYZ of a map radiance seen with nothing in between.
    #[inline(always)]
    pub fn xyz(&self, rgb: [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (value, column) in rgb.iter().zip(&self.rgb_to_xyz) {
            for c in 0..3 {
                sum[c] += value * column[c];
            }
        }
        sum
    }

    /// Adds the maps' light found by a path that carries `s_and_p` at a block of nodes and sees `rgb` in them.
    #[inline(always)]
    pub fn add_map<S: Simd>(
        &self,
        simd: S,
        block: usize,
        s_and_p: f32x16<S>,
        rgb: [f32; 3],
        [x, y, z]: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let MapBlock { basis: [red, green, blue], weights } = &self.map_blocks[block];
        let spectrum = red.load(simd) * rgb[0];
        let spectrum = green.load(simd).mul_add(f32x16::splat(simd, rgb[1]), spectrum);
        let spectrum = blue.load(simd).mul_add(f32x16::splat(simd, rgb[2]), spectrum);
        let carried = s_and_p * spectrum;
        [
            weights[0].load(simd).mul_add(carried, x),
            weights[1].load(simd).mul_add(carried, y),
            weights[2].load(simd).mul_add(carried, z),
        ]
    }

    /// Adds the uniform lights found by a path that carries `s_and_p` at a block of nodes.
    #[inline(always)]
    pub fn add_uniform<S: Simd>(
        &self,
        simd: S,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let Some(weights) = self.uniform.get(block) else { return xyz };
        add_weighted(simd, weights, s_and_p, xyz)
    }
}

fn scaled_lanes(lanes: Lanes, factor: f64) -> Lanes {
    iridesce_numerics::lanes::Lanes(lanes.0.map(|value| value * factor as f32))
}

#[inline(always)]
fn add_weighted<S: Simd>(simd: S, weights: &Weights, s_and_p: f32x16<S>, [x, y, z]: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [
        weights[0].load(simd).mul_add(s_and_p, x),
        weights[1].load(simd).mul_add(s_and_p, y),
        weights[2].load(simd).mul_add(s_and_p, z),
    ]
}

/// A direction turned from +z towards +x about +y.
fn turned(v: Vec3, degrees: f64) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(v.x * cos + v.z * sin, v.y, v.z * cos - v.x * sin)
}

fn add_to(sum: &mut [Vec<f64>; 3], own: &[Vec<f64>; 3]) {
    for (sum, own) in sum.iter_mut().flatten().zip(own.iter().flatten()) {
        *sum += own;
    }
}

fn scaled(weights: &[Vec<f64>; 3], factor: f64) -> [Vec<f64>; 3] {
    std::array::from_fn(|c| weights[c].iter().map(|w| factor * w).collect())
}

/// XYZ of a light that nothing stands before: s and p weights are 1 each.
fn sums(weights: &[Vec<f64>; 3]) -> [f64; 3] {
    std::array::from_fn(|c| 2.0 * weights[c].iter().sum::<f64>())
}

fn halved(illuminant: &Illuminant, nodes: &Nodes) -> [Vec<f64>; 3] {
    nodes.weights(illuminant, Observer::Cie1931).map(|w| w.into_iter().map(|v| 0.5 * v).collect())
}

fn in_blocks([a, b, c]: [Vec<f64>; 3]) -> Vec<[Lanes; 3]> {
    let [a, b, c] = [a, b, c].map(|v| blocks(v.into_iter()));
    a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]).collect()
}
