//! All the light of a scene, added up: uniform lights are one set of spectral weights, maps one RGB radiance.
//!
//! Suns, emitters and lights without size ([`delta`]) are sampled one by one or by what is expected of them ([`chooser`]).

pub mod chooser;
pub mod delta;
mod make;
pub mod polarization;
pub mod seeds;
mod weights;
mod worth;

pub use self::make::EmittingObject;

use std::sync::Arc;

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_scene::{ResolvedEnvironment, ResolvedSource};

use self::chooser::{Extent, LightId};
use self::delta::DeltaSource;
use self::polarization::Linear;
use self::weights::{MapBlock, Weights, add_weighted};
use crate::environment::{MapLookup, MapSampler};

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
    /// Spectral radiance ([`crate::spectral::Nodes::radiance`]).
    pub radiance: [f32; LANES],
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

impl Lights {
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
