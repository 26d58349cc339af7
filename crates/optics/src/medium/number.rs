//! Numbers in and out of text: decimal shifts that round once, short forms for messages.

use crate::Complex64;

/// The number in `text` times ten to the `shift`, rounded once.
///
/// "0.1879" micrometres read as a double and multiplied by 1000 is 187.89999999999998 nm, so that 187.9 nm
/// would fall outside; shifting the decimal exponent in the text gives 187.9.
/// `None` when the text is no finite decimal number.
pub(super) fn shifted(text: &str, shift: i32) -> Option<f64> {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let value: f64 = format!("{mantissa}e{}", exponent.checked_add(shift)?).parse().ok()?;
    value.is_finite().then_some(value)
}

/// The number in `text`, `None` when it is no finite decimal number.
pub(super) fn plain(text: &str) -> Option<f64> {
    shifted(text, 0)
}

/// A wavelength in nm for messages: whole nanometres, more digits only below 100.
pub(super) fn short_nm(nm: f64) -> String {
    if nm >= 100.0 {
        return format!("{nm:.0}");
    }
    let digits = (3.0 - nm.abs().max(1e-9).log10().floor()).max(0.0) as usize;
    let text = format!("{nm:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.to_owned()
}

/// `"188-1937"`.
pub(super) fn short_range((from, to): (f64, f64)) -> String {
    format!("{}-{}", short_nm(from), short_nm(to))
}

/// An index as a user would type it: `1.33`, `2+3j`.
pub(super) fn index_text(index: Complex64) -> String {
    if index.im == 0.0 { format!("{}", index.re) } else { format!("{}{:+}j", index.re, index.im) }
}

#[cfg(test)]
mod tests {
    use super::{index_text, plain, shifted, short_nm, short_range};
    use crate::Complex64;

    #[test]
    fn shifts_round_once() {
        assert_eq!(shifted("0.1879", 3), Some(187.9));
        assert_eq!(shifted("8.2", 3), Some(8200.0));
        assert_eq!(shifted("2.5000e-01", 3), Some(250.0));
        assert_eq!(shifted("1.2399E-04", 3), Some(0.12399));
        assert_eq!(shifted("+3E+2", 0), Some(300.0));
        for bad in [
            "",
            "nan",
            "NaN",
            "inf",
            "-inf",
            "infinity",
            "1e400",
            "1e",
            "e3",
            "0x10",
            "1_0",
            "1,5",
            "1e99999999999",
            "1e2147483647",
        ] {
            assert_eq!(shifted(bad, 3), None, "{bad}");
        }
        assert_eq!(plain("-1.5"), Some(-1.5));
    }

    #[test]
    fn short_forms() {
        assert_eq!(short_range((187.9, 1937.0)), "188-1937");
        assert_eq!(short_nm(0.12399), "0.124");
        assert_eq!(short_nm(31.07), "31.07");
        assert_eq!(short_nm(99.0), "99");
        assert_eq!(short_nm(10.0), "10");
        assert_eq!(index_text(Complex64::new(1.33, 0.0)), "1.33");
        assert_eq!(index_text(Complex64::new(2.0, 3.0)), "2+3j");
        assert_eq!(index_text(Complex64::new(2.0, -0.5)), "2-0.5j");
    }
}
