//! Colours of stacks against the solver, closed forms and finer sums.

use super::at_angle::AtAngle;
use super::fringes::{AGREE, HALVINGS};
use super::levels::Level;
use super::*;
use crate::color::difference::ciede2000;
use crate::color::gamut::Mapping;
use crate::color::request::Model;
use crate::color::space::{Adaptation, Space};
use crate::color::sums::Grid;
use crate::color::{Illuminant, Observer, Quantity};
use crate::incidence::Incidence;
use crate::stack::Solver;
use crate::{Complex64, Medium, Polarization};
use iridesce_numerics::sums::dot;

fn request(n: &[Complex64], coherent: &[bool]) -> ColorRequest {
    ColorRequest {
        media: n.iter().map(|n| Medium::constant(*n).unwrap()).collect(),
        coherent: coherent.to_vec(),
        illuminant: Illuminant::named("D65").unwrap(),
        observer: Observer::Cie1931,
        polarization: Polarization::Unpolarized,
        quantity: Quantity::Reflectance,
        model: Model::Exact,
        grid: None,
        space: Space::Xyz,
        adaptation: Adaptation::None,
        gamut: None,
    }
}

fn real(n: &[f64]) -> Vec<Complex64> {
    n.iter().map(|n| Complex64::new(*n, 0.0)).collect()
}

fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) {
    for i in 0..3 {
        assert!((a[i] - b[i]).abs() <= tolerance, "{a:?} against {b:?}");
    }
}

#[test]
fn zero_thickness_is_the_bare_interface() {
    let made = StackColor::new(request(&real(&[1.0, 2.0, 1.5]), &[true])).unwrap();
    let colors = made.colors(&[0.0], &[0.0]).unwrap();
    close(colors.values[0], made.sums.level(0).unwrap().weights.white.map(|w| 0.04 * w), 1e-15);
}

/// The sum of a film's spectrum, wavelength by wavelength through the solver.
fn by_solver(made: &StackColor, level: &Level, deg: f64, t: f64) -> [f64; 3] {
    let (mut solver, mut scratch) = (Solver::new(), Vec::new());
    let request = &made.sums.request;
    let one = |(i, &nm): (usize, &f64)| {
        let n = [0, 1, 2].map(|medium| made.sums.index(level, medium, i));
        solver.prepare(&n, &[t], &request.coherent, nm, Incidence::from_degrees(deg).unwrap());
        match request.quantity {
            Quantity::Reflectance => solver.powers(request.polarization).unwrap().reflectance,
            Quantity::Transmittance => solver.powers(request.polarization).unwrap().transmittance,
            Quantity::Absorptance => solver.absorptance(request.polarization, &mut scratch).unwrap(),
        }
    };
    let values: Vec<f64> = level.weights.wavelength_nm.iter().enumerate().map(one).collect();
    level.columns.each_ref().map(|w| dot(w, &values))
}

#[test]
fn vectors_are_the_general_solver() {
    let gold = Complex64::new(0.3, 2.9);
    for n in [
        [1.0.into(), 1.33.into(), 1.0.into()],
        [1.0.into(), 1.46.into(), gold],
        [1.0.into(), Complex64::new(2.4, 0.3), gold],
        [1.5.into(), 1.0.into(), 1.5.into()],
        [1.5.into(), gold, 1.0.into()],
    ] as [[Complex64; 3]; 5]
    {
        for quantity in [Quantity::Reflectance, Quantity::Transmittance, Quantity::Absorptance] {
            for polarization in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
                let made = StackColor::new(ColorRequest { quantity, polarization, ..request(&n, &[true]) }).unwrap();
                for (deg, t) in [(0.0, 5.0), (30.0, 310.0), (60.0, 1500.0), (80.0, 40.0)] {
                    let watch = Watch::new();
                    let at = AtAngle::new(&made.sums, deg, &watch).unwrap();
                    let level = made.sums.level(0).unwrap();
                    assert!(at.sweep(level, &[t], 1).unwrap().is_vectorised());
                    let mut fast = [[0.0; 3]];
                    at.xyz(level, &[t], &mut fast).unwrap();
                    let [fast] = fast;
                    close(fast, by_solver(&made, level, deg, t), 2e-14);
                }
            }
        }
    }
}

/// By the general solver, through a layer of no thickness in front.
fn with_general_solver(n: [Complex64; 3], t: f64, deg: f64) -> [f64; 3] {
    let made = StackColor::new(request(&[n[0], n[0], n[1], n[2]], &[true, true])).unwrap();
    made.colors(&[0.0, t], &[deg]).unwrap().values[0]
}

#[test]
fn gain_and_light_along_the_film_take_the_general_solver() {
    for (n, t, deg) in [
        ([1.0.into(), Complex64::new(1.5, -0.004), 1.3.into()], 600.0, 20.0),
        // n sin(theta) = 0.75: within rounding of the critical angle of the film, where kz is 1e-8 or 0
        ([1.5.into(), 0.75.into(), 1.5.into()], 300.0, 30.0),
        ([1.5.into(), 0.75.into(), 1.5.into()], 300.0, 29.999),
    ] {
        let made = StackColor::new(request(&n, &[true])).unwrap();
        let value = made.colors(&[t], &[deg]).unwrap().values[0];
        assert!(value.iter().all(|v| v.is_finite()), "{value:?}");
        close(value, with_general_solver(n, t, deg), 1e-13);
    }
}

#[test]
fn incoherent_slabs_need_no_refinement() {
    let made = StackColor::new(request(&real(&[1.0, 1.5, 1.0]), &[false])).unwrap();
    let colors = made.colors(&[1e9], &[0.0]).unwrap();
    close(colors.values[0], made.sums.level(0).unwrap().weights.white.map(|w| 0.08 / 1.04 * w), 1e-14);
    assert!(made.sums.levels[1..].iter().all(|level| level.get().is_none()));
}

#[test]
fn thick_films_are_refined_to_their_mean() {
    // Fringes far finer than 1 nm average out: R of the incoherent slab, 2 r0 / (1 + r0).
    let made = StackColor::new(request(&real(&[1.0, 1.5, 1.0]), &[true])).unwrap();
    let colors = made.colors(&[0.5e6], &[0.0]).unwrap();
    close(colors.values[0], made.sums.level(0).unwrap().weights.white.map(|w| 0.08 / 1.04 * w), 2e-5);
    assert_eq!(colors.forced, Forced::default());
    // The steps of the rule, and half of them to see that they are enough.
    let used: Vec<usize> = (0..=HALVINGS).filter(|h| made.sums.levels[*h].get().is_some()).collect();
    assert_eq!(used, [0, 6, 7]);
    let message = made.colors(&[1e9], &[0.0]).unwrap_err().to_string();
    assert!(message.contains("coherent=False"), "{message}");
}

#[test]
fn refining_agrees_with_a_grid_given_as_fine() {
    let n = real(&[1.0, 1.33, 1.0]);
    let own = StackColor::new(request(&n, &[true])).unwrap().colors(&[30_000.0], &[10.0]).unwrap();
    let grid = Some(Grid::default().divided(4));
    let given = StackColor::new(ColorRequest { grid, ..request(&n, &[true]) }).unwrap();
    let given = given.colors(&[30_000.0], &[10.0]).unwrap();
    close(own.values[0], given.values[0], 1e-15);
    assert!(given.forced.steps > 0.0 && given.forced.steps < FRINGE_STEPS);
    let coarse =
        ColorRequest { grid: Some(Grid { first_nm: 380.0, step_nm: 10.0, count: 41 }), ..request(&n, &[true]) };
    let coarse = StackColor::new(coarse).unwrap().colors(&[30_000.0], &[10.0]).unwrap();
    assert!(coarse.forced.steps > 4.0);
}

#[test]
fn overtones_are_seen() {
    // At 80 degrees glass reflects so much that a fringe of 4 steps is not resolved by them.
    let n = real(&[1.0, 1.77, 1.0]);
    let asked =
        ColorRequest { illuminant: Illuminant::named("FL12").unwrap(), space: Space::Lab, ..request(&n, &[true]) };
    let fine = ColorRequest { grid: Some(Grid::default().divided(64)), ..asked.clone() };
    let by_rule = ColorRequest { grid: Some(Grid::default().divided(2)), ..asked.clone() };
    let [own, fine, by_rule] =
        [asked, fine, by_rule].map(|asked| StackColor::new(asked).unwrap().colors(&[20_694.3], &[79.9]).unwrap());
    assert!(by_rule.forced.steps <= FRINGE_STEPS, "{:?}", by_rule.forced);
    assert!(ciede2000(by_rule.values[0], fine.values[0]) > 0.1, "{by_rule:?} {fine:?}");
    assert!(ciede2000(own.values[0], fine.values[0]) < AGREE, "{own:?} {fine:?}");
}

#[test]
fn order_of_points_does_not_matter() {
    let made = StackColor::new(request(&real(&[1.0, 1.33, 1.5]), &[true])).unwrap();
    let angles: Vec<f64> = (0..700).map(|i| f64::from(i * 37 % 80)).collect();
    let thickness: Vec<f64> = (0..700).map(|i| f64::from(i) * 3.0).collect();
    let all = made.colors(&thickness, &angles).unwrap();
    for i in [0, 13, 333, 699] {
        assert_eq!(made.colors(&thickness[i..=i], &angles[i..=i]).unwrap().values[0], all.values[i]);
    }
}

#[test]
fn gamut_and_spaces() {
    let n = real(&[1.0, 1.33, 1.0]);
    let asked = ColorRequest { space: Space::Srgb, gamut: Some(Mapping::Hue), ..request(&n, &[true]) };
    let thickness: Vec<f64> = (0..400).map(|i| f64::from(i) * 2.0).collect();
    let angles = vec![0.0; 400];
    let mapped = StackColor::new(asked.clone()).unwrap().colors(&thickness, &angles).unwrap();
    assert!(mapped.values.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
    assert!(mapped.out_of_gamut > 20, "{}", mapped.out_of_gamut);
    let kept =
        StackColor::new(ColorRequest { gamut: None, ..asked.clone() }).unwrap().colors(&thickness, &angles).unwrap();
    let negative = kept.values.iter().filter(|v| v.iter().any(|v| *v < -2e-5)).count() as u64;
    assert_eq!((negative, kept.out_of_gamut), (mapped.out_of_gamut, 0));
    let message = StackColor::new(ColorRequest { space: Space::Lab, ..asked }).unwrap_err().to_string();
    assert!(message.contains("RGB space"), "{message}");
}

#[test]
fn lines_need_no_refinement() {
    let mut asked = request(&real(&[1.0, 1.33, 1.0]), &[true]);
    asked.illuminant = Illuminant::named("laser:632.99").unwrap();
    let made = StackColor::new(asked).unwrap();
    let t = 1e6;
    let value = made.colors(&[t], &[0.0]).unwrap().values[0][1];
    let r0: f64 = (0.33f64 / 2.33).powi(2);
    let f = 4.0 * r0 / (1.0 - r0).powi(2) * (2.0 * std::f64::consts::PI * 1.33 * t / 632.99).sin().powi(2);
    assert!((value - f / (1.0 + f)).abs() < 1e-11);
    assert!(made.colors(&[1e12], &[0.0]).is_ok());
    assert!(made.sums.levels[1..].iter().all(|level| level.get().is_none()));
}

#[test]
fn refuses_what_it_cannot_do() {
    let good = request(&real(&[1.0, 1.33, 1.0]), &[true]);
    let two_beam = ColorRequest { model: Model::TwoBeam, ..good.clone() };
    let absorbing = request(&[1.0.into(), Complex64::new(1.33, 0.1), 1.0.into()], &[true]);
    for (bad, wanted) in [
        (ColorRequest { polarization: Polarization::S, ..two_beam.clone() }, "unpolarized"),
        (ColorRequest { quantity: Quantity::Transmittance, ..two_beam.clone() }, "reflectance only"),
        (ColorRequest { model: Model::TwoBeam, ..absorbing }, "real indices"),
        (ColorRequest { model: Model::TwoBeam, ..request(&real(&[1.0, 1.3, 1.4, 1.5]), &[true; 2]) }, "one layer"),
        (ColorRequest { coherent: vec![false], ..two_beam }, "coherent"),
        (request(&[Complex64::new(1.0, 0.1), 1.5.into()], &[]), "first medium"),
        (request(&[1.0.into(), Complex64::new(1.5, -0.1)], &[]), "last medium"),
        (request(&[1.0.into()], &[]), "a stack needs"),
    ] {
        let message = StackColor::new(bad).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
    let made = StackColor::new(good).unwrap();
    assert!(made.colors(&[1.0], &[90.0]).unwrap_err().to_string().contains("angle_deg"));
    assert!(made.colors(&[-1.0], &[0.0]).unwrap_err().to_string().contains("thickness_nm"));
    assert!(made.colors(&[f64::NAN], &[0.0]).is_err());
    assert!(made.colors(&[1.0, 2.0], &[0.0]).is_err());
    assert_eq!(made.colors(&[], &[]).unwrap().values.len(), 0);
}

/// Media that are alike are held once, however many layers are of them, and what cannot fit is refused.
#[test]
fn memory_goes_with_the_layers() {
    let mut n = vec![Complex64::from(1.0)];
    n.extend((0..10_000).map(|j| Complex64::from(if j % 2 == 0 { 1.3 } else { 1.4 })));
    n.push(Complex64::from(1.0));
    let made = StackColor::new(request(&n, &vec![true; 10_000])).unwrap();
    let level = made.sums.level(HALVINGS).unwrap();
    assert_eq!(level.tables.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1]);
    // A grid of one wavelength: the sum itself, without its refinements.
    let grid = Some(Grid { first_nm: 550.0, step_nm: 1.0, count: 2 });
    let coarse = StackColor::new(ColorRequest { grid, ..request(&n, &vec![true; 10_000]) }).unwrap();
    let y = coarse.colors(&vec![10.0; 10_000], &[0.0]).unwrap().values[0][1];
    assert!((0.0..=1.0).contains(&y), "{y}");

    let media = (0..400_u32).map(|j| {
        let row = |i: u32| (i as usize + 1, 300.0 + 300.0 * f64::from(i), 1.3 + 0.001 * f64::from(i + j), 0.0);
        Medium::from_rows(&[row(0), row(1), row(2)], false, "own", "").unwrap()
    });
    let mut asked = request(&n[..402], &[true; 400]);
    asked.media.splice(1..401, media);
    let made = StackColor::new(asked).unwrap();
    assert!(made.sums.level(0).is_ok());
    let error = made.sums.level(HALVINGS).unwrap_err();
    assert!(matches!(error, OpticsError::Resource(_)) && error.to_string().contains("400"), "{error}");
}

#[test]
fn a_stopped_sum_ends() {
    let made = StackColor::new(request(&real(&[1.0, 1.33, 1.0]), &[true])).unwrap();
    let watch = Watch::new();
    watch.stop();
    assert_eq!(made.colors_watched(&[300.0], &[0.0], &watch), Err(OpticsError::Stopped));
}
