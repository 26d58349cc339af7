//! How a picture was exposed: one gain of all channels and the haze of each, from pixels that stand for the picture.
//!
//! Gain and haze trade off and the films of the pixels are unknown, so the search begins at several gains, without haze and
//! with that of a film that is black somewhere, with errors taken as thirty times what they are, and goes to and fro between
//! the nearest film of each pixel and gain and haze for all of them, while the errors shrink to their size. (A gain for each
//! channel falls into false minima: a white balance turns one order's colours into another's.)

use fearless_simd::dispatch;
use iridesce_numerics::{Watch, simd};
use rayon::prelude::*;

use crate::InverseError;
use crate::pixels::{Exposure, Nearest, PixelTable};

/// Where the search begins: the share of the darkest light that is haze, and the gain that a picture would have with that
/// haze, times these. Half of all light may be haze. Where the darkest film is black its light is the haze and nothing else; from
/// no haze such pictures end in false minima (one of 8 to 816 nm came out 1.36 times too thick).
const STARTS: [(f32, f32); 9] =
    [(0.0, 0.4), (0.0, 0.55), (0.0, 0.75), (0.0, 1.0), (0.0, 1.3), (0.0, 1.6), (1.0, 0.75), (1.0, 1.0), (1.0, 1.3)];
/// The light that this share of the pixels stays below is taken for the darkest.
const DARKEST: f32 = 0.02;
/// Errors, in units of their size, from step to step.
const COOLING: [f32; 8] = [30.0, 10.0, 4.0, 2.0, 1.0, 1.0, 1.0, 1.0];
/// Pixels by which the ends of all starts are found, and steps by which all pixels then correct these.
const FEW: usize = 512;
const FINISH: usize = 3;
/// Ends by few pixels that cost so much more than the best one, for a misfit of 1, are no rivals of it.
const FAR: f64 = 100.0;
/// Ends that differ by less, of their light, are one.
const SAME: f32 = 0.002;
/// A pixel costs no more than this above the median: it may show something else.
const OUTLYING: f32 = 12.0;
/// A pixel's thickness is free within so much, nm: as far as a film's channels are straight lines.
const MOVED_NM: f64 = 15.0;
/// Variance of a channel that says nothing.
const UNKNOWN: f64 = 1e12;
/// Median of chi square with two degrees of freedom: three channels and the prior of the gain, less gain and thickness.
const MEDIAN: f64 = 1.386;
/// Parts of the range of thicknesses in which residuals are averaged.
const BINS: usize = 24;

/// Channels of every film at every angle.
#[derive(Debug, Clone, Copy)]
pub struct FilmChannels<'a> {
    /// First thickness.
    pub first_nm: f32,
    /// From one to the next.
    pub step_nm: f32,
    /// (angles, 3, thicknesses), row after row.
    pub channels: &'a [f32],
    /// Number of thicknesses.
    pub count: usize,
}

impl FilmChannels<'_> {
    /// The tables of all angles.
    pub fn tables(&self, of: &Exposure) -> Result<Vec<PixelTable>, InverseError> {
        if self.count < 3 || self.channels.is_empty() || !self.channels.len().is_multiple_of(3 * self.count) {
            return Err(InverseError::Argument("channels must be (angles, 3, thicknesses)".into()));
        }
        let made = self.channels.chunks_exact(3 * self.count).map(|one| {
            let channels = std::array::from_fn(|c| one[c * self.count..(c + 1) * self.count].to_vec());
            PixelTable::new(self.first_nm, self.step_nm, &channels, of)
        });
        made.collect()
    }
}

/// Pixels that stand for a picture.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Three channels a pixel.
    pub pixels: &'a [f32],
    /// Which angle each has; `None`: the first.
    pub table_of: Option<&'a [u8]>,
}

impl Sample<'_> {
    fn count(&self) -> usize {
        self.pixels.len() / 3
    }

    /// Every so manieth pixel, and its table.
    fn every(&self, step: usize) -> (Vec<f32>, Option<Vec<u8>>) {
        let pixels = self.pixels.chunks_exact(3).step_by(step).flatten().copied().collect();
        (pixels, self.table_of.map(|of| of.iter().step_by(step).copied().collect()))
    }

    fn pixel(&self, i: usize) -> [f32; 3] {
        std::array::from_fn(|c| self.pixels[3 * i + c])
    }

    fn table<'t>(&self, i: usize, of: &'t [PixelTable]) -> &'t PixelTable {
        &of[self.table_of.map_or(0, |table| usize::from(table[i]))]
    }

    fn nearest(&self, tables: &[PixelTable]) -> Vec<Option<Nearest>> {
        let mut scratch = vec![0.0; tables[0].count()];
        dispatch!(simd::level_or_best(), _simd => {
            (0..self.count()).map(|i| self.table(i, tables).nearest(self.pixel(i), &mut scratch)).collect()
        })
    }
}

/// An exposure that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// With its gain and haze.
    pub exposure: Exposure,
    /// Minus the logarithm of the likelihood of all pixels, thicknesses summed over.
    pub cost: f64,
    /// Size of the residuals over what they should be.
    pub misfit: f64,
    /// Size of what residuals of pixels of one thickness have in common, over their noise: 0 where the model holds.
    pub bias: f64,
}

/// The exposures that each start leads to, best first. `of` has all but gain and haze.
pub fn exposures(
    films: &FilmChannels<'_>,
    sample: &Sample<'_>,
    of: &Exposure,
    watch: &Watch,
) -> Result<Vec<Fitted>, InverseError> {
    let mean = |values: &mut dyn Iterator<Item = &f32>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + f64::from(*v), count + 1.0));
        sum / f64::max(count, 1.0)
    };
    let seen = mean(&mut sample.pixels.iter().filter(|value| value.is_finite()));
    let film = mean(&mut films.channels.iter()).max(1e-9);
    let level = (seen / film).max(1e-12) as f32;
    let dark: [f32; 3] = std::array::from_fn(|c| darkest(sample, c));
    let film_light = seen - f64::from(dark.iter().sum::<f32>()) / 3.0;
    let dark_level = (film_light / film).max(f64::from(level) * 0.05) as f32;
    let start = |&(hazy, times): &(f32, f32)| {
        let gain = times * if hazy > 0.0 { dark_level } else { level };
        Exposure { gain, haze: dark.map(|h| h * hazy), ..*of }
    };
    let from = |sample: &Sample<'_>, starts: &[Exposure], cooling: &[f32]| {
        let each = |start: &Exposure| {
            watch.check()?;
            from_start(films, sample, *start, level, cooling)
        };
        starts.par_iter().map(each).collect::<Result<Vec<_>, InverseError>>()
    };
    let starts: Vec<Exposure> = STARTS.iter().map(start).collect();
    let thinning = sample.count() / FEW;
    let mut found = if thinning < 2 {
        from(sample, &starts, &COOLING)?
    } else {
        // Few pixels tell which starts end where; those ends that can be the best are sought to the end by all pixels.
        let (pixels, table_of) = sample.every(thinning);
        let few = Sample { pixels: &pixels, table_of: table_of.as_deref() };
        let rough = from(&few, &starts, &COOLING)?;
        let ends = ends(&rough, thinning as f64);
        let last = &COOLING[COOLING.len() - FINISH..];
        from(sample, &ends.iter().map(|end| end.exposure).collect::<Vec<_>>(), last)?
    };
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    Ok(found)
}

/// Of exposures found by one pixel in `thinning` those that all pixels could prefer, each once, best first.
fn ends(rough: &[Fitted], thinning: f64) -> Vec<Fitted> {
    let mut sorted: Vec<&Fitted> = rough.iter().collect();
    sorted.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = sorted[0];
    let far = FAR * best.misfit.clamp(1.0, 10.0).powi(2) / thinning.sqrt();
    let mut kept: Vec<Fitted> = Vec::new();
    for one in sorted {
        let near = |other: &Fitted| {
            let (a, b) = (&one.exposure, &other.exposure);
            let size = SAME * (b.gain + b.haze.iter().copied().fold(0.0, f32::max));
            (a.gain - b.gain).abs() < size && a.haze.iter().zip(b.haze).all(|(a, b)| (a - b).abs() < size)
        };
        if one.cost - best.cost < far && !kept.iter().any(near) {
            kept.push(*one);
        }
    }
    kept
}

/// The light of a channel that a [`DARKEST`] share of the pixels stays below; not below zero.
fn darkest(sample: &Sample<'_>, channel: usize) -> f32 {
    let mut values: Vec<f32> =
        sample.pixels.iter().skip(channel).step_by(3).copied().filter(|value| value.is_finite()).collect();
    let at = (values.len() as f32 * DARKEST) as usize;
    if at >= values.len() {
        return 0.0;
    }
    values.select_nth_unstable_by(at, f32::total_cmp).1.max(0.0)
}

fn from_start(
    films: &FilmChannels<'_>,
    sample: &Sample<'_>,
    start: Exposure,
    level: f32,
    cooling: &[f32],
) -> Result<Fitted, InverseError> {
    let mut at = start;
    for &kappa in cooling {
        let hot = Exposure {
            noise: at.noise.map(|one| one.map(|n| n * kappa * kappa)),
            unknown: at.unknown * kappa.min(4.0),
            ..at
        };
        let tables = films.tables(&hot)?;
        let nearest = sample.nearest(&tables);
        if let Some((gain, haze)) = step(sample, &tables, &nearest, &at, level) {
            at = Exposure { gain, haze, ..at };
        }
    }
    let tables = films.tables(&at)?;
    let nearest = sample.nearest(&tables);
    let mut means: Vec<f32> = nearest.iter().flatten().map(|one| one.mean).collect();
    means.sort_by(f32::total_cmp);
    let cap = means.get(means.len() / 2).map_or(0.0, |median| median + OUTLYING);
    // A gain is as likely at half as at twice what a picture without haze would have.
    let far = f64::from((at.gain / level).ln()) / 0.5;
    let cost = means.iter().map(|mean| f64::from(mean.min(cap))).sum::<f64>() + 0.5 * far * far;
    let (misfit, bias) = residuals(sample, &tables, &nearest, films);
    Ok(Fitted { exposure: at, cost, misfit, bias })
}

/// One gain and three hazes: a step of Gauss and Newton for the likelihood in which each pixel's own gain and thickness take
/// whatever value suits them. What these two could explain counts as error, common to the channels; least squares with the
/// nearest films taken for true would draw the gain towards zero. Haze is not below zero.
fn step(
    sample: &Sample<'_>,
    tables: &[PixelTable],
    nearest: &[Option<Nearest>],
    at: &Exposure,
    level: f32,
) -> Option<(f32, [f32; 3])> {
    // Normal equations of gain and three hazes, and their right side.
    let mut normal = [[0.0_f64; 5]; 4];
    let mut used = 0;
    for (i, one) in nearest.iter().enumerate() {
        let Some(one) = one else { continue };
        let table = sample.table(i, tables);
        let (m, slope) = table.film_and_slope(one.thickness_nm);
        let y = sample.pixel(i);
        let (errors, said) = errors(at, y, m, slope);
        let Some(weight) = inverse(&errors) else { continue };
        let gain = f64::from(at.gain);
        let left: [f64; 3] = std::array::from_fn(|c| {
            if said[c] { f64::from(y[c]) - f64::from(at.haze[c]) - gain * f64::from(m[c]) } else { 0.0 }
        });
        let chi: f64 = (0..3).map(|a| (0..3).map(|b| left[a] * weight[a][b] * left[b]).sum::<f64>()).sum();
        // Cauchy's weights: a pixel that shows something else counts little.
        let robust = 1.0 / (1.0 + chi / 6.0);
        let column = |k: usize, c: usize| if k == 0 { f64::from(m[c]) } else { f64::from(u8::from(k - 1 == c)) };
        let value: [f64; 3] = std::array::from_fn(|c| if said[c] { f64::from(y[c]) } else { 0.0 });
        for (k, row) in normal.iter_mut().enumerate() {
            let side: [f64; 3] =
                std::array::from_fn(|b| robust * (0..3).map(|a| column(k, a) * weight[a][b]).sum::<f64>());
            for (l, sum) in row.iter_mut().enumerate().take(4) {
                *sum += (0..3).map(|c| side[c] * column(l, c)).sum::<f64>();
            }
            row[4] += (0..3).map(|c| side[c] * value[c]).sum::<f64>();
        }
        used += 1;
    }
    if used < 8 {
        return None;
    }
    // Haze is of the size of the film's own light: a weak prior that breaks the trade where films show one colour.
    let level = f64::from(level);
    let size = level * f64::from(tables[0].film_and_slope(0.0).0.iter().sum::<f32>() + 0.02);
    for (k, row) in normal.iter_mut().enumerate().skip(1) {
        row[k] += 1.0 / (size * size).max(1e-18);
    }
    let [gain, haze @ ..] = without_negative_haze(&normal)?;
    let gain = gain.clamp(0.05 * level, 5.0 * level);
    gain.is_finite().then(|| (gain as f32, haze.map(|h| h as f32)))
}

/// What the three channels of a pixel are off by, each and together, and which of them say anything.
fn errors(at: &Exposure, y: [f32; 3], m: [f32; 3], slope: [f32; 3]) -> ([[f64; 3]; 3], [bool; 3]) {
    let mut errors = [[0.0_f64; 3]; 3];
    let gain = f64::from(at.gain);
    for c in 0..3 {
        if y[c].is_nan() || y[c] >= at.clip[c] || (at.cut_at_zero && y[c] <= 0.0) {
            errors[c][c] = UNKNOWN; // says nothing
            continue;
        }
        let value = f64::from(y[c].max(0.0));
        errors[c][c] =
            (f64::from(at.noise[c][0]) + f64::from(at.noise[c][1]) * value + (f64::from(at.unknown) * value).powi(2))
                .max(1e-14);
    }
    let said: [bool; 3] = std::array::from_fn(|c| errors[c][c] < UNKNOWN);
    let shading = f64::from(at.shading).powi(2);
    for a in 0..3 {
        for b in (0..3).filter(|&b| said[a] && said[b]) {
            let (ga, gb) = (gain * f64::from(m[a]), gain * f64::from(m[b]));
            let (sa, sb) = (gain * f64::from(slope[a]), gain * f64::from(slope[b]));
            errors[a][b] += shading * ga * gb + MOVED_NM * MOVED_NM * sa * sb;
        }
    }
    (errors, said)
}

/// The solution without the hazes that would be below zero.
fn without_negative_haze(normal: &[[f64; 5]; 4]) -> Option<[f64; 4]> {
    let mut free = [true; 4];
    loop {
        let found = solved(normal, free)?;
        match (1..4).filter(|&k| free[k] && found[k] < 0.0).min_by(|&a, &b| found[a].total_cmp(&found[b])) {
            Some(worst) => free[worst] = false,
            None => return Some(found),
        }
    }
}

/// The inverse of a symmetric matrix.
fn inverse(of: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        of[r1][c1] * of[r2][c2] - of[r1][c2] * of[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| of[0][c] * cofactor(0, c)).sum();
    (determinant > 0.0).then(|| std::array::from_fn(|r| std::array::from_fn(|c| cofactor(c, r) / determinant)))
}

/// Normal equations by elimination; what is not free is 0.
fn solved(normal: &[[f64; 5]; 4], free: [bool; 4]) -> Option<[f64; 4]> {
    let mut rows = *normal;
    for k in (0..4).filter(|&k| !free[k]) {
        rows[k] = [0.0; 5];
        rows[k][k] = 1.0;
        (0..4).filter(|&other| other != k).for_each(|other| rows[other][k] = 0.0);
    }
    for k in 0..4 {
        // Normal matrices are positive: the diagonal is a pivot, unless nothing was measured.
        if rows[k][k].is_nan() || rows[k][k] <= 0.0 {
            return None;
        }
        for other in (0..4).filter(|&other| other != k) {
            let factor = rows[other][k] / rows[k][k];
            let from = rows[k];
            (0..5).for_each(|c| rows[other][c] -= factor * from[c]);
        }
    }
    Some(std::array::from_fn(|k| rows[k][4] / rows[k][k]))
}

fn residuals(
    sample: &Sample<'_>,
    tables: &[PixelTable],
    nearest: &[Option<Nearest>],
    films: &FilmChannels<'_>,
) -> (f64, f64) {
    let mut sizes = Vec::new();
    let mut bins = [[[0.0_f64; 3]; 3]; BINS];
    let range = films.step_nm * films.count as f32;
    for (i, one) in nearest.iter().enumerate() {
        let Some(one) = one else { continue };
        let left = sample.table(i, tables).residual(sample.pixel(i), one.thickness_nm);
        if left.iter().all(|r| r.is_finite()) {
            sizes.push(left.iter().map(|r| f64::from(*r).powi(2)).sum::<f64>());
        }
        let bin = ((one.thickness_nm - films.first_nm) / range * BINS as f32).clamp(0.0, (BINS - 1) as f32) as usize;
        for (sum, r) in bins[bin].iter_mut().zip(left) {
            if r.is_finite() {
                // One outlier must not be what a whole bin has in common.
                let r = f64::from(r.clamp(-4.0, 4.0));
                *sum = [sum[0] + 1.0, sum[1] + r, sum[2] + r * r];
            }
        }
    }
    sizes.sort_by(f64::total_cmp);
    let misfit = sizes.get(sizes.len() / 2).map_or(f64::INFINITY, |median| (median / MEDIAN).sqrt());
    let (mut square, mut count) = (0.0, 0.0);
    for [n, sum, squares] in bins.into_iter().flatten() {
        if n >= 6.0 {
            let mean = sum / n;
            // Less what the mean of so many would be by chance.
            square += n * (mean * mean - (squares / n - mean * mean) / (n - 1.0));
            count += n;
        }
    }
    (misfit, if count > 0.0 { (square / count).max(0.0).sqrt() } else { 0.0 })
}

/// Of each pixel the share of its likelihood near `thickness_nm` under another exposure, table or lamp.
pub fn agreement(
    films: &FilmChannels<'_>,
    sample: &Sample<'_>,
    of: &Exposure,
    thickness_nm: &[f32],
    reach_nm: f32,
) -> Result<Vec<f32>, InverseError> {
    if thickness_nm.len() != sample.count() {
        return Err(InverseError::Argument("one thickness a pixel is wanted".into()));
    }
    let tables = films.tables(of)?;
    let mut scratch = vec![0.0; films.count];
    Ok((0..sample.count())
        .map(|i| {
            let table = sample.table(i, &tables);
            table.mass_near(sample.pixel(i), thickness_nm[i], reach_nm, &mut scratch).unwrap_or(f32::NAN)
        })
        .collect())
}
