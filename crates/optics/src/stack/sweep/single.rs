//! The lossless film of `film` in single precision: twice the lanes, half the bytes.
//!
//! The phase is kept: rate and thickness come in two parts each, so that what is left of many half turns is good to
//! 1e-7 of a half turn however thick the film is (a rounded thickness alone would cost 6e-8 of the whole phase). Where
//! the machine does not fuse multiplication and addition, one rounding of the product remains.

use fearless_simd::{Simd, prelude::*};

use super::film::FilmRows;

/// sin(pi x) = x P(x^2) on [-1/2, 1/2]: P through five Chebyshev nodes, relative error 4e-8.
const SIN_PI: [f32; 5] = [std::f32::consts::PI, -5.167_710_3, 2.550_077_4, -0.598_290_4, 0.077_655_91];
/// Adding and taking away 1.5 * 2^23 rounds to the nearest integer; for arguments below 2^22.
const ROUND: f32 = 12_582_912.0;
/// Thicker films leave no room for the parts of the phase below.
pub(super) const MOST_HALF_TURNS: f64 = 65_536.0;
/// 1 + d s must not cancel: less than this left costs digits that single precision does not have.
pub(super) const LEAST_LEFT: f64 = 0.05;

/// A number as the sum of two of single precision.
fn parts(value: f64) -> [f32; 2] {
    let high = value as f32;
    [high, (value - f64::from(high)) as f32]
}

/// Thicknesses ready for many rows: high and low parts.
#[derive(Debug, Default)]
pub(super) struct Lengths {
    high: Vec<f32>,
    low: Vec<f32>,
}

impl Lengths {
    pub(super) fn set(&mut self, thickness_nm: &[f64]) {
        self.high.clear();
        self.low.clear();
        for &thickness in thickness_nm {
            let [high, low] = parts(thickness);
            self.high.push(high);
            self.low.push(low);
        }
    }
}

/// One row of films in vectors of single precision.
#[derive(Clone, Copy)]
struct Row<V, const PARTS: usize> {
    rate: [V; 2],
    parts: [[V; 3]; PARTS],
}

#[inline(always)]
fn evaluate<S: Simd, const PARTS: usize>(simd: S, row: &Row<S::f32s, PARTS>, high: S::f32s, low: S::f32s) -> S::f32s {
    let [zero, one, round] = [0.0, 1.0, ROUND].map(|x| S::f32s::splat(simd, x));
    let whole = row.rate[0].mul_add(high, round) - round;
    let small = row.rate[1].mul_add(high, row.rate[0] * low);
    let x = row.rate[0].mul_sub(high, whole) + small;
    let y = x * x;
    let mut sum = S::f32s::splat(simd, SIN_PI[4]);
    for k in (0..4).rev() {
        sum = sum.mul_add(y, S::f32s::splat(simd, SIN_PI[k]));
    }
    let s = y * (sum * sum);
    let [a, b, d] = row.parts[0];
    let (over, under) = (b.mul_add(s, a), d.mul_add(s, one));
    if PARTS == 1 {
        return (over / under).max(zero).min(one);
    }
    let [a, b, d] = row.parts[PARTS - 1];
    let (over_2, under_2) = (b.mul_add(s, a), d.mul_add(s, one));
    (over.mul_add(under_2, over_2 * under) / (under * under_2)).max(zero).min(one)
}

/// One row, all its thicknesses.
#[inline(always)]
pub(super) fn along_thickness<S: Simd, const PARTS: usize>(
    simd: S,
    rows: &FilmRows,
    row: usize,
    lengths: &Lengths,
    out: &mut [f32],
) {
    let [high, low] = parts(rows.rate.0[row]);
    let rate = [S::f32s::splat(simd, high), S::f32s::splat(simd, low)];
    let mut coefficients = [[rate[0]; 3]; PARTS];
    for (part, of) in coefficients.iter_mut().zip(&rows.parts) {
        let [a, b, d] = [of.a.0[row], of.b.0[row], of.d.0[row]];
        *part = [S::f32s::splat(simd, a as f32), S::f32s::splat(simd, b as f32), S::f32s::splat(simd, d as f32)];
    }
    let of_row = Row { rate, parts: coefficients };
    let mut highs = lengths.high.chunks_exact(S::f32s::LEN);
    let mut lows = lengths.low.chunks_exact(S::f32s::LEN);
    let mut results = out.chunks_exact_mut(S::f32s::LEN);
    for ((high, low), result) in (&mut highs).zip(&mut lows).zip(&mut results) {
        let (high, low) = (S::f32s::from_slice(simd, high), S::f32s::from_slice(simd, low));
        evaluate(simd, &of_row, high, low).store_slice(result);
    }
    let (count, lanes) = (out.len(), S::f32s::LEN);
    if count.is_multiple_of(lanes) {
        return;
    }
    if count > lanes {
        // The last vector reaches back into what is done already.
        let last = count - lanes;
        let (high, low) = (&lengths.high[last..], &lengths.low[last..]);
        let (high, low) = (S::f32s::from_slice(simd, high), S::f32s::from_slice(simd, low));
        evaluate(simd, &of_row, high, low).store_slice(&mut out[last..]);
        return;
    }
    // 16 lanes are the most that any level has.
    let (mut high, mut low, mut result) = ([0.0; 16], [0.0; 16], [0.0; 16]);
    high[..count].copy_from_slice(&lengths.high);
    low[..count].copy_from_slice(&lengths.low);
    let (high, low) = (S::f32s::from_slice(simd, &high[..lanes]), S::f32s::from_slice(simd, &low[..lanes]));
    evaluate(simd, &of_row, high, low).store_slice(&mut result[..lanes]);
    out.copy_from_slice(&result[..count]);
}
