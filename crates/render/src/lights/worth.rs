//! How much light is expected of each light at a place: by that lights are chosen, and branches judged.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::color::REC709_LUMINANCE;

use super::Lights;
use super::chooser::{FEW, LightId, expected_picks};
use super::weights::Weights;

impl Lights {
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
}
