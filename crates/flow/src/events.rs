//! What happens to a film at times of its own: patches that a meniscus sends up, black spots that open.
//!
//! Events are numbered. The rate at which they come follows the film; event k comes when the integral of that rate
//! reaches the sum of k exponential draws, and all else about it is drawn from its number. So neither the length of a
//! step nor a checkpoint changes what is drawn.

use rayon::prelude::*;

use crate::chance::{Draws, Purpose};
use crate::grid::{Grid, Shape};
use crate::parameters::Parameters;
use crate::share::rest;

/// Most events of one step. A preset has a dozen; a rate beyond any film's would fill the memory and never come to an end.
const MOST_EVENTS: u64 = 1 << 20;

/// A sequence of events and how far it has come.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Clock {
    /// Integral of the rate so far.
    pub passed: f64,
    /// Where the next event comes.
    pub next: f64,
    /// Its number.
    pub number: u64,
}

impl Clock {
    pub fn new(seed: u64, purpose: Purpose) -> Clock {
        Clock { passed: 0.0, next: Draws::new(seed, purpose, 0).exponential(), number: 0 }
    }

    /// Lets `rate * dt` pass; calls `event` with the share of the step at which it comes and with its draws.
    fn run(&mut self, seed: u64, purpose: Purpose, passing: f64, mut event: impl FnMut(f64, &mut Draws)) {
        let first = self.number;
        while passing > 0.0 && self.next <= self.passed + passing && self.number - first < MOST_EVENTS {
            let mut draws = Draws::new(seed, purpose, self.number);
            draws.exponential();
            event((self.next - self.passed) / passing, &mut draws);
            self.number += 1;
            self.next += Draws::new(seed, purpose, self.number).exponential();
        }
        self.passed += passing;
    }
}

/// When a film bursts, if it does within a step, s: by chance where it is thinner than `rupture_m`, as often as the
/// parameters say, by a clock that runs as fast as such film is wide.
pub fn rupture(
    grid: &Grid,
    p: &Parameters,
    clock: &mut Clock,
    [h, share]: [&[f64]; 2],
    time: f64,
    dt: f64,
) -> Option<f64> {
    if p.rupture_m == 0.0 {
        return None;
    }
    let n = grid.columns;
    let rows: Vec<f64> = if share.is_empty() {
        let thin = |row: &[f64]| row.iter().filter(|&&h| h <= p.rupture_m).count() as f64;
        h.par_chunks_exact(n).with_min_len(8).map(thin).collect()
    } else {
        let black_m = p.black_film_m();
        let thin = |(&h, &phi): (&f64, &f64)| {
            let own = if black_m <= p.rupture_m { phi } else { 0.0 };
            if rest(h, phi, black_m) <= p.rupture_m { 1.0 } else { own }
        };
        let pairs = h.par_chunks_exact(n).zip(share.par_chunks_exact(n)).with_min_len(8);
        pairs.map(|(h, share)| h.iter().zip(share).map(thin).sum()).collect()
    };
    let area: f64 = rows.iter().zip(&grid.area).map(|(count, area)| count * area).sum();
    if area == 0.0 {
        return None;
    }
    if p.rupture_rate.is_infinite() {
        return Some(time + dt);
    }
    let mut burst = None;
    clock.run(p.seed, Purpose::Rupture, p.speed * p.rupture_rate * area * dt, |share, _| {
        burst = burst.or(Some(time + share * dt));
    });
    burst
}

/// A place where something grows: a patch at the meniscus, or a black spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// On the unit sphere, or x and height on the plane.
    pub place: [f64; 3],
    /// Final radius, m.
    pub radius: f64,
    /// When it began, s.
    pub from: f64,
    /// Thickness of a patch as a share of the film next to it; not used by black spots.
    pub ratio: f64,
}

/// Cells within `reach` metres of a place, with their distance in m.
pub fn near(grid: &Grid, place: [f64; 3], reach: f64, mut each: impl FnMut(usize, usize, f64)) {
    let rows = grid.rows;
    for row in 0..rows {
        // Rows that are too far are left out at once; columns that are not there only where a row is long.
        let (away, polar) = match grid.shape {
            Shape::Plane { .. } => ((grid.height[row] - place[2]).abs(), 0.0),
            Shape::Sphere { radius_m, .. } => {
                let own = place[2].clamp(-1.0, 1.0).acos();
                ((((row as f64 + 0.5) * grid.dy / radius_m) - own).abs() * radius_m, own)
            }
        };
        if away > reach {
            continue;
        }
        let n = grid.columns;
        let (middle, half) = match grid.shape {
            Shape::Plane { .. } => (place[0] / grid.width[0], reach / grid.width[0] + 1.0),
            Shape::Sphere { radius_m, .. } => {
                let turn = place[1].atan2(place[0]) / std::f64::consts::TAU;
                // Chord over the smaller of the two circles, with room to spare.
                let circle = (polar.sin() * grid.polar[row][0]).sqrt() * radius_m * std::f64::consts::TAU / n as f64;
                (turn * n as f64, if circle > 0.0 { 1.7 * reach / circle + 1.0 } else { n as f64 })
            }
        };
        // Around a row that closes on itself each column once; beside a border as far as it reaches.
        let half = (half.ceil() as usize).min(if grid.closes() { n / 2 } else { n });
        let first = middle.floor() as isize - half as isize;
        for k in 0..(2 * half).clamp(1, if grid.closes() { n } else { 2 * n }) {
            let column = first + k as isize;
            if !grid.closes() && !(0..n as isize).contains(&column) {
                continue;
            }
            let column = column.rem_euclid(n as isize) as usize;
            let cell = grid.place(row, column);
            let d = match grid.shape {
                Shape::Plane { width_m, .. } => {
                    let x = (cell[0] - place[0]).abs();
                    let x = if grid.closes() { x.min(width_m - x) } else { x };
                    x.hypot(cell[2] - place[2])
                }
                Shape::Sphere { radius_m, .. } => {
                    let chord = (0..3).map(|k| (cell[k] - place[k]).powi(2)).sum::<f64>().sqrt();
                    2.0 * radius_m * (chord / 2.0).min(1.0).asin()
                }
            };
            if d <= reach {
                each(row, column, d);
            }
        }
    }
}

/// Where the meniscus of a bubble or the lower border of a plane touches the film, as a row that may lie between two;
/// the length around it, m.
fn rim(grid: &Grid, p: &Parameters) -> (f64, f64) {
    let around = std::f64::consts::TAU;
    match grid.shape {
        Shape::Plane { width_m, .. } => (grid.rows as f64, width_m),
        Shape::Sphere { radius_m, rim_deg } if rim_deg < 180.0 => {
            (grid.rows as f64, around * radius_m * rim_deg.to_radians().sin())
        }
        Shape::Sphere { radius_m, .. } => {
            (grid.rows as f64 - p.drop_m / grid.dy, around * radius_m * (p.drop_m / radius_m).sin())
        }
    }
}

/// Mean thickness of the film along the wetted borders: above the rim column by column, then, where a frame has them,
/// beside the left and the right border row by row. A patch and a half wide.
fn beside(grid: &Grid, p: &Parameters, rim: f64, h: &[f64]) -> Vec<f64> {
    let n = grid.columns;
    let band = 1.5 * p.patch_m / grid.dy;
    let (first, last) = ((rim - band).max(0.0) as usize, (rim as usize).min(grid.rows));
    let first = first.min(last - 1);
    let mut means: Vec<f64> =
        (0..n).map(|j| (first..last).map(|i| h[i * n + j]).sum::<f64>() / (last - first) as f64).collect();
    if !grid.closes() {
        let wide = ((1.5 * p.patch_m / grid.width[0]) as usize).clamp(1, n);
        let mean = |cells: &[f64]| cells.iter().sum::<f64>() / wide as f64;
        means.extend(h.chunks_exact(n).map(|row| mean(&row[..wide])));
        means.extend(h.chunks_exact(n).map(|row| mean(&row[n - wide..])));
    }
    means
}

/// Marginal regeneration: the meniscus swallows thick film and gives the same area of thinner film back. Returns what
/// it swallowed, m3.
pub fn regenerate(
    grid: &Grid,
    p: &Parameters,
    clock: &mut Clock,
    patches: &mut Vec<Spot>,
    (h, share): (&mut [f64], &[f64]),
    time: f64,
    dt: f64,
) -> f64 {
    if !p.patches() {
        return 0.0;
    }
    let n = grid.columns;
    let (rim, length) = rim(grid, p);
    // Patches per metre and second at each column. A patch swallows what its shape takes of the film above the rim:
    // the integral of (1 - r^w) / (1 - r) over it is 0.478 of a full disk, to 1 % for r from 0.8 to 0.9.
    let area = 0.478 * std::f64::consts::PI * p.patch_m * p.patch_m;
    let speed =
        p.speed * p.regeneration * p.tension / p.viscosity / p.meniscus_m.powf(1.5) / (area * (1.0 - p.patch_ratio));
    // A wider meniscus pulls less.
    let below = if p.bottom_meniscus_m > 0.0 { (p.meniscus_m / p.bottom_meniscus_m).powf(1.5) } else { 1.0 };
    let means = beside(grid, p, rim, h);
    let mut sums = Vec::with_capacity(means.len() + 1);
    let mut sum = 0.0;
    sums.push(0.0);
    for (k, mean) in means.iter().enumerate() {
        // As many columns' worth as the place is long.
        let columns = if k < n { below } else { grid.dy / grid.width[0] };
        sum += columns * speed * mean.max(0.0).powf(1.5);
        sums.push(sum);
    }
    let passing = sum * length / n as f64 * dt;
    clock.run(p.seed, Purpose::Patch, passing, |share, draws| {
        let wanted = draws.share() * sum;
        let at = sums.partition_point(|&s| s < wanted).clamp(1, means.len()) - 1;
        let within = ((wanted - sums[at]) / (sums[at + 1] - sums[at])).clamp(0.0, 1.0);
        // The mean of a^2 is patch_m^2, as the rate has it.
        let radius = p.patch_m * (0.3 * draws.normal() - 0.09).exp();
        let radius = radius.clamp(0.4 * p.patch_m, 2.5 * p.patch_m);
        let ratio = (p.patch_ratio + 0.05 * draws.normal()).clamp(0.5 * p.patch_ratio, 0.98);
        let place = beside_border(grid, rim, at, within, radius);
        patches.push(Spot { place, radius, from: time + share * dt, ratio });
    });
    let swallowed = swallow(grid, p, patches, (h, share), [time, time + dt]);
    patches.retain(|patch| patch.from + p.patch_s > time + dt);
    swallowed
}

/// Where a patch is born at place `at` of the border (columns of the rim, then rows of the left and the right side), in m
/// on a plane: so far from the border that it swallows what the rate has it swallow.
fn beside_border(grid: &Grid, rim: f64, at: usize, within: f64, radius: f64) -> [f64; 3] {
    let n = grid.columns;
    let inside = 0.6 * radius;
    match grid.shape {
        Shape::Plane { width_m, height_m, .. } => {
            let row = ((at.max(n) - n) % grid.rows) as f64 + within;
            let height = height_m - row * grid.dy;
            match at.checked_sub(n) {
                None => [(at as f64 + within) * grid.width[0], 0.0, height_m - (rim - inside / grid.dy) * grid.dy],
                Some(row) if row < grid.rows => [inside, 0.0, height],
                Some(_) => [width_m - inside, 0.0, height],
            }
        }
        Shape::Sphere { radius_m, .. } => {
            let row = rim - inside / grid.dy;
            let (s, c) = (row * grid.dy / radius_m).sin_cos();
            let (sp, cp) = ((at as f64 + within) / n as f64 * std::f64::consts::TAU).sin_cos();
            [s * cp, s * sp, c]
        }
    }
}

/// What patches take of the film between two times, m3: in each cell what is not black film falls to `ratio` of itself
/// within the patch's life.
fn swallow(
    grid: &Grid,
    p: &Parameters,
    patches: &[Spot],
    (h, share): (&mut [f64], &[f64]),
    [from, to]: [f64; 2],
) -> f64 {
    let n = grid.columns;
    let black_m = if share.is_empty() { 0.0 } else { p.black_film_m() };
    let mut swallowed = 0.0;
    for patch in patches {
        let part = (to.min(patch.from + p.patch_s) - patch.from.max(from)) / p.patch_s;
        let strength = part.max(0.0) * -patch.ratio.ln();
        near(grid, patch.place, patch.radius, |row, column, d| {
            let x = (d / patch.radius).powi(2);
            let weight = (1.0 - x) * (1.0 - x) * (1.0 + 2.0 * x);
            let at = row * n + column;
            let black = share.get(at).map_or(0.0, |phi| phi * black_m);
            let other = h[at] - black;
            let thinner = other * (-strength * weight).exp();
            swallowed += (other - thinner) * grid.area[row];
            h[at] = black + thinner;
        });
    }
    swallowed
}

/// Black spots open at random places of thin film and widen; what they lose gathers in a rim around them, as in the
/// film itself. Returns what found no room there, m3.
pub fn open_spots(
    grid: &Grid,
    p: &Parameters,
    clock: &mut Clock,
    spots: &mut Vec<Spot>,
    (h, share): (&mut [f64], &mut Vec<f64>),
    time: f64,
    dt: f64,
) -> f64 {
    if p.spots == 0.0 {
        return 0.0;
    }
    let n = grid.columns;
    let black_m = p.black_film_m();
    let thin = |i: usize, j: usize| {
        let (h, phi) = (h[i * n + j], share.get(i * n + j).copied().unwrap_or(0.0));
        let thick = rest(h, phi, black_m);
        phi < 0.5 && thick < p.spot_below_m && thick > p.black_below_m
    };
    let rows: Vec<f64> = (0..grid.rows).map(|i| (0..n).filter(|&j| thin(i, j)).count() as f64 * grid.area[i]).collect();
    let total: f64 = rows.iter().sum();
    clock.run(p.seed, Purpose::Spot, p.speed * p.spots * total * dt, |share, draws| {
        let (row, column) = drawn_cell(grid, &rows, draws.share() * total, thin);
        let radius = (p.spot_m * (0.4 * draws.normal()).exp()).clamp(0.3 * p.spot_m, 3.0 * p.spot_m);
        spots.push(Spot { place: grid.place(row, column), radius, from: time + share * dt, ratio: 0.0 });
    });
    if !spots.is_empty() && share.is_empty() {
        share.resize(h.len(), 0.0);
    }
    let lost = spots.iter().map(|spot| open(grid, p, spot, (h, share), time + dt)).sum();
    let life = |spot: &Spot| spot.from + spot.radius / (p.speed * p.spot_speed);
    spots.retain(|spot| life(spot) > time + dt);
    lost
}

/// The cell in which `wanted` of the area ends that is thin enough; `rows` is that area, row by row.
fn drawn_cell(grid: &Grid, rows: &[f64], mut wanted: f64, thin: impl Fn(usize, usize) -> bool) -> (usize, usize) {
    let mut found = (0, 0);
    for (i, all) in rows.iter().enumerate() {
        if wanted > *all {
            wanted -= all;
            continue;
        }
        for j in (0..grid.columns).filter(|&j| thin(i, j)) {
            found = (i, j);
            wanted -= grid.area[i];
            if wanted <= 0.0 {
                break;
            }
        }
        break;
    }
    found
}

/// Opens a black spot as far as it has come by `time`; its liquid goes into a rim around it. What finds no room there, m3.
fn open(grid: &Grid, p: &Parameters, spot: &Spot, (h, share): (&mut [f64], &mut [f64]), time: f64) -> f64 {
    let (n, black_m) = (grid.columns, p.black_film_m());
    let radius = (p.speed * p.spot_speed * (time - spot.from)).min(spot.radius);
    // A rim as wide as the spot's own radius, two cells at least.
    let outer = 2.0 * radius + 2.0 * grid.dy;
    // What of a cell is outside, where its edge passes through it.
    let outside = |d: f64| ((d - radius) / grid.dy + 0.5).clamp(0.0, 1.0);
    // Area that can take liquid in: film around the spot that is not thin itself.
    let takes = |at: usize, d: f64, h: &[f64], share: &[f64]| {
        let thick = share[at] < 1.0 && rest(h[at], share[at], black_m) > p.black_below_m;
        if d > radius && thick { 1.0 - share[at] } else { 0.0 }
    };
    let (mut freed, mut room) = (0.0, 0.0);
    near(grid, spot.place, outer, |row, column, d| {
        let at = row * n + column;
        let (other, left) = (1.0 - share[at], outside(d));
        if left < other && h[at] > black_m {
            let excess = (h[at] - black_m) * (left / other);
            freed += (h[at] - black_m - excess) * grid.area[row];
            (h[at], share[at]) = (black_m + excess, 1.0 - left);
        }
        room += takes(at, d, h, share) * grid.area[row];
    });
    if room == 0.0 {
        return freed;
    }
    near(grid, spot.place, outer, |row, column, d| {
        let at = row * n + column;
        h[at] += freed / room * takes(at, d, h, share);
    });
    0.0
}
