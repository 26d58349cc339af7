//! A power law in height: what drains.

use iridesce_numerics::Bounds;

use crate::error::{ThicknessError, check_nm};

/// `bottom + (top - bottom) s^exponent`, s the relative height over the object's own bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gradient {
    top_nm: f64,
    bottom_nm: f64,
    exponent: f64,
}

impl Gradient {
    /// From `top_nm` at the highest point to `bottom_nm` at the lowest, both >= 0; exponent > 0; all finite.
    ///
    /// ```
    /// use iridesce_thickness::Gradient;
    /// let gradient = Gradient::new(100.0, 900.0, 2.0)?;
    /// assert_eq!(gradient.at_height(0.5), 700.0);
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn new(top_nm: f64, bottom_nm: f64, exponent: f64) -> Result<Gradient, ThicknessError> {
        check_nm("top", top_nm)?;
        check_nm("bottom", bottom_nm)?;
        if !(exponent.is_finite() && exponent > 0.0) {
            return Err(Bounds::above("exponent", 0.0).refuse(exponent));
        }
        Ok(Gradient { top_nm, bottom_nm, exponent })
    }

    /// Thickness in nm at relative height `s` (clamped to 0..1).
    pub fn at_height(&self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        let shape = if self.exponent == 1.0 { s } else { s.powf(self.exponent) };
        self.bottom_nm + (self.top_nm - self.bottom_nm) * shape
    }

    /// The larger of its two ends, nm.
    pub fn max_nm(&self) -> f64 {
        self.top_nm.max(self.bottom_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_meet_their_ends_and_stay_between() {
        for exponent in [0.3, 1.0, 2.5] {
            let gradient = Gradient::new(20.0, 900.0, exponent).unwrap();
            assert_eq!((gradient.at_height(0.0), gradient.at_height(1.0)), (900.0, 20.0));
            assert_eq!((gradient.at_height(-1e-9), gradient.at_height(1.0 + 1e-9)), (900.0, 20.0));
            let mut last = f64::INFINITY;
            for i in 0..=100 {
                let t = gradient.at_height(f64::from(i) / 100.0);
                assert!((20.0..=900.0).contains(&t) && t <= last);
                last = t;
            }
            assert_eq!(gradient.max_nm(), 900.0);
        }
    }

    #[test]
    fn impossible_gradients_are_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(Gradient::new(bad, 1.0, 1.0).unwrap_err().argument, "top");
            assert_eq!(Gradient::new(1.0, bad, 1.0).unwrap_err().argument, "bottom");
            assert_eq!(Gradient::new(1.0, 1.0, bad).unwrap_err().argument, "exponent");
        }
        assert!(Gradient::new(1.0, 1.0, 0.0).is_err());
    }
}
