//! Gating: which landmarks may have caused which measurement, and with which likelihood. [Loopy belief
//! propagation](super::data_association) then computes the association probabilities s_jz.

use super::associations::Association;
use super::config::JointConfig;
use super::covariance::{Blocks, sandwiched, symmetric};
use super::data_association::marginals;
use super::landmark::Landmark;
use super::loop_closure::{exclude_weakly_determined, least_of};
use super::movers::Movers;
use super::state::{Header, Memory};
use crate::models::OwnNoise;
use crate::{
    Births, Clutter, FieldOfView, Linear, LnSum, Matrix, MeasurementModel, Pose, PositionOf, Real, ScalarOf, Sensor,
    Symmetric, TangentOf, Vector,
};
use nalgebra::SVector;

/// The predicted measurement of a feature, and its derivatives by pose and feature.
pub(super) struct Predicted<P: Pose, Y: Vector> {
    /// ẑ.
    pub(super) measurement: Y,
    /// Hx = ∂h/∂x.
    pub(super) by_pose: Linear<Y, TangentOf<P>>,
    /// Hm = ∂h/∂m.
    pub(super) by_feature: Linear<Y, PositionOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>, Y: Vector<Scalar = T>> Predicted<P, Y> {
    /// The prediction for a feature in a frame of the sensor; `None` if the feature cannot be measured, or if a number
    /// is not finite.
    pub(super) fn of<S>(sensor: &S, frame: &S::Frame, feature: &P::Position) -> Option<Self>
    where
        S: Sensor<Pose = P, Measurement = Y>,
    {
        let expected = sensor.expect(frame, feature)?;
        let by_pose = sensor.by_pose(frame, feature, &expected);
        let (measurement, by_feature) = (expected.measurement, expected.jacobian);
        let mut numbers = measurement.as_slice().iter().chain(by_pose.as_slice()).chain(by_feature.as_slice());
        let finite = numbers.all(|x| x.is_finite());
        finite.then_some(Self { measurement, by_pose, by_feature })
    }

    /// The prediction for a landmark that corrections may have moved, with the derivatives by the errors of which P is the
    /// covariance.
    pub(super) fn of_corrected<S>(
        sensor: &S,
        frame: &S::Frame,
        header: &Header<P>,
        landmark: &Landmark<P::Position>,
    ) -> Option<Self>
    where
        S: Sensor<Pose = P, Measurement = Y>,
    {
        let Self { measurement, by_pose, by_feature } = Self::of(sensor, frame, &landmark.mean)?;
        let by_pose = header.in_invariant_error::<Y>(&by_pose, &by_feature, landmark);
        Some(Self { measurement, by_pose, by_feature })
    }

    /// S − R = Hx P_xx Hxᵀ + Hx P_xm Hmᵀ + Hm P_mx Hxᵀ + Hm P_mm Hmᵀ.
    pub(super) fn covariance(&self, blocks: &Blocks<P>) -> Symmetric<Y> {
        let Self { by_pose, by_feature, .. } = self;
        let mixed = sandwiched::<Y, P::Position, P::Tangent>(by_feature, &blocks.cross, by_pose);
        let own = sandwiched::<Y, P::Position, P::Position>(by_feature, &blocks.feature, by_feature);
        let of_pose = sandwiched::<Y, P::Tangent, P::Tangent>(by_pose, &blocks.pose, by_pose);
        let full = of_pose + own + mixed + Matrix::with(|row, column| mixed.at(column, row));
        symmetric::<Y>(&full)
    }

    /// The prediction of one coordinate of the measurement.
    #[inline]
    pub(super) fn along(&self, k: usize) -> Predicted<P, SVector<T, 1>> {
        Predicted {
            measurement: Vector::with(|_| self.measurement.at(k)),
            by_pose: Matrix::with(|_, column| self.by_pose.at(k, column)),
            by_feature: Matrix::with(|_, column| self.by_feature.at(k, column)),
        }
    }
}

/// Whether the squared Mahalanobis distance is above the gate because ν²/S is along one coordinate, with S = `variance` of it. The
/// last factor exceeds rounding errors.
#[inline]
pub(super) fn is_beyond<T: Real>(innovation: T, variance: T, gate: T) -> bool {
    innovation * innovation > greatest_square(variance, gate)
}

/// The greatest ν² for which this is not so.
#[inline]
pub(super) fn greatest_square<T: Real>(variance: T, gate: T) -> T {
    gate * variance * (T::ONE + T::EPSILON * T::from_f64(16.0))
}

/// Results of the data association of a scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Associated<T> {
    /// Features in view, without the excluded landmarks.
    pub(super) in_view: usize,
    /// Landmarks that were excluded because they are weakly determined.
    pub(super) weak: usize,
    /// Expected detections of the excluded landmarks.
    pub(super) expected_of_weak: T,
    /// ln of the likelihood of the scan.
    pub(super) ln_evidence: T,
}

/// Computes p_D of every landmark, and the associations of every measurement. Weakly determined landmarks among the
/// first `window` are excluded.
pub(super) fn associate<
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    V: Movers<X::Pose>,
>(
    models: &X,
    births: &Births<T>,
    config: &JointConfig<T>,
    memory: &mut Memory<'_, X::Pose, Z>,
    movers: &mut V,
    measurements: &[X::Measurement],
    window: usize,
) -> Associated<T> {
    let Memory { header, landmarks, joint, association_table, .. } = memory;
    let sensor = models.sensor();
    let frame = sensor.frame(&header.pose);
    let ln_birth = births.of_static.ln();
    for (row, z) in association_table.iter_mut().zip(measurements) {
        row.start(ln_lambda(models, ln_birth, births, movers.are_tracked(), z));
    }
    let mut tracks = movers.tracks();
    if let Some(tracks) = &mut tracks {
        let landmarks = landmarks.get(..header.len).unwrap_or(&[]);
        tracks.predict_detection(models, &frame, measurements, config.occlusion_factor, landmarks);
    }
    // The innovation of a landmark that the last scan initiated would have the covariance 2 R + Hx W Hxᵀ, with W the
    // covariance that the motion since then has added. This bound is not used if no landmark can be initiated.
    let may_be_born = births.of_static > T::ZERO && header.len < landmarks.len();
    let newborn = sensor.noise().plus(sensor.noise());
    let ln_newborn = newborn.factor().filter(|_| may_be_born).map_or(T::NEG_INFINITY, |factor| factor.ln_peak());
    let ln_usual = sensor.noise().factor().map_or(T::ZERO, |factor| factor.ln_peak());
    let (mut in_view, mut ln_missed, mut ln_highest) = (0, T::ZERO, T::NEG_INFINITY);
    for (index, landmark) in landmarks.iter_mut().enumerate().take(header.len) {
        let seen = in_view_of(models, &frame, &landmark.mean, measurements, config.occlusion_factor);
        landmark.scratch = T::INFINITY;
        landmark.detection = seen.as_ref().map_or(T::ZERO, |&(_, detection)| detection);
        in_view += usize::from(seen.is_some());
        let expected = landmark.detection * landmark.existence.visible;
        // A moving-object track of the same object may be detected instead of the landmark.
        let neither = |moving: T| (T::ONE - expected - moving).at_least(T::EPSILON);
        let moving = tracks.as_mut().map_or(T::ZERO, |tracks| tracks.set_not_detected(index, neither));
        if !(expected + moving > T::ZERO) {
            continue;
        }
        let ln_not_detected = if moving > T::ZERO { neither(moving).ln() } else { (T::ONE - expected).ln() };
        ln_missed += ln_not_detected;
        let Some((predicted, _)) = seen.filter(|_| expected > T::ZERO) else { continue };
        let own = OwnNoise::of(sensor, &predicted.measurement, &predicted.measurement);
        let noise = own.as_ref().map_or(sensor.noise(), |own| &own.covariance);
        let covariance = predicted.covariance(&joint.blocks(index));
        let Some(factor) = covariance.plus(noise).factor() else { continue };
        // Landmarks with different noise R are compared by the ratio of the determinants of S and R.
        let scaled_peak = |ln_peak: T| own.as_ref().map_or(ln_peak, |own| ln_peak - own.factor.ln_peak() + ln_usual);
        ln_highest = ln_highest.at_least(scaled_peak(factor.ln_peak()));
        if index < window {
            // A landmark that may be a moving object instead keeps its associations.
            landmark.scratch = if moving > T::ZERO { T::INFINITY } else { scaled_peak(factor.ln_peak()) };
            if landmark.scratch < least_of::<X::Measurement>(ln_newborn) {
                let of_motion = header.motion_noise.congruence::<X::Measurement>(&predicted.by_pose);
                let here = of_motion.plus(&own.as_ref().map_or(newborn, |own| own.covariance.plus(&own.covariance)));
                let least = |ln_peak| least_of::<X::Measurement>(scaled_peak(ln_peak));
                if here.factor().is_some_and(|factor| landmark.scratch < least(factor.ln_peak())) {
                    landmark.scratch = T::NEG_INFINITY;
                }
            }
        }
        let ln_expected = expected.ln() - ln_not_detected;
        let ln_peak = ln_expected + factor.ln_peak();
        // The squared distance is at least ν²/S along the first coordinate, which excludes most measurements. The last factor
        // exceeds rounding errors.
        let sifts = X::Sensor::SIFTED_BY == Some(0) && own.is_none();
        let farthest =
            config.gate * (covariance.get(0, 0) + noise.get(0, 0)) * (T::ONE + T::EPSILON * T::from_f64(16.0));
        for (row, z) in association_table.iter_mut().zip(measurements) {
            let apart = z.at(0) - predicted.measurement.at(0);
            if sifts && apart * apart > farthest {
                continue;
            }
            let innovation = sensor.innovation(z, &predicted.measurement);
            let of_own_noise = OwnNoise::of(sensor, z, &predicted.measurement)
                .and_then(|own| covariance.plus(&own.covariance).factor());
            let (distance, ln_peak) = match of_own_noise {
                Some(own) => (own.mahalanobis(&innovation), ln_expected + own.ln_peak()),
                None => (factor.mahalanobis(&innovation), ln_peak),
            };
            if distance <= config.gate {
                row.associate(Association::new(index as u16, ln_peak - distance * T::from_f64(0.5)));
            }
        }
    }
    let table = association_table.get_mut(..measurements.len()).unwrap_or(&mut []);
    let landmarks = landmarks.get_mut(..header.len).unwrap_or(&mut []);
    let (weak, ln_missed_weak) = exclude_weakly_determined(landmarks, table, least_of::<X::Measurement>(ln_highest));
    ln_missed -= ln_missed_weak;
    if let Some(tracks) = &mut tracks {
        ln_missed += tracks.associate(models, &frame, measurements, config.gate, table);
    }
    let ln_evidence = marginals::<T, X::Pose, V>(landmarks, table, movers, ln_missed);
    // Σ p_D v is approximated by Σ −ln(1 − p_D v), which is accurate for small terms, and is at most the number of
    // landmarks.
    let expected_of_weak = (-ln_missed_weak).at_most(T::from_usize(weak));
    Associated { in_view: in_view - weak, weak, expected_of_weak, ln_evidence }
}

/// ln λ = ln( κ + w_b ) of a measurement, with `ln_birth` that of births of static features.
#[inline]
pub(super) fn ln_lambda<T, X>(models: &X, ln_birth: T, births: &Births<T>, are_tracked: bool, z: &X::Measurement) -> T
where
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
{
    let ln_clutter = models.clutter().ln_intensity(z);
    // The comparison is written so that NaN means no clutter.
    let ln_clutter = if ln_clutter < T::INFINITY { ln_clutter } else { T::NEG_INFINITY };
    let mut lambda = LnSum::of(ln_clutter);
    lambda.add(ln_birth);
    if are_tracked {
        lambda.add(births.of_moving.ln());
    }
    lambda.ln()
}

/// Result of [`in_view_of`].
type Seen<X> = (
    Predicted<<X as MeasurementModel>::Pose, <X as MeasurementModel>::Measurement>,
    ScalarOf<<X as MeasurementModel>::Pose>,
);

/// The predicted measurement of a feature, and p_D; `None` if the feature is not in view.
pub(super) fn in_view_of<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    models: &X,
    frame: &X::Frame,
    feature: &PositionOf<X::Pose>,
    measurements: &[X::Measurement],
    occlusion_factor: T,
) -> Option<Seen<X>> {
    let sensor = models.sensor();
    if !models.field_of_view().may_see(frame, feature) {
        return None;
    }
    let predicted = Predicted::of(sensor, frame, feature)?;
    let in_window = models.field_of_view().detection_probability(frame, feature, &predicted.measurement);
    // The comparison is written so that NaN is out of view.
    if !(in_window > T::ZERO) {
        return None;
    }
    let occluded = measurements.iter().any(|z| sensor.occludes(z, &predicted.measurement));
    let detection = if occluded { in_window * occlusion_factor } else { in_window };
    Some((predicted, detection.at_most(T::ONE - T::EPSILON)))
}
