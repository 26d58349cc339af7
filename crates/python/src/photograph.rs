//! Bindings of the inverse stage's photographs: flat arrays in, flat arrays out.

use iridesce::inverse::{
    Exposure, FilmChannels, Neighbourhood, Photograph, Prior, Question, Sample, TOLD, Tie, agreement, exposures,
    map_thickness, neighbourhood, noise,
};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyReadonlyArray4, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside};

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(picture_noise, module)?)?;
    module.add_function(wrap_pyfunction!(picture_exposures, module)?)?;
    module.add_function(wrap_pyfunction!(picture_agreement, module)?)?;
    module.add_function(wrap_pyfunction!(picture_neighbourhood, module)?)?;
    module.add_function(wrap_pyfunction!(picture_thickness, module)?)
}

/// Gain, haze (3), noise (3 of a and b), unknown, shading, clip (3), cut at zero, temper, outlier.
fn exposure(row: &[f32]) -> Result<Exposure> {
    let &[gain, h0, h1, h2, a0, b0, a1, b1, a2, b2, unknown, shading, c0, c1, c2, cut, temper, outlier] = row else {
        return Err(Error::value(format!("an exposure has 18 numbers, got {}", row.len())));
    };
    Ok(Exposure {
        gain,
        haze: [h0, h1, h2],
        noise: [[a0, b0], [a1, b1], [a2, b2]],
        unknown,
        shading,
        clip: [c0, c1, c2],
        cut_at_zero: cut != 0.0,
        temper,
        outlier,
    })
}

fn films<'a>(channels: &'a PyReadonlyArray3<'_, f32>, first_nm: f32, step_nm: f32) -> Result<FilmChannels<'a>> {
    Ok(FilmChannels { first_nm, step_nm, channels: channels.as_slice()?, count: channels.shape()[2] })
}

/// A picture and what of it is left out.
struct Picture<'py> {
    pixels: PyReadonlyArray2<'py, f32>,
    width: usize,
    table_of: Option<PyReadonlyArray1<'py, u8>>,
    mask: Option<PyReadonlyArray1<'py, bool>>,
}

impl Picture<'_> {
    fn photograph(&self) -> Result<Photograph<'_>> {
        Ok(Photograph {
            pixels: self.pixels.as_slice()?,
            width: self.width,
            table_of: self.table_of.as_ref().map(|of| of.as_slice()).transpose()?,
            mask: self.mask.as_ref().map(|of| of.as_slice()).transpose()?,
        })
    }
}

/// Variance of each channel's noise, (3, 2): a + b value.
#[pyfunction]
fn picture_noise<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    width: usize,
    mask: Option<PyReadonlyArray1<'py, bool>>,
) -> Result<Bound<'py, PyArray2<f64>>> {
    let picture = Picture { pixels, width, table_of: None, mask };
    let of = picture.photograph()?;
    of.check(1)?;
    let found = beside(py, Long::default(), |_| noise(&of))?;
    Ok(found.as_flattened().to_vec().into_pyarray(py).reshape([3, 2])?)
}

/// For each camera and lamp the exposures that suit: gain, haze (3), cost, misfit, bias; a (found, 7) for each, best first.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "plain arrays of one picture")]
fn picture_exposures<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    table_of: Option<PyReadonlyArray1<'py, u8>>,
    channels: PyReadonlyArray4<'py, f32>,
    first_nm: f32,
    step_nm: f32,
    exposed: Vec<f32>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<Vec<Bound<'py, PyArray2<f64>>>> {
    let base = exposure(&exposed)?;
    let picture = Picture { pixels, width: 1, table_of, mask: None };
    let (views, angles, count) = (channels.shape()[0], channels.shape()[1], channels.shape()[3]);
    let of = picture.photograph()?;
    of.check(angles)?;
    let sample = Sample { pixels: of.pixels, table_of: of.table_of };
    let all = channels.as_slice()?;
    let found = beside(py, Long { progress, threads }, |watch| {
        watch.begin("exposure", views as u64);
        let mut every = Vec::with_capacity(views);
        for channels in all.chunks_exact(angles * 3 * count) {
            let films = FilmChannels { first_nm, step_nm, channels, count };
            let mut rows = Vec::new();
            for one in exposures(&films, &sample, &base, watch)? {
                let [h0, h1, h2] = one.exposure.haze.map(f64::from);
                rows.extend([f64::from(one.exposure.gain), h0, h1, h2, one.cost, one.misfit, one.bias]);
            }
            every.push(rows);
            watch.add(1);
        }
        Ok::<_, iridesce::inverse::InverseError>(every)
    })??;
    let arrays = found.into_iter().map(|rows| {
        let count = rows.len() / 7;
        Ok(rows.into_pyarray(py).reshape([count, 7])?)
    });
    arrays.collect()
}

/// Of each pixel the share of its likelihood within `reach_nm` of a thickness, (pixels,).
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "plain arrays of one picture")]
fn picture_agreement<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    table_of: Option<PyReadonlyArray1<'py, u8>>,
    channels: PyReadonlyArray3<'py, f32>,
    first_nm: f32,
    step_nm: f32,
    exposed: Vec<f32>,
    thickness_nm: PyReadonlyArray1<'py, f32>,
    reach_nm: f32,
) -> Result<Bound<'py, PyArray1<f32>>> {
    let of = exposure(&exposed)?;
    let picture = Picture { pixels, width: 1, table_of, mask: None };
    let photograph = picture.photograph()?;
    photograph.check(channels.shape()[0])?;
    let sample = Sample { pixels: photograph.pixels, table_of: photograph.table_of };
    let films = films(&channels, first_nm, step_nm)?;
    let nm = thickness_nm.as_slice()?;
    let found = beside(py, Long::default(), |_| agreement(&films, &sample, &of, nm, reach_nm))??;
    Ok(found.into_pyarray(py))
}

/// Temper, steps along rows and columns, whether the temper still grew.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "plain arrays of one picture")]
fn picture_neighbourhood<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    width: usize,
    table_of: Option<PyReadonlyArray1<'py, u8>>,
    mask: Option<PyReadonlyArray1<'py, bool>>,
    channels: PyReadonlyArray3<'py, f32>,
    first_nm: f32,
    step_nm: f32,
    exposed: Vec<f32>,
    quarter_nm: f32,
    threads: Option<usize>,
) -> Result<(f32, f32, f32, bool)> {
    let of = exposure(&exposed)?;
    let picture = Picture { pixels, width, table_of, mask };
    let photograph = picture.photograph()?;
    photograph.check(channels.shape()[0])?;
    let films = films(&channels, first_nm, step_nm)?;
    let found =
        beside(py, Long::threads(threads), |watch| neighbourhood(&films, &of, &photograph, quarter_nm, watch))??;
    Ok((found.temper, found.tau_nm[0], found.tau_nm[1], found.grows))
}

/// Best, sd and confidence (n,), candidates and weights (n, told), anchors (n,), which tie points were taken.
type MapArrays<'py> = (
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<u8>>,
    Vec<bool>,
);

/// Thickness and confidence of the frame before, and the mean step.
type PyPrior<'py> = (PyReadonlyArray1<'py, f32>, PyReadonlyArray1<'py, f32>, f32);

/// The thickness of every pixel of a picture.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "plain arrays of one picture")]
fn picture_thickness<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    width: usize,
    table_of: Option<PyReadonlyArray1<'py, u8>>,
    mask: Option<PyReadonlyArray1<'py, bool>>,
    channels: PyReadonlyArray3<'py, f32>,
    first_nm: f32,
    step_nm: f32,
    exposed: Vec<f32>,
    neighbours: (f32, f32, f32),
    quarter_nm: f32,
    ties: Vec<(usize, f32)>,
    prior: Option<PyPrior<'py>>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> Result<MapArrays<'py>> {
    let picture = Picture { pixels, width, table_of, mask };
    let (temper, across, down) = neighbours;
    let ties: Vec<Tie> = ties.into_iter().map(|(pixel, thickness_nm)| Tie { pixel, thickness_nm }).collect();
    let prior = prior.as_ref().map(|(nm, confidence, tau_nm)| {
        let (thickness_nm, confidence) = (nm.as_slice()?, confidence.as_slice()?);
        Ok::<_, Error>(Prior { thickness_nm, confidence, tau_nm: *tau_nm })
    });
    let ask = Question {
        films: films(&channels, first_nm, step_nm)?,
        exposure: exposure(&exposed)?,
        neighbourhood: Neighbourhood { temper, tau_nm: [across, down], grows: false },
        quarter_nm,
        ties: &ties,
        prior: prior.transpose()?,
    };
    let of = picture.photograph()?;
    let map = beside(py, Long { progress, threads }, |watch| map_thickness(&ask, &of, watch))??;
    let count = map.best_nm.len();
    Ok((
        map.best_nm.into_pyarray(py),
        map.sd_nm.into_pyarray(py),
        map.confidence.into_pyarray(py),
        map.candidates_nm.into_pyarray(py).reshape([count, TOLD])?,
        map.weights.into_pyarray(py).reshape([count, TOLD])?,
        map.anchor.into_pyarray(py),
        map.taken,
    ))
}
