//! Cholesky's factor of a small symmetric matrix, in place: all that the evidence needs of linear algebra.

/// The lower factor of a symmetric positive definite matrix given by its lower triangle, row after row of `size`.
///
/// Matrices here are 1 + B^T B: their eigenvalues are at least 1, so a pivot below half of that is rounding and is held there.
pub(crate) fn factor(matrix: &mut [f64], size: usize) {
    for row in 0..size {
        for column in 0..=row {
            let (above, below) = matrix.split_at(row * size);
            let dot: f64 = if column < row {
                below[..column].iter().zip(&above[column * size..column * size + column]).map(|(a, b)| a * b).sum()
            } else {
                below[..row].iter().map(|a| a * a).sum()
            };
            let value = matrix[row * size + column] - dot;
            matrix[row * size + column] =
                if column < row { value / matrix[column * size + column] } else { value.max(0.5).sqrt() };
        }
    }
}

/// Solves C z = b in place.
pub(crate) fn forward(factor: &[f64], size: usize, right: &mut [f64]) {
    for row in 0..size {
        let line = &factor[row * size..row * size + row];
        let dot: f64 = line.iter().zip(&right[..row]).map(|(a, b)| a * b).sum();
        right[row] = (right[row] - dot) / factor[row * size + row];
    }
}

/// Solves C^T x = z in place.
pub(crate) fn backward(factor: &[f64], size: usize, right: &mut [f64]) {
    for row in (0..size).rev() {
        let dot: f64 = (row + 1..size).map(|below| factor[below * size + row] * right[below]).sum();
        right[row] = (right[row] - dot) / factor[row * size + row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_solves_its_matrix() {
        let matrix = [4.0, 0.0, 0.0, 2.0, 5.0, 0.0, 1.0, 3.0, 6.0];
        let full = |r: usize, c: usize| matrix[r.max(c) * 3 + r.min(c)];
        let wanted = [1.0, -2.0, 0.5];
        let mut right: Vec<f64> = (0..3).map(|r| (0..3).map(|c| full(r, c) * wanted[c]).sum()).collect();
        let mut lower = matrix.to_vec();
        factor(&mut lower, 3);
        forward(&lower, 3, &mut right);
        backward(&lower, 3, &mut right);
        for (got, wanted) in right.iter().zip(wanted) {
            assert!((got - wanted).abs() < 1e-14, "{right:?}");
        }
    }
}
