//! Bindings of the thickness stage.

use iridesce::thickness::ThicknessModel;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A thickness model.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Thickness {
    inner: ThicknessModel,
}

#[pymethods]
impl Thickness {
    #[staticmethod]
    fn uniform(thickness_nm: f64) -> PyResult<Thickness> {
        wrap(ThicknessModel::uniform(thickness_nm))
    }

    #[staticmethod]
    fn gradient(top: f64, bottom: f64, exponent: f64) -> PyResult<Thickness> {
        wrap(ThicknessModel::gradient(top, bottom, exponent))
    }

    fn at_height<'py>(&self, py: Python<'py>, s: PyReadonlyArray1<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values: Vec<f64> = s.as_slice()?.iter().map(|&s| self.inner.at_height(s)).collect();
        Ok(values.into_pyarray(py))
    }
}

fn wrap(model: Result<ThicknessModel, iridesce::thickness::ThicknessError>) -> PyResult<Thickness> {
    model.map(|inner| Thickness { inner }).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Thickness>()
}
