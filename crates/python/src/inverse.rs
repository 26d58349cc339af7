//! Bindings of the inverse stage: flat arrays in, flat arrays out.

use iridesce::inverse::{Fine, InverseError, Measured, Nuisance, SmoothCurves, explain, log_evidences};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(inverse_evidence, module)?)?;
    module.add_function(wrap_pyfunction!(inverse_explain, module)?)
}

/// Nuisances as rows: which length, gain, level, bend, stray, kappa, drift.
fn nuisances(rows: &PyReadonlyArray2<'_, f64>) -> Result<Vec<Nuisance>> {
    let values = rows.as_slice()?;
    let made = values.chunks_exact(7).map(|row| Nuisance {
        curves: row[0] as usize,
        gain: row[1],
        level: row[2],
        bend: row[3],
        stray: row[4],
        kappa: row[5],
        drift: row[6],
    });
    Ok(made.collect())
}

/// Length of a curve, of the finer ones on it, and their share of the variance.
type Curve = (f64, f64, f64);

fn curves(wavelength_nm: &[f64], of: &[Curve]) -> std::result::Result<Vec<SmoothCurves>, InverseError> {
    let made = |&(length, fine, share): &Curve| {
        SmoothCurves::with_fine(wavelength_nm, length, Fine { length_nm: fine, share })
    };
    of.iter().map(made).collect()
}

/// Log evidence, (spectra, nuisances).
#[pyfunction]
fn inverse_evidence<'py>(
    py: Python<'py>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    sd: PyReadonlyArray1<'py, f64>,
    spectra: PyReadonlyArray2<'py, f64>,
    smooth: Vec<Curve>,
    nuisance: PyReadonlyArray2<'py, f64>,
) -> Result<Bound<'py, PyArray2<f64>>> {
    let (nm, values, sd, spectra) =
        (wavelength_nm.as_slice()?, values.as_slice()?, sd.as_slice()?, spectra.as_slice()?);
    let nuisances = nuisances(&nuisance)?;
    let found = beside(py, Long::default(), |watch| {
        let curves = curves(nm, &smooth)?;
        log_evidences(Measured { values, sd }, spectra, &curves, &nuisances, watch)
    })?;
    let rows = spectra.len() / values.len().max(1);
    Ok(found?.into_pyarray(py).reshape([rows, nuisances.len()])?)
}

/// Response and stray light at every wavelength.
type Explained<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Response and stray light of one spectrum under one nuisance.
#[pyfunction]
fn inverse_explain<'py>(
    py: Python<'py>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    sd: PyReadonlyArray1<'py, f64>,
    spectrum: PyReadonlyArray1<'py, f64>,
    smooth: Vec<Curve>,
    nuisance: PyReadonlyArray2<'py, f64>,
) -> Result<Explained<'py>> {
    let of = Measured { values: values.as_slice()?, sd: sd.as_slice()? };
    let nuisances = nuisances(&nuisance)?;
    let curves = curves(wavelength_nm.as_slice()?, &smooth)?;
    let one = nuisances.first().ok_or_else(|| Error::value("no nuisance"))?;
    let spectrum = spectrum.as_slice()?;
    let found = released(py, || explain(of, spectrum, &curves, one))?;
    Ok((found.response.into_pyarray(py), found.stray.into_pyarray(py)))
}
