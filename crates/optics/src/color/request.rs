//! What can be asked about the colour of a stack.

use iridesce_numerics::Argument;

use super::gamut::{Gamut, Mapping};
use super::illuminant::Illuminant;
use super::observer::Observer;
use super::space::{Adaptation, Space};
use super::sums::Grid;
pub use crate::stack::sweep::Power as Quantity;
use crate::{Complex64, Medium, OpticsError, Polarization};

/// Which optics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// Every reflection, both polarisations.
    #[default]
    Exact,
    /// The two-beam form of 1991: one layer, real indices, amplitudes of normal incidence at every angle.
    TwoBeam,
}

impl Model {
    /// `"exact"` or `"two-beam"`.
    pub fn named(name: &str) -> Result<Model, OpticsError> {
        match name {
            "exact" => Ok(Model::Exact),
            "two-beam" => Ok(Model::TwoBeam),
            _ => Err(Argument::one_of("model", &["exact", "two-beam"], name).into()),
        }
    }
}

/// What is asked of a stack.
#[derive(Debug, Clone)]
pub struct ColorRequest {
    /// First medium, layers in the order light meets them, last medium.
    pub media: Vec<Medium>,
    /// One entry a layer; `false` for an incoherent slab.
    pub coherent: Vec<bool>,
    /// The light.
    pub illuminant: Illuminant,
    /// The observer.
    pub observer: Observer,
    /// The polarisation of the light.
    pub polarization: Polarization,
    /// The power ratio.
    pub quantity: Quantity,
    /// The optics.
    pub model: Model,
    /// Wavelengths of the sum, taken as they are; `None`: 360..830 nm at 1 nm, refined where fringes need it.
    pub grid: Option<Grid>,
    /// The space of the answer.
    pub space: Space,
    /// Adaptation to the space's white.
    pub adaptation: Adaptation,
    /// What to do with RGB out of range; `None` keeps it.
    pub gamut: Option<Mapping>,
}

impl ColorRequest {
    /// What can be told without indices.
    pub(super) fn check(&self) -> Result<(), OpticsError> {
        let bad = |message: &str| Err(OpticsError::Argument(message.to_string()));
        if self.media.len() < 2 || self.coherent.len() + 2 != self.media.len() {
            return bad("a stack needs a first medium, one entry of coherent for each layer, and a last medium");
        }
        if self.gamut.is_some() && self.space.rgb_from_xyz().is_none() {
            return Err(OpticsError::Argument(format!(
                "gamut= needs an RGB space (srgb, display-p3, rec2020, linear-srgb, acescg, ntsc1953), got space={:?}",
                self.space.name()
            )));
        }
        if self.model == Model::TwoBeam {
            if self.coherent.len() != 1 || !self.coherent[0] {
                return bad("model=\"two-beam\" needs exactly one layer, a coherent one");
            }
            if self.polarization != Polarization::Unpolarized {
                return bad("model=\"two-beam\" knows no polarisation: polarization must be \"unpolarized\"");
            }
            if self.quantity != Quantity::Reflectance {
                return bad("model=\"two-beam\" gives the reflectance only: quantity must be \"reflectance\"");
            }
        }
        Ok(())
    }

    /// XYZ in the space that was asked for, and whether a gamut mapping had to change it.
    pub(super) fn finish(&self, xyz: [f64; 3], white: [f64; 3]) -> ([f64; 3], bool) {
        let value = self.space.from_xyz(xyz, white, self.adaptation);
        match self.gamut.and_then(|mapping| Gamut::new(self.space, mapping)) {
            None => (value, false),
            Some(gamut) => gamut.map_encoded(self.space, value),
        }
    }

    /// Whether the index of one medium of the stack can be used.
    pub(super) fn check_index(&self, index: Complex64, place: usize, nm: f64) -> Result<(), OpticsError> {
        let last = place + 1 == self.media.len();
        let what = match place {
            0 if !(index.re > 0.0 && index.im == 0.0) => "the first medium must have a real index > 0",
            _ if last && index.im < 0.0 => "the last medium must not amplify (k >= 0)",
            _ if self.model == Model::TwoBeam && index.im != 0.0 => "model=\"two-beam\" needs real indices",
            _ if !(index.re.is_finite() && index.im.is_finite()) => "indices must be finite",
            _ => return Ok(()),
        };
        Err(OpticsError::Argument(format!("{what}, got {index} for medium {:?} at {nm} nm", self.media[place].name())))
    }
}
