//! Neighbours in a picture: what each pixel's candidates are worth once those left, right, above and below have spoken.
//!
//! Along a line neighbouring thicknesses differ by a Laplace distributed step, now and then by a jump:
//! P(h' | h) = (1 - e) exp(-|h' - h| / tau) / (2 tau) + e / range. Sums over candidates run forward and backward along every row and
//! every column (Rabiner, Proc. IEEE 77, 257 (1989)); a pixel's belief is its own likelihood, once, times the four messages
//! that reach it (Drory et al. 2014, doi 10.1007/978-3-319-11752-2_4: counted four times it is too sure of itself).

use iridesce_numerics::Watch;
use rayon::prelude::*;

use crate::InverseError;
use crate::pixels::{Candidate, MOST, filled};

/// Share of neighbours between which there is an edge.
const JUMP: f32 = 1e-3;
/// Columns a task, so that the rows of a block of columns come in whole cache lines.
const BLOCK: usize = 16;
/// Rows a task.
const ROWS: usize = 16;
/// A message is nothing to a candidate at this share of the best; four of them are still a float.
const LEAST: f32 = 1e-8;

/// How thickness changes from a pixel to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Mean size of a step, nm.
    pub tau_nm: f32,
    /// Range of all thicknesses, nm: where a jump may end.
    pub range_nm: f32,
}

type Messages = [f32; MOST];

/// From the candidates of one pixel (likelihoods times what came to it) to those of the next. Where nothing is known, nothing is
/// passed on.
#[inline]
fn pass(from: &[Candidate], come: &Messages, to: &[Candidate], slope: &Slope) -> Messages {
    let near = (1.0 - JUMP) / (2.0 * slope.tau_nm);
    let far = JUMP / slope.range_nm;
    let rate = 1.0 / slope.tau_nm;
    let mut belief = [0.0; MOST];
    let mut total = 0.0;
    for ((belief, one), come) in belief.iter_mut().zip(from).zip(come) {
        *belief = one.likelihood * come;
        total += *belief;
    }
    if total <= 0.0 {
        return [1.0; MOST];
    }
    let mut out = [0.0; MOST];
    let mut most = 0.0_f32;
    for (value, to) in out.iter_mut().zip(to) {
        if to.likelihood <= 0.0 {
            break; // candidates stand in front
        }
        let mut sum = far * total;
        for (belief, from) in belief.iter().zip(from) {
            if *belief > 0.0 {
                // A step of less than the pixel's own uncertainty is no step.
                let blur = 0.8 * (from.sd_nm + to.sd_nm).min(4.0 * slope.tau_nm);
                let step = ((to.thickness_nm - from.thickness_nm).abs() - blur).max(0.0) * rate;
                if step < 20.0 {
                    sum += belief * near * (-step).exp();
                }
            }
        }
        *value = sum;
        most = most.max(sum);
    }
    if most <= 0.0 {
        return [1.0; MOST];
    }
    out.map(|value| (value / most).max(LEAST))
}

/// Both directions along one line; `at(i)` is the place of its pixel i, `hear` takes the messages that reach it.
fn line(
    length: usize,
    at: impl Fn(usize) -> usize,
    candidates: &[Candidate],
    slope: &Slope,
    mut hear: impl FnMut(usize, &Messages),
) {
    let of = |i: usize| &candidates[at(i) * MOST..(at(i) + 1) * MOST];
    for backward in [false, true] {
        let place = |i: usize| if backward { length - 1 - i } else { i };
        let mut come: Messages = [1.0; MOST];
        for i in 1..length {
            come = pass(of(place(i - 1)), &come, of(place(i)), slope);
            hear(place(i), &come);
        }
    }
}

#[inline]
fn times(belief: &mut [f32], come: &Messages) {
    for (belief, come) in belief.iter_mut().zip(come) {
        *belief *= come;
    }
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
    out.par_chunks_mut(width * MOST).enumerate().with_min_len(ROWS).try_for_each(|(row, out)| {
        watch.check()?;
        let first = row * width * MOST;
        for (belief, one) in out.iter_mut().zip(&candidates[first..]) {
            *belief = one.likelihood;
        }
        line(
            width,
            |i| row * width + i,
            candidates,
            &slopes[0],
            |i, come| {
                times(&mut out[i * MOST..(i + 1) * MOST], come);
            },
        );
        watch.add(width as u64);
        Ok::<(), InverseError>(())
    })?;
    // Each task owns a block of columns: of every row the part that lies in it.
    let mut blocks: Vec<Vec<&mut [f32]>> = (0..width.div_ceil(BLOCK)).map(|_| Vec::with_capacity(height)).collect();
    for row in out.chunks_mut(width * MOST) {
        for (block, part) in blocks.iter_mut().zip(row.chunks_mut(BLOCK * MOST)) {
            block.push(part);
        }
    }
    blocks.into_par_iter().enumerate().try_for_each(|(block, mut rows)| {
        let first = block * BLOCK;
        let wide = BLOCK.min(width - first);
        for column in 0..wide {
            watch.check()?;
            line(
                height,
                |i| i * width + first + column,
                candidates,
                &slopes[1],
                |i, come| {
                    times(&mut rows[i][column * MOST..(column + 1) * MOST], come);
                },
            );
        }
        for row in rows {
            for pixel in row.chunks_exact_mut(MOST) {
                let total: f32 = pixel.iter().sum();
                if total > 0.0 {
                    pixel.iter_mut().for_each(|value| *value /= total);
                }
            }
        }
        watch.add((wide * height) as u64);
        Ok::<(), InverseError>(())
    })?;
    Ok(out)
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
