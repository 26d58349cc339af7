//! The two-beam form of 1991 over a whole spectrum.

use std::f64::consts::PI;

use fearless_simd::{Level, dispatch};

use crate::Complex64;
use crate::incidence::{Incidence, sqrt_upper};

/// A film at one angle, at every wavelength of a sum: `R = mean + swing cos(2 pi turns_per_nm t)` with
/// `mean = r12^2 + r23^2` and `swing = 2 r12 r23`, the amplitudes of normal incidence at every angle (Dias 1991).
#[derive(Debug, Default, Clone)]
pub(super) struct TwoBeamSpectrum {
    turns_per_nm: Vec<f64>,
    mean: Vec<f64>,
    swing: Vec<f64>,
}

impl TwoBeamSpectrum {
    /// Real indices; the wavelength of the first total reflection inside is the error.
    pub(super) fn new(
        wavelength_nm: &[f64],
        indices: &[[Complex64; 3]],
        incidence: Incidence,
    ) -> Result<TwoBeamSpectrum, f64> {
        let mut film = TwoBeamSpectrum::default();
        for (&nm, [n1, n2, n3]) in wavelength_nm.iter().zip(indices) {
            let q2 = sqrt_upper(incidence.kz_squared(n1.re, *n2));
            if q2.im > 0.0 {
                return Err(nm);
            }
            film.turns_per_nm.push(2.0 * q2.re / nm);
            let (r12, r23) = ((n1.re - n2.re) / (n1.re + n2.re), (n2.re - n3.re) / (n2.re + n3.re));
            film.mean.push(r12 * r12 + r23 * r23);
            film.swing.push(2.0 * r12 * r23);
        }
        Ok(film)
    }

    /// The spectrum at one thickness, into `out` (as long as the wavelengths).
    pub(super) fn evaluate(&self, thickness_nm: f64, out: &mut [f64]) {
        // The loop is plain; here it is compiled for the widest vectors this machine has. Nothing in it is reordered
        // or fused, so every machine gives the same bits.
        dispatch!(Level::new(), _simd => self.fill(thickness_nm, out));
    }

    #[inline(always)]
    fn fill(&self, thickness_nm: f64, out: &mut [f64]) {
        let len = out.len();
        let (turns, mean, swing) = (&self.turns_per_nm[..len], &self.mean[..len], &self.swing[..len]);
        for i in 0..len {
            let (cos, _) = cos_sin_turns(turns[i] * thickness_nm);
            out[i] = mean[i] + swing[i] * cos;
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
}
