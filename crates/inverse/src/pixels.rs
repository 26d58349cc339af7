//! What one pixel says of the film under it: costs of all thicknesses, and the few that could be.
//!
//! For a film whose channels are m_c(h) the pixel is y_c = g m_c(h) + eps_c, g = 1 +- sg (shading), eps_c normal of variance
//! 1/w_c(h). With g integrated out (Woodbury's identity),
//!
//! ```text
//! E(h) = 1/2 [sum w y^2 + 1/sg^2 - (sum w m y + 1/sg^2)^2 / (sum w m^2 + 1/sg^2)] + 1/2 log(1 + sg^2 sum w m^2) - 1/2 sum log w
//! ```
//!
//! All that depends on h alone stands in a table, so that a thickness costs fourteen operations. A channel above its limit says only that
//! it is at least there (a censored datum): half the square of what is missing, where something is.

use rayon::prelude::*;

use crate::InverseError;

/// As many thicknesses are kept of a pixel.
pub const MOST: usize = 6;
/// Costs so far above the best are not kept, and so far, tempered, are looked at: a wide minimum may be the likelier one.
const SPAN: f32 = 14.0;
pub(crate) const REACH: f32 = SPAN + 8.0;
/// Thicknesses that are looked at together.
pub(crate) const EIGHT: usize = 8;
/// Steps towards the film nearest to a minimum of the grid, at most.
pub(crate) const STEPS: usize = 3;
/// A turning point of colour is no wider than this, nm.
const WIDEST_NM: f32 = 30.0;

/// The least of some numbers, by lanes.
#[inline(always)]
fn lowest(of: &[f32]) -> f32 {
    let mut lanes = [f32::INFINITY; EIGHT];
    let (whole, rest) = of.as_chunks::<EIGHT>();
    for eight in whole {
        for (lane, value) in lanes.iter_mut().zip(eight) {
            *lane = if *value < *lane { *value } else { *lane };
        }
    }
    lanes.iter().chain(rest).copied().fold(f32::INFINITY, f32::min)
}

/// Channels of every film, and how they vary.
#[derive(Debug, Clone)]
pub struct PixelTable {
    /// Thicknesses, evenly spaced: the first, the step, how many.
    first_nm: f32,
    step_nm: f32,
    count: usize,
    /// For sixteen pixels at once, thickness by thickness: w and w m of the channels, and what is [`Known`] of all three; and one
    /// more, whose cost is endless.
    pub(crate) columns: Vec<[f32; 8]>,
    /// For each channel: w, w m.
    weight: [Vec<f32>; 3],
    weighted: [Vec<f32>; 3],
    /// By the channels that are numbers (bit c: channel c).
    known: Vec<Known>,
    pub(crate) model: [Vec<f32>; 3],
    /// 1/sg^2.
    pub(crate) shading: f32,
    /// Standard deviation of the thickness of one pixel, tempered, nm, and minus its logarithm.
    sd_nm: Vec<f32>,
    narrowness: Vec<f32>,
    gain: f32,
    pub(crate) haze: [f32; 3],
    clip: [f32; 3],
    pub(crate) noise: [[f32; 2]; 3],
    pub(crate) unknown: f32,
    /// By how much a cost may lie above the minimum beside it, at most, for every eight thicknesses: half a step of so many
    /// standard deviations.
    pub(crate) coarse: Vec<f32>,
    pub(crate) coarsest: f32,
    /// Tempered costs above this are cut: outliers happen.
    floor: f32,
    pub(crate) temper: f32,
    bare: bool,
}

/// Pattern in which all channels are numbers.
const ALL: usize = 0b111;

/// What a pixel's cost takes from thickness alone, by the channels that are numbers.
#[derive(Debug, Clone, Default)]
struct Known {
    /// 1 / (sum w m^2 + 1/sg^2).
    inverse: Vec<f32>,
    /// What is left of E.
    constant: Vec<f32>,
}

/// How a picture's numbers come about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Picture = gain * film + haze.
    pub gain: f32,
    /// Haze of each channel.
    pub haze: [f32; 3],
    /// Variance of the noise of each channel: `noise[c][0] + noise[c][1] * value + (unknown * value)^2`.
    pub noise: [[f32; 2]; 3],
    /// What the model does not know of a value, of itself: indices, the cone of the lens, the curve of the camera.
    pub unknown: f32,
    /// Standard deviation of the gain from pixel to pixel, of itself.
    pub shading: f32,
    /// Values at or above which a channel is full.
    pub clip: [f32; 3],
    /// Whether values at 0 were cut there.
    pub cut_at_zero: bool,
    /// By how much neighbours' errors hang together, >= 1.
    pub temper: f32,
    /// Density of pixels that show something else.
    pub outlier: f32,
}

/// Thicknesses that one pixel could have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Thickness, nm; NaN for none.
    pub thickness_nm: f32,
    /// Likelihood, tempered, times the width of its minimum; of the best one, which has 1. 0 for none.
    pub likelihood: f32,
    /// Standard deviation, nm, tempered.
    pub sd_nm: f32,
}

/// Those of a pixel, best first.
pub type Candidates = [Candidate; MOST];

/// No candidate.
pub const NONE: Candidate = Candidate { thickness_nm: f32::NAN, likelihood: 0.0, sd_nm: 0.0 };

/// Refuses a table or an exposure that makes no sense.
fn check(step_nm: f32, model: &[Vec<f32>; 3], of: &Exposure) -> Result<(), InverseError> {
    let count = model[0].len();
    let positive =
        of.gain > 0.0 && of.temper >= 1.0 && of.shading >= 0.0 && of.noise.iter().flatten().all(|n| *n >= 0.0);
    if count < 3
        || model.iter().any(|m| m.len() != count || m.iter().any(|v| !v.is_finite()))
        || step_nm.is_nan()
        || step_nm <= 0.0
    {
        return Err(InverseError::Argument(format!("a table of {count} thicknesses by {step_nm} nm is none")));
    }
    if !positive || of.haze.iter().any(|h| !h.is_finite()) {
        return Err(InverseError::Argument(format!("an exposure must be positive and finite, got {of:?}")));
    }
    Ok(())
}

impl PixelTable {
    /// A table of `model[c][k]` for thicknesses `first_nm + k step_nm`, under an exposure.
    pub fn new(first_nm: f32, step_nm: f32, model: &[Vec<f32>; 3], of: &Exposure) -> Result<PixelTable, InverseError> {
        check(step_nm, model, of)?;
        let count = model[0].len();
        let shading = 1.0 / (of.shading * of.shading).max(1e-8);
        let mut table = PixelTable {
            first_nm,
            step_nm,
            count,
            columns: Vec::with_capacity(count),
            weight: Default::default(),
            weighted: Default::default(),
            known: vec![Known::default(); ALL + 1],
            model: std::array::from_fn(|c| model[c].iter().map(|m| of.gain * m).collect()),
            shading,
            sd_nm: Vec::with_capacity(count),
            narrowness: Vec::with_capacity(count),
            gain: of.gain,
            haze: of.haze,
            clip: of.clip,
            noise: of.noise,
            unknown: of.unknown,
            coarse: vec![0.0; (count + 1).div_ceil(EIGHT)],
            coarsest: 0.0,
            floor: -(of.outlier.max(1e-30)).ln(),
            temper: of.temper,
            bare: of.cut_at_zero,
        };
        for k in 0..count {
            table.push(k);
        }
        // Beyond the last there is nothing, so that a minimum there has two sides, too.
        table.columns.push([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::INFINITY]);
        table.coarsest = table.coarse.iter().copied().fold(0.0, f32::max);
        Ok(table)
    }

    /// The column of the thickness `k`, of which the model is known.
    fn push(&mut self, k: usize) {
        let m: [f32; 3] = std::array::from_fn(|c| self.model[c][k]);
        let w: [f32; 3] = std::array::from_fn(|c| self.weight_of(c, m[c]));
        for (pattern, known) in self.known.iter_mut().enumerate() {
            let of = || (0..3).filter(|c| pattern >> c & 1 == 1);
            let square: f32 = of().map(|c| w[c] * m[c] * m[c]).sum();
            let volume = 0.5 * (1.0 + square / self.shading).ln() - 0.5 * of().map(|c| w[c].ln()).sum::<f32>();
            known.inverse.push(1.0 / (square + self.shading));
            known.constant.push(volume + 0.5 * self.shading);
        }
        let inverse = self.known[ALL].inverse[k];
        for c in 0..3 {
            self.weight[c].push(w[c]);
            self.weighted[c].push(w[c] * m[c]);
        }
        let constant = self.known[ALL].constant[k];
        self.columns.push([w[0], w[1], w[2], w[0] * m[0], w[1] * m[1], w[2] * m[2], inverse, constant]);
        // The slope, less its part along m, which a change of gain imitates.
        let (a, b) = (k.saturating_sub(1), (k + 1).min(self.count - 1));
        let slope: [f32; 3] =
            std::array::from_fn(|c| (self.model[c][b] - self.model[c][a]) / ((b - a) as f32 * self.step_nm));
        let along: f32 = (0..3).map(|c| w[c] * m[c] * slope[c]).sum();
        let whole: f32 = (0..3).map(|c| w[c] * slope[c] * slope[c]).sum();
        // Where colour stands still, a minimum is as wide as its curvature makes it, not endless.
        let alone = 1.0 / (whole - along * along * inverse).max(1e-12);
        let coarse = &mut self.coarse[k / EIGHT];
        *coarse = coarse.max(0.125 * self.step_nm * self.step_nm / alone);
        let sd = (self.temper * alone).sqrt().min(WIDEST_NM);
        self.sd_nm.push(sd);
        self.narrowness.push(-sd.ln());
    }

    /// Weight of a channel whose film has the light `m`. Channels that a colour matrix has mixed may be below zero: what a model
    /// does not know of them is a share of their size.
    #[inline(always)]
    fn weight_of(&self, c: usize, m: f32) -> f32 {
        let value = m + self.haze[c];
        1.0 / (self.noise[c][0] + self.noise[c][1] * value.max(0.0) + (self.unknown * value).powi(2)).max(1e-14)
    }

    /// Channels beside column `k` by `t` steps, and their change a step: parabolas through three columns.
    #[inline(always)]
    fn beside(&self, k: usize, t: f32) -> ([f32; 3], [f32; 3]) {
        let k = k.clamp(1, self.count - 2);
        let of = |c: usize| {
            let (a, b, d) = (self.model[c][k - 1], self.model[c][k], self.model[c][k + 1]);
            (b, 0.5 * (d - a), a - 2.0 * b + d)
        };
        (
            std::array::from_fn(|c| {
                let (at, slope, bend) = of(c);
                at + t * (slope + 0.5 * t * bend)
            }),
            std::array::from_fn(|c| {
                let (_, slope, bend) = of(c);
                slope + t * bend
            }),
        )
    }

    /// The film nearest to a minimum of the grid: (steps from column `k`, its cost). Steps are too coarse for a parabola through
    /// costs, whose height is many times their noise's; colours are smooth enough for one.
    #[inline(always)]
    fn refined(&self, pixel: [f32; 3], k: usize, start: f32) -> (f32, f32) {
        let (middle, offset) = (k.clamp(1, self.count - 2), k as f32 - k.clamp(1, self.count - 2) as f32);
        // Beyond the ends there is no film.
        let (low, high) = (-(k as f32), (self.count - 1 - k) as f32);
        let full: [bool; 3] = std::array::from_fn(|c| pixel[c] >= self.clip[c]);
        let empty: [bool; 3] = std::array::from_fn(|c| self.bare && pixel[c] <= 0.0);
        let v: [f32; 3] = std::array::from_fn(|c| pixel[c] - self.haze[c]);
        let whole = (0..3).filter(|&c| !full[c] && !empty[c]).map(|c| 1 << c).sum::<usize>();
        // What is left of the cost is as smooth as the colours are.
        let constant = &self.known[whole].constant;
        let mut t = start;
        for turn in 0..=STEPS {
            let (m, slope) = self.beside(middle, t + offset);
            let w: [f32; 3] = std::array::from_fn(|c| self.weight_of(c, m[c]));
            let (mut square, mut along, mut size) = (self.shading, self.shading, self.shading);
            for c in 0..3 {
                if !full[c] && !empty[c] {
                    square += w[c] * v[c] * v[c];
                    along += w[c] * m[c] * v[c];
                    size += w[c] * m[c] * m[c];
                }
            }
            let gain = along / size;
            // Gauss and Newton, the pixel's own gain taken out.
            let (mut missing, mut pull, mut stiff, mut turned) = (0.0, 0.0, 0.0, 0.0);
            for c in 0..3 {
                let past = if full[c] {
                    (self.clip[c] - self.haze[c] - gain * m[c]).max(0.0)
                } else if empty[c] {
                    (-self.haze[c] - gain * m[c]).min(0.0)
                } else {
                    v[c] - gain * m[c]
                };
                if full[c] || empty[c] {
                    missing += w[c] * past * past;
                    if past == 0.0 {
                        continue;
                    }
                }
                let change = gain * slope[c];
                pull += w[c] * change * past;
                stiff += w[c] * change * change;
                turned += w[c] * change * m[c];
            }
            let stiff = stiff - turned * turned / size;
            let step = if stiff > 1e-9 { (pull / stiff).clamp(-0.5, 0.5) } else { 0.0 };
            // A tenth of a standard deviation: nothing is gained beyond.
            if turn == STEPS || step * step * stiff < 0.01 {
                let [a, b, d] = [middle - 1, middle, middle + 1].map(|k| constant[k]);
                let constant = b + (t + offset) * (0.5 * (d - a) + 0.5 * (t + offset) * (a - 2.0 * b + d));
                return (t, 0.5 * (square - along * gain - self.shading + missing) + constant);
            }
            t = (t + step).clamp((-1.0_f32).max(low), 1.0_f32.min(high));
        }
        (start, f32::INFINITY)
    }

    /// Thickness of a column.
    fn thickness_nm(&self, k: usize) -> f32 {
        self.first_nm + k as f32 * self.step_nm
    }

    /// Costs of all thicknesses, into `out` (not tempered); `None` for a pixel that says nothing.
    #[inline(always)]
    fn costs(&self, pixel: [f32; 3], out: &mut [f32]) -> Option<()> {
        if pixel.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let v: [f32; 3] = std::array::from_fn(|c| pixel[c] - self.haze[c]);
        let full: [bool; 3] = std::array::from_fn(|c| pixel[c] >= self.clip[c]);
        let empty: [bool; 3] = std::array::from_fn(|c| self.bare && pixel[c] <= 0.0);
        let censored = (0..3).any(|c| full[c] || empty[c]);
        if (0..3).all(|c| full[c] || empty[c]) && full.contains(&true) {
            return None;
        }
        let [w0, w1, w2] = [0, 1, 2].map(|c| &self.weight[c][..self.count]);
        let [b0, b1, b2] = [0, 1, 2].map(|c| &self.weighted[c][..self.count]);
        let out = &mut out[..self.count];
        if !censored {
            let Known { inverse, constant } = &self.known[ALL];
            let (inverse, constant) = (&inverse[..out.len()], &constant[..out.len()]);
            let (s0, s1, s2) = (v[0] * v[0], v[1] * v[1], v[2] * v[2]);
            for k in 0..out.len() {
                let square = w0[k] * s0 + w1[k] * s1 + w2[k] * s2;
                let along = b0[k] * v[0] + b1[k] * v[1] + b2[k] * v[2] + self.shading;
                out[k] = 0.5 * (square - along * along * inverse[k]) + constant[k];
            }
            return Some(());
        }
        // Channels that are cut say on which side they are; the others fix the gain.
        let cut: [bool; 3] = std::array::from_fn(|c| full[c] || empty[c]);
        let pattern = (0..3).filter(|&c| !cut[c]).map(|c| 1 << c).sum::<usize>();
        let Known { inverse, constant } = &self.known[pattern];
        let (inverse, constant) = (&inverse[..out.len()], &constant[..out.len()]);
        let u: [f32; 3] = std::array::from_fn(|c| if cut[c] { 0.0 } else { v[c] });
        let squares = u.map(|u| u * u);
        let edge: [f32; 3] = std::array::from_fn(|c| if full[c] { self.clip[c] - self.haze[c] } else { -self.haze[c] });
        let sign: [f32; 3] = std::array::from_fn(|c| f32::from(u8::from(full[c])) - f32::from(u8::from(empty[c])));
        let [m0, m1, m2] = [0, 1, 2].map(|c| &self.model[c][..self.count]);
        for k in 0..out.len() {
            let square = w0[k] * squares[0] + w1[k] * squares[1] + w2[k] * squares[2];
            let along = b0[k] * u[0] + b1[k] * u[1] + b2[k] * u[2] + self.shading;
            let gain = along * inverse[k];
            // How far a cut channel's film lies on the wrong side of the edge.
            let past = |c: usize, m: f32| (sign[c] * (edge[c] - gain * m)).max(0.0);
            let (p0, p1, p2) = (past(0, m0[k]), past(1, m1[k]), past(2, m2[k]));
            let missing = w0[k] * p0 * p0 + w1[k] * p1 * p1 + w2[k] * p2 * p2;
            out[k] = 0.5 * (square - along * gain + missing) + constant[k];
        }
        Some(())
    }

    /// Every minimum of some costs that may lie within `reach` of the least: its column, steps from there, its cost.
    #[inline(always)]
    fn minima(&self, pixel: [f32; 3], scratch: &[f32], reach: f32, mut take: impl FnMut(usize, f32, f32)) {
        let costs = &scratch[..self.count];
        // A coarse table's minima lie between its columns.
        let mut best = lowest(costs);
        let last = costs.len() - 1;
        for ((part, eight), coarse) in costs.chunks(EIGHT).enumerate().zip(&self.coarse) {
            let limit = best + reach + 1.5 * coarse;
            // (Not the least of them: that takes a vector apart.)
            if !eight.iter().fold(false, |any, at| any | (*at <= limit)) {
                continue;
            }
            for (i, &at) in eight.iter().enumerate() {
                let k = part * EIGHT + i;
                let before = if k > 0 { costs[k - 1] } else { f32::INFINITY };
                let after = if k < last { costs[k + 1] } else { f32::INFINITY };
                if at > limit || at > before || at >= after {
                    continue;
                }
                if let Some((shift, low)) = self.between(pixel, [before, at, after], k, best + reach) {
                    best = best.min(low);
                    take(k, shift, low);
                }
            }
        }
    }

    /// Steps from column `k` to the minimum that three costs enclose, and its cost; `None` where it lies above a limit.
    #[inline(always)]
    fn between(&self, pixel: [f32; 3], costs: [f32; 3], k: usize, limit: f32) -> Option<(f32, f32)> {
        let (shift, low) = self.refined(pixel, k, Self::start(costs, limit)?);
        Some(if low < costs[1] { (shift, low) } else { (0.0, costs[1]) })
    }

    /// Where, in steps from the middle one, the minimum that three costs enclose is looked for; `None` where it lies above a limit.
    #[inline(always)]
    pub(crate) fn start([before, at, after]: [f32; 3], limit: f32) -> Option<f32> {
        let bend = before - 2.0 * at + after;
        let inner = bend.is_finite() && bend > 1e-6;
        let start = if inner { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        // A parabola through costs errs by a share of their height.
        let above = inner && at - 0.25 * (before - after) * start - 0.1 * (before.max(after) - at) > limit;
        (!above).then_some(start)
    }

    /// Whether a channel of a pixel is full, or cut at 0.
    #[inline(always)]
    pub(crate) fn is_cut(&self, pixel: [f32; 3]) -> bool {
        (0..3).any(|c| pixel[c] >= self.clip[c] || (self.bare && pixel[c] <= 0.0))
    }

    /// What is left of the cost of each thickness where no channel is cut.
    #[inline(always)]
    pub(crate) fn constant(&self) -> &[f32] {
        &self.known[ALL].constant
    }

    /// The local minima of the cost, best first; `scratch` holds a number a thickness.
    #[inline(always)]
    pub(crate) fn candidates(&self, pixel: [f32; 3], scratch: &mut [f32], out: &mut Candidates) {
        out.fill(NONE);
        if self.costs(pixel, scratch).is_none() {
            return;
        }
        let mut kept = [(f32::INFINITY, NONE); MOST];
        self.minima(pixel, scratch, REACH * self.temper, |k, shift, low| self.insert(&mut kept, k, shift, low));
        self.told(&kept, out);
    }

    /// Puts a minimum among the likeliest.
    #[inline(always)]
    pub(crate) fn insert(&self, kept: &mut [(f32, Candidate); MOST], k: usize, shift: f32, low: f32) {
        // Its mass, not its height: a wide minimum holds more thicknesses.
        let cost = low / self.temper + self.narrowness[k];
        let place = kept.iter().position(|one| one.0 > cost).unwrap_or(MOST);
        if place < MOST {
            kept[place..].rotate_right(1);
            let thickness_nm = self.thickness_nm(k) + shift * self.step_nm;
            kept[place] = (cost, Candidate { thickness_nm, likelihood: 0.0, sd_nm: self.sd_nm[k] });
        }
    }

    /// The likeliest minima as candidates.
    #[inline(always)]
    pub(crate) fn told(&self, kept: &[(f32, Candidate); MOST], out: &mut Candidates) {
        // Outliers happen: nothing is worse than the floor.
        let best = kept[0].0;
        for ((cost, one), out) in kept.iter().zip(out) {
            if *cost < best + REACH {
                *out = Candidate { likelihood: (best - cost).max(-self.floor).exp(), ..*one };
            }
        }
    }

    /// What one pixel says of all thicknesses together; `scratch` holds a number a thickness.
    #[inline(always)]
    pub(crate) fn nearest(&self, pixel: [f32; 3], scratch: &mut [f32]) -> Option<Nearest> {
        self.costs(pixel, scratch)?;
        let costs = &scratch[..self.count];
        let least = lowest(costs);
        let mut best = (f32::INFINITY, 0.0, 0);
        let mut sum = 0.0;
        let (reach, last) = (self.coarsest.max(17.0), costs.len() - 1);
        for (k, &at) in costs.iter().enumerate() {
            if at > least + reach {
                continue;
            }
            // Beyond this nothing is added that a float would keep.
            if at < least + 17.0 {
                sum += (least - at).exp();
            }
            let before = if k > 0 { costs[k - 1] } else { f32::INFINITY };
            let after = if k < last { costs[k + 1] } else { f32::INFINITY };
            if at <= before && at < after {
                let one = self.between(pixel, [before, at, after], k, best.0.min(least));
                if let Some((shift, low)) = one.filter(|one| one.1 < best.0) {
                    best = (low, shift, k);
                }
            }
        }
        let (low, shift, k) = best;
        if !low.is_finite() {
            return None;
        }
        sum *= (low - least).exp();
        // Where columns are farther apart than a minimum is wide, its mass is that of a normal peak.
        let width = (2.0 * std::f32::consts::PI / self.temper).sqrt() * self.sd_nm[k] / self.step_nm;
        let sum = if width < 2.5 { width.max(sum.min(2.5)) } else { sum };
        Some(Nearest {
            thickness_nm: self.thickness_nm(k) + shift * self.step_nm,
            cost: low,
            mean: low - (sum / self.count as f32).ln(),
        })
    }

    /// Share of one pixel's likelihood within `reach_nm` of a thickness.
    pub fn mass_near(&self, pixel: [f32; 3], thickness_nm: f32, reach_nm: f32, scratch: &mut [f32]) -> Option<f32> {
        self.costs(pixel, scratch)?;
        let least = lowest(&scratch[..self.count]);
        let (mut near, mut all) = (0.0, 0.0);
        self.minima(pixel, scratch, SPAN * self.temper, |k, shift, low| {
            let value = ((least - low) / self.temper).min(80.0).exp() * self.sd_nm[k];
            all += value;
            if (self.thickness_nm(k) + shift * self.step_nm - thickness_nm).abs() <= reach_nm {
                near += value;
            }
        });
        Some(near / all)
    }

    /// Number of thicknesses.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Channels of a film of unit gain, without haze, and their change per nm.
    pub(crate) fn film_and_slope(&self, thickness_nm: f32) -> ([f32; 3], [f32; 3]) {
        let (k, t) = self.place(thickness_nm);
        let (m, slope) = self.beside(k, t);
        (m.map(|m| m / self.gain), slope.map(|slope| slope / self.gain / self.step_nm))
    }

    /// The column in whose middle a thickness lies, and steps from there.
    fn place(&self, thickness_nm: f32) -> (usize, f32) {
        let at = ((thickness_nm - self.first_nm) / self.step_nm).clamp(0.0, (self.count - 1) as f32);
        let k = (at.round() as usize).clamp(1, self.count - 2);
        (k, at - k as f32)
    }

    /// What is left of a pixel when the film of a column and the gain that suits it are taken away, over its noise; NaN for a
    /// channel that is cut.
    pub(crate) fn residual(&self, pixel: [f32; 3], thickness_nm: f32) -> [f32; 3] {
        let (k, t) = self.place(thickness_nm);
        let (m, _) = self.beside(k, t);
        let cut: [bool; 3] =
            std::array::from_fn(|c| pixel[c].is_nan() || pixel[c] >= self.clip[c] || (self.bare && pixel[c] <= 0.0));
        let (mut along, mut size) = (self.shading, self.shading);
        for c in (0..3).filter(|&c| !cut[c]) {
            let w = self.weight_of(c, m[c]);
            along += w * m[c] * (pixel[c] - self.haze[c]);
            size += w * m[c] * m[c];
        }
        let gain = along / size;
        std::array::from_fn(|c| {
            let left = (pixel[c] - self.haze[c] - gain * m[c]) * self.weight_of(c, m[c]).sqrt();
            if cut[c] { f32::NAN } else { left }
        })
    }
}

/// What one pixel says of all thicknesses together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// The thickness that suits best.
    pub thickness_nm: f32,
    /// Its cost.
    pub cost: f32,
    /// Minus the logarithm of the mean likelihood over all thicknesses: what an exposure is fitted by.
    pub mean: f32,
}

/// A vector with room for so many, or an error where the memory for it cannot be had.
pub(crate) fn reserved<T>(count: usize) -> Result<Vec<T>, InverseError> {
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(|_| InverseError::Memory(count.saturating_mul(size_of::<T>())))?;
    Ok(out)
}

/// A vector of one value, or an error where the memory for it cannot be had. All threads write it: a system gives memory page by
/// page, as it is written to first.
pub(crate) fn filled<T: Clone + Send + Sync>(count: usize, value: T) -> Result<Vec<T>, InverseError> {
    let mut out = reserved(count)?;
    rayon::iter::repeat_n(value, count).with_min_len(1 << 14).collect_into_vec(&mut out);
    Ok(out)
}

/// One picture.
#[derive(Debug, Clone, Copy)]
pub struct Photograph<'a> {
    /// Three channels a pixel, row after row.
    pub pixels: &'a [f32],
    /// Pixels a row.
    pub width: usize,
    /// Which table (angle) each pixel takes; `None`: the first.
    pub table_of: Option<&'a [u8]>,
    /// `true`: left out.
    pub mask: Option<&'a [bool]>,
}

impl Photograph<'_> {
    /// Number of pixels.
    pub fn count(&self) -> usize {
        self.pixels.len() / 3
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.count() / self.width.max(1)
    }

    /// Whether all lengths belong to one picture, and every table is there.
    pub fn check(&self, tables: usize) -> Result<(), InverseError> {
        let count = self.count();
        let wrong = |what: String| Err(InverseError::Argument(what));
        if self.width == 0 || count == 0 || self.pixels.len() != 3 * self.width * self.height() {
            return wrong(format!("{} numbers are no picture {} pixels wide", self.pixels.len(), self.width));
        }
        let fits = |length: Option<usize>| length.is_none_or(|length| length == count);
        if !fits(self.table_of.map(<[u8]>::len)) || !fits(self.mask.map(<[bool]>::len)) {
            return wrong(format!("mask and angles must have one value a pixel, {count}"));
        }
        match self.table_of.and_then(|of| of.iter().find(|one| usize::from(**one) >= tables)) {
            Some(table) => wrong(format!("there is no table {table}, only {tables}")),
            None if tables == 0 => wrong("there is no table".into()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use iridesce_numerics::Watch;

    use super::*;
    use crate::blocks::all_candidates;

    const PLAIN: Exposure = Exposure {
        gain: 1.0,
        haze: [0.0; 3],
        noise: [[1e-8, 0.0]; 3],
        unknown: 0.01,
        shading: 0.03,
        clip: [f32::INFINITY; 3],
        cut_at_zero: false,
        temper: 1.0,
        outlier: 1e-3,
    };

    /// Two-beam colours of a film of n = 1.33 at three wavelengths, over their own white.
    fn model(count: usize, step: f32) -> [Vec<f32>; 3] {
        let two_pi = 2.0 * std::f32::consts::PI;
        [610.0_f32, 540.0, 460.0].map(|nm| {
            (0..count).map(|k| 0.04 * (1.0 - (2.0 * 1.33 * k as f32 * step / nm * two_pi).cos() * 0.9)).collect()
        })
    }

    fn table(of: &Exposure) -> PixelTable {
        PixelTable::new(0.0, 2.0, &model(500, 2.0), of).unwrap()
    }

    fn pixel(table: &PixelTable, k: usize) -> [f32; 3] {
        std::array::from_fn(|c| table.model[c][k] + table.haze[c])
    }

    fn found(table: &PixelTable, pixel: [f32; 3]) -> Vec<Candidate> {
        let mut out = [NONE; MOST];
        table.candidates(pixel, &mut vec![0.0; 500], &mut out);
        out.into_iter().filter(|one| one.likelihood > 0.0).collect()
    }

    /// The density with the gain integrated numerically: another road to the same cost.
    #[test]
    fn the_gain_is_integrated_out() {
        let table = table(&PLAIN);
        let y: [f32; 3] = std::array::from_fn(|c| 1.02 * table.model[c][120] + 2e-4);
        let mut costs = vec![0.0; 500];
        table.costs(y, &mut costs).unwrap();
        for k in [117, 120, 122] {
            let density = |g: f64| -> f64 {
                let mut log = -0.5 * ((g - 1.0) / 0.03).powi(2) - 0.03_f64.ln();
                for (c, y) in y.iter().enumerate() {
                    let w = f64::from(table.weight[c][k]);
                    log += 0.5 * w.ln() - 0.5 * w * (f64::from(*y) - g * f64::from(table.model[c][k])).powi(2);
                }
                log
            };
            let nodes: Vec<f64> = (0..40_001).map(|i| 0.2 + 1e-4 * f64::from(i)).collect();
            let top = nodes.iter().map(|g| density(*g)).fold(f64::NEG_INFINITY, f64::max);
            let sum: f64 = nodes.iter().map(|g| (density(*g) - top).exp() * 1e-4).sum();
            let wanted = -(top + sum.ln()) + 0.5 * (2.0 * std::f64::consts::PI).ln();
            let got = f64::from(costs[k]);
            assert!((got - wanted).abs() < 2e-3 * wanted.abs().max(1.0), "{k}: {got} {wanted}");
        }
    }

    #[test]
    fn a_clean_pixel_finds_its_thickness_and_a_full_channel_is_no_number() {
        let table = table(&Exposure { haze: [0.01, 0.02, 0.0], ..PLAIN });
        for k in [40, 137, 251] {
            let best = found(&table, pixel(&table, k))[0];
            assert!((best.thickness_nm - 2.0 * k as f32).abs() < 0.2, "{k}: {best:?}");
        }
        // Red runs full at 0.05: the pixel says at least that much. Taken as a number it would be another film.
        let clip = [0.05, f32::INFINITY, f32::INFINITY];
        let aware = self::table(&Exposure { clip, ..PLAIN });
        let k = (0..500).rev().find(|&k| (0.06..0.07).contains(&aware.model[0][k])).unwrap();
        let mut y = pixel(&aware, k);
        y[0] = 0.05;
        let among = |table: &PixelTable| {
            found(table, y).iter().any(|one| (one.thickness_nm - 2.0 * k as f32).abs() < 2.0 && one.likelihood > 0.01)
        };
        assert!(among(&aware));
        assert!(!among(&self::table(&PLAIN)));
    }

    #[test]
    fn pixels_that_say_nothing_have_no_candidates() {
        let table = table(&Exposure { clip: [0.05; 3], ..PLAIN });
        assert!(found(&table, [f32::NAN, 0.01, 0.01]).is_empty());
        assert!(found(&table, [0.06, 0.07, 0.05]).is_empty());
        let of = Photograph { pixels: &[0.01, 0.02, 0.03], width: 1, table_of: None, mask: Some(&[true]) };
        let masked = all_candidates(&[table], &of, &Watch::new()).unwrap();
        assert!(masked.as_flattened().as_flattened().iter().all(|one| one.thickness_nm.is_nan()));
    }
}
