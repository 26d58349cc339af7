//! Effective-medium rules: Lorentz-Lorenz, Bruggeman, Maxwell Garnett.

use iridesce_numerics::Argument;

use crate::{Complex64, OpticsError};

/// A rule for the index of a mixture finer than the wavelength.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The refractions of the molecules add: for solutions.
    LorentzLorenz,
    /// Both parts are grains on the same footing: for rough faces and porous or granular films.
    Bruggeman,
    /// Spheres of the second part in a host of the first, far from each other.
    MaxwellGarnett,
}

impl Rule {
    /// `"lorentz-lorenz"`, `"bruggeman"` or `"maxwell-garnett"`.
    pub fn named(name: &str) -> Result<Rule, OpticsError> {
        match name {
            "lorentz-lorenz" => Ok(Rule::LorentzLorenz),
            "bruggeman" => Ok(Rule::Bruggeman),
            "maxwell-garnett" => Ok(Rule::MaxwellGarnett),
            _ => Err(Argument::one_of("rule", &["bruggeman", "maxwell-garnett", "lorentz-lorenz"], name).into()),
        }
    }

    /// The index of the mixture from those of its parts, each with its volume.
    pub(super) fn index(self, parts: [(Complex64, f64); 2]) -> Complex64 {
        let [(first, _), (second, share)] = parts;
        match self {
            Rule::Bruggeman => bruggeman(first.powi(2), second.powi(2), share),
            Rule::MaxwellGarnett => maxwell_garnett(first.powi(2), second.powi(2), share),
            Rule::LorentzLorenz => lorentz_lorenz(parts),
        }
    }
}

/// (1 - f)(a - e)/(a + 2e) + f (b - e)/(b + 2e) = 0 for e = n^2 (D. A. G. Bruggeman, Ann. Phys. 416, 636 (1935)).
///
/// Of the two roots, whose product is -ab/2, the one of passive matter has Im e >= 0; where both are real, the one with
/// the sign of the parts.
fn bruggeman(a: Complex64, b: Complex64, share: f64) -> Complex64 {
    let sum = (2.0 - 3.0 * share) * a + (3.0 * share - 1.0) * b;
    let root = (sum * sum + 8.0 * a * b).sqrt();
    let (plus, minus) = (0.25 * (sum + root), 0.25 * (sum - root));
    // The smaller of the two by the product: their difference would lose its digits.
    let (plus, minus) =
        if plus.norm() >= minus.norm() { (plus, -0.5 * a * b / plus) } else { (-0.5 * a * b / minus, minus) };
    let tolerance = 1e-13 * (plus.norm() + minus.norm());
    let chosen = if (plus.im - minus.im).abs() > tolerance {
        if plus.im > minus.im { plus } else { minus }
    } else if (plus.re > minus.re) == (a.re + b.re > 0.0) {
        plus
    } else {
        minus
    };
    index_of(chosen)
}

/// (e - a)/(e + 2a) = f (b - a)/(b + 2a) for e = n^2, spheres b in a host a (J. C. Maxwell Garnett, Phil. Trans. R. Soc. A
/// 203, 385 (1904)).
fn maxwell_garnett(host: Complex64, spheres: Complex64, share: f64) -> Complex64 {
    let contrast = share * (spheres - host) / (spheres + 2.0 * host);
    index_of(host * (1.0 + 2.0 * contrast) / (1.0 - contrast))
}

/// The index of a permittivity; k of passive matter may round to below 0.
fn index_of(permittivity: Complex64) -> Complex64 {
    Complex64::new(permittivity.re, permittivity.im.max(0.0)).sqrt()
}

/// (n^2 - 1) / (n^2 + 2) = sum of v (n_i^2 - 1) / (n_i^2 + 2) over the parts, v the volume that the part had before
/// mixing per volume of the mixture: the refractions of the molecules add (Lorentz-Lorenz formula, Born & Wolf,
/// Principles of Optics, sec. 2.3.3).
fn lorentz_lorenz(parts: [(Complex64, f64); 2]) -> Complex64 {
    let mut sum = Complex64::new(0.0, 0.0);
    for (index, volume) in parts {
        let square = index.powi(2);
        sum += volume * (square - 1.0) / (square + 2.0);
    }
    ((1.0 + 2.0 * sum) / (1.0 - sum)).sqrt()
}
