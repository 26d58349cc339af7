//! Bindings of films that flow.

use std::cell::RefCell;
use std::sync::Mutex;

use iridesce::flow::{Film, FlowError, PRESETS, Parameters, stand, standing, watch_fields};
use iridesce::numerics::Watch;
use iridesce::scene::flow_field;
use iridesce::thickness::{ThicknessError, ThicknessModel};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, locked};

/// A film in time.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Flow {
    inner: Mutex<Film>,
}

#[pymethods]
impl Flow {
    #[new]
    fn new(
        py: Python<'_>,
        preset: &str,
        columns: Option<usize>,
        seed: u64,
        changes: Vec<(String, f64)>,
        checkpoint: Option<Vec<u8>>,
    ) -> Result<Flow> {
        let parameters = parameters(preset, columns, seed, &changes)?;
        let film = beside(py, Long::default(), |_| -> std::result::Result<Film, FlowError> {
            Ok(match checkpoint {
                Some(bytes) => Film::resume(parameters, &bytes)?,
                None => Film::new(parameters)?,
            })
        })??;
        Ok(Flow { inner: Mutex::new(film) })
    }

    /// Steps until a time; a film that is stopped stands after some whole step.
    fn advance_to(&self, py: Python<'_>, time_s: f64) -> Result<()> {
        let mut film = locked(py, &self.inner)?;
        let film = &mut *film;
        Ok(beside(py, Long::default(), |watch| film.advance_while(time_s, |_| !watch.is_stopped()))??)
    }

    fn thickness_nm<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<f64>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let values = beside(py, Long::default(), |_| film.thickness_nm())?;
        let shape = [film.parameters().rows, film.parameters().columns];
        Ok(values.into_pyarray(py).reshape(shape)?)
    }

    /// The thickness over a whole sphere.
    fn map<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray2<f64>>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let map = beside(py, Long::default(), |_| film.map())??;
        let shape = [map.height(), map.width()];
        Ok(map.into_thickness_nm().into_pyarray(py).reshape(shape)?)
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

    fn checkpoint<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>> {
        let film = locked(py, &self.inner)?;
        let film = &*film;
        let bytes = beside(py, Long::default(), |_| film.checkpoint())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Every number by its name; the seed apart.
    fn parameters(&self, py: Python<'_>) -> Result<Vec<(&'static str, f64)>> {
        let listed = locked(py, &self.inner)?.parameters().listed();
        Ok(listed.into_iter().filter(|(name, _)| *name != "seed").collect())
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

/// A preset's film at a time on a grid of any size, smooth between its own cells.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the arguments of a Python function
fn flow_map<'py>(
    py: Python<'py>,
    preset: &str,
    time_s: f64,
    seed: u64,
    columns: Option<usize>,
    width: usize,
    height: usize,
) -> Result<Bound<'py, PyArray2<f64>>> {
    let flowed = reading(py, || flow_field(preset, time_s, seed, columns))?;
    let field = flowed.map_err(|error| interruption().map_or_else(|| error.into(), Error::from))?;
    let map = beside(py, Long::default(), |_| ThicknessModel::Flow(field).map(width, height, None))??;
    Ok(map.into_thickness_nm().into_pyarray(py).reshape([height, width])?)
}

/// What ended the last film that flowed for a scene: an exception of its watcher, or Ctrl-C.
static INTERRUPTION: Mutex<Option<PyErr>> = Mutex::new(None);
/// Called as `watcher(reached_s, asked_s)` while a film flows for a scene.
static WATCHER: Mutex<Option<Py<PyAny>>> = Mutex::new(None);

fn held<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// The exception that stopped a film, if one did; it is handed out once.
pub fn interruption() -> Option<PyErr> {
    held(&INTERRUPTION).take()
}

thread_local! {
    /// The watch over the scene that is read on this thread.
    static READING: RefCell<Option<Watch>> = const { RefCell::new(None) };
}

/// Runs what may let films flow for a scene.
pub fn reading<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> Result<T> {
    beside(py, Long::default(), |watch| {
        READING.set(Some(watch.clone()));
        let made = work();
        READING.set(None);
        made
    })
}

fn goes_on(reached_s: f64, asked_s: f64) -> bool {
    if READING.with_borrow(|watch| watch.as_ref().is_some_and(Watch::is_stopped)) {
        return false;
    }
    let heard = Python::attach(|py| {
        let watcher = held(&WATCHER).as_ref().map(|watcher| watcher.clone_ref(py));
        watcher.map_or(Ok(()), |watcher| watcher.call1(py, (reached_s, asked_s)).map(|_| ()))
    });
    heard.map_err(|error| *held(&INTERRUPTION) = Some(error)).is_ok()
}

/// Has `watcher(reached_s, asked_s)` called at every step of films that flow while a scene is read; None: nobody.
#[pyfunction]
fn flow_watch(watcher: Option<Py<PyAny>>) {
    *held(&WATCHER) = watcher;
}

/// A film that flowed for a scene, where it stands now, to be given to `flow_stand`.
#[pyfunction]
fn flow_standing<'py>(
    py: Python<'py>,
    preset: &str,
    seed: u64,
    columns: Option<usize>,
) -> Result<Option<Bound<'py, PyBytes>>> {
    let bytes = beside(py, Long::default(), |_| standing(preset, seed, columns))??;
    Ok(bytes.map(|bytes| PyBytes::new(py, &bytes)))
}

/// Lets films of scenes go on from where one stood.
#[pyfunction]
fn flow_stand(py: Python<'_>, preset: &str, seed: u64, columns: Option<usize>, bytes: Vec<u8>) -> Result<()> {
    Ok(beside(py, Long::default(), |_| stand(preset, seed, columns, &bytes))??)
}

/// Names of the presets.
#[pyfunction]
fn flow_presets() -> Vec<&'static str> {
    PRESETS.to_vec()
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Flow>()?;
    watch_fields(goes_on);
    module.add_function(wrap_pyfunction!(flow_map, module)?)?;
    module.add_function(wrap_pyfunction!(flow_watch, module)?)?;
    module.add_function(wrap_pyfunction!(flow_standing, module)?)?;
    module.add_function(wrap_pyfunction!(flow_stand, module)?)?;
    module.add_function(wrap_pyfunction!(flow_presets, module)?)
}
