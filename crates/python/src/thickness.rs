//! Bindings of the thickness stage.

use std::path::PathBuf;
use std::sync::Arc;

use iridesce::files::{FileError, MapChoice, read_thickness_map, thickness_exr};
use iridesce::thickness::{ThicknessError, ThicknessMap as InnerMap, ThicknessModel};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{Error, Result};
use crate::files::{PyReport, plain};
use crate::interrupt::{Long, beside, fill};

/// A thickness model.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Thickness {
    inner: ThicknessModel,
}

#[pymethods]
impl Thickness {
    #[staticmethod]
    fn uniform(thickness_nm: f64) -> Result<Thickness> {
        Ok(Thickness { inner: ThicknessModel::uniform(thickness_nm)? })
    }

    #[staticmethod]
    fn gradient(top: f64, bottom: f64, exponent: f64) -> Result<Thickness> {
        Ok(Thickness { inner: ThicknessModel::gradient(top, bottom, exponent)? })
    }

    #[staticmethod]
    fn wedge(from_point: [f64; 3], to_point: [f64; 3], start_nm: f64, end_nm: f64) -> Result<Thickness> {
        // `from` is a word of Python's own.
        let renamed = |e: ThicknessError| match e.argument.as_ref() {
            "from" => ThicknessError { argument: "from_point".into(), ..e },
            "to" => ThicknessError { argument: "to_point".into(), ..e },
            _ => e,
        };
        let model = ThicknessModel::wedge(from_point, to_point, start_nm, end_nm).map_err(renamed);
        Ok(Thickness { inner: model? })
    }

    #[staticmethod]
    fn lens_gap(radius_mm: f64, contact_gap_nm: f64) -> Result<Thickness> {
        Ok(Thickness { inner: ThicknessModel::lens_gap(radius_mm, contact_gap_nm)? })
    }

    fn at_height<'py>(&self, py: Python<'py>, s: PyReadonlyArray1<'py, f64>) -> Result<Bound<'py, PyArray1<f64>>> {
        let s = s.as_slice()?;
        match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => filled(py, s.len(), |_| *thickness_nm),
            ThicknessModel::Gradient(gradient) => filled(py, s.len(), |place| gradient.at_height(s[place])),
            _ => Err(does_not_follow("height")),
        }
    }

    fn at_point<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> Result<Bound<'py, PyArray1<f64>>> {
        let (points, rest) = points.as_slice()?.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(Error::value("points must have three coordinates"));
        }
        match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => filled(py, points.len(), |_| *thickness_nm),
            ThicknessModel::Wedge(wedge) => filled(py, points.len(), |place| wedge.at_point(points[place])),
            _ => Err(does_not_follow("points")),
        }
    }

    fn at_radius<'py>(
        &self,
        py: Python<'py>,
        distance_mm: PyReadonlyArray1<'py, f64>,
    ) -> Result<Bound<'py, PyArray1<f64>>> {
        let distances = distance_mm.as_slice()?;
        match &self.inner {
            ThicknessModel::Uniform { thickness_nm } => filled(py, distances.len(), |_| *thickness_nm),
            ThicknessModel::LensGap(gap) => filled(py, distances.len(), |place| gap.at_radius(distances[place])),
            _ => Err(does_not_follow("a distance")),
        }
    }

    fn map<'py>(
        &self,
        py: Python<'py>,
        width: usize,
        height: usize,
        extent: Option<[f64; 4]>,
    ) -> Result<Bound<'py, PyArray2<f64>>> {
        map_array(py, beside(py, Long::default(), |_| self.inner.map(width, height, extent))??)
    }
}

/// A function of so many places.
fn filled<'py>(
    py: Python<'py>,
    count: usize,
    function: impl Fn(usize) -> f64 + Sync,
) -> Result<Bound<'py, PyArray1<f64>>> {
    let made = PyArray1::zeros(py, count, false);
    fill(py, made.readwrite().as_slice_mut()?, |place| Ok::<_, Error>(function(place)))?;
    Ok(made)
}

/// The Python side asks only what a model can answer.
fn does_not_follow(what: &str) -> Error {
    Error::value(format!("this model does not follow {what}"))
}

fn map_array(py: Python<'_>, map: InnerMap) -> Result<Bound<'_, PyArray2<f64>>> {
    let shape = [map.height(), map.width()];
    Ok(map.into_thickness_nm().into_pyarray(py).reshape(shape)?)
}

/// A grid of thicknesses.
#[pyclass(frozen, module = "iridesce._core")]
pub struct ThicknessMap {
    pub(crate) inner: InnerMap,
}

#[pymethods]
impl ThicknessMap {
    #[new]
    fn new(thickness_nm: PyReadonlyArray2<'_, f64>) -> Result<ThicknessMap> {
        let [height, width] = [thickness_nm.shape()[0], thickness_nm.shape()[1]];
        let values = thickness_nm.as_slice()?.to_vec();
        Ok(ThicknessMap { inner: InnerMap::new(width, height, values)? })
    }

    fn sample<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray1<'py, f64>,
        v: PyReadonlyArray1<'py, f64>,
    ) -> Result<Bound<'py, PyArray1<f64>>> {
        let (u, v) = (u.as_slice()?, v.as_slice()?);
        filled(py, u.len().min(v.len()), |place| self.inner.sample(u[place], v[place]))
    }

    /// The map as the bytes of an OpenEXR file.
    fn exr_bytes<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>> {
        let bytes = beside(py, Long::default(), |_| thickness_exr(&self.inner))?.map_err(Error::value)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// The map in a file.
#[pyfunction]
fn load_thickness_map<'py>(
    py: Python<'py>,
    path: PathBuf,
    min_nm: Option<f64>,
    max_nm: Option<f64>,
    channel: Option<&str>,
    page: Option<usize>,
) -> Result<(Bound<'py, PyArray2<f64>>, PyReport)> {
    let choice = MapChoice { channel, page };
    let read = beside(py, Long::default(), |watch| read_thickness_map(&path, min_nm, max_nm, &choice, watch))?;
    let (map, report) = read.map_err(|e| match e {
        FileError::Argument(why) => Error::value(format!("{:?} {why}", path.display().to_string())),
        _ => e.into(),
    })?;
    Ok((map_array(py, Arc::unwrap_or_clone(map))?, plain(report)))
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Thickness>()?;
    module.add_class::<ThicknessMap>()?;
    module.add_function(wrap_pyfunction!(load_thickness_map, module)?)
}
