//! Cholesky's factor of a small symmetric matrix, in place: all that the evidence needs of linear algebra.

use fearless_simd::{Simd, f64x8, prelude::*};

/// The lower factor of a symmetric positive definite matrix given by its lower triangle, row after row of `size`.
///
/// Matrices here are 1 + B^T B: their eigenvalues are at least 1, so a pivot below half of that is rounding and is held there.
#[inline(always)]
pub(crate) fn factor<S: Simd>(simd: S, matrix: &mut [f64], size: usize) {
    for row in 0..size {
        let (above, below) = matrix.split_at_mut(row * size);
        let line = &mut below[..=row];
        for column in 0..row {
            let other = &above[column * size..=column * size + column];
            line[column] = (line[column] - dot(simd, &line[..column], &other[..column])) / other[column];
        }
        line[row] = (line[row] - dot(simd, &line[..row], &line[..row])).max(0.5).sqrt();
    }
}

/// Numbers that are summed side by side.
const LANES: usize = 8;

/// a . b, in an order that does not depend on the processor.
#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    let [sum] = dots(simd, &[a], b);
    sum
}

/// Products of several vectors with one, side by side.
#[inline(always)]
pub(crate) fn dots<S: Simd, const N: usize, V: AsRef<[f64]>>(simd: S, of: &[V; N], with: &[f64]) -> [f64; N] {
    let (eights, rest) = with.as_chunks::<LANES>();
    let of = of.each_ref().map(|one| one.as_ref()[..with.len()].as_chunks::<LANES>());
    // (A plain loop over lanes was taken two by two.)
    let mut sums = [f64x8::splat(simd, 0.0); N];
    for (k, eight) in eights.iter().enumerate() {
        let eight = f64x8::load_array_ref(simd, eight);
        for n in 0..N {
            sums[n] += f64x8::load_array_ref(simd, &of[n].0[k]) * eight;
        }
    }
    let lanes = sums.map(f64x8::to_array);
    std::array::from_fn(|n| {
        let [p, q, r, s, t, u, v, w] = lanes[n];
        let rest: f64 = of[n].1.iter().zip(rest).map(|(a, b)| a * b).sum();
        ((p + t) + (r + v)) + ((q + u) + (s + w)) + rest
    })
}

/// Solves C z = b in place.
#[inline(always)]
pub(crate) fn forward<S: Simd>(simd: S, factor: &[f64], size: usize, right: &mut [f64]) {
    for row in 0..size {
        let known = dot(simd, &factor[row * size..row * size + row], &right[..row]);
        right[row] = (right[row] - known) / factor[row * size + row];
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
    use fearless_simd::dispatch;
    use iridesce_numerics::simd;

    #[test]
    fn a_factor_solves_its_matrix() {
        let matrix = [4.0, 0.0, 0.0, 2.0, 5.0, 0.0, 1.0, 3.0, 6.0];
        let full = |r: usize, c: usize| matrix[r.max(c) * 3 + r.min(c)];
        let wanted = [1.0, -2.0, 0.5];
        let mut right: Vec<f64> = (0..3).map(|r| (0..3).map(|c| full(r, c) * wanted[c]).sum()).collect();
        let mut lower = matrix.to_vec();
        dispatch!(simd::level_or_best(), simd => factor(simd, &mut lower, 3));
        dispatch!(simd::level_or_best(), simd => forward(simd, &lower, 3, &mut right));
        backward(&lower, 3, &mut right);
        for (got, wanted) in right.iter().zip(wanted) {
            assert!((got - wanted).abs() < 1e-14, "{right:?}");
        }
    }
}
