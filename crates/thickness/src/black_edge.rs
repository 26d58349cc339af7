//! The edge of black film between the cells of a film that has flowed.
//!
//! Black film ends abruptly: in the grid a cell is black or is not, and a curve through the thickness itself would follow
//! the corners of the cells, with all thicknesses between the two in a seam around them. Drawn is the smoothest edge that
//! leaves every cell on its side, and beyond it the thickness of the other side alone (after Whitaker, "Reducing aliasing
//! artifacts in iso-surfaces of binary volumes", IEEE Symposium on Volume Visualization 2000, with heat flow in the place
//! of the flow by mean curvature).

/// Rounds of smoothing, each by half a row squared; the edge bends within about twice as many rows as their root.
const ROUNDS: usize = 4;
/// Where the share of each cell is known its edge need not be found, only freed of what the grid lets stand between cells: a
/// circle of R rows is drawn smaller by a quarter of a row over R.
const ROUNDS_OF_SHARES: usize = 1;
const SPREAD: f64 = 0.5;
/// How far from the edge the middle of a cell stays, where 1 is far away.
const LEAST: f64 = 0.02;
/// Cells by which either side goes on beyond the edge: two that a cubic reaches, one that the edge may lie further, one
/// to spare.
const BEYOND: usize = 4;

/// The two sides of the edges of black film, where there is black film and other film.
#[derive(Debug, Clone, PartialEq)]
pub struct BlackEdge {
    /// Below zero in black film, above in the rest, 1 far away.
    pub level: Vec<f64>,
    /// Thickness of black film, which goes on beyond its edge, nm.
    pub black: Vec<f64>,
    /// Thickness of the rest, which goes on beyond its edge, nm.
    pub rest: Vec<f64>,
    /// Whether some cell of the three by three around each is on the other side, or holds both.
    near: Vec<bool>,
}

/// How a grid closes.
#[derive(Debug, Clone, Copy)]
struct Around {
    width: usize,
    height: usize,
    is_globe: bool,
}

impl Around {
    /// The row before the first or after the last, as a row and a shift of columns.
    fn row(&self, i: isize) -> (usize, usize) {
        let last = self.height as isize - 1;
        if (0..=last).contains(&i) {
            return (i as usize, 0);
        }
        let inside = if i < 0 { -1 - i } else { 2 * last + 1 - i }.clamp(0, last);
        // Beyond a pole lies the other side; beyond the border of a plane the border goes on.
        (inside as usize, if self.is_globe { self.width / 2 } else { 0 })
    }

    /// Cells around one, itself among them.
    fn nine(&self, i: usize, j: usize) -> [usize; 9] {
        let n = self.width;
        std::array::from_fn(|k| {
            let (row, shift) = self.row(i as isize + (k / 3) as isize - 1);
            row * n + (j + n + k % 3 - 1 + shift) % n
        })
    }
}

impl BlackEdge {
    /// Of a grid of thicknesses, film thinner than `below_nm` being black; `None` where all is black or none is. Cells of a
    /// plane are taken to be square.
    pub fn find(thickness_nm: &[f64], width: usize, is_globe: bool, below_nm: f64) -> Option<BlackEdge> {
        let is_black: Vec<bool> = thickness_nm.iter().map(|&nm| nm < below_nm).collect();
        let around = Around { width, height: thickness_nm.len() / width, is_globe };
        if is_black.iter().all(|&black| black == is_black[0]) {
            return None;
        }
        let sign: Vec<f64> = is_black.iter().map(|&black| if black { -1.0 } else { 1.0 }).collect();
        let level = spread_out(sign.clone(), ROUNDS, &around, |k, line| sign[k] * (sign[k] * line).max(LEAST));
        BlackEdge::between(level, &is_black, [thickness_nm; 2], &around, |_| false)
    }

    /// Of a grid of mean thicknesses, of which it is known what share of each cell is black film of `black_nm`.
    pub fn of_shares(
        thickness_nm: &[f64],
        width: usize,
        is_globe: bool,
        share: &[f64],
        black_nm: f64,
    ) -> Option<BlackEdge> {
        let is_black: Vec<bool> = share.iter().map(|&phi| phi >= 0.5).collect();
        let around = Around { width, height: thickness_nm.len() / width, is_globe };
        let pairs = || thickness_nm.iter().zip(share);
        let black: Vec<f64> = pairs().map(|(&nm, &phi)| if phi == 1.0 { nm } else { black_nm }).collect();
        let rest: Vec<f64> = pairs()
            .map(|(&nm, &phi)| if phi == 0.0 || phi >= 0.5 { nm } else { (nm - phi * black_nm).max(0.0) / (1.0 - phi) })
            .collect();
        let level = share.iter().map(|phi| 1.0 - 2.0 * phi).collect();
        let level = spread_out(level, ROUNDS_OF_SHARES, &around, |_, line| line);
        BlackEdge::between(level, &is_black, [&black, &rest], &around, |k| share[k] > 0.0 && share[k] < 1.0)
    }

    /// The edge where a level is zero, with thicknesses of either side from the cells that belong to it.
    fn between(
        level: Vec<f64>,
        is_black: &[bool],
        [black, rest]: [&[f64]; 2],
        around: &Around,
        holds_both: impl Fn(usize) -> bool,
    ) -> Option<BlackEdge> {
        let is_below = |k: usize| level[k] < 0.0;
        let is_rest: Vec<bool> = is_black.iter().map(|black| !black).collect();
        let alike = |sides: &[bool]| sides.iter().all(|&side| side == sides[0]);
        if alike(is_black) || (1..level.len()).all(|k| is_below(k) == is_below(0)) {
            return None;
        }
        let n = around.width;
        let near = (0..level.len())
            .map(|k| around.nine(k / n, k % n).into_iter().any(|at| is_below(at) != is_below(k) || holds_both(at)))
            .collect();
        let (black, rest) = (gone_on(black, is_black, around), gone_on(rest, &is_rest, around));
        Some(BlackEdge { level, black, rest, near })
    }

    /// Whether an edge may pass between four cells, or bend what is drawn between them: any of the sixteen around is on
    /// the other side.
    #[inline]
    pub fn passes(&self, cells: [usize; 4]) -> bool {
        cells.into_iter().any(|at| self.near[at])
    }
}

/// A level, smoothed over and over, each cell kept as `held` says.
fn spread_out(mut level: Vec<f64>, rounds: usize, around: &Around, held: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    let Around { width: n, height, is_globe } = *around;
    let mut lines = vec![0.0; level.len()];
    for _ in 0..rounds {
        for i in 0..height {
            let ((above, a), (below, b)) = (around.row(i as isize - 1), around.row(i as isize + 1));
            for j in 0..n {
                let beside = level[above * n + (j + a) % n] + level[below * n + (j + b) % n];
                lines[i * n + j] = (1.0 - SPREAD) * level[i * n + j] + 0.5 * SPREAD * beside;
            }
        }
        for (i, line) in lines.chunks_exact_mut(n).enumerate() {
            // Columns in a row of cells, of a globe whose rows are as high as they are wide at the equator.
            let wide = if is_globe {
                let sine = ((i as f64 + 0.5) * std::f64::consts::PI / height as f64).sin();
                2.0 * height as f64 / n as f64 * sine
            } else {
                1.0
            };
            spread(line, SPREAD / (wide * wide));
        }
        for (k, (level, line)) in level.iter_mut().zip(&lines).enumerate() {
            *level = held(k, *line);
        }
    }
    level
}

/// Spreads the values of a ring by a kernel that falls off exponentially both ways, of a variance in cells squared.
fn spread(ring: &mut [f64], variance: f64) {
    // A kernel a^|k| has the variance 2 a / (1 - a)^2.
    let b = 1.0 + 1.0 / variance;
    let a = b - (b * b - 1.0).sqrt();
    let turn = 1.0 / (1.0 - a.powi(ring.len().min(i32::MAX as usize) as i32));
    // What has come around once comes around again and again: a geometric series.
    let first: f64 = ring.iter().fold(0.0, |sum, value| sum * a + (1.0 - a) * value) * turn;
    ring.iter_mut().fold(first, |sum, value| {
        *value = sum * a + (1.0 - a) * *value;
        *value
    });
    let last: f64 = ring.iter().rev().fold(0.0, |sum, value| sum * a + (1.0 - a) * value) * turn;
    ring.iter_mut().rev().fold(last, |sum, value| {
        *value = sum * a + (1.0 - a) * *value;
        *value
    });
}

/// The values of the cells that are `own`, and beyond them means of what lies beside, ring by ring.
fn gone_on(values: &[f64], own: &[bool], around: &Around) -> Vec<f64> {
    let n = around.width;
    let mut out: Vec<f64> = values.iter().zip(own).map(|(&value, &own)| if own { value } else { 0.0 }).collect();
    let mut known = own.to_vec();
    for _ in 0..BEYOND {
        let found: Vec<(usize, f64)> = (0..values.len())
            .filter(|&k| !known[k])
            .filter_map(|k| {
                let beside = around.nine(k / n, k % n).into_iter().filter(|&at| known[at]);
                let (count, sum) = beside.fold((0.0, 0.0), |(count, sum), at| (count + 1.0, sum + out[at]));
                (count > 0.0).then(|| (k, sum / count))
            })
            .collect();
        for (k, value) in found {
            (out[k], known[k]) = (value, true);
        }
    }
    out
}
