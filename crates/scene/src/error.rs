//! What is wrong with a scene, and why one was not resolved.

use std::fmt;
use std::path::{Path, PathBuf};

use iridesce_numerics::Stopped;

/// Why a scene cannot be used, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneError {
    /// What was wrong, what was given, what is allowed.
    pub message: String,
    /// The file it stands in; `None` for a scene that is no file.
    pub file: Option<PathBuf>,
    /// The line, counted from 1.
    pub line: Option<usize>,
    /// The key, dotted: `camera.fov_deg`, `object.bubble.shape`.
    pub key: Option<String>,
    /// Whether the scene is sound but too large for any machine.
    pub is_resource: bool,
    /// What else is wrong with the scene, in the order of reading.
    pub others: Vec<SceneError>,
}

/// Most complaints that are shown at once.
const MOST_SHOWN: usize = 20;

impl SceneError {
    /// A complaint that is not yet tied to a place.
    pub fn new(message: impl Into<String>) -> SceneError {
        SceneError {
            message: message.into(),
            file: None,
            line: None,
            key: None,
            is_resource: false,
            others: Vec::new(),
        }
    }

    /// The same, at a key and line.
    pub fn at(mut self, key: impl Into<String>, line: Option<usize>) -> SceneError {
        self.key = Some(key.into());
        self.line = line;
        self
    }

    /// The same, in a file.
    pub fn in_file(mut self, file: Option<&Path>) -> SceneError {
        self.file = file.map(Path::to_path_buf);
        self.others = self.others.into_iter().map(|other| other.in_file(file)).collect();
        self
    }

    /// All complaints as one, named by the first; `None` where there are none.
    pub fn of_all(faults: Vec<SceneError>) -> Option<SceneError> {
        let mut faults = faults.into_iter();
        let mut first = faults.next()?;
        first.others = faults.collect();
        Some(first)
    }

    /// Its own message with its place, without those of the others.
    pub fn first(&self) -> SceneError {
        SceneError { others: Vec::new(), ..self.clone() }
    }
}

impl fmt::Display for SceneError {
    /// `scenes/bubble.toml:11: message`, and a line for each of the others.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        }
        write!(f, "{}", self.message)?;
        for other in self.others.iter().take(MOST_SHOWN - 1) {
            write!(f, "\n{other}")?;
        }
        match self.others.len().saturating_sub(MOST_SHOWN - 1) {
            0 => Ok(()),
            more => write!(f, "\n... and {more} more"),
        }
    }
}

impl std::error::Error for SceneError {}

/// Why a scene was not resolved.
#[derive(Debug, Clone, PartialEq)]
pub enum ResolveError {
    /// Whoever watches said so.
    Stopped,
    /// A map cannot be used, or a film does not flow.
    Scene(SceneError),
}

impl fmt::Display for ResolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ResolveError::Stopped => Stopped.fmt(f),
            ResolveError::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ResolveError {}

impl From<SceneError> for ResolveError {
    fn from(error: SceneError) -> ResolveError {
        ResolveError::Scene(error)
    }
}

impl From<Stopped> for ResolveError {
    fn from(_: Stopped) -> ResolveError {
        ResolveError::Stopped
    }
}
