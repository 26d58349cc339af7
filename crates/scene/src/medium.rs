//! Media: names, numbers or pairs.

use iridesce_optics::medium::VISIBLE_NM;
use iridesce_optics::{Complex64, Medium};

use crate::error::SceneError;
use crate::reader::as_number;
use crate::tree::{Node, Value};

/// Least k of a medium that the renderer takes as opaque wherever it fills space: e^-1 within 50 um.
pub const OPAQUE_K: f64 = 1e-3;

/// Largest n and k: beyond any metal's, and their fourth powers stay within the range of single precision.
const MAX_INDEX: f64 = 1e3;
/// Smallest |n + ik|: below any medium's, and fourth powers of what lies between two media stay within it, too.
const MIN_INDEX: f64 = 1e-6;

/// A medium is a name, a number or `[n, k]`.
pub fn medium(node: &Node, path: &str) -> Result<(Medium, Node), SceneError> {
    let wrong = |message: String| SceneError::new(format!("{path} {message}")).at(path, node.line);
    let constant = |n: f64, k: f64| {
        if !(n > 0.0 && n <= MAX_INDEX && (0.0..=MAX_INDEX).contains(&k) && n.hypot(k) >= MIN_INDEX) {
            return Err(wrong(format!(
                "must have 0 < n <= 1000 and 0 <= k <= 1000 in a scene, and |n + ik| >= 1e-6, got {}",
                node.describe()
            )));
        }
        Medium::constant(Complex64::new(n, k)).map_err(|e| wrong(format!("cannot be used: {e}")))
    };
    let other = || wrong(format!("must be a medium: a name, a number or [n, k], got {}", node.describe()));
    let found = match &node.value {
        // Longer than any name: not to be repeated in a message.
        Value::Text(name) if name.len() > 100 => return Err(other()),
        Value::Text(name) => Medium::named(name).map_err(|e| wrong(format!("cannot be used: {e}")))?,
        Value::Int(_) | Value::Float(_) => constant(as_number(node).ok_or_else(other)?, 0.0)?,
        Value::List(items) => match items.iter().map(as_number).collect::<Option<Vec<f64>>>().as_deref() {
            Some(&[n, k]) => constant(n, k)?,
            _ => return Err(other()),
        },
        _ => return Err(other()),
    };
    for nm in [VISIBLE_NM.0, VISIBLE_NM.1] {
        let (index, _) = found.index_extended(nm).map_err(|e| wrong(format!("cannot be used: {e}")))?;
        if !(MIN_INDEX..=2.0 * MAX_INDEX).contains(&index.norm()) {
            return Err(wrong(format!(
                "cannot be used in a scene: |n + ik| is {} at {nm} nm, not 1e-6 to 2000",
                index.norm()
            )));
        }
    }
    Ok((found, node.without_lines()))
}

/// Whether light gets through a medium somewhere in the visible range.
pub fn is_clear(medium: &Medium) -> bool {
    let (first, last) = VISIBLE_NM;
    (first as u32..=last as u32).step_by(10).any(|nm| is_clear_at(medium, f64::from(nm)))
}

/// The same at one wavelength.
pub fn is_clear_at(medium: &Medium, wavelength_nm: f64) -> bool {
    medium.index_extended(wavelength_nm).is_ok_and(|(index, _)| index.im < OPAQUE_K)
}
