//! Bindings of the stack stage.

use pyo3::prelude::*;

/// Adds this stage's names to `_core`.
pub fn register(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
