//! Kernels over rows of cells: plain loops that become vector instructions where [`wide!`] compiles them.

/// What pushes a row of sides.
pub struct Pushed {
    pub density: f64,
    pub air_mass: f64,
    pub dt: f64,
    pub gravity: f64,
    /// Air that comes down upon a frame that is shaken, m/s.
    pub coming: f64,
    pub coupling: f64,
}

#[inline(always)]
pub fn push_row(p: &Pushed, h: [&[f64]; 2], drag: [&[f64]; 2], air: &[f64], u: &mut [f64], inverse: &mut [f64]) {
    let n = u.len();
    let ([a, b], [c, d], air) = (h.map(|h| &h[..n]), drag.map(|drag| &drag[..n]), &air[..n]);
    let inverse = &mut inverse[..n];
    for j in 0..n {
        let weight = p.density * (a[j] + b[j]) * 0.5;
        let (mass, c) = (weight + p.air_mass, (c[j] + d[j]) * 0.5);
        let one = 1.0 / (mass + p.dt * c);
        u[j] = (mass * u[j] + p.dt * (weight * p.gravity + c * (air[j] + p.coming))) * one;
        inverse[j] = p.coupling * one;
    }
}

/// `weight s` less what leaves each cell of a row; lengths of the upper, the lower and the right side.
#[inline(always)]
pub fn gathering(sides: [&[f64]; 2], right: &[f64], lengths: [f64; 3], s: &[f64], weight: f64, out: &mut [f64]) {
    let n = out.len();
    let ([above, below], right, s) = (sides.map(|side| &side[..n]), &right[..n], &s[..n]);
    let [upper, lower, high] = lengths;
    out[0] = weight * s[0] - (lower * below[0] - upper * above[0] + high * (right[0] - right[n - 1]));
    for j in 1..n {
        out[j] = weight * s[j] - (lower * below[j] - upper * above[j] + high * (right[j] - right[j - 1]));
    }
}

#[inline(always)]
pub fn pull(out: &mut [f64], before: &[f64], after: &[f64], coupling: &[f64], scale: f64) {
    let n = out.len();
    let (before, after, coupling) = (&before[..n], &after[..n], &coupling[..n]);
    for j in 0..n {
        out[j] -= (after[j] - before[j]) * coupling[j] * scale;
    }
}

/// Sum in an order of its own: eight at a time.
#[inline(always)]
pub fn sum(values: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (whole, rest) = values.as_chunks::<8>();
    for part in whole {
        for k in 0..8 {
            sums[k] += part[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

/// Zero, unless one of the values is no number.
#[inline(always)]
pub fn none(values: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (whole, rest) = values.as_chunks::<8>();
    for part in whole {
        for k in 0..8 {
            sums[k] += 0.0 * part[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|value| 0.0 * value).sum::<f64>()
}

#[inline(always)]
pub fn drag_of(sides: [&[f64]; 2], right: &[f64], stress: f64, least: f64, out: &mut [f64]) {
    let n = out.len();
    let ([above, below], right) = (sides.map(|side| &side[..n]), &right[..n]);
    let one = |v: f64, u: f64| {
        let speed = (0.25 * (v * v + u * u)).sqrt();
        stress * if speed > least { speed } else { least }.sqrt()
    };
    out[0] = one(above[0] + below[0], right[0] + right[n - 1]);
    for j in 1..n {
        out[j] = one(above[j] + below[j], right[j] + right[j - 1]);
    }
}

#[inline(always)]
pub fn thin_row(row: &mut [f64], loss: f64, kept: f64, [black_m, below_m]: [f64; 2]) -> (f64, f64) {
    let (mut dry, mut black) = ([0.0; 8], [0.0; 8]);
    let one = |h: &mut f64, dry: &mut f64, black: &mut f64| {
        let room = *h - black_m;
        let room = if room > 0.0 { room } else { 0.0 };
        let taken = if loss < room { loss } else { room };
        let left = *h - taken;
        let turned = black_m + (left - black_m) * kept;
        let new = if left < below_m { turned } else { left };
        *dry += taken;
        *black += left - new;
        *h = new;
    };
    let (whole, rest) = row.as_chunks_mut::<8>();
    for part in whole {
        for k in 0..8 {
            one(&mut part[k], &mut dry[k], &mut black[k]);
        }
    }
    for h in rest {
        one(h, &mut dry[0], &mut black[0]);
    }
    (dry.iter().sum(), black.iter().sum())
}

/// Share of a cell below which what is left of film that turns black is black film, too.
const LEFT: f64 = 1e-3;

/// The same where a share of each cell is black film: evaporation thins the rest, and the rest turns black bit by bit where it
/// is thinner than `below_m`, without thinning on its way.
#[inline(always)]
pub fn thin_mixed_row(
    row: &mut [f64],
    share: &mut [f64],
    loss: f64,
    kept: f64,
    [black_m, below_m]: [f64; 2],
) -> (f64, f64) {
    let (mut dry, mut black) = (0.0, 0.0);
    let share = &mut share[..row.len()];
    for (h, phi) in row.iter_mut().zip(share) {
        let rest = 1.0 - *phi;
        // What the rest has above black film; that which closed up or drew apart has some, too.
        let excess = *h - black_m;
        let room = if excess > 0.0 { excess } else { 0.0 };
        let taken = if rest * loss < room { rest * loss } else { room };
        let left = excess - taken;
        let turns = left < rest * (below_m - black_m) || rest == 0.0;
        let (new, new_rest) = if turns { (left * kept, rest * kept) } else { (left, rest) };
        *phi = if turns && (new_rest < LEFT || new <= 0.0) { 1.0 } else { 1.0 - new_rest };
        dry += taken;
        black += left - new;
        *h = black_m + new;
    }
    (dry, black)
}
