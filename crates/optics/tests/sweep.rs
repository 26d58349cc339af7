//! Whole arrays by vectors against the solver point by point, at every level of SIMD that the machine has.
//!
//! Both are within the pass rule of the reference vectors, |R - R_ref| <= 1e-12 + 1e3 |dR|, dR being what a relative change
//! of 2^-53 in wavelength and angle does to R. Between the two twice that is allowed. (Phases are worked out in another
//! order: what is left of a phase of 1e4 turns differs by 1e4 roundings.)

mod random;

use fearless_simd::Level;
use iridesce_numerics::Watch;
use iridesce_optics::incidence::Incidence;
use iridesce_optics::stack::sweep::{Operand, Power, Quantity, Sweep, SweepRequest, levels};
use iridesce_optics::stack::{self, Solver};
use iridesce_optics::{Complex64, OpticsError, Polarization};
use random::Random;

const POWERS: [Power; 3] = [Power::Reflectance, Power::Transmittance, Power::Absorptance];
const POLARIZATIONS: [Polarization; 3] = [Polarization::S, Polarization::P, Polarization::Unpolarized];

/// A stack over an array; `strides` tell how each operand broadcasts.
#[derive(Debug, Clone)]
struct Problem {
    indices: Vec<Vec<Complex64>>,
    shape: Vec<usize>,
    wavelength_nm: (Vec<f64>, Vec<usize>),
    angle_deg: (Vec<f64>, Vec<usize>),
    thickness_nm: Vec<(Vec<f64>, Vec<usize>)>,
}

impl Problem {
    fn request(&self, power: Power, polarization: Polarization) -> SweepRequest<'_> {
        SweepRequest {
            quantity: Quantity::Power(power),
            polarization,
            coherent: vec![true; self.thickness_nm.len()],
            indices: self.indices.iter().map(Vec::as_slice).collect(),
            shape: self.shape.clone(),
            wavelength_nm: Operand { values: &self.wavelength_nm.0, strides: self.wavelength_nm.1.clone() },
            angle_deg: Operand { values: &self.angle_deg.0, strides: self.angle_deg.1.clone() },
            thickness_nm: self
                .thickness_nm
                .iter()
                .map(|(values, strides)| Operand { values, strides: strides.clone() })
                .collect(),
        }
    }

    fn count(&self) -> usize {
        self.shape.iter().product()
    }

    /// Wavelength index, angle, thicknesses of one element.
    fn element(&self, mut element: usize) -> (usize, f64, Vec<f64>) {
        let mut place = vec![0; self.shape.len()];
        for (index, length) in place.iter_mut().zip(&self.shape).rev() {
            *index = element % length;
            element /= length;
        }
        let at = |strides: &[usize]| strides.iter().zip(&place).map(|(step, index)| step * index).sum::<usize>();
        let thickness = self.thickness_nm.iter().map(|(values, strides)| values[at(strides)]).collect();
        (at(&self.wavelength_nm.1), self.angle_deg.0[at(&self.angle_deg.1)], thickness)
    }

    /// One element by the solver, its wavelength and angle changed by a few roundings.
    fn solve(&self, solver: &mut Solver, element: usize, power: Power, light: Polarization, nudge: [f64; 2]) -> f64 {
        let (at, angle_deg, thickness_nm) = self.element(element);
        let indices: Vec<Complex64> =
            self.indices.iter().map(|table| if table.len() == 1 { table[0] } else { table[at] }).collect();
        let coherent = vec![true; thickness_nm.len()];
        let wavelength_nm = self.wavelength_nm.0[at] * (1.0 + nudge[0] * f64::EPSILON / 2.0);
        let angle_deg = (angle_deg * (1.0 + nudge[1] * f64::EPSILON / 2.0)).min(90.0_f64.next_down());
        stack::check(&indices, &thickness_nm, &coherent, wavelength_nm).unwrap();
        solver.prepare(&indices, &thickness_nm, &coherent, wavelength_nm, Incidence::from_degrees(angle_deg).unwrap());
        match power {
            Power::Reflectance => solver.powers(light).unwrap().reflectance,
            Power::Transmittance => solver.powers(light).unwrap().transmittance,
            Power::Absorptance => solver.absorptance(light, &mut Vec::new()).unwrap(),
        }
    }

    /// Largest difference between the sweep and the solver, over what is allowed.
    fn compare(&self) -> f64 {
        let mut solver = Solver::new();
        let mut worst = 0.0_f64;
        for power in POWERS {
            for light in POLARIZATIONS {
                for level in levels() {
                    let sweep = Sweep::at_level(self.request(power, light), level).unwrap();
                    assert!(sweep.is_vectorised());
                    let mut out = vec![f64::NAN; self.count()];
                    sweep.evaluate(&mut out).unwrap();
                    for (element, &got) in out.iter().enumerate() {
                        let wanted = self.solve(&mut solver, element, power, light, [0.0, 0.0]);
                        let error = (got - wanted).abs();
                        // Exact agreement needs no allowance, and most of what is left is within 1e-13.
                        if error <= 1e-13 && (power != Power::Transmittance || wanted > 1e-3) {
                            continue;
                        }
                        // A wider step than one rounding, so that the change is not lost in roundings of its own.
                        let moved = [[64.0, 0.0], [0.0, 64.0]]
                            .map(|nudge| (self.solve(&mut solver, element, power, light, nudge) - wanted).abs() / 64.0);
                        let allowed = 1e-12 + 1e3 * (moved[0] + moved[1]);
                        let ratio = error / (2.0 * allowed);
                        assert!(ratio <= 1.0, "{level:?} {power:?} {light:?} {got} {wanted} {:?}", self.named(element));
                        worst = worst.max(ratio);
                        if power == Power::Transmittance && wanted > 1e-300 {
                            let relative = (got / wanted - 1.0).abs();
                            let allowed = 1e-9 + 1e3 * (moved[0] + moved[1]) / wanted;
                            assert!(
                                relative <= allowed,
                                "{level:?} {light:?} T {got:e} {wanted:e} {:?}",
                                self.named(element)
                            );
                        }
                    }
                }
            }
        }
        worst
    }

    fn named(&self, element: usize) -> String {
        let (at, angle_deg, thickness_nm) = self.element(element);
        let n: Vec<Complex64> =
            self.indices.iter().map(|table| if table.len() == 1 { table[0] } else { table[at] }).collect();
        format!("n {n:?} d {thickness_nm:?} at {} nm, {angle_deg} deg", self.wavelength_nm.0[at])
    }
}

fn real(n: &[f64]) -> Vec<Vec<Complex64>> {
    n.iter().map(|n| vec![Complex64::new(*n, 0.0)]).collect()
}

/// 5 wavelengths x 4 angles x the given thicknesses, of every layer the same axis.
fn grid(indices: Vec<Vec<Complex64>>, thickness_nm: Vec<Vec<f64>>) -> Problem {
    let steps = thickness_nm[0].len();
    Problem {
        indices,
        shape: vec![5, 4, steps],
        wavelength_nm: (vec![360.0, 410.5, 550.0, 633.0, 830.0], vec![1, 0, 0]),
        angle_deg: (vec![0.0, 33.3, 60.0, 88.5], vec![0, 1, 0]),
        thickness_nm: thickness_nm.into_iter().map(|values| (values, vec![0, 0, 1])).collect(),
    }
}

fn spread(count: usize, thickest: f64) -> Vec<f64> {
    (0..count).map(|i| thickest * i as f64 / count as f64).collect()
}

#[test]
fn lossless_films() {
    for n in [[1.0, 1.33, 1.0], [1.0, 1.38, 1.52], [1.0, 2.4, 1.5], [1.0, 1.0, 1.0], [1.33, 1.45, 1.4], [1.0, 1.5, 3.9]]
    {
        for thickest in [300.0, 5_000.0, 3e6] {
            grid(real(&n), vec![spread(19, thickest)]).compare();
        }
    }
}

/// What is left of a reflection that a quarter wave takes away is rounding, and rounding has either sign.
#[test]
fn nothing_reflects_less_than_nothing() {
    let mut zeros = 0;
    for i in 0..2000 {
        let last = 1.2 + 1e-3 * f64::from(i);
        let film = last.sqrt();
        let problem = grid(real(&[1.0, film, last]), vec![vec![550.0 / 4.0 / film, 550.0 * 0.75 / film]]);
        for light in POLARIZATIONS {
            let sweep = Sweep::at_level(problem.request(Power::Reflectance, light), levels()[0]).unwrap();
            let mut out = vec![f64::NAN; problem.count()];
            sweep.evaluate(&mut out).unwrap();
            assert!(out.iter().all(|r| *r >= 0.0), "{film} on {last}: {out:?}");
            zeros += out.iter().filter(|r| **r < 1e-16).count();
        }
    }
    assert!(zeros > 0);
}

#[test]
fn films_beyond_the_critical_angle_and_absorbing_ones() {
    let c = Complex64::new;
    for n in [
        [c(1.5, 0.0), c(1.0, 0.0), c(1.5, 0.0)],
        [c(1.5, 0.0), c(1.0, 0.0), c(1.2, 0.0)],
        [c(1.0, 0.0), c(1.46, 0.0), c(4.08, 0.028)],
        [c(1.0, 0.0), c(2.34, 0.1), c(2.95, 2.93)],
        [c(1.0, 0.0), c(0.06, 3.6), c(1.5, 0.0)],
        [c(1.0, 0.0), c(1.5, 1e-9), c(1.5, 3e-8)],
        [c(1.0, 0.0), c(0.0, 3.0), c(1.5, 0.0)],
    ] {
        let n: Vec<Vec<Complex64>> = n.iter().map(|n| vec![*n]).collect();
        for thickest in [80.0, 900.0, 1e5] {
            grid(n.clone(), vec![spread(19, thickest)]).compare();
        }
    }
}

#[test]
fn stacks() {
    let c = Complex64::new;
    let mirror: Vec<f64> = [1.0].into_iter().chain((0..10).map(|i| if i % 2 == 0 { 2.35 } else { 1.46 })).collect();
    let mut mirror = real(&mirror);
    mirror.push(vec![c(1.52, 0.0)]);
    let lengths = (0..10).map(|i| spread(11, 90.0 + f64::from(i) * 7.0)).collect();
    grid(mirror.clone(), lengths).compare();
    let mut metal = mirror;
    metal[4] = vec![c(0.06, 3.6)];
    metal[9] = vec![c(2.0, 0.3)];
    metal[11] = vec![c(1.2, 7.0)];
    let lengths = (0..10).map(|i| spread(11, 90.0 + f64::from(i) * 700.0)).collect();
    grid(metal, lengths).compare();
}

#[test]
fn random_stacks_over_random_broadcasts() {
    let mut random = Random::new(11);
    let mut worst = 0.0_f64;
    for _ in 0..400 {
        let problem = random_problem(&mut random);
        worst = worst.max(problem.compare());
    }
    println!("worst difference from the solver {worst:.3e} of what is allowed");
}

fn random_problem(random: &mut Random) -> Problem {
    let axes = random.below(4) as usize;
    let shape: Vec<usize> = (0..axes).map(|_| 1 + random.below(12) as usize).collect();
    // Each operand owns a random set of axes, in C order.
    let operand = |random: &mut Random, value: &mut dyn FnMut(&mut Random) -> f64| {
        let mut strides = vec![0; axes];
        let mut count = 1;
        for axis in (0..axes).rev() {
            if random.one_in(2) && shape[axis] > 1 {
                strides[axis] = count;
                count *= shape[axis];
            }
        }
        ((0..count).map(|_| value(random)).collect::<Vec<f64>>(), strides)
    };
    let wavelength_nm = operand(random, &mut |random| random.between(300.0, 2000.0));
    let steepest = if random.one_in(3) { 89.999_999 } else { 85.0 };
    let angle_deg = operand(random, &mut |random| if random.one_in(5) { 0.0 } else { random.between(0.0, steepest) });
    let layers = random.below(7) as usize;
    let lossy = random.one_in(2);
    let index = |random: &mut Random| match random.below(if lossy { 6 } else { 2 }) {
        2 => Complex64::new(random.between(1.0, 3.0), random.decades(1e-10, 1e-2)),
        3 => Complex64::new(random.between(0.05, 4.0), random.between(0.0, 8.0)),
        4 => Complex64::new(0.0, random.between(0.1, 6.0)),
        _ => Complex64::new(random.between(0.8, 4.0), 0.0),
    };
    let first = Complex64::new(random.between(1.0, 2.0), 0.0);
    let table = |random: &mut Random, wavelengths: usize| -> Vec<Complex64> {
        if random.one_in(3) { (0..wavelengths).map(|_| index(random)).collect() } else { vec![index(random)] }
    };
    let wavelengths = wavelength_nm.0.len();
    let mut indices = vec![vec![first]];
    indices.extend((0..=layers).map(|_| table(random, wavelengths)));
    let thickest = random.decades(1.0, 1e5);
    let thickness_nm = (0..layers).map(|_| operand(random, &mut |random| random.between(0.0, thickest))).collect();
    Problem { indices, shape, wavelength_nm, angle_deg, thickness_nm }
}

#[test]
fn how_the_work_is_cut_up_changes_no_bit() {
    // Large enough for many tasks; each alone, in any order, must give what all give.
    let mut problem = grid(real(&[1.0, 1.38, 1.52]), vec![spread(60_000, 4000.0)]);
    problem.angle_deg.0[3] = 89.99; // a row for the march among those of films
    let sweep = Sweep::new(problem.request(Power::Reflectance, Polarization::Unpolarized)).unwrap();
    let mut out = vec![0.0; problem.count()];
    let mut tasks = sweep.tasks(&mut out, &mut []).unwrap();
    assert!(tasks.len() > 4, "{}", tasks.len());
    for task in tasks.iter_mut().rev() {
        sweep.run(task).unwrap();
    }
    // The same values with thickness as the first axis: lanes are rows there.
    let turned = Problem {
        shape: vec![60_000, 5, 4],
        wavelength_nm: (problem.wavelength_nm.0.clone(), vec![0, 1, 0]),
        angle_deg: (problem.angle_deg.0.clone(), vec![0, 0, 1]),
        thickness_nm: vec![(problem.thickness_nm[0].0.clone(), vec![1, 0, 0])],
        ..problem.clone()
    };
    let sweep = Sweep::new(turned.request(Power::Reflectance, Polarization::Unpolarized)).unwrap();
    let mut other = vec![0.0; problem.count()];
    sweep.evaluate(&mut other).unwrap();
    for row in 0..20 {
        for t in 0..60_000 {
            assert_eq!(out[row * 60_000 + t].to_bits(), other[t * 20 + row].to_bits(), "{row} {t}");
        }
    }
}

#[test]
fn what_is_wrong_is_refused_by_name() {
    let c = Complex64::new;
    let good = grid(real(&[1.0, 1.38, 1.52]), vec![spread(3, 100.0)]);
    let ask = |problem: &Problem| Sweep::new(problem.request(Power::Reflectance, Polarization::S)).map(|_| ());
    assert!(ask(&good).is_ok());
    let refused = |part: &str, change: &dyn Fn(&mut Problem)| {
        let mut problem = good.clone();
        change(&mut problem);
        let message = ask(&problem).unwrap_err().to_string();
        assert!(message.contains(part), "{part}: {message}");
    };
    refused("last medium", &|p| p.indices[2] = vec![c(1.5, -0.01)]);
    refused("first medium", &|p| p.indices[0] = vec![c(1.5, 0.01)]);
    refused("layer 1", &|p| p.indices[1] = vec![c(f64::NAN, 0.0)]);
    refused("(at wavelength_nm = ", &|p| p.indices[1] = [vec![c(1.5, 0.0); 4], vec![c(1e13, 0.0)]].concat());
    refused("do not belong together", &|p| p.indices[1] = vec![c(1.5, 0.0); 3]);
    refused("do not belong together", &|p| p.indices.truncate(2));
    refused("wavelength_nm must be > 0 and finite, got 0.0 at index (2,)", &|p| p.wavelength_nm.0[2] = 0.0);
    refused("wavelength_nm must be > 0", &|p| p.wavelength_nm.0[2] = f64::NAN);
    refused("angle_deg must be >= 0 and < 90, got 90.0 at index (0,)", &|p| p.angle_deg.0[0] = 90.0);
    refused("thickness_nm must be >= 0 and finite, got -1.0 at index (0,) in layer 1", &|p| {
        p.thickness_nm[0].0[0] = -1.0
    });
    refused("thickness_nm must be >= 0 and finite, got inf", &|p| p.thickness_nm[0].0[0] = f64::INFINITY);
    refused("at most 1e30 wavelengths", &|p| p.thickness_nm[0].0[0] = 1e40);
    refused("do not belong together", &|p| p.thickness_nm[0].1 = vec![0, 0, 2]);
    refused("do not belong together", &|p| p.shape = vec![5, 4]);
    refused("cannot fit", &|p| p.shape = vec![usize::MAX, 4, 3]);
    let sweep = Sweep::new(good.request(Power::Reflectance, Polarization::S)).unwrap();
    assert!(sweep.tasks(&mut [0.0; 3], &mut []).is_err());
    assert!(sweep.evaluate(&mut [0.0; 3]).unwrap_err().to_string().contains("60 elements of 1 numbers, got 3"));
    let amplitudes = SweepRequest {
        quantity: Quantity::Amplitudes,
        coherent: vec![false],
        ..good.request(Power::Reflectance, Polarization::S)
    };
    assert!(Sweep::new(amplitudes).unwrap_err().to_string().contains("incoherent"));
    let absorbing = Problem { indices: vec![vec![c(1.0, 0.0)], vec![c(1.4, 0.1)], vec![c(1.0, 0.0)]], ..good.clone() };
    let two_beam =
        SweepRequest { quantity: Quantity::TwoBeam, ..absorbing.request(Power::Reflectance, Polarization::S) };
    assert!(Sweep::new(two_beam).unwrap_err().to_string().contains("real indices, got 1.4+0.1i"));
    // Nothing at all is no mistake.
    let mut nothing = good.clone();
    nothing.shape[0] = 0;
    let sweep = Sweep::new(nothing.request(Power::Reflectance, Polarization::S)).unwrap();
    assert!(sweep.evaluate(&mut []).is_ok() && sweep.evaluate_single(&mut []).is_ok());
}

/// Gain, extreme indices and incoherent slabs are no vectors' work, and come out as the solver's own numbers; so do amplitudes,
/// angles and layers, whose numbers an element stand side by side.
#[test]
fn what_no_vector_covers_goes_through_the_solver() {
    let c = Complex64::new;
    let of = |n: Complex64| grid(vec![vec![c(1.0, 0.0)], vec![n], vec![c(1.5, 0.0)]], vec![spread(3, 100.0)]);
    let mut solver = Solver::new();
    for (problem, coherent) in [(of(c(1.5, -0.01)), true), (of(c(1e9, 0.0)), true), (of(c(1.4, 0.0)), false)] {
        for light in POLARIZATIONS {
            for power in POWERS {
                let request = SweepRequest { coherent: vec![coherent], ..problem.request(power, light) };
                let sweep = Sweep::new(request).unwrap();
                assert!(!sweep.is_vectorised());
                let (mut out, mut single) = (vec![0.0; problem.count()], vec![0.0; problem.count()]);
                sweep.evaluate(&mut out).unwrap();
                sweep.evaluate_single(&mut single).unwrap();
                for (element, got) in out.iter().enumerate() {
                    let (at, angle, d) = problem.element(element);
                    let n = [0, 1, 2].map(|medium| problem.indices[medium][0]);
                    let incidence = Incidence::from_degrees(angle).unwrap();
                    solver.prepare(&n, &d, &[coherent], problem.wavelength_nm.0[at], incidence);
                    let wanted = match power {
                        Power::Reflectance => solver.powers(light).unwrap().reflectance,
                        Power::Transmittance => solver.powers(light).unwrap().transmittance,
                        Power::Absorptance => solver.absorptance(light, &mut Vec::new()).unwrap(),
                    };
                    assert_eq!((*got, single[element]), (wanted, wanted as f32));
                }
                let weight: Vec<f64> = (0..20).map(|row| f64::from(row) - 3.0).collect();
                let mut sums = vec![[0.0; 3]; 3];
                sweep.weigh([&weight, &weight, &weight], &mut sums).unwrap();
                for (t, sum) in sums.iter().enumerate() {
                    let plain: f64 = (0..20).map(|row| weight[row] * out[3 * row + t]).sum();
                    assert!((sum[1] - plain).abs() <= 1e-13 * plain.abs().max(1.0), "{sum:?} {plain}");
                }
            }
        }
    }
    let problem = grid(vec![vec![c(1.0, 0.0)], vec![c(1.4, 0.2)], vec![c(1.5, 0.0)]], vec![spread(300, 100.0)]);
    for quantity in [Quantity::LayerAbsorptance, Quantity::Amplitudes, Quantity::Ellipsometry] {
        let sweep =
            Sweep::new(SweepRequest { quantity, ..problem.request(Power::Reflectance, Polarization::P) }).unwrap();
        let [wide, wide_second] = quantity.widths(1);
        let (mut out, mut second) = (vec![0.0; wide * problem.count()], vec![0.0; wide_second * problem.count()]);
        let mut tasks = sweep.tasks(&mut out, &mut second).unwrap();
        assert!(tasks.len() > 4);
        tasks.iter_mut().rev().try_for_each(|task| sweep.run(task)).unwrap();
        for element in [0, 1, 511, 512, 5999] {
            let (at, angle, d) = problem.element(element);
            let n = [0, 1, 2].map(|medium| problem.indices[medium][0]);
            solver.prepare(&n, &d, &[true], problem.wavelength_nm.0[at], Incidence::from_degrees(angle).unwrap());
            let (s, p) = (solver.amplitudes(Polarization::S).unwrap(), solver.amplitudes(Polarization::P).unwrap());
            match quantity {
                Quantity::Amplitudes => {
                    assert_eq!(out[2 * element..][..2], [p.r.re, p.r.im]);
                    assert_eq!(second[2 * element..][..2], [p.t.re, p.t.im]);
                }
                Quantity::Ellipsometry => {
                    assert_eq!(Some((out[element], second[element])), stack::ellipsometry(s.r, p.r));
                }
                _ => assert_eq!(out[element], solver.absorptance(Polarization::P, &mut Vec::new()).unwrap()),
            }
        }
    }
}

/// A medium in itself reflects nothing, so that its angles have no value: the error tells where.
#[test]
fn errors_tell_their_place() {
    let c = Complex64::new;
    let problem = grid(real(&[1.0, 1.4, 1.0]), vec![spread(3, 100.0)]);
    let nothing = Problem { indices: vec![vec![c(1.5, 0.0)]; 3], ..problem.clone() };
    let angles =
        SweepRequest { quantity: Quantity::Ellipsometry, ..nothing.request(Power::Reflectance, Polarization::S) };
    let sweep = Sweep::new(angles).unwrap();
    let (mut psi, mut delta) = (vec![0.0; problem.count()], vec![0.0; problem.count()]);
    let error = sweep.run(&mut sweep.tasks(&mut psi, &mut delta).unwrap()[0]).unwrap_err();
    assert!(error.to_string().ends_with("where nothing is reflected (at index (0, 0, 0))"), "{error}");
}

#[test]
fn a_stopped_sweep_ends() {
    let problem = grid(real(&[1.0, 1.38, 1.52]), vec![spread(3, 100.0)]);
    let watch = Watch::new();
    let sweep = Sweep::new(problem.request(Power::Reflectance, Polarization::S)).unwrap().watched(&watch);
    let mut out = vec![0.0; problem.count()];
    assert!(sweep.evaluate(&mut out).is_ok());
    watch.stop();
    assert_eq!(sweep.evaluate(&mut out), Err(OpticsError::Stopped));
}

#[test]
fn rows_that_the_kernels_leave_alone() {
    // Exactly along the film, within rounding of it, phases beyond all digits, long mirrors: the solver's own numbers.
    let mut problem = grid(real(&[1.5, 0.75, 1.5]), vec![vec![0.0, 100.0, 300.0]]);
    problem.angle_deg.0 = vec![0.0, 29.999_999_999, 30.0, 30.000_000_001];
    problem.compare();
    let thick = grid(real(&[1.0, 1.33, 1.0]), vec![vec![1e12, 1e15, 1e22]]);
    let mut out = vec![0.0; thick.count()];
    Sweep::new(thick.request(Power::Reflectance, Polarization::S)).unwrap().evaluate(&mut out).unwrap();
    let mut solver = Solver::new();
    for (element, got) in out.iter().enumerate() {
        assert_eq!(*got, thick.solve(&mut solver, element, Power::Reflectance, Polarization::S, [0.0, 0.0]));
    }
    let mut n = vec![1.0];
    n.extend((0..2000).map(|i| if i % 2 == 0 { 2.44 } else { 1.456 }));
    n.push(1.5);
    let d = n[1..2001].iter().map(|n| vec![550.0 / (4.0 * n)]).collect();
    let mirror = Problem { shape: vec![5, 4, 1], ..grid(real(&n), d) };
    let mut out = vec![0.0; mirror.count()];
    Sweep::new(mirror.request(Power::Reflectance, Polarization::S)).unwrap().evaluate(&mut out).unwrap();
    assert_eq!(out[2 * 4], 1.0);
}

/// Single precision against double. What is left of the phase is good to a rounding or two of 2^-24 half turns, R moves by
/// (1 + sqrt(F)) pi / 2 times that at most (F the finesse factor of the steepest row), and a dozen roundings of 2^-24
/// come on top. Without fused multiplication one rounding of the whole phase is added.
#[test]
fn single_precision() {
    for (n, finesse) in [([1.0, 1.33, 1.0], 300.0), ([1.0, 1.38, 1.52], 5.0), ([1.0, 2.0, 1.0], 1000.0)] {
        for thickest in [500.0, 20_000.0, 1e6, 1e8] {
            let problem = grid(real(&n), vec![spread(37, thickest)]);
            for light in POLARIZATIONS {
                for power in [Power::Reflectance, Power::Transmittance] {
                    for level in levels() {
                        let sweep = Sweep::at_level(problem.request(power, light), level).unwrap();
                        let mut double = vec![0.0; problem.count()];
                        let mut single = vec![0.0_f32; problem.count()];
                        sweep.evaluate(&mut double).unwrap();
                        sweep.evaluate_single(&mut single).unwrap();
                        let fused = format!("{level:?}").starts_with("Avx") || format!("{level:?}").starts_with("Neon");
                        let half_turns = if fused { 0.0 } else { 2.0 * n[1] * thickest / 360.0 };
                        let rounding = f64::from(f32::EPSILON) / 2.0;
                        let allowed = rounding
                            * (12.0 + (2.0 + half_turns) * (1.0 + f64::sqrt(finesse)) * std::f64::consts::FRAC_PI_2);
                        for (element, (single, double)) in single.iter().zip(&double).enumerate() {
                            let error = (f64::from(*single) - double).abs();
                            assert!(
                                error <= allowed,
                                "{level:?} {power:?} {light:?} {error:e} > {allowed:e} {}",
                                problem.named(element)
                            );
                        }
                    }
                }
            }
        }
    }
    // A metal film goes through double precision; thickness as the first axis too.
    let silver = vec![vec![Complex64::new(1.0, 0.0)], vec![Complex64::new(0.06, 3.6)], vec![Complex64::new(1.5, 0.0)]];
    let problem = grid(silver, vec![spread(9, 60.0)]);
    let sweep = Sweep::new(problem.request(Power::Absorptance, Polarization::P)).unwrap();
    let (mut double, mut single) = (vec![0.0; problem.count()], vec![0.0_f32; problem.count()]);
    sweep.evaluate(&mut double).unwrap();
    sweep.evaluate_single(&mut single).unwrap();
    assert!(single.iter().zip(&double).all(|(single, double)| *single == *double as f32));
}

/// Weighted sums over rows against the values themselves, added up one by one: 4 * 10^-16 an addition.
#[test]
fn weighted_sums() {
    let c = Complex64::new;
    let real_film = real(&[1.0, 1.38, 1.52]);
    let wafer = vec![vec![c(1.0, 0.0)], vec![c(1.46, 0.0)], vec![c(4.08, 0.028)]];
    let gap = real(&[1.5, 1.0, 1.5]);
    for indices in [real_film, wafer, gap] {
        for light in POLARIZATIONS {
            for power in POWERS {
                let problem = grid(indices.clone(), vec![spread(13, 900.0)]);
                for level in levels() {
                    weighted_sums_at(&problem, power, light, level);
                }
                let sweep = Sweep::new(problem.request(power, light)).unwrap();
                let mut sums = vec![[f64::NAN; 3]; 13];
                let wrong = sweep.weigh([&[1.0][..]; 3], &mut sums).unwrap_err().to_string();
                assert!(wrong.contains("20 rows and 13 thicknesses"), "{wrong}");
            }
        }
    }
}

fn weighted_sums_at(problem: &Problem, power: Power, light: Polarization, level: Level) {
    let sweep = Sweep::at_level(problem.request(power, light), level).unwrap();
    let mut values = vec![0.0; problem.count()];
    sweep.evaluate(&mut values).unwrap();
    let weights: [Vec<f64>; 3] =
        [0.3, 1.7, 4.1].map(|phase: f64| (0..20).map(|i| (f64::from(i) * 0.7 + phase).sin()).collect());
    let mut sums = vec![[f64::NAN; 3]; 13];
    sweep.weigh(weights.each_ref().map(Vec::as_slice), &mut sums).unwrap();
    for (element, sums) in sums.iter().enumerate() {
        for (sum, weights) in sums.iter().zip(&weights) {
            let plain: f64 = (0..20).map(|row| weights[row] * values[row * 13 + element]).sum();
            assert!((sum - plain).abs() < 20.0 * 4e-16, "{level:?} {power:?} {light:?} {sum} {plain}");
        }
    }
}
