//! What a kernel computes with: one number of double precision, or a vector of either precision, as wide as the machine
//! has them.
//!
//! A formula that is written over [`Number`] is compiled for every instance and every level of SIMD, so that the careful
//! form, the fast one and the one in single precision cannot drift apart. `crates/optics/tests/instances.rs` compares them.

use std::ops::{Add, BitAnd, Div, Mul, Neg, Sub};

use fearless_simd::{ExtractToken, Simd, SimdFloatElement, prelude::*};

/// A real number, or one in every lane of a vector.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self> + Sized
{
    /// `f32` or `f64`.
    type Precision: Precision;
    /// What comparisons give.
    type Mask: Copy + BitAnd<Output = Self::Mask>;

    /// The same value in every lane.
    fn like(self, value: f64) -> Self;
    /// `self * a + b`, with one rounding where the machine has that instruction and two elsewhere.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `self * a - b`, likewise.
    fn mul_sub(self, a: Self, b: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The smaller one; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// The nearest whole number, the even one of two.
    fn round_ties_even(self) -> Self;
    /// Its size with the sign of another.
    fn copysign(self, sign: Self) -> Self;
    /// Where it is less.
    fn lt(self, other: Self) -> Self::Mask;
    /// Where it is greater.
    fn gt(self, other: Self) -> Self::Mask;
    /// Where it is greater or equal.
    fn ge(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// `2^self` of a whole number within the range of exponents.
    fn power_of_two(self) -> Self;

    /// Times a constant.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self * self.like(factor)
    }

    /// Plus a constant.
    #[inline(always)]
    fn plus(self, term: f64) -> Self {
        self + self.like(term)
    }
}

/// What depends on the number of digits.
pub trait Precision: SimdFloatElement {
    /// Adding and taking away 1.5 times two to the number of stored digits rounds to the nearest whole number.
    const ROUND: f64;
    /// Bias of the exponent, and the bits below it.
    const EXPONENT: (f64, u32);
    /// Squares below this have lost digits, or all of them, to the end of the range.
    const LEAST_SQUARE: f64;

    /// The nearest number of this precision.
    fn of(value: f64) -> Self;
    /// sin(pi x) / x at `x^2`, for |x| <= 1/2.
    fn sine<V: Number<Precision = Self>>(square: V) -> V;
    /// cos(pi x) at `x^2`, for |x| <= 1/2.
    fn cosine<V: Number<Precision = Self>>(square: V) -> V;
}

/// One number of double precision. Products are never fused with sums, so every machine gives the same bits.
impl Number for f64 {
    type Precision = f64;
    type Mask = bool;

    #[inline(always)]
    fn like(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64) -> f64 {
        self * a + b
    }
    #[inline(always)]
    fn mul_sub(self, a: f64, b: f64) -> f64 {
        self * a - b
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn round_ties_even(self) -> f64 {
        f64::round_ties_even(self)
    }
    #[inline(always)]
    fn copysign(self, sign: f64) -> f64 {
        f64::copysign(self, sign)
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn gt(self, other: f64) -> bool {
        self > other
    }
    #[inline(always)]
    fn ge(self, other: f64) -> bool {
        self >= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn power_of_two(self) -> f64 {
        let (bias, digits) = f64::EXPONENT;
        f64::from_bits((self + (f64::ROUND + bias)).to_bits() << digits)
    }
}

/// Vectors of one kind.
macro_rules! vector {
    ($vector:ident, $element:ident) => {
        impl<S: Simd> Number for fearless_simd::$vector<S> {
            type Precision = $element;
            type Mask = <Self as SimdBase<S>>::Mask;

            #[inline(always)]
            fn like(self, value: f64) -> Self {
                Self::simd_from(self.token(), $element::of(value))
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                SimdFloat::<S>::mul_add(self, a, b)
            }
            #[inline(always)]
            fn mul_sub(self, a: Self, b: Self) -> Self {
                SimdFloat::<S>::mul_sub(self, a, b)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::<S>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::<S>::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                SimdBase::<S>::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                SimdBase::<S>::max(self, other)
            }
            #[inline(always)]
            fn round_ties_even(self) -> Self {
                SimdFloat::<S>::round_ties_even(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                SimdFloat::<S>::copysign(self, sign)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                self.simd_lt(other)
            }
            #[inline(always)]
            fn gt(self, other: Self) -> Self::Mask {
                self.simd_gt(other)
            }
            #[inline(always)]
            fn ge(self, other: Self) -> Self::Mask {
                self.simd_ge(other)
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Select::select(mask, yes, no)
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                let (bias, digits) = $element::EXPONENT;
                Self::from_bits((self.plus($element::ROUND + bias)).to_bits() << digits)
            }
        }
    };
}

vector!(f32x4, f32);
vector!(f32x8, f32);
vector!(f32x16, f32);
vector!(f64x2, f64);
vector!(f64x4, f64);
vector!(f64x8, f64);

/// A level of SIMD whose own vectors are [`Number`]s: all are.
pub trait Machine: Simd<f64s: Number<Precision = f64>, f32s: Number<Precision = f32>> {}

impl<S> Machine for S
where
    S: Simd,
    S::f64s: Number<Precision = f64>,
    S::f32s: Number<Precision = f32>,
{
}
