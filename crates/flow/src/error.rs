//! Why a film cannot flow, or not on.

use iridesce_thickness::ThicknessError;

/// Why a run cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// A number stopped being one.
    #[error("{field} is {value} at step {step}, {time_s} s, row {row}, column {column}; a shorter step_s may help")]
    NotFinite {
        /// Which field.
        field: &'static str,
        /// What it is.
        value: f64,
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        column: usize,
    },
    /// The film moves so fast that a step would need too many sub-steps.
    #[error(
        "step_s, {dt} s, is too long at step {step}, {time_s} s: {needed} sub-steps would be needed, {most} are allowed"
    )]
    StepTooLong {
        /// Step, s.
        dt: f64,
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
        /// Sub-steps that it would take.
        needed: f64,
        /// Most of them.
        most: f64,
    },
    /// The tension was not found.
    #[error(
        "the tension of the film is not found at step {step}, {time_s} s; a shorter step_s or a larger air_mass may help"
    )]
    Tension {
        /// Step, counted from 1.
        step: u64,
        /// Time, s.
        time_s: f64,
    },
    /// A parameter is not possible.
    #[error(transparent)]
    Parameter(#[from] ThicknessError),
    /// Whoever watches said so.
    #[error("the film was stopped")]
    Stopped,
    /// A checkpoint cannot be used.
    #[error("the checkpoint {0}")]
    Checkpoint(String),
}
