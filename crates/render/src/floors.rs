//! How faint a branch of a path is before it goes on only by chance.

/// Luminance (of 1 at the camera) below which a branch survives only by chance in a picture of [`FEW`] samples a pixel. One such choice
/// makes noise of at most half of this times the deviation of the light from its least; docs/evidence/performance.md has the trade
/// against time.
const FAINT: f32 = 2e-4;

/// Samples a pixel up to which the noise of its edges hides that of these choices. It falls as one over the samples, where that of
/// chance falls as one over their root alone: so the luminance falls as the root, too.
const FEW: u32 = 16;

/// No picture is looked at more closely: sums in single precision do not tell more.
const LEAST_FAINT: f32 = 1e-7;

/// So many hits a path has before that luminance rises, and how often it doubles, in a scene with bodies: glass, metals and what is
/// coated, everything but free films and matt surfaces. What many surfaces part into many branches is looked at less and less closely.
/// (Three balls of glass within one another: 54 hits a camera ray without it.)
const FREE_HITS: u32 = 4;
const DOUBLINGS: u32 = 4;

/// The luminances below which branches of a picture survive only by chance.
#[derive(Debug, Clone, Copy)]
pub struct Floors {
    /// Of every branch.
    pub faint: f32,
    /// Of those after many hits.
    most: f32,
}

impl Floors {
    /// Of a picture of so many samples a pixel; `has_bodies`: some of its surfaces are those of glass, of metals, or coated.
    pub fn new(samples: u32, has_bodies: bool) -> Floors {
        let few = (f64::from(FEW) / f64::from(samples.max(1))).min(1.0) as f32;
        let faint = (FAINT * few.sqrt()).max(LEAST_FAINT);
        let most = if has_bodies { (FAINT * (1 << DOUBLINGS) as f32 * few).max(faint) } else { faint };
        Floors { faint, most }
    }

    /// After so many hits.
    #[inline(always)]
    pub fn after(&self, hits: u32) -> f32 {
        (self.faint * (1 << hits.saturating_sub(FREE_HITS).min(DOUBLINGS)) as f32).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_samples_look_more_closely() {
        for has_bodies in [false, true] {
            let few = Floors::new(1, has_bodies);
            assert_eq!(few.faint, Floors::new(FEW, has_bodies).faint);
            let mut before = few;
            for samples in [64, 256, 4096, 1 << 20, u32::MAX] {
                let floors = Floors::new(samples, has_bodies);
                for hits in [0, 4, 5, 8, 100] {
                    assert!(floors.after(hits) < before.after(hits), "{samples} samples, {hits} hits");
                    assert!(floors.after(hits) >= floors.faint);
                }
                before = floors;
            }
        }
        assert_eq!(Floors::new(4 * FEW, false).faint, FAINT / 2.0);
        assert_eq!(Floors::new(FEW, true).after(6), 4.0 * FAINT);
        assert_eq!(Floors::new(FEW, false).after(6), FAINT);
    }
}
