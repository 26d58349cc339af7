//! Bindings of the medium stage.

use std::sync::atomic::{AtomicBool, Ordering};

use iridesce::files::read_medium;
use iridesce::numerics::index_place;
use iridesce::optics::{Beyond, Complex64, Medium as Inner, OpticsError, medium};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::files::{PyReport, plain};
use crate::interrupt::{Long, beside, fill};

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
    fn constant(n: f64, k: f64) -> Result<Medium> {
        wrap(Inner::constant(Complex64::new(n, k)))
    }

    /// A built-in medium.
    #[staticmethod]
    fn named(name: &str) -> Result<Medium> {
        wrap(Inner::named(name))
    }

    /// A page of refractiveindex.info (YAML) or a table, told apart by content and label: the medium, the text of the file, and
    /// how it was understood.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8], label: &str) -> Result<(Medium, String, PyReport)> {
        let read = beside(py, Long::threads(Some(1)), |_| read_medium(bytes, label))?;
        let (inner, text, report) = read.map_err(Error::value)?;
        Ok((Medium { inner }, text, plain(report)))
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
    ) -> Result<Medium> {
        let rule = medium::Rule::named(rule)?;
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
    ) -> Result<Bound<'py, PyArray1<Complex64>>> {
        let beyond = if hold { Beyond::Hold } else { Beyond::Refuse };
        let values = wavelength_nm.as_slice()?;
        let indices = PyArray1::zeros(py, values.len(), false);
        fill(py, indices.readwrite().as_slice_mut()?, |flat| {
            // The place is spelt out only for the one wavelength that is refused.
            let nm = values[flat];
            self.inner.index(nm, beyond).or_else(|_| self.inner.index_at(nm, beyond, &index_place(flat, &shape)))
        })?;
        Ok(indices)
    }

    /// Complex index at each wavelength as colour sums take it, and whether a stated extension was used.
    fn index_extended<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray1<'py, f64>,
    ) -> Result<(Bound<'py, PyArray1<Complex64>>, bool)> {
        let values = wavelength_nm.as_slice()?;
        let indices = PyArray1::zeros(py, values.len(), false);
        let extended = AtomicBool::new(false);
        fill(py, indices.readwrite().as_slice_mut()?, |flat| {
            let (index, beyond) = self.inner.index_extended(values[flat])?;
            if beyond {
                extended.store(true, Ordering::Relaxed);
            }
            Ok::<_, OpticsError>(index)
        })?;
        Ok((indices, extended.into_inner()))
    }
}

fn wrap(made: std::result::Result<Inner, OpticsError>) -> Result<Medium> {
    Ok(Medium { inner: made? })
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
