//! The march: tangential fields carried from the exit medium up to the incident one.
//!
//! Every layer by [`Field::up`] of `layer`, here for one evaluation at a time and whatever it may be: the matrix of a layer
//! is even in `kz`, so that no branch is chosen inside it and `kz = 0` (a layer at its critical angle) is no special case,
//! and fields that grow are scaled down by powers of two.

use super::layer::Field;
use crate::Complex64;
use crate::incidence::sqrt_upper;

/// `cos(delta)` and `sin(delta)/kz` of one layer, both times `exp(-decay)` with `decay = |Im delta|`.
///
/// The factor is carried as a logarithm: without it an opaque layer overflows at `Im delta = 710`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wave {
    pub(super) cos: Complex64,
    pub(super) sin_over_kz: Complex64,
    kz_squared: Complex64,
    pub(super) decay: f64,
}

impl Wave {
    /// `k0_d` is `2 pi thickness / wavelength`.
    #[inline]
    pub(super) fn new(kz_squared: Complex64, k0_d: f64) -> Wave {
        let kz = sqrt_upper(kz_squared);
        let (re, im) = (kz.re * k0_d, kz.im * k0_d);
        let (cos, sin_over_kz, decay) = if re.abs() + im < 1e-4 {
            // 0/0 at kz = 0 otherwise; the series is good to delta^6/720 < 2e-27.
            let square = kz_squared * (k0_d * k0_d);
            let cos = 1.0 - square * (0.5 - square * (1.0 / 24.0));
            let sin_over_kz = k0_d * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)));
            (cos, sin_over_kz, 0.0)
        } else if im == 0.0 {
            let (sin, cos) = re.sin_cos();
            (Complex64::new(cos, 0.0), Complex64::new(sin / kz.re, 0.0), 0.0)
        } else {
            // cosh and sinh times exp(-im); expm1 keeps the digits of sinh for thin layers.
            let half_lost = -0.5 * (-2.0 * im).exp_m1();
            let (sinh, cosh) = (half_lost, 1.0 - half_lost);
            if re == 0.0 {
                (Complex64::new(cosh, 0.0), Complex64::new(sinh / kz.im, 0.0), im)
            } else {
                let (sin, cos) = re.sin_cos();
                let scaled_sin = Complex64::new(sin * cosh, cos * sinh);
                (Complex64::new(cos * cosh, -sin * sinh), scaled_sin / kz, im)
            }
        };
        Wave { cos, sin_over_kz, kz_squared, decay }
    }
}

/// A complex number as the kernels have it.
#[inline(always)]
pub(super) fn parts(z: Complex64) -> [f64; 2] {
    [z.re, z.im]
}

/// From the bottom of a layer to its top, `weight` 1 (s) or n^2 (p); tells by which logarithm the scale has grown.
#[inline]
pub(super) fn up(field: &mut Field<f64>, wave: &Wave, weight: Complex64) -> f64 {
    if wave.kz_squared.im == 0.0 && weight.im == 0.0 {
        let (cos, sin) = (wave.cos.re, wave.sin_over_kz.re);
        field.up_real(cos, weight.re * sin, wave.kz_squared.re / weight.re * sin);
    } else {
        let under = wave.kz_squared / weight * wave.sin_over_kz;
        field.up(parts(wave.cos), parts(weight * wave.sin_over_kz), parts(under));
    }
    wave.decay + rescaled(field)
}

/// Inside the stop band of a long mirror the fields grow without any absorption; a power of two keeps every digit. The
/// logarithm of what was taken out.
#[inline]
pub(super) fn rescaled(field: &mut Field<f64>) -> f64 {
    let size = field.e[0].abs() + field.e[1].abs() + field.h[0].abs() + field.h[1].abs();
    if (1e-60..1e60).contains(&size) { 0.0 } else { rescale(field, size) }
}

#[cold]
fn rescale(field: &mut Field<f64>, size: f64) -> f64 {
    if !(size > 0.0 && size.is_finite()) {
        return 0.0;
    }
    let exponent = size.log2().floor();
    let factor = (-exponent).exp2();
    field.e = field.e.map(|part| part * factor);
    field.h = field.h.map(|part| part * factor);
    exponent * std::f64::consts::LN_2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Layers as `(kz^2, k0 d)` and `cos(delta)`, `sin(delta)/kz` to 17 digits (mpmath), the factor taken out.
    #[test]
    fn waves_keep_their_relative_accuracy() {
        let c = Complex64::new;
        let cases = [
            // kz = 0, and both sides of the switch to the series
            (c(0.0, 0.0), 3.0, c(1.0, 0.0), c(3.0, 0.0)),
            (c(1.21, 0.0), 9e-05, c(0.9999999950995, 0.0), c(8.999999985298501e-05, 0.0)),
            (c(1.21, 0.0), 9.2e-05, c(0.99999999487928, 0.0), c(9.199999984296459e-05, 0.0)),
            (c(-1.21, 0.0), 9e-05, c(1.0000000049005, 0.0), c(9.0000000147015e-05, 0.0)),
            (c(-1.21, 0.0), 0.00015, c(1.0000000136125, 0.0), c(0.00015000000068062498, 0.0)),
            (c(-1.21, 0.0), 2.0, c(4.567908328898227, 0.0), c(4.051913791396267, 0.0)),
            (
                c(1.5, 0.75),
                1e-05,
                c(0.999999999925, -3.749999999906251e-11),
                c(9.99999999975e-06, -1.2499999999812504e-16),
            ),
            (
                c(1.5, 0.75),
                0.00013,
                c(0.9999999873250001, -6.3374999732240615e-09),
                c(0.00012999999945075, -2.7462499930382553e-13),
            ),
            (
                c(1.5, -0.75),
                2.5,
                c(-1.289578813587616, -0.007593951527031965),
                c(-0.15350806273116385, 0.6098510022773724),
            ),
            (
                c(-2.0, 3e-08),
                1.7,
                c(5.5797516051036675, -9.898078498001691e-08),
                c(3.8815994109810554, -4.202983738271384e-08),
            ),
        ];
        for (kz_squared, k0_d, cos, sin_over_kz) in cases {
            let wave = Wave::new(kz_squared, k0_d);
            let factor = wave.decay.exp();
            let close = |got: Complex64, wanted: Complex64| {
                (got.re * factor - wanted.re).abs() <= 2e-15 * wanted.norm()
                    && (got.im * factor - wanted.im).abs() <= 2e-15 * wanted.norm()
            };
            assert!(close(wave.cos, cos) && close(wave.sin_over_kz, sin_over_kz), "{kz_squared} {k0_d}: {wave:?}");
        }
    }

    #[test]
    fn opaque_layers_do_not_overflow() {
        let wave = Wave::new(Complex64::new(-4.0, 1.0), 1e9);
        assert!(wave.cos.is_finite() && wave.sin_over_kz.is_finite() && wave.decay > 1e9);
        assert!((wave.cos.norm() - 0.5).abs() < 1e-15);
    }
}
