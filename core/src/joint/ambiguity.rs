//! Whether a feature's measurements can be told from each other.

use super::associations::{AssociationRow, probabilities};
use crate::{Pose, Real, Sensor, Zero};

/// No measurement has as much of a feature's detections.
const SURE: f64 = 0.5;
/// Mean squared Mahalanobis distance of measurements to their mean, by the noise: three standard deviations.
const APART: f64 = 9.0;

/// Whether the measurements that a feature has a share of lie apart by more than noise, and none is its own. Their mean, which is what it
/// would be corrected to, is then the place of none of them; and scan after scan of such means are no independent errors. After a
/// time without a detection, many landmarks are within the gate of each.
pub(super) fn is_ambiguous<T, S>(
    sensor: &S,
    table: &[AssociationRow<T>],
    index: usize,
    measurements: &[S::Measurement],
) -> bool
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
{
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
    let Some(noise) = sensor.noise().factor() else { return false };
    let (mut squares, mut mean) = (T::ZERO, S::Measurement::ZERO);
    for (probability, z) in probabilities(table, index, measurements) {
        let apart = sensor.innovation(z, surest);
        mean += apart * probability;
        squares += probability * noise.mahalanobis(&apart);
    }
    // Σ s · Σ s dᵀ R⁻¹ d − d̄ᵀ R⁻¹ d̄, with d from the surest one.
    detected * squares - noise.mahalanobis(&mean) > detected * detected * T::from_f64(APART)
}

#[cfg(test)]
mod tests {
    use super::super::associations::{Association, AssociationRow};
    use super::is_ambiguous;
    use crate::RangeBearing;
    use nalgebra::Vector2;
    use std::vec::Vec;

    /// With σ = 0.1 m and 0.01 rad, of measurements with these ranges and bearings and the shares that one feature has of them.
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
    fn three_far_apart_are_two_near_or_with_a_sure_one_are_not() {
        let thirds = |apart: f64| [([5.0 - apart, 1.0], 0.3), ([5.0, 1.0], 0.3), ([5.0 + apart, 1.0], 0.3)];
        // Their variance is 2/3 of the squared distance: 9 σ² at 0.367 m.
        assert!(ambiguous(&thirds(0.37)) && !ambiguous(&thirds(0.36)));
        // One that has half of what there is.
        assert!(!ambiguous(&[([4.0, 1.0], 0.2), ([5.0, 1.0], 0.4), ([6.0, 1.0], 0.2)]));
        assert!(ambiguous(&[([4.0, 1.0], 0.2), ([5.0, 1.0], 0.39), ([6.0, 1.0], 0.2)]));
        // Two have half each at least, one of them: never.
        assert!(!ambiguous(&[([4.0, 1.0], 0.5), ([6.0, 1.0], 0.5)]));
    }

    #[test]
    fn bearings_across_the_seam_are_near_each_other() {
        let pi = core::f64::consts::PI;
        let around = |turn: f64| [([5.0, pi - turn], 0.3), ([5.0, turn - pi], 0.3), ([5.0, pi], 0.3)];
        assert!(!ambiguous(&around(0.036)) && ambiguous(&around(0.037)));
    }
}
