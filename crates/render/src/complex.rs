//! Complex numbers in sixteen lanes: real and imaginary parts side by side.

use fearless_simd::{Simd, f32x16, prelude::*};

/// A complex number in every lane.
pub type Complex<S> = [f32x16<S>; 2];

#[inline(always)]
pub fn add<S: Simd>(a: Complex<S>, b: Complex<S>) -> Complex<S> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub fn sub<S: Simd>(a: Complex<S>, b: Complex<S>) -> Complex<S> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub fn mul<S: Simd>(a: Complex<S>, b: Complex<S>) -> Complex<S> {
    [a[0].mul_sub(b[0], a[1] * b[1]), a[0].mul_add(b[1], a[1] * b[0])]
}

#[inline(always)]
pub fn inverse<S: Simd>(simd: S, z: Complex<S>) -> Complex<S> {
    let scale = f32x16::splat(simd, 1.0) / power(z);
    [z[0] * scale, -z[1] * scale]
}

/// |z|^2.
#[inline(always)]
pub fn power<S: Simd>(z: Complex<S>) -> f32x16<S> {
    z[0].mul_add(z[0], z[1] * z[1])
}

/// a times the conjugate of b.
#[inline(always)]
pub fn conjugate_product<S: Simd>(a: Complex<S>, b: Complex<S>) -> Complex<S> {
    [a[0].mul_add(b[0], a[1] * b[1]), a[1].mul_sub(b[0], a[0] * b[1])]
}

/// Square root with both parts >= 0 for Im z >= 0. The smaller part comes from the product, because
/// |z| - Re z cancels. At z = 0 (the critical angle itself) a tiny value keeps the ratios finite.
#[inline(always)]
pub fn square_root<S: Simd>(simd: S, z: Complex<S>) -> Complex<S> {
    let modulus = power(z).sqrt();
    let large = ((modulus + z[0].abs()) * 0.5).max(f32x16::splat(simd, 1e-12)).sqrt();
    let small = z[1] / (large * 2.0);
    let forward = z[0].simd_ge(f32x16::splat(simd, 0.0));
    [forward.select(large, small), forward.select(small, large)]
}
