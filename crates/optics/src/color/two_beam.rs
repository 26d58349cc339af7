//! The two-beam form of 1991 over a whole spectrum.

use fearless_simd::dispatch;
use iridesce_numerics::simd;
use iridesce_numerics::turns::cos_sin_turns;

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
        dispatch!(simd::level_or_best(), _simd => self.fill(thickness_nm, out));
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
