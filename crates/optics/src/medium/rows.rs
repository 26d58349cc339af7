//! From rows of numbers, each with its line in the file, to tables over ascending wavelength.

use super::value::check_index;
use crate::spectrum::Tabulated;
use crate::{Complex64, OpticsError};

/// Which quantities a row holds after its wavelength.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Columns {
    N,
    K,
    NK,
}

impl Columns {
    /// Numbers in a row, the wavelength included.
    pub(super) fn count(self) -> usize {
        if self == Columns::NK { 3 } else { 2 }
    }

    /// The row in words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Columns::N => "wavelength and n",
            Columns::K => "wavelength and k",
            Columns::NK => "wavelength, n and k",
        }
    }
}

/// One row: its line in the file, its wavelength, and n, k (0 where absent).
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) line: usize,
    pub(super) wavelength_nm: f64,
    pub(super) n: f64,
    pub(super) k: f64,
}

impl Row {
    /// A checked row of finite numbers; the message says what is wrong.
    pub(super) fn new(line: usize, columns: Columns, numbers: &[f64]) -> Result<Row, String> {
        if numbers.len() != columns.count() {
            return Err(format!("a row holds {}, got {} numbers", columns.words(), numbers.len()));
        }
        let wavelength_nm = numbers[0];
        if wavelength_nm <= 0.0 {
            return Err(format!("a wavelength must be > 0, got {wavelength_nm}"));
        }
        let (n, k) = match columns {
            Columns::N => (numbers[1], 0.0),
            Columns::K => (0.0, numbers[1]),
            Columns::NK => (numbers[1], numbers[2]),
        };
        if columns != Columns::K {
            check_index(Complex64::new(n, k))
                .map_err(|got| format!("n must be >= 0 (and > 0 without k), within 1e-12 to 1e12; {got}"))?;
        }
        Ok(Row { line, wavelength_nm, n, k })
    }
}

/// What to do with rows of the same wavelength and different values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Repeated {
    /// An error that names both lines: in a measured table it is a mistake.
    Refuse,
    /// Their mean: published pages hold neighbouring rows whose wavelengths were rounded to the same digits.
    Mean,
}

/// Tables of n and of k over ascending wavelength (the rows may come in any order), and how many wavelengths
/// were given more than once with different values.
pub(super) fn tables(
    mut rows: Vec<Row>,
    repeated: Repeated,
    label: &str,
) -> Result<(Tabulated, Tabulated, usize), OpticsError> {
    rows.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
    let (mut x, mut n, mut k) = (Vec::new(), Vec::new(), Vec::new());
    let mut conflicts = 0;
    for same in rows.chunk_by(|a, b| a.wavelength_nm == b.wavelength_nm) {
        let first = same[0];
        let (mut mean_n, mut mean_k) = (first.n, first.k);
        if let Some(other) = same.iter().find(|row| row.n != first.n || row.k != first.k) {
            if repeated == Repeated::Refuse {
                return Err(OpticsError::Data(format!(
                    "{label}:{}: the wavelength {} nm stands on line {} too, with other values",
                    other.line, first.wavelength_nm, first.line
                )));
            }
            conflicts += 1;
            let count = same.len() as f64;
            mean_n = same.iter().map(|row| row.n / count).sum();
            mean_k = same.iter().map(|row| row.k / count).sum();
        }
        x.push(first.wavelength_nm);
        n.push(mean_n);
        k.push(mean_k);
    }
    let unsound = || OpticsError::Data(format!("{label}: the table holds no rows"));
    let n = Tabulated::new(x.clone(), n).ok_or_else(unsound)?;
    let k = Tabulated::new(x, k).ok_or_else(unsound)?;
    Ok((n, k, conflicts))
}
