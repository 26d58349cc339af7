//! Bindings of the color stage. Arrays arrive as flat rows of three, checked and broadcast by the Python module.

use std::sync::atomic::{AtomicU64, Ordering};

use iridesce::files::read_lamp;
use iridesce::numerics::Argument;
use iridesce::numerics::Watch;
use iridesce::optics::color::gamut::{Gamut, Mapping};
use iridesce::optics::color::{
    self, Adaptation, ColorRequest, Dias1991, DiasMatrix, DiasTable, Forced, Grid, Model, Observer, Quantity, Space,
    StackColor, Weights,
};
use iridesce::optics::medium::VISIBLE_NM;
use iridesce::optics::{Complex64, OpticsError, Polarization};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::files::{PyReport, plain};
use crate::interrupt::{Long, beside, fill};
use crate::medium::Medium;

/// Colours of one call of the core: more than a hundred tasks. The watch is asked within, but for the two-beam form: its
/// slices are short.
const SLICE: usize = 1 << 16;
const SLICE_TWO_BEAM: usize = 1 << 10;

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("VISIBLE_NM", VISIBLE_NM)?;
    module.add("REC709_LUMINANCE", color::REC709_LUMINANCE)?;
    module.add_class::<Illuminant>()?;
    module.add_function(wrap_pyfunction!(illuminant_names, module)?)?;
    module.add_function(wrap_pyfunction!(color_matching, module)?)?;
    module.add_function(wrap_pyfunction!(spectrum_to_xyz, module)?)?;
    module.add_function(wrap_pyfunction!(convert_color, module)?)?;
    module.add_function(wrap_pyfunction!(rgb_matrix, module)?)?;
    module.add_function(wrap_pyfunction!(delta_e, module)?)?;
    module.add_function(wrap_pyfunction!(map_gamut, module)?)?;
    module.add_function(wrap_pyfunction!(stack_color, module)?)?;
    module.add_function(wrap_pyfunction!(color_weights, module)?)?;
    module.add_function(wrap_pyfunction!(dias1991_wavelengths, module)?)?;
    module.add_function(wrap_pyfunction!(dias1991, module)?)
}

/// What optics answers.
type Answer<T> = std::result::Result<T, OpticsError>;

type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// Rows of three.
fn triples<'a>(values: &'a PyReadonlyArray2<'_, f64>) -> Result<&'a [[f64; 3]]> {
    let (rows, rest) = values.as_slice()?.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(Error::value("rows of three values are needed"));
    }
    Ok(rows)
}

/// A function of so many places, as rows of three.
fn rows<'py, E: Send>(
    py: Python<'py>,
    count: usize,
    function: impl Fn(usize) -> std::result::Result<[f64; 3], E> + Sync,
) -> Result<Rows<'py>>
where
    Error: From<E>,
{
    let made = PyArray2::zeros(py, [count, 3], false);
    fill(py, made.readwrite().as_slice_mut()?.as_chunks_mut::<3>().0, function)?;
    Ok(made)
}

/// The same of functions that always answer.
fn sure<T>(value: T) -> Result<T> {
    Ok(value)
}

/// A light source.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Illuminant {
    pub inner: color::Illuminant,
}

#[pymethods]
impl Illuminant {
    #[staticmethod]
    fn named(name: &str) -> Result<Illuminant> {
        Ok(Illuminant { inner: color::Illuminant::named(name)? })
    }

    /// The lamp in the bytes of a file, and how they were understood.
    #[staticmethod]
    fn from_bytes(bytes: &[u8], label: &str) -> Result<(Illuminant, PyReport)> {
        let (inner, report) = read_lamp(bytes, label).map_err(Error::value)?;
        Ok((Illuminant { inner }, plain(report)))
    }

    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    #[getter]
    fn lines(&self) -> Vec<(f64, f64)> {
        self.inner.lines().to_vec()
    }

    fn power<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray1<'py, f64>,
    ) -> Result<Bound<'py, PyArray1<f64>>> {
        let nm = wavelength_nm.as_slice()?;
        let power = PyArray1::zeros(py, nm.len(), false);
        fill(py, power.readwrite().as_slice_mut()?, |place| sure(self.inner.power(nm[place])))?;
        Ok(power)
    }

    fn white(&self, observer: &str) -> Result<[f64; 3]> {
        let [x, y, z] = self.inner.white(Observer::named(observer)?);
        Ok([x / y, 1.0, z / y])
    }
}

#[pyfunction]
fn illuminant_names() -> Vec<&'static str> {
    color::illuminant_names().collect()
}

#[pyfunction]
fn color_matching<'py>(
    py: Python<'py>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    observer: &str,
) -> Result<Rows<'py>> {
    let observer = Observer::named(observer)?;
    let nm = wavelength_nm.as_slice()?;
    rows(py, nm.len(), |place| sure(observer.at(nm[place])))
}

#[pyfunction]
fn spectrum_to_xyz<'py>(
    py: Python<'py>,
    wavelength_nm: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray2<'py, f64>,
    illuminant: PyRef<'py, Illuminant>,
    observer: &str,
) -> Result<Rows<'py>> {
    let grid = Grid::through(wavelength_nm.as_slice()?)?;
    let observer = Observer::named(observer)?;
    let weights = Weights::new(&grid, &illuminant.inner, observer)?;
    let spectra = values.as_slice()?;
    let spectrum = |place: usize| &spectra[place * grid.count..][..grid.count];
    rows(py, spectra.len() / grid.count, |place| weights.sum(&grid, spectrum(place)))
}

#[pyfunction]
fn convert_color<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    from_space: &str,
    to_space: &str,
    white: [f64; 3],
    adaptation: Option<&str>,
) -> Result<Rows<'py>> {
    let space = Space::named;
    let (from, to, adaptation) = (space(from_space)?, space(to_space)?, Adaptation::named(adaptation)?);
    let values = triples(&values)?;
    rows(py, values.len(), |place| sure(to.from_xyz(from.to_xyz(values[place], white, adaptation), white, adaptation)))
}

#[pyfunction]
fn rgb_matrix(space: &str) -> Result<Option<[[f64; 3]; 3]>> {
    Ok(Space::named(space)?.rgb_from_xyz())
}

#[pyfunction]
fn delta_e<'py>(
    py: Python<'py>,
    lab_a: PyReadonlyArray2<'py, f64>,
    lab_b: PyReadonlyArray2<'py, f64>,
) -> Result<Bound<'py, PyArray1<f64>>> {
    let (a, b) = (triples(&lab_a)?, triples(&lab_b)?);
    let differences = PyArray1::zeros(py, a.len().min(b.len()), false);
    fill(py, differences.readwrite().as_slice_mut()?, |place| sure(color::ciede2000(a[place], b[place])))?;
    Ok(differences)
}

/// Maps colours of an RGB space (encoded where the space is) into its gamut; the number that were outside.
#[pyfunction]
fn map_gamut<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    space: &str,
    gamut: &str,
) -> Result<(Rows<'py>, u64)> {
    let space = Space::named(space)?;
    let mapping = Mapping::named(gamut)?;
    let Some(gamut) = Gamut::new(space, mapping) else {
        return Err(Error::value(format!("a gamut mapping needs an RGB space, got {:?}", space.name())));
    };
    let values = triples(&values)?;
    let outside = AtomicU64::new(0);
    let mapped = rows(py, values.len(), |place| {
        let (value, out) = gamut.map_encoded(space, values[place]);
        outside.fetch_add(u64::from(out), Ordering::Relaxed);
        sure(value)
    })?;
    Ok((mapped, outside.into_inner()))
}

/// Colours of a stack: `thickness_nm` (points, layers), `angle_deg` (points), into `out` (points, 3). Returns the names of
/// media whose extension was used, and on a forced grid the largest fringe measure and the coherent nm of its point.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one call carries the whole request")]
fn stack_color<'py>(
    py: Python<'py>,
    media: Vec<PyRef<'py, Medium>>,
    coherent: Vec<bool>,
    thickness_nm: PyReadonlyArray2<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    polarization: &str,
    illuminant: PyRef<'py, Illuminant>,
    observer: &str,
    space: &str,
    quantity: &str,
    model: &str,
    wavelength_nm: Option<PyReadonlyArray1<'py, f64>>,
    adaptation: Option<&str>,
    gamut: Option<&str>,
    mut out: PyReadwriteArray2<'py, f64>,
) -> Result<(Vec<String>, f64, f64)> {
    let request = || -> Answer<ColorRequest> {
        Ok(ColorRequest {
            media: media.iter().map(|medium| medium.inner.clone()).collect(),
            coherent,
            illuminant: illuminant.inner.clone(),
            observer: Observer::named(observer)?,
            polarization: Polarization::named(polarization)?,
            quantity: Quantity::named(quantity)?,
            model: Model::named(model)?,
            grid: match &wavelength_nm {
                Some(nm) => Some(Grid::through(nm.as_slice().unwrap_or_default())?),
                None => None,
            },
            space: Space::named(space)?,
            adaptation: Adaptation::named(adaptation)?,
            gamut: gamut.map(Mapping::named).transpose()?,
        })
    };
    let request = request()?;
    let layers = request.coherent.len();
    let slice = if request.model == Model::TwoBeam { SLICE_TWO_BEAM } else { SLICE };
    let (thickness, angle) = (thickness_nm.as_slice()?, angle_deg.as_slice()?);
    if thickness.len() != angle.len() * layers {
        return Err(Error::value("thicknesses and angles do not belong together"));
    }
    let (rows, _) = out.as_slice_mut()?.as_chunks_mut::<3>();
    if rows.len() != angle.len() {
        return Err(Error::value("angles and colours do not belong together"));
    }
    let work = |watch: &Watch| -> Answer<(Vec<String>, Forced)> {
        let made = StackColor::new(request)?;
        let mut forced = Forced::default();
        for done in (0..angle.len()).step_by(slice).take_while(|_| !watch.is_stopped()) {
            let end = angle.len().min(done + slice);
            let colors = made.colors_watched(&thickness[done * layers..end * layers], &angle[done..end], watch)?;
            rows[done..end].copy_from_slice(&colors.values);
            if colors.forced.steps > forced.steps {
                forced = colors.forced;
            }
        }
        Ok((made.extended(), forced))
    };
    let (extended, forced) = beside(py, Long::default(), work)??;
    Ok((extended, forced.steps, forced.thickness_nm))
}

#[pyfunction]
fn dias1991_wavelengths<'py>(py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
    color::dias1991_wavelengths().collect::<Vec<_>>().into_pyarray(py)
}

/// `indices` (40, 3) complex; `matrix` a name or nine numbers by rows.
#[pyfunction]
fn dias1991<'py>(
    py: Python<'py>,
    indices: PyReadonlyArray2<'py, Complex64>,
    thickness_nm: PyReadonlyArray1<'py, f64>,
    angle_deg: PyReadonlyArray1<'py, f64>,
    table: &str,
    matrix: MatrixArgument,
) -> Result<(Rows<'py>, Rows<'py>)> {
    let table = match table {
        "printed" => DiasTable::Printed,
        "full" => DiasTable::Full,
        _ => return Err(Argument::one_of("table", &["printed", "full"], table).into()),
    };
    let matrix = match matrix {
        MatrixArgument::Given(matrix) => DiasMatrix::Given(matrix),
        MatrixArgument::Named(name) => match name.as_str() {
            "printed" => DiasMatrix::Printed,
            "full" => DiasMatrix::Full,
            _ => {
                let allowed = "\"printed\", \"full\" or a 3 x 3 array";
                return Err(Argument::new("matrix", allowed, format!("{name:?}")).into());
            }
        },
    };
    let (indices, _) = indices.as_slice()?.as_chunks::<3>();
    let film = Dias1991::new(indices, table, matrix)?;
    let (thickness_nm, angle_deg) = (thickness_nm.as_slice()?, angle_deg.as_slice()?);
    let count = thickness_nm.len().min(angle_deg.len());
    let mut both = vec![([0.0; 3], [0.0; 3]); count];
    fill(py, &mut both, |place| film.color(thickness_nm[place], angle_deg[place]))?;
    Ok((rows(py, count, |place| sure(both[place].0))?, rows(py, count, |place| sure(both[place].1))?))
}

#[derive(FromPyObject)]
enum MatrixArgument {
    Named(String),
    Given([[f64; 3]; 3]),
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
) -> Result<Weighted<'py>> {
    let grid = match wavelength_nm {
        Some(given) => Grid::through(given.as_slice()?)?,
        None => Grid::default(),
    };
    let observer = Observer::named(observer)?;
    let weights = Weights::new(&grid.divided(parts.clamp(1, 1 << 16)), &illuminant.inner, observer)?;
    let count = weights.wavelength_nm.len();
    let of_grid = weights.grid_index.iter().filter(|index| index.is_some()).count();
    let xyz = weights.xyz.into_flattened().into_pyarray(py).reshape([count, 3])?;
    Ok((weights.wavelength_nm.into_pyarray(py), xyz, weights.white, of_grid))
}
