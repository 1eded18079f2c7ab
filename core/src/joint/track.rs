//! Moving-object tracks in a scan: they are associated with measurements together with the static landmarks, and corrected.
//!
//! Every birth may be static or moving: it is both a static feature of the joint map and a track with the same label, of which at
//! most one exists. Later scans decide which; until then both are associated with measurements as one object.

use super::associate::{Predicted, in_view_of, is_beyond};
use super::associations::{Association, AssociationRow, detected, probabilities};
use super::config::JointConfig;
use super::existence::MovingHypothesis;
use super::landmark::Landmark;
use super::movers::{MOVES, Mover, Movers, NONE, Tracks};
use super::state::Header;
use crate::map::reduce::{Near, heavier, moment_match};
use crate::models::noise_at;
use crate::numerics::range::is_within_range;
use crate::{
    Component, Correction, CovarianceOf, Factor, Linear, Matrix, MeasurementModel, MovingOf, Pose, PositionOf, Real,
    Sensor, Symmetric, Vector,
};
use nalgebra::SVector;

/// The predicted measurement of a track, and its covariance.
struct PredictedTrack<P: Pose, Y: Vector> {
    predicted: Predicted<P, Y>,
    /// R + Hx Q Hxᵀ, with Q the process noise of the vehicle since the last scan.
    noise: Symmetric<Y>,
    /// The factor of S = Hm P Hmᵀ + R + Hx Q Hxᵀ.
    factor: Factor<Y>,
}

impl<T: Real, P: Pose<Scalar = T>, Y: Vector<Scalar = T>> PredictedTrack<P, Y> {
    /// `None` if the track cannot be measured, or if rounding errors have made S invalid.
    fn of<S: Sensor<Pose = P, Measurement = Y>>(
        sensor: &S,
        frame: &S::Frame,
        component: &Component<MovingOf<P>>,
        process_noise: &CovarianceOf<P>,
    ) -> Option<Self> {
        let predicted = Predicted::of(sensor, frame, &component.position())?;
        let noise = noise_at(sensor, &predicted.measurement);
        Self::with(predicted, noise, &component.covariance.leading::<PositionOf<P>>(), process_noise)
    }

    /// Of a prediction, with R = `noise` and the covariance `place` of the position.
    fn with(
        predicted: Predicted<P, Y>,
        noise: Symmetric<Y>,
        place: &Symmetric<PositionOf<P>>,
        process_noise: &CovarianceOf<P>,
    ) -> Option<Self> {
        let noise = noise.plus(&process_noise.congruence::<Y>(&predicted.by_pose));
        let factor = place.congruence::<Y>(&predicted.by_feature).plus(&noise).factor()?;
        Some(Self { predicted, noise, factor })
    }
}

impl<T: Real, P: Pose<Scalar = T>> Tracks<'_, P> {
    /// Predicts all tracks over the time since the last scan, and drops those that are then unlikely or too uncertain.
    /// Returns the number of dropped tracks.
    pub(super) fn advance(&mut self, waited_s: T, least: T) -> usize {
        self.clamp();
        let motion = self.config.motion;
        if waited_s > T::ZERO {
            for mover in self.kept_mut() {
                match motion.advance::<PositionOf<P>>(&mover.component, waited_s) {
                    Some(component) => mover.component = component,
                    None => mover.component.ln_weight = T::NEG_INFINITY,
                }
            }
        }
        self.drop_unlikely(least)
    }

    /// Drops the tracks that are unlikely, too uncertain or out of range. Returns the number of dropped tracks.
    fn drop_unlikely(&mut self, least: T) -> usize {
        let spread = self.config.spread_max_m * self.config.spread_max_m;
        self.retain(|mover| {
            let Component { ln_weight, mean, covariance, .. } = &mover.component;
            let near = (0..PositionOf::<P>::DIMENSION).all(|axis| covariance.get(axis, axis) <= spread);
            near && is_within_range(mean) && ln_weight.is_finite() && mover.weight() >= least
        })
    }

    /// Sets p_D of every track, and the index of the static feature of the same object.
    pub(super) fn predict_detection<X: MeasurementModel<Pose = P>>(
        &mut self,
        models: &X,
        frame: &X::Frame,
        measurements: &[X::Measurement],
        occlusion_factor: T,
        landmarks: &[Landmark<PositionOf<P>>],
    ) {
        for mover in self.kept_mut() {
            (mover.detection, mover.not_detected, mover.message_sum, mover.static_index) =
                (T::ZERO, T::ONE, T::ZERO, NONE);
            let static_index = landmarks.iter().position(|landmark| landmark.label == mover.component.label);
            mover.static_index = static_index.map_or(NONE, |index| index as u16);
            if let Some(landmark) = static_index.and_then(|index| landmarks.get(index)) {
                // Merging may have made the sum of both probabilities greater than one.
                mover.component.ln_weight = mover.component.ln_weight.at_most(landmark.existence.absent.ln());
            }
            let seen = in_view_of(models, frame, &mover.component.position(), measurements, occlusion_factor);
            mover.detection = seen.map_or(T::ZERO, |(_, detection)| detection);
            if static_index.is_none() {
                mover.not_detected = (T::ONE - mover.detection * mover.weight()).at_least(T::EPSILON);
            }
        }
    }

    /// p_D w of the track of the same object as the static feature `index`; 0 without one. Sets the probability that
    /// the scan detects neither of the two to `of` this value.
    pub(super) fn set_not_detected(&mut self, index: usize, of: impl Fn(T) -> T) -> T {
        let mut tracks = self.kept_mut().iter_mut().filter(|mover| usize::from(mover.static_index) == index);
        let Some(mover) = tracks.next() else { return T::ZERO };
        let expected = mover.detection * mover.weight();
        mover.not_detected = of(expected);
        expected
    }

    /// Adds the associations of all tracks in view. Returns Σ ln(1 − p_D w) over the tracks without a static feature.
    pub(super) fn associate<X: MeasurementModel<Pose = P>>(
        &mut self,
        models: &X,
        frame: &X::Frame,
        measurements: &[X::Measurement],
        gate: T,
        table: &mut [AssociationRow<T>],
    ) -> T {
        let sensor = models.sensor();
        let process_noise = self.common.process_noise;
        let mut ln_missed = T::ZERO;
        for (index, mover) in self.kept().iter().enumerate() {
            let expected = mover.detection * mover.weight();
            if !(expected > T::ZERO) {
                continue;
            }
            let ln_not_detected = mover.not_detected.ln();
            if mover.static_index == NONE {
                ln_missed += ln_not_detected;
            }
            let Some(track) = PredictedTrack::of(sensor, frame, &mover.component, &process_noise) else { continue };
            let PredictedTrack { predicted, factor, .. } = track;
            let ln_peak = expected.ln() - ln_not_detected + factor.ln_peak();
            for (row, z) in table.iter_mut().zip(measurements) {
                let distance = factor.mahalanobis(&sensor.innovation(z, &predicted.measurement));
                if distance <= gate {
                    row.associate(Association::new(MOVES | index as u16, ln_peak - distance * T::from_f64(0.5)));
                }
            }
        }
        ln_missed
    }

    /// Corrects the tracks in view with a scan: a track becomes one Gaussian for all outcomes, corrected by each
    /// associated measurement or missed, and its probability w is updated. The process noise is then zero. With several
    /// hypotheses `causes` are the landmarks; landmarks and tracks then have the only measurement that they caused.
    pub(super) fn correct<S: Sensor<Pose = P>>(
        &mut self,
        sensor: &S,
        header: &Header<P>,
        table: &[AssociationRow<T>],
        measurements: &[S::Measurement],
        causes: Option<&[Landmark<PositionOf<P>>]>,
    ) {
        let frame = sensor.frame(&header.pose);
        let process_noise = self.common.process_noise;
        for (index, mover) in self.kept_mut().iter_mut().enumerate() {
            if !(mover.not_detected < T::ONE) {
                continue;
            }
            let (table, measurements) = match causes {
                Some(landmarks) => {
                    let landmark = landmarks.get(usize::from(mover.static_index));
                    of_cause(table, measurements, landmark, Some(mover))
                }
                None => (table, measurements),
            };
            let own = usize::from(MOVES) | index;
            let of_static = detected(table, usize::from(mover.static_index), measurements);
            let seen = detected(table, own, measurements);
            let missed = (T::ONE - seen - of_static).at_least(T::ZERO) / mover.not_detected;
            let ln_weight = (missed * mover.weight() * (T::ONE - mover.detection)).ln();
            let unseen = Component { ln_weight, ..mover.component };
            mover.component =
                corrected(sensor, &frame, &process_noise, unseen, || probabilities(table, own, measurements));
            mover.component.ln_weight = (seen + ln_weight.exp()).at_most(T::ONE).ln();
        }
        self.common.process_noise = Symmetric::ZERO;
    }

    /// Adds a track for a measurement, at rest with the standard deviation σ_v of the velocity. Returns the number of
    /// tracks that were lost because there was no room.
    pub(super) fn initiate(
        &mut self,
        label: u32,
        weight: T,
        position: &PositionOf<P>,
        covariance: &Linear<PositionOf<P>, PositionOf<P>>,
    ) -> usize {
        let velocity = self.config.velocity_sigma_mps * self.config.velocity_sigma_mps;
        let covariance =
            Symmetric::<MovingOf<P>>::from_fn(|row, column| match (row < PositionOf::<P>::DIMENSION, row == column) {
                (true, _) => covariance.at(row, column),
                (false, true) => velocity,
                (false, false) => T::ZERO,
            });
        let Some((covariance, _)) = covariance.kept_positive_definite() else { return 0 };
        let mean = MovingOf::<P>::with(|row| position.at(row));
        self.put(Component { label, ln_weight: weight.ln(), mean, covariance })
    }

    /// Merges every two tracks that are within the merging distance in position and velocity, by the covariance of each
    /// of the two, and drops unlikely tracks. Returns the number of merged pairs.
    pub(super) fn merge_and_prune(&mut self, config: &JointConfig<T>) -> usize {
        let mut united = 0;
        let mut one = 0;
        while one < self.common.len {
            let mut other = one + 1;
            while other < self.common.len {
                let (Some(a), Some(b)) = (self.movers.get(one).copied(), self.movers.get(other).copied()) else {
                    break;
                };
                let near =
                    |a: &Mover<P>, b: &Mover<P>| Near::of(&a.component, config.merge_distance).holds(&b.component.mean);
                if !(near(&a, &b) && near(&b, &a)) {
                    other += 1;
                    continue;
                }
                let (head, rest) = if heavier(&b.component, &a.component) { (b, a) } else { (a, b) };
                let component = moment_match(&head.component, core::iter::once(rest.component));
                let ln_weight = component.ln_weight.at_most(T::ZERO);
                if let Some(slot) = self.movers.get_mut(one) {
                    *slot = Mover { component: Component { ln_weight, ..component }, ..head };
                }
                self.drop_at(other);
                united += 1;
            }
            one += 1;
        }
        self.drop_unlikely(config.least_existence);
        united
    }
}

/// One Gaussian with the mean and covariance of all outcomes of a scan: the track `unseen`, which was missed, with its
/// weight, and its correction by each associated measurement, with the association probability as weight.
fn corrected<'m, T: Real, S: Sensor<Pose: Pose<Scalar = T>>, I: Iterator<Item = (T, &'m S::Measurement)>>(
    sensor: &S,
    frame: &S::Frame,
    process_noise: &CovarianceOf<S::Pose>,
    unseen: Component<MovingOf<S::Pose>>,
    probabilities: impl Fn() -> I,
) -> Component<MovingOf<S::Pose>>
where
    S::Measurement: 'm,
{
    let likeliest =
        probabilities().enumerate().fold(None, |most: Option<(usize, T)>, (index, (probability, _))| match most {
            Some((_, known)) if !(probability > known) => most,
            _ => Some((index, probability)),
        });
    let Some((likeliest, _)) = likeliest else { return unseen };
    let Some(track) = PredictedTrack::of(sensor, frame, &unseen, process_noise) else { return unseen };
    let PredictedTrack { predicted, noise, factor } = track;
    let correction = Correction::new(&unseen.covariance, &predicted.by_feature, &noise, &factor);
    let seen = |(probability, z): (T, &S::Measurement)| {
        correction.apply(&unseen, &sensor.innovation(z, &predicted.measurement), probability.ln())
    };
    let Some(head) = probabilities().nth(likeliest).map(seen) else { return unseen };
    if !(head.ln_weight > T::NEG_INFINITY) {
        return unseen;
    }
    let others =
        probabilities().enumerate().filter(|&(index, _)| index != likeliest).map(|(_, probability)| seen(probability));
    moment_match(&head, core::iter::once(unseen).chain(others))
}

/// A track in one coordinate of the measurement at a time.
pub(super) struct Along<'a, P: Pose, Y: Vector> {
    pub(super) predicted: &'a Predicted<P, Y>,
    /// Covariance of its position.
    pub(super) place: &'a Symmetric<PositionOf<P>>,
    /// R.
    pub(super) noise: &'a Symmetric<Y>,
    /// Q.
    pub(super) process_noise: &'a CovarianceOf<P>,
}

impl<T: Real, P: Pose<Scalar = T>, Y: Vector<Scalar = T>> Along<'_, P, Y> {
    /// The variance of the innovation.
    pub(super) fn variance(&self, k: usize) -> T {
        let Predicted { by_pose, by_feature, .. } = self.predicted.along(k);
        let of_pose = self.process_noise.congruence::<SVector<T, 1>>(&by_pose).get(0, 0);
        let of_place = self.place.congruence::<SVector<T, 1>>(&by_feature).get(0, 0);
        of_place + (self.noise.get(k, k) + of_pose)
    }
}

/// The log-likelihood of a measurement of this moving object; `None` beyond the gate.
pub(super) fn ln_density<T: Real, S: Sensor<Pose: Pose<Scalar = T>>>(
    sensor: &S,
    frame: &S::Frame,
    component: &Component<MovingOf<S::Pose>>,
    process_noise: &CovarianceOf<S::Pose>,
    z: &S::Measurement,
    gate: T,
) -> Option<T> {
    let predicted = Predicted::of(sensor, frame, &component.position())?;
    let innovation = sensor.innovation(z, &predicted.measurement);
    // One coordinate alone excludes most tracks, at a fraction of the cost.
    let (noise, place) =
        (noise_at(sensor, &predicted.measurement), component.covariance.leading::<PositionOf<S::Pose>>());
    let along = Along { predicted: &predicted, place: &place, noise: &noise, process_noise };
    let is_far = |k| is_beyond(innovation.at(k), along.variance(k), gate);
    if (0..S::Measurement::DIMENSION).any(is_far) {
        return None;
    }
    let PredictedTrack { factor, .. } = PredictedTrack::with(predicted, noise, &place, process_noise)?;
    let distance = factor.mahalanobis(&innovation);
    (distance <= gate).then(|| factor.ln_peak() - distance * T::from_f64(0.5))
}

/// Of the associations and measurements of a scan those of the measurement that a landmark or its track caused, if there is one;
/// only with several hypotheses.
pub(super) fn of_cause<'m, T: Real, P: Pose<Scalar = T>, Y>(
    table: &'m [AssociationRow<T>],
    measurements: &'m [Y],
    landmark: Option<&Landmark<PositionOf<P>>>,
    mover: Option<&Mover<P>>,
) -> (&'m [AssociationRow<T>], &'m [Y]) {
    // If both have one it is the same.
    let of_landmark = landmark.map_or(NONE, |landmark| landmark.measurement);
    let index = usize::from(mover.map_or(of_landmark, |mover| mover.measurement.min(of_landmark)));
    (table.get(index..=index).unwrap_or(&[]), measurements.get(index..=index).unwrap_or(&[]))
}

/// The hypothesis that the object of a static feature moves, after the association of a scan.
pub(super) fn moving_hypothesis<T: Real, P: Pose<Scalar = T>, V: Movers<P>, Y>(
    movers: &V,
    index: usize,
    table: &[AssociationRow<T>],
    measurements: &[Y],
) -> MovingHypothesis<T> {
    let track = movers.kept().iter().enumerate().find(|(_, mover)| usize::from(mover.static_index) == index);
    track.map_or(MovingHypothesis::NOTHING, |(own, mover)| MovingHypothesis {
        expected: mover.detection * mover.weight(),
        left: (T::ONE - mover.detection) * mover.weight(),
        detected: detected(table, usize::from(MOVES) | own, measurements),
    })
}
