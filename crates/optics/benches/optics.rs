//! How fast the optics are on this machine: `cargo bench -p iridesce-optics [-- NAME]`.
//!
//! Each job runs for a while on one thread (two where it says so); the best of many short runs is shown, since
//! other work on the machine can only make a run longer. docs/evidence/performance.md says what bounds each.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use iridesce_optics::color::{
    Adaptation, ColorRequest, ColorTable, ColorTableRequest, Illuminant, Model, Observer, Quantity, Space, StackColor,
};
use iridesce_optics::film::kernel::free_reflectance;
use iridesce_optics::stack::sweep::{Operand, Power, Sweep, SweepRequest, levels};
use iridesce_optics::{Complex64, Medium, Polarization};
use rayon::prelude::*;

/// Time given to each job.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Runs `job` again and again; the rate of the fastest run in millions a second.
fn best(elements: usize, mut job: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut best = f64::INFINITY;
    while begin.elapsed() < PATIENCE {
        let start = Instant::now();
        job();
        best = best.min(start.elapsed().as_secs_f64());
    }
    elements as f64 / best / 1e6
}

fn report(name: &str, rate: f64) {
    println!("{name:<60} {rate:>10.3} M/s");
}

fn range(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
}

fn real(n: f64) -> Vec<Complex64> {
    vec![Complex64::new(n, 0.0)]
}

/// A stack over wavelengths x angles x thicknesses, the thicknesses the same for all layers.
struct Grid {
    indices: Vec<Vec<Complex64>>,
    shape: [usize; 3],
    wavelength_nm: Vec<f64>,
    angle_deg: Vec<f64>,
    thickness_nm: Vec<Vec<f64>>,
}

impl Grid {
    fn new(indices: Vec<Vec<Complex64>>, thicknesses: usize, thickest_nm: f64) -> Grid {
        let layers = indices.len() - 2;
        Grid {
            indices,
            shape: [471, 90, thicknesses],
            wavelength_nm: range(360.0, 830.0, 471),
            angle_deg: range(0.0, 89.0, 90),
            thickness_nm: (0..layers).map(|j| range(1.0, thickest_nm + 3.0 * j as f64, thicknesses)).collect(),
        }
    }

    fn sweep(&self, power: Power, polarization: Polarization, level: Level) -> Sweep<'_> {
        let request = SweepRequest {
            quantity: iridesce_optics::stack::sweep::Quantity::Power(power),
            polarization,
            coherent: vec![true; self.thickness_nm.len()],
            indices: self.indices.iter().map(Vec::as_slice).collect(),
            shape: self.shape.to_vec(),
            wavelength_nm: Operand { values: &self.wavelength_nm, strides: vec![1, 0, 0] },
            angle_deg: Operand { values: &self.angle_deg, strides: vec![0, 1, 0] },
            thickness_nm: self.thickness_nm.iter().map(|values| Operand { values, strides: vec![0, 0, 1] }).collect(),
        };
        Sweep::at_level(request, level).expect("sound")
    }

    fn count(&self) -> usize {
        self.shape.iter().product()
    }
}

fn sweeps(chosen: &dyn Fn(&str) -> bool) {
    let film = Grid::new(vec![real(1.0), real(1.33), real(1.0)], 200, 2000.0);
    let mut small = Grid::new(vec![real(1.0), real(1.33), real(1.0)], 200, 2000.0);
    small.shape[0] = 5;
    let coat = Grid::new(vec![real(1.0), real(1.38), real(1.52)], 200, 2000.0);
    let oxide = Grid::new(vec![real(1.0), real(1.46), vec![Complex64::new(4.08, 0.028)]], 200, 2000.0);
    let metal = Grid::new(vec![real(1.0), vec![Complex64::new(0.06, 3.6)], real(1.52)], 200, 80.0);
    let mut ten = vec![real(1.0)];
    ten.extend((0..10).map(|j| real(if j % 2 == 0 { 2.35 } else { 1.46 })));
    ten.push(real(1.52));
    let mut lossy = ten.clone();
    for n in lossy.iter_mut().skip(1).step_by(2) {
        n[0].im = 1e-3;
    }
    let (ten, lossy) = (Grid::new(ten, 10, 100.0), Grid::new(lossy, 10, 100.0));
    let jobs = [
        ("film 471 x 90 x 200, R unpolarised", &film, Power::Reflectance, Polarization::Unpolarized),
        ("film 5 x 90 x 200, R unpolarised", &small, Power::Reflectance, Polarization::Unpolarized),
        ("film 471 x 90 x 200, R of s", &film, Power::Reflectance, Polarization::S),
        ("film 471 x 90 x 200, T unpolarised", &film, Power::Transmittance, Polarization::Unpolarized),
        ("coat on glass 471 x 90 x 200, R unpolarised", &coat, Power::Reflectance, Polarization::Unpolarized),
        ("oxide on silicon 471 x 90 x 200, R unpolarised", &oxide, Power::Reflectance, Polarization::Unpolarized),
        ("silver film 471 x 90 x 200, R unpolarised", &metal, Power::Reflectance, Polarization::Unpolarized),
        ("ten layers 471 x 90 x 10, R unpolarised", &ten, Power::Reflectance, Polarization::Unpolarized),
        ("ten layers, five absorbing, R unpolarised", &lossy, Power::Reflectance, Polarization::Unpolarized),
        ("ten layers, five absorbing, A unpolarised", &lossy, Power::Absorptance, Polarization::Unpolarized),
    ];
    for (name, grid, power, polarization) in jobs {
        let mut out = vec![0.0; grid.count()];
        for level in levels() {
            let name = format!("{name}, {level:?}");
            if chosen(&name) {
                let sweep = grid.sweep(power, polarization, level);
                report(&name, best(grid.count(), || sweep.evaluate(black_box(&mut out)).unwrap()));
            }
        }
    }
}

/// The jobs of docs/evidence/performance.md on one thread and on two.
fn threads(chosen: &dyn Fn(&str) -> bool) {
    let film = Grid::new(vec![real(1.0), real(1.33), real(1.0)], 200, 2000.0);
    let mut ten = vec![real(1.0)];
    ten.extend((0..10).map(|j| real(if j % 2 == 0 { 2.35 } else { 1.46 })));
    ten.push(real(1.52));
    let ten = Grid::new(ten, 10, 100.0);
    let mut out = vec![0.0; film.count()];
    for (name, grid) in [("film 471 x 90 x 200", &film), ("ten layers 471 x 90 x 10", &ten)] {
        for threads in [1, 2] {
            let name = format!("threads: {name}, {threads} threads");
            if chosen(&name) {
                let sweep = grid.sweep(Power::Reflectance, Polarization::Unpolarized, Level::new());
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let out = &mut out[..grid.count()];
                let run = || {
                    best(grid.count(), || {
                        let mut tasks = sweep.tasks(black_box(&mut *out), &mut []).expect("as long as the shape says");
                        tasks.par_iter_mut().try_for_each(|task| sweep.run(task)).unwrap();
                    })
                };
                report(&name, pool.install(run));
            }
        }
    }
}

fn single_precision(chosen: &dyn Fn(&str) -> bool) {
    let film = Grid::new(vec![real(1.0), real(1.33), real(1.0)], 200, 2000.0);
    let mut out = vec![0.0_f32; film.count()];
    for level in levels() {
        let name = format!("film 471 x 90 x 200, f32, R unpolarised, {level:?}");
        if chosen(&name) {
            let sweep = film.sweep(Power::Reflectance, Polarization::Unpolarized, level);
            report(&name, best(film.count(), || sweep.evaluate_single(black_box(&mut out)).unwrap()));
        }
    }
}

/// Films as the renderer asks for them, one hit of 32 nodes after the other: how long it waits for each, and what hits side by
/// side could save. Rates are of hits.
fn hits(chosen: &dyn Fn(&str) -> bool) {
    const COUNT: usize = 100_000;
    let level = Level::new();
    let cosines: Vec<f32> = (0..1024).map(|i| 0.1 + 0.8 * i as f32 / 1024.0).collect();
    if chosen("hits of a film, none waits for another") {
        let job = || dispatch!(level, simd => apart(simd, COUNT, black_box(&cosines)));
        report("hits of a film, none waits for another", best(COUNT, || _ = black_box(job())));
    }
    if chosen("hits of a film, each waits for the last") {
        let job = || dispatch!(level, simd => chains::<1, _>(simd, COUNT, black_box([0.5])));
        report("hits of a film, each waits for the last", best(COUNT, || _ = black_box(job())));
    }
    if chosen("hits of a film, two such chains side by side") {
        let job = || dispatch!(level, simd => chains::<2, _>(simd, COUNT, black_box([0.5, 0.4])));
        report("hits of a film, two such chains side by side", best(COUNT, || _ = black_box(job())));
    }
}

/// What a film sends back at one hit, summed over two blocks of nodes.
#[inline(always)]
fn hit<S: Simd>(simd: S, cos_theta: f32, thickness_nm: f32) -> f32x16<S> {
    let cos = f32x16::splat(simd, cos_theta);
    // Soap in air, at the ends of the spectrum.
    let mut sum = f32x16::splat(simd, 0.0);
    // (A closure would be compiled without the instructions of the level.)
    for (contrast, rate) in [(0.77, 2.0 / 700.0), (0.79, 2.0 / 450.0)] {
        let rate = f32x16::splat(simd, rate * thickness_nm);
        let [s, p] = free_reflectance(f32x16::splat(simd, contrast), cos, rate);
        sum = sum + s + p;
    }
    sum
}

#[inline(always)]
fn apart<S: Simd>(simd: S, count: usize, cosines: &[f32]) -> f32 {
    let mut sum = f32x16::splat(simd, 0.0);
    for i in 0..count {
        sum += hit(simd, cosines[i % 1024], 300.0);
    }
    sum.reduce_sum()
}

/// Chains of hits, each at an angle that hangs on the light of the last.
#[inline(always)]
fn chains<const SIDE_BY_SIDE: usize, S: Simd>(simd: S, count: usize, mut cosines: [f32; SIDE_BY_SIDE]) -> f32 {
    let from = cosines;
    for _ in 0..count / SIDE_BY_SIDE {
        for (cos, from) in cosines.iter_mut().zip(from) {
            *cos = from + 1e-9 * hit(simd, *cos, 300.0).reduce_sum();
        }
    }
    cosines.iter().sum()
}

fn colors(chosen: &dyn Fn(&str) -> bool) {
    let oxide = Complex64::new(4.08, 0.028);
    let film = vec![Complex64::from(1.0), Complex64::from(1.33), Complex64::from(1.0)];
    let wafer = vec![Complex64::from(1.0), Complex64::from(1.46), oxide];
    let mut ten = vec![Complex64::from(1.0)];
    ten.extend((0..10).map(|j| Complex64::from(if j % 2 == 0 { 2.35 } else { 1.46 })));
    ten.push(Complex64::from(1.52));
    for (name, n, space) in [
        ("colour, film, 0 to 2000 nm, XYZ", &film, Space::Xyz),
        ("colour, film, 0 to 2000 nm, sRGB", &film, Space::Srgb),
        ("colour, oxide on silicon, sRGB", &wafer, Space::Srgb),
        ("colour, ten layers, one varies, sRGB", &ten, Space::Srgb),
        ("colour, ten layers, all vary, sRGB", &ten, Space::Srgb),
    ] {
        for threads in [1, 2] {
            let name = format!("{name}, {threads} threads");
            if !chosen(&name) {
                continue;
            }
            let layers = n.len() - 2;
            let points = 16_384 / layers;
            let thickness: Vec<f64> = (0..points)
                .flat_map(|i| {
                    let share = i as f64 / points as f64;
                    (0..layers).map(move |j| if layers == 1 { 2000.0 * share } else { 100.0 * share + 3.0 * j as f64 })
                })
                .collect();
            let thickness = if name.contains("one varies") { only_third(&thickness, layers) } else { thickness };
            let made = StackColor::new(color_request(n, space)).unwrap();
            let angle = vec![0.0; points];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            report(&name, pool.install(|| best(points, || drop(black_box(made.colors(&thickness, &angle).unwrap())))));
        }
    }
}

fn tables(chosen: &dyn Fn(&str) -> bool) {
    let name = "colour table, 0 to 2000 nm x 0 to 80 deg";
    if !chosen(name) {
        return;
    }
    let request = ColorTableRequest {
        color: color_request(&[1.0, 1.33, 1.0].map(Complex64::from), Space::Xyz),
        thickness_nm: vec![0.0],
        layer: 0,
        range_nm: [0.0, 2000.0],
        range_deg: [0.0, 80.0],
        tolerance: 0.1,
    };
    let start = Instant::now();
    let table = ColorTable::build(request, &iridesce_numerics::Watch::new()).unwrap();
    println!("{name}, built in {:.3} s: {:?}", start.elapsed().as_secs_f64(), table.shape());
    let points = 1 << 20;
    // A hash of the place: neighbours in the list are no neighbours in the table.
    let share = |i: usize, k: usize| (i.wrapping_mul(k) % 1_048_583) as f64 / 1_048_583.0;
    let thickness: Vec<f64> = (0..points).map(|i| 2000.0 * share(i, 7_368_787)).collect();
    let angle: Vec<f64> = (0..points).map(|i| 80.0 * share(i, 5_915_587)).collect();
    let mut out = vec![[0.0; 3]; points];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rate = pool.install(|| best(points, || table.evaluate(&thickness, &angle, black_box(&mut out)).unwrap()));
        report(&format!("{name}, random points, {threads} threads"), rate);
    }
}

/// What bounds the jobs above: the clock, divisions in vectors, and writing to memory.
fn bounds(chosen: &dyn Fn(&str) -> bool) {
    if chosen("bound: clock") {
        let steps = 10_000_000_u64;
        let cycles = best(2 * steps as usize, || {
            let mut sum = black_box(1_u64);
            for _ in 0..steps {
                // An or and an addition, each waiting for the one before: two cycles.
                sum = sum.wrapping_add(sum | 1);
            }
            black_box(sum);
        });
        report("bound: clock, by a chain of additions", cycles);
    }
    let level = Level::new();
    if chosen("bound: divisions, f64") {
        let (a, mut b) = (range(1.0, 2.0, 1024), range(1.1, 1.9, 1024));
        report("bound: divisions, f64", best(1024 * 256, || dispatch!(level, simd => divide(simd, &a, &mut b))));
    }
    if chosen("bound: divisions, f32") {
        let single = |values: Vec<f64>| values.into_iter().map(|v| v as f32).collect::<Vec<f32>>();
        let (a, mut b) = (single(range(1.0, 2.0, 1024)), single(range(1.1, 1.9, 1024)));
        report("bound: divisions, f32", best(1024 * 256, || dispatch!(level, simd => divide_single(simd, &a, &mut b))));
    }
    if chosen("bound: writing f64") {
        let mut out = vec![0.0_f64; 471 * 90 * 200];
        report("bound: writing f64", best(out.len(), || black_box(&mut out).fill(black_box(0.5))));
    }
}

#[inline(always)]
fn divide<S: Simd>(simd: S, a: &[f64], b: &mut [f64]) {
    for _ in 0..256 {
        for (a, b) in a.chunks_exact(S::f64s::LEN).zip(black_box(&mut *b).chunks_exact_mut(S::f64s::LEN)) {
            // (Back and forth between a / b and b, so that the digits stay irregular.)
            (S::f64s::from_slice(simd, a) / S::f64s::from_slice(simd, b)).store_slice(b);
        }
    }
}

#[inline(always)]
fn divide_single<S: Simd>(simd: S, a: &[f32], b: &mut [f32]) {
    for _ in 0..256 {
        for (a, b) in a.chunks_exact(S::f32s::LEN).zip(black_box(&mut *b).chunks_exact_mut(S::f32s::LEN)) {
            (S::f32s::from_slice(simd, a) / S::f32s::from_slice(simd, b)).store_slice(b);
        }
    }
}

/// The same points with all layers but the third held at 80 nm.
fn only_third(thickness: &[f64], layers: usize) -> Vec<f64> {
    thickness.iter().enumerate().map(|(i, t)| if i % layers == 2 { *t } else { 80.0 }).collect()
}

fn color_request(n: &[Complex64], space: Space) -> ColorRequest {
    ColorRequest {
        media: n.iter().map(|n| Medium::constant(*n).unwrap()).collect(),
        coherent: vec![true; n.len() - 2],
        illuminant: Illuminant::named("D65").unwrap(),
        observer: Observer::Cie1931,
        polarization: Polarization::Unpolarized,
        quantity: Quantity::Reflectance,
        model: Model::Exact,
        grid: None,
        space,
        adaptation: Adaptation::None,
        gamut: None,
    }
}

fn main() {
    // `cargo bench` passes --bench; other arguments are parts of names.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let chosen = |name: &str| wanted.iter().all(|part| name.contains(part.as_str()));
    sweeps(&chosen);
    single_precision(&chosen);
    hits(&chosen);
    colors(&chosen);
    tables(&chosen);
    threads(&chosen);
    bounds(&chosen);
}
