//! Mixtures of two media.

use std::sync::Arc;

use super::rule::Rule;
use super::value::{Index, Inner, Medium, Mixture, Part};
use crate::OpticsError;

/// Two media, each with its volume before mixing per volume of the mixture; known where both are.
pub(super) fn mix(first: (Medium, f64), second: (Medium, f64), rule: Rule) -> Medium {
    let range_nm = match (first.0.range_nm(), second.0.range_nm()) {
        (Some((a, b)), Some((c, d))) => Some((a.max(c), b.min(d))),
        (one, other) => one.or(other),
    };
    let source = format!("{} / {}", first.0.source(), second.0.source());
    let known = |medium: &Medium| medium.0.builtin || medium.constant_index().is_some();
    let builtin = known(&first.0) && known(&second.0);
    let parts = [first, second].map(|(medium, volume)| Part { medium, volume });
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
