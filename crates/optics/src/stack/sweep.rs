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
mod lanes;
mod march;
mod rows;

use fearless_simd::{Level, Simd, dispatch};

pub use march::Power;

use self::axes::{Axis, Inner, Walk, axes_of, split};
use self::film::{FilmRows, along_rows, along_thickness};
use self::lanes::{LANES, Lane};
use self::march::{StackRows, march};
use self::rows::Block;
use super::{MOST_WAVES, Polarization, Solver, check_indices};
use crate::incidence::Incidence;
use crate::{Complex64, OpticsError};

/// Layer evaluations a task: its results stay in the second cache, and its rows are prepared once.
const TASK_WORK: usize = 1 << 18;
/// Indices beyond these have squares and ratios that the kernels were not made for.
const MODULUS_RANGE: (f64, f64) = (1e-3, 1e3);
/// As many directions are kept ready; more are worked out where they are met.
const MOST_DIRECTIONS: usize = 1 << 16;
/// From this many thicknesses on a march takes lanes along them rather than along the rows.
const MANY_THICKNESSES: usize = 64;

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
    pub shape: &'a [usize],
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
pub struct SweepTask<'o> {
    axes: Vec<Axis>,
    /// Where the run begins in each operand.
    offsets: Vec<usize>,
    out: &'o mut [f64],
}

impl<'a> Sweep<'a> {
    /// A sweep, or `None` where the vector kernels do not cover the stack or something is not as [`super::check`] wants it:
    /// the point by point solution will do it, or say what is wrong.
    pub fn new(request: SweepRequest<'a>) -> Option<Sweep<'a>> {
        Sweep::at_level(request, Level::new())
    }

    /// The same, held to one level of SIMD.
    pub fn at_level(request: SweepRequest<'a>, level: Level) -> Option<Sweep<'a>> {
        let SweepRequest { power, polarization, indices, shape, wavelength_nm, angle_deg, thickness_nm } = request;
        let layers = thickness_nm.len();
        let operands: Vec<Operand<'a>> = [wavelength_nm, angle_deg].into_iter().chain(thickness_nm).collect();
        let fits = |operand: &Operand<'_>| operand.strides.len() == shape.len() && operand.reaches(shape);
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
            axes: axes_of(shape, &operands),
            values: operands.iter().map(|operand| operand.values).collect(),
            count,
            directions,
            kernel,
            level,
        })
    }

    /// Cuts the result into runs; `None` where `out` does not have its length.
    pub fn tasks<'o>(&self, mut out: &'o mut [f64]) -> Option<Vec<SweepTask<'o>>> {
        if out.len() != self.count {
            return None;
        }
        let most = (TASK_WORK / (self.media.of.len() - 1)).max(1);
        // The first axis whose sub-arrays are small enough is cut; the ones before it are walked.
        let cut = (0..self.axes.len()).find(|&a| self.axes[a].out <= most).unwrap_or(self.axes.len());
        let mut walk = Walk::new(&self.axes[..cut], vec![0; self.values.len()]);
        let whole = [Axis { length: 1, out: 1, strides: vec![0; self.values.len()] }];
        let (axis, below) = self.axes[cut..].split_first().unwrap_or((&whole[0], &[]));
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

    /// Does one run. The only error is what [`Solver::powers`] can meet.
    pub fn run(&self, task: &mut SweepTask<'_>) -> Result<(), OpticsError> {
        if self.kernel == Kernel::Zero {
            task.out.fill(0.0);
            return Ok(());
        }
        dispatch!(self.level, simd => self.run_with(simd, task))
    }

    /// The whole sweep on the calling thread.
    pub fn evaluate(&self, out: &mut [f64]) -> Result<(), OpticsError> {
        let expected = self.count;
        let got = out.len();
        let wrong = || OpticsError::Argument(format!("out must have {expected} elements, got {got}"));
        self.tasks(out).ok_or_else(wrong)?.iter_mut().try_for_each(|task| self.run(task))
    }

    #[inline(always)]
    fn run_with<S: Simd>(&self, simd: S, task: &mut SweepTask<'_>) -> Result<(), OpticsError> {
        let (row_axes, inner_axes) = split(&task.axes);
        let mut inner = Inner::new(&inner_axes, &row_axes, &task.offsets, &self.values[2..]);
        // Thicknesses that are the same in every row need not be walked.
        let walked = if inner.moves() { self.values.len() } else { 2 };
        let mut walk = Walk::new(&row_axes, task.offsets[..walked].to_vec());
        let many = match self.kernel {
            Kernel::March if walk.left >= LANES => MANY_THICKNESSES,
            _ => LANES,
        };
        let along_inner = inner.is_contiguous() && inner.len() >= many;
        let mut desk = Desk::new(self, walked);
        while walk.left > 0 {
            let rows = self.gather(&mut walk, &mut desk)?;
            self.prepare(simd, &mut desk);
            if along_inner {
                for row in 0..rows {
                    self.row_along_thickness(simd, &mut desk, row, &mut inner, task.out)?;
                }
            } else {
                self.rows_at_each_thickness(simd, &mut desk, rows, &inner, task.out)?;
            }
        }
        Ok(())
    }

    /// Takes up to [`LANES`] rows from the walk; lanes past the last one repeat it.
    fn gather(&self, walk: &mut Walk, desk: &mut Desk) -> Result<usize, OpticsError> {
        let mut rows = 0;
        for lane in 0..LANES {
            if walk.left > 0 {
                desk.offsets[lane].copy_from_slice(&walk.offsets);
                desk.out[lane] = walk.out;
                walk.next();
                rows += 1;
            } else {
                let (before, after) = desk.offsets.split_at_mut(lane);
                after[0].copy_from_slice(&before[rows - 1]);
            }
            let (at, angle_at) = (desk.offsets[lane][0], desk.offsets[lane][1]);
            let incidence = match &self.directions {
                Some(directions) => directions[angle_at],
                None => Incidence::from_degrees(self.values[1][angle_at])?,
            };
            desk.block.set(lane, self.values[0][at], incidence);
            for (medium, table) in self.media.tables.iter().enumerate() {
                // (Those that hold at all wavelengths have been on the desk from the beginning.)
                if table.len() > 1 {
                    desk.block.set_index(medium, lane, table[at]);
                }
            }
        }
        Ok(rows)
    }

    #[inline(always)]
    fn prepare<S: Simd>(&self, simd: S, desk: &mut Desk) {
        desk.block.wavenumbers(simd);
        desk.block.find_odd(simd, &self.media.thickest_nm);
        match self.kernel {
            Kernel::Film => {
                let (from, until) = self.parts();
                let media = [self.media.of[0], self.media.of[1], self.media.of[2]];
                desk.block.film(simd, media, from, until, self.power == Power::Transmittance, &mut desk.film);
            }
            _ => desk.block.stack(simd, &self.media.of, &self.media.real, &mut desk.stack),
        }
    }

    fn parts(&self) -> (usize, usize) {
        match self.polarization {
            Polarization::S => (0, 1),
            Polarization::P => (1, 2),
            Polarization::Unpolarized => (0, 2),
        }
    }

    /// Lanes are thicknesses: one row after the other.
    #[inline(always)]
    fn row_along_thickness<S: Simd>(
        &self,
        simd: S,
        desk: &mut Desk,
        row: usize,
        inner: &mut Inner,
        out: &mut [f64],
    ) -> Result<(), OpticsError> {
        inner.move_to(&desk.offsets[row], &self.values[2..]);
        let out = &mut out[desk.out[row]..][..inner.len()];
        if desk.block.odd[row] {
            for (element, value) in out.iter_mut().enumerate() {
                inner.thickness_at(element, &mut desk.thickness_nm);
                *value = self.carefully(desk, row)?;
            }
            return Ok(());
        }
        if self.kernel == Kernel::Film {
            match self.polarization {
                Polarization::Unpolarized => along_thickness::<S, 2>(simd, &desk.film, row, inner.values(0), out),
                _ => along_thickness::<S, 1>(simd, &desk.film, row, inner.values(0), out),
            }
            return Ok(());
        }
        desk.repeated.repeat(&desk.stack, row);
        for first in (0..out.len()).step_by(LANES) {
            let some = LANES.min(out.len() - first);
            for (layer, lane) in desk.lanes.iter_mut().enumerate() {
                lane.0[..some].copy_from_slice(&inner.values(layer)[first..first + some]);
                lane.0[some..].fill(0.0);
            }
            let mut result = Lane::ZERO;
            self.march(simd, &desk.repeated, &desk.lanes, &mut result);
            for (place, &value) in result.0[..some].iter().enumerate() {
                out[first + place] = if value.is_nan() {
                    inner.thickness_at(first + place, &mut desk.thickness_nm);
                    self.carefully(desk, row)?
                } else {
                    value
                };
            }
        }
        Ok(())
    }

    /// Lanes are rows: one thickness after the other.
    #[inline(always)]
    fn rows_at_each_thickness<S: Simd>(
        &self,
        simd: S,
        desk: &mut Desk,
        rows: usize,
        inner: &Inner,
        out: &mut [f64],
    ) -> Result<(), OpticsError> {
        let start = desk.out[0];
        let any_odd = desk.block.odd.contains(&true);
        let in_order = rows == LANES && (1..LANES).all(|lane| desk.out[lane] == start + lane);
        for element in 0..inner.len() {
            for (layer, lanes) in desk.lanes.iter_mut().enumerate() {
                inner.gather(layer, element, &desk.offsets, self.values[2 + layer], lanes);
            }
            let mut result = Lane::ZERO;
            if self.kernel == Kernel::Film {
                match self.polarization {
                    Polarization::Unpolarized => along_rows::<S, 2>(simd, &desk.film, &desk.lanes[0], &mut result),
                    _ => along_rows::<S, 1>(simd, &desk.film, &desk.lanes[0], &mut result),
                }
            } else {
                self.march(simd, &desk.stack, &desk.lanes, &mut result);
            }
            let unsound = any_odd || result.0.iter().any(|value| value.is_nan());
            if unsound {
                for row in 0..rows {
                    if desk.block.odd[row] || result.0[row].is_nan() {
                        for (thickness, lanes) in desk.thickness_nm.iter_mut().zip(&desk.lanes) {
                            *thickness = lanes.0[row];
                        }
                        result.0[row] = self.carefully(desk, row)?;
                    }
                }
            }
            let step = inner.out(element);
            if in_order {
                out[start + step..][..LANES].copy_from_slice(&result.0);
            } else {
                for (&value, &at) in result.0[..rows].iter().zip(&desk.out) {
                    out[at + step] = value;
                }
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn march<S: Simd>(&self, simd: S, rows: &StackRows, thickness_nm: &[Lane], out: &mut Lane) {
        let (real, layers) = (&self.media.real, &self.media.of[1..self.media.of.len() - 1]);
        match self.polarization {
            Polarization::S => march::<S, 0, 1>(simd, rows, layers, real, thickness_nm, self.power, out),
            Polarization::P => march::<S, 1, 2>(simd, rows, layers, real, thickness_nm, self.power, out),
            Polarization::Unpolarized => march::<S, 0, 2>(simd, rows, layers, real, thickness_nm, self.power, out),
        }
    }

    /// One evaluation by the solver, of a row on the desk at the thicknesses on the desk.
    #[cold]
    #[inline(never)]
    fn carefully(&self, desk: &mut Desk, row: usize) -> Result<f64, OpticsError> {
        for (index, &medium) in desk.indices.iter_mut().zip(&self.media.of) {
            *index = desk.block.index(medium, row);
        }
        let (wavelength_nm, incidence) = (desk.block.wavelength_nm.0[row], desk.block.incidence[row]);
        desk.solver.prepare(&desk.indices, &desk.thickness_nm, &desk.coherent, wavelength_nm, incidence);
        match self.power {
            Power::Reflectance => Ok(desk.solver.powers(self.polarization)?.reflectance),
            Power::Transmittance => Ok(desk.solver.powers(self.polarization)?.transmittance),
            Power::Absorptance => desk.solver.absorptance(self.polarization, &mut desk.scratch),
        }
    }
}

/// The media, each different one once: a mirror of a hundred layers has two, and their wavenumbers are worked out once.
#[derive(Debug)]
struct Media<'a> {
    /// Index of each different medium at every wavelength, or a single one that holds at all of them.
    tables: Vec<&'a [Complex64]>,
    /// Which of the tables each medium of the stack has, first to last.
    of: Vec<usize>,
    /// Of each table whether it is lossless and lets light in at every row.
    real: Vec<bool>,
    /// Of each table the thickest layer; less than nothing where it is of no layer and not the last medium.
    thickest_nm: Vec<f64>,
    /// Whether some layer absorbs at some wavelength.
    absorbs: bool,
}

impl<'a> Media<'a> {
    /// `None` for indices that are not allowed or that the kernels do not cover.
    fn look_at(indices: &[&'a [Complex64]], wavelengths: usize, angles: &[f64]) -> Option<Media<'a>> {
        if indices.iter().any(|table| table.len() != 1 && table.len() != wavelengths) {
            return None;
        }
        let mut tables: Vec<&'a [Complex64]> = Vec::new();
        let mut of = Vec::with_capacity(indices.len());
        for table in indices {
            let same = |other: &&[Complex64]| std::ptr::eq(*other, *table) || (table.len() == 1 && other == table);
            of.push(tables.iter().position(same).unwrap_or_else(|| {
                tables.push(table);
                tables.len() - 1
            }));
        }
        let steepest = angles.iter().copied().fold(0.0, f64::max);
        let sine_squared = 1.0 - Incidence::from_degrees(steepest).ok()?.cos_theta().powi(2);
        let last = of.len() - 1;
        let mut media =
            Media { real: vec![true; tables.len()], thickest_nm: vec![-1.0; tables.len()], absorbs: false, tables, of };
        media.thickest_nm[media.of[last]] = 0.0;
        let coherent = vec![true; last - 1];
        let different = if indices.iter().all(|table| table.len() == 1) { 1 } else { wavelengths };
        let mut at = vec![Complex64::default(); last + 1];
        for place in 0..different {
            for (index, table) in at.iter_mut().zip(indices) {
                *index = if table.len() == 1 { table[0] } else { table[place] };
                let modulus = index.norm();
                if !(modulus >= MODULUS_RANGE.0 && modulus <= MODULUS_RANGE.1 && index.im >= 0.0) {
                    return None;
                }
            }
            check_indices(&at, &coherent).ok()?;
            for (position, (n, &medium)) in at.iter().zip(&media.of).enumerate() {
                // Light enters at every angle: kz^2 > 0.
                media.real[medium] &= n.im == 0.0 && n.re * n.re > at[0].re * at[0].re * sine_squared;
                media.absorbs |= (1..last).contains(&position) && n.re * n.im != 0.0;
            }
        }
        Some(media)
    }
}

/// The buffers of one run.
struct Desk {
    block: Block,
    film: FilmRows,
    stack: StackRows,
    repeated: StackRows,
    /// Thicknesses of the layers, a vector each.
    lanes: Vec<Lane>,
    /// Where each row begins in every operand and in the result.
    offsets: Vec<Vec<usize>>,
    out: [usize; LANES],
    // For the careful path:
    solver: Solver,
    indices: Vec<Complex64>,
    thickness_nm: Vec<f64>,
    coherent: Vec<bool>,
    scratch: Vec<f64>,
}

impl Desk {
    /// `walked` operands are walked from row to row.
    fn new(sweep: &Sweep<'_>, walked: usize) -> Desk {
        let (media, layers) = (sweep.media.tables.len(), sweep.values.len() - 2);
        let normal = Incidence::from_cos(1.0).expect("1 is the cosine of an angle");
        let in_use = if sweep.kernel == Kernel::March { media } else { 0 };
        let mut block = Block::new(media, sweep.media.of[0], normal);
        for (medium, table) in sweep.media.tables.iter().enumerate() {
            (0..LANES).for_each(|lane| block.set_index(medium, lane, table[0]));
        }
        Desk {
            block,
            film: FilmRows::new(),
            stack: StackRows::new(in_use),
            repeated: StackRows::new(in_use),
            lanes: vec![Lane::ZERO; layers],
            offsets: vec![vec![0; walked]; LANES],
            out: [0; LANES],
            solver: Solver::new(),
            indices: vec![Complex64::default(); layers + 2],
            thickness_nm: vec![0.0; layers],
            coherent: vec![true; layers],
            scratch: Vec::new(),
        }
    }
}

/// Every level of SIMD that this machine has, from the plainest on: for tests and measurements.
pub fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        let levels = [
            best.as_sse2().map(Simd::level),
            best.as_sse4_2().map(Simd::level),
            best.as_avx2().map(Simd::level),
            best.as_avx512().map(Simd::level),
        ];
        levels.into_iter().flatten().collect()
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        vec![best]
    }
}
