//! Black film as a share of cells: what is stirred keeps it, edges stay sharp and round, liquid stays booked.

use super::*;

const DOME: Shape = Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 };

/// Six disks of 4 mm of black film in film of 260 nm, half-way down a dome.
fn disks(grid: &Grid, state: &mut State) {
    let n = grid.columns;
    for k in 0..grid.cells() {
        let x = grid.place(k / n, k % n);
        let inside = (0..6).any(|disk| {
            let (sin, cos) = (f64::from(disk) * std::f64::consts::FRAC_PI_3).sin_cos();
            let middle = [cos * 0.5_f64.sqrt(), sin * 0.5_f64.sqrt(), 0.5_f64.sqrt()];
            (0..3).map(|k| x[k] * middle[k]).sum::<f64>().clamp(-1.0, 1.0).acos() * 0.025 < 4e-3
        });
        state.h[k] = if inside { 12e-9 } else { 260e-9 };
    }
}

/// Such a film in wind and eddies, without any losses.
fn stirred(columns: usize) -> Film {
    let p = Parameters {
        wind: 0.1,
        eddies: 0.1,
        noise: 0.0,
        evaporation: 0.0,
        regeneration: 0.0,
        drains_inside: false,
        spots: 0.0,
        rupture_m: 0.0,
        ..Parameters::preset("late").unwrap().with_columns(columns)
    };
    film(p, disks)
}

/// Area that is black film, of all; area of cells that are more than half of it; blackened liquid; share of the black area that lies
/// in cells that are neither.
fn told(film: &Film) -> [f64; 4] {
    let state = film.state();
    let grid = Grid::new(DOME, film.parameters().columns, film.parameters().rows);
    let all = grid.total_area();
    let half: Vec<f64> = state.black.iter().map(|&phi| f64::from(u8::from(phi >= 0.5))).collect();
    let mixed: Vec<f64> = state.black.iter().map(|&phi| if (0.05..0.95).contains(&phi) { phi } else { 0.0 }).collect();
    let area = grid.integral(&state.black);
    [area / all, grid.integral(&half) / all, state.books.blackened / state.books.start, grid.integral(&mixed) / area]
}

fn told_of(columns: usize) {
    let mut film = stirred(columns);
    let start = told(&film);
    println!("{columns} at first: {start:.4?}");
    for time_s in [0.25, 0.5, 1.0, 2.0] {
        film.advance_to(time_s).unwrap();
        let off = (film.volume() + film.state().books.gone()) / film.state().books.start - 1.0;
        let [least, most] = [film.summary().min_nm, film.summary().max_nm];
        println!("{columns} after {time_s} s: {:.4?}, booked to {off:.1e}, {least:.2} to {most:.1} nm", told(&film));
        assert!((told(&film)[0] / start[0] - 1.0).abs() < 5e-3 && off.abs() < 1e-12, "{columns}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn finer_stirred_disks() {
    for columns in [192, 384, 768] {
        told_of(columns);
    }
}

/// A round black film, 20 degrees in radius, that a sphere carries once around an axis tilted from its own, or that rests for as
/// many sub-steps: how much of its area is left, the area on the wrong side of its edge, and that which is neither (0.1 to 0.9), over
/// the length of the edge, in rows; how far off the rest is, where a cell has some.
fn round(columns: usize, tilt_deg: Option<f64>) -> [f64; 4] {
    use crate::share::Sharing;
    use crate::transport::Transport;
    use std::f64::consts::TAU;
    let grid = Grid::new(BUBBLE, columns, columns / 2);
    let n = columns;
    let mut state = Film::new(bare(BUBBLE, n, grid.rows)).unwrap().state().clone();
    if let Some(tilt) = tilt_deg.map(f64::to_radians) {
        let speed = TAU * grid.radius * grid.radius;
        stream(&grid, &mut state, |polar, turn| {
            -speed * (polar.sin() * turn.cos() * tilt.sin() + polar.cos() * tilt.cos())
        });
    }
    let radius = 20.0_f64.to_radians();
    let inside = |k: usize| (-grid.place(k / n, k % n)[1]).clamp(-1.0, 1.0).acos() < radius;
    let start: Vec<f64> = (0..grid.cells()).map(|k| f64::from(u8::from(inside(k)))).collect();
    let mut share = start.clone();
    let mut h: Vec<f64> = start.iter().map(|phi| 12e-9 * phi + 260e-9 * (1.0 - phi)).collect();
    let (mut transport, mut sharing) = (Transport::new(&grid), Sharing::new(&grid));
    let steps = match tilt_deg {
        Some(_) => columns * Transport::substeps(&grid, &state.down, &state.across, 1.0 / columns as f64) as usize,
        None => 2 * columns,
    };
    for _ in 0..steps {
        let dt = 1.0 / steps as f64;
        sharing.carry(&grid, &mut transport, [&mut h, &mut share], [&state.down, &state.across], (dt, 12e-9));
        sharing.sharpen(&grid, 12e-9, &mut h, &mut share);
    }
    assert!(share.iter().all(|phi| (0.0..=1.0).contains(phi)));
    let edge = TAU * grid.radius * radius.sin() * grid.dy;
    let of = |part: &dyn Fn(usize) -> bool| -> f64 {
        grid.integral(&(0..grid.cells()).map(|k| f64::from(u8::from(part(k)))).collect::<Vec<f64>>()) / edge
    };
    let worst = (0..grid.cells())
        .filter(|&k| share[k] < 0.95)
        .map(|k| ((h[k] - 12e-9 * share[k]) / (1.0 - share[k]) / 260e-9 - 1.0).abs())
        .fold(0.0, f64::max);
    let wrong = of(&|k| (share[k] >= 0.5) != (start[k] >= 0.5));
    let neither = of(&|k| (0.1..0.9).contains(&share[k]));
    [grid.integral(&share) / grid.integral(&start), wrong, neither, worst]
}

/// Edges keep their place and their width of two rows, whatever the angle at which they pass the grid.
#[test]
fn a_round_black_film_goes_around_and_stays_round() {
    for tilt_deg in [None, Some(0.0), Some(45.0), Some(90.0)] {
        for columns in [128, 256] {
            let [area, wrong, neither, rest] = round(columns, tilt_deg);
            println!(
                "round black film on {columns} columns, {tilt_deg:?} deg: area kept to {:.1e}, {wrong:.2} rows on the wrong \
                 side, edge of {neither:.2} rows, rest within {rest:.1e}",
                area - 1.0
            );
            assert!((area - 1.0).abs() < 1e-12 && wrong < 0.35 && neither < 2.2 && rest < 1e-9);
        }
    }
}

/// Black film is neither made nor lost by stirring; cells keep it, and all liquid is booked.
#[test]
fn stirred_black_film_is_kept() {
    let mut film = stirred(192);
    let start = told(&film)[0];
    film.advance_to(0.25).unwrap();
    let [area, half, blackened, _] = told(&film);
    let books = film.state().books;
    let off = (film.volume() + books.gone()) / books.start - 1.0;
    println!("stirred black film: {start:.4}, after 0.25 s {area:.4}, {half:.4} as drawn, booked to {off:.1e}");
    assert!((area / start - 1.0).abs() < 5e-3 && half > 0.9 * start && blackened.abs() < 1e-6 && off.abs() < 1e-12);
}

/// Without black film there is no share, and nothing is computed of it.
#[test]
fn a_film_without_black_film_has_no_share() {
    let p = Parameters { patch_m: 4e-3, ..Parameters::preset("bubble-on-bath").unwrap().with_columns(160) };
    let mut film = Film::new(p).unwrap();
    film.advance_to(0.2).unwrap();
    assert!(film.state().black.is_empty() && film.black_share().is_none());
}

/// A film that dries to its threshold turns black as a share of its cells, which keep the rest as thick as it was: the mean falls
/// as `exp(-t / black_s)` and so does the rest.
#[test]
fn film_below_the_threshold_turns_black_bit_by_bit() {
    let p =
        Parameters { thickness_m: 50e-9, black_below_m: 55e-9, black_m: 12e-9, black_s: 0.05, ..bare(BUBBLE, 16, 8) };
    let mut film = Film::new(p).unwrap();
    alone(|| film.advance_to(0.1)).unwrap();
    let (h, phi) = (film.state().h[40], film.state().black[40]);
    let left = (-2.0_f64).exp();
    println!("turning black: share {phi:.6}, mean {:.4} nm; law {:.6}, {:.4}", h * 1e9, 1.0 - left, 12.0 + 38.0 * left);
    assert!((phi - 1.0 + left).abs() < 1e-9 && (h - 12e-9 - 38e-9 * left).abs() < 1e-15);
    alone(|| film.advance_to(1.0)).unwrap();
    assert!(film.state().black.iter().all(|&phi| phi == 1.0));
}
