//! Mixtures by effective-medium rules: Lorentz-Lorenz, Bruggeman, Maxwell Garnett.

use iridesce_numerics::Argument;

use std::sync::Arc;

use super::{Index, Inner, Medium, Mixture};
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

    /// The index of the mixture from those of its parts.
    pub(super) fn index(
        self,
        parts: &[Part],
        index: impl Fn(&Medium) -> Result<Complex64, OpticsError>,
    ) -> Result<Complex64, OpticsError> {
        match (self, parts) {
            (Rule::Bruggeman, [first, second]) => {
                Ok(bruggeman(index(&first.medium)?.powi(2), index(&second.medium)?.powi(2), second.volume))
            }
            (Rule::MaxwellGarnett, [host, spheres]) => {
                Ok(maxwell_garnett(index(&host.medium)?.powi(2), index(&spheres.medium)?.powi(2), spheres.volume))
            }
            _ => lorentz_lorenz(parts, index),
        }
    }
}

/// One part of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    medium: Medium,
    /// Its volume before mixing, per volume of the mixture. Liquids shrink when they mix, so the sum may exceed 1.
    volume: f64,
}

/// Two media, each with its volume before mixing per volume of the mixture; known where both are.
pub(super) fn mix(first: (Medium, f64), second: (Medium, f64), rule: Rule) -> Medium {
    let range_nm = match (first.0.range_nm(), second.0.range_nm()) {
        (Some((a, b)), Some((c, d))) => Some((a.max(c), b.min(d))),
        (one, other) => one.or(other),
    };
    let source = format!("{} / {}", first.0.source(), second.0.source());
    let known = |medium: &Medium| medium.0.builtin || medium.constant_index().is_some();
    let builtin = known(&first.0) && known(&second.0);
    let parts = [first, second].map(|(medium, volume)| Part { medium, volume }).to_vec();
    Medium(Arc::new(Inner {
        name: String::new(),
        source,
        note: String::new(),
        builtin,
        index: Index::Mixture(Mixture { rule, parts }),
        range_nm,
    }))
}

/// The mixture of two passive media with volumes `first.1` and `second.1`; see [`Medium::mixture`].
pub(super) fn checked(
    first: (Medium, f64),
    second: (Medium, f64),
    rule: Rule,
    name: &str,
) -> Result<Medium, OpticsError> {
    for (medium, volume) in [&first, &second] {
        if !(volume.is_finite() && *volume >= 0.0) {
            return Err(OpticsError::Argument(format!("the share of a part must be >= 0 and finite, got {volume}")));
        }
        if medium.constant_index().is_some_and(|index| index.im < 0.0) {
            return Err(OpticsError::Argument(format!("a mixture needs parts with k >= 0, got {}", medium.name())));
        }
    }
    if rule != Rule::LorentzLorenz && (first.1 + second.1 - 1.0).abs() > 1e-12 {
        return Err(OpticsError::Argument(format!("volume shares must add to 1, got {} and {}", first.1, second.1)));
    }
    if let (Some((a, b)), Some((c, d))) = (first.0.range_nm(), second.0.range_nm())
        && (a > d || c > b)
    {
        return Err(OpticsError::Data(format!(
            "media \"{}\" ({a}-{b} nm) and \"{}\" ({c}-{d} nm) have no wavelength in common",
            first.0.name(),
            second.0.name()
        )));
    }
    let mut medium = mix(first, second, rule);
    if let Some(inner) = Arc::get_mut(&mut medium.0) {
        name.clone_into(&mut inner.name);
    }
    Ok(medium)
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
fn lorentz_lorenz(
    parts: &[Part],
    index: impl Fn(&Medium) -> Result<Complex64, OpticsError>,
) -> Result<Complex64, OpticsError> {
    let mut sum = Complex64::new(0.0, 0.0);
    for part in parts {
        let square = index(&part.medium)?.powi(2);
        sum += part.volume * (square - 1.0) / (square + 2.0);
    }
    Ok(((1.0 + 2.0 * sum) / (1.0 - sum)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{Rule, checked, mix};
    use crate::{Beyond, Complex64, Medium};

    fn constant(n: f64) -> Medium {
        Medium::constant(Complex64::new(n, 0.0)).unwrap()
    }

    /// Halves of n = 1 and n = 2: (n^2 - 1) / (n^2 + 2) = 0 + 0.5 / 2, so n^2 = 1.5 / 0.75 = 2.
    #[test]
    fn worked_by_hand() {
        let index = |mixture: Medium| mixture.index(500.0, Beyond::Refuse).unwrap();
        let half = index(mix((constant(1.0), 0.5), (constant(2.0), 0.5), Rule::LorentzLorenz));
        assert!((half - Complex64::new(2.0_f64.sqrt(), 0.0)).norm() < 1e-15, "{half}");
        let same = index(mix((constant(1.5), 0.25), (constant(1.5), 0.75), Rule::LorentzLorenz));
        assert!((same - Complex64::new(1.5, 0.0)).norm() < 1e-15, "{same}");
    }

    #[test]
    fn known_where_both_parts_are() {
        let narrow = Medium::from_rows(&[(1, 500.0, 1.4, 0.0), (2, 900.0, 1.4, 0.0)], false, "a", "").unwrap();
        let wide = Medium::from_rows(&[(1, 400.0, 1.5, 0.0), (2, 600.0, 1.5, 0.0)], false, "b", "").unwrap();
        let mixture = mix((narrow, 0.5), (wide, 0.5), Rule::Bruggeman);
        assert_eq!(mixture.range_nm(), Some((500.0, 600.0)));
        assert!(mixture.index(450.0, Beyond::Refuse).is_err());
        mixture.index(450.0, Beyond::Hold).unwrap();
    }

    fn complex(n: f64, k: f64) -> Medium {
        Medium::constant(Complex64::new(n, k)).unwrap()
    }

    fn of(first: &Medium, second: &Medium, share: f64, rule: Rule) -> Complex64 {
        let mixture = checked((first.clone(), 1.0 - share), (second.clone(), share), rule, "m").unwrap();
        mixture.index(500.0, Beyond::Refuse).unwrap()
    }

    #[test]
    fn rules_solve_their_equations() {
        let pairs = [
            (complex(1.0, 0.0), complex(2.4, 0.0)),
            (complex(1.5, 0.0), complex(0.06, 3.6)),
            (complex(1.3, 0.2), complex(4.1, 0.03)),
        ];
        for (first, second) in &pairs {
            let index = |medium: &Medium| medium.index(500.0, Beyond::Refuse).unwrap();
            let (a, b) = (index(first).powi(2), index(second).powi(2));
            for share in [0.0, 0.01, 0.2, 0.333, 0.5, 0.7, 0.999, 1.0] {
                let e = of(first, second, share, Rule::Bruggeman).powi(2);
                let left = (1.0 - share) * (a - e) * (b + 2.0 * e) + share * (b - e) * (a + 2.0 * e);
                assert!(left.norm() < 1e-13 * (a.norm() + b.norm()).powi(2), "{a} {b} {share} {e}");
                assert!(e.im >= -1e-15, "{e}");
                let e = of(first, second, share, Rule::MaxwellGarnett).powi(2);
                let left = (e - a) * (b + 2.0 * a) - share * (b - a) * (e + 2.0 * a);
                assert!(left.norm() < 1e-12 * (a.norm() + b.norm()).powi(2), "{a} {b} {share} {e}");
            }
            for rule in [Rule::Bruggeman, Rule::MaxwellGarnett, Rule::LorentzLorenz] {
                assert!((of(first, second, 0.0, rule) - index(first)).norm() < 1e-13);
                assert!((of(first, second, 1.0, rule) - index(second)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn bruggeman_does_not_care_which_part_comes_first_and_grows_smoothly() {
        let (air, silver) = (complex(1.0, 0.0), complex(0.06, 3.6));
        let mut last = of(&air, &silver, 0.0, Rule::Bruggeman);
        for step in 1..=1000 {
            let share = f64::from(step) / 1000.0;
            let there = of(&air, &silver, share, Rule::Bruggeman);
            let back = of(&silver, &air, 1.0 - share, Rule::Bruggeman);
            assert!((there - back).norm() < 1e-9, "{share} {there} {back}");
            assert!((there - last).norm() < 0.3, "a jump at {share}: {last} {there}");
            last = there;
        }
    }

    #[test]
    fn refuses_what_is_no_mixture() {
        let (air, glass) = (complex(1.0, 0.0), complex(1.5, 0.0));
        let no = |result: Result<Medium, crate::OpticsError>| result.unwrap_err().to_string();
        assert!(no(checked((air.clone(), 0.5), (glass.clone(), 0.6), Rule::Bruggeman, "m")).contains("add to 1"));
        assert!(no(checked((air.clone(), -0.5), (glass.clone(), 1.5), Rule::Bruggeman, "m")).contains(">= 0"));
        assert!(no(checked((complex(1.5, -0.1), 0.5), (glass, 0.5), Rule::Bruggeman, "m")).contains("k >= 0"));
        let table = |from: f64| Medium::from_rows(&[(1, from, 1.4, 0.0), (2, from + 100.0, 1.4, 0.0)], false, "a", "");
        let (low, high) = (table(500.0), table(700.0));
        let text = no(checked((low.unwrap(), 0.5), (high.unwrap(), 0.5), Rule::Bruggeman, "m"));
        assert!(text.contains("in common"), "{text}");
        assert!(Rule::named("Bruggeman").is_err());
    }
}
