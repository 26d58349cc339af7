//! Thickness models: a thickness in nm as a function of place.

use std::sync::Arc;

use crate::lens_gap::LensGap;
use crate::map::ThicknessMap;
use crate::wedge::Wedge;

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
    /// Linear between two points of the scene.
    Wedge(Wedge),
    /// The gap under a lens, around the object's centre.
    LensGap(LensGap),
    /// A grid laid over the object by its u and v.
    Map(Arc<ThicknessMap>),
}

/// A thickness in nm that a film can have.
pub(crate) fn check_nm(key: &'static str, value: f64) -> Result<(), ThicknessError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ThicknessError { key, message: format!("must be a finite thickness in nm, >= 0, got {value:?}") })
}

/// A gradient at relative height `s`, clamped to 0..1.
#[inline(always)]
pub(crate) fn power_law(top_nm: f64, bottom_nm: f64, exponent: f64, s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    let shape = if exponent == 1.0 { s } else { s.powf(exponent) };
    bottom_nm + (top_nm - bottom_nm) * shape
}

impl ThicknessModel {
    /// The same thickness everywhere, nm, >= 0 and finite.
    pub fn uniform(thickness_nm: f64) -> Result<ThicknessModel, ThicknessError> {
        check_nm("thickness_nm", thickness_nm)?;
        Ok(ThicknessModel::Uniform { thickness_nm })
    }

    /// A power law in height: `bottom + (top - bottom) s^exponent`; thicknesses >= 0 in nm, exponent > 0, all finite.
    ///
    /// ```
    /// use iridesce_thickness::ThicknessModel;
    /// let model = ThicknessModel::gradient(100.0, 900.0, 2.0).unwrap();
    /// assert_eq!(model.at_height(0.5), Some(700.0));
    /// ```
    pub fn gradient(top: f64, bottom: f64, exponent: f64) -> Result<ThicknessModel, ThicknessError> {
        check_nm("top", top)?;
        check_nm("bottom", bottom)?;
        if !(exponent.is_finite() && exponent > 0.0) {
            return Err(ThicknessError {
                key: "exponent",
                message: format!("must be a finite exponent > 0, got {exponent:?}"),
            });
        }
        Ok(ThicknessModel::Gradient { top_nm: top, bottom_nm: bottom, exponent })
    }

    /// Thickness in nm at relative height `s` (clamped to 0..1); `None` for a model that does not follow height.
    pub fn at_height(&self, s: f64) -> Option<f64> {
        match *self {
            ThicknessModel::Uniform { thickness_nm } => Some(thickness_nm),
            ThicknessModel::Gradient { top_nm, bottom_nm, exponent } => Some(power_law(top_nm, bottom_nm, exponent, s)),
            ThicknessModel::Wedge(_) | ThicknessModel::LensGap(_) | ThicknessModel::Map(_) => None,
        }
    }

    /// The largest thickness in nm that the model can give; a lens's gap is counted to the full radius of its sphere.
    pub fn max_nm(&self) -> f64 {
        match self {
            ThicknessModel::Uniform { thickness_nm } => *thickness_nm,
            ThicknessModel::Gradient { top_nm, bottom_nm, .. } => top_nm.max(*bottom_nm),
            ThicknessModel::Wedge(wedge) => wedge.max_nm(),
            ThicknessModel::LensGap(gap) => gap.max_nm(),
            ThicknessModel::Map(map) => map.max_nm(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_meet_their_ends_and_stay_between() {
        for exponent in [0.3, 1.0, 2.5] {
            let model = ThicknessModel::gradient(20.0, 900.0, exponent).unwrap();
            let at = |s| model.at_height(s).unwrap();
            assert_eq!((at(0.0), at(1.0)), (900.0, 20.0));
            assert_eq!((at(-1e-9), at(1.0 + 1e-9)), (900.0, 20.0));
            let mut last = f64::INFINITY;
            for i in 0..=100 {
                let t = at(f64::from(i) / 100.0);
                assert!((20.0..=900.0).contains(&t) && t <= last);
                last = t;
            }
            assert_eq!(model.max_nm(), 900.0);
        }
    }

    #[test]
    fn impossible_films_are_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(ThicknessModel::uniform(bad).unwrap_err().key, "thickness_nm");
            assert_eq!(ThicknessModel::gradient(bad, 1.0, 1.0).unwrap_err().key, "top");
            assert_eq!(ThicknessModel::gradient(1.0, bad, 1.0).unwrap_err().key, "bottom");
            assert_eq!(ThicknessModel::gradient(1.0, 1.0, bad).unwrap_err().key, "exponent");
        }
        assert!(ThicknessModel::gradient(1.0, 1.0, 0.0).is_err());
    }
}
