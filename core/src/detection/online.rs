//! Learning while running how often features are detected, and how much clutter there is.
//!
//! The models state p_D and κ; here a factor for either is learnt from what the heaviest particle sees. Detections are counted of
//! confirmed features that were there before the scan, so that a feature that is gone is missed but once, and clutter is what no
//! feature explains. Both counts fade, and start as if the models had been right for a while.

use crate::models::is_rate;
use crate::settings::config::ADAPTIVE;
use crate::{ConfigError, Real};

/// What is learnt while running.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Online<T> {
    /// Scans after which 1/e is left of what was learnt of p_D. Zero: the model's p_D is taken as it is.
    pub detection_memory: T,
    /// The same of κ; needs clutter whose [rate](crate::Clutter::per_scan) is known.
    pub clutter_memory: T,
}

impl<T: Real> Online<T> {
    /// Nothing.
    pub const NONE: Self = Self { detection_memory: T::ZERO, clutter_memory: T::ZERO };

    /// The first field that is out of range, if any.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let memory = |scans: T, field| {
            let holds = scans == T::ZERO || (scans >= T::ONE && scans.is_finite());
            if holds { Ok(()) } else { Err(ConfigError { field, range: "0, or at least 1" }) }
        };
        memory(self.detection_memory, "online.detection_memory")?;
        memory(self.clutter_memory, "online.clutter_memory")
    }

    /// Whether anything is learnt.
    pub(crate) fn learns(&self) -> bool {
        self.detection_memory > T::ZERO || self.clutter_memory > T::ZERO
    }
}

/// Events that the models have been right about before the first one: what a single scan can do is bounded.
const PRIOR: f64 = 10.0;
/// A factor is at least this, and at most its inverse.
const LEAST: f64 = 0.05;
/// No feature is taken for detected more certainly than this, unless the model is surer.
const SUREST: f64 = 0.99;

/// Events that happened, and how many the model had expected, both fading: with a prior of its own a Gamma distribution of
/// their ratio. For a p_D that is the same everywhere, p_D times its mean is that of p_D's Beta distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ratio<T> {
    pub(crate) happened: T,
    pub(crate) expected: T,
}

impl<T: Real> Ratio<T> {
    pub(crate) const ZERO: Self = Self { happened: T::ZERO, expected: T::ZERO };

    /// How many times as many as expected.
    fn mean(&self) -> T {
        let prior = T::from_f64(PRIOR);
        let mean = (prior + self.happened) / (prior + self.expected);
        mean.at_least(T::from_f64(LEAST)).at_most(T::from_f64(1.0 / LEAST))
    }

    /// Takes in one scan.
    fn learn(&mut self, scan: Self, memory: T) {
        if memory > T::ZERO && scan.happened.is_finite() && scan.expected.is_finite() {
            let kept = (-(T::ONE / memory)).exp();
            self.happened = self.happened * kept + scan.happened;
            self.expected = self.expected * kept + scan.expected;
        }
    }
}

/// What has been learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Learnt<T> {
    /// Of detections.
    pub(crate) detections: Ratio<T>,
    /// Of false measurements.
    pub(crate) clutter: Ratio<T>,
}

impl<T: Real> Learnt<T> {
    /// Nothing.
    pub(crate) const ZERO: Self = Self { detections: Ratio::ZERO, clutter: Ratio::ZERO };

    /// Whether this may have been learnt.
    pub(crate) fn is_in_range(&self) -> bool {
        let learnt = [self.detections, self.clutter];
        let mut numbers = learnt.iter().flat_map(|ratio| [ratio.happened, ratio.expected]);
        numbers.all(|number| number >= T::ZERO && number.is_finite())
    }

    /// The factor of p_D; exactly 1 where it is not learnt.
    pub(crate) fn detection_scale(&self, online: &Online<T>) -> T {
        if ADAPTIVE && online.detection_memory > T::ZERO { self.detections.mean() } else { T::ONE }
    }

    /// The factor of κ; exactly 1 where it is not learnt.
    pub(crate) fn clutter_scale(&self, online: &Online<T>) -> T {
        if ADAPTIVE && online.clutter_memory > T::ZERO { self.clutter.mean() } else { T::ONE }
    }

    /// Takes in what one scan showed.
    pub(crate) fn learn(&mut self, seen: &Shown<T>, clutter_per_scan: T, online: &Online<T>) {
        self.detections.learn(seen.detections, online.detection_memory);
        if clutter_per_scan > T::ZERO && is_rate(clutter_per_scan) {
            let clutter = Ratio { happened: seen.clutter, expected: clutter_per_scan };
            self.clutter.learn(clutter, online.clutter_memory);
        }
    }
}

/// p_D with the factor that was learnt, and below 1: at 1 a missed component would weigh nothing, and its logarithm be −∞.
#[inline]
pub(crate) fn scaled<T: Real>(detection: T, scale: T) -> T {
    let learnt =
        if ADAPTIVE { (detection * scale).at_most(detection.at_least(T::from_f64(SUREST))) } else { detection };
    learnt.at_most(T::ONE - T::EPSILON)
}

/// What one scan showed to one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shown<T> {
    /// Of the features that were there, detected and expected by the model.
    pub(crate) detections: Ratio<T>,
    /// Expected number of measurements that are clutter, Σ_z κ/η_z.
    pub(crate) clutter: T,
}

#[cfg(all(test, feature = "adaptive"))]
mod tests {
    use super::{Ratio, scaled};

    #[test]
    fn the_mean_is_that_of_a_beta_distribution_and_fades_to_the_prior() {
        // p_D = 0.8, 50 detections in 100 opportunities: Beta(10 + 50, 2.5 + 50), the prior ten detections in 12.5.
        let mut ratio = Ratio { happened: 50.0_f64, expected: 80.0 };
        assert!((0.8 * ratio.mean() - (10.0 + 50.0) / (10.0 / 0.8 + 100.0)).abs() < 1e-15);
        let nothing = Ratio { happened: 0.0, expected: 0.0 };
        (0..10).for_each(|_| ratio.learn(nothing, 10.0));
        assert!((ratio.happened - 50.0 * (-1.0_f64).exp()).abs() < 1e-12);
        (0..1000).for_each(|_| ratio.learn(nothing, 10.0));
        assert!((ratio.mean() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_number_leaves_its_range() {
        let mut ratio = Ratio { happened: 0.0_f32, expected: 0.0 };
        ratio.learn(Ratio { happened: f32::NAN, expected: 1.0 }, 10.0);
        assert_eq!(ratio, Ratio::ZERO);
        (0..1000).for_each(|_| ratio.learn(Ratio { happened: 0.0, expected: 50.0 }, 1e6));
        assert_eq!(ratio.mean(), 0.05);
        assert_eq!((scaled(0.9_f32, 20.0), scaled(0.999, 20.0), scaled(0.5, 0.5)), (0.99, 0.999, 0.25));
        assert_eq!((scaled(0.123_f32, 1.0), scaled(1.0_f32, 1.0)), (0.123, 1.0 - f32::EPSILON));
    }
}
