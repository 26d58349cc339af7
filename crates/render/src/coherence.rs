//! How long an optical path difference still shows fringes: the coherence of lamps as an eye sees it.
//!
//! Light of the spectrum S(lambda), seen by an observer, shows fringes of the contrast
//!
//! ```text
//! |sum S c exp(2 pi i P / lambda)| / sum S c,   c = x, y, z
//! ```
//!
//! over a path difference P (Born & Wolf, Principles of Optics, 7th ed., 10.4: the modulus of the complex degree of coherence). Smooth
//! spectra lose theirs within micrometres, the narrow bands of fluorescent lamps within a tenth of a millimetre. Beyond, a film shows the
//! mean over all phases, and no spectrum need be fine enough for its fringes.

use iridesce_optics::color::{Illuminant, Observer};

use crate::spectral::{FROM_NM, TO_NM};

/// Path differences below this are always resolved, nm: nodes for them cost little.
pub const LEAST_SEEN_NM: f64 = 20_000.0;

/// The longest path difference whose fringes are resolved under any lamp, nm: films of 0.15 mm of water. Those of the lamps with the
/// narrowest bands (FL11, HP1) move colours by CIEDE2000 0.1 there.
const MOST_SEEN_NM: f64 = 400_000.0;

/// Contrast of fringes that nobody sees: it moves colours by CIEDE2000 0.05.
const UNSEEN: f64 = 3e-4;

/// Ratio of one path difference that is looked at to the next.
const STEP: f64 = 0.985;

/// The path difference (nm) beyond which no light of these spectra shows fringes.
pub fn longest_seen_nm(illuminants: &[Illuminant]) -> f64 {
    illuminants.iter().map(longest_seen_of).fold(LEAST_SEEN_NM, f64::max)
}

fn longest_seen_of(illuminant: &Illuminant) -> f64 {
    let knots: Vec<(f64, [f64; 3])> = (FROM_NM as u32..=TO_NM as u32)
        .map(|nm| {
            let nm = f64::from(nm);
            (nm, Observer::Cie1931.at(nm).map(|c| c * illuminant.power(nm)))
        })
        .collect();
    let totals: [f64; 3] = std::array::from_fn(|c| knots.iter().map(|knot| knot.1[c]).sum());
    let mut path_nm = MOST_SEEN_NM;
    while path_nm > LEAST_SEEN_NM {
        let contrast = contrast(&knots, totals, path_nm);
        if contrast > UNSEEN {
            // Contrasts rise and fall: the next step up may just have been a place between two lobes.
            return (path_nm / (STEP * STEP)).min(MOST_SEEN_NM);
        }
        path_nm *= STEP;
    }
    LEAST_SEEN_NM
}

/// Largest contrast of X, Y and Z. Between the knots, 1 nm apart, both the light and the phase are taken for straight lines
/// (the phase is one to 0.01 turns): the integral over each is exact, however many turns it makes.
fn contrast(knots: &[(f64, [f64; 3])], totals: [f64; 3], path_nm: f64) -> f64 {
    let mut sums = [[0.0; 2]; 3];
    let phase = |nm: f64| std::f64::consts::TAU * path_nm / nm;
    for pair in knots.windows(2) {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        let (first, last) = (phase(from), phase(to));
        let turn = last - first;
        let ((s0, c0), (s1, c1)) = (first.sin_cos(), last.sin_cos());
        for c in 0..3 {
            // (f1 e1 - f0 e0) / (i turn) + (f1 - f0) (e1 - e0) / turn^2
            let slope = (high[c] - low[c]) / (turn * turn);
            sums[c][0] += (high[c] * s1 - low[c] * s0) / turn + slope * (c1 - c0);
            sums[c][1] += (low[c] * c0 - high[c] * c1) / turn + slope * (s1 - s0);
        }
    }
    (0..3).map(|c| sums[c][0].hypot(sums[c][1]) / totals[c].max(f64::MIN_POSITIVE)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a sum in steps of 0.01 nm.
    #[test]
    fn contrasts_are_those_of_fine_sums() {
        for name in ["D65", "FL2", "HP1"] {
            let illuminant = Illuminant::named(name).unwrap();
            let at = |nm: f64| Observer::Cie1931.at(nm).map(|c| c * illuminant.power(nm));
            let knots: Vec<(f64, [f64; 3])> = (360..=830).map(|nm| (f64::from(nm), at(f64::from(nm)))).collect();
            let totals: [f64; 3] = std::array::from_fn(|c| knots.iter().map(|knot| knot.1[c]).sum());
            for path_nm in [20_000.0, 61_000.0, 150_000.0, 390_000.0] {
                let mut sums = [[0.0; 2]; 3];
                for i in 0..=47_000 {
                    let nm = 360.0 + 0.01 * f64::from(i);
                    let (sin, cos) = (std::f64::consts::TAU * path_nm / nm).sin_cos();
                    for (sum, value) in sums.iter_mut().zip(at(nm)) {
                        sum[0] += 0.01 * value * cos;
                        sum[1] += 0.01 * value * sin;
                    }
                }
                let fine = (0..3).map(|c| sums[c][0].hypot(sums[c][1]) / totals[c]).fold(0.0, f64::max);
                let found = contrast(&knots, totals, path_nm);
                // A third of what is not seen.
                assert!((found - fine).abs() < 0.3 * UNSEEN + 0.05 * fine, "{name}, {path_nm}: {found} {fine}");
            }
        }
    }

    #[test]
    fn narrow_bands_show_fringes_for_longer() {
        let seen = |name: &str| longest_seen_nm(&[Illuminant::named(name).unwrap()]);
        let (smooth, white, tube) = (seen("A"), seen("D65"), seen("FL11"));
        assert!(smooth < white && white < 120_000.0, "{smooth} {white}");
        assert!(tube == MOST_SEEN_NM, "{tube}");
    }
}
