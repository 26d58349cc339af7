//! Coherent runs of layers with everything that happens inside them: fields at every interface, and the derivatives of
//! the two amplitudes with respect to every thickness and every medium.
//!
//! The fields `v = (e, h)` of `march` at the interfaces of a run are enough for the derivatives of `r`: every layer
//! matrix `M` has determinant 1, so `v^T J M = v_below^T J` with `J` the antisymmetric unit, and
//!
//! ```text
//! dr = 2 q / S^2 (h de - e dh) at the lit side = 2 q / S^2 (h_top de' - e_top dh'),   (de', dh') = dM v_bottom
//! ```
//!
//! with `S = q e + h` at the lit side and `v_top`, `v_bottom` at the two faces of the layer that changes. (With `dM` written out
//! this is the integral of the squared field over the layer.) `t = 2 q / S` needs the row `(q, 1)`, marched from the lit side
//! down: `dt = -t (row dM v_bottom) / S`. One march up and one down serve all parameters.

use super::layer::Field;
use super::march::{Wave, parts, rescaled};
use crate::Complex64;

const ZERO: Complex64 = Complex64::new(0.0, 0.0);

/// What the march needs of a medium: `X = kz^2` and the weight `W`, 1 for s and n^2 for p.
#[derive(Debug, Clone, Copy)]
pub(super) struct Half {
    pub(super) kz_squared: Complex64,
    pub(super) kz: Complex64,
    pub(super) weight: Complex64,
}

impl Half {
    pub(super) fn new(kz_squared: Complex64, kz: Complex64, weight: Complex64) -> Half {
        Half { kz_squared, kz, weight }
    }

    /// `h / e` of a wave that travels down.
    pub(super) fn q(&self) -> Complex64 {
        self.kz / self.weight
    }

    /// `dq/dX`; infinite at the critical angle of the medium.
    fn q_by_kz_squared(&self) -> Complex64 {
        0.5 / (self.kz * self.weight)
    }

    fn q_by_weight(&self) -> Complex64 {
        -self.q() / self.weight
    }
}

/// A layer's matrix times `exp(-decay)`, from its bottom to its top, or its derivative: the elements of [`Field::up`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Matrix {
    cos: Complex64,
    over: Complex64,
    under: Complex64,
}

impl Matrix {
    fn times(&self, field: &Field<f64>) -> Field<f64> {
        let mut field = *field;
        field.up(parts(self.cos), parts(self.over), parts(self.under));
        field
    }

    /// A row from the left: the transposed matrix.
    fn row_times(&self, row: &Field<f64>) -> Field<f64> {
        Matrix { over: self.under, under: self.over, ..*self }.times(row)
    }
}

/// The wave of a layer, and how its sine changes with kz^2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Phase {
    wave: Wave,
    sin_by_kz_squared: Complex64,
    k0_d: f64,
}

impl Phase {
    /// `k0_d` is `2 pi thickness / wavelength`.
    pub(super) fn new(kz_squared: Complex64, k0_d: f64) -> Phase {
        let wave = Wave::new(kz_squared, k0_d);
        let square = kz_squared * (k0_d * k0_d);
        let sin_by_kz_squared = if square.norm() < 0.04 {
            // The closed form is 0/0 at kz = 0. Six terms leave 0.04^6 / 13! < 1e-17.
            let terms =
                [-1.0 / 6.0, 2.0 / 120.0, -3.0 / 5_040.0, 4.0 / 362_880.0, -5.0 / 39_916_800.0, 6.0 / 6_227_020_800.0];
            let slope = terms.iter().rev().fold(ZERO, |sum, term| sum * square + term);
            slope * k0_d.powi(3) * (-wave.decay).exp()
        } else {
            (k0_d * wave.cos - wave.sin_over_kz) / (2.0 * kz_squared)
        };
        Phase { wave, sin_by_kz_squared, k0_d }
    }

    /// `|Im delta|`.
    pub(super) fn decay(&self) -> f64 {
        self.wave.decay
    }

    pub(super) fn matrix(&self, of: &Half) -> Matrix {
        let sin = self.wave.sin_over_kz;
        Matrix { cos: self.wave.cos, over: of.weight * sin, under: of.kz_squared / of.weight * sin }
    }

    /// The matrix's derivative with respect to `k0` times the thickness.
    fn by_thickness(&self, of: &Half) -> Matrix {
        let cos = self.wave.cos;
        Matrix {
            cos: -of.kz_squared * self.wave.sin_over_kz,
            over: of.weight * cos,
            under: of.kz_squared / of.weight * cos,
        }
    }

    fn by_kz_squared(&self, of: &Half) -> Matrix {
        let (sin, slope) = (self.wave.sin_over_kz, self.sin_by_kz_squared);
        Matrix {
            cos: -0.5 * self.k0_d * sin,
            over: of.weight * slope,
            under: (sin + of.kz_squared * slope) / of.weight,
        }
    }

    fn by_weight(&self, of: &Half) -> Matrix {
        let sin = self.wave.sin_over_kz;
        Matrix { cos: ZERO, over: sin, under: -of.kz_squared / (of.weight * of.weight) * sin }
    }
}

/// Fields at the interfaces of a run, each times a factor whose logarithm is kept beside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaled {
    pub(super) field: Field<f64>,
    pub(super) log: f64,
}

impl Scaled {
    pub(super) fn new((e, h): (Complex64, Complex64)) -> Scaled {
        Scaled { field: Field { e: parts(e), h: parts(h) }, log: 0.0 }
    }

    /// The two fields.
    pub(super) fn pair(&self) -> (Complex64, Complex64) {
        let [e, h] = [self.field.e, self.field.h].map(|[re, im]| Complex64::new(re, im));
        (e, h)
    }

    pub(super) fn up(self, phase: &Phase, of: &Half) -> Scaled {
        Scaled::balanced(phase.matrix(of).times(&self.field), self.log + phase.decay())
    }

    fn down_row(self, phase: &Phase, of: &Half) -> Scaled {
        Scaled::balanced(phase.matrix(of).row_times(&self.field), self.log + phase.decay())
    }

    fn balanced(mut field: Field<f64>, log: f64) -> Scaled {
        let taken = rescaled(&mut field);
        Scaled { field, log: log + taken }
    }
}

/// A complex covector over the parameters of a stack: how something changes with each thickness, each `X = kz^2` and
/// each weight `W`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slopes {
    /// One a layer; layer `j` is medium `j + 1`.
    pub(super) thickness: Vec<Complex64>,
    /// One a medium.
    pub(super) kz_squared: Vec<Complex64>,
    /// One a medium.
    pub(super) weight: Vec<Complex64>,
}

impl Slopes {
    pub(super) fn zero(media: usize) -> Slopes {
        Slopes { thickness: vec![ZERO; media - 2], kz_squared: vec![ZERO; media], weight: vec![ZERO; media] }
    }

    /// Adds `factor` times another.
    pub(super) fn add(&mut self, factor: Complex64, other: &Slopes) {
        let pairs = [
            (&mut self.thickness, &other.thickness),
            (&mut self.kz_squared, &other.kz_squared),
            (&mut self.weight, &other.weight),
        ];
        for (mine, theirs) in pairs {
            for (sum, term) in mine.iter_mut().zip(theirs) {
                *sum += factor * term;
            }
        }
    }

    /// Adds `factor` times the change of `q` of a medium.
    pub(super) fn add_q(&mut self, factor: Complex64, medium: usize, half: &Half) {
        self.kz_squared[medium] += factor * half.q_by_kz_squared();
        self.weight[medium] += factor * half.q_by_weight();
    }
}

/// A coherent run between two media, lit from above or from below with unit field.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// Reflected field over the incident one (E for s, H for p).
    pub(super) r: Complex64,
    /// Transmitted field over the incident one.
    pub(super) t: Complex64,
    /// `dr`.
    pub(super) r_slopes: Slopes,
    /// `dt / t`.
    pub(super) t_slopes: Slopes,
}

/// The layers of a run in the order of the march, from the dark side to the lit one.
pub(super) fn layers_from_dark(top: usize, bottom: usize, from_below: bool) -> impl Iterator<Item = usize> {
    (1..bottom - top).map(move |step| if from_below { top + step } else { bottom - step })
}

/// Fields at the interfaces of a run, from the dark side to the lit one.
pub(super) fn march(halves: &[Half], phases: &[Phase], top: usize, bottom: usize, from_below: bool) -> Vec<Scaled> {
    let dark = if from_below { top } else { bottom };
    let mut fields = Vec::with_capacity(bottom - top);
    fields.push(Scaled::new((Complex64::new(1.0, 0.0), halves[dark].q())));
    for medium in layers_from_dark(top, bottom, from_below) {
        fields.push(fields[fields.len() - 1].up(&phases[medium - 1], &halves[medium]));
    }
    fields
}

/// Amplitudes of a run and their derivatives, `k0 = 2 pi / wavelength`. `None` at a pole (a laser at its threshold).
pub(super) fn run(
    halves: &[Half],
    phases: &[Phase],
    k0: f64,
    (top, bottom): (usize, usize),
    from_below: bool,
) -> Option<Run> {
    let (lit, dark) = if from_below { (bottom, top) } else { (top, bottom) };
    let fields = march(halves, phases, top, bottom, from_below);
    let layers: Vec<usize> = layers_from_dark(top, bottom, from_below).collect();
    let end = fields[layers.len()];
    let (e, h) = end.pair();
    let q = halves[lit].q();
    let sum = q * e + h;
    if sum.norm_sqr() == 0.0 || !sum.is_finite() {
        return None;
    }
    let (r, t) = ((q * e - h) / sum, 2.0 * q / sum * (-end.log).exp());
    let mut r_slopes = Slopes::zero(halves.len());
    let mut t_slopes = Slopes::zero(halves.len());
    let factor = 2.0 * q / (sum * sum);
    r_slopes.add_q(2.0 * e * h / (sum * sum), lit, &halves[lit]);
    t_slopes.add_q(1.0 / q - e / sum, lit, &halves[lit]);

    let mut row = Scaled::new((q, Complex64::new(1.0, 0.0)));
    for (step, &medium) in layers.iter().enumerate().rev() {
        let (half, phase) = (&halves[medium], &phases[medium - 1]);
        let (below, above) = (fields[step], fields[step + 1]);
        let of_r = factor * (above.log + below.log + phase.decay() - 2.0 * end.log).exp();
        let of_t = -(row.log + phase.decay() + below.log - end.log).exp() / sum;
        let slopes = |change: &Matrix| {
            let (de, dh) = Scaled { field: change.times(&below.field), log: 0.0 }.pair();
            let ((e, h), (x, y)) = (above.pair(), row.pair());
            (of_r * (h * de - e * dh), of_t * (x * de + y * dh))
        };
        let (by_r, by_t) = slopes(&phase.by_thickness(half));
        r_slopes.thickness[medium - 1] += k0 * by_r;
        t_slopes.thickness[medium - 1] += k0 * by_t;
        let (by_r, by_t) = slopes(&phase.by_kz_squared(half));
        r_slopes.kz_squared[medium] += by_r;
        t_slopes.kz_squared[medium] += by_t;
        let (by_r, by_t) = slopes(&phase.by_weight(half));
        r_slopes.weight[medium] += by_r;
        t_slopes.weight[medium] += by_t;
        row = row.down_row(phase, half);
    }
    r_slopes.add_q(-factor * (-2.0 * end.log).exp(), dark, &halves[dark]);
    t_slopes.add_q(-row.pair().1 * (row.log - end.log).exp() / sum, dark, &halves[dark]);
    Some(Run { r, t, r_slopes, t_slopes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incidence::sqrt_upper;

    /// `kz^2`, `k0 d`, `sin(delta)/kz` and its derivative with respect to `kz^2` (mpmath, 40 digits); the series ends at
    /// a modulus of 0.04 of `delta^2`.
    #[test]
    fn sines_and_their_slopes_on_both_sides_of_the_series() {
        let c = Complex64::new;
        for (kz_squared, k0_d, sin_over_kz, slope) in [
            (c(0.0, 0.0), 3.0, c(3.0, 0.0), c(-4.5, 0.0)),
            (c(0.0396, 0.0), 1.0, c(0.9934130556855171, 0.0), c(-0.16600759941103174, 0.0)),
            (c(0.0404, 0.0), 1.0, c(0.9932802549241512, 0.0), c(-0.1659943041306327, 0.0)),
            (c(-0.0396, 0.0), 1.0, c(1.0066130803280362, 0.0), c(-0.1673276007800605, 0.0)),
            (c(-0.0404, 0.0), 1.0, c(1.0067469477571978, 0.0), c(-0.16734097225098704, 0.0)),
            (
                c(0.01, 0.03),
                1.1,
                c(1.0977709399880562, -0.006646940496533943),
                c(-0.22156398771535488, 0.0008045585621034627),
            ),
            (
                c(0.01, 0.03),
                1.2,
                c(1.1971034296886383, -0.0086275456165757),
                c(-0.28758357520246186, 0.0012428792696989415),
            ),
            (
                c(1.5, -0.75),
                2.5,
                c(-0.15350806273116385, 0.6098510022773724),
                c(-0.73493894151744, -0.5770814311237041),
            ),
            (c(-4.0, 1.0), 3.0, c(84.54614419135727, -60.589758450184156), c(-55.72845198668879, 32.15009857133392)),
        ] {
            let phase = Phase::new(kz_squared, k0_d);
            let scale = phase.decay().exp();
            assert!((phase.wave.sin_over_kz * scale - sin_over_kz).norm() < 1e-15 * sin_over_kz.norm(), "{kz_squared}");
            // The closed form loses the digits of delta^2, about two at the switch.
            assert!((phase.sin_by_kz_squared * scale - slope).norm() < 3e-14 * slope.norm(), "{kz_squared}");
        }
    }

    #[test]
    fn matrices_keep_their_determinant() {
        let (square, weight) = (Complex64::new(1.3, 0.4), Complex64::new(2.0, -0.3));
        let half = Half::new(square, sqrt_upper(square), weight);
        let phase = Phase::new(square, 2.2);
        let m = phase.matrix(&half);
        let determinant = (m.cos * m.cos + m.over * m.under) * (2.0 * phase.decay()).exp();
        assert!((determinant - 1.0).norm() < 1e-14, "{determinant}");
    }
}
