//! One stack, one wavelength, one direction: prepared once, then asked for either polarisation.

use std::f64::consts::TAU;

use super::averaging::averages;
use super::layer::Field;
use super::march::{Wave, parts, up};
use crate::fresnel::{Amplitudes, Polarization};
use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, OpticsError};

/// Reflected and transmitted power of one polarisation, relative to the incident one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Powers {
    /// Reflectance.
    pub reflectance: f64,
    /// Transmittance: power flux along the normal in the last medium over that in the first.
    pub transmittance: f64,
}

/// The workhorse behind [`solve`](super::solve) for many evaluations: it keeps its buffers, and checks nothing.
///
/// Call [`Solver::prepare`] for each wavelength, direction and set of thicknesses, then any of the questions. Indices,
/// thicknesses and wavelength must be within what [`check`](super::check) accepts.
///
/// ```
/// use iridesce_optics::stack::{Polarization, Solver};
/// use iridesce_optics::{Complex64, incidence::Incidence};
/// let n = [1.0, 1.333, 1.0].map(|n| Complex64::new(n, 0.0));
/// let mut solver = Solver::new();
/// solver.prepare(&n, &[100.0], &[true], 550.0, Incidence::from_degrees(0.0).unwrap());
/// let powers = solver.powers(Polarization::S).unwrap();
/// assert!((powers.reflectance - 0.0781050139).abs() < 1e-10);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Solver {
    /// Index, its square, and the wavenumber along the normal (`Im >= 0`), of every medium.
    pub(super) n: Vec<Complex64>,
    pub(super) n_squared: Vec<Complex64>,
    pub(super) kz: Vec<Complex64>,
    /// One wave a layer; layer `j` is medium `j + 1`.
    pub(super) waves: Vec<Wave>,
    /// Media whose two faces add powers, as used: see [`Solver::prepare`].
    pub(super) slabs: Vec<usize>,
    pub(super) has_gain: bool,
    /// Net flux at every interface of the last traced march, and by which logarithm its scale grew in the layer before.
    pub(super) trace: Vec<(f64, f64)>,
}

/// What the coherent run between two media does with light of unit field from one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    /// Field ratios (E for s, H for p).
    pub(super) r: Complex64,
    pub(super) t: Complex64,
    /// `Re q` of the medium the light comes from and of the one it leaves into.
    pub(super) incident_q: f64,
    pub(super) leaving_q: f64,
    /// Net flux at the lit side, for unit incident field.
    pub(super) entering: f64,
    /// What turns a flux of the march at the lit side into that for unit incident field.
    norm: f64,
}

impl Solver {
    /// A solver without buffers yet.
    pub fn new() -> Solver {
        Solver::default()
    }

    /// Sets the problem: `indices` of all media, first to last, and for each layer between them thickness and whether
    /// it is coherent.
    ///
    /// An incoherent slab is the mean over the phase of a propagating wave. Where the wave inside decays faster than it
    /// oscillates (total reflection, metals), or where a slab absorbs and is thinner than about one radian, there is no
    /// such phase, and it counts as coherent; one thick enough to be a slab gives the same result either way.
    pub fn prepare(
        &mut self,
        indices: &[Complex64],
        thickness_nm: &[f64],
        coherent: &[bool],
        wavelength_nm: f64,
        incidence: Incidence,
    ) {
        debug_assert!(indices.len() == thickness_nm.len() + 2 && coherent.len() == thickness_nm.len());
        let n_first = indices[0].re;
        let last = indices.len() - 1;
        self.has_gain = false;
        self.n.clear();
        self.n_squared.clear();
        self.kz.clear();
        self.waves.clear();
        self.slabs.clear();
        self.n.extend_from_slice(indices);
        for (j, &n) in indices.iter().enumerate() {
            self.n_squared.push(n * n);
            if j == 0 {
                self.kz.push(Complex64::new(n_first * incidence.cos_theta(), 0.0));
                continue;
            }
            let kz_squared = incidence.kz_squared(n_first, n);
            let kz = sqrt_upper(kz_squared);
            self.kz.push(kz);
            if j < last {
                self.has_gain |= n.im < 0.0;
                let k0_d = TAU * thickness_nm[j - 1] / wavelength_nm;
                self.waves.push(Wave::new(kz_squared, k0_d));
                if !coherent[j - 1] && averages(n, kz, k0_d) {
                    self.slabs.push(j);
                }
            }
        }
    }

    /// Reflectance and transmittance; for `Unpolarized` the mean of s and p.
    ///
    /// The only error is a stack with gain at or beyond its lasing threshold, which has no steady state to report.
    pub fn powers(&mut self, polarization: Polarization) -> Result<Powers, OpticsError> {
        match polarization {
            Polarization::Unpolarized => {
                let s = self.powers(Polarization::S)?;
                let p = self.powers(Polarization::P)?;
                Ok(Powers {
                    reflectance: 0.5 * (s.reflectance + p.reflectance),
                    transmittance: 0.5 * (s.transmittance + p.transmittance),
                })
            }
            _ if self.slabs.is_empty() => {
                let light = self.light(polarization, 0, self.n.len() - 1, false, |_, _| ())?;
                Ok(self.coherent_powers(&light))
            }
            _ => self.slab_powers(polarization, None),
        }
    }

    /// The same, and the share of the incident power absorbed in each layer (negative for gain) into `layers`.
    pub fn powers_and_layers(&mut self, polarization: Polarization, layers: &mut [f64]) -> Result<Powers, OpticsError> {
        debug_assert_eq!(layers.len(), self.waves.len());
        match polarization {
            Polarization::Unpolarized => {
                let s = self.powers_and_layers(Polarization::S, layers)?;
                let mut of_p = vec![0.0; layers.len()];
                let p = self.powers_and_layers(Polarization::P, &mut of_p)?;
                for (layer, p) in layers.iter_mut().zip(of_p) {
                    *layer = 0.5 * (*layer + p);
                }
                Ok(Powers {
                    reflectance: 0.5 * (s.reflectance + p.reflectance),
                    transmittance: 0.5 * (s.transmittance + p.transmittance),
                })
            }
            _ if self.slabs.is_empty() => {
                let last = self.n.len() - 1;
                let light = self.traced_light(polarization, 0, last, false)?;
                layers.fill(0.0);
                self.add_absorbed(&light, 0, last, false, 1.0 / light.incident_q, layers);
                Ok(self.coherent_powers(&light))
            }
            _ => self.slab_powers(polarization, Some(layers)),
        }
    }

    /// The share of the incident power absorbed in all finite layers together; exactly 0 where none absorbs.
    pub fn absorptance(&mut self, polarization: Polarization, scratch: &mut Vec<f64>) -> Result<f64, OpticsError> {
        let last = self.n.len() - 1;
        if self.n_squared[1..last].iter().all(|square| square.im == 0.0) {
            return Ok(0.0);
        }
        scratch.resize(last - 1, 0.0);
        self.powers_and_layers(polarization, scratch)?;
        Ok(scratch.iter().sum())
    }

    /// Electric-field amplitudes: `r` with its phase at the first interface, `t` at the last one. `S` or `P` only, and
    /// only of stacks without incoherent slabs.
    pub fn amplitudes(&self, polarization: Polarization) -> Result<Amplitudes, OpticsError> {
        let light = self.light(polarization, 0, self.n.len() - 1, false, |_, _| ())?;
        // t of p is a ratio of H so far; E = H / n.
        let to_electric = match polarization {
            Polarization::P => self.n[0] / self.n[self.n.len() - 1],
            _ => Complex64::new(1.0, 0.0),
        };
        Ok(Amplitudes { r: light.r, t: light.t * to_electric })
    }

    fn coherent_powers(&self, light: &Light) -> Powers {
        let t = light.t.norm();
        // Factor by factor: |t|^2 alone could underflow where T does not.
        let transmittance = t * (light.leaving_q / light.incident_q) * t;
        Powers { reflectance: self.bounded(light.r.norm_sqr()), transmittance }
    }

    /// A passive stack reflects no more than all; |r|^2 may round to 1 + 2e-16.
    pub(super) fn bounded(&self, reflectance: f64) -> f64 {
        if self.has_gain { reflectance } else { reflectance.min(1.0) }
    }

    /// `q` of a medium: the ratio h/e of a wave that travels down.
    #[inline]
    pub(super) fn q(&self, medium: usize, polarization: Polarization) -> Complex64 {
        match polarization {
            Polarization::P => self.kz[medium] / self.n_squared[medium],
            _ => self.kz[medium],
        }
    }

    /// Light through the layers between the media `top` and `bottom`, from above or from below; `at_interface` sees
    /// the flux at every interface, from the dark side to the lit one, and by which logarithm its scale grew in the layer.
    #[inline]
    pub(super) fn light(
        &self,
        polarization: Polarization,
        top: usize,
        bottom: usize,
        from_below: bool,
        mut at_interface: impl FnMut(f64, f64),
    ) -> Result<Light, OpticsError> {
        let one = Complex64::new(1.0, 0.0);
        let (lit, dark) = if from_below { (bottom, top) } else { (top, bottom) };
        // Re(kz/n^2) for p, not Re(n conj(cos)): the same number, and exactly 0 beyond a critical angle.
        let leaving_q = self.q(dark, polarization);
        let mut field = Field::leaving(parts(leaving_q));
        let mut log = 0.0_f64;
        at_interface(leaving_q.re, 0.0);
        for step in 1..bottom - top {
            let medium = if from_below { top + step } else { bottom - step };
            let weight = if polarization == Polarization::P { self.n_squared[medium] } else { one };
            let step_log = up(&mut field, &self.waves[medium - 1], weight);
            log += step_log;
            at_interface(field.flux(), step_log);
        }
        let q = self.q(lit, polarization);
        let [e, h] = [field.e, field.h].map(|[re, im]| Complex64::new(re, im));
        let incident = q * e;
        let sum = incident + h;
        if sum.norm_sqr() == 0.0 || !sum.is_finite() {
            return Err(lasing());
        }
        let unit = 2.0 * q / sum;
        let norm = unit.norm_sqr();
        Ok(Light {
            r: (incident - h) / sum,
            t: unit * (-log).exp(),
            incident_q: q.re,
            leaving_q: leaving_q.re,
            entering: field.flux() * norm,
            norm,
        })
    }

    pub(super) fn traced_light(
        &mut self,
        polarization: Polarization,
        top: usize,
        bottom: usize,
        from_below: bool,
    ) -> Result<Light, OpticsError> {
        let mut trace = std::mem::take(&mut self.trace);
        trace.clear();
        let light = self.light(polarization, top, bottom, from_below, |flux, log| trace.push((flux, log)));
        self.trace = trace;
        light
    }

    /// Adds `factor` times the power absorbed in each layer of the run just traced, for unit incident field.
    pub(super) fn add_absorbed(
        &self,
        light: &Light,
        top: usize,
        bottom: usize,
        from_below: bool,
        factor: f64,
        layers: &mut [f64],
    ) {
        // From the lit side down, so that the scale is a sum of small numbers: the logarithm of a millimetre of metal
        // is 1e5 and more, and the difference of two such would leave 11 digits of the flux.
        let mut scale = 0.0_f64;
        for step in (1..bottom - top).rev() {
            let (flux, log) = self.trace[step];
            let at_top = flux * (-2.0 * scale).exp();
            scale += log;
            let medium = if from_below { top + step } else { bottom - step };
            if self.n_squared[medium].im != 0.0 {
                // (A lossless layer takes nothing; its two fluxes differ by rounding only.)
                let at_bottom = self.trace[step - 1].0 * (-2.0 * scale).exp();
                layers[medium - 1] += factor * light.norm * (at_top - at_bottom);
            }
        }
    }
}

pub(super) fn lasing() -> OpticsError {
    OpticsError::Argument(
        "the stack amplifies light at or beyond its lasing threshold; there is no steady state".into(),
    )
}
