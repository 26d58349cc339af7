//! Bindings of what happens inside a stack: fields, and one layer as an Airy sum.

use iridesce::optics::stack::{self, Fields};
use iridesce::optics::{Complex64, Polarization};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::Result;
use crate::stacks::Elements;

/// Depths between two looks for Ctrl-C: some milliseconds.
const LOOK: usize = 1 << 14;

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_layer_airy, module)?)?;
    module.add_function(wrap_pyfunction!(stack_fields, module)?)
}

/// For each element the six numbers of `stack::LayerAiry`, in its order.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_layer_airy<'py>(
    py: Python<'py>,
    polarization: &str,
    indices: PyReadonlyArray2<'py, Complex64>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    layer: usize,
    mut out: PyReadwriteArray2<'py, Complex64>,
) -> Result<()> {
    let polarization = Polarization::named(polarization)?;
    let coherent = vec![true; thickness_nm.as_array().ncols()];
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let mut nothing = vec![(); elements.wavelength_nm.len()];
    elements.fill(py, [6, 1], out.as_slice_mut()?, &mut nothing, |at, row, _, _| {
        let airy = stack::layer_airy(at.indices, at.thickness_nm, at.wavelength_nm, at.incidence, polarization, layer)?;
        let passed = Complex64::new(airy.passed, 0.0);
        let values = [airy.r_above, airy.t_above_squared, airy.r_inside, airy.r_below, passed, airy.kz];
        row.copy_from_slice(&values);
        Ok(())
    })
}

/// Fields at depths: `depth_nm` (elements, depths); `fields` (elements, depths x 6) takes E and H along x, y, z, `power`
/// (elements, depths x 2) the flux and the power absorbed per nm.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_fields<'py>(
    py: Python<'py>,
    polarization: &str,
    indices: PyReadonlyArray2<'py, Complex64>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    depth_nm: PyReadonlyArray1<'py, f64>,
    mut fields: PyReadwriteArray2<'py, Complex64>,
    mut power: PyReadwriteArray2<'py, f64>,
) -> Result<()> {
    let polarization = Polarization::named(polarization)?;
    let coherent = vec![true; thickness_nm.as_array().ncols()];
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let depths = depth_nm.as_slice()?.to_vec();
    if depths.is_empty() || elements.wavelength_nm.is_empty() {
        return Ok(());
    }
    let widths = [6 * depths.len(), 2 * depths.len()];
    elements.fill(py, widths, fields.as_slice_mut()?, power.as_slice_mut()?, |at, fields, power, watch| {
        let made = Fields::new(at.indices, at.thickness_nm, at.wavelength_nm, at.incidence, polarization)?;
        let rows = fields.chunks_exact_mut(6).zip(power.chunks_exact_mut(2));
        for (i, (depth, (field, power))) in depths.iter().zip(rows).enumerate() {
            // One element may have more depths than fit into the time of a Ctrl-C.
            if i % LOOK == 0 && watch.is_stopped() {
                break;
            }
            let here = made.at(*depth);
            field[..3].copy_from_slice(&here.electric);
            field[3..].copy_from_slice(&here.magnetic);
            power.copy_from_slice(&[here.flux, here.absorbed_per_nm]);
        }
        Ok(())
    })
}
