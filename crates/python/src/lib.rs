//! `iridesce._core`: small functions on flat arrays and plain values; the Python package documents and checks.

use pyo3::prelude::*;

mod color;
mod color_table;
mod detail;
mod flow;
mod medium;
mod render;
mod scene;
mod stack;
mod thickness;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    medium::register(module)?;
    stack::register(module)?;
    color::register(module)?;
    color_table::register(module)?;
    detail::register(module)?;
    thickness::register(module)?;
    flow::register(module)?;
    scene::register(module)?;
    render::register(module)
}
