//! Seeded random numbers that are the same on every machine.
//!
//! xoshiro256++ with a 64-bit seed, IEEE 754 arithmetic, and the logarithm, exponential and cosine of `libm`. General
//! distribution crates may use the platform's mathematics library, whose last bits differ between machines.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::f64::consts::PI;

#[derive(Debug, Clone)]
pub struct Noise {
    rng: Xoshiro256PlusPlus,
}

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self { rng: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    /// Uniform in (0, 1), ends excluded: an odd multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1_u64 << 52) as f64;
        ((self.rng.next_u64() >> 12) as f64 + 0.5) * STEP
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    /// Standard normal (Box and Muller); never beyond 8.6.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        radius * libm::cos(2.0 * PI * self.uniform())
    }

    pub fn happens(&mut self, p: f64) -> bool {
        self.uniform() < p
    }

    /// Poisson number with mean `mean` < 500 (Knuth: the number of uniform numbers whose product is above e^−mean).
    pub fn poisson(&mut self, mean: f64) -> usize {
        let floor = libm::exp(-mean);
        let mut product = self.uniform();
        let mut count = 0;
        while product > floor {
            product *= self.uniform();
            count += 1;
        }
        count
    }

    /// A random order of `items` (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            // `uniform` < 1, and lists are far shorter than 2⁵², so that the product is below last + 1.
            items.swap(last, (self.uniform() * (last + 1) as f64) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: usize = 200_000;

    fn moments(draw: impl FnMut(usize) -> f64) -> (f64, f64) {
        let values: Vec<f64> = (0..DRAWS).map(draw).collect();
        let mean = values.iter().sum::<f64>() / DRAWS as f64;
        (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / DRAWS as f64)
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut noise = Noise::new(1);
        let (mean, variance) = moments(|_| noise.normal());
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.015, "{mean} {variance}");
        let (mean, variance) = moments(|_| noise.between(-1.0, 3.0));
        assert!((mean - 1.0).abs() < 0.01 && (variance - 16.0 / 12.0).abs() < 0.015, "{mean} {variance}");
        let (mean, variance) = moments(|_| noise.poisson(20.0) as f64);
        assert!((mean - 20.0).abs() < 0.05 && (variance - 20.0).abs() < 0.3, "{mean} {variance}");
        let (mean, _) = moments(|_| f64::from(u8::from(noise.happens(0.95))));
        assert!((mean - 0.95).abs() < 0.002, "{mean}");
    }

    #[test]
    fn tails_are_normal() {
        let mut noise = Noise::new(2);
        let beyond = (0..DRAWS).filter(|_| noise.normal().abs() > 3.0).count() as f64 / DRAWS as f64;
        assert!((beyond - 0.0027).abs() < 0.0005, "{beyond}");
    }

    #[test]
    fn all_orders_are_equally_likely() {
        let mut noise = Noise::new(3);
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..60_000 {
            let mut items = [0, 1, 2];
            noise.shuffle(&mut items);
            *counts.entry(items).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|n| (9_500..10_500).contains(n)), "{counts:?}");
    }

    #[test]
    fn the_sequence_is_fixed() {
        let mut noise = Noise::new(42);
        let drawn = [noise.uniform(), noise.normal(), noise.poisson(20.0) as f64];
        let expected = [4605509828241559245, 4609453583164098785, 4626885667169763328];
        assert_eq!(drawn.map(f64::to_bits), expected, "committed figures depend on these bits");
    }
}
