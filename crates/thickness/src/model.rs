//! Thickness models: a thickness in nm as a function of place.

/// What can be wrong with a thickness model; `key` is the parameter at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} {message}")]
pub struct ThicknessError {
    /// The parameter at fault, e.g. `top`.
    pub key: &'static str,
    /// What was given and what is allowed.
    pub message: String,
}

/// A film's thickness over an object.
#[derive(Debug, Clone, PartialEq)]
pub enum ThicknessModel {
    /// The same everywhere.
    Uniform {
        /// Thickness in nm, >= 0.
        thickness_nm: f64,
    },
    /// `bottom + (top - bottom) s^exponent`, s = relative world height over the object's own bounding box.
    Gradient {
        /// Thickness at the highest point, nm.
        top_nm: f64,
        /// Thickness at the lowest point, nm.
        bottom_nm: f64,
        /// Exponent > 0; 1 is linear in height.
        exponent: f64,
    },
}

impl ThicknessModel {
    /// Thickness in nm at relative height `s` (clamped to 0..1).
    pub fn at_height(&self, s: f64) -> f64 {
        match *self {
            ThicknessModel::Uniform { thickness_nm } => thickness_nm,
            ThicknessModel::Gradient { top_nm, bottom_nm, exponent } => {
                let s = s.clamp(0.0, 1.0);
                let shape = if exponent == 1.0 { s } else { s.powf(exponent) };
                bottom_nm + (top_nm - bottom_nm) * shape
            }
        }
    }

    /// The largest thickness in nm that the model can give.
    pub fn max_nm(&self) -> f64 {
        match *self {
            ThicknessModel::Uniform { thickness_nm } => thickness_nm,
            ThicknessModel::Gradient { top_nm, bottom_nm, .. } => top_nm.max(bottom_nm),
        }
    }
}
