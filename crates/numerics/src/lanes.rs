//! How arrays of numbers are stored for vectors: in blocks as long as the widest vector of any machine, so that kernels
//! need no remainder loop.

use fearless_simd::{Simd, f32x16, f64x8, prelude::*};

use crate::number::F64s;

/// Neighbouring numbers that are worked on together, aligned for the widest loads.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<T, const N: usize>(pub [T; N]);

/// Numbers of double precision in a block.
pub const DOUBLES: usize = 8;
/// Numbers of single precision in a block.
pub const SINGLES: usize = 16;

/// Eight of double precision.
pub type Doubles = Lanes<f64, DOUBLES>;
/// Sixteen of single precision.
pub type Singles = Lanes<f32, SINGLES>;

impl Doubles {
    /// All zero.
    pub const ZERO: Doubles = Lanes([0.0; 8]);

    /// The entries from `at` on, as many as the machine's own vector holds.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, at: usize) -> F64s<S> {
        F64s::from_slice(simd, &self.0[at..at + F64s::<S>::LEN])
    }

    /// Writes the entries from `at` on.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, at: usize, value: F64s<S>) {
        value.store_slice(&mut self.0[at..at + F64s::<S>::LEN]);
    }

    /// All eight.
    #[inline(always)]
    pub fn load_all<S: Simd>(&self, simd: S) -> f64x8<S> {
        f64x8::load_array_ref(simd, &self.0)
    }

    /// The sum of all lanes, in an order of its own.
    pub fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}

impl Singles {
    /// All zero.
    pub const ZERO: Singles = Lanes([0.0; 16]);
    /// All one.
    pub const ONE: Singles = Lanes([1.0; 16]);

    /// All sixteen.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::load_array_ref(simd, &self.0)
    }

    /// Writes all sixteen.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, value: f32x16<S>) {
        value.store_array(&mut self.0);
    }
}

/// A whole array in blocks of sixteen, rounded to single precision; its length must be a multiple of sixteen.
pub fn blocks(values: impl Iterator<Item = f64>) -> Vec<Singles> {
    let values: Vec<f64> = values.collect();
    values.chunks(SINGLES).map(|chunk| Lanes(std::array::from_fn(|i| chunk[i] as f32))).collect()
}
