//! Bindings of the stack stage: one call evaluates a stack over broadcast arrays.

use iridesce::optics::stack::sweep::{Operand, Quantity, Sweep, SweepRequest};
use iridesce::optics::{Complex64, OpticsError, Polarization};
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// Elements, and layers over all of them, of a call that is done on the spot: a tenth of what goes between two looks for
/// Ctrl-C.
const SHORT: usize = 512;
const SHORT_WORK: usize = (1 << 18) / 10;

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_evaluate, module)?)
}

/// Evaluates a stack. `indices` holds for each different medium its index at every wavelength, or a single one that holds at
/// all of them; `media` says which of these each medium of the stack has. Each of `arguments` (wavelength, angle, then the
/// thickness of each layer) comes as flat values with its strides along the axes of `shape`. Results are written into `out`
/// and, where there are two, `second`.
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
    let tables = indices.iter().map(|table| Ok(table.as_slice()?)).collect::<Result<Vec<_>>>()?;
    let mut operands = arguments
        .iter()
        .map(|(values, strides)| Ok(Operand { values: values.as_slice()?, strides: strides.clone() }))
        .collect::<Result<Vec<_>>>()?;
    let thickness_nm = operands.split_off(2);
    let [wavelength_nm, angle_deg] = <[_; 2]>::try_from(operands).expect("two are left");
    let count: usize = shape.iter().product();
    let sweep = Sweep::new(SweepRequest {
        quantity,
        polarization,
        indices: media.iter().map(|&which| tables[which]).collect(),
        coherent,
        shape,
        wavelength_nm,
        angle_deg,
        thickness_nm,
    })?;
    let second = match &mut second {
        Some(array) => array.as_slice_mut()?,
        None => &mut [],
    };
    let mut tasks = sweep.tasks(out.as_slice_mut()?, second)?;
    if count <= SHORT && count * (layers + 1) <= SHORT_WORK {
        return Ok(released(py, || tasks.iter_mut().try_for_each(|task| sweep.run(task)))?);
    }
    // Runs are cut without regard to threads; of several errors the first in the array is told.
    let done = beside(py, Long::threads(threads), |watch| {
        let run = |task: &mut _| if watch.is_stopped() { Ok(()) } else { sweep.run(task) };
        tasks.par_iter_mut().map(run).find_first(std::result::Result::is_err).unwrap_or(Ok::<(), OpticsError>(()))
    })?;
    Ok(done?)
}
