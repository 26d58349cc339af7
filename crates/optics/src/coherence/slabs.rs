//! Mueller matrices of stacks, the phases of incoherent slabs averaged out.

use std::f64::consts::TAU;

use crate::fresnel::Polarization;
use crate::incidence::{Incidence, sqrt_upper};
use crate::mueller::Mueller;
use crate::stack::{Solver, phase_averages};
use crate::{Complex64, OpticsError};

/// Slabs whose phases are averaged: a rule for each, so that more would take a million evaluations.
pub const MOST_SLABS: usize = 2;
/// Phases of a slab: doubled until nothing changes any more; the rule errs by terms of order `(r r')^phases`.
const FEWEST_PHASES: usize = 8;
const MOST_PHASES: [usize; MOST_SLABS] = [512, 64];
const SAME: f64 = 1e-13;

/// Reflected or transmitted light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// What comes back.
    Reflection,
    /// What passes.
    Transmission,
}

impl Direction {
    /// `"reflection"` or `"transmission"`.
    pub fn named(name: &str) -> Result<Direction, OpticsError> {
        match name {
            "reflection" => Ok(Direction::Reflection),
            "transmission" => Ok(Direction::Transmission),
            _ => Err(OpticsError::Argument(format!(
                "direction must be \"reflection\" or \"transmission\", got {name:?}"
            ))),
        }
    }
}

/// The four numbers of the Mueller matrix of a stack: powers of s and p, and the mean of `a_s conj(a_p)` over the phases of
/// its incoherent slabs (at most [`MOST_SLABS`]), in transmission times the ratio of fluxes. Slabs depolarise: the modulus
/// of the mean is less than the root of both powers.
///
/// The problem must pass [`check`](crate::stack::check).
///
/// ```
/// use iridesce_optics::coherence::{Direction, mueller};
/// use iridesce_optics::{Complex64, incidence::Incidence};
/// let n = [1.0, 1.5].map(Complex64::from);
/// let normal = Incidence::from_degrees(0.0).unwrap();
/// let m = mueller(&n, &[], &[], 550.0, normal, Direction::Reflection).unwrap();
/// assert!((m.s - 0.04).abs() < 1e-15 && (m.cross[0] + 0.04).abs() < 1e-15, "a mirror turns the handedness over");
/// ```
pub fn mueller(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    incidence: Incidence,
    direction: Direction,
) -> Result<Mueller<f64>, OpticsError> {
    let slabs: Vec<usize> = (0..coherent.len()).filter(|&layer| !coherent[layer]).collect();
    if slabs.len() > MOST_SLABS {
        return Err(OpticsError::Argument(format!(
            "the Mueller matrix of a stack takes at most {MOST_SLABS} incoherent slabs, got {}",
            slabs.len()
        )));
    }
    let mut solver = Solver::new();
    solver.prepare(indices, thickness_nm, coherent, wavelength_nm, incidence);
    let powers = [solver.powers(Polarization::S)?, solver.powers(Polarization::P)?];
    let [s, p] = powers.map(|powers| match direction {
        Direction::Reflection => powers.reflectance,
        Direction::Transmission => powers.transmittance,
    });
    let mut all = Coherent {
        indices,
        coherent: vec![true; coherent.len()],
        thickness_nm: thickness_nm.to_vec(),
        wavelength_nm,
        incidence,
        direction,
        solver,
    };
    let cross = if slabs.is_empty() { all.cross()? } else { all.mean(thickness_nm, &slabs)? };
    Ok(Mueller { s, p, cross: [cross.re, cross.im] })
}

impl Mueller<f64> {
    /// The matrix itself, on Stokes vectors with I = |E_s|^2 + |E_p|^2, Q = |E_s|^2 - |E_p|^2, U + iV = 2 E_s conj(E_p).
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let (mean, half) = (0.5 * (self.s + self.p), 0.5 * (self.s - self.p));
        let [re, im] = self.cross;
        [[mean, half, 0.0, 0.0], [half, mean, 0.0, 0.0], [0.0, 0.0, re, -im], [0.0, 0.0, im, re]]
    }
}

/// The same stack with every layer coherent.
struct Coherent<'a> {
    indices: &'a [Complex64],
    coherent: Vec<bool>,
    thickness_nm: Vec<f64>,
    wavelength_nm: f64,
    incidence: Incidence,
    direction: Direction,
    solver: Solver,
}

impl Coherent<'_> {
    fn cross(&mut self) -> Result<Complex64, OpticsError> {
        let Coherent { indices, coherent, thickness_nm, wavelength_nm, incidence, direction, solver } = self;
        solver.prepare(indices, thickness_nm, coherent, *wavelength_nm, *incidence);
        let (s, p) = (solver.amplitudes(Polarization::S)?, solver.amplitudes(Polarization::P)?);
        match direction {
            Direction::Reflection => Ok(s.r * p.r.conj()),
            Direction::Transmission => {
                // The flux of a wave with s and p is not the product of amplitudes alone: sqrt(T_s T_p) with its phase.
                let both = s.t.norm() * p.t.norm();
                let turned = if both > 0.0 { s.t * p.t.conj() / both } else { Complex64::new(1.0, 0.0) };
                let (of_s, of_p) = (solver.powers(Polarization::S)?, solver.powers(Polarization::P)?);
                Ok((of_s.transmittance * of_p.transmittance).sqrt() * turned)
            }
        }
    }

    /// The mean over equal steps of the phase of each slab. The function is periodic in each, so that few steps do.
    fn mean(&mut self, thickness_nm: &[f64], slabs: &[usize]) -> Result<Complex64, OpticsError> {
        let turns: Vec<f64> = slabs.iter().map(|&slab| self.turn_nm(thickness_nm[slab], slab)).collect();
        let most = MOST_PHASES[slabs.len() - 1];
        let mut phases = FEWEST_PHASES;
        let mut last = self.mean_of(thickness_nm, slabs, &turns, phases)?;
        while phases < most {
            phases *= 2;
            let mean = self.mean_of(thickness_nm, slabs, &turns, phases)?;
            if (mean - last).norm() < SAME {
                return Ok(mean);
            }
            last = mean;
        }
        Ok(last)
    }

    fn mean_of(
        &mut self,
        thickness_nm: &[f64],
        slabs: &[usize],
        turns: &[f64],
        phases: usize,
    ) -> Result<Complex64, OpticsError> {
        let all = phases.pow(slabs.len() as u32);
        let mut total = Complex64::default();
        for which in 0..all {
            let mut rest = which;
            for (&slab, turn) in slabs.iter().zip(turns) {
                self.thickness_nm[slab] = thickness_nm[slab] + turn * ((rest % phases) as f64 / phases as f64);
                rest /= phases;
            }
            total += self.cross()?;
        }
        Ok(total / all as f64)
    }

    /// The thickness in which the phase of a slab, there and back, turns once; 0 where it has no phase to average.
    fn turn_nm(&self, thickness_nm: f64, slab: usize) -> f64 {
        let n = self.indices[slab + 1];
        let kz = sqrt_upper(self.incidence.kz_squared(self.indices[0].re, n));
        let k0_d = TAU * thickness_nm / self.wavelength_nm;
        if phase_averages(n, kz, k0_d) { self.wavelength_nm / (2.0 * kz.re) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One slab of glass, in closed form: with z the round trip, a = r1 + (1 - r1^2) r2 z/(1 + r1 r2 z), and the mean of
    /// a_s conj(a_p) over z is r1s r1p + (1 - r1s^2)(1 - r1p^2) r2s r2p / (1 - r1s r2s r1p r2p), r2 = -r1.
    #[test]
    fn a_slab_of_glass_depolarises_as_its_series_says() {
        let n = [1.0, 1.5, 1.0].map(Complex64::from);
        for degrees in [0.0, 30.0, 56.0, 80.0] {
            let incidence = Incidence::from_degrees(degrees).unwrap();
            let face =
                |polarization| crate::fresnel::interface(1.0, n[1], incidence.cos_theta(), polarization).unwrap().r.re;
            let (s, p) = (face(Polarization::S), face(Polarization::P));
            let (ss, pp) = (s * s, p * p);
            let wanted = s * p + (1.0 - ss) * (1.0 - pp) * s * p / (1.0 - ss * pp);
            let m = mueller(&n, &[1e6], &[false], 550.0, incidence, Direction::Reflection).unwrap();
            assert!((m.cross[0] - wanted).abs() < 1e-12 && m.cross[1].abs() < 1e-12, "{degrees}: {m:?} {wanted}");
            assert!(m.cross[0].abs() <= (m.s * m.p).sqrt() + 1e-15);
            let matrix = m.matrix();
            assert_eq!((matrix[0][0], matrix[2][3]), (0.5 * (m.s + m.p), -m.cross[1]));
        }
    }

    #[test]
    fn three_slabs_are_refused() {
        let n = [1.0, 1.5, 1.4, 1.5, 1.0].map(Complex64::from);
        let incidence = Incidence::from_degrees(0.0).unwrap();
        let error = mueller(&n, &[1e6; 3], &[false; 3], 550.0, incidence, Direction::Reflection).unwrap_err();
        assert!(error.to_string().contains("at most 2"), "{error}");
    }
}
