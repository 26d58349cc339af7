//! A wedge: thickness linear along a direction.

use crate::error::{ThicknessError, check_nm};

/// A thickness that grows linearly from one point to another and stays what it is beyond them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wedge {
    from: [f64; 3],
    to: [f64; 3],
    start_nm: f64,
    end_nm: f64,
    /// `to - from` over the square of its length: its product with a way from `from` is the share of the whole way.
    slope: [f64; 3],
}

impl Wedge {
    /// From `start_nm` at `from` to `end_nm` at `to`, thicknesses >= 0 in nm; the points differ and are finite.
    ///
    /// ```
    /// use iridesce_thickness::Wedge;
    /// let wedge = Wedge::new([-1.0, 0.0, 0.0], [3.0, 0.0, 0.0], 0.0, 800.0)?;
    /// assert_eq!(wedge.at_point([0.0, 7.0, -2.0]), 200.0);
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn new(from: [f64; 3], to: [f64; 3], start_nm: f64, end_nm: f64) -> Result<Wedge, ThicknessError> {
        for (key, point) in [("from", from), ("to", to)] {
            if !point.iter().all(|x| x.is_finite()) {
                return Err(ThicknessError::new(key, "three finite numbers", format!("{point:?}")));
            }
        }
        check_nm("start_nm", start_nm)?;
        check_nm("end_nm", end_nm)?;
        let way: [f64; 3] = std::array::from_fn(|i| to[i] - from[i]);
        let square: f64 = way.iter().map(|x| x * x).sum();
        let slope = way.map(|x| x / square);
        // Also where the square of the distance underflows or overflows.
        if !(square > 0.0 && slope.iter().all(|x| x.is_finite()) && slope.iter().any(|x| *x != 0.0)) {
            return Err(ThicknessError::new(
                "to",
                format!("a point away from the other end {from:?}"),
                format!("{to:?}"),
            ));
        }
        Ok(Wedge { from, to, start_nm, end_nm, slope })
    }

    /// Where it starts.
    pub fn from(&self) -> [f64; 3] {
        self.from
    }

    /// Where it ends.
    pub fn to(&self) -> [f64; 3] {
        self.to
    }

    /// Thickness in nm at a point.
    pub fn at_point(&self, point: [f64; 3]) -> f64 {
        let share: f64 = (0..3).map(|i| (point[i] - self.from[i]) * self.slope[i]).sum();
        let share = share.clamp(0.0, 1.0);
        // Exact at both ends.
        self.start_nm * (1.0 - share) + self.end_nm * share
    }

    /// The larger of its two ends, nm.
    pub fn max_nm(&self) -> f64 {
        self.start_nm.max(self.end_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wedges_are_linear_between_their_ends_and_flat_beyond() {
        let (from, to) = ([1.0, -2.0, 0.5], [-3.0, 4.0, 2.0]);
        let wedge = Wedge::new(from, to, 50.0, 650.0).unwrap();
        assert_eq!((wedge.at_point(from), wedge.at_point(to), wedge.max_nm()), (50.0, 650.0, 650.0));
        for i in -20..=40 {
            let s = f64::from(i) / 20.0;
            // A step sideways, at right angles to the way from end to end, changes nothing.
            let sideways = [6.0, 4.0, 0.0];
            let point = std::array::from_fn(|k| from[k] + s * (to[k] - from[k]) + 0.7 * sideways[k]);
            let expected = 50.0 + 600.0 * s.clamp(0.0, 1.0);
            assert!((wedge.at_point(point) - expected).abs() < 1e-10, "{s}");
        }
    }

    #[test]
    fn impossible_wedges_are_refused_by_name() {
        let key = |from, to, start, end| Wedge::new(from, to, start, end).unwrap_err().argument;
        let (a, b) = ([0.0; 3], [1.0, 0.0, 0.0]);
        assert_eq!(key(b, b, 1.0, 2.0), "to");
        assert_eq!(key(a, [1e-170, 0.0, 0.0], 1.0, 2.0), "to", "its square underflows");
        assert_eq!(key(a, [1e170, 0.0, 0.0], 1.0, 2.0), "to", "its square overflows");
        assert_eq!(key(a, [0.0, f64::NAN, 0.0], 1.0, 2.0), "to");
        assert_eq!(key([f64::INFINITY, 0.0, 0.0], b, 1.0, 2.0), "from");
        assert_eq!(key(a, b, -1.0, 2.0), "start_nm");
        assert_eq!(key(a, b, 1.0, f64::NAN), "end_nm");
    }
}
