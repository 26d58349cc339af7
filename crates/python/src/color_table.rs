//! Bindings of colour tables.

use std::path::PathBuf;

use iridesce::optics::color::{
    self, Adaptation, ColorRequest, ColorTableRequest, ColorTableShape, Model, Observer, Quantity, Space, gamut,
};
use iridesce::optics::{OpticsError, Polarization};
use iridesce::render::Progress;
use iridesce::render::image::{self, Fact, Table};
use numpy::{PyReadonlyArray1, PyReadwriteArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::color::Illuminant;
use crate::medium::Medium;
use crate::render::{PyFact, beside, facts, image_error};

/// Points between two looks for Ctrl-C: some 30 ms.
const POINTS_PER_LOOK: usize = 1 << 20;
/// Points a task where colours are converted.
const CHUNK: usize = 4096;
/// What the planes of a file are called, in the order of a node's numbers (the fourth and the last are no more than padding).
const PLANES: [(&str, usize); 6] =
    [("XYZ.X", 0), ("XYZ.Y", 1), ("XYZ.Z", 2), ("slope.X", 4), ("slope.Y", 5), ("slope.Z", 6)];
const KIND: &str = "iridesce colour table 1";

/// A table read from a file, and the words that were saved with it.
type ReadTable = (ColorTable, Vec<(String, String)>);
/// A table to be saved, the name of its part of the file, and the facts to save with it.
type SavedTable<'py> = (PyRef<'py, ColorTable>, String, Vec<(String, PyFact)>);

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<ColorTable>()?;
    module.add_function(wrap_pyfunction!(color_tables_read, module)?)?;
    module.add_function(wrap_pyfunction!(color_tables_save, module)?)
}

fn value_error(error: OpticsError) -> PyErr {
    PyValueError::new_err(error.to_string())
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
    ) -> PyResult<(ColorTable, Vec<String>)> {
        let color = ColorRequest {
            media: media.iter().map(|medium| medium.inner.clone()).collect(),
            coherent,
            illuminant: illuminant.inner.clone(),
            observer: Observer::named(observer).map_err(value_error)?,
            polarization: Polarization::named(polarization).map_err(value_error)?,
            quantity: Quantity::named(quantity).map_err(value_error)?,
            model: Model::Exact,
            grid: None,
            space: Space::Xyz,
            adaptation: Adaptation::None,
            gamut: None,
        };
        let request = ColorTableRequest { color, thickness_nm, layer, range_nm, range_deg, tolerance: max_delta_e };
        let built = beside(py, progress, |shared| {
            color::ColorTable::build(request, &|done, total| {
                shared.advance(done, total);
                shared.cancelled()
            })
        })?;
        let inner = built.map_err(value_error)?;
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
    ) -> PyResult<()> {
        let space = Space::named(space).map_err(value_error)?;
        let adaptation = Adaptation::named(adaptation).map_err(value_error)?;
        let mapping = gamut.map(gamut::Mapping::named).transpose().map_err(value_error)?;
        let gamut = mapping.and_then(|mapping| gamut::Gamut::new(space, mapping));
        if mapping.is_some() && gamut.is_none() {
            return Err(PyValueError::new_err(format!("gamut= needs an RGB space, got space={:?}", space.name())));
        }
        let (thickness, angle) = (thickness_nm.as_slice()?, angle_deg.as_slice()?);
        let (rows, _) = out.as_slice_mut()?.as_chunks_mut::<3>();
        if rows.len() != thickness.len() || (angle.len() != 1 && angle.len() != thickness.len()) {
            return Err(PyValueError::new_err("thicknesses, angles and colours do not belong together"));
        }
        let pool = match threads {
            None => None,
            Some(threads) => Some(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .map_err(|error| PyValueError::new_err(format!("threads={threads}: {error}")))?,
            ),
        };
        let white = self.inner.shape().white;
        for (group, rows) in rows.chunks_mut(POINTS_PER_LOOK).enumerate() {
            let start = group * POINTS_PER_LOOK;
            let thickness = &thickness[start..start + rows.len()];
            let angle = if angle.len() == 1 { angle } else { &angle[start..start + rows.len()] };
            let mut work = || -> Result<(), OpticsError> {
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
                Ok(())
            };
            py.detach(|| match &pool {
                Some(pool) => pool.install(work),
                None => work(),
            })
            .map_err(value_error)?;
            py.check_signals()?;
        }
        Ok(())
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
fn color_tables_read(py: Python<'_>, bytes: &[u8]) -> PyResult<Vec<ReadTable>> {
    let tables = py.detach(|| image::read_tables(bytes)).map_err(image_error)?;
    tables.into_iter().map(read_one).collect()
}

fn read_one(table: Table) -> PyResult<ReadTable> {
    let fact = |name: &str| table.facts.iter().find(|(known, _)| known == name).map(|(_, fact)| fact);
    if fact("kind") != Some(&Fact::Text(KIND.into())) {
        return Err(PyValueError::new_err(format!("it is no colour table: its attribute \"kind\" is not {KIND:?}")));
    }
    let number = |name: &str| match fact(name) {
        Some(Fact::Number(value)) => Ok(*value),
        _ => Err(PyValueError::new_err(format!("the colour table lacks the number {name:?}"))),
    };
    let shape = ColorTableShape {
        rows: table.height,
        columns: table.width,
        range_nm: [number("thickness_nm_from")?, number("thickness_nm_to")?],
        range_deg: [number("angle_deg_from")?, number("angle_deg_to")?],
        inverse_square: number("inverse_square")?,
        white: [number("white_x")?, 1.0, number("white_z")?],
        max_delta_e: number("max_delta_e")?,
        mean_delta_e: number("mean_delta_e")?,
        probes: number("probes")? as usize,
    };
    let mut nodes = vec![[0.0; 8]; table.width * table.height];
    for (name, place) in PLANES {
        let plane = table.planes.iter().find(|(known, _)| known == name);
        let (_, values) =
            plane.ok_or_else(|| PyValueError::new_err(format!("the colour table lacks the channel {name:?}")))?;
        nodes.iter_mut().zip(values).for_each(|(node, value)| node[place] = *value);
    }
    let inner = color::ColorTable::from_nodes(shape, nodes).map_err(value_error)?;
    let words = table.facts.into_iter().filter_map(|(name, fact)| match fact {
        Fact::Text(text) => Some((name, text)),
        _ => None,
    });
    Ok((ColorTable { inner }, words.collect()))
}

/// Writes tables into one EXR file, a part each, with their names and facts.
#[pyfunction]
fn color_tables_save(py: Python<'_>, path: PathBuf, tables: Vec<SavedTable<'_>>) -> PyResult<()> {
    let tables: Vec<Table> =
        tables.into_iter().map(|(table, name, words)| part(&table.inner, name, facts(words))).collect();
    beside(py, None, |shared| image::write_tables(&path, &tables, &|| shared.cancelled()))?.map_err(image_error)
}

fn part(table: &color::ColorTable, name: String, mut facts: Vec<(String, Fact)>) -> Table {
    let (shape, nodes) = (table.shape(), table.nodes());
    let mut planes: Vec<(String, Vec<f32>)> = PLANES
        .iter()
        .map(|(name, place)| ((*name).to_owned(), nodes.iter().map(|node| node[*place]).collect()))
        .collect();
    // Linear Rec.709, so that every viewer shows the colours.
    if let Some(rgb_from_xyz) = Space::LinearSrgb.rgb_from_xyz() {
        for (name, row) in ["R", "G", "B"].into_iter().zip(rgb_from_xyz) {
            let dot = |node: &[f32; 8]| (0..3).map(|i| row[i] * f64::from(node[i])).sum::<f64>() as f32;
            planes.push((name.to_owned(), nodes.iter().map(dot).collect()));
        }
    }
    facts.push(("kind".to_owned(), Fact::Text(KIND.into())));
    for (name, value) in [
        ("thickness_nm_from", shape.range_nm[0]),
        ("thickness_nm_to", shape.range_nm[1]),
        ("angle_deg_from", shape.range_deg[0]),
        ("angle_deg_to", shape.range_deg[1]),
        ("inverse_square", shape.inverse_square),
        ("white_x", shape.white[0]),
        ("white_z", shape.white[2]),
        ("max_delta_e", shape.max_delta_e),
        ("mean_delta_e", shape.mean_delta_e),
        ("probes", shape.probes as f64),
    ] {
        facts.push((name.to_owned(), Fact::Number(value)));
    }
    Table { name, width: shape.columns, height: shape.rows, planes, facts }
}
