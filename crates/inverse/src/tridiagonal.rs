//! Many systems 1 + t K x = b of one K: a tridiagonal matrix that K is turned into once makes each of them a walk along it.

use fearless_simd::Simd;

use crate::cholesky::dots;

/// A symmetric matrix K as Q T Q^T, T tridiagonal, with some vectors turned along: Q^T b.
pub(crate) struct Tridiagonal<const N: usize> {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    turned: [Vec<f64>; N],
}

impl<const N: usize> Tridiagonal<N> {
    /// By Householder's reflections (G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed. 2013, sec. 8.3.1) from the lower
    /// triangle, row after row of `size`, which is used up.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, matrix: &mut [f64], size: usize, mut turned: [Vec<f64>; N]) -> Tridiagonal<N> {
        let mut beside = vec![0.0; size.saturating_sub(1)];
        let (mut v, mut p) = (vec![0.0; size], vec![0.0; size]);
        for k in 0..size.saturating_sub(1) {
            let left = size - k - 1;
            let (v, p) = (&mut v[..left], &mut p[..left]);
            for (i, v) in v.iter_mut().enumerate() {
                *v = matrix[(k + 1 + i) * size + k];
            }
            let [below] = dots(simd, &[&v[1..]], &v[1..]);
            if below == 0.0 {
                // Nothing to turn away.
                beside[k] = v[0];
                continue;
            }
            let length = (v[0] * v[0] + below).sqrt();
            // Away from the first: nothing cancels.
            let onto = if v[0] > 0.0 { -length } else { length };
            beside[k] = onto;
            v[0] -= onto;
            let tau = 2.0 / (v[0] * v[0] + below);
            p.fill(0.0);
            for (i, row) in matrix.chunks_exact(size).skip(k + 1).enumerate() {
                let row = &row[k + 1..=k + 1 + i];
                let [own] = dots(simd, &[&row[..i]], &v[..i]);
                p[i] += own + row[i] * v[i];
                let along = v[i];
                p[..i].iter_mut().zip(row).for_each(|(p, a)| *p += along * a);
            }
            let [across] = dots(simd, &[&*p], v);
            let half = 0.5 * tau * across;
            p.iter_mut().zip(&*v).for_each(|(p, v)| *p = tau * (*p - half * v));
            for (i, row) in matrix.chunks_exact_mut(size).skip(k + 1).enumerate() {
                let (vi, pi) = (v[i], p[i]);
                let row = &mut row[k + 1..=k + 1 + i];
                row.iter_mut().zip(&*p).zip(&*v).for_each(|((a, p), v)| *a -= vi * p + pi * v);
            }
            for one in &mut turned {
                let [along] = dots(simd, &[&one[k + 1..]], v);
                one[k + 1..].iter_mut().zip(&*v).for_each(|(b, v)| *b -= tau * along * v);
            }
        }
        Tridiagonal { diagonal: (0..size).map(|i| matrix[i * size + i]).collect(), beside, turned }
    }

    /// Largest sum of sizes along a row of T: no eigenvalue of K is larger.
    pub(crate) fn bound(&self) -> f64 {
        (0..self.diagonal.len())
            .map(|i| {
                let before = if i > 0 { self.beside[i - 1].abs() } else { 0.0 };
                self.diagonal[i].abs() + before + self.beside.get(i).map_or(0.0, |one| one.abs())
            })
            .fold(0.0, f64::max)
    }

    /// log det (1 + t K) and b^T (1 + t K)^-1 b, b the sum of the turned vectors times `parts`; K's eigenvalues are >= 0.
    #[inline(always)]
    pub(crate) fn solved(&self, t: f64, parts: [f64; N]) -> (f64, f64) {
        let right = |i: usize| -> f64 { (0..N).map(|n| parts[n] * self.turned[n][i]).sum() };
        let (mut volume, mut product, mut square) = (0.0, 1.0_f64, 0.0);
        let (mut pivot, mut z) = (1.0, 0.0);
        for i in 0..self.diagonal.len() {
            let beside = if i > 0 { t * self.beside[i - 1] } else { 0.0 };
            let step = beside / pivot;
            z = right(i) - step * z;
            // Eigenvalues are at least 1: a pivot below half of that is rounding.
            pivot = (1.0 + t * self.diagonal[i] - step * beside).max(0.5);
            square += z * z / pivot;
            product *= pivot;
            // A logarithm now and then: no pivot is above 1e40.
            if i % 4 == 3 {
                volume += product.ln();
                product = 1.0;
            }
        }
        (volume + product.ln(), square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::{factor, forward};
    use fearless_simd::dispatch;
    use iridesce_numerics::simd;

    #[test]
    fn a_walk_solves_what_a_factor_solves() {
        for size in [1, 2, 3, 17, 40] {
            // K = B B^T of few columns and of many: of deficient and of full rank.
            for rank in [1, size / 2 + 1, 2 * size] {
                let b: Vec<f64> = (0..size * rank).map(|i| (i as f64 * 1.7 + 0.3 * rank as f64).sin()).collect();
                let k = |r: usize, c: usize| -> f64 { (0..rank).map(|j| b[r * rank + j] * b[c * rank + j]).sum() };
                let right: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
                let other: Vec<f64> = (0..size).map(|i| 1.0 / (1.0 + i as f64)).collect();
                let mut matrix: Vec<f64> = (0..size * size).map(|i| k(i / size, i % size)).collect();
                let made = dispatch!(simd::level_or_best(), simd => Tridiagonal::new(simd, &mut matrix, size, [right.clone(), other.clone()]));
                for t in [1e-3, 1.0, 1e5] {
                    let mut whole: Vec<f64> = (0..size * size)
                        .map(|i| t * k(i / size, i % size) + f64::from(u8::from(i / size == i % size)))
                        .collect();
                    let mut z: Vec<f64> = right.iter().zip(&other).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
                    dispatch!(simd::level_or_best(), simd => factor(simd, &mut whole, size));
                    dispatch!(simd::level_or_best(), simd => forward(simd, &whole, size, &mut z));
                    let volume: f64 = (0..size).map(|i| 2.0 * whole[i * size + i].ln()).sum();
                    let square: f64 = z.iter().map(|z| z * z).sum();
                    let got = made.solved(t, [2.0, -3.0]);
                    assert!((got.0 - volume).abs() < 1e-8 * (1.0 + volume), "{size} {rank} {t}: {got:?} {volume}");
                    assert!((got.1 - square).abs() < 1e-8 * (1.0 + square), "{size} {rank} {t}: {got:?} {square}");
                    assert!(
                        made.bound() * 1.000_001 >= (0..size).map(|i| k(i, i)).fold(0.0, f64::max),
                        "{size} {rank}"
                    );
                }
            }
        }
    }
}
