//! Sines and cosines of half turns, arc tangents in turns, and exponentials: polynomials after exact reductions.
//!
//! Angles are counted in half turns of pi, because a phase comes as a rate and a length and whole half turns can be taken
//! off their exact product: a cosine of a large argument in radians has lost the digits before it begins.

use crate::number::{Number, Precision};

/// sin(pi x) = x P(x^2) on [-1/2, 1/2], P through nine Chebyshev nodes: relative error 4e-17 before rounding.
const SIN_PI_F64: [f64; 9] = [
    std::f64::consts::PI,
    -5.167712780049969,
    2.5501640398773007,
    -0.5992645293189447,
    0.0821458865731029,
    -0.007370430505916944,
    0.0004662998161898394,
    -2.1903497074626018e-05,
    7.697826768224191e-07,
];
/// cos(pi x) = P(x^2) on [-1/2, 1/2], likewise: error 1e-16 before rounding.
const COS_PI_F64: [f64; 9] = [
    1.0,
    -4.934802200544676,
    4.058712126416497,
    -1.335262768843447,
    0.23533063012953284,
    -0.025806888737002202,
    0.0019295562724817132,
    -0.00010456655338748738,
    4.149564353942586e-06,
];
/// The same in single precision: minimax of P, error 1.4e-8.
const SIN_PI_F32: [f32; 5] = [3.141_592_5, -5.167_710_3, 2.550_077_7, -0.598_292_2, 0.077_659_41];
/// Minimax, error 2.2e-10 before rounding.
const COS_PI_F32: [f32; 6] = [1.0, -4.934_802, 4.058_709, -1.335_212_1, 0.234_937_56, -0.024_396_72];

impl Precision for f64 {
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const EXPONENT: (f64, u32) = (1023.0, 52);
    const LEAST_SQUARE: f64 = f64::MIN_POSITIVE;

    #[inline(always)]
    fn of(value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn sine<V: Number<Precision = f64>>(square: V) -> V {
        polynomial(square, &SIN_PI_F64)
    }
    #[inline(always)]
    fn cosine<V: Number<Precision = f64>>(square: V) -> V {
        polynomial(square, &COS_PI_F64)
    }
}

impl Precision for f32 {
    const ROUND: f64 = 12_582_912.0;
    const EXPONENT: (f64, u32) = (127.0, 23);
    const LEAST_SQUARE: f64 = 1e-12;

    #[inline(always)]
    fn of(value: f64) -> f32 {
        value as f32
    }
    #[inline(always)]
    fn sine<V: Number<Precision = f32>>(square: V) -> V {
        horner(square, &SIN_PI_F32)
    }
    #[inline(always)]
    fn cosine<V: Number<Precision = f32>>(square: V) -> V {
        horner(square, &COS_PI_F32)
    }
}

/// `c[0] + c[1] x + c[2] x^2 + ..` in single precision, each term waiting for the one before: for short polynomials.
#[inline(always)]
pub fn horner<V: Number<Precision = f32>, const N: usize>(x: V, c: &[f32; N]) -> V {
    let mut sum = x.like(f64::from(c[N - 1]));
    for &c in c[..N - 1].iter().rev() {
        sum = sum.mul_add(x, x.like(f64::from(c)));
    }
    sum
}

/// `c[0] + c[1] x + c[2] x^2 + ..`, even and odd powers side by side: half the steps that wait for one another.
#[inline(always)]
pub fn polynomial<V: Number<Precision = f64>, const N: usize>(x: V, c: &[f64; N]) -> V {
    let square = x * x;
    let mut last = x.like(c[N - 1]);
    let mut before = x.like(c[N - 2]);
    for k in (0..N - 2).rev() {
        let next = last.mul_add(square, x.like(c[k]));
        last = before;
        before = next;
    }
    last.mul_add(x, before)
}

/// `rate * length` half turns less the nearest whole number of them, within +-1/2 (and a rounding): the product is exact
/// where the machine fuses. For less than 2^51 half turns (2^22 in single precision).
#[inline(always)]
pub fn within_half_turn<V: Number>(rate: V, length: V) -> V {
    let round = rate.like(V::Precision::ROUND);
    let whole = rate.mul_add(length, round) - round;
    rate.mul_sub(length, whole)
}

/// sin(pi x) for |x| <= 1/2.
#[inline(always)]
pub fn sin_pi<V: Number>(x: V) -> V {
    x * V::Precision::sine(x * x)
}

/// sin(pi x) and cos(pi x) for |x| <= 1/2.
#[inline(always)]
pub fn sin_cos_pi<V: Number>(x: V) -> (V, V) {
    let square = x * x;
    (x * V::Precision::sine(square), V::Precision::cosine(square))
}

/// Sine and cosine of an angle in turns, for less than some thousand of them.
///
/// ```
/// let (sin, cos) = iridesce_numerics::turns::sin_cos_turns(1.375_f64);
/// assert!((sin - 0.5_f64.sqrt()).abs() < 1e-15 && (cos + 0.5_f64.sqrt()).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn sin_cos_turns<V: Number>(turns: V) -> (V, V) {
    let half_turns = turns + turns;
    let whole = half_turns.round_ties_even();
    let (sin, cos) = sin_cos_pi(half_turns - whole);
    // An odd number of half turns changes both signs.
    let half = whole.times(0.5);
    let is_odd = (half - half.floor()).gt(half.like(0.25));
    (V::select(is_odd, -sin, sin), V::select(is_odd, -cos, cos))
}

/// sin^2(pi x) for |x| <= 1/2.
#[inline(always)]
pub fn sin_squared_pi<V: Number>(x: V) -> V {
    let sine = sin_pi(x);
    sine * sine
}

/// exp(r) - 1 = r + r^2 P(r) for |r| <= ln(2)/2: Taylor's terms to r^14, the rest below 1e-18 of the whole.
const EXP_M1: [f64; 13] = [
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
    1.0 / 87_178_291_200.0,
];
/// ln 2 in two parts; the first ends in zeros, so that its product with a small integer is exact.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// exp of less is no normal number.
const LEAST_EXPONENT: f64 = -708.0;

/// exp(x) - 1 for x <= 0, good to a rounding or two of itself however small x is; and exp(x), 0 below exp(-708).
#[inline(always)]
pub fn exp_m1<V: Number<Precision = f64>>(x: V) -> (V, V) {
    let least = x.like(LEAST_EXPONENT);
    let vanishes = x.lt(least);
    let x = x.max(least);
    let (round, one) = (x.like(f64::ROUND), x.like(1.0));
    let whole = x.mul_add(x.like(std::f64::consts::LOG2_E), round) - round;
    let [high, low] = LN_2.map(|part| x.like(-part));
    let rest = whole.mul_add(low, whole.mul_add(high, x));
    let part = (rest * rest).mul_add(polynomial(rest, &EXP_M1), rest);
    let scale = whole.power_of_two();
    let less_one = scale.mul_add(part, scale - one);
    (V::select(vanishes, -one, less_one), V::select(vanishes, x.like(0.0), scale.mul_add(part, scale)))
}

/// 2^x on [-1/2, 1/2]; Chebyshev fit, error 2.6e-9.
const EXP2: [f32; 7] =
    [1.0, std::f32::consts::LN_2, 0.240_226_5, 0.055_503_27, 0.009_618_026, 0.001_340_043_1, 0.000_154_697_32];

/// 2^x for x <= 0 in single precision; zero below the smallest normal number.
#[inline(always)]
pub fn exp2<V: Number<Precision = f32>>(x: V) -> V {
    let clamped = x.max(x.like(-120.0));
    let whole = clamped.round_ties_even();
    let fraction = horner(clamped - whole, &EXP2);
    V::select(x.lt(x.like(-119.0)), x.like(0.0), fraction * whole.power_of_two())
}

/// atan(t) / (2 pi t) as a polynomial of t^2 on [0, 1]; weighted minimax fit.
const ATAN: [f32; 8] = [
    0.159_154_83,
    -0.053_046_122,
    0.031_745_944,
    -0.022_136_265,
    0.015_346_02,
    -0.008_898_706,
    0.003_479_586_2,
    -0.000_645_301_3,
];

/// atan2(y, x) in turns, in [-1/2, 1/2], in single precision; error below 1e-8 of a turn before rounding, so that a map of
/// 8192 columns is looked up to 5e-4 of a texel. NaN-free: atan2(0, 0) is 0.
#[inline(always)]
pub fn atan2_turns<V: Number<Precision = f32>>(y: V, x: V) -> V {
    let (ax, ay) = (x.abs(), y.abs());
    // The smallest normal number keeps 0 / 0 from happening and changes no other quotient.
    let t = ax.min(ay) / ax.max(ay).max(x.like(f64::from(f32::MIN_POSITIVE)));
    let octant = t * horner(t * t, &ATAN);
    let quadrant = V::select(ay.gt(ax), x.like(0.25) - octant, octant);
    let half = V::select(x.lt(x.like(0.0)), x.like(0.5) - quadrant, quadrant);
    half.copysign(y)
}

/// Of the arc tangent: 1, -1/3, 1/5, ... and half of the last.
const ATAN_SERIES: [f64; 13] = [
    1.0,
    -1.0 / 3.0,
    1.0 / 5.0,
    -1.0 / 7.0,
    1.0 / 9.0,
    -1.0 / 11.0,
    1.0 / 13.0,
    -1.0 / 15.0,
    1.0 / 17.0,
    -1.0 / 19.0,
    1.0 / 21.0,
    -1.0 / 23.0,
    0.5 / 25.0,
];

/// atan2(y, x) in radians, to 2e-11: a third of the time of the library's, which is exact. At the origin it is some number, not NaN.
///
/// ```
/// assert!((iridesce_numerics::turns::atan2_fast(-1.0, -2.0) - f64::atan2(-1.0, -2.0)).abs() < 2e-11);
/// ```
#[inline]
pub fn atan2_fast(y: f64, x: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax > ay { (ay, ax) } else { (ax, ay) };
    // tan(a - pi/8) keeps the argument within 0.4142 of zero.
    const T: f64 = 0.414_213_562_373_095_03;
    let t = if large > 0.0 { (small - T * large) / (large + T * small) } else { 0.0 };
    let s = t * t;
    // The series of the arc tangent: s^11 / 23 at s = 0.1716 is 2e-10 of t, so eleven terms and half the next. Even and
    // odd terms go side by side, for what one waits for is the other's time.
    let q = s * s;
    let (mut even, mut odd) = (ATAN_SERIES[12], ATAN_SERIES[11]);
    for k in (0..6).rev() {
        even = ATAN_SERIES[2 * k] + q * even;
    }
    for k in (0..5).rev() {
        odd = ATAN_SERIES[2 * k + 1] + q * odd;
    }
    let sum = even + s * odd;
    let octant = FRAC_PI_2 / 4.0 + t * sum;
    let quadrant = if ay > ax { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    if y < 0.0 { -half } else { half }
}

/// (cos, sin) of 2 pi `turns`, for |turns| < 2^49, to 1e-16 or so beyond the rounding of `turns`.
///
/// Written without calls or branches so that the compiler can do several at once and without a fused step, so that every
/// machine gives the same bits: quarter turns are split off exactly, and a Taylor series serves the rest of an eighth of a
/// turn.
///
/// ```
/// let (cos, sin) = iridesce_numerics::turns::cos_sin_turns(1000.125);
/// assert!((cos - 0.5_f64.sqrt()).abs() < 1e-15 && (sin - 0.5_f64.sqrt()).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn cos_sin_turns(turns: f64) -> (f64, f64) {
    use std::f64::consts::FRAC_PI_2;
    let within = turns - ((turns + f64::ROUND) - f64::ROUND);
    let quarters = 4.0 * within;
    let quarter = (quarters + f64::ROUND) - f64::ROUND;
    let x = (quarters - quarter) * FRAC_PI_2;
    let y = x * x;
    // Terms to x^15 and x^16: the rest is below (pi/4)^17 / 17! = 5e-17.
    let sin = x + x
        * y
        * (-1.0 / 6.0
            + y * (1.0 / 120.0
                + y * (-1.0 / 5040.0
                    + y * (1.0 / 362_880.0
                        + y * (-1.0 / 39_916_800.0
                            + y * (1.0 / 6_227_020_800.0 + y * (-1.0 / 1_307_674_368_000.0)))))));
    let cos = 1.0
        + y * (-0.5
            + y * (1.0 / 24.0
                + y * (-1.0 / 720.0
                    + y * (1.0 / 40_320.0
                        + y * (-1.0 / 3_628_800.0
                            + y * (1.0 / 479_001_600.0
                                + y * (-1.0 / 87_178_291_200.0 + y * (1.0 / 20_922_789_888_000.0))))))));
    let sign = 1.0 - quarter.abs(); // 1, 0, -1 for 0, +-1, +-2 quarters
    let odd = quarter * (1.0 - sign * sign); // +-1 for +-1 quarter, else 0
    (sign * cos - odd * sin, sign * sin + odd * cos)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Simd, dispatch, f32x16, f64x8, prelude::*};

    use super::*;
    use crate::simd::levels;

    #[test]
    fn cosine_and_sine_of_turns() {
        for i in -4000..=4000 {
            let turns = f64::from(i) / 512.0;
            let (cos, sin) = cos_sin_turns(turns);
            let (s, c) = (std::f64::consts::TAU * (turns - turns.round())).sin_cos();
            // The reference rounds 2 pi turns, up to pi, by 4e-16 at most.
            assert!((cos - c).abs() < 6e-16 && (sin - s).abs() < 6e-16, "{turns}: {cos} {c} {sin} {s}");
        }
        assert_eq!(cos_sin_turns(0.25), (0.0, 1.0));
        assert_eq!(cos_sin_turns(1e6 + 0.5), (-1.0, 0.0));
    }

    #[test]
    fn angles_agree_with_the_library() {
        use std::f64::consts::{PI, TAU};
        for k in 0..100_000 {
            let a = TAU * f64::from(k) / 100_000.0 - PI + 1e-9;
            let r = 1.0 + f64::from(k % 7);
            assert!((atan2_fast(r * a.sin(), r * a.cos()) - a).abs() < 2e-11, "{a}");
        }
        assert!(atan2_fast(0.0, 0.0).is_finite());
    }

    #[test]
    fn fast_arc_tangent_is_the_arc_tangent() {
        #[inline(always)]
        fn check<S: Simd>(simd: S) {
            for i in 0..1000 {
                let angle = (f64::from(i) / 1000.0 - 0.5) * std::f64::consts::TAU * 0.999;
                let (y, x) = (angle.sin() as f32, angle.cos() as f32);
                let turns = atan2_turns(f32x16::splat(simd, y), f32x16::splat(simd, x)).to_array()[3];
                let exact = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
                assert!((f64::from(turns) - exact).abs() < 6e-8, "{turns} {exact}");
            }
            for (y, x, wanted) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.25), (-1.0, 0.0, -0.25), (0.0, -1.0, 0.5)] {
                let turns = atan2_turns(f32x16::splat(simd, y), f32x16::splat(simd, x)).to_array()[0];
                assert!((turns - wanted).abs() < 1e-7, "{y} {x}");
            }
        }
        for level in levels() {
            dispatch!(level, simd => check(simd));
        }
    }

    /// x, sin(pi x), cos(pi x) of a rate times some lengths, by one instance.
    #[inline(always)]
    fn sines<V: Number>(rate: V, length: V) -> [V; 3] {
        let x = within_half_turn(rate, length);
        let (sin, cos) = sin_cos_pi(x);
        [x, sin, cos]
    }

    const LENGTHS: [f64; 8] = [0.0, 0.5, 1.0, 1.5, 3.0, 64.0, 1000.0, 1.0 + f64::EPSILON];

    #[inline(always)]
    fn in_double<S: Simd>(simd: S, rate: f64) -> [[f64; 8]; 3] {
        sines(f64x8::splat(simd, rate), f64x8::from_slice(simd, &LENGTHS)).map(|v| v.to_array())
    }

    #[inline(always)]
    fn in_single<S: Simd>(simd: S, rate: f64) -> [[f32; 16]; 3] {
        let lengths: [f32; 16] = std::array::from_fn(|i| LENGTHS[i % 8] as f32);
        sines(f32x16::splat(simd, rate as f32), f32x16::from_slice(simd, &lengths)).map(|v| v.to_array())
    }

    /// Every instance against the library's sine of the exact remainder: double within 5e-16, single within 2.5e-7
    /// (4e-8 of the polynomial and 3.5 roundings of 6e-8).
    #[test]
    fn sines_and_cosines_of_half_turns_in_every_instance() {
        for i in 0..2000 {
            // Exact in single precision too, and so are its products with all lengths but the last.
            let rate = f64::from(i) / 4096.0 - 0.25;
            let wanted = LENGTHS.map(|length| {
                let half_turns = rate * length;
                let nearest = half_turns.round_ties_even();
                let (sin, cos) = (std::f64::consts::PI * (half_turns - nearest)).sin_cos();
                (half_turns - nearest, sin, cos)
            });
            let agrees = |what: &str, lane: usize, got: [f64; 3], tolerance: f64| {
                let (x, sin, cos) = wanted[lane];
                // Half a turn to one side is half a turn to the other with both signs changed.
                let sign = if (got[0] - x).abs() > 0.5 { -1.0 } else { 1.0 };
                assert!(got[0].abs() <= 0.5 + tolerance, "{what}");
                assert!((sign * got[1] - sin).abs() < tolerance, "{what} {rate} {lane}: {} {sin}", got[1]);
                assert!((sign * got[2] - cos).abs() < tolerance, "{what} {rate} {lane}: {} {cos}", got[2]);
            };
            for (lane, length) in LENGTHS.into_iter().enumerate() {
                agrees("scalar", lane, sines(rate, length), 5e-16);
            }
            for level in levels() {
                let name = format!("{level:?}");
                let [x, sin, cos] = dispatch!(level, simd => in_double(simd, rate));
                (0..8).for_each(|lane| agrees(&name, lane, [x[lane], sin[lane], cos[lane]], 5e-16));
                let [x, sin, cos] = dispatch!(level, simd => in_single(simd, rate));
                let wide = |v: f32| f64::from(v);
                (0..7).for_each(|lane| {
                    agrees(&name, lane, [wide(x[lane]), wide(sin[lane]), wide(cos[lane])], 2.5e-7);
                });
            }
        }
    }

    #[inline(always)]
    fn exponentials<S: Simd>(simd: S, x: f64) -> [f64; 3] {
        let (less_one, whole) = exp_m1(f64x8::splat(simd, x));
        let two = exp2(f32x16::splat(simd, x as f32));
        [less_one.to_array()[3], whole.to_array()[3], f64::from(two.to_array()[3])]
    }

    #[test]
    fn exponentials_keep_their_digits_in_every_instance() {
        let xs = [0.0, -1e-300, -1e-17, -1e-8, -1e-3, -0.34, -0.36, -0.7, -1.0, -5.0, -37.0, -300.0, -700.0, -708.1];
        for x in xs.into_iter().chain((0..4000).map(|i| -f64::from(i) * 0.01)) {
            let (less_one, whole) = exp_m1(x);
            let mut all = vec![("scalar".to_string(), [less_one, whole])];
            for level in levels() {
                let [less_one, whole, two] = dispatch!(level, simd => exponentials(simd, x));
                all.push((format!("{level:?}"), [less_one, whole]));
                let exact = f64::from(x as f32).exp2();
                let wanted = if x < -119.0 { 0.0 } else { exact };
                assert!((two - wanted).abs() <= 2e-7 * wanted, "{level:?} {x}: {two:e} {wanted:e}");
            }
            for (name, [less_one, whole]) in all {
                assert!((less_one - x.exp_m1()).abs() <= 4e-16 * x.exp_m1().abs(), "{name} {x}: {less_one}");
                let wanted = if x < LEAST_EXPONENT { 0.0 } else { x.exp() };
                assert!((whole - wanted).abs() <= 4e-16 * wanted, "{name} {x}: {whole:e} {wanted:e}");
            }
        }
        let (less_one, whole) = exp_m1(-1e9);
        assert_eq!((less_one, whole), (-1.0, 0.0));
    }
}
