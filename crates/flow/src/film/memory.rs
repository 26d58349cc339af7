//! Steps of second order: flow by the velocity in the middle of a step, forces by half at its end and by half, carried
//! along, at its beginning, where the step before left them.

use rayon::prelude::*;

use super::forces::{self, fill_poles};
use super::state::{Memory, State};
use crate::carry::Carry;
use crate::grid::Grid;
use crate::parameters::Parameters;

/// By how much more than a half the forces at the end weigh, /s: waves of tension, far shorter than a step, would swing
/// for ever with halves alone. It vanishes with the step, so that the order stays.
const DAMPING: f64 = 5.0;

/// A step of second order while it is made.
pub struct Second {
    memory: Option<Memory>,
    before: [Vec<f64>; 2],
    carried: [Vec<f64>; 3],
    /// How long the forces of its end act, s; a first step has no others.
    pub part: f64,
    /// How long those of its beginning act, s.
    rest: f64,
}

impl Second {
    /// Brings the velocity to the middle of the step, as it changed in the last one.
    pub fn begin(state: &mut State, dt: f64) -> Second {
        let before = [state.down.clone(), state.across.clone()];
        let memory = state.memory.take();
        let part = if memory.is_some() { (0.5 + DAMPING * dt).min(1.0) * dt } else { dt };
        if let Some(memory) = &memory {
            let ahead = 0.5 * dt / memory.dt;
            further(&mut state.down, &memory.down, ahead);
            further(&mut state.across, &memory.across, ahead);
        }
        Second { memory, before, carried: Default::default(), part, rest: dt - part }
    }

    /// Velocity and surfactant, with what is left of the forces, along a trace; the drag of the air at the end of the step,
    /// kg/(m2 s).
    pub fn carry(&mut self, grid: &Grid, p: &Parameters, state: &mut State, carry: &mut Carry) -> Vec<f64> {
        let State { down, across, s, .. } = state;
        // The velocity at the end, as far as it can be told: as much again beyond the middle.
        further(down, &self.before[0], 1.0);
        further(across, &self.before[1], 1.0);
        let drag = forces::drag(grid, p, down, across);
        down.copy_from_slice(&self.before[0]);
        across.copy_from_slice(&self.before[1]);
        if let Some(memory) = &self.memory {
            add(down, &memory.push_down, self.rest);
            add(across, &memory.push_across, self.rest);
            add(s, &memory.push_s, self.rest);
            fill_poles(grid, down);
        }
        carry.take(grid, down, across);
        carry.velocity(grid, down, across);
        if p.elasticity.is_finite() {
            carry.scalar(grid, s);
        }
        self.carried = [down.clone(), across.clone(), s.clone()];
        drag
    }

    /// What pushed since it was carried.
    pub fn end(self, state: &State, dt: f64) -> Memory {
        let [mut push_down, mut push_across, mut push_s] = self.carried;
        let scale = 1.0 / self.part;
        for (push, now) in [(&mut push_down, &state.down), (&mut push_across, &state.across), (&mut push_s, &state.s)] {
            push.par_iter_mut().with_min_len(4096).zip(now).for_each(|(push, now)| *push = (now - *push) * scale);
        }
        let [down, across] = self.before;
        Memory { dt, down, across, push_down, push_across, push_s }
    }
}

/// Goes on from `before` beyond `now`, by `share` of the way between them.
fn further(now: &mut [f64], before: &[f64], share: f64) {
    now.par_iter_mut().with_min_len(4096).zip(before).for_each(|(now, before)| *now += share * (*now - before));
}

fn add(values: &mut [f64], more: &[f64], scale: f64) {
    values.par_iter_mut().with_min_len(4096).zip(more).for_each(|(value, more)| *value += scale * more);
}
