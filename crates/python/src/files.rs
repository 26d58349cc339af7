//! Bindings of the readers: bytes in, numbers and a report out.

use std::path::PathBuf;

use iridesce::files::{self, MapChoice, ReadReport, SpectrumChoice};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// Format; role, name, unit and reason of what was taken; what was left out; notes.
pub type PyReport = (String, Vec<(String, String, String, String)>, Vec<String>, Vec<String>);

/// A report as plain values; `iridesce.files.report` makes an object of it.
pub fn plain(report: ReadReport) -> PyReport {
    let taken = report.taken.into_iter().map(|taken| (taken.role, taken.name, taken.unit, taken.why)).collect();
    (report.format, taken, report.dropped, report.notes)
}

/// All bytes of an ordinary file of at most `limit`; `ValueError` says why there are none.
#[pyfunction]
fn read_file(py: Python<'_>, path: PathBuf, limit: u64) -> Result<Bound<'_, PyBytes>> {
    let bytes = beside(py, Long::threads(Some(1)), |watch| files::read_whole_watched(&path, limit, watch))?;
    Ok(PyBytes::new(py, &bytes.map_err(Error::value)?))
}

/// Wavelengths in nm, values, the name of their column, and the report.
type PySpectrum<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, String, PyReport);

/// The spectrum in the bytes of a file.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries everything that a user decides")]
fn read_spectrum<'py>(
    py: Python<'py>,
    bytes: &[u8],
    column: Option<&str>,
    wavelength_column: Option<&str>,
    unit: Option<&str>,
    unit_y: Option<&str>,
    quantity: &str,
    range_nm: Option<(f64, f64)>,
) -> Result<PySpectrum<'py>> {
    let choice = SpectrumChoice { column, wavelength_column, unit, unit_y, quantity, range_nm };
    let spectrum =
        beside(py, Long::threads(Some(1)), |_| files::read_spectrum(bytes, &choice))?.map_err(Error::value)?;
    let (nm, values) = (spectrum.wavelength_nm.into_pyarray(py), spectrum.values.into_pyarray(py));
    Ok((nm, values, spectrum.column, plain(spectrum.report)))
}

/// Why the bytes of a PNG or OpenEXR file are no whole picture of that size; None where they are one.
#[pyfunction]
fn picture_fault(bytes: &[u8], width: u32, height: u32) -> Option<String> {
    files::check_picture(bytes, width, height).err()
}

/// Linear light (height, width, 3), which pixels are clipped (height, width), and the report.
type PyPhotograph<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<bool>>, PyReport);

/// The photograph in a file.
#[pyfunction]
fn read_photograph<'py>(
    py: Python<'py>,
    path: PathBuf,
    channel: Option<&str>,
    page: Option<usize>,
) -> Result<PyPhotograph<'py>> {
    let choice = MapChoice { channel, page };
    let read = beside(py, Long::threads(Some(1)), |watch| {
        files::read_whole_watched(&path, files::MAX_PHOTOGRAPH_BYTES, watch)
            .and_then(|bytes| files::read_photograph(&bytes, &choice, watch))
    })?;
    let photograph = read.map_err(|why| Error::value(format!("{}: {why}", path.display())))?;
    let shape = [photograph.height, photograph.width];
    let rgb = photograph.rgb.into_pyarray(py).reshape([shape[0], shape[1], 3])?;
    Ok((rgb, photograph.clipped.into_pyarray(py).reshape(shape)?, plain(photograph.report)))
}

/// Columns and rows that a picture's header declares, None where only the whole file tells.
#[pyfunction]
fn photograph_size(py: Python<'_>, path: PathBuf) -> Option<(u64, u64)> {
    released(py, || files::photograph_size(&path))
}

/// Linear Rec.709 (height, width, 3) of the environment map in a file, and the report.
#[pyfunction]
fn read_environment<'py>(
    py: Python<'py>,
    path: PathBuf,
    layer: Option<&str>,
) -> Result<(Bound<'py, PyArray3<f32>>, PyReport)> {
    let read = beside(py, Long::threads(Some(1)), |watch| {
        files::read_whole_watched(&path, files::MAX_ENVIRONMENT_BYTES, watch)
            .and_then(|bytes| files::read_environment(&bytes, layer, watch))
    })?;
    let (map, report) = read.map_err(|why| Error::value(format!("{}: {why}", path.display())))?;
    Ok((map.rgb.into_pyarray(py).reshape([map.height, map.width, 3])?, plain(report)))
}

/// A message without control characters, cut at 200 of them.
#[pyfunction]
fn harmless(message: &str) -> String {
    files::harmless(message)
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MAX_SPECTRUM_BYTES", files::MAX_SPECTRUM_BYTES)?;
    module.add("MAX_LAMP_BYTES", files::MAX_LAMP_BYTES)?;
    module.add_function(wrap_pyfunction!(read_file, module)?)?;
    module.add_function(wrap_pyfunction!(read_spectrum, module)?)?;
    module.add_function(wrap_pyfunction!(picture_fault, module)?)?;
    module.add_function(wrap_pyfunction!(read_photograph, module)?)?;
    module.add_function(wrap_pyfunction!(photograph_size, module)?)?;
    module.add_function(wrap_pyfunction!(read_environment, module)?)?;
    module.add_function(wrap_pyfunction!(harmless, module)?)
}
