//! Map management: landmarks are initiated, merged and pruned.

use super::config::JointConfig;
use super::covariance::{Common, first};
use super::difference::{Closed, Difference};
use super::existence::Existence;
use super::movers::Movers;
use super::state::{Landmark, Memory};
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::product;
use crate::{Births, FieldOfView, Linear, Matrix, MeasurementModel, Pose, PositionOf, Real, Sensor, TangentOf, Vector};

/// Detections that a tentative feature has fewer of.
pub(super) const TENTATIVE: f64 = 1.5;
/// What is there with a lower probability is no loss: what was clutter stays for a while as what may be hidden.
const HARDLY_THERE: f64 = 0.01;

/// What births did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Initiated {
    /// New features.
    pub(super) births: usize,
    /// Measurements that could not give birth: no inverse, or out of view.
    pub(super) no_birth: usize,
    /// Births, or features in their place, for which there was no room.
    pub(super) lost: usize,
}

/// Adds a feature for every measurement that nothing explains well.
pub(super) fn initiate<T, X, Z, V>(
    models: &X,
    births: &Births<T>,
    config: &JointConfig<T>,
    memory: &mut Memory<'_, X::Pose, Z>,
    movers: &mut V,
    measurements: &[X::Measurement],
) -> Initiated
where
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    V: Movers<X::Pose>,
{
    let mut born = Initiated::default();
    let (ln_birth, ln_moving) = (births.of_static.ln(), births.of_moving.ln());
    let frame = models.sensor().frame(&memory.known.pose);
    for (index, z) in measurements.iter().enumerate() {
        let Some(explained) = memory.explained.get(index) else { break };
        let unexplained = explained.unexplained;
        let born_of = |ln_birth: T| (unexplained * (ln_birth - explained.ln_unexplained).exp()).at_most(T::ONE);
        // Where nothing at all explains a measurement, no share of it is known, but that none is of births that there are none of.
        let existence = if births.of_static == T::ZERO { T::ZERO } else { born_of(ln_birth) };
        let moving = if V::MOVE && births.of_moving > T::ZERO { born_of(ln_moving) } else { T::ZERO };
        if !(unexplained >= config.birth_share && existence + moving > T::ZERO) {
            continue;
        }
        let label = memory.known.next_label;
        memory.known.next_label = label.wrapping_add(1);
        let Some((mean, by_pose, own)) = invert(models, &frame, z) else {
            born.no_birth += 1;
            continue;
        };
        if let Some(mut tracks) = movers.tracks().filter(|_| moving > T::ZERO) {
            born.lost += tracks.initiate(label, moving, &mean, &own);
        }
        if !(existence > T::ZERO) {
            continue;
        }
        if memory.known.len == memory.landmarks.len() {
            match weakest(memory) {
                Some((place, total)) if total < existence => {
                    born.lost += usize::from(total >= T::from_f64(HARDLY_THERE));
                    memory.drop_feature(place);
                }
                _ => {
                    born.lost += 1;
                    continue;
                }
            }
        }
        let place = memory.known.len;
        let Some(slot) = memory.landmarks.get_mut(place) else { break };
        let existence = Existence::of(existence);
        *slot = Landmark { label, mean, existence, detections: existence.in_sight, ..Landmark::ZERO };
        memory.joint.add(&by_pose, &own, place);
        memory.known.len += 1;
        born.births += 1;
    }
    born
}

/// The feature that a measurement would be of, ∂m/∂x and the covariance that the measurement brings; `None` where it has no
/// inverse in view.
type Newborn<P> = (PositionOf<P>, Linear<PositionOf<P>, TangentOf<P>>, Linear<PositionOf<P>, PositionOf<P>>);

fn invert<T, X>(models: &X, frame: &X::Frame, z: &X::Measurement) -> Option<Newborn<X::Pose>>
where
    T: Real,
    X: MeasurementModel<Pose: Pose<Scalar = T>>,
{
    let inverse = models.sensor().invert(frame, z)?;
    let expected = models.sensor().expect(frame, &inverse.feature)?;
    let detection = models.field_of_view().detection_probability(frame, &inverse.feature, &expected.measurement);
    // h(m, x) = z: what moves the vehicle moves the feature so that the measurement stays.
    let by_pose = models.sensor().by_pose(frame, &inverse.feature, &expected);
    let by_pose = product::<PositionOf<X::Pose>, X::Measurement, TangentOf<X::Pose>>(&inverse.jacobian, &by_pose);
    let by_pose: Linear<PositionOf<X::Pose>, TangentOf<X::Pose>> = Matrix::with(|row, column| -by_pose.at(row, column));
    let own = models.sensor().noise().congruence::<PositionOf<X::Pose>>(&inverse.jacobian);
    let finite = by_pose.as_slice().iter().all(|x| x.is_finite());
    let usable = is_within_range(&inverse.feature) && is_within_square(&own) && finite;
    (detection > T::ZERO && usable).then_some((inverse.feature, by_pose, own.to_matrix()))
}

/// The feature that is there with the least probability.
fn weakest<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>) -> Option<(usize, T)> {
    let totals = memory.landmarks.iter().take(memory.known.len).map(|slot| slot.existence.total()).enumerate();
    totals.fold(None, |least, (place, total)| match least {
        Some((_, known)) if !(total < known) => least,
        _ => Some((place, total)),
    })
}

/// Drops features whose place, or whose variance, rounding or a model has spoilt, and keeps the pose's variances; how many.
pub(super) fn drop_spoilt<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(memory: &mut Memory<'_, P, Z>) -> usize {
    let mut spoilt = memory.joint.mend_pose(memory.known.len);
    for place in (0..memory.known.len).rev() {
        let (first, behind) = (first::<P>(place), first::<P>(place + 1));
        let usable = |variance: T| variance > T::ZERO && variance < T::INFINITY;
        let sound = memory.landmarks.get(place).is_some_and(|slot| is_within_range(&slot.mean))
            && (first..behind).all(|coordinate| usable(memory.joint.get(coordinate, coordinate)));
        if !sound {
            memory.drop_feature(place);
            spoilt += 1;
        }
    }
    spoilt
}

/// Drops what is hardly there, but for what was born in this scan and has labels from `first_label` on: that waits for the next.
pub(super) fn drop_unlikely<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
    first_label: u32,
) -> usize {
    let mut dropped = 0;
    for place in (0..memory.known.len).rev() {
        let Some(slot) = memory.landmarks.get(place) else { continue };
        // Labels wrap around, and loaded ones may be any.
        if slot.label.wrapping_sub(first_label) < memory.known.next_label.wrapping_sub(first_label) {
            continue;
        }
        let tentative = slot.detections < T::from_f64(TENTATIVE) && slot.detection > T::ZERO;
        let least = if tentative { config.least_tentative } else { config.least_existence };
        // Written so that NaN goes.
        if !(slot.existence.total() >= least.at_least(config.least_existence)) {
            memory.drop_feature(place);
            dropped += 1;
        }
    }
    dropped
}

/// Makes one of every two established features in view that are closer to each other than their covariances and one measurement could
/// tell: that they are one and the same is a measurement, m_i − m_j = 0, of which everything else learns. Of what may be clutter, nothing
/// is to be learnt: it goes of itself, for the other one has the greater share of what it would need to stay.
pub(super) fn merge<T, S, Z>(sensor: &S, config: &JointConfig<T>, memory: &mut Memory<'_, S::Pose, Z>) -> usize
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let mut merged = 0;
    let frame = sensor.frame(&memory.known.pose);
    let mut one = 0;
    while one < memory.known.len {
        let Some(slot) = memory.landmarks.get(one) else { break };
        // What one measurement from here would tell of its place.
        let alone = if is_established(slot) {
            let expected = sensor.expect(&frame, &slot.mean);
            let inverse = expected.and_then(|expected| sensor.invert(&frame, &expected.measurement));
            inverse.and_then(|inverse| sensor.noise().congruence::<PositionOf<S::Pose>>(&inverse.jacobian).factor())
        } else {
            None
        };
        if let Some(alone) = alone {
            let mean = slot.mean;
            let mut other = one + 1;
            while other < memory.known.len {
                let near = memory.landmarks.get(other).is_some_and(|slot| {
                    is_established(slot) && alone.mahalanobis(&(slot.mean - mean)) <= config.merge_distance
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

/// Whether a feature is in view, was detected twice, and is rather there than not.
fn is_established<T: Real, D: Vector<Scalar = T>>(slot: &Landmark<D>) -> bool {
    slot.detection > T::ZERO && slot.detections >= T::from_f64(TENTATIVE) && slot.existence.total() >= T::from_f64(0.5)
}

/// Makes `other` one with `one`, if their covariances let them be; whether it did.
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
    let closed = Closed::of::<P>(&apart.difference, &factor, &apart.heading);
    if !(closed.distance <= config.merge_distance) {
        return false;
    }
    let Memory { known, landmarks, joint, .. } = memory;
    let by: P::Tangent = closed.moves(joint, &apart, 0);
    known.pose = known.pose.displaced(&by);
    known.moved.iter_mut().zip(by.as_slice()).for_each(|(moved, &by)| *moved += by);
    for (place, slot) in landmarks.iter_mut().enumerate().take(known.len) {
        let by: P::Position = closed.moves(joint, &apart, first::<P>(place));
        slot.mean += by;
        slot.moved += by;
    }
    memory.reset_error_frame();
    for coordinate in 0..P::Position::DIMENSION {
        constrain_equal(memory, [one, other], coordinate);
    }
    if let Some(slot) = memory.landmarks.get_mut(one) {
        let (likelier, other) = if a.existence.total() >= b.existence.total() { (a, b) } else { (b, a) };
        slot.existence = likelier.existence;
        slot.detections = likelier.detections + other.detections;
        // Pages of the archive know their anchors by their labels.
        let of_first = if a.is_anchor == b.is_anchor { a.detections >= b.detections } else { a.is_anchor };
        slot.label = if of_first { a.label } else { b.label };
        slot.is_anchor = a.is_anchor || b.is_anchor;
    }
    memory.drop_feature(other);
    true
}

/// Takes in that coordinate `of` of two features is the same, which are where they are taken to be already.
fn constrain_equal<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
    places: [usize; 2],
    of: usize,
) {
    let Memory { known, joint, common, .. } = memory;
    let features = known.len;
    let [first, second] = places.map(|place| first::<P>(place) + of);
    // One coordinate of the measurement space carries it.
    let along = |value: T| Z::with(|z| if z == 0 { value } else { T::ZERO });
    let of_row = |row: usize| along(joint.get(row, first) - joint.get(row, second));
    let (at_first, at_second) = (of_row(first), of_row(second));
    let variance = (at_first - at_second).as_slice().iter().fold(T::ZERO, |sum, &x| sum + x);
    if !(variance > joint.get(first, first) * T::EPSILON) {
        return;
    }
    let mut common = Common::over(common);
    common.fill(features, of_row);
    let by = Matrix::with(|r, c| if r == 0 && c == 0 { -T::ONE / variance } else { T::ZERO });
    joint.add_product::<Z>(&common, &by, features);
}
