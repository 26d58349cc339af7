//! Gauss-Legendre rules, and averages over spectral lines by them.

use std::f64::consts::{LN_2, PI};

use crate::OpticsError;

/// Standard deviations of a Gaussian on either side: 2.6e-12 of it lies beyond, and the weights are normalised.
pub(super) const TAIL: f64 = 7.0;

/// How an instrument's line, or a source's, is shaped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineShape {
    /// A Gaussian.
    Gaussian,
    /// All wavelengths of the width alike.
    Rectangle,
    /// A monochromator with equal slits.
    Triangle,
}

impl LineShape {
    /// `"gaussian"`, `"rectangle"` or `"triangle"`.
    pub fn named(name: &str) -> Result<LineShape, OpticsError> {
        match name {
            "gaussian" => Ok(LineShape::Gaussian),
            "rectangle" => Ok(LineShape::Rectangle),
            "triangle" => Ok(LineShape::Triangle),
            _ => Err(OpticsError::Argument(format!(
                "a line must be \"gaussian\", \"rectangle\" or \"triangle\", got {name:?}"
            ))),
        }
    }

    /// Offsets from the middle of a line of this full width at half maximum, and weights that add up to 1; `count` nodes,
    /// of a triangle on either side.
    pub(super) fn rule(self, fwhm: f64, count: usize) -> Rule {
        match self {
            LineShape::Gaussian => {
                let sd = fwhm / (8.0 * LN_2).sqrt();
                scaled(count, [-TAIL * sd, TAIL * sd], |x| (-0.5 * (x / sd).powi(2)).exp())
            }
            LineShape::Rectangle => scaled(count, [-0.5 * fwhm, 0.5 * fwhm], |_| 1.0),
            LineShape::Triangle => {
                let halves =
                    [scaled(count, [-fwhm, 0.0], |x| 1.0 + x / fwhm), scaled(count, [0.0, fwhm], |x| 1.0 - x / fwhm)];
                halves.into_iter().flatten().map(|(x, weight)| (x, 0.5 * weight)).collect()
            }
        }
    }
}

/// Nodes and weights.
pub(super) type Rule = Vec<(f64, f64)>;

/// Nodes on (0, 1).
pub(super) fn plain(count: usize) -> Rule {
    scaled(count, [0.0, 1.0], |_| 1.0)
}

fn scaled(count: usize, [low, high]: [f64; 2], density: impl Fn(f64) -> f64) -> Rule {
    let (nodes, weights) = legendre(count);
    let mut rule: Rule = nodes
        .into_iter()
        .zip(weights)
        .map(|(node, weight)| {
            let x = low + 0.5 * (high - low) * (node + 1.0);
            (x, weight * density(x))
        })
        .collect();
    let whole: f64 = rule.iter().map(|(_, weight)| weight).sum();
    rule.iter_mut().for_each(|(_, weight)| *weight /= whole);
    rule
}

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1], in rising order: exact for polynomials of degree `2 count - 1`.
///
/// Newton's method on the three-term recurrence (Press et al., Numerical Recipes, sec. 4.6).
///
/// ```
/// let (nodes, weights) = iridesce_optics::coherence::legendre(3);
/// assert!((nodes[2] - 0.6_f64.sqrt()).abs() < 1e-15 && (weights[1] - 8.0 / 9.0).abs() < 1e-15);
/// ```
pub fn legendre(count: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut nodes, mut weights) = (vec![0.0; count], vec![0.0; count]);
    let n = count as f64;
    for i in 0..count.div_ceil(2) {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..16 {
            let (mut p, mut before) = (1.0, 0.0);
            for j in 0..count {
                let j = j as f64;
                (p, before) = (((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0), p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            let step = p / slope;
            x -= step;
            if step.abs() <= 1e-16 {
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (nodes[i], nodes[count - 1 - i]) = (-x, x);
        (weights[i], weights[count - 1 - i]) = (weight, weight);
    }
    (nodes, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_exactly() {
        for count in [1, 2, 5, 16, 64, 257] {
            let (nodes, weights) = legendre(count);
            assert!(nodes.windows(2).all(|pair| pair[0] < pair[1]));
            for power in [0, 1, 2, 13, 14, 15].into_iter().filter(|power| *power < 2 * count) {
                let sum: f64 = nodes.iter().zip(&weights).map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 0 { 2.0 / (power as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "{count} {power}: {sum} {exact}");
            }
        }
    }

    /// Mean and variance of each shape: FWHM^2 / (8 ln 2), / 12, / 6.
    #[test]
    fn lines_have_their_widths() {
        for (shape, share) in [
            (LineShape::Gaussian, 1.0 / (8.0 * LN_2)),
            (LineShape::Rectangle, 1.0 / 12.0),
            (LineShape::Triangle, 1.0 / 6.0),
        ] {
            let rule = shape.rule(3.0, 64);
            let moment = |power: i32| rule.iter().map(|(x, w)| w * x.powi(power)).sum::<f64>();
            assert!((moment(0) - 1.0).abs() < 1e-14 && moment(1).abs() < 1e-14);
            // A Gaussian's tails beyond 7 sd hold 1e-10 of its variance.
            assert!((moment(2) / (9.0 * share) - 1.0).abs() < 2e-10, "{shape:?} {}", moment(2));
        }
    }
}
