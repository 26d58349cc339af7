//! Velocity and tension.

use std::f64::consts::{PI, TAU};

use super::*;

fn kinetic(grid: &Grid, state: &State) -> f64 {
    let n = grid.columns;
    let square = |k: usize| {
        let (above, below) = (state.down[k], state.down[k + n]);
        let (left, right) = (state.across[k / n * n + (k + n - 1) % n], state.across[k]);
        (above * above + below * below + left * left + right * right) / 2.0
    };
    grid.integral(&(0..grid.cells()).map(square).collect::<Vec<f64>>())
}

/// Turning about its axis with the surfactant that balances it, a sphere goes on turning.
#[test]
fn steady_zonal_flow_stays() {
    let off = |columns: usize| zonal(columns, 0.128 / columns as f64, 1.0);
    let (coarse, fine) = (off(64), off(128));
    println!("zonal flow: {coarse:.2e} at 64 x 32, {fine:.2e} at 128 x 64, order {:.2}", order(coarse, fine));
    assert!(fine < 3e-3 && order(coarse, fine) > 0.8);
}

/// Errors of the drift and change of the energy in half a second, of a wave of degree 5 and order 4 in a turning film.
fn rossby_haurwitz(columns: usize, step_s: f64, time_order: f64) -> (f64, f64) {
    let omega = 2.0;
    let p = Parameters { step_s, time_order, ..bare(BUBBLE, columns, columns / 2) };
    let grid = Grid::new(BUBBLE, columns, columns / 2);
    let mut film = film(p, |grid, state| {
        stream(grid, state, |polar, turn| {
            let sin = polar.sin();
            grid.radius * grid.radius * omega * polar.cos() * (-1.0 + 0.5 * sin.powi(4) * (4.0 * turn).cos())
        });
    });
    let row = columns / 8;
    let start = wave(&grid, &film.state().across, row, 4);
    let energy = kinetic(&grid, film.state());
    film.advance_to(0.5).unwrap();
    let end = wave(&grid, &film.state().across, row, 4);
    let turned = (end.1.atan2(end.0) - start.1.atan2(start.0)) / 4.0;
    let expected = omega * (1.0 - 2.0 / 30.0) * 0.5;
    // The phase is known but for whole waves.
    let whole = ((expected - turned) / (TAU / 4.0)).round() * (TAU / 4.0);
    ((turned + whole) / expected - 1.0, kinetic(&grid, film.state()) / energy - 1.0)
}

/// Steps of second order: the error of a zonal flow and what a step takes from the energy of a wave fall by four where the
/// step is halved; swirls are as near to their limit as steps of first order of half the length.
#[test]
fn steps_of_second_order_are() {
    let off = |step_s: f64| zonal(64, step_s, 2.0);
    let (long, short) = (off(10e-3), off(5e-3));
    let first = zonal(64, 5e-3, 1.0);
    println!(
        "zonal flow, steps of 10, 5 ms: {long:.2e}, {short:.2e}, order {:.2}; of first order {first:.2e}",
        order(long, short)
    );
    assert!(order(long, short) > 1.8 && short < first / 10.0);
    let ends = [20e-3, 10e-3, 5e-3].map(|step_s| rossby_haurwitz(64, step_s, 2.0).0);
    let first = rossby_haurwitz(64, 5e-3, 1.0).0;
    println!(
        "Rossby-Haurwitz, steps of 20, 10, 5 ms: drift off by {:.2e}, {:.2e}, {:.2e}; first order {first:.2e}",
        ends[0], ends[1], ends[2]
    );
    assert!(ends[2].abs() < first.abs() / 10.0);
    let swirls = |time_order: f64, step_s: f64| {
        let own = Parameters::preset("bubble-on-bath").unwrap().with_columns(96);
        let p = Parameters { step_s, time_order, regeneration: 0.0, evaporation: 0.0, ..own };
        let mut film = Film::new(p).unwrap();
        film.advance_to(0.2).unwrap();
        film.state().h.clone()
    };
    let apart = |time_order: f64, step_s: f64| {
        let (a, b) = (swirls(time_order, step_s), swirls(time_order, step_s / 2.0));
        (a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt() * 1e9
    };
    let (first, second) = (apart(1.0, 10e-3), apart(2.0, 20e-3));
    println!(
        "swirls: {first:.2} nm between steps of 10 and 5 ms of first order, {second:.2} between 20 and 10 ms of second"
    );
    assert!(second < 1.2 * first);
}

/// How far a zonal flow is off after half a second, of its speed.
fn zonal(columns: usize, step_s: f64, time_order: f64) -> f64 {
    let speed = 0.1;
    let p = Parameters { elasticity: 22e-3, step_s, time_order, ..bare(BUBBLE, columns, columns / 2) };
    let mut film = film(p, |grid, state| {
        for k in 0..grid.cells() {
            let sin = grid.polar[k / columns][0];
            state.across[k] = speed * sin;
            state.s[k] = 1e-3 * speed * speed / (2.0 * 22e-3) * sin * sin;
        }
    });
    let grid = Grid::new(BUBBLE, columns, columns / 2);
    alone(|| film.advance_to(0.5)).unwrap();
    let state = film.state();
    let error = (0..grid.cells()).map(|k| (state.across[k] - speed * grid.polar[k / columns][0]).abs());
    error.chain(state.down.iter().map(|v| v.abs())).fold(0.0, f64::max) / speed
}

/// What a step of second order leaves to the next goes through a checkpoint, breath and all, to the same bytes.
#[test]
fn films_of_second_order_go_on_from_checkpoints() {
    let own = Parameters::preset("bubble-on-bath-small-preview").unwrap();
    let parameters = Parameters { time_order: 2.0, step_s: 0.02, ..own };
    let mut film = Film::new(parameters.clone()).unwrap();
    film.advance_to(0.1).unwrap();
    film.stir([10.0, 20.0], [0.1, 0.2], 8e-3).unwrap();
    let mut other = Film::resume(parameters, &film.checkpoint()).unwrap();
    assert_eq!(film.state(), other.state());
    film.advance_to(0.2).unwrap();
    other.advance_to(0.2).unwrap();
    assert_eq!(film.state(), other.state());
    for bad in [0.0, 1.5, 3.0] {
        assert!(film.change("time_order", bad).is_err());
        assert!(Film::new(Parameters { time_order: bad, ..film.parameters().clone() }).is_err());
    }
}

/// Such a wave drifts at omega (1 - 2 / 30).
#[test]
fn a_rossby_haurwitz_wave_drifts() {
    let off = |columns: usize| rossby_haurwitz(columns, 0.64 / columns as f64, 1.0);
    let (coarse, fine) = (off(64), off(128));
    println!(
        "Rossby-Haurwitz: drift off by {:.2e} at 64 x 32, {:.2e} at 128 x 64, order {:.2}; energy {:.1e}",
        coarse.0,
        fine.0,
        order(coarse.0.abs(), fine.0.abs()),
        fine.1
    );
    assert!(fine.0.abs() < 2e-3 && fine.1.abs() < 2e-2);
}

/// A vorticity harmonic of degree l decays at nu (l (l + 1) - 2) / R^2; a turning film does not.
#[test]
fn harmonics_decay_and_rotation_does_not() {
    let nu = 2e-5;
    let rate = |columns: usize, l: f64, m: i32, shape: &dyn Fn(f64) -> f64| {
        let p = Parameters { surface_viscosity: nu * 1e-3 / 2.0, step_s: 1e-3, ..bare(BUBBLE, columns, columns / 2) };
        let grid = Grid::new(BUBBLE, columns, columns / 2);
        let mut film = film(p, |grid, state| {
            stream(grid, state, |polar, turn| 1e-9 * shape(polar) * (f64::from(m) * turn).cos());
        });
        let before = kinetic(&grid, film.state());
        alone(|| film.advance_to(0.2)).unwrap();
        let decay = (before / kinetic(&grid, film.state())).ln() / 0.4;
        let law = nu * (l * (l + 1.0) - 2.0) / (0.025 * 0.025);
        // Backward Euler decays by 1 / (1 + rate dt).
        if l > 1.0 { decay / ((1.0 + law * 1e-3).ln() / 1e-3) - 1.0 } else { decay / (nu / (0.025 * 0.025)) }
    };
    let sectoral = |polar: f64| polar.sin().powi(4) * polar.cos();
    let (coarse, fine) = (rate(64, 5.0, 4, &sectoral), rate(128, 5.0, 4, &sectoral));
    println!(
        "harmonic 5, 4: {coarse:.2e} at 64 x 32, {fine:.2e} at 128 x 64, order {:.2}",
        order(coarse.abs(), fine.abs())
    );
    let zonal = |polar: f64| 1.5 * polar.cos().powi(2) - 0.5;
    let flat = rate(128, 2.0, 0, &zonal);
    println!("harmonic 2, 0: {flat:.2e} at 128 x 64");
    assert!(fine.abs() < 8e-3 && order(coarse.abs(), fine.abs()) > 1.7 && flat.abs() < 5e-3);
    let own = rate(128, 1.0, 0, &|polar| polar.cos());
    let tilted = rate(128, 1.0, 1, &|polar| polar.sin());
    println!("rotation, in units of nu / R^2: {own:.1e} about the axis, {tilted:.1e} across it");
    assert!(own.abs() < 1e-9 && tilted.abs() < 2e-3);
}

/// Drag of still air: exp(-C t / (rho h)).
#[test]
fn air_stops_a_film() {
    let p = Parameters {
        air_density: 1.184,
        // Faster than anything here, so that the drag is the same everywhere.
        air_speed: 1.0,
        step_s: 1e-4,
        ..bare(BUBBLE, 64, 32)
    };
    let c = 2.0 * 1.184 * (p.air_viscosity / p.air_length_m).sqrt();
    let grid = Grid::new(BUBBLE, 64, 32);
    let mut film = film(p, |grid, state| {
        stream(grid, state, |polar, turn| 1e-7 * polar.sin().powi(4) * polar.cos() * (4.0 * turn).cos());
    });
    let before = kinetic(&grid, film.state());
    alone(|| film.advance_to(0.02)).unwrap();
    let decay = (before / kinetic(&grid, film.state())).ln() / 0.04;
    println!("air drag: rate {decay:.4} /s, law {:.4} /s", c / 1e-3);
    // Backward Euler: half a step's worth of the rate, 0.5 %.
    assert!((decay / ((1.0 + c / 1e-3 * 1e-4).ln() / 1e-4) - 1.0).abs() < 2e-3);
}

/// At rest a film of elasticity E is h0 / (1 + z / H) thick, H = E / (rho g h0).
#[test]
fn a_film_at_rest_carries_its_own_weight() {
    let off = |step_s: f64| {
        let p = Parameters {
            elasticity: 22e-3,
            // Ten times the weight of nature, so that there is something to see; thick air brings it to rest.
            gravity: 98.1,
            air_density: 1.184,
            air_speed: 100.0,
            step_s,
            ..bare(BUBBLE, 64, 32)
        };
        let mut film = film(p, |_, state| state.s.fill(0.0));
        alone(|| film.advance_to(0.5)).unwrap();
        let grid = Grid::new(BUBBLE, 64, 32);
        let h = &film.state().h;
        // h (1 + z / H) is the thickness at z = 0, where H follows from it.
        let at_zero = (h[15 * 64] + h[16 * 64]) / 2.0;
        let scale = 22e-3 / (1000.0 * 98.1 * at_zero);
        let errors = (0..32).map(|i| (h[i * 64] * (1.0 + grid.height[i] / scale) / at_zero - 1.0).abs());
        (errors.fold(0.0, f64::max), h[0] / h[31 * 64])
    };
    let (long, short) = (off(1e-3), off(5e-4));
    println!(
        "hydrostatic: top {:.4} of the bottom; off by {:.2e} for steps of 1 ms, {:.2e} for 0.5 ms, order {:.2}",
        short.1,
        long.0,
        short.0,
        order(long.0, short.0)
    );
    assert!(short.0 < 1e-3 && (0.75..0.85).contains(&short.1) && order(long.0, short.0) > 0.8);
}

/// A layered film heaves: s^2 = g b k^2 / (k^2 + b^2 / 4 + (pi / d)^2) for h = h0 exp(b z) between walls d apart,
/// exactly; growth where it is heavy above, an oscillation where it is heavy below.
fn layered(columns: usize, b: f64, until: f64) -> (f64, Vec<f64>) {
    let (width, depth) = (0.02, 0.02);
    let shape = Shape::Plane { width_m: width, height_m: depth, sides: Sides::Periodic };
    let rows = columns;
    let p = Parameters { gravity: 9.81, step_s: 0.032 / columns as f64, ..bare(shape, columns, rows) };
    let (k, kz) = (TAU / width, PI / depth);
    let rate = (9.81 * b.abs() * k * k / (k * k + b * b / 4.0 + kz * kz)).sqrt();
    let mut film = film(p, |grid, state| {
        for cell in 0..grid.cells() {
            state.h[cell] = 1e-6 * (b * grid.height[cell / columns]).exp();
        }
        // The mode itself, w ~ exp(-b z / 2) sin(kz z).
        stream(grid, state, |z, x| 1e-9 * (-b * z / 2.0).exp() * (kz * z).sin() * (k * x).cos());
        if b > 0.0 {
            // Growing, it already lies where its own motion would have brought it: h' = -w dh/dz / s.
            for cell in 0..grid.cells() {
                let (z, x) = (grid.height[cell / columns], grid.place(cell / columns, cell % columns)[0]);
                // Down is -dpsi/dx, so up is psi_x.
                let up = -1e-9 * k * (-b * z / 2.0).exp() * (kz * z).sin() * (k * x).sin();
                state.h[cell] -= up / rate * b * state.h[cell];
            }
        }
    });
    let grid = Grid::new(shape, columns, rows);
    let mut seen = Vec::new();
    let steps = 60;
    for step in 0..=steps {
        alone(|| film.advance_to(until * f64::from(step) / f64::from(steps))).unwrap();
        // Velocity down along the middle row, sine part: the mode as it is now.
        let n = grid.columns;
        let row = &film.state().down[rows / 2 * n..(rows / 2 + 1) * n];
        seen.push(row.iter().enumerate().map(|(j, v)| v * (k * (j as f64 + 0.5) * grid.width[0]).sin()).sum::<f64>());
    }
    (rate, seen)
}

#[test]
fn heavy_film_above_falls_at_the_rate_of_rayleigh_and_taylor() {
    let off = |columns: usize| {
        let (rate, seen) = layered(columns, 5.0, 0.3);
        ((seen[60] / seen[20]).ln() / 0.2) / rate - 1.0
    };
    let (coarse, fine) = (off(32), off(64));
    println!(
        "Rayleigh-Taylor: {coarse:.2e} at 32 x 32, {fine:.2e} at 64 x 64, order {:.2}",
        order(coarse.abs(), fine.abs())
    );
    assert!(fine.abs() < 1e-2 && order(coarse.abs(), fine.abs()) > 0.8);
}

#[test]
fn heavy_film_below_swings_at_its_frequency() {
    let off = |columns: usize| {
        let (rate, seen) = layered(columns, -5.0, 0.5);
        // The first time it stands still, a quarter of a swing.
        let k = seen.windows(2).position(|w| w[0] * w[1] <= 0.0).unwrap();
        let time = 0.5 / 60.0 * (k as f64 + seen[k] / (seen[k] - seen[k + 1]));
        PI / 2.0 / time / rate - 1.0
    };
    let (coarse, fine) = (off(32), off(64));
    println!(
        "layered oscillation: {coarse:.2e} at 32 x 32, {fine:.2e} at 64 x 64, order {:.2}",
        order(coarse.abs(), fine.abs())
    );
    assert!(fine.abs() < 2e-2);
}

/// A frame that leans has the weight of its slope: at 60 degrees half of it, the film swings 1 / sqrt(2) as fast.
#[test]
fn a_frame_that_leans_has_less_weight() {
    let shape = Shape::Plane { width_m: 0.02, height_m: 0.02, sides: Sides::Periodic };
    let run = |tilt_deg: f64, gravity: f64| {
        let p = Parameters { gravity, tilt_deg, step_s: 1e-3, ..bare(shape, 32, 32) };
        let mut film = film(p, |grid, state| {
            for cell in 0..grid.cells() {
                state.h[cell] = 1e-6 * (1.0 - 0.2 * (grid.place(cell / 32, cell % 32)[0] * TAU / 0.02).cos());
            }
        });
        film.advance_to(0.2).unwrap();
        film
    };
    let (leaning, light, upright) = (run(60.0, 9.81), run(0.0, 9.81 * 0.5), run(0.0, 9.81));
    let apart =
        |a: &Film, b: &Film| a.state().h.iter().zip(&b.state().h).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!(
        "leaning frame: {:.1e} m from half the weight, {:.1e} m from all of it",
        apart(&leaning, &light),
        apart(&leaning, &upright)
    );
    assert!(apart(&leaning, &light) < 1e-13 && apart(&leaning, &upright) > 1e-8);
}

/// A frame that is pulled up is as good as one with more weight (there is no air here); air that comes down upon a film
/// of one thickness does not move it, for the tension takes it up; a shaken frame ends a swing where gravity alone does
/// but for the work of the shaking.
#[test]
fn a_frame_that_is_pulled_up_has_more_weight() {
    let shape = Shape::Plane { width_m: 0.02, height_m: 0.02, sides: Sides::Periodic };
    let run = |gravity: f64, shake: f64, shake_hz: f64| {
        let p = Parameters { gravity, shake, shake_hz, step_s: 1e-3, ..bare(shape, 32, 32) };
        let mut film = film(p, |grid, state| {
            for cell in 0..grid.cells() {
                state.h[cell] = 1e-6 * (1.0 - 0.2 * (grid.place(cell / 32, cell % 32)[0] * TAU / 0.02).cos());
            }
        });
        film.advance_to(0.1).unwrap();
        film
    };
    let apart =
        |a: &Film, b: &Film| a.state().h.iter().zip(&b.state().h).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // 0.1 s of a period of 1000 s is a steady pull to 1e-7.
    let (pulled, heavy, light) = (run(4.905, 4.905, 1e-3), run(9.81, 0.0, 1.0), run(4.905, 0.0, 1.0));
    println!(
        "pulled frame: {:.1e} m from twice the weight, {:.1e} m from its own",
        apart(&pulled, &heavy),
        apart(&pulled, &light)
    );
    assert!(apart(&pulled, &heavy) < 1e-12 && apart(&pulled, &light) > 1e-8);
    // A film shaken a thousand times a second feels the mean, which is nothing.
    assert!(apart(&run(4.905, 4.905, 1000.0), &light) < 1e-12);
    let still = Parameters {
        gravity: 9.81,
        shake: 5.0,
        shake_hz: 3.0,
        air_density: 1.184,
        ..bare(Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 }, 64, 16)
    };
    let mut still = Film::new(still).unwrap();
    still.advance_to(0.3).unwrap();
    assert!(still.state().down.iter().all(|v| v.abs() < 1e-9));
}

/// A wave of tension runs at sqrt(E / (rho h)); backward Euler damps it by exp(-w^2 dt t / 2).
#[test]
fn a_marangoni_wave_runs() {
    let shape = Shape::Plane { width_m: 0.02, height_m: 0.01, sides: Sides::Periodic };
    let k = TAU / 0.02;
    let frequency = k * (22e-3_f64 / 1e-3).sqrt();
    let dt = 0.05 / frequency;
    let p = Parameters { elasticity: 22e-3, step_s: dt, ..bare(shape, 128, 16) };
    let mut film = film(p, |grid, state| {
        for cell in 0..grid.cells() {
            state.s[cell] = 1e-5 * (k * grid.place(cell / 128, cell % 128)[0]).cos();
        }
    });
    let mut seen = vec![1e-5];
    for step in 1..=400 {
        film.advance_to(f64::from(step) * dt).unwrap();
        let row = &film.state().s[..128];
        let cosine = |j: usize| (k * (j as f64 + 0.5) * 0.02 / 128.0).cos();
        seen.push(row.iter().enumerate().map(|(j, s)| s * cosine(j)).sum::<f64>() / 64.0);
    }
    let zeros: Vec<f64> = (0..400)
        .filter(|&i| seen[i] * seen[i + 1] <= 0.0)
        .map(|i| (i as f64 + seen[i] / (seen[i] - seen[i + 1])) * dt)
        .collect();
    let measured = PI * (zeros.len() - 1) as f64 / (zeros[zeros.len() - 1] - zeros[0]);
    let peak = |from: usize| seen[from..from + 63].iter().fold(0.0_f64, |m, s| m.max(s.abs()));
    let damping = (peak(60) / peak(311)).ln() / (251.0 * dt);
    println!(
        "Marangoni wave: frequency off by {:.2e}, damping {:.4} of w^2 dt / 2",
        measured / frequency - 1.0,
        damping / (frequency * frequency * dt / 2.0)
    );
    assert!((measured / frequency - 1.0).abs() < 5e-3);
    assert!((damping / (frequency * frequency * dt / 2.0) - 1.0).abs() < 0.02);
}

/// A patch at 0.85 of its surroundings rises as fast as air lets it: the weight that it gives up is what drag takes,
/// and its speed with viscosity lies near that of a reference computation, which does not say how it took the speed.
#[test]
fn a_patch_rises_as_fast_as_air_lets_it() {
    for (thickness_nm, radius_mm, expected) in [(1000.0, 2.0, 2.1), (1000.0, 4.0, 2.8), (300.0, 2.0, 0.7)] {
        let p = Parameters {
            gravity: 9.81,
            viscosity: 1e-15,
            air_density: 1.184,
            thickness_m: thickness_nm * 1e-9,
            step_s: 2e-3,
            tolerance: 1e-6,
            ..bare(BUBBLE, 256, 128)
        };
        let grid = Grid::new(BUBBLE, 256, 128);
        let patch = |grid: &Grid, state: &mut State| {
            crate::events::near(grid, [1.0, 0.0, 0.0], radius_mm * 1e-3, |row, column, d| {
                let x = (d / (radius_mm * 1e-3)).powi(2);
                state.h[row * 256 + column] *= 0.85_f64.powf((1.0 - x) * (1.0 - x) * (1.0 + 2.0 * x));
            });
        };
        let mut film = film(p.clone(), patch);
        let energy = |film: &Film| {
            let h = &film.state().h;
            let weight: Vec<f64> = h.iter().enumerate().map(|(k, h)| h * grid.height[k / 256]).collect();
            let n = grid.columns;
            let moving = |k: usize| {
                let v = (film.state().down[k] + film.state().down[k + n]) / 2.0;
                let u = (film.state().across[k] + film.state().across[k / n * n + (k + n - 1) % n]) / 2.0;
                (u * u + v * v, h[k])
            };
            let kinetic: Vec<f64> = (0..grid.cells()).map(|k| moving(k).0 * moving(k).1 / 2.0).collect();
            let drag: Vec<f64> = (0..grid.cells())
                .map(|k| {
                    let square = moving(k).0;
                    let speed = square.sqrt().max(p.air_speed);
                    2.0 * p.air_density * (p.air_viscosity * speed / p.air_length_m).sqrt() * square
                })
                .collect();
            (p.density * (9.81 * grid.integral(&weight) + grid.integral(&kinetic)), grid.integral(&drag))
        };
        alone(|| film.advance_to(0.1)).unwrap();
        let (start, mut last) = energy(&film);
        let mut lost = 0.0;
        for step in 51..=100 {
            alone(|| film.advance_to(f64::from(step) * 2e-3)).unwrap();
            let now = energy(&film).1;
            lost += (last + now) / 2.0 * 2e-3;
            last = now;
        }
        let given = start - energy(&film).0;
        let mut sticky = self::film(Parameters { viscosity: 1.5e-3, surface_viscosity: 1e-8, ..p.clone() }, patch);
        alone(|| sticky.advance_to(0.2)).unwrap();
        let fastest = sticky.state().down.iter().fold(0.0_f64, |most, v| most.max(-v)) * 100.0;
        println!(
            "patch of {radius_mm} mm in {thickness_nm} nm: {fastest:.2} cm/s, reference {expected}; drag takes {:.3} of the weight given up",
            lost / given
        );
        assert!((lost / given - 1.0).abs() < 0.1);
        assert!((fastest / expected - 1.0).abs() < 0.2);
    }
}

/// The same laws on the grids of the reference computation; minutes, so only when asked for:
/// `cargo test --release -p iridesce-thickness finer -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn finer_grids() {
    for step_s in [5e-3, 2.5e-3] {
        for order in [1.0, 2.0] {
            let (drift, energy) = rossby_haurwitz(256, step_s, order);
            println!(
                "Rossby-Haurwitz, 256 x 128, order {order}, {step_s} s: drift off by {drift:.2e}, energy {energy:.1e}"
            );
        }
    }
}
