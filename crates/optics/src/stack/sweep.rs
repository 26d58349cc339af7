//! Powers of a coherent stack over a whole array of wavelengths, angles and thicknesses, several evaluations at a time.
//!
//! Axes along which wavelength or angle change make *rows*, the others only change thicknesses. What a row needs
//! (wavenumbers, admittances) is worked out once; per thickness remain a phase a layer and the arithmetic of `film` or
//! `march`. Lanes of a vector are thicknesses where these are the innermost axes, else rows. Neither that choice nor how
//! the work is cut up changes a bit of the answer.
//!
//! A sweep is total: what no vector kernel covers (incoherent slabs, gain, extreme indices, amplitudes and angles) goes
//! element by element through [`Solver`](super::Solver), in the same tasks, and so do single rows of the others (light
//! along a layer, phases beyond all digits).

mod axes;
mod film;
mod general;
pub(crate) mod lanes;
mod march;
mod media;
mod operand;
mod quantity;
mod rows;
mod run;
mod single;

use fearless_simd::Level;
use iridesce_numerics::{ANGLE_DEG, Bounds, THICKNESS_NM, WAVELENGTH_NM, Watch, index_place, simd};

pub use iridesce_numerics::simd::levels;
pub use march::Power;
pub use operand::Operand;
pub use quantity::Quantity;

use self::axes::{Axis, Walk, axes_of};
use self::media::Media;
use super::{Polarization, check_indices, check_phase};
use crate::incidence::Incidence;
use crate::{Complex64, OpticsError};

/// Layer evaluations a task: its results stay in the second cache, and its rows are prepared once.
const TASK_WORK: usize = 1 << 18;
/// Elements a task of the general kernel: enough to pay for its dispatch, few enough to share evenly.
const GENERAL_TASK: usize = 512;
/// As many directions are kept ready; more are worked out where they are met.
const MOST_DIRECTIONS: usize = 1 << 16;

/// What a sweep runs over.
#[derive(Debug, Clone)]
pub struct SweepRequest<'a> {
    /// What is asked for.
    pub quantity: Quantity,
    /// Of which light.
    pub polarization: Polarization,
    /// Of each medium, first to last, its index at every wavelength, or a single one that holds at all of them.
    pub indices: Vec<&'a [Complex64]>,
    /// Of each layer whether it is coherent.
    pub coherent: Vec<bool>,
    /// Shape of the result.
    pub shape: Vec<usize>,
    /// Vacuum wavelength in nm.
    pub wavelength_nm: Operand<'a>,
    /// Angle of incidence in degrees.
    pub angle_deg: Operand<'a>,
    /// Thickness of each layer in nm.
    pub thickness_nm: Vec<Operand<'a>>,
}

/// A stack over a broadcast array, made ready.
#[derive(Debug)]
pub struct Sweep<'a> {
    quantity: Quantity,
    polarization: Polarization,
    coherent: Vec<bool>,
    indices: Vec<&'a [Complex64]>,
    /// Wavelength, angle, then the thickness of each layer.
    values: Vec<&'a [f64]>,
    /// One stride an axis of the result, of each of these.
    strides: Vec<Vec<usize>>,
    shape: Vec<usize>,
    count: usize,
    axes: Vec<Axis>,
    /// For the vector kernels.
    media: Media<'a>,
    directions: Option<Vec<Incidence>>,
    kernel: Kernel,
    level: Level,
    watch: Option<&'a Watch>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kernel {
    /// Absorptance where nothing absorbs.
    Zero,
    Film,
    March,
    /// Element by element.
    General,
}

/// A run of elements and where their results go.
#[derive(Debug)]
pub struct SweepTask<'o, T = f64> {
    axes: Vec<Axis>,
    /// Where the run begins in each operand.
    offsets: Vec<usize>,
    /// The same in the result, in elements, and how many there are.
    start: usize,
    count: usize,
    out: &'o mut [T],
    second: &'o mut [f64],
}

impl<'a> Sweep<'a> {
    /// A sweep, made ready; an error tells what is wrong with the request, with its place and what is allowed.
    pub fn new(request: SweepRequest<'a>) -> Result<Sweep<'a>, OpticsError> {
        Sweep::at_level(request, simd::level()?)
    }

    /// The same, held to one level of SIMD.
    pub fn at_level(request: SweepRequest<'a>, level: Level) -> Result<Sweep<'a>, OpticsError> {
        let SweepRequest { quantity, polarization, indices, coherent, shape, wavelength_nm, angle_deg, thickness_nm } =
            request;
        let layers = coherent.len();
        let operands: Vec<Operand<'a>> = [wavelength_nm, angle_deg].into_iter().chain(thickness_nm).collect();
        let count = shape.iter().try_fold(1_usize, |count, &length| count.checked_mul(length));
        let count = count.ok_or_else(|| OpticsError::Resource(format!("a result of shape {shape:?} cannot fit")))?;
        let (wavelengths, angles) = (operands[0].values, operands[1].values);
        let fits =
            |operand: &Operand<'_>| operand.strides.len() == shape.len() && (count == 0 || operand.reaches(&shape));
        let tables_fit = indices.iter().all(|table| table.len() == 1 || table.len() == wavelengths.len());
        if indices.len() != layers + 2 || operands.len() != layers + 2 || !tables_fit || !operands.iter().all(fits) {
            return Err(OpticsError::Argument(format!(
                "media, arguments and the shape {shape:?} do not belong together: {} media, {layers} coherent flags, {} \
                 thicknesses",
                indices.len(),
                operands.len() - 2
            )));
        }
        let mut sweep = Sweep {
            quantity,
            polarization,
            axes: if count == 0 { Vec::new() } else { axes_of(&shape, &operands) },
            values: operands.iter().map(|operand| operand.values).collect(),
            strides: operands.into_iter().map(|operand| operand.strides).collect(),
            shape,
            count,
            media: Media::default(),
            directions: None,
            kernel: Kernel::Zero,
            level,
            watch: None,
            coherent,
            indices,
        };
        if count > 0 {
            sweep.check_numbers()?;
            sweep.kernel = sweep.choose(angles);
        }
        if sweep.kernel == Kernel::General {
            sweep.check_media()?;
        }
        if matches!(sweep.kernel, Kernel::Film | Kernel::March) && angles.len() <= MOST_DIRECTIONS {
            sweep.directions =
                Some(angles.iter().map(|&angle| Incidence::from_degrees(angle)).collect::<Result<_, _>>()?);
        }
        Ok(sweep)
    }

    /// Wavelengths, angles and thicknesses by themselves, and thicknesses against wavelengths.
    fn check_numbers(&self) -> Result<(), OpticsError> {
        let check = |bounds: Bounds, values: &[f64]| match bounds.first_outside(values) {
            Some(at) => {
                let place = if values.len() > 1 { index_place(at, &[values.len()]) } else { String::new() };
                Err(bounds.refuse(values[at]).at(place))
            }
            None => Ok(()),
        };
        check(WAVELENGTH_NM, self.values[0])?;
        check(ANGLE_DEG, self.values[1])?;
        let shortest = self.values[0].iter().copied().fold(f64::INFINITY, f64::min);
        for (j, values) in self.values[2..].iter().enumerate() {
            let in_layer = format!("in layer {}", j + 1);
            check(THICKNESS_NM, values).map_err(|wrong| wrong.at(&in_layer))?;
            let thickest = values.iter().copied().fold(0.0, f64::max);
            check_phase(thickest, shortest).map_err(|wrong| wrong.at(format!("{in_layer} at {shortest} nm")))?;
        }
        Ok(())
    }

    /// Indices at every wavelength, and whether the quantity exists for such a stack.
    fn check_media(&self) -> Result<(), OpticsError> {
        let places = if self.indices.iter().all(|table| table.len() == 1) { 1 } else { self.values[0].len() };
        let mut n = vec![Complex64::default(); self.indices.len()];
        for place in 0..places {
            for (n, table) in n.iter_mut().zip(&self.indices) {
                *n = if table.len() == 1 { table[0] } else { table[place] };
            }
            let told = |error: OpticsError| {
                OpticsError::Argument(format!("{error} (at wavelength_nm = {})", self.values[0][place]))
            };
            check_indices(&n, &self.coherent).map_err(told)?;
            if self.quantity == Quantity::TwoBeam {
                if self.coherent.len() != 1 {
                    return Err(OpticsError::Argument("the two-beam form takes exactly one layer".into()));
                }
                if let Some(n) = n.iter().find(|n| n.im != 0.0) {
                    return Err(told(OpticsError::Argument(format!("the two-beam form takes real indices, got {n}"))));
                }
            }
        }
        let needs_phase = matches!(self.quantity, Quantity::Amplitudes | Quantity::Ellipsometry);
        if needs_phase && self.coherent.contains(&false) {
            return Err(OpticsError::Argument("amplitudes of a stack with incoherent slabs do not exist".into()));
        }
        Ok(())
    }

    /// The kernel for it; its media where that is one of the vectors'.
    fn choose(&mut self, angles: &[f64]) -> Kernel {
        let Quantity::Power(power) = self.quantity else { return Kernel::General };
        if self.coherent.contains(&false) {
            return Kernel::General;
        }
        let Some(mut media) = Media::look_at(&self.indices, self.values[0].len(), angles) else {
            return Kernel::General;
        };
        for (values, &medium) in self.values[2..].iter().zip(&media.of[1..]) {
            let thickest = values.iter().copied().fold(0.0, f64::max);
            media.thickest_nm[medium] = media.thickest_nm[medium].max(thickest);
        }
        self.media = media;
        match power {
            Power::Absorptance if !self.media.absorbs => Kernel::Zero,
            _ if self.coherent.len() == 1 && self.media.real[self.media.of[1]] && self.media.real[self.media.of[2]] => {
                Kernel::Film
            }
            _ => Kernel::March,
        }
    }

    /// R, T or A, for the kernels that know no other.
    fn power(&self) -> Power {
        match self.quantity {
            Quantity::Power(power) => power,
            _ => Power::Reflectance,
        }
    }

    /// Until the watch is stopped: runs end with [`OpticsError::Stopped`] then.
    pub fn watched(mut self, watch: &'a Watch) -> Sweep<'a> {
        self.watch = Some(watch);
        self
    }

    fn look(&self) -> Result<(), OpticsError> {
        if self.watch.is_some_and(Watch::is_stopped) { Err(OpticsError::Stopped) } else { Ok(()) }
    }

    /// Whether vectors do the work, or element after element goes through the solver.
    pub fn is_vectorised(&self) -> bool {
        self.kernel != Kernel::General
    }

    /// Cuts the result into runs. `out` and `second` have [`Quantity::widths`] numbers an element.
    pub fn tasks<'o>(&self, out: &'o mut [f64], second: &'o mut [f64]) -> Result<Vec<SweepTask<'o>>, OpticsError> {
        let [wide, wide_second] = self.quantity.widths(self.coherent.len());
        self.check_room(out.len(), wide)?;
        self.check_room(second.len(), wide_second)?;
        if self.kernel != Kernel::General {
            return Ok(self.cut(out));
        }
        let most = (TASK_WORK / (self.coherent.len() + 1)).clamp(1, GENERAL_TASK);
        let (mut first, mut second) = (out, second);
        let mut tasks = Vec::with_capacity(self.count.div_ceil(most));
        for start in (0..self.count).step_by(most) {
            let count = most.min(self.count - start);
            let (head, tail) = first.split_at_mut(count * wide);
            let (head_second, tail_second) = second.split_at_mut(count * wide_second);
            (first, second) = (tail, tail_second);
            let (axes, offsets) = (Vec::new(), Vec::new());
            tasks.push(SweepTask { axes, offsets, start, count, out: head, second: head_second });
        }
        Ok(tasks)
    }

    /// The same in single precision, of a power.
    pub fn tasks_single<'o>(&self, out: &'o mut [f32]) -> Result<Vec<SweepTask<'o, f32>>, OpticsError> {
        if !matches!(self.quantity, Quantity::Power(_)) {
            return Err(OpticsError::Argument(
                "single precision is for reflectance, transmittance, absorptance".into(),
            ));
        }
        self.check_room(out.len(), 1)?;
        Ok(self.cut(out))
    }

    fn check_room(&self, got: usize, width: usize) -> Result<(), OpticsError> {
        match self.count.checked_mul(width) {
            Some(expected) if expected == got => Ok(()),
            _ => Err(OpticsError::Argument(format!(
                "the output must have {} elements of {width} numbers, got {got} numbers",
                self.count
            ))),
        }
    }

    fn cut<'o, T>(&self, mut out: &'o mut [T]) -> Vec<SweepTask<'o, T>> {
        if out.is_empty() {
            return Vec::new();
        }
        let work = (TASK_WORK / (self.coherent.len() + 1)).max(1);
        // Where thicknesses come first, a larger run spares preparing the rows for each few of them.
        let most_of = |axis: &Axis| if axis.is_row() { work } else { 8 * work };
        // The first axis whose sub-arrays are small enough is cut; the ones before it are walked.
        let cut = (0..self.axes.len()).find(|&a| self.axes[a].out <= most_of(&self.axes[a])).unwrap_or(self.axes.len());
        let mut walk = Walk::new(&self.axes[..cut], vec![0; self.values.len()]);
        let whole = [Axis { length: 1, out: 1, strides: vec![0; self.values.len()] }];
        let (axis, below) = self.axes[cut..].split_first().unwrap_or((&whole[0], &[]));
        let most = if below.iter().any(Axis::is_row) { most_of(axis) } else { work };
        let piece = (most / axis.out).clamp(1, axis.length);
        let (mut tasks, mut start) = (Vec::new(), 0);
        while walk.left > 0 {
            for first in (0..axis.length).step_by(piece) {
                let length = piece.min(axis.length - first);
                let count = length * axis.out;
                let (head, tail) = out.split_at_mut(count);
                out = tail;
                let offsets = walk.offsets.iter().zip(&axis.strides).map(|(at, step)| at + first * step).collect();
                let own = Axis { length, ..axis.clone() };
                let axes = std::iter::once(own).chain(below.iter().cloned()).collect();
                tasks.push(SweepTask { axes, offsets, start, count, out: head, second: &mut [] });
                start += count;
            }
            walk.next();
        }
        tasks
    }

    /// The whole sweep on the calling thread.
    pub fn evaluate(&self, out: &mut [f64]) -> Result<(), OpticsError> {
        self.tasks(out, &mut [])?.iter_mut().try_for_each(|task| self.run(task))
    }

    /// The whole sweep on the calling thread, in single precision: see [`Sweep::run_single`].
    pub fn evaluate_single(&self, out: &mut [f32]) -> Result<(), OpticsError> {
        self.tasks_single(out)?.iter_mut().try_for_each(|task| self.run_single(task))
    }
}
