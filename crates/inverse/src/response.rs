//! Smooth curves as a Gaussian prior: what a lamp, a detector or stray light may do along the wavelengths.

use crate::InverseError;

/// Variance that a basis may leave out, relative to the curve's own: its square root, 1e-4, is far below any noise times the
/// bends (0.3 at most) that curves are given.
const LEFT_OUT: f64 = 1e-8;
const MOST_COLUMNS: usize = 160;

/// Curves 1 and Psi over some channels, so that Psi Psi^T is the covariance exp(-(dl / length)^2 / 2).
#[derive(Debug, Clone)]
pub struct SmoothCurves {
    /// Column after column, a value a channel: 1, then Psi.
    values: Vec<f64>,
    channels: usize,
}

/// Finer structure on a smooth curve: a lamp is a wide bell with narrower bumps, not one or the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fine {
    /// How far it keeps its size, nm.
    pub length_nm: f64,
    /// Its variance, of that of the smooth curve.
    pub share: f64,
}

impl SmoothCurves {
    /// Curves of one length.
    pub fn new(wavelength_nm: &[f64], length_nm: f64) -> Result<SmoothCurves, InverseError> {
        SmoothCurves::with_fine(wavelength_nm, length_nm, Fine { length_nm, share: 0.0 })
    }

    /// Curves of one length with finer ones on them, of variance 1 together: covariance
    /// (exp(-(dl / length)^2 / 2) + share exp(-(dl / fine length)^2 / 2)) / (1 + share).
    ///
    /// By Cholesky's factor with pivots, each the channel that the columns so far describe worst (H. Harbrecht, M. Peters,
    /// R. Schneider, Appl. Numer. Math. 62, 428 (2012)): as many columns as the length asks for.
    pub fn with_fine(wavelength_nm: &[f64], length_nm: f64, fine: Fine) -> Result<SmoothCurves, InverseError> {
        let finite = wavelength_nm.iter().all(|nm| nm.is_finite());
        if !(finite && [length_nm, fine.length_nm].iter().all(|l| *l > 0.0 && l.is_finite()) && fine.share >= 0.0) {
            return Err(InverseError::Argument(format!(
                "a length must be > 0 nm at finite wavelengths, got {length_nm} and {fine:?}"
            )));
        }
        let alike = |step_nm: f64, length_nm: f64| (-0.5 * (step_nm / length_nm).powi(2)).exp();
        let covariance = |step_nm: f64| {
            (alike(step_nm, length_nm) + fine.share * alike(step_nm, fine.length_nm)) / (1.0 + fine.share)
        };
        let count = wavelength_nm.len();
        let mut left = vec![1.0_f64; count];
        let mut basis: Vec<Vec<f64>> = Vec::new();
        while basis.len() < MOST_COLUMNS.min(count) {
            let (pivot, &most) = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("there is a channel");
            if most < LEFT_OUT {
                break;
            }
            let scale = most.sqrt();
            let from_pivot = |nm: &f64| covariance(nm - wavelength_nm[pivot]);
            let mut column: Vec<f64> = wavelength_nm.iter().map(from_pivot).collect();
            for known in &basis {
                let along = known[pivot];
                column.iter_mut().zip(known).for_each(|(value, known)| *value -= along * known);
            }
            column.iter_mut().for_each(|value| *value /= scale);
            for (left, value) in left.iter_mut().zip(&column) {
                *left = (*left - value * value).max(0.0);
            }
            left[pivot] = 0.0;
            basis.push(column);
        }
        let ones = vec![1.0; count];
        Ok(SmoothCurves { values: [&ones].into_iter().chain(&basis).flatten().copied().collect(), channels: count })
    }

    /// Number of columns, the constant one included.
    pub fn columns(&self) -> usize {
        self.values.len() / self.channels.max(1)
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// One column.
    pub(crate) fn column(&self, a: usize) -> &[f64] {
        &self.values[a * self.channels..(a + 1) * self.channels]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_make_the_covariance() {
        let nm: Vec<f64> = (0..120).map(|i| 400.0 + 3.0 * f64::from(i)).collect();
        for (length, share) in [(20.0, 0.0), (50.0, 0.0), (120.0, 0.0), (50.0, 0.04), (120.0, 0.04)] {
            let curves = SmoothCurves::with_fine(&nm, length, Fine { length_nm: 20.0, share }).unwrap();
            assert!(curves.columns() < 50 && curves.channels() == 120, "{}", curves.columns());
            assert!(curves.column(0).iter().all(|one| *one == 1.0));
            for (i, j) in [(0, 0), (0, 5), (17, 31), (40, 119)] {
                let got: f64 = (1..curves.columns()).map(|a| curves.column(a)[i] * curves.column(a)[j]).sum();
                let of = |length: f64| (-0.5 * ((nm[i] - nm[j]) / length).powi(2)).exp();
                let wanted = (of(length) + share * of(20.0)) / (1.0 + share);
                assert!((got - wanted).abs() < 2e-4, "{length} {i} {j}: {got} {wanted}");
            }
        }
    }
}
