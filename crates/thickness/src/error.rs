//! What can be wrong with a thickness.

use iridesce_numerics::{Argument, THICKNESS_NM};

/// What can be wrong with a thickness model: the parameter at fault, what it may be, what was given.
pub type ThicknessError = Argument;

/// A thickness in nm that a film can have.
pub(crate) fn check_nm(parameter: &'static str, value: f64) -> Result<(), ThicknessError> {
    THICKNESS_NM.named(parameter).check(value).map(|_| ())
}
