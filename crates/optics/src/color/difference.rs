//! CIEDE2000.

use super::space::hue_deg;

/// The colour difference CIEDE2000 of two CIELAB colours, with k_L = k_C = k_H = 1.
///
/// CIE 142-2001; formulae and the treatment of hues across 0 degrees after Sharma, Wu & Dalal, "The CIEDE2000
/// color-difference formula: implementation notes", Color Research & Application 30, 21 (2005).
pub fn ciede2000(a: [f64; 3], b: [f64; 3]) -> f64 {
    let seventh = |c: f64| {
        // c^7 / (c^7 + 25^7), written so that a huge chroma gives 1 and not inf / inf.
        if c == 0.0 { 0.0 } else { 1.0 / (1.0 + (25.0 / c).powi(7)) }
    };
    let mean_chroma = 0.5 * (a[1].hypot(a[2]) + b[1].hypot(b[2]));
    let g = 0.5 * (1.0 - seventh(mean_chroma).sqrt());
    let polar = |lab: [f64; 3]| {
        let a = (1.0 + g) * lab[1];
        (a.hypot(lab[2]), hue_deg(a, lab[2]))
    };
    let ((c1, h1), (c2, h2)) = (polar(a), polar(b));
    let grey = c1 == 0.0 || c2 == 0.0;

    let turn = h2 - h1;
    let dh_deg = match turn {
        _ if grey => 0.0,
        t if t > 180.0 => t - 360.0,
        t if t < -180.0 => t + 360.0,
        t => t,
    };
    let (dl, dc) = (b[0] - a[0], c2 - c1);
    let dh = 2.0 * c1.sqrt() * c2.sqrt() * (0.5 * dh_deg).to_radians().sin();

    let (l, c) = (0.5 * (a[0] + b[0]), 0.5 * (c1 + c2));
    let h = match h1 + h2 {
        s if grey => s,
        s if turn.abs() <= 180.0 => 0.5 * s,
        s if s < 360.0 => 0.5 * (s + 360.0),
        s => 0.5 * (s - 360.0),
    };
    let cos = |deg: f64| deg.to_radians().cos();
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0) - 0.20 * cos(4.0 * h - 63.0);
    let from_50 = (l - 50.0) * (l - 50.0);
    // from_50 / sqrt(20 + from_50), again without inf / inf
    let s_l = 1.0 + 0.015 * from_50 / (20.0 + from_50).sqrt();
    let s_c = 1.0 + 0.045 * c;
    let s_h = 1.0 + 0.015 * c * t;
    let d_theta = 30.0 * (-((h - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * seventh(c).sqrt() * (2.0 * d_theta).to_radians().sin();
    let (x, y, z) = (dl / s_l, dc / s_c, dh / s_h);
    // The form is not positive definite everywhere: a hair below zero is zero.
    (x * x + y * y + z * z + r_t * y * z).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_pairs() {
        // Sharma, Wu & Dalal 2005, table 1: pairs about grey, across 0 degrees, and of large difference.
        for (a, b, wanted) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0000),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
            ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            assert!((ciede2000(a, b) - wanted).abs() < 5e-5, "{a:?} {b:?} {}", ciede2000(a, b));
            assert!((ciede2000(b, a) - wanted).abs() < 5e-5);
            assert_eq!(ciede2000(a, a), 0.0);
        }
    }

    #[test]
    fn finite_for_finite_colours() {
        for lab in [[0.0, 1e-300, 0.0], [1e60, -1e60, 1e60], [-20.0, 0.0, 500.0]] {
            assert!(ciede2000(lab, [50.0, 0.0, 0.0]).is_finite());
        }
    }
}
