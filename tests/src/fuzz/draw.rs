//! Random numbers for the fuzzer, determined by a seed; some of them are hostile.

use scphd::Real;

/// A stream of numbers (Steele, Lea & Flood 2014, `SplitMix64`).
#[derive(Debug, Clone)]
pub struct Draw {
    state: u64,
    /// Probability that a number is hostile.
    hostility: f64,
}

/// Numbers that a data link, a damaged byte or a division by zero may produce.
const HOSTILE: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f64::MIN_POSITIVE,
    5e-324,
    1e-40,
    -1e-45,
    1e-18,
    1e18,
    -1e18,
    1e30,
    3.402_823_4e38,
    -3.402_823_4e38,
    f64::MAX,
    f64::MIN,
    1e154,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    1e8,
    -1e8,
    4_294_967_296.0,
    std::f64::consts::PI,
];

impl Draw {
    pub fn new(seed: u64, hostility: f64) -> Self {
        Self { state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15), hostility }
    }

    /// A random 64-bit word.
    pub fn word(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.state;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    /// A number below `bound`, which is above zero.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.word() % bound as u64) as usize
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.even(0.0, 1.0) < probability
    }

    /// A uniform number from `low` to `high`, never hostile.
    pub fn even(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.word() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// A log-uniform number from `low` to `high`, both above zero, never hostile.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.even(low.ln(), high.ln()).exp()
    }

    /// A uniform number from `low` to `high`, or a hostile one.
    pub fn real<T: Real>(&mut self, low: f64, high: f64) -> T {
        let plausible = self.even(low, high);
        T::from_f64(self.spoilt(plausible))
    }

    /// This number, or a hostile one.
    pub fn spoilt(&mut self, plausible: f64) -> f64 {
        if !self.chance(self.hostility) {
            return plausible;
        }
        match self.below(4) {
            // A number that is almost the same, or of another magnitude.
            0 => plausible * (1.0 + f64::EPSILON),
            1 => plausible * 10.0_f64.powi(self.below(40) as i32 - 10),
            _ => HOSTILE[self.below(HOSTILE.len())],
        }
    }
}
