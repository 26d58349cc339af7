//! What a step of a flowing film costs: `cargo bench -p iridesce-flow`.
//!
//! A windy free bubble, the hardest preset, from its start to 0.1 s, then steps of 5 ms one by one on one and on two
//! threads. The best step and the median are shown, since other work on a machine can only make a step longer; on one
//! thread also the time that the processor spent (Linux), which other work changes least. docs/guide/living-films.md says
//! what bounds a step.

use std::sync::OnceLock;
use std::time::Instant;

use iridesce_flow::{Film, Parameters};

const SIZES: [(usize, usize); 3] = [(256, 60), (512, 30), (1024, 20)];
const START_S: f64 = 0.1;
const STEP_S: f64 = 5e-3;

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

fn main() {
    let only = std::env::args().find_map(|word| word.parse::<usize>().ok());
    println!("memory: {:.1} GB/s on one thread, {:.1} on two", memory(1), memory(2));
    println!("ms a step of 5 ms: best, median; processor time a step; sub-steps, iterations; shares of the time");
    for (columns, steps) in SIZES.into_iter().filter(|(columns, _)| only.is_none_or(|only| only == *columns)) {
        // Patches need a grid of their own; they cost nothing that could be seen here.
        let parameters = Parameters { regeneration: 0.0, ..Parameters::preset("free-bubble").expect("a preset") };
        let parameters = parameters.with_columns(columns);
        for threads in [1, 2] {
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
                for ((name, before), (_, after)) in shares.iter().zip(film.spent()) {
                    print!(" {name} {:.1}", (after - before) * 1e3 / steps as f64);
                }
                println!();
            });
        }
    }
}
