//! Incoherent slabs: layers so thick, or so uneven, that the phase across them averages out.
//!
//! The slabs cut the stack into coherent runs. The mean over the phase of each slab is exactly a sum of powers:
//!
//! ```text
//! |r|^2 = |r1|^2 + |t1 t1'|^2 P^2 R2 / (1 - |r1'|^2 P^2 R2)      P = exp(-2 Im kz k0 d), primed: from below
//! |t|^2 = |t1|^2 P |t2|^2 / (1 - |r1'|^2 P^2 R2)
//! ```
//!
//! (the mean over a full turn of an analytic function is its value at the centre, so no cross term is left). Squared
//! fields are kept rather than fluxes inside absorbing slabs, where the fluxes of two crossing waves do not add.

use super::solver::{Light, Powers, Solver, lasing};
use crate::OpticsError;
use crate::fresnel::Polarization;

/// A coherent run: the media at its ends, and what it does with light from above and from below.
struct Run {
    top: usize,
    bottom: usize,
    down: Light,
    up: Light,
}

impl Solver {
    pub(super) fn slab_powers(
        &mut self,
        polarization: Polarization,
        layers: Option<&mut [f64]>,
    ) -> Result<Powers, OpticsError> {
        let runs = self.runs(polarization)?;
        let slabs = self.slabs.len();
        let pass: Vec<f64> = self.slabs.iter().map(|&slab| (-2.0 * self.waves[slab - 1].decay).exp()).collect();

        // From the last run up: what everything below slab m does with light that travels down in it.
        let below = &runs[slabs].down;
        let mut reflected = vec![0.0; slabs + 1];
        reflected[slabs] = below.r.norm_sqr();
        let mut transmitted = below.t.norm_sqr();
        for m in (0..slabs).rev() {
            let round_trip = pass[m] * pass[m] * reflected[m + 1];
            let escape = self.escape(&runs[m], round_trip)?;
            let through = runs[m].down.t.norm_sqr();
            reflected[m] = runs[m].down.r.norm_sqr() + through * runs[m].up.t.norm_sqr() * round_trip / escape;
            transmitted = through * pass[m] * transmitted / escape;
        }
        let incident_q = runs[0].down.incident_q;
        let powers = Powers {
            reflectance: self.bounded(reflected[0]),
            transmittance: below.leaving_q / incident_q * transmitted,
        };
        if let Some(layers) = layers {
            self.absorbed_in_slabs(polarization, &runs, &pass, &reflected, layers)?;
        }
        Ok(powers)
    }

    /// What is left of light bouncing in a slab: `1 - |r'|^2 P^2 R`.
    fn escape(&self, run: &Run, round_trip: f64) -> Result<f64, OpticsError> {
        let escape = 1.0 - run.up.r.norm_sqr() * round_trip;
        if self.has_gain {
            return if escape > 0.0 { Ok(escape) } else { Err(lasing()) };
        }
        // Between two perfect mirrors this rounds to 0 or below; then no light gets in either, and 0/0 must stay 0.
        Ok(escape.max(f64::EPSILON))
    }

    fn runs(&self, polarization: Polarization) -> Result<Vec<Run>, OpticsError> {
        let mut runs = Vec::with_capacity(self.slabs.len() + 1);
        let mut top = 0;
        for &bottom in self.slabs.iter().chain(std::iter::once(&(self.n.len() - 1))) {
            let down = self.light(polarization, top, bottom, false, |_, _| ())?;
            let up = self.light(polarization, top, bottom, true, |_, _| ())?;
            runs.push(Run { top, bottom, down, up });
            top = bottom;
        }
        Ok(runs)
    }

    fn absorbed_in_slabs(
        &mut self,
        polarization: Polarization,
        runs: &[Run],
        pass: &[f64],
        reflected: &[f64],
        layers: &mut [f64],
    ) -> Result<(), OpticsError> {
        layers.fill(0.0);
        let per_incident = 1.0 / runs[0].down.incident_q;
        let mut down = 1.0; // squared field that arrives at the run from above
        let mut above = 0.0; // net flux at the bottom of the slab above comes from here
        for (m, run) in runs.iter().enumerate() {
            // Squared fields just below the run: travelling down, and coming back from everything further below.
            let (leaving, back) = if m < pass.len() {
                let round_trip = pass[m] * pass[m] * reflected[m + 1];
                let leaving = down * run.down.t.norm_sqr() / self.escape(run, round_trip)?;
                (leaving, leaving * round_trip)
            } else {
                (0.0, 0.0)
            };
            let top_flux = down * run.down.entering - back * run.up.leaving_q * run.up.t.norm_sqr();
            if m > 0 {
                let slab = run.top;
                // A lossless slab keeps nothing; the difference would be rounding.
                layers[slab - 1] = if self.n_squared[slab].im == 0.0 { 0.0 } else { (above - top_flux) * per_incident };
            }
            above = down * run.down.leaving_q * run.down.t.norm_sqr() - back * run.up.entering;
            for (from_below, squared_field) in [(false, down), (true, back)] {
                if squared_field > 0.0 {
                    let light = self.traced_light(polarization, run.top, run.bottom, from_below)?;
                    let factor = squared_field * per_incident;
                    self.add_absorbed(&light, run.top, run.bottom, from_below, factor, layers);
                }
            }
            down = if m < pass.len() { leaving * pass[m] } else { 0.0 };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Polarization, Solver};
    use crate::Complex64;
    use crate::incidence::Incidence;

    /// Thin absorbing "slabs", in which a sum over bounces would grow without end, absorb no less than nothing.
    #[test]
    fn no_light_out_of_thin_absorbing_slabs() {
        let n = [(1.0, 0.0), (1.5, 1.2), (0.3, 0.29), (1.8, 1.7), (2.0, 0.0)].map(|(n, k)| Complex64::new(n, k));
        let mut solver = Solver::new();
        for step in 0..400 {
            let d = 0.5 * 1.03_f64.powi(step);
            for degrees in [0.0, 16.0, 30.0, 60.0, 85.0] {
                for polarization in [Polarization::S, Polarization::P] {
                    let incidence = Incidence::from_degrees(degrees).unwrap();
                    solver.prepare(&n, &[d, 0.7 * d, 1.3 * d], &[false; 3], 550.0, incidence);
                    let mut layers = [0.0; 3];
                    let powers = solver.powers_and_layers(polarization, &mut layers).unwrap();
                    let sum = powers.reflectance + powers.transmittance + layers.iter().sum::<f64>();
                    assert!((sum - 1.0).abs() < 1e-12, "d = {d}, {degrees} degrees: {powers:?}, {layers:?}");
                    assert!(powers.reflectance < 1.0 && powers.transmittance < 1.0);
                }
            }
        }
    }
}
