//! Bindings of the thickness stage.

use std::path::PathBuf;
use std::sync::Arc;

use iridesce::files::{read_thickness_map, thickness_exr};
use iridesce::thickness::{ThicknessError, ThicknessMap as InnerMap, ThicknessModel};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

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

    #[staticmethod]
    fn wedge(from_point: [f64; 3], to_point: [f64; 3], start_nm: f64, end_nm: f64) -> PyResult<Thickness> {
        // `from` is a word of Python's own.
        let renamed = |e: ThicknessError| match e.key {
            "from" => ThicknessError { key: "from_point", ..e },
            "to" => ThicknessError { key: "to_point", ..e },
            _ => e,
        };
        let model = ThicknessModel::wedge(from_point, to_point, start_nm, end_nm).map_err(renamed);
        wrap(model).map(|inner| Thickness { inner })
    }

    #[staticmethod]
    fn lens_gap(radius_mm: f64, contact_gap_nm: f64) -> PyResult<Thickness> {
        wrap(ThicknessModel::lens_gap(radius_mm, contact_gap_nm)).map(|inner| Thickness { inner })
    }

    fn at_height<'py>(&self, py: Python<'py>, s: PyReadonlyArray1<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let s = s.as_slice()?;
        let values: Vec<f64> = match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => vec![*thickness_nm; s.len()],
            ThicknessModel::Gradient(gradient) => s.iter().map(|&s| gradient.at_height(s)).collect(),
            _ => return Err(does_not_follow("height")),
        };
        Ok(values.into_pyarray(py))
    }

    fn at_point<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (points, rest) = points.as_slice()?.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(PyValueError::new_err("points must have three coordinates"));
        }
        let values: Vec<f64> = match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => vec![*thickness_nm; points.len()],
            ThicknessModel::Wedge(wedge) => points.iter().map(|&point| wedge.at_point(point)).collect(),
            _ => return Err(does_not_follow("points")),
        };
        Ok(values.into_pyarray(py))
    }

    fn at_radius<'py>(
        &self,
        py: Python<'py>,
        distance_mm: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let distances = distance_mm.as_slice()?;
        let values: Vec<f64> = match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => vec![*thickness_nm; distances.len()],
            ThicknessModel::LensGap(gap) => distances.iter().map(|&r| gap.at_radius(r)).collect(),
            _ => return Err(does_not_follow("a distance")),
        };
        Ok(values.into_pyarray(py))
    }

    fn map<'py>(
        &self,
        py: Python<'py>,
        width: usize,
        height: usize,
        extent: Option<[f64; 4]>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        map_array(py, wrap(py.detach(|| self.inner.map(width, height, extent)))?)
    }
}

/// The Python side asks only what a model can answer.
fn does_not_follow(what: &str) -> PyErr {
    PyValueError::new_err(format!("this model does not follow {what}"))
}

fn map_array(py: Python<'_>, map: InnerMap) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = [map.height(), map.width()];
    map.into_thickness_nm().into_pyarray(py).reshape(shape)
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

    /// The map as the bytes of an OpenEXR file.
    fn exr_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| thickness_exr(&self.inner)).map_err(PyValueError::new_err)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// The map in a file.
#[pyfunction]
fn load_thickness_map(
    py: Python<'_>,
    path: PathBuf,
    min_nm: Option<f64>,
    max_nm: Option<f64>,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let map = py.detach(|| read_thickness_map(&path, min_nm, max_nm)).map_err(|e| match e.key {
        "path" => PyValueError::new_err(format!("{:?} {}", path.display().to_string(), e.message)),
        _ => PyValueError::new_err(e.to_string()),
    })?;
    map_array(py, Arc::unwrap_or_clone(map))
}

fn wrap<T>(made: Result<T, ThicknessError>) -> PyResult<T> {
    made.map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Thickness>()?;
    module.add_class::<ThicknessMap>()?;
    module.add_function(wrap_pyfunction!(load_thickness_map, module)?)
}
