//! What a picture says of itself: its noise, how far the errors of neighbours hang together, how fast thickness changes.

use iridesce_numerics::Watch;

use crate::InverseError;
use crate::blocks::all_candidates;
use crate::exposure::FilmChannels;
use crate::lines::{Slope, beliefs};
use crate::pixels::{Candidate, Exposure, MOST, Photograph, PixelTable};

/// Side of the blocks in which neighbours are compared, pixels.
const BLOCK: usize = 56;
/// Where the blocks lie, shares of height and width.
const PLACES: [[f64; 2]; 5] = [[0.5, 0.5], [0.22, 0.28], [0.72, 0.66], [0.28, 0.76], [0.78, 0.22]];
/// Most rings of lags that are summed.
const RINGS: usize = 14;
/// A ring of lags whose mean correlation is below this ends the sum.
const FAINT: f64 = 0.05;
/// Levels of light at which noise is measured.
const LEVELS: usize = 8;
/// Variance of a residual, in units of its noise, when gain and thickness have taken two of three degrees of freedom.
const EXPECTED: f64 = 1.0 / 3.0;
/// Windows from which noise is measured.
const WINDOWS: usize = 40_000;

/// How neighbours hang together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbourhood {
    /// So many residuals are worth one, >= 1.
    pub temper: f32,
    /// Mean step along rows and along columns, nm.
    pub tau_nm: [f32; 2],
    /// Whether the temper still grew when it was measured again: the model is wrong.
    pub grows: bool,
}

/// Variance of each channel's noise, `a + b value`: what is left of windows of 3 x 3 when all that is smooth is taken away
/// (J. Immerkaer, Comput. Vis. Image Underst. 64, 300 (1996), doi 10.1006/cviu.1996.0060), by medians at several levels.
pub fn noise(of: &Photograph<'_>) -> [[f64; 2]; 3] {
    let (width, height) = (of.width, of.height());
    if width < 3 || height < 3 {
        return [[0.0; 2]; 3];
    }
    let windows = (width - 2) * (height - 2);
    let stride = (windows / WINDOWS).max(1);
    std::array::from_fn(|c| {
        let mut seen: Vec<[f32; 2]> = Vec::new();
        for window in (0..windows).step_by(stride) {
            let (x, y) = (window % (width - 2), window / (width - 2));
            let at = |dx: usize, dy: usize| of.pixels[3 * ((y + dy) * width + x + dx) + c];
            let is_masked = of.mask.is_some_and(|mask| (0..9).any(|i| mask[(y + i / 3) * width + x + i % 3]));
            let rest = at(0, 0) + at(2, 0) + at(0, 2) + at(2, 2) - 2.0 * (at(1, 0) + at(0, 1) + at(2, 1) + at(1, 2))
                + 4.0 * at(1, 1);
            let mean = (0..9).map(|i| at(i % 3, i / 3)).sum::<f32>() / 9.0;
            if rest.is_finite() && !is_masked {
                seen.push([mean, rest.abs() / 6.0]);
            }
        }
        if seen.is_empty() {
            return [0.0; 2];
        }
        seen.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut sums = [0.0_f64; 5];
        for part in seen.chunks(seen.len().div_ceil(LEVELS)) {
            let mut rests: Vec<f32> = part.iter().map(|one| one[1]).collect();
            rests.sort_by(f32::total_cmp);
            // The median of |normal| is 0.6745 of its standard deviation.
            let variance = (f64::from(rests[rests.len() / 2]) / 0.6745).powi(2);
            let level = part.iter().map(|one| f64::from(one[0])).sum::<f64>() / part.len() as f64;
            let w = 1.0 / (variance * variance).max(1e-30);
            for (sum, value) in
                sums.iter_mut().zip([w, w * level, w * level * level, w * variance, w * variance * level])
            {
                *sum += value;
            }
        }
        let [w, wx, wxx, wy, wxy] = sums;
        let spread = w * wxx - wx * wx;
        let slope = if spread > 1e-9 * w * wxx { (w * wxy - wx * wy) / spread } else { 0.0 };
        let base = (wy - slope * wx) / w;
        if slope <= 0.0 {
            [wy / w, 0.0]
        } else if base < 0.0 {
            [0.0, (wxy / wxx).max(0.0)]
        } else {
            [base, slope]
        }
    })
}

/// Temper and steps, measured in blocks of the picture: answer, residuals, temper, answer.
pub fn neighbourhood(
    films: &FilmChannels<'_>,
    exposure: &Exposure,
    of: &Photograph<'_>,
    quarter_nm: f32,
    watch: &Watch,
) -> Result<Neighbourhood, InverseError> {
    let mut found = Neighbourhood { temper: 1.0, tau_nm: [quarter_nm / 8.0; 2], grows: false };
    let range_nm = films.step_nm * films.count as f32;
    let blocks: Vec<Block> = PLACES.iter().filter_map(|place| Block::cut(of, *place)).collect();
    let mut before = 1.0;
    for round in 0..3 {
        let tables = films.tables(&Exposure { temper: found.temper, ..*exposure })?;
        let slopes = found.tau_nm.map(|tau_nm| Slope { tau_nm, range_nm });
        let (mut tempers, mut steps) = (Vec::new(), [[0.0_f64; 2]; 2]);
        for block in &blocks {
            watch.check()?;
            let picture = block.picture();
            let found = all_candidates(&tables, &picture, watch)?;
            let candidates = &found.as_flattened().as_flattened()[..picture.count() * MOST];
            let beliefs = beliefs(candidates, block.width, slopes, watch)?;
            let best = best(candidates, &beliefs);
            for (axis, steps) in steps.iter_mut().enumerate() {
                add_steps(&best, block.width, axis, quarter_nm, steps);
            }
            tempers.extend(temper(&tables, &picture, &best));
        }
        tempers.sort_by(f64::total_cmp);
        before = if round == 2 { found.temper } else { before };
        found.temper = tempers.get(tempers.len() / 2).map_or(1.0, |t| t.max(1.0) as f32);
        for (tau, [sum, count]) in found.tau_nm.iter_mut().zip(steps) {
            if count >= 20.0 {
                *tau = ((sum / count) as f32).clamp(0.5, quarter_nm);
            }
        }
    }
    found.grows = found.temper > 2.0 * before && found.temper > 8.0;
    Ok(found)
}

/// A block of a picture, copied.
struct Block {
    pixels: Vec<f32>,
    width: usize,
    table_of: Option<Vec<u8>>,
    mask: Option<Vec<bool>>,
}

impl Block {
    /// `None` where most of it is masked.
    fn cut(of: &Photograph<'_>, place: [f64; 2]) -> Option<Block> {
        let (width, height) = (of.width, of.height());
        let from = |share: f64, length: usize| {
            ((share * length as f64) as usize).saturating_sub(BLOCK / 2).min(length.saturating_sub(BLOCK))
        };
        let (top, left) = (from(place[0], height), from(place[1], width));
        let (rows, wide) = (BLOCK.min(height), BLOCK.min(width));
        let places = || (top..top + rows).flat_map(move |y| (left..left + wide).map(move |x| y * width + x));
        let mask: Option<Vec<bool>> = of.mask.map(|mask| places().map(|i| mask[i]).collect());
        if mask.as_ref().is_some_and(|mask| mask.iter().filter(|m| **m).count() * 10 > 7 * mask.len()) {
            return None;
        }
        Some(Block {
            pixels: places().flat_map(|i| of.pixels[3 * i..3 * i + 3].to_vec()).collect(),
            width: wide,
            table_of: of.table_of.map(|table| places().map(|i| table[i]).collect()),
            mask,
        })
    }

    fn picture(&self) -> Photograph<'_> {
        Photograph {
            pixels: &self.pixels,
            width: self.width,
            table_of: self.table_of.as_deref(),
            mask: self.mask.as_deref(),
        }
    }
}

/// The likeliest candidate of each pixel and its belief; NaN without any.
fn best(candidates: &[Candidate], beliefs: &[f32]) -> Vec<[f32; 2]> {
    let each = candidates.chunks_exact(MOST).zip(beliefs.chunks_exact(MOST)).map(|(candidates, beliefs)| {
        let mut found = [f32::NAN, 0.0];
        for (one, belief) in candidates.iter().zip(beliefs) {
            if *belief > found[1] {
                found = [one.thickness_nm, *belief];
            }
        }
        found
    });
    each.collect()
}

fn add_steps(best: &[[f32; 2]], width: usize, axis: usize, quarter_nm: f32, sum: &mut [f64; 2]) {
    let far = if axis == 0 { 1 } else { width };
    for i in 0..best.len().saturating_sub(far) {
        if axis == 0 && i % width == width - 1 {
            continue;
        }
        let (a, b) = (best[i], best[i + far]);
        let step = (a[0] - b[0]).abs();
        if a[1] > 0.9 && b[1] > 0.9 && step < quarter_nm {
            *sum = [sum[0] + f64::from(step), sum[1] + 1.0];
        }
    }
}

/// For each channel: 1 + the correlations of the residuals over all lags, ring by ring outwards.
fn temper(tables: &[PixelTable], of: &Photograph<'_>, best: &[[f32; 2]]) -> Vec<f64> {
    let (width, height) = (of.width, of.height());
    let left: Vec<[f32; 3]> = (0..of.count())
        .map(|i| {
            if best[i][1] <= 0.0 {
                return [f32::NAN; 3];
            }
            let table = &tables[of.table_of.map_or(0, |table| usize::from(table[i]))];
            table.residual(std::array::from_fn(|c| of.pixels[3 * i + c]), best[i][0])
        })
        .collect();
    let mut found = Vec::new();
    for c in 0..3 {
        let known: Vec<f64> = left.iter().map(|r| f64::from(r[c])).filter(|r| r.is_finite()).collect();
        if known.len() < 100 {
            continue;
        }
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        let at = |x: usize, y: usize| {
            let r = f64::from(left[y * width + x][c]) - mean;
            // Where neighbours were given different orders their residuals are no noise.
            if r.is_finite() { r.clamp(-5.0, 5.0) } else { 0.0 }
        };
        // Errors smaller than the model allows for hang together without harm.
        let variance = (0..of.count()).map(|i| at(i % width, i / width).powi(2)).sum::<f64>();
        let variance = variance.max(EXPECTED * known.len() as f64);
        let correlation = |dx: isize, dy: usize| {
            let (from, to) = ((-dx).max(0) as usize, (width as isize - dx.max(0)).max(0) as usize);
            let rows = 0..height.saturating_sub(dy);
            let products = rows.flat_map(|y| {
                (from..to).map(move |x| (x, y)).map(|(x, y)| at(x, y) * at((x as isize + dx) as usize, y + dy))
            });
            products.sum::<f64>() / variance
        };
        let mut total = 1.0;
        for ring in 1..=RINGS.min(width / 3).min(height / 3) {
            let reach = ring as isize;
            let half = (-reach..=reach)
                .flat_map(|dx| (0..=ring).map(move |dy| (dx, dy)))
                .filter(|&(dx, dy)| dx.unsigned_abs().max(dy) == ring && (dy > 0 || dx > 0));
            let values: Vec<f64> = half.map(|(dx, dy)| correlation(dx, dy)).collect();
            let sum: f64 = values.iter().sum();
            if sum < FAINT * values.len() as f64 {
                break;
            }
            total += 2.0 * sum;
        }
        found.push(total);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use iridesce_numerics::noise::SplitMix64;

    /// The sum of twelve uniform numbers, less six: variance 1.
    fn normal(random: &mut SplitMix64) -> f32 {
        (0..12).map(|_| random.bits() as f64 / u64::MAX as f64).sum::<f64>() as f32 - 6.0
    }

    #[test]
    fn noise_of_a_smooth_picture_is_found_level_by_level() {
        let (width, height, mut random) = (160, 120, SplitMix64::new(1));
        let mut pixels = Vec::new();
        for i in 0..width * height {
            let level = 0.1 + 0.5 * (i % width) as f32 / width as f32 + 0.1 * (i / width) as f32 / height as f32;
            let sd = (1e-6 + 4e-5 * level).sqrt();
            pixels.extend([level + sd * normal(&mut random), level + 0.01 * normal(&mut random), level]);
        }
        let of = Photograph { pixels: &pixels, width, table_of: None, mask: None };
        let [red, green, blue] = noise(&of);
        let at = |of: [f64; 2], level: f64| (of[0] + of[1] * level).sqrt();
        for level in [0.15_f64, 0.6] {
            let wanted = (1e-6 + 4e-5 * level).sqrt();
            assert!((at(red, level) / wanted - 1.0).abs() < 0.06, "{level}: {} {wanted}", at(red, level));
            assert!((at(green, level) / 0.01 - 1.0).abs() < 0.06, "{level}: {}", at(green, level));
        }
        assert!(at(blue, 0.5) < 1e-6);
    }

    /// A film of three two-beam channels, a ramp, and errors that are new at every pixel or shared by blocks of 2 x 2.
    fn temper_of(shared: usize) -> Neighbourhood {
        let (width, height, mut random) = (96, 96, SplitMix64::new(3));
        let channels: Vec<f32> = [610.0_f32, 540.0, 460.0]
            .iter()
            .flat_map(|nm| {
                (0..400).map(move |k| {
                    let phase = 4.0 * std::f32::consts::PI * 1.33 * 2.0 * k as f32 / nm;
                    0.04 * (1.0 - 0.9 * phase.cos())
                })
            })
            .collect();
        let films = FilmChannels { first_nm: 0.0, step_nm: 2.0, channels: &channels, count: 400 };
        let exposure = Exposure {
            gain: 1.0,
            haze: [0.0; 3],
            noise: [[2.5e-7, 0.0]; 3],
            unknown: 0.0,
            shading: 0.03,
            clip: [f32::MAX; 3],
            cut_at_zero: false,
            temper: 1.0,
            outlier: 1e-3,
        };
        let table = &films.tables(&exposure).unwrap()[0];
        let error: Vec<f32> = (0..3 * width * height).map(|_| 5e-4 * normal(&mut random)).collect();
        let mut pixels = Vec::new();
        for i in 0..width * height {
            let (x, y) = (i % width, i / width);
            let film = table.film_and_slope(150.0 + 3.0 * x as f32 + 1.0 * y as f32);
            let from = (y / shared * shared) * width + x / shared * shared;
            pixels.extend((0..3).map(|c| film.0[c] + error[3 * from + c]));
        }
        let of = Photograph { pixels: &pixels, width, table_of: None, mask: None };
        neighbourhood(&films, &exposure, &of, 103.0, &Watch::new()).unwrap()
    }

    #[test]
    fn temper_is_one_for_new_errors_and_counts_shared_ones_once() {
        let (own, shared) = (temper_of(1), temper_of(2));
        assert!(own.temper < 1.25 && !own.grows, "{own:?}");
        assert!((2.8..5.5).contains(&shared.temper), "{shared:?}");
        assert!((own.tau_nm[0] - 3.0).abs() < 0.6 && (own.tau_nm[1] - 1.0).abs() < 0.6, "{own:?}");
    }
}
