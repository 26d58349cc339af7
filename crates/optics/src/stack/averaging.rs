//! Whether the phase across a layer averages out.

use std::f64::consts::FRAC_PI_2;

use crate::Complex64;

/// Whether a layer that is meant to be incoherent has a phase to average, at optical thickness `k0_d = 2 pi d/lambda`.
///
/// It has none where the wave decays faster than it oscillates. And where the medium absorbs, the admittance of its wave
/// is complex, of argument `theta`, and a passive face can reflect more field than meets it, by up to
/// `tan(pi/4 + theta/2) = exp(asinh(tan theta))`. Between two such faces light would grow from bounce to bounce, and the
/// sum over bounces have no meaning, unless the way there and back takes more than that: `asinh(tan theta) <= Im kz k0 d`.
/// For weak absorption that is a phase of one radian.
pub(crate) fn averages(n: Complex64, kz: Complex64, k0_d: f64) -> bool {
    if kz.im >= kz.re {
        return false;
    }
    // q = kz for s, kz/n^2 for p; gain is left to the lasing threshold.
    let (of_kz, of_n) = (kz.im.atan2(kz.re), n.im.atan2(n.re));
    let theta = of_kz.abs().max((2.0 * of_n - of_kz).abs());
    n.im <= 0.0 || (theta < FRAC_PI_2 && theta.tan().asinh() <= kz.im * k0_d)
}
