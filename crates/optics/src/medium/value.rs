//! A medium: what it is made from, and its index at a wavelength.

use std::sync::Arc;

use iridesce_numerics::WAVELENGTH_NM;

use super::formula::Formula;
use super::number::{index_text, short_nm, short_range};
use super::rule::Rule;
use crate::spectrum::Tabulated;
use crate::{Complex64, OpticsError};

/// Colour sums and renders ask for these wavelengths (nm); built-in media answer on all of them.
pub const VISIBLE_NM: (f64, f64) = (360.0, 830.0);

/// What to do with a wavelength outside a medium's data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// Refuse with an error that names the range.
    Refuse,
    /// Hold the end value.
    Hold,
}

/// What a medium is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// One index at every wavelength.
    Constant,
    /// A dispersion formula for n; no absorption.
    Formula,
    /// Tables of n, or of n and k.
    Table,
    /// A dispersion formula for n with a table of k.
    FormulaAndTable,
    /// Other media mixed.
    Mixture,
}

impl Kind {
    /// The word for it: `"constant"`, `"formula"`, `"table"`, `"formula and table"`, `"mixture"`.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Constant => "constant",
            Kind::Formula => "formula",
            Kind::Table => "table",
            Kind::FormulaAndTable => "formula and table",
            Kind::Mixture => "mixture",
        }
    }
}

/// Real part of the index against wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Real {
    Formula { formula: Formula, range_nm: (f64, f64) },
    Table(Tabulated),
}

impl Real {
    pub(super) fn range_nm(&self) -> (f64, f64) {
        match self {
            Real::Formula { range_nm, .. } => *range_nm,
            Real::Table(table) => table.range(),
        }
    }

    /// n with the end value held outside the range; the message says why there is none.
    fn held(&self, wavelength_nm: f64) -> Result<f64, String> {
        match self {
            Real::Formula { formula, range_nm } => formula.n(wavelength_nm.clamp(range_nm.0, range_nm.1)),
            Real::Table(table) => Ok(table.held(wavelength_nm)),
        }
    }

    /// n, a formula taken beyond its range, the end value of a table held.
    fn continued(&self, wavelength_nm: f64) -> Result<f64, String> {
        match self {
            Real::Formula { formula, .. } => formula.n(wavelength_nm),
            Real::Table(table) => Ok(table.held(wavelength_nm)),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Index {
    Constant(Complex64),
    Data { n: Real, k: Option<Tabulated> },
    Mixture(Mixture),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mixture {
    pub(super) rule: Rule,
    pub(super) parts: [Part; 2],
}

/// One part of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    pub(super) medium: Medium,
    /// Its volume before mixing, per volume of the mixture. Liquids shrink when they mix, so the sum may exceed 1.
    pub(super) volume: f64,
}

#[derive(Debug, PartialEq)]
pub(super) struct Inner {
    pub(super) name: String,
    pub(super) source: String,
    pub(super) note: String,
    pub(super) builtin: bool,
    pub(super) index: Index,
    pub(super) range_nm: Option<(f64, f64)>,
}

/// A medium: complex index `n + ik` against vacuum wavelength, with its source. Cheap to clone.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium(pub(super) Arc<Inner>);

impl Medium {
    /// A medium of one index at every wavelength.
    ///
    /// Allowed: n >= 0, finite, modulus from 1e-12 to 1e12; k < 0 is gain.
    pub fn constant(index: Complex64) -> Result<Medium, OpticsError> {
        // Adding zero turns -0.0 into 0.0, so that equal indices print and compare alike.
        let index = Complex64::new(index.re + 0.0, index.im + 0.0);
        check_index(index).map_err(|why| {
            OpticsError::Argument(format!(
                "the index of a medium must have n >= 0 and |n + ik| from 1e-12 to 1e12; {why}"
            ))
        })?;
        Ok(Medium(Arc::new(Inner {
            name: index_text(index),
            source: "given by the user".to_owned(),
            note: String::new(),
            builtin: false,
            index: Index::Constant(index),
            range_nm: None,
        })))
    }

    /// A medium of data read by one of the readers.
    pub(super) fn from_data(data: Data, label: &str) -> Result<Medium, OpticsError> {
        let Data { n, k, source, note } = data;
        let (mut from, mut to) = n.range_nm();
        if let Some(k) = &k {
            let (k_from, k_to) = k.range();
            if k_from > to || k_to < from {
                return Err(OpticsError::Data(format!(
                    "{label}: n is given for {} nm and k for {} nm; they have no wavelength in common",
                    short_range((from, to)),
                    short_range((k_from, k_to))
                )));
            }
            (from, to) = (from.max(k_from), to.min(k_to));
        }
        Ok(Medium(Arc::new(Inner {
            name: label.to_owned(),
            source,
            note,
            builtin: false,
            index: Index::Data { n, k },
            range_nm: Some((from, to)),
        })))
    }

    /// The name it was asked for by: a built-in name, a number such as `1.33` or `2+3j`, or a file's label.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Where the numbers come from: author, title, journal.
    pub fn source(&self) -> &str {
        &self.0.source
    }

    /// What a user should know about the data; may be empty.
    pub fn note(&self) -> &str {
        &self.0.note
    }

    /// What it is made from.
    pub fn kind(&self) -> Kind {
        match &self.0.index {
            Index::Constant(_) => Kind::Constant,
            Index::Data { n: Real::Formula { .. }, k: None } => Kind::Formula,
            Index::Data { n: Real::Formula { .. }, k: Some(_) } => Kind::FormulaAndTable,
            Index::Data { n: Real::Table(_), .. } => Kind::Table,
            Index::Mixture(_) => Kind::Mixture,
        }
    }

    /// The vacuum wavelengths (nm) its data cover, ends included, where both n and k are known;
    /// `None` for a constant, which holds everywhere.
    pub fn range_nm(&self) -> Option<(f64, f64)> {
        self.0.range_nm
    }

    /// The index where it does not depend on wavelength.
    pub fn constant_index(&self) -> Option<Complex64> {
        match &self.0.index {
            Index::Constant(index) => Some(*index),
            _ => None,
        }
    }

    /// How colour sums and renders continue a built-in medium whose data stop inside 360..830 nm, in words;
    /// `None` where nothing needs continuing, or nothing is continued (media of the user).
    pub fn extension(&self) -> Option<String> {
        let (from, to) = self.range_nm()?;
        let (first, last) = VISIBLE_NM;
        if !self.0.builtin || (from <= first && last <= to) {
            return None;
        }
        let mut gaps = Vec::new();
        if first < from {
            gaps.push(format!("{} nm", short_range((first, from))));
        }
        if to < last {
            gaps.push(format!("{} nm", short_range((to, last))));
        }
        let how = match &self.0.index {
            Index::Data { n: Real::Table(_), .. } => "the end value of the table is held",
            Index::Mixture(_) => "the parts are continued, each as it states",
            Index::Data { k: Some(_), .. } => "the dispersion formula is continued, the end value of k is held",
            _ => "the dispersion formula is continued",
        };
        Some(format!("{}: {how}", gaps.join(" and ")))
    }

    /// Complex index n + ik at a vacuum wavelength (nm, > 0).
    ///
    /// Outside the data [`Beyond::Refuse`] is an error that names the range; [`Beyond::Hold`] takes n and k
    /// each at the end of its own data. A formula that gives no index (n^2 < 0, a pole) is an error.
    pub fn index(&self, wavelength_nm: f64, beyond: Beyond) -> Result<Complex64, OpticsError> {
        self.index_at(wavelength_nm, beyond, "")
    }

    /// As [`Medium::index`]; `place` (such as `at index (3, 7)`, or empty) tells in errors which
    /// element of an array was meant.
    pub fn index_at(&self, wavelength_nm: f64, beyond: Beyond, place: &str) -> Result<Complex64, OpticsError> {
        check_wavelength(wavelength_nm, place)?;
        if beyond == Beyond::Refuse && !self.covers(wavelength_nm) {
            let asked = self.asked_outside(wavelength_nm, place);
            return Err(OpticsError::OutsideData(format!(
                "{asked}. Pass extrapolate=\"hold\" to accept the end value"
            )));
        }
        match &self.0.index {
            Index::Constant(index) => Ok(*index),
            Index::Data { n, k } => self.joined(n.held(wavelength_nm), k.as_ref(), wavelength_nm, place),
            Index::Mixture(Mixture { rule, parts }) => {
                let mixed = rule.index(each(parts, |medium| medium.index(wavelength_nm, Beyond::Hold))?);
                self.sound(mixed, wavelength_nm, place)
            }
        }
    }

    /// The index for colour sums and renders. Built-in media whose data stop inside 360..830 nm continue
    /// there as [`Medium::extension`] states; `true` tells that the extension was used.
    /// Media of the user are never continued.
    pub fn index_extended(&self, wavelength_nm: f64) -> Result<(Complex64, bool), OpticsError> {
        check_wavelength(wavelength_nm, "")?;
        if self.covers(wavelength_nm) {
            return self.index(wavelength_nm, Beyond::Refuse).map(|index| (index, false));
        }
        let asked = self.asked_outside(wavelength_nm, "");
        if !self.0.builtin {
            let (first, last) = VISIBLE_NM;
            return Err(OpticsError::OutsideData(format!(
                "{asked}. Colour sums and renders continue only built-in media beyond their data: \
                 give data for the whole of the wavelengths used ({first}-{last} nm unless wavelength_nm says otherwise)"
            )));
        }
        let (first, last) = VISIBLE_NM;
        if !(first..=last).contains(&wavelength_nm) {
            return Err(OpticsError::OutsideData(format!(
                "{asked}; its stated extension ends at {first} and {last} nm"
            )));
        }
        let index = match &self.0.index {
            Index::Constant(index) => *index,
            Index::Data { n, k } => self.joined(n.continued(wavelength_nm), k.as_ref(), wavelength_nm, "")?,
            Index::Mixture(Mixture { rule, parts }) => {
                let extended = |medium: &Medium| medium.index_extended(wavelength_nm).map(|(index, _)| index);
                self.sound(rule.index(each(parts, extended)?), wavelength_nm, "")?
            }
        };
        Ok((index, true))
    }

    fn covers(&self, wavelength_nm: f64) -> bool {
        self.0.range_nm.is_none_or(|(from, to)| from <= wavelength_nm && wavelength_nm <= to)
    }

    fn asked_outside(&self, wavelength_nm: f64, place: &str) -> String {
        let (from, to) = self.0.range_nm.unwrap_or((0.0, f64::INFINITY));
        // Rounded ends read best, but must not seem to contain the wavelength that they refuse.
        let (mut low, mut high) = (short_nm(from), short_nm(to));
        let seems_inside = |low: &str, high: &str| {
            let end = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
            end(low) <= wavelength_nm && wavelength_nm <= end(high)
        };
        if seems_inside(&low, &high) {
            (low, high) = (from.to_string(), to.to_string());
        }
        let place = spaced(place);
        format!("medium \"{}\" has data for {low}-{high} nm; {wavelength_nm:?} nm was asked{place}", self.0.name)
    }

    fn joined(
        &self,
        n: Result<f64, String>,
        k: Option<&Tabulated>,
        wavelength_nm: f64,
        place: &str,
    ) -> Result<Complex64, OpticsError> {
        let n = n.map_err(|why| self.no_index(&why, wavelength_nm, place))?;
        let k = k.map_or(0.0, |table| table.held(wavelength_nm));
        self.sound(Complex64::new(n, k), wavelength_nm, place)
    }

    /// A formula can leave what [`Medium::constant`] allows: close to a pole, or by rounding to nothing.
    fn sound(&self, index: Complex64, wavelength_nm: f64, place: &str) -> Result<Complex64, OpticsError> {
        check_index(index).map_err(|why| self.no_index(&why, wavelength_nm, place))?;
        Ok(index)
    }

    fn no_index(&self, why: &str, wavelength_nm: f64, place: &str) -> OpticsError {
        let place = spaced(place);
        OpticsError::Data(format!(
            "medium \"{}\" gives no refractive index at {wavelength_nm:?} nm{place}: {why}",
            self.0.name
        ))
    }
}

/// What a reader hands over.
pub(super) struct Data {
    pub(super) n: Real,
    pub(super) k: Option<Tabulated>,
    pub(super) source: String,
    pub(super) note: String,
}

/// The index of each part with its volume.
fn each(
    [first, second]: &[Part; 2],
    index: impl Fn(&Medium) -> Result<Complex64, OpticsError>,
) -> Result<[(Complex64, f64); 2], OpticsError> {
    Ok([(index(&first.medium)?, first.volume), (index(&second.medium)?, second.volume)])
}

/// The rule for every index, given or read: finite, n >= 0, neither nothing nor beyond all matter.
/// The bounds keep fourth powers of the index, which appear in the optics, inside double precision.
pub(super) fn check_index(index: Complex64) -> Result<(), String> {
    let modulus = index.norm();
    if index.re >= 0.0 && (1e-12..=1e12).contains(&modulus) {
        return Ok(());
    }
    Err(format!("got n = {:?}, k = {:?}", index.re, index.im))
}

fn check_wavelength(wavelength_nm: f64, place: &str) -> Result<(), OpticsError> {
    Ok(WAVELENGTH_NM.check(wavelength_nm).map(|_| ()).map_err(|wrong| wrong.at(place))?)
}

fn spaced(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(" {place}") }
}
