//! The lights of a scene at the nodes of a level.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::OpticsError;
use iridesce_optics::color::{Illuminant, rgb_basis};
use iridesce_scene::{Emitter, Light, ResolvedScene, ResolvedSource, Sun};

use super::chooser::Extent;
use super::delta::DeltaSource;
use super::polarization::Linear;
use super::weights::{MapBlock, Weights, add_to, halved, in_blocks, scaled, scaled_lanes, sums};
use super::{AreaLight, DeltaLamp, EnvironmentLight, Lights, SunDisc};
use crate::spectral::Nodes;

/// An object that emits.
pub struct EmittingObject<'a> {
    pub object: usize,
    pub emitter: &'a Emitter,
    pub extent: Option<Extent>,
}

/// A light at the nodes: the weights of X, Y, Z and its radiance, both halved as all weights are.
struct Shone {
    weights: [Vec<f64>; 3],
    radiance: Vec<f64>,
}

impl Shone {
    /// An illuminant of a power. Of its radiance nobody asks in renders without spectra.
    fn new(nodes: &Nodes, illuminant: &Illuminant, power: f64) -> Shone {
        let has_spectra = nodes.probes().len() > 0;
        let radiance = if has_spectra { nodes.radiance(illuminant) } else { vec![0.0; nodes.row_len()] };
        Shone {
            weights: scaled(&halved(illuminant, nodes), power),
            radiance: radiance.into_iter().map(|value| 0.5 * power * value).collect(),
        }
    }

    fn add(&mut self, other: &Shone) {
        add_to(&mut self.weights, &other.weights);
        self.radiance.iter_mut().zip(&other.radiance).for_each(|(total, own)| *total += own);
    }

    fn in_blocks(self) -> (Vec<Weights>, Vec<Lanes>) {
        (in_blocks(self.weights), blocks(self.radiance.into_iter()))
    }
}

/// A sun at the nodes.
struct Disc {
    direction: Vec3,
    cos_radius: f64,
    shone: Shone,
}

impl Disc {
    fn new(nodes: &Nodes, sun: &Sun, power: f64) -> Disc {
        Disc {
            direction: sun.direction.into(),
            cos_radius: sun.angular_radius_deg.to_radians().cos(),
            shone: Shone::new(nodes, &sun.illuminant, power),
        }
    }

    fn is_at_the_place_of(&self, other: &Disc) -> bool {
        (self.direction, self.cos_radius) == (other.direction, other.cos_radius)
    }

    fn light(self, linear: Option<Linear>, is_of_sky: bool) -> SunDisc {
        let xyz = sums(&self.shone.weights);
        let (weights, radiance) = self.shone.in_blocks();
        SunDisc { direction: self.direction, cos_radius: self.cos_radius, weights, radiance, xyz, linear, is_of_sky }
    }
}
/// A direction turned from +z towards +x about +y.
fn turned(v: Vec3, degrees: f64) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(v.x * cos + v.z * sin, v.y, v.z * cos - v.x * sin)
}

/// The lights that are the same in every direction, added up, and the suns of skies.
struct Surroundings {
    uniform: Option<Shone>,
    suns: Vec<Disc>,
}

impl Surroundings {
    fn new(scene: &ResolvedScene, nodes: &Nodes) -> Surroundings {
        let mut all = Surroundings { uniform: None, suns: Vec::new() };
        for environment in &scene.environments {
            match &environment.source {
                ResolvedSource::Map(_) => {}
                ResolvedSource::Sky(_, sun) => {
                    let mut own = Disc::new(nodes, sun, environment.radiance * sun.radiance);
                    own.direction = turned(own.direction, environment.rotation_deg).normalized();
                    // Two skies have one sun, of both radiances: a place of the sky is looked up in one disc.
                    match all.suns.iter_mut().find(|there| there.is_at_the_place_of(&own)) {
                        Some(there) => there.shone.add(&own.shone),
                        None => all.suns.push(own),
                    }
                }
                ResolvedSource::Uniform(illuminant) => {
                    let own = Shone::new(nodes, illuminant, environment.radiance);
                    match &mut all.uniform {
                        Some(sum) => sum.add(&own),
                        None => all.uniform = Some(own),
                    }
                }
            }
        }
        all
    }
}

impl Lights {
    /// `emitters`: in the order of their numbers.
    pub fn new(
        scene: &ResolvedScene,
        nodes: &Nodes,
        around: &EnvironmentLight,
        emitters: &[EmittingObject<'_>],
    ) -> Result<Lights, OpticsError> {
        let Surroundings { uniform, suns } = Surroundings::new(scene, nodes);
        let mut suns: Vec<SunDisc> = suns.into_iter().map(|disc| disc.light(None, true)).collect();
        let mut deltas = Vec::new();
        for light in &scene.recipe.lights {
            match light {
                Light::Environment(_) => {}
                Light::Sun(sun) => {
                    let disc = Disc::new(nodes, sun, sun.radiance);
                    suns.push(disc.light(sun.polarized_deg.map(Linear::new), false));
                }
                Light::Delta(delta) => {
                    let (weights, radiance) = Shone::new(nodes, &delta.illuminant, delta.power).in_blocks();
                    deltas.push(DeltaLamp {
                        source: DeltaSource::new(&delta.kind),
                        weights,
                        radiance,
                        linear: delta.polarized_deg.map(Linear::new),
                        power: delta.power,
                    });
                }
            }
        }
        let area_light = |&EmittingObject { object, emitter, extent }: &EmittingObject<'_>| {
            let (weights, radiance) = Shone::new(nodes, &emitter.illuminant, emitter.radiance).in_blocks();
            let linear = emitter.polarized_deg.map(Linear::new);
            AreaLight { object, weights, radiance, linear, power: emitter.radiance, extent }
        };
        let uniform_xyz = uniform.as_ref().map_or([0.0; 3], |light| sums(&light.weights));
        let (uniform, uniform_radiance) = match uniform {
            Some(light) => light.in_blocks(),
            None => (Vec::new(), blocks(vec![0.0; nodes.row_len()].into_iter())),
        };
        let d65 = Shone::new(nodes, &Illuminant::named("D65")?, 1.0);
        let basis: [Vec<f64>; 3] =
            std::array::from_fn(|rgb| nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[rgb]).collect());
        let rgb_to_xyz = std::array::from_fn(|rgb| {
            std::array::from_fn(|c| d65.weights[c].iter().zip(&basis[rgb]).map(|(w, f)| 2.0 * w * f).sum::<f64>())
        });
        let (map_weights, map_radiance) = d65.in_blocks();
        let map_block = |(weights, basis): (Weights, [Lanes; 3])| MapBlock { basis, weights };
        Ok(Lights {
            uniform_xyz,
            uniform,
            uniform_radiance,
            map_radiance,
            whole: 1.0,
            maps: around.maps.clone(),
            mean_rgb: around.mean_rgb,
            least_rgb: around.least_rgb,
            sampler: around.sampler.clone(),
            map_blocks: map_weights.into_iter().zip(in_blocks(basis)).map(map_block).collect(),
            rgb_to_xyz,
            suns,
            area_lights: emitters.iter().map(area_light).collect(),
            deltas,
        })
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
}
