//! Derivatives of what a stack does, with respect to every thickness and every index: analytic, one march up and one
//! down for all of them.

use std::f64::consts::TAU;

use super::averaging::averages;
use super::runs::{self, Half, Phase, Run, Slopes};
use super::solver::lasing;
use crate::fresnel::Polarization;
use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, OpticsError};

const I: Complex64 = Complex64::new(0.0, 1.0);

/// A real quantity and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Derivatives {
    /// The quantity itself.
    pub value: f64,
    /// With respect to each thickness, per nm.
    pub thickness: Vec<f64>,
    /// With respect to n of every medium, first to last.
    pub n: Vec<f64>,
    /// With respect to k of every layer and of the last medium (the first has none).
    pub k: Vec<f64>,
}

/// Derivatives of reflectance and transmittance. The problem must pass [`check`](super::check).
pub fn power_derivatives(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    incidence: Incidence,
    polarization: Polarization,
) -> Result<[Derivatives; 2], OpticsError> {
    let mut mean: Option<[Derivatives; 2]> = None;
    for &part in polarization.parts() {
        let problem = Problem::new(indices, thickness_nm, coherent, wavelength_nm, incidence, part);
        let powers = if problem.slabs.is_empty() { problem.coherent_powers()? } else { problem.slab_powers()? };
        let found = [problem.real(&powers[0])?, problem.real(&powers[1])?];
        mean = Some(match mean {
            None => found,
            Some([r, t]) => [r.mean_with(&found[0]), t.mean_with(&found[1])],
        });
    }
    mean.ok_or_else(|| OpticsError::Argument("no polarisation".into()))
}

/// Derivatives of psi and delta, in degrees; the stack must be coherent.
pub fn ellipsometry_derivatives(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    incidence: Incidence,
) -> Result<[Derivatives; 2], OpticsError> {
    let coherent = vec![true; thickness_nm.len()];
    let solved = [Polarization::S, Polarization::P].map(|polarization| -> Result<_, OpticsError> {
        let problem = Problem::new(indices, thickness_nm, &coherent, wavelength_nm, incidence, polarization);
        let run = problem.run(0, indices.len() - 1, false)?;
        let logarithm = {
            let mut slopes = Slopes::zero(indices.len());
            slopes.add(1.0 / run.r, &run.r_slopes);
            slopes
        };
        // d ln r, real and imaginary part (Im z = Re(-i z)).
        let real = problem.real(&Slope { value: 0.0, slopes: logarithm.clone() })?;
        let mut turned = Slopes::zero(indices.len());
        turned.add(-I, &logarithm);
        Ok((run.r, real, problem.real(&Slope { value: 0.0, slopes: turned })?))
    });
    let [s, p] = solved;
    let ((r_s, ln_s, arg_s), (r_p, ln_p, arg_p)): (LogSlopes, LogSlopes) = (s?, p?);
    let (psi_deg, delta_deg) = super::ellipsometry(r_s, r_p).ok_or_else(no_ratio)?;
    let (sin, cos) = psi_deg.to_radians().sin_cos();
    if sin == 0.0 || cos == 0.0 {
        return Err(no_ratio());
    }
    // tan psi = |r_p/r_s|: d psi = sin psi cos psi d ln|r_p/r_s|.
    let degrees = 1.0_f64.to_degrees();
    Ok([ln_p.minus(&ln_s, psi_deg, sin * cos * degrees), arg_p.minus(&arg_s, delta_deg, degrees)])
}

type LogSlopes = (Complex64, Derivatives, Derivatives);

fn no_ratio() -> OpticsError {
    OpticsError::Argument("psi and delta have no derivatives where one polarisation is not reflected".into())
}

/// How the reflected and transmitted field depend on one layer: the amplitudes of what lies above and below it.
///
/// With `z = exp(2 i kz k0 d)` the stack reflects `r_above + t_above^2 r_below z / (1 - r_inside r_below z)`; E ratios
/// for s, H ratios for p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerAiry {
    /// Reflection of all above the layer, for light from the first medium.
    pub r_above: Complex64,
    /// Transmission through all above the layer, down times up.
    pub t_above_squared: Complex64,
    /// Reflection of all above the layer, for light from inside it.
    pub r_inside: Complex64,
    /// Reflection of all below the layer.
    pub r_below: Complex64,
    /// `|t_above t_below|^2` times the ratio of fluxes: the transmittance is this times `|z| / |1 - r_inside r_below z|^2`.
    pub passed: f64,
    /// Wavenumber along the normal inside the layer, in units of the vacuum one.
    pub kz: Complex64,
}

/// [`LayerAiry`] of layer `layer` (0 is the first); the thickness given for that layer does not matter. All layers must be
/// coherent, and the polarisation s or p.
pub fn layer_airy(
    indices: &[Complex64],
    thickness_nm: &[f64],
    wavelength_nm: f64,
    incidence: Incidence,
    polarization: Polarization,
    layer: usize,
) -> Result<LayerAiry, OpticsError> {
    if polarization == Polarization::Unpolarized || layer >= thickness_nm.len() {
        return Err(OpticsError::Argument("amplitudes of a layer need s or p, and a layer of the stack".into()));
    }
    let coherent = vec![true; thickness_nm.len()];
    let problem = Problem::new(indices, thickness_nm, &coherent, wavelength_nm, incidence, polarization);
    let (medium, last) = (layer + 1, indices.len() - 1);
    let (down, up) = (problem.amplitudes(0, medium, false)?, problem.amplitudes(0, medium, true)?);
    let below = problem.amplitudes(medium, last, false)?;
    let passed = (down.1 * below.1).norm_sqr() * problem.halves[last].q().re / problem.halves[0].q().re;
    Ok(LayerAiry {
        r_above: down.0,
        t_above_squared: down.1 * up.1,
        r_inside: up.0,
        r_below: below.0,
        passed,
        kz: problem.halves[medium].kz,
    })
}

impl Derivatives {
    fn mean_with(&self, other: &Derivatives) -> Derivatives {
        self.combined(other, 0.5 * (self.value + other.value), |a, b| 0.5 * (a + b))
    }

    fn minus(&self, other: &Derivatives, value: f64, factor: f64) -> Derivatives {
        self.combined(other, value, |a, b| factor * (a - b))
    }

    fn combined(&self, other: &Derivatives, value: f64, rule: impl Fn(f64, f64) -> f64) -> Derivatives {
        let each = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| rule(*a, *b)).collect();
        Derivatives {
            value,
            thickness: each(&self.thickness, &other.thickness),
            n: each(&self.n, &other.n),
            k: each(&self.k, &other.k),
        }
    }

    /// All derivatives in one row: thicknesses, n, k.
    pub fn row(&self) -> impl Iterator<Item = f64> + '_ {
        self.thickness.iter().chain(&self.n).chain(&self.k).copied()
    }
}

/// A real value and the covector of its change: `d value = Re(slopes . d parameters)`.
#[derive(Debug, Clone)]
struct Slope {
    value: f64,
    slopes: Slopes,
}

impl Slope {
    fn constant(value: f64, media: usize) -> Slope {
        Slope { value, slopes: Slopes::zero(media) }
    }

    /// `|a|^2` where the covector of `a` is `factor * slopes`.
    fn squared(a: Complex64, factor: Complex64, slopes: &Slopes) -> Slope {
        let mut sum = Slope::constant(a.norm_sqr(), slopes.kz_squared.len());
        sum.slopes.add(2.0 * a.conj() * factor, slopes);
        sum
    }

    fn scaled(&self, factor: f64) -> Slope {
        let mut scaled = Slope::constant(factor * self.value, self.slopes.kz_squared.len());
        scaled.slopes.add(factor.into(), &self.slopes);
        scaled
    }

    fn times(&self, other: &Slope) -> Slope {
        let mut product = self.scaled(other.value);
        product.slopes.add(self.value.into(), &other.slopes);
        product
    }

    fn plus(&self, other: &Slope) -> Slope {
        let mut sum = self.clone();
        sum.value += other.value;
        sum.slopes.add(1.0.into(), &other.slopes);
        sum
    }

    /// `1 / (1 - self)`.
    fn bounced(&self) -> Slope {
        // Between two perfect mirrors this rounds to 0; then no light gets in either.
        let inverse = 1.0 / (1.0 - self.value).max(f64::EPSILON);
        let mut sum = self.scaled(inverse * inverse);
        sum.value = inverse;
        sum
    }
}

/// One stack, wavelength, direction and polarisation, made ready.
struct Problem<'a> {
    indices: &'a [Complex64],
    incidence: Incidence,
    polarization: Polarization,
    k0: f64,
    halves: Vec<Half>,
    phases: Vec<Phase>,
    k0_d: Vec<f64>,
    /// Media whose two faces add powers; as for the solver, not where there is no phase to average.
    slabs: Vec<usize>,
}

impl<'a> Problem<'a> {
    fn new(
        indices: &'a [Complex64],
        thickness_nm: &[f64],
        coherent: &[bool],
        wavelength_nm: f64,
        incidence: Incidence,
        polarization: Polarization,
    ) -> Problem<'a> {
        let k0 = TAU / wavelength_nm;
        let halves: Vec<Half> =
            indices.iter().enumerate().map(|(j, &n)| half(indices[0].re, n, j == 0, incidence, polarization)).collect();
        let k0_d: Vec<f64> = thickness_nm.iter().map(|d| k0 * d).collect();
        let phases = halves[1..].iter().zip(&k0_d).map(|(half, d)| Phase::new(half.kz_squared, *d)).collect();
        let is_slab = |j: &usize| !coherent[j - 1] && averages(indices[*j], halves[*j].kz, k0_d[j - 1]);
        let slabs = (1..=coherent.len()).filter(is_slab).collect();
        Problem { indices, incidence, polarization, k0, halves, phases, k0_d, slabs }
    }

    fn run(&self, top: usize, bottom: usize, from_below: bool) -> Result<Run, OpticsError> {
        runs::run(&self.halves, &self.phases, self.k0, (top, bottom), from_below).ok_or_else(lasing)
    }

    /// `r` and `t` alone.
    fn amplitudes(&self, top: usize, bottom: usize, from_below: bool) -> Result<(Complex64, Complex64), OpticsError> {
        let fields = runs::march(&self.halves, &self.phases, top, bottom, from_below);
        let end = fields[fields.len() - 1];
        let q = self.halves[if from_below { bottom } else { top }].q();
        let sum = q * end.pair().0 + end.pair().1;
        if sum.norm_sqr() == 0.0 || !sum.is_finite() {
            return Err(lasing());
        }
        Ok(((q * end.pair().0 - end.pair().1) / sum, 2.0 * q / sum * (-end.log).exp()))
    }

    fn coherent_powers(&self) -> Result<[Slope; 2], OpticsError> {
        let run = self.run(0, self.indices.len() - 1, false)?;
        let reflected = Slope::squared(run.r, 1.0.into(), &run.r_slopes);
        let passed = Slope::squared(run.t, run.t, &run.t_slopes);
        Ok([reflected, passed.times(&self.flux_ratio())])
    }

    /// `Re q` of the last medium over that of the first.
    fn flux_ratio(&self) -> Slope {
        let last = self.indices.len() - 1;
        let (q_first, q_last) = (self.halves[0].q().re, self.halves[last].q().re);
        let mut ratio = Slope::constant(q_last / q_first, self.indices.len());
        ratio.slopes.add_q((1.0 / q_first).into(), last, &self.halves[last]);
        ratio.slopes.add_q((-q_last / (q_first * q_first)).into(), 0, &self.halves[0]);
        ratio
    }

    /// The recursion of the solver's slabs, with derivatives.
    fn slab_powers(&self) -> Result<[Slope; 2], OpticsError> {
        let last = self.indices.len() - 1;
        let mut runs = Vec::with_capacity(self.slabs.len() + 1);
        let mut top = 0;
        for &bottom in self.slabs.iter().chain(std::iter::once(&last)) {
            runs.push((self.run(top, bottom, false)?, self.run(top, bottom, true)?));
            top = bottom;
        }
        let one = Complex64::new(1.0, 0.0);
        let below = &runs[self.slabs.len()].0;
        let mut reflected = Slope::squared(below.r, one, &below.r_slopes);
        let mut passed = Slope::squared(below.t, below.t, &below.t_slopes);
        for (m, &slab) in self.slabs.iter().enumerate().rev() {
            let (down, up) = &runs[m];
            let pass = self.slab_pass(slab);
            let round_trip = pass.times(&pass).times(&reflected);
            let escape = Slope::squared(up.r, one, &up.r_slopes).times(&round_trip).bounced();
            let into = Slope::squared(down.t, down.t, &down.t_slopes);
            let back = into.times(&Slope::squared(up.t, up.t, &up.t_slopes)).times(&round_trip).times(&escape);
            reflected = Slope::squared(down.r, one, &down.r_slopes).plus(&back);
            passed = into.times(&pass).times(&passed).times(&escape);
        }
        Ok([reflected, passed.times(&self.flux_ratio())])
    }

    /// `exp(-2 Im kz k0 d)` of a slab.
    fn slab_pass(&self, slab: usize) -> Slope {
        let half = &self.halves[slab];
        let k0_d = self.k0_d[slab - 1];
        let value = (-2.0 * half.kz.im * k0_d).exp();
        let mut pass = Slope::constant(value, self.indices.len());
        pass.slopes.thickness[slab - 1] = (-2.0 * half.kz.im * self.k0 * value).into();
        // -2 k0 d Im(dkz) = Re(2 i k0 d dkz), dkz = dX / (2 kz).
        pass.slopes.kz_squared[slab] = I * k0_d * value / half.kz;
        pass
    }

    /// From `X`, `W` and thickness to thickness, n and k.
    fn real(&self, slope: &Slope) -> Result<Derivatives, OpticsError> {
        let (media, by) = (self.indices.len(), &slope.slopes);
        let is_p = self.polarization == Polarization::P;
        let n_first = self.indices[0].re;
        let cos_squared = self.incidence.cos_theta().powi(2);
        let mut by_first = 2.0 * n_first * by.kz_squared[0].re * cos_squared;
        if is_p {
            by_first += 2.0 * n_first * by.weight[0].re;
        }
        let mut n = vec![0.0; media];
        let mut k = vec![0.0; media - 1];
        for j in 1..media {
            // kz^2 = n^2 - (n_first sin)^2
            by_first -= 2.0 * n_first * self.incidence.sin_theta().powi(2) * by.kz_squared[j].re;
            let by_square = by.kz_squared[j] + if is_p { by.weight[j] } else { 0.0.into() };
            let by_index = 2.0 * self.indices[j] * by_square;
            n[j] = by_index.re;
            k[j - 1] = -by_index.im;
        }
        n[0] = by_first;
        let found = Derivatives { value: slope.value, thickness: by.thickness.iter().map(|d| d.re).collect(), n, k };
        if found.row().all(f64::is_finite) {
            return Ok(found);
        }
        Err(OpticsError::Argument(
            "there are no derivatives exactly at the critical angle of the last medium or of a slab".into(),
        ))
    }
}

pub(super) fn half(
    n_first: f64,
    n: Complex64,
    is_first: bool,
    incidence: Incidence,
    polarization: Polarization,
) -> Half {
    let weight = if polarization == Polarization::P { n * n } else { Complex64::new(1.0, 0.0) };
    if is_first {
        let kz = Complex64::new(n_first * incidence.cos_theta(), 0.0);
        return Half::new(kz * kz, kz, weight);
    }
    let kz_squared = incidence.kz_squared(n_first, n);
    Half::new(kz_squared, sqrt_upper(kz_squared), weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stack::{Solver, ellipsometry};

    fn c(re: f64, im: f64) -> Complex64 {
        Complex64::new(re, im)
    }

    /// R and T as the solver has them.
    fn powers(
        n: &[Complex64],
        d: &[f64],
        coherent: &[bool],
        incidence: Incidence,
        polarization: Polarization,
    ) -> [f64; 2] {
        let mut solver = Solver::new();
        solver.prepare(n, d, coherent, 550.0, incidence);
        let powers = solver.powers(polarization).unwrap();
        [powers.reflectance, powers.transmittance]
    }

    /// Richardson's rule from central differences: error of order step^4.
    fn slope(f: impl Fn(f64) -> f64, step: f64) -> f64 {
        let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
        (4.0 * central(0.5 * step) - central(step)) / 3.0
    }

    type Case = (Vec<Complex64>, Vec<f64>, Vec<bool>);

    fn cases() -> Vec<Case> {
        vec![
            (vec![c(1.0, 0.0), c(1.33, 0.0), c(1.0, 0.0)], vec![320.0], vec![true]),
            (vec![c(1.0, 0.0), c(2.3, 0.05), c(1.46, 0.0), c(4.0, 0.03)], vec![60.0, 210.0], vec![true; 2]),
            (vec![c(1.5, 0.0), c(0.06, 3.6), c(1.0, 0.0), c(1.7, 0.2)], vec![30.0, 500.0], vec![true; 2]),
            (vec![c(1.0, 0.0), c(2.0, 0.01), c(1.5, 1e-6), c(1.0, 0.0)], vec![150.0, 2e4], vec![true, false]),
            (
                vec![c(1.2, 0.0), c(2.0, 0.0), c(1.5, 2e-6), c(1.38, 0.0), c(1.6, 1e-6), c(1.9, 0.2), c(1.1, 0.0)],
                vec![150.0, 2e4, 90.0, 1.3e4, 40.0],
                vec![true, false, true, false, true],
            ),
            (vec![c(1.0, 0.0), c(1.4, 0.0), c(1.5, 0.0)], vec![0.0], vec![true]),
        ]
    }

    #[test]
    fn powers_change_as_differences_say() {
        let mut worst = 0.0_f64;
        for (n, d, coherent) in cases() {
            for angle in [0.0, 31.0, 58.0] {
                let incidence = Incidence::from_degrees(angle).unwrap();
                for polarization in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
                    let found = power_derivatives(&n, &d, &coherent, 550.0, incidence, polarization).unwrap();
                    let plain = powers(&n, &d, &coherent, incidence, polarization);
                    for (which, derivatives) in found.iter().enumerate() {
                        assert!((derivatives.value - plain[which]).abs() < 1e-13);
                        let mut compare = |got: f64, wanted: f64, what: &str| {
                            let error = (got - wanted).abs() / (1.0 + wanted.abs());
                            assert!(error < 2e-8, "{what} {got} {wanted} {n:?} {angle} {polarization:?} {which}");
                            worst = worst.max(error);
                        };
                        for j in 0..d.len() {
                            let at = |step: f64| {
                                let mut moved = d.clone();
                                moved[j] += step;
                                powers(&n, &moved, &coherent, incidence, polarization)[which]
                            };
                            if d[j] > 0.0 {
                                compare(derivatives.thickness[j], slope(at, 0.05), "thickness");
                            }
                        }
                        for j in 0..n.len() {
                            let at = |step: Complex64| {
                                let mut moved = n.clone();
                                moved[j] += step;
                                powers(&moved, &d, &coherent, incidence, polarization)[which]
                            };
                            compare(derivatives.n[j], slope(|h| at(c(h, 0.0)), 1e-4), "n");
                            // k of a clear slab cannot be moved below 0.
                            if j > 0 && (j > coherent.len() || coherent[j - 1]) && n[j].im > 1e-3 {
                                compare(derivatives.k[j - 1], slope(|h| at(c(0.0, h)), 1e-4), "k");
                            }
                        }
                    }
                }
            }
        }
        println!("worst {worst:e}");
    }

    #[test]
    fn psi_and_delta_change_as_differences_say() {
        for (n, d, coherent) in cases().into_iter().filter(|case| case.2.iter().all(|flag| *flag)) {
            if d[0] == 0.0 {
                continue;
            }
            let incidence = Incidence::from_degrees(52.0).unwrap();
            let angles = |n: &[Complex64], d: &[f64]| {
                let mut solver = Solver::new();
                solver.prepare(n, d, &coherent, 550.0, incidence);
                let r_s = solver.amplitudes(Polarization::S).unwrap().r;
                let r_p = solver.amplitudes(Polarization::P).unwrap().r;
                let (psi, delta) = ellipsometry(r_s, r_p).unwrap();
                [psi, delta]
            };
            let found = ellipsometry_derivatives(&n, &d, 550.0, incidence).unwrap();
            for (which, derivatives) in found.iter().enumerate() {
                for j in 0..d.len() {
                    let at = |step: f64| {
                        let mut moved = d.clone();
                        moved[j] += step;
                        angles(&n, &moved)[which]
                    };
                    let wanted = slope(at, 0.05);
                    assert!((derivatives.thickness[j] - wanted).abs() < 1e-7 * (1.0 + wanted.abs()));
                }
                for j in 1..n.len() {
                    for (step, got) in [(c(1e-4, 0.0), derivatives.n[j]), (c(0.0, 1e-4), derivatives.k[j - 1])] {
                        if step.im > 0.0 && j == n.len() - 1 && n[j].im == 0.0 {
                            continue; // k < 0 of the last medium would be gain
                        }
                        let at = |h: f64| {
                            let mut moved = n.clone();
                            moved[j] += step / 1e-4 * h;
                            angles(&moved, &d)[which]
                        };
                        let wanted = slope(at, 1e-4);
                        assert!((got - wanted).abs() < 1e-6 * (1.0 + wanted.abs()), "{j} {got} {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_layer_is_a_ratio_of_its_round_trip() {
        let (n, d) = (vec![c(1.0, 0.0), c(2.3, 0.05), c(1.46, 0.002), c(4.0, 0.03)], [60.0, 210.0]);
        for polarization in [Polarization::S, Polarization::P] {
            let incidence = Incidence::from_degrees(40.0).unwrap();
            for layer in 0..2 {
                let airy = layer_airy(&n, &d, 550.0, incidence, polarization, layer).unwrap();
                let z = (2.0 * I * airy.kz * TAU * d[layer] / 550.0).exp();
                let loop_ = airy.r_inside * airy.r_below * z;
                let r = airy.r_above + airy.t_above_squared * airy.r_below * z / (1.0 - loop_);
                let passed = airy.passed * z.norm() / (1.0 - loop_).norm_sqr();
                let [wanted_r, wanted_t] = powers(&n, &d, &[true; 2], incidence, polarization);
                assert!((r.norm_sqr() - wanted_r).abs() < 1e-14 && (passed - wanted_t).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn deep_in_a_mirror_and_behind_metal() {
        let (high, low) = (c(2.35, 0.0), c(1.38, 0.0));
        let mut n = vec![c(1.0, 0.0)];
        let mut d = Vec::new();
        for _ in 0..150 {
            n.extend([high, low]);
            d.extend([550.0 / 4.0 / 2.35, 550.0 / 4.0 / 1.38]);
        }
        n.push(c(1.52, 0.0));
        let incidence = Incidence::from_cos(1.0).unwrap();
        let [r, t] = power_derivatives(&n, &d, &vec![true; 300], 550.0, incidence, Polarization::S).unwrap();
        assert!((r.value - 1.0).abs() < 1e-13 && t.value > 0.0 && t.value < 1e-60);
        // Relative change of T: differences of ln T, which the solver has to full precision.
        let ln_t = |step: f64| {
            let mut moved = d.clone();
            moved[299] += step;
            powers(&n, &moved, &vec![true; 300], incidence, Polarization::S)[1].ln()
        };
        assert!((t.thickness[299] / t.value - slope(ln_t, 0.05)).abs() < 1e-8);
        let metal = [c(1.0, 0.0), c(0.05, 3.9), c(1.5, 0.0)];
        let [r, t] = power_derivatives(&metal, &[1e7], &[true], 550.0, incidence, Polarization::S).unwrap();
        assert_eq!((t.value, t.thickness[0]), (0.0, 0.0));
        assert!(r.thickness[0].abs() < 1e-15);
    }
}
