//! Bindings of films that flow.

use std::sync::{Arc, Mutex};

use iridesce::flow::{Film, FilmRun, FlowError, PRESETS, Parameters};
use iridesce::scene::Context;
use iridesce::thickness::{ThicknessError, ThicknessMap, ThicknessModel};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::Result;
use crate::interrupt::{Long, beside, locked};

/// A film in time.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Flow {
    inner: Mutex<Film>,
}

#[pymethods]
impl Flow {
    #[new]
    #[allow(clippy::too_many_arguments)] // the arguments of a Python class
    fn new(
        py: Python<'_>,
        preset: &str,
        columns: Option<usize>,
        seed: u64,
        changes: Vec<(String, f64)>,
        checkpoint: Option<Vec<u8>>,
        initial: Option<PyRef<'_, crate::thickness::ThicknessMap>>,
        sides: Option<&str>,
    ) -> Result<Flow> {
        let mut parameters = parameters(preset, columns, seed, &changes)?;
        if let Some(sides) = sides {
            parameters.set_sides(sides)?;
        }
        let initial = initial.map(|map| map.inner.clone());
        let film = beside(py, Long::default(), |_| -> std::result::Result<Film, FlowError> {
            Ok(match (checkpoint, initial) {
                (Some(bytes), None) => Film::resume(parameters, &bytes)?,
                (Some(bytes), Some(initial)) => Film::resume(parameters.starting_from(&initial), &bytes)?,
                (None, Some(initial)) => Film::starting_from(parameters, &initial)?,
                (None, None) => Film::new(parameters)?,
            })
        })??;
        Ok(Flow { inner: Mutex::new(film) })
    }

    /// Steps until a time; a film that is stopped stands after some whole step.
    fn advance_to(&self, py: Python<'_>, time_s: f64, progress: Option<Py<PyAny>>) -> Result<()> {
        let mut film = locked(py, &self.inner)?;
        let film = &mut *film;
        Ok(beside(py, Long::told(progress), |watch| film.advance_watched(time_s, watch))??)
    }

    fn thickness_nm<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<f64>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let values = beside(py, Long::default(), |_| film.thickness_nm())?;
        let shape = [film.parameters().rows, film.parameters().columns];
        Ok(values.into_pyarray(py).reshape(shape)?)
    }

    /// The thickness over a whole sphere; on a grid of `columns` as it is drawn.
    fn map<'py>(&self, py: Python<'py>, columns: Option<usize>) -> Result<Bound<'py, PyArray2<f64>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let map = beside(py, Long::default(), |_| -> Result<ThicknessMap> {
            let Some(columns) = columns else { return Ok(film.map()?) };
            let field = film.field()?;
            let (width, height) = (field.map().width(), field.map().height());
            let rows = ((height * columns) as f64 / width as f64).round().max(1.0) as usize;
            Ok(ThicknessModel::Flow(Arc::new(field)).map(columns, rows, None)?)
        })??;
        let shape = [map.height(), map.width()];
        Ok(map.into_thickness_nm().into_pyarray(py).reshape(shape)?)
    }

    /// The share of each cell of `map(None)` that is black film; None where no film has turned black yet.
    fn black_share<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyArray2<f64>>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let Some(share) = beside(py, Long::default(), |_| film.black_share())? else { return Ok(None) };
        let columns = film.parameters().columns;
        let rows = share.len() / columns;
        Ok(Some(share.into_pyarray(py).reshape([rows, columns])?))
    }

    /// Time, steps so far, sub-steps and iterations of the last, and where liquid went.
    fn facts<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>> {
        let facts = PyDict::new(py);
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let volume_m3 = beside(py, Long::default(), |_| film.volume())?;
        let (state, (substeps, iterations)) = (film.state(), film.effort());
        let books = state.books;
        for (name, value) in [
            ("time_s", state.time_s),
            ("step", state.step as f64),
            ("substeps", substeps as f64),
            ("iterations", iterations as f64),
            ("volume_m3", volume_m3),
            ("start_m3", books.start),
            ("evaporated_m3", books.evaporated),
            ("swallowed_m3", books.swallowed),
            ("blackened_m3", books.blackened),
            ("drained_m3", books.drained),
        ] {
            facts.set_item(name, value)?;
        }
        facts.set_item("ruptured_s", state.ruptured_s)?;
        Ok(facts)
    }

    /// A row of `history`: time, mean, least, greatest, black share, and the shares of the first volume that went each
    /// way.
    fn summary(&self, py: Python<'_>) -> Result<[f64; 9]> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let s = beside(py, Long::default(), |_| film.summary())?;
        let ways = [s.evaporated, s.swallowed, s.blackened, s.drained];
        let [evaporated, swallowed, blackened, drained] = ways;
        Ok([s.time_s, s.mean_nm, s.min_nm, s.max_nm, s.black_share, evaporated, swallowed, blackened, drained])
    }

    /// Height in m, mean, least and greatest thickness in nm, row by row from the top.
    fn profile<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<f64>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let rows = beside(py, Long::default(), |_| film.profile())?;
        Ok(rows.concat().into_pyarray(py).reshape([rows.len(), 4])?)
    }

    fn checkpoint<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let bytes = beside(py, Long::default(), |_| film.checkpoint())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// What lies beyond the sides of a plane.
    fn sides(&self, py: Python<'_>) -> Result<Option<&'static str>> {
        Ok(locked(py, &self.inner)?.parameters().sides())
    }

    /// Every number by its name; the seed apart.
    fn parameters(&self, py: Python<'_>) -> Result<Vec<(&'static str, f64)>> {
        let listed = locked(py, &self.inner)?.parameters().listed();
        Ok(listed.into_iter().filter(|(name, _)| !["seed", "sides"].contains(name)).collect())
    }
}

fn parameters(
    preset: &str,
    columns: Option<usize>,
    seed: u64,
    changes: &[(String, f64)],
) -> std::result::Result<Parameters, ThicknessError> {
    let mut parameters = Parameters::preset(preset)?;
    if let Some(columns) = columns {
        parameters = parameters.with_columns(columns);
    }
    parameters.seed = seed;
    for (name, value) in changes {
        parameters.set(name, *value)?;
    }
    Ok(parameters)
}

/// Films where they stand, for a model that is asked more than once.
#[pyclass(frozen, module = "iridesce._core")]
pub struct FlowContext {
    inner: Context,
}

#[pymethods]
impl FlowContext {
    #[new]
    fn new() -> FlowContext {
        FlowContext { inner: Context::default() }
    }
}

/// A preset's film at a time on a grid of any size, smooth between its own cells.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the arguments of a Python function
fn flow_map<'py>(
    py: Python<'py>,
    context: PyRef<'py, FlowContext>,
    preset: &str,
    time_s: f64,
    seed: u64,
    columns: Option<usize>,
    width: usize,
    height: usize,
    progress: Option<Py<PyAny>>,
) -> Result<Bound<'py, PyArray2<f64>>> {
    let context = &*context;
    let film = FilmRun::new(preset, seed, columns)?;
    let map = beside(py, Long::told(progress), |watch| -> Result<ThicknessMap> {
        let field = context.inner.film(&film, time_s, watch)?;
        Ok(ThicknessModel::Flow(field).map(width, height, None)?)
    })??;
    Ok(map.into_thickness_nm().into_pyarray(py).reshape([height, width])?)
}

/// Names of the presets.
#[pyfunction]
fn flow_presets() -> Vec<&'static str> {
    PRESETS.to_vec()
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Flow>()?;
    module.add_class::<FlowContext>()?;
    module.add_function(wrap_pyfunction!(flow_map, module)?)?;
    module.add_function(wrap_pyfunction!(flow_presets, module)?)
}
