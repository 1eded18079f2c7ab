//! The filter's own random stream: the same numbers on every machine, in bounded time.

use crate::Real;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Standard normal and uniform numbers from one xoshiro128++ stream.
///
/// Every number costs exactly one 32-bit word and a bounded number of operations: normal numbers come from
/// the inverse of the normal distribution function instead of a rejection method. An `f32` and an `f64`
/// filter with the same seed see the same noise up to rounding.
///
/// ```
/// use scphd::numerics::Noise;
///
/// let mut coarse = Noise::seeded(7);
/// let mut fine = coarse.clone();
/// let (a, b): (f32, f64) = (coarse.normal(), fine.normal());
/// assert!((f64::from(a) - b).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Noise {
    stream: Xoshiro128PlusPlus,
}

/// How many numbers the stream skips at once: more than take as long one by one.
const JUMPED: usize = 1024;
/// The coefficients of x¹⁰²⁴, x²⁰⁴⁸, … modulo the characteristic polynomial of a step of xoshiro128, from the lowest power.
const JUMPS: [u128; 7] = [
    0x5f7a_a4ff_503a_9ae6_94b5_4ba1_845a_09b1,
    0x780f_1aed_9ab5_cf0e_ece7_bc8e_0a1f_06b6,
    0xeb3e_4975_07ee_277a_d66b_4f59_8fcf_f8d3,
    0xc9d1_ce32_8b01_ce7b_60e1_6970_8a29_79a9,
    0xee62_62e1_3853_473d_57b8_e99a_d4fd_7b86,
    0x6681_40b3_a232_7f56_a1ea_4d71_7f08_61fd,
    0x4e27_1317_6d91_6ade_2fb4_4195_08a2_4926,
];

impl Noise {
    /// The stream of a seed.
    pub fn seeded(seed: u64) -> Self {
        Self { stream: Xoshiro128PlusPlus::seed_from_u64(seed) }
    }

    /// The 128 bits that determine all following numbers, for digests and snapshots.
    pub(crate) fn bytes(&self) -> [u8; 16] {
        self.stream.state()
    }

    /// The stream that continues from these bits.
    pub(crate) fn from_bytes(bytes: [u8; 16]) -> Self {
        Self { stream: Xoshiro128PlusPlus::from_seed(bytes) }
    }

    /// Skips this many numbers.
    pub fn skip(&mut self, numbers: usize) {
        let mut left = numbers;
        for (place, &jump) in JUMPS.iter().enumerate().rev() {
            while left >= JUMPED << place {
                self.jump(jump);
                left -= JUMPED << place;
            }
        }
        for _ in 0..left {
            self.stream.next_u32();
        }
    }

    /// Skips a power of two of numbers. Every step is linear in the state, so that this many are a polynomial of one step.
    fn jump(&mut self, polynomial: u128) {
        let (mut sum, mut left) = (0, polynomial);
        for _ in 0..u128::BITS {
            if left & 1 == 1 {
                sum ^= u128::from_le_bytes(self.bytes());
            }
            left >>= 1;
            self.stream.next_u32();
        }
        *self = Self::from_bytes(sum.to_le_bytes());
    }

    /// A uniform number in [0, 1): 24 random bits, exact in both precisions.
    pub fn uniform<T: Real>(&mut self) -> T {
        let bits = (self.stream.next_u32() >> 8) as i32;
        T::from_i32(bits) * T::from_f64(1.0 / 16_777_216.0)
    }

    /// A standard normal number; |x| ≤ 6.4.
    pub fn normal<T: Real>(&mut self) -> T {
        inverse_normal(self.stream.next_u32() as i32)
    }
}

/// The standard normal quantile at p = (k + 2³¹ + ½)/2³² (M. J. Wichura, algorithm AS 241, PPND16, Applied
/// Statistics 37, 1988; relative error about 1e-16 in `f64`, rounding in `f32`).
fn inverse_normal<T: Real>(k: i32) -> T {
    let c = T::from_f64;
    let scale = c(1.0 / 4_294_967_296.0);
    // p − ½ and the distance of p from the nearer end are computed from integers: a subtraction in T would lose the digits of the
    // tail, and round p to 1 in single precision.
    let q = (T::from_i32(k) + c(0.5)) * scale;
    if q.abs() <= c(0.425) {
        let r = c(0.180625) - q * q;
        return q * ratio(r, &CENTRE);
    }
    let to_end = if k < 0 { k.wrapping_sub(i32::MIN) } else { i32::MAX - k };
    let tail = (T::from_i32(to_end) + c(0.5)) * scale;
    // The third range of AS 241 begins at r = 5; 32 bits reach only r = 4.79.
    let magnitude = ratio((-tail.ln()).sqrt() - c(1.6), &MIDDLE);
    if k < 0 { -magnitude } else { magnitude }
}

/// Numerator and denominator of a rational function, from the lowest power.
struct Ratio([f64; 8], [f64; 8]);

fn ratio<T: Real>(x: T, coefficients: &Ratio) -> T {
    let horner = |c: &[f64; 8]| c.iter().rev().fold(T::ZERO, |sum, &coefficient| sum * x + T::from_f64(coefficient));
    horner(&coefficients.0) / horner(&coefficients.1)
}

const CENTRE: Ratio = Ratio(
    [
        3.387_132_872_796_366_5, 1.331_416_678_917_843_8e2, 1.971_590_950_306_551_3e3, 1.373_169_376_550_946e4,
        4.592_195_393_154_987e4, 6.726_577_092_700_87e4, 3.343_057_558_358_813e4, 2.509_080_928_730_122_7e3,
    ],
    [
        1.0, 4.231_333_070_160_091e1, 6.871_870_074_920_579e2, 5.394_196_021_424_751e3, 2.121_379_430_158_659_7e4,
        3.930_789_580_009_271e4, 2.872_908_573_572_194_3e4, 5.226_495_278_852_545e3,
    ],
);

const MIDDLE: Ratio = Ratio(
    [
        1.423_437_110_749_683_5, 4.630_337_846_156_546, 5.769_497_221_460_691, 3.647_848_324_763_204_5,
        1.270_458_252_452_368_4, 2.417_807_251_774_506e-1, 2.272_384_498_926_918_4e-2, 7.745_450_142_783_414e-4,
    ],
    [
        1.0, 2.053_191_626_637_759, 1.676_384_830_183_803_8, 6.897_673_349_851e-1, 1.481_039_764_274_800_8e-1,
        1.519_866_656_361_645_7e-2, 5.475_938_084_995_345e-4, 1.050_750_071_644_416_9e-9,
    ],
);

#[cfg(test)]
mod tests {
    use super::{Noise, inverse_normal};

    /// The word whose quantile has a probability nearest to `p`.
    fn word(p: f64) -> i32 {
        (p * 4_294_967_296.0 - 0.5 - 2_147_483_648.0).round() as i32
    }

    #[test]
    fn agrees_with_known_quantiles() {
        // Standard normal table; the tolerance is that of a 32-bit probability.
        let cases = [
            (0.5, 0.0, 1e-9),
            (0.841_344_746_068_542_9, 1.0, 1e-9),
            (0.977_249_868_051_820_8, 2.0, 1e-8),
            (0.001_349_898_031_630_094_6, -3.0, 1e-7),
            (0.999_968_328_758_166_9, 4.0, 1e-6),
        ];
        for (p, quantile, tolerance) in cases {
            let x: f64 = inverse_normal(word(p));
            assert!((x - quantile).abs() < tolerance, "{p}: {x}");
        }
        // 2⁻³³, the outermost value.
        let outermost: f64 = inverse_normal(i32::MIN);
        assert!((outermost + 6.338).abs() < 2e-3, "{outermost}");
    }

    #[test]
    fn is_odd_and_agrees_in_both_precisions() {
        for k in [0, 1, 1000, 1 << 20, 1 << 29, 0x3f00_0000, i32::MAX - 70_000, i32::MAX - 1, i32::MAX] {
            let x: f64 = inverse_normal(k);
            let mirrored: f64 = inverse_normal(-1 - k);
            assert_eq!(x, -mirrored);
            let single: f32 = inverse_normal(k);
            assert!((f64::from(single) - x).abs() <= 2e-6 * (1.0 + x.abs()), "{k}: {single} {x}");
        }
    }

    #[test]
    fn skipping_has_the_effect_of_drawing() {
        for numbers in [0, 5, 1024, 3000, 300_000] {
            let mut noise = Noise::seeded(3);
            let mut other = noise.clone();
            for k in 0..numbers {
                let _: f32 = if k % 2 == 0 { noise.normal() } else { noise.uniform() };
            }
            other.skip(numbers);
            assert_eq!(other, noise);
        }
    }

    #[test]
    fn a_stream_continues_from_its_bits() {
        let mut noise = Noise::seeded(3);
        let _: [f32; 100] = core::array::from_fn(|_| noise.normal());
        let mut other = Noise::from_bytes(noise.bytes());
        assert_eq!(other, noise);
        assert_eq!(other.normal::<f64>(), noise.normal::<f64>());
    }

    #[test]
    fn moments_are_those_of_the_normal_distribution() {
        let mut noise = Noise::seeded(1);
        let n = 200_000;
        let (mut m1, mut m2, mut m4, mut u1) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let x: f64 = noise.normal();
            m1 += x;
            m2 += x * x;
            m4 += x * x * x * x;
            u1 += noise.uniform::<f64>();
        }
        let n = f64::from(n);
        // Five standard errors each.
        assert!((m1 / n).abs() < 5.0 / n.sqrt());
        assert!((m2 / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((m4 / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
        assert!((u1 / n - 0.5).abs() < 5.0 / (12.0 * n).sqrt());
    }
}
