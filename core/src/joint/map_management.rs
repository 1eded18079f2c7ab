//! Map management: landmarks are initiated, merged and pruned.

use super::config::JointConfig;
use super::covariance::first;
use super::difference::{Difference, Fusion};
use super::existence::Existence;
use super::landmark::Landmark;
use super::movers::Movers;
use super::state::Memory;
use crate::models::noise_at;
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::product;
use crate::{
    Births, FieldOfView, Linear, Matrix, MeasurementModel, Pose, PositionOf, Real, Sensor, Serial, TangentOf, Vector,
};

/// A landmark with fewer detections than this is tentative.
pub(super) const TENTATIVE_BELOW: f64 = 1.5;
/// Dropping a landmark with a lower probability of existence is not reported as a loss: it is probably clutter, which
/// stays in the map for some time because it may be an occluded landmark.
const NEGLIGIBLE_EXISTENCE: f64 = 0.01;

/// Counts of landmark initiation.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Initiated {
    /// New landmarks.
    pub(super) births: usize,
    /// Measurements that could not initiate a landmark: without an inverse, or out of view.
    pub(super) no_birth: usize,
    /// Landmarks for which there was no room: new ones, or less likely ones that were dropped for them.
    pub(super) lost: usize,
}

/// Initiates a landmark from every measurement that no landmark caused with a probability of at least `birth_probability_min`.
pub(super) fn initiate<
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
) -> Initiated {
    let mut initiated = Initiated::default();
    let (ln_birth, ln_moving) = (births.of_static.ln(), births.of_moving.ln());
    let frame = models.sensor().frame(&memory.header.pose);
    // The least likely landmark of a full map, until one is dropped.
    let mut least = None;
    for (z_index, z) in measurements.iter().enumerate() {
        let Some(row) = memory.association_table.get(z_index) else { break };
        let no_feature_probability = row.no_feature_probability;
        let birth_probability =
            |ln_birth: T| (no_feature_probability * (ln_birth - row.ln_lambda).exp()).at_most(T::ONE);
        // If λ is zero the quotient w_b/λ is undefined; without births the landmark's probability of existence is zero.
        let existence = if births.of_static == T::ZERO { T::ZERO } else { birth_probability(ln_birth) };
        let moving =
            if movers.are_tracked() && births.of_moving > T::ZERO { birth_probability(ln_moving) } else { T::ZERO };
        if !(no_feature_probability >= config.birth_probability_min && existence + moving > T::ZERO) {
            continue;
        }
        let label = memory.header.next_label;
        memory.header.next_label = label.wrapping_add(1);
        let Some((mean, by_pose, own)) = invert(models, &frame, z) else {
            initiated.no_birth += 1;
            continue;
        };
        if let Some(mut tracks) = movers.tracks().filter(|_| moving > T::ZERO) {
            initiated.lost += tracks.initiate(label, moving, &mean, &own);
        }
        if !(existence > T::ZERO) {
            continue;
        }
        if memory.header.len == memory.landmarks.len() {
            least = least.or_else(|| least_likely(memory));
            match least {
                Some((index, total)) if total < existence => {
                    least = None;
                    initiated.lost += usize::from(total >= T::from_f64(NEGLIGIBLE_EXISTENCE));
                    memory.drop_feature(index);
                }
                _ => {
                    initiated.lost += 1;
                    continue;
                }
            }
        }
        let index = memory.header.len;
        let Some(landmark) = memory.landmarks.get_mut(index) else { break };
        let existence = Existence::of(existence);
        *landmark = Landmark { label, mean, existence, detections: existence.visible, ..Landmark::ZERO };
        memory.joint.add(&by_pose, &own, index);
        memory.header.len += 1;
        initiated.births += 1;
    }
    initiated
}

/// Position of a new landmark, ∂m/∂x, and the covariance H* R H*ᵀ from the measurement's noise.
type InitialLandmark<P> = (PositionOf<P>, Linear<PositionOf<P>, TangentOf<P>>, Linear<PositionOf<P>, PositionOf<P>>);

/// The landmark that a measurement initiates; `None` without an inverse, or if the position is out of view.
fn invert<T, X>(models: &X, frame: &X::Frame, z: &X::Measurement) -> Option<InitialLandmark<X::Pose>>
where
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
{
    let inverse = models.sensor().invert(frame, z)?;
    let expected = models.sensor().expect(frame, &inverse.feature)?;
    let detection = models.field_of_view().detection_probability(frame, &inverse.feature, &expected.measurement);
    // From h(m, x) = z by implicit differentiation: ∂m/∂x = −H* ∂h/∂x.
    let by_pose = models.sensor().by_pose(frame, &inverse.feature, &expected);
    let by_pose = product::<PositionOf<X::Pose>, X::Measurement, TangentOf<X::Pose>>(&inverse.jacobian, &by_pose);
    let by_pose: Linear<PositionOf<X::Pose>, TangentOf<X::Pose>> = Matrix::with(|row, column| -by_pose.at(row, column));
    let own = noise_at(models.sensor(), z).congruence::<PositionOf<X::Pose>>(&inverse.jacobian);
    let finite = by_pose.as_slice().iter().all(|x| x.is_finite());
    let usable = is_within_range(&inverse.feature) && is_within_square(&own) && finite;
    (detection > T::ZERO && usable).then_some((inverse.feature, by_pose, own.to_matrix()))
}

/// The landmark with the least probability of existence.
fn least_likely<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>) -> Option<(usize, T)> {
    let totals = memory.landmarks.iter().take(memory.header.len).map(|landmark| landmark.existence.total()).enumerate();
    totals.fold(None, |least, (index, total)| match least {
        Some((_, known)) if !(total < known) => least,
        _ => Some((index, total)),
    })
}

/// Repairs the variances of the pose, and drops landmarks whose position or variance is invalid, because of rounding or
/// an invalid value of a model. Returns the number of repairs and dropped landmarks.
pub(super) fn drop_degenerate<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
) -> usize {
    let mut invalid = memory.joint.repair_pose(memory.header.len);
    for index in (0..memory.header.len).rev() {
        let (first, behind) = (first::<P>(index), first::<P>(index + 1));
        let usable = |variance: T| variance > T::ZERO && variance < T::INFINITY;
        let sound = memory.landmarks.get(index).is_some_and(|landmark| is_within_range(&landmark.mean))
            && (first..behind).all(|coordinate| usable(memory.joint.get(coordinate, coordinate)));
        if !sound {
            memory.drop_feature(index);
            invalid += 1;
        }
    }
    invalid
}

/// Drops landmarks with a low probability of existence, except those of this scan, whose labels begin with `first_label`.
pub(super) fn drop_unlikely<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
    first_label: u32,
) -> usize {
    let mut dropped = 0;
    for index in (0..memory.header.len).rev() {
        let Some(landmark) = memory.landmarks.get(index) else { continue };
        // Labels wrap around, and loaded landmarks may have any label.
        if landmark.label.wrapping_sub(first_label) < memory.header.next_label.wrapping_sub(first_label) {
            continue;
        }
        let tentative = landmark.detections < T::from_f64(TENTATIVE_BELOW) && landmark.detection > T::ZERO;
        let least = if tentative { config.least_tentative } else { config.least_existence };
        // Written so that a landmark with NaN is dropped.
        if !(landmark.existence.total() >= least.at_least(config.least_existence)) {
            memory.drop_feature(index);
            dropped += 1;
        }
    }
    dropped
}

/// Fuses every two landmarks in view whose difference is insignificant, both by the covariance of one measurement and
/// by its own covariance. Their equality is a measurement m_i − m_j = 0 without noise, which corrects the whole state.
/// Tentative landmarks may be clutter and are not fused; a tentative duplicate is dropped later, because the other
/// landmark has the greater association probabilities.
pub(super) fn merge<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    config: &JointConfig<T>,
    memory: &mut Memory<'_, S::Pose, Z>,
) -> usize {
    let mut merged = 0;
    let frame = sensor.frame(&memory.header.pose);
    let mut one = 0;
    while one < memory.header.len {
        let Some(landmark) = memory.landmarks.get(one) else { break };
        // The covariance of the position from one measurement at the present pose.
        let single_measurement = if is_mergeable(landmark) {
            let expected = sensor.expect(&frame, &landmark.mean);
            expected.and_then(|expected| {
                let inverse = sensor.invert(&frame, &expected.measurement)?;
                noise_at(sensor, &expected.measurement).congruence::<PositionOf<S::Pose>>(&inverse.jacobian).factor()
            })
        } else {
            None
        };
        if let Some(single_measurement) = single_measurement {
            let mean = landmark.mean;
            let mut other = one + 1;
            while other < memory.header.len {
                let near = memory.landmarks.get(other).is_some_and(|landmark| {
                    is_mergeable(landmark)
                        && single_measurement.mahalanobis(&(landmark.mean - mean)) <= config.merge_distance
                });
                if near && fuse(config, memory, one, other) {
                    merged += 1;
                } else {
                    other += 1;
                }
            }
        }
        one += 1;
    }
    merged
}

/// Whether a landmark is in view, was detected twice, and exists with a probability of at least one half.
fn is_mergeable<T: Real, D: Vector<Scalar = T>>(landmark: &Landmark<D>) -> bool {
    landmark.detection > T::ZERO
        && landmark.detections >= T::from_f64(TENTATIVE_BELOW)
        && landmark.existence.total() >= T::from_f64(0.5)
}

/// Fuses `other` into `one` if they are within the merging distance. Returns whether they were.
pub(super) fn fuse<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
    one: usize,
    other: usize,
) -> bool {
    let (Some(a), Some(b)) = (memory.landmarks.get(one).copied(), memory.landmarks.get(other).copied()) else {
        return false;
    };
    let Some(apart) = Difference::of(memory, [one, other]) else { return false };
    let Some(factor) = apart.factor() else { return false };
    let fusion = Fusion::of::<P>(&apart.difference, &factor, &apart.heading);
    if !(fusion.distance <= config.merge_distance) {
        return false;
    }
    let Memory { header, landmarks, joint, .. } = memory;
    let by: P::Tangent = fusion.moves(joint, &apart, 0);
    header.pose = header.pose.displaced(&by);
    header.moved.iter_mut().zip(by.as_slice()).for_each(|(moved, &by)| *moved += by);
    for (index, landmark) in landmarks.iter_mut().enumerate().take(header.len) {
        let by: P::Position = fusion.moves(joint, &apart, first::<P>(index));
        landmark.mean += by;
        landmark.moved += by;
    }
    memory.reset_error_frame(&Serial);
    for coordinate in 0..P::Position::DIMENSION {
        constrain_equal(memory, [one, other], coordinate);
    }
    if let Some(landmark) = memory.landmarks.get_mut(one) {
        let (likelier, other) = if a.existence.total() >= b.existence.total() { (a, b) } else { (b, a) };
        landmark.existence = likelier.existence;
        landmark.detections = likelier.detections + other.detections;
        // Archived submaps refer to their anchors by label.
        let of_first = if a.is_anchor == b.is_anchor { a.detections >= b.detections } else { a.is_anchor };
        landmark.label = if of_first { a.label } else { b.label };
        landmark.is_anchor = a.is_anchor || b.is_anchor;
    }
    memory.drop_feature(other);
    true
}

/// Updates the covariance with the constraint that coordinate `of` of two landmarks is equal. Their means are equal already.
fn constrain_equal<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
    indices: [usize; 2],
    of: usize,
) {
    let Memory { header, joint, pending, .. } = memory;
    let features = header.len;
    let [first, second] = indices.map(|index| first::<P>(index) + of);
    // The first coordinate of `Z` has the value, the others are zero.
    let along = |value: T| Z::with(|z| if z == 0 { value } else { T::ZERO });
    let of_row = |row: usize| along(joint.get(row, first) - joint.get(row, second));
    let (at_first, at_second) = (of_row(first), of_row(second));
    let variance = (at_first - at_second).as_slice().iter().fold(T::ZERO, |sum, &x| sum + x);
    if !(variance > joint.get(first, first) * T::EPSILON) {
        return;
    }
    pending.fill(features, of_row);
    pending.push(&Matrix::with(|r, c| if r == 0 && c == 0 { -T::ONE / variance } else { T::ZERO }));
    joint.apply(pending, features, &Serial);
}
