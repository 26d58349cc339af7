//! Bindings of the scene stage.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use iridesce::flow::FilmRun;
use iridesce::scene::{
    Context, Node, Origin, Scene as CoreScene, SceneError, Value, builtin_names, builtin_text, json_schema, resolve,
};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{
    PyBool, PyBytes, PyComplex, PyComplexMethods, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple,
};

use crate::error::{Error, Result};
use crate::interrupt::{Long, beside};

/// Deepest nesting of a dict: beyond it Python's own recursion is in danger.
const MAX_DEPTH: usize = 64;
/// Longest list: objects may be many, and nothing else is.
const MAX_ITEMS: usize = 100_000;

/// Positions (n, 3), normals (n, 3) and u, v (n, 2) if the file has them, thickness (n,) nm likewise, corners (m, 3).
type PyMesh<'py> = (
    Bound<'py, PyArray2<f64>>,
    Option<Bound<'py, PyArray2<f32>>>,
    Option<Bound<'py, PyArray2<f32>>>,
    Option<Vec<f32>>,
    Bound<'py, PyArray2<u32>>,
    Vec<String>,
);

/// A validated scene, with what it and its relatives have read and let flow.
#[pyclass(frozen, module = "iridesce._core")]
pub struct Scene {
    /// The scene.
    pub inner: CoreScene,
    /// Shared by all scenes that were made from one by `with_value`.
    pub context: Arc<Context>,
}

#[pymethods]
impl Scene {
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> Result<Scene> {
        Scene::new(beside(py, Long::default(), |_| CoreScene::builtin(name))??)
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, allow_outside: bool) -> Result<Scene> {
        Scene::new(beside(py, Long::default(), |_| CoreScene::load(Path::new(&path), allow_outside))??)
    }

    #[staticmethod]
    fn from_dict(
        py: Python<'_>,
        tree: &Bound<'_, PyMapping>,
        folder: PathBuf,
        file: Option<PathBuf>,
        allow_outside: bool,
    ) -> Result<Scene> {
        let node = to_node(tree.as_any(), "", 0)?;
        let origin = Origin { file, folder: Some(folder), allow_outside };
        Scene::new(beside(py, Long::default(), |_| CoreScene::from_node(&node, origin))??)
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_node(py, self.inner.tree())
    }

    fn to_json(&self) -> String {
        self.inner.to_json().to_string()
    }

    fn with_value(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> Result<Scene> {
        let value = to_node(value, path, 0)?;
        Ok(Scene {
            inner: beside(py, Long::default(), |_| self.inner.with_value(path, value))??,
            context: self.context.clone(),
        })
    }

    /// Reads the maps and lets the films flow, so that a render need not.
    fn resolve(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> Result<()> {
        let resolved = beside(py, Long::told(progress), |watch| resolve(&self.inner, &self.context, watch))?;
        resolved?;
        Ok(())
    }

    /// The mesh of an object in scene units, if its shape is one, and where the object is put, (instances, 3, 4).
    fn body<'py>(&self, py: Python<'py>, object: usize) -> Result<(Option<PyMesh<'py>>, Bound<'py, PyArray3<f64>>)> {
        let (mesh, placements) = beside(py, Long::default(), |watch| self.context.body(&self.inner, object, watch))??;
        let rows: Vec<f64> = placements.iter().flat_map(|by| by.rows).flatten().collect();
        let placements = rows.into_pyarray(py).reshape([placements.len(), 3, 4])?;
        let Some(mesh) = mesh else { return Ok((None, placements)) };
        let flat = |list: &[[f32; 3]]| list.iter().flatten().copied().collect::<Vec<f32>>().into_pyarray(py);
        let count = mesh.positions.len();
        let positions: Vec<f64> = mesh.positions.iter().flatten().copied().collect();
        let normals = mesh.normals.as_deref().map(|list| flat(list).reshape([count, 3])).transpose()?;
        let uv = mesh
            .uv
            .as_deref()
            .map(|list| list.iter().flatten().copied().collect::<Vec<f32>>().into_pyarray(py).reshape([count, 2]));
        let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        let triangles = corners.into_pyarray(py).reshape([mesh.triangles.len(), 3])?;
        let positions = positions.into_pyarray(py).reshape([count, 3])?;
        let parts = (positions, normals, uv.transpose()?, mesh.thickness_nm.clone(), triangles, mesh.notes.clone());
        Ok((Some(parts), placements))
    }

    /// A film that flowed for this scene or a relative, where it stands now, to be given to `stand`.
    fn standing<'py>(
        &self,
        py: Python<'py>,
        preset: &str,
        seed: u64,
        columns: Option<usize>,
    ) -> Result<Option<Bound<'py, PyBytes>>> {
        let film = FilmRun::new(preset, seed, columns)?;
        let bytes = beside(py, Long::default(), |_| self.context.films().standing(&film))?;
        Ok(bytes.map(|bytes| PyBytes::new(py, &bytes)))
    }

    /// Lets a film of this scene and its relatives go on from where one stood.
    fn stand(&self, py: Python<'_>, preset: &str, seed: u64, columns: Option<usize>, bytes: Vec<u8>) -> Result<()> {
        let film = FilmRun::new(preset, seed, columns)?;
        Ok(beside(py, Long::default(), |_| self.context.films().stand(&film, &bytes))??)
    }

    /// Whether a stated extension of a medium's data is used somewhere in 360..830 nm, and by which medium.
    fn extended_media(&self) -> Vec<String> {
        self.inner.extended_media()
    }

    /// The films that are layers of the faces of bodies: (film, body) by the numbers of the objects.
    fn films_on_faces(&self) -> Vec<(usize, usize)> {
        self.inner.films_on_faces().into_iter().map(|lies| (lies.film, lies.body)).collect()
    }

    /// What whoever renders the scene should be told.
    fn notes(&self) -> Vec<String> {
        self.inner.notes()
    }

    #[getter]
    fn file(&self) -> Option<PathBuf> {
        self.inner.origin().file.clone()
    }

    #[getter]
    fn folder(&self) -> Option<PathBuf> {
        self.inner.origin().folder.clone()
    }

    #[getter]
    fn allow_outside(&self) -> bool {
        self.inner.origin().allow_outside
    }
}

impl Scene {
    /// A scene that nothing has been read for yet.
    fn new(inner: CoreScene) -> Result<Scene> {
        Ok(Scene { inner, context: Arc::default() })
    }
}

/// A Python value as part of a scene; numpy numbers and arrays count as numbers and lists.
fn to_node(value: &Bound<'_, PyAny>, path: &str, depth: usize) -> Result<Node> {
    if depth > MAX_DEPTH {
        return Err(wrong_at(path, format!("nested deeper than {MAX_DEPTH} levels")));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::Text(text_of(text, path)?).into());
    }
    if let Ok(table) = value.cast::<PyMapping>() {
        return table_node(table, path, depth);
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Bool(flag.is_true()).into());
    }
    if value.is_instance_of::<PyInt>() {
        // Whole numbers beyond 128 bits are as wrong as any other that large.
        return Ok(value.extract::<i128>().map_or_else(|_| Value::Float(f64::INFINITY), Value::Int).into());
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?).into());
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        return list_node(value, path, depth);
    }
    if let Some(plain) = plain_value(value, path)? {
        return to_node(&plain, path, depth + 1);
    }
    if let Ok(pair) = value.cast::<PyComplex>() {
        return Ok(Value::List(vec![Node::number(pair.real()), Node::number(pair.imag())]).into());
    }
    // The validator says what is allowed here.
    Ok(Value::Other(if value.is_none() {
        "None".into()
    } else {
        format!("a value of type {}", value.get_type().name()?)
    })
    .into())
}

fn table_node(table: &Bound<'_, PyMapping>, path: &str, depth: usize) -> Result<Node> {
    let mut entries = Vec::new();
    // A copy: what converts one item may be Python code that changes the table.
    for pair in table.items()? {
        let (key, item): (Bound<'_, PyAny>, Bound<'_, PyAny>) = pair.extract()?;
        let Ok(key) = key.cast::<PyString>() else {
            let kind = key.get_type().name()?;
            return Err(wrong_at(path, format!("keys of a scene are texts, got one of type {kind}")));
        };
        let key = text_of(key, path)?;
        let node = to_node(&item, &below(path, &key), depth + 1)?;
        entries.push((key, node));
    }
    Ok(Value::Table(entries).into())
}

fn list_node(list: &Bound<'_, PyAny>, path: &str, depth: usize) -> Result<Node> {
    check_length(list.len()?, path)?;
    let mut items = Vec::new();
    for (i, item) in list.try_iter()?.enumerate() {
        items.push(to_node(&item?, &below(path, &i.to_string()), depth + 1)?);
    }
    Ok(Value::List(items).into())
}

/// What thickness models, paths, numpy scalars and arrays say of themselves in plain values.
fn plain_value<'py>(value: &Bound<'py, PyAny>, path: &str) -> Result<Option<Bound<'py, PyAny>>> {
    if value.hasattr("to_scene")? {
        return Ok(Some(value.call_method0("to_scene")?));
    }
    if value.hasattr("__fspath__")? {
        return Ok(Some(value.py().import("os")?.call_method1("fspath", (value,))?));
    }
    if value.hasattr("tolist")? {
        if let Ok(size) = value.getattr("size").and_then(|size| size.extract::<usize>()) {
            check_length(size, path)?;
        }
        return Ok(Some(value.call_method0("tolist")?));
    }
    Ok(None)
}

fn below(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn wrong_at(path: &str, message: String) -> Error {
    let error = SceneError::new(message);
    if path.is_empty() { error.into() } else { error.at(path, None).into() }
}

fn text_of(text: &Bound<'_, PyString>, path: &str) -> Result<String> {
    text.to_str().map(str::to_owned).map_err(|_| wrong_at(path, "a text of a scene must be Unicode".to_owned()))
}

fn check_length(length: usize, path: &str) -> Result<()> {
    if length <= MAX_ITEMS {
        return Ok(());
    }
    Err(wrong_at(path, format!("a list of a scene has at most {MAX_ITEMS} entries, got {length}")))
}

fn from_node<'py>(py: Python<'py>, node: &Node) -> PyResult<Bound<'py, PyAny>> {
    Ok(match &node.value {
        Value::Bool(b) => PyBool::new(py, *b).to_owned().into_any(),
        Value::Int(i) => i.into_pyobject(py)?.into_any(),
        Value::Float(f) => f.into_pyobject(py)?.into_any(),
        Value::Text(t) => t.into_pyobject(py)?.into_any(),
        // A validated scene holds none.
        Value::Other(_) => py.None().into_bound(py),
        Value::List(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(from_node(py, item)?)?;
            }
            list.into_any()
        }
        Value::Table(entries) => {
            let table = PyDict::new(py);
            for (key, item) in entries {
                table.set_item(key, from_node(py, item)?)?;
            }
            table.into_any()
        } // A validated scene holds none.
    })
}

/// The scene language as a JSON Schema.
#[pyfunction]
fn scene_schema() -> String {
    json_schema().to_string()
}

/// Names of the built-in scenes.
#[pyfunction]
fn scene_names() -> Vec<&'static str> {
    builtin_names().collect()
}

/// The text of a built-in scene.
#[pyfunction]
fn scene_text(name: &str) -> Result<&'static str> {
    Ok(builtin_text(name)?)
}

/// Adds this stage's names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Scene>()?;
    module.add_function(wrap_pyfunction!(scene_schema, module)?)?;
    module.add_function(wrap_pyfunction!(scene_names, module)?)?;
    module.add_function(wrap_pyfunction!(scene_text, module)?)
}
