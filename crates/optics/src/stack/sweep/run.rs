//! One run of a sweep: rows are gathered, prepared and sent through a kernel.

use fearless_simd::{Simd, dispatch};

use iridesce_numerics::sums::dot;

use super::axes::{Axis, Inner, Walk, split};
use super::film::{FilmRows, along_rows, along_thickness, weigh_along_rows};
use super::lanes::{LANES, Lane, add_weighted};
use super::march::{Power, StackRows, march};
use super::rows::Block;
use super::single::{self, Lengths};
use super::{Kernel, Quantity, Sweep, SweepTask};
use crate::incidence::Incidence;
use crate::stack::{Polarization, Solver};
use crate::{Complex64, OpticsError};

/// From this many thicknesses on a march takes lanes along them rather than along the rows.
const MANY_THICKNESSES: usize = 64;

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

impl Sweep<'_> {
    /// Does one run. An error tells the place of its element: a laser beyond its threshold, or a ratio of nothing.
    pub fn run(&self, task: &mut SweepTask<'_>) -> Result<(), OpticsError> {
        let SweepTask { start, count, .. } = *task;
        match self.kernel {
            Kernel::Zero => task.out.fill(0.0),
            Kernel::General => return self.run_general(start, count, task.out, task.second),
            Kernel::Film | Kernel::March => {
                let done = dispatch!(self.level, simd => self.run_with(simd, task));
                // Element by element, so that the error tells its place.
                return match done {
                    Ok(()) | Err(OpticsError::Stopped) => done,
                    Err(_) => self.run_general(start, count, task.out, task.second),
                };
            }
        }
        Ok(())
    }

    /// The same in single precision: lossless films by vectors of it, good to 1e-6 at any thickness; everything else is
    /// worked out in double precision and rounded.
    pub fn run_single(&self, task: &mut SweepTask<'_, f32>) -> Result<(), OpticsError> {
        if self.kernel == Kernel::Film {
            let (row_axes, inner_axes) = split(&task.axes);
            let inner = Inner::new(&inner_axes, &row_axes, &task.offsets, &self.values[2..]);
            if inner.is_contiguous() && inner.len() >= LANES {
                return dispatch!(self.level, simd => self.films_single(simd, task, inner));
            }
        }
        let mut double = vec![0.0; task.out.len()];
        let (axes, offsets) = (task.axes.clone(), task.offsets.clone());
        let (start, count) = (task.start, task.count);
        self.run(&mut SweepTask { axes, offsets, start, count, out: &mut double, second: &mut [] })?;
        for (single, double) in task.out.iter_mut().zip(double) {
            *single = double as f32;
        }
        Ok(())
    }

    /// Sums over all rows, weighted three times: entry `j` of `out` is, for thicknesses `j`, the sum over rows `i` of value
    /// times `weights[.][i]`. Rows and thicknesses are counted in C order of their own axes. What a colour is.
    ///
    /// Sums run in eight lanes and then over these; the order does not depend on how many thicknesses there are.
    pub fn weigh(&self, weights: [&[f64]; 3], out: &mut [[f64; 3]]) -> Result<(), OpticsError> {
        let (row_axes, inner_axes) = split(&self.axes);
        let rows: usize = row_axes.iter().map(|axis| axis.length).product();
        let inner: usize = inner_axes.iter().map(|axis| axis.length).product();
        if weights.iter().any(|column| column.len() != rows) || out.len() != inner {
            let got = (weights.map(<[f64]>::len), out.len());
            return Err(OpticsError::Argument(format!("{rows} rows and {inner} thicknesses to weigh, got {got:?}")));
        }
        match self.kernel {
            Kernel::Zero => {
                out.fill([0.0; 3]);
                Ok(())
            }
            Kernel::General => self.weigh_general(&row_axes, &inner_axes, weights, out),
            _ => dispatch!(self.level, simd => self.weigh_with(simd, &row_axes, &inner_axes, weights, out)),
        }
    }

    fn weigh_general(
        &self,
        row_axes: &[Axis],
        inner_axes: &[Axis],
        weights: [&[f64]; 3],
        out: &mut [[f64; 3]],
    ) -> Result<(), OpticsError> {
        if !matches!(self.quantity, Quantity::Power(_)) {
            return Err(OpticsError::Argument("reflectance, transmittance, absorptance can be weighed".into()));
        }
        let mut bench = self.bench();
        let mut values = vec![0.0; weights[0].len()];
        let mut inner = Walk::new(inner_axes, vec![0; self.values.len()]);
        for out in out {
            let mut rows = Walk::new(row_axes, inner.offsets.clone());
            for value in &mut values {
                self.look()?;
                self.evaluate_at(&mut bench, &rows.offsets, std::slice::from_mut(value), &mut [])?;
                rows.next();
            }
            *out = weights.map(|weights| dot(weights, &values));
            inner.next();
        }
        Ok(())
    }

    #[inline(always)]
    fn weigh_with<S: Simd>(
        &self,
        simd: S,
        row_axes: &[Axis],
        inner_axes: &[Axis],
        weights: [&[f64]; 3],
        out: &mut [[f64; 3]],
    ) -> Result<(), OpticsError> {
        let start = vec![0; self.values.len()];
        let inner = Inner::new(inner_axes, row_axes, &start, &self.values[2..]);
        let mut walk = Walk::new(row_axes, start);
        let mut desk = Desk::new(self, self.values.len());
        let mut sums = vec![[Lane::ZERO; 3]; out.len()];
        let mut done = 0;
        while walk.left > 0 {
            self.look()?;
            let rows = self.gather(&mut walk, &mut desk)?;
            self.prepare(simd, &mut desk);
            let mut block = [Lane::ZERO; 3];
            for (lane, column) in block.iter_mut().zip(weights) {
                lane.0[..rows].copy_from_slice(&column[done..done + rows]);
            }
            done += rows;
            let plain = self.kernel == Kernel::Film && !inner.moves() && !desk.block.odd.contains(&true);
            match self.polarization {
                Polarization::Unpolarized if plain => {
                    weigh_along_rows::<S, 2>(simd, &desk.film, inner.values(0), &block, &mut sums);
                }
                _ if plain => weigh_along_rows::<S, 1>(simd, &desk.film, inner.values(0), &block, &mut sums),
                _ => {
                    for (element, sums) in sums.iter_mut().enumerate() {
                        let values = self.rows_at(simd, &mut desk, rows, &inner, element)?;
                        add_weighted(simd, &values, &block, sums);
                    }
                }
            }
        }
        for (out, sums) in out.iter_mut().zip(&sums) {
            *out = [sums[0].total(), sums[1].total(), sums[2].total()];
        }
        Ok(())
    }

    #[inline(always)]
    fn films_single<S: Simd>(
        &self,
        simd: S,
        task: &mut SweepTask<'_, f32>,
        mut inner: Inner,
    ) -> Result<(), OpticsError> {
        let (row_axes, _) = split(&task.axes);
        let mut walk = Walk::new(&row_axes, task.offsets.clone());
        let mut desk = Desk::new(self, self.values.len());
        let mut double = vec![0.0; inner.len()];
        let mut lengths = Lengths::default();
        lengths.set(inner.values(0));
        let thickest = self.media.thickest_nm[self.media.of[1]];
        while walk.left > 0 {
            self.look()?;
            let rows = self.gather(&mut walk, &mut desk)?;
            self.prepare(simd, &mut desk);
            for row in 0..rows {
                if inner.moves() {
                    inner.move_to(&desk.offsets[row], &self.values[2..]);
                    lengths.set(inner.values(0));
                }
                let [one, other] = [desk.film.parts[0].d.0[row], desk.film.parts[1].d.0[row]];
                let apart = one.min(other) + 1.0 < single::LEAST_LEFT
                    || desk.film.rate.0[row] * thickest > single::MOST_HALF_TURNS
                    || desk.block.odd[row];
                let out = &mut task.out[desk.out[row]..][..inner.len()];
                if apart {
                    desk.out[row] = 0;
                    self.row_along_thickness(simd, &mut desk, row, &mut inner, &mut double)?;
                    for (single, double) in out.iter_mut().zip(&double) {
                        *single = *double as f32;
                    }
                    continue;
                }
                match self.polarization {
                    Polarization::Unpolarized => {
                        single::along_thickness::<S, 2>(simd, &desk.film, row, &lengths, out);
                    }
                    _ => single::along_thickness::<S, 1>(simd, &desk.film, row, &lengths, out),
                }
            }
        }
        Ok(())
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
            self.look()?;
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
                desk.block.film(simd, media, from, until, self.power() == Power::Transmittance, &mut desk.film);
            }
            _ => desk.block.stack(simd, &self.media, &mut desk.stack),
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
        let in_order = rows == LANES && (1..LANES).all(|lane| desk.out[lane] == start + lane);
        for element in 0..inner.len() {
            let result = self.rows_at(simd, desk, rows, inner, element)?;
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

    /// A block of rows at one set of thicknesses.
    #[inline(always)]
    fn rows_at<S: Simd>(
        &self,
        simd: S,
        desk: &mut Desk,
        rows: usize,
        inner: &Inner,
        element: usize,
    ) -> Result<Lane, OpticsError> {
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
        if desk.block.odd.contains(&true) || result.0.iter().any(|value| value.is_nan()) {
            for row in 0..rows {
                if desk.block.odd[row] || result.0[row].is_nan() {
                    for (thickness, lanes) in desk.thickness_nm.iter_mut().zip(&desk.lanes) {
                        *thickness = lanes.0[row];
                    }
                    result.0[row] = self.carefully(desk, row)?;
                }
            }
            // Past the last row stand copies of it, which nobody asked for.
            result.0[rows..].fill(0.0);
        }
        Ok(result)
    }

    #[inline(always)]
    fn march<S: Simd>(&self, simd: S, rows: &StackRows, thickness_nm: &[Lane], out: &mut Lane) {
        let (real, layers) = (&self.media.real, &self.media.of[1..self.media.of.len() - 1]);
        match self.polarization {
            Polarization::S => march::<S, 0, 1>(simd, rows, layers, real, thickness_nm, self.power(), out),
            Polarization::P => march::<S, 1, 2>(simd, rows, layers, real, thickness_nm, self.power(), out),
            Polarization::Unpolarized => march::<S, 0, 2>(simd, rows, layers, real, thickness_nm, self.power(), out),
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
        match self.power() {
            Power::Reflectance => Ok(desk.solver.powers(self.polarization)?.reflectance),
            Power::Transmittance => Ok(desk.solver.powers(self.polarization)?.transmittance),
            Power::Absorptance => desk.solver.absorptance(self.polarization, &mut desk.scratch),
        }
    }
}
