//! How many evaluations go together, and the sums over them.

use fearless_simd::Simd;
pub(crate) use iridesce_numerics::lanes::{DOUBLES as LANES, Doubles as Lane};
use iridesce_numerics::{F64s, Number};

/// More half turns than this are for the careful path: beyond, rounding to integers and all digits of the phase are lost.
pub(super) const MOST_HALF_TURNS: f64 = (1_u64 << 40) as f64;

/// Adds `values` to three sums, each times its weight.
#[inline(always)]
pub(super) fn add_weighted<S: Simd>(simd: S, values: &Lane, weights: &[Lane; 3], sums: &mut [Lane; 3]) {
    for (weight, sum) in weights.iter().zip(sums) {
        for at in (0..LANES).step_by(F64s::<S>::LEN) {
            let value = values.load(simd, at).mul_add(weight.load(simd, at), sum.load(simd, at));
            sum.store::<S>(at, value);
        }
    }
}
