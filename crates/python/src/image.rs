//! Bindings of pictures: developed, and written into files.

use std::path::{Path, PathBuf};

use iridesce::files::{self, BitDepth, Fact, OutputSpace, Packing, Picture, Plane, Values};
use iridesce::optics::color::gamut::Mapping;
use iridesce::render::image::{self, Development};
use numpy::{
    PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside, released};

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(develop_image, module)?)?;
    module.add_function(wrap_pyfunction!(auto_exposure, module)?)?;
    module.add_function(wrap_pyfunction!(save_png, module)?)?;
    module.add_function(wrap_pyfunction!(png_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(save_exr, module)?)?;
    module.add_function(wrap_pyfunction!(load_exr, module)?)?;
    module.add_function(wrap_pyfunction!(check_output, module)?)?;
    module.add_function(wrap_pyfunction!(write_file, module)?)
}

/// `(rgb, out_of_gamut, overexposed)`; `xyz` contiguous.
#[pyfunction]
fn develop_image<'py>(
    py: Python<'py>,
    xyz: PyReadonlyArray3<'py, f32>,
    space: &str,
    exposure: f64,
    gamut: &str,
) -> Result<(Bound<'py, PyArray3<f32>>, f64, f64)> {
    let gamut = Mapping::named(gamut)?;
    let how = Development { space: OutputSpace::named(space)?, exposure, gamut };
    let shape: [usize; 3] = [xyz.shape()[0], xyz.shape()[1], xyz.shape()[2]];
    let values = xyz.as_slice()?;
    let developed = beside(py, Long::default(), |watch| image::develop(values, &how, &|| watch.is_stopped()))??;
    let rgb = PyArray1::from_vec(py, developed.rgb).reshape(shape)?;
    Ok((rgb, developed.out_of_gamut, developed.overexposed))
}

/// Stops.
#[pyfunction]
fn auto_exposure(py: Python<'_>, xyz: PyReadonlyArray3<'_, f32>, depth: PyReadonlyArray2<'_, f32>) -> Result<f64> {
    let (xyz, depth) = (xyz.as_slice()?, depth.as_slice()?);
    Ok(beside(py, Long::default(), |watch| image::auto_exposure(xyz, depth, &|| watch.is_stopped()))??)
}

#[derive(FromPyObject)]
pub enum PyFact {
    Integer(i32),
    Number(f64),
    Text(String),
}

pub fn facts(facts: Vec<(String, PyFact)>) -> Vec<(String, Fact)> {
    let fact = |fact| match fact {
        PyFact::Integer(value) => Fact::Integer(value),
        PyFact::Number(value) => Fact::Number(value),
        PyFact::Text(value) => Fact::Text(value),
    };
    facts.into_iter().map(|(name, value)| (name, fact(value))).collect()
}

/// Width and height of an array, rows first.
fn sides(shape: &[usize]) -> Result<(u32, u32)> {
    match (u32::try_from(shape[1]), u32::try_from(shape[0])) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(Error::value(format!("at most {} pixels a side, got shape {shape:?}", u32::MAX))),
    }
}

#[pyfunction]
fn save_png(
    py: Python<'_>,
    path: PathBuf,
    rgb: PyReadonlyArray3<'_, f32>,
    bits: u8,
    space: &str,
    facts_: Vec<(String, PyFact)>,
    is_quick: bool,
) -> Result<()> {
    let packing = if is_quick { Packing::Quick } else { Packing::Small };
    let bits = match bits {
        8 => BitDepth::Eight,
        16 => BitDepth::Sixteen,
        _ => return Err(Error::value(format!("bits must be 8 or 16, got {bits}"))),
    };
    let space = OutputSpace::named(space)?;
    let (width, height) = sides(rgb.shape())?;
    let (values, facts) = (rgb.as_slice()?, facts(facts_));
    beside(py, Long::default(), |watch| {
        files::write_png(&path, width, height, values, bits, packing, space, &facts, &|| watch.is_stopped())
    })??;
    Ok(())
}

#[pyfunction]
fn png_bytes(py: Python<'_>, rgb: PyReadonlyArray3<'_, f32>, space: &str) -> Result<Vec<u8>> {
    let space = OutputSpace::named(space)?;
    let (width, height) = sides(rgb.shape())?;
    let values = rgb.as_slice()?;
    Ok(beside(py, Long::default(), |_| files::png_bytes(width, height, values, space))??)
}

/// A plane: the names of its channels, its numbers, and whether floats are to be halves.
#[derive(FromPyObject)]
struct PyPlane<'py>(Vec<String>, PyValues<'py>, bool);

#[derive(FromPyObject)]
enum PyValues<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Whole(PyReadonlyArrayDyn<'py, u32>),
}

#[pyfunction]
fn save_exr(
    py: Python<'_>,
    path: PathBuf,
    xyz: PyReadonlyArray3<'_, f32>,
    is_half: bool,
    planes: Vec<PyPlane<'_>>,
    facts_: Vec<(String, PyFact)>,
) -> Result<()> {
    let (width, height) = sides(xyz.shape())?;
    let mut borrowed = Vec::new();
    for PyPlane(channels, values, is_half) in &planes {
        let values = match values {
            PyValues::Single(values) if *is_half => Values::Half(values.as_slice()?),
            PyValues::Single(values) => Values::Single(values.as_slice()?),
            PyValues::Whole(values) => Values::Whole(values.as_slice()?),
        };
        borrowed.push(Plane { channels: channels.clone(), values });
    }
    let picture = Picture { width, height, xyz: xyz.as_slice()?, is_half, planes: borrowed };
    let facts = facts(facts_);
    beside(py, Long::default(), |watch| files::write_exr(&path, &picture, &facts, &|| watch.is_stopped()))??;
    Ok(())
}

type PyRead<'py> = (Vec<(String, Bound<'py, PyArray2<f32>>, bool)>, Bound<'py, PyDict>, Option<[f32; 8]>);

/// Every channel of the first part of an OpenEXR file (name, values, whether they are whole numbers), its words and numbers,
/// and x, y of its primaries and white.
#[pyfunction]
fn load_exr<'py>(py: Python<'py>, bytes: &[u8]) -> Result<PyRead<'py>> {
    let read = beside(py, Long::default(), |watch| files::open_exr(bytes, watch))?.map_err(Error::value)?;
    let mut channels = Vec::new();
    for channel in read.channels.into_iter().filter(|channel| channel.part == 0) {
        let values = PyArray1::from_vec(py, channel.values).reshape([channel.height, channel.width])?;
        channels.push((channel.short, values, channel.is_whole));
    }
    let facts = PyDict::new(py);
    for (name, fact) in read.facts {
        match fact {
            Fact::Text(words) => facts.set_item(name, words)?,
            Fact::Integer(value) => facts.set_item(name, value)?,
            Fact::Number(value) => facts.set_item(name, value)?,
        }
    }
    let corners = read.chromaticities.map(|c| {
        let [red, green, blue, white] = [c.red, c.green, c.blue, c.white];
        [red.0, red.1, green.0, green.1, blue.0, blue.1, white.0, white.1]
    });
    Ok((channels, facts, corners))
}

/// Raises what saving to this path would raise.
#[pyfunction]
fn check_output(path: PathBuf) -> Result<()> {
    Ok(files::check_output(Path::new(&path))?)
}

/// Writes a file, whole or not at all.
#[pyfunction]
fn write_file(py: Python<'_>, path: PathBuf, bytes: &[u8]) -> Result<()> {
    Ok(released(py, || files::write_bytes(Path::new(&path), bytes))?)
}
