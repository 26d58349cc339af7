//! The one way out of the interpreter lock: work runs on worker threads while the caller looks for Ctrl-C and tells progress.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use iridesce::numerics::{Progress, Watch, simd};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::pool::Lease;

/// How often a waiting caller looks for Ctrl-C and tells of progress.
const POLL: Duration = Duration::from_millis(30);

/// Elements that are not worth another thread, at a microsecond each.
const SHORT: usize = 1 << 10;

/// Elements between two looks at whether to stop: some milliseconds.
const CHUNK: usize = 1 << 13;

/// How a long call is to be run.
#[derive(Default)]
pub struct Long {
    /// Called as `progress(done, total, stage)` when there is news, some thirty times a second at most, and once at the end.
    pub progress: Option<Py<PyAny>>,
    /// Worker threads, as the user asked for; `None`: all cores, or `RAYON_NUM_THREADS`.
    pub threads: Option<usize>,
}

impl Long {
    /// On so many threads.
    pub fn threads(threads: Option<usize>) -> Long {
        Long { threads, ..Long::default() }
    }

    /// With its progress told.
    pub fn told(progress: Option<Py<PyAny>>) -> Long {
        Long { progress, ..Long::default() }
    }
}

/// Runs work that ends within some milliseconds, without the interpreter lock.
///
/// Not for work that uses rayon: outside a leased pool that would be rayon's own, which no child of a fork has.
pub fn released<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    py.detach(work)
}

/// Runs work of any length in a pool of its own ([`Lease`]), without the interpreter lock. The calling thread looks every
/// 30 ms for Ctrl-C and tells of progress; an exception from either stops the watch, and is the answer once the work has
/// noticed. So `work` asks its watch every 0.2 s at the latest, and holds no lock that other calls take.
pub fn beside<T: Send>(py: Python<'_>, how: Long, work: impl FnOnce(&Watch) -> T + Send) -> Result<T> {
    // Refused before any work, whatever the work is.
    simd::level().map_err(|error| Error::value(error.to_string()))?;
    let lease = Lease::new(py, how.threads)?;
    let watch = Watch::new();
    let mut told = Progress::default();
    let progress = how.progress;
    let mut tell = |py: Python<'_>| -> PyResult<()> {
        py.check_signals()?;
        let now = watch.progress();
        if let Some(progress) = &progress
            && (told.done, told.stage) != (now.done, now.stage)
            && now.done > 0
        {
            told = now;
            progress.call1(py, (now.done, now.total, now.stage))?;
        }
        Ok(())
    };
    tell(py)?;
    let pool = lease.pool();
    let outcome = py.detach(|| -> Result<T> {
        pool.in_place_scope(|scope| {
            let (sender, receiver) = channel();
            let watch = &watch;
            scope.spawn(move |_| {
                // A panic is our mistake, not the user's: it must not take the interpreter with it.
                let result = catch_unwind(AssertUnwindSafe(|| work(watch)));
                let _ = sender.send(result);
            });
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(Ok(result)) => return Ok(result),
                    Ok(Err(panic)) => return Err(internal(panic.as_ref())),
                    Err(RecvTimeoutError::Disconnected) => return Err(Error::internal("the worker vanished")),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(error) = Python::attach(&mut tell) {
                            watch.stop();
                            return Err(error.into()); // the scope waits for the work to notice
                        }
                    }
                }
            }
        })
    })?;
    tell(py)?;
    Ok(outcome)
}

/// Fills `out` with a function of every place, on all cores and without the interpreter lock, and hears Ctrl-C: arrays may have any
/// length. The error is that of the first place that has one.
pub fn fill<T: Send, E: Send>(
    py: Python<'_>,
    out: &mut [T],
    function: impl Fn(usize) -> std::result::Result<T, E> + Sync,
) -> Result<()>
where
    Error: From<E>,
{
    let run = |first: usize, part: &mut [T]| {
        part.iter_mut().enumerate().try_for_each(|(i, slot)| function(first + i).map(|value| *slot = value))
    };
    if out.len() <= SHORT {
        return Ok(released(py, || run(0, out))?);
    }
    let wrong = beside(py, Long::default(), |watch| {
        out.par_chunks_mut(CHUNK)
            .enumerate()
            .find_map_first(|(number, part)| if watch.is_stopped() { None } else { run(number * CHUNK, part).err() })
    })?;
    wrong.map_or(Ok(()), |error| Err(error.into()))
}

/// Takes a lock that another Python thread may hold for long, as the interpreter's is not held meanwhile and Ctrl-C is heard.
pub fn locked<'a, T>(py: Python<'_>, of: &'a Mutex<T>) -> Result<MutexGuard<'a, T>> {
    loop {
        match of.try_lock() {
            Ok(guard) => return Ok(guard),
            // A poisoned lock follows a panic, which has been reported; what it guards is as it was left.
            Err(TryLockError::Poisoned(poisoned)) => return Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                py.check_signals()?;
                py.detach(|| sleep(Duration::from_millis(2)));
            }
        }
    }
}

fn internal(panic: &(dyn Any + Send)) -> Error {
    let words = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    Error::internal(words.unwrap_or("unknown"))
}
