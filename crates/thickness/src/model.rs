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

/// A thickness in nm that a film can have.
pub(crate) fn check_nm(key: &'static str, value: f64) -> Result<(), ThicknessError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ThicknessError { key, message: format!("must be a finite thickness in nm, >= 0, got {value:?}") })
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
    /// assert_eq!(model.at_height(0.5), 700.0);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_meet_their_ends_and_stay_between() {
        for exponent in [0.3, 1.0, 2.5] {
            let model = ThicknessModel::gradient(20.0, 900.0, exponent).unwrap();
            assert_eq!((model.at_height(0.0), model.at_height(1.0)), (900.0, 20.0));
            assert_eq!((model.at_height(-1e-9), model.at_height(1.0 + 1e-9)), (900.0, 20.0));
            let mut last = f64::INFINITY;
            for i in 0..=100 {
                let t = model.at_height(f64::from(i) / 100.0);
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
