//! All the light of a scene, added up: uniform lights are one set of spectral weights, maps one RGB radiance.

use std::sync::Arc;

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::OpticsError;
use iridesce_optics::color::{Illuminant, Observer, rgb_basis};
use iridesce_scene::{Emitter, ResolvedEnvironment, ResolvedScene, ResolvedSource};

use crate::environment::{MapLookup, MapSampler};
use crate::spectral::Nodes;

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
    /// The density by which diffuse surfaces sample the maps.
    sampler: Option<Arc<MapSampler>>,
}

impl EnvironmentLight {
    /// `is_sampled`: diffuse surfaces will sample the maps.
    pub fn new(environments: &[ResolvedEnvironment], is_sampled: bool) -> EnvironmentLight {
        let mut maps = Vec::new();
        for environment in environments {
            if let ResolvedSource::Map(map) | ResolvedSource::Sky(map, _) = &environment.source {
                maps.push((MapLookup::new(map.clone(), environment.rotation_deg), environment.radiance as f32));
            }
        }
        let mut mean_rgb = [0.0; 3];
        for (lookup, factor) in &maps {
            for (sum, mean) in mean_rgb.iter_mut().zip(lookup.mean_rgb()) {
                *sum += factor * mean;
            }
        }
        let sampler = (is_sampled && !maps.is_empty()).then(|| Arc::new(MapSampler::new(&maps)));
        EnvironmentLight { maps: Arc::new(maps), mean_rgb, sampler }
    }
}

/// A disc of light, infinitely far away.
pub struct SunDisc {
    pub direction: Vec3,
    pub cos_radius: f64,
    weights: Vec<Weights>,
    /// Its XYZ with nothing in between.
    pub xyz: [f64; 3],
}

/// A surface that emits.
pub struct AreaLight {
    pub object: usize,
    weights: Vec<Weights>,
}

/// The lights of a scene. Light is linear, so any number of environments costs no more than these.
pub struct Lights {
    /// Sum of all lights that are the same in every direction.
    uniform: Vec<Weights>,
    /// Its XYZ with nothing in between.
    pub uniform_xyz: [f64; 3],
    maps: Arc<Vec<(MapLookup, f32)>>,
    map_blocks: Vec<MapBlock>,
    /// Mean of all maps over the sphere.
    pub mean_rgb: [f32; 3],
    pub sampler: Option<Arc<MapSampler>>,
    /// XYZ of a map's bare red, green and blue.
    rgb_to_xyz: [[f64; 3]; 3],
    pub suns: Vec<SunDisc>,
    /// In the order of their numbers.
    pub area_lights: Vec<AreaLight>,
}

impl Lights {
    /// `emitters`: emitting objects by their index, in the order of their numbers.
    pub fn new(
        scene: &ResolvedScene,
        nodes: &Nodes,
        around: &EnvironmentLight,
        emitters: &[(usize, &Emitter)],
    ) -> Result<Lights, OpticsError> {
        let map_weights = halved(&Illuminant::named("D65")?, nodes);
        let basis: [Vec<f64>; 3] =
            std::array::from_fn(|rgb| nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[rgb]).collect());
        let rgb_to_xyz = std::array::from_fn(|rgb| {
            std::array::from_fn(|c| map_weights[c].iter().zip(&basis[rgb]).map(|(w, f)| 2.0 * w * f).sum::<f64>())
        });
        let mut uniform: Option<[Vec<f64>; 3]> = None;
        let mut suns: Vec<(Vec3, f64, [Vec<f64>; 3])> = Vec::new();
        for environment in &scene.environments {
            match &environment.source {
                ResolvedSource::Map(_) => {}
                ResolvedSource::Sky(_, sun) => {
                    let weights = scaled(&halved(&sun.illuminant, nodes), environment.radiance * sun.radiance);
                    let direction = turned(sun.direction.into(), environment.rotation_deg).normalized();
                    let cos_radius = sun.angular_radius_deg.to_radians().cos();
                    // Two skies have one sun, of both radiances: a place of the sky is looked up in one disc.
                    match suns.iter_mut().find(|(there, cos, _)| (*there, *cos) == (direction, cos_radius)) {
                        Some((_, _, sum)) => add_to(sum, &weights),
                        None => suns.push((direction, cos_radius, weights)),
                    }
                }
                ResolvedSource::Uniform(illuminant) => {
                    let own = scaled(&halved(illuminant, nodes), environment.radiance);
                    let sum = uniform.get_or_insert_with(|| std::array::from_fn(|_| vec![0.0; nodes.len()]));
                    add_to(sum, &own);
                }
            }
        }
        let sun_disc = |(direction, cos_radius, weights)| SunDisc {
            direction,
            cos_radius,
            xyz: sums(&weights),
            weights: in_blocks(weights),
        };
        let area_light = |&(object, emitter): &(usize, &Emitter)| AreaLight {
            object,
            weights: in_blocks(scaled(&halved(&emitter.illuminant, nodes), emitter.radiance)),
        };
        Ok(Lights {
            uniform_xyz: uniform.as_ref().map_or([0.0; 3], sums),
            uniform: uniform.map(in_blocks).unwrap_or_default(),
            maps: around.maps.clone(),
            mean_rgb: around.mean_rgb,
            sampler: around.sampler.clone(),
            map_blocks: in_blocks(map_weights)
                .into_iter()
                .zip(in_blocks(basis))
                .map(|(weights, basis)| MapBlock { basis, weights })
                .collect(),
            rgb_to_xyz,
            suns: suns.into_iter().map(sun_disc).collect(),
            area_lights: emitters.iter().map(area_light).collect(),
        })
    }

    /// By what a path's s and p weights are judged: the Y weights of the lights, scaled to a sum of 1/2.
    ///
    /// They are kept even where a cardinal spline dips below zero: choices in proportion to exactly the luminance
    /// that the picture shows are what keeps a white furnace white.
    pub fn importance(&self) -> Vec<Lanes> {
        let y = |weights: &[Weights]| -> Vec<Lanes> { weights.iter().map(|w| w[1]).collect() };
        let maps: Vec<Weights> = self.map_blocks.iter().map(|block| block.weights).collect();
        let any = |weights: &[Lanes]| weights.iter().flat_map(|l| l.0).sum::<f32>() > 0.0;
        let area_lights = self.area_lights.iter().map(|area_light| y(&area_light.weights));
        let weights = std::iter::once(y(&self.uniform))
            .chain([y(&maps)])
            .chain(area_lights)
            .find(|weights| any(weights))
            .unwrap_or_else(|| vec![Lanes::ONE; self.map_blocks.len()]);
        let sum: f64 = weights.iter().flat_map(|l| l.0).map(f64::from).sum();
        blocks(weights.iter().flat_map(|l| l.0).map(|w| 0.5 * f64::from(w) / sum))
    }

    /// Whether any light far away depends on direction.
    #[inline(always)]
    pub fn depend_on_direction(&self) -> bool {
        !self.maps.is_empty() || !self.suns.is_empty()
    }

    /// Whether there are maps.
    #[inline(always)]
    pub fn has_maps(&self) -> bool {
        !self.maps.is_empty()
    }

    /// The sun in this direction.
    #[inline(always)]
    pub fn sun_at(&self, direction: Vec3) -> Option<usize> {
        self.suns.iter().position(|sun| direction.dot(sun.direction) >= sun.cos_radius)
    }

    /// Adds a sun's light found by a path that carries `s_and_p` at a block of nodes.
    #[inline(always)]
    pub fn add_sun<S: Simd>(
        &self,
        simd: S,
        sun: usize,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        add_weighted(simd, &self.suns[sun].weights[block], s_and_p, xyz)
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
