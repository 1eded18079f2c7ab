//! Transcendental functions in single precision that stay in single precision.
//!
//! `libm` computes `expf`, `sincosf` and `tanf` partly in double precision, which a single-precision FPU must emulate (over a
//! thousand instructions for a sine). These functions use only integers and f32 additions, multiplications and divisions, on every
//! target, and so give the same bits everywhere. The polynomials are minimax fits of this project; the tests check the error bounds
//! in the documentation of each function over millions of arguments.

// The compiler rounds the constants of the fits to single precision.
#![allow(clippy::excessive_precision)]

/// ln 2 in two parts, the first short enough that its multiples up to 2¹⁰ are exact.
const LN_2: [f32; 2] = [0.693_115_234_375, 3.194_618_3e-5];

/// π/2 in three parts, the first two short enough that their multiples up to 2¹² are exact.
const HALF_PI: [f32; 3] = [1.570_312_5, 0.000_483_751_297, 7.549_790_1e-8];

/// c₀ + c₁ x + c₂ x² + …
#[inline]
fn polynomial<const N: usize>(coefficients: [f32; N], x: f32) -> f32 {
    coefficients.into_iter().rev().reduce(|sum, coefficient| sum * x + coefficient).unwrap_or(0.0)
}

/// The nearest whole number, halves away from zero.
#[inline]
fn nearest(x: f32) -> i32 {
    (x + 0.5_f32.copysign(x)) as i32
}

/// 2ⁿ for −126 ≤ n ≤ 127.
#[inline]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) << 23).cast_unsigned())
}

/// e to the power of `x`; relative error below 1.5e-7 where the result is a normal number.
#[inline]
pub(crate) fn exp(x: f32) -> f32 {
    if !(x.abs() < 87.0) {
        return exp_of_far(x);
    }
    // The result is a normal number: its exponent is the sum of both.
    let (power, n) = power_and_exponent(x);
    f32::from_bits(power.to_bits().wrapping_add((n << 23).cast_unsigned()))
}

/// eˣ = p 2ⁿ, with p between √½ and √2 except for rounding errors.
#[inline]
fn power_and_exponent(x: f32) -> (f32, i32) {
    const COEFFICIENTS: [f32; 7] =
        [1.0, 1.0, 0.499_999_934, 0.166_665_206, 0.041_668_388, 0.008_368_717, 0.001_381_459_8];
    let n = nearest(x * core::f32::consts::LOG2_E);
    let whole = n as f32;
    (polynomial(COEFFICIENTS, x - whole * LN_2[0] - whole * LN_2[1]), n)
}

/// The exponential of a number whose result may not be a normal number, or of NaN.
#[cold]
#[inline(never)]
fn exp_of_far(x: f32) -> f32 {
    if !(x > -104.0 && x < 88.8) {
        return if x < 0.0 {
            0.0
        } else if x > 0.0 {
            f32::INFINITY
        } else {
            x
        };
    }
    let (power, n) = power_and_exponent(x);
    // In two steps, so that neither factor leaves the range of normal numbers.
    let half = n >> 1;
    power * power_of_two(half) * power_of_two(n - half)
}

/// Whether the number is positive and neither subnormal, infinite nor NaN. One comparison of integers: for two of numbers, compilers
/// produce up to fourteen instructions.
#[inline]
pub(crate) fn is_normal_positive(x: f32) -> bool {
    const LEAST: u32 = f32::MIN_POSITIVE.to_bits();
    x.to_bits().wrapping_sub(LEAST) < f32::INFINITY.to_bits() - LEAST
}

/// Natural logarithm; error below 1.5e-7 relative to the result, or to 1 where that is more.
#[inline]
pub(crate) fn ln(x: f32) -> f32 {
    const COEFFICIENTS: [f32; 3] = [0.666_666_850, 0.399_887_806, 0.295_799_494];
    if !is_normal_positive(x) {
        return ln_of_abnormal(x);
    }
    // x = 2ⁿ (1 + f), with 1 + f between √½ and √2.
    const ROOT_HALF: u32 = 0x3f35_04f3;
    let above = x.to_bits().wrapping_sub(ROOT_HALF);
    let n = above.cast_signed() >> 23;
    let f = f32::from_bits((above & 0x007f_ffff) + ROOT_HALF) - 1.0;
    // ln(1 + f) = 2 artanh s, whose first term 2 s is f − s f.
    let s = f / (2.0 + f);
    let square = s * s;
    let half_square = 0.5 * f * f;
    let whole = n as f32;
    let rest = s * (half_square + square * polynomial(COEFFICIENTS, square)) + whole * LN_2[1];
    whole * LN_2[0] + (f - (half_square - rest))
}

/// The logarithm of a number that is not normal or not positive. Not inlined, so that its code exists only once.
#[cold]
#[inline(never)]
fn ln_of_abnormal(x: f32) -> f32 {
    libm::logf(x)
}

/// 1/√x; relative error below 2e-7 where `x` is a normal number.
#[inline]
pub(crate) fn inverse_sqrt(x: f32) -> f32 {
    if !is_normal_positive(x) {
        return 1.0 / libm::sqrtf(x);
    }
    // Halving the exponent gives 1/√x to 3.5 %; two iterations of third order, on the residual 1 − x y², give full precision.
    let start = f32::from_bits(0x5f37_59df - (x.to_bits() >> 1));
    (0..2).fold(start, |y, _| {
        let missing = 1.0 - x * y * y;
        y + y * missing * (0.5 + 0.375 * missing)
    })
}

/// An upper bound of √x, at most 0.1 % above it.
#[inline]
pub(crate) fn sqrt_above(x: f32) -> f32 {
    if !is_normal_positive(x) {
        return libm::sqrtf(x);
    }
    // The mean of a and x/a is never below √x; halving the exponent gives an a with an error of at most 3.5 %. The last factor
    // exceeds rounding errors.
    let start = f32::from_bits(0x1fbd_1df5 + (x.to_bits() >> 1));
    (start + x / start) * 0.500_000_2
}

/// Angle of the vector (`x`, `y`), rad, in \[−π, π\]; error below 3e-7.
#[inline]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    const COEFFICIENTS: [f32; 8] = [
        -0.333_329_871, 0.199_903_966, -0.141_859_750, 0.105_739_310, -0.073_667_037, 0.041_121_831, -0.015_132_518,
        0.002_622_240,
    ];
    let (along, across) = (x.abs(), y.abs());
    let steep = across > along;
    let (less, more) = if steep { (along, across) } else { (across, along) };
    if !is_normal_positive(more) {
        return libm::atan2f(y, x);
    }
    let slope = less / more;
    let square = slope * slope;
    let octant = slope + slope * square * polynomial(COEFFICIENTS, square);
    let quadrant = if steep { core::f32::consts::FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { core::f32::consts::PI - quadrant } else { quadrant };
    half.copysign(y)
}

/// Sine and cosine of an angle, rad; error below 1.5e-7.
pub(crate) fn sin_cos(angle: f32) -> (f32, f32) {
    const SINE: [f32; 3] = [-0.166_666_506, 0.008_331_976, -0.000_194_952_93];
    const COSINE: [f32; 3] = [0.041_666_647, -0.001_388_736_4, 2.443_809_06e-5];
    // Most angles are below 4096. Larger ones and NaN are handled separately.
    let (n, rest) = if angle.abs() < 4096.0 {
        let n = nearest(angle * core::f32::consts::FRAC_2_PI);
        let whole = n as f32;
        (n, angle - whole * HALF_PI[0] - whole * HALF_PI[1] - whole * HALF_PI[2])
    } else if angle.is_finite() {
        quadrant_of_large(angle)
    } else {
        return (f32::NAN, f32::NAN);
    };
    let square = rest * rest;
    let sine = rest + rest * square * polynomial(SINE, square);
    let cosine = 1.0 - 0.5 * square + square * square * polynomial(COSINE, square);
    match n & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// The nearest multiple of π/2 to an angle of at least 4096, modulo four, and the angle from there.
///
/// After Payne and Hanek (1983): uses only those digits of 2/π that are not so high that they count whole turns, nor so low that
/// they have no effect.
#[cold]
#[inline(never)]
fn quadrant_of_large(angle: f32) -> (i32, f32) {
    /// The first 192 binary digits of 2/π.
    const DIGITS: [u64; 3] = [0xa2f9_836e_4e44_1529, 0xfc27_57d1_f534_ddc0, 0xdb62_9599_3c43_9041];
    // |angle| = m 2ᵉ, with m below 2²⁴.
    let bits = angle.to_bits();
    let m = u64::from(bits & 0x007f_ffff | 0x0080_0000);
    let e = (bits >> 23 & 0xff).cast_signed() - 150;
    // 64 digits of 2/π, the first of which is worth two quadrants for m = 1.
    let first = e - 2;
    let digits = if first < 0 {
        DIGITS[0] >> -first
    } else if first < 64 {
        window(DIGITS[0], DIGITS[1], first)
    } else {
        window(DIGITS[1], DIGITS[2], first - 64)
    };
    // Quadrants modulo 4, in units of 2⁻⁶²: whole turns overflow.
    let quadrants = m.wrapping_mul(digits);
    let n = (quadrants >> 61).div_ceil(2) as i32;
    let rest = (quadrants << 2).cast_signed() >> 32;
    let rest = rest as i32 as f32 * (core::f32::consts::FRAC_PI_2 / 4_294_967_296.0);
    if angle < 0.0 { (-n, -rest) } else { (n, rest) }
}

/// The 64 digits of two words from index `digits` on, which is below 64.
fn window(high: u64, low: u64, digits: i32) -> u64 {
    if digits == 0 { high } else { high << digits | low >> (64 - digits) }
}

/// Tangent of an angle, rad; relative error below 4e-7 up to 1.5 rad.
#[inline]
pub(crate) fn tan(angle: f32) -> f32 {
    let (sine, cosine) = sin_cos(angle);
    sine / cosine
}

#[cfg(test)]
mod tests {
    use super::{atan2, exp, inverse_sqrt, ln, sin_cos, sqrt_above, tan};

    /// Every step-th number between two positive ones: their bits have the same order.
    fn numbers(from: f32, to: f32, step: usize) -> impl Iterator<Item = f32> {
        (from.to_bits()..=to.to_bits()).step_by(step).map(f32::from_bits)
    }

    #[test]
    fn exponentials() {
        let mut worst = 0.0_f64;
        for x in numbers(1e-9, 87.3, 257).flat_map(|x| [x, -x]) {
            let exact = f64::from(x).exp();
            worst = worst.max((f64::from(exp(x)) / exact - 1.0).abs());
        }
        std::println!("exp: relative error {worst:e}");
        assert!(worst < 1.5e-7, "{worst:e}");
        assert_eq!((exp(0.0), exp(f32::NEG_INFINITY), exp(f32::INFINITY)), (1.0, 0.0, f32::INFINITY));
        assert_eq!((exp(-200.0), exp(89.0)), (0.0, f32::INFINITY));
        assert!(exp(f32::NAN).is_nan());
        // Below the normal numbers the result is subnormal.
        assert!((f64::from(exp(-90.0)) / (-90.0_f64).exp() - 1.0).abs() < 1e-3 && exp(-103.0) > 0.0);
    }

    #[test]
    fn logarithms() {
        let mut worst = 0.0_f64;
        for x in numbers(f32::MIN_POSITIVE, 3e38, 997).chain(numbers(0.5, 2.0, 7)) {
            let exact = f64::from(x).ln();
            worst = worst.max((f64::from(ln(x)) - exact).abs() / exact.abs().max(1.0));
        }
        std::println!("ln: error {worst:e}");
        assert!(worst < 1.5e-7, "{worst:e}");
        assert_eq!((ln(1.0), ln(0.0), ln(f32::INFINITY)), (0.0, f32::NEG_INFINITY, f32::INFINITY));
        assert!(ln(-1.0).is_nan() && ln(f32::NAN).is_nan());
        assert!((f64::from(ln(1e-40)) - f64::from(1e-40_f32).ln()).abs() < 1e-5);
    }

    #[test]
    fn inverse_square_roots() {
        let mut worst = 0.0_f64;
        for x in numbers(f32::MIN_POSITIVE, 3e38, 997).chain(numbers(1.0, 4.0, 7)) {
            worst = worst.max((f64::from(inverse_sqrt(x)) * f64::from(x).sqrt() - 1.0).abs());
        }
        std::println!("1/√: relative error {worst:e}");
        for x in numbers(f32::MIN_POSITIVE, 3e38, 997).chain(numbers(1.0, 4.0, 7)) {
            let ratio = f64::from(sqrt_above(x)) / f64::from(x).sqrt();
            assert!((1.0..1.001).contains(&ratio), "{x}: {ratio}");
        }
        assert!(worst < 2e-7, "{worst:e}");
        assert_eq!((inverse_sqrt(0.0), inverse_sqrt(f32::INFINITY)), (f32::INFINITY, 0.0));
        assert!(inverse_sqrt(-1.0).is_nan() && inverse_sqrt(f32::NAN).is_nan());
        assert!((inverse_sqrt(1e-40) * 1e-20 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn angles() {
        let mut worst = 0.0_f64;
        for y in numbers(1e-4, 1e4, 9973).flat_map(|y| [y, -y]) {
            for x in [-300.0, -7.0, -1.0, -0.3, -1e-3, 0.0, 1e-3, 0.3, 1.0, 7.0, 300.0_f32] {
                let exact = f64::from(y).atan2(f64::from(x));
                worst = worst.max((f64::from(atan2(y, x)) - exact).abs());
            }
        }
        std::println!("atan2: error {worst:e}");
        assert!(worst < 3e-7, "{worst:e}");
        let pi = core::f32::consts::PI;
        assert_eq!((atan2(0.0, 1.0), atan2(0.0, -1.0), atan2(-0.0, -1.0)), (0.0, pi, -pi));
        assert_eq!((atan2(2.0, 0.0), atan2(-2.0, 0.0)), (pi / 2.0, -pi / 2.0));
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert!((atan2(f32::INFINITY, 1.0) - pi / 2.0).abs() < 2e-7);
        assert!(atan2(f32::NAN, 1.0).is_nan() && atan2(1.0, f32::NAN).is_nan());
        assert!((atan2(3e38, 3e38) - pi / 4.0).abs() < 1e-6);
    }

    #[test]
    fn sines_and_cosines() {
        let mut worst = 0.0_f64;
        for angle in numbers(1e-6, 4000.0, 409).flat_map(|angle| [angle, -angle]) {
            let (sine, cosine) = sin_cos(angle);
            let (exact_sine, exact_cosine) = f64::from(angle).sin_cos();
            worst = worst.max((f64::from(sine) - exact_sine).abs()).max((f64::from(cosine) - exact_cosine).abs());
        }
        std::println!("sine, cosine: error {worst:e}");
        assert!(worst < 1.5e-7, "{worst:e}");
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f32::INFINITY).0.is_nan() && sin_cos(f32::NAN).1.is_nan());
    }

    #[test]
    fn sines_and_cosines_of_large_angles() {
        let mut worst = 0.0_f64;
        // Powers of two use all digits of 2/π; the numbers next to them are both ends of every interval.
        let beside =
            (12..128).map(|power| 2.0_f32.powi(power)).flat_map(|x| [x, x.next_up(), x.next_down(), 1.999_999 * x]);
        for angle in numbers(4096.0, f32::MAX, 1009).chain(beside).flat_map(|angle| [angle, -angle]) {
            let (sine, cosine) = sin_cos(angle);
            let (exact_sine, exact_cosine) = f64::from(angle).sin_cos();
            worst = worst.max((f64::from(sine) - exact_sine).abs()).max((f64::from(cosine) - exact_cosine).abs());
        }
        std::println!("sine, cosine of large angles: error {worst:e}");
        assert!(worst < 1.5e-7, "{worst:e}");
    }

    #[test]
    fn tangents() {
        let mut worst = 0.0_f64;
        for angle in numbers(1e-9, 1.5, 409).flat_map(|angle| [angle, -angle]) {
            worst = worst.max((f64::from(tan(angle)) / f64::from(angle).tan() - 1.0).abs());
        }
        std::println!("tangent: relative error {worst:e}");
        assert!(worst < 4e-7, "{worst:e}");
        assert_eq!(tan(0.0), 0.0);
        assert!(tan(f32::INFINITY).is_nan() && tan(f32::NAN).is_nan());
    }
}
