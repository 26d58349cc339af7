//! How light arrives: the angle in the first medium, and the normal wavenumbers that follow from it.
//!
//! Everything downstream needs only `kz^2 = n^2 - (n_first sin theta)^2` (in units of the vacuum wavenumber).
//! It is formed as `(n - n_first)(n + n_first) + (n_first cos theta)^2`: the textbook `n^2 - (n_first sin theta)^2` loses
//! every digit of the cosine at grazing incidence and of the index step between like media. Where n is less than
//! n_first cos theta it is the other way round (light from glass into a film of 0.25 would leave two digits fewer, and thick
//! films multiply that by their phase), so there the textbook's form is taken.

use iridesce_numerics::{ANGLE_DEG, Bounds};

use crate::{Complex64, OpticsError};

/// The direction of the incident light in the first medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    cos_theta: f64,
    sin_theta: f64,
    /// Kept where the user gave degrees, so that close to a critical angle the cosine can be had to more digits.
    angle_deg: Option<f64>,
}

impl Incidence {
    /// From the cosine of the angle to the normal, `0 < cos_theta <= 1`.
    pub fn from_cos(cos_theta: f64) -> Result<Incidence, OpticsError> {
        if cos_theta > 0.0 && cos_theta <= 1.0 {
            let sin_theta = ((1.0 - cos_theta) * (1.0 + cos_theta)).sqrt();
            Ok(Incidence { cos_theta, sin_theta, angle_deg: None })
        } else {
            Err(Bounds::above("cos_theta", 0.0).at_most(1.0).refuse(cos_theta).into())
        }
    }

    /// From the angle to the normal in degrees, `0 <= angle_deg < 90`.
    pub fn from_degrees(angle_deg: f64) -> Result<Incidence, OpticsError> {
        if ANGLE_DEG.holds(angle_deg) {
            let sin_theta = sin_of_degrees(angle_deg);
            Ok(Incidence { cos_theta: cos_of_degrees(angle_deg), sin_theta, angle_deg: Some(angle_deg) })
        } else {
            Err(ANGLE_DEG.refuse(angle_deg).into())
        }
    }

    /// The cosine of the angle to the normal.
    #[inline]
    pub fn cos_theta(&self) -> f64 {
        self.cos_theta
    }

    /// The sine of the angle to the normal.
    #[inline]
    pub fn sin_theta(&self) -> f64 {
        self.sin_theta
    }

    /// Squared wavenumber along the normal in a medium of index `n`, in units of the vacuum wavenumber.
    #[inline]
    pub fn kz_squared(&self, n_first: f64, n: Complex64) -> Complex64 {
        let first = n_first * self.cos_theta;
        let first = first * first;
        let along = n_first * self.sin_theta;
        let (re, cancelling) = if n.re * n.re < first {
            ((n.re - along) * (n.re + along) - n.im * n.im, along * along)
        } else {
            ((n.re - n_first) * (n.re + n_first) + first - n.im * n.im, first)
        };
        // Near a critical angle the terms cancel, and the rounding of the cosine alone would show in sqrt(kz^2).
        let re = if re.abs() < 1e-3 * cancelling { self.kz_squared_exactly(n_first, n) } else { re };
        Complex64::new(re, 2.0 * n.re * n.im)
    }

    /// The real part of `kz^2` with twice the digits; rare, so kept out of the hot path.
    #[cold]
    fn kz_squared_exactly(&self, n_first: f64, n: Complex64) -> f64 {
        let cos = match self.angle_deg {
            Some(angle_deg) => Double::cos_of_degrees(angle_deg),
            None => Double::from(self.cos_theta),
        };
        let n_first = Double::from(n_first);
        let n_re = Double::from(n.re);
        let first = n_first * cos;
        let absorbed = Double::from(n.im) * Double::from(n.im);
        let sum = (n_re - n_first) * (n_re + n_first) + first * first - absorbed;
        sum.high + sum.low
    }
}

/// Cosine of an angle in degrees, to full relative precision up to 90 degrees (`90 - angle` is exact from 45 on).
pub fn cos_of_degrees(angle_deg: f64) -> f64 {
    if angle_deg < 45.0 { angle_deg.to_radians().cos() } else { (90.0 - angle_deg).to_radians().sin() }
}

/// Sine of an angle in degrees, to full relative precision.
fn sin_of_degrees(angle_deg: f64) -> f64 {
    if angle_deg < 45.0 { angle_deg.to_radians().sin() } else { (90.0 - angle_deg).to_radians().cos() }
}

/// The square root with `Im >= 0`; with `Re > 0` where the argument is real and positive.
///
/// Both parts keep full relative precision. The polar form does not: for a negative real part with a tiny imaginary
/// one, `cos(pi/2 - tiny)` would leave no digit of the real part, which is the power that leaks through total reflection.
#[inline]
pub(crate) fn sqrt_upper(z: Complex64) -> Complex64 {
    let (re, im) = (z.re, z.im);
    if im == 0.0 {
        return if re >= 0.0 { Complex64::new(re.sqrt(), 0.0) } else { Complex64::new(0.0, (-re).sqrt()) };
    }
    let modulus = z.norm();
    if re >= 0.0 {
        let root = (0.5 * (modulus + re)).sqrt();
        // Im < 0 in gain media: the root with Im >= 0 is the other one.
        if im > 0.0 { Complex64::new(root, 0.5 * im / root) } else { Complex64::new(-root, -0.5 * im / root) }
    } else {
        let root = (0.5 * (modulus - re)).sqrt();
        Complex64::new(0.5 * im / root, root)
    }
}

/// An unevaluated sum of two doubles, about 32 digits (T. J. Dekker, Numer. Math. 18, 224 (1971)).
#[derive(Debug, Clone, Copy)]
struct Double {
    high: f64,
    low: f64,
}

impl From<f64> for Double {
    fn from(high: f64) -> Double {
        Double { high, low: 0.0 }
    }
}

impl Double {
    /// pi / 180 to 32 digits.
    const RADIANS_PER_DEGREE: Double = Double { high: 0.017453292519943295, low: 2.9486522708701687e-19 };

    /// Sum of two doubles with its rounding error.
    fn sum(a: f64, b: f64) -> Double {
        let high = a + b;
        let part = high - a;
        Double { high, low: (a - (high - part)) + (b - part) }
    }

    fn over(self, divisor: f64) -> Double {
        let high = self.high / divisor;
        let rest = (-high).mul_add(divisor, self.high) + self.low;
        Double::sum(high, rest / divisor)
    }

    /// Cosine of an exact number of degrees in [0, 90).
    fn cos_of_degrees(angle_deg: f64) -> Double {
        let near_normal = angle_deg < 45.0;
        let x = Double::from(if near_normal { angle_deg } else { 90.0 - angle_deg }) * Double::RADIANS_PER_DEGREE;
        let square = x * x;
        // Taylor series of cos x or sin x, x <= pi/4: 16 terms leave less than 1e-37.
        let mut term = if near_normal { Double::from(1.0) } else { x };
        let mut sum = term;
        let mut order = if near_normal { 1.0 } else { 2.0 };
        for _ in 0..16 {
            term = -(term * square).over(order * (order + 1.0));
            sum = sum + term;
            order += 2.0;
        }
        sum
    }
}

impl std::ops::Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        Double { high: -self.high, low: -self.low }
    }
}

impl std::ops::Add for Double {
    type Output = Double;
    fn add(self, other: Double) -> Double {
        let high = Double::sum(self.high, other.high);
        let low = Double::sum(self.low, other.low);
        let first = Double::sum(high.high, high.low + low.high);
        Double::sum(first.high, first.low + low.low)
    }
}

impl std::ops::Sub for Double {
    type Output = Double;
    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl std::ops::Mul for Double {
    type Output = Double;
    fn mul(self, other: Double) -> Double {
        let high = self.high * other.high;
        let error = self.high.mul_add(other.high, -high);
        Double::sum(high, error + (self.high * other.low + self.low * other.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_keeps_its_digits_near_grazing() {
        // mpmath, 40 digits: cos(89.999999999 deg), cos(60 deg), cos(44.9 deg).
        assert!((cos_of_degrees(89.999_999_999) / 1.745335597058627e-11 - 1.0).abs() < 5e-16);
        assert!((cos_of_degrees(60.0) - 0.5).abs() < 2e-16);
        assert_eq!(cos_of_degrees(0.0), 1.0);
        for step in 0..9000 {
            let angle = f64::from(step) * 0.01;
            let exact = Double::cos_of_degrees(angle);
            assert!((cos_of_degrees(angle) / exact.high - 1.0).abs() < 6e-16, "{angle}");
        }
    }

    #[test]
    fn wavenumbers_keep_their_digits_also_in_films_much_thinner_optically_than_the_first_medium() {
        // mpmath, 40 digits: n^2 - (n_first sin theta)^2 of the doubles.
        for (n_first, n, angle_deg, expected) in [
            (3.05, 0.25, 2.25, 0.048_161_748_526_211_5),
            (1.955, 0.286, 3.5, 0.067_551_602_613_461_91),
            (1.5, 1.0, 20.0, 0.736_799_998_508_850_3),
            (2.5, 0.05, 0.5, 0.002_024_047_363_722_622_6),
            (1.5, 1.49, 60.0, 0.532_6),
        ] {
            let medium = Complex64::new(n, 0.0);
            let by_degrees = Incidence::from_degrees(angle_deg).unwrap().kz_squared(n_first, medium).re;
            // Two or three roundings, of numbers at most twice as large.
            assert!((by_degrees / expected - 1.0).abs() < 6e-16, "{n_first} {n} {angle_deg}: {by_degrees}");
        }
    }

    #[test]
    fn double_cosine_has_thirty_digits() {
        // mpmath: cos(41.1395 deg) = 0.75315...; high + low to 32 digits.
        let cos = Double::cos_of_degrees(41.1395);
        assert_eq!(cos.high, 0.753110015443814);
        assert!((cos.low - 3.924288766797509e-17).abs() < 1e-31, "{:e}", cos.low);
        let cos = Double::cos_of_degrees(67.25);
        assert_eq!(cos.high, 0.3867109616368206);
        assert!((cos.low - 4.8272914740563254e-18).abs() < 1e-31, "{:e}", cos.low);
    }

    #[test]
    fn square_root_keeps_both_parts() {
        for (re, im) in [(-1.0, 1e-20), (-4.0, 6e-8), (2.0, 1e-30), (3.0, -4.0), (-3.0, -4.0), (0.0, 2.0), (0.0, 0.0)] {
            let root = sqrt_upper(Complex64::new(re, im));
            assert!(root.im >= 0.0);
            let square_re = (root.re - root.im) * (root.re + root.im);
            assert!((square_re - re).abs() <= 1e-15 * (re.abs() + im.abs()), "{re} {im}");
            assert!((2.0 * root.re * root.im - im).abs() <= 1e-15 * im.abs(), "{re} {im}");
        }
        assert_eq!(sqrt_upper(Complex64::new(-4.0, -0.0)), Complex64::new(0.0, 2.0));
    }

    #[test]
    fn kz_is_exact_close_to_the_critical_angle() {
        // mpmath, 40 digits, n 1.52 -> 1.0 at doubles within 1e-9 degree of the critical angle.
        let incidence = Incidence::from_degrees(41.13951041389915).unwrap();
        let kz2 = incidence.kz_squared(1.52, Complex64::new(1.0, 0.0));
        assert!((kz2.re / 3.99582333580391e-11 - 1.0).abs() < 1e-13, "{:e}", kz2.re);
    }

    #[test]
    fn kz_keeps_a_small_index_step_at_grazing_incidence() {
        // (n - n0)(n + n0) + (n0 cos)^2 with n - n0 = 2^-30 exactly: every factor is known to the last digit.
        let step = f64::powi(2.0, -30);
        let incidence = Incidence::from_cos(1e-8).unwrap();
        let kz2 = incidence.kz_squared(1.5, Complex64::new(1.5 + step, 0.0));
        let expected = step * (3.0 + step) + 2.25e-16;
        assert!((kz2.re / expected - 1.0).abs() < 1e-15, "{:e} {expected:e}", kz2.re);
    }

    #[test]
    fn refuses_directions_that_are_none() {
        for cos_theta in [0.0, -0.1, 1.0000001, f64::NAN, f64::INFINITY] {
            assert!(Incidence::from_cos(cos_theta).is_err());
        }
        for angle_deg in [-1e-9, 90.0, 180.0, f64::NAN, f64::INFINITY] {
            assert!(Incidence::from_degrees(angle_deg).is_err());
        }
    }
}
