//! Media: complex refractive index against vacuum wavelength, with source and range.
//!
//! `n + ik` with `k > 0` absorbs. A medium is one constant index, a page of refractiveindex.info
//! (dispersion formula, tables, or both), a CSV table, or a mixture of built-in media.
//! Tables are read by linear interpolation in wavelength.
//!
//! ```
//! use iridesce_optics::{Beyond, Medium};
//! let glass = Medium::named("N-BK7")?;
//! let index = glass.index(589.3, Beyond::Refuse)?;
//! assert_eq!(format!("{:.5}", index.re), "1.51673");
//! assert_eq!(glass.range_nm(), Some((300.0, 2500.0)));
//! # Ok::<(), iridesce_optics::OpticsError>(())
//! ```

mod catalogue;
mod formula;
mod mixture;
mod number;
mod page;
mod rows;
mod rule;
mod value;
mod yaml;

use crate::OpticsError;
pub use catalogue::names;
pub use formula::Formula;
pub use rule::Rule;
pub use value::{Beyond, Kind, Medium, VISIBLE_NM};
pub use yaml::MAX_TEXT_BYTES;

use rows::{Columns, Repeated, Row, tables};
use value::{Data, Real};

impl Medium {
    /// A built-in medium by name; see [`names`]. An unknown name is answered with the nearest known one.
    pub fn named(name: &str) -> Result<Medium, OpticsError> {
        catalogue::named(name)
    }

    /// Reads a page of the refractiveindex.info database (YAML). `label` names it in errors.
    ///
    /// Wavelengths in the text are micrometres. Dispersion formulas 1 to 9, `tabulated n`, `tabulated k` and
    /// `tabulated nk` are read; where n or k is given twice the later entry counts. Rows may stand in any
    /// order; of rows that repeat a wavelength with other values the mean is taken, because published pages
    /// hold such rounding pairs.
    pub fn from_yaml(text: &str, label: &str) -> Result<Medium, OpticsError> {
        yaml::read(text, label)
    }

    /// A table of n, or of n and k, as measured: linear between its rows, which may stand in any order. `label` names it, also
    /// in errors; `note` is kept beside it.
    ///
    /// Each row is its line in the file that it came from, the vacuum wavelength in nm, n and k (0 where there is none). A
    /// wavelength given twice with different values is an error.
    ///
    /// ```
    /// use iridesce_optics::{Beyond, Medium};
    /// let glass = Medium::from_rows(&[(1, 400.0, 1.54, 0.0), (2, 700.0, 1.51, 0.0)], false, "glass", "")?;
    /// assert_eq!(glass.index(550.0, Beyond::Refuse)?.re, 1.525);
    /// # Ok::<(), iridesce_optics::OpticsError>(())
    /// ```
    pub fn from_rows(
        rows: &[(usize, f64, f64, f64)],
        has_k: bool,
        label: &str,
        note: &str,
    ) -> Result<Medium, OpticsError> {
        if rows.is_empty() {
            return Err(OpticsError::Data(format!("{label}: holds no rows of nm, n [, k]")));
        }
        let checked = |&(line, nm, n, k): &(usize, f64, f64, f64)| {
            Row::new(line, Columns::NK, &[nm, n, k]).map_err(|why| OpticsError::Data(format!("{label}:{line}: {why}")))
        };
        let rows = rows.iter().map(checked).collect::<Result<Vec<Row>, OpticsError>>()?;
        let (n, k, _) = tables(rows, Repeated::Refuse, label)?;
        let data =
            Data { n: Real::Table(n), k: has_k.then_some(k), source: format!("file {label}"), note: note.to_owned() };
        Medium::from_data(data, label)
    }

    /// Two passive media mixed more finely than the wavelength, by an effective-medium rule; known where both are.
    ///
    /// Each comes with its volume per volume of the mixture. The two add to 1, except for [`Rule::LorentzLorenz`], where they
    /// are the volumes before mixing. `name` is what the mixture is called.
    pub fn mixture(first: (Medium, f64), second: (Medium, f64), rule: Rule, name: &str) -> Result<Medium, OpticsError> {
        mixture::checked(first, second, rule, name)
    }
}

#[cfg(test)]
mod tests;
