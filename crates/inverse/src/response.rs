//! Smooth curves as a Gaussian prior: what a lamp, a detector or stray light may do along the wavelengths.

use crate::InverseError;

/// Variance that a basis may leave out, relative to the curve's own: its square root, 1e-4, is far below any noise times the
/// bends (0.3 at most) that curves are given.
const LEFT_OUT: f64 = 1e-8;
const MOST_COLUMNS: usize = 160;

/// Curves 1 and Psi over some channels, so that Psi Psi^T is the covariance exp(-(dl / length)^2 / 2).
#[derive(Debug, Clone)]
pub struct SmoothCurves {
    /// Channel after channel, `columns` each: 1, then Psi.
    pub(crate) rows: Vec<f64>,
    pub(crate) columns: usize,
}

impl SmoothCurves {
    /// By Cholesky's factor with pivots, each the channel that the columns so far describe worst (H. Harbrecht, M. Peters,
    /// R. Schneider, Appl. Numer. Math. 62, 428 (2012)): as many columns as the length asks for.
    pub fn new(wavelength_nm: &[f64], length_nm: f64) -> Result<SmoothCurves, InverseError> {
        let finite = wavelength_nm.iter().all(|nm| nm.is_finite());
        if !(finite && length_nm > 0.0 && length_nm.is_finite()) {
            return Err(InverseError::Argument(format!(
                "a length must be > 0 nm at finite wavelengths, got {length_nm}"
            )));
        }
        let count = wavelength_nm.len();
        let mut left = vec![1.0_f64; count];
        let mut basis: Vec<Vec<f64>> = Vec::new();
        while basis.len() < MOST_COLUMNS.min(count) {
            let (pivot, &most) = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).expect("there is a channel");
            if most < LEFT_OUT {
                break;
            }
            let scale = most.sqrt();
            let column: Vec<f64> = (0..count)
                .map(|i| {
                    let step = (wavelength_nm[i] - wavelength_nm[pivot]) / length_nm;
                    let known: f64 = basis.iter().map(|one| one[i] * one[pivot]).sum();
                    ((-0.5 * step * step).exp() - known) / scale
                })
                .collect();
            for (left, value) in left.iter_mut().zip(&column) {
                *left = (*left - value * value).max(0.0);
            }
            left[pivot] = 0.0;
            basis.push(column);
        }
        let columns = basis.len() + 1;
        let mut rows = Vec::with_capacity(count * columns);
        for i in 0..count {
            rows.push(1.0);
            rows.extend(basis.iter().map(|column| column[i]));
        }
        Ok(SmoothCurves { rows, columns })
    }

    /// Number of columns, the constant one included.
    pub fn columns(&self) -> usize {
        self.columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_make_the_covariance() {
        let nm: Vec<f64> = (0..120).map(|i| 400.0 + 3.0 * f64::from(i)).collect();
        for length in [20.0, 50.0, 120.0] {
            let curves = SmoothCurves::new(&nm, length).unwrap();
            assert!(curves.columns() < 50, "{}", curves.columns());
            for (i, j) in [(0, 0), (0, 5), (17, 31), (40, 119)] {
                let row = |i: usize| &curves.rows[i * curves.columns + 1..(i + 1) * curves.columns];
                let got: f64 = row(i).iter().zip(row(j)).map(|(a, b)| a * b).sum();
                let wanted = (-0.5 * ((nm[i] - nm[j]) / length).powi(2)).exp();
                assert!((got - wanted).abs() < 2e-4, "{length} {i} {j}: {got} {wanted}");
            }
        }
    }
}
