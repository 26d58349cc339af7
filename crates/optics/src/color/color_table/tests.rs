use iridesce_numerics::Watch;

use super::*;
use crate::color::{Adaptation, ColorRequest, Illuminant, Model, Observer, Quantity, Space, StackColor, ciede2000};
use crate::{Complex64, Medium, Polarization};

fn request(n: &[Complex64], layer: usize, range_nm: [f64; 2], range_deg: [f64; 2]) -> ColorTableRequest {
    ColorTableRequest {
        color: ColorRequest {
            media: n.iter().map(|n| Medium::constant(*n).unwrap()).collect(),
            coherent: vec![true; n.len() - 2],
            illuminant: Illuminant::named("D65").unwrap(),
            observer: Observer::Cie1931,
            polarization: Polarization::Unpolarized,
            quantity: Quantity::Reflectance,
            model: Model::Exact,
            grid: None,
            space: Space::Srgb,
            adaptation: Adaptation::None,
            gamut: None,
        },
        thickness_nm: vec![60.0; n.len() - 2],
        layer,
        range_nm,
        range_deg,
        tolerance: 0.1,
    }
}

fn soap() -> Vec<Complex64> {
    [1.0, 1.33, 1.0].map(Complex64::from).to_vec()
}

/// Points of another sequence than the table's own probes, against exact sums.
fn worst(table: &ColorTable, request: &ColorTableRequest) -> f64 {
    let exact = StackColor::new(ColorRequest { space: Space::Lab, ..request.color.clone() }).unwrap();
    let at = |range: [f64; 2], share: f64| range[0] + (range[1] - range[0]) * share;
    let share = |i: u32, ratio: f64| (f64::from(i) * ratio).fract();
    // Golden and plastic ratios: evenly spread in both directions, ends included below.
    let mut t: Vec<f64> = (0..6000).map(|i| at(request.range_nm, share(i, 0.754_877_666))).collect();
    let mut angle: Vec<f64> = (0..6000).map(|i| at(request.range_deg, share(i / 50, 0.569_840_29))).collect();
    for (share_t, share_a) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        t.push(at(request.range_nm, share_t));
        angle.push(at(request.range_deg, share_a));
    }
    let mut thickness = request.thickness_nm.repeat(t.len());
    thickness.iter_mut().skip(request.layer).step_by(request.thickness_nm.len()).zip(&t).for_each(|(a, b)| *a = *b);
    let wanted = exact.colors(&thickness, &angle).unwrap().values;
    let mut found = vec![[0.0; 3]; t.len()];
    table.evaluate(&t, &angle, &mut found).unwrap();
    let lab = |xyz: [f64; 3]| Space::Lab.from_xyz(xyz, table.shape.white, Adaptation::None);
    found.iter().zip(&wanted).map(|(a, b)| ciede2000(lab(*a), *b)).fold(0.0, f64::max)
}

#[test]
fn tables_keep_to_what_they_say() {
    let c = Complex64::new;
    let wafer = vec![c(1.0, 0.0), c(1.46, 0.0), c(4.08, 0.028)];
    let metal = vec![c(1.0, 0.0), c(0.2, 3.3), c(1.5, 0.0)];
    let mirror = [1.0, 2.35, 1.46, 2.35, 1.52].map(Complex64::from).to_vec();
    for request in [
        request(&soap(), 0, [0.0, 1500.0], [0.0, 80.0]),
        request(&soap(), 0, [300.0, 2000.0], [45.0, 45.0]),
        request(&wafer, 0, [0.0, 600.0], [0.0, 60.0]),
        request(&metal, 0, [0.0, 80.0], [0.0, 70.0]),
        request(&mirror, 1, [20.0, 400.0], [10.0, 50.0]),
    ] {
        let table = ColorTable::build(request.clone(), &Watch::new()).unwrap();
        let found = worst(&table, &request);
        println!("{:?}: {found}", table.shape);
        assert!(table.shape.max_delta_e <= 0.1 && table.shape.mean_delta_e <= table.shape.max_delta_e);
        assert!(found <= table.shape.max_delta_e, "{found} against {}", table.shape.max_delta_e);
        // What is stated is no mere tolerance: the error is of that order.
        assert!(table.shape.max_delta_e <= 3.0 * found, "{found} against {}", table.shape.max_delta_e);
    }
}

#[test]
fn one_point_and_a_range_of_no_length() {
    let request = request(&soap(), 0, [320.0, 320.0], [30.0, 30.0]);
    let table = ColorTable::build(request.clone(), &Watch::new()).unwrap();
    assert!(worst(&table, &request) < 1e-3);
}

#[test]
fn nodes_make_the_same_table() {
    let table = ColorTable::build(request(&soap(), 0, [0.0, 300.0], [0.0, 40.0]), &Watch::new()).unwrap();
    let again = ColorTable::from_nodes(*table.shape(), table.nodes().to_vec()).unwrap();
    let (mut a, mut b) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    table.evaluate(&[0.0, 150.0, 300.0], &[0.0, 39.0, 40.0], &mut a).unwrap();
    again.evaluate(&[0.0, 150.0, 300.0], &[0.0, 39.0, 40.0], &mut b).unwrap();
    assert_eq!(a, b);
    assert!(ColorTable::from_nodes(*table.shape(), table.nodes()[1..].to_vec()).is_err());
    let mut broken = table.nodes().to_vec();
    broken[5][4] = f32::NAN;
    assert!(ColorTable::from_nodes(*table.shape(), broken).is_err());
    let good = *table.shape();
    for shape in [
        ColorTableShape { rows: 3, ..good },
        ColorTableShape { columns: 1, ..good },
        ColorTableShape { columns: usize::MAX, ..good },
        ColorTableShape { range_nm: [5.0, 1.0], ..good },
        ColorTableShape { range_deg: [0.0, 90.0], ..good },
        ColorTableShape { inverse_square: 4.0, ..good },
        ColorTableShape { white: [0.0; 3], ..good },
        ColorTableShape { max_delta_e: f64::NAN, ..good },
    ] {
        assert!(ColorTable::from_nodes(shape, table.nodes().to_vec()).is_err(), "{shape:?}");
    }
}

#[test]
fn refusals() {
    let message = |request| ColorTable::build(request, &Watch::new()).unwrap_err().to_string();
    let good = request(&soap(), 0, [0.0, 300.0], [0.0, 40.0]);
    assert!(message(ColorTableRequest { layer: 1, ..good.clone() }).contains("varying layer"));
    assert!(message(ColorTableRequest { range_nm: [10.0, 5.0], ..good.clone() }).contains("thickness_nm"));
    assert!(message(ColorTableRequest { range_nm: [0.0, f64::NAN], ..good.clone() }).contains("thickness_nm"));
    assert!(message(ColorTableRequest { range_nm: [0.0, 0.0], ..good.clone() }).contains("thickness_nm"));
    assert!(message(ColorTableRequest { range_deg: [0.0, 90.0], ..good.clone() }).contains("angle_deg"));
    assert!(message(ColorTableRequest { tolerance: 0.0, ..good.clone() }).contains("max_delta_e"));
    assert!(message(ColorTableRequest { range_nm: [0.0, 1e7], ..good.clone() }).contains("fringes"));
    let narrow = ColorTableRequest { range_nm: [100.0, 130.0], range_deg: [30.0, 30.0], ..good.clone() };
    assert!(message(ColorTableRequest { tolerance: 1e-9, ..narrow }).contains("was reached"));
    let stopped = Watch::new();
    stopped.stop();
    assert!(ColorTable::build(good.clone(), &stopped).unwrap_err().to_string().contains("stopped"));
    let table = ColorTable::build(good, &Watch::new()).unwrap();
    let mut out = [[0.0; 3]; 2];
    let wrong = table.evaluate(&[1.0, 301.0], &[0.0], &mut out).unwrap_err().to_string();
    assert!(wrong.contains("thickness_nm must be within") && wrong.contains("301 at point 1"), "{wrong}");
    let wrong = table.evaluate(&[1.0, 2.0], &[0.0, f64::NAN], &mut out).unwrap_err().to_string();
    assert!(wrong.contains("angle_deg") && wrong.contains("point 1"), "{wrong}");
    assert!(table.evaluate(&[1.0], &[0.0], &mut out).is_err());
    table.evaluate(&[], &[0.0], &mut []).unwrap();
}

/// Places come in doubles, so that all levels find the same cell (or its neighbour, at whose edge both agree); weights and
/// sums of 32 products of single precision leave 32 roundings of 6e-8.
#[test]
fn every_level_looks_up_the_same() {
    let table = ColorTable::build(request(&soap(), 0, [0.0, 900.0], [0.0, 70.0]), &Watch::new()).unwrap();
    let t: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.754_877_666).fract() * 900.0).collect();
    let angle: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.569_840_29).fract() * 70.0).collect();
    let mut wanted = vec![[0.0; 3]; 5000];
    table.evaluate(&t, &angle, &mut wanted).unwrap();
    for level in crate::stack::sweep::levels() {
        let mut found = vec![[f64::NAN; 3]; 5000];
        table.evaluate_at(level, &t, &angle, &mut found);
        for (a, b) in found.as_flattened().iter().zip(wanted.as_flattened()) {
            assert!((a - b).abs() < 32.0 * 6e-8, "{level:?}: {a} {b}");
        }
    }
}
