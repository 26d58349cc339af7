//! Neighbours in a picture: what each pixel's candidates are worth once those left, right, above and below have spoken.
//!
//! Along a line neighbouring thicknesses differ by a Laplace distributed step, now and then by a jump:
//! P(h' | h) = (1 - e) exp(-|h' - h| / tau) / (2 tau) + e / range. Sums over candidates run forward and backward along every row and
//! every column (Rabiner, Proc. IEEE 77, 257 (1989)); a pixel's belief is its own likelihood, once, times the four messages
//! that reach it (Drory et al. 2014, doi 10.1007/978-3-319-11752-2_4: counted four times it is too sure of itself). Sixteen lines
//! are passed along at once, a lane a line.

use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use iridesce_numerics::lanes::{SINGLES, Singles};
use iridesce_numerics::turns::exp2;
use iridesce_numerics::{Watch, simd};
use rayon::prelude::*;

use crate::InverseError;
use crate::pixels::{Candidate, MOST, filled};

/// Share of neighbours between which there is an edge.
const JUMP: f32 = 1e-3;
/// A message is nothing to a candidate at this share of the best; four of them are still a float.
const LEAST: f32 = 1e-8;
/// Steps along a line between two questions to the watch.
const PIECE: usize = 1 << 12;

/// How thickness changes from a pixel to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Mean size of a step, nm.
    pub tau_nm: f32,
    /// Range of all thicknesses, nm: where a jump may end.
    pub range_nm: f32,
}

/// What sixteen pixels hear, a lane a pixel, for each of their candidates.
type Messages<S> = [f32x16<S>; MOST];

/// Candidates of sixteen pixels side by side, each on a line of its own.
#[derive(Debug, Clone, Copy)]
struct Front {
    thickness_nm: [Singles; MOST],
    likelihood: [Singles; MOST],
    sd_nm: [Singles; MOST],
    /// The most that one of them has.
    most: usize,
}

impl Front {
    /// Of the pixels `at(lane)`, `many` of them; the other lanes have none.
    #[inline(always)]
    fn gather(candidates: &[Candidate], many: usize, at: impl Fn(usize) -> usize) -> Front {
        let none = [Singles::ZERO; MOST];
        let mut out = Front { thickness_nm: none, likelihood: none, sd_nm: none, most: 0 };
        for lane in 0..many {
            let first = at(lane) * MOST;
            for (k, one) in candidates[first..first + MOST].iter().enumerate() {
                if one.likelihood <= 0.0 {
                    break; // candidates stand in front
                }
                out.thickness_nm[k].0[lane] = one.thickness_nm;
                out.likelihood[k].0[lane] = one.likelihood;
                out.sd_nm[k].0[lane] = one.sd_nm;
                out.most = out.most.max(k + 1);
            }
        }
        out
    }
}

/// From the candidates of sixteen pixels (likelihoods times what came to them) to those of the next. Where nothing is known,
/// nothing is passed on.
#[inline(always)]
fn pass<S: Simd>(simd: S, from: &Front, come: &Messages<S>, to: &Front, slope: &Slope) -> Messages<S> {
    let all = |value: f32| f32x16::splat(simd, value);
    let rate = all(-std::f32::consts::LOG2_E / slope.tau_nm);
    let near = all((1.0 - JUMP) / (2.0 * slope.tau_nm));
    let longest = all(4.0 * slope.tau_nm);
    let (zero, one) = (all(0.0), all(1.0));
    let mut beliefs = [zero; MOST];
    let mut total = zero;
    for ((belief, likelihood), come) in beliefs.iter_mut().zip(&from.likelihood).zip(come).take(from.most) {
        *belief = likelihood.load(simd) * *come;
        total += *belief;
    }
    let far = all(JUMP / slope.range_nm) * total;
    let mut out = [zero; MOST];
    let mut most = zero;
    for (t, out) in out.iter_mut().enumerate().take(to.most) {
        let (there, sd) = (to.thickness_nm[t].load(simd), to.sd_nm[t].load(simd));
        let mut sum = far;
        for (f, belief) in beliefs.iter().enumerate().take(from.most) {
            // A step of less than the pixel's own uncertainty is no step.
            let blur = all(0.8) * (from.sd_nm[f].load(simd) + sd).min(longest);
            let step = ((there - from.thickness_nm[f].load(simd)).abs() - blur).max(zero);
            sum += *belief * near * exp2(step * rate);
        }
        *out = to.likelihood[t].load(simd).simd_gt(zero).select(sum, zero);
        most = most.max(*out);
    }
    let told = most.simd_gt(zero);
    let scale = one / told.select(most, one);
    out.map(|value| told.select((value * scale).max(all(LEAST)), one))
}

/// Both directions along sixteen lines; `at(i, lane)` is the place of pixel i of a line, `hear` takes what reaches its pixels i.
#[inline(always)]
fn lines<S: Simd>(
    simd: S,
    (length, many): (usize, usize),
    at: impl Fn(usize, usize) -> usize,
    candidates: &[Candidate],
    slope: &Slope,
    watch: &Watch,
    mut hear: impl FnMut(usize, usize, &[Singles; MOST]),
) -> Result<(), InverseError> {
    for backward in [false, true] {
        let mut come = [f32x16::splat(simd, 1.0); MOST];
        let place = |i: usize| if backward { length - 1 - i } else { i };
        let mut from = Front::gather(candidates, many, |lane| at(place(0), lane));
        for i in 1..length {
            if i % PIECE == 0 {
                watch.check()?;
            }
            let to = Front::gather(candidates, many, |lane| at(place(i), lane));
            come = pass(simd, &from, &come, &to, slope);
            let mut heard = [Singles::ZERO; MOST];
            heard.iter_mut().zip(come).for_each(|(heard, come)| heard.store(come));
            hear(place(i), to.most, &heard);
            from = to;
        }
    }
    Ok(())
}

/// Beliefs of all candidates, `MOST` a pixel, each pixel's adding to 1 (0 for a pixel without any).
pub fn beliefs(
    candidates: &[Candidate],
    width: usize,
    slopes: [Slope; 2],
    watch: &Watch,
) -> Result<Vec<f32>, InverseError> {
    let height = candidates.len() / MOST / width.max(1);
    let mut out = filled(candidates.len(), 0.0_f32)?;
    let level = simd::level_or_best();
    // A task has sixteen rows.
    out.par_chunks_mut(width * MOST * SINGLES).enumerate().try_for_each(|(task, out)| {
        watch.check()?;
        let (first, many) = (task * SINGLES * width, out.len() / MOST / width);
        for (belief, one) in out.iter_mut().zip(&candidates[first * MOST..]) {
            *belief = one.likelihood;
        }
        let at = |i: usize, lane: usize| first + lane * width + i;
        dispatch!(level, simd => lines(simd, (width, many), at, candidates, &slopes[0], watch, |i, most, heard| {
            for lane in 0..many {
                times(&mut out[(lane * width + i) * MOST..][..most], heard, lane);
            }
        }))?;
        watch.add((width * many) as u64);
        Ok::<(), InverseError>(())
    })?;
    // And a task has sixteen columns: of every row the part that lies in them.
    let mut blocks: Vec<Vec<&mut [f32]>> = (0..width.div_ceil(SINGLES)).map(|_| Vec::with_capacity(height)).collect();
    for row in out.chunks_mut(width * MOST) {
        for (block, part) in blocks.iter_mut().zip(row.chunks_mut(SINGLES * MOST)) {
            block.push(part);
        }
    }
    blocks.into_par_iter().enumerate().try_for_each(|(block, mut rows)| {
        watch.check()?;
        let first = block * SINGLES;
        let many = SINGLES.min(width - first);
        let at = |i: usize, lane: usize| i * width + first + lane;
        dispatch!(level, simd => lines(simd, (height, many), at, candidates, &slopes[1], watch, |i, most, heard| {
            for lane in 0..many {
                times(&mut rows[i][lane * MOST..][..most], heard, lane);
            }
        }))?;
        for pixel in rows.iter_mut().flat_map(|row| row.chunks_exact_mut(MOST)) {
            let total: f32 = pixel.iter().sum();
            if total > 0.0 {
                pixel.iter_mut().for_each(|value| *value /= total);
            }
        }
        watch.add((many * height) as u64);
        Ok::<(), InverseError>(())
    })?;
    Ok(out)
}

#[inline(always)]
fn times(beliefs: &mut [f32], heard: &[Singles; MOST], lane: usize) {
    for (belief, heard) in beliefs.iter_mut().zip(heard) {
        *belief *= heard.0[lane];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pixels::NONE;

    fn at(thickness_nm: f32, likelihood: f32) -> Candidate {
        Candidate { thickness_nm, likelihood, sd_nm: 1.0 }
    }

    /// A ramp of 3 nm a pixel whose every pixel has a twin 200 nm away; one pixel in the middle knows which it is.
    fn ramp(width: usize, height: usize, sure: usize) -> Vec<Candidate> {
        let mut out = Vec::new();
        for i in 0..width * height {
            let h = 300.0 + 3.0 * (i % width) as f32 + 2.0 * (i / width) as f32;
            let mut pixel = [NONE; MOST];
            pixel[0] = at(h, 1.0);
            pixel[1] = at(h + 200.0, if i == sure { 6e-6 } else { 1.0 });
            out.extend(pixel);
        }
        out
    }

    #[test]
    fn one_pixel_that_is_sure_convinces_its_row_and_column_once() {
        let (width, height) = (21, 15);
        let sure = 7 * width + 10;
        let slopes = [Slope { tau_nm: 4.0, range_nm: 1000.0 }; 2];
        let beliefs = beliefs(&ramp(width, height, sure), width, slopes, &Watch::new()).unwrap();
        let right = |i: usize| beliefs[i * MOST];
        assert!(right(7 * width) > 0.99 && right(10) > 0.99, "{} {}", right(7 * width), right(10));
        // Pixels on neither line have heard nothing: both of their candidates stand.
        assert!((right(0) - 0.5).abs() < 1e-3, "{}", right(0));
        assert!(beliefs.chunks_exact(MOST).all(|b| (b.iter().sum::<f32>() - 1.0).abs() < 1e-5));
    }

    /// All assignments of a short row, summed one by one: another road to the same marginals.
    #[test]
    fn beliefs_of_a_row_are_its_marginals() {
        let width = 4;
        let mut candidates = vec![NONE; width * MOST];
        for i in 0..width {
            for k in 0..3 {
                let (h, likelihood) = (300.0 + 60.0 * k as f32 + 9.0 * (i * i) as f32, [1.0, 0.6, 0.3][(k + i) % 3]);
                candidates[i * MOST + k] = Candidate { sd_nm: 0.0, ..at(h, likelihood) };
            }
        }
        let slope = Slope { tau_nm: 30.0, range_nm: 1000.0 };
        let got = beliefs(&candidates, width, [slope; 2], &Watch::new()).unwrap();
        let step =
            |a: f64, b: f64| (1.0 - f64::from(JUMP)) * (-(a - b).abs() / 30.0).exp() / 60.0 + f64::from(JUMP) / 1000.0;
        let mut sums = [[0.0_f64; 3]; 4];
        for code in 0..81_usize {
            let states: [usize; 4] = std::array::from_fn(|i| code / 3_usize.pow(i as u32) % 3);
            let one = |i: usize| candidates[i * MOST + states[i]];
            let mut p: f64 = (0..4).map(|i| f64::from(one(i).likelihood)).product();
            for i in 1..4 {
                p *= step(f64::from(one(i).thickness_nm), f64::from(one(i - 1).thickness_nm));
            }
            (0..4).for_each(|i| sums[i][states[i]] += p);
        }
        for i in 0..4 {
            let total: f64 = sums[i].iter().sum();
            for k in 0..3 {
                let (got, wanted) = (f64::from(got[i * MOST + k]), sums[i][k] / total);
                assert!((got - wanted).abs() < 1e-5, "{i} {k}: {got} {wanted}");
            }
        }
    }

    #[test]
    fn an_empty_pixel_stops_a_line() {
        let width = 9;
        let mut candidates = ramp(width, 1, 0);
        candidates[4 * MOST..5 * MOST].fill(NONE);
        let slopes = [Slope { tau_nm: 4.0, range_nm: 1000.0 }; 2];
        let beliefs = beliefs(&candidates, width, slopes, &Watch::new()).unwrap();
        assert!(beliefs[3 * MOST] > 0.99);
        assert!((beliefs[6 * MOST] - 0.5).abs() < 1e-3);
        assert_eq!(beliefs[4 * MOST..5 * MOST], [0.0; MOST]);
    }

    #[test]
    fn threads_change_no_bit() {
        let candidates = ramp(70, 33, 40);
        let slopes = [Slope { tau_nm: 4.0, range_nm: 1000.0 }; 2];
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| beliefs(&candidates, 70, slopes, &Watch::new()).unwrap())
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_stopped_watch_ends_it() {
        let watch = Watch::new();
        watch.stop();
        let slopes = [Slope { tau_nm: 4.0, range_nm: 1000.0 }; 2];
        assert!(matches!(beliefs(&ramp(9, 9, 0), 9, slopes, &watch), Err(InverseError::Stopped(_))));
    }
}
