//! Layers whose index changes with depth, as slices.

use super::Polarization;
use super::sweep::{Operand, Power, Quantity, Sweep, SweepRequest};
use crate::{Complex64, OpticsError};

/// Slices that a layer is cut into at most.
pub const MOST_SLICES: usize = 1024;
/// Surroundings in which the error is measured besides the layer's own ends: air above, and the index of silicon below.
const AROUND: [f64; 2] = [1.0, 4.0];
/// Angles at which it is measured, degrees.
const ANGLES: [f64; 2] = [0.0, 60.0];

/// Into how many equal slices, each of the index in its middle, a layer must be cut so that R and T err by no more than
/// `tolerance` at some wavelengths, at 0 and 60 degrees, unpolarised, between air and silicon and (where both are clear)
/// between media like its own ends. `index_at` takes the depth as a share of the thickness and gives the index at every
/// wavelength, or one that holds at all of them.
///
/// Slices err as their number to the power -2: a doubling that changes R by no more than three times the tolerance leaves it.
pub fn slices<E: From<OpticsError>>(
    mut index_at: impl FnMut(f64) -> Result<Vec<Complex64>, E>,
    wavelength_nm: &[f64],
    thickness_nm: f64,
    tolerance: f64,
) -> Result<usize, E> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(OpticsError::Argument(format!("tolerance must be > 0 and finite, got {tolerance}")).into());
    }
    let ends = [index_at(0.0)?, index_at(1.0)?];
    let around = AROUND.map(|n| vec![Complex64::from(n)]);
    // A first medium absorbs nothing and a last one has no gain: ends that are not clear are looked at from air.
    let clear = ends.iter().flatten().all(|n| n.im == 0.0);
    let surroundings = if clear { vec![around, ends] } else { vec![around] };
    let mut seen = |count: usize| -> Result<Vec<f64>, E> {
        let middle = |place: usize| index_at((place as f64 + 0.5) / count as f64);
        let inside = (0..count).map(middle).collect::<Result<Vec<_>, E>>()?;
        let mut powers = Vec::new();
        for [first, last] in &surroundings {
            powers.extend(spectra(first, &inside, last, wavelength_nm, thickness_nm / count as f64)?);
        }
        Ok(powers)
    };
    let mut count = 2;
    let mut before = seen(count)?;
    loop {
        let after = seen(2 * count)?;
        if after.iter().zip(&before).all(|(after, before)| (after - before).abs() <= 3.0 * tolerance) {
            return Ok(2 * count);
        }
        (count, before) = (2 * count, after);
        if count >= MOST_SLICES {
            return Err(OpticsError::Argument(format!(
                "tolerance {tolerance} is not reached with {MOST_SLICES} slices of {thickness_nm} nm in all: give a \
                 larger tolerance, or the layer in parts"
            ))
            .into());
        }
    }
}

/// R and T of equal slices between two media, unpolarised, at every angle and wavelength.
fn spectra(
    first: &[Complex64],
    inside: &[Vec<Complex64>],
    last: &[Complex64],
    wavelength_nm: &[f64],
    each_nm: f64,
) -> Result<Vec<f64>, OpticsError> {
    let slices = inside.iter().map(Vec::as_slice);
    let indices: Vec<&[Complex64]> = std::iter::once(first).chain(slices).chain(std::iter::once(last)).collect();
    let each = Operand { values: std::slice::from_ref(&each_nm), strides: vec![0, 0] };
    let mut powers = vec![0.0; 2 * ANGLES.len() * wavelength_nm.len()];
    let (of_r, of_t) = powers.split_at_mut(ANGLES.len() * wavelength_nm.len());
    for (power, out) in [(Power::Reflectance, of_r), (Power::Transmittance, of_t)] {
        let request = SweepRequest {
            quantity: Quantity::Power(power),
            polarization: Polarization::Unpolarized,
            indices: indices.clone(),
            coherent: vec![true; inside.len()],
            shape: vec![ANGLES.len(), wavelength_nm.len()],
            wavelength_nm: Operand { values: wavelength_nm, strides: vec![0, 1] },
            angle_deg: Operand { values: &ANGLES, strides: vec![1, 0] },
            thickness_nm: vec![each.clone(); inside.len()],
        };
        Sweep::new(request)?.evaluate(out)?;
    }
    Ok(powers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(from: f64, to: f64) -> impl FnMut(f64) -> Result<Vec<Complex64>, OpticsError> {
        move |depth| Ok(vec![Complex64::from(from + (to - from) * depth)])
    }

    #[test]
    fn a_steeper_layer_and_a_finer_tolerance_need_more_slices() {
        let nm = [450.0, 650.0];
        let count = |to: f64, tolerance: f64| slices(linear(1.4, to), &nm, 200.0, tolerance).unwrap();
        assert_eq!(count(1.4, 1e-6), 4, "an even layer needs none, and is looked at twice");
        // The error falls as the square: a hundredth of it takes ten times as many, to a power of two.
        let (coarse, fine) = (count(2.2, 1e-4), count(2.2, 1e-6));
        assert!(fine / coarse == 8 || fine / coarse == 16, "{coarse} {fine}");
    }

    #[test]
    fn what_cannot_be_reached_is_refused() {
        let error = slices(linear(1.4, 2.2), &[550.0], 1e5, 1e-12).unwrap_err();
        assert!(error.to_string().contains("1024 slices"), "{error}");
        let error = slices(linear(1.4, 2.2), &[550.0], 100.0, 0.0).unwrap_err();
        assert!(error.to_string().contains("tolerance must be > 0"), "{error}");
    }
}
