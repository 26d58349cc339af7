//! A free film (the same medium on both sides) at one hit: what it reflects and passes at every spectral node, by the
//! kernels of [`iridesce_optics::film::kernel`] in single precision. Absorbing films, and films that light cannot enter
//! beyond a critical angle, go through the complex form. The phase is kept in half turns, from which the nearest whole
//! number is taken off before any polynomial (f32 cosines of large arguments are what this prevents).

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::complex::square_root;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_numerics::turns::exp2;
use iridesce_optics::film::kernel::{free_absorbing, free_lossless, free_reflectance};
use iridesce_optics::mueller;
use num_complex::Complex64;

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

/// Light on a film, per block of nodes.
pub type Beam<S> = mueller::Beam<f32x16<S>>;
/// Powers and cross terms of a film for a block of nodes.
pub type Response<S> = mueller::Response<f32x16<S>>;
/// What a film reflects, or passes, for a block of nodes.
pub type Mueller<S> = mueller::Mueller<f32x16<S>>;

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
        let FilmBlock { contrast, rate, .. } = &self.blocks[block];
        let cos = f32x16::splat(simd, cos_theta.max(SMALLEST_COS));
        free_reflectance(contrast.load(simd), cos, rate.load(simd) * thickness_nm)
    }

    /// Everything about a block of nodes of any film.
    #[inline(always)]
    pub fn response<S: Simd>(&self, simd: S, block: usize, cos_theta: f32, thickness_nm: f32) -> Response<S> {
        let FilmBlock { contrast, loss, rate } = &self.blocks[block];
        let cos = f32x16::splat(simd, cos_theta.max(SMALLEST_COS));
        let (contrast, per_b) = (contrast.load(simd), rate.load(simd) * thickness_nm);
        if self.is_plain {
            return free_lossless(contrast, cos, per_b);
        }
        let loss = loss.load(simd);
        let b = square_root([cos.mul_add(cos, contrast), loss]);
        let decay = exp2(b[1] * per_b * -EXP2_PER_HALF_TURN);
        free_absorbing(cos, b, [(contrast + 1.0) * cos, loss * cos], per_b, decay)
    }
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
