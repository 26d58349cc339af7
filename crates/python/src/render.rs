//! Bindings of the render stage.

use std::path::PathBuf;

use iridesce::files::Journal;
use iridesce::render::{
    Framebuffer, KeepOptions, Rect, RenderError, RenderOptions, Shard, TILE_SIDE, check, simd_level, tiles,
};
use iridesce::scene::{Scene as CoreScene, SceneError, resolve};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};
use crate::scene::Scene;

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("SIMD_LEVEL", simd_level())?;
    module.add("MAX_SAMPLES", RenderOptions::MAX_SAMPLES)?;
    module.add("MOST_SHARDS", Shard::MOST)?;
    module.add("TILE_SIDE", TILE_SIDE)?;
    module.add_function(wrap_pyfunction!(render_scene, module)?)?;
    module.add_function(wrap_pyfunction!(journal_head, module)?)?;
    module.add_function(wrap_pyfunction!(render_tiles, module)?)
}

/// What a render is asked for, beside the scene.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Asked {
    samples: Option<u32>,
    seed: Option<u64>,
    size: Option<[u32; 2]>,
    threads: Option<usize>,
    crop: Option<[u32; 4]>,
    until: Option<f64>,
    time_s: Option<f64>,
    settled: Option<f64>,
    shard: Option<[u32; 2]>,
    spectral_nm: Vec<f64>,
    stokes: bool,
    keep: Option<Keep>,
}

impl Asked {
    /// The core's options, and where the journal is. The threads are those of the pool that the call runs in.
    fn options(self) -> (RenderOptions, Option<KeepOptions>) {
        let options = RenderOptions {
            samples: self.samples,
            seed: self.seed,
            size: self.size,
            threads: None,
            crop: self.crop.map(|[x, y, width, height]| Rect { x, y, width, height }),
            until: self.until,
            time_s: self.time_s,
            settled: self.settled,
            shard: self.shard.map(|[number, of]| Shard { number, of }),
            spectral_nm: self.spectral_nm,
            stokes: self.stokes,
        };
        let keep = self.keep.map(|Keep(path, head, after_s, resume)| KeepOptions { path, head, after_s, resume });
        (options, keep)
    }
}

/// A journal: path, which render it is, seconds before it begins, and whether what it holds is taken over.
#[derive(FromPyObject)]
struct Keep(PathBuf, Vec<u8>, f64, bool);

type Rendered<'py> = (
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyDict>,
    Bound<'py, PyDict>,
    (u32, u64, f64, String, usize),
    Option<[u32; 4]>,
    Vec<String>,
);

/// `(xyz, planes, spectral planes, (samples, seed, seconds, simd, threads), (x, y, width, height) outside which there are no
/// surfaces, notes on files)`.
#[pyfunction]
fn render_scene<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    asked: Asked,
    progress: Option<Py<PyAny>>,
) -> Result<Rendered<'py>> {
    let threads = asked.threads;
    let (options, keep) = asked.options();
    let (wavelengths, has_stokes) = (options.spectral_nm.len(), options.stokes);
    let (recipe, context) = (scene.inner.clone(), scene.context.clone());
    let rendered = beside(py, Long { progress, threads }, |watch| -> Result<(Framebuffer, Vec<String>)> {
        // What cannot be rendered is told before any film flows.
        check(&recipe, &options).map_err(|error| in_scene(&recipe, error))?;
        let resolved = resolve(&recipe, &context, watch)?;
        let frame = iridesce::render::render(&resolved, &options, keep.as_ref(), watch);
        Ok((frame.map_err(|error| in_scene(&recipe, error))?, resolved.notes))
    })?;
    let (frame, notes) = rendered?;
    answer(py, frame, (wavelengths, has_stokes), notes)
}

/// What Python is given of a picture that was asked for so many wavelengths, with Stokes vectors or not.
fn answer<'py>(
    py: Python<'py>,
    frame: Framebuffer,
    (wavelengths, has_stokes): (usize, bool),
    notes: Vec<String>,
) -> Result<Rendered<'py>> {
    let (rows, columns) = (frame.height as usize, frame.width as usize);
    let plane = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns]);
    let whole = |values: Vec<i32>| PyArray1::from_vec(py, values).reshape([rows, columns]);
    let triple = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns, 3]);
    let planes = PyDict::new(py);
    planes.set_item("depth", plane(frame.depth)?)?;
    planes.set_item("thickness_nm", plane(frame.thickness_nm)?)?;
    planes.set_item("path_difference_nm", plane(frame.path_difference_nm)?)?;
    planes.set_item("normal", triple(frame.normal)?)?;
    planes.set_item("object", whole(frame.object)?)?;
    planes.set_item("variance", plane(frame.variance)?)?;
    planes.set_item("samples", whole(frame.samples)?)?;
    if let Some(alpha) = frame.alpha {
        planes.set_item("alpha", plane(alpha)?)?;
    }
    let spectral = PyDict::new(py);
    if let Some(stokes) = frame.stokes {
        spectral.set_item("stokes", PyArray1::from_vec(py, stokes).reshape([rows, columns, 3, 4])?)?;
    }
    if let Some(spectra) = frame.spectra {
        let values = PyArray1::from_vec(py, spectra);
        if has_stokes {
            spectral.set_item("spectral_stokes", values.reshape([rows, columns, wavelengths, 4])?)?;
        } else {
            spectral.set_item("spectra", values.reshape([rows, columns, wavelengths])?)?;
        }
    }
    let info = frame.info;
    let surfaces = frame.surfaces.map(|part| [part.x, part.y, part.width, part.height]);
    let made = (info.samples, info.seed, info.seconds, info.simd, info.threads);
    Ok((triple(frame.xyz)?, planes, spectral, made, surfaces, notes))
}

/// Which render the journal of that name is of, in the words that were given to it; `None` where there is none.
#[pyfunction]
fn journal_head<'py>(py: Python<'py>, path: PathBuf) -> Result<Option<Bound<'py, PyBytes>>> {
    let read = released(py, || Journal::read(&path))?;
    Ok(read.map(|(head, _)| PyBytes::new(py, &head)))
}

/// `(x, y, width, height)` of each tile of a picture of this size, in the order by which shards take them.
#[pyfunction]
fn render_tiles(size: [u32; 2]) -> Vec<[u32; 4]> {
    let [width, height] = size;
    tiles(Rect { x: 0, y: 0, width, height })
        .into_iter()
        .map(|tile| [tile.x, tile.y, tile.width, tile.height])
        .collect()
}

/// An error of a render; what is wrong with the scene is told with the scene's file.
fn in_scene(scene: &CoreScene, error: RenderError) -> Error {
    match error {
        RenderError::Scene { message, key } => {
            SceneError::new(message).at(key, None).in_file(scene.origin().file.as_deref()).into()
        }
        error => error.into(),
    }
}
