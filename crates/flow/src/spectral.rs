//! Direct solvers: a Fourier transform along the rows, then one tridiagonal system down the columns for each wave.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// Waves that are solved side by side.
const BLOCK: usize = 16;

/// How rows go on beyond their ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// They repeat.
    Closed,
    /// They are mirrored at the sides of the outermost cells: a cosine transform.
    Even,
    /// They are mirrored with the other sign, at the last value, which is none, and at the one before the first: a sine
    /// transform.
    Odd,
}

impl Ends {
    /// Length after which rows repeat.
    fn period(self, columns: usize) -> usize {
        if self == Ends::Closed { columns } else { 2 * columns }
    }

    /// A row over a whole period.
    fn extend(self, row: &[f64], out: &mut [f64]) {
        let n = row.len();
        match self {
            Ends::Closed => out.copy_from_slice(row),
            Ends::Even => {
                out[..n].copy_from_slice(row);
                out[n..].iter_mut().zip(row.iter().rev()).for_each(|(out, value)| *out = *value);
            }
            Ends::Odd => {
                (out[0], out[n]) = (0.0, 0.0);
                out[1..n].copy_from_slice(&row[..n - 1]);
                out[n + 1..].iter_mut().zip(row[..n - 1].iter().rev()).for_each(|(out, value)| *out = -value);
            }
        }
    }

    /// The row of a whole period, times `scale`.
    fn restrict(self, whole: &[f64], scale: f64, row: &mut [f64]) {
        let n = row.len();
        if self == Ends::Odd {
            row[..n - 1].iter_mut().zip(&whole[1..n]).for_each(|(out, value)| *out = value * scale);
            row[n - 1] = 0.0;
        } else {
            row.iter_mut().zip(whole).for_each(|(out, value)| *out = value * scale);
        }
    }
}

/// Transforms of rows of one length, and room for them.
pub struct Spectral {
    columns: usize,
    rows: usize,
    ends: Ends,
    waves: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// By row.
    spectra: Vec<Complex<f64>>,
    /// By block of waves, then by row.
    blocks: Vec<Complex<f64>>,
}

/// Tridiagonal systems, one a wave: `-above x[i-1] + diagonal x[i] - below x[i+1]`, eliminated.
pub struct Tridiagonal {
    above: Vec<f64>,
    below: Vec<f64>,
    /// One over the pivots, by block of waves, then by row.
    pivots: Vec<f64>,
}

/// `2 - 2 cos(m dphi)`, what a second difference makes of wave m of `columns`.
pub fn second_difference(wave: usize, columns: usize) -> f64 {
    let sine = (std::f64::consts::PI * wave as f64 / columns as f64).sin();
    4.0 * sine * sine
}

impl Tridiagonal {
    /// Of `rows` unknowns on rows that repeat after `columns`: `diagonal(row, second difference of the wave)`. Where a pivot vanishes (a constant that
    /// nothing determines) that unknown is zero.
    pub fn new(columns: usize, above: Vec<f64>, below: Vec<f64>, diagonal: impl Fn(usize, f64) -> f64 + Sync) -> Self {
        let rows = above.len();
        let waves = columns / 2 + 1;
        let mut pivots = vec![0.0; waves.div_ceil(BLOCK) * rows * BLOCK];
        pivots.par_chunks_exact_mut(rows * BLOCK).enumerate().for_each(|(block, out)| {
            let turns: [f64; BLOCK] =
                std::array::from_fn(|k| second_difference((block * BLOCK + k).min(waves - 1), columns));
            // Row by row, the waves side by side: each division waits for the one in the row before.
            let mut last = [0.0; BLOCK];
            wide!(for (row, out) in out.chunks_exact_mut(BLOCK).enumerate() {
                let coupling = if row == 0 { 0.0 } else { above[row] * below[row - 1] };
                for k in 0..BLOCK {
                    let whole = diagonal(row, turns[k]);
                    let rest = whole - coupling * last[k];
                    last[k] = if rest.abs() <= 1e-12 * whole.abs() { 0.0 } else { 1.0 / rest };
                }
                out.copy_from_slice(&last);
            });
        });
        Tridiagonal { above, below, pivots }
    }

    #[inline(always)]
    fn solve(&self, block: usize, values: &mut [Complex<f64>]) {
        let rows = self.above.len();
        let pivots = &self.pivots[block * rows * BLOCK..(block + 1) * rows * BLOCK];
        for row in 0..rows {
            let (before, here) = values.split_at_mut(row * BLOCK);
            let here = &mut here[..BLOCK];
            let pivot = &pivots[row * BLOCK..(row + 1) * BLOCK];
            if row == 0 {
                for k in 0..BLOCK {
                    here[k] *= pivot[k];
                }
                continue;
            }
            let before = &before[(row - 1) * BLOCK..];
            let above = self.above[row];
            for k in 0..BLOCK {
                here[k] = (here[k] + before[k] * above) * pivot[k];
            }
        }
        for row in (0..rows.saturating_sub(1)).rev() {
            let (here, after) = values.split_at_mut((row + 1) * BLOCK);
            let here = &mut here[row * BLOCK..];
            let after = &after[..BLOCK];
            let pivot = &pivots[row * BLOCK..(row + 1) * BLOCK];
            let below = self.below[row];
            for k in 0..BLOCK {
                here[k] += after[k] * (below * pivot[k]);
            }
        }
    }
}

/// What is done with each wave.
pub enum Task<'a> {
    /// `A x = b`.
    Solve(&'a Tridiagonal),
    /// `first y = b`, then `second x = y - b`.
    SolveChange(&'a Tridiagonal, &'a Tridiagonal),
}

impl Spectral {
    pub fn new(columns: usize, rows: usize, ends: Ends) -> Spectral {
        let mut planner = RealFftPlanner::new();
        let period = ends.period(columns);
        let waves = period / 2 + 1;
        let zero = Complex::new(0.0, 0.0);
        Spectral {
            columns,
            rows,
            waves,
            ends,
            forward: planner.plan_fft_forward(period),
            inverse: planner.plan_fft_inverse(period),
            spectra: vec![zero; rows * waves],
            blocks: vec![zero; waves.div_ceil(BLOCK) * rows * BLOCK],
        }
    }

    /// Solves in place, row after row; `without_mean` leaves the mean of each row out, which comes back as zero.
    pub fn solve(&mut self, values: &mut [f64], task: &Task<'_>, without_mean: bool) {
        if self.ends != Ends::Closed {
            self.transform(values);
            return self.finish(values, task, without_mean);
        }
        let forward = self.forward.clone();
        // The transforms take only buffers of their own lengths, so none of their errors can happen.
        self.spectra
            .par_chunks_exact_mut(self.waves)
            .zip(values.par_chunks_exact_mut(self.columns))
            .with_min_len(8)
            .for_each_init(
                || forward.make_scratch_vec(),
                |scratch, (spectrum, row)| {
                    forward
                        .process_with_scratch(row, spectrum, scratch)
                        .expect("buffers of the transform's own length");
                },
            );
        self.finish(values, task, without_mean);
    }

    /// The same from one place to another.
    pub fn solve_from(&mut self, from: &[f64], values: &mut [f64], task: &Task<'_>, without_mean: bool) {
        self.transform(from);
        self.finish(values, task, without_mean);
    }

    /// The spectra of rows.
    fn transform(&mut self, from: &[f64]) {
        let (forward, ends) = (self.forward.clone(), self.ends);
        self.spectra
            .par_chunks_exact_mut(self.waves)
            .zip(from.par_chunks_exact(self.columns))
            .with_min_len(8)
            .for_each_init(
                || (forward.make_input_vec(), forward.make_scratch_vec()),
                |(room, scratch), (spectrum, row)| {
                    ends.extend(row, room);
                    forward
                        .process_with_scratch(room, spectrum, scratch)
                        .expect("buffers of the transform's own length");
                },
            );
    }

    /// All but the transform of the rows.
    fn finish(&mut self, values: &mut [f64], task: &Task<'_>, without_mean: bool) {
        let (columns, rows, waves) = (self.columns, self.rows, self.waves);
        let zero = Complex::new(0.0, 0.0);
        let spectra = &mut self.spectra;
        if without_mean {
            spectra.iter_mut().step_by(waves).for_each(|mean| *mean = zero);
        }
        let spectra = &*spectra;
        self.blocks.par_chunks_exact_mut(rows * BLOCK).enumerate().for_each(|(block, out)| {
            let first = block * BLOCK;
            let count = BLOCK.min(waves - first);
            for (row, here) in out.chunks_exact_mut(BLOCK).enumerate() {
                here[..count].copy_from_slice(&spectra[row * waves + first..row * waves + first + count]);
                here[count..].fill(zero);
            }
            match task {
                Task::Solve(system) => wide!(system.solve(block, out)),
                Task::SolveChange(one, two) => {
                    let before = out.to_vec();
                    wide!(one.solve(block, out));
                    out.iter_mut().zip(&before).for_each(|(after, before)| *after -= before);
                    wide!(two.solve(block, out));
                }
            }
        });
        let blocks = &self.blocks;
        let inverse = &self.inverse;
        let ends = self.ends;
        let scale = 1.0 / ends.period(columns) as f64;
        self.spectra
            .par_chunks_exact_mut(waves)
            .zip(values.par_chunks_exact_mut(columns))
            .enumerate()
            .with_min_len(8)
            .for_each_init(
                || {
                    (
                        inverse.make_scratch_vec(),
                        if ends == Ends::Closed { Vec::new() } else { inverse.make_output_vec() },
                    )
                },
                |(scratch, room), (row, (spectrum, out))| {
                    for (block, part) in spectrum.chunks_mut(BLOCK).enumerate() {
                        let start = (block * rows + row) * BLOCK;
                        part.copy_from_slice(&blocks[start..start + part.len()]);
                    }
                    // A real row has no imaginary part in its mean, nor in the wave of two columns.
                    spectrum[0].im = 0.0;
                    spectrum[waves - 1].im = 0.0;
                    let whole = if ends == Ends::Closed { &mut *out } else { &mut room[..] };
                    inverse
                        .process_with_scratch(spectrum, whole, scratch)
                        .expect("buffers of the transform's own length");
                    if ends == Ends::Closed {
                        out.iter_mut().for_each(|value| *value *= scale);
                    } else {
                        ends.restrict(room, scale, out);
                    }
                },
            );
    }
}
