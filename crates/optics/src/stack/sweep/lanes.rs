//! Functions of whole vectors: the sine and cosine of a number of half turns, and `exp(x) - 1`.
//!
//! Vectors are as wide as the machine has them; where it fuses multiplication and addition the results are a rounding
//! better. Phases come as a rate and a length, so that the whole half turns are taken off the exact product.

use fearless_simd::{Simd, prelude::*};

/// Evaluations that are prepared and carried together: one vector of the widest level, several of the others.
pub(crate) const LANES: usize = 8;

/// One number for each of [`LANES`] evaluations.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Lane(pub(crate) [f64; LANES]);

impl Lane {
    pub(crate) const ZERO: Lane = Lane([0.0; LANES]);

    /// The entries from `at` on, as many as a vector holds.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, at: usize) -> S::f64s {
        S::f64s::from_slice(simd, &self.0[at..at + S::f64s::LEN])
    }

    /// The sum of all lanes, in an order of its own.
    pub(super) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }

    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, at: usize, value: S::f64s) {
        value.store_slice(&mut self.0[at..at + S::f64s::LEN]);
    }
}

/// Adds `values` to three sums, each times its weight.
#[inline(always)]
pub(super) fn add_weighted<S: Simd>(simd: S, values: &Lane, weights: &[Lane; 3], sums: &mut [Lane; 3]) {
    for (weight, sum) in weights.iter().zip(sums) {
        for at in (0..LANES).step_by(S::f64s::LEN) {
            let value = values.load(simd, at).mul_add(weight.load(simd, at), sum.load(simd, at));
            sum.store::<S>(at, value);
        }
    }
}

/// sin(pi x) = x P(x^2) on [-1/2, 1/2], P through nine Chebyshev nodes: relative error 4e-17 before rounding.
const SIN_PI: [f64; 9] = [
    std::f64::consts::PI,
    -5.167712780049969,
    2.5501640398773007,
    -0.5992645293189447,
    0.0821458865731029,
    -0.007370430505916944,
    0.0004662998161898394,
    -2.1903497074626018e-05,
    7.697826768224191e-07,
];
/// cos(pi x) = P(x^2) on [-1/2, 1/2], likewise: error 1e-16 before rounding.
const COS_PI: [f64; 9] = [
    1.0,
    -4.934802200544676,
    4.058712126416497,
    -1.335262768843447,
    0.23533063012953284,
    -0.025806888737002202,
    0.0019295562724817132,
    -0.00010456655338748738,
    4.149564353942586e-06,
];
/// Adding and taking away 1.5 * 2^52 rounds to the nearest integer; for arguments below 2^51.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// More half turns than this are for the careful path: beyond, rounding to integers and all digits of the phase are lost.
pub(super) const MOST_HALF_TURNS: f64 = (1_u64 << 40) as f64;

/// c[0] + c[1] x + c[2] x^2 + .. as even and odd powers apart: half the waiting of Horner's rule, one product more.
#[inline(always)]
pub(super) fn polynomial<S: Simd, const N: usize>(simd: S, x: S::f64s, c: &[f64; N]) -> S::f64s {
    let square = x * x;
    let mut last = S::f64s::splat(simd, c[N - 1]);
    let mut before = S::f64s::splat(simd, c[N - 2]);
    for k in (0..N - 2).rev() {
        let next = last.mul_add(square, S::f64s::splat(simd, c[k]));
        last = before;
        before = next;
    }
    last.mul_add(x, before)
}

/// `rate * length` half turns less the nearest whole number of them, within +-1/2 (and a rounding).
#[inline(always)]
pub(super) fn within_half_turn<S: Simd>(simd: S, rate: S::f64s, length: S::f64s) -> S::f64s {
    let round = S::f64s::splat(simd, ROUND);
    let whole = rate.mul_add(length, round) - round;
    rate.mul_sub(length, whole)
}

/// sin(pi x) for |x| <= 1/2.
#[inline(always)]
pub(crate) fn sin_pi<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    x * polynomial(simd, x * x, &SIN_PI)
}

/// sin(pi x) and cos(pi x) for |x| <= 1/2.
#[inline(always)]
pub(super) fn sin_cos_pi<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let y = x * x;
    (x * polynomial(simd, y, &SIN_PI), polynomial(simd, y, &COS_PI))
}

/// exp(r) - 1 = r + r^2 P(r) for |r| <= ln(2)/2: Taylor's terms to r^14, the rest below 1e-18 of the whole.
const EXP_M1: [f64; 13] = [
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
    1.0 / 87_178_291_200.0,
];
/// ln 2 in two parts; the first ends in zeros, so that its product with a small integer is exact.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// exp of less is no normal number.
const LEAST_EXPONENT: f64 = -708.0;

/// exp(x) - 1 for x <= 0, good to a rounding or two of itself however small x is; and exp(x), 0 below exp(-708).
#[inline(always)]
pub(super) fn exp_m1<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let least = S::f64s::splat(simd, LEAST_EXPONENT);
    let vanishes = x.simd_lt(least);
    let x = x.max(least);
    let (round, one) = (S::f64s::splat(simd, ROUND), S::f64s::splat(simd, 1.0));
    let whole = x.mul_add(S::f64s::splat(simd, std::f64::consts::LOG2_E), round) - round;
    let [high, low] = LN_2.map(|part| S::f64s::splat(simd, -part));
    let rest = whole.mul_add(low, whole.mul_add(high, x));
    let part = (rest * rest).mul_add(polynomial(simd, rest, &EXP_M1), rest);
    // 2^whole: the integer stands in the low bits of the sum and is moved to where an exponent belongs.
    let bits = (whole + S::f64s::splat(simd, ROUND + 1023.0)).to_bits();
    let scale = S::f64s::from_bits(bits << 52);
    let less_one = scale.mul_add(part, scale - one);
    let zero = S::f64s::splat(simd, 0.0);
    (vanishes.select(-one, less_one), vanishes.select(zero, scale.mul_add(part, scale)))
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;

    #[inline(always)]
    fn sines_of<S: Simd>(simd: S, rate: f64, lengths: &[f64; LANES]) -> [[f64; LANES]; 3] {
        let (mut x, mut sin, mut cos) = (Lane::ZERO, Lane::ZERO, Lane::ZERO);
        for at in (0..LANES).step_by(S::f64s::LEN) {
            let within = within_half_turn(simd, S::f64s::splat(simd, rate), Lane(*lengths).load(simd, at));
            let (s, c) = sin_cos_pi(simd, within);
            x.store::<S>(at, within);
            sin.store::<S>(at, s);
            cos.store::<S>(at, c);
        }
        [x.0, sin.0, cos.0]
    }

    #[inline(always)]
    fn exponentials<S: Simd>(simd: S, x: &[f64; LANES]) -> [[f64; LANES]; 2] {
        let (mut less_one, mut whole) = (Lane::ZERO, Lane::ZERO);
        for at in (0..LANES).step_by(S::f64s::LEN) {
            let (m1, exp) = exp_m1(simd, Lane(*x).load(simd, at));
            less_one.store::<S>(at, m1);
            whole.store::<S>(at, exp);
        }
        [less_one.0, whole.0]
    }

    #[test]
    fn sines_and_cosines_of_half_turns() {
        for level in super::super::levels() {
            for i in 0..2000 {
                let rate = f64::from(i) / 4096.0 - 0.25;
                let lengths = [0.0, 0.5, 1.0, 1.5, 3.0, 64.0, 1000.0, 1.0 + f64::EPSILON];
                let [x, sin, cos] = dispatch!(level, simd => sines_of(simd, rate, &lengths));
                for (lane, length) in lengths.into_iter().enumerate() {
                    let half_turns = rate * length; // exact but for the last length
                    let nearest = half_turns.round_ties_even();
                    let sign = if nearest % 2.0 == 0.0 { 1.0 } else { -1.0 };
                    let (s, c) = (std::f64::consts::PI * (half_turns - nearest)).sin_cos();
                    let factor = if (x[lane] - (half_turns - nearest)).abs() > 0.5 { -1.0 } else { 1.0 };
                    assert!(x[lane].abs() <= 0.5 && sign * sign == 1.0);
                    assert!((factor * sin[lane] - s).abs() < 5e-16, "{level:?} {half_turns}: {} {s}", sin[lane]);
                    assert!((factor * cos[lane] - c).abs() < 5e-16, "{level:?} {half_turns}: {} {c}", cos[lane]);
                }
            }
        }
    }

    #[test]
    fn exponential_less_one_keeps_its_digits() {
        let xs = [0.0, -1e-300, -1e-17, -1e-8, -1e-3, -0.34, -0.36, -0.7, -1.0, -5.0, -37.0, -300.0, -700.0, -708.1];
        for level in super::super::levels() {
            for x in xs.into_iter().chain((0..4000).map(|i| -f64::from(i) * 0.01)) {
                let [less_one, exp] = dispatch!(level, simd => exponentials(simd, &[x; LANES]));
                assert!((less_one[3] - x.exp_m1()).abs() <= 4e-16 * x.exp_m1().abs(), "{level:?} {x}: {}", less_one[3]);
                let wanted = if x < LEAST_EXPONENT { 0.0 } else { x.exp() };
                assert!((exp[3] - wanted).abs() <= 4e-16 * wanted, "{level:?} {x}: {:e} {wanted:e}", exp[3]);
            }
            assert_eq!(dispatch!(level, simd => exponentials(simd, &[-1e9; LANES])), [[-1.0; LANES], [0.0; LANES]]);
        }
    }
}
