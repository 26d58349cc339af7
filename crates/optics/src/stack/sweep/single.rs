//! The lossless film of `film` in single precision: twice the lanes, half the bytes.
//!
//! The phase is kept: rate and thickness come in two parts each, so that what is left of many half turns is good to
//! 1e-7 of a half turn however thick the film is (a rounded thickness alone would cost 6e-8 of the whole phase). Where
//! the machine does not fuse multiplication and addition, one rounding of the product remains.

use fearless_simd::Simd;
use iridesce_numerics::turns::sin_squared_pi;
use iridesce_numerics::{F32s, Number, Precision};

use super::film::FilmRows;
use crate::film::kernel::Fringes;

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
    parts: [Fringes<V>; PARTS],
}

#[inline(always)]
fn evaluate<V: Number<Precision = f32>, const PARTS: usize>(row: &Row<V, PARTS>, high: V, low: V) -> V {
    let round = high.like(f32::ROUND);
    let whole = row.rate[0].mul_add(high, round) - round;
    let small = row.rate[1].mul_add(high, row.rate[0] * low);
    let x = row.rate[0].mul_sub(high, whole) + small;
    Fringes::sum(&row.parts, sin_squared_pi(x))
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
    let rate = [F32s::splat(simd, high), F32s::splat(simd, low)];
    let mut coefficients = [Fringes { a: rate[0], b: rate[0], d: rate[0] }; PARTS];
    for (part, of) in coefficients.iter_mut().zip(&rows.parts) {
        part.a = F32s::splat(simd, of.a.0[row] as f32);
        part.b = F32s::splat(simd, of.b.0[row] as f32);
        part.d = F32s::splat(simd, of.d.0[row] as f32);
    }
    let of_row = Row { rate, parts: coefficients };
    let mut highs = lengths.high.chunks_exact(F32s::<S>::LEN);
    let mut lows = lengths.low.chunks_exact(F32s::<S>::LEN);
    let mut results = out.chunks_exact_mut(F32s::<S>::LEN);
    for ((high, low), result) in (&mut highs).zip(&mut lows).zip(&mut results) {
        let (high, low) = (F32s::from_slice(simd, high), F32s::from_slice(simd, low));
        evaluate(&of_row, high, low).store_slice(result);
    }
    let (count, lanes) = (out.len(), F32s::<S>::LEN);
    if count.is_multiple_of(lanes) {
        return;
    }
    if count > lanes {
        // The last vector reaches back into what is done already.
        let last = count - lanes;
        let (high, low) = (&lengths.high[last..], &lengths.low[last..]);
        let (high, low) = (F32s::from_slice(simd, high), F32s::from_slice(simd, low));
        evaluate(&of_row, high, low).store_slice(&mut out[last..]);
        return;
    }
    // 16 lanes are the most that any level has.
    let (mut high, mut low, mut result) = ([0.0; 16], [0.0; 16], [0.0; 16]);
    high[..count].copy_from_slice(&lengths.high);
    low[..count].copy_from_slice(&lengths.low);
    let (high, low) = (F32s::from_slice(simd, &high[..lanes]), F32s::from_slice(simd, &low[..lanes]));
    evaluate(&of_row, high, low).store_slice(&mut result[..lanes]);
    out.copy_from_slice(&result[..count]);
}
