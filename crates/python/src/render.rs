//! Bindings of the render stage.

use iridesce::render::{Framebuffer, RenderError, RenderOptions, check, simd_level};
use iridesce::scene::{Scene as CoreScene, SceneError, resolve};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside};
use crate::scene::Scene;

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("SIMD_LEVEL", simd_level())?;
    module.add("MAX_SAMPLES", RenderOptions::MAX_SAMPLES)?;
    module.add_function(wrap_pyfunction!(render_scene, module)?)
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
) -> Result<Planes4<'py>> {
    // The threads are those of the pool that it runs in.
    let options = RenderOptions { samples, seed, size, threads: None };
    let (recipe, context) = (scene.inner.clone(), scene.context.clone());
    let rendered = beside(py, Long { progress, threads }, |watch| -> Result<Framebuffer> {
        // What cannot be rendered is told before any film flows.
        check(&recipe, &options).map_err(|error| in_scene(&recipe, error))?;
        let resolved = resolve(&recipe, &context, watch)?;
        iridesce::render::render(&resolved, &options, watch).map_err(|error| in_scene(&recipe, error))
    })?;
    let Framebuffer { width, height, xyz, depth, thickness_nm, normal, info } = rendered?;
    let (rows, columns) = (height as usize, width as usize);
    let plane = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns]);
    let triple = |values: Vec<f32>| PyArray1::from_vec(py, values).reshape([rows, columns, 3]);
    let info = (info.samples, info.seed, info.seconds, info.simd, info.threads);
    Ok((triple(xyz)?, plane(depth)?, plane(thickness_nm)?, triple(normal)?, info))
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
