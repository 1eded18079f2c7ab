//! The locator.

use super::config::LocatorConfig;
use super::evidence::area;
use super::state::{LocatorState, Memory, Sweep};
use crate::numerics::ln_sum::ln_sum;
use crate::numerics::range::is_within_range;
use crate::{
    Bounds, Component, ConfigError, Detector, LoadMapError, MeasurementModel, PlanarPose, Pose, PoseEstimate, Real,
};
use nalgebra::Vector2;

/// A place where the vehicle may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located<T: Real> {
    /// The pose in the map, and its covariance.
    pub pose: PoseEstimate<PlanarPose<T>>,
    /// The probability that it is there.
    pub probability: T,
    /// Landmarks that it has found and the map has.
    pub matched: usize,
}

/// What a locator knows after a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LocatorReport<T: Real> {
    /// Where the vehicle is, if that is sure.
    pub found: Option<Located<T>>,
    /// The likeliest place, however unlikely.
    pub likeliest: Option<Located<T>>,
    /// The probability that it is somewhere else: where the map has nothing, or where nobody has looked yet.
    pub elsewhere: T,
    /// Places that it may be at.
    pub hypotheses: usize,
    /// Landmarks that it has found.
    pub landmarks: usize,
    /// Landmarks for which there was no room.
    pub left_out: usize,
    /// Pairs of landmarks laid over pairs of the map in this scan.
    pub trials: usize,
    /// Pairs of landmarks that have been laid over all pairs of the map.
    pub searched: usize,
}

/// Finds the vehicle in a map, in the plane.
///
/// The vehicle maps as ever, from a pose that is anything: in a frame of its own. After every scan the locator is told the pose and the
/// landmarks in that frame, and lays them over the map. Where one place explains them, and no other does, the vehicle is
/// found.
#[derive(Debug)]
pub struct Locator<'s, T: Real> {
    config: LocatorConfig<T>,
    memory: Memory<'s, T>,
}

impl<'s, T: Real> Locator<'s, T> {
    /// A locator over a state, which keeps what it holds: a fresh one must be given a [map](Self::load_map) first.
    ///
    /// # Errors
    /// A field of the configuration is out of range.
    pub fn new<const FEATURES: usize, const HYPOTHESES: usize>(
        config: LocatorConfig<T>,
        state: &'s mut LocatorState<T, FEATURES, HYPOTHESES>,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config, memory: state.memory() })
    }

    /// Takes this map, and starts to look. The weight of a feature is the probability that it is there.
    ///
    /// # Errors
    /// A feature is not finite, beyond 1e8 m, heavier than a million or its covariance not positive definite; or there are more than the
    /// state holds. The locator is as it was.
    pub fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), LoadMapError> {
        let Memory { known, map, .. } = &mut self.memory;
        if features.len() > map.len() {
            return Err(LoadMapError::TooManyComponents { components: features.len(), capacity: map.len() });
        }
        if let Some(index) = features.iter().position(|feature| !feature.is_usable()) {
            return Err(LoadMapError::Component { index });
        }
        let mut bounds = Bounds::<Vector2<T>>::EMPTY;
        features.iter().for_each(|feature| bounds.include(&feature.mean));
        known.map = features.len();
        (known.middle, known.area) = if features.is_empty() {
            (Vector2::new(T::ZERO, T::ZERO), T::ZERO)
        } else {
            ((bounds.low + bounds.high) * T::from_f64(0.5), area(&bounds))
        };
        for (slot, feature) in map.iter_mut().zip(features) {
            *slot = Component { mean: feature.mean - known.middle, ..*feature };
        }
        self.memory.restart();
        Ok(())
    }

    /// Starts to look again: the vehicle's own frame is another one.
    pub fn restart(&mut self) {
        self.memory.restart();
    }

    /// After every scan: the vehicle's pose and the landmarks that it has found, both in its own frame, and the detector of the scan.
    /// Landmarks should have been detected twice, and be rather there than not:
    /// [`JointSlam::features`](crate::JointSlam::features), or what [`ScPhd::estimate_map`](crate::ScPhd::estimate_map) writes.
    /// Those that are not finite, or for which there is no room, are left out; with a pose that is not finite nothing is found.
    pub fn look<X: MeasurementModel<Pose = PlanarPose<T>>, R>(
        &mut self,
        detector: &Detector<X, R>,
        pose: &PoseEstimate<PlanarPose<T>>,
        landmarks: impl IntoIterator<Item = Component<Vector2<T>>>,
    ) -> LocatorReport<T> {
        let Self { config, memory } = self;
        let models = detector.on_vehicle();
        let left_out = memory.take(landmarks);
        if pose.mean.is_finite() {
            memory.known.views.add(&pose.mean);
        }
        memory.known.looked_at = memory.looked_at(&models);
        for place in (0..memory.known.hypotheses).rev() {
            let Some(laying) = memory.hypotheses.get(place).map(|hypothesis| hypothesis.laying) else { continue };
            memory.drop_hypothesis(place);
            if let Some(hypothesis) = memory.weigh(config, &models, &laying) {
                memory.keep(config, &hypothesis);
            }
        }
        let trials = memory.search(config, &models);
        let ln_elsewhere = config.elsewhere.ln();
        let ln_weights = memory.hypotheses().iter().map(|hypothesis| hypothesis.ln_weight);
        let ln_total = ln_sum(ln_weights.chain([ln_elsewhere]));
        let likeliest = memory.hypotheses().iter().reduce(|a, b| if b.ln_weight > a.ln_weight { b } else { a });
        let likeliest = likeliest.map(|hypothesis| Located {
            pose: PoseEstimate {
                mean: hypothesis.laying.pose_in_map(&pose.mean, &memory.known.middle),
                covariance: hypothesis.laying.covariance_in_map(&pose.mean, &pose.covariance),
            },
            probability: (hypothesis.ln_weight - ln_total).exp(),
            matched: hypothesis.matched,
        });
        let searched = memory.known.sweep.done;
        let sure = |place: &Located<T>| {
            let most = T::from_usize(place.matched) >= config.least_share * T::from_usize(memory.known.seen);
            let enough = place.matched >= config.least_matched && most && searched >= config.searched;
            // A vehicle whose own pose is no number, or that would be beyond every range of the map, is nowhere.
            let mean = &place.pose.mean;
            let placed = mean.is_finite() && is_within_range(&mean.coordinates()) && place.pose.covariance.is_finite();
            enough && placed && place.probability >= config.sure
        };
        LocatorReport {
            found: likeliest.filter(sure),
            likeliest,
            elsewhere: (ln_elsewhere - ln_total).exp(),
            hypotheses: memory.known.hypotheses,
            landmarks: memory.known.seen,
            left_out,
            trials,
            searched,
        }
    }
}

impl<T: Real> Memory<'_, T> {
    fn restart(&mut self) {
        let known = &mut self.known;
        (known.seen, known.hypotheses) = (0, 0);
        known.sweep = Sweep::NONE;
        known.views.clear(known.area.sqrt() * T::from_f64(0.05));
    }

    /// Takes the landmarks that the vehicle has found; how many had no room.
    fn take(&mut self, landmarks: impl IntoIterator<Item = Component<Vector2<T>>>) -> usize {
        let mut left_out = 0;
        self.known.seen = 0;
        for landmark in landmarks.into_iter().filter(Component::is_usable) {
            match self.seen.get_mut(self.known.seen) {
                Some(slot) => {
                    *slot = landmark;
                    self.known.seen += 1;
                }
                None => left_out += 1,
            }
        }
        left_out
    }

    /// Drops a hypothesis; the last one takes its place.
    fn drop_hypothesis(&mut self, place: usize) {
        let last = self.known.hypotheses.saturating_sub(1);
        if last < self.hypotheses.len() && place <= last {
            self.hypotheses.swap(place, last);
            self.known.hypotheses = last;
        }
    }
}
