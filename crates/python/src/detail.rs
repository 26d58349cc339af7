//! Bindings of what lies deeper in a stack: derivatives, one layer as an Airy sum, fields. Arguments arrive in full size: row `i` of
//! every array belongs to element `i`.

use iridesce::optics::color::{Adaptation, Grid, Observer, Space, Weights};
use iridesce::optics::incidence::Incidence;
use iridesce::optics::stack::{self, Derivatives, Fields};
use iridesce::optics::{Complex64, OpticsError, Polarization};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::color::Illuminant;
use crate::medium::value_error;

/// Elements a task.
const TASK: usize = 256;
/// Elements between two looks for Ctrl-C.
const GROUP: usize = 1 << 15;

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stack_derivatives, module)?)?;
    module.add_function(wrap_pyfunction!(stack_layer_airy, module)?)?;
    module.add_function(wrap_pyfunction!(stack_fields, module)?)?;
    module.add_function(wrap_pyfunction!(color_weights, module)?)?;
    module.add_function(wrap_pyfunction!(color_jacobian, module)?)
}

/// Many stacks of the same build.
struct Elements<'a> {
    /// (elements, media)
    indices: &'a [Complex64],
    /// (elements, layers)
    thickness_nm: &'a [f64],
    coherent: &'a [bool],
    wavelength_nm: &'a [f64],
    angle_deg: &'a [f64],
}

/// One of them.
struct Element<'a> {
    indices: &'a [Complex64],
    thickness_nm: &'a [f64],
    wavelength_nm: f64,
    incidence: Incidence,
}

impl<'a> Elements<'a> {
    fn check(&self) -> PyResult<()> {
        let (count, layers) = (self.wavelength_nm.len(), self.coherent.len());
        let fits = self.angle_deg.len() == count
            && self.indices.len() == count * (layers + 2)
            && self.thickness_nm.len() == count * layers;
        if fits { Ok(()) } else { Err(PyValueError::new_err("the arrays do not belong together")) }
    }

    fn at(&self, element: usize) -> Result<Element<'a>, OpticsError> {
        let layers = self.coherent.len();
        let indices = &self.indices[element * (layers + 2)..][..layers + 2];
        let thickness_nm = &self.thickness_nm[element * layers..][..layers];
        let wavelength_nm = self.wavelength_nm[element];
        stack::check(indices, thickness_nm, self.coherent, wavelength_nm)
            .map_err(|error| OpticsError::Argument(format!("{error} (at wavelength_nm = {wavelength_nm})")))?;
        let incidence = Incidence::from_degrees(self.angle_deg[element])?;
        Ok(Element { indices, thickness_nm, wavelength_nm, incidence })
    }

    /// Fills rows of `first` and `second`, `widths` numbers an element each, on all cores.
    fn fill<A: Send, B: Send>(
        &self,
        py: Python<'_>,
        widths: [usize; 2],
        first: &mut [A],
        second: &mut [B],
        each: impl Fn(&Element<'a>, &mut [A], &mut [B]) -> Result<(), OpticsError> + Sync,
    ) -> PyResult<()> {
        self.check()?;
        let count = self.wavelength_nm.len();
        if first.len() != count * widths[0] || second.len() != count * widths[1] {
            return Err(PyValueError::new_err("the output does not have the shape of the result"));
        }
        let (mut first, mut second) = (first, second);
        for start in (0..count).step_by(GROUP) {
            let group = GROUP.min(count - start);
            let (head, tail) = std::mem::take(&mut first).split_at_mut(group * widths[0]);
            let (other_head, other_tail) = std::mem::take(&mut second).split_at_mut(group * widths[1]);
            (first, second) = (tail, other_tail);
            let one = |number: usize, a: &mut [A], b: &mut [B]| -> Result<(), OpticsError> {
                let rows = a.chunks_exact_mut(widths[0]).zip(b.chunks_exact_mut(widths[1])).enumerate();
                for (i, (a, b)) in rows {
                    each(&self.at(start + number * TASK + i)?, a, b)?;
                }
                Ok(())
            };
            py.detach(|| {
                if group <= TASK {
                    return one(0, head, other_head);
                }
                head.par_chunks_mut(TASK * widths[0])
                    .zip(other_head.par_chunks_mut(TASK * widths[1]))
                    .enumerate()
                    .try_for_each(|(number, (a, b))| one(number, a, b))
            })
            .map_err(value_error)?;
            py.check_signals()?;
        }
        Ok(())
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
) -> PyResult<()> {
    let polarization = Polarization::named(polarization).map_err(value_error)?;
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let parameters = 3 * coherent.len() + 3;
    let ellipsometry = match quantity {
        "reflectance" | "transmittance" | "absorptance" => false,
        "ellipsometry" => true,
        _ => return Err(PyValueError::new_err(format!("no quantity is named {quantity:?}"))),
    };
    let width = if ellipsometry { 2 } else { 1 };
    let flags = coherent.as_slice();
    let solve = |at: &Element<'_>, values: &mut [f64], rows: &mut [f64]| -> Result<(), OpticsError> {
        let Element { indices, thickness_nm, wavelength_nm, incidence } = *at;
        let [first, second] = if ellipsometry {
            stack::ellipsometry_derivatives(indices, thickness_nm, wavelength_nm, incidence)?
        } else {
            stack::power_derivatives(indices, thickness_nm, flags, wavelength_nm, incidence, polarization)?
        };
        let mut write = |place: usize, derivatives: &Derivatives, factor: f64| {
            values[place] += factor * derivatives.value;
            for (slot, value) in rows[place * parameters..][..parameters].iter_mut().zip(derivatives.row()) {
                *slot += factor * value;
            }
        };
        match quantity {
            "transmittance" => write(0, &second, 1.0),
            "absorptance" => {
                write(0, &first, -1.0);
                write(0, &second, -1.0);
                values[0] += 1.0;
            }
            "ellipsometry" => {
                write(0, &first, 1.0);
                write(1, &second, 1.0);
            }
            _ => write(0, &first, 1.0),
        }
        Ok(())
    };
    values.as_slice_mut()?.fill(0.0);
    rows.as_slice_mut()?.fill(0.0);
    elements.fill(py, [width, width * parameters], values.as_slice_mut()?, rows.as_slice_mut()?, solve)
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
) -> PyResult<()> {
    let polarization = Polarization::named(polarization).map_err(value_error)?;
    let coherent = vec![true; thickness_nm.as_array().ncols()];
    let elements = Elements {
        indices: indices.as_slice()?,
        thickness_nm: thickness_nm.as_slice()?,
        coherent: &coherent,
        wavelength_nm: wavelength_nm.as_slice()?,
        angle_deg: angle_deg.as_slice()?,
    };
    let mut nothing = vec![(); elements.wavelength_nm.len()];
    elements.fill(py, [6, 1], out.as_slice_mut()?, &mut nothing, |at, row, _| {
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
) -> PyResult<()> {
    let polarization = Polarization::named(polarization).map_err(value_error)?;
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
    elements.fill(py, widths, fields.as_slice_mut()?, power.as_slice_mut()?, |at, fields, power| {
        let made = Fields::new(at.indices, at.thickness_nm, at.wavelength_nm, at.incidence, polarization)?;
        for (i, depth) in depths.iter().enumerate() {
            let here = made.at(*depth);
            fields[6 * i..][..3].copy_from_slice(&here.electric);
            fields[6 * i + 3..][..3].copy_from_slice(&here.magnetic);
            power[2 * i..][..2].copy_from_slice(&[here.flux, here.absorbed_per_nm]);
        }
        Ok(())
    })
}

type Weighted<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, [f64; 3], usize);

/// The wavelengths of a colour sum with every step divided into `parts`, their weights for X, Y, Z, the white, and how many of the
/// wavelengths belong to the grid (the rest are lines).
#[pyfunction]
fn color_weights<'py>(
    py: Python<'py>,
    illuminant: PyRef<'py, Illuminant>,
    observer: &str,
    wavelength_nm: Option<PyReadonlyArray1<'py, f64>>,
    parts: usize,
) -> PyResult<Weighted<'py>> {
    let grid = match wavelength_nm {
        Some(given) => Grid::through(given.as_slice()?).map_err(value_error)?,
        None => Grid::default(),
    };
    let observer = Observer::named(observer).map_err(value_error)?;
    let weights =
        Weights::new(&grid.divided(parts.clamp(1, 1 << 16)), &illuminant.inner, observer).map_err(value_error)?;
    let count = weights.wavelength_nm.len();
    let of_grid = weights.grid_index.iter().filter(|index| index.is_some()).count();
    let xyz = weights.xyz.into_flattened().into_pyarray(py).reshape([count, 3])?;
    Ok((weights.wavelength_nm.into_pyarray(py), xyz, weights.white, of_grid))
}

/// The derivatives of a space's values with respect to XYZ, nine a row; NaN where there are none.
#[pyfunction]
fn color_jacobian<'py>(
    py: Python<'py>,
    xyz: PyReadonlyArray2<'py, f64>,
    space: &str,
    white: [f64; 3],
    adaptation: Option<&str>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let space = Space::named(space).map_err(value_error)?;
    let adaptation = Adaptation::named(adaptation).map_err(value_error)?;
    let (rows, _) = xyz.as_slice()?.as_chunks::<3>();
    let flat: Vec<f64> = rows
        .iter()
        .flat_map(|xyz| space.jacobian(*xyz, white, adaptation).unwrap_or([[f64::NAN; 3]; 3]).into_iter().flatten())
        .collect();
    flat.into_pyarray(py).reshape([rows.len(), 9])
}
