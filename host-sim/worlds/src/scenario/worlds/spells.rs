//! Intervals in which a landmark is not detected.

use scphd_log::noise::Noise;

/// Rate of such intervals for each landmark, 1/s.
const PER_SECOND: f64 = 0.01;

/// For every landmark the time until which it is not detected.
pub(crate) struct Spells {
    until_s: Vec<f64>,
    noise: Noise,
}

impl Spells {
    /// No intervals, for this number of landmarks.
    pub fn new(landmarks: usize, noise: Noise) -> Self {
        Self { until_s: vec![f64::NEG_INFINITY; landmarks], noise }
    }

    /// Begins intervals of this length, s, in the time that has passed. Uses the same number of random numbers without a length.
    pub fn begin(&mut self, t_s: f64, passed_s: f64, length_s: Option<f64>) {
        for until_s in &mut self.until_s {
            let begins = self.noise.happens(PER_SECOND * passed_s);
            if let Some(length_s) = length_s.filter(|_| begins) {
                *until_s = t_s + length_s;
            }
        }
    }

    /// Whether the landmark is in such an interval at this time.
    pub fn holds(&self, landmark: usize, t_s: f64) -> bool {
        self.until_s[landmark] > t_s
    }
}
