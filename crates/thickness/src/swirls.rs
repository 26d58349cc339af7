//! Swirls: a field that looks like a film stirred by chance. No physics is claimed; it is smooth noise whose places are
//! displaced by smooth noise, twice, and it fits to itself at its edges.

use std::sync::Arc;

use iridesce_numerics::noise::mix64;

use crate::error::{ThicknessError, check_nm};
use crate::map::ThicknessMap;

/// Cells each way: bilinear between them errs by less than a thousandth of the range.
const SIDE: usize = 512;
/// Waves of the coarsest noise over the map.
const WAVES: i64 = 2;
/// Octaves, each of twice the waves and half the height of the one before.
const OCTAVES: u32 = 4;
/// Furthest displacement, as a share of the map.
const REACH: f64 = 0.34;

/// Swirls between two thicknesses in nm, >= 0; another `seed`, other swirls.
///
/// ```
/// let map = iridesce_thickness::swirls(100.0, 700.0, 1)?;
/// let (least, most) = map.thickness_nm().iter().fold((f64::MAX, 0.0_f64), |(a, b), t| (a.min(*t), b.max(*t)));
/// assert_eq!((least, most), (100.0, 700.0));
/// # Ok::<(), iridesce_thickness::ThicknessError>(())
/// ```
pub fn swirls(min_nm: f64, max_nm: f64, seed: u64) -> Result<Arc<ThicknessMap>, ThicknessError> {
    check_nm("min_nm", min_nm)?;
    check_nm("max_nm", max_nm)?;
    let at = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let mut field: Vec<f64> =
        (0..SIDE * SIDE).map(|cell| stirred(at(cell % SIDE), 1.0 - at(cell / SIDE), seed)).collect();
    let least = field.iter().copied().fold(f64::INFINITY, f64::min);
    let most = field.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for value in &mut field {
        let share = (*value - least) / (most - least);
        *value = min_nm * (1.0 - share) + max_nm * share;
    }
    ThicknessMap::new(SIDE, SIDE, field).map(Arc::new)
}

fn stirred(u: f64, v: f64, seed: u64) -> f64 {
    let first = [octaves(u, v, mix64(seed ^ 1)), octaves(u, v, mix64(seed ^ 2))];
    let (a, b) = (u + REACH * first[0], v + REACH * first[1]);
    let second = [octaves(a, b, mix64(seed ^ 3)), octaves(a, b, mix64(seed ^ 4))];
    octaves(u + REACH * second[0], v + REACH * second[1], mix64(seed ^ 5))
}

fn octaves(u: f64, v: f64, seed: u64) -> f64 {
    (0..OCTAVES)
        .map(|octave| {
            let waves = WAVES << octave;
            gradient_noise(u * waves as f64, v * waves as f64, waves, mix64(seed ^ u64::from(octave)))
                / f64::from(1 << octave)
        })
        .sum()
}

/// Smooth noise of period `waves` with a random slope at every whole place, where it is zero (K. Perlin, "Improving
/// noise", SIGGRAPH 2002: the fade of fifth order).
fn gradient_noise(x: f64, y: f64, waves: i64, seed: u64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let (dx, dy) = (x - column, y - row);
    let corner = |i: i64, j: i64| {
        let (i_wrapped, j_wrapped) = ((column as i64 + i).rem_euclid(waves), (row as i64 + j).rem_euclid(waves));
        let hash = mix64(seed ^ (i_wrapped as u64) << 32 ^ j_wrapped as u64);
        let (sin, cos) = (hash as f64 / u64::MAX as f64 * std::f64::consts::TAU).sin_cos();
        cos * (dx - i as f64) + sin * (dy - j as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let between = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let (across, up) = (fade(dx), fade(dy));
    between(between(corner(0, 0), corner(1, 0), across), between(corner(0, 1), corner(1, 1), across), up)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swirls_fit_to_themselves_and_differ_by_seed() {
        for (u, v) in [(0.0, 0.3), (0.7, 0.0), (0.21, 0.9)] {
            assert!((stirred(u, v, 7) - stirred(u + 1.0, v, 7)).abs() < 1e-9);
            assert!((stirred(u, v, 7) - stirred(u, v - 1.0, 7)).abs() < 1e-9);
            assert!((stirred(u, v, 7) - stirred(u, v, 8)).abs() > 1e-6);
        }
        // No jump anywhere: a step of 1e-6 of the map moves it by no more than its steepest slope allows.
        for i in 0..1000 {
            let u = f64::from(i) / 1000.0;
            assert!((stirred(u, 0.37, 7) - stirred(u + 1e-6, 0.37, 7)).abs() < 1e-3);
        }
    }

    #[test]
    fn impossible_ranges_are_refused() {
        assert_eq!(swirls(-1.0, 2.0, 0).unwrap_err().argument, "min_nm");
        assert_eq!(swirls(1.0, f64::NAN, 0).unwrap_err().argument, "max_nm");
    }
}
