//! The CIE standard observers.

use iridesce_numerics::Argument;

use std::sync::OnceLock;

use super::table::{at_one_nm, own_triples};
use crate::OpticsError;
use crate::medium::VISIBLE_NM;

/// First wavelength of the observer tables, nm.
pub const FIRST_NM: f64 = VISIBLE_NM.0;
/// Last wavelength of the observer tables, nm.
pub const LAST_NM: f64 = VISIBLE_NM.1;

/// A CIE standard colorimetric observer, tabulated at 1 nm over 360..830 nm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Observer {
    /// CIE 1931, 2 degrees.
    #[default]
    Cie1931,
    /// CIE 1964, 10 degrees.
    Cie1964,
}

impl Observer {
    /// `"cie1931"` (also `"2"`, `"2deg"`) or `"cie1964"` (`"10"`, `"10deg"`); letter case does not matter.
    pub fn named(name: &str) -> Result<Observer, OpticsError> {
        match name.trim().to_ascii_lowercase().as_str() {
            "cie1931" | "2" | "2deg" => Ok(Observer::Cie1931),
            "cie1964" | "10" | "10deg" => Ok(Observer::Cie1964),
            _ => Err(Argument::one_of("observer", &["cie1931", "cie1964"], name).into()),
        }
    }

    /// The name that [`Observer::named`] takes.
    pub fn name(self) -> &'static str {
        match self {
            Observer::Cie1931 => "cie1931",
            Observer::Cie1964 => "cie1964",
        }
    }

    /// The table: (xbar, ybar, zbar) at 360, 361, .. 830 nm.
    pub fn table(self) -> &'static [[f64; 3]] {
        static CIE1931: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
        static CIE1964: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
        match self {
            Observer::Cie1931 => {
                CIE1931.get_or_init(|| own_triples(include_str!("../../data/observers/cie1931.csv"), "cie1931.csv"))
            }
            Observer::Cie1964 => {
                CIE1964.get_or_init(|| own_triples(include_str!("../../data/observers/cie1964.csv"), "cie1964.csv"))
            }
        }
    }

    /// (xbar, ybar, zbar) at a vacuum wavelength: linear between the 1 nm entries, zero outside 360..830 nm.
    pub fn at(self, wavelength_nm: f64) -> [f64; 3] {
        at_one_nm(self.table(), FIRST_NM, wavelength_nm).unwrap_or([0.0; 3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_published_figures() {
        // Wyszecki & Stiles, Color Science, 2nd ed., 1982.
        assert_eq!(Observer::Cie1931.at(560.0), [0.5945, 0.995, 0.0039]);
        assert_eq!(Observer::Cie1931.at(450.0), [0.3362, 0.038, 1.77211]);
        assert_eq!(Observer::Cie1964.at(560.0)[1], 0.997340);
        for observer in [Observer::Cie1931, Observer::Cie1964] {
            assert_eq!(observer.table().len(), 471);
        }
    }

    #[test]
    fn linear_between_and_zero_outside() {
        let observer = Observer::Cie1931;
        let (a, b, middle) = (observer.at(600.0), observer.at(601.0), observer.at(600.25));
        for i in 0..3 {
            assert!((middle[i] - (0.75 * a[i] + 0.25 * b[i])).abs() < 1e-15);
        }
        assert!(observer.at(360.0)[0] > 0.0 && observer.at(830.0)[0] > 0.0);
        for outside in [359.999, 830.001, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(observer.at(outside), [0.0; 3]);
        }
    }

    #[test]
    fn names() {
        for observer in [Observer::Cie1931, Observer::Cie1964] {
            assert_eq!(Observer::named(observer.name()).unwrap(), observer);
        }
        assert!(Observer::named("cie2015").unwrap_err().to_string().contains("cie1931"));
    }
}
