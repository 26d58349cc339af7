//! The single film in closed form, and the two-beam form of 1991.

pub mod kernel;

use iridesce_numerics::{Argument, THICKNESS_NM, WAVELENGTH_NM};
use std::f64::consts::TAU;

use crate::fresnel::{Amplitudes, Polarization, between, check_finite_index, check_first, check_last};
use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, OpticsError};

/// What one film between two media does with one polarisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmResponse {
    /// Electric-field amplitudes: `r` with its phase at the first interface, `t` at the second.
    pub amplitudes: Amplitudes,
    /// Reflectance `|r|^2`.
    pub reflectance: f64,
    /// Transmittance: power flux along the normal in the last medium over that in the first.
    pub transmittance: f64,
}

/// A single film by Airy's sum, exact for any indices and angle.
///
/// `r = (r12 + r23 e^{i delta})/(1 + r12 r23 e^{i delta})`, `t = t12 t23 e^{i delta/2}/(1 + r12 r23 e^{i delta})`,
/// `delta = 4 pi n2 d cos(theta2)/lambda`, per polarisation. The film may absorb, not amplify (its wave is taken with
/// `Im kz >= 0`), and must not sit exactly at its critical angle; [`crate::stack`] has neither limit.
/// Source: Born & Wolf, Principles of Optics, 7th ed., sec. 7.6.
///
/// ```
/// use iridesce_optics::{Complex64, film, fresnel::Polarization};
/// let n = [1.0, 1.333, 1.0].map(|n| Complex64::new(n, 0.0));
/// let cos = 45.0_f64.to_radians().cos();
/// let film = film::airy(n, 300.0, 550.0, cos, Polarization::P).unwrap();
/// assert!((film.reflectance - 0.0050102129).abs() < 1e-10);
/// ```
pub fn airy(
    n: [Complex64; 3],
    thickness_nm: f64,
    wavelength_nm: f64,
    cos_theta: f64,
    polarization: Polarization,
) -> Result<FilmResponse, OpticsError> {
    check_first(n[0])?;
    check_finite_index(n[1], "the film")?;
    check_last(n[2])?;
    if n[1].im < 0.0 {
        return Err(OpticsError::Argument(format!("the closed form needs a film with k >= 0, got {}", n[1])));
    }
    check_lengths(thickness_nm, wavelength_nm)?;
    let incidence = Incidence::from_cos(cos_theta)?;
    let q1 = Complex64::new(n[0].re * cos_theta, 0.0);
    let [q2, q3] = [n[1], n[2]].map(|n_j| sqrt_upper(incidence.kz_squared(n[0].re, n_j)));
    if q2.norm() == 0.0 {
        return Err(OpticsError::Argument("the film is at its critical angle; use the multilayer solution".into()));
    }
    let front = between((n[0], q1), (n[1], q2), polarization)?;
    let back = between((n[1], q2), (n[2], q3), polarization)?;
    let half_turn = (Complex64::i() * q2 * (TAU * thickness_nm / wavelength_nm)).exp();
    let echo = back.r * half_turn * half_turn;
    let bounces = 1.0 + front.r * echo;
    let r = (front.r + echo) / bounces;
    let t = front.t * back.t * half_turn / bounces;
    // Power along the normal: Re(n cos) |E|^2 for s, Re(n conj(cos)) |E|^2 for p.
    let flux_ratio = match polarization {
        Polarization::P => (q3 / n[2] * n[2].conj()).re / q1.re,
        _ => q3.re / q1.re,
    };
    Ok(FilmResponse {
        amplitudes: Amplitudes { r, t },
        reflectance: r.norm_sqr(),
        transmittance: flux_ratio * t.norm_sqr(),
    })
}

/// Reflectance of a lossless film with the same lossless medium on both sides: a soap film, an air gap.
///
/// `R = F s/(1 + F s)`, `F = 4 r0/(1 - r0)^2`, `s = sin^2(delta/2)`, `r0` the reflectance of one face. Beyond the critical
/// angle `s` becomes `sinh^2`, and the same form gives frustrated total reflection.
/// Source: Born & Wolf, Principles of Optics, 7th ed., sec. 7.6.1.
pub fn symmetric_reflectance(
    n_outside: f64,
    n_film: f64,
    thickness_nm: f64,
    wavelength_nm: f64,
    cos_theta: f64,
    polarization: Polarization,
) -> Result<f64, OpticsError> {
    check_first(Complex64::new(n_outside, 0.0))?;
    check_first(Complex64::new(n_film, 0.0))?;
    check_lengths(thickness_nm, wavelength_nm)?;
    let incidence = Incidence::from_cos(cos_theta)?;
    let of = |polarization| {
        let kz_squared = incidence.kz_squared(n_outside, Complex64::new(n_film, 0.0)).re;
        let k0_d = TAU * thickness_nm / wavelength_nm;
        let delta_half = kz_squared.abs().sqrt() * k0_d;
        let sinc = if delta_half == 0.0 {
            1.0
        } else if kz_squared > 0.0 {
            delta_half.sin() / delta_half
        } else {
            delta_half.sinh() / delta_half
        };
        // F s = ((q1^2 - q2^2)/(2 q1 q2))^2 sin^2, with q = kz (s) or kz/n^2 (p); written with sin/kz it has no pole at
        // the critical angle. The numerator is the index step, not a difference of squares that may cancel.
        let q1 = n_outside * cos_theta;
        let w = if polarization == Polarization::P { (n_film / n_outside) * (n_film / n_outside) } else { 1.0 };
        let contrast = if polarization == Polarization::P {
            w * q1 * q1 - kz_squared / w
        } else {
            (n_outside - n_film) * (n_outside + n_film)
        };
        let root = contrast / (2.0 * q1) * (k0_d * sinc);
        let fringes = root * root;
        if fringes.is_infinite() { 1.0 } else { fringes / (1.0 + fringes) }
    };
    Ok(polarization.parts().iter().map(|&part| of(part)).sum::<f64>() / polarization.parts().len() as f64)
}

/// Signed amplitudes `r12 = (n1 - n2)/(n1 + n2)` and `r23` of the two-beam form: those of normal incidence, at every angle.
pub fn two_beam_amplitudes(n: [f64; 3]) -> Result<(f64, f64), OpticsError> {
    for n_j in n {
        check_first(Complex64::new(n_j, 0.0))
            .map_err(|_| OpticsError::Argument(format!("the two-beam form takes real indices > 0, got {n_j}")))?;
    }
    Ok(((n[0] - n[1]) / (n[0] + n[1]), (n[1] - n[2]) / (n[1] + n[2])))
}

/// Reflectance in the two-beam form of 1991: `R = 4 r12 r23 (eps + cos^2(delta/2))` for weak contrast, with
/// `delta = 4 pi n2 t cos(theta2)/lambda`; no polarisation, and the amplitudes of normal incidence at every angle.
///
/// Computed as `r12^2 + r23^2 + 2 r12 r23 cos(delta)`, the same number, which also holds where `r12 r23 = 0`.
/// Source: M. L. Dias, IEEE Computer Graphics and Applications 11(2), 1991, with the factor `4 r12 r23` of the correction
/// in 14(3), 1994.
///
/// ```
/// let film = iridesce_optics::film::two_beam_reflectance([1.0, 1.333, 1.0], 103.15, 550.0, 1.0).unwrap();
/// assert!((film - 4.0 * (0.333_f64 / 2.333).powi(2)).abs() < 1e-8);
/// ```
pub fn two_beam_reflectance(
    n: [f64; 3],
    thickness_nm: f64,
    wavelength_nm: f64,
    cos_theta: f64,
) -> Result<f64, OpticsError> {
    let (r12, r23) = two_beam_amplitudes(n)?;
    check_lengths(thickness_nm, wavelength_nm)?;
    let kz_squared = Incidence::from_cos(cos_theta)?.kz_squared(n[0], Complex64::new(n[1], 0.0)).re;
    if kz_squared < 0.0 {
        return Err(OpticsError::Argument(format!(
            "the two-beam form has no meaning beyond the critical angle of the film (indices {} and {}, cos_theta \
             {cos_theta})",
            n[0], n[1]
        )));
    }
    let delta = 2.0 * TAU * kz_squared.sqrt() * thickness_nm / wavelength_nm;
    Ok(r12 * r12 + r23 * r23 + 2.0 * r12 * r23 * delta.cos())
}

/// Colour purity of the two-beam form, `eps = (r12 - r23)^2/(4 r12 r23)`: purest at 0 or -1, paler as |eps| grows.
///
/// An error where an interface does not reflect (`r12 r23 = 0`): there are no two beams then.
pub fn two_beam_purity(n: [f64; 3]) -> Result<f64, OpticsError> {
    let (r12, r23) = two_beam_amplitudes(n)?;
    if r12 * r23 == 0.0 {
        return Err(OpticsError::Argument(format!(
            "the purity eps of indices {n:?} has no value where an interface does not reflect"
        )));
    }
    Ok((r12 - r23) * (r12 - r23) / (4.0 * r12 * r23))
}

fn check_lengths(thickness_nm: f64, wavelength_nm: f64) -> Result<(), OpticsError> {
    THICKNESS_NM.check(thickness_nm)?;
    WAVELENGTH_NM.check(wavelength_nm)?;
    if thickness_nm / wavelength_nm >= 1e30 {
        let allowed = format!("> {:?}, a 1e30th of the thickness", thickness_nm / 1e30);
        return Err(Argument::new("wavelength_nm", allowed, wavelength_nm).into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incidence::cos_of_degrees;

    fn real(n: [f64; 3]) -> [Complex64; 3] {
        n.map(|n| Complex64::new(n, 0.0))
    }

    /// Exact Airy values of n1 = n3 = 1, n2 = 1.333, ten digits: d, lambda, angle, Rs, Rp.
    const SOAP: [[f64; 5]; 8] = [
        [5.0, 550.0, 0.0, 0.0004911109, 0.0004911109],
        [100.0, 550.0, 0.0, 0.0781050139, 0.0781050139],
        [300.0, 550.0, 0.0, 0.0767841164, 0.0767841164],
        [300.0, 550.0, 45.0, 0.0953222150, 0.0050102129],
        [300.0, 550.0, 60.0, 0.0585675138, 0.0018389055],
        [500.0, 450.0, 30.0, 0.0632852148, 0.0244683810],
        [1000.0, 650.0, 75.0, 0.4176540705, 0.1308153089],
        [250.0, 589.3, 53.12, 0.0310295066, 0.0000000002],
    ];

    #[test]
    fn soap_table() {
        for [d, wavelength, angle, r_s, r_p] in SOAP {
            let cos = cos_of_degrees(angle);
            for (polarization, expected) in [(Polarization::S, r_s), (Polarization::P, r_p)] {
                let film = airy(real([1.0, 1.333, 1.0]), d, wavelength, cos, polarization).unwrap();
                assert!((film.reflectance - expected).abs() < 0.6e-10, "{d} {angle} {polarization:?}");
                assert!((film.reflectance + film.transmittance - 1.0).abs() < 1e-14);
                let symmetric = symmetric_reflectance(1.0, 1.333, d, wavelength, cos, polarization).unwrap();
                assert!((film.reflectance - symmetric).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn absorbing_and_unequal_table() {
        let c = Complex64::new;
        let cases = [
            ([c(1.0, 0.0), c(1.46, 0.0), c(4.08, 0.028)], 100.0, 0.0, 0.1022081453, 0.1022081453),
            ([c(1.0, 0.0), c(1.46, 0.0), c(4.08, 0.028)], 300.0, 45.0, 0.1475898947, 0.1402395460),
            ([c(1.0, 0.0), c(2.45, 0.0), c(2.54, 3.43)], 40.0, 0.0, 0.0375371607, 0.0375371607),
            ([c(1.0, 0.0), c(2.45, 0.0), c(2.54, 3.43)], 120.0, 60.0, 0.7650555428, 0.3594527388),
            ([c(1.0, 0.0), c(2.34, 0.10), c(2.95, 2.93)], 50.0, 0.0, 0.0255715164, 0.0255715164),
            ([c(1.5, 0.0), c(1.0, 0.0), c(1.5, 0.0)], 137.5, 0.0, 0.1479289941, 0.1479289941),
            ([c(1.5, 0.0), c(1.0, 0.0), c(1.5, 0.0)], 200.0, 45.0, 0.6916255095, 0.4669787489),
            ([c(1.0, 0.0), c(1.38, 0.0), c(1.52, 0.0)], 99.6377, 0.0, 0.0126007902, 0.0126007902),
        ];
        for (n, d, angle, r_s, r_p) in cases {
            for (polarization, expected) in [(Polarization::S, r_s), (Polarization::P, r_p)] {
                let film = airy(n, d, 550.0, cos_of_degrees(angle), polarization).unwrap();
                assert!((film.reflectance - expected).abs() < 0.6e-10, "{n:?} {angle} {polarization:?}");
            }
        }
    }

    #[test]
    fn air_gap_beyond_the_critical_angle_in_closed_form() {
        for d in [0.0, 0.5, 50.0, 250.0, 900.0, 1e5, 1e9] {
            for polarization in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
                let symmetric = symmetric_reflectance(1.5, 1.0, d, 589.3, cos_of_degrees(45.0), polarization).unwrap();
                let parts = polarization.parts();
                let exact = parts.iter().map(|&part| {
                    airy(real([1.5, 1.0, 1.5]), d, 589.3, cos_of_degrees(45.0), part).unwrap().reflectance
                });
                assert!((symmetric - exact.sum::<f64>() / parts.len() as f64).abs() < 1e-14, "{d} {polarization:?}");
            }
        }
        // At the critical angle of the film (30 degrees for 2.5 to 1.25) the closed form keeps its finite limit.
        let thickness = 100.0;
        let limit = symmetric_reflectance(2.5, 1.25, thickness, 500.0, cos_of_degrees(30.0), Polarization::S).unwrap();
        let root: f64 = (2.5 * 2.5 - 1.25 * 1.25) / (2.0 * 2.5 * cos_of_degrees(30.0)) * TAU * thickness / 500.0;
        assert!((limit - root * root / (1.0 + root * root)).abs() < 1e-14);
    }

    #[test]
    fn quarter_waves() {
        // Least reflectance of one coat: ((n1 n3 - n2^2)/(n1 n3 + n2^2))^2, nothing for n2^2 = n1 n3.
        let coat = airy(real([1.0, 1.5, 2.25]), 100.0, 600.0, 1.0, Polarization::S).unwrap();
        assert!(coat.reflectance < 1e-30 && (coat.transmittance - 1.0).abs() < 1e-15);
        let coat = airy(real([1.0, 1.38, 1.52]), 550.0 / (4.0 * 1.38), 550.0, 1.0, Polarization::P).unwrap();
        let expected = ((1.52 - 1.38 * 1.38) / (1.52 + 1.38 * 1.38_f64)).powi(2);
        assert!((coat.reflectance - expected).abs() < 1e-15);
        // The brightest soap film: 4 r0/(1 + r0)^2.
        let r0 = (0.333_f64 / 2.333).powi(2);
        let film = airy(real([1.0, 1.333, 1.0]), 550.0 / (4.0 * 1.333), 550.0, 1.0, Polarization::S).unwrap();
        assert!((film.reflectance - 4.0 * r0 / (1.0 + r0).powi(2)).abs() < 1e-15);
    }

    #[test]
    fn opaque_film_is_its_own_surface() {
        let metal = Complex64::new(2.54, 3.43);
        let film = airy([Complex64::new(1.0, 0.0), metal, Complex64::new(1.5, 0.0)], 1e6, 550.0, 0.5, Polarization::P);
        let surface = crate::fresnel::interface(1.0, metal, 0.5, Polarization::P).unwrap();
        let film = film.unwrap();
        assert!((film.reflectance - surface.r.norm_sqr()).abs() < 1e-15);
        assert_eq!(film.transmittance, 0.0);
    }

    #[test]
    fn two_beam_form_and_purity() {
        let n = [1.0, 1.38, 1.52];
        let (r12, r23) = two_beam_amplitudes(n).unwrap();
        let eps = two_beam_purity(n).unwrap();
        for (d, cos) in [(0.0, 1.0), (120.0, 1.0), (437.0, 0.6), (1000.0, 0.1)] {
            let cos_film = (1.0 - (1.0 - cos * cos) / (1.38 * 1.38_f64)).sqrt();
            let delta = 4.0 * std::f64::consts::PI * 1.38 * d * cos_film / 550.0;
            let expected = 4.0 * r12 * r23 * (eps + (delta / 2.0).cos().powi(2));
            let got = two_beam_reflectance(n, d, 550.0, cos).unwrap();
            assert!((got - expected).abs() < 1e-15, "{d} {cos}");
        }
        // A soap film is as pure as can be: r23 = -r12.
        assert_eq!(two_beam_purity([1.0, 1.33, 1.0]).unwrap(), -1.0);
        assert!(two_beam_purity([1.0, 1.5, 1.5]).is_err());
        assert!(two_beam_reflectance([1.5, 1.0, 1.5], 100.0, 550.0, 0.3).is_err());
        assert!(two_beam_reflectance([1.0, -1.3, 1.0], 100.0, 550.0, 1.0).is_err());
    }

    #[test]
    fn refuses_bad_numbers() {
        let n = real([1.0, 1.33, 1.0]);
        for (d, wavelength, cos) in [
            (-1.0, 550.0, 1.0),
            (f64::NAN, 550.0, 1.0),
            (f64::INFINITY, 550.0, 1.0),
            (100.0, 0.0, 1.0),
            (100.0, f64::NAN, 1.0),
            (100.0, 550.0, 0.0),
            (100.0, 550.0, 1.5),
        ] {
            assert!(airy(n, d, wavelength, cos, Polarization::S).is_err());
            assert!(symmetric_reflectance(1.0, 1.33, d, wavelength, cos, Polarization::S).is_err());
            assert!(two_beam_reflectance([1.0, 1.33, 1.0], d, wavelength, cos).is_err());
        }
        assert!(airy(n, 100.0, 550.0, 1.0, Polarization::Unpolarized).is_err());
        let gain = [n[0], Complex64::new(1.5, -0.01), n[2]];
        assert!(airy(gain, 100.0, 550.0, 1.0, Polarization::S).is_err());
    }
}
