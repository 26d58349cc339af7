//! Every vector of `reference/optics_reference.json` under its own pass rule; the worst error of each category is shown
//! by `cargo test -p iridesce-optics --test reference_vectors -- --nocapture`, as a multiple of what is allowed.

use std::collections::BTreeMap;

use iridesce_optics::incidence::Incidence;
use iridesce_optics::stack::sweep::{Operand, Power, Quantity, Sweep, SweepRequest, levels};
use iridesce_optics::{Complex64, Polarization, stack};
use serde_json::Value;

const REFERENCE: &str = include_str!("reference/optics_reference.json");

fn reference() -> Value {
    serde_json::from_str(REFERENCE).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(number(&value[0]), number(&value[1]))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn polarization(value: &Value) -> Polarization {
    Polarization::named(value["pol"].as_str().unwrap()).unwrap()
}

/// Worst error over what is allowed, for every category and quantity.
#[derive(Default)]
struct Worst(BTreeMap<(String, &'static str), (f64, String)>);

impl Worst {
    fn add(&mut self, category: &str, quantity: &'static str, id: &str, error: f64, allowed: f64) {
        let ratio = if error <= 0.0 { 0.0 } else { error / allowed };
        // NaN must count as a failure, not vanish in a comparison.
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        let entry = self.0.entry((category.to_string(), quantity)).or_insert((-1.0, String::new()));
        if ratio > entry.0 {
            *entry = (ratio, format!("{id}: error {error:.3e}, allowed {allowed:.3e}"));
        }
    }

    fn report(&self) -> String {
        let line = |((category, quantity), (ratio, text)): (&(String, &str), &(f64, String))| {
            format!("{ratio:10.2e} of the allowance  {category:<18} {quantity:<8} {text}\n")
        };
        self.0.iter().map(line).collect()
    }

    fn failures(&self) -> usize {
        self.0.values().filter(|(ratio, _)| *ratio > 1.0).count()
    }

    fn finish(&self, title: &str) {
        let report = self.report();
        println!("{title}\n{report}");
        assert_eq!(self.failures(), 0, "{title}: beyond the pass rule\n{report}");
    }
}

/// A reference case as arguments of `solve_angle`.
struct Case {
    n: Vec<Complex64>,
    d_nm: Vec<f64>,
    coherent: Vec<bool>,
    wavelength_nm: f64,
    angle_deg: f64,
}

impl Case {
    fn read(case: &Value) -> Case {
        let n: Vec<Complex64> = case["n"].as_array().unwrap().iter().map(complex).collect();
        let d_nm = numbers(&case["d_nm"]);
        let coherent = vec![true; d_nm.len()];
        Case { n, d_nm, coherent, wavelength_nm: number(&case["wavelength_nm"]), angle_deg: number(&case["angle_deg"]) }
    }

    fn solve(&self, polarization: Polarization) -> stack::Response {
        let (n, d) = (&self.n, &self.d_nm);
        stack::solve_angle(n, d, &self.coherent, self.wavelength_nm, self.angle_deg, polarization).unwrap()
    }

    fn critical_within(&self, degrees: f64) -> bool {
        let sine = self.n[self.n.len() - 1].re / self.n[0].re;
        sine <= 1.0 && (sine.asin().to_degrees() - self.angle_deg).abs() < degrees
    }
}

/// |T - T_ref| and, wherever T_ref is a normal number well above underflow, T / T_ref.
fn check_power(worst: &mut Worst, category: &str, id: &str, got: f64, case: &Value) {
    let reference = number(&case["T40"]);
    worst.add(category, "T", id, (got - reference).abs(), 1e-12 + 1e3 * number(&case["dT_ulp"]));
    if reference > 1e-300 {
        worst.add(category, "T/Tref", id, (got / reference - 1.0).abs(), 1e-9);
    }
}

#[test]
fn coherent_cases() {
    let reference = reference();
    let cases = reference["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 186);
    let mut worst = Worst::default();
    for value in cases {
        let (id, category) = (value["id"].as_str().unwrap(), value["category"].as_str().unwrap());
        let case = Case::read(value);
        let response = case.solve(polarization(value));
        let slack = 1e3 * number(&value["dR_ulp"]);
        let reflectance = response.reflectance - number(&value["R40"]);
        worst.add(category, "R", id, reflectance.abs(), 1e-12 + slack);
        check_power(&mut worst, category, id, response.transmittance, value);

        let amplitudes = response.amplitudes.unwrap();
        if !(case.d_nm.is_empty() && case.critical_within(1e-6)) {
            let (r, t) = (complex(&value["r40"]), complex(&value["t40"]));
            worst.add(category, "r", id, (amplitudes.r - r).norm(), 1e-11 + slack);
            if t.norm() > 1e-290 {
                worst.add(category, "t/tref", id, (amplitudes.t / t - 1.0).norm(), 1e-9);
            }
        }

        if value.get("A_layer40").is_some() {
            let incidence = Incidence::from_degrees(case.angle_deg).unwrap();
            let polarization = polarization(value);
            let (n, d, wavelength) = (&case.n, &case.d_nm, case.wavelength_nm);
            let layers = stack::layer_absorptance(n, d, &case.coherent, wavelength, incidence, polarization).unwrap();
            for (got, reference) in layers.iter().zip(numbers(&value["A_layer40"])) {
                worst.add(category, "A_layer", id, (got - reference).abs(), 1e-11);
            }
        }
    }
    worst.finish("coherent stacks");
}

/// R and T of the vector kernels at every level of SIMD, under the same rule.
#[test]
fn coherent_cases_by_vectors() {
    let reference = reference();
    let mut worst = Worst::default();
    let mut covered = 0;
    for value in reference["cases"].as_array().unwrap() {
        let (id, category) = (value["id"].as_str().unwrap(), value["category"].as_str().unwrap());
        let case = Case::read(value);
        let one = |values| Operand { values, strides: Vec::new() };
        for level in levels() {
            let [reflectance, transmittance] = [Power::Reflectance, Power::Transmittance].map(|power| {
                let request = SweepRequest {
                    quantity: Quantity::Power(power),
                    polarization: polarization(value),
                    coherent: vec![true; case.d_nm.len()],
                    indices: case.n.iter().map(std::slice::from_ref).collect(),
                    shape: Vec::new(),
                    wavelength_nm: one(std::slice::from_ref(&case.wavelength_nm)),
                    angle_deg: one(std::slice::from_ref(&case.angle_deg)),
                    thickness_nm: case.d_nm.iter().map(|d| one(std::slice::from_ref(d))).collect(),
                };
                let mut out = [f64::NAN];
                let sweep = Sweep::at_level(request, level).unwrap();
                sweep.is_vectorised().then(|| sweep.evaluate(&mut out).map(|()| out[0]).unwrap())
            });
            let (Some(reflectance), Some(transmittance)) = (reflectance, transmittance) else {
                continue;
            };
            covered += 1;
            let allowed = 1e-12 + 1e3 * number(&value["dR_ulp"]);
            worst.add(category, "R", id, (reflectance - number(&value["R40"])).abs(), allowed);
            check_power(&mut worst, category, id, transmittance, value);
        }
    }
    println!("{covered} of {} cases and levels", 186 * levels().len());
    assert!(covered > 160 * levels().len(), "{covered}");
    worst.finish("coherent stacks by vectors");
}

#[test]
fn ellipsometry() {
    let reference = reference();
    let cases = reference["ellipsometry"].as_array().unwrap();
    assert_eq!(cases.len(), 8);
    let mut worst = Worst::default();
    for value in cases {
        let id = value["id"].as_str().unwrap();
        let case = Case::read(value);
        let r_s = case.solve(Polarization::S).amplitudes.unwrap().r;
        let r_p = case.solve(Polarization::P).amplitudes.unwrap().r;
        let (psi_deg, delta_deg) = stack::ellipsometry(r_s, r_p).unwrap();
        worst.add("ellipsometry", "psi", id, (psi_deg - number(&value["psi40"])).abs(), 1e-9);
        worst.add("ellipsometry", "delta", id, (delta_deg - number(&value["delta40"])).abs(), 1e-9);
    }
    worst.finish("ellipsometry");
}

#[test]
fn incoherent_slabs() {
    let reference = reference();
    let cases = reference["incoherent"].as_array().unwrap();
    assert_eq!(cases.len(), 20);
    let mut worst = Worst::default();
    for value in cases {
        let id = value["id"].as_str().unwrap();
        let mut n = vec![complex(&value["n_in"])];
        let (mut d_nm, mut coherent) = (Vec::new(), Vec::new());
        let mut add = |layer: &Value, is_coherent: bool| {
            n.push(complex(&layer[0]));
            d_nm.push(number(&layer[1]));
            coherent.push(is_coherent);
        };
        value["front"].as_array().unwrap().iter().for_each(|layer| add(layer, true));
        add(&value["slab"], false);
        value["back"].as_array().unwrap().iter().for_each(|layer| add(layer, true));
        n.push(complex(&value["n_out"]));
        let (wavelength, angle) = (number(&value["wavelength_nm"]), number(&value["angle_deg"]));
        let response = stack::solve_angle(&n, &d_nm, &coherent, wavelength, angle, polarization(value)).unwrap();
        worst.add("incoherent", "R", id, (response.reflectance - number(&value["R40"])).abs(), 1e-11);
        worst.add("incoherent", "T", id, (response.transmittance - number(&value["T40"])).abs(), 1e-11);
        assert!(response.amplitudes.is_none());
    }
    worst.finish("incoherent slabs");
}

#[test]
fn the_comparison_can_fail() {
    let mut worst = Worst::default();
    worst.add("a", "R", "x", 2e-12, 1e-12);
    worst.add("b", "R", "x", f64::NAN, 1e-12);
    worst.add("c", "R", "x", 0.5e-12, 1e-12);
    assert_eq!(worst.failures(), 2);
}
