//! How the values of a colour space change with XYZ.

use super::matrix::{Matrix, mul};
use super::space::{
    Adaptation, OKLAB_FROM_ROOTS, OKLAB_LMS_FROM_XYZ, Space, bradford, rec2020_encode_slope, srgb_encode_slope,
};
use crate::color::matrix::times;

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Space {
    /// The derivatives of [`Space::from_xyz`]: row `i` holds those of value `i` with respect to X, Y, Z.
    ///
    /// `None` where there are none: xyY and Oklab of black, the hue of a grey.
    pub fn jacobian(self, xyz: [f64; 3], white: [f64; 3], adaptation: Adaptation) -> Option<Matrix> {
        let adapted = match (adaptation, self.white()) {
            (Adaptation::Bradford, Some(own)) => bradford(white, own),
            _ => IDENTITY,
        };
        let found = match self {
            Space::Xyz => IDENTITY,
            Space::Xyy => {
                let sum: f64 = xyz.iter().sum();
                let share =
                    |of: usize| std::array::from_fn(|i| (if i == of { sum } else { 0.0 } - xyz[of]) / (sum * sum));
                [share(0), share(1), IDENTITY[1]]
            }
            Space::Lab => lab(xyz, white),
            Space::Lch => {
                let [lightness, a, b] = lab(xyz, white);
                let [_, at_a, at_b] = self_lab(xyz, white);
                let chroma = at_a.hypot(at_b);
                [
                    lightness,
                    std::array::from_fn(|i| (at_a * a[i] + at_b * b[i]) / chroma),
                    std::array::from_fn(|i| ((at_a * b[i] - at_b * a[i]) / (chroma * chroma)).to_degrees()),
                ]
            }
            Space::Oklab => {
                let cones = mul(&OKLAB_LMS_FROM_XYZ, &adapted);
                let at = times(&cones, xyz);
                let slopes: Matrix = std::array::from_fn(|i| cones[i].map(|v| v / (3.0 * at[i].cbrt() * at[i].cbrt())));
                mul(&OKLAB_FROM_ROOTS, &slopes)
            }
            _ => {
                let matrix = mul(&self.rgb_from_xyz()?, &adapted);
                let linear = times(&matrix, xyz);
                std::array::from_fn(|i| matrix[i].map(|v| v * self.encode_slope(linear[i])))
            }
        };
        found.iter().flatten().all(|v| v.is_finite()).then_some(found)
    }

    fn encode_slope(self, linear: f64) -> f64 {
        match self {
            Space::Srgb | Space::DisplayP3 => srgb_encode_slope(linear.abs()),
            Space::Rec2020 => rec2020_encode_slope(linear.abs()),
            _ => 1.0,
        }
    }
}

fn self_lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    Space::Lab.from_xyz(xyz, white, Adaptation::None)
}

/// Derivatives of CIE 1976 L*a*b*.
fn lab(xyz: [f64; 3], white: [f64; 3]) -> Matrix {
    const DELTA: f64 = 6.0 / 29.0;
    let f: [f64; 3] = std::array::from_fn(|i| {
        let t = xyz[i] / white[i];
        let slope =
            if t > DELTA * DELTA * DELTA { 1.0 / (3.0 * t.cbrt() * t.cbrt()) } else { 1.0 / (3.0 * DELTA * DELTA) };
        slope / white[i]
    });
    [[0.0, 116.0 * f[1], 0.0], [500.0 * f[0], -500.0 * f[1], 0.0], [0.0, 200.0 * f[1], -200.0 * f[2]]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::SPACES;

    #[test]
    fn every_space_against_differences() {
        let white = [1.0985, 1.0, 0.3558];
        for adaptation in [Adaptation::None, Adaptation::Bradford] {
            for (space, name) in SPACES {
                for xyz in [[0.3, 0.25, 0.1], [0.02, 0.03, 0.2], [0.002, 0.001, 0.0004], [0.6, 0.9, 0.05]] {
                    let found = space.jacobian(xyz, white, adaptation).unwrap();
                    for j in 0..3 {
                        let at = |step: f64| {
                            let mut moved = xyz;
                            moved[j] += step;
                            space.from_xyz(moved, white, adaptation)
                        };
                        let (wide, near) = (1e-6, 5e-7);
                        for (i, row) in found.iter().enumerate() {
                            let slope = |h: f64| (at(h)[i] - at(-h)[i]) / (2.0 * h);
                            let wanted = (4.0 * slope(near) - slope(wide)) / 3.0;
                            let error = (row[j] - wanted).abs() / (1.0 + wanted.abs());
                            assert!(error < 2e-7, "{name} {xyz:?} {i}{j}: {} {wanted}", row[j]);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn none_where_there_is_none() {
        let white = [0.95, 1.0, 1.09];
        assert!(Space::Lch.jacobian(white.map(|v| 0.5 * v), white, Adaptation::None).is_none());
        assert!(Space::Oklab.jacobian([0.0; 3], white, Adaptation::None).is_none());
        assert!(Space::Xyy.jacobian([0.0; 3], white, Adaptation::None).is_none());
        assert!(Space::Lab.jacobian([0.0; 3], white, Adaptation::None).is_some());
    }
}
