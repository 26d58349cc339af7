//! How likely a measured curve is if a film has a certain spectrum, the lamp, the stray light and the noise being unknown.
//!
//! For a film whose spectrum is R(l),
//!
//! ```text
//! y(l) = g (1 + level u + bend p(l)) R(l) + g stray (v + drift q(l)) + noise
//! ```
//!
//! with u, v normal of variance 1, p and q smooth curves of covariance exp(-(dl / length)^2 / 2), and independent noise of
//! standard deviation kappa s(l). All of it is linear in (u, p, v, q), which are integrated out in closed form (C. E. Rasmussen,
//! C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, sec. 2.7):
//!
//! ```text
//! y = g R + A theta + eps,  theta ~ N(0, 1),  B = A / (kappa s),  M = 1 + B^T B = C C^T,  z = C^-1 B^T (y - g R) / (kappa s)
//! log E = -1/2 (sum ((y - g R) / (kappa s))^2 - z.z) - sum log C_jj - sum log(kappa s) - N/2 log 2 pi
//! ```
//!
//! The term sum log C_jj is what a chi-square lacks: explanations of different freedom stand on one scale.
//!
//! All columns of A grow with g: explanations that differ in g and kappa alone have M = 1 + (g / kappa)^2 K with one K, which is
//! made tridiagonal once for all of them.

use fearless_simd::{Simd, dispatch};
use iridesce_numerics::{Watch, simd};
use rayon::prelude::*;

use crate::cholesky::{backward, dots, factor, forward};
use crate::tridiagonal::Tridiagonal;
use crate::{InverseError, SmoothCurves};

/// A measured curve.
#[derive(Debug, Clone, Copy)]
pub struct Measured<'a> {
    /// The values.
    pub values: &'a [f64],
    /// Standard deviation of each, > 0.
    pub sd: &'a [f64],
}

/// How lamp, stray light and noise may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisance {
    /// Which of the smooth curves bend the response and the stray light; without effect where `bend` and `drift` are 0.
    pub curves: usize,
    /// The gain g, > 0.
    pub gain: f64,
    /// Standard deviation of the gain, of itself.
    pub level: f64,
    /// Standard deviation of the response along the wavelengths, of the gain.
    pub bend: f64,
    /// Standard deviation of the stray light, in the unit of R.
    pub stray: f64,
    /// By how much the noise is larger than stated.
    pub kappa: f64,
    /// Standard deviation of the stray light along the wavelengths, of `stray`: light through the same lamp bends as that
    /// does, a baseline that drifts does so under an even response, too.
    pub drift: f64,
}

/// What the light and the film together look like, once an explanation is taken.
#[derive(Debug, Clone)]
pub struct Explained {
    /// The response g (1 + level u + bend p).
    pub response: Vec<f64>,
    /// The stray light.
    pub stray: Vec<f64>,
}

/// The products of one spectrum with one set of curves: what all nuisances of these curves share.
struct Products {
    /// U^T W R^2 U, U^T W R U, U^T W U, row after row, whole.
    squares: [Vec<f64>; 3],
    /// U^T W R y, U^T W y.
    sides: [Vec<f64>; 2],
}

#[inline(always)]
fn products<S: Simd>(simd: S, curves: &SmoothCurves, spectrum: &[f64], of: Measured<'_>) -> Products {
    let q = curves.columns();
    let mut squares = [vec![0.0; q * q], vec![0.0; q * q], vec![0.0; q * q]];
    let mut sides = [vec![0.0; q], vec![0.0; q]];
    // W R^2 u, W R u, W u of one column u.
    let mut weighted = [vec![0.0; spectrum.len()], vec![0.0; spectrum.len()], vec![0.0; spectrum.len()]];
    for a in 0..q {
        let [film, mixed, stray] = &mut weighted;
        for (i, value) in curves.column(a).iter().enumerate() {
            stray[i] = value / (of.sd[i] * of.sd[i]);
            mixed[i] = stray[i] * spectrum[i];
            film[i] = mixed[i] * spectrum[i];
        }
        for b in 0..=a {
            let sums = dots(simd, &weighted, curves.column(b));
            for (square, sum) in squares.iter_mut().zip(sums) {
                square[a * q + b] = sum;
                square[b * q + a] = sum;
            }
        }
        let [_, first, second] = dots(simd, &weighted, of.values);
        (sides[0][a], sides[1][a]) = (first, second);
    }
    Products { squares, sides }
}

/// M = 1 + B^T B (lower triangle), B^T (y - g R) / (kappa s), the scale of each column, and its place among the curves.
struct System {
    size: usize,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Scale, whether it is stray light, and the column of the curves.
    columns: Vec<(f64, bool, usize)>,
}

#[inline(always)]
fn system(products: &Products, q: usize, of: &Nuisance) -> System {
    let used = if of.bend > 0.0 || of.drift > 0.0 { q } else { 1 };
    let mut columns = Vec::with_capacity(2 * used);
    for (is_stray, size) in [(false, of.gain), (true, of.gain * of.stray)] {
        for a in 0..used {
            let scale = size
                * match (is_stray, a) {
                    (false, 0) => of.level,
                    (false, _) => of.bend,
                    (true, 0) => 1.0,
                    (true, _) => of.drift,
                };
            if scale > 0.0 {
                columns.push((scale, is_stray, a));
            }
        }
    }
    let size = columns.len();
    let (mut matrix, mut right) = (vec![0.0; size * size], vec![0.0; size]);
    let weight = 1.0 / (of.kappa * of.kappa);
    let [film, mixed, stray] = &products.squares;
    for (row, &(scale, is_stray, a)) in columns.iter().enumerate() {
        for (column, &(other, other_is_stray, b)) in columns[..=row].iter().enumerate() {
            let square = match (is_stray, other_is_stray) {
                (false, false) => film,
                (true, true) => stray,
                _ => mixed,
            };
            matrix[row * size + column] = weight * scale * other * square[a * q + b];
        }
        matrix[row * size + row] += 1.0;
        // The columns against what is left after the mean response.
        let side = &products.sides[usize::from(is_stray)];
        let mean = if is_stray { mixed } else { film };
        right[row] = weight * scale * (side[a] - of.gain * mean[a * q]);
    }
    System { size, matrix, right, columns }
}

#[inline(always)]
fn log_evidence<S: Simd>(simd: S, products: &Products, q: usize, of: &Nuisance, sums: (f64, f64), count: usize) -> f64 {
    let mut system = system(products, q, of);
    factor(simd, &mut system.matrix, system.size);
    forward(simd, &system.matrix, system.size, &mut system.right);
    let explained: f64 = system.right.iter().map(|z| z * z).sum();
    let volume: f64 = (0..system.size).map(|j| system.matrix[j * system.size + j].ln()).sum();
    log_density(products, of, (explained, volume), sums, count)
}

/// log E from z.z and sum log C_jj, and from the sums of (y / s)^2 and log s.
#[inline(always)]
fn log_density(
    products: &Products,
    of: &Nuisance,
    (explained, volume): (f64, f64),
    (square, log_sd): (f64, f64),
    count: usize,
) -> f64 {
    let weight = 1.0 / (of.kappa * of.kappa);
    let left = square - 2.0 * of.gain * products.sides[0][0] + of.gain * of.gain * products.squares[0][0];
    let count = count as f64;
    -0.5 * (weight * left - explained).max(0.0)
        - volume
        - log_sd
        - count * of.kappa.ln()
        - 0.5 * count * (2.0 * std::f64::consts::PI).ln()
}

/// Fewer explanations than this are quicker with a factor of each.
const LEAST_SHARED: usize = 6;
/// Beyond this a factor of each loses less to rounding: 1e-16 times this many is far below a unit of the logarithm.
const LARGEST_SHARED: f64 = 1e10;

/// Nuisances that differ in gain and noise alone.
struct Shared {
    /// The nuisance of gain 1 and kappa 1.
    of: Nuisance,
    places: Vec<usize>,
}

/// Groups of all nuisances, in the order of their first.
fn shared(nuisances: &[Nuisance]) -> Vec<Shared> {
    let mut groups: Vec<Shared> = Vec::new();
    for (place, one) in nuisances.iter().enumerate() {
        let of = Nuisance { gain: 1.0, kappa: 1.0, ..*one };
        match groups.iter_mut().find(|group| group.of == of) {
            Some(group) => group.places.push(place),
            None => groups.push(Shared { of, places: vec![place] }),
        }
    }
    groups
}

/// What is left of a spectrum's numbers once a group has made its K tridiagonal.
#[inline(always)]
fn tridiagonal<S: Simd>(simd: S, products: &Products, q: usize, of: &Nuisance) -> Tridiagonal<2> {
    let System { size, mut matrix, columns, .. } = system(products, q, of);
    (0..size).for_each(|i| matrix[i * size + i] -= 1.0);
    // The columns against the data, and against the mean response.
    let [film, mixed, _] = &products.squares;
    let measured = columns.iter().map(|&(scale, stray, a)| scale * products.sides[usize::from(stray)][a]).collect();
    let mean = columns.iter().map(|&(scale, stray, a)| scale * if stray { mixed } else { film }[a * q]).collect();
    Tridiagonal::new(simd, &mut matrix, size, [measured, mean])
}

/// One spectrum under all nuisances.
#[inline(always)]
fn row<S: Simd>(
    simd: S,
    of: Measured<'_>,
    spectrum: &[f64],
    curves: &[SmoothCurves],
    (nuisances, groups): (&[Nuisance], &[Shared]),
    (square, log_sd): (f64, f64),
    out: &mut [f64],
) {
    let mut made: Vec<Option<Products>> = (0..curves.len()).map(|_| None).collect();
    let count = of.values.len();
    for group in groups {
        let curve = &curves[group.of.curves];
        // (A closure would be compiled for any processor.)
        if made[group.of.curves].is_none() {
            made[group.of.curves] = Some(products(simd, curve, spectrum, of));
        }
        let products = made[group.of.curves].as_ref().expect("made above");
        let q = curve.columns();
        let walk =
            if group.places.len() < LEAST_SHARED { None } else { Some(tridiagonal(simd, products, q, &group.of)) };
        let bound = walk.as_ref().map_or(f64::INFINITY, Tridiagonal::bound);
        for &place in &group.places {
            let one = &nuisances[place];
            let weight = 1.0 / (one.kappa * one.kappa);
            let growth = one.gain * one.gain * weight;
            out[place] = match &walk {
                Some(walk) if growth * bound < LARGEST_SHARED => {
                    let part = one.gain * weight;
                    let (volume, explained) = walk.solved(growth, [part, -part * one.gain]);
                    log_density(products, one, (explained, 0.5 * volume), (square, log_sd), count)
                }
                _ => log_evidence(simd, products, q, one, (square, log_sd), count),
            };
        }
    }
}

fn check(
    of: Measured<'_>,
    spectrum_length: usize,
    curves: &[SmoothCurves],
    nuisances: &[Nuisance],
) -> Result<(), InverseError> {
    let count = of.values.len();
    let refuse = |words: String| Err(InverseError::Argument(words));
    if count == 0 || of.sd.len() != count || !spectrum_length.is_multiple_of(count) {
        return refuse(format!(
            "values, sd and spectra must be of one length, got {count}, {} and {spectrum_length} in all",
            of.sd.len()
        ));
    }
    if let Some(one) = of.sd.iter().find(|sd| !(**sd > 0.0 && sd.is_finite())) {
        return refuse(format!("sd must be > 0 and finite, got {one}"));
    }
    if let Some(one) = curves.iter().find(|one| one.channels() != count) {
        return refuse(format!("curves of {} channels for {count}", one.channels()));
    }
    let good = |n: &Nuisance| {
        n.curves < curves.len()
            && n.gain > 0.0
            && n.kappa > 0.0
            && [n.gain, n.kappa, n.level, n.bend, n.stray, n.drift].iter().all(|v| *v >= 0.0 && v.is_finite())
    };
    match nuisances.iter().find(|one| !good(one)) {
        Some(one) => refuse(format!("gain and kappa must be > 0, all others >= 0, curves known, got {one:?}")),
        None => Ok(()),
    }
}

/// log E of each spectrum (rows) under each nuisance.
///
/// `spectra` holds R, channel after channel, spectrum after spectrum. The answer has a row a spectrum, and is the same for
/// any number of threads.
pub fn log_evidences(
    of: Measured<'_>,
    spectra: &[f64],
    curves: &[SmoothCurves],
    nuisances: &[Nuisance],
    watch: &Watch,
) -> Result<Vec<f64>, InverseError> {
    check(of, spectra.len(), curves, nuisances)?;
    let count = of.values.len();
    let square: f64 = of.values.iter().zip(of.sd).map(|(y, s)| (y / s) * (y / s)).sum();
    let log_sd: f64 = of.sd.iter().map(|s| s.ln()).sum();
    let level = simd::level_or_best();
    let groups = shared(nuisances);
    let mut out = vec![0.0; spectra.len() / count * nuisances.len()];
    out.par_chunks_exact_mut(nuisances.len().max(1)).zip(spectra.par_chunks_exact(count)).try_for_each(
        |(out, spectrum)| {
            watch.check()?;
            dispatch!(level, simd => row(simd, of, spectrum, curves, (nuisances, &groups), (square, log_sd), out));
            watch.add(1);
            Ok::<(), InverseError>(())
        },
    )?;
    Ok(out)
}

/// The response and the stray light that one explanation takes: the means of their posterior.
pub fn explain(
    of: Measured<'_>,
    spectrum: &[f64],
    curves: &[SmoothCurves],
    nuisance: &Nuisance,
) -> Result<Explained, InverseError> {
    check(of, spectrum.len(), curves, std::slice::from_ref(nuisance))?;
    let curve = &curves[nuisance.curves];
    let q = curve.columns();
    let mut system = dispatch!(simd::level_or_best(), simd => {
        let mut system = system(&products(simd, curve, spectrum, of), q, nuisance);
        factor(simd, &mut system.matrix, system.size);
        forward(simd, &system.matrix, system.size, &mut system.right);
        system
    });
    backward(&system.matrix, system.size, &mut system.right);
    let (mut response, mut stray) = (vec![nuisance.gain; of.values.len()], vec![0.0; of.values.len()]);
    for (&(scale, is_stray, a), theta) in system.columns.iter().zip(&system.right) {
        let sum = if is_stray { &mut stray } else { &mut response };
        sum.iter_mut().zip(curve.column(a)).for_each(|(sum, value)| *sum += scale * theta * value);
    }
    Ok(Explained { response, stray })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// log N(y; g R, Sigma) with Sigma written out whole: another road to the same number.
    fn whole(of: Measured<'_>, spectrum: &[f64], nm: &[f64], length: f64, n: &Nuisance) -> f64 {
        let count = of.values.len();
        let mut sigma = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                let k = (-0.5 * ((nm[i] - nm[j]) / length).powi(2)).exp();
                let (bend, drift) = (n.bend * n.bend * k, n.drift * n.drift * k);
                sigma[i * count + j] = n.gain
                    * n.gain
                    * (spectrum[i] * spectrum[j] * (n.level * n.level + bend) + n.stray * n.stray * (1.0 + drift));
            }
            sigma[i * count + i] += (n.kappa * of.sd[i]).powi(2);
        }
        let mut log_det = 0.0;
        let mut right: Vec<f64> = (0..count).map(|i| of.values[i] - n.gain * spectrum[i]).collect();
        // `factor` holds pivots above 1/2: bring the diagonal there.
        let scale = 1e4;
        sigma.iter_mut().for_each(|v| *v *= scale);
        dispatch!(simd::level_or_best(), simd => factor(simd, &mut sigma, count));
        (0..count).for_each(|i| log_det += sigma[i * count + i].ln() - 0.5 * scale.ln());
        dispatch!(simd::level_or_best(), simd => forward(simd, &sigma, count, &mut right));
        let square: f64 = right.iter().map(|z| z * z * scale).sum();
        -0.5 * square - log_det - 0.5 * count as f64 * (2.0 * std::f64::consts::PI).ln()
    }

    #[test]
    fn closed_form_is_the_normal_density_of_the_whole_covariance() {
        let nm: Vec<f64> = (0..40).map(|i| 450.0 + 9.0 * f64::from(i)).collect();
        let spectrum: Vec<f64> = nm.iter().map(|l| 0.2 + 0.15 * (9000.0 / l).cos()).collect();
        let values: Vec<f64> =
            nm.iter().zip(&spectrum).map(|(l, r)| 1.1 * r * (1.0 + 0.1 * (l / 40.0).sin()) + 0.01).collect();
        let sd: Vec<f64> = nm.iter().map(|l| 0.02 + 1e-5 * l).collect();
        let of = Measured { values: &values, sd: &sd };
        for (length, bend, stray, level, drift) in [
            (50.0, 0.3, 0.05, 0.2, 0.3),
            (120.0, 0.1, 0.0, 0.1, 0.1),
            (50.0, 0.0, 0.05, 0.3, 0.0),
            (200.0, 0.0, 0.05, 0.3, 0.5),
            (120.0, 0.03, 0.05, 0.0, 0.5),
            (20.0, 0.0, 0.0, 0.0, 0.0),
        ] {
            let curves = [SmoothCurves::new(&nm, length).unwrap()];
            let nuisance = Nuisance { curves: 0, gain: 1.0, level, bend, stray, kappa: 1.3, drift };
            let got = log_evidences(of, &spectrum, &curves, &[nuisance], &Watch::new()).unwrap()[0];
            let wanted = whole(of, &spectrum, &nm, length, &nuisance);
            assert!((got - wanted).abs() < 2e-3, "{length} {bend}: {got} {wanted}");
        }
    }

    #[test]
    fn explanations_that_share_a_walk_are_as_likely_as_each_alone() {
        let nm: Vec<f64> = (0..160).map(|i| 450.0 + 2.5 * f64::from(i)).collect();
        let spectrum: Vec<f64> = nm.iter().map(|l| 0.2 + 0.15 * (40_000.0 / l).cos()).collect();
        let values: Vec<f64> =
            nm.iter().zip(&spectrum).map(|(l, r)| 1.1 * r * (1.0 + 0.1 * (l / 40.0).sin()) + 0.01).collect();
        // From plain noise to exact data, which no walk may spoil.
        for noise in [3e-2, 1e-3, 1e-6] {
            let sd = vec![noise; nm.len()];
            let of = Measured { values: &values, sd: &sd };
            let curves = [SmoothCurves::new(&nm, 50.0).unwrap(), SmoothCurves::new(&nm, 20.0).unwrap()];
            let mut nuisances = Vec::new();
            for (curves, bend, drift) in [(0, 0.3, 0.3), (1, 0.05, 0.5), (0, 0.0, 0.0)] {
                for gain in [0.3, 1.0, 3.0] {
                    for kappa in [1.0, 3.0, 10.0] {
                        nuisances.push(Nuisance { curves, gain, level: 0.3, bend, stray: 0.05, kappa, drift });
                    }
                }
            }
            let together = log_evidences(of, &spectrum, &curves, &nuisances, &Watch::new()).unwrap();
            for (one, got) in nuisances.iter().zip(together) {
                let wanted = log_evidences(of, &spectrum, &curves, &[*one], &Watch::new()).unwrap()[0];
                assert!((got - wanted).abs() < 1e-4 + 1e-9 * wanted.abs(), "{noise} {one:?}: {got} {wanted}");
            }
        }
    }

    #[test]
    fn a_response_is_found_where_the_film_is_known() {
        let nm: Vec<f64> = (0..200).map(|i| 450.0 + 2.0 * f64::from(i)).collect();
        let spectrum: Vec<f64> = nm.iter().map(|l| 0.2 + 0.15 * (40_000.0 / l).cos()).collect();
        let lamp = |l: f64| 2.0 * (1.0 + 0.2 * ((l - 620.0) / 60.0).sin());
        let values: Vec<f64> = nm.iter().zip(&spectrum).map(|(l, r)| lamp(*l) * r + 0.05).collect();
        let sd = vec![1e-3; nm.len()];
        let curves = [SmoothCurves::new(&nm, 50.0).unwrap()];
        let nuisance = Nuisance { curves: 0, gain: 2.0, level: 0.3, bend: 0.3, stray: 0.1, kappa: 1.0, drift: 0.3 };
        let found = explain(Measured { values: &values, sd: &sd }, &spectrum, &curves, &nuisance).unwrap();
        for (i, l) in nm.iter().enumerate().skip(10).take(180) {
            assert!((found.response[i] / lamp(*l) - 1.0).abs() < 0.02, "{l}: {} {}", found.response[i], lamp(*l));
            assert!((found.stray[i] - 0.05).abs() < 6e-3, "{l}: {}", found.stray[i]);
        }
    }

    #[test]
    fn what_cannot_be_asked_is_refused_and_what_is_stopped_stops() {
        let (values, sd) = ([1.0, 2.0], [0.1, 0.1]);
        let curves = [SmoothCurves::new(&[500.0, 510.0], 50.0).unwrap()];
        let nuisance = Nuisance { curves: 0, gain: 1.0, level: 0.0, bend: 0.0, stray: 0.0, kappa: 1.0, drift: 0.0 };
        let of = Measured { values: &values, sd: &sd };
        let bad = Nuisance { gain: -1.0, ..nuisance };
        assert!(log_evidences(of, &[0.1, 0.2], &curves, &[bad], &Watch::new()).is_err());
        assert!(log_evidences(of, &[0.1, 0.2, 0.3], &curves, &[nuisance], &Watch::new()).is_err());
        let zero = Measured { values: &values, sd: &[0.0, 0.1] };
        assert!(log_evidences(zero, &[0.1, 0.2], &curves, &[nuisance], &Watch::new()).is_err());
        let watch = Watch::new();
        watch.stop();
        let stopped = log_evidences(of, &[0.1, 0.2], &curves, &[nuisance], &watch);
        assert_eq!(stopped, Err(InverseError::Stopped(iridesce_numerics::Stopped)));
    }
}
