//! Random numbers: the interface of the reference, and an own generator.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Source of random numbers. The caller supplies it, so that the reference and another filter can
/// run on the same numbers.
pub trait Draws {
    /// A standard normal number.
    fn normal(&mut self) -> f64;
    /// A number uniform in [0, 1).
    fn uniform(&mut self) -> f64;
}

/// The generator of `docs/recursion.md`: xoshiro128++, one 32-bit word for each number.
#[derive(Debug, Clone)]
pub struct OwnDraws {
    words: Xoshiro128PlusPlus,
}

impl OwnDraws {
    pub fn new(seed: u64) -> Self {
        Self { words: Xoshiro128PlusPlus::seed_from_u64(seed) }
    }
}

impl Draws for OwnDraws {
    fn normal(&mut self) -> f64 {
        let signed = self.words.next_u32().cast_signed();
        // 33 significant bits: p and 1 − p are exact, and neither is ever 0.
        inverse_normal((f64::from(signed) + 2f64.powi(31) + 0.5) / 2f64.powi(32))
    }

    fn uniform(&mut self) -> f64 {
        f64::from(self.words.next_u32() >> 8) / 2f64.powi(24)
    }
}

/// The x with Φ(x) = p, for 0 < p < 1.
///
/// Newton's method on ln Φ. Because ln Φ is concave and increasing, the iteration converges from any start, and no table of
/// coefficients is needed: the definition of the function is used. Only the lower half is solved, where Φ has full relative
/// precision.
fn inverse_normal(p: f64) -> f64 {
    if p > 0.5 {
        return -inverse_normal(1.0 - p);
    }
    let target = p.ln();
    let mut x = -(-2.0 * target).sqrt();
    loop {
        let distribution = 0.5 * libm::erfc(-x * FRAC_1_SQRT_2);
        let density = (-0.5 * x * x).exp() / TAU.sqrt();
        let step = (distribution.ln() - target) * distribution / density;
        x -= step;
        // Convergence is quadratic: the remaining error is far below the last bit.
        if step.abs() < 1e-10 {
            return x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_quantiles() {
        // Tabulated quantiles of the standard normal distribution.
        for (p, x) in [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.841_344_746_068_542_9, 1.0),
            (0.975, 1.959_963_984_540_054),
            (0.995, 2.575_829_303_548_901),
            (0.001, -3.090_232_306_167_814),
            (1e-6, -4.753_424_308_822_899),
            (1e-9, -5.997_807_015_007_687),
        ] {
            let found = inverse_normal(p);
            assert!((found - x).abs() < 2e-14 * (1.0 + x.abs()), "{p}: {found}");
        }
    }

    #[test]
    fn words_are_converted_as_documented() {
        let mut words = Xoshiro128PlusPlus::seed_from_u64(7);
        let mut draws = OwnDraws::new(7);
        for _ in 0..100 {
            let word = words.next_u32();
            // Adding 2³¹ to the signed value of a word inverts its top bit.
            let flipped = word ^ 0x8000_0000;
            let p = (f64::from(flipped) + 0.5) / 4_294_967_296.0;
            assert_eq!(draws.normal(), inverse_normal(p));
            let uniform = f64::from(words.next_u32() >> 8) / 16_777_216.0;
            assert_eq!(draws.uniform(), uniform);
        }
    }
}
