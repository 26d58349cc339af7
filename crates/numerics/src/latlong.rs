//! Latitude-longitude maps: first row +y, middle column -z, columns grow towards +x.

use std::f64::consts::{PI, TAU};

/// The direction at `(column, row)`, counted in texels from the left and upper edge (a texel's middle is at its number and
/// a half), of a map of `[columns, rows]`.
///
/// ```
/// let ahead = iridesce_numerics::latlong::direction([4.0, 2.0], [8, 4]);
/// assert!((ahead[2] + 1.0).abs() < 1e-15 && ahead[0].abs() < 1e-15 && ahead[1].abs() < 1e-15);
/// ```
#[inline(always)]
pub fn direction([column, row]: [f64; 2], [columns, rows]: [usize; 2]) -> [f64; 3] {
    let colatitude = PI * row / rows as f64;
    let azimuth = TAU * (column / columns as f64 - 0.5);
    let level = colatitude.sin();
    [level * azimuth.sin(), colatitude.cos(), -level * azimuth.cos()]
}

/// Cosines of the colatitudes of the upper and the lower edge of a row.
#[inline(always)]
pub fn band(row: usize, rows: usize) -> [f64; 2] {
    [row, row + 1].map(|edge| (PI * edge as f64 / rows as f64).cos())
}

/// The solid angle of a texel of a row, sr.
#[inline(always)]
pub fn solid_angle(row: usize, [columns, rows]: [usize; 2]) -> f64 {
    let [upper, lower] = band(row, rows);
    TAU / columns as f64 * (upper - lower)
}

/// `(column, row)` in texels of a direction of length 1, the inverse of [`direction`]; columns in [0, columns].
#[inline(always)]
pub fn place([x, y, z]: [f64; 3], [columns, rows]: [usize; 2]) -> [f64; 2] {
    let turn = x.atan2(-z) / TAU + 0.5;
    [turn * columns as f64, y.clamp(-1.0, 1.0).acos() / PI * rows as f64]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_are_inverse_and_fill_the_sphere() {
        let size = [12, 7];
        let mut whole = 0.0;
        for row in 0..size[1] {
            for column in 0..size[0] {
                let middle = [column as f64 + 0.5, row as f64 + 0.5];
                let back = place(direction(middle, size), size);
                assert!((back[0] - middle[0]).abs() < 1e-13 && (back[1] - middle[1]).abs() < 1e-13, "{back:?}");
                whole += solid_angle(row, size);
            }
        }
        assert!((whole / (2.0 * TAU) - 1.0).abs() < 1e-14);
        assert!(direction([6.0, 0.0], size)[1] == 1.0, "the first row is up");
        assert!(direction([9.0, 3.5], size)[0] > 0.99, "columns grow towards +x");
    }
}
