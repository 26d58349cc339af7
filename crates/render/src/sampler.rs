//! Where in a pixel its camera rays pass: an Owen-scrambled Sobol (0,2) sequence per pixel.
//!
//! Counter-based: the point is a pure function of (seed, pixel, sample), so any thread may compute any pixel.
//! Why not jittered strata: a lone film is smooth across most pixels, and there a scrambled (0,2)-net has
//! variance n^-3 where jitter has n^-2 (A. B. Owen, "Scrambled net variance for integrals of smooth functions",
//! Annals of Statistics 25, 1541, 1997). Scrambling by hash: S. Laine, T. Karras, "Stratified sampling for
//! stochastic transparency", Computer Graphics Forum 30, 1197 (2011).

use iridesce_numerics::noise::{SplitMix64, mix64};

const TO_UNIT: f64 = 1.0 / 4_294_967_296.0;

/// A permutation of the bit-reversed integers in which every bit depends on lower bits only:
/// between two bit reversals it is an Owen scramble.
#[inline(always)]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6C50_B47C);
    x ^= x.wrapping_mul(0xB82F_1E52);
    x ^= x.wrapping_mul(0xC7AF_E638);
    x ^= x.wrapping_mul(0x8D22_F6E6);
    x
}

/// Second dimension of the Sobol sequence, its bits in the other order (the first dimension is the index in that order).
///
/// The direction numbers are the rows of Pascal's triangle modulo 2, and C(k, j) is odd where the bits of j are among those of k: bit j
/// is the sum of all bits k of the index that hold j, which five steps add up, one for each bit of a bit's number.
#[inline(always)]
fn sobol_second_reversed(mut index: u32) -> u32 {
    index ^= (index & 0xAAAA_AAAA) >> 1;
    index ^= (index & 0xCCCC_CCCC) >> 2;
    index ^= (index & 0xF0F0_F0F0) >> 4;
    index ^= (index & 0xFF00_FF00) >> 8;
    index ^ index >> 16
}

/// Third dimension, its bits in the other order: that of the polynomial x^2 + x + 1.
#[inline(always)]
fn sobol_third_reversed(mut index: u32) -> u32 {
    const DIRECTIONS: [u32; 32] = third_directions();
    let mut reversed = 0;
    while index != 0 {
        reversed ^= DIRECTIONS[index.trailing_zeros() as usize];
        index &= index - 1;
    }
    reversed
}

/// Its direction numbers, m_k / 2^(k + 1), their bits in the other order: m_k = 2 m_(k-1) ^ 4 m_(k-2) ^ m_(k-2), beginning with 1 and 3.
const fn third_directions() -> [u32; 32] {
    let (mut all, mut m, mut next, mut k) = ([0; 32], 1_u64, 3_u64, 0);
    while k < 32 {
        all[k] = ((m << (31 - k)) as u32).reverse_bits();
        (m, next) = (next, (2 * next) ^ (4 * m) ^ m);
        k += 1;
    }
    all
}

/// The points of one pixel.
#[derive(Clone, Copy)]
pub struct PixelSampler {
    key: u64,
}

impl PixelSampler {
    #[inline(always)]
    pub fn new(seed: u64, pixel: u64) -> PixelSampler {
        PixelSampler { key: mix64(mix64(seed) ^ pixel) }
    }

    /// Point `sample` in the unit square; each coordinate in [0, 1).
    #[inline(always)]
    pub fn point(self, sample: u32) -> (f64, f64) {
        net_point(self.key, sample)
    }

    /// [`PixelSampler::point`] of neighbouring samples, side by side.
    #[inline(always)]
    pub fn points(self, first: u32, x: &mut [f64], y: &mut [f64]) {
        net_points(self.key, first, x, y);
    }

    /// The random numbers of one path: independent of its place in the pixel.
    #[inline(always)]
    pub fn choices(self, sample: u32) -> Choices {
        Choices {
            key: self.key,
            sample,
            third: 0,
            pairs: 0,
            random: SplitMix64::new(mix64(self.key ^ (u64::from(sample) << 32 | 0x5EED))).skip(),
        }
    }
}

/// The order of the points is scrambled by blocks, so that the first 2^k samples of any pixel are a whole net.
#[inline(always)]
fn shuffled(key: u64, sample: u32) -> u32 {
    laine_karras(sample.reverse_bits(), key as u32).reverse_bits()
}

/// Point `sample` of the scrambled net that belongs to a key.
#[inline(always)]
fn net_point(key: u64, sample: u32) -> (f64, f64) {
    let shuffled = shuffled(key, sample);
    let keys = mix64(key);
    let x = laine_karras(shuffled, keys as u32).reverse_bits();
    let y = laine_karras(sobol_second_reversed(shuffled), (keys >> 32) as u32).reverse_bits();
    (f64::from(x) * TO_UNIT, f64::from(y) * TO_UNIT)
}

/// [`net_point`] of neighbouring samples.
#[inline(always)]
fn net_points(key: u64, first: u32, x: &mut [f64], y: &mut [f64]) {
    for ((x, y), sample) in x.iter_mut().zip(y).zip(0..) {
        (*x, *y) = net_point(key, first.wrapping_add(sample));
    }
}

/// Random numbers for the choices along one path: a stream of single ones, and pairs and numbers by name that are stratified over
/// the samples of the pixel.
#[derive(Clone)]
pub struct Choices {
    key: u64,
    sample: u32,
    /// The third coordinate of the sample's place in the pixel, its bits in the other order, before it is scrambled; 0 until it is asked for.
    third: u32,
    /// Pairs drawn so far.
    pairs: u64,
    random: SplitMix64,
}

impl Choices {
    /// A point in the unit square. The n-th pairs of all samples of a pixel are a (0,2)-net of their own.
    #[inline(always)]
    pub fn pair(&mut self) -> (f64, f64) {
        self.pairs(1).point(0)
    }

    /// A point in the unit square for each of so many branches: those of all samples of a pixel are one net together.
    #[inline(always)]
    pub fn pairs(&mut self, branches: u32) -> Pairs {
        self.pairs += 1;
        Pairs { key: self.key_of_pairs(), first: self.sample.wrapping_mul(branches) }
    }

    /// [`Choices::pair`] of neighbouring samples of a pixel that have drawn as many, side by side.
    #[inline(always)]
    pub fn pair_each(samples: &mut [Choices], a: &mut [f64], b: &mut [f64]) {
        for choices in samples.iter_mut() {
            choices.pairs += 1;
        }
        if let Some(first) = samples.first() {
            net_points(first.key_of_pairs(), first.sample, a, b);
        }
    }

    /// The key of the net of the pairs that were drawn last.
    #[inline(always)]
    fn key_of_pairs(&self) -> u64 {
        mix64(self.key ^ self.pairs.wrapping_mul(0xD1B5_4A32_D192_ED03))
    }

    /// Uniform in [0, 1), for the choice of this name. What all samples of a pixel draw by one name lies evenly, and so do the places
    /// in the pixel of those that draw nearly the same: they are three dimensions of one sequence.
    #[inline(always)]
    pub fn even(&mut self, name: u32) -> f64 {
        if self.third == 0 {
            self.third = sobol_third_reversed(shuffled(self.key, self.sample));
        }
        let key = mix64(self.key ^ mix64(name.into()));
        let even = laine_karras(self.third, (key >> 32) as u32).reverse_bits();
        // What follows the 32 bits of the sequence is random.
        (f64::from(even) + self.random.unit()) * TO_UNIT
    }

    /// Uniform in [0, 1).
    #[inline(always)]
    pub fn next(&mut self) -> f32 {
        self.random.unit_single()
    }
}

/// Points of a net that belong to one sample.
pub struct Pairs {
    key: u64,
    first: u32,
}

impl Pairs {
    /// Those of the first branches.
    #[inline(always)]
    pub fn points<const COUNT: usize>(&self) -> [(f64, f64); COUNT] {
        let (mut a, mut b) = ([0.0; COUNT], [0.0; COUNT]);
        net_points(self.key, self.first, &mut a, &mut b);
        std::array::from_fn(|branch| (a[branch], b[branch]))
    }

    /// That of one of its branches.
    #[inline(always)]
    pub fn point(&self, branch: u32) -> (f64, f64) {
        net_point(self.key, self.first.wrapping_add(branch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the recursion of the direction numbers: v_0 = 1/2, v_(k+1) = v_k + v_k / 2 without carry.
    #[test]
    fn the_second_dimension_is_that_of_sobol() {
        let by_recursion = |index: u32| {
            let (mut direction, mut x) = (1_u32 << 31, 0);
            for bit in 0..32 {
                x ^= if index >> bit & 1 == 1 { direction } else { 0 };
                direction ^= direction >> 1;
            }
            x
        };
        for index in (0..300).chain((0..500).map(|i: u32| mix64(i.into()) as u32)).chain([u32::MAX, 1 << 31]) {
            assert_eq!(sobol_second_reversed(index).reverse_bits(), by_recursion(index), "{index:#x}");
        }
    }

    fn assert_net(points: &[(f64, f64)], what: &str) {
        assert_eq!(points.len(), 16);
        for split in 0..=4 {
            let (columns, rows) = (1_usize << split, 1_usize << (4 - split));
            let mut count = vec![0; 16];
            for &(x, y) in points {
                count[(y * rows as f64) as usize * columns + (x * columns as f64) as usize] += 1;
            }
            assert!(count.iter().all(|&c| c == 1), "{what}, {columns} x {rows}: {count:?}");
        }
    }

    #[test]
    fn branches_of_all_samples_are_a_net_together() {
        for pixel in 0..50 {
            let sampler = PixelSampler::new(7, pixel);
            let points: Vec<(f64, f64)> = (0..4)
                .flat_map(|sample| {
                    let mut choices = sampler.choices(sample);
                    choices.pair();
                    let pairs = choices.pairs(4);
                    (0..4).map(move |branch| pairs.point(branch))
                })
                .collect();
            assert_net(&points, &format!("pixel {pixel}"));
        }
    }

    /// Every elementary rectangle of area 1/n of a (0,2)-net in base 2 holds exactly one of its n points.
    #[test]
    fn sixteen_points_are_a_net() {
        for pixel in 0..50 {
            let sampler = PixelSampler::new(7, pixel);
            assert_net(&(0..16).map(|i| sampler.point(i)).collect::<Vec<_>>(), &format!("pixel {pixel}"));
        }
    }

    /// The published points of that dimension (S. Joe, F. Y. Kuo, direction numbers of 2010: degree 2, a = 1, m = 1, 3), which come in the order
    /// of Gray's code.
    #[test]
    fn the_third_dimension_is_that_of_sobol() {
        let found = (0..8).map(|i: u32| f64::from(sobol_third_reversed(i ^ i >> 1).reverse_bits()) * TO_UNIT);
        assert_eq!(found.collect::<Vec<_>>(), [0.0, 0.5, 0.25, 0.75, 0.625, 0.125, 0.875, 0.375]);
    }

    /// Together with places in the pixel numbers of one name are a (1,3)-net: each elementary box of an eighth holds two of sixteen points.
    #[test]
    fn numbers_of_one_name_are_a_net_with_the_places() {
        for pixel in 0..50 {
            let sampler = PixelSampler::new(7, pixel);
            let points: Vec<[f64; 3]> = (0..16)
                .map(|sample| {
                    let (x, y) = sampler.point(sample);
                    [x, y, sampler.choices(sample).even(pixel as u32 + 1)]
                })
                .collect();
            for a in 0..=3 {
                for b in 0..=3 - a {
                    let sides = [a, b, 3 - a - b].map(|bits| f64::from(1 << bits));
                    let mut count = std::collections::HashMap::new();
                    for point in &points {
                        let cell: Vec<u32> = point.iter().zip(sides).map(|(x, n)| (x * n) as u32).collect();
                        *count.entry(cell).or_insert(0) += 1;
                    }
                    assert!(count.len() == 8 && count.values().all(|&n| n == 2), "pixel {pixel}, {sides:?}: {count:?}");
                }
            }
            let mut rows: Vec<u32> = points.iter().map(|point| (point[2] * 16.0) as u32).collect();
            rows.sort_unstable();
            assert_eq!(rows, (0..16).collect::<Vec<u32>>(), "pixel {pixel}");
        }
    }

    #[test]
    fn numbers_of_two_names_are_independent() {
        let mut count = [0_u32; 64];
        for pixel in 0..64_000 {
            let mut choices = PixelSampler::new(3, pixel).choices(5);
            let (a, b) = (choices.even(1), choices.even(2));
            count[(a * 8.0) as usize * 8 + (b * 8.0) as usize] += 1;
        }
        let chi: f64 = count.iter().map(|&c| (f64::from(c) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi < 103.4, "chi-square {chi} (63 degrees of freedom, 99.9 %)");
    }

    #[test]
    fn seeds_and_pixels_differ_and_repeat() {
        let point = |seed, pixel| PixelSampler::new(seed, pixel).point(3);
        assert_eq!(point(1, 2), point(1, 2));
        assert_ne!(point(1, 2), point(2, 2));
        assert_ne!(point(1, 2), point(1, 3));
    }

    /// Chi-square over 64 cells of first points of many pixels: 63 degrees of freedom, 99.9 % below 103.4.
    #[test]
    fn first_points_are_uniform() {
        let pixels = 64_000;
        let mut count = [0_u32; 64];
        for pixel in 0..pixels {
            let (x, y) = PixelSampler::new(3, pixel).point(0);
            count[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
        }
        let expected = pixels as f64 / 64.0;
        let chi: f64 = count.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        assert!(chi < 103.4, "chi-square {chi}");
    }

    #[test]
    fn points_side_by_side_are_those_one_by_one() {
        let sampler = PixelSampler::new(5, 77);
        let (mut x, mut y) = ([0.0; 40], [0.0; 40]);
        sampler.points(9, &mut x, &mut y);
        assert!((0..40).all(|i| (x[i], y[i]) == sampler.point(9 + i as u32)));
        let mut all: Vec<Choices> = (9..49).map(|sample| sampler.choices(sample)).collect();
        let mut one_by_one = all.clone();
        for _ in 0..3 {
            Choices::pair_each(&mut all, &mut x, &mut y);
            assert!((0..40).all(|i| (x[i], y[i]) == one_by_one[i].pair()));
        }
    }

    #[test]
    fn choices_are_uniform() {
        let mut choices = PixelSampler::new(1, 1).choices(0);
        let mut count = [0_u32; 32];
        for _ in 0..32_000 {
            let u = choices.next();
            assert!((0.0..1.0).contains(&u));
            count[(u * 32.0) as usize] += 1;
        }
        let chi: f64 = count.iter().map(|&c| (f64::from(c) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi < 61.1, "chi-square {chi} (31 degrees of freedom, 99.9 %)");
    }
}
