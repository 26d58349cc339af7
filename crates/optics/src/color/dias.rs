//! The road of 1991: ten-nanometre sums under illuminant C, the two-beam film, NTSC.
//!
//! From the paper (M. L. Dias, "Ray Tracing Interference Color", IEEE CG&A 11(2), 1991; corrected in 14(3), 1994): the
//! two-beam reflectance with amplitudes of normal incidence, and the colour purity eps (both in [`crate::film`]). From the student's report on it:
//! k = 1 / sum(S ybar), sums in 10 nm steps from 380 to 770 nm over illuminant C with the table of Wyszecki & Stiles, Color
//! Science, 1982, as printed there, and the printed inverse of the NTSC 1953 matrix.

use iridesce_numerics::{ANGLE_DEG, Argument, THICKNESS_NM};

use std::sync::OnceLock;

use super::illuminant::Illuminant;
use super::matrix::{Matrix, times};
use super::observer::Observer;
use super::space::Space;
use super::table::parse_csv;
use crate::film::two_beam_reflectance;
use crate::incidence::cos_of_degrees;
use crate::{Complex64, OpticsError};

/// The report's matrix from XYZ in percent to linear NTSC RGB.
pub const PRINTED_MATRIX: Matrix = [[0.0191, -0.0053, -0.0029], [-0.0098, 0.0200, -0.0003], [0.0006, -0.0012, 0.0090]];

/// The wavelengths of the sum, nm: 380, 390, .. 770.
pub fn dias1991_wavelengths() -> impl Iterator<Item = f64> {
    (38..=77).map(|ten| f64::from(ten) * 10.0)
}

/// Which tables of illuminant C and of the observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiasTable {
    /// The report's own, four digits.
    #[default]
    Printed,
    /// The CIE's, every digit.
    Full,
}

/// Which matrix from XYZ (Y = 1) to linear RGB.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DiasMatrix {
    /// [`PRINTED_MATRIX`], which is for percent, times 100.
    #[default]
    Printed,
    /// The one derived from the NTSC 1953 primaries and white C.
    Full,
    /// The caller's, for XYZ with Y = 1.
    Given(Matrix),
}

/// Weights of X, Y, Z at the forty wavelengths, the perfect reflector at Y = 1.
fn weights(table: DiasTable) -> &'static [[f64; 3]] {
    static PRINTED: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    static FULL: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    let normalised = |products: Vec<[f64; 3]>| {
        let total: f64 = products.iter().map(|w| w[1]).sum();
        products.into_iter().map(|w| w.map(|v| v / total)).collect()
    };
    match table {
        DiasTable::Printed => PRINTED.get_or_init(|| {
            let csv = parse_csv(include_str!("../../data/report_table1.csv"), "report_table1.csv")
                .expect("our own table reads");
            let field = |row: &[Option<f64>], i: usize| row[i].expect("our own table is full");
            normalised(
                csv.rows.iter().map(|(_, row)| std::array::from_fn(|i| field(row, 1) * field(row, 2 + i))).collect(),
            )
        }),
        DiasTable::Full => FULL.get_or_init(|| {
            let light = Illuminant::named("C").expect("C is a CIE table");
            let product = |nm: f64| Observer::Cie1931.at(nm).map(|v| v * light.power(nm));
            normalised(dias1991_wavelengths().map(product).collect())
        }),
    }
}

/// A film on the road of 1991: indices (first, film, last) at the forty wavelengths, ready for many points.
#[derive(Debug, Clone)]
pub struct Dias1991 {
    indices: Vec<[f64; 3]>,
    table: DiasTable,
    matrix: Matrix,
}

impl Dias1991 {
    /// `indices`: real indices > 0 of the first medium, the film and the last medium at [`dias1991_wavelengths`].
    pub fn new(indices: &[[Complex64; 3]], table: DiasTable, matrix: DiasMatrix) -> Result<Dias1991, OpticsError> {
        if indices.len() != dias1991_wavelengths().count() {
            return Err(OpticsError::Argument(format!("the sum has 40 wavelengths, got indices at {}", indices.len())));
        }
        for (n, nm) in indices.iter().flatten().zip(dias1991_wavelengths().flat_map(|nm| [nm; 3])) {
            if !(n.re > 0.0 && n.re.is_finite() && n.im == 0.0) {
                let message = format!("the two-beam form of 1991 needs real indices > 0, got {n} at {nm} nm");
                return Err(OpticsError::Argument(message));
            }
        }
        let matrix = match matrix {
            DiasMatrix::Printed => PRINTED_MATRIX.map(|row| row.map(|v| 100.0 * v)),
            DiasMatrix::Full => Space::Ntsc1953.rgb_from_xyz().expect("NTSC has primaries"),
            DiasMatrix::Given(matrix) if matrix.iter().flatten().all(|v| v.is_finite()) => matrix,
            DiasMatrix::Given(matrix) => {
                return Err(Argument::new("matrix", "finite", format!("{matrix:?}")).into());
            }
        };
        Ok(Dias1991 { indices: indices.iter().map(|n| n.map(|n| n.re)).collect(), table, matrix })
    }

    /// (XYZ with Y = 1 for the perfect reflector, linear RGB) at one thickness and angle in the first medium.
    pub fn color(&self, thickness_nm: f64, angle_deg: f64) -> Result<([f64; 3], [f64; 3]), OpticsError> {
        THICKNESS_NM.check(thickness_nm)?;
        ANGLE_DEG.check(angle_deg)?;
        let cos = cos_of_degrees(angle_deg);
        let mut xyz = [0.0; 3];
        for ((n, nm), weight) in self.indices.iter().zip(dias1991_wavelengths()).zip(weights(self.table)) {
            let reflectance = two_beam_reflectance(*n, thickness_nm, nm, cos)?;
            for (sum, w) in xyz.iter_mut().zip(weight) {
                *sum += reflectance * w;
            }
        }
        Ok((xyz, times(&self.matrix, xyz)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(n: [f64; 3], table: DiasTable, matrix: DiasMatrix) -> Dias1991 {
        Dias1991::new(&[n.map(Complex64::from); 40], table, matrix).unwrap()
    }

    #[test]
    fn first_rows_of_the_reference_file() {
        let matrix = [[1.91, -0.533, -0.288], [-0.985, 2.0, -0.028], [0.058, -0.118, 0.896]];
        let soap = film([1.0, 1.33, 1.0], DiasTable::Full, DiasMatrix::Given(matrix));
        let (xyz, rgb) = soap.color(105.0, 0.0).unwrap();
        for (value, wanted) in xyz.iter().zip([0.0754031438337, 0.0790717626875, 0.0821839523974]) {
            assert!((value - wanted).abs() < 1e-12);
        }
        for (value, wanted) in rgb.iter().zip([0.0782057769195, 0.0815702780316, 0.0686797356933]) {
            assert!((value - wanted).abs() < 1e-12);
        }
    }

    #[test]
    fn printed_differs_from_full_by_its_rounding() {
        let n = [1.0, 1.33, 1.0];
        let (printed, printed_rgb) = film(n, DiasTable::Printed, DiasMatrix::Printed).color(305.0, 20.0).unwrap();
        let (full, full_rgb) = film(n, DiasTable::Full, DiasMatrix::Full).color(305.0, 20.0).unwrap();
        for i in 0..3 {
            let off = (printed[i] - full[i]).abs();
            assert!(off > 0.0 && off < 2e-4 * full[1], "{printed:?} {full:?}");
            assert!((printed_rgb[i] - full_rgb[i]).abs() < 0.01 * full[1], "{printed_rgb:?} {full_rgb:?}");
        }
    }

    #[test]
    fn refuses() {
        let soap = film([1.5, 1.0, 1.5], DiasTable::Printed, DiasMatrix::Printed);
        assert!(soap.color(100.0, 60.0).unwrap_err().to_string().contains("critical angle"));
        assert!(soap.color(-1.0, 0.0).is_err() && soap.color(f64::NAN, 0.0).is_err() && soap.color(1.0, 90.0).is_err());
        let absorbing = [[Complex64::new(1.0, 0.0), Complex64::new(2.0, 0.1), Complex64::new(1.0, 0.0)]; 40];
        assert!(Dias1991::new(&absorbing, DiasTable::Printed, DiasMatrix::Printed).is_err());
        assert!(Dias1991::new(&absorbing[..3], DiasTable::Printed, DiasMatrix::Printed).is_err());
    }
}
