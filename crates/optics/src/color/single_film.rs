//! The single coherent film over a whole spectrum: what colour charts spend their time on.
//!
//! Everything that does not depend on the thickness is worked out once per angle; what remains per wavelength is a
//! phase, its cosine (and sine, and decay where something absorbs) and one division. The tests of `stack_color` hold it
//! against the general solver.

use std::f64::consts::PI;

use fearless_simd::{Level, dispatch};

use super::stack_color::Quantity;
use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, Polarization};

/// A film at one angle, at every wavelength of a sum:
///
/// ```text
/// value = (a0 + a1 g^2 + g (a2 cos d - a3 sin d + a4)) / (1 + b0 g^2 + g (b1 cos d - b2 sin d))
/// d = 2 pi turns_per_nm t,  g = exp(-decay_per_nm t)
/// ```
///
/// which is |r12 + r23 g e^(i d)|^2 / |1 + r12 r23 g e^(i d)|^2 and its kin multiplied out.
#[derive(Debug, Default, Clone)]
pub(super) struct FilmSpectrum {
    turns_per_nm: Vec<f64>,
    decay_per_nm: Vec<f64>,
    /// One entry for each polarisation that is averaged.
    ratios: Vec<Ratio>,
    /// Real amplitudes and no decay at every wavelength: g = 1 and no sine.
    lossless: bool,
}

#[derive(Debug, Default, Clone)]
struct Ratio {
    a: [Vec<f64>; 5],
    b: [Vec<f64>; 3],
}

impl Ratio {
    fn push(&mut self, a: [f64; 5], b: [f64; 3]) {
        self.a.iter_mut().zip(a).for_each(|(column, v)| column.push(v));
        self.b.iter_mut().zip(b).for_each(|(column, v)| column.push(v));
    }
}

/// Normal wavenumber in units of the vacuum one, Im >= 0.
pub(super) fn normal_wavenumber(incidence: Incidence, n_first: f64, n: Complex64) -> Complex64 {
    sqrt_upper(incidence.kz_squared(n_first, n))
}

impl FilmSpectrum {
    /// The exact film; `None` where this closed form loses digits (gain in the film, or light that runs nearly along it),
    /// which the general solver does not.
    pub(super) fn exact(
        wavelength_nm: &[f64],
        indices: &[[Complex64; 3]],
        incidence: Incidence,
        polarization: Polarization,
        quantity: Quantity,
    ) -> Option<FilmSpectrum> {
        let polarizations = polarization.parts();
        let mut film = FilmSpectrum { lossless: true, ..FilmSpectrum::default() };
        film.ratios = vec![Ratio::default(); polarizations.len()];
        for (&nm, [n1, n2, n3]) in wavelength_nm.iter().zip(indices) {
            let q1 = n1.re * incidence.cos_theta();
            let [q2, q3] = [*n2, *n3].map(|n| normal_wavenumber(incidence, n1.re, n));
            if n2.im < 0.0 || q2.norm() < 1e-3 * q1 {
                return None;
            }
            film.turns_per_nm.push(2.0 * q2.re / nm);
            film.decay_per_nm.push(4.0 * PI * q2.im / nm);
            for (ratio, polarization) in film.ratios.iter_mut().zip(polarizations) {
                // Admittances: amplitudes of E for s, of H for p; powers are the same.
                let (y1, y2, y3) = match polarization {
                    Polarization::P => (Complex64::from(q1) / (n1 * n1), q2 / (n2 * n2), q3 / (n3 * n3)),
                    _ => (Complex64::from(q1), q2, q3),
                };
                let (r12, r23) = ((y1 - y2) / (y1 + y2), (y2 - y3) / (y2 + y3));
                let (product, cross) = (r12 * r23, r12.conj() * r23);
                film.lossless &= q2.im == 0.0 && r12.im == 0.0 && r23.im == 0.0;
                let b = [product.norm_sqr(), 2.0 * product.re, 2.0 * product.im];
                let reflected = [r12.norm_sqr(), r23.norm_sqr(), 2.0 * cross.re, 2.0 * cross.im, 0.0];
                let passed = y3.re / y1.re * (4.0 * y1 * y2 / ((y1 + y2) * (y2 + y3))).norm_sqr();
                let a = match quantity {
                    Quantity::Reflectance => reflected,
                    Quantity::Transmittance => [0.0, 0.0, 0.0, 0.0, passed],
                    Quantity::Absorptance => {
                        [1.0 - reflected[0], b[0] - reflected[1], b[1] - reflected[2], b[2] - reflected[3], -passed]
                    }
                };
                ratio.push(a, b);
            }
        }
        Some(film)
    }

    /// The reflectance of the two-beam form: r12^2 + r23^2 + 2 r12 r23 cos d with the amplitudes of normal incidence at every
    /// angle (Dias 1991). Real indices; the wavelength of the first total reflection inside is the error.
    pub(super) fn two_beam(
        wavelength_nm: &[f64],
        indices: &[[Complex64; 3]],
        incidence: Incidence,
    ) -> Result<FilmSpectrum, f64> {
        let mut film = FilmSpectrum { lossless: true, ..FilmSpectrum::default() };
        let mut ratio = Ratio::default();
        for (&nm, [n1, n2, n3]) in wavelength_nm.iter().zip(indices) {
            let q2 = normal_wavenumber(incidence, n1.re, *n2);
            if q2.im > 0.0 {
                return Err(nm);
            }
            film.turns_per_nm.push(2.0 * q2.re / nm);
            film.decay_per_nm.push(0.0);
            let (r12, r23) = ((n1.re - n2.re) / (n1.re + n2.re), (n2.re - n3.re) / (n2.re + n3.re));
            ratio.push([r12 * r12, r23 * r23, 2.0 * r12 * r23, 0.0, 0.0], [0.0; 3]);
        }
        film.ratios.push(ratio);
        Ok(film)
    }

    /// The spectrum at one thickness, into `out` (as long as the wavelengths).
    pub(super) fn evaluate(&self, thickness_nm: f64, out: &mut [f64]) {
        // The loops below are plain; here they are compiled for the widest vectors this machine has. Nothing in them is
        // reordered or fused, so every machine gives the same bits.
        dispatch!(Level::new(), _simd => self.add_all(thickness_nm, out));
    }

    #[inline(always)]
    fn add_all(&self, thickness_nm: f64, out: &mut [f64]) {
        let share = 1.0 / self.ratios.len() as f64;
        out.fill(0.0);
        for ratio in &self.ratios {
            if self.lossless {
                self.add_lossless(ratio, thickness_nm, share, out);
            } else {
                self.add_general(ratio, thickness_nm, share, out);
            }
        }
    }

    #[inline(always)]
    fn add_lossless(&self, ratio: &Ratio, thickness_nm: f64, share: f64, out: &mut [f64]) {
        let len = out.len();
        let [a0, a1, a2, _, a4] = ratio.a.each_ref().map(|column| &column[..len]);
        let [b0, b1, _] = ratio.b.each_ref().map(|column| &column[..len]);
        let turns = &self.turns_per_nm[..len];
        for i in 0..len {
            let (cos, _) = cos_sin_turns(turns[i] * thickness_nm);
            let above = a0[i] + a1[i] + a4[i] + a2[i] * cos;
            out[i] += share * above / (1.0 + b0[i] + b1[i] * cos);
        }
    }

    #[inline(always)]
    fn add_general(&self, ratio: &Ratio, thickness_nm: f64, share: f64, out: &mut [f64]) {
        // The exponential is a call: worked out a block at a time, so that it does not stand in the way of the vectors.
        const BLOCK: usize = 64;
        let mut decayed = [1.0; BLOCK];
        for start in (0..out.len()).step_by(BLOCK) {
            let end = out.len().min(start + BLOCK);
            let len = end - start;
            for (g, decay) in decayed.iter_mut().zip(&self.decay_per_nm[start..end]) {
                *g = if *decay == 0.0 { 1.0 } else { (-decay * thickness_nm).exp() };
            }
            let out = &mut out[start..end];
            let [a0, a1, a2, a3, a4] = ratio.a.each_ref().map(|column| &column[start..end]);
            let [b0, b1, b2] = ratio.b.each_ref().map(|column| &column[start..end]);
            let (turns, decayed) = (&self.turns_per_nm[start..end], &decayed[..len]);
            for i in 0..len {
                let (cos, sin) = cos_sin_turns(turns[i] * thickness_nm);
                let g = decayed[i];
                let above = a0[i] + a1[i] * g * g + g * (a2[i] * cos - a3[i] * sin + a4[i]);
                let below = 1.0 + b0[i] * g * g + g * (b1[i] * cos - b2[i] * sin);
                out[i] += share * above / below;
            }
        }
    }
}

/// (cos, sin) of 2 pi `turns`, for |turns| < 2^49, to 1e-16 or so beyond the rounding of `turns`.
///
/// Written without calls or branches so that the compiler can do several wavelengths at once: quarter turns are split off
/// exactly, and a Taylor series serves the rest of an eighth of a turn.
#[inline(always)]
fn cos_sin_turns(turns: f64) -> (f64, f64) {
    // Adding and taking away 1.5 * 2^52 rounds to the nearest integer.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let within = turns - ((turns + ROUND) - ROUND);
    let quarters = 4.0 * within;
    let quarter = (quarters + ROUND) - ROUND;
    let x = (quarters - quarter) * (0.5 * PI);
    let y = x * x;
    // Terms to x^15 and x^16: the rest is below (pi/4)^17 / 17! = 5e-17.
    let sin = x + x
        * y
        * (-1.0 / 6.0
            + y * (1.0 / 120.0
                + y * (-1.0 / 5040.0
                    + y * (1.0 / 362_880.0
                        + y * (-1.0 / 39_916_800.0
                            + y * (1.0 / 6_227_020_800.0 + y * (-1.0 / 1_307_674_368_000.0)))))));
    let cos = 1.0
        + y * (-0.5
            + y * (1.0 / 24.0
                + y * (-1.0 / 720.0
                    + y * (1.0 / 40_320.0
                        + y * (-1.0 / 3_628_800.0
                            + y * (1.0 / 479_001_600.0
                                + y * (-1.0 / 87_178_291_200.0 + y * (1.0 / 20_922_789_888_000.0))))))));
    let sign = 1.0 - quarter.abs(); // 1, 0, -1 for 0, +-1, +-2 quarters
    let odd = quarter * (1.0 - sign * sign); // +-1 for +-1 quarter, else 0
    (sign * cos - odd * sin, sign * sin + odd * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_and_sine_of_turns() {
        for i in -4000..=4000 {
            let turns = f64::from(i) / 512.0;
            let (cos, sin) = cos_sin_turns(turns);
            let (s, c) = (2.0 * PI * (turns - turns.round())).sin_cos();
            // The reference rounds 2 pi turns, up to pi, by 4e-16 at most.
            assert!((cos - c).abs() < 6e-16 && (sin - s).abs() < 6e-16, "{turns}: {cos} {c} {sin} {s}");
        }
        assert_eq!(cos_sin_turns(0.25), (0.0, 1.0));
        assert_eq!(cos_sin_turns(1e6 + 0.5), (-1.0, 0.0));
    }

    #[test]
    fn known_reflectances() {
        // reference/physics.md, "Unit-test vectors": n = 1.333 in air, and an absorbing film, ten decimals.
        let real = |n: f64| Complex64::new(n, 0.0);
        for (n, t, nm, deg, rs, rp) in [
            ([real(1.0), real(1.333), real(1.0)], 300.0, 550.0, 45.0, 0.0953222150, 0.0050102129),
            ([real(1.0), real(1.333), real(1.0)], 1000.0, 650.0, 75.0, 0.4176540705, 0.1308153089),
            ([real(1.0), real(1.46), Complex64::new(4.08, 0.028)], 300.0, 550.0, 45.0, 0.1475898947, 0.1402395460),
            (
                [real(1.0), Complex64::new(2.34, 0.10), Complex64::new(2.95, 2.93)],
                50.0,
                550.0,
                0.0,
                0.0255715164,
                0.0255715164,
            ),
            ([real(1.5), real(1.0), real(1.5)], 200.0, 550.0, 45.0, 0.6916255095, 0.4669787489),
        ] {
            for (polarization, wanted) in [(Polarization::S, rs), (Polarization::P, rp)] {
                let incidence = Incidence::from_degrees(deg).unwrap();
                let film = FilmSpectrum::exact(&[nm], &[n], incidence, polarization, Quantity::Reflectance).unwrap();
                let mut out = [0.0];
                film.evaluate(t, &mut out);
                assert!((out[0] - wanted).abs() < 1e-10, "{n:?} {polarization:?}: {} {wanted}", out[0]);
            }
        }
    }
}
