//! Gains, losses, events; what must not depend on chance: threads, checkpoints, steps.

use super::*;
use crate::error::FlowError;

fn small(name: &str) -> Parameters {
    // 512 columns hold the preset's patches; wider patches need fewer.
    Parameters { patch_m: 4e-3, ..Parameters::preset(name).unwrap().with_columns(160) }
}

#[test]
fn no_liquid_and_no_surfactant_is_lost() {
    let mut film = Film::new(Parameters {
        regeneration: 0.4,
        spots: 4e4,
        spot_below_m: 300e-9,
        thickness_m: 200e-9,
        ..small("bubble-on-bath")
    })
    .unwrap();
    let surfactant = film.surfactant();
    film.advance_to(1.0).unwrap();
    let books = film.state().books;
    let off = (film.volume() + books.gone()) / books.start - 1.0;
    let shares = [books.evaporated, books.swallowed, books.blackened, books.drained].map(|v| v / books.start);
    println!("all booked to {off:.1e}; evaporated, swallowed, blackened, drained: {shares:.4?}");
    println!("surfactant to {:.1e}", film.surfactant() / surfactant - 1.0);
    assert!(off.abs() < 1e-12);
    assert!(shares.iter().all(|&share| share > 0.0));
    assert!((film.surfactant() / surfactant - 1.0).abs() < 1e-12);
}

#[test]
fn surfactant_diffuses_and_comes_to_rest() {
    let start = |p: Parameters| {
        film(p, |grid, state| {
            for k in 0..grid.cells() {
                // Degree 2: it decays at 6 D / R^2.
                let cos = grid.polar[k / grid.columns][1];
                state.s[k] = (1.0 + 0.1 * (1.5 * cos * cos - 0.5)).ln();
            }
        })
    };
    // So soft that nothing moves: only diffusion is left.
    let p = |columns: usize| Parameters {
        elasticity: 1e-12,
        air_density: 1.184,
        surfactant_diffusivity: 1e-4,
        step_s: 1e-3,
        ..bare(BUBBLE, columns, columns / 2)
    };
    let height = |film: &Film| {
        let (n, s) = (film.parameters().columns, &film.state().s);
        s[0].exp() - s[n / 4 * n].exp()
    };
    let rate = |columns: usize| {
        let mut diffusing = start(p(columns));
        let (before, amount) = (height(&diffusing), diffusing.surfactant());
        alone(|| diffusing.advance_to(0.5)).unwrap();
        assert!((diffusing.surfactant() / amount - 1.0).abs() < 1e-12);
        (before / height(&diffusing)).ln() / 0.5
    };
    // Backward Euler has ln(1 + rate dt) / dt.
    let law = (6.0 * 1e-4 / 0.025_f64.powi(2) * 1e-3).ln_1p() / 1e-3;
    let (coarse, fine) = (rate(32) / law - 1.0, rate(64) / law - 1.0);
    println!(
        "surfactant diffusion: {coarse:.2e} at 32 x 16, {fine:.2e} at 64 x 32, order {:.2}",
        order(coarse.abs(), fine.abs())
    );
    assert!(fine.abs() < 1e-2 && order(coarse.abs(), fine.abs()) > 1.7);
    let p = p(64);
    let before = height(&start(p.clone()));
    let mut exchanging = start(Parameters { surfactant_diffusivity: 0.0, surfactant_exchange_s: 0.5, ..p });
    alone(|| exchanging.advance_to(1.0)).unwrap();
    let kept = height(&exchanging) / before;
    println!("surfactant exchange: kept {kept:.5}, law {:.5}", (-2.0_f64).exp());
    assert!((kept / (-2.0_f64).exp() - 1.0).abs() < 1e-3);
}

#[test]
fn a_film_dries_at_its_rate() {
    let p = Parameters { evaporation: 20e-9, ..bare(BUBBLE, 64, 32) };
    let mut film = Film::new(p).unwrap();
    film.advance_to(2.0).unwrap();
    let law = 1e-6 - 40e-9;
    let off = film.state().h.iter().map(|h| (h / law - 1.0).abs()).fold(0.0, f64::max);
    println!("evaporation: off by {off:.1e}");
    assert!(off < 1e-12);
}

/// A film that regenerates at its rim thins as h0 (1 + t / t*)^(-2/3).
#[test]
fn a_regenerating_film_thins_by_its_law() {
    let p = Parameters {
        gravity: 9.81,
        viscosity: 1.5e-3,
        surface_viscosity: 1e-8,
        air_density: 1.184,
        regeneration: 0.5,
        thickness_m: 450e-9,
        noise: 0.1,
        patch_m: 3e-3,
        step_s: 0.01,
        tolerance: 1e-4,
        ..bare(Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 }, 256, 64)
    };
    let slowness =
        1.5 * p.regeneration * (p.tension / p.viscosity) * p.thickness_m.powf(1.5) / (p.meniscus_m.powf(1.5) * 0.025);
    let mut film = Film::new(p).unwrap();
    let start = film.volume();
    let mut worst: f64 = 0.0;
    for t in 1..=6 {
        alone(|| film.advance_to(f64::from(t))).unwrap();
        let law = (1.0 + slowness * f64::from(t)).powf(-2.0 / 3.0);
        let mean = film.volume() / start;
        println!("regenerating film at {t} s: {mean:.4} of its start, law {law:.4}");
        worst = worst.max((mean / law - 1.0).abs());
    }
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn black_film_spreads_from_spots() {
    let dome = Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 };
    let p = Parameters {
        spots: 2e4,
        spot_m: 2e-3,
        spot_below_m: 300e-9,
        black_m: 12e-9,
        black_below_m: 55e-9,
        thickness_m: 150e-9,
        ..bare(dome, 256, 64)
    };
    let mut film = Film::new(p).unwrap();
    film.advance_to(0.5).unwrap();
    let black = film.state().h.iter().filter(|&&h| h < 20e-9).count();
    println!(
        "black after 0.5 s: {black} of {} cells, {} spots so far, {} grow",
        film.state().h.len(),
        film.state().spot_clock.number,
        film.state().spots.len()
    );
    assert!(black > 200 && film.state().spot_clock.number > 5);
    assert!(film.state().h.iter().all(|&h| h > 11.9e-9));
}

/// Black film is as thick as the salt makes it, and comes at the rate at which film of that thickness tears.
#[test]
fn thin_film_turns_black_by_the_pressure_between_its_faces() {
    let p = |salt: f64| Parameters {
        salt,
        black_below_m: 55e-9,
        thickness_m: 50e-9,
        viscosity: 1.5e-3,
        ..bare(BUBBLE, 16, 8)
    };
    // By hand, 100 Pa against 64 k T n tanh^2(e psi / 4 k T) exp(-h / lambda) - A / (6 pi h^3): Debye lengths 3.04 and
    // 0.961 nm at 10 and 100 mol/m3, 8.92e4 Pa per mol/m3 of both faces together. Above 0.2 mol/l none holds.
    for (salt, wanted_nm) in [(10.0, 25.1), (100.0, 7.1), (300.0, 4.5)] {
        let black_nm = p(salt).black_film_m() * 1e9;
        println!("black film of {salt} mol/m3: {black_nm:.2} nm");
        assert!((black_nm - wanted_nm).abs() < 0.3, "{black_nm}");
    }
    assert_eq!(Parameters { salt: 1.0, ..p(1.0) }.check().unwrap_err().argument, "salt_mol_m3");
    // With much salt attraction alone is left, and waves grow at A^2 / (96 pi^2 mu sigma h^5).
    let much = p(300.0);
    let law = |time_s: f64| {
        let mut h = 50e-9_f64;
        for _ in 0..(time_s * 1e5) as usize {
            let rate = (4e-20_f64 / std::f64::consts::PI).powi(2) / (96.0 * 1.5e-3 * 0.03 * h.powi(5));
            h -= (h - 4.5e-9) * rate * 1e-5;
        }
        h
    };
    let mut film = Film::new(much).unwrap();
    for time_s in [0.5, 1.5] {
        alone(|| film.advance_to(time_s)).unwrap();
        let (h, wanted) = (film.state().h[40], law(time_s));
        println!("film of 50 nm after {time_s} s: {:.3} nm, law {:.3}", h * 1e9, wanted * 1e9);
        assert!((h / wanted - 1.0).abs() < 5e-3);
    }
    alone(|| film.advance_to(4.0)).unwrap();
    assert!(film.state().h.iter().all(|h| (h / 4.5e-9 - 1.0).abs() < 1e-6));
    let books = film.state().books;
    assert!(((film.volume() + books.blackened) / books.start - 1.0).abs() < 1e-12);
}

#[test]
fn threads_and_checkpoints_change_no_byte() {
    let p =
        Parameters { wind: 0.05, eddies: 0.1, spots: 1e4, spot_below_m: 400e-9, ..small("bubble-on-bath-time-lapse") };
    let run = |threads: usize, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut film = Film::new(p.clone()).unwrap();
            film.advance_to(0.2).unwrap();
            if stop {
                film = Film::resume(p.clone(), &film.checkpoint()).unwrap();
            }
            film.advance_to(0.4).unwrap();
            film.checkpoint()
        })
    };
    let one = run(1, false);
    assert!(one == run(3, false));
    assert!(one == run(2, true));
}

#[test]
fn patches_do_not_hang_on_the_step() {
    let patches = |step_s: f64| {
        let bubble = small("bubble-on-bath");
        let p = Parameters { step_s, gravity: 1e-9, noise: 0.0, regeneration: 2.0, wind: 0.03, ..bubble };
        let mut film = Film::new(p).unwrap();
        film.advance_to(0.5).unwrap();
        let state = film.state();
        (state.patch_clock.number, state.patches.iter().map(|spot| spot.radius).collect::<Vec<f64>>())
    };
    let (long, short) = (patches(0.02), patches(0.005));
    assert!(long.0 > 10 && long == short, "{long:?} {short:?}");
}

#[test]
fn a_number_that_is_none_stops_the_run_with_its_place() {
    let mut film = film(bare(BUBBLE, 64, 32), |_, state| state.h[5 * 64 + 7] = f64::NAN);
    match film.advance_to(1.0).unwrap_err() {
        FlowError::NotFinite { field, step, row, column, .. } => {
            assert_eq!((field, step), ("the thickness", 1));
            assert!(row.abs_diff(5) <= 3 && column.abs_diff(7) <= 3, "{row} {column}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_step_that_is_too_long_is_refused() {
    let p = Parameters { step_s: 10.0, ..bare(BUBBLE, 64, 32) };
    let mut film =
        film(p, |_, state| state.across.iter_mut().enumerate().for_each(|(k, u)| *u = f64::from(k as u32 % 2)));
    assert!(matches!(film.advance_to(10.0), Err(FlowError::StepTooLong { .. })));
}

#[test]
fn a_film_that_bursts_ends() {
    let p = Parameters {
        evaporation: 100e-9,
        rupture_m: 0.9e-6,
        rupture_rate: f64::INFINITY,
        step_s: 5e-3,
        ..bare(BUBBLE, 64, 32)
    };
    let mut film = Film::new(p).unwrap();
    film.advance_to(3.0).unwrap();
    assert!((film.state().ruptured_s.unwrap() - 1.0).abs() < 0.011);
    assert!(film.state().time_s < 1.02);
}

/// Film that is thin enough bursts by chance: after exponential times whose mean is that of the rate and the area, from
/// the seed alone; sooner by as much as the film ages faster; thicker film and `rupture_nm = 0` never.
#[test]
fn films_burst_by_chance() {
    let rate = 500.0;
    let p =
        Parameters { thickness_m: 30e-9, rupture_m: 31e-9, rupture_rate: rate, step_s: 0.05, ..bare(BUBBLE, 16, 8) };
    let burst = |p: Parameters| {
        let mut film = Film::new(p).unwrap();
        film.advance_to(20.0).unwrap();
        film.state().ruptured_s
    };
    let area = 4.0 * std::f64::consts::PI * 0.025 * 0.025;
    let waits: Vec<f64> =
        alone(|| (1..=100).map(|seed| burst(Parameters { seed, ..p.clone() }).unwrap() * rate * area).collect());
    let mean = waits.iter().sum::<f64>() / 100.0;
    let late = waits.iter().filter(|&&wait| wait > 1.0).count();
    println!("bursting by chance: mean wait {mean:.3} of the law, {late} of 100 later than that (37 by the law)");
    // Three standard errors: 0.1 of the mean, 4.8 of the count.
    assert!((mean - 1.0).abs() < 0.3 && (22..=52).contains(&late));
    let first = burst(p.clone()).unwrap();
    for (change, at) in
        [(Parameters { step_s: 0.01, ..p.clone() }, first), (Parameters { speed: 5.0, ..p.clone() }, first / 5.0)]
    {
        assert!((burst(change).unwrap() / at - 1.0).abs() < 1e-9);
    }
    assert_eq!(burst(Parameters { rupture_m: 0.0, ..p.clone() }), None);
    assert_eq!(burst(Parameters { rupture_m: 29e-9, ..p.clone() }), None);
    // A run that was stopped in between bursts when it would have.
    let mut film = Film::new(p.clone()).unwrap();
    film.advance_to(first / 2.0).unwrap();
    let mut film = Film::resume(p, &film.checkpoint()).unwrap();
    film.advance_to(20.0).unwrap();
    assert!((film.state().ruptured_s.unwrap() / first - 1.0).abs() < 1e-9);
}

#[test]
fn impossible_films_are_refused_by_name() {
    let good = || Parameters::preset("bubble-on-bath").unwrap();
    let shape = |radius_m: f64, rim_deg: f64| Shape::Sphere { radius_m, rim_deg };
    for (key, bad) in [
        ("viscosity_pa_s", Parameters { viscosity: -1.0, ..good() }),
        ("surface_viscosity_pa_s_m", Parameters { surface_viscosity: f64::NAN, ..good() }),
        ("radius_m", Parameters { shape: shape(0.0, 90.0), ..good() }),
        ("rim_deg", Parameters { shape: shape(0.02, 170.0), ..good() }),
        ("step_s", Parameters { step_s: 0.0, ..good() }),
        ("wind_m_s", Parameters { wind: f64::INFINITY, ..good() }),
        ("tilt_deg", Parameters { tilt_deg: 10.0, ..good() }),
        ("tilt_deg", Parameters { tilt_deg: 91.0, ..Parameters::preset("vertical-film").unwrap() }),
        ("shake_hz", Parameters { shake_hz: 0.0, ..good() }),
        ("columns", good().with_columns(256)),
        ("columns", Parameters { columns: 601, ..good() }),
        ("rows", Parameters { rows: 1 << 40, ..good() }),
        ("patch_ratio", Parameters { patch_ratio: 1.0, ..good() }),
        ("black_nm", Parameters { black_m: 1e-6, ..good() }),
        ("noise", Parameters { noise: 2.0, ..good() }),
    ] {
        let error = bad.check().unwrap_err();
        assert_eq!(error.argument, key, "{error}");
        assert!(Film::new(bad).is_err());
    }
    for name in crate::PRESETS {
        Parameters::preset(name).unwrap().check().unwrap();
    }
}

#[test]
fn checkpoints_of_other_runs_are_refused() {
    let film = Film::new(small("bubble-on-bath")).unwrap();
    let bytes = film.checkpoint();
    let refusal = |p: Parameters, bytes: &[u8]| Film::resume(p, bytes).err().unwrap().to_string();
    assert!(refusal(Parameters { seed: 2, ..small("bubble-on-bath") }, &bytes).contains("seed 1, not seed 2"));
    assert!(refusal(small("bubble-on-bath-time-lapse"), &bytes).contains("speed"));
    for length in [0, 7, 8, 100, bytes.len() - 1] {
        assert!(refusal(small("bubble-on-bath"), &bytes[..length]).contains("checkpoint"));
    }
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    assert!(refusal(small("bubble-on-bath"), &damaged).contains("damaged"));
}
