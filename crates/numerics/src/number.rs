//! What a kernel computes with: one number of double precision, or a vector of either precision, as wide as the machine
//! has them.
//!
//! A formula that is written over [`Number`] is compiled for every instance and every level of SIMD, so that the careful
//! form, the fast one and the one in single precision cannot drift apart. `crates/optics/tests/instances.rs` compares them.

use std::marker::PhantomData;
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
    /// The largest whole number that is not greater.
    fn floor(self) -> Self;
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
    fn floor(self) -> f64 {
        f64::floor(self)
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

/// A vector as wide as the level `S` has them, as a [`Number`]: `Simd::f64s` and `Simd::f32s` are not known to be any
/// certain type where `S` is not.
pub struct Wide<S, V>(pub V, PhantomData<S>);

/// The level's own vector of double precision.
pub type F64s<S> = Wide<S, <S as Simd>::f64s>;
/// The level's own vector of single precision.
pub type F32s<S> = Wide<S, <S as Simd>::f32s>;

impl<S, V: Copy> Clone for Wide<S, V> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, V: Copy> Copy for Wide<S, V> {}

impl<S: Simd, V: SimdFloat<S>> Wide<S, V> {
    /// Numbers that go together.
    pub const LEN: usize = V::LEN;

    #[inline(always)]
    pub(crate) fn new(vector: V) -> Self {
        Wide(vector, PhantomData)
    }

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: V::Element) -> Self {
        Wide::new(V::simd_from(simd, value))
    }

    /// The first entries of a slice, which must hold as many.
    #[inline(always)]
    pub fn from_slice(simd: S, slice: &[V::Element]) -> Self {
        Wide::new(V::from_slice(simd, slice))
    }

    /// Writes to the first entries of a slice, which must hold as many.
    #[inline(always)]
    pub fn store_slice(self, slice: &mut [V::Element]) {
        self.0.store_slice(slice);
    }
}

/// Operators of [`Wide`], between vectors and with a constant.
macro_rules! operator {
    ($operator:ident, $method:ident) => {
        impl<S: Simd, V: SimdFloat<S>> $operator for Wide<S, V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Wide::new(self.0.$method(other.0))
            }
        }

        impl<S: Simd, V: SimdFloat<S>> $operator<f64> for Wide<S, V>
        where
            V::Element: Precision,
        {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Wide::new(self.0.$method(V::Element::of(other)))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);

impl<S: Simd, V: SimdFloat<S>> Div for Wide<S, V> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Wide::new(self.0 / other.0)
    }
}

impl<S: Simd, V: SimdFloat<S>> Neg for Wide<S, V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Wide::new(-self.0)
    }
}

/// Makes a kind of vector a [`Number`]: what wraps the library's vector, and how it is had.
macro_rules! vector {
    ([$($generics:tt)*] $type:ty, $vector:ty, $wrap:expr, $x:ident => $inner:expr) => {
        impl<S: Simd, $($generics)*> Number for $type
        where
            <$vector as SimdBase<S>>::Element: Precision,
        {
            type Precision = <$vector as SimdBase<S>>::Element;
            type Mask = <$vector as SimdBase<S>>::Mask;

            #[inline(always)]
            fn like(self, value: f64) -> Self {
                let $x = self;
                $wrap(<$vector>::simd_from($inner.token(), Self::Precision::of(value)))
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                let (bias, digits) = Self::Precision::EXPONENT;
                let $x = self.plus(Self::Precision::ROUND + bias);
                $wrap(<$vector as SimdFloat<S>>::from_bits(SimdFloat::<S>::to_bits($inner) << digits))
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                let yes = {
                    let $x = yes;
                    $inner
                };
                let $x = no;
                $wrap(Select::<$vector>::select(mask, yes, $inner))
            }
            vector!(@ $vector, $wrap, $x => $inner, SimdFloat: sqrt round_ties_even floor);
            vector!(@ $vector, $wrap, $x => $inner, SimdBase: abs);
            vector!(@2 $vector, $wrap, $x => $inner, SimdBase: min max);
            vector!(@2 $vector, $wrap, $x => $inner, SimdFloat: copysign);
            vector!(@3 $vector, $wrap, $x => $inner, mul_add mul_sub);
            vector!(@compare $vector, $x => $inner, lt simd_lt, gt simd_gt, ge simd_ge);
        }
    };
    (@ $vector:ty, $wrap:expr, $x:ident => $inner:expr, $trait:ident: $($method:ident)*) => {$(
        #[inline(always)]
        fn $method(self) -> Self {
            let $x = self;
            $wrap($trait::<S>::$method($inner))
        }
    )*};
    (@2 $vector:ty, $wrap:expr, $x:ident => $inner:expr, $trait:ident: $($method:ident)*) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Self {
            let other = {
                let $x = other;
                $inner
            };
            let $x = self;
            $wrap($trait::<S>::$method($inner, other))
        }
    )*};
    (@3 $vector:ty, $wrap:expr, $x:ident => $inner:expr, $($method:ident)*) => {$(
        #[inline(always)]
        fn $method(self, a: Self, b: Self) -> Self {
            let a = {
                let $x = a;
                $inner
            };
            let b = {
                let $x = b;
                $inner
            };
            let $x = self;
            $wrap(SimdFloat::<S>::$method($inner, a, b))
        }
    )*};
    (@compare $vector:ty, $x:ident => $inner:expr, $($method:ident $theirs:ident),*) => {$(
        #[inline(always)]
        fn $method(self, other: Self) -> Self::Mask {
            let other = {
                let $x = other;
                $inner
            };
            let $x = self;
            SimdBase::<S>::$theirs($inner, other)
        }
    )*};
}

vector!([V: SimdFloat<S>] Wide<S, V>, V, Wide::new, x => x.0);
vector!([] fearless_simd::f32x16<S>, fearless_simd::f32x16<S>, std::convert::identity, x => x);
vector!([] fearless_simd::f64x8<S>, fearless_simd::f64x8<S>, std::convert::identity, x => x);
