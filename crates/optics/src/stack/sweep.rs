//! Powers of a coherent stack over a whole array of wavelengths, angles and thicknesses, several evaluations at a time.
//!
//! Axes along which wavelength or angle change make *rows*, the others only change thicknesses. What a row needs
//! (wavenumbers, admittances) is worked out once; per thickness remain a phase a layer and the arithmetic of `film` or
//! `march`. Lanes of a vector are thicknesses where these are the innermost axes, else rows. Neither that choice nor how
//! the work is cut up changes a bit of the answer.
//!
//! What the kernels do not cover goes through [`Solver`]: whole stacks with incoherent slabs, gain or extreme indices
//! are refused by [`Sweep::new`], single rows (light along a layer, phases beyond all digits) are done here.

mod axes;
mod film;
pub(crate) mod lanes;
mod march;
mod media;
mod rows;
mod run;
mod single;

use fearless_simd::Level;
use iridesce_numerics::simd;

pub use iridesce_numerics::simd::levels;
pub use march::Power;

use self::axes::{Axis, Walk, axes_of};
use self::media::Media;
use super::{MOST_WAVES, Polarization};
use crate::incidence::Incidence;
use crate::{Complex64, OpticsError};

/// Layer evaluations a task: its results stay in the second cache, and its rows are prepared once.
const TASK_WORK: usize = 1 << 18;
/// As many directions are kept ready; more are worked out where they are met.
const MOST_DIRECTIONS: usize = 1 << 16;
/// One argument: its own values, and how far to step in them along each axis of the result (0: broadcast).
#[derive(Debug, Clone)]
pub struct Operand<'a> {
    /// The values.
    pub values: &'a [f64],
    /// One stride an axis.
    pub strides: Vec<usize>,
}

/// What a sweep runs over.
#[derive(Debug, Clone)]
pub struct SweepRequest<'a> {
    /// What is asked for.
    pub power: Power,
    /// Of which light.
    pub polarization: Polarization,
    /// Of each medium, first to last, its index at every wavelength, or a single one that holds at all of them.
    pub indices: Vec<&'a [Complex64]>,
    /// Shape of the result.
    pub shape: Vec<usize>,
    /// Vacuum wavelength in nm.
    pub wavelength_nm: Operand<'a>,
    /// Angle of incidence in degrees.
    pub angle_deg: Operand<'a>,
    /// Thickness of each layer in nm.
    pub thickness_nm: Vec<Operand<'a>>,
}

/// A coherent stack over a broadcast array, made ready.
#[derive(Debug)]
pub struct Sweep<'a> {
    power: Power,
    polarization: Polarization,
    media: Media<'a>,
    /// Wavelength, angle, then the thickness of each layer.
    values: Vec<&'a [f64]>,
    axes: Vec<Axis>,
    count: usize,
    directions: Option<Vec<Incidence>>,
    kernel: Kernel,
    level: Level,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kernel {
    /// Absorptance where nothing absorbs.
    Zero,
    Film,
    March,
}

/// A run of elements and where their results go.
#[derive(Debug)]
pub struct SweepTask<'o, T = f64> {
    axes: Vec<Axis>,
    /// Where the run begins in each operand.
    offsets: Vec<usize>,
    out: &'o mut [T],
}

impl<'a> Sweep<'a> {
    /// A sweep, or `None` where the vector kernels do not cover the stack or something is not as [`super::check`] wants it:
    /// the point by point solution will do it, or say what is wrong.
    pub fn new(request: SweepRequest<'a>) -> Option<Sweep<'a>> {
        Sweep::at_level(request, simd::level_or_best())
    }

    /// The same, held to one level of SIMD.
    pub fn at_level(request: SweepRequest<'a>, level: Level) -> Option<Sweep<'a>> {
        let SweepRequest { power, polarization, indices, shape, wavelength_nm, angle_deg, thickness_nm } = request;
        let layers = thickness_nm.len();
        let operands: Vec<Operand<'a>> = [wavelength_nm, angle_deg].into_iter().chain(thickness_nm).collect();
        let fits = |operand: &Operand<'_>| operand.strides.len() == shape.len() && operand.reaches(&shape);
        let count = shape.iter().try_fold(1_usize, |count, &length| count.checked_mul(length))?;
        if indices.len() != layers + 2 || count == 0 || !operands.iter().all(fits) {
            return None;
        }
        let (wavelengths, angles) = (operands[0].values, operands[1].values);
        let angle_ok = |angle: &f64| (0.0..90.0).contains(angle);
        let shortest = wavelengths.iter().copied().fold(f64::INFINITY, f64::min);
        let lengths_ok = |values: &[f64]| values.iter().all(|v| *v >= 0.0 && v / shortest < MOST_WAVES);
        let sound = wavelengths.iter().all(|nm| *nm > 0.0 && nm.is_finite())
            && angles.iter().all(angle_ok)
            && operands[2..].iter().all(|operand| lengths_ok(operand.values));
        if !sound {
            return None;
        }
        let mut media = Media::look_at(&indices, wavelengths.len(), angles)?;
        for (operand, &medium) in operands[2..].iter().zip(&media.of[1..]) {
            let thickest = operand.values.iter().copied().fold(0.0, f64::max);
            media.thickest_nm[medium] = media.thickest_nm[medium].max(thickest);
        }
        let kernel = match power {
            Power::Absorptance if !media.absorbs => Kernel::Zero,
            _ if layers == 1 && media.real[media.of[1]] && media.real[media.of[2]] => Kernel::Film,
            _ => Kernel::March,
        };
        let directions = (angles.len() <= MOST_DIRECTIONS)
            .then(|| angles.iter().map(|&angle| Incidence::from_degrees(angle)).collect::<Result<_, _>>())
            .transpose()
            .ok()?;
        Some(Sweep {
            power,
            polarization,
            media,
            axes: axes_of(&shape, &operands),
            values: operands.iter().map(|operand| operand.values).collect(),
            count,
            directions,
            kernel,
            level,
        })
    }

    /// Cuts the result into runs; `None` where `out` does not have its length.
    pub fn tasks<'o, T>(&self, mut out: &'o mut [T]) -> Option<Vec<SweepTask<'o, T>>> {
        if out.len() != self.count {
            return None;
        }
        let work = (TASK_WORK / (self.media.of.len() - 1)).max(1);
        // Where thicknesses come first, a larger run spares preparing the rows for each few of them.
        let most_of = |axis: &Axis| if axis.is_row() { work } else { 8 * work };
        // The first axis whose sub-arrays are small enough is cut; the ones before it are walked.
        let cut = (0..self.axes.len()).find(|&a| self.axes[a].out <= most_of(&self.axes[a])).unwrap_or(self.axes.len());
        let mut walk = Walk::new(&self.axes[..cut], vec![0; self.values.len()]);
        let whole = [Axis { length: 1, out: 1, strides: vec![0; self.values.len()] }];
        let (axis, below) = self.axes[cut..].split_first().unwrap_or((&whole[0], &[]));
        let most = if below.iter().any(Axis::is_row) { most_of(axis) } else { work };
        let piece = (most / axis.out).clamp(1, axis.length);
        let mut tasks = Vec::new();
        while walk.left > 0 {
            for first in (0..axis.length).step_by(piece) {
                let length = piece.min(axis.length - first);
                let (head, tail) = out.split_at_mut(length * axis.out);
                out = tail;
                let offsets = walk.offsets.iter().zip(&axis.strides).map(|(at, step)| at + first * step).collect();
                let own = Axis { length, ..axis.clone() };
                let axes = std::iter::once(own).chain(below.iter().cloned()).collect();
                tasks.push(SweepTask { axes, offsets, out: head });
            }
            walk.next();
        }
        Some(tasks)
    }

    /// The whole sweep on the calling thread.
    pub fn evaluate(&self, out: &mut [f64]) -> Result<(), OpticsError> {
        self.all_tasks(out)?.iter_mut().try_for_each(|task| self.run(task))
    }

    /// The whole sweep on the calling thread, in single precision: see [`Sweep::run_single`].
    pub fn evaluate_single(&self, out: &mut [f32]) -> Result<(), OpticsError> {
        self.all_tasks(out)?.iter_mut().try_for_each(|task| self.run_single(task))
    }

    fn all_tasks<'o, T>(&self, out: &'o mut [T]) -> Result<Vec<SweepTask<'o, T>>, OpticsError> {
        let (expected, got) = (self.count, out.len());
        let wrong = || OpticsError::Argument(format!("out must have {expected} elements, got {got}"));
        self.tasks(out).ok_or_else(wrong)
    }
}
