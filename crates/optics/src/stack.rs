//! Stable solution of any stack of layers.

use crate::Medium;

/// Polarisation of the incident light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarization {
    /// Electric field normal to the plane of incidence (TE).
    S,
    /// Electric field in the plane of incidence (TM).
    P,
    /// The mean of both powers.
    Unpolarized,
}

/// One finite layer.
#[derive(Debug, Clone)]
pub struct Layer {
    /// What it is made of.
    pub medium: Medium,
    /// Thickness in nm, >= 0.
    pub thickness_nm: f64,
    /// `false`: an incoherent slab, whose two faces add powers instead of amplitudes.
    pub coherent: bool,
}

/// First medium, layers in the order light meets them, last medium.
#[derive(Debug, Clone)]
pub struct Stack {
    /// The medium light comes from.
    pub first: Medium,
    /// The layers.
    pub layers: Vec<Layer>,
    /// The medium behind.
    pub last: Medium,
}
