//! Worker threads that belong to the process.
//!
//! Threads do not survive a fork: a child that inherits a pool waits for ever for workers that are not there. So rayon's own
//! pool, which cannot be made anew, is never used; every call leases one from here, and a child of a fork finds none and
//! makes its own. Two calls at once (of two Python threads) lease two pools: a worker that waits may take up any job of its
//! pool, and a short call would end only with a long one that it had taken up.

use std::process;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

/// Idle pools that are kept: their threads sleep, but each has a stack.
const MOST_IDLE: usize = 4;

/// A pool and what it was made for.
struct Kept {
    process: u32,
    threads: Option<usize>,
    pool: ThreadPool,
}

/// Locked only with the interpreter lock held, so that no fork of Python's finds it locked by a thread that the child lacks.
static IDLE: Mutex<Vec<Kept>> = Mutex::new(Vec::new());

/// A pool of one call's own; it goes back when the lease ends. Not `Send`: it is taken and given back under the interpreter
/// lock.
pub struct Lease<'py> {
    kept: Option<Kept>,
    _py: Python<'py>,
}

impl<'py> Lease<'py> {
    /// `threads` workers; `None`: one a core, or as many as `RAYON_NUM_THREADS` says.
    pub fn new(py: Python<'py>, threads: Option<usize>) -> Result<Lease<'py>> {
        if threads == Some(0) {
            return Err(Error::value("threads must be at least 1, got 0"));
        }
        let process = process::id();
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        // Pools of a parent have no threads here: to end them would be to wait for these.
        idle.extract_if(.., |kept| kept.process != process).for_each(std::mem::forget);
        let found = idle.iter().rposition(|kept| kept.threads == threads).map(|place| idle.remove(place));
        drop(idle);
        let kept = match found {
            Some(kept) => kept,
            None => {
                let builder = ThreadPoolBuilder::new().thread_name(|_| "iridesce".into());
                let pool = builder.num_threads(threads.unwrap_or(0)).build().map_err(|error| {
                    Error::resource(match threads {
                        Some(threads) => format!("cannot start {threads} threads: {error}"),
                        None => format!("cannot start a thread for each core: {error}"),
                    })
                })?;
                Kept { process, threads, pool }
            }
        };
        Ok(Lease { kept: Some(kept), _py: py })
    }

    /// The pool.
    pub fn pool(&self) -> &ThreadPool {
        &self.kept.as_ref().expect("a lease holds its pool until it is dropped").pool
    }
}

impl Drop for Lease<'_> {
    fn drop(&mut self) {
        let Some(kept) = self.kept.take() else { return };
        if kept.process != process::id() {
            std::mem::forget(kept);
            return;
        }
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(kept);
        if idle.len() > MOST_IDLE {
            drop(idle.remove(0));
        }
    }
}

/// Worker threads that a call without `threads=` uses.
#[pyfunction]
fn threads(py: Python<'_>) -> Result<usize> {
    Ok(Lease::new(py, None)?.pool().current_num_threads())
}

/// Adds these names to `_core`.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(threads, module)?)
}
