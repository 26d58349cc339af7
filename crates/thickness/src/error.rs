//! What can be wrong with a thickness.

/// What can be wrong with a thickness model; `key` is the parameter at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} {message}")]
pub struct ThicknessError {
    /// The parameter at fault, e.g. `top`.
    pub key: &'static str,
    /// What was given and what is allowed.
    pub message: String,
}

/// A thickness in nm that a film can have.
pub(crate) fn check_nm(key: &'static str, value: f64) -> Result<(), ThicknessError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ThicknessError { key, message: format!("must be a finite thickness in nm, >= 0, got {value:?}") })
}
