//! How faint a branch of a path is before it goes on only by chance.

/// Luminance (of 1 at the camera) below which a branch survives only by chance in a picture of [`FEW`] samples a pixel. One such choice
/// makes noise of at most half of this times the deviation of the light from its least; docs/evidence/performance.md has the trade
/// against time.
const FAINT: f32 = 2e-4;

/// Samples a pixel up to which the noise of its edges hides that of these choices. It falls as one over the samples, where that of
/// chance falls as one over their root alone, and in proportion to the luminance: that falls as one over the samples, so that chance
/// is the smaller share of a picture's noise the more closely one looks.
const FEW: u32 = 16;

/// No picture is looked at more closely: sums in single precision do not tell more.
const LEAST_FAINT: f32 = 1e-7;

/// So many hits all branches of a sample have together before that luminance doubles with each further one, up to the next, in a scene
/// with bodies: glass, metals and what is coated, everything but free films and matt surfaces. What many surfaces part into many
/// branches is looked at less and less closely, and one ball of glass, whose branches have five, nearly as closely as ever.
const FREE_HITS: u32 = 4;

/// It rises no further (at up to [`FEW`] samples). A camera ray has 24 hits with it that meets three balls of glass within one another, 71
/// if it never rose (docs/evidence/performance.md).
const MOST_FAINT: f32 = 4.8e-3;

/// [`MOST_FAINT`] is reached by then.
const MOST_DOUBLINGS: u32 = 5;

/// After a surface that scatters a branch survives for certain down to this share of its luminance: its direction was a matter of
/// chance, so that what follows need not be followed to the last detail.
const SHARE: f32 = 0.25;

/// The same in a scene with smooth glass, each face of which mirrors a hundredth to a twentieth: what finds a lamp over one of them by chance
/// is a pixel that stands out (of `coated-lens` at 8 samples by five times the mean of the picture at [`SHARE`], by two at this).
const SHARE_OF_GLASS: f32 = 0.1;

/// What bodies a scene has: glass, metals and what is coated, everything but free films and matt surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bodies {
    None,
    /// Opaque or rough ones alone.
    Other,
    /// Some that light passes smoothly.
    Glass,
}

/// The luminances below which branches of a picture survive only by chance.
#[derive(Debug, Clone, Copy)]
pub struct Floors {
    /// Of every branch.
    pub faint: f32,
    /// Of those of samples with many hits.
    most: f32,
    /// Whether branches survive evenly over the samples of a pixel, and not each by a number of its own.
    pub are_even: bool,
    /// Of those after a surface that scatters, over the luminance that it sends on.
    pub share: f32,
}

impl Floors {
    /// Of a picture of so many samples a pixel.
    pub fn new(samples: u32, bodies: Bodies) -> Floors {
        let few = (f64::from(FEW) / f64::from(samples.max(1))).min(1.0) as f32;
        let faint = (FAINT * few).max(LEAST_FAINT);
        let most = match bodies {
            Bodies::None => faint,
            Bodies::Other | Bodies::Glass => (MOST_FAINT * few).max(faint),
        };
        let share = if bodies == Bodies::Glass { SHARE_OF_GLASS } else { SHARE };
        Floors { faint, most, are_even: bodies != Bodies::None, share }
    }

    /// Where all branches of a sample have had so many hits.
    #[inline(always)]
    pub fn after(&self, hits: u32) -> f32 {
        (self.faint * (1 << hits.saturating_sub(FREE_HITS).min(MOST_DOUBLINGS)) as f32).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_samples_look_more_closely() {
        for bodies in [Bodies::None, Bodies::Other, Bodies::Glass] {
            let few = Floors::new(1, bodies);
            assert_eq!(few.faint, Floors::new(FEW, bodies).faint);
            let mut before = few;
            for samples in [64, 256, 4096, 1 << 14] {
                let floors = Floors::new(samples, bodies);
                for hits in [0, 4, 5, 8, 100] {
                    assert!(floors.after(hits) < before.after(hits), "{samples} samples, {hits} hits");
                    assert!(floors.after(hits) >= floors.faint);
                }
                before = floors;
            }
        }
        assert_eq!(Floors::new(u32::MAX, Bodies::Glass).after(100), LEAST_FAINT);
        assert_eq!(Floors::new(4 * FEW, Bodies::None).faint, FAINT / 4.0);
        assert_eq!(Floors::new(FEW, Bodies::Other).after(6), 4.0 * FAINT);
        assert_eq!(Floors::new(FEW, Bodies::None).after(6), FAINT);
    }
}
