//! Single films over a [`Number`]: the sweeps' in double and single precision, the renderer's, and the tests' scalars are
//! instances of these.
//!
//! A lossless film between lossless media, with the admittances y (kz for s, kz/n^2 for p) of the three and
//! `s = sin^2(beta)`, `beta = 2 pi kz2 t / lambda`:
//!
//! ```text
//! R = (p + d s)/(1 + d s),   T = (1 - p)/(1 + d s)
//! p = ((y1 - y3)/(y1 + y3))^2,   d = (y2^2 - y1^2)(y2^2 - y3^2)/(y2^2 (y1 + y3)^2)
//! ```
//!
//! which is Airy's sum over a common denominator: p is the bare interface without the film, and 1 + d s stays between 1
//! and what the film does at a quarter wave.
//!
//! A free film (the same medium on both sides), with c = cos(theta) outside, m its index over the outer medium's,
//! `b^2 = m^2 - sin^2(theta)`, `u = m^2 c` and `beta = 2 pi n_outer t b / lambda`:
//!
//! ```text
//! r / t = -i g sin(beta),   1 / t = cos(beta) - i h sin(beta)
//! g_s = (c^2 - b^2) / (2 c b) = (1 - m^2) / (2 c b),   g_p = (u^2 - b^2) / (2 u b),   h = sqrt(1 + g^2)
//! R = g^2 sin^2 / (1 + g^2 sin^2),   T = 1 - R
//! ```
//!
//! without a single difference of nearly equal numbers: `b^2 = (m^2 - 1) + c^2` and
//! `u^2 - b^2 = (m^2 - 1)((m^2 + 1) c^2 - 1)`; `contrast` is `Re m^2 - 1`.
//!
//! Source of the Airy sums: Born & Wolf, Principles of Optics, 7th ed., sec. 7.6.

use iridesce_numerics::Number;
use iridesce_numerics::complex::{Complex, conjugate_product, inverse, mul, power};
use iridesce_numerics::turns::{sin_cos_pi, sin_squared_pi};

use crate::mueller::{Mueller, Response};

/// One polarisation of a lossless film between lossless media: `(a + b s)/(1 + d s)`.
#[derive(Debug, Clone, Copy)]
pub struct Fringes<V> {
    /// The bare interface.
    pub a: V,
    /// What the film adds.
    pub b: V,
    /// What its echoes divide by.
    pub d: V,
}

impl<V: Number> Fringes<V> {
    /// From the squared admittances and the admittances of the three media, times `share`.
    #[inline(always)]
    pub fn new([y1_2, y2_2, y3_2]: [V; 3], [y1, _, y3]: [V; 3], share: f64, transmittance: bool) -> Fringes<V> {
        let (one, share) = (y1.like(1.0), y1.like(share));
        let sum = y1 + y3;
        let inverse = one / (sum * sum * y2_2);
        let d = (y2_2 - y1_2) * (y2_2 - y3_2) * inverse;
        let bare = y2_2 * inverse;
        let step = y1 - y3;
        let passed = (y1 * y3 * bare).times(4.0);
        let (a, b) = if transmittance { (passed, y1.like(0.0)) } else { (step * step * bare, d) };
        Fringes { a: a * share, b: b * share, d }
    }

    /// The sum of one or two of them at `s = sin^2(beta)`, within 0 and 1.
    #[inline(always)]
    pub fn sum<const PARTS: usize>(parts: &[Fringes<V>; PARTS], s: V) -> V {
        // A quarter wave that takes all reflection away cancels a against b s to rounding, on either side of zero.
        let (zero, one) = (s.like(0.0), s.like(1.0));
        let Fringes { a, b, d } = parts[0];
        let (over, under) = (b.mul_add(s, a), d.mul_add(s, one));
        if PARTS == 1 {
            return (over / under).max(zero).min(one);
        }
        // One division for two ratios: the divider is the busiest unit of this loop.
        let Fringes { a, b, d } = parts[PARTS - 1];
        let (over_2, under_2) = (b.mul_add(s, a), d.mul_add(s, one));
        (over.mul_add(under_2, over_2 * under) / (under * under_2)).max(zero).min(one)
    }
}

/// The phase of a free film less its nearest whole number of half turns: `per_b` is `2 n_outer t / lambda`.
#[inline(always)]
fn within<V: Number>(b: V, per_b: V) -> V {
    let half_turns = b * per_b;
    half_turns - half_turns.round_ties_even()
}

/// R of s and p light of a free lossless film that light enters at every angle (m >= 1).
#[inline(always)]
pub fn free_reflectance<V: Number>(contrast: V, cos: V, per_b: V) -> [V; 2] {
    let (e, c2) = (contrast, cos * cos);
    let b2 = e + c2;
    let q = sin_squared_pi(within(b2.sqrt(), per_b));
    let u = e.plus(1.0) * cos;
    let k = e * e.plus(2.0).mul_sub(c2, e.like(1.0));
    let four_b2 = b2.times(4.0);
    let s = e * e * q;
    let p = k * k * q;
    // One division for two ratios: the divider is the busiest unit of this loop.
    let (under_s, under_p) = (four_b2.mul_add(c2, s), four_b2.mul_add(u * u, p));
    let inverse = e.like(1.0) / (under_s * under_p);
    [s * under_p * inverse, p * under_s * inverse]
}

/// Everything about a free lossless film that light enters at every angle (m >= 1).
#[inline(always)]
pub fn free_lossless<V: Number>(contrast: V, cos: V, per_b: V) -> Response<V> {
    let (e, c, one) = (contrast, cos, contrast.like(1.0));
    let b2 = c.mul_add(c, e);
    let b = b2.sqrt();
    let (sine, cosine) = sin_cos_pi(within(b, per_b));
    let (q, cc) = (sine * sine, cosine * cosine);
    let u = e.plus(1.0) * c;
    let (over_s, over_p) = (one / (c * b).times(2.0), one / (u * b).times(2.0));
    let g_s = -e * over_s;
    let g_p = e * e.plus(2.0).mul_sub(c * c, one) * over_p;
    let h_s = c.mul_add(c, b2) * over_s;
    let h_p = u.mul_add(u, b2) * over_p;
    let (f_s, f_p) = (g_s * g_s * q, g_p * g_p * q);
    let (t_s, t_p) = (one / f_s.plus(1.0), one / f_p.plus(1.0));
    // t_s conj(t_p) = 1 / D = conj(D) / |D|^2 and |D|^2 = 1 / (T_s T_p).
    let norm = t_s * t_p;
    let real = (h_s * h_p).mul_add(q, cc) * norm;
    let imag = sine * cosine * (h_s - h_p) * norm;
    let scale = g_s * g_p * q;
    Response {
        reflect: Mueller { s: f_s * t_s, p: f_p * t_p, cross: [real * scale, imag * scale] },
        transmit: Mueller { s: t_s, p: t_p, cross: [real, imag] },
    }
}

/// Everything about any free film: `b` and `u` are complex, and `decay = exp(-Im beta)`.
#[inline(always)]
pub fn free_absorbing<V: Number>(cos: V, b: Complex<V>, u: Complex<V>, per_b: V, decay: V) -> Response<V> {
    let one = cos.like(1.0);
    // One passage: exp(i beta), up to a sign that is the same for s and p and drops out of every product.
    let (sine, cosine) = sin_cos_pi(within(b[0], per_b));
    let pass = [cosine * decay, sine * decay];
    let round = mul(pass, pass);
    // 1 - exp(2 i beta): near no phase at all the difference is 2 sin^2 of the half and not a cancellation.
    let lost = [(one - decay * decay) + (decay * decay * sine * sine).times(2.0), -round[1]];
    let (r_s, t_s) = free_amplitudes([cos, cos.like(0.0)], b, pass, lost);
    let (r_p, t_p) = free_amplitudes(u, b, pass, lost);
    Response {
        reflect: Mueller { s: power(r_s), p: power(r_p), cross: conjugate_product(r_s, r_p) },
        transmit: Mueller { s: power(t_s), p: power(t_p), cross: conjugate_product(t_s, t_p) },
    }
}

/// r and t of one polarisation, of admittance `a` outside and `b` inside.
#[inline(always)]
fn free_amplitudes<V: Number>(
    a: Complex<V>,
    b: Complex<V>,
    pass: Complex<V>,
    lost: Complex<V>,
) -> (Complex<V>, Complex<V>) {
    let sum = inverse([a[0] + b[0], a[1] + b[1]]);
    let r12 = mul([a[0] - b[0], a[1] - b[1]], sum);
    let through = mul(mul(mul(a, b), sum), sum).map(|v| v.times(4.0));
    let r2 = mul(r12, r12);
    // 1 - r12^2 E = (1 - r12^2) + r12^2 (1 - E)
    let extra = mul(r2, lost);
    let denominator = inverse([through[0] + extra[0], through[1] + extra[1]]);
    (mul(mul(r12, lost), denominator), mul(mul(through, pass), denominator))
}
