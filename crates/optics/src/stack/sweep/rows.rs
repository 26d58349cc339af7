//! What of a stack depends on wavelength and direction alone, for a block of rows at once.

use std::f64::consts::TAU;

use fearless_simd::{Simd, SimdMask};
use iridesce_numerics::Lanes;
use iridesce_numerics::complex::{inverse, mul, square_root};
use iridesce_numerics::{F64s, Number};

use super::film::{FilmRows, LEAST_LEFT};
use super::lanes::{LANES, Lane, MOST_HALF_TURNS};
use super::march::{Pair, StackRows};
use super::media::Media;
use crate::Complex64;
use crate::film::kernel::Fringes;
use crate::incidence::Incidence;

/// The arguments of a block of rows, gathered. Lanes past the last row repeat it.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) wavelength_nm: Lane,
    pub(super) incidence: [Incidence; LANES],
    cos_theta: Lane,
    sin_theta: Lane,
    /// Index of each different medium, and which of them is the first.
    n: Vec<Pair>,
    first: usize,
    kz_squared: Vec<Pair>,
    /// Rows for the careful path: light along a layer, or phases beyond all digits.
    pub(super) odd: [bool; LANES],
}

/// Below this kz^2 (in squared vacuum wavenumbers) light runs along the layer, and 1/kz is kept out of the kernels.
const LEAST_KZ_SQUARED: f64 = 1e-18;

impl Block {
    pub(super) fn new(media: usize, first: usize, incidence: Incidence) -> Block {
        Block {
            wavelength_nm: Lanes([1.0; LANES]),
            incidence: [incidence; LANES],
            cos_theta: Lane::ZERO,
            sin_theta: Lane::ZERO,
            n: vec![[Lane::ZERO; 2]; media],
            first,
            kz_squared: vec![[Lane::ZERO; 2]; media],
            odd: [false; LANES],
        }
    }

    pub(super) fn set(&mut self, lane: usize, wavelength_nm: f64, incidence: Incidence) {
        self.wavelength_nm.0[lane] = wavelength_nm;
        self.incidence[lane] = incidence;
        self.cos_theta.0[lane] = incidence.cos_theta();
        self.sin_theta.0[lane] = incidence.sin_theta();
    }

    pub(super) fn set_index(&mut self, medium: usize, lane: usize, n: Complex64) {
        self.n[medium][0].0[lane] = n.re;
        self.n[medium][1].0[lane] = n.im;
    }

    pub(super) fn index(&self, medium: usize, lane: usize) -> Complex64 {
        Complex64::new(self.n[medium][0].0[lane], self.n[medium][1].0[lane])
    }

    /// `kz^2` of every medium, with the digits of a double also where its terms cancel: see [`Incidence::kz_squared`].
    #[inline(always)]
    pub(super) fn wavenumbers<S: Simd>(&mut self, simd: S) {
        let mut cancels = false;
        for ([re, im], out) in self.n.iter().zip(&mut self.kz_squared) {
            for at in (0..LANES).step_by(F64s::<S>::LEN) {
                let (n, k) = (re.load(simd, at), im.load(simd, at));
                let n_first = self.n[self.first][0].load(simd, at);
                let first = n_first * self.cos_theta.load(simd, at);
                let first = first * first;
                let along = n_first * self.sin_theta.load(simd, at);
                let is_small = (n * n).lt(first);
                // (n - a)(n + a) + b, as the scalar form has it.
                let apart = Number::select(is_small, along, n_first);
                let added = Number::select(is_small, F64s::splat(simd, 0.0), first);
                let square = (n - apart).mul_add(n + apart, added - k * k);
                let cancelling = Number::select(is_small, along * along, first);
                cancels |= square.abs().lt(cancelling * 1e-3).any_true();
                out[0].store::<S>(at, square);
                out[1].store::<S>(at, n * k * 2.0);
            }
        }
        if cancels {
            self.wavenumbers_exactly();
        }
    }

    #[cold]
    fn wavenumbers_exactly(&mut self) {
        for medium in 0..self.n.len() {
            for lane in 0..LANES {
                let n_first = self.n[self.first][0].0[lane];
                let exact = self.incidence[lane].kz_squared(n_first, self.index(medium, lane));
                self.kz_squared[medium][0].0[lane] = exact.re;
            }
        }
    }

    /// Marks the rows that the kernels must leave alone; `thickest_nm` holds the greatest thickness of each
    /// medium, less than nothing where its wavenumber does not matter.
    #[inline(always)]
    pub(super) fn find_odd<S: Simd>(&mut self, simd: S, thickest_nm: &[f64]) {
        self.odd = [false; LANES];
        for ([re, im], &thickest) in self.kz_squared.iter().zip(thickest_nm) {
            if thickest < 0.0 {
                continue;
            }
            for at in (0..LANES).step_by(F64s::<S>::LEN) {
                let size = re.load(simd, at).abs() + im.load(simd, at).abs();
                let most = self.wavelength_nm.load(simd, at) * MOST_HALF_TURNS;
                // 2 |kz| t / lambda < most half turns, without roots and quotients; an overflow counts as too many.
                let sound =
                    size.ge(F64s::splat(simd, LEAST_KZ_SQUARED)) & (size * (4.0 * thickest * thickest)).lt(most * most);
                if !sound.all_true() {
                    for lane in 0..F64s::<S>::LEN {
                        self.odd[at + lane] |= !sound.test(lane);
                    }
                }
            }
        }
    }

    /// One lossless film; rows where its closed form would lose digits join the odd ones.
    #[inline(always)]
    pub(super) fn film<S: Simd>(
        &mut self,
        simd: S,
        [first, film, last]: [usize; 3],
        from: usize,
        until: usize,
        transmittance: bool,
        out: &mut FilmRows,
    ) {
        let share = 1.0 / (until - from) as f64;
        for at in (0..LANES).step_by(F64s::<S>::LEN) {
            let n = [self.n[first][0].load(simd, at), self.n[film][0].load(simd, at), self.n[last][0].load(simd, at)];
            let kz_1 = n[0] * self.cos_theta.load(simd, at);
            let squares =
                [kz_1 * kz_1, self.kz_squared[film][0].load(simd, at), self.kz_squared[last][0].load(simd, at)];
            let kz = [kz_1, squares[1].sqrt(), squares[2].sqrt()];
            out.rate.store::<S>(at, kz[1] * 2.0 / self.wavelength_nm.load(simd, at));
            for polarization in from..until {
                let (squares, admittances) = if polarization == 0 {
                    (squares, kz)
                } else {
                    let y = [kz[0] / (n[0] * n[0]), kz[1] / (n[1] * n[1]), kz[2] / (n[2] * n[2])];
                    ([y[0] * y[0], y[1] * y[1], y[2] * y[2]], y)
                };
                let Fringes { a, b, d } = Fringes::new(squares, admittances, share, transmittance);
                let part = &mut out.parts[polarization - from];
                part.a.store::<S>(at, a);
                part.b.store::<S>(at, b);
                part.d.store::<S>(at, d);
                let sound = (d + 1.0).gt(F64s::splat(simd, LEAST_LEFT));
                if !sound.all_true() {
                    for lane in 0..F64s::<S>::LEN {
                        self.odd[at + lane] |= !sound.test(lane);
                    }
                }
            }
        }
    }

    /// Any stack.
    #[inline(always)]
    pub(super) fn stack<S: Simd>(&self, simd: S, media: &Media<'_>, out: &mut StackRows) {
        let last = media.of[media.of.len() - 1];
        out.absorbs = Lane::ZERO;
        for at in (0..LANES).step_by(F64s::<S>::LEN) {
            let one = F64s::splat(simd, 1.0);
            let per_wavelength = one / self.wavelength_nm.load(simd, at);
            let (half_turns, nepers) = (per_wavelength * 2.0, per_wavelength * TAU);
            let n_first = self.n[self.first][0].load(simd, at);
            let cos = self.cos_theta.load(simd, at);
            out.first[0].store::<S>(at, n_first * cos);
            out.first[1].store::<S>(at, cos / n_first);
            for (medium, (layer, &is_real)) in out.media.iter_mut().zip(&media.real).enumerate() {
                if !media.of_layer[medium] {
                    continue;
                }
                let n = self.n[medium][0].load(simd, at);
                let square = self.kz_squared[medium][0].load(simd, at);
                if is_real {
                    let kz = square.sqrt();
                    let n_squared = n * n;
                    // One division for 1/kz and 1/n^2.
                    let inverse = one / (kz * n_squared);
                    layer.rate.store::<S>(at, kz * half_turns);
                    layer.over[0][0].store::<S>(at, n_squared * inverse);
                    layer.under[0][0].store::<S>(at, kz);
                    layer.over[1][0].store::<S>(at, n_squared * n_squared * inverse);
                    layer.under[1][0].store::<S>(at, square * inverse);
                    continue;
                }
                let k = self.n[medium][1].load(simd, at);
                let kz = square_root([square, self.kz_squared[medium][1].load(simd, at)]);
                let n_squared = [n.mul_sub(n, k * k), n * k * 2.0];
                let (over_kz, over_n_squared) = (inverse(kz), inverse(n_squared));
                layer.rate.store::<S>(at, kz[0] * half_turns);
                layer.loss.store::<S>(at, kz[1] * nepers);
                store::<S>(&mut layer.over[0], at, over_kz);
                store::<S>(&mut layer.under[0], at, kz);
                store::<S>(&mut layer.over[1], at, mul(n_squared, over_kz));
                store::<S>(&mut layer.under[1], at, mul(kz, over_n_squared));
                let absorbs = k.gt(F64s::splat(simd, 0.0)) & n.gt(F64s::splat(simd, 0.0));
                out.absorbs.store::<S>(at, Number::select(absorbs, one, out.absorbs.load(simd, at)));
            }
            let (n, k) = (self.n[last][0].load(simd, at), self.n[last][1].load(simd, at));
            let square = [self.kz_squared[last][0].load(simd, at), self.kz_squared[last][1].load(simd, at)];
            let kz = square_root(square);
            let n_squared = [n.mul_sub(n, k * k), n * k * 2.0];
            store::<S>(&mut out.last[0], at, kz);
            store::<S>(&mut out.last[1], at, mul(kz, inverse(n_squared)));
        }
    }
}

#[inline(always)]
fn store<S: Simd>(pair: &mut Pair, at: usize, [re, im]: [F64s<S>; 2]) {
    pair[0].store::<S>(at, re);
    pair[1].store::<S>(at, im);
}
