//! Progress and stop of long work: one value, given to every call that can take longer than a moment.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Long work was asked to stop, and did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stopped")
    }
}

impl std::error::Error for Stopped {}

/// How far long work is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// What is being done, e.g. `rendering`; empty before anything has begun.
    pub stage: &'static str,
    /// Units of work that are done, in the stage's own unit (pixels, steps, nodes).
    pub done: u64,
    /// Units of work in all.
    pub total: u64,
}

/// A hand on long work: the worker tells how far it is and asks whether to go on; whoever else holds a clone reads the
/// one and decides the other, from any thread.
///
/// A stage is begun by one thread; its units are added by any. A worker asks often enough to end within 0.3 s.
///
/// ```
/// use iridesce_numerics::Watch;
/// let watch = Watch::new();
/// watch.begin("counting", 10);
/// watch.add(4);
/// assert_eq!((watch.progress().done, watch.progress().total), (4, 10));
/// assert!(watch.check().is_ok());
/// watch.clone().stop();
/// assert!(watch.check().is_err());
/// ```
#[derive(Debug, Clone, Default)]
pub struct Watch {
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    stage: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
    stop: AtomicBool,
}

impl Watch {
    /// Nothing begun, nothing stopped.
    pub fn new() -> Watch {
        Watch::default()
    }

    /// Asks the work to stop. It cannot be taken back.
    pub fn stop(&self) {
        self.state.stop.store(true, Ordering::Relaxed);
    }

    /// Whether the work should stop; as cheap as reading a number.
    #[inline]
    pub fn is_stopped(&self) -> bool {
        self.state.stop.load(Ordering::Relaxed)
    }

    /// [`Stopped`] once somebody asked for it: `watch.check()?` between two pieces of work.
    #[inline]
    pub fn check(&self) -> Result<(), Stopped> {
        if self.is_stopped() { Err(Stopped) } else { Ok(()) }
    }

    /// A new stage of `total` units, none of them done.
    pub fn begin(&self, stage: &'static str, total: u64) {
        *self.state.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
        self.state.done.store(0, Ordering::Relaxed);
        self.state.total.store(total, Ordering::Relaxed);
    }

    /// The stage turns out to have `total` units.
    pub fn expect(&self, total: u64) {
        self.state.total.store(total, Ordering::Relaxed);
    }

    /// `units` more are done.
    #[inline]
    pub fn add(&self, units: u64) {
        self.state.done.fetch_add(units, Ordering::Relaxed);
    }

    /// How far the work is.
    pub fn progress(&self) -> Progress {
        Progress {
            stage: *self.state.stage.lock().unwrap_or_else(PoisonError::into_inner),
            done: self.state.done.load(Ordering::Relaxed),
            total: self.state.total.load(Ordering::Relaxed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_is_watched_and_stopped_from_another_thread() {
        let watch = Watch::new();
        assert_eq!(watch.progress(), Progress::default());
        let worker = watch.clone();
        let counted = std::thread::scope(|scope| {
            let work = scope.spawn(move || {
                worker.begin("counting", u64::MAX);
                let mut counted = 0;
                while worker.check().is_ok() {
                    worker.add(1);
                    counted += 1;
                }
                counted
            });
            while watch.progress().done < 10 {
                std::thread::yield_now();
            }
            watch.stop();
            work.join().unwrap()
        });
        let Progress { stage, done, total } = watch.progress();
        assert_eq!((stage, done, total), ("counting", counted, u64::MAX));
        watch.begin("again", 3);
        assert_eq!(watch.progress(), Progress { stage: "again", done: 0, total: 3 });
        watch.expect(5);
        assert_eq!(watch.progress().total, 5);
        assert_eq!(watch.check(), Err(Stopped));
    }
}
