//! Bindings of the thickness stage.

use iridesce::thickness::{ThicknessError, ThicknessMap as InnerMap, ThicknessModel};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
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
        wrap(ThicknessModel::uniform(thickness_nm)).map(|inner| Thickness { inner })
    }

    #[staticmethod]
    fn gradient(top: f64, bottom: f64, exponent: f64) -> PyResult<Thickness> {
        wrap(ThicknessModel::gradient(top, bottom, exponent)).map(|inner| Thickness { inner })
    }

    fn at_height<'py>(&self, py: Python<'py>, s: PyReadonlyArray1<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let heights = s.as_slice()?.iter();
        let values: Vec<f64> = match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => heights.map(|_| *thickness_nm).collect(),
            ThicknessModel::Gradient(gradient) => heights.map(|&s| gradient.at_height(s)).collect(),
            _ => return Err(PyValueError::new_err("this model does not follow height")),
        };
        Ok(values.into_pyarray(py))
    }

    fn map<'py>(&self, py: Python<'py>, width: usize, height: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let map = wrap(py.detach(|| self.inner.map(width, height, None)))?;
        map.into_thickness_nm().into_pyarray(py).reshape([height, width])
    }
}

/// A grid of thicknesses.
#[pyclass(frozen, module = "iridesce._core")]
pub struct ThicknessMap {
    inner: InnerMap,
}

#[pymethods]
impl ThicknessMap {
    #[new]
    fn new(thickness_nm: PyReadonlyArray2<'_, f64>) -> PyResult<ThicknessMap> {
        let [height, width] = [thickness_nm.shape()[0], thickness_nm.shape()[1]];
        let values = thickness_nm.as_slice()?.to_vec();
        wrap(InnerMap::new(width, height, values)).map(|inner| ThicknessMap { inner })
    }

    fn sample<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray1<'py, f64>,
        v: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let pairs = u.as_slice()?.iter().zip(v.as_slice()?);
        let values: Vec<f64> = pairs.map(|(&u, &v)| self.inner.sample(u, v)).collect();
        Ok(values.into_pyarray(py))
    }
}

fn wrap<T>(made: Result<T, ThicknessError>) -> PyResult<T> {
    made.map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Thickness>()?;
    module.add_class::<ThicknessMap>()
}
