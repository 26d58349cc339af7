//! `iridesce._core`: small functions on flat arrays and plain values; the Python package documents and checks.
//!
//! One file a stage; `error` turns every error into an exception, `interrupt` runs what takes long, `pool` has its threads.

use numpy::PyArray1;
use pyo3::prelude::*;

mod coherence;
mod color;
mod color_table;
mod derivatives;
mod error;
mod fields;
mod files;
mod flow;
mod image;
mod interrupt;
mod inverse;
mod medium;
mod photograph;
mod pool;
mod render;
mod scene;
mod stack;
mod stacks;
mod thickness;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    load_numpy(module.py())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::register(module)?;
    medium::register(module)?;
    stack::register(module)?;
    derivatives::register(module)?;
    fields::register(module)?;
    coherence::register(module)?;
    color::register(module)?;
    color_table::register(module)?;
    thickness::register(module)?;
    flow::register(module)?;
    inverse::register(module)?;
    photograph::register(module)?;
    scene::register(module)?;
    render::register(module)?;
    image::register(module)?;
    files::register(module)?;
    pool::register(module)
}

/// Has numpy's C interface at hand. It is otherwise looked up by the first array that is made, which panics if Ctrl-C comes
/// during the look-up; here it is an import that Ctrl-C ends like any other.
fn load_numpy(py: Python<'_>) -> PyResult<()> {
    py.import("numpy")?;
    py.check_signals()?;
    // All of it is loaded now: no Python code runs, so no signal is heard, where the interface is asked for.
    PyArray1::<f64>::zeros(py, 0, false);
    Ok(())
}
