//! A free film (the same medium on both sides) at one hit: what it reflects and passes at every spectral node, by the
//! kernels of [`iridesce_optics::film::kernel`] in single precision. Absorbing films, and films that light cannot enter
//! beyond a critical angle, go through the complex form. The phase is kept in half turns, from which the nearest whole
//! number is taken off before any polynomial (f32 cosines of large arguments are what this prevents).

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::complex::square_root;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_numerics::turns::exp2;
use iridesce_optics::film::kernel::{free_absorbing, free_lossless, free_reflectance};
use iridesce_optics::mueller;
use num_complex::Complex64;

use crate::spectral::Nodes;

/// exp(-pi x) = 2^(-x times this).
pub const EXP2_PER_HALF_TURN: f32 = std::f32::consts::PI * std::f32::consts::LOG2_E;
/// cos(theta) is kept above this: at 90 degrees every ratio below would be 0/0, and closer than this the product of
/// two denominators, down to (2 cos^2)^4 without contrast, would leave the range of f32. R there is 1 to 1e-7.
pub const SMALLEST_COS: f32 = 1e-4;

/// Optical path difference beyond which single precision does not hold the phase, nm: 2e-4 of a fringe at the violet end.
/// No continuous light shows fringes that far, so that double precision is for lines alone.
const SINGLE_NM: f64 = 400_000.0;
/// Phases of a mean over all of them. Echoes beyond the 32nd are lost: 1e-3 of the light where a face mirrors 80 % of it.
const PHASES: usize = 32;

/// How the phase of a film is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// In single precision.
    Single,
    /// In double precision.
    Exact,
    /// At nodes of a continuous spectrum not at all: their mean over all phases counts. At lines in double precision.
    Averaged,
}

impl Phase {
    /// Of a path difference in nm, where fringes are seen up to `seen_nm`.
    #[inline(always)]
    pub fn of(path_nm: f64, seen_nm: f64) -> Phase {
        match () {
            () if path_nm > seen_nm => Phase::Averaged,
            () if path_nm > SINGLE_NM => Phase::Exact,
            () => Phase::Single,
        }
    }
}

/// A film medium at the nodes of a render.
#[derive(Debug, Clone)]
pub struct FilmTable {
    blocks: Vec<FilmBlock>,
    exact: Vec<ExactNode>,
    is_plain: bool,
    is_clear: bool,
}

/// A film medium at a node, in double precision.
#[derive(Debug, Clone, Copy)]
struct ExactNode {
    /// m^2 - 1.
    contrast: Complex64,
    /// 2 n_outer / lambda.
    rate: f64,
    is_continuous: bool,
}

/// A film medium at a block of nodes.
#[derive(Debug, Clone, Copy)]
struct FilmBlock {
    /// Re(m^2) - 1, taken in f64 because m may be close to 1.
    contrast: Lanes,
    /// Re(m^2), which the contrast of a nearly empty medium does not hold: at m = 1e-4 it is -1 in single precision.
    square: Lanes,
    /// b^2 = cos^2 + near + rest: the contrast and 0, or -1 and Re(m^2) where m is small.
    near: Lanes,
    rest: Lanes,
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
    pub fn new(nodes: &Nodes, film: &[Complex64], outer: &[f64]) -> FilmTable {
        let wavelength_nm = &nodes.wavelength_nm;
        let relative: Vec<Complex64> = film.iter().zip(outer).map(|(n, o)| n / o).collect();
        let contrast_of = |m: &Complex64| (m.re - 1.0) * (m.re + 1.0) - m.im * m.im;
        let square_of = |m: &Complex64| (m.re - m.im) * (m.re + m.im);
        let is_small = |m: &&Complex64| square_of(m).abs() < 0.5;
        let contrast = blocks(relative.iter().map(contrast_of));
        let square = blocks(relative.iter().map(square_of));
        let near = blocks(relative.iter().map(|m| if is_small(&m) { -1.0 } else { contrast_of(m) }));
        let rest = blocks(relative.iter().map(|m| if is_small(&m) { square_of(m) } else { 0.0 }));
        let loss = blocks(relative.iter().map(|m| 2.0 * m.re * m.im));
        let rate = blocks(wavelength_nm.iter().zip(outer).map(|(l, o)| 2.0 * o / l));
        let bent = square.into_iter().zip(near.into_iter().zip(rest));
        let joined = contrast.into_iter().zip(loss).zip(rate).zip(bent);
        let exact = relative.iter().zip(wavelength_nm.iter().zip(outer)).enumerate();
        let exact = exact.map(|(node, (m, (l, o)))| ExactNode {
            contrast: (m - 1.0) * (m + 1.0),
            rate: 2.0 * o / l,
            is_continuous: nodes.is_continuous(node),
        });
        FilmTable {
            exact: exact.collect(),
            blocks: joined
                .map(|(((contrast, loss), rate), (square, (near, rest)))| FilmBlock {
                    contrast,
                    square,
                    near,
                    rest,
                    loss,
                    rate,
                })
                .collect(),
            is_clear: relative.iter().all(|m| m.im == 0.0),
            is_plain: relative.iter().all(|m| m.im == 0.0 && m.re >= 1.0),
        }
    }

    /// Whether the film is lossless and lets light in at every angle: then T = 1 - R and only
    /// [`FilmTable::reflectance`] is needed while all planes of incidence coincide.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Whether nothing is lost in it.
    pub fn is_clear(&self) -> bool {
        self.is_clear
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
        let FilmBlock { contrast, rate, .. } = &self.blocks[block];
        let cos = f32x16::splat(simd, cos_theta.max(SMALLEST_COS));
        let (contrast, per_b) = (contrast.load(simd), rate.load(simd) * thickness_nm);
        if self.is_plain {
            return free_lossless(contrast, cos, per_b);
        }
        let b = self.inner(simd, block, cos);
        let decay = exp2(b[1] * per_b * -EXP2_PER_HALF_TURN);
        self.lossy(simd, block, cos, b, per_b, decay)
    }

    /// b of any film.
    #[inline(always)]
    fn inner<S: Simd>(&self, simd: S, block: usize, cos: f32x16<S>) -> [f32x16<S>; 2] {
        let FilmBlock { near, rest, loss, .. } = &self.blocks[block];
        square_root([cos.mul_add(cos, near.load(simd)) + rest.load(simd), loss.load(simd)])
    }

    /// The complex form.
    #[inline(always)]
    fn lossy<S: Simd>(
        &self,
        simd: S,
        block: usize,
        cos: f32x16<S>,
        b: [f32x16<S>; 2],
        per_b: f32x16<S>,
        decay: f32x16<S>,
    ) -> Response<S> {
        let FilmBlock { square, loss, .. } = &self.blocks[block];
        free_absorbing(cos, b, [square.load(simd) * cos, loss.load(simd) * cos], per_b, decay)
    }

    /// [`FilmTable::response`] of a film whose phase single precision does not hold.
    #[inline(always)]
    pub fn long_response<S: Simd>(
        &self,
        simd: S,
        block: usize,
        cos_theta: f64,
        thickness_nm: f64,
        phase: Phase,
    ) -> Response<S> {
        let FilmBlock { contrast, .. } = &self.blocks[block];
        let cos_theta = cos_theta.max(f64::from(SMALLEST_COS));
        let cos = f32x16::splat(simd, cos_theta as f32);
        let own = &self.exact[block * LANES..(block + 1) * LANES];
        let mut inner = [0.0; LANES];
        let mut decay = Lanes::ZERO;
        let mut is_averaged = [false; LANES];
        for lane in 0..LANES {
            let b = (own[lane].contrast + cos_theta * cos_theta).sqrt();
            inner[lane] = b.re;
            decay.0[lane] = (-std::f64::consts::PI * own[lane].rate * thickness_nm * b.im).exp() as f32;
            is_averaged[lane] = phase == Phase::Averaged && own[lane].is_continuous;
        }
        let count = if is_averaged.contains(&true) { PHASES } else { 1 };
        let zero =
            Mueller { s: f32x16::splat(simd, 0.0), p: f32x16::splat(simd, 0.0), cross: [f32x16::splat(simd, 0.0); 2] };
        let mut sum = Response { reflect: zero, transmit: zero };
        for k in 0..count {
            let mut per_b = Lanes::ZERO;
            for lane in 0..LANES {
                let half_turns = if is_averaged[lane] {
                    (k as f64 + 0.5) / count as f64
                } else {
                    let all = own[lane].rate * thickness_nm * inner[lane];
                    all - all.round()
                };
                // Where light does not enter at all there is no phase.
                per_b.0[lane] = if inner[lane] > 0.0 { (half_turns / inner[lane]) as f32 } else { 0.0 };
            }
            let per_b = per_b.load(simd);
            let one = if self.is_plain {
                free_lossless(contrast.load(simd), cos, per_b)
            } else {
                self.lossy(simd, block, cos, self.inner(simd, block, cos), per_b, decay.load(simd))
            };
            sum = Response {
                reflect: added(sum.reflect, one.reflect, 1.0 / count as f32),
                transmit: added(sum.transmit, one.transmit, 1.0 / count as f32),
            };
        }
        sum
    }
}

#[inline(always)]
fn added<S: Simd>(to: Mueller<S>, one: Mueller<S>, share: f32) -> Mueller<S> {
    Mueller {
        s: one.s.mul_add(share, to.s),
        p: one.p.mul_add(share, to.p),
        cross: [one.cross[0].mul_add(share, to.cross[0]), one.cross[1].mul_add(share, to.cross[1])],
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
        let table = FilmTable::new(&nodes, &vec![index; count], &vec![outer; count]);
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

    /// A nearly empty medium in another. What one passage loses is told to 2^-23 and divided by 1 - r12^2 E, which is small here.
    #[test]
    fn films_of_hardly_any_index_agree_with_the_multilayer() {
        let nodes = Nodes::new(32, &[]);
        let (count, node) = (nodes.len(), 7);
        let nm = nodes.wavelength_nm[node];
        for index in [0.3, 0.01, 1e-4, 1e-6] {
            let table = FilmTable::new(&nodes, &vec![Complex64::new(index, 0.0); count], &vec![1.0; count]);
            for (thickness_nm, cos_theta) in
                [0.0_f32, 1e-3, 5.0, 300.0].into_iter().flat_map(|d| [1.0_f32, 0.98, 0.5, 0.01].map(|c| (d, c)))
            {
                let (cos, square) = (f64::from(cos_theta), index * index);
                let found = kernel(Level::new(), &table, count / 16, cos_theta, thickness_nm);
                let expected = exact(Complex64::new(index, 0.0), nm, cos, f64::from(thickness_nm));
                let b = Complex64::new(square - (1.0 - cos) * (1.0 + cos), 0.0).sqrt();
                let pass = (-b.im * std::f64::consts::TAU * f64::from(thickness_nm) / nm).exp();
                let tolerance = [(cos, expected[1][0]), (square * cos, expected[1][1])].map(|(a, passed)| {
                    let denominator = (4.0 * a * b / ((a + b) * (a + b))).norm() * pass / passed.sqrt();
                    1e-5 + 2.0 * 2.0_f64.powi(-23) / denominator
                });
                let tolerance = [tolerance[0], tolerance[1], tolerance[0] + tolerance[1], tolerance[0] + tolerance[1]];
                for (found, expected) in [&found.reflect, &found.transmit].iter().zip(expected) {
                    for c in 0..4 {
                        let value = f64::from(found[c][node]);
                        assert!(
                            (value - expected[c]).abs() < tolerance[c],
                            "{index} {thickness_nm} {cos_theta} {c}: {value} {expected:?} {tolerance:?}"
                        );
                    }
                }
            }
        }
    }

    fn long(table: &FilmTable, blocks: usize, cos_theta: f64, thickness_nm: f64, phase: Phase) -> Found {
        #[inline(always)]
        fn run<S: Simd>(simd: S, table: &FilmTable, blocks: usize, at: (f64, f64, Phase)) -> Found {
            let mut found =
                Found { reflect: Default::default(), transmit: Default::default(), plain: Default::default() };
            for block in 0..blocks {
                let response = table.long_response(simd, block, at.0, at.1, at.2);
                for (m, out) in [(response.reflect, &mut found.reflect), (response.transmit, &mut found.transmit)] {
                    for (value, out) in [m.s, m.p, m.cross[0], m.cross[1]].into_iter().zip(out) {
                        out.extend(value.to_array());
                    }
                }
            }
            found
        }
        dispatch!(Level::new(), simd => run(simd, table, blocks, (cos_theta, thickness_nm, phase)))
    }

    /// Powers and cross terms of what the multilayer reflects and passes.
    fn exact(index: Complex64, nm: f64, cos_theta: f64, thickness_nm: f64) -> [[f64; 4]; 2] {
        let one = Complex64::new(1.0, 0.0);
        let [s, p] = [Polarization::S, Polarization::P].map(|polarization| {
            let solved = solve(&[one, index, one], &[thickness_nm], &[true], nm, cos_theta, polarization).unwrap();
            solved.amplitudes.expect("a coherent film has amplitudes")
        });
        [(s.r, p.r), (s.t, p.t)].map(|(s, p)| {
            let cross = s * p.conj();
            [s.norm_sqr(), p.norm_sqr(), cross.re, cross.im]
        })
    }

    /// 10 mm of film: 40 000 half turns. In single precision they are off by a hundredth of one.
    #[test]
    fn long_films_keep_their_phase() {
        let nodes = Nodes::new(32, &[589.2, 632.8]);
        let count = nodes.len();
        for index in [Complex64::new(1.33, 0.0), Complex64::new(1.5, 1e-6)] {
            let table = FilmTable::new(&nodes, &vec![index; count], &vec![1.0; count]);
            for (thickness_nm, angle) in [(1e7_f64, 0.0_f64), (1e7 + 37.0, 40.0), (3.3e5, 75.0)] {
                let cos_theta = angle.to_radians().cos();
                let found = long(&table, count / 16, cos_theta, thickness_nm, Phase::Exact);
                for node in [0, 17, 32, 33] {
                    let expected = exact(index, nodes.wavelength_nm[node], cos_theta, thickness_nm);
                    for (found, expected) in [&found.reflect, &found.transmit].iter().zip(expected) {
                        for c in 0..4 {
                            let value = f64::from(found[c][node]);
                            assert!(
                                (value - expected[c]).abs() < 5e-6,
                                "{index} {thickness_nm} {angle}: {value} {expected:?}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// Continuous light of long films is the mean over a whole fringe; lines keep their phase.
    #[test]
    fn long_films_lose_the_phase_that_nobody_sees() {
        let nodes = Nodes::new(32, &[589.2]);
        let count = nodes.len();
        for index in [Complex64::new(1.33, 0.0), Complex64::new(1.5, 2e-5)] {
            let table = FilmTable::new(&nodes, &vec![index; count], &vec![1.0; count]);
            for angle in [0.0_f64, 50.0, 80.0] {
                let (cos_theta, thickness_nm) = (angle.to_radians().cos(), 1e6);
                let found = long(&table, count / 16, cos_theta, thickness_nm, Phase::Averaged);
                for node in [0, 17, 31, 32] {
                    let nm = nodes.wavelength_nm[node];
                    let steps = if node == 32 { 1 } else { 128 };
                    let fringe_nm = 0.5 * nm / (index * index - 1.0 + cos_theta * cos_theta).sqrt().re;
                    let mut mean = [[0.0; 4]; 2];
                    for step in 0..steps {
                        // Around the thickness: what is absorbed changes with it.
                        let aside = if steps == 1 { 0.0 } else { (f64::from(step) + 0.5) / f64::from(steps) - 0.5 };
                        let one = exact(index, nm, cos_theta, thickness_nm + fringe_nm * aside);
                        for (mean, one) in mean.iter_mut().flatten().zip(one.iter().flatten()) {
                            *mean += one / f64::from(steps);
                        }
                    }
                    for (found, expected) in [&found.reflect, &found.transmit].iter().zip(mean) {
                        for c in 0..4 {
                            let value = f64::from(found[c][node]);
                            assert!((value - expected[c]).abs() < 1e-5, "{index} {angle} {node}: {value} {expected:?}");
                        }
                    }
                }
            }
        }
    }

    /// Every level computes the same film to rounding; fused and separate multiplications differ by design.
    #[test]
    fn simd_levels_agree() {
        let nodes = Nodes::new(32, &[]);
        let count = nodes.len();
        let fallback = Level::baseline();
        for index in [Complex64::new(1.33, 0.0), Complex64::new(0.5, 2.0)] {
            let table = FilmTable::new(&nodes, &vec![index; count], &vec![1.0; count]);
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
