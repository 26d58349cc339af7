//! Mixtures of transparent liquids by the Lorentz-Lorenz rule.

use std::sync::Arc;

use super::{Index, Inner, Medium};
use crate::{Complex64, OpticsError};

/// One part of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    medium: Medium,
    /// Its volume before mixing, per volume of the mixture. Liquids shrink when they mix, so the sum may exceed 1.
    volume: f64,
}

/// Two media, each with its volume before mixing per volume of the mixture; known where both are.
pub(super) fn mix(first: (Medium, f64), second: (Medium, f64)) -> Medium {
    let range_nm = match (first.0.range_nm(), second.0.range_nm()) {
        (Some((a, b)), Some((c, d))) => Some((a.max(c), b.min(d))),
        (one, other) => one.or(other),
    };
    let source = format!("{} / {}", first.0.source(), second.0.source());
    let parts = [first, second].map(|(medium, volume)| Part { medium, volume });
    Medium(Arc::new(Inner {
        name: String::new(),
        source,
        note: String::new(),
        builtin: false,
        index: Index::Mixture(parts.to_vec()),
        range_nm,
    }))
}

/// (n^2 - 1) / (n^2 + 2) = sum of v (n_i^2 - 1) / (n_i^2 + 2) over the parts, v the volume that the part had before
/// mixing per volume of the mixture: the refractions of the molecules add (Lorentz-Lorenz formula, Born & Wolf,
/// Principles of Optics, sec. 2.3.3).
pub(super) fn lorentz_lorenz(
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
    use super::mix;
    use crate::{Beyond, Complex64, Medium};

    fn constant(n: f64) -> Medium {
        Medium::constant(Complex64::new(n, 0.0)).unwrap()
    }

    /// Halves of n = 1 and n = 2: (n^2 - 1) / (n^2 + 2) = 0 + 0.5 / 2, so n^2 = 1.5 / 0.75 = 2.
    #[test]
    fn worked_by_hand() {
        let index = |mixture: Medium| mixture.index(500.0, Beyond::Refuse).unwrap();
        let half = index(mix((constant(1.0), 0.5), (constant(2.0), 0.5)));
        assert!((half - Complex64::new(2.0_f64.sqrt(), 0.0)).norm() < 1e-15, "{half}");
        let same = index(mix((constant(1.5), 0.25), (constant(1.5), 0.75)));
        assert!((same - Complex64::new(1.5, 0.0)).norm() < 1e-15, "{same}");
    }

    #[test]
    fn known_where_both_parts_are() {
        let narrow = Medium::from_csv("500 1.4\n900 1.4", "a").unwrap();
        let wide = Medium::from_csv("400 1.5\n600 1.5", "b").unwrap();
        let mixture = mix((narrow, 0.5), (wide, 0.5));
        assert_eq!(mixture.range_nm(), Some((500.0, 600.0)));
        assert!(mixture.index(450.0, Beyond::Refuse).is_err());
        mixture.index(450.0, Beyond::Hold).unwrap();
    }
}
