//! What the readers of a scene's parts are given besides the part.

use crate::model::Unit;
use crate::origin::Origin;

/// What an object is read with.
pub struct Reading<'a> {
    /// What 1.0 means.
    pub unit: Unit,
    /// What paths are relative to.
    pub origin: &'a Origin,
    /// The object has a transform or instances: laws wait for where it is.
    pub is_placed: bool,
}
