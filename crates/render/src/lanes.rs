//! Sixteen values side by side: the unit in which spectra are stored and worked on.

use fearless_simd::{Simd, f32x16, prelude::*};

/// Nodes come in multiples of the widest vector, so that kernels need no remainder loop.
pub const LANES: usize = 16;

/// Sixteen neighbouring spectral nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    pub const ZERO: Lanes = Lanes([0.0; LANES]);
    pub const ONE: Lanes = Lanes([1.0; LANES]);

    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::load_array_ref(simd, &self.0)
    }

    #[inline(always)]
    pub fn store<S: Simd>(&mut self, value: f32x16<S>) {
        value.store_array(&mut self.0);
    }
}

/// A whole spectrum in blocks of sixteen; the length must be a multiple of sixteen.
pub fn blocks(values: impl Iterator<Item = f64>) -> Vec<Lanes> {
    let values: Vec<f64> = values.collect();
    values.chunks(LANES).map(|chunk| Lanes(std::array::from_fn(|i| chunk[i] as f32))).collect()
}

/// Evaluates c[0] + c[1] x + c[2] x^2 + .. by Horner's rule.
#[inline(always)]
pub fn polynomial<S: Simd, const N: usize>(simd: S, x: f32x16<S>, coefficients: &[f32; N]) -> f32x16<S> {
    let mut sum = f32x16::splat(simd, coefficients[N - 1]);
    for &c in coefficients[..N - 1].iter().rev() {
        sum = sum.mul_add(x, f32x16::splat(simd, c));
    }
    sum
}
