//! Transport of thickness in flux form: what leaves a cell enters its neighbour, so that no liquid is lost.
//!
//! The scheme of Lin and Rood (Monthly Weather Review 124, 2046, 1996): one flux each way, each of a field that has
//! been carried half a step the other way, so that a constant stays constant in a flow without divergence. Fluxes are
//! of the piecewise parabolic method (Colella and Woodward, J. Comput. Phys. 54, 174, 1984); around the parallels they
//! reach over any number of cells.

use rayon::prelude::*;

use crate::grid::{GHOSTS, Ghosts, Grid, Kind, floor};

/// Furthest way down in one sub-step, cells; also how much neighbouring columns may close up.
const MOST_CELLS: f64 = 0.9;
/// Most sub-steps of a step.
pub const MOST_SUBSTEPS: f64 = 400.0;
/// Rows that one thread takes at a time.
const BLOCK: usize = 8;

pub struct Transport {
    ghosts: Ghosts,
    half_across: Vec<f64>,
    flux_across: Vec<f64>,
    limits: Vec<Limits>,
}

/// What a row of cells held before, and how fast the flow gathers there, 1/s.
#[derive(Clone, Copy, Default)]
struct Limits {
    least: f64,
    most: f64,
    gathers: f64,
}

/// Rows that are carried in another way.
#[derive(Clone, Copy, Default)]
pub struct Rows<'a> {
    /// Those in which a field is not nothing: none other is looked at, and none is kept within a range.
    pub some: Option<&'a [bool]>,
    /// Those that are not kept within their range.
    pub free: Option<&'a [bool]>,
}

impl Transport {
    pub fn new(grid: &Grid) -> Transport {
        Transport {
            ghosts: Ghosts::new(grid),
            half_across: vec![0.0; grid.cells()],
            flux_across: vec![0.0; grid.cells()],
            limits: vec![Limits::default(); grid.rows],
        }
    }

    /// How many sub-steps a step of `dt` seconds takes, as a number that may be too large.
    pub fn substeps(grid: &Grid, down: &[f64], across: &[f64], dt: f64) -> f64 {
        let n = grid.columns;
        let fastest: Vec<f64> = across
            .par_chunks_exact(n)
            .enumerate()
            .with_min_len(16)
            .map(|(i, row)| {
                let [closing, fastest] = wide!(extremes(row, &down[i * n..(i + 2) * n]));
                // A number that is none must be heard: `max` would swallow it.
                let (a, b) = (closing * (dt / grid.width[i]), fastest * dt / grid.dy);
                if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
            })
            .collect();
        let needed =
            fastest.into_iter().fold(0.0, |a: f64, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) });
        if needed.is_nan() { needed } else { (needed / MOST_CELLS).ceil().max(1.0) }
    }

    /// Carries `h` over `dt` seconds in one sub-step.
    pub fn step(&mut self, grid: &Grid, h: &mut [f64], down: &[f64], across: &[f64], dt: f64) {
        self.carry_rows(grid, h, [down, across], dt, Rows::default());
    }

    /// The same where rows differ.
    pub fn carry_rows(&mut self, grid: &Grid, h: &mut [f64], [down, across]: [&[f64]; 2], dt: f64, rows: Rows<'_>) {
        let n = grid.columns;
        let Rows { some, free } = rows;
        let is_nothing = |rows: std::ops::Range<usize>| some.is_some_and(|some| !some[rows].iter().any(|&some| some));
        let Transport { ghosts, half_across, flux_across, limits } = self;
        ghosts.fill(grid, Kind::Scalar, h);
        let from = &*h;
        let line = |i: isize| ghosts.line(from, i);
        let closes = grid.closes();
        half_across
            .par_chunks_exact_mut(n)
            .zip(flux_across.par_chunks_exact_mut(n))
            .zip(&mut *limits)
            .enumerate()
            .with_min_len(BLOCK)
            .for_each_init(Row::default, |room, (i, ((half, flux), limits))| {
                if is_nothing(i..i + 1) {
                    half.fill(0.0);
                    return flux.fill(0.0);
                }
                let (row, u) = (line(i as isize), &across[i * n..(i + 1) * n]);
                let (above, below) = (line(i as isize - 1), line(i as isize + 1));
                let (v, w) = (&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]);
                let rate = dt / grid.width[i];
                // Half a step across, by the velocity at the middles of cells; half a step down, and with that the
                // liquid through the right sides, m3.
                let lengths = [grid.side[i], grid.side[i + 1], grid.dy];
                wide!({
                    *limits = held(row, u, [v, w], lengths, 1.0 / grid.area[i]);
                    room.middles(u, rate);
                    room.half_across(row, closes, half);
                    room.half_down([above, row, below], [v, w], dt / grid.dy / 2.0, closes);
                    room.flux(u, rate, grid.dy * grid.width[i], flux);
                });
            });
        ghosts.fill(grid, Kind::Scalar, half_across);
        let half_across = &*half_across;
        let line = |i: isize| ghosts.line(half_across, i);
        // Liquid through the upper sides, m3; what enters less what leaves.
        let through = |i: usize, out: &mut [f64]| {
            if i == 0 || i == grid.rows {
                return out.fill(0.0);
            }
            let rows = std::array::from_fn(|k| line(i as isize + k as isize - 3));
            wide!(flux_down(rows, &down[i * n..(i + 1) * n], dt / grid.dy, grid.side[i] * dt, out));
        };
        h.par_chunks_mut(n * BLOCK).enumerate().for_each_init(
            || (vec![0.0; n], vec![0.0; n]),
            |(above, below), (block, rows)| {
                if is_nothing(block * BLOCK..block * BLOCK + rows.len() / n) {
                    return;
                }
                through(block * BLOCK, above);
                for (k, row) in rows.chunks_exact_mut(n).enumerate() {
                    let i = block * BLOCK + k;
                    through(i + 1, below);
                    wide!(change(row, [above, below], &flux_across[i * n..(i + 1) * n], 1.0 / grid.area[i]));
                    if some.is_none() && !free.is_some_and(|free| free[i]) {
                        let [low, top] = range(limits, i, dt);
                        wide!(keep_in(row, low, top));
                    }
                    std::mem::swap(above, below);
                }
            },
        );
    }
}

/// A flow without divergence takes a cell nowhere outside what was around it: the range of row `i` after a sub-step.
fn range(limits: &[Limits], i: usize, dt: f64) -> [f64; 2] {
    let around = &limits[i.saturating_sub(1)..(i + 2).min(limits.len())];
    let start = Limits { least: f64::INFINITY, most: f64::NEG_INFINITY, gathers: 0.0 };
    let all = around.iter().fold(start, |a, b| Limits {
        least: a.least.min(b.least),
        most: a.most.max(b.most),
        gathers: a.gathers.max(b.gathers),
    });
    // Twice that where it gathers: both fluxes are of fields that moved half a step.
    let room = 1.0 + 2.0 * dt * all.gathers + 1e-13;
    [all.least / room, all.most * room]
}

/// How much neighbours close up, and the fastest of the second; a number that is none comes through.
#[inline(always)]
fn extremes(row: &[f64], down: &[f64]) -> [f64; 2] {
    let closing = |a: f64, b: f64| (b - a).abs();
    // Several at a time: what one waits for is the other's time.
    let mut most = [[0.0_f64; 8]; 2];
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let n = row.len();
    most[0][0] = closing(row[n - 1], row[0]);
    for (k, (a, b)) in row[..n - 1].iter().zip(&row[1..]).enumerate() {
        most[0][k % 8] = larger(most[0][k % 8], closing(*a, *b));
    }
    for (k, v) in down.iter().enumerate() {
        most[1][k % 8] = larger(most[1][k % 8], v.abs());
    }
    // Zero times a sum is zero, or none.
    let heard = 0.0 * (row.iter().sum::<f64>() + down.iter().sum::<f64>());
    most.map(|most| most.into_iter().fold(0.0, larger) + heard)
}

/// `rows` are the three above and the three below.
#[inline(always)]
fn flux_down(rows: [&[f64]; 6], v: &[f64], rate: f64, whole: f64, out: &mut [f64]) {
    let n = out.len();
    let [a, b, c, d, e, f] = rows.map(|row| &row[..n]);
    let v = &v[..n];
    for j in 0..n {
        let courant = v[j] * rate;
        let forward = courant > 0.0;
        // Against the stream it is the same seen from below.
        let pick = |x: f64, y: f64| if forward { x } else { y };
        let cells = [pick(a[j], f[j]), pick(b[j], e[j]), pick(c[j], d[j]), pick(d[j], c[j]), pick(e[j], b[j])];
        out[j] = v[j] * whole * mean_leaving(cells, courant.abs());
    }
}

#[inline(always)]
fn change(row: &mut [f64], sides: [&[f64]; 2], right: &[f64], scale: f64) {
    let n = row.len();
    let [above, below] = sides.map(|side| &side[..n]);
    let right = &right[..n];
    row[0] -= (right[0] - right[n - 1] + below[0] - above[0]) * scale;
    for j in 1..n {
        row[j] -= (right[j] - right[j - 1] + below[j] - above[j]) * scale;
    }
}

/// Least and greatest thickness of a row, and the fastest that the flow gathers in one of its cells.
#[inline(always)]
fn held(row: &[f64], u: &[f64], sides: [&[f64]; 2], lengths: [f64; 3], scale: f64) -> Limits {
    let n = row.len();
    let ([v, w], u) = (sides.map(|side| &side[..n]), &u[..n]);
    let [upper, lower, high] = lengths;
    let (mut low, mut top, mut fast) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8], [0.0; 8]);
    for j in 0..n {
        let left = u[if j == 0 { n - 1 } else { j - 1 }];
        low[j % 8] = least(low[j % 8], row[j]);
        top[j % 8] = most(top[j % 8], row[j]);
        let gathers = upper * v[j] - lower * w[j] + high * (left - u[j]);
        fast[j % 8] = most(fast[j % 8], gathers.abs());
    }
    Limits {
        least: low.into_iter().fold(f64::INFINITY, least),
        most: top.into_iter().fold(f64::NEG_INFINITY, most),
        gathers: fast.into_iter().fold(0.0, most) * scale,
    }
}

/// Cells of a row that share what lies beyond the limits.
const SHARING: usize = 16;

/// Keeps a row within limits: what lies beyond them is shared among cells nearby that have room, or if they have none
/// among all of the row, so that nothing is lost. Two fluxes across each other overshoot where edges are sharp.
#[inline(always)]
pub fn keep_in(row: &mut [f64], low: f64, top: f64) {
    let (mut a, mut b) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    for (k, h) in row.iter().enumerate() {
        a[k % 8] = least(a[k % 8], *h);
        b[k % 8] = most(b[k % 8], *h);
    }
    if a.into_iter().fold(f64::INFINITY, least) >= low && b.into_iter().fold(f64::NEG_INFINITY, most) <= top {
        return;
    }
    let mut rest = 0.0;
    for cells in row.chunks_mut(SHARING) {
        rest += share(cells, low, top, 0.0);
    }
    if rest != 0.0 {
        let left = share(row, low, top, rest);
        // No room in the whole row: better a cell beyond the limits than liquid lost.
        row[0] += left;
    }
}

/// Clips cells and gives what was clipped, with what is `owed` to them, to those with room; returns what found none.
#[inline(always)]
fn share(cells: &mut [f64], low: f64, top: f64, owed: f64) -> f64 {
    let mut owed = owed;
    for h in cells.iter_mut() {
        let kept = most(least(*h, top), low);
        owed += *h - kept;
        *h = kept;
    }
    if owed == 0.0 {
        return 0.0;
    }
    let room: f64 = cells.iter().map(|h| if owed > 0.0 { top - h } else { h - low }).sum();
    if room <= 0.0 {
        return owed;
    }
    let part = least(owed.abs() / room, 1.0);
    for h in cells.iter_mut() {
        *h += part * if owed > 0.0 { top - *h } else { low - *h };
    }
    if part < 1.0 { 0.0 } else { owed - room.copysign(owed) }
}

/// Mean over the last `share` of the middle of five cells, of the parabola through it.
#[inline(always)]
fn mean_leaving(cells: [f64; 5], share: f64) -> f64 {
    let [a, b, c, d, e] = cells;
    let (left, right) = limited(b, c, d, edge(a, b, c, d), edge(b, c, d, e));
    leaving(c, left, right, share)
}

#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The value between `b` and `c` of four cells, never outside these two.
#[inline(always)]
fn edge(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let value = (7.0 * (b + c) - a - d) * (1.0 / 12.0);
    least(most(value, least(b, c)), most(b, c))
}

/// Ends of a parabola of mean `c`, such that it stays between its neighbours.
#[inline(always)]
fn limited(b: f64, c: f64, d: f64, left: f64, right: f64) -> (f64, f64) {
    let change = right - left;
    let bend = 6.0 * (c - 0.5 * (left + right));
    let (steep, square) = (change * bend, change * change);
    let new_left = if steep > square { 3.0 * c - 2.0 * right } else { left };
    let new_right = if steep < -square { 3.0 * c - 2.0 * left } else { right };
    let turns = (c - b) * (d - c) <= 0.0;
    (if turns { c } else { new_left }, if turns { c } else { new_right })
}

#[inline(always)]
fn leaving(c: f64, left: f64, right: f64, share: f64) -> f64 {
    let bend = 6.0 * (c - 0.5 * (left + right));
    right - 0.5 * share * (right - left - (1.0 - 2.0 / 3.0 * share) * bend)
}

/// Whole turns and the column of a place on a ring of `n`: seldom more than a turn away, so that nothing is divided.
#[inline(always)]
fn around(k: isize, n: usize) -> (isize, usize) {
    let n = n as isize;
    let turns = isize::from(k >= n) - isize::from(k < 0);
    let at = k - turns * n;
    if (0..n).contains(&at) { (turns, at as usize) } else { (k.div_euclid(n), k.rem_euclid(n) as usize) }
}

/// Room for one parallel.
#[derive(Default)]
struct Row {
    /// Courant numbers of half a step at the middles of cells.
    middles: Vec<f64>,
    /// Whether some reach a whole cell.
    far: bool,
    /// The row half a step down, with ghosts on either side.
    cells: Vec<f64>,
    /// Left and right ends of the parabolas of cells -1 to n.
    ends: [Vec<f64>; 2],
    /// Sums of the first cells.
    sums: Vec<f64>,
}

impl Row {
    #[inline(always)]
    fn middles(&mut self, u: &[f64], rate: f64) {
        let n = u.len();
        self.middles.resize(n, 0.0);
        self.cells.resize(n + 2 * GHOSTS, 0.0);
        self.ends.iter_mut().for_each(|ends| ends.resize(n + 2, 0.0));
        let half = rate / 2.0;
        let out = &mut self.middles[..n];
        out[0] = (u[0] + u[n - 1]) * half;
        for j in 1..n {
            out[j] = (u[j] + u[j - 1]) * half;
        }
        let mut fastest = [0.0; 8];
        for (k, u) in u.iter().enumerate() {
            fastest[k % 8] = most(fastest[k % 8], u.abs());
        }
        self.far = fastest.into_iter().fold(0.0, most) * rate >= 1.0;
    }

    /// Half of it as it is and half of it a half step later.
    #[inline(always)]
    fn half_across(&mut self, row: &[f64], closes: bool, out: &mut [f64]) {
        let n = row.len();
        let (c, out) = (&self.middles[..n], &mut out[..n]);
        if self.far {
            for j in 0..n {
                let from = j as f64 - c[j];
                let left = floor(from);
                let share = from - left;
                let (left, right) = if closes {
                    let (_, left) = around(left as isize, n);
                    (left, if left + 1 == n { 0 } else { left + 1 })
                } else {
                    // No way leads beyond a border; half a cell next to it is its own mirror image.
                    let within = |k: isize| k.clamp(0, n as isize - 1) as usize;
                    (within(left as isize), within(left as isize + 1))
                };
                out[j] = 0.5 * (row[j] + row[left] * (1.0 - share) + row[right] * share);
            }
            return;
        }
        let one = |before: f64, here: f64, after: f64, c: f64| {
            let slope = if c > 0.0 { here - before } else { after - here };
            here - 0.5 * c * slope
        };
        let (first, last) = if closes { (row[n - 1], row[0]) } else { (row[0], row[n - 1]) };
        out[0] = one(first, row[0], row[1], c[0]);
        for j in 1..n - 1 {
            out[j] = one(row[j - 1], row[j], row[j + 1], c[j]);
        }
        out[n - 1] = one(row[n - 2], row[n - 1], last, c[n - 1]);
    }

    #[inline(always)]
    fn half_down(&mut self, rows: [&[f64]; 3], sides: [&[f64]; 2], rate: f64, closes: bool) {
        let n = rows[0].len();
        let [above, here, below] = rows.map(|row| &row[..n]);
        let [v, w] = sides.map(|side| &side[..n]);
        let out = &mut self.cells[GHOSTS..GHOSTS + n];
        for j in 0..n {
            let c = (v[j] + w[j]) * rate;
            let from = if c > 0.0 { above[j] } else { below[j] };
            out[j] = here[j] - 0.5 * c.abs() * (here[j] - from);
        }
        for k in 0..GHOSTS {
            let (left, right) = if closes { (n - 1 - k, k) } else { (k, n - 1 - k) };
            self.cells[GHOSTS - 1 - k] = self.cells[GHOSTS + left];
            self.cells[GHOSTS + n + k] = self.cells[GHOSTS + right];
        }
    }

    /// What passes the right side of each cell, in thickness times `whole`.
    #[inline(always)]
    fn flux(&mut self, u: &[f64], rate: f64, whole: f64, out: &mut [f64]) {
        let n = u.len();
        let out = &mut out[..n];
        let c = &self.cells[..n + 2 * GHOSTS];
        // Ends k belong to cell k - 1, which is c[k + 2].
        let [lefts, rights] = &mut self.ends;
        let (lefts, rights) = (&mut lefts[..n + 2], &mut rights[..n + 2]);
        for k in 0..n + 2 {
            let (left, right) =
                (edge(c[k], c[k + 1], c[k + 2], c[k + 3]), edge(c[k + 1], c[k + 2], c[k + 3], c[k + 4]));
            (lefts[k], rights[k]) = limited(c[k + 1], c[k + 2], c[k + 3], left, right);
        }
        if !self.far {
            let here = &c[GHOSTS..GHOSTS + n + 1];
            for j in 0..n {
                let courant = u[j] * rate;
                let forward = courant > 0.0;
                let pick = |x: f64, y: f64| if forward { x } else { y };
                let cell = pick(here[j], here[j + 1]);
                let (from, to) = (pick(lefts[j + 1], rights[j + 2]), pick(rights[j + 1], lefts[j + 2]));
                out[j] = courant * whole * leaving(cell, from, to, courant.abs());
            }
            return;
        }
        let row = &c[GHOSTS..GHOSTS + n];
        self.sums.clear();
        self.sums.push(0.0);
        let mut sum = 0.0;
        for value in row {
            sum += value;
            self.sums.push(sum);
        }
        let (total, sums) = (sum, &self.sums);
        // Sum of the cells before `k`, which may lie any number of turns away.
        let up_to = |k: isize| {
            let (turns, k) = around(k, n);
            total * turns as f64 + sums[k]
        };
        for j in 0..n {
            let courant = u[j] * rate;
            let passing = floor(courant.abs());
            let share = courant.abs() - passing;
            let cells = passing as isize;
            // The first cell that is not passed whole.
            let (k, forward) = if courant > 0.0 { (j as isize - cells, true) } else { (j as isize + 1 + cells, false) };
            let (_, at) = around(k, n);
            let (left, right) = (lefts[at + 1], rights[at + 1]);
            let (from, to) = if forward { (left, right) } else { (right, left) };
            let mut passed = share * leaving(row[at], from, to, share);
            if cells > 0 {
                let j = j as isize;
                passed += if forward { up_to(j + 1) - up_to(k + 1) } else { up_to(k) - up_to(j + 1) };
            }
            out[j] = if forward { passed } else { -passed } * whole;
        }
    }
}
