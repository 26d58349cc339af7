//! The lossless film between lossless media: a phase, its squared sine, and one division for both polarisations.
//!
//! With the admittances y (kz for s, kz/n^2 for p) of the three media and s = sin^2(beta), beta = 2 pi kz2 t / lambda,
//!
//! ```text
//! R = (p + d s)/(1 + d s),   T = (1 - p)/(1 + d s)
//! p = ((y1 - y3)/(y1 + y3))^2,   d = (y2^2 - y1^2)(y2^2 - y3^2)/(y2^2 (y1 + y3)^2)
//! ```
//!
//! which is Airy's sum over a common denominator (Born & Wolf, Principles of Optics, 7th ed., sec. 7.6): p is the bare
//! interface without the film, and 1 + d s stays between 1 and what the film does at a quarter wave.

use fearless_simd::{Simd, prelude::*};

use super::lanes::{LANES, Lane, sin_pi, within_half_turn};

/// Where a film makes an interface clearer (d < 0), 1 + d s may cancel; with less than this left of it digits would be
/// lost that the rule of 1e-12 needs, and the fields are marched instead.
const LEAST_LEFT: f64 = 1e-3;

/// Rows of films: one wavelength and direction a lane. Each polarisation that is asked for contributes
/// `(a + b s)/(1 + d s)` to the answer.
#[derive(Debug, Clone)]
pub(super) struct FilmRows {
    /// Half turns of phase per nm of thickness.
    pub(super) rate: Lane,
    pub(super) parts: [Part; 2],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) a: Lane,
    pub(super) b: Lane,
    pub(super) d: Lane,
}

impl FilmRows {
    pub(super) fn new() -> FilmRows {
        let part = Part { a: Lane::ZERO, b: Lane::ZERO, d: Lane::ZERO };
        FilmRows { rate: Lane::ZERO, parts: [part; 2] }
    }
}

/// `(a + b s)/(1 + d s)` of a lossless film; `sound` is cleared where this form would lose digits.
#[inline(always)]
pub(super) fn prepare_part<S: Simd>(
    simd: S,
    squares: [S::f64s; 3],
    admittances: [S::f64s; 3],
    share: f64,
    transmittance: bool,
) -> ([S::f64s; 3], <S::f64s as SimdBase<S>>::Mask) {
    let [y1_2, y2_2, y3_2] = squares;
    let [y1, _, y3] = admittances;
    let one = S::f64s::splat(simd, 1.0);
    let share = S::f64s::splat(simd, share);
    let sum = y1 + y3;
    let inverse = one / (sum * sum * y2_2);
    let d = (y2_2 - y1_2) * (y2_2 - y3_2) * inverse;
    let bare = y2_2 * inverse;
    let step = y1 - y3;
    let passed = y1 * y3 * bare * 4.0;
    let sound = (d + one).simd_gt(S::f64s::splat(simd, LEAST_LEFT));
    let (a, b) = if transmittance { (passed, S::f64s::splat(simd, 0.0)) } else { (step * step * bare, d) };
    ([a * share, b * share, d], sound)
}

/// The answer of one vector of evaluations.
#[inline(always)]
fn evaluate<S: Simd, const PARTS: usize>(
    simd: S,
    rate: S::f64s,
    parts: &[[S::f64s; 3]; PARTS],
    thickness_nm: S::f64s,
) -> S::f64s {
    // A quarter wave that takes all reflection away cancels a against b s to rounding, on either side of zero.
    let (zero, one) = (S::f64s::splat(simd, 0.0), S::f64s::splat(simd, 1.0));
    let sine = sin_pi(simd, within_half_turn(simd, rate, thickness_nm));
    let s = sine * sine;
    let [a, b, d] = parts[0];
    let (over, under) = (b.mul_add(s, a), d.mul_add(s, one));
    if PARTS == 1 {
        return (over / under).max(zero).min(one);
    }
    // One division for two ratios: the divider is the busiest unit of this loop.
    let [a, b, d] = parts[PARTS - 1];
    let (over_2, under_2) = (b.mul_add(s, a), d.mul_add(s, one));
    (over.mul_add(under_2, over_2 * under) / (under * under_2)).max(zero).min(one)
}

/// One row, all its thicknesses: lanes are thicknesses.
#[inline(always)]
pub(super) fn along_thickness<S: Simd, const PARTS: usize>(
    simd: S,
    rows: &FilmRows,
    row: usize,
    thickness_nm: &[f64],
    out: &mut [f64],
) {
    let rate = S::f64s::splat(simd, rows.rate.0[row]);
    let mut parts = [[rate; 3]; PARTS];
    for (part, of) in parts.iter_mut().zip(&rows.parts) {
        let [a, b, d] = [of.a.0[row], of.b.0[row], of.d.0[row]];
        *part = [S::f64s::splat(simd, a), S::f64s::splat(simd, b), S::f64s::splat(simd, d)];
    }
    let mut thicknesses = thickness_nm.chunks_exact(S::f64s::LEN);
    let mut results = out.chunks_exact_mut(S::f64s::LEN);
    for (t, result) in (&mut thicknesses).zip(&mut results) {
        evaluate(simd, rate, &parts, S::f64s::from_slice(simd, t)).store_slice(result);
    }
    let (count, lanes) = (out.len(), S::f64s::LEN);
    if count.is_multiple_of(lanes) {
        return;
    }
    if count > lanes {
        // The last vector reaches back into what is done already.
        let last = count - lanes;
        let t = S::f64s::from_slice(simd, &thickness_nm[last..]);
        evaluate(simd, rate, &parts, t).store_slice(&mut out[last..]);
        return;
    }
    let (mut t, mut result) = (Lane::ZERO, Lane::ZERO);
    t.0[..count].copy_from_slice(thickness_nm);
    result.store::<S>(0, evaluate(simd, rate, &parts, t.load(simd, 0)));
    out.copy_from_slice(&result.0[..count]);
}

/// One thickness a row, all rows of a block: lanes are rows.
#[inline(always)]
pub(super) fn along_rows<S: Simd, const PARTS: usize>(simd: S, rows: &FilmRows, thickness_nm: &Lane, out: &mut Lane) {
    for at in (0..LANES).step_by(S::f64s::LEN) {
        let rate = rows.rate.load(simd, at);
        let mut parts = [[rate; 3]; PARTS];
        for (part, of) in parts.iter_mut().zip(&rows.parts) {
            *part = [of.a.load(simd, at), of.b.load(simd, at), of.d.load(simd, at)];
        }
        out.store::<S>(at, evaluate(simd, rate, &parts, thickness_nm.load(simd, at)));
    }
}

/// All thicknesses, all rows of a block, added to the three weighted sums of each thickness.
#[inline(always)]
pub(super) fn weigh_along_rows<S: Simd, const PARTS: usize>(
    simd: S,
    rows: &FilmRows,
    thickness_nm: &[f64],
    weights: &[Lane; 3],
    sums: &mut [[Lane; 3]],
) {
    for at in (0..LANES).step_by(S::f64s::LEN) {
        let rate = rows.rate.load(simd, at);
        let mut parts = [[rate; 3]; PARTS];
        for (part, of) in parts.iter_mut().zip(&rows.parts) {
            *part = [of.a.load(simd, at), of.b.load(simd, at), of.d.load(simd, at)];
        }
        let weights = [weights[0].load(simd, at), weights[1].load(simd, at), weights[2].load(simd, at)];
        for (&thickness, sums) in thickness_nm.iter().zip(&mut *sums) {
            let value = evaluate(simd, rate, &parts, S::f64s::splat(simd, thickness));
            for (sum, weight) in sums.iter_mut().zip(weights) {
                let added = value.mul_add(weight, sum.load(simd, at));
                sum.store::<S>(at, added);
            }
        }
    }
}
