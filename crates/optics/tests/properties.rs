//! What must hold for every stack, over 10^5 random ones with wide ranges of everything.

mod random;

use iridesce_optics::incidence::Incidence;
use iridesce_optics::stack::{self, Solver};
use iridesce_optics::{Complex64, Polarization};
use random::Random;

#[derive(Debug, Clone)]
struct Problem {
    n: Vec<Complex64>,
    d_nm: Vec<f64>,
    coherent: Vec<bool>,
    wavelength_nm: f64,
    angle_deg: f64,
}

/// Thicknesses are multiples of 2^-20 nm, so that splitting them is exact.
fn on_grid(thickness_nm: f64) -> f64 {
    (thickness_nm * 1_048_576.0).round() / 1_048_576.0
}

impl Problem {
    fn random(random: &mut Random, most_layers: u64, thickest_nm: f64) -> Problem {
        let index = |random: &mut Random| match random.below(6) {
            0 => Complex64::new(random.between(1.0, 3.0), random.decades(1e-10, 1e-2)),
            1 => Complex64::new(random.between(0.02, 4.0), random.between(0.0, 8.0)),
            2 => Complex64::new(0.0, random.decades(1e-2, 10.0)),
            3 => Complex64::new(random.decades(0.01, 1.0), random.decades(1e-6, 1.0)),
            _ => Complex64::new(random.between(0.3, 5.0), 0.0),
        };
        let layers = random.below(most_layers + 1) as usize;
        let first = Complex64::new(random.between(0.5, 4.0), 0.0);
        let mut n = vec![first];
        let mut d_nm = Vec::new();
        for _ in 0..layers {
            n.push(if random.one_in(8) { first } else { index(random) });
            d_nm.push(if random.one_in(10) { 0.0 } else { on_grid(random.decades(1e-3, thickest_nm)) });
        }
        n.push(if random.one_in(8) { first } else { index(random) });
        let angle_deg = match random.below(4) {
            0 => 0.0,
            1 => (90.0 - random.decades(1e-9, 10.0)).min(89.999_999_999),
            _ => random.between(0.0, 89.0),
        };
        Problem { n, coherent: vec![true; layers], d_nm, wavelength_nm: random.decades(100.0, 20_000.0), angle_deg }
    }

    fn incidence(&self) -> Incidence {
        Incidence::from_degrees(self.angle_deg).unwrap()
    }

    /// R, T, and the absorptance of each layer.
    fn solve(&self, solver: &mut Solver, polarization: Polarization) -> (f64, f64, Vec<f64>) {
        stack::check(&self.n, &self.d_nm, &self.coherent, self.wavelength_nm).unwrap();
        solver.prepare(&self.n, &self.d_nm, &self.coherent, self.wavelength_nm, self.incidence());
        let mut layers = vec![0.0; self.d_nm.len()];
        let powers = solver.powers_and_layers(polarization, &mut layers).unwrap();
        (powers.reflectance, powers.transmittance, layers)
    }
}

const BOTH: [Polarization; 2] = [Polarization::S, Polarization::P];

#[test]
fn energy_is_shared_out() {
    let mut random = Random::new(1);
    let mut solver = Solver::new();
    let mut worst = 0.0_f64;
    for _ in 0..100_000 {
        let problem = Problem::random(&mut random, 10, 1e6);
        for polarization in BOTH {
            let (r, t, layers) = problem.solve(&mut solver, polarization);
            assert!((0.0..=1.0).contains(&r) && (0.0..=1.0 + 1e-12).contains(&t), "R {r} T {t} {problem:?}");
            assert!(layers.iter().all(|a| *a >= -1e-12 && *a <= 1.0 + 1e-12), "{layers:?} {problem:?}");
            let error = (r + t + layers.iter().sum::<f64>() - 1.0).abs();
            assert!(error <= 1e-12, "R + T + A - 1 = {error:e} {problem:?}");
            worst = worst.max(error);
        }
    }
    println!("worst |R + T + A - 1| {worst:e}");
}

#[test]
fn splitting_a_layer_changes_nothing() {
    let mut random = Random::new(2);
    let mut solver = Solver::new();
    let mut worst = 0.0_f64;
    for _ in 0..50_000 {
        let problem = Problem::random(&mut random, 6, 1e4);
        if problem.d_nm.is_empty() {
            continue;
        }
        let j = random.below(problem.d_nm.len() as u64) as usize;
        let part = on_grid(problem.d_nm[j] * random.unit());
        let mut split = problem.clone();
        split.d_nm[j] = part;
        split.d_nm.insert(j + 1, problem.d_nm[j] - part);
        split.n.insert(j + 1, problem.n[j + 1]);
        split.coherent.insert(j + 1, true);
        for polarization in BOTH {
            let (r, t, layers) = problem.solve(&mut solver, polarization);
            let (split_r, split_t, split_layers) = split.solve(&mut solver, polarization);
            let mut error = (r - split_r).abs().max((t - split_t).abs());
            error = error.max((layers[j] - split_layers[j] - split_layers[j + 1]).abs());
            assert!(error <= 1e-11, "{error:e} {problem:?}");
            worst = worst.max(error);
        }
    }
    println!("worst change by splitting {worst:e}");
}

#[test]
fn transmittance_is_the_same_from_both_sides() {
    let mut random = Random::new(3);
    let mut solver = Solver::new();
    let mut worst = 0.0_f64;
    for _ in 0..50_000 {
        let mut problem = Problem::random(&mut random, 8, 1e4);
        let last = problem.n.len() - 1;
        problem.n[last] = problem.n[0];
        let mut turned = problem.clone();
        turned.n.reverse();
        turned.d_nm.reverse();
        for polarization in BOTH {
            let (_, t, _) = problem.solve(&mut solver, polarization);
            let (_, back, _) = turned.solve(&mut solver, polarization);
            if t > 1e-300 {
                let error = (t / back - 1.0).abs();
                assert!(error < 1e-11 || (t - back).abs() < 1e-14, "T {t:e} and {back:e} {problem:?}");
                worst = worst.max(error);
            }
        }
    }
    println!("worst relative difference of T from both sides {worst:e}");
}

#[test]
fn slabs_conserve_energy_and_agree_with_the_phase_mean() {
    let mut random = Random::new(4);
    let mut solver = Solver::new();
    for _ in 0..50_000 {
        let mut problem = Problem::random(&mut random, 8, 1e4);
        for j in 0..problem.d_nm.len() {
            // Where a wave decays within a turn, the mean over phases is of no real slab: thick ones here.
            if random.one_in(3) {
                problem.coherent[j] = false;
                problem.d_nm[j] = on_grid(random.decades(1e5, 1e7));
                problem.n[j + 1] = match random.below(3) {
                    0 => Complex64::new(random.between(1.0, 2.5), random.decades(1e-9, 1e-6)),
                    _ => Complex64::new(random.between(0.5, 2.5), 0.0),
                };
            }
        }
        for polarization in BOTH {
            let (r, t, layers) = problem.solve(&mut solver, polarization);
            assert!((0.0..=1.0).contains(&r) && (0.0..=1.0 + 1e-9).contains(&t), "R {r} T {t} {problem:?}");
            let error = (r + t + layers.iter().sum::<f64>() - 1.0).abs();
            assert!(error <= 1e-12, "R + T + A - 1 = {error:e} {problem:?}");
        }
    }
}

#[test]
fn slab_is_the_mean_over_its_phase() {
    // A coated slab between unlike media: the mean of the coherent result over one fringe, 64 thicknesses.
    let n = [1.0, 2.2, 1.5, 1.38, 1.2].map(|n| Complex64::new(n, 0.0));
    let incidence = Incidence::from_degrees(35.0).unwrap();
    let kz = incidence.kz_squared(1.0, n[2]).re.sqrt();
    let fringe = 550.0 / (2.0 * kz);
    let mut solver = Solver::new();
    for polarization in BOTH {
        solver.prepare(&n, &[70.0, 2e4, 95.0], &[true, false, true], 550.0, incidence);
        let slab = solver.powers(polarization).unwrap();
        let mut mean = 0.0;
        for step in 0..64 {
            let d = [70.0, 2e4 + fringe * f64::from(step) / 64.0, 95.0];
            solver.prepare(&n, &d, &[true; 3], 550.0, incidence);
            mean += solver.powers(polarization).unwrap().reflectance / 64.0;
        }
        assert!((slab.reflectance - mean).abs() < 1e-13, "{} {mean}", slab.reflectance);
    }
    // Bare slab: R = 2 r0/(1 + r0).
    let n = [1.0, 1.5, 1.0].map(|n| Complex64::new(n, 0.0));
    let response = stack::solve(&n, &[1e6], &[false], 550.0, 1.0, Polarization::S).unwrap();
    assert!((response.reflectance - 0.08 / 1.04).abs() < 1e-15);
}

#[test]
fn slabs_beyond_the_critical_angle() {
    let c = Complex64::new;
    for k in [0.0, 1e-9, 1e-3] {
        for polarization in BOTH {
            // A thick air slab between prisms lets nothing through; a thin one is frustrated as if coherent.
            let n = [c(1.5, 0.0), c(1.0, k), c(1.5, 0.0)];
            let thick = stack::solve_angle(&n, &[1e6], &[false], 550.0, 60.0, polarization).unwrap();
            assert_eq!(thick.transmittance, 0.0);
            assert!(thick.reflectance <= 1.0 && thick.reflectance > 0.99);
            let thin = stack::solve_angle(&n, &[100.0], &[false], 550.0, 60.0, polarization).unwrap();
            let coherent = stack::solve_angle(&n, &[100.0], &[true], 550.0, 60.0, polarization).unwrap();
            assert_eq!(thin.reflectance, coherent.reflectance);
        }
    }
    // Total reflection at the back of a slab with an absorbing coat in front: no NaN, all accounted for.
    let n = [c(1.7, 0.0), c(0.3, 3.0), c(1.6, 0.0), c(1.0, 0.0)];
    let response = stack::solve_angle(&n, &[20.0, 1e6], &[true, false], 550.0, 55.0, Polarization::P).unwrap();
    assert_eq!(response.transmittance, 0.0);
    assert!(response.reflectance > 0.0 && response.reflectance < 1.0);
    // Light trapped between two perfect mirrors: 0/0 in the sum of bounces.
    let n = [c(1.5, 0.0), c(1.0, 0.0), c(1.5, 0.0), c(1.0, 0.0)];
    let response = stack::solve_angle(&n, &[1e6, 1e6], &[true, false], 550.0, 60.0, Polarization::S).unwrap();
    assert!((response.reflectance - 1.0).abs() < 1e-15 && response.transmittance == 0.0);
}

#[test]
fn s_and_p_agree_at_normal_incidence() {
    let mut random = Random::new(5);
    let mut solver = Solver::new();
    for _ in 0..20_000 {
        let mut problem = Problem::random(&mut random, 8, 1e4);
        problem.angle_deg = 0.0;
        let (s_r, s_t, _) = problem.solve(&mut solver, Polarization::S);
        let (p_r, p_t, _) = problem.solve(&mut solver, Polarization::P);
        assert!((s_r - p_r).abs() < 1e-12 && (s_t - p_t).abs() < 1e-12, "{problem:?}");
        let s = solver.amplitudes(Polarization::S).unwrap();
        let p = solver.amplitudes(Polarization::P).unwrap();
        assert!((s.r + p.r).norm() < 1e-12, "r_p = -r_s: {problem:?}");
        assert!((s.t - p.t).norm() <= 1e-11 * (1.0 + s.t.norm()), "{problem:?}");
    }
}

#[test]
fn film_in_closed_form_is_the_stack() {
    let mut random = Random::new(6);
    for _ in 0..20_000 {
        let mut problem = Problem::random(&mut random, 1, 1e4);
        problem.n.truncate(2);
        problem.n.resize(3, Complex64::new(random.between(0.3, 4.0), 0.0));
        problem.d_nm = vec![random.decades(1.0, 1e4)];
        let cos = problem.incidence().cos_theta();
        for polarization in BOTH {
            let n = [problem.n[0], problem.n[1], problem.n[2]];
            let Ok(film) = iridesce_optics::film::airy(n, problem.d_nm[0], problem.wavelength_nm, cos, polarization)
            else {
                continue;
            };
            let d = &problem.d_nm;
            let stack = stack::solve(&n, d, &[true], problem.wavelength_nm, cos, polarization).unwrap();
            assert!((film.reflectance - stack.reflectance).abs() < 1e-11, "{problem:?}");
            assert!((film.transmittance - stack.transmittance).abs() < 1e-11, "{problem:?}");
            assert!((film.amplitudes.r - stack.amplitudes.unwrap().r).norm() < 1e-11, "{problem:?}");
        }
    }
}

#[test]
fn extremes_stay_finite() {
    let c = Complex64::new;
    let indices = [c(1e-12, 0.0), c(1e-3, 1e-9), c(1.0, 0.0), c(1.0, 3e-8), c(3.5, 2.7), c(0.0, 5.0), c(5e11, 5e11)];
    let thicknesses = [0.0, 5e-324, 1e-300, 1e-8, 1.0, 1e5, 1e20, 1e30];
    let mut solver = Solver::new();
    for a in indices {
        for b in indices {
            for last in indices {
                for (d1, d2) in thicknesses.iter().flat_map(|&d1| thicknesses.iter().map(move |&d2| (d1, d2))) {
                    for first in [1e-12, 1.0, 1e12] {
                        for angle_deg in [0.0, 45.0, 90.0_f64.next_down()] {
                            let problem = Problem {
                                n: vec![c(first, 0.0), a, b, last],
                                d_nm: vec![d1, d2],
                                coherent: vec![true, true],
                                wavelength_nm: 550.0,
                                angle_deg,
                            };
                            for polarization in BOTH {
                                let (r, t, layers) = problem.solve(&mut solver, polarization);
                                let sound =
                                    (0.0..=1.0).contains(&r) && t >= 0.0 && layers.iter().all(|a| a.is_finite());
                                assert!(sound && t <= 1.0 + 1e-9, "R {r} T {t} {layers:?} {problem:?}");
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn long_mirror_neither_overflows_nor_underflows() {
    // 2000 pairs: the fields grow by more than 10^500 without absorption.
    let (high, low) = (Complex64::new(2.44, 0.0), Complex64::new(1.456, 0.0));
    let mut n = vec![Complex64::new(1.0, 0.0)];
    let mut d = Vec::new();
    for _ in 0..2000 {
        n.extend([high, low]);
        d.extend([550.0 / (4.0 * 2.44), 550.0 / (4.0 * 1.456)]);
    }
    n.push(Complex64::new(1.5, 0.0));
    let coherent = vec![true; d.len()];
    let response = stack::solve(&n, &d, &coherent, 550.0, 1.0, Polarization::S).unwrap();
    assert_eq!((response.reflectance, response.transmittance), (1.0, 0.0));
    // Quarter-wave pairs in closed form: Y = ns (nH/nL)^(2N), R = ((1 - Y)/(1 + Y))^2, T = 4 Y/(1 + Y)^2.
    let pairs = 300;
    let mut short = n[..1 + 2 * pairs].to_vec();
    short.push(Complex64::new(1.5, 0.0));
    let response = stack::solve(&short, &d[..2 * pairs], &coherent[..2 * pairs], 550.0, 1.0, Polarization::S).unwrap();
    let log_y = 1.5_f64.ln() + 2.0 * pairs as f64 * (2.44_f64 / 1.456).ln();
    let expected = (4.0_f64.ln() - log_y).exp();
    assert!((response.transmittance / expected - 1.0).abs() < 1e-9, "{:e} {expected:e}", response.transmittance);
}

#[test]
fn refusals() {
    let c = Complex64::new;
    let air = c(1.0, 0.0);
    let bad = |n: &[Complex64], d: &[f64], coherent: &[bool], wavelength: f64, angle: f64| {
        stack::solve_angle(n, d, coherent, wavelength, angle, Polarization::S).unwrap_err().to_string()
    };
    assert!(bad(&[c(1.5, 1e-9), air], &[], &[], 550.0, 0.0).contains("first medium"));
    assert!(bad(&[c(-1.5, 0.0), air], &[], &[], 550.0, 0.0).contains("first medium"));
    assert!(bad(&[air, c(1.5, -1e-9)], &[], &[], 550.0, 0.0).contains("last medium"));
    assert!(bad(&[air, c(f64::NAN, 0.0), air], &[1.0], &[true], 550.0, 0.0).contains("layer 1"));
    assert!(bad(&[air, c(0.0, 0.0), air], &[1.0], &[true], 550.0, 0.0).contains("layer 1"));
    assert!(bad(&[air, c(1.5, -0.1), air], &[1.0], &[false], 550.0, 0.0).contains("incoherent"));
    assert!(bad(&[air, air, air], &[-1.0], &[true], 550.0, 0.0).contains("got -1"));
    assert!(bad(&[air, air, air], &[f64::NAN], &[true], 550.0, 0.0).contains("NaN"));
    assert!(bad(&[air, air, air], &[1e300], &[true], 550.0, 0.0).contains("wavelengths"));
    assert!(bad(&[air, air, air], &[1.0, 2.0], &[true], 550.0, 0.0).contains("thicknesses"));
    assert!(bad(&[air], &[], &[], 550.0, 0.0).contains("thicknesses"));
    for wavelength in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(bad(&[air, air], &[], &[], wavelength, 0.0).contains("wavelength_nm"));
    }
    for angle in [-1.0, 90.0, f64::NAN] {
        assert!(bad(&[air, air], &[], &[], 550.0, angle).contains("angle_deg"));
    }
}

#[test]
fn gain_is_allowed_in_finite_layers() {
    let c = Complex64::new;
    let n = [c(1.0, 0.0), c(1.6, -0.02), c(1.5, 0.0)];
    let response = stack::solve_angle(&n, &[400.0], &[true], 580.0, 45.0, Polarization::S).unwrap();
    assert!(response.reflectance + response.transmittance > 1.0);
    let incidence = Incidence::from_degrees(45.0).unwrap();
    let layers = stack::layer_absorptance(&n, &[400.0], &[true], 580.0, incidence, Polarization::S).unwrap();
    assert!((response.reflectance + response.transmittance + layers[0] - 1.0).abs() < 1e-13);
    assert!(layers[0] < 0.0);
}
