//! Ambiguity test: whether the measurements that are associated with a feature contradict each other.

use super::associations::{AssociationRow, probabilities};
use crate::models::noise_at;
use crate::{Pose, Real, Sensor, Zero};

/// An association is unambiguous if one measurement has at least this share of the feature's detections.
const SURE: f64 = 0.5;
/// Greatest mean squared Mahalanobis distance of the measurements from their mean, with the covariance of the sensor
/// noise: three standard deviations.
const APART: f64 = 9.0;

/// Whether the association of a feature is ambiguous: no measurement has at least half of its detections, and the
/// measurements differ by more than noise. A correction would move the feature to the mean of the measurements, where
/// none of them is, and the errors of such means are correlated from scan to scan. This happens after a time without
/// detections, when the gates are so large that they contain many landmarks.
pub(super) fn is_ambiguous<T: Real, S: Sensor<Pose: Pose<Scalar = T>>>(
    sensor: &S,
    table: &[AssociationRow<T>],
    index: usize,
    measurements: &[S::Measurement],
) -> bool {
    let mut surest: Option<(T, &S::Measurement)> = None;
    let mut detected = T::ZERO;
    for (probability, z) in probabilities(table, index, measurements) {
        detected += probability;
        if surest.is_none_or(|(most, _)| probability > most) {
            surest = Some((probability, z));
        }
    }
    let Some((probability, surest)) = surest else { return false };
    if probability >= detected * T::from_f64(SURE) {
        return false;
    }
    let Some(noise) = noise_at(sensor, surest).factor() else { return false };
    let (mut squares, mut mean) = (T::ZERO, S::Measurement::ZERO);
    for (probability, z) in probabilities(table, index, measurements) {
        let apart = sensor.innovation(z, surest);
        mean += apart * probability;
        squares += probability * noise.mahalanobis(&apart);
    }
    // (Σ s)² times the mean squared distance from the mean: Σ s · Σ s dᵀ R⁻¹ d − d̄ᵀ R⁻¹ d̄ with d̄ = Σ s d, and d the
    // difference from the most probable measurement.
    detected * squares - noise.mahalanobis(&mean) > detected * detected * T::from_f64(APART)
}

#[cfg(test)]
mod tests {
    use super::super::associations::{Association, AssociationRow};
    use super::is_ambiguous;
    use crate::RangeBearing;
    use nalgebra::Vector2;
    use std::vec::Vec;

    /// Whether the association is ambiguous for measurements with these ranges and bearings, σ = 0.1 m and 0.01 rad,
    /// and with these association probabilities of one feature.
    fn ambiguous(measurements: &[([f64; 2], f64)]) -> bool {
        let sensor = RangeBearing::new(0.1, 0.01).unwrap();
        let z: Vec<Vector2<f64>> = measurements.iter().map(|&(z, _)| Vector2::from(z)).collect();
        let table: Vec<AssociationRow<f64>> = measurements
            .iter()
            .map(|&(_, probability)| {
                let mut row = AssociationRow::ZERO;
                row.associate(Association { probability, ..Association::new(3, 0.0) });
                row
            })
            .collect();
        assert!(!is_ambiguous(&sensor, &table, 2, &z), "a feature without a share");
        is_ambiguous(&sensor, &table, 3, &z)
    }

    #[test]
    fn distant_measurements_without_a_dominant_one_are_ambiguous() {
        let thirds = |apart: f64| [([5.0 - apart, 1.0], 0.3), ([5.0, 1.0], 0.3), ([5.0 + apart, 1.0], 0.3)];
        // The variance of the ranges is 2/3 of the squared distance: 9 σ² at 0.367 m.
        assert!(ambiguous(&thirds(0.37)) && !ambiguous(&thirds(0.36)));
        // One measurement has half of all detections.
        assert!(!ambiguous(&[([4.0, 1.0], 0.2), ([5.0, 1.0], 0.4), ([6.0, 1.0], 0.2)]));
        assert!(ambiguous(&[([4.0, 1.0], 0.2), ([5.0, 1.0], 0.39), ([6.0, 1.0], 0.2)]));
        // One of two measurements always has at least half of all detections.
        assert!(!ambiguous(&[([4.0, 1.0], 0.5), ([6.0, 1.0], 0.5)]));
    }

    #[test]
    fn bearings_on_both_sides_of_pi_are_near_each_other() {
        let pi = core::f64::consts::PI;
        let around = |turn: f64| [([5.0, pi - turn], 0.3), ([5.0, turn - pi], 0.3), ([5.0, pi], 0.3)];
        assert!(!ambiguous(&around(0.036)) && ambiguous(&around(0.037)));
    }
}
