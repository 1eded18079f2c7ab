//! The scalar, `f32` or `f64`, with transcendental functions that are the same on every target: from `libm`, or from `single.rs`
//! where those of `libm` use double precision for `f32`.

use crate::Zero;
use crate::numerics::single;
use core::fmt::Display;
use nalgebra::Scalar;
use num_traits::NumAssign;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point scalar: implemented by `f32` and `f64`, and by nothing else.
///
/// All functions that are not exactly rounded come from `libm` or this crate on every target, the host included, so that
/// the same inputs give the same bits everywhere. No method uses a fused multiply-add.
///
/// ```
/// use scphd::Real;
///
/// fn norm<T: Real>(x: T, y: T) -> T {
///     (x * x + y * y).sqrt()
/// }
/// assert_eq!(norm(3.0_f32, 4.0), 5.0);
/// assert_eq!(norm(3.0_f64, 4.0), 5.0);
/// ```
pub trait Real:
    sealed::Sealed + Zero + Scalar + Default + Display + PartialOrd + NumAssign + core::ops::Neg<Output = Self>
{
    /// 1, as a constant.
    const ONE: Self;
    /// Distance from 1 to the next greater number.
    const EPSILON: Self;
    /// −∞, the logarithm of a weight of zero.
    const NEG_INFINITY: Self;
    /// ln of a quarter of [`EPSILON`](Self::EPSILON), or a little less: a term smaller than a sum by this factor does not change
    /// it.
    const LN_VANISHING: Self;
    /// +∞.
    const INFINITY: Self;
    /// π.
    const PI: Self;

    /// The nearest scalar to `x`.
    fn from_f64(x: f64) -> Self;
    /// The nearest scalar to `n`.
    fn from_usize(n: usize) -> Self;
    /// The nearest scalar to `n`.
    fn from_i32(n: i32) -> Self;
    /// The same number as `f64`.
    fn to_f64(self) -> f64;
    /// The nearest integer towards zero, saturating; 0 for NaN.
    fn to_i32(self) -> i32;
    /// The nearest integer towards zero between 0 and `most`; 0 for NaN.
    fn to_index(self, most: u8) -> usize;
    /// The bits of the number (of an `f32`, in the lower half), for digests.
    fn bits(self) -> u64;
    /// The number with these bits.
    fn from_bits(bits: u64) -> Self;

    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether the number is finite and not negative. Not inlined, for checks of settings: compilers test its class bit by bit,
    /// which takes more code than a call.
    #[inline(never)]
    fn is_amount(self) -> bool {
        self >= Self::ZERO && self.is_finite()
    }
    /// Whether the number is positive and neither subnormal, infinite nor NaN.
    fn is_normal_positive(self) -> bool;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Greatest integer not above.
    fn floor(self) -> Self;
    /// Square root, exactly rounded.
    fn sqrt(self) -> Self;
    /// 1/√`self`, within a few rounding errors.
    fn inverse_sqrt(self) -> Self;
    /// An upper bound of the square root, at most 0.1 % above it.
    fn sqrt_above(self) -> Self;
    /// e to the power of `self`.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine and cosine of an angle in rad.
    fn sin_cos(self) -> (Self, Self);
    /// Tangent of an angle in rad.
    fn tan(self) -> Self;
    /// Angle of the vector (`x`, `self`) in rad, in \[−π, π\].
    fn atan2(self, x: Self) -> Self;

    /// The smaller of two numbers; `other` if `self` is NaN.
    fn at_most(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// The greater of two numbers; `other` if `self` is NaN.
    fn at_least(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

macro_rules! implement_real {
    ($t:ident, $is_normal_positive:expr, $sqrt:ident, $inverse_sqrt:expr, $sqrt_above:path, $exp:path, $ln:path, $sincos:path, $tan:path, $atan2:path, $floor:ident, $vanishing:literal) => {
        impl Zero for $t {
            const ZERO: Self = 0.0;
        }
        impl Real for $t {
            const ONE: Self = 1.0;
            const EPSILON: Self = $t::EPSILON;
            const NEG_INFINITY: Self = $t::NEG_INFINITY;
            const INFINITY: Self = $t::INFINITY;
            const LN_VANISHING: Self = $vanishing;
            const PI: Self = core::$t::consts::PI;

            #[inline]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline]
            fn from_usize(n: usize) -> Self {
                n as $t
            }
            #[inline]
            fn from_i32(n: i32) -> Self {
                n as $t
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline]
            fn to_index(self, most: u8) -> usize {
                // The same number; on a PC the first form takes a third of the instructions, on a Cortex-M the second.
                if cfg!(target_arch = "x86_64") {
                    usize::from((self as u8).min(most))
                } else {
                    (self as i32).clamp(0, i32::from(most)).unsigned_abs() as usize
                }
            }
            #[inline]
            fn bits(self) -> u64 {
                u64::from(self.to_bits())
            }
            #[inline]
            fn from_bits(bits: u64) -> Self {
                $t::from_bits(bits as _)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            #[inline]
            fn is_normal_positive(self) -> bool {
                $is_normal_positive(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline]
            fn floor(self) -> Self {
                libm::$floor(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            #[inline]
            fn inverse_sqrt(self) -> Self {
                $inverse_sqrt(self)
            }
            #[inline]
            fn sqrt_above(self) -> Self {
                $sqrt_above(self)
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn tan(self) -> Self {
                $tan(self)
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
        }
    };
}

implement_real!(
    f32,
    single::is_normal_positive,
    sqrtf,
    single::inverse_sqrt,
    single::sqrt_above,
    single::exp,
    single::ln,
    single::sin_cos,
    single::tan,
    single::atan2,
    floorf,
    -17.33
);
implement_real!(
    f64,
    |x: f64| (f64::MIN_POSITIVE..f64::INFINITY).contains(&x),
    sqrt,
    |x| 1.0 / libm::sqrt(x),
    libm::sqrt,
    libm::exp,
    libm::log,
    libm::sincos,
    libm::tan,
    libm::atan2,
    floor,
    -37.43
);
