//! What a film is subjected to while it flows: another wind, another weight, somebody's breath.

use super::air::{at_sides, eddies, wind};
use super::{Edge, Film, FlowError};
use crate::grid::Grid;
use crate::parameters::CHANGEABLE;
use iridesce_thickness::ThicknessError;

/// Fastest breath, m/s: ten times what a film does by itself. Faster ones would only cost sub-steps.
const FASTEST: f64 = 2.0;

impl Film {
    /// Another value of one of [`crate::CHANGEABLE`], from the next step on; refused as [`crate::Parameters::check`] would.
    ///
    /// ```
    /// use iridesce_flow::{Film, Parameters};
    /// let mut film = Film::new(Parameters::preset("bubble-on-bath-small-preview")?)?;
    /// film.change("gravity_m_s2", 1.62)?;
    /// assert_eq!(film.parameters().gravity, 1.62);
    /// assert!(film.change("thickness_nm", 300.0).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn change(&mut self, name: &str, value: f64) -> Result<(), FlowError> {
        if !CHANGEABLE.contains(&name) {
            let allowed = format!("one of {} while a film flows", CHANGEABLE.join(", "));
            return Err(ThicknessError::new("parameter", allowed, format!("{name:?}")).into());
        }
        let mut changed = self.parameters.clone();
        changed.set(name, value)?;
        changed.check()?;
        if changed.wind != self.parameters.wind {
            self.wind = wind(&self.grid, &changed);
        }
        if changed.eddies > 0.0 && self.eddies.is_empty() {
            self.eddies = eddies(&self.grid, &changed);
        }
        self.parameters = changed;
        Ok(())
    }

    /// Drags the film along around a place, `row` and `column` in cells (the middle of the first is 0, 0): `speed` down
    /// and across in m/s is added to its velocity there, less by a Gaussian of `radius_m` around it.
    pub fn stir(&mut self, [row, column]: [f64; 2], speed: [f64; 2], radius_m: f64) -> Result<(), FlowError> {
        let grid = &self.grid;
        let wrong = |key: &'static str, allowed: String, given: String| {
            Err(FlowError::Parameter(ThicknessError::new(key, allowed, given)))
        };
        if !(row.is_finite() && (-0.5..=grid.rows as f64 - 0.5).contains(&row) && column.is_finite()) {
            let allowed = format!("a row of the film's {} and a column", grid.rows);
            return wrong("place", allowed, format!("{row:?}, {column:?}"));
        }
        if !speed.iter().all(|v| v.abs() <= FASTEST) {
            return wrong("speed", format!("at most {FASTEST} m/s either way"), format!("{speed:?}"));
        }
        let least = 2.0 * grid.dy;
        if !(radius_m >= least && radius_m.is_finite()) {
            return wrong("radius_m", format!("at least two cells, {least:?} m"), format!("{radius_m:?}"));
        }
        let (middle, push) = breath(grid, row, column, speed);
        let [down, across] = at_sides(grid, |x| {
            let square: f64 = (0..3).map(|k| ((x[k] - middle[k]) * grid.radius / radius_m).powi(2)).sum();
            // Beyond three radii less than 1.3e-4 is left.
            let share = if square > 9.0 { 0.0 } else { (-square).exp() };
            push.map(|v| v * share)
        });
        let n = grid.columns;
        let blown = |to_down: &mut [f64], to_across: &mut [f64]| {
            for (to, add) in to_down.iter_mut().zip(&down).chain(to_across.iter_mut().zip(&across)) {
                *to += add;
            }
            // Nothing passes a wall.
            if !grid.closes() {
                to_across.iter_mut().skip(n - 1).step_by(n).for_each(|u| *u = 0.0);
            }
            if grid.top == Edge::Wall {
                to_down[..n].fill(0.0);
            }
            if grid.bottom == Edge::Wall {
                to_down[grid.rows * n..].fill(0.0);
            }
        };
        blown(&mut self.state.down, &mut self.state.across);
        if let Some(memory) = &mut self.state.memory {
            // As if it had always blown: a step goes on as the velocity changes, and a jump is no change.
            blown(&mut memory.down, &mut memory.across);
        }
        Ok(())
    }
}

/// A place on the grid and a velocity there, in space.
fn breath(grid: &Grid, row: f64, column: f64, [down, across]: [f64; 2]) -> ([f64; 3], [f64; 3]) {
    let along = (row + 0.5) * grid.dy;
    if grid.is_plane() {
        let top = grid.height[0] + grid.dy / 2.0;
        return ([(column + 0.5) * grid.width[0], 0.0, top - along], [across, 0.0, -down]);
    }
    let (sin, cos) = (along / grid.radius).sin_cos();
    let (sin_a, cos_a) = (std::f64::consts::TAU * (column + 0.5) / grid.columns as f64).sin_cos();
    let push = [down * cos * cos_a - across * sin_a, down * cos * sin_a + across * cos_a, -down * sin];
    ([sin * cos_a, sin * sin_a, cos], push)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameters;

    fn film(preset: &str) -> Film {
        Film::new(Parameters::preset(preset).unwrap()).unwrap()
    }

    #[test]
    fn a_breath_moves_the_film_where_it_blows_and_liquid_stays() {
        for preset in ["bubble-on-bath-small-preview", "vertical-film-preview"] {
            let mut film = film(preset);
            let place = [film.grid.rows as f64 / 2.0, 20.0];
            film.stir(place, [0.0, 0.5], 8e-3).unwrap();
            let n = film.grid.columns;
            let at = |film: &Film, row: usize, column: usize| film.state.across[row * n + column];
            let row = film.grid.rows / 2;
            assert!((at(&film, row, 20) - 0.5).abs() < 0.02, "{preset}: {}", at(&film, row, 20));
            assert!(at(&film, row, n / 2 + 20).abs() < 1e-3, "{preset}: the far side rests");
            let before = film.volume();
            film.advance_to(0.1).unwrap();
            let change = film.volume() + film.state.books.gone() - before;
            assert!(change.abs() < 1e-12 * before, "{preset}: {change} of {before}");
        }
    }

    #[test]
    fn a_breath_across_a_pole_has_one_direction() {
        let mut film = film("free-bubble-preview");
        film.stir([-0.5, 0.0], [0.3, 0.0], 10e-3).unwrap();
        let n = film.grid.columns;
        // Down on one side of the pole is up on the other.
        let (here, there) = (film.state.down[n], film.state.down[n + n / 2]);
        assert!((here + there).abs() < 1e-9 && here > 0.28, "{here} {there}");
    }

    #[test]
    fn what_cannot_be_blown_or_changed_is_refused() {
        let mut film = film("bubble-on-bath-small-preview");
        let state = film.state.clone();
        for (place, speed, radius) in [
            ([f64::NAN, 0.0], [0.0, 0.0], 0.01),
            ([99.0, 0.0], [0.0, 0.0], 0.01),
            ([3.0, 0.0], [3.0, 0.0], 0.01),
            ([3.0, 0.0], [f64::NAN, 0.0], 0.01),
            ([3.0, 0.0], [0.1, 0.0], 1e-6),
        ] {
            film.stir(place, speed, radius).unwrap_err();
        }
        for (name, value) in [("columns", 64.0), ("gravity_m_s2", -1.0), ("wind_m_s", f64::NAN), ("tilt_deg", 20.0)] {
            film.change(name, value).unwrap_err();
        }
        assert_eq!(film.state, state);
        film.change("wind_m_s", 0.2).unwrap();
        film.change("eddies_m_s", 0.1).unwrap();
        assert!(!film.eddies.is_empty());
        film.advance_to(0.1).unwrap();
    }

    #[test]
    fn previews_flow_within_their_grids() {
        for preset in crate::PRESETS.iter().filter(|name| name.ends_with("-preview")) {
            let mut film = film(preset);
            assert!(film.parameters.columns <= 256, "{preset}");
            film.advance_to(0.4).unwrap();
            assert_eq!(film.state.step, (0.4 / film.parameters.step_s).round() as u64, "{preset}");
        }
    }
}
