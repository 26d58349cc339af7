//! Bindings of the medium stage.

use iridesce::optics::{Beyond, Complex64, Medium as Inner, OpticsError, medium};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Wavelengths between two looks at whether Ctrl-C was pressed: some milliseconds of the slowest formula.
const CHUNK: usize = 1 << 15;

/// A medium: complex refractive index against vacuum wavelength.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Medium {
    /// The medium itself, for the stages after this one.
    pub inner: Inner,
}

#[pymethods]
impl Medium {
    /// A medium of one index n + ik.
    #[staticmethod]
    fn constant(n: f64, k: f64) -> PyResult<Medium> {
        wrap(Inner::constant(Complex64::new(n, k)))
    }

    /// A built-in medium.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Medium> {
        wrap(Inner::named(name))
    }

    /// A page of refractiveindex.info (YAML) or a CSV table, told apart by content and label.
    #[staticmethod]
    fn from_text(py: Python<'_>, text: &str, label: &str) -> PyResult<Medium> {
        wrap(py.detach(|| Inner::from_text(text, label)))
    }

    /// Two media with their volumes, mixed by a rule.
    #[staticmethod]
    fn mixture(
        first: PyRef<'_, Medium>,
        second: PyRef<'_, Medium>,
        first_volume: f64,
        second_volume: f64,
        rule: &str,
        name: &str,
    ) -> PyResult<Medium> {
        let rule = medium::Rule::named(rule).map_err(value_error)?;
        let parts = ((first.inner.clone(), first_volume), (second.inner.clone(), second_volume));
        wrap(Inner::mixture(parts.0, parts.1, rule, name))
    }

    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    #[getter]
    fn source(&self) -> &str {
        self.inner.source()
    }

    #[getter]
    fn note(&self) -> &str {
        self.inner.note()
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.inner.kind().word()
    }

    #[getter]
    fn range_nm(&self) -> Option<(f64, f64)> {
        self.inner.range_nm()
    }

    #[getter]
    fn extension(&self) -> Option<String> {
        self.inner.extension()
    }

    #[getter]
    fn constant_index(&self) -> Option<(f64, f64)> {
        self.inner.constant_index().map(|index| (index.re, index.im))
    }

    /// Complex index at each wavelength; `shape` is the user's shape, for naming the place of a wrong one.
    fn index<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray1<'py, f64>,
        hold: bool,
        shape: Vec<usize>,
    ) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
        let beyond = if hold { Beyond::Hold } else { Beyond::Refuse };
        let indices = each(py, &wavelength_nm, |flat, nm| {
            // The place is spelt out only for the one wavelength that is refused.
            self.inner.index(nm, beyond).or_else(|_| self.inner.index_at(nm, beyond, &place(flat, &shape)))
        })?;
        Ok(indices.into_pyarray(py))
    }

    /// Complex index at each wavelength as colour sums take it, and whether a stated extension was used.
    fn index_extended<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<(Bound<'py, PyArray1<Complex64>>, bool)> {
        let pairs = each(py, &wavelength_nm, |_, nm| self.inner.index_extended(nm))?;
        let extended = pairs.iter().any(|&(_, extended)| extended);
        Ok((pairs.into_iter().map(|(index, _)| index).collect::<Vec<_>>().into_pyarray(py), extended))
    }
}

/// `function` of every element with its place, without the GIL, looking for Ctrl-C between chunks.
fn each<T: Send>(
    py: Python<'_>,
    values: &PyReadonlyArray1<'_, f64>,
    function: impl Fn(usize, f64) -> Result<T, OpticsError> + Sync,
) -> PyResult<Vec<T>> {
    let mut results = Vec::with_capacity(values.len()?);
    // Copied chunk by chunk: without the GIL another thread may write into the array.
    for (chunk_number, chunk) in values.as_slice()?.chunks(CHUNK).enumerate() {
        let chunk = chunk.to_vec();
        let first = chunk_number * CHUNK;
        let found: Result<Vec<T>, OpticsError> =
            py.detach(|| chunk.into_iter().enumerate().map(|(i, value)| function(first + i, value)).collect());
        results.extend(found.map_err(value_error)?);
        py.check_signals()?;
    }
    Ok(results)
}

/// `at index (3, 7)`, as Python writes it; nothing for a scalar.
fn place(flat: usize, shape: &[usize]) -> String {
    let mut rest = flat;
    let mut indices: Vec<String> = Vec::with_capacity(shape.len());
    for &length in shape.iter().rev() {
        indices.push((rest % length.max(1)).to_string());
        rest /= length.max(1);
    }
    indices.reverse();
    match indices.len() {
        0 => String::new(),
        1 => format!("at index ({},)", indices[0]),
        _ => format!("at index ({})", indices.join(", ")),
    }
}

fn wrap(result: Result<Inner, OpticsError>) -> PyResult<Medium> {
    result.map(|inner| Medium { inner }).map_err(value_error)
}

/// Every error of optics is a `ValueError` in Python.
pub(crate) fn value_error(error: OpticsError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The names of the built-in media.
#[pyfunction]
fn media_names() -> Vec<&'static str> {
    medium::names().to_vec()
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Medium>()?;
    module.add("MEDIUM_TEXT_BYTES", medium::MAX_TEXT_BYTES)?;
    module.add_function(wrap_pyfunction!(media_names, module)?)
}
