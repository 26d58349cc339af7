//! What a light of a spectrum adds to X, Y, Z at the nodes.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::color::{Illuminant, Observer};

use crate::spectral::Nodes;

/// Weights of X, Y, Z at a block of nodes. They are halved because they meet the sum of s and p weights.
pub(super) type Weights = [Lanes; 3];

/// Spectra and weights of the maps at a block of nodes, side by side in memory as they are read.
#[derive(Clone, Copy)]
pub(super) struct MapBlock {
    /// Spectra of linear Rec.709 red, green and blue relative to D65; their sum is 1.
    pub(super) basis: [Lanes; 3],
    /// D65, by which the radiance of a map is meant.
    pub(super) weights: Weights,
}

#[inline(always)]
pub(super) fn add_weighted<S: Simd>(
    simd: S,
    weights: &Weights,
    s_and_p: f32x16<S>,
    [x, y, z]: [f32x16<S>; 3],
) -> [f32x16<S>; 3] {
    [
        weights[0].load(simd).mul_add(s_and_p, x),
        weights[1].load(simd).mul_add(s_and_p, y),
        weights[2].load(simd).mul_add(s_and_p, z),
    ]
}

pub(super) fn scaled_lanes(lanes: Lanes, factor: f64) -> Lanes {
    iridesce_numerics::lanes::Lanes(lanes.0.map(|value| value * factor as f32))
}

pub(super) fn halved(illuminant: &Illuminant, nodes: &Nodes) -> [Vec<f64>; 3] {
    nodes.weights(illuminant, Observer::Cie1931).map(|w| w.into_iter().map(|v| 0.5 * v).collect())
}

pub(super) fn scaled(weights: &[Vec<f64>; 3], factor: f64) -> [Vec<f64>; 3] {
    std::array::from_fn(|c| weights[c].iter().map(|w| factor * w).collect())
}

pub(super) fn add_to(sum: &mut [Vec<f64>; 3], own: &[Vec<f64>; 3]) {
    for (sum, own) in sum.iter_mut().flatten().zip(own.iter().flatten()) {
        *sum += own;
    }
}

/// XYZ of a light that nothing stands before: s and p weights are 1 each.
pub(super) fn sums(weights: &[Vec<f64>; 3]) -> [f64; 3] {
    std::array::from_fn(|c| 2.0 * weights[c].iter().sum::<f64>())
}

pub(super) fn in_blocks([a, b, c]: [Vec<f64>; 3]) -> Vec<[Lanes; 3]> {
    let [a, b, c] = [a, b, c].map(|v| blocks(v.into_iter()));
    a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]).collect()
}
