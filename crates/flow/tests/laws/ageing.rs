//! How films age: how fast borders drain a frame, whether the top of a dome follows, how long bubbles of all sizes take.

use super::*;

fn preset(name: &str) -> Parameters {
    Parameters::preset(name).unwrap()
}

/// When a film has only `share` of its volume left, s; asked a hundred times until then.
fn until(parameters: Parameters, share: f64, about_s: f64) -> f64 {
    let mut film = Film::new(parameters).unwrap();
    let start = film.volume();
    let (mut time_s, mut before) = (0.0, start);
    loop {
        time_s += about_s / 100.0;
        film.advance_to(time_s).unwrap();
        let now = film.volume();
        if now <= share * start {
            return time_s - about_s / 100.0 * (share * start - now) / (before - now);
        }
        before = now;
    }
}

/// A frame that drains through its sides takes as long as it is wide: each takes K (sigma / mu) h^(5/2) / r_m^(3/2) of
/// its height, whatever lies between them. It takes longer than with the mean's own h, for patches have just left there.
#[test]
fn a_frame_drains_in_proportion_to_its_width() {
    let time = |width_m: f64| {
        let p = Parameters {
            shape: Shape::Plane { width_m, height_m: 0.03, sides: Sides::Menisci },
            columns: (width_m / 0.5e-3).round() as usize,
            rows: 60,
            patch_m: 2e-3,
            regeneration: 0.4,
            evaporation: 0.0,
            drains_inside: false,
            noise: 0.05,
            // The bottom takes nothing.
            bottom_meniscus_m: 1e3,
            ..preset("vertical-film-preview")
        };
        // A film of one thickness: h^(-3/2) grows evenly.
        let rate = 2.0 * p.regeneration * p.tension / p.viscosity * p.thickness_m.powf(1.5)
            / (p.meniscus_m.powf(1.5) * width_m);
        let law = (0.9_f64.powf(-1.5) - 1.0) / (1.5 * rate);
        (alone(|| until(p, 0.9, law)), law)
    };
    let times = [0.03, 0.06, 0.12].map(time);
    for (width, (time, law)) in [3, 6, 12].iter().zip(&times) {
        println!("a frame of {width} cm loses a tenth in {time:.2} s, law {law:.2}");
    }
    for pair in times.windows(2) {
        assert!((pair[1].0 / pair[0].0 / 2.0 - 1.0).abs() < 0.1);
    }
    assert!(times.iter().all(|(time, law)| (1.0..1.4).contains(&(time / law))));
}

/// In saturated air the top thins, too: patches come up that are thinner than it is. The quieter the start, the sooner.
/// It takes all of them, so that it thins faster than the mean until it is some 7 % thinner.
#[test]
fn the_top_of_a_dome_follows_in_saturated_air() {
    let rates = |noise: f64| {
        let p = Parameters { evaporation: 0.0, noise, speed: 6.0, ..preset("bubble-on-bath-small-preview") };
        let mut film = Film::new(p).unwrap();
        // The top fifth of a dome's area is the top fifth of its height.
        let mut look = |time_s: f64| {
            film.advance_to(time_s).unwrap();
            let n = film.parameters().columns;
            let (mut sum, mut area) = (0.0, 0.0);
            for (i, row) in film.state().h.chunks_exact(n).enumerate() {
                let cos = |i: usize| (i as f64 / 32.0 * std::f64::consts::FRAC_PI_2).cos();
                if cos(i + 1) > 0.8 {
                    sum += (cos(i) - cos(i + 1)) * row.iter().sum::<f64>() / n as f64;
                    area += cos(i) - cos(i + 1);
                }
            }
            ((sum / area).ln(), film.volume().ln())
        };
        let (before, after) = (look(4.0), look(8.0));
        (before.0 - after.0) / (before.1 - after.1)
    };
    let [quiet, loud] = [0.03, 0.25].map(|noise| alone(|| rates(noise)));
    println!("the top fifth thins at {quiet:.2} of the mean's rate from a start with 3 % noise, {loud:.2} with 25 %");
    assert!((0.8..1.6).contains(&quiet) && loud < 0.3);
}

/// A dome of 2 um in a draughty room, until its mean is below 200 nm: dh/dt = -K (sigma / mu) h^(5/2) / (r_m^(3/2) R) - e
/// at every size; large bubbles last longer.
#[test]
fn large_bubbles_last_longer() {
    let mut last = 0.0;
    for radius_m in [0.01, 0.025, 0.05] {
        let own = preset("bubble-on-bath-small-preview");
        let p = Parameters {
            shape: Shape::Sphere { radius_m, rim_deg: 90.0 },
            thickness_m: 2e-6,
            noise: 0.05,
            noise_longest_m: 0.25 * radius_m,
            noise_shortest_m: 0.05 * radius_m,
            patch_m: 0.2 * radius_m,
            evaporation: 30e-9,
            drains_inside: false,
            speed: 3.0,
            ..own
        };
        let strength = p.regeneration * p.tension / p.viscosity / (p.meniscus_m.powf(1.5) * radius_m);
        let (mut h, mut law) = (2e-6_f64, 0.0);
        while h > 200e-9 {
            h -= 1e-3 * p.speed * (strength * h.powf(2.5) + p.evaporation);
            law += 1e-3;
        }
        let time = alone(|| until(p, 0.1, law));
        println!(
            "a dome of {:.1} cm: from 2 um to 200 nm in {:.1} s, law {:.1}",
            radius_m * 100.0,
            3.0 * time,
            3.0 * law
        );
        assert!((time / law - 1.0).abs() < 0.1 && time > last);
        last = time;
    }
}
