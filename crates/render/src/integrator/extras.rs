//! What is added up beside X, Y, Z of the picture: Stokes vectors, and the radiance at single wavelengths.
//!
//! A path carries the adjoint row (1, 0, 0, 0) from the camera. For a Stokes vector it carries four rows, one for each
//! component that is measured, as further blocks of the same nodes ([`crate::spectral::Nodes::with_extras`]): every surface
//! treats them like the first, and since their importance is zero all choices are those of the first. Wavelengths that are
//! asked for are nodes of their own, of weight zero for X, Y, Z: the transport there is exact, not interpolated.
//!
//! The picture's own sums know nothing of this; a render without extras runs the same code as before.

use std::cell::RefCell;

use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;

use crate::lights::{Lights, Source};
use crate::spectral::Nodes;

/// Sums of one batch, and of the pixel so far.
pub struct Extras {
    /// Rows of the adjoint: 1, or 4 with Stokes vectors.
    rows: usize,
    /// Blocks of one row.
    base: usize,
    /// To which of the wavelengths that were asked for a node of a row belongs.
    outputs: Vec<Option<usize>>,
    wavelengths: usize,
    sums: RefCell<Sums>,
    totals: Vec<f64>,
}

struct Sums {
    /// X, Y, Z of the rows after the first.
    stokes: Vec<[[f32; LANES]; 3]>,
    /// Radiance by blocks of all rows; empty if none was asked for.
    spectra: Vec<[f32; LANES]>,
}

impl Extras {
    /// How many numbers a pixel has beside X, Y, Z: those of S1, S2, S3, then all components of each wavelength.
    pub fn count(stokes: bool, wavelengths: usize) -> usize {
        if stokes { 9 + 4 * wavelengths } else { wavelengths }
    }

    /// `None` where nothing was asked for.
    pub fn new(nodes: &Nodes) -> Option<Extras> {
        let (rows, wavelengths) = (nodes.rows(), nodes.probes().len());
        let base = nodes.row_len() / LANES;
        let spectra = if wavelengths > 0 { rows * base } else { 0 };
        (rows > 1 || wavelengths > 0).then(|| Extras {
            rows,
            base,
            outputs: nodes.outputs(),
            wavelengths,
            sums: RefCell::new(Sums {
                stokes: vec![[[0.0; LANES]; 3]; rows - 1],
                spectra: vec![[0.0; LANES]; spectra],
            }),
            totals: vec![0.0; Extras::count(rows > 1, wavelengths)],
        })
    }

    /// Whether Stokes vectors are measured.
    pub fn has_stokes(&self) -> bool {
        self.rows > 1
    }

    /// Writes the rows of a camera ray into its slot: s, p, u, v, each of all blocks. Its frame is the camera's upright and,
    /// for light that comes towards the camera, the left of the picture: so S2, positive on the other side, is -U.
    ///
    /// Without Stokes vectors it is what passes a polariser, if there is one, along the frame's first axis.
    pub fn start(&self, slot: &mut [Lanes], is_polarized: bool) {
        slot.fill(Lanes::ZERO);
        let (blocks, base) = (self.rows * self.base, self.base);
        let mut put = |component: usize, row: usize, value: f32| {
            let start = component * blocks + row * base;
            slot[start..start + base].fill(iridesce_numerics::lanes::Lanes([value; LANES]));
        };
        put(0, 0, 1.0);
        put(1, 0, if is_polarized && self.rows == 1 { 0.0 } else { 1.0 });
        if self.rows > 1 {
            put(0, 1, 1.0);
            put(1, 1, -1.0);
            put(2, 2, -1.0);
            put(3, 3, 1.0);
        }
    }

    /// Light is found by a path that carries so much of it at a block. Not inlined: it is rare, and has no part in the speed
    /// of other renders.
    #[inline(never)]
    pub fn receive(&self, lights: &Lights, source: Source, block: usize, carried: &[f32; LANES]) {
        let (row, at) = (block / self.base, block % self.base);
        let sums = &mut *self.sums.borrow_mut();
        let emitted = lights.emitted(source, at);
        if row > 0 {
            for (sum, weights) in sums.stokes[row - 1].iter_mut().zip(&emitted.weights) {
                for lane in 0..LANES {
                    sum[lane] += weights[lane] * carried[lane];
                }
            }
        }
        if let Some(sum) = sums.spectra.get_mut(block) {
            for lane in 0..LANES {
                sum[lane] += emitted.radiance[lane] * carried[lane];
            }
        }
    }

    /// The same for light that every node carries alike, by rows.
    pub fn receive_evenly(&self, lights: &Lights, source: Source, carried: [f32; 4]) {
        for (row, carried) in carried.iter().take(self.rows).enumerate() {
            for block in 0..self.base {
                self.receive(lights, source, row * self.base + block, &[*carried; LANES]);
            }
        }
    }

    /// The end of a batch: single precision does not add up a million samples.
    pub fn end_batch(&mut self) {
        let sums = self.sums.get_mut();
        let mut at = 0;
        for row in &mut sums.stokes {
            for channel in row {
                self.totals[at] += channel.iter().map(|&v| f64::from(v)).sum::<f64>();
                *channel = [0.0; LANES];
                at += 1;
            }
        }
        for (block, lanes) in sums.spectra.iter_mut().enumerate() {
            let row = block / self.base;
            for (lane, value) in lanes.iter_mut().enumerate() {
                if let Some(output) = self.outputs[block % self.base * LANES + lane] {
                    self.totals[at + output * self.rows + row] += f64::from(*value);
                }
                *value = 0.0;
            }
        }
        debug_assert_eq!(self.totals.len(), at + self.wavelengths * self.rows);
    }

    /// The pixel's sums, which then start afresh.
    pub fn take(&mut self, into: &mut [f64]) {
        self.end_batch();
        for (to, total) in into.iter_mut().zip(&mut self.totals) {
            *to += std::mem::take(total);
        }
    }

    /// Forgets the pixel.
    pub fn clear(&mut self) {
        self.end_batch();
        self.totals.fill(0.0);
    }
}
