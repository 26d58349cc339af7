//! Regions that hang together, and what fixes their order: a tie point, no film at all, or colours of low orders.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use iridesce_numerics::Watch;

use crate::InverseError;
use crate::pixels::{Candidate, MOST, filled};

/// Nothing fixes the order.
pub const NO_ANCHOR: u8 = 0;
/// Colours of low orders do, which differ.
pub const COLOR: u8 = 1;
/// The film goes down to nothing: black film, contact, bare base.
pub const ZERO: u8 = 2;
/// The user does.
pub const TIE_POINT: u8 = 3;
/// Beyond so many orders colours repeat (inverse: 1-sigma against the nearest colour of another order).
const COLORFUL: f32 = 5.5;
/// Pixels with errors of their own, and share of a region, that must know their order by themselves.
const ENOUGH: f32 = 12.0;
const SHARE: f32 = 2e-3;
/// A region without an anchor is no surer than this.
const UNANCHORED: f32 = 0.9;
/// What hangs together with a tie point is at least as sure of its order.
const TIED: f32 = 0.98;
/// A pixel that is surer than this by itself of another order ends what hangs together with a tie point.
const CONTRARY: f32 = 0.999;
/// Looked at between two questions to the watch.
const PIECE: usize = 1 << 16;

/// A pixel whose thickness is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// Its place.
    pub pixel: usize,
    /// Its thickness.
    pub thickness_nm: f32,
}

/// Answers of all pixels that regions may change.
pub(crate) struct Answers<'a> {
    pub best_nm: &'a mut [f32],
    pub confidence: &'a mut [f32],
    pub anchor: &'a mut [u8],
    /// Probability of the order by the pixel alone.
    pub own: &'a [f32],
}

fn around(i: usize, width: usize, count: usize) -> impl Iterator<Item = usize> {
    let x = i % width;
    let next = [
        (x > 0).then(|| i - 1),
        (x + 1 < width).then(|| i + 1),
        i.checked_sub(width),
        (i + width < count).then(|| i + width),
    ];
    next.into_iter().flatten()
}

/// Candidates that continue from the tie points, smallest step first, become the answers. Which ties found no candidate near
/// their thickness.
pub(crate) fn tie(
    ties: &[Tie],
    candidates: &[Candidate],
    width: usize,
    quarter_nm: f32,
    answers: &mut Answers<'_>,
    watch: &Watch,
) -> Result<Vec<bool>, InverseError> {
    let count = answers.best_nm.len();
    let nearest = |i: usize, nm: f32| {
        candidates[i * MOST..(i + 1) * MOST]
            .iter()
            .filter(|one| one.likelihood > 0.0)
            .map(|one| ((one.thickness_nm - nm).abs(), one.thickness_nm))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    // Steps are not negative: their bits are in their order.
    let mut heap = BinaryHeap::new();
    let mut taken = Vec::new();
    for tie in ties {
        let found = nearest(tie.pixel, tie.thickness_nm).filter(|(far, _)| *far <= quarter_nm);
        taken.push(found.is_some());
        if let Some((_, nm)) = found {
            heap.push(Reverse((0_u32, tie.pixel, nm.to_bits())));
        }
    }
    let mut looked = 0;
    while let Some(Reverse((_, i, bits))) = heap.pop() {
        looked += 1;
        if looked % PIECE == 0 {
            watch.check()?;
        }
        if answers.anchor[i] == TIE_POINT {
            continue;
        }
        let nm = f32::from_bits(bits);
        let is_same = (answers.best_nm[i] - nm).abs() <= quarter_nm;
        let is_given = ties.iter().any(|tie| tie.pixel == i);
        if !is_same && !is_given && answers.own[i] > CONTRARY {
            continue;
        }
        answers.confidence[i] = if is_same { answers.confidence[i].max(TIED) } else { TIED };
        answers.best_nm[i] = nm;
        answers.anchor[i] = TIE_POINT;
        for next in around(i, width, count) {
            if answers.anchor[next] == TIE_POINT {
                continue;
            }
            if let Some((step, there)) = nearest(next, nm).filter(|(step, _)| *step <= 0.5 * quarter_nm) {
                heap.push(Reverse((step.to_bits(), next, there.to_bits())));
            }
        }
    }
    Ok(taken)
}

/// Names what fixes the order of each region of pixels that hang together, and takes confidence from those that nothing does.
///
/// So many pixels (`temper`) share their errors and are one witness: a step of 200 nm of oxide whose colour a JPEG had moved to that
/// of 24 nm was otherwise held to be the place where the film goes down to nothing, by each of its 1500 pixels.
pub(crate) fn anchor(
    width: usize,
    (quarter_nm, first_nm): (f32, f32),
    temper: f32,
    answers: &mut Answers<'_>,
    watch: &Watch,
) -> Result<(), InverseError> {
    let count = answers.best_nm.len();
    let mut seen = filled(count, false)?;
    let mut region: Vec<usize> = Vec::new();
    let mut looked = 0;
    for start in 0..count {
        if seen[start] || !answers.best_nm[start].is_finite() {
            continue;
        }
        region.clear();
        region.push(start);
        seen[start] = true;
        let (mut colorful, mut zero, mut tied) = (0, 0, false);
        let mut at = 0;
        while at < region.len() {
            let i = region[at];
            at += 1;
            looked += 1;
            if looked % PIECE == 0 {
                watch.check()?;
            }
            let nm = answers.best_nm[i];
            // Half a wave a step is an order; a quarter is `quarter_nm`.
            colorful += usize::from(answers.own[i] > 0.95 && nm < 2.0 * COLORFUL * quarter_nm);
            zero += usize::from(answers.confidence[i] > 0.9 && nm < 0.3 * quarter_nm);
            tied |= answers.anchor[i] == TIE_POINT;
            for next in around(i, width, count) {
                if !seen[next] && (answers.best_nm[next] - nm).abs() <= 0.5 * quarter_nm {
                    seen[next] = true;
                    region.push(next);
                }
            }
        }
        let enough = (ENOUGH * temper).max(SHARE * region.len() as f32) as usize;
        let found = if tied {
            TIE_POINT
        } else if zero >= enough && first_nm < 0.3 * quarter_nm {
            ZERO
        } else if colorful >= enough {
            COLOR
        } else {
            NO_ANCHOR
        };
        for &i in &region {
            if answers.anchor[i] != TIE_POINT {
                answers.anchor[i] = found;
            }
            if found == NO_ANCHOR {
                answers.confidence[i] = answers.confidence[i].min(UNANCHORED);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pixels::NONE;

    const QUARTER_NM: f32 = 103.0;

    struct Own {
        best: Vec<f32>,
        confidence: Vec<f32>,
        anchor: Vec<u8>,
        own: Vec<f32>,
    }

    impl Own {
        fn new(best: Vec<f32>, own: f32) -> Own {
            let count = best.len();
            Own { best, confidence: vec![0.99; count], anchor: vec![NO_ANCHOR; count], own: vec![own; count] }
        }

        fn answers(&mut self) -> Answers<'_> {
            let Own { best, confidence, anchor, own } = self;
            Answers { best_nm: best, confidence, anchor, own }
        }
    }

    #[test]
    fn regions_are_named_by_what_fixes_their_order() {
        // Three strips of 8 x 24: from black film, thick without anything, thick with colours of its own.
        let strip = |x: usize, i: usize| [5.0 + 2.0 * i as f32, 1800.0, 600.0][x];
        let best: Vec<f32> = (0..24 * 24).map(|i| strip(i % 24 / 8, i / 24)).collect();
        let mut picture = Own::new(best, 0.5);
        for (i, own) in picture.own.iter_mut().enumerate() {
            *own = if i % 24 >= 16 { 0.99 } else { 0.5 };
        }
        anchor(24, (QUARTER_NM, 0.0), 1.0, &mut picture.answers(), &Watch::new()).unwrap();
        assert_eq!([0, 12, 20].map(|x| picture.anchor[10 * 24 + x]), [ZERO, NO_ANCHOR, COLOR]);
        assert_eq!([0, 12, 20].map(|x| picture.confidence[10 * 24 + x]), [0.99, UNANCHORED, 0.99]);
    }

    #[test]
    fn pixels_that_share_their_errors_are_one_witness() {
        // 8 x 24 pixels of black film, and as many with colours of their own: 192 each, seven of them apart where errors are shared by 30.
        let best: Vec<f32> = (0..16 * 24).map(|i| if i % 16 < 8 { 10.0 } else { 600.0 }).collect();
        let anchors = |temper: f32| {
            let mut picture = Own::new(best.clone(), 0.99);
            anchor(16, (QUARTER_NM, 0.0), temper, &mut picture.answers(), &Watch::new()).unwrap();
            ([0, 12].map(|x| picture.anchor[x]), [0, 12].map(|x| picture.confidence[x]))
        };
        assert_eq!(anchors(1.0), ([ZERO, COLOR], [0.99; 2]));
        assert_eq!(anchors(15.0), ([ZERO, COLOR], [0.99; 2]));
        assert_eq!(anchors(30.0), ([NO_ANCHOR; 2], [UNANCHORED; 2]));
    }

    #[test]
    fn what_hangs_together_with_a_tie_point_takes_its_order() {
        let width = 12;
        let ramp = |i: usize| 700.0 + 4.0 * (i % width) as f32;
        let mut candidates = vec![NONE; MOST * width * 2];
        for i in 0..2 * width {
            for (k, shift) in [0.0, 210.0].into_iter().enumerate() {
                candidates[i * MOST + k] = Candidate { thickness_nm: ramp(i) + shift, likelihood: 1.0, sd_nm: 2.0 };
            }
        }
        let mut picture = Own::new((0..2 * width).map(ramp).collect(), 0.5);
        picture.own[width - 1] = 0.9999; // knows better
        let ties = [Tie { pixel: 3, thickness_nm: 925.0 }, Tie { pixel: 5, thickness_nm: 1500.0 }];
        let taken = tie(&ties, &candidates, width, QUARTER_NM, &mut picture.answers(), &Watch::new()).unwrap();
        assert_eq!(taken, [true, false]);
        for i in (0..2 * width).filter(|i| *i != width - 1) {
            assert_eq!((picture.best[i], picture.anchor[i]), (ramp(i) + 210.0, TIE_POINT), "{i}");
            assert!((picture.confidence[i] - TIED).abs() < 1e-6);
        }
        assert_eq!(picture.best[width - 1], ramp(width - 1));
    }
}
