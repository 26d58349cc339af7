//! Work that cannot ask a watch: it gets a thread of its own, which is left behind when the watch says stop.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use iridesce_numerics::{Stopped, Watch};

/// How often whoever waits looks at the watch.
const POLL: Duration = Duration::from_millis(20);

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoAnswer {
    /// The watch said stop.
    Stopped,
    /// The work panicked.
    Panicked,
    /// There is no thread to be had; in the words of the system.
    NoThread(String),
}

impl std::fmt::Display for NoAnswer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoAnswer::Stopped => Stopped.fmt(f),
            NoAnswer::Panicked => f.write_str("it is damaged"),
            NoAnswer::NoThread(why) => write!(f, "cannot start a thread for it: {why}"),
        }
    }
}

impl std::error::Error for NoAnswer {}

/// Does work of others (a decoder that does everything in one call) so that it can be stopped within 0.1 s.
///
/// The work owns what it needs, since it may outlive the call: it then ends by itself, and its answer is dropped. It must not
/// use rayon, whose own pool no child of a fork has.
///
/// ```
/// use iridesce_files::{NoAnswer, aside};
/// use iridesce_numerics::Watch;
/// let watch = Watch::new();
/// assert_eq!(aside(&watch, || 2 + 2), Ok(4));
/// assert_eq!(aside(&watch, || -> u8 { panic!("on purpose") }), Err(NoAnswer::Panicked));
/// watch.stop();
/// let long = || std::thread::sleep(std::time::Duration::from_secs(5));
/// let began = std::time::Instant::now();
/// assert_eq!(aside(&watch, long), Err(NoAnswer::Stopped));
/// assert!(began.elapsed().as_secs_f64() < 4.0);
/// ```
pub fn aside<T: Send + 'static>(watch: &Watch, work: impl FnOnce() -> T + Send + 'static) -> Result<T, NoAnswer> {
    let (sender, receiver) = sync_channel(1);
    let told = move || {
        // Nobody may be waiting any more.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
    };
    let thread = std::thread::Builder::new().name("iridesce".into());
    thread.spawn(told).map_err(|error| NoAnswer::NoThread(error.to_string()))?;
    loop {
        match receiver.recv_timeout(POLL) {
            Ok(answer) => return answer.map_err(|_| NoAnswer::Panicked),
            Err(RecvTimeoutError::Timeout) if watch.is_stopped() => return Err(NoAnswer::Stopped),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(NoAnswer::Panicked),
        }
    }
}
