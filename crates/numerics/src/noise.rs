//! Random numbers that hang on a counter alone, never on the order of the work: SplitMix64 (G. Steele, D. Lea, C. Flood,
//! "Fast splittable pseudorandom number generators", OOPSLA 2014; the constants of S. Vigna's version, public domain).

/// The step of the counter: 2^64 over the golden ratio, odd.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// A well-mixed hash of 64 bits: SplitMix64's output for the state `x`.
///
/// ```
/// // The first number of the published generator seeded with 0.
/// assert_eq!(iridesce_numerics::noise::mix64(0), 0xE220_A839_7B1D_CDAF);
/// ```
#[inline(always)]
pub fn mix64(x: u64) -> u64 {
    let x = x.wrapping_add(STEP);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// A sequence of random numbers.
#[derive(Debug, Clone)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// The sequence of a seed: the published generator.
    #[inline(always)]
    pub fn new(seed: u64) -> SplitMix64 {
        SplitMix64 { state: seed }
    }

    /// 64 random bits.
    #[inline(always)]
    pub fn bits(&mut self) -> u64 {
        let drawn = mix64(self.state);
        self.state = self.state.wrapping_add(STEP);
        drawn
    }

    /// Uniform in [0, 1), 53 bits.
    #[inline(always)]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in (0, 1], 53 bits.
    #[inline(always)]
    pub fn above_zero(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 1.0) / (1_u64 << 53) as f64
    }

    /// Uniform in [0, 1) in single precision, 24 bits.
    #[inline(always)]
    pub fn unit_single(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Goes past one number.
    #[inline(always)]
    pub fn skip(mut self) -> SplitMix64 {
        self.state = self.state.wrapping_add(STEP);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_sequence() {
        // The generator's own C code, seed 1234567.
        let wanted = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431];
        let mut random = SplitMix64::new(1_234_567);
        assert_eq!(wanted.map(|_| random.bits()), wanted);
    }

    #[test]
    fn units_stay_in_their_ranges() {
        let mut random = SplitMix64::new(7);
        let mut sum = 0.0;
        for _ in 0..10_000 {
            let (a, b, c) = (random.unit(), random.above_zero(), random.unit_single());
            assert!((0.0..1.0).contains(&a) && b > 0.0 && b <= 1.0 && (0.0..1.0).contains(&c));
            sum += a;
        }
        // The mean of 10^4 uniform numbers has a standard deviation of 0.0029.
        assert!((sum / 10_000.0 - 0.5).abs() < 0.012, "{sum}");
    }
}
