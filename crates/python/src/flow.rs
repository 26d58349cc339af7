//! Bindings of films that flow.

use std::sync::Mutex;

use iridesce::flow::{Film, FlowError, PRESETS, Parameters, stand, standing, watch_fields};
use iridesce::scene::flow_field;
use iridesce::thickness::{ThicknessError, ThicknessModel};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

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
    ) -> PyResult<Flow> {
        let parameters = parameters(preset, columns, seed, &changes).map_err(wrong)?;
        let film = py.detach(|| match checkpoint {
            Some(bytes) => Film::resume(parameters, &bytes).map_err(failed),
            None => Film::new(parameters).map_err(wrong),
        })?;
        Ok(Flow { inner: Mutex::new(film) })
    }

    /// Steps until a time; Ctrl-C is heard between two steps.
    fn advance_to(&self, py: Python<'_>, time_s: f64) -> PyResult<()> {
        let mut stopped = None;
        let done = py.detach(|| {
            self.film().advance_while(time_s, |_| match Python::attach(|py| py.check_signals()) {
                Ok(()) => true,
                Err(signal) => {
                    stopped = Some(signal);
                    false
                }
            })
        });
        stopped.map_or(Ok(()), Err)?;
        done.map_err(failed)
    }

    fn thickness_nm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (values, shape) = py.detach(|| {
            let film = self.film();
            (film.thickness_nm(), [film.parameters().rows, film.parameters().columns])
        });
        values.into_pyarray(py).reshape(shape)
    }

    /// The thickness over a whole sphere.
    fn map<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let map = py.detach(|| self.film().map()).map_err(wrong)?;
        let shape = [map.height(), map.width()];
        map.into_thickness_nm().into_pyarray(py).reshape(shape)
    }

    /// Time, steps so far, sub-steps and iterations of the last, and where liquid went.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let facts = PyDict::new(py);
        let (values, ruptured_s) = py.detach(|| {
            let film = self.film();
            let (state, (substeps, iterations)) = (film.state(), film.effort());
            let books = state.books;
            let values = [
                ("time_s", state.time_s),
                ("step", state.step as f64),
                ("substeps", substeps as f64),
                ("iterations", iterations as f64),
                ("volume_m3", film.volume()),
                ("start_m3", books.start),
                ("evaporated_m3", books.evaporated),
                ("swallowed_m3", books.swallowed),
                ("blackened_m3", books.blackened),
                ("drained_m3", books.drained),
            ];
            (values, state.ruptured_s)
        });
        for (name, value) in values {
            facts.set_item(name, value)?;
        }
        facts.set_item("ruptured_s", ruptured_s)?;
        Ok(facts)
    }

    fn checkpoint<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| self.film().checkpoint());
        PyBytes::new(py, &bytes)
    }

    /// Every number by its name; the seed apart.
    fn parameters(&self, py: Python<'_>) -> Vec<(&'static str, f64)> {
        let listed = py.detach(|| self.film().parameters().listed());
        listed.into_iter().filter(|(name, _)| *name != "seed").collect()
    }
}

impl Flow {
    fn film(&self) -> std::sync::MutexGuard<'_, Film> {
        // A poisoned lock follows a panic, which has been reported; the film is then as it was left.
        self.inner.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

fn parameters(
    preset: &str,
    columns: Option<usize>,
    seed: u64,
    changes: &[(String, f64)],
) -> Result<Parameters, ThicknessError> {
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

fn wrong(error: ThicknessError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

fn failed(error: FlowError) -> PyErr {
    PyValueError::new_err(error.to_string())
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
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flowed = py.detach(|| flow_field(preset, time_s, seed, columns));
    let field = flowed.map_err(|error| interruption().unwrap_or_else(|| failed(error)))?;
    let map = py.detach(|| ThicknessModel::Flow(field).map(width, height, None)).map_err(wrong)?;
    map.into_thickness_nm().into_pyarray(py).reshape([height, width])
}

/// What ended the last film that flowed for a scene: an exception of its watcher, or Ctrl-C.
static INTERRUPTION: Mutex<Option<PyErr>> = Mutex::new(None);
/// Called as `watcher(reached_s, asked_s)` while a film flows for a scene.
static WATCHER: Mutex<Option<Py<PyAny>>> = Mutex::new(None);

fn locked<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// The exception that stopped a film, if one did; it is handed out once.
pub fn interruption() -> Option<PyErr> {
    locked(&INTERRUPTION).take()
}

fn goes_on(reached_s: f64, asked_s: f64) -> bool {
    let heard = Python::attach(|py| {
        py.check_signals()?;
        let watcher = locked(&WATCHER).as_ref().map(|watcher| watcher.clone_ref(py));
        watcher.map_or(Ok(()), |watcher| watcher.call1(py, (reached_s, asked_s)).map(|_| ()))
    });
    heard.map_err(|error| *locked(&INTERRUPTION) = Some(error)).is_ok()
}

/// Has `watcher(reached_s, asked_s)` called at every step of films that flow while a scene is read; None: nobody.
#[pyfunction]
fn flow_watch(watcher: Option<Py<PyAny>>) {
    *locked(&WATCHER) = watcher;
}

/// A film that flowed for a scene, where it stands now, to be given to `flow_stand`.
#[pyfunction]
fn flow_standing<'py>(
    py: Python<'py>,
    preset: &str,
    seed: u64,
    columns: Option<usize>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let bytes = py.detach(|| standing(preset, seed, columns)).map_err(failed)?;
    Ok(bytes.map(|bytes| PyBytes::new(py, &bytes)))
}

/// Lets films of scenes go on from where one stood.
#[pyfunction]
fn flow_stand(py: Python<'_>, preset: &str, seed: u64, columns: Option<usize>, bytes: Vec<u8>) -> PyResult<()> {
    py.detach(|| stand(preset, seed, columns, &bytes)).map_err(failed)
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
