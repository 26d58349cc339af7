//! What can be asked of a stack over an array.

use super::march::Power;
use crate::OpticsError;

/// What is written for each element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// R, T or A.
    Power(Power),
    /// The share of the incident power absorbed in each layer.
    LayerAbsorptance,
    /// `r` and `t`, real and imaginary part each.
    Amplitudes,
    /// psi and delta in degrees.
    Ellipsometry,
    /// R in the two-beam form of 1991.
    TwoBeam,
}

impl Quantity {
    /// By name: `reflectance`, `transmittance`, `absorptance`, `layer_absorptance`, `amplitudes`, `ellipsometry`, `two_beam`.
    pub fn named(name: &str) -> Result<Quantity, OpticsError> {
        match name {
            "layer_absorptance" => Ok(Quantity::LayerAbsorptance),
            "amplitudes" => Ok(Quantity::Amplitudes),
            "ellipsometry" => Ok(Quantity::Ellipsometry),
            "two_beam" => Ok(Quantity::TwoBeam),
            _ => Power::named(name).map(Quantity::Power),
        }
    }

    /// Numbers an element in the first and in the second output.
    pub fn widths(self, layers: usize) -> [usize; 2] {
        match self {
            Quantity::LayerAbsorptance => [layers, 0],
            Quantity::Amplitudes => [2, 2],
            Quantity::Ellipsometry => [1, 1],
            Quantity::Power(_) | Quantity::TwoBeam => [1, 0],
        }
    }
}
