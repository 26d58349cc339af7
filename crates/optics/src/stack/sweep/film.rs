//! Lossless films between lossless media along thicknesses or rows: a phase, its squared sine, and one division for both
//! polarisations ([`Fringes`]).

use fearless_simd::Simd;
use iridesce_numerics::turns::{sin_squared_pi, within_half_turn};
use iridesce_numerics::{F64s, Number};

use super::lanes::{LANES, Lane};
use crate::film::kernel::Fringes;

/// Where a film makes an interface clearer (d < 0), 1 + d s may cancel; with less than this left of it digits would be
/// lost that the rule of 1e-12 needs, and the fields are marched instead.
pub(super) const LEAST_LEFT: f64 = 1e-3;

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

/// The answer of one vector of evaluations.
#[inline(always)]
fn evaluate<V: Number, const PARTS: usize>(rate: V, parts: &[Fringes<V>; PARTS], thickness_nm: V) -> V {
    Fringes::sum(parts, sin_squared_pi(within_half_turn(rate, thickness_nm)))
}

// Loops, not closures: those are not always compiled for the wider instructions.
impl FilmRows {
    /// The polarisations asked for of one row, in every lane.
    #[inline(always)]
    fn row<S: Simd, const PARTS: usize>(&self, simd: S, row: usize) -> [Fringes<F64s<S>>; PARTS] {
        let none = F64s::splat(simd, 0.0);
        let mut parts = [Fringes { a: none, b: none, d: none }; PARTS];
        for (part, of) in parts.iter_mut().zip(&self.parts) {
            part.a = F64s::splat(simd, of.a.0[row]);
            part.b = F64s::splat(simd, of.b.0[row]);
            part.d = F64s::splat(simd, of.d.0[row]);
        }
        parts
    }

    /// The polarisations asked for of the rows from `at` on.
    #[inline(always)]
    fn rows<S: Simd, const PARTS: usize>(&self, simd: S, at: usize) -> [Fringes<F64s<S>>; PARTS] {
        let none = F64s::splat(simd, 0.0);
        let mut parts = [Fringes { a: none, b: none, d: none }; PARTS];
        for (part, of) in parts.iter_mut().zip(&self.parts) {
            *part = Fringes { a: of.a.load(simd, at), b: of.b.load(simd, at), d: of.d.load(simd, at) };
        }
        parts
    }
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
    let rate = F64s::splat(simd, rows.rate.0[row]);
    let parts: [_; PARTS] = rows.row(simd, row);
    let mut thicknesses = thickness_nm.chunks_exact(F64s::<S>::LEN);
    let mut results = out.chunks_exact_mut(F64s::<S>::LEN);
    for (t, result) in (&mut thicknesses).zip(&mut results) {
        evaluate(rate, &parts, F64s::from_slice(simd, t)).store_slice(result);
    }
    let (count, lanes) = (out.len(), F64s::<S>::LEN);
    if count.is_multiple_of(lanes) {
        return;
    }
    if count > lanes {
        // The last vector reaches back into what is done already.
        let last = count - lanes;
        let t = F64s::from_slice(simd, &thickness_nm[last..]);
        evaluate(rate, &parts, t).store_slice(&mut out[last..]);
        return;
    }
    let (mut t, mut result) = (Lane::ZERO, Lane::ZERO);
    t.0[..count].copy_from_slice(thickness_nm);
    result.store::<S>(0, evaluate(rate, &parts, t.load(simd, 0)));
    out.copy_from_slice(&result.0[..count]);
}

/// One thickness a row, all rows of a block: lanes are rows.
#[inline(always)]
pub(super) fn along_rows<S: Simd, const PARTS: usize>(simd: S, rows: &FilmRows, thickness_nm: &Lane, out: &mut Lane) {
    for at in (0..LANES).step_by(F64s::<S>::LEN) {
        let rate = rows.rate.load(simd, at);
        let parts: [_; PARTS] = rows.rows(simd, at);
        out.store::<S>(at, evaluate(rate, &parts, thickness_nm.load(simd, at)));
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
    for at in (0..LANES).step_by(F64s::<S>::LEN) {
        let rate = rows.rate.load(simd, at);
        let parts: [_; PARTS] = rows.rows(simd, at);
        let weights = [weights[0].load(simd, at), weights[1].load(simd, at), weights[2].load(simd, at)];
        for (&thickness, sums) in thickness_nm.iter().zip(&mut *sums) {
            let value = evaluate(rate, &parts, F64s::splat(simd, thickness));
            for (sum, weight) in sums.iter_mut().zip(weights) {
                let added = value.mul_add(weight, sum.load(simd, at));
                sum.store::<S>(at, added);
            }
        }
    }
}
