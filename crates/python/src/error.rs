//! The one place where errors become Python's exceptions.

use std::io::ErrorKind;

use iridesce::files::FileError;
use iridesce::flow::FlowError;
use iridesce::inverse::InverseError;
use iridesce::numerics::{Argument, Bounds};
use iridesce::optics::OpticsError;
use iridesce::render::RenderError;
use iridesce::scene::{ResolveError, SceneError};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// What `iridesce/errors.py` defines.
mod python {
    pyo3::import_exception!(iridesce.errors, ArgumentError);
    pyo3::import_exception!(iridesce.errors, ResourceError);
    pyo3::import_exception!(iridesce.errors, SceneError);
}

/// An exception. Every error of the crates becomes one by `?`, and this becomes Python's where a function returns.
#[derive(Debug)]
pub struct Error(PyErr);

/// What a function of the binding answers.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// `ValueError`.
    pub fn value(message: impl Into<String>) -> Error {
        Error(PyValueError::new_err(message.into()))
    }

    /// `iridesce.ResourceError`: something that cannot fit.
    pub fn resource(message: impl Into<String>) -> Error {
        Error(python::ResourceError::new_err((message.into(),)))
    }

    /// `RuntimeError`: a mistake of ours.
    pub fn internal(words: &str) -> Error {
        Error(PyRuntimeError::new_err(format!("internal error, please report it: {words}")))
    }
}

impl From<Error> for PyErr {
    fn from(error: Error) -> PyErr {
        error.0
    }
}

impl From<PyErr> for Error {
    fn from(error: PyErr) -> Error {
        Error(error)
    }
}

/// An array that Python was to make contiguous.
impl From<numpy::AsSliceError> for Error {
    fn from(error: numpy::AsSliceError) -> Error {
        Error(error.into())
    }
}

/// `iridesce.errors.ArgumentError`, a `ValueError` with the parts.
impl From<Argument> for Error {
    fn from(error: Argument) -> Error {
        let words = error.to_string();
        let Argument { argument, allowed, given, place } = error;
        Error(python::ArgumentError::new_err((words, argument.into_owned(), allowed.into_owned(), given, place)))
    }
}

impl From<OpticsError> for Error {
    fn from(error: OpticsError) -> Error {
        let message = error.to_string();
        match error {
            OpticsError::Parts(argument) => (*argument).into(),
            OpticsError::Resource(_) => Error::resource(message),
            // Who stopped it has an exception of his own, which is raised instead.
            OpticsError::Stopped => Error(PyRuntimeError::new_err(message)),
            _ => Error::value(message),
        }
    }
}

impl From<InverseError> for Error {
    fn from(error: InverseError) -> Error {
        let message = error.to_string();
        match error {
            InverseError::Memory(_) => Error::resource(message),
            InverseError::Stopped(_) => Error(PyRuntimeError::new_err(message)),
            InverseError::Argument(_) => Error::value(message),
        }
    }
}

impl From<FlowError> for Error {
    fn from(error: FlowError) -> Error {
        match error {
            FlowError::Parameter(argument) => argument.into(),
            _ => Error::value(error.to_string()),
        }
    }
}

impl From<SceneError> for Error {
    fn from(error: SceneError) -> Error {
        if error.is_resource {
            return Error::resource(error.to_string());
        }
        let place = |error: &SceneError| {
            let file = error.file.as_ref().map(|file| file.display().to_string());
            (error.first().to_string(), file, error.line, error.key.clone())
        };
        let others: Vec<_> = error.others.iter().map(place).collect();
        let (_, file, line, key) = place(&error);
        Error(python::SceneError::new_err((error.to_string(), file, line, key, others)))
    }
}

impl From<ResolveError> for Error {
    fn from(error: ResolveError) -> Error {
        match error {
            ResolveError::Scene(error) => error.into(),
            // Who stopped it has an exception of his own, which is raised instead.
            ResolveError::Stopped => Error(PyRuntimeError::new_err(error.to_string())),
        }
    }
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Error {
        let message = error.to_string();
        match error {
            RenderError::Resource(_) => Error::resource(message),
            RenderError::Optics(error) => error.into(),
            RenderError::Scene { message, key } => SceneError::new(message).at(key, None).into(),
            // Who stopped it has an exception of his own, which is raised instead.
            RenderError::Cancelled => Error(PyRuntimeError::new_err(message)),
            RenderError::File(error) => error.into(),
            _ => Error::value(message),
        }
    }
}

/// `OSError` with its errno, so that Python makes it `FileNotFoundError`, `PermissionError` and so on.
impl From<FileError> for Error {
    fn from(error: FileError) -> Error {
        match error {
            FileError::Write { path, source } => {
                let errno = source.raw_os_error().unwrap_or(match source.kind() {
                    ErrorKind::NotFound => 2,
                    ErrorKind::PermissionDenied => 13,
                    ErrorKind::NotADirectory => 20,
                    ErrorKind::IsADirectory => 21,
                    ErrorKind::InvalidInput => 22,
                    ErrorKind::StorageFull => 28,
                    ErrorKind::ReadOnlyFilesystem => 30,
                    _ => 5,
                });
                let message = format!("cannot be written: {source}");
                Error(PyOSError::new_err((errno, message, path.into_os_string())))
            }
            FileError::Parts(argument) => argument.into(),
            FileError::Cancelled => Error(PyRuntimeError::new_err(error.to_string())),
            _ => Error::value(error.to_string()),
        }
    }
}

/// The words of an error with parts, for the checks that Python makes: the same as those of the crates.
#[pyfunction]
fn argument_words(argument: String, allowed: String, given: &str, place: &str) -> String {
    Argument::new(argument, allowed, given).at(place).to_string()
}

/// What a finite number within bounds is called: `>= 0 and < 90`.
#[pyfunction]
fn range_words(low: f64, includes_low: bool, high: f64) -> String {
    Bounds { low, includes_low, high, ..Bounds::finite("") }.words()
}

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(argument_words, module)?)?;
    module.add_function(wrap_pyfunction!(range_words, module)?)
}
