//! What every stage computes with, and no physics: numbers, and how long work is watched.

pub mod watch;

pub use watch::{Progress, Stopped, Watch};
