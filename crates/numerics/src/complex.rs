//! Complex numbers over a [`Number`]: real and imaginary part side by side.

use crate::number::{Number, Precision};

/// Real and imaginary part.
pub type Complex<V> = [V; 2];

/// a + b.
#[inline(always)]
pub fn add<V: Number>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    [a[0] + b[0], a[1] + b[1]]
}

/// a - b.
#[inline(always)]
pub fn sub<V: Number>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    [a[0] - b[0], a[1] - b[1]]
}

/// a b.
#[inline(always)]
pub fn mul<V: Number>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    [a[0].mul_sub(b[0], a[1] * b[1]), a[0].mul_add(b[1], a[1] * b[0])]
}

/// 1 / z, by one division.
#[inline(always)]
pub fn inverse<V: Number>(z: Complex<V>) -> Complex<V> {
    let scale = z[0].like(1.0) / power(z);
    [z[0] * scale, -z[1] * scale]
}

/// |z|^2.
#[inline(always)]
pub fn power<V: Number>(z: Complex<V>) -> V {
    z[0].mul_add(z[0], z[1] * z[1])
}

/// a times the conjugate of b.
#[inline(always)]
pub fn conjugate_product<V: Number>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    [a[0].mul_add(b[0], a[1] * b[1]), a[1].mul_sub(b[0], a[0] * b[1])]
}

/// The square root with both parts >= 0 of a number with Im z >= 0, as long as |z|^2 stays in range. The smaller part comes
/// from the product, because |z| - Re z cancels; at z = 0 (a critical angle itself) a tiny value keeps ratios finite.
#[inline(always)]
pub fn square_root<V: Number>(z: Complex<V>) -> Complex<V> {
    let modulus = power(z).sqrt();
    let large = (modulus + z[0].abs()).times(0.5).max(z[0].like(V::Precision::LEAST_SQUARE)).sqrt();
    let small = z[1] / large.times(2.0);
    let forward = z[0].ge(z[0].like(0.0));
    [V::select(forward, large, small), V::select(forward, small, large)]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Simd, dispatch, f32x16, f64x8, prelude::*};

    use super::*;
    use crate::simd::levels;

    /// Product, quotient, root and their kin of two numbers, by one instance.
    #[inline(always)]
    fn all<V: Number>(a: Complex<V>, b: Complex<V>) -> [Complex<V>; 6] {
        let zero = a[0].like(0.0);
        [
            mul(a, b),
            mul(a, inverse(b)),
            square_root([a[0], a[1].abs()]),
            conjugate_product(a, b),
            add(a, sub(a, b)),
            [power(a), zero],
        ]
    }

    #[inline(always)]
    fn lanes<S: Simd>(simd: S, a: [f64; 2], b: [f64; 2]) -> [[[f64; 2]; 6]; 2] {
        let double = |z: [f64; 2]| z.map(|part| f64x8::splat(simd, part));
        let single = |z: [f64; 2]| z.map(|part| f32x16::splat(simd, part as f32));
        [
            all(double(a), double(b)).map(|z| z.map(|part| part.to_array()[5])),
            all(single(a), single(b)).map(|z| z.map(|part| f64::from(part.to_array()[9]))),
        ]
    }

    /// Against each other, in units of the last digit of the modulus: products and sums of two roundings, quotients and
    /// roots of five.
    #[test]
    fn instances_agree() {
        for i in 0..500_u32 {
            // Exact in single precision.
            let part = |k: u32| f64::from(i.wrapping_mul(k) % 2048) / 512.0 - 2.0;
            let (a, b) = ([part(37), part(59)], [part(83), part(101) + 2.25]);
            let wanted = all(a, b);
            for level in levels() {
                for (got, unit) in dispatch!(level, simd => lanes(simd, a, b)).into_iter().zip([f64::EPSILON, 1.2e-7]) {
                    for (got, wanted) in got.into_iter().zip(wanted) {
                        let size = wanted[0].hypot(wanted[1]) + a[0].abs() + a[1].abs();
                        let error = (got[0] - wanted[0]).hypot(got[1] - wanted[1]);
                        assert!(error <= 5.0 * unit * size, "{level:?} {a:?} {b:?}: {got:?} {wanted:?}");
                    }
                }
            }
        }
    }
}
