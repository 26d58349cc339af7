//! Bindings of the render stage: render, develop, save. Long work runs beside the caller, who stays interruptible.

use std::any::Any;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use iridesce::files::{self, BitDepth, Fact, FileError, OutputSpace, Planes};
use iridesce::optics::color::gamut::Mapping;
use iridesce::render::image::{self, Development};
use iridesce::render::{Framebuffer, Progress, RenderError, RenderOptions, simd_level};
use iridesce::scene::{Scene as CoreScene, SceneError};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::scene::{self, Scene};

/// How often a waiting caller looks for Ctrl-C and tells of progress.
const POLL: Duration = Duration::from_millis(30);

/// What a worker and its waiting caller share.
#[derive(Default)]
pub(crate) struct Shared {
    done: AtomicU64,
    total: AtomicU64,
    stop: AtomicBool,
}

impl Progress for Shared {
    fn advance(&self, done_pixels: u64, total_pixels: u64) {
        self.total.store(total_pixels, Ordering::Relaxed);
        self.done.fetch_max(done_pixels, Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs `work` on a thread of its own without the interpreter lock. The calling thread looks every 30 ms for Ctrl-C and
/// calls `progress(done, total)` when there is news, and once at the end; an exception from either stops the work.
pub(crate) fn beside<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Shared) -> T + Send,
) -> PyResult<T> {
    let shared = Shared::default();
    let told = AtomicU64::new(0);
    let tell = |py: Python<'_>| -> PyResult<()> {
        py.check_signals()?;
        let (done, total) = (shared.done.load(Ordering::Relaxed), shared.total.load(Ordering::Relaxed));
        if let Some(progress) = &progress
            && told.swap(done, Ordering::Relaxed) != done
        {
            progress.call1(py, (done, total))?;
        }
        Ok(())
    };
    let outcome = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = channel();
            let shared = &shared;
            thread::Builder::new().name("iridesce".into()).spawn_scoped(scope, move || {
                // A panic is our mistake, not the user's: it must not take the interpreter with it.
                let result = catch_unwind(AssertUnwindSafe(|| work(shared)));
                let _ = sender.send(result);
            })?;
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(Ok(result)) => return Ok(result),
                    Ok(Err(panic)) => return Err(internal(panic.as_ref())),
                    Err(RecvTimeoutError::Disconnected) => return Err(internal(&"the worker vanished")),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(error) = Python::attach(tell) {
                            shared.stop.store(true, Ordering::Relaxed);
                            return Err(error); // the scope waits for the worker to notice
                        }
                    }
                }
            }
        })
    })?;
    tell(py)?;
    Ok(outcome)
}

fn internal(panic: &(dyn Any + Send)) -> PyErr {
    let words = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    PyRuntimeError::new_err(format!("internal error, please report it: {}", words.unwrap_or("unknown")))
}

fn render_error(py: Python<'_>, scene: &CoreScene, error: RenderError) -> PyErr {
    let message = error.to_string();
    match error {
        RenderError::Resource(_) => match py.import("iridesce.errors").and_then(|m| m.getattr("ResourceError")) {
            Ok(class) => class.call1((message,)).map_or_else(|e| e, |value| PyErr::from_value(value)),
            Err(error) => error,
        },
        RenderError::Scene { message, key } => {
            scene::to_python(py, SceneError::new(message).at(key, None).in_file(scene.origin().file.as_deref()))
        }
        RenderError::Cancelled => PyRuntimeError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// `OSError` with its errno, so that Python makes it `FileNotFoundError`, `PermissionError` and so on.
pub(crate) fn image_error(error: FileError) -> PyErr {
    match error {
        FileError::Write { path, source } => {
            let errno = source.raw_os_error().unwrap_or(match source.kind() {
                ErrorKind::NotFound => 2,
                ErrorKind::PermissionDenied => 13,
                ErrorKind::NotADirectory => 20,
                ErrorKind::IsADirectory => 21,
                ErrorKind::InvalidInput => 22,
                ErrorKind::StorageFull => 28,
                ErrorKind::ReadOnlyFilesystem => 30,
                _ => 5,
            });
            PyOSError::new_err((errno, format!("cannot write the picture: {source}"), path.into_os_string()))
        }
        FileError::Cancelled => PyRuntimeError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

type Planes4<'py> = (
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray3<f32>>,
    (u32, u64, f64, String, usize),
);

/// `(xyz, depth, thickness_nm, normal, (samples, seed, seconds, simd, threads))`.
#[pyfunction]
fn render_scene<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    samples: Option<u32>,
    seed: Option<u64>,
    size: Option<[u32; 2]>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Planes4<'py>> {
    let options = RenderOptions { samples, seed, size, threads };
    let scene = scene.inner.clone();
    let rendered = beside(py, progress, |shared| iridesce::render::render(&scene, &options, shared))?;
    let Framebuffer { width, height, xyz, depth, thickness_nm, normal, info } =
        rendered.map_err(|e| render_error(py, &scene, e))?;
    let (rows, columns) = (height as usize, width as usize);
    let plane = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns]);
    let triple = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns, 3]);
    let info = (info.samples, info.seed, info.seconds, info.simd, info.threads);
    Ok((triple(xyz)?, plane(depth)?, plane(thickness_nm)?, triple(normal)?, info))
}

/// `(rgb, out_of_gamut, overexposed)`; `xyz` contiguous.
#[pyfunction]
fn develop_image<'py>(
    py: Python<'py>,
    xyz: PyReadonlyArray3<'py, f32>,
    space: &str,
    exposure: f64,
    gamut: &str,
) -> PyResult<(Bound<'py, PyArray3<f32>>, f64, f64)> {
    let gamut = Mapping::named(gamut).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let how = Development { space: OutputSpace::named(space).map_err(image_error)?, exposure, gamut };
    let shape: [usize; 3] = [xyz.shape()[0], xyz.shape()[1], xyz.shape()[2]];
    let values = xyz.as_slice()?;
    let developed =
        beside(py, None, |shared| image::develop(values, &how, &|| shared.cancelled()))?.map_err(image_error)?;
    let rgb = PyArray1::from_vec(py, developed.rgb).reshape(shape)?;
    Ok((rgb, developed.out_of_gamut, developed.overexposed))
}

/// Stops.
#[pyfunction]
fn auto_exposure(py: Python<'_>, xyz: PyReadonlyArray3<'_, f32>, depth: PyReadonlyArray2<'_, f32>) -> PyResult<f64> {
    let (xyz, depth) = (xyz.as_slice()?, depth.as_slice()?);
    py.detach(|| image::auto_exposure(xyz, depth)).map_err(image_error)
}

#[derive(FromPyObject)]
pub(crate) enum PyFact {
    Integer(i32),
    Number(f64),
    Text(String),
}

pub(crate) fn facts(facts: Vec<(String, PyFact)>) -> Vec<(String, Fact)> {
    let fact = |fact| match fact {
        PyFact::Integer(value) => Fact::Integer(value),
        PyFact::Number(value) => Fact::Number(value),
        PyFact::Text(value) => Fact::Text(value),
    };
    facts.into_iter().map(|(name, value)| (name, fact(value))).collect()
}

/// Width and height of an array, rows first.
fn sides(shape: &[usize]) -> PyResult<(u32, u32)> {
    match (u32::try_from(shape[1]), u32::try_from(shape[0])) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(PyValueError::new_err(format!("at most {} pixels a side, got shape {shape:?}", u32::MAX))),
    }
}

#[pyfunction]
fn save_png(
    py: Python<'_>,
    path: PathBuf,
    rgb: PyReadonlyArray3<'_, f32>,
    bits: u8,
    space: &str,
    facts_: Vec<(String, PyFact)>,
) -> PyResult<()> {
    let bits = match bits {
        8 => BitDepth::Eight,
        16 => BitDepth::Sixteen,
        _ => return Err(PyValueError::new_err(format!("bits must be 8 or 16, got {bits}"))),
    };
    let space = OutputSpace::named(space).map_err(image_error)?;
    let (width, height) = sides(rgb.shape())?;
    let (values, facts) = (rgb.as_slice()?, facts(facts_));
    beside(py, None, |shared| {
        files::write_png(&path, width, height, values, bits, space, &facts, &|| shared.cancelled())
    })?
    .map_err(image_error)
}

#[pyfunction]
fn png_bytes(py: Python<'_>, rgb: PyReadonlyArray3<'_, f32>, space: &str) -> PyResult<Vec<u8>> {
    let space = OutputSpace::named(space).map_err(image_error)?;
    let (width, height) = sides(rgb.shape())?;
    let values = rgb.as_slice()?;
    py.detach(|| files::png_bytes(width, height, values, space)).map_err(image_error)
}

#[pyfunction]
fn save_exr(
    py: Python<'_>,
    path: PathBuf,
    xyz: PyReadonlyArray3<'_, f32>,
    depth: PyReadonlyArray2<'_, f32>,
    thickness_nm: PyReadonlyArray2<'_, f32>,
    normal: PyReadonlyArray3<'_, f32>,
    facts_: Vec<(String, PyFact)>,
) -> PyResult<()> {
    let (width, height) = sides(xyz.shape())?;
    let planes = Planes {
        width,
        height,
        xyz: xyz.as_slice()?,
        depth: depth.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        normal: normal.as_slice()?,
    };
    let facts = facts(facts_);
    beside(py, None, |shared| files::write_exr(&path, &planes, &facts, &|| shared.cancelled()))?.map_err(image_error)
}

/// Raises what saving to this path would raise.
#[pyfunction]
fn check_output(path: PathBuf) -> PyResult<()> {
    files::check_output(Path::new(&path)).map_err(image_error)
}

/// Writes a file, whole or not at all.
#[pyfunction]
fn write_file(py: Python<'_>, path: PathBuf, bytes: &[u8]) -> PyResult<()> {
    py.detach(|| files::write_bytes(Path::new(&path), bytes)).map_err(image_error)
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("SIMD_LEVEL", simd_level())?;
    module.add("MAX_SAMPLES", RenderOptions::MAX_SAMPLES)?;
    module.add_function(wrap_pyfunction!(render_scene, module)?)?;
    module.add_function(wrap_pyfunction!(develop_image, module)?)?;
    module.add_function(wrap_pyfunction!(auto_exposure, module)?)?;
    module.add_function(wrap_pyfunction!(save_png, module)?)?;
    module.add_function(wrap_pyfunction!(png_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(save_exr, module)?)?;
    module.add_function(wrap_pyfunction!(check_output, module)?)?;
    module.add_function(wrap_pyfunction!(write_file, module)?)
}
