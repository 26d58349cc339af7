//! Sampled functions of wavelength: tables with linear interpolation.

/// A table `(x ascending, y)` read by linear interpolation.
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulated {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Tabulated {
    /// A table over strictly ascending `x`; `None` when lengths differ, `x` is empty, not finite or not ascending.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Option<Tabulated> {
        let sound = !x.is_empty()
            && x.len() == y.len()
            && x.iter().chain(&y).all(|v| v.is_finite())
            && x.windows(2).all(|w| w[0] < w[1]);
        sound.then_some(Tabulated { x, y })
    }

    /// First and last abscissa.
    pub fn range(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// The abscissae.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// The ordinates.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// The linearly interpolated value, `None` outside the range.
    pub fn at(&self, x: f64) -> Option<f64> {
        let (from, to) = self.range();
        if !(from <= x && x <= to) {
            return None;
        }
        let above = self.x.partition_point(|&v| v < x);
        if self.x[above] == x {
            return Some(self.y[above]);
        }
        let (x0, x1) = (self.x[above - 1], self.x[above]);
        let (y0, y1) = (self.y[above - 1], self.y[above]);
        Some(y0 + (y1 - y0) * ((x - x0) / (x1 - x0)))
    }

    /// The interpolated value, the end value beyond either end.
    pub fn held(&self, x: f64) -> f64 {
        let (from, to) = self.range();
        self.at(x.clamp(from, to)).unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::Tabulated;

    #[test]
    fn interpolates_and_ends() {
        let table = Tabulated::new(vec![400.0, 500.0, 700.0], vec![1.0, 2.0, 6.0]).unwrap();
        assert_eq!(table.at(400.0), Some(1.0));
        assert_eq!(table.at(450.0), Some(1.5));
        assert_eq!(table.at(600.0), Some(4.0));
        assert_eq!(table.at(700.0), Some(6.0));
        assert_eq!(table.at(399.9), None);
        assert_eq!(table.at(f64::NAN), None);
        assert_eq!(table.held(1000.0), 6.0);
    }

    #[test]
    fn refuses_unsound_tables() {
        assert!(Tabulated::new(vec![], vec![]).is_none());
        assert!(Tabulated::new(vec![1.0, 1.0], vec![0.0, 0.0]).is_none());
        assert!(Tabulated::new(vec![1.0], vec![0.0, 0.0]).is_none());
        assert!(Tabulated::new(vec![1.0, 2.0], vec![0.0, f64::NAN]).is_none());
    }
}
