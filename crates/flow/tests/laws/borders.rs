//! Frames with borders: mirrors along which a film slips, and menisci that swallow it; how fast all of it goes.

use std::f64::consts::TAU;

use super::*;

fn preset(name: &str) -> Parameters {
    Parameters::preset(name).unwrap()
}

/// Between borders a film does what half of a film does that is twice as wide, repeats, and is its own mirror image.
#[test]
fn a_border_is_a_mirror() {
    let start = |columns: usize, width_m: f64, sides: Sides| {
        let p = Parameters {
            gravity: 9.81,
            viscosity: 1.5e-3,
            surface_viscosity: 1e-7,
            elasticity: 22e-3,
            air_density: 1.184,
            surfactant_diffusivity: 1e-6,
            drains_inside: true,
            tolerance: 1e-12,
            ..bare(Shape::Plane { width_m, height_m: 0.02, sides }, columns, 32)
        };
        film(p, |grid, state| {
            for k in 0..grid.cells() {
                let [x, _, z] = grid.place(k / columns, k % columns);
                let turn = TAU / 0.04 * x;
                state.h[k] = 1e-6 * (1.0 + 0.4 * turn.cos() + 0.3 * (2.0 * turn).cos() * (z / 0.003).sin());
            }
            // Faster than a cell a step in places, so that long ways are seen, too.
            stream(grid, state, |z, x| 8e-4 * (TAU / 0.04 * x).sin() * (z / 0.02 * TAU / 2.0).sin());
        })
    };
    let mut half = start(32, 0.02, Sides::Menisci);
    let mut whole = start(64, 0.04, Sides::Periodic);
    half.advance_to(0.25).unwrap();
    whole.advance_to(0.25).unwrap();
    let (a, b) = (half.state(), whole.state());
    let off = |a: &[f64], b: &[f64]| (0..a.len()).map(|k| (a[k] - b[k / 32 * 64 + k % 32]).abs()).fold(0.0, f64::max);
    let (h, s) = (off(&a.h, &b.h) / 1e-6, off(&a.s, &b.s));
    let speed = off(&a.across, &b.across).max(off(&a.down, &b.down));
    println!("a border against a mirror: thickness off by {h:.1e}, surfactant {s:.1e}, velocity {speed:.1e} m/s");
    assert!(h < 1e-7 && s < 1e-9 && speed < 1e-8);
    assert!(a.across.iter().skip(31).step_by(32).all(|u| *u == 0.0));
    let kept = (half.volume() + a.books.gone()) / a.books.start - 1.0;
    assert!(kept.abs() < 1e-13, "{kept}");
}

/// Residual of ln h(z, t) after the best f(z) + g(t), over the whole spread of ln h: 2 to 12 s, mean over the middle half
/// of the width, at `rows` heights.
fn separability(parameters: Parameters) -> f64 {
    let mut film = Film::new(parameters).unwrap();
    let mut table: Vec<Vec<f64>> = Vec::new();
    for k in 0..=20 {
        film.advance_to(2.0 + 0.5 * f64::from(k)).unwrap();
        let n = film.parameters().columns;
        let rows = film.state().h.chunks_exact(n);
        table.push(rows.map(|row| (row[n / 4..3 * n / 4].iter().sum::<f64>() / (n / 2) as f64).ln()).collect());
    }
    let (times, rows) = (table.len() as f64, table[0].len() as f64);
    let all = table.iter().flatten().sum::<f64>() / times / rows;
    let of_time: Vec<f64> = table.iter().map(|row| row.iter().sum::<f64>() / rows - all).collect();
    let of_height: Vec<f64> =
        (0..table[0].len()).map(|i| table.iter().map(|row| row[i]).sum::<f64>() / times - all).collect();
    let (mut left, mut whole) = (0.0, 0.0);
    for (row, a) in table.iter().zip(&of_time) {
        for (value, b) in row.iter().zip(&of_height) {
            left += (value - all - a - b).powi(2);
            whole += (value - all).powi(2);
        }
    }
    (left / whole).sqrt()
}

/// The frame's sides drain it: its profile keeps its shape.
#[test]
fn a_frame_with_borders_drains_alike_at_all_heights() {
    let dry = |name: &str| Parameters { evaporation: 0.0, ..preset(name) };
    let borders = alone(|| separability(dry("vertical-film-preview")));
    // With a meniscus below that is as narrow as those of the sides 0.076: two thirds of what is left over then lie in the
    // lowest eighth. Without borders at the sides 0.094.
    println!("separability of a vertical film, 192 columns: {borders:.3}");
    assert!(borders < 0.06);
}

/// `speed` multiplies all that takes liquid: a preset named time-lapse loses 8 % of its volume so many times sooner.
#[test]
fn a_time_lapse_keeps_its_word() {
    for name in crate::PRESETS.iter().filter(|name| name.ends_with("-time-lapse")) {
        let natural = name.strip_suffix("-time-lapse").unwrap();
        assert_eq!(preset(name), Parameters { speed: 6.0, ..preset(natural) });
    }
    // Where all that is lost dries, or drains between faces that stand still, it is so to the digit.
    let lost = |speed: f64, time_s: f64| {
        let p = Parameters { speed, regeneration: 0.0, gravity: 1e-9, step_s: 1e-2 / speed, ..small() };
        let mut film = Film::new(p).unwrap();
        film.advance_to(time_s).unwrap();
        1.0 - film.volume() / film.state().books.start
    };
    let (slow, quick) = (lost(1.0, 1.2), lost(6.0, 0.2));
    println!("lost in 1.2 s: {slow:.6}; six times as fast in 0.2 s: {quick:.6}");
    assert!((quick / slow - 1.0).abs() < 1e-9 && slow > 0.05);
    // Where patches rise, the film is not sorted as much by then: within 10 %.
    let until = |speed: f64| {
        let p = Parameters { speed, ..preset("bubble-on-bath-small-preview") };
        let mut film = Film::new(p).unwrap();
        let start = film.volume();
        let mut time_s = 0.0;
        while film.volume() > 0.92 * start {
            time_s += 1.0 / 60.0 / speed;
            film.advance_to(time_s).unwrap();
        }
        time_s
    };
    let ratio = until(1.0) / until(6.0);
    println!("a dome loses 8 % of its volume {ratio:.2} times sooner at speed 6");
    assert!((ratio / 6.0 - 1.0).abs() < 0.1);
}

fn small() -> Parameters {
    Parameters { noise: 0.05, ..preset("bubble-on-bath").with_columns(64) }
}
