//! From linear RGB to light: the smooth factors by which the D65 spectrum is multiplied.

use std::sync::OnceLock;

use super::observer::{FIRST_NM, LAST_NM};
use super::table::{at_one_nm, own_triples};

/// The factors (f_R, f_G, f_B) at a vacuum wavelength.
///
/// The light `D65 * (r f_R + g f_G + b f_B)` has the linear Rec.709 coordinates (r, g, b) of the CIE 1931 observer,
/// to within 3e-4 of each coordinate: the published D65 table is that far from the white (0.3127, 0.3290).
/// All three are >= 0 and sum to 1, so a grey is D65 itself. Found once by a quadratic programme
/// (`tools/data/rgb_basis.py`) after the idea of Mallett & Yuksel, "Spectral primary decomposition for rendering with sRGB
/// reflectance", EGSR 2019. Outside 360..830 nm the end values are held.
pub fn rgb_basis(wavelength_nm: f64) -> [f64; 3] {
    static TABLE: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    let table = TABLE.get_or_init(|| own_triples(include_str!("../../data/observers/rgb_basis.csv"), "rgb_basis.csv"));
    let held = if wavelength_nm > FIRST_NM { wavelength_nm.min(LAST_NM) } else { FIRST_NM };
    at_one_nm(table, FIRST_NM, held).unwrap_or(table[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Illuminant, Observer};

    /// XYZ to linear Rec.709 with white (0.3127, 0.3290), IEC 61966-2-1 primaries; ten digits of the derived matrix.
    const RGB_FROM_XYZ: [[f64; 3]; 3] = [
        [3.2409699419, -1.53738317757, -0.498610760293],
        [-0.969243636281, 1.87596750151, 0.0415550574072],
        [0.055630079697, -0.203976958889, 1.05697151424],
    ];

    fn rgb_of(factor: impl Fn(f64) -> f64) -> [f64; 3] {
        let light = Illuminant::named("D65").unwrap();
        let (mut xyz, mut white) = ([0.0; 3], 0.0);
        for nm in 360..=830 {
            let nm = f64::from(nm);
            let (power, cmf) = (light.power(nm), Observer::Cie1931.at(nm));
            white += power * cmf[1];
            for i in 0..3 {
                xyz[i] += power * factor(nm) * cmf[i];
            }
        }
        std::array::from_fn(|i| (0..3).map(|j| RGB_FROM_XYZ[i][j] * xyz[j] / white).sum())
    }

    #[test]
    fn each_factor_has_its_own_coordinates() {
        for j in 0..3 {
            let rgb = rgb_of(|nm| rgb_basis(nm)[j]);
            for (i, value) in rgb.iter().enumerate() {
                let wanted = if i == j { 1.0 } else { 0.0 };
                // The white of the D65 table accounts for 2.4e-4 on the diagonal, and for nothing off it.
                let allowed = if i == j { 3e-4 } else { 1e-8 };
                assert!((value - wanted).abs() < allowed, "f_{j}: {rgb:?}");
            }
        }
    }

    #[test]
    fn non_negative_and_sum_to_one() {
        for tenth in 3600..=8300 {
            let f = rgb_basis(f64::from(tenth) / 10.0);
            assert!(f.iter().all(|&v| (0.0..=1.0).contains(&v)));
            assert!((f.iter().sum::<f64>() - 1.0).abs() < 2e-12, "{tenth}: {f:?}");
        }
    }

    #[test]
    fn smooth() {
        for nm in 361..830 {
            let nm = f64::from(nm);
            let (a, b, c) = (rgb_basis(nm - 1.0), rgb_basis(nm), rgb_basis(nm + 1.0));
            for j in 0..3 {
                assert!((a[j] - 2.0 * b[j] + c[j]).abs() < 2.5e-3, "{nm}");
                assert!((c[j] - b[j]).abs() < 0.035, "{nm}");
            }
        }
    }

    #[test]
    fn ends_are_held() {
        assert_eq!(rgb_basis(100.0), rgb_basis(360.0));
        assert_eq!(rgb_basis(2000.0), rgb_basis(830.0));
        assert!(rgb_basis(f64::NAN).iter().all(|v| v.is_finite()));
    }
}
