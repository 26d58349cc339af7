//! Stable solution of any stack of layers: complex, dispersive, absorbing or amplifying, coherent or not, at any angle.
//!
//! The road: `kz^2` without cancellation ([`crate::incidence`]), the fields marched up from the exit medium (`march`),
//! both polarisations from one preparation ([`Solver`]), incoherent slabs as sums of powers (`slabs`); whole arrays
//! in vectors ([`sweep`]).

mod averaging;
mod derivatives;
mod fields;
pub mod graded;
pub mod layer;
mod march;
mod runs;
mod slabs;
mod solver;
pub mod sweep;
mod text;

pub use crate::fresnel::{Amplitudes, Polarization};
pub(crate) use averaging::averages as phase_averages;
pub use derivatives::{Derivatives, LayerAiry, ellipsometry_derivatives, layer_airy, power_derivatives};
pub use fields::{FieldAt, Fields};
pub use solver::{Powers, Solver};
pub use text::StackText;

use iridesce_numerics::{Argument, THICKNESS_NM, WAVELENGTH_NM};

use crate::fresnel::{check_finite_index, check_first, check_last};
use crate::incidence::Incidence;
use crate::medium::Beyond;
use crate::{Complex64, Medium, OpticsError};

/// One finite layer.
#[derive(Debug, Clone)]
pub struct Layer {
    /// What it is made of.
    pub medium: Medium,
    /// Thickness in nm, >= 0.
    pub thickness_nm: f64,
    /// `false`: an incoherent slab, whose two faces add powers instead of amplitudes.
    pub coherent: bool,
}

/// First medium, layers in the order light meets them, last medium.
#[derive(Debug, Clone)]
pub struct Stack {
    /// The medium light comes from.
    pub first: Medium,
    /// The layers.
    pub layers: Vec<Layer>,
    /// The medium behind.
    pub last: Medium,
}

impl Stack {
    /// Indices of all media, first to last, at one wavelength; an error outside the data of any of them.
    pub fn indices(&self, wavelength_nm: f64) -> Result<Vec<Complex64>, OpticsError> {
        let media = std::iter::once(&self.first)
            .chain(self.layers.iter().map(|layer| &layer.medium))
            .chain(std::iter::once(&self.last));
        media.map(|medium| medium.index(wavelength_nm, Beyond::Refuse)).collect()
    }

    /// What the stack does with light of one wavelength from one direction.
    ///
    /// ```
    /// use iridesce_optics::{Complex64, Layer, Medium, Polarization, Stack};
    /// let air = Medium::constant(Complex64::new(1.0, 0.0)).unwrap();
    /// let coat = Medium::constant(Complex64::new(1.38, 0.0)).unwrap();
    /// let glass = Medium::constant(Complex64::new(1.52, 0.0)).unwrap();
    /// let layers = vec![Layer { medium: coat, thickness_nm: 99.6377, coherent: true }];
    /// let response = Stack { first: air, layers, last: glass }.solve(550.0, 0.0, Polarization::Unpolarized).unwrap();
    /// assert!((response.reflectance - 0.0126007902).abs() < 1e-10);
    /// ```
    pub fn solve(
        &self,
        wavelength_nm: f64,
        angle_deg: f64,
        polarization: Polarization,
    ) -> Result<Response, OpticsError> {
        if !(wavelength_nm > 0.0 && wavelength_nm.is_finite()) {
            return Err(WAVELENGTH_NM.refuse(wavelength_nm).into());
        }
        let indices = self.indices(wavelength_nm)?;
        let thickness_nm: Vec<f64> = self.layers.iter().map(|layer| layer.thickness_nm).collect();
        let coherent: Vec<bool> = self.layers.iter().map(|layer| layer.coherent).collect();
        solve_angle(&indices, &thickness_nm, &coherent, wavelength_nm, angle_deg, polarization)
    }
}

/// What a stack does with light of one wavelength, direction and polarisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Reflected share of the incident power.
    pub reflectance: f64,
    /// Transmitted share: power flux along the normal in the last medium over that in the first.
    pub transmittance: f64,
    /// Electric-field amplitudes; `None` for unpolarised light and for stacks with incoherent slabs.
    pub amplitudes: Option<Amplitudes>,
}

/// Reflectance, transmittance and amplitudes of a stack given by its indices, the angle by its cosine.
///
/// `indices` run from the first medium to the last, `thickness_nm` and `coherent` over the layers between them. The
/// first medium must have real n > 0 and k = 0, the last k >= 0. Powers are good to 1e-12, T to 1e-9 of itself down to
/// 1e-300, as far as the problem is conditioned.
pub fn solve(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    cos_theta: f64,
    polarization: Polarization,
) -> Result<Response, OpticsError> {
    let incidence = Incidence::from_cos(cos_theta)?;
    respond(indices, thickness_nm, coherent, wavelength_nm, incidence, polarization)
}

/// [`solve`] with the angle in degrees, `0 <= angle_deg < 90`: exact also where a rounded cosine would not be, at
/// grazing incidence and within 1e-6 degrees of a critical angle.
pub fn solve_angle(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    angle_deg: f64,
    polarization: Polarization,
) -> Result<Response, OpticsError> {
    let incidence = Incidence::from_degrees(angle_deg)?;
    respond(indices, thickness_nm, coherent, wavelength_nm, incidence, polarization)
}

fn respond(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    incidence: Incidence,
    polarization: Polarization,
) -> Result<Response, OpticsError> {
    check(indices, thickness_nm, coherent, wavelength_nm)?;
    let mut solver = Solver::new();
    solver.prepare(indices, thickness_nm, coherent, wavelength_nm, incidence);
    let powers = solver.powers(polarization)?;
    let has_amplitudes = polarization != Polarization::Unpolarized && coherent.iter().all(|&c| c);
    let amplitudes = has_amplitudes.then(|| solver.amplitudes(polarization)).transpose()?;
    Ok(Response { reflectance: powers.reflectance, transmittance: powers.transmittance, amplitudes })
}

/// The share of the incident power absorbed in each layer (negative for gain); with R and T it makes 1. What an
/// absorbing last medium takes in is T.
pub fn layer_absorptance(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
    incidence: Incidence,
    polarization: Polarization,
) -> Result<Vec<f64>, OpticsError> {
    check(indices, thickness_nm, coherent, wavelength_nm)?;
    let mut solver = Solver::new();
    solver.prepare(indices, thickness_nm, coherent, wavelength_nm, incidence);
    let mut layers = vec![0.0; thickness_nm.len()];
    solver.powers_and_layers(polarization, &mut layers)?;
    Ok(layers)
}

/// Ellipsometric angles in degrees: `tan psi = |r_p / r_s|`, `delta = arg(r_p / r_s)` in [0, 360).
///
/// `None` where nothing is reflected in either polarisation, so that the ratio has no value.
/// (Instruments that write n - ik report `360 - delta`; some programs report `delta - 180`.)
pub fn ellipsometry(r_s: Complex64, r_p: Complex64) -> Option<(f64, f64)> {
    let (s, p) = (r_s.norm(), r_p.norm());
    if s == 0.0 && p == 0.0 {
        return None;
    }
    let delta = if s == 0.0 || p == 0.0 { 0.0 } else { (r_p / p * (r_s / s).conj()).arg().to_degrees() };
    let delta = if delta < 0.0 { delta + 360.0 } else { delta };
    // -1e-17 + 360 rounds to 360 itself.
    Some((p.atan2(s).to_degrees(), if delta >= 360.0 { 0.0 } else { delta }))
}

/// Whether a stack can be solved; the error names what is wrong and what is allowed.
pub fn check(
    indices: &[Complex64],
    thickness_nm: &[f64],
    coherent: &[bool],
    wavelength_nm: f64,
) -> Result<(), OpticsError> {
    if indices.len() != thickness_nm.len() + 2 || coherent.len() != thickness_nm.len() {
        return Err(OpticsError::Argument(format!(
            "a stack of {} media takes {} thicknesses and as many coherent flags, got {} and {}",
            indices.len(),
            indices.len().saturating_sub(2),
            thickness_nm.len(),
            coherent.len()
        )));
    }
    WAVELENGTH_NM.check(wavelength_nm)?;
    check_indices(indices, coherent)?;
    for (j, &thickness) in thickness_nm.iter().enumerate() {
        THICKNESS_NM.check(thickness).map_err(|e| e.at(format!("in layer {}", j + 1)))?;
        check_phase(thickness, wavelength_nm)
            .map_err(|e| e.at(format!("in layer {} at {wavelength_nm:?} nm", j + 1)))?;
    }
    Ok(())
}

/// Thicker layers, in vacuum wavelengths, would overflow; their phase has lost all its digits long before.
pub const MOST_WAVES: f64 = 1e30;

/// The part of [`check`] that concerns the media.
pub fn check_indices(indices: &[Complex64], coherent: &[bool]) -> Result<(), OpticsError> {
    let last = indices.len() - 1;
    check_first(indices[0])?;
    check_last(indices[last])?;
    for (j, &n) in indices[1..last].iter().enumerate() {
        check_finite_index(n, &format!("layer {}", j + 1))?;
        if n.im < 0.0 && !coherent[j] {
            return Err(OpticsError::Argument(format!(
                "an incoherent slab must have k >= 0, got {n} in layer {}",
                j + 1
            )));
        }
    }
    Ok(())
}

/// The part of [`check`] that looks at thickness and wavelength together.
pub fn check_phase(thickness_nm: f64, wavelength_nm: f64) -> Result<(), Argument> {
    if thickness_nm / wavelength_nm <= MOST_WAVES {
        return Ok(());
    }
    Err(Argument::new("thickness_nm", format!("at most {MOST_WAVES:e} wavelengths"), format!("{thickness_nm:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipsometric_angles_lie_in_their_range() {
        let c = Complex64::new;
        let one = c(1.0, 0.0);
        assert_eq!(ellipsometry(one, one), Some((45.0, 0.0)));
        assert_eq!(ellipsometry(one, -one), Some((45.0, 180.0)));
        assert_eq!(ellipsometry(one, c(-1.0, -0.0)), Some((45.0, 180.0)));
        assert_eq!(ellipsometry(one, c(0.0, -1.0)), Some((45.0, 270.0)));
        // Rounds to 360 when brought up from below 0.
        assert_eq!(ellipsometry(one, c(1.0, -1e-17)), Some((45.0, 0.0)));
        assert_eq!(ellipsometry(c(0.0, 0.0), one), Some((90.0, 0.0)));
        assert_eq!(ellipsometry(one, c(0.0, 0.0)), Some((0.0, 0.0)));
        assert_eq!(ellipsometry(c(0.0, 0.0), c(0.0, 0.0)), None);
        // Squares of these would underflow.
        let (psi, delta) = ellipsometry(c(1e-200, 0.0), c(0.0, 1e-200)).unwrap();
        assert!((psi - 45.0).abs() < 1e-13 && (delta - 90.0).abs() < 1e-13);
    }

    #[test]
    fn power_that_leaks_through_total_reflection() {
        // 1.5 -> 1 + 3e-8i at 60 degrees, mpmath with 50 digits.
        let n = [Complex64::new(1.5, 0.0), Complex64::new(1.0, 3e-8)];
        for (polarization, expected) in
            [(Polarization::S, 8.683526346821388e-08), (Polarization::P, 1.43466952972052e-07)]
        {
            let response = solve_angle(&n, &[], &[], 550.0, 60.0, polarization).unwrap();
            assert!((response.transmittance / expected - 1.0).abs() < 1e-14, "{:e}", response.transmittance);
        }
    }
}
