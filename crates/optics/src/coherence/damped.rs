//! One clear layer of uneven thickness, in closed form.

use crate::Complex64;
use crate::stack::LayerAiry;
use crate::stack::sweep::Power;

/// Terms that are added at most.
const MOST_TERMS: u32 = 100_000;

/// R or T of a stack one layer of which turns its light by `turn = exp(2 i kz k0 d)` from face to face and back, the m-th
/// harmonic of that times `exp(-m^2 damping)`: for a Gaussian spread of its thickness, `damping = (2 kz k0 sd)^2 / 2`.
///
/// With `q = r_inside r_below turn` and `e = t_above^2 r_below turn`,
///
/// ```text
/// <R> = |a|^2 + |e|^2/(1 - |q|^2) + 2 Re sum_m D^(m^2) q^(m-1) (a* e + |e|^2 q/(1 - |q|^2))
/// <T> = T_0 / (1 - |q|^2) (1 + 2 Re sum_m D^(m^2) q^m)
/// ```
///
/// (Airy's series, Born & Wolf, Principles of Optics, 7th ed., sec. 7.6, squared term by term.)
pub fn damped(airy: &LayerAiry, turn: Complex64, damping: f64, power: Power) -> f64 {
    let q = airy.r_inside * airy.r_below * turn;
    let size = q.norm_sqr();
    let head = airy.t_above_squared * airy.r_below * turn;
    let (base, factor) = match power {
        Power::Transmittance => {
            let base = airy.passed * turn.norm() / (1.0 - size);
            (base, base * q)
        }
        _ => {
            let echoes = head.norm_sqr() / (1.0 - size);
            (airy.r_above.norm_sqr() + echoes, airy.r_above.conj() * head + echoes * q)
        }
    };
    let modulus = size.sqrt();
    let (mut total, mut power_of_q, mut left) = (base, Complex64::new(1.0, 0.0), 1.0);
    for order in 1..MOST_TERMS {
        let m = f64::from(order);
        total += 2.0 * (-m * m * damping).exp() * (factor * power_of_q).re;
        left *= modulus;
        // The next term, and all after it, are below the last digit.
        if left * (-((m + 1.0) * (m + 1.0) * damping).min(700.0)).exp() < 1e-17 * (1.0 - modulus) {
            break;
        }
        power_of_q *= q;
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Polarization;
    use crate::incidence::Incidence;
    use crate::stack::{Solver, layer_airy};

    /// Without damping it is the stack itself, with much it is the incoherent slab.
    #[test]
    fn between_a_film_and_a_slab() {
        let n = [1.0, 2.0, 1.5].map(Complex64::from);
        let incidence = Incidence::from_degrees(40.0).unwrap();
        let (nm, d) = (550.0, 730.0);
        let mut solver = Solver::new();
        for polarization in [Polarization::S, Polarization::P] {
            let airy = layer_airy(&n, &[d], nm, incidence, polarization, 0).unwrap();
            let phase = 2.0 * airy.kz.re * std::f64::consts::TAU * d / nm;
            let turn = Complex64::from_polar(1.0, phase);
            for (coherent, damping) in [(true, 0.0), (false, 1e3)] {
                solver.prepare(&n, &[d], &[coherent], nm, incidence);
                let powers = solver.powers(polarization).unwrap();
                assert!((damped(&airy, turn, damping, Power::Reflectance) - powers.reflectance).abs() < 1e-14);
                assert!((damped(&airy, turn, damping, Power::Transmittance) - powers.transmittance).abs() < 1e-14);
            }
        }
    }
}
