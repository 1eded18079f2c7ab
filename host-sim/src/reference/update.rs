//! `Update` of appendix A: the multi-object likelihood and the posterior mixture of one pose.

use super::field_of_view::FieldOfView;
use super::gaussian::{Component, Vector};
use super::log_domain::log_sum_exp;
use super::pre_update::PreUpdate;
use super::sensor::RangeBearing;

/// ln η_z of every measurement (4.51, 5.19 with one birth space): η_z = κ + w_b + Σ p_D w N(z; ẑ, S)
/// over the components in view. `unexplained` is κ + w_b, 1/(m·rad).
pub(super) fn ln_eta(view: &PreUpdate, measurements: usize, unexplained: f64) -> Vec<f64> {
    (0..measurements)
        .map(|z| {
            let mut terms: Vec<f64> = view.in_view.iter().map(|j| j.ln_detection(z)).collect();
            terms.push(unexplained.ln());
            log_sum_exp(&terms)
        })
        .collect()
}

/// ln L = −Σ p_D w + Σ ln η_z (4.52): the mass in view counts against a pose, not for it as (5.24)
/// prints. The clutter rate λ, which is the same for every pose, is left out.
pub(super) fn ln_likelihood(view: &PreUpdate, ln_eta: &[f64]) -> f64 {
    let expected: f64 = view.in_view.iter().map(|j| j.detection_probability * j.prior.weight()).sum();
    ln_eta.iter().sum::<f64>() - expected
}

/// The persisting components in view after the update: for each one missed, w (1 − p_D), then for each
/// measurement each one detected, p_D w N(z; ẑ, S)/η_z (5.17, 5.18, corrected).
pub(super) fn persisting(view: &PreUpdate, ln_eta: &[f64]) -> Vec<Component> {
    let missed = view
        .in_view
        .iter()
        .map(|j| Component { ln_weight: j.prior.ln_weight + (-j.detection_probability).ln_1p(), ..j.prior });
    let detected = ln_eta
        .iter()
        .enumerate()
        // η_z = 0 where nothing at all explains z; it then detects nothing either.
        .filter(|(_, eta)| **eta > f64::NEG_INFINITY)
        .flat_map(|(z, eta)| {
            view.in_view.iter().map(move |j| Component {
                ln_weight: j.ln_detection(z) - eta,
                mean: j.updated[z].0,
                covariance: j.covariance,
            })
        });
    missed.chain(detected).collect()
}

/// The components born on the measurements: w_b/η_z at h⁻¹(z, x) with R*, where that is in view (5.9, 5.10, 5.17).
pub(super) fn born(
    pose: [f64; 3],
    measurements: &[Vector],
    ln_eta: &[f64],
    sensor: &RangeBearing,
    field_of_view: &FieldOfView,
    birth_intensity: f64,
) -> Vec<Component> {
    if birth_intensity == 0.0 {
        return Vec::new();
    }
    measurements
        .iter()
        .zip(ln_eta)
        .filter_map(|(&measurement, eta)| {
            let (mean, covariance) = sensor.inverse(measurement, pose)?;
            if field_of_view.detection_probability(mean, pose) <= 0.0 {
                return None;
            }
            Some(Component { ln_weight: birth_intensity.ln() - eta, mean, covariance })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::pre_update::pre_update;
    use super::super::tests::{SENSOR, WIDE_VIEW};
    use super::*;

    const POSE: [f64; 3] = [1.0, -2.0, 0.4];
    const UNEXPLAINED: f64 = 0.04;

    fn feature(weight: f64, forward: f64) -> Component {
        Component {
            ln_weight: weight.ln(),
            mean: [POSE[0] + forward * POSE[2].cos(), POSE[1] + forward * POSE[2].sin()],
            covariance: [[0.2, 0.05], [0.05, 0.1]],
        }
    }

    fn view(map: &[Component], measurements: &[Vector]) -> PreUpdate {
        pre_update(map, POSE, measurements, &SENSOR, &WIDE_VIEW)
    }

    #[test]
    fn mass_in_view_that_nothing_measures_counts_against_the_pose() {
        let view = view(&[feature(0.8, 5.0)], &[]);
        let expected = -WIDE_VIEW.p_near * 0.8;
        assert!((ln_likelihood(&view, &[]) - expected).abs() < 1e-15);
    }

    #[test]
    fn empty_map_explains_by_clutter_and_birth() {
        let measurements = [[4.0, 0.1], [7.0, -1.0]];
        let view = view(&[], &measurements);
        let ln_eta = ln_eta(&view, 2, UNEXPLAINED);
        let expected = 2.0 * UNEXPLAINED.ln();
        assert!((ln_likelihood(&view, &ln_eta) - expected).abs() < 1e-14);
        let births = born(POSE, &measurements, &ln_eta, &SENSOR, &WIDE_VIEW, 0.03);
        assert_eq!(births.len(), 2);
        for (birth, measurement) in births.iter().zip(measurements) {
            assert!((birth.weight() - 0.75).abs() < 1e-14);
            let (mean, covariance) = SENSOR.inverse(measurement, POSE).expect("range above 0");
            assert_eq!((birth.mean, birth.covariance), (mean, covariance));
        }
    }

    #[test]
    fn missed_feature_keeps_place_and_loses_weight() {
        let before = feature(0.8, 5.0);
        let after = persisting(&view(&[before], &[]), &[]);
        assert_eq!(after.len(), 1);
        assert!((after[0].weight() - 0.8 * (1.0 - WIDE_VIEW.p_near)).abs() < 1e-15);
        assert_eq!((after[0].mean, after[0].covariance), (before.mean, before.covariance));
    }

    #[test]
    fn every_measurement_hands_out_exactly_its_own_mass() {
        let measurements = [[5.1, 0.02], [5.0, -0.01], [9.0, 2.0]];
        let map = [feature(0.8, 5.0), feature(0.3, 5.6)];
        let view = view(&map, &measurements);
        let ln_eta = ln_eta(&view, 3, UNEXPLAINED);
        let after = persisting(&view, &ln_eta);
        for (z, eta) in ln_eta.iter().enumerate() {
            let detected: f64 = after[2 + 2 * z..4 + 2 * z].iter().map(Component::weight).sum();
            assert!((detected + UNEXPLAINED / eta.exp() - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn measurement_that_nothing_explains_updates_nothing() {
        let measurements = [[5.0, 0.0]];
        let weightless = feature(0.0, 5.0);
        let view = view(&[weightless], &measurements);
        let ln_eta = ln_eta(&view, 1, 0.0);
        assert_eq!(ln_likelihood(&view, &ln_eta), f64::NEG_INFINITY);
        assert_eq!(persisting(&view, &ln_eta), [weightless]);
        assert!(born(POSE, &measurements, &ln_eta, &SENSOR, &WIDE_VIEW, 0.0).is_empty());
    }

    #[test]
    fn measurement_without_inverse_bears_nothing_but_is_weighed() {
        let measurements = [[0.0, 0.0]];
        let ln_eta = ln_eta(&view(&[], &measurements), 1, UNEXPLAINED);
        assert!((ln_eta[0] - UNEXPLAINED.ln()).abs() < 1e-15);
        assert!(born(POSE, &measurements, &ln_eta, &SENSOR, &WIDE_VIEW, 0.03).is_empty());
    }

    #[test]
    fn covariance_shrinks_and_stays_positive() {
        let mut component = feature(1.0, 5.0);
        let mut area = f64::INFINITY;
        for _ in 0..1000 {
            let view = view(&[component], &[[5.0, 0.0]]);
            component.covariance = view.in_view[0].covariance;
            let [[a, b], [c, d]] = component.covariance;
            assert_eq!(b, c);
            assert!(a > 0.0 && d > 0.0 && a * d - b * c > 0.0);
            assert!(a * d - b * c < area);
            area = a * d - b * c;
        }
    }
}
