//! Bindings of partial coherence: averages over lines and thicknesses, Mueller matrices of slabs, slices of graded layers.

use iridesce::numerics::index_place;
use iridesce::optics::coherence::{AverageRequest, Direction, LineShape, MOST_SLABS, averaged, mueller};
use iridesce::optics::color::fringe_parts;
use iridesce::optics::stack::graded;
use iridesce::optics::stack::sweep::Power;
use iridesce::optics::{Complex64, Polarization, film};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::Result;
use crate::interrupt::{Long, beside, fill};
use crate::medium::Medium;
use crate::stacks::Elements;

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_averaged, module)?)?;
    module.add_function(wrap_pyfunction!(stack_mueller, module)?)?;
    module.add_function(wrap_pyfunction!(two_beam_purity, module)?)?;
    module.add_function(wrap_pyfunction!(graded_slices, module)?)?;
    module.add_function(wrap_pyfunction!(color_parts, module)?)?;
    module.add("MOST_SLABS", MOST_SLABS)
}

type Pair<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Values and errors of the averages of some points; `thickness_nm` (points, layers), `lines` of (shape, width in nm).
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_averaged<'py>(
    py: Python<'py>,
    quantity: &str,
    polarization: &str,
    media: Vec<PyRef<'py, Medium>>,
    coherent: Vec<bool>,
    lines: Vec<(String, f64)>,
    thickness_sd_nm: Vec<f64>,
    tolerance: f64,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
) -> Result<Pair<'py>> {
    let media: Vec<_> = media.iter().map(|medium| medium.inner.clone()).collect();
    let named = |(shape, width): &(String, f64)| Ok((LineShape::named(shape)?, *width));
    let lines = lines.iter().map(named).collect::<Result<Vec<_>>>()?;
    let request = AverageRequest {
        power: Power::named(quantity)?,
        polarization: Polarization::named(polarization)?,
        media: &media,
        coherent: &coherent,
        lines: &lines,
        thickness_sd_nm: &thickness_sd_nm,
        tolerance,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
    };
    let found = beside(py, Long::default(), |watch| averaged(&request, watch))??;
    Ok((found.value.into_pyarray(py), found.error.into_pyarray(py)))
}

/// Sixteen numbers an element, by rows.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_mueller<'py>(
    py: Python<'py>,
    direction: &str,
    indices: PyReadonlyArray2<'py, Complex64>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    coherent: Vec<bool>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    mut out: PyReadwriteArray2<'py, f64>,
) -> Result<()> {
    let direction = Direction::named(direction)?;
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let mut nothing = vec![(); elements.wavelength_nm.len()];
    elements.fill(py, [16, 1], out.as_slice_mut()?, &mut nothing, |at, row, _, _| {
        let found = mueller(at.indices, at.thickness_nm, &coherent, at.wavelength_nm, at.incidence, direction)?;
        row.copy_from_slice(found.matrix().as_flattened());
        Ok(())
    })
}

/// Colour purities of the two-beam form: `n` holds three real indices an element of `shape`.
#[pyfunction]
fn two_beam_purity<'py>(
    py: Python<'py>,
    n: PyReadonlyArray2<'py, f64>,
    shape: Vec<usize>,
) -> Result<Bound<'py, PyArray1<f64>>> {
    let (rows, _) = n.as_slice()?.as_chunks::<3>();
    let made = PyArray1::zeros(py, rows.len(), false);
    fill(py, made.readwrite().as_slice_mut()?, |element| {
        film::two_beam_purity(rows[element]).map_err(|error| error.at(&index_place(element, &shape)))
    })?;
    Ok(made)
}

/// How many equal slices a graded layer needs; `index_at` takes the depth as a share of the thickness and gives the index at
/// every wavelength, or one.
#[pyfunction]
fn graded_slices<'py>(
    py: Python<'py>,
    index_at: Bound<'py, PyAny>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    thickness_nm: f64,
    tolerance: f64,
) -> Result<usize> {
    let at = |depth: f64| -> Result<Vec<Complex64>> {
        py.check_signals()?;
        let found: PyReadonlyArray1<'py, Complex64> = index_at.call1((depth,))?.extract()?;
        Ok(found.as_slice()?.to_vec())
    };
    graded::slices(at, wavelength_nm.as_slice()?, thickness_nm, tolerance)
}

/// Into how many parts the colour sum of each point divides its 1 nm steps; `thickness_nm` (points, layers).
#[pyfunction]
fn color_parts<'py>(
    py: Python<'py>,
    media: Vec<PyRef<'py, Medium>>,
    coherent: Vec<bool>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
) -> Result<Vec<usize>> {
    let media: Vec<_> = media.iter().map(|medium| medium.inner.clone()).collect();
    let (thickness_nm, angle_deg) = (thickness_nm.as_slice()?, angle_deg.as_slice()?);
    Ok(beside(py, Long::default(), |_| fringe_parts(&media, &coherent, thickness_nm, angle_deg))??)
}
