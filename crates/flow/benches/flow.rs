//! What a step of a flowing film costs: `cargo bench -p iridesce-flow`.
//!
//! A windy free bubble, the hardest preset, from its start to 0.1 s, then steps of 5 ms one by one on one and on two
//! threads. The best step and the median are shown, since other work on a machine can only make a step longer; on one
//! thread also the time that the processor spent (Linux), which other work changes least.
//!
//! Each pass stands beside its bound: the bytes that it must move through memory, at the rate that this run measures, and
//! then its operations, at the rate of this run in vectors that stay in registers. docs/guide/living-films.md says more.
//!
//! `cargo bench -p iridesce-flow -- previews`: what a picture of a preview costs, on one thread as in a browser.
//! `cargo bench -p iridesce-flow -- black`: what a step costs more where black film has a share of cells.

use std::sync::OnceLock;
use std::time::Instant;

use iridesce_flow::{Film, PRESETS, Parameters};
use iridesce_thickness::ThicknessMap;

const SIZES: [(usize, usize); 3] = [(256, 60), (512, 30), (1024, 20)];
const START_S: f64 = 0.1;
const STEP_S: f64 = 5e-3;
/// Of a preview.
const PICTURES: u32 = 60;
/// Of films with black film and without.
const STEPS: u32 = 40;

/// Seconds since the program first asked.
fn clock() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// Time that the processor spent on all threads of this program so far, s.
fn busy() -> Option<f64> {
    let mut total = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        total += text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9;
    }
    Some(total)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// `a = b + 2 c` over numbers that no cache holds, GB/s: 24 bytes each, 32 with the line that is read before it is written.
fn memory(threads: usize) -> f64 {
    use rayon::prelude::*;
    const COUNT: usize = 1 << 23;
    let (mut a, b, c) = (vec![0.0_f64; COUNT], vec![1.0_f64; COUNT], vec![2.0_f64; COUNT]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let best = (0..20)
        .map(|_| {
            let start = Instant::now();
            pool.install(|| {
                a.par_chunks_mut(1 << 16).zip(b.par_chunks(1 << 16)).zip(c.par_chunks(1 << 16)).for_each(
                    |((a, b), c)| {
                        a.iter_mut().zip(b.iter().zip(c)).for_each(|(a, (b, c))| *a = b + 2.0 * c);
                    },
                );
            });
            std::hint::black_box(&a);
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    32.0 * COUNT as f64 / best / 1e9
}

/// Operations a second of vectors in registers, in G: products and sums in turn, not fused, as the passes have them.
fn operations(threads: usize) -> f64 {
    use rayon::prelude::*;
    const LANES: usize = 64;
    const ROUNDS: usize = 200_000;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let best = (0..10)
        .map(|_| {
            let start = Instant::now();
            pool.install(|| {
                (0..threads).into_par_iter().for_each(|_| {
                    let mut values: [f64; LANES] = std::array::from_fn(|k| 1.0 + k as f64 * 1e-3);
                    let (scale, add) = std::hint::black_box((0.999_999, 1e-6));
                    fearless_simd::dispatch!(iridesce_numerics::simd::level_or_best(), _simd => turn(&mut values, ROUNDS, scale, add));
                    std::hint::black_box(&values);
                });
            });
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    (2 * LANES * ROUNDS * threads) as f64 / best / 1e9
}

#[inline(always)]
fn turn(values: &mut [f64; 64], rounds: usize, scale: f64, add: f64) {
    for _ in 0..rounds {
        for value in values.iter_mut() {
            *value = *value * scale + add;
        }
    }
}

/// What a pass moves and computes, a cell: numbers of eight bytes, of which one that is written counts twice (its line is
/// read first), and operations (a division, a root or a choice counts as one). Both are counted in the sources.
struct Pass {
    name: &'static str,
    moved: [f64; 2],
    operations: [f64; 2],
}

/// Per step, and per sub-step (thickness) or iteration (tension). Operations of a transform of n numbers: 2.5 n log2 n.
fn passes(columns: usize) -> [Pass; 5] {
    let transform = 2.0 * 2.5 * (columns as f64).log2();
    let tridiagonal = 10.0;
    [
        // Both velocities, once; across: thickness, velocities, fluxes and half a step; down: those again.
        Pass { name: "thickness", moved: [2.0, 12.0], operations: [4.0, 160.0] },
        // Ghosts 6, middles 6, ways 6, drag 4, velocities 12, surfactant 8.
        Pass { name: "trace and carry", moved: [42.0, 0.0], operations: [770.0, 0.0] },
        // Air 14, push 14, right side 5, pull 8, viscosities 1, strain 6, checks 5.
        Pass { name: "forces", moved: [53.0, 0.0], operations: [115.0, 0.0] },
        // Means 3, first residual 6, pivots 1; transforms and systems 11.5, products 2, direction 3, matrix 5, step 6.
        Pass { name: "tension", moved: [10.0, 27.5], operations: [20.0, transform + tridiagonal + 27.0] },
        // Vorticity 4, pivots 2, transforms and systems 13, mean flow 3, stream function 6.
        Pass { name: "viscosity", moved: [28.0, 0.0], operations: [transform + 2.0 * tridiagonal + 25.0, 0.0] },
    ]
}

/// Time that the processor spent so far where that can be known, which other work on a machine changes little, s.
fn spent() -> f64 {
    busy().unwrap_or_else(clock)
}

/// Thirty pictures a second of each preview, after its first second.
fn previews() {
    println!(
        "ms of processor time a picture of 1/30 s, median; sub-steps, iterations of its last step; ms of each part"
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for preset in PRESETS.iter().filter(|name| name.ends_with("-preview")) {
        pool.install(|| {
            let mut film = Film::new(Parameters::preset(preset).expect("a preset")).expect("a film");
            film.time_with(spent);
            film.advance_to(1.0).expect("it flows");
            let before = film.spent();
            let times: Vec<f64> = (1..=PICTURES)
                .map(|k| {
                    let start = spent();
                    film.advance_to(1.0 + f64::from(k) / 30.0).expect("it flows");
                    (spent() - start) * 1e3
                })
                .collect();
            let (substeps, iterations) = film.effort();
            print!("{preset:<29} {:5.2} ms; {substeps:>2}, {iterations};", median(times));
            for ((name, before), (_, after)) in before.into_iter().zip(film.spent()) {
                print!(" {name} {:.2}", (after - before) * 1e3 / f64::from(PICTURES));
            }
            println!();
        });
    }
}

/// `late` when a fifth of it is black, and the same stirred for a second: steps with the share of black film and, of a film that
/// knows none, without it, in turn.
fn black() {
    println!("ms a step of 5 ms on one thread, the least of {STEPS}: without the share of black film, with it");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let still = Parameters { rupture_m: 0.0, ..Parameters::preset("late").expect("a preset") };
        let windy = Parameters { wind: 0.1, eddies: 0.1, ..still.clone() };
        let of = |film: &Film| {
            let Parameters { columns, rows, .. } = *film.parameters();
            ThicknessMap::new(columns, rows, film.thickness_nm()).expect("a map")
        };
        let mut film = Film::new(still.clone()).expect("a film");
        film.advance_to(5.0).expect("it flows");
        let mut stirred = Film::starting_from(windy.clone(), &of(&film)).expect("a film");
        stirred.advance_to(1.0).expect("it flows");
        for (name, parameters, map) in [("late", still, of(&film)), ("stirred", windy, of(&stirred))] {
            let plain = Parameters { black_below_m: 0.0, black_m: 0.0, spots: 0.0, ..parameters.clone() };
            let mut films = [plain, parameters].map(|p| Film::starting_from(p, &map).expect("a film"));
            let mut best = [f64::INFINITY; 2];
            for k in 1..=STEPS {
                for (film, best) in films.iter_mut().zip(&mut best) {
                    let start = clock();
                    film.advance_to(f64::from(k) * STEP_S).expect("it flows");
                    *best = best.min((clock() - start) * 1e3);
                }
            }
            let [without, with] = best;
            let share = films[1].summary().black_share;
            assert_eq!(films.map(|film| film.black_share().is_some()), [false, true]);
            println!("{name:<8} {share:.3} black: {without:.2}, {with:.2} ms: {:.2} times", with / without);
        }
    });
}

fn main() {
    if std::env::args().any(|word| word == "black") {
        return black();
    }
    if std::env::args().any(|word| word == "previews") {
        return previews();
    }
    let only = std::env::args().find_map(|word| word.parse::<usize>().ok());
    let rates = [1, 2].map(|threads| (memory(threads), operations(threads)));
    for (threads, (bytes, operations)) in [1, 2].into_iter().zip(rates) {
        println!("{threads} threads: {bytes:.1} GB/s, {operations:.1} G operations/s");
    }
    println!(
        "ms a step of 5 ms: best, median; processor time a step; sub-steps, iterations; ms of each pass and its bound"
    );
    for (columns, steps) in SIZES.into_iter().filter(|(columns, _)| only.is_none_or(|only| only == *columns)) {
        // Patches need a grid of their own; they cost nothing that could be seen here.
        let parameters = Parameters { regeneration: 0.0, ..Parameters::preset("free-bubble").expect("a preset") };
        let parameters = parameters.with_columns(columns);
        for (threads, (gigabytes, giga)) in [1, 2].into_iter().zip(rates) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                let mut film = Film::new(parameters.clone()).expect("a film");
                film.time_with(clock);
                film.advance_to(START_S).expect("it flows");
                let (before, shares) = (busy(), film.spent());
                let times: Vec<f64> = (1..=steps)
                    .map(|k| {
                        let start = Instant::now();
                        film.advance_to(START_S + k as f64 * STEP_S).expect("it flows");
                        start.elapsed().as_secs_f64() * 1e3
                    })
                    .collect();
                let spent = busy().zip(before).map_or(f64::NAN, |(after, before)| after - before) * 1e3 / steps as f64;
                let best = times.iter().copied().fold(f64::INFINITY, f64::min);
                let (substeps, iterations) = film.effort();
                print!(
                    "{columns:>5} x {:<4} {threads} threads: {best:7.1} {:7.1} ms; {spent:7.1} ms; {substeps}, {iterations};",
                    parameters.rows,
                    median(times)
                );
                let spent = film.spent();
                let took = |name: &str| -> f64 {
                    let own = shares.iter().zip(&spent).filter(|((own, _), _)| *own == name);
                    own.map(|((_, before), (_, after))| (after - before) * 1e3 / steps as f64).sum()
                };
                print!(" sources {:.1}", took("sources"));
                let cells = (columns * parameters.rows) as f64;
                let (mut all, mut bounds) = (0.0, 0.0);
                for Pass { name, moved, operations } in passes(columns) {
                    let times = [1.0, if name == "thickness" { substeps as f64 } else { iterations as f64 }];
                    let [numbers, operations] =
                        [moved, operations].map(|of| of.iter().zip(times).map(|(a, b)| a * b).sum::<f64>() * cells);
                    let bound = 8.0 * numbers / gigabytes / 1e6 + operations / giga / 1e6;
                    print!("; {name} {:.1} (bound {bound:.1}, {:.2})", took(name), took(name) / bound);
                    (all, bounds) = (all + took(name), bounds + bound);
                }
                println!("; together {:.2} times the bound", all / bounds);
            });
        }
    }
}
