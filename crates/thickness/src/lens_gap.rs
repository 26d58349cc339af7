//! The gap between a plate and a sphere that rests on it: Newton's rings.

use iridesce_numerics::Bounds;

use crate::error::{ThicknessError, check_nm};

/// Nanometres in a millimetre.
const NM_PER_MM: f64 = 1e6;

/// The gap under a lens: `contact_gap_nm + 1e6 (R - sqrt(R^2 - r^2))` at the distance r from where it rests, R and r
/// in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensGap {
    radius_mm: f64,
    contact_gap_nm: f64,
}

impl LensGap {
    /// A gap under a sphere of `radius_mm` > 0 that is `contact_gap_nm` >= 0 wide where they are nearest.
    ///
    /// ```
    /// use iridesce_thickness::LensGap;
    /// let gap = LensGap::new(1000.0, 0.0)?;
    /// assert!((gap.at_radius(10.0) - 50_001.250_0625).abs() < 1e-6);    // r^2 / 2R + r^4 / 8R^3 + ...
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn new(radius_mm: f64, contact_gap_nm: f64) -> Result<LensGap, ThicknessError> {
        // Its square must neither vanish nor overflow.
        if !(1e-150..=1e150).contains(&radius_mm) {
            return Err(Bounds::above("radius_mm", 0.0).in_unit("mm").refuse(radius_mm));
        }
        check_nm("contact_gap_nm", contact_gap_nm)?;
        Ok(LensGap { radius_mm, contact_gap_nm })
    }

    /// Radius of the sphere, mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Width of the gap where it is narrowest, nm.
    pub fn contact_gap_nm(&self) -> f64 {
        self.contact_gap_nm
    }

    /// Width of the gap in nm at a distance from the axis, mm; beyond the sphere's radius, the one there.
    pub fn at_radius(&self, distance_mm: f64) -> f64 {
        self.at_square(distance_mm * distance_mm)
    }

    /// The same from the square of the distance, mm^2.
    pub fn at_square(&self, square_mm2: f64) -> f64 {
        let square = square_mm2.min(self.radius_mm * self.radius_mm);
        // R - sqrt(R^2 - r^2) without taking the difference of two numbers that are nearly the same.
        let root = (self.radius_mm * self.radius_mm - square).sqrt();
        self.contact_gap_nm + NM_PER_MM * square / (self.radius_mm + root)
    }

    /// The width at the sphere's full radius, nm: an upper bound wherever the gap ends.
    pub fn max_nm(&self) -> f64 {
        self.contact_gap_nm + NM_PER_MM * self.radius_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_follow_the_sphere_to_rounding() {
        // r = R sin(a): the gap is R (1 - cos a) = 2 R sin^2(a / 2), which needs no difference either.
        for radius in [0.5, 1000.0, 1e7] {
            let gap = LensGap::new(radius, 25.0).unwrap();
            for a in [1e-9, 1e-6, 1e-3, 0.017, 0.5, 1.0, 1.5] {
                let exact = 2e6 * radius * f64::sin(a / 2.0).powi(2);
                let found = gap.at_radius(radius * f64::sin(a)) - 25.0;
                assert!((found - exact).abs() <= 1e-13 * (exact + 25.0) / (1.6 - a), "{radius} {a}: {found} {exact}");
            }
            assert_eq!(gap.at_radius(0.0), 25.0);
            assert_eq!(gap.at_radius(radius), gap.max_nm());
            assert_eq!(gap.at_radius(2.0 * radius), gap.max_nm());
        }
    }

    #[test]
    fn the_rings_of_a_metre_lie_where_they_should() {
        // A dark ring of order m at r with 2 t = m lambda: r^2 = t (2 R - t).
        let gap = LensGap::new(1000.0, 0.0).unwrap();
        for m in [1.0, 10.0, 493.0] {
            let t_mm = m * 589.3e-6 / 2.0;
            let r = f64::sqrt(t_mm * (2000.0 - t_mm));
            assert!((gap.at_radius(r) / (1e6 * t_mm) - 1.0).abs() < 1e-9, "{m}");
        }
    }

    #[test]
    fn impossible_gaps_are_refused_by_name() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e200] {
            assert_eq!(LensGap::new(bad, 0.0).unwrap_err().argument, "radius_mm");
        }
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(LensGap::new(1.0, bad).unwrap_err().argument, "contact_gap_nm");
        }
    }
}
