//! Weights of neighbours between which something is interpolated, over a [`Number`].

use crate::number::Number;

/// Weights of four places at -1, 0, 1 and 2 for the cubic through all four (Lagrange), at `f` from the second.
///
/// ```
/// use iridesce_numerics::interpolation::lagrange;
/// let cube = |x: f64| x.powi(3);
/// let weights = lagrange(0.25);
/// let sum: f64 = weights.iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(w, x)| w * cube(x)).sum();
/// assert!((sum - cube(0.25)).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn lagrange<V: Number>(f: V) -> [V; 4] {
    let (a, b, c) = (f.plus(1.0), f.plus(-1.0), f.plus(-2.0));
    [(f * b * c).times(-1.0 / 6.0), (a * b * c).times(0.5), (a * f * c).times(-0.5), (a * f * b).times(1.0 / 6.0)]
}

/// Weights of the four neighbours of a place a share `f` behind the second of them, for a cubic with continuous slopes
/// (E. Catmull, R. Rom, 1974).
#[inline(always)]
pub fn catmull_rom<V: Number>(f: V) -> [V; 4] {
    let (g, h) = (f * f, f * f * f);
    [
        (-h + g.times(2.0) - f).times(0.5),
        (h.times(3.0) - g.times(5.0)).plus(2.0).times(0.5),
        (h.times(-3.0) + g.times(4.0) + f).times(0.5),
        (h - g).times(0.5),
    ]
}

/// Weights of the value and the slope at the near end of a cell of length 1 and of the same at its far end, for the cubic
/// through them (Hermite), at `f` from the near end.
#[inline(always)]
pub fn hermite<V: Number>(f: V) -> [V; 4] {
    let rest = f.like(1.0) - f;
    [f.times(2.0).plus(1.0) * rest * rest, f * rest * rest, f * f * f.times(-2.0).plus(3.0), -(f * f * rest)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each kind is exact for the cubics (Catmull and Rom: parabolas) that it promises.
    #[test]
    fn weights_meet_polynomials() {
        for step in 0..=16 {
            let f = f64::from(step) / 16.0;
            let square = |x: f64| 1.0 - 3.0 * x + 0.5 * x * x;
            let cube = |x: f64| square(x) + 2.0 * x * x * x;
            let four =
                |weights: [f64; 4], values: [f64; 4]| -> f64 { weights.iter().zip(values).map(|(w, v)| w * v).sum() };
            let at = [-1.0, 0.0, 1.0, 2.0];
            assert!((four(lagrange(f), at.map(cube)) - cube(f)).abs() < 2e-14);
            assert!((four(catmull_rom(f), at.map(square)) - square(f)).abs() < 2e-14);
            let slope = |x: f64| -3.0 + x + 6.0 * x * x;
            let ends = [cube(0.0), slope(0.0), cube(1.0), slope(1.0)];
            assert!((four(hermite(f), ends) - cube(f)).abs() < 2e-14);
        }
    }
}
