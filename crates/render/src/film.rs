//! A free film (the same medium on both sides) at one hit: what it reflects and passes at every spectral node.
//!
//! With c = cos(theta) outside, m the film's index over the outer medium's, b^2 = m^2 - sin^2(theta),
//! u = m^2 c and the half phase beta = 2 pi n_outer t b / lambda, each polarisation of a lossless film has
//!
//! ```text
//! r / t = -i g sin(beta),   1 / t = cos(beta) - i h sin(beta)
//! g_s = (c^2 - b^2) / (2 c b) = (1 - m^2) / (2 c b),   g_p = (u^2 - b^2) / (2 u b),   h = sqrt(1 + g^2)
//! R = g^2 sin^2 / (1 + g^2 sin^2),   T = 1 - R
//! ```
//!
//! which is Airy's sum written without a single difference of nearly equal numbers: b^2 = (m^2 - 1) + c^2 and
//! u^2 - b^2 = (m^2 - 1)((m^2 + 1) c^2 - 1). Absorbing films, and films that light cannot enter beyond a
//! critical angle, go through the complex form. The phase is kept in half turns, from which the nearest whole
//! number is taken off before any polynomial (f32 cosines of large arguments are what this prevents).
//!
//! Source of the Airy sums: Born & Wolf, Principles of Optics, 7th ed., sec. 7.6.

use fearless_simd::{Simd, f32x16, prelude::*};
use num_complex::Complex64;

use crate::complex::{Complex, conjugate_product, inverse, mul, power, square_root};
use crate::lanes::{Lanes, blocks, polynomial};

/// sin(pi x) = x P(x^2) on [-1/2, 1/2]; minimax of P, error 1.4e-8.
pub const SIN_PI: [f32; 5] = [3.141_592_5, -5.167_710_3, 2.550_077_7, -0.598_292_2, 0.077_659_41];
/// cos(pi x) = P(x^2) on [-1/2, 1/2]; minimax, error 2.2e-10 before rounding.
pub const COS_PI: [f32; 6] = [1.0, -4.934_802, 4.058_709, -1.335_212_1, 0.234_937_56, -0.024_396_72];
/// 2^x on [-1/2, 1/2]; Chebyshev fit, error 2.6e-9.
const EXP2: [f32; 7] =
    [1.0, std::f32::consts::LN_2, 0.240_226_5, 0.055_503_27, 0.009_618_026, 0.001_340_043_1, 0.000_154_697_32];
/// exp(-pi x) = 2^(-x times this).
pub const EXP2_PER_HALF_TURN: f32 = std::f32::consts::PI * std::f32::consts::LOG2_E;
/// cos(theta) is kept above this: at 90 degrees every ratio below would be 0/0, and closer than this the product of
/// two denominators, down to (2 cos^2)^4 without contrast, would leave the range of f32. R there is 1 to 1e-7.
pub const SMALLEST_COS: f32 = 1e-4;

/// A film medium at the nodes of a render.
#[derive(Debug, Clone)]
pub struct FilmTable {
    blocks: Vec<FilmBlock>,
    is_plain: bool,
}

/// A film medium at a block of nodes.
#[derive(Debug, Clone, Copy)]
struct FilmBlock {
    /// Re(m^2) - 1, taken in f64 because m may be close to 1.
    contrast: Lanes,
    /// Im(m^2).
    loss: Lanes,
    /// Half turns of phase per nm of thickness and unit of b: 2 n_outer / lambda.
    rate: Lanes,
}

/// Light on a film, per block of nodes: weights of s and p light, and of the two Stokes components between them.
#[derive(Debug, Clone, Copy)]
pub struct Beam<S: Simd> {
    pub s: f32x16<S>,
    pub p: f32x16<S>,
    pub u: f32x16<S>,
    pub v: f32x16<S>,
}

/// Powers and cross terms of a film for a block of nodes.
#[derive(Debug, Clone, Copy)]
pub struct Response<S: Simd> {
    pub reflect: Mueller<S>,
    pub transmit: Mueller<S>,
}

/// The four numbers of the Mueller matrix of a film in its own plane of incidence:
/// powers of s and p, and `cross` = amplitude_s * conj(amplitude_p).
#[derive(Debug, Clone, Copy)]
pub struct Mueller<S: Simd> {
    pub s: f32x16<S>,
    pub p: f32x16<S>,
    pub cross: [f32x16<S>; 2],
}

impl<S: Simd> Mueller<S> {
    /// Carries an adjoint (row) vector through the film: the row times the Mueller matrix.
    #[inline(always)]
    pub fn carry(&self, w: &Beam<S>) -> Beam<S> {
        let [re, im] = self.cross;
        Beam { s: w.s * self.s, p: w.p * self.p, u: w.u * re + w.v * im, v: w.v * re - w.u * im }
    }
}

impl FilmTable {
    /// The table of a film of index `film` in a medium of real index `outer`, one value a node each.
    pub fn new(wavelength_nm: &[f64], film: &[Complex64], outer: &[f64]) -> FilmTable {
        let relative: Vec<Complex64> = film.iter().zip(outer).map(|(n, o)| n / o).collect();
        let contrast = blocks(relative.iter().map(|m| (m.re - 1.0) * (m.re + 1.0) - m.im * m.im));
        let loss = blocks(relative.iter().map(|m| 2.0 * m.re * m.im));
        let rate = blocks(wavelength_nm.iter().zip(outer).map(|(l, o)| 2.0 * o / l));
        let joined = contrast.into_iter().zip(loss).zip(rate);
        FilmTable {
            blocks: joined.map(|((contrast, loss), rate)| FilmBlock { contrast, loss, rate }).collect(),
            is_plain: relative.iter().all(|m| m.im == 0.0 && m.re >= 1.0),
        }
    }

    /// Whether the film is lossless and lets light in at every angle: then T = 1 - R and only
    /// [`FilmTable::reflectance`] is needed while all planes of incidence coincide.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// R of s and p light for a block of nodes of a plain film.
    #[inline(always)]
    pub fn reflectance<S: Simd>(&self, simd: S, block: usize, cos_theta: f32, thickness_nm: f32) -> [f32x16<S>; 2] {
        let c = cos_theta.max(SMALLEST_COS);
        let c2 = f32x16::splat(simd, c * c);
        let e = self.blocks[block].contrast.load(simd);
        let b2 = e + c2;
        let half_turns = b2.sqrt() * (self.blocks[block].rate.load(simd) * thickness_nm);
        let x = half_turns - half_turns.round_ties_even();
        let sine = x * polynomial(simd, x * x, &SIN_PI);
        let q = sine * sine;
        let u = (e + 1.0) * c;
        let k = e * ((e + 2.0).mul_sub(c2, f32x16::splat(simd, 1.0)));
        let four_b2 = b2 * 4.0;
        let s = e * e * q;
        let p = k * k * q;
        // One division for two ratios: the divider is the busiest unit of this loop.
        let (under_s, under_p) = (four_b2.mul_add(c2, s), four_b2.mul_add(u * u, p));
        let inverse = f32x16::splat(simd, 1.0) / (under_s * under_p);
        [s * under_p * inverse, p * under_s * inverse]
    }

    /// Everything about a block of nodes of any film.
    #[inline(always)]
    pub fn response<S: Simd>(&self, simd: S, block: usize, cos_theta: f32, thickness_nm: f32) -> Response<S> {
        if self.is_plain {
            self.plain_response(simd, block, cos_theta, thickness_nm)
        } else {
            self.complex_response(simd, block, cos_theta, thickness_nm)
        }
    }

    #[inline(always)]
    fn plain_response<S: Simd>(&self, simd: S, block: usize, cos_theta: f32, thickness_nm: f32) -> Response<S> {
        let one = f32x16::splat(simd, 1.0);
        let c = f32x16::splat(simd, cos_theta.max(SMALLEST_COS));
        let e = self.blocks[block].contrast.load(simd);
        let b2 = c.mul_add(c, e);
        let b = b2.sqrt();
        let half_turns = b * (self.blocks[block].rate.load(simd) * thickness_nm);
        let x = half_turns - half_turns.round_ties_even();
        let x2 = x * x;
        let sine = x * polynomial(simd, x2, &SIN_PI);
        let cosine = polynomial(simd, x2, &COS_PI);
        let (q, cc) = (sine * sine, cosine * cosine);
        let u = (e + 1.0) * c;
        let (over_s, over_p) = (one / (c * b * 2.0), one / (u * b * 2.0));
        let g_s = -e * over_s;
        let g_p = e * ((e + 2.0).mul_sub(c * c, one)) * over_p;
        let h_s = c.mul_add(c, b2) * over_s;
        let h_p = u.mul_add(u, b2) * over_p;
        let (f_s, f_p) = (g_s * g_s * q, g_p * g_p * q);
        let (t_s, t_p) = (one / (f_s + 1.0), one / (f_p + 1.0));
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

    #[inline(always)]
    fn complex_response<S: Simd>(&self, simd: S, block: usize, cos_theta: f32, thickness_nm: f32) -> Response<S> {
        let one = f32x16::splat(simd, 1.0);
        let c = f32x16::splat(simd, cos_theta.max(SMALLEST_COS));
        let (e, loss) = (self.blocks[block].contrast.load(simd), self.blocks[block].loss.load(simd));
        let b = square_root(simd, [c.mul_add(c, e), loss]);
        let u = [(e + 1.0) * c, loss * c];
        let rate = self.blocks[block].rate.load(simd) * thickness_nm;
        let half_turns = b[0] * rate;
        let x = half_turns - half_turns.round_ties_even();
        let x2 = x * x;
        let sine = x * polynomial(simd, x2, &SIN_PI);
        let cosine = polynomial(simd, x2, &COS_PI);
        // One passage: exp(i beta), up to a sign that is the same for s and p and drops out of every product.
        let decay = exp2(simd, b[1] * rate * -EXP2_PER_HALF_TURN);
        let pass = [cosine * decay, sine * decay];
        let round = mul(pass, pass);
        // 1 - exp(2 i beta): near no phase at all the difference is 2 sin^2 of the half and not a cancellation.
        let lost = [(one - decay * decay) + decay * decay * sine * sine * 2.0, -round[1]];
        let amplitudes = |a: Complex<S>| {
            let sum = inverse(simd, [a[0] + b[0], a[1] + b[1]]);
            let r12 = mul([a[0] - b[0], a[1] - b[1]], sum);
            let through = mul(mul(mul(a, b), sum), sum).map(|v| v * 4.0);
            let r2 = mul(r12, r12);
            // 1 - r12^2 E = (1 - r12^2) + r12^2 (1 - E)
            let extra = mul(r2, lost);
            let denominator = inverse(simd, [through[0] + extra[0], through[1] + extra[1]]);
            (mul(mul(r12, lost), denominator), mul(mul(through, pass), denominator))
        };
        let (r_s, t_s) = amplitudes([c, f32x16::splat(simd, 0.0)]);
        let (r_p, t_p) = amplitudes(u);
        Response {
            reflect: Mueller { s: power(r_s), p: power(r_p), cross: conjugate_product(r_s, r_p) },
            transmit: Mueller { s: power(t_s), p: power(t_p), cross: conjugate_product(t_s, t_p) },
        }
    }
}

/// 2^x for x <= 0; zero below the smallest normal number.
#[inline(always)]
pub fn exp2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let clamped = x.max(f32x16::splat(simd, -120.0));
    let whole = clamped.round_ties_even();
    let fraction = polynomial(simd, clamped - whole, &EXP2);
    // 2^whole through the exponent bits: 1.5 * 2^23 pushes the integer into the low mantissa bits.
    let magic = whole + (12_582_912.0 + 127.0);
    let bits: fearless_simd::u32x16<S> = magic.to_bits();
    let scale = f32x16::from_bits(bits << 23);
    x.simd_lt(f32x16::splat(simd, -119.0)).select(f32x16::splat(simd, 0.0), fraction * scale)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use iridesce_optics::Polarization;
    use iridesce_optics::stack::solve;

    use super::*;
    use crate::spectral::Nodes;

    /// One film at one angle: everything from the kernel under test, by node.
    struct Found {
        reflect: [Vec<f32>; 4],
        transmit: [Vec<f32>; 4],
        plain: [Vec<f32>; 2],
    }

    fn kernel(level: Level, table: &FilmTable, blocks: usize, cos_theta: f32, thickness_nm: f32) -> Found {
        #[inline(always)]
        fn run<S: Simd>(simd: S, table: &FilmTable, blocks: usize, cos_theta: f32, thickness_nm: f32) -> Found {
            let mut found =
                Found { reflect: Default::default(), transmit: Default::default(), plain: Default::default() };
            for block in 0..blocks {
                let response = table.response(simd, block, cos_theta, thickness_nm);
                for (m, out) in [(response.reflect, &mut found.reflect), (response.transmit, &mut found.transmit)] {
                    for (value, out) in [m.s, m.p, m.cross[0], m.cross[1]].into_iter().zip(out) {
                        out.extend(value.to_array());
                    }
                }
                if table.is_plain() {
                    for (value, out) in
                        table.reflectance(simd, block, cos_theta, thickness_nm).into_iter().zip(&mut found.plain)
                    {
                        out.extend(value.to_array());
                    }
                }
            }
            found
        }
        dispatch!(level, simd => run(simd, table, blocks, cos_theta, thickness_nm))
    }

    /// The f32 kernel against the f64 multilayer, inputs rounded to f32 first.
    ///
    /// Tolerance: three roundings of 2^-24 make the half phase wrong by 3 * 2^-24 of itself, and R = F s^2 / (1 + F s^2)
    /// moves by at most 1 + sqrt(F) times that (sharp fringes near grazing); the rest is a dozen roundings of 2^-24.
    fn compare(index: Complex64, outer: f64, thickness: &[f32]) {
        let nodes = Nodes::new(32, &[]);
        let count = nodes.len();
        let table = FilmTable::new(&nodes.wavelength_nm, &vec![index; count], &vec![outer; count]);
        for &thickness_nm in thickness {
            for angle in [0.0_f64, 10.0, 45.0, 53.1, 75.0, 88.0] {
                let cos_theta = angle.to_radians().cos() as f32;
                let found = kernel(Level::new(), &table, count / 16, cos_theta, thickness_nm);
                for (i, &nm) in nodes.wavelength_nm.iter().enumerate() {
                    let media = [Complex64::new(outer, 0.0), index, Complex64::new(outer, 0.0)];
                    let exact = |polarization| {
                        let solved =
                            solve(&media, &[f64::from(thickness_nm)], &[true], nm, f64::from(cos_theta), polarization)
                                .unwrap();
                        let amplitudes = solved.amplitudes.expect("a coherent film has amplitudes");
                        (amplitudes.r, amplitudes.t)
                    };
                    let ((r_s, t_s), (r_p, t_p)) = (exact(Polarization::S), exact(Polarization::P));
                    let m2 = (index / outer) * (index / outer);
                    let c = f64::from(cos_theta);
                    let b = (m2 - 1.0 + c * c).sqrt().norm();
                    let finesse = (m2 - 1.0).norm() / (2.0 * c * b);
                    let half_phase = std::f64::consts::TAU * outer * b * f64::from(thickness_nm) / nm;
                    let tolerance = 3e-6 + (1.0 + finesse) * half_phase * 3.0 * 2.0_f64.powi(-24);
                    let check = |what: &str, found: f32, expected: f64| {
                        assert!(
                            (f64::from(found) - expected).abs() < tolerance,
                            "{what}: {found} for {expected}; n {index}, {thickness_nm} nm, {angle} deg, {nm} nm"
                        );
                    };
                    for (name, found, s, p) in [("R", &found.reflect, r_s, r_p), ("T", &found.transmit, t_s, t_p)] {
                        check(&format!("{name}_s"), found[0][i], s.norm_sqr());
                        check(&format!("{name}_p"), found[1][i], p.norm_sqr());
                        let cross = s * p.conj();
                        check(&format!("{name} cross re"), found[2][i], cross.re);
                        check(&format!("{name} cross im"), found[3][i], cross.im);
                    }
                    if table.is_plain() {
                        check("plain R_s", found.plain[0][i], r_s.norm_sqr());
                        check("plain R_p", found.plain[1][i], r_p.norm_sqr());
                    }
                }
            }
        }
    }

    #[test]
    fn lossless_films_agree_with_the_multilayer() {
        for index in [1.0, 1.0003, 1.33, 1.7, 2.4] {
            compare(Complex64::new(index, 0.0), 1.0, &[0.0, 5.0, 137.0, 400.0, 1000.0, 3000.0]);
        }
    }

    #[test]
    fn absorbing_films_agree_with_the_multilayer() {
        for index in [Complex64::new(0.27, 2.95), Complex64::new(2.9, 3.0), Complex64::new(1.5, 0.01)] {
            compare(index, 1.0, &[0.0, 5.0, 40.0, 400.0]);
        }
    }

    #[test]
    fn films_of_air_in_glass_agree_beyond_the_critical_angle_too() {
        compare(Complex64::new(1.0, 0.0), 1.5, &[0.0, 50.0, 200.0, 800.0]);
    }

    /// Every level computes the same film to rounding; fused and separate multiplications differ by design.
    #[test]
    fn simd_levels_agree() {
        let nodes = Nodes::new(32, &[]);
        let count = nodes.len();
        let fallback = Level::baseline();
        for index in [Complex64::new(1.33, 0.0), Complex64::new(0.5, 2.0)] {
            let table = FilmTable::new(&nodes.wavelength_nm, &vec![index; count], &vec![1.0; count]);
            let wide = kernel(Level::new(), &table, count / 16, 0.6, 700.0);
            let narrow = kernel(fallback, &table, count / 16, 0.6, 700.0);
            for (a, b) in wide.reflect.iter().zip(&narrow.reflect).chain(wide.transmit.iter().zip(&narrow.transmit)) {
                for (a, b) in a.iter().zip(b) {
                    assert!((a - b).abs() < 2e-6, "{a} {b}");
                }
            }
        }
    }
}
