//! All that changes in time.

use crate::events::{Clock, Spot};

/// Where liquid went, m3. Together with the film's own volume it stays what it was at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Books {
    /// Film at the start.
    pub start: f64,
    /// Into the air.
    pub evaporated: f64,
    /// Into the meniscus, by marginal regeneration.
    pub swallowed: f64,
    /// Out of film that turned black.
    pub blackened: f64,
    /// Down between the faces, out at the rim.
    pub drained: f64,
}

impl Books {
    /// All that left the film, m3.
    pub fn gone(&self) -> f64 {
        self.evaporated + self.swallowed + self.blackened + self.drained
    }
}

/// A film at one time in a few numbers. Volumes are shares of the film's own at the start, so that `mean_nm` over the
/// first one and the four shares sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Time, s.
    pub time_s: f64,
    /// Mean thickness over the area, nm.
    pub mean_nm: f64,
    /// Least thickness of a cell, nm.
    pub min_nm: f64,
    /// Greatest, nm.
    pub max_nm: f64,
    /// Share of the area that is black film, or thinner than `black_below_m`.
    pub black_share: f64,
    /// Into the air.
    pub evaporated: f64,
    /// Into the meniscus.
    pub swallowed: f64,
    /// Out of film that turned black.
    pub blackened: f64,
    /// Down between the faces.
    pub drained: f64,
}

/// All that changes in time; see [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Mean thickness of cells, m.
    pub h: Vec<f64>,
    /// Share of each cell that is black film; empty until some is. The rest of a cell is `(h - share b) / (1 - share)` thick,
    /// with the thickness b of black film.
    pub black: Vec<f64>,
    /// ln(Gamma / Gamma_0) of the surfactant, at the middles of cells.
    pub s: Vec<f64>,
    /// Velocity down through the upper sides of cells, one row more, m/s.
    pub down: Vec<f64>,
    /// Velocity across through the right sides of cells, m/s.
    pub across: Vec<f64>,
    /// Last solution of the tension.
    pub(crate) q: Vec<f64>,
    /// Steps so far.
    pub step: u64,
    /// Time, s.
    pub time_s: f64,
    /// Where liquid went.
    pub books: Books,
    /// Surfactant in all, in areas at Gamma_0, m2.
    pub(crate) surfactant: f64,
    pub(crate) patch_clock: Clock,
    pub(crate) spot_clock: Clock,
    pub(crate) rupture_clock: Clock,
    pub(crate) patches: Vec<Spot>,
    pub(crate) spots: Vec<Spot>,
    /// When the film burst, s.
    pub ruptured_s: Option<f64>,
    /// What the last step leaves to the next, for steps of second order.
    pub(crate) memory: Option<Memory>,
}

/// What a step leaves to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    /// Length of that step, s.
    pub dt: f64,
    /// Velocity before it, m/s.
    pub down: Vec<f64>,
    pub across: Vec<f64>,
    /// What pushed at its end: velocity per second, m/s2, and strain of the surfactant per second.
    pub push_down: Vec<f64>,
    pub push_across: Vec<f64>,
    pub push_s: Vec<f64>,
}

impl Memory {
    /// Its fields with their names.
    pub fn fields(&self) -> [(&'static str, &Vec<f64>); 5] {
        [
            ("velocity down before the last step", &self.down),
            ("velocity across before the last step", &self.across),
            ("push down", &self.push_down),
            ("push across", &self.push_across),
            ("strain of the surfactant", &self.push_s),
        ]
    }
}
