//! The nine dispersion formulas of refractiveindex.info: n against vacuum wavelength in micrometres.

/// One dispersion formula with its coefficients.
///
/// With L the vacuum wavelength in micrometres and coefficients c1, c2, ... (missing ones are 0):
///
/// | number | name | formula |
/// |---|---|---|
/// | 1 | Sellmeier | n^2 - 1 = c1 + sum c2 L^2 / (L^2 - c3^2) + ... |
/// | 2 | Sellmeier-2 | n^2 - 1 = c1 + sum c2 L^2 / (L^2 - c3) + ... |
/// | 3 | polynomial | n^2 = c1 + sum c2 L^c3 + ... |
/// | 4 | RefractiveIndex.INFO | n^2 = c1 + c2 L^c3 / (L^2 - c4^c5) + c6 L^c7 / (L^2 - c8^c9) + sum c10 L^c11 + ... |
/// | 5 | Cauchy | n = c1 + sum c2 L^c3 + ... |
/// | 6 | gases | n - 1 = c1 + sum c2 / (c3 - L^-2) + ... |
/// | 7 | Herzberger | n = c1 + c2 / (L^2 - 0.028) + c3 / (L^2 - 0.028)^2 + c4 L^2 + c5 L^4 + c6 L^6 |
/// | 8 | retro | (n^2 - 1) / (n^2 + 2) = c1 + c2 L^2 / (L^2 - c3) + c4 L^2 |
/// | 9 | exotic | n^2 = c1 + c2 / (L^2 - c3) + c4 (L - c5) / ((L - c5)^2 + c6) |
///
/// Source: "Dispersion formulas", documentation of the refractiveindex.info database (CC0).
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    number: u8,
    coefficients: Vec<f64>,
}

/// Fewest and most coefficients of each formula, 1 to 9. The database's own upper bounds.
const COUNTS: [(usize, usize); 9] = [(1, 17), (1, 17), (1, 17), (1, 17), (1, 11), (1, 11), (1, 6), (1, 4), (1, 6)];

impl Formula {
    /// Formula `number` (1 to 9) with finite coefficients; the message says what is wrong.
    pub fn new(number: u8, coefficients: Vec<f64>) -> Result<Formula, String> {
        let Some(&(fewest, most)) = (number as usize).checked_sub(1).and_then(|i| COUNTS.get(i)) else {
            return Err(format!("dispersion formulas are numbered 1 to 9, got {number}"));
        };
        let count = coefficients.len();
        if !(fewest..=most).contains(&count) {
            return Err(format!("formula {number} takes {fewest} to {most} coefficients, got {count}"));
        }
        if let Some(bad) = coefficients.iter().position(|c| !c.is_finite()) {
            return Err(format!("coefficient {} is {}", bad + 1, coefficients[bad]));
        }
        // A term cut in half would silently become another term, so a truncated list is refused.
        let whole = match number {
            1 | 2 | 3 | 5 | 6 => count % 2 == 1,
            4 => matches!(count, 1 | 5 | 9) || (count > 9 && count % 2 == 1),
            _ => true,
        };
        if !whole {
            let rule = if number == 4 { "1, 5, 9, 11, 13, 15 or 17" } else { "an odd number of" };
            return Err(format!("formula {number} takes {rule} coefficients (whole terms), got {count}"));
        }
        Ok(Formula { number, coefficients })
    }

    /// The number of the formula, 1 to 9.
    pub fn number(&self) -> u8 {
        self.number
    }

    /// n at a vacuum wavelength in nm; the message says why there is none (n^2 <= 0, a pole).
    pub fn n(&self, wavelength_nm: f64) -> Result<f64, String> {
        // The formulas take micrometres; dividing by 1000 rounds once, multiplying by 1e-3 twice.
        let um = wavelength_nm / 1000.0;
        let square = |what: f64| {
            if what > 0.0 && what.is_finite() {
                Ok(what.sqrt())
            } else {
                Err(format!("its dispersion formula has n^2 = {what} there"))
            }
        };
        match self.number {
            1 => square(1.0 + self.c(1) + self.terms(2, |b, c| b * um * um / (um * um - c * c))),
            2 => square(1.0 + self.c(1) + self.terms(2, |b, c| b * um * um / (um * um - c))),
            3 => square(self.c(1) + self.terms(2, |b, c| b * um.powf(c))),
            4 => {
                let resonance = |first: usize| {
                    let [b, p, c, q] = [0, 1, 2, 3].map(|i| self.c(first + i));
                    if b == 0.0 { 0.0 } else { b * um.powf(p) / (um * um - c.powf(q)) }
                };
                square(self.c(1) + resonance(2) + resonance(6) + self.terms(10, |b, c| b * um.powf(c)))
            }
            5 => real(self.c(1) + self.terms(2, |b, c| b * um.powf(c))),
            6 => real(1.0 + self.c(1) + self.terms(2, |b, c| b / (c - 1.0 / (um * um)))),
            7 => {
                let l = 1.0 / (um * um - 0.028);
                let even = self.c(4) * um.powi(2) + self.c(5) * um.powi(4) + self.c(6) * um.powi(6);
                real(self.c(1) + self.c(2) * l + self.c(3) * l * l + even)
            }
            8 => {
                let ratio = self.c(1) + self.c(2) * um * um / (um * um - self.c(3)) + self.c(4) * um * um;
                square((1.0 + 2.0 * ratio) / (1.0 - ratio))
            }
            _ => {
                let shifted = um - self.c(5);
                square(
                    self.c(1)
                        + zero_or(self.c(2), um * um - self.c(3))
                        + zero_or(self.c(4) * shifted, shifted * shifted + self.c(6)),
                )
            }
        }
    }

    /// Coefficient number `i`, counted from 1 as in the formulas; 0 where none is given.
    fn c(&self, i: usize) -> f64 {
        self.coefficients.get(i - 1).copied().unwrap_or(0.0)
    }

    /// Sum of `term` over the coefficient pairs from number `first` on.
    fn terms(&self, first: usize, term: impl Fn(f64, f64) -> f64) -> f64 {
        let pairs = self.coefficients.get(first - 1..).unwrap_or(&[]).chunks_exact(2);
        // A term of weight 0 is absent even where its other coefficient makes a pole (0/0).
        pairs.map(|pair| if pair[0] == 0.0 { 0.0 } else { term(pair[0], pair[1]) }).sum()
    }
}

/// `a / b`, an absent term (weight 0) being 0 even at its pole.
fn zero_or(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

fn real(n: f64) -> Result<f64, String> {
    if n > 0.0 && n.is_finite() { Ok(n) } else { Err(format!("its dispersion formula has n = {n} there")) }
}

#[cfg(test)]
mod tests {
    use super::Formula;

    fn n(number: u8, coefficients: &[f64], wavelength_nm: f64) -> Result<f64, String> {
        Formula::new(number, coefficients.to_vec()).unwrap().n(wavelength_nm)
    }

    /// Each formula with coefficients simple enough to work out by hand, L = 0.5 um.
    #[test]
    fn hand_computed_values() {
        let close = |value: Result<f64, String>, wanted: f64| {
            let value = value.unwrap();
            assert!((value - wanted).abs() < 1e-14 * wanted, "{value} {wanted}");
        };
        // 1: 1 + 0.1 + 1.0 * 0.25 / (0.25 - 0.01) + 0.6 * 0.25 / (0.25 - 100)
        close(n(1, &[0.1, 1.0, 0.1, 0.6, 10.0], 500.0), (1.1 + 0.25 / 0.24 - 0.15 / 99.75_f64).sqrt());
        // 2: the same terms, C not squared
        close(n(2, &[0.1, 1.0, 0.01, 0.6, 100.0], 500.0), (1.1 + 0.25 / 0.24 - 0.15 / 99.75_f64).sqrt());
        // 3: 2.25 + 0.5 / 4 + 0.25 * 4 + 0.125 * 16 = 5.375
        close(n(3, &[2.25, 0.5, 2.0, 0.25, -2.0, 0.125, -4.0], 500.0), 5.375_f64.sqrt());
        // 4: 2 + 0.5 * 0.25 / (0.25 - 0.2^2) + 3 * 1 / (0.25 - 10) + 0.3 * 4 + 0.7 * 0.5
        close(
            n(4, &[2.0, 0.5, 2.0, 0.2, 2.0, 3.0, 0.0, 10.0, 1.0, 0.3, -2.0, 0.7, 1.0], 500.0),
            (2.0 + 0.125 / 0.21 - 3.0 / 9.75 + 1.2 + 0.35_f64).sqrt(),
        );
        // 5: 1.3 + 0.01 * 4 - 0.001 * 16 = 1.324
        close(n(5, &[1.3, 0.01, -2.0, -0.001, -4.0], 500.0), 1.324);
        // 6: 1 + 0.001 + 0.05 / (104 - 4) + 0.0024 / (64 - 4)
        close(n(6, &[0.001, 0.05, 104.0, 0.0024, 64.0], 500.0), 1.00154);
        // 7: L^2 - 0.028 = 0.222; 3 + 0.1/0.222 + 0.02/0.222^2 + 0.4 * 0.25 + 0.8 * 0.0625 - 0.64 * 0.015625
        close(
            n(7, &[3.0, 0.1, 0.02, 0.4, 0.8, -0.64], 500.0),
            3.0 + 0.1 / 0.222 + 0.02 / (0.222 * 0.222) + 0.1 + 0.05 - 0.01,
        );
        // 8: ratio = 0.2 + 0.1 * 0.25 / (0.25 - 0.05) + 0.04 * 0.25 = 0.335; n^2 = 1.67 / 0.665
        close(n(8, &[0.2, 0.1, 0.05, 0.04], 500.0), (1.67 / 0.665_f64).sqrt());
        // 9: 2 + 0.1 / (0.25 - 0.05) + 0.3 * 0.4 / (0.4^2 + 0.04) = 2 + 0.5 + 0.6
        close(n(9, &[2.0, 0.1, 0.05, 0.3, 0.1, 0.04], 500.0), 3.1_f64.sqrt());
    }

    /// Missing coefficients are zero: no stray pole, no 0/0.
    #[test]
    fn short_lists() {
        for (number, wanted) in [(1, 2.0_f64.sqrt()), (2, 2.0_f64.sqrt()), (3, 1.0), (4, 1.0), (5, 1.0), (6, 2.0)] {
            assert_eq!(n(number, &[1.0], 500.0), Ok(wanted), "formula {number}");
        }
        assert_eq!(n(7, &[1.5], 500.0), Ok(1.5));
        assert_eq!(n(8, &[0.25], 500.0), Ok(2.0_f64.sqrt()));
        assert_eq!(n(9, &[2.25], 500.0), Ok(1.5));
        assert_eq!(n(9, &[2.25, 0.0, 0.25, 0.0, 0.5], 500.0), Ok(1.5), "absent terms at their own poles");
        assert_eq!(n(1, &[1.25, 0.0, 0.5], 500.0), Ok(1.5));
    }

    #[test]
    fn no_index_is_an_error() {
        assert!(n(1, &[0.0, 1.0, 0.5], 500.0).unwrap_err().contains("n^2 = inf"), "a pole");
        assert!(n(1, &[0.0, 1.0, 0.6], 500.0).unwrap_err().contains("n^2 = -"), "inside the absorption");
        assert!(n(5, &[-1.5], 500.0).unwrap_err().contains("n = -1.5"));
        assert!(n(3, &[0.0], 500.0).is_err());
        assert!(n(4, &[2.0, 1.0, 0.0, -0.3, 1.5], 500.0).is_err(), "a negative base to a broken power is NaN");
        assert!(n(8, &[1.0], 500.0).is_err());
        assert!(n(7, &[1.0, 1.0], 0.028_f64.sqrt() * 1000.0).is_err());
    }

    #[test]
    fn refuses_lists_that_are_not_whole() {
        let refused = |number: u8, list: &[f64]| Formula::new(number, list.to_vec()).unwrap_err();
        assert!(refused(0, &[1.0]).contains("1 to 9"));
        assert!(refused(10, &[1.0]).contains("1 to 9"));
        assert!(refused(1, &[]).contains("got 0"));
        assert!(refused(1, &[0.0, 1.0]).contains("odd"));
        assert!(refused(4, &[0.0, 1.0, 0.0]).contains("1, 5, 9"));
        assert!(refused(7, &[0.0; 7]).contains("1 to 6"));
        assert!(refused(5, &[1.0, f64::NAN, 2.0]).contains("coefficient 2"));
    }
}
