//! Spells in which something that is there is not detected.

use scphd_log::noise::Noise;

/// Spells of each that begin in a second.
const PER_SECOND: f64 = 0.01;

/// For every landmark the time until which it is hidden.
pub(crate) struct Spells {
    until_s: Vec<f64>,
    noise: Noise,
}

impl Spells {
    /// None yet, of so many landmarks.
    pub fn new(landmarks: usize, noise: Noise) -> Self {
        Self { until_s: vec![f64::NEG_INFINITY; landmarks], noise }
    }

    /// Those that begin in the time that has passed, each so long, s. Draws the same random numbers where there are to be none.
    pub fn begin(&mut self, t_s: f64, passed_s: f64, length_s: Option<f64>) {
        for until_s in &mut self.until_s {
            let begins = self.noise.happens(PER_SECOND * passed_s);
            if let Some(length_s) = length_s.filter(|_| begins) {
                *until_s = t_s + length_s;
            }
        }
    }

    /// Whether the landmark is hidden at that time.
    pub fn holds(&self, landmark: usize, t_s: f64) -> bool {
        self.until_s[landmark] > t_s
    }
}
