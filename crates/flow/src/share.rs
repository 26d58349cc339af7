//! The share of each cell that is black film, carried with the film and kept sharp.
//!
//! It is carried by the scheme of the thickness: fluxes of that scheme are of first degree in what they carry, so that a
//! cell that is partly black film and partly film of one thickness stays a mixture of these two. What that spreads is then
//! drawn together again: neighbours exchange black film for the same area of other film until the share falls off across
//! an edge as `1 / (1 + exp(d / WIDTH))` with the distance d, the profile of conservative level sets (Olsson and Kreiss,
//! J. Comput. Phys. 210, 225, 2005). Here the exchange is one of detailed balance, `w phi_a (1 - phi_b)` one way and
//! `(1 - w) phi_b (1 - phi_a)` the other: it has that profile exactly, and no share can leave the range from 0 to 1.

use rayon::prelude::*;

use crate::grid::{Grid, Kind, PAD, Padded};
use crate::transport::{Rows, Transport, keep_in};

/// Scale of an edge's profile in rows: from a tenth to nine tenths within 1.5 rows.
const WIDTH: f64 = 0.35;
/// Greatest share of a cell that one side exchanges at a time: a cell has four.
const MOST: f64 = 0.25;
/// What two cells would exchange at most, below which they are left alone: what transport spreads thinly stays there.
const LEAST: f64 = 1e-6;
/// Rows that one thread takes at a time.
const BLOCK: usize = 8;

/// Room for the share of black film.
pub struct Sharing {
    share: Padded,
    /// Grows across an edge about as a distance, see [`distances`]: its slope tells the edge's direction.
    distance: Padded,
    excess: Padded,
    /// Rows that hold black film or have it next to them.
    near: Vec<bool>,
}

/// What the sides of a row of cells exchange: black film as shares of a cell, and the liquid above black film that comes
/// back for it, in thickness.
struct Exchanged {
    black: Vec<f64>,
    liquid: Vec<f64>,
}

impl Exchanged {
    fn nothing(columns: usize) -> Exchanged {
        Exchanged { black: vec![0.0; columns], liquid: vec![0.0; columns] }
    }

    fn clear(&mut self) {
        self.black.fill(0.0);
        self.liquid.fill(0.0);
    }
}

impl Sharing {
    pub fn new(grid: &Grid) -> Sharing {
        let padded = || Padded::new(grid, Kind::Scalar);
        Sharing { share: padded(), distance: padded(), excess: padded(), near: vec![false; grid.rows] }
    }

    /// Carries thickness and share over `dt` seconds in one sub-step.
    pub fn carry(
        &mut self,
        grid: &Grid,
        transport: &mut Transport,
        [h, share]: [&mut [f64]; 2],
        [down, across]: [&[f64]; 2],
        (dt, black_m): (f64, f64),
    ) {
        let n = grid.columns;
        self.find_rows(grid, share);
        let near = &self.near[..];
        transport.carry_rows(grid, share, [down, across], dt, Rows { some: Some(near), free: None });
        // Not kept within its range by itself: it would leave its mixture. Both are brought back together, below.
        transport.carry_rows(grid, h, [down, across], dt, Rows { some: None, free: Some(near) });
        let rows = share.par_chunks_exact_mut(n).zip(h.par_chunks_exact_mut(n));
        rows.enumerate().with_min_len(BLOCK).for_each(|(i, (share, h))| {
            if !near[i] {
                return;
            }
            let sides = [&down[i * n..(i + 1) * n], &down[(i + 1) * n..(i + 2) * n]];
            let lengths = [grid.side[i], grid.side[i + 1], grid.dy].map(|length| length * dt / grid.area[i]);
            wide!(undo_gathering(share, sides, &across[i * n..(i + 1) * n], lengths));
            keep(share, h, black_m);
            wide!(keep_in(h, 0.0, f64::INFINITY));
        });
    }

    /// Rows from which black film can come into others in a sub-step, and those that it can come into: it moves less than
    /// a cell, and parabolas reach two further.
    fn find_rows(&mut self, grid: &Grid, share: &[f64]) {
        const REACH: usize = 4;
        let n = grid.columns;
        let some: Vec<bool> =
            share.par_chunks_exact(n).with_min_len(BLOCK).map(|row| row.iter().any(|&phi| phi != 0.0)).collect();
        for (i, near) in self.near.iter_mut().enumerate() {
            *near = some[i.saturating_sub(REACH)..(i + REACH + 1).min(grid.rows)].iter().any(|&some| some);
        }
    }

    /// Draws edges together: black film goes where it is blacker, and as much other film comes back for it.
    pub fn sharpen(&mut self, grid: &Grid, black_m: f64, h: &mut [f64], share: &mut [f64]) {
        let n = grid.columns;
        let stride = n + 2 * PAD;
        self.find_rows(grid, share);
        self.share.fill(grid, Kind::Scalar, share);
        self.excess.fill(grid, Kind::Scalar, h);
        let near = &self.near;
        // Rows of ghosts are few: taken as near.
        let is_near = |padded_row: usize| *padded_row.checked_sub(PAD).and_then(|i| near.get(i)).unwrap_or(&true);
        self.distance
            .data
            .par_chunks_exact_mut(stride)
            .zip(self.share.data.par_chunks_exact(stride))
            .enumerate()
            .with_min_len(BLOCK)
            .filter(|(i, _)| is_near(*i))
            .for_each(|(_, (out, share))| wide!(distances(share, out)));
        let this = &*self;
        h.par_chunks_mut(n * BLOCK).zip(share.par_chunks_mut(n * BLOCK)).enumerate().for_each_init(
            || std::array::from_fn::<Exchanged, 3, _>(|_| Exchanged::nothing(n)),
            |[above, below, right], (block, (h, share))| {
                let first = block * BLOCK;
                let rows = h.len() / n;
                if !this.near[first..first + rows].iter().any(|&near| near) {
                    return;
                }
                this.exchange_down(grid, first, black_m, above);
                for k in 0..rows {
                    let i = first + k;
                    this.exchange_down(grid, i + 1, black_m, below);
                    this.exchange_across(grid, i, black_m, right);
                    let parts = [i, i + 1].map(|side| corner(grid, side) / grid.area[i]);
                    let row = k * n..(k + 1) * n;
                    wide!(gain(&mut share[row.clone()], [&above.black, &below.black, &right.black], parts, 1.0));
                    wide!(gain(&mut h[row], [&above.liquid, &below.liquid, &right.liquid], parts, -1.0));
                    std::mem::swap(above, below);
                }
            },
        );
    }

    /// Through the upper sides of a row, downwards; in shares of the smaller of the two cells.
    fn exchange_down(&self, grid: &Grid, i: usize, black_m: f64, out: &mut Exchanged) {
        if i == 0 || i == grid.rows || !(self.near[i - 1] && self.near[i]) {
            return out.clear();
        }
        let stride = self.share.stride;
        let (a, b) = ((i - 1 + PAD) * stride + PAD, (i + PAD) * stride + PAD);
        // How many rows four columns make, in the mean of both rows.
        let beside = 2.0 * (grid.width[i - 1] + grid.width[i]) / grid.dy;
        let pairs = [[a + 1, a - 1], [b + 1, b - 1]];
        self.exchange([a, b], pairs, [1.0, beside], black_m, out);
    }

    /// Through the right sides of a row; in shares of a cell.
    fn exchange_across(&self, grid: &Grid, i: usize, black_m: f64, out: &mut Exchanged) {
        if !self.near[i] {
            return out.clear();
        }
        let stride = self.share.stride;
        let first = (i + PAD) * stride + PAD;
        let pairs = [first, first + 1].map(|at| [at + stride, at - stride]);
        self.exchange([first, first + 1], pairs, [grid.width[i] / grid.dy, 4.0], black_m, out);
        if !grid.closes() {
            let last = grid.columns - 1;
            (out.black[last], out.liquid[last]) = (0.0, 0.0);
        }
    }

    /// From the cells of a row that begins at the first place to those of one that begins at the second. `pairs` are neighbours
    /// of either across the way between them; `rows` says how many rows lie between the cells and between the pairs, twice.
    fn exchange(&self, cells: [usize; 2], pairs: [[usize; 2]; 2], rows: [f64; 2], black_m: f64, out: &mut Exchanged) {
        let n = out.black.len();
        let of = |at: usize| &self.distance.data[at..at + n];
        let share = cells.map(|at| &self.share.data[at..at + n]);
        let h = cells.map(|at| &self.excess.data[at..at + n]);
        let (along, beside) = (cells.map(of), pairs.map(|pair| pair.map(of)));
        let Exchanged { black, liquid } = out;
        wide!(exchange(share, h, along, beside, rows, black_m, [&mut black[..], &mut liquid[..]]));
    }
}

/// A number for each share that grows across an edge of the profile `1 / (1 + exp(-y))` as about 0.6 y, and ends where shares are
/// too small to tell a direction.
#[inline(always)]
fn distances(share: &[f64], out: &mut [f64]) {
    let out = &mut out[..share.len()];
    for j in 0..share.len() {
        let phi = share[j];
        out[j] = (phi - 0.5) / (phi * (1.0 - phi) + 0.02).sqrt();
    }
}

#[inline(always)]
fn exchange(
    [a, b]: [&[f64]; 2],
    [h_a, h_b]: [&[f64]; 2],
    [d_a, d_b]: [&[f64]; 2],
    beside: [[&[f64]; 2]; 2],
    [reach, wide]: [f64; 2],
    black_m: f64,
    [black, liquid]: [&mut [f64]; 2],
) {
    let n = black.len();
    let (a, b, h_a, h_b, d_a, d_b) = (&a[..n], &b[..n], &h_a[..n], &h_b[..n], &d_a[..n], &d_b[..n]);
    let [[after_a, before_a], [after_b, before_b]] = beside.map(|pair| pair.map(|line| &line[..n]));
    let liquid = &mut liquid[..n];
    let (each, across) = (1.0 / reach, 1.0 / wide);
    for j in 0..n {
        let slope = (d_b[j] - d_a[j]) * each;
        let other = (after_a[j] - before_a[j] + after_b[j] - before_b[j]) * across;
        // Half the rows between the cells across the edge, in scales of the edge; its hyperbolic tangent (Pade, 3 over 2).
        let x = slope / (slope * slope + other * other + 1e-12).sqrt() * (0.5 * reach / WIDTH);
        let square = x * x;
        let lean = x * (27.0 + square) / (27.0 + 9.0 * square);
        let lean = if lean > 1.0 { 1.0 } else { lean };
        let lean = if lean < -1.0 { -1.0 } else { lean };
        let (forth, back) = (a[j] * (1.0 - b[j]), b[j] * (1.0 - a[j]));
        let flow = 0.5 * MOST * ((1.0 + lean) * forth - (1.0 - lean) * back);
        let flow = if forth + back < LEAST { 0.0 } else { flow };
        // Other film comes from where black film goes, as thick as it is there.
        let forward = flow > 0.0;
        let (room, h) = if forward { (1.0 - b[j], h_b[j]) } else { (1.0 - a[j], h_a[j]) };
        let room = if room > 1e-30 { room } else { 1e-30 };
        black[j] = flow;
        liquid[j] = flow / room * (h - black_m);
    }
}

/// What comes from above and from the left, less what leaves downwards and to the right, times `sign`.
#[inline(always)]
fn gain(row: &mut [f64], sides: [&[f64]; 3], [upper, lower]: [f64; 2], sign: f64) {
    let n = row.len();
    let [above, below, right] = sides.map(|side| &side[..n]);
    row[0] += sign * (above[0] * upper - below[0] * lower + (right[n - 1] - right[0]));
    for j in 1..n {
        row[j] += sign * (above[j] * upper - below[j] * lower + (right[j - 1] - right[j]));
    }
}

/// Area that neighbours above and below a side exchange through it at most: the smaller of them.
fn corner(grid: &Grid, side: usize) -> f64 {
    if side == 0 || side == grid.rows { 0.0 } else { grid.area[side - 1].min(grid.area[side]) }
}

/// A share of a cell stays the same where the cell itself closes up.
#[inline(always)]
fn undo_gathering(row: &mut [f64], sides: [&[f64]; 2], right: &[f64], lengths: [f64; 3]) {
    let n = row.len();
    let ([above, below], right) = (sides.map(|side| &side[..n]), &right[..n]);
    let [upper, lower, high] = lengths;
    for j in 0..n {
        let left = right[if j == 0 { n - 1 } else { j - 1 }];
        row[j] /= 1.0 + upper * above[j] - lower * below[j] + high * (left - right[j]);
    }
}

/// Cells of a row that share what lies beyond the limits.
const NEIGHBOURS: usize = 16;

/// What lies beyond 0 and 1 goes to cells nearby that are neither, so that edges stay where they are; other film changes
/// places with it.
fn keep(share: &mut [f64], h: &mut [f64], black_m: f64) {
    if share.iter().all(|phi| (0.0..=1.0).contains(phi)) {
        return;
    }
    for (share, h) in share.chunks_mut(NEIGHBOURS).zip(h.chunks_mut(NEIGHBOURS)) {
        pass_on(share, h, black_m);
    }
    pass_on(share, h, black_m);
    // No room in the whole row: a film that is all black or not at all.
    share.iter_mut().for_each(|phi| *phi = phi.clamp(0.0, 1.0));
}

/// Gives what cells have beyond 0 and 1 to those between, as far as they have room for it.
fn pass_on(share: &mut [f64], h: &mut [f64], black_m: f64) {
    let beyond = |phi: f64| phi - phi.clamp(0.0, 1.0);
    let (mut above, mut below, mut room) = (0.0, 0.0, 0.0);
    for &phi in share.iter() {
        let over = beyond(phi);
        above += over.max(0.0);
        below -= over.min(0.0);
        room += if over == 0.0 { phi * (1.0 - phi) } else { 0.0 };
    }
    if above == 0.0 && below == 0.0 {
        return;
    }
    // At most phi, or 1 - phi, of each cell between; what finds no room stays where it is.
    let part = if room > 0.0 { ((above - below) / room).clamp(-1.0, 1.0) } else { 0.0 };
    let part_above = if above > 0.0 { ((part * room).max(0.0) + below.min(above)) / above } else { 0.0 };
    let part_below = if below > 0.0 { ((-part * room).max(0.0) + above.min(below)) / below } else { 0.0 };
    // Other film comes from cells below 0, or from those between, and goes to those above 1, or to those between.
    let mut liquid = 0.0;
    let mut taken = 0.0;
    for (phi, h) in share.iter_mut().zip(h.iter_mut()) {
        let (over, excess) = (beyond(*phi), *h - black_m);
        let leaves = if over < 0.0 {
            -over * part_below
        } else if over == 0.0 && part > 0.0 {
            part * *phi * (1.0 - *phi)
        } else {
            continue;
        };
        if leaves > 0.0 {
            let gone = excess * leaves / (1.0 - *phi);
            (liquid, taken) = (liquid + gone, taken + leaves);
            *h -= gone;
            *phi += leaves;
        }
    }
    if taken <= 0.0 {
        return;
    }
    for (phi, h) in share.iter_mut().zip(h) {
        let over = beyond(*phi);
        let comes = if over > 0.0 {
            over * part_above
        } else if over == 0.0 && part < 0.0 {
            -part * *phi * (1.0 - *phi)
        } else {
            continue;
        };
        *h += liquid * (comes / taken);
        *phi -= comes;
    }
}

/// Thickness of what is not black film in a cell, m.
pub fn rest(h: f64, share: f64, black_m: f64) -> f64 {
    if share == 0.0 || share == 1.0 { h } else { black_m + (h - black_m) / (1.0 - share) }
}
