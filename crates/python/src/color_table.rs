//! Bindings of colour tables.

use std::path::PathBuf;

use iridesce::files;
use iridesce::numerics::Watch;
use iridesce::optics::color::{
    self, Adaptation, ColorRequest, ColorTableRequest, Model, Observer, Quantity, Space, gamut,
};
use iridesce::optics::{OpticsError, Polarization};
use numpy::{PyReadonlyArray1, PyReadwriteArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;

use crate::color::Illuminant;
use crate::error::{Error, Result};
use crate::image::{PyFact, facts};
use crate::interrupt::{Long, beside};
use crate::medium::Medium;

/// Points between two looks for Ctrl-C: some 30 ms.
const POINTS_PER_LOOK: usize = 1 << 20;
/// Points a task where colours are converted.
const CHUNK: usize = 4096;
/// A table read from a file, and the words that were saved with it.
type ReadTable = (ColorTable, Vec<(String, String)>);
/// A table to be saved, the name of its part of the file, and the facts to save with it.
type SavedTable<'py> = (PyRef<'py, ColorTable>, String, Vec<(String, PyFact)>);

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<ColorTable>()?;
    module.add_function(wrap_pyfunction!(color_tables_read, module)?)?;
    module.add_function(wrap_pyfunction!(color_tables_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(color_tables_save, module)?)
}

/// A table of colours over angle and reduced thickness.
#[pyclass(frozen, module = "iridesce._core")]
pub struct ColorTable {
    inner: color::ColorTable,
}

#[pymethods]
impl ColorTable {
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
    fn build(
        py: Python<'_>,
        media: Vec<PyRef<'_, Medium>>,
        coherent: Vec<bool>,
        thickness_nm: Vec<f64>,
        layer: usize,
        range_nm: [f64; 2],
        range_deg: [f64; 2],
        polarization: &str,
        illuminant: PyRef<'_, Illuminant>,
        observer: &str,
        quantity: &str,
        max_delta_e: f64,
        progress: Option<Py<PyAny>>,
    ) -> Result<(ColorTable, Vec<String>)> {
        let color = ColorRequest {
            media: media.iter().map(|medium| medium.inner.clone()).collect(),
            coherent,
            illuminant: illuminant.inner.clone(),
            observer: Observer::named(observer)?,
            polarization: Polarization::named(polarization)?,
            quantity: Quantity::named(quantity)?,
            model: Model::Exact,
            grid: None,
            space: Space::Xyz,
            adaptation: Adaptation::None,
            gamut: None,
        };
        let request = ColorTableRequest { color, thickness_nm, layer, range_nm, range_deg, tolerance: max_delta_e };
        let inner = beside(py, Long::told(progress), |watch| color::ColorTable::build(request, watch))??;
        let extended = inner.extended().to_vec();
        Ok((ColorTable { inner }, extended))
    }

    #[expect(clippy::too_many_arguments, reason = "one call carries the whole question")]
    /// Colours of points with one thickness and one angle each (or one angle for all), into `out` (points, 3).
    fn evaluate(
        &self,
        py: Python<'_>,
        thickness_nm: PyReadonlyArray1<'_, f64>,
        angle_deg: PyReadonlyArray1<'_, f64>,
        space: &str,
        adaptation: Option<&str>,
        gamut: Option<&str>,
        mut out: PyReadwriteArray2<'_, f64>,
        threads: Option<usize>,
    ) -> Result<()> {
        let space = Space::named(space)?;
        let adaptation = Adaptation::named(adaptation)?;
        let mapping = gamut.map(gamut::Mapping::named).transpose()?;
        let gamut = mapping.and_then(|mapping| gamut::Gamut::new(space, mapping));
        if mapping.is_some() && gamut.is_none() {
            return Err(Error::value(format!("gamut= needs an RGB space, got space={:?}", space.name())));
        }
        let (thickness, angle) = (thickness_nm.as_slice()?, angle_deg.as_slice()?);
        let (rows, _) = out.as_slice_mut()?.as_chunks_mut::<3>();
        if rows.len() != thickness.len() || (angle.len() != 1 && angle.len() != thickness.len()) {
            return Err(Error::value("thicknesses, angles and colours do not belong together"));
        }
        let white = self.inner.shape().white;
        let work = |watch: &Watch| -> std::result::Result<(), OpticsError> {
            for (group, rows) in rows.chunks_mut(POINTS_PER_LOOK).enumerate() {
                if watch.is_stopped() {
                    break;
                }
                let start = group * POINTS_PER_LOOK;
                let thickness = &thickness[start..start + rows.len()];
                let angle = if angle.len() == 1 { angle } else { &angle[start..start + rows.len()] };
                self.inner.evaluate(thickness, angle, rows)?;
                if space != Space::Xyz {
                    rows.par_chunks_mut(CHUNK).for_each(|chunk| {
                        for row in chunk {
                            *row = space.from_xyz(*row, white, adaptation);
                            if let Some(gamut) = &gamut {
                                *row = gamut.map_encoded(space, *row).0;
                            }
                        }
                    });
                }
            }
            Ok(())
        };
        Ok(beside(py, Long::threads(threads), work)??)
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.inner.shape().rows, self.inner.shape().columns)
    }

    #[getter]
    fn range_nm(&self) -> (f64, f64) {
        self.inner.shape().range_nm.into()
    }

    #[getter]
    fn range_deg(&self) -> (f64, f64) {
        self.inner.shape().range_deg.into()
    }

    /// Stated and mean CIEDE2000 against exact sums, and at how many points it was measured.
    #[getter]
    fn delta_e(&self) -> (f64, f64, usize) {
        let shape = self.inner.shape();
        (shape.max_delta_e, shape.mean_delta_e, shape.probes)
    }
}

/// The tables in the bytes of an EXR file, each with the words that were saved with it.
#[pyfunction]
fn color_tables_read(py: Python<'_>, bytes: &[u8]) -> Result<Vec<ReadTable>> {
    let tables = beside(py, Long::default(), |_| files::read_color_tables(bytes))??;
    Ok(tables.into_iter().map(|(inner, words)| (ColorTable { inner }, words)).collect())
}

/// Writes tables into one EXR file, a part each, with their names and facts.
#[pyfunction]
fn color_tables_save(py: Python<'_>, path: PathBuf, tables: Vec<SavedTable<'_>>) -> Result<()> {
    let tables: Vec<_> = tables.into_iter().map(|(table, name, words)| (table, name, facts(words))).collect();
    let tables: Vec<_> = tables.iter().map(|(table, name, facts)| (&table.inner, name.as_str(), &facts[..])).collect();
    Ok(beside(py, Long::default(), |watch| files::write_color_tables(&path, &tables, &|| watch.is_stopped()))??)
}

/// The same file in memory.
#[pyfunction]
fn color_tables_bytes<'py>(py: Python<'py>, tables: Vec<SavedTable<'py>>) -> Result<Bound<'py, PyBytes>> {
    let tables: Vec<_> = tables.into_iter().map(|(table, name, words)| (table, name, facts(words))).collect();
    let tables: Vec<_> = tables.iter().map(|(table, name, facts)| (&table.inner, name.as_str(), &facts[..])).collect();
    let bytes = beside(py, Long::default(), |_| files::color_tables_bytes(&tables))??;
    Ok(PyBytes::new(py, &bytes))
}
