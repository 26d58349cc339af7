//! Bindings of the stack stage: one call evaluates a stack over broadcast arrays.

use iridesce::optics::incidence::Incidence;
use iridesce::optics::stack::sweep::{Operand, Power, Sweep, SweepRequest};
use iridesce::optics::stack::{self, Solver};
use iridesce::optics::{Complex64, OpticsError, Polarization, film};
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// What optics answers.
type Answer<T> = std::result::Result<T, OpticsError>;

/// Elements a task at most: enough to pay for its dispatch, few enough to share evenly.
const TASK: usize = 512;
/// Layer evaluations of a task at most: some 20 ms, after which it is asked whether to go on. Calls of a tenth of that are
/// done on the spot.
const WORK: usize = 1 << 18;

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_evaluate, module)?)
}

/// What is written for each element.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Quantity {
    Reflectance,
    Transmittance,
    Absorptance,
    LayerAbsorptance,
    /// `r` and `t`, real and imaginary part each.
    Amplitudes,
    /// psi and delta in degrees.
    Ellipsometry,
    TwoBeam,
}

impl Quantity {
    fn named(name: &str) -> Result<Quantity> {
        match name {
            "reflectance" => Ok(Quantity::Reflectance),
            "transmittance" => Ok(Quantity::Transmittance),
            "absorptance" => Ok(Quantity::Absorptance),
            "layer_absorptance" => Ok(Quantity::LayerAbsorptance),
            "amplitudes" => Ok(Quantity::Amplitudes),
            "ellipsometry" => Ok(Quantity::Ellipsometry),
            "two_beam" => Ok(Quantity::TwoBeam),
            _ => Err(Error::value(format!("no quantity is named {name:?}"))),
        }
    }

    /// Numbers an element in the first and in the second output.
    fn widths(self, layers: usize) -> [usize; 2] {
        match self {
            Quantity::LayerAbsorptance => [layers, 0],
            Quantity::Amplitudes => [2, 2],
            Quantity::Ellipsometry => [1, 1],
            _ => [1, 0],
        }
    }
}

/// A stack over a broadcast shape.
struct Job<'a> {
    quantity: Quantity,
    polarization: Polarization,
    /// For each medium of the stack its indices: one a wavelength, or a single one that holds at all of them.
    indices: Vec<&'a [Complex64]>,
    coherent: Vec<bool>,
    shape: Vec<usize>,
    /// Wavelength, angle, then one thickness a layer.
    operands: Vec<Operand<'a>>,
}

/// A run of elements and where their results go.
struct Task<'a> {
    start: usize,
    count: usize,
    out: [&'a mut [f64]; 2],
}

/// Evaluates a stack. `indices` holds for each different medium its index at every wavelength, or a single one that holds at
/// all of them; `media` says which of these each medium of the stack has. Each of `arguments` (wavelength, angle, then the thickness of each layer) comes as flat values with its
/// strides along the axes of `shape`. Results are written into `out` and, where there are two, `second`.
#[pyfunction]
#[pyo3(signature = (quantity, polarization, indices, media, coherent, arguments, shape, out, second, threads))]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_evaluate<'py>(
    py: Python<'py>,
    quantity: &str,
    polarization: &str,
    indices: Vec<PyReadonlyArray1<'py, Complex64>>,
    media: Vec<usize>,
    coherent: Vec<bool>,
    arguments: Vec<(PyReadonlyArray1<'py, f64>, Vec<usize>)>,
    shape: Vec<usize>,
    mut out: PyReadwriteArray1<'py, f64>,
    mut second: Option<PyReadwriteArray1<'py, f64>>,
    threads: Option<usize>,
) -> Result<()> {
    let quantity = Quantity::named(quantity)?;
    let polarization = Polarization::named(polarization)?;
    let layers = coherent.len();
    if media.len() != layers + 2 || arguments.len() != layers + 2 || media.iter().any(|&which| which >= indices.len()) {
        return Err(Error::value("media, coherent flags, arguments and indices do not belong together"));
    }
    let wavelengths = arguments[0].0.len()?;
    let tables = indices.iter().map(|table| Ok(table.as_slice()?)).collect::<Result<Vec<_>>>()?;
    if tables.iter().any(|table| table.len() != 1 && table.len() != wavelengths) {
        return Err(Error::value("indices do not fit the wavelengths"));
    }
    let indices = media.iter().map(|&which| tables[which]).collect();
    let operands = arguments
        .iter()
        .map(|(values, strides)| operand(values.as_slice()?, strides.clone(), &shape))
        .collect::<Result<Vec<_>>>()?;
    let job = Job { quantity, polarization, indices, coherent, shape, operands };
    job.check_phases()?;

    let count: usize = job.shape.iter().product();
    let widths = quantity.widths(layers);
    let first = out.as_slice_mut()?;
    let other = match &mut second {
        Some(array) => array.as_slice_mut()?,
        None => &mut [],
    };
    if first.len() != count * widths[0] || other.len() != count * widths[1] {
        return Err(Error::value("the output does not have the shape of the result"));
    }
    let short = count <= TASK && count * (layers + 1) <= WORK / 10;
    if let Some(sweep) = job.sweep() {
        return run_sweep(py, &job, &sweep, first, threads, short);
    }
    if short {
        let mut all = Task { start: 0, count, out: [first, other] };
        return Ok(released(py, || job.run(&mut all))?);
    }
    let mut tasks = tasks(count, (WORK / (layers + 1)).clamp(1, TASK), widths, first, other);
    let done: Answer<()> = beside(py, Long::threads(threads), |watch| {
        tasks.par_iter_mut().try_for_each(|task| if watch.is_stopped() { Ok(()) } else { job.run(task) })
    })?;
    Ok(done?)
}

/// The vector kernels. Runs are cut without regard to threads.
fn run_sweep(
    py: Python<'_>,
    job: &Job<'_>,
    sweep: &Sweep<'_>,
    out: &mut [f64],
    threads: Option<usize>,
    short: bool,
) -> Result<()> {
    let whole = "the output does not have the shape of the result";
    let mut tasks = sweep.tasks(out).ok_or_else(|| Error::value(whole))?;
    let done = if short {
        released(py, || tasks.iter_mut().try_for_each(|task| sweep.run(task)))
    } else {
        beside(py, Long::threads(threads), |watch| {
            tasks.par_iter_mut().try_for_each(|task| if watch.is_stopped() { Ok(()) } else { sweep.run(task) })
        })?
    };
    drop(tasks);
    if done.is_err() {
        // Point by point, so that the error tells its place.
        let mut all = Task { start: 0, count: out.len(), out: [out, &mut []] };
        beside(py, Long::threads(Some(1)), |_| job.run(&mut all))??;
    }
    Ok(())
}

/// An argument that broadcasts to `shape`.
fn operand<'a>(values: &'a [f64], strides: Vec<usize>, shape: &[usize]) -> Result<Operand<'a>> {
    let operand = Operand { values, strides };
    if operand.strides.len() != shape.len() || !operand.reaches(shape) {
        return Err(Error::value("an argument does not broadcast to the shape of the result"));
    }
    Ok(operand)
}

fn tasks<'a>(
    count: usize,
    most: usize,
    widths: [usize; 2],
    mut first: &'a mut [f64],
    mut second: &'a mut [f64],
) -> Vec<Task<'a>> {
    let mut tasks = Vec::with_capacity(count.div_ceil(most));
    for start in (0..count).step_by(most) {
        let count = most.min(count - start);
        let (head, tail) = first.split_at_mut(count * widths[0]);
        let (other_head, other_tail) = second.split_at_mut(count * widths[1]);
        tasks.push(Task { start, count, out: [head, other_head] });
        (first, second) = (tail, other_tail);
    }
    tasks
}

impl Job<'_> {
    /// The same by vectors, where they cover it.
    fn sweep(&self) -> Option<Sweep<'_>> {
        let power = match self.quantity {
            Quantity::Reflectance => Power::Reflectance,
            Quantity::Transmittance => Power::Transmittance,
            Quantity::Absorptance => Power::Absorptance,
            _ => return None,
        };
        if self.coherent.contains(&false) {
            return None;
        }
        Sweep::new(SweepRequest {
            power,
            polarization: self.polarization,
            indices: self.indices.clone(),
            shape: self.shape.clone(),
            wavelength_nm: self.operands[0].clone(),
            angle_deg: self.operands[1].clone(),
            thickness_nm: self.operands[2..].to_vec(),
        })
    }

    /// The part of `stack::check` that looks at thickness and wavelength together.
    fn check_phases(&self) -> Answer<()> {
        let shortest = self.operands[0].values.iter().copied().fold(f64::INFINITY, f64::min);
        for (j, layer) in self.operands[2..].iter().enumerate() {
            let thickest = layer.values.iter().copied().fold(0.0, f64::max);
            if thickest / shortest > stack::MOST_WAVES {
                return Err(OpticsError::Argument(format!(
                    "thickness_nm of layer {} must be at most {:e} wavelengths, got {thickest} at {shortest} nm",
                    j + 1,
                    stack::MOST_WAVES
                )));
            }
        }
        Ok(())
    }

    fn run(&self, task: &mut Task<'_>) -> Answer<()> {
        let mut solver = Solver::new();
        let mut scratch = Vec::new();
        let mut thickness_nm = vec![0.0; self.coherent.len()];
        let mut place = self.place(task.start);
        let mut offsets: Vec<usize> = self
            .operands
            .iter()
            .map(|operand| operand.strides.iter().zip(&place).map(|(stride, index)| stride * index).sum())
            .collect();
        let mut incidence: Option<(f64, Incidence)> = None;
        let mut indices = vec![Complex64::default(); self.indices.len()];
        let mut indices_at = usize::MAX;
        for element in 0..task.count {
            let angle_deg = self.operands[1].values[offsets[1]];
            let incidence = match incidence {
                Some((angle, incidence)) if angle == angle_deg => incidence,
                _ => {
                    let new = Incidence::from_degrees(angle_deg)?;
                    incidence = Some((angle_deg, new));
                    new
                }
            };
            for (j, thickness) in thickness_nm.iter_mut().enumerate() {
                *thickness = self.operands[j + 2].values[offsets[j + 2]];
            }
            let wavelength_nm = self.operands[0].values[offsets[0]];
            if indices_at != offsets[0] {
                indices_at = offsets[0];
                self.look_up(indices_at, &mut indices)?;
            }
            let point = Point { indices: &indices, thickness_nm: &thickness_nm, wavelength_nm, incidence };
            self.evaluate(&mut solver, &mut scratch, &point, element, task)
                .map_err(|error| OpticsError::Argument(format!("{error}{}", self.named_place(task.start + element))))?;
            self.step(&mut place, &mut offsets);
        }
        Ok(())
    }

    /// The indices of all media at one wavelength, checked.
    fn look_up(&self, at: usize, indices: &mut [Complex64]) -> Answer<()> {
        for (index, table) in indices.iter_mut().zip(&self.indices) {
            *index = if table.len() == 1 { table[0] } else { table[at] };
        }
        stack::check_indices(indices, &self.coherent).map_err(|error| {
            OpticsError::Argument(format!("{error} (at wavelength_nm = {})", self.operands[0].values[at]))
        })
    }

    fn evaluate(
        &self,
        solver: &mut Solver,
        scratch: &mut Vec<f64>,
        point: &Point<'_>,
        element: usize,
        task: &mut Task<'_>,
    ) -> Answer<()> {
        let [first, second] = &mut task.out;
        if self.quantity == Quantity::TwoBeam {
            first[element] = point.two_beam()?;
            return Ok(());
        }
        let Point { indices, thickness_nm, wavelength_nm, incidence } = *point;
        solver.prepare(indices, thickness_nm, &self.coherent, wavelength_nm, incidence);
        match self.quantity {
            Quantity::Reflectance => first[element] = solver.powers(self.polarization)?.reflectance,
            Quantity::Transmittance => first[element] = solver.powers(self.polarization)?.transmittance,
            Quantity::Absorptance => first[element] = solver.absorptance(self.polarization, scratch)?,
            Quantity::LayerAbsorptance => {
                let layers = self.coherent.len();
                let row = &mut first[element * layers..(element + 1) * layers];
                solver.powers_and_layers(self.polarization, row)?;
            }
            Quantity::Amplitudes => {
                let amplitudes = solver.amplitudes(self.polarization)?;
                first[2 * element..][..2].copy_from_slice(&[amplitudes.r.re, amplitudes.r.im]);
                second[2 * element..][..2].copy_from_slice(&[amplitudes.t.re, amplitudes.t.im]);
            }
            _ => {
                let r_s = solver.amplitudes(Polarization::S)?.r;
                let r_p = solver.amplitudes(Polarization::P)?.r;
                (first[element], second[element]) = stack::ellipsometry(r_s, r_p).ok_or_else(|| {
                    OpticsError::Argument("psi and delta have no value where nothing is reflected".into())
                })?;
            }
        }
        Ok(())
    }

    /// Indices along the axes of the result.
    fn place(&self, mut element: usize) -> Vec<usize> {
        let mut place = vec![0; self.shape.len()];
        for (index, &length) in place.iter_mut().zip(&self.shape).rev() {
            *index = element % length;
            element /= length;
        }
        place
    }

    fn named_place(&self, element: usize) -> String {
        match self.place(element).as_slice() {
            [] => String::new(),
            [index] => format!(" (at index ({index},))"),
            place => {
                let indices: Vec<String> = place.iter().map(usize::to_string).collect();
                format!(" (at index ({}))", indices.join(", "))
            }
        }
    }

    /// On to the next element in C order.
    fn step(&self, place: &mut [usize], offsets: &mut [usize]) {
        for axis in (0..place.len()).rev() {
            place[axis] += 1;
            if place[axis] < self.shape[axis] {
                for (offset, operand) in offsets.iter_mut().zip(&self.operands) {
                    *offset += operand.strides[axis];
                }
                return;
            }
            place[axis] = 0;
            for (offset, operand) in offsets.iter_mut().zip(&self.operands) {
                *offset -= operand.strides[axis] * (self.shape[axis] - 1);
            }
        }
    }
}

/// The arguments of one element.
#[derive(Clone, Copy)]
struct Point<'a> {
    indices: &'a [Complex64],
    thickness_nm: &'a [f64],
    wavelength_nm: f64,
    incidence: Incidence,
}

impl Point<'_> {
    fn two_beam(&self) -> Answer<f64> {
        let [n1, n2, n3] = self.indices else {
            return Err(OpticsError::Argument("the two-beam form takes exactly one layer".into()));
        };
        let n = real_indices([*n1, *n2, *n3])?;
        film::two_beam_reflectance(n, self.thickness_nm[0], self.wavelength_nm, self.incidence.cos_theta())
    }
}

fn real_indices(n: [Complex64; 3]) -> Answer<[f64; 3]> {
    match n.iter().find(|n| n.im != 0.0) {
        Some(n) => Err(OpticsError::Argument(format!("the two-beam form takes real indices, got {n}"))),
        None => Ok(n.map(|n| n.re)),
    }
}
