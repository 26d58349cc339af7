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
        diffusing.advance_to(0.5).unwrap();
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
    exchanging.advance_to(1.0).unwrap();
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
        film.advance_to(f64::from(t)).unwrap();
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
    let p = Parameters { evaporation: 100e-9, rupture_m: 0.9e-6, ..bare(BUBBLE, 64, 32) };
    let mut film = Film::new(p).unwrap();
    film.advance_to(3.0).unwrap();
    assert!((film.state().ruptured_s.unwrap() - 1.0).abs() < 0.011);
    assert!(film.state().time_s < 1.02);
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
        assert_eq!(error.key, key, "{error}");
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
