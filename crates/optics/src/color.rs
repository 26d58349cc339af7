//! From spectra to colour: observers, illuminants, XYZ, colour spaces, gamut mapping.

/// A light source: a continuous part (a table over wavelength) and true lines.
#[derive(Debug, Clone)]
pub struct Illuminant {
    name: String,
}

impl Illuminant {
    /// The name it was asked for by.
    pub fn name(&self) -> &str {
        &self.name
    }
}
