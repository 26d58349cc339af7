//! Broadcast axes: joined where they can be, parted into rows and thicknesses, and walked.

use super::lanes::{LANES, Lane};
use super::operand::Operand;

/// One axis of a result.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) length: usize,
    /// How far to step in the flat result.
    pub(super) out: usize,
    /// How far to step in each operand: wavelength, angle, thicknesses.
    pub(super) strides: Vec<usize>,
}

impl Axis {
    /// Whether wavelength or angle change along it.
    pub(super) fn is_row(&self) -> bool {
        self.strides[0] != 0 || self.strides[1] != 0
    }
}

/// The axes of a shape without those of length 1, neighbours joined where every operand steps through them as through one.
pub(super) fn axes_of(shape: &[usize], operands: &[Operand<'_>]) -> Vec<Axis> {
    let mut axes: Vec<Axis> = Vec::new();
    let mut out = 1;
    for (place, &length) in shape.iter().enumerate().rev() {
        let strides: Vec<usize> = operands.iter().map(|operand| operand.strides[place]).collect();
        if length > 1 {
            let axis = Axis { length, out, strides };
            match axes.last_mut() {
                Some(inner) if continues(inner, &axis) => inner.length *= length,
                _ => axes.push(axis),
            }
        }
        out *= length;
    }
    axes.reverse();
    axes
}

fn continues(inner: &Axis, outer: &Axis) -> bool {
    outer.strides.iter().zip(&inner.strides).all(|(outer, step)| *outer == step * inner.length)
}

/// Axes along which wavelength or angle change, and the others.
pub(super) fn split(axes: &[Axis]) -> (Vec<Axis>, Vec<Axis>) {
    axes.iter().cloned().partition(Axis::is_row)
}

/// Goes through the elements of some axes in C order.
#[derive(Debug)]
pub(super) struct Walk {
    axes: Vec<Axis>,
    place: Vec<usize>,
    /// Elements from here on, this one included.
    pub(super) left: usize,
    /// Where it is, in each operand and in the result.
    pub(super) offsets: Vec<usize>,
    pub(super) out: usize,
}

impl Walk {
    pub(super) fn new(axes: &[Axis], offsets: Vec<usize>) -> Walk {
        let left = axes.iter().map(|axis| axis.length).product();
        Walk { axes: axes.to_vec(), place: vec![0; axes.len()], left, offsets, out: 0 }
    }

    pub(super) fn next(&mut self) {
        self.left -= 1;
        for (axis, place) in self.axes.iter().zip(&mut self.place).rev() {
            *place += 1;
            if *place < axis.length {
                self.out += axis.out;
                for (offset, stride) in self.offsets.iter_mut().zip(&axis.strides) {
                    *offset += stride;
                }
                return;
            }
            *place = 0;
            self.out -= axis.out * (axis.length - 1);
            for (offset, stride) in self.offsets.iter_mut().zip(&axis.strides) {
                *offset -= stride * (axis.length - 1);
            }
        }
    }
}

/// The thicknesses that every row runs through.
#[derive(Debug)]
pub(super) struct Inner {
    /// Of each element its step in the result.
    out: Vec<usize>,
    layers: Vec<InnerLayer>,
}

#[derive(Debug)]
struct InnerLayer {
    /// Of each element its step in the operand; empty where the thickness is the same for all.
    steps: Vec<usize>,
    /// Thickness of each element, of the row that was last moved to.
    values: Vec<f64>,
    /// Whether rows differ in this thickness.
    moves: bool,
}

impl Inner {
    /// `offsets` say where the first row begins in each operand, `values` are those of the thicknesses.
    pub(super) fn new(inner: &[Axis], rows: &[Axis], offsets: &[usize], values: &[&[f64]]) -> Inner {
        let mut walk = Walk::new(inner, vec![0; offsets.len()]);
        let mut layers: Vec<InnerLayer> = (0..values.len())
            .map(|layer| InnerLayer {
                steps: Vec::with_capacity(walk.left),
                values: Vec::new(),
                moves: rows.iter().any(|axis| axis.strides[2 + layer] != 0),
            })
            .collect();
        let mut out = Vec::with_capacity(walk.left);
        while walk.left > 0 {
            out.push(walk.out);
            for (layer, step) in layers.iter_mut().zip(&walk.offsets[2..]) {
                layer.steps.push(*step);
            }
            walk.next();
        }
        for ((layer, values), start) in layers.iter_mut().zip(values).zip(&offsets[2..]) {
            layer.values = layer.steps.iter().map(|step| values[start + step]).collect();
        }
        Inner { out, layers }
    }

    pub(super) fn len(&self) -> usize {
        self.out.len()
    }

    /// Whether rows differ in any thickness.
    pub(super) fn moves(&self) -> bool {
        self.layers.iter().any(|layer| layer.moves)
    }

    /// Whether the elements lie side by side in the result.
    pub(super) fn is_contiguous(&self) -> bool {
        self.out.iter().enumerate().all(|(place, &at)| place == at)
    }

    pub(super) fn out(&self, element: usize) -> usize {
        self.out[element]
    }

    /// Reads the thicknesses of a row that begins at `offsets` (in every operand; thicknesses may be left out where
    /// rows differ in none).
    pub(super) fn move_to(&mut self, offsets: &[usize], values: &[&[f64]]) {
        for ((layer, values), start) in self.layers.iter_mut().zip(values).zip(&offsets[2..]) {
            if layer.moves {
                for (value, step) in layer.values.iter_mut().zip(&layer.steps) {
                    *value = values[start + step];
                }
            }
        }
    }

    /// Thicknesses of one layer, of the row last moved to.
    pub(super) fn values(&self, layer: usize) -> &[f64] {
        &self.layers[layer].values
    }

    /// Thicknesses of all layers at one element, of the row last moved to.
    pub(super) fn thickness_at(&self, element: usize, thickness_nm: &mut [f64]) {
        for (thickness, layer) in thickness_nm.iter_mut().zip(&self.layers) {
            *thickness = layer.values[element];
        }
    }

    /// Thicknesses of one layer at one element, of rows that begin at `offsets` (in every operand).
    #[inline(always)]
    pub(super) fn gather(
        &self,
        layer: usize,
        element: usize,
        offsets: &[Vec<usize>],
        values: &[f64],
        lanes: &mut Lane,
    ) {
        let of = &self.layers[layer];
        if !of.moves {
            lanes.0 = [of.values[element]; LANES];
            return;
        }
        for (lane, start) in lanes.0.iter_mut().zip(offsets) {
            *lane = values[start[2 + layer] + of.steps[element]];
        }
    }
}
