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

/// A hypothesis of the vehicle's pose in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located<T: Real> {
    /// The pose in the map, and its covariance.
    pub pose: PoseEstimate<PlanarPose<T>>,
    /// Its probability.
    pub probability: T,
    /// Landmarks of the vehicle that are associated with landmarks of the map.
    pub matched: usize,
}

/// Result of a scan of a locator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LocatorReport<T: Real> {
    /// The accepted pose of the vehicle, if there is one.
    pub found: Option<Located<T>>,
    /// The most probable pose, however improbable.
    pub likeliest: Option<Located<T>>,
    /// The probability that the vehicle is elsewhere: outside the map, or at a pose that was not tried yet.
    pub elsewhere: T,
    /// Number of pose hypotheses.
    pub hypotheses: usize,
    /// Landmarks detected by the vehicle.
    pub landmarks: usize,
    /// Landmarks that were left out because the memory is full.
    pub left_out: usize,
    /// Trial alignments in this scan: pairs of landmarks with pairs of the map.
    pub trials: usize,
    /// Pairs of landmarks that have been compared with all pairs of the map.
    pub searched: usize,
}

/// Global localisation: finds the pose of the vehicle in a map, in the plane.
///
/// The vehicle maps as usual, starting at an arbitrary pose: in a frame of its own. After every scan the locator gets the pose and
/// the landmarks in that frame and aligns them with the map. When one pose explains the landmarks and no other does, it is
/// accepted.
#[derive(Debug)]
pub struct Locator<'s, T: Real> {
    config: LocatorConfig<T>,
    memory: Memory<'s, T>,
}

impl<'s, T: Real> Locator<'s, T> {
    /// A locator that continues with the content of `state`; a new state needs a [map](Self::load_map) first.
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

    /// Loads a map and starts the search. The weight of a feature is its existence probability.
    ///
    /// # Errors
    /// A feature is not finite, beyond 1e8 m, or heavier than a million, or its covariance is not positive definite; or there are
    /// more features than the state has memory for. The locator is unchanged.
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

    /// Restarts the search, after the frame of the vehicle has changed.
    pub fn restart(&mut self) {
        self.memory.restart();
    }

    /// To be called after every scan, with the pose of the vehicle and the landmarks it has mapped, both in its own frame, and the
    /// detector of the scan. Landmarks should have been detected twice, with an existence probability above ½:
    /// [`JointSlam::features`](crate::JointSlam::features), or those written by
    /// [`ScPhd::estimate_map`](crate::ScPhd::estimate_map). Landmarks that are not finite or exceed the memory are left out; if the
    /// pose is not finite, nothing is found.
    pub fn update<X: MeasurementModel<Pose = PlanarPose<T>>, R>(
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
        memory.known.observed_area = memory.observed_area(&models);
        for place in (0..memory.known.hypotheses).rev() {
            let Some(alignment) = memory.hypotheses.get(place).map(|hypothesis| hypothesis.alignment) else { continue };
            memory.drop_hypothesis(place);
            if let Some(hypothesis) = memory.weigh(config, &models, &alignment) {
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
                mean: hypothesis.alignment.pose_in_map(&pose.mean, &memory.known.middle),
                covariance: hypothesis.alignment.covariance_in_map(&pose.mean, &pose.covariance),
            },
            probability: (hypothesis.ln_weight - ln_total).exp(),
            matched: hypothesis.matched,
        });
        let searched = memory.known.sweep.done;
        let sure = |place: &Located<T>| {
            let most = T::from_usize(place.matched) >= config.least_share * T::from_usize(memory.known.seen);
            let enough = place.matched >= config.least_matched && most && searched >= config.searched;
            // No result for a pose that is not finite, or far outside the map.
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

    /// Stores the landmarks of the vehicle. Returns the number that had no room.
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

    /// Removes a hypothesis; the last one moves into its slot.
    fn drop_hypothesis(&mut self, place: usize) {
        let last = self.known.hypotheses.saturating_sub(1);
        if last < self.hypotheses.len() && place <= last {
            self.hypotheses.swap(place, last);
            self.known.hypotheses = last;
        }
    }
}
