//! Who may have caused which measurement, by how much: the responsibilities s_jz.

use super::config::JointConfig;
use super::covariance::{Blocks, symmetric};
use super::exclusive::settle;
use super::state::{Claim, Memory};
use crate::{Clutter, Dim, FieldOfView, LnSum, Locating, Packed, Pose, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// What is expected of a feature, and how the innovation depends on pose and feature.
pub(super) struct Predicted<T, const K: usize, const D: usize, const Z: usize> {
    /// ẑ.
    pub(super) measurement: SVector<T, Z>,
    /// Hx = ∂h/∂x.
    pub(super) by_pose: SMatrix<T, Z, K>,
    /// Hm = ∂h/∂m.
    pub(super) by_feature: SMatrix<T, Z, D>,
}

impl<T: Real, const K: usize, const D: usize, const Z: usize> Predicted<T, K, D, Z> {
    /// Of a feature from there; `None` where it cannot be measured, or nothing finite is expected.
    pub(super) fn of<S: Locating<T, K, D, Z>>(sensor: &S, frame: &S::Frame, feature: &SVector<T, D>) -> Option<Self>
    where
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        let expected = sensor.expect(frame, feature)?;
        let by_pose = sensor.by_pose(frame, feature, &expected);
        let (measurement, by_feature) = (expected.measurement, expected.jacobian);
        let finite = measurement.iter().chain(by_pose.iter()).chain(by_feature.iter()).all(|x| x.is_finite());
        finite.then_some(Self { measurement, by_pose, by_feature })
    }

    /// S = Hx P_xx Hxᵀ + Hx P_xm Hmᵀ + Hm P_mx Hxᵀ + Hm P_mm Hmᵀ + R.
    fn innovation_covariance(&self, blocks: &Blocks<T, K, D>, noise: &Symmetric<T, Z>) -> Symmetric<T, Z>
    where
        Dim<Z>: Packed,
    {
        let mixed = self.by_feature * blocks.cross * self.by_pose.transpose();
        let own = self.by_feature * blocks.feature * self.by_feature.transpose();
        let full = self.by_pose * blocks.pose * self.by_pose.transpose() + own + mixed + mixed.transpose();
        symmetric(&full).plus(noise)
    }
}

/// The models of a sensor where it sits on the vehicle.
#[derive(Debug)]
pub(super) struct Models<'a, S, V, C> {
    pub(super) sensor: &'a S,
    pub(super) field_of_view: &'a V,
    pub(super) clutter: &'a C,
}

/// Fills in p_D of every feature in view and what explains every measurement; the features in view, and ln of the likelihood of the
/// scan.
pub(super) fn associate<T, P, S, V, C, const K: usize, const D: usize, const Z: usize, const Y: usize>(
    models: &Models<'_, S, V, C>,
    ln_birth: T,
    config: &JointConfig<T>,
    memory: &mut Memory<'_, T, P, K, D, Z>,
    measurements: &[SVector<T, Y>],
) -> (usize, T)
where
    T: Real,
    P: Pose<T, K>,
    S: Locating<T, K, D, Y, Pose = P>,
    V: FieldOfView<T, S::Frame, D, Y>,
    C: Clutter<T, Y>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<Y>: Packed,
{
    let Memory { known, slots, joint, explained, .. } = memory;
    let sensor = models.sensor;
    let frame = sensor.frame(&known.pose);
    for (slot, z) in explained.iter_mut().zip(measurements) {
        let ln_clutter = models.clutter.ln_intensity(z);
        // Written so that NaN is no clutter too.
        let ln_clutter = if ln_clutter < T::INFINITY { ln_clutter } else { T::NEG_INFINITY };
        let mut unexplained = LnSum::of(ln_clutter);
        unexplained.add(ln_birth);
        slot.start(unexplained.ln());
    }
    let (mut in_view, mut ln_missed) = (0, T::ZERO);
    for (place, slot) in slots.iter_mut().enumerate().take(known.len) {
        slot.detection = T::ZERO;
        let Some(predicted) = Predicted::of(sensor, &frame, &slot.mean) else { continue };
        let in_window = models.field_of_view.detection_probability(&frame, &slot.mean, &predicted.measurement);
        // Written so that NaN is out of view.
        if !(in_window > T::ZERO) {
            continue;
        }
        let hidden = measurements.iter().any(|z| sensor.hides(z, &predicted.measurement));
        let detection = if hidden { in_window * config.behind } else { in_window };
        slot.detection = detection.at_most(T::ONE - T::EPSILON);
        in_view += 1;
        let expected = slot.detection * slot.existence.in_sight;
        if !(expected > T::ZERO) {
            continue;
        }
        let ln_not_detected = (T::ONE - expected).ln();
        ln_missed += ln_not_detected;
        let covariance = predicted.innovation_covariance(&joint.blocks(place), sensor.noise());
        let Some(factor) = covariance.factor() else { continue };
        let ln_peak = expected.ln() - ln_not_detected + factor.ln_peak();
        for (explained, z) in explained.iter_mut().zip(measurements) {
            let distance = factor.mahalanobis(&sensor.innovation(z, &predicted.measurement));
            if distance <= config.gate {
                explained.claim(Claim::new(place as u16, ln_peak - distance * T::from_f64(0.5)));
            }
        }
    }
    let explained = explained.get_mut(..measurements.len()).unwrap_or(&mut []);
    let slots = slots.get_mut(..known.len).unwrap_or(&mut []);
    (in_view, settle(slots, explained, ln_missed))
}
