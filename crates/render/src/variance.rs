//! How far a pixel's mean may be off, from the means of batches of its samples.
//!
//! The samples of a pixel are one scrambled net: a batch of them is stratified in itself and against the others, so that
//! the spread of the batches' means over their number, the textbook's estimate, is too large, by the square of the number of
//! batches where the picture is smooth. What consecutive batches do tell without bias is how much the variance falls when
//! two of them are joined: for means a, b of neighbouring blocks E (a - b)^2 / 4 = v(block) - v(two blocks). From these
//! differences at all sizes of blocks the law v(m) = C m^-p is fitted by likelihood and carried on to all samples; p is
//! weighed over 1 (samples independent of one another) to 3 (a scrambled net on a smooth function: Owen, Annals of Statistics
//! 25, 1541, 1997), and as far beyond on the other side as its uncertainty: a scale that ended at 3 would pull all means down.

/// Most batches of a pixel. Fewer leave p too uncertain: of 16 the estimate is off by a factor of three now and then.
pub const MOST_BATCHES: usize = 64;

/// What pairs of the smallest blocks say counts as if there were no more of them: the law there need not be that of large
/// blocks, to which the answer is nearer.
const MOST_PAIRS: f64 = 8.0;

/// Fall of the variance with the number of samples, and how probable each is beforehand: most pixels are smooth (a net's 3
/// and beyond, where neighbouring blocks mend each other's errors), few are mere noise.
const POWERS: [(f64, f64); 6] = [(1.0, 1.0), (1.5, 1.0), (2.0, 1.0), (2.5, 2.0), (3.0, 4.0), (3.5, 8.0)];

/// What few batches do not tell is taken for noise: this over their number is added to how probable that is.
const CAUTION: f64 = 64.0;

/// Samples of a batch where a pixel has so many in all: a power of two, so that batches are nets themselves.
pub fn batch_size(samples: u32) -> u32 {
    samples.div_ceil(MOST_BATCHES as u32).next_power_of_two()
}

/// Sizes of blocks: [`MOST_BATCHES`] are halved so often until one pair is left.
const MOST_LEVELS: usize = MOST_BATCHES.ilog2() as usize;

/// What the estimate needs of a number of batches: the same for every pixel of a picture.
pub struct Estimator {
    count: usize,
    /// Of each size of blocks, the smallest first: how much its pairs count.
    pairs: Vec<f64>,
    /// The sum of these.
    total: f64,
    laws: [Law; POWERS.len()],
}

/// A fall of the variance with the number of samples.
#[derive(Clone, Copy)]
struct Law {
    /// By which each size of blocks is brought to that of the batches.
    scales: [f64; MOST_LEVELS],
    /// Part of minus twice the logarithm of the likelihood that does not hang on the batches, and that of the prior.
    misfit: [f64; 2],
    /// Share by which one doubling lets the variance fall.
    fall: f64,
    /// The logarithm by which it falls over all batches.
    all: f64,
}

impl Estimator {
    /// For so many batches of a pixel, at most [`MOST_BATCHES`].
    pub fn new(count: usize) -> Estimator {
        let mut pairs = Vec::new();
        let mut blocks = count;
        while blocks >= 2 {
            blocks /= 2;
            pairs.push(MOST_PAIRS.min(blocks as f64));
        }
        let depth: f64 = pairs.iter().enumerate().map(|(j, pairs)| j as f64 * pairs).sum();
        let laws = POWERS.map(|(power, prior)| {
            let prior = if power == 1.0 { prior + CAUTION / count as f64 } else { prior };
            Law {
                scales: std::array::from_fn(|j| (power * j as f64).exp2()),
                misfit: [power * std::f64::consts::LN_2 * depth, 2.0 * f64::ln(prior)],
                fall: 1.0 - (-power).exp2(),
                all: power * (count as f64).ln(),
            }
        });
        Estimator { count, total: pairs.iter().sum(), pairs, laws }
    }

    /// Variance of the mean over batches of equal size, as many as there are for each pixel; NaN for fewer than two. Of the
    /// means nothing is left.
    pub fn variance_of_mean(&self, batches: &mut [f64]) -> f32 {
        if self.count < 2 {
            return f32::NAN;
        }
        // Level j: blocks of 2^j batches; mean of (a - b)^2 / 4 over pairs of them. Blocks take the place of their parts.
        let mut falls = [0.0; MOST_LEVELS];
        let mut blocks = self.count;
        for (fall, _) in falls.iter_mut().zip(&self.pairs) {
            let mut sum = 0.0;
            for k in 0..blocks / 2 {
                let (a, b) = (batches[2 * k], batches[2 * k + 1]);
                sum += 0.25 * (a - b).powi(2);
                batches[k] = 0.5 * (a + b);
            }
            blocks /= 2;
            *fall = sum / blocks as f64;
        }
        let (mut weights, mut sum) = (0.0, 0.0);
        let mut best = f64::INFINITY;
        let mut fits = [(0.0, 0.0); POWERS.len()];
        for (law, fit) in self.laws.iter().zip(&mut fits) {
            // The variance scale that fits best with this power, and minus twice the logarithm of its likelihood.
            let levels = self.pairs.iter().zip(&falls).zip(&law.scales);
            let scale = levels.map(|((pairs, fall), scale)| pairs * fall * scale).sum::<f64>() / self.total;
            if scale <= 0.0 {
                return 0.0;
            }
            let misfit = self.total * scale.ln() - law.misfit[0] - law.misfit[1];
            best = best.min(misfit);
            *fit = (misfit, (scale / law.fall).ln() - law.all);
        }
        for (misfit, logarithm) in fits {
            let weight = (0.5 * (best - misfit)).exp();
            weights += weight;
            sum += weight * logarithm;
        }
        (sum / weights).exp() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::PixelSampler;

    fn variance_of_mean(batches: &[f32]) -> f32 {
        let mut means: Vec<f64> = batches.iter().map(|&mean| f64::from(mean)).collect();
        Estimator::new(batches.len()).variance_of_mean(&mut means)
    }

    /// Median over pixels of estimate over truth, the truth from the means of all pixels.
    fn ratio(samples: u32, of: impl Fn(PixelSampler, u32) -> f64) -> f64 {
        let size = batch_size(samples);
        let (mut estimates, mut means) = (Vec::new(), Vec::new());
        for pixel in 0..800 {
            let sampler = PixelSampler::new(5, pixel);
            let batches: Vec<f32> = (0..samples / size)
                .map(|batch| {
                    let values = (batch * size..(batch + 1) * size).map(|sample| of(sampler, sample));
                    (values.sum::<f64>() / f64::from(size)) as f32
                })
                .collect();
            estimates.push(f64::from(variance_of_mean(&batches)));
            means.push(batches.iter().map(|&mean| f64::from(mean)).sum::<f64>() / batches.len() as f64);
        }
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let truth = means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (means.len() - 1) as f64;
        estimates.sort_by(f64::total_cmp);
        estimates[estimates.len() / 2] / truth
    }

    /// In sigma that is a factor of 2.2 either way at most: the law of a pixel need not be one power.
    #[test]
    fn noise_edges_and_smooth_pixels_are_told_within_a_factor_of_five() {
        for samples in [64, 256] {
            let noise = ratio(samples, |sampler, sample| f64::from(sampler.choices(sample).next()));
            // An edge across the pixel, and smooth pixels: there the textbook's estimate is 10 to 4000 times too large.
            let edge = ratio(samples, |sampler, sample| {
                let (x, y) = sampler.point(sample);
                f64::from(x + 0.37 * y < 0.6)
            });
            let smooth = ratio(samples, |sampler, sample| {
                let (x, y) = sampler.point(sample);
                (1.3 * x).sin() + (x + 0.4 * y).exp()
            });
            let rings = ratio(samples, |sampler, sample| {
                let (x, y) = sampler.point(sample);
                (9.0 * (x * x + y * y)).cos()
            });
            assert!((0.6..1.6).contains(&noise), "noise, {samples} samples: {noise}");
            for (what, ratio) in [("edge", edge), ("smooth", smooth), ("rings", rings)] {
                assert!((0.2..5.0).contains(&ratio), "{what}, {samples} samples: {ratio}");
            }
        }
    }

    #[test]
    fn ends() {
        assert!(variance_of_mean(&[1.0]).is_nan());
        assert_eq!(variance_of_mean(&[1.0; 7]), 0.0);
        assert!(variance_of_mean(&[1.0, 2.0, 1.0]) > 0.0);
        assert_eq!([1, 16, 64, 65, 128, 1 << 20].map(batch_size), [1, 1, 1, 2, 2, 1 << 14]);
    }
}
