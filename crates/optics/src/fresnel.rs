//! Fresnel amplitudes of one interface.
//!
//! Sign convention, here and everywhere: time factor `exp(-i omega t)`, index `n + ik` with `k > 0` absorbing, amplitudes
//! are ratios of electric fields, `r_p = -r_s` at normal incidence.

use iridesce_numerics::Argument;

use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, OpticsError};

/// Polarisation of the incident light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Polarization {
    /// Electric field normal to the plane of incidence (TE).
    S,
    /// Electric field in the plane of incidence (TM).
    P,
    /// The mean of both powers.
    Unpolarized,
}

impl Polarization {
    /// `"s"`, `"p"` or `"unpolarized"`; nothing else.
    pub fn named(name: &str) -> Result<Polarization, OpticsError> {
        match name {
            "s" => Ok(Polarization::S),
            "p" => Ok(Polarization::P),
            "unpolarized" => Ok(Polarization::Unpolarized),
            _ => Err(Argument::one_of("polarization", &["s", "p", "unpolarized"], name).into()),
        }
    }

    /// The polarisations whose mean is meant.
    pub fn parts(self) -> &'static [Polarization] {
        match self {
            Polarization::S => &[Polarization::S],
            Polarization::P => &[Polarization::P],
            Polarization::Unpolarized => &[Polarization::S, Polarization::P],
        }
    }
}

/// Amplitude ratios of reflected and transmitted electric fields to the incident one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitudes {
    /// Reflected over incident.
    pub r: Complex64,
    /// Transmitted over incident.
    pub t: Complex64,
}

/// Amplitudes of the interface between a lossless medium of index `n_first` and one of index `n`.
///
/// `r_s = (q1 - q2)/(q1 + q2)`, `r_p = (n2^2 q1 - n1^2 q2)/(n2^2 q1 + n1^2 q2)`, `q` the wavenumber along the normal;
/// beyond the critical angle `q2` is imaginary and `|r| = 1`. Source: Born & Wolf, Principles of Optics, sec. 1.5.2
/// (with the sign of `r_p` stated above).
///
/// ```
/// use iridesce_optics::{Complex64, fresnel};
/// let glass = fresnel::interface(1.0, Complex64::new(1.5, 0.0), 1.0, fresnel::Polarization::S).unwrap();
/// assert!((glass.r.norm_sqr() - 0.04).abs() < 1e-15);
/// ```
pub fn interface(
    n_first: f64,
    n: Complex64,
    cos_theta: f64,
    polarization: Polarization,
) -> Result<Amplitudes, OpticsError> {
    let incidence = Incidence::from_cos(cos_theta)?;
    check_first(Complex64::new(n_first, 0.0))?;
    check_last(n)?;
    let q1 = Complex64::new(n_first * cos_theta, 0.0);
    let q2 = sqrt_upper(incidence.kz_squared(n_first, n));
    between((Complex64::new(n_first, 0.0), q1), (n, q2), polarization)
}

/// Amplitudes between two media, each given as index and wavenumber along the normal.
pub(crate) fn between(
    (n1, q1): (Complex64, Complex64),
    (n2, q2): (Complex64, Complex64),
    polarization: Polarization,
) -> Result<Amplitudes, OpticsError> {
    match polarization {
        Polarization::S => Ok(Amplitudes { r: (q1 - q2) / (q1 + q2), t: 2.0 * q1 / (q1 + q2) }),
        Polarization::P => {
            // Divided by n1 n2, so that neither square over- nor underflows.
            let (a, b) = (n2 / n1 * q1, n1 / n2 * q2);
            Ok(Amplitudes { r: (a - b) / (a + b), t: 2.0 * q1 / (a + b) })
        }
        Polarization::Unpolarized => Err(OpticsError::Argument(
            "amplitudes exist for polarization \"s\" or \"p\" only, got \"unpolarized\"".into(),
        )),
    }
}

/// Indices are kept to a range whose squares and products stay far from the ends of a double.
pub(crate) const MODULUS_RANGE: (f64, f64) = (1e-12, 1e12);

pub(crate) fn check_finite_index(n: Complex64, which: &str) -> Result<(), OpticsError> {
    let square = n.norm_sqr();
    if n.re >= 0.0 && square >= MODULUS_RANGE.0 * MODULUS_RANGE.0 && square <= MODULUS_RANGE.1 * MODULUS_RANGE.1 {
        return Ok(());
    }
    Err(OpticsError::Argument(format!(
        "the index of {which} must have n >= 0 and a modulus from {:e} to {:e}, got {n}",
        MODULUS_RANGE.0, MODULUS_RANGE.1
    )))
}

/// Light enters from a medium with real `n > 0`: only there is the incident power defined apart from the reflected one.
pub(crate) fn check_first(n: Complex64) -> Result<(), OpticsError> {
    check_finite_index(n, "the first medium")?;
    if n.re > 0.0 && n.im == 0.0 {
        return Ok(());
    }
    Err(OpticsError::Argument(format!("the first medium must have real n > 0 and k = 0, got {n}")))
}

/// Gain is allowed in finite layers only: a half-space with gain has no agreed direction of outgoing waves.
pub(crate) fn check_last(n: Complex64) -> Result<(), OpticsError> {
    check_finite_index(n, "the last medium")?;
    if n.im >= 0.0 {
        return Ok(());
    }
    Err(OpticsError::Argument(format!("the last medium must have k >= 0 (gain only in finite layers), got {n}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(n: f64) -> Complex64 {
        Complex64::new(n, 0.0)
    }

    #[test]
    fn signs_and_closed_values() {
        let s = interface(1.0, real(1.5), 1.0, Polarization::S).unwrap();
        let p = interface(1.0, real(1.5), 1.0, Polarization::P).unwrap();
        assert!((s.r + 0.2).norm() < 1e-16 && (p.r - 0.2).norm() < 1e-16);
        assert!((s.t - 0.8).norm() < 1e-15 && (p.t - 0.8).norm() < 1e-15);
    }

    #[test]
    fn no_p_light_at_brewster() {
        let cos = 1.0 / (1.0_f64 + 1.33 * 1.33).sqrt();
        let p = interface(1.0, real(1.33), cos, Polarization::P).unwrap();
        assert!(p.r.norm() < 1e-15);
    }

    #[test]
    fn total_reflection_has_modulus_one_and_a_decaying_wave() {
        for polarization in [Polarization::S, Polarization::P] {
            let beyond = interface(1.5, real(1.0), 0.5, polarization).unwrap();
            assert!((beyond.r.norm() - 1.0).abs() < 1e-15);
            // Goos-Haenchen phase of exp(-i omega t): r = (q1 - i K)/(q1 + i K) has a negative argument for s.
            if polarization == Polarization::S {
                assert!(beyond.r.arg() < 0.0);
            }
        }
    }

    #[test]
    fn names_and_refusals() {
        assert_eq!(Polarization::named("s").unwrap(), Polarization::S);
        assert!(Polarization::named("TE").unwrap_err().to_string().contains("\"TE\""));
        assert!(interface(1.0, real(1.5), 1.0, Polarization::Unpolarized).is_err());
        assert!(interface(-1.0, real(1.5), 1.0, Polarization::S).is_err());
        assert!(interface(1.0, Complex64::new(1.5, -0.1), 1.0, Polarization::S).is_err());
        assert!(interface(1.0, real(f64::NAN), 1.0, Polarization::S).is_err());
        assert!(interface(1.0, real(0.0), 1.0, Polarization::S).is_err());
        assert!(interface(1.0, real(1.5), 0.0, Polarization::S).is_err());
    }
}
