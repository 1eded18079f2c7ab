//! The likeliest causes of a measurement in one hypothesis. Those that were chosen are stored in the landmarks and tracks.

use super::super::associate::{Predicted, in_view_of, is_beyond};
use super::super::config::JointConfig;
use super::super::innovation_statistics::LEAST_DETECTED;
use super::super::movers::{MOVES, Movers, NONE};
use super::super::state::Memory;
use super::super::track::ln_density;
use super::best::Best;
use super::gated::Gated;
use crate::models::OwnNoise;
use crate::{LnSum, MeasurementModel, Pose, Real, ScalarOf, Sensor, Vector};

/// Most landmarks that a hypothesis considers as the cause of a measurement.
pub(super) const CAUSES: usize = 3;

/// The cause of a measurement. A static landmark and the track of the same object are one cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cause<T> {
    /// Index of the landmark, or [`NONE`].
    pub(super) landmark: u16,
    /// Index of the track, or [`NONE`].
    pub(super) mover: u16,
    /// The probability that it is the landmark and not the track.
    pub(super) share: T,
}

impl<T: Real> Cause<T> {
    /// Clutter, or a new landmark.
    pub(super) const NEW: Self = Self { landmark: NONE, mover: NONE, share: T::ZERO };

    /// Whether pose and map are corrected.
    pub(super) fn corrects(&self) -> bool {
        self.landmark != NONE && self.share >= T::from_f64(LEAST_DETECTED)
    }

    /// Associates the landmark with the first measurement.
    pub(super) fn associate<P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(&self, memory: &mut Memory<'_, P, Z>) {
        if let Some(row) = memory.association_table.first_mut() {
            row.clear();
            row.add_certain(self.landmark, self.share);
        }
    }

    /// Stores this cause of a measurement of the present scan in the landmark and the track.
    pub(super) fn store<P: Pose<Scalar = T>, Z: Vector<Scalar = T>, V: Movers<P>>(
        &self,
        measurement: usize,
        memory: &mut Memory<'_, P, Z>,
        movers: &mut V,
    ) {
        if let Some(landmark) = memory.landmarks.get_mut(usize::from(self.landmark)) {
            (landmark.measurement, landmark.scratch) = (measurement as u16, self.share);
        }
        if let Some(mover) = movers.tracks().and_then(|tracks| tracks.movers.get_mut(usize::from(self.mover))) {
            mover.measurement = measurement as u16;
        }
    }
}

/// Starts a scan, of which no measurement has a cause so far: computes p_D of all landmarks and tracks. Returns the number of
/// landmarks in view, and ln of the probability that nothing is detected. Weakly determined landmarks are not excluded: that one
/// of them caused a measurement is a hypothesis of its own.
pub(super) fn start<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<X::Pose>>(
    models: &X,
    occlusion_factor: T,
    memory: &mut Memory<'_, X::Pose, Z>,
    movers: &mut V,
    measurements: &[X::Measurement],
) -> (usize, T) {
    let frame = models.sensor().frame(&memory.header.pose);
    let landmarks = memory.landmarks.get_mut(..memory.header.len).unwrap_or(&mut []);
    let mut tracks = movers.tracks();
    if let Some(tracks) = &mut tracks {
        tracks.predict_detection(models, &frame, measurements, occlusion_factor, landmarks);
        tracks.kept_mut().iter_mut().for_each(|mover| mover.measurement = NONE);
    }
    let (mut in_view, mut ln_missed) = (0, T::ZERO);
    for (index, landmark) in landmarks.iter_mut().enumerate() {
        let seen = in_view_of(models, &frame, &landmark.mean, measurements, occlusion_factor);
        in_view += usize::from(seen.is_some());
        landmark.detection = seen.map_or(T::ZERO, |(_, detection)| detection);
        let expected = landmark.detection * landmark.existence.visible;
        let neither = |moving: T| (T::ONE - expected - moving).at_least(T::EPSILON);
        let moving = tracks.as_mut().map_or(T::ZERO, |tracks| tracks.set_not_detected(index, neither));
        (landmark.measurement, landmark.scratch) = (NONE, neither(moving).ln());
        ln_missed += landmark.scratch;
    }
    let alone = movers.kept().iter().filter(|mover| mover.static_index == NONE);
    (in_view, alone.fold(ln_missed, |sum, mover| sum + mover.not_detected.ln()))
}

/// Adds the stored causes to the rows of their measurements in the association table.
pub(super) fn fill<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>, V: Movers<P>>(
    memory: &mut Memory<'_, P, Z>,
    movers: &V,
) {
    let Memory { header, landmarks, association_table, .. } = memory;
    let mut add = |measurement: u16, feature, probability| {
        if let Some(row) = association_table.get_mut(usize::from(measurement)) {
            row.add_certain(feature, probability);
        }
    };
    let landmarks = landmarks.get(..header.len).unwrap_or(&[]);
    for (landmark, index) in landmarks.iter().zip(0..) {
        add(landmark.measurement, index, landmark.scratch);
    }
    for (mover, index) in movers.kept().iter().zip(0..) {
        let of_static = landmarks.get(usize::from(mover.static_index));
        let share = of_static.filter(|landmark| landmark.measurement == mover.measurement);
        add(mover.measurement, MOVES | index, T::ONE - share.map_or(T::ZERO, |landmark| landmark.scratch));
    }
}

/// The likeliest causes of a measurement among old landmarks and tracks, with ln( p_D v N(z; ẑ, S) / (1 − p_D v) ), without those
/// that caused earlier measurements: a landmark causes at most one measurement. p_D of all landmarks and tracks must be that of
/// this scan; only the pairs in `gated` are examined.
pub(super) fn causes_of<
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    V: Movers<X::Pose>,
>(
    models: &X,
    config: &JointConfig<T>,
    memory: &Memory<'_, X::Pose, Z>,
    movers: &V,
    gated: &Gated,
    measurement: usize,
    z: &X::Measurement,
) -> Best<Cause<T>, T, CAUSES> {
    let mut causes = Best::new(CAUSES, Cause::NEW);
    let sensor = models.sensor();
    let frame = sensor.frame(&memory.header.pose);
    let ln_moving = |index: u16| {
        let mover = movers.kept().get(usize::from(index)).filter(|mover| mover.detection > T::ZERO)?;
        let (common, _) = movers.common()?;
        let ln_density = ln_density(sensor, &frame, &mover.component, &common.process_noise, z, config.gate)?;
        let expected = mover.detection * mover.weight();
        (expected > T::ZERO).then(|| expected.ln() + ln_density)
    };
    for (index, landmark) in memory.landmarks.iter().enumerate().take(memory.header.len) {
        if !(gated.has_pair(index, measurement) && landmark.may_be_cause()) {
            continue;
        }
        let ln_not_detected = landmark.scratch;
        let mover = track_of(movers, index);
        if movers.kept().get(usize::from(mover)).is_some_and(|mover| mover.measurement != NONE) {
            continue;
        }
        let expected = landmark.detection * landmark.existence.visible;
        let mut cause = Cause { landmark: index as u16, mover, share: T::ONE };
        let ln_static = of_static::<T, X, Z>(sensor, &frame, memory, index, z, config.gate);
        let ln_static = ln_static.filter(|_| expected > T::ZERO).map(|ln| expected.ln() + ln);
        let ln_moving = ln_moving(mover);
        if ln_static.is_none() && ln_moving.is_none() {
            continue;
        }
        let mut both = LnSum::EMPTY;
        ln_static.into_iter().chain(ln_moving).for_each(|ln| both.add(ln));
        match (ln_static, ln_moving) {
            (None, _) => cause.share = T::ZERO,
            (Some(_), None) => cause.mover = NONE,
            (Some(ln), Some(_)) => cause.share = (ln - both.ln()).exp().at_most(T::ONE),
        }
        if cause.share == T::ZERO {
            cause.landmark = NONE;
        }
        causes.add(cause, both.ln() - ln_not_detected);
    }
    for (index, mover) in movers.kept().iter().enumerate().filter(|(_, mover)| mover.static_index == NONE) {
        let cause = Cause { landmark: NONE, mover: index as u16, share: T::ZERO };
        if gated.has_pair(index, measurement)
            && mover.may_be_cause()
            && let Some(ln) = ln_moving(cause.mover)
        {
            causes.add(cause, ln - mover.not_detected.ln());
        }
    }
    causes
}

/// Index of the track of the same object as a landmark, or [`NONE`].
fn track_of<P: Pose, V: Movers<P>>(movers: &V, index: usize) -> u16 {
    let is_this = |landmark: u16| landmark != NONE && usize::from(landmark) == index;
    movers.kept().iter().position(|mover| is_this(mover.static_index)).map_or(NONE, |index| index as u16)
}

/// ln of the density of a measurement, if this landmark causes it; `None` beyond the gate.
fn of_static<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &X::Sensor,
    frame: &<X::Sensor as Sensor>::Frame,
    memory: &Memory<'_, X::Pose, Z>,
    index: usize,
    z: &X::Measurement,
    gate: ScalarOf<X::Pose>,
) -> Option<T> {
    let landmark = memory.landmarks.get(index)?;
    let predicted = Predicted::of_corrected(sensor, frame, memory.header, landmark)?;
    let innovation = sensor.innovation(z, &predicted.measurement);
    let own = OwnNoise::of(sensor, z, &predicted.measurement);
    let noise = own.as_ref().map_or(sensor.noise(), |own| &own.covariance);
    let blocks = memory.joint.blocks(index);
    let variance = |k| predicted.along(k).covariance(&blocks).get(0, 0) + noise.get(k, k);
    let is_far = |k| is_beyond(innovation.at(k), variance(k), gate);
    // One coordinate alone excludes most landmarks, at a fraction of the cost.
    if (0..X::Measurement::DIMENSION).any(is_far) {
        return None;
    }
    let factor = predicted.covariance(&blocks).plus(noise).factor()?;
    let distance = factor.mahalanobis(&innovation);
    (distance <= gate).then(|| factor.ln_peak() - distance * T::from_f64(0.5))
}
