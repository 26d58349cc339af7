//! Electric and magnetic field at any depth of a coherent stack, the power that flows there and the power absorbed.
//!
//! x lies in the plane of incidence along the light, y across it, z into the stack. With fields of s `(E_y, -H_x)` and of p
//! `(H_y, E_x)` from the march, Maxwell's equations give the third component: `H_z = kx E_y`, `E_z = -kx H_y / n^2`, wavenumbers in
//! units of the vacuum one, H in units of E over the impedance of vacuum.

use std::f64::consts::TAU;

use super::derivatives::half;
use super::runs::{Half, Phase, Scaled};
use super::solver::lasing;
use crate::fresnel::Polarization;
use crate::incidence::Incidence;
use crate::{Complex64, OpticsError};

const I: Complex64 = Complex64::new(0.0, 1.0);
const ZERO: Complex64 = Complex64::new(0.0, 0.0);

/// Fields at one depth, for an incident electric field of modulus 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldAt {
    /// Along x, y, z.
    pub electric: [Complex64; 3],
    /// Along x, y, z, times the impedance of vacuum.
    pub magnetic: [Complex64; 3],
    /// Power that flows along z, relative to the incident one.
    pub flux: f64,
    /// Power absorbed per nm of depth, relative to the incident one; negative for gain.
    pub absorbed_per_nm: f64,
}

/// A stack at one wavelength, direction and polarisation (s or p), ready to be asked at any depth.
#[derive(Debug, Clone)]
pub struct Fields {
    polarization: Polarization,
    n_squared: Vec<Complex64>,
    halves: Vec<Half>,
    /// Depth of every interface, nm; the first is 0.
    depth_nm: Vec<f64>,
    /// Fields at the interfaces in the same order, with their logarithms.
    at: Vec<Scaled>,
    k0: f64,
    kx: f64,
    /// What turns a field of the march at the first interface into that for unit incident field, and its logarithm.
    unit: Complex64,
    unit_log: f64,
}

impl Fields {
    /// The problem must pass [`check`](super::check), all layers coherent.
    pub fn new(
        indices: &[Complex64],
        thickness_nm: &[f64],
        wavelength_nm: f64,
        incidence: Incidence,
        polarization: Polarization,
    ) -> Result<Fields, OpticsError> {
        if polarization == Polarization::Unpolarized {
            return Err(OpticsError::Argument("fields need polarization \"s\" or \"p\"".into()));
        }
        let k0 = TAU / wavelength_nm;
        let n_first = indices[0].re;
        let halves: Vec<Half> =
            indices.iter().enumerate().map(|(j, &n)| half(n_first, n, j == 0, incidence, polarization)).collect();
        let last = indices.len() - 1;
        let mut at = vec![Scaled::new((Complex64::new(1.0, 0.0), halves[last].q()))];
        for medium in (1..last).rev() {
            let phase = Phase::new(halves[medium].kz_squared, k0 * thickness_nm[medium - 1]);
            at.push(at[at.len() - 1].up(&phase, &halves[medium]));
        }
        at.reverse();
        let mut depth_nm = vec![0.0];
        for thickness in thickness_nm {
            depth_nm.push(depth_nm[depth_nm.len() - 1] + thickness);
        }
        let (e, h) = at[0].pair();
        let q = halves[0].q();
        let sum = q * e + h;
        if sum.norm_sqr() == 0.0 || !sum.is_finite() {
            return Err(lasing());
        }
        // Unit incident E along y for s; for p along (-cos, 0, sin), which has H_y = -n.
        let incident = if polarization == Polarization::P { -n_first } else { 1.0 };
        let sin = (1.0 - incidence.cos_theta()).max(0.0) * (1.0 + incidence.cos_theta());
        Ok(Fields {
            polarization,
            n_squared: indices.iter().map(|n| n * n).collect(),
            halves,
            depth_nm,
            k0,
            kx: n_first * sin.sqrt(),
            unit: incident * 2.0 * q / sum,
            unit_log: at[0].log,
            at,
        })
    }

    /// The medium at a depth: an interface belongs to what lies below it.
    pub fn medium(&self, depth_nm: f64) -> usize {
        self.depth_nm.iter().take_while(|interface| **interface <= depth_nm).count()
    }

    /// Fields at a depth below the first interface, nm; negative in the first medium.
    pub fn at(&self, depth_nm: f64) -> FieldAt {
        let medium = self.medium(depth_nm);
        let half = &self.halves[medium];
        let last = self.halves.len() - 1;
        let field = if medium == last {
            // Leaving wave: exp(i kz k0 z) from the last interface.
            let below = self.k0 * (depth_nm - self.depth_nm[last - 1]);
            let wave = (I * half.kz * below).exp();
            let (e, h) = self.at[last - 1].pair();
            Scaled { log: self.at[last - 1].log, ..Scaled::new((e * wave, h * wave)) }
        } else {
            let phase = Phase::new(half.kz_squared, self.k0 * (self.depth_nm[medium] - depth_nm));
            self.at[medium].up(&phase, half)
        };
        let factor = self.unit * (field.log - self.unit_log).exp();
        let (e, h) = (field.pair().0 * factor, field.pair().1 * factor);
        let square = self.n_squared[medium];
        let (electric, magnetic) = match self.polarization {
            Polarization::P => ([h, ZERO, -self.kx * e / square], [ZERO, e, ZERO]),
            _ => ([ZERO, e, ZERO], [-h, ZERO, self.kx * e]),
        };
        let incident = self.halves[0].kz.re;
        let strength: f64 = electric.iter().map(Complex64::norm_sqr).sum();
        FieldAt {
            electric,
            magnetic,
            flux: (e.re * h.re + e.im * h.im) / incident,
            absorbed_per_nm: self.k0 * square.im * strength / incident,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stack::layer_absorptance;

    /// Gauss-Legendre with 5 nodes on `pieces` equal pieces.
    fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64, pieces: usize) -> f64 {
        let nodes = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let step = (to - from) / pieces as f64;
        (0..pieces)
            .map(|i| {
                let middle = from + (i as f64 + 0.5) * step;
                let pair = |x: f64| f(middle - 0.5 * step * x) + f(middle + 0.5 * step * x);
                let sum: f64 = nodes[1..].iter().map(|(x, w)| w * pair(*x)).sum();
                0.5 * step * (nodes[0].1 * f(middle) + sum)
            })
            .sum()
    }

    #[test]
    fn absorption_adds_up_and_is_what_the_flux_loses() {
        let c = Complex64::new;
        let n = [c(1.3, 0.0), c(2.1, 0.02), c(0.06, 3.6), c(1.4, 0.3), c(3.0, 0.4)];
        let d = [180.0, 25.0, 400.0];
        for polarization in [Polarization::S, Polarization::P] {
            for angle in [0.0, 35.0, 70.0] {
                let incidence = Incidence::from_degrees(angle).unwrap();
                let fields = Fields::new(&n, &d, 550.0, incidence, polarization).unwrap();
                let wanted = layer_absorptance(&n, &d, &[true; 3], 550.0, incidence, polarization).unwrap();
                let mut top = 0.0;
                for (j, thickness) in d.iter().enumerate() {
                    let bottom = top + thickness;
                    // Just above the interface, where the layer still counts.
                    let end = bottom - 1e-9;
                    let inside = integral(|z| fields.at(z).absorbed_per_nm, top, bottom, 64);
                    assert!((inside - wanted[j]).abs() < 1e-12, "{polarization:?} {angle} {j} {inside} {}", wanted[j]);
                    let lost = fields.at(top).flux - fields.at(end).flux;
                    assert!((lost - wanted[j]).abs() < 1e-9, "{polarization:?} {angle} {j}");
                    top = bottom;
                }
            }
        }
    }

    #[test]
    fn tangential_fields_do_not_jump() {
        let c = Complex64::new;
        let n = [c(1.0, 0.0), c(2.0, 0.1), c(1.5, 0.0)];
        let incidence = Incidence::from_degrees(50.0).unwrap();
        for polarization in [Polarization::S, Polarization::P] {
            let fields = Fields::new(&n, &[90.0], 600.0, incidence, polarization).unwrap();
            for z in [0.0, 90.0] {
                let (above, below) = (fields.at(z - 1e-10), fields.at(z));
                for axis in [0, 1] {
                    assert!((above.electric[axis] - below.electric[axis]).norm() < 1e-10);
                    assert!((above.magnetic[axis] - below.magnetic[axis]).norm() < 1e-10);
                }
            }
            assert_eq!((fields.medium(-1.0), fields.medium(0.0), fields.medium(90.0)), (0, 1, 2));
        }
    }

    #[test]
    fn nothing_overflows_behind_an_opaque_metal() {
        let c = Complex64::new;
        let n = [c(1.0, 0.0), c(0.05, 3.9), c(1.5, 0.0)];
        let fields = Fields::new(&n, &[1e6], 600.0, Incidence::from_cos(1.0).unwrap(), Polarization::S).unwrap();
        assert_eq!(fields.at(1e6).electric[1].norm(), 0.0);
        assert!(fields.at(10.0).electric[1].norm() > 0.1);
    }
}
