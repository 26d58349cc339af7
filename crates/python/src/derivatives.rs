//! Bindings of the derivatives of stacks and colours.

use iridesce::numerics::Watch;
use iridesce::optics::color::{Adaptation, Space};
use iridesce::optics::stack::{self, Derivatives};
use iridesce::optics::{Complex64, OpticsError, Polarization};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::fill;
use crate::stacks::{Element, Elements};

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(color_jacobian, module)?)
}

/// What is differentiated.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Differentiated {
    Reflectance,
    Transmittance,
    Absorptance,
    Ellipsometry,
}

impl Differentiated {
    fn named(name: &str) -> Result<Differentiated> {
        match name {
            "reflectance" => Ok(Differentiated::Reflectance),
            "transmittance" => Ok(Differentiated::Transmittance),
            "absorptance" => Ok(Differentiated::Absorptance),
            "ellipsometry" => Ok(Differentiated::Ellipsometry),
            _ => Err(Error::value(format!("no quantity is named {name:?}"))),
        }
    }

    /// Its values and the rows of their derivatives, from those of R and T or of psi and delta.
    fn write(self, [first, second]: &[Derivatives; 2], values: &mut [f64], rows: &mut [f64]) {
        values.fill(0.0);
        rows.fill(0.0);
        let parameters = rows.len() / values.len();
        let mut add = |place: usize, derivatives: &Derivatives, factor: f64| {
            values[place] += factor * derivatives.value;
            for (slot, value) in rows[place * parameters..][..parameters].iter_mut().zip(derivatives.row()) {
                *slot += factor * value;
            }
        };
        match self {
            Differentiated::Reflectance => add(0, first, 1.0),
            Differentiated::Transmittance => add(0, second, 1.0),
            Differentiated::Absorptance => {
                add(0, first, -1.0);
                add(0, second, -1.0);
                values[0] += 1.0;
            }
            Differentiated::Ellipsometry => {
                add(0, first, 1.0);
                add(1, second, 1.0);
            }
        }
    }
}

/// Values and derivatives: `values` (elements, 1 or 2), `rows` (elements, values x parameters), the parameters of a value being its
/// thicknesses, n of every medium, k of all but the first.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_derivatives<'py>(
    py: Python<'py>,
    quantity: &str,
    polarization: &str,
    indices: PyReadonlyArray2<'py, Complex64>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    coherent: Vec<bool>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    mut values: PyReadwriteArray2<'py, f64>,
    mut rows: PyReadwriteArray2<'py, f64>,
) -> Result<()> {
    let polarization = Polarization::named(polarization)?;
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let parameters = 3 * coherent.len() + 3;
    let quantity = Differentiated::named(quantity)?;
    let width = if quantity == Differentiated::Ellipsometry { 2 } else { 1 };
    let flags = coherent.as_slice();
    let solve =
        |at: &Element<'_>, values: &mut [f64], rows: &mut [f64], _: &Watch| -> std::result::Result<(), OpticsError> {
            let Element { indices, thickness_nm, wavelength_nm, incidence } = *at;
            let pair = if quantity == Differentiated::Ellipsometry {
                stack::ellipsometry_derivatives(indices, thickness_nm, wavelength_nm, incidence)?
            } else {
                stack::power_derivatives(indices, thickness_nm, flags, wavelength_nm, incidence, polarization)?
            };
            quantity.write(&pair, values, rows);
            Ok(())
        };
    elements.fill(py, [width, width * parameters], values.as_slice_mut()?, rows.as_slice_mut()?, solve)
}

/// The derivatives of a space's values with respect to XYZ, nine a row; NaN where there are none.
#[pyfunction]
fn color_jacobian<'py>(
    py: Python<'py>,
    xyz: PyReadonlyArray2<'py, f64>,
    space: &str,
    white: [f64; 3],
    adaptation: Option<&str>,
) -> Result<Bound<'py, PyArray2<f64>>> {
    let space = Space::named(space)?;
    let adaptation = Adaptation::named(adaptation)?;
    let (rows, _) = xyz.as_slice()?.as_chunks::<3>();
    let made = PyArray2::zeros(py, [rows.len(), 9], false);
    fill(py, made.readwrite().as_slice_mut()?.as_chunks_mut::<9>().0, |place| {
        let jacobian = space.jacobian(rows[place], white, adaptation).unwrap_or([[f64::NAN; 3]; 3]);
        let [[a, b, c], [d, e, f], [g, h, i]] = jacobian;
        Ok::<_, Error>([a, b, c, d, e, f, g, h, i])
    })?;
    Ok(made)
}
