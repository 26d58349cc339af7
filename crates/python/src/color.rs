//! Bindings of the color stage.

use pyo3::prelude::*;

/// Adds this stage's names to `_core`.
pub fn register(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
