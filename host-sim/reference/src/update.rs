//! `Update` of appendix A: the posterior mixture of one pose.

use super::algebra::{determinant, identity, scaled};
use super::config::{Config, Remembering};
use super::field_of_view::FieldOfView;
use super::gaussian::Component;
use super::pre_update::{InView, PreUpdate};
use super::reduce::{heavy_enough, prune_and_merge};
use super::sensor::RangeBearing;
use super::sight::Sight;

/// The persisting components in view after the update: first the missed ones, with w (1 − p_D) or their least weight, then for
/// each measurement the detected ones, with p_D w N(z; ẑ, S)/η_z (5.17, 5.18, corrected).
pub(super) fn persisting<const N: usize>(
    view: &PreUpdate<N>,
    ln_eta: &[f64],
    remembering: Remembering,
    prune_weight: f64,
) -> Vec<Component<N>> {
    let missed = view.in_view.iter().map(|j| {
        let faded = j.prior.weight() * (1.0 - j.detection_probability);
        let explaining = ln_eta.iter().enumerate().filter(|(_, eta)| **eta > f64::NEG_INFINITY);
        let weights = explaining.map(|(z, eta)| (j.ln_detection(z) - eta).exp());
        // Components that are pruned do not count as detected.
        let detected: f64 = weights.filter(|weight| *weight >= prune_weight).sum();
        let least = remembering.weight.min(j.prior.weight()) - detected;
        if faded < least && is_confirmed(j, remembering.detections) {
            Component { ln_weight: least.ln(), ..j.prior }
        } else {
            Component { ln_weight: j.prior.ln_weight + (-j.detection_probability).ln_1p(), ..j.prior }
        }
    });
    let detected = ln_eta
        .iter()
        .enumerate()
        // η_z = 0 if z has the likelihood zero; then it updates no component.
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

/// Whether a component is better known than after this number of measurements from this pose: det S / det R, which is det P / det
/// P⁺, is below the mean of its values after k and k + 1 measurements, for every dimension of the position.
fn is_confirmed<const N: usize>(j: &InView<N>, detections: f64) -> bool {
    let half_way = 1.0 + 0.5 / detections + 0.5 / (detections + 1.0);
    determinant(&j.prior.covariance) < determinant(&j.covariance) * half_way.powi(N as i32)
}

/// Greatest part of features in η_z of an unexplained measurement, relative to that of clutter and births.
const UNEXPLAINED_SHARE: f64 = 1e-3;

/// The births of the static or the moving part in a scan, in the order of the measurements.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Births<const N: usize> {
    /// Births on measurements explained by features: reduced together with the components in view.
    pub(super) reduced: Vec<Component<N>>,
    /// Births on unexplained measurements: not changed in this scan.
    pub(super) waiting: Vec<Component<N>>,
}

impl Births<2> {
    /// The same births of moving features.
    pub(super) fn set_in_motion(&self, velocity_sigma_mps: f64) -> Births<4> {
        let moving =
            |births: &[Component]| births.iter().map(|birth| set_in_motion(birth, velocity_sigma_mps)).collect();
        Births { reduced: moving(&self.reduced), waiting: moving(&self.waiting) }
    }
}

/// The static births on the measurements, at h⁻¹(z, x) with R*, if that is in view (5.9, 5.10, 5.17).
pub(super) fn born(sight: &Sight<'_, RangeBearing>, field_of_view: &FieldOfView, birth_intensity: f64) -> Births<2> {
    let in_view = |mean| field_of_view.detection_probability(mean, sight.pose) > 0.0;
    let places =
        sight.measurements.iter().map(|&z| sight.sensor.inverse(z, sight.pose).filter(|&(mean, _)| in_view(mean)));
    born_at(places, &sight.ln_eta, sight.ln_unexplained, birth_intensity)
}

/// The births on measurements with these positions and covariances, or none: w/η_z.
pub(super) fn born_at<const N: usize>(
    places: impl Iterator<Item = Option<([f64; N], [[f64; N]; N])>>,
    ln_eta: &[f64],
    ln_unexplained: f64,
    birth_intensity: f64,
) -> Births<N> {
    let mut births = Births { reduced: Vec::new(), waiting: Vec::new() };
    if birth_intensity == 0.0 {
        return births;
    }
    for (place, &eta) in places.zip(ln_eta) {
        let Some((mean, covariance)) = place else { continue };
        let unexplained = eta <= ln_unexplained + UNEXPLAINED_SHARE.ln_1p();
        let kind = if unexplained { &mut births.waiting } else { &mut births.reduced };
        kind.push(Component { ln_weight: birth_intensity.ln() - eta, mean, covariance });
    }
    births
}

/// One part of a map after the scan: unchanged components out of view; the reduced others, heaviest first; then waiting births in
/// the order of the measurements, without those that are too light.
pub(super) fn after_scan<const N: usize>(
    out_of_view: Vec<Component<N>>,
    persisting: Vec<Component<N>>,
    births: Births<N>,
    config: &Config,
) -> Vec<Component<N>> {
    let reduced = prune_and_merge(&[persisting, births.reduced].concat(), config);
    let waiting = births.waiting.into_iter().filter(|birth| heavy_enough(birth, config.prune_weight));
    out_of_view.into_iter().chain(reduced).chain(waiting).collect()
}

/// A birth that may move: the same position, and an unknown velocity with this standard deviation, m/s.
pub(super) fn set_in_motion(birth: &Component, velocity_sigma_mps: f64) -> Component<4> {
    let [x, y] = birth.mean;
    let mut covariance = scaled(velocity_sigma_mps.powi(2), &identity());
    for (row, entries) in birth.covariance.iter().enumerate() {
        covariance[row][..2].copy_from_slice(entries);
    }
    Component { ln_weight: birth.ln_weight, mean: [x, y, 0.0, 0.0], covariance }
}

#[cfg(test)]
mod tests {
    use super::super::gaussian::Vector;
    use super::super::tests::{CONFIG, SENSOR, WIDE_VIEW};
    use super::*;

    const POSE: [f64; 3] = [1.0, -2.0, 0.4];
    const UNEXPLAINED: f64 = 0.04;
    const NONE: Births<2> = Births { reduced: Vec::new(), waiting: Vec::new() };

    fn feature(weight: f64, forward: f64) -> Component {
        Component {
            ln_weight: weight.ln(),
            mean: [POSE[0] + forward * POSE[2].cos(), POSE[1] + forward * POSE[2].sin()],
            covariance: [[0.2, 0.05], [0.05, 0.1]],
        }
    }

    fn moving(weight: f64, forward: f64) -> Component<4> {
        set_in_motion(&feature(weight, forward), 1.5)
    }

    /// The components in view, with `unexplained` as the sum of κ and the birth intensities.
    fn sight<'a>(
        map: &[Component],
        moving: &[Component<4>],
        measurements: &'a [Vector],
        unexplained: f64,
    ) -> Sight<'a, RangeBearing> {
        let config = Config { clutter_intensity: unexplained, birth_intensity: 0.0, ..CONFIG };
        Sight::new(POSE, map, moving, measurements, &SENSOR, &WIDE_VIEW, &config)
    }

    #[test]
    fn births_have_the_unexplained_share() {
        let measurements = [[4.0, 0.1], [7.0, -1.0]];
        let births = born(&sight(&[], &[], &measurements, UNEXPLAINED), &WIDE_VIEW, 0.03);
        assert_eq!((births.waiting.len(), births.reduced.len()), (2, 0));
        for (birth, measurement) in births.waiting.iter().zip(measurements) {
            assert!((birth.weight() - 0.75).abs() < 1e-14);
            let (mean, covariance) = SENSOR.inverse(measurement, POSE).expect("range above 0");
            assert_eq!((birth.mean, birth.covariance), (mean, covariance));
        }
    }

    /// Births on a measurement for which a feature adds this share to the intensity without features.
    fn born_where_a_feature_adds(share: f64) -> Births<2> {
        let measurements = [[5.1, 0.02]];
        let whole = sight(&[feature(1.0, 5.0)], &[], &measurements, UNEXPLAINED);
        let weight = share * UNEXPLAINED / whole.still.in_view[0].ln_detection(0).exp();
        let sight = sight(&[feature(weight, 5.0)], &[], &measurements, UNEXPLAINED);
        assert!((sight.ln_eta[0] - (UNEXPLAINED * (1.0 + share)).ln()).abs() < 1e-14);
        born(&sight, &WIDE_VIEW, 0.03)
    }

    #[test]
    fn a_share_of_a_thousandth_explains_a_measurement() {
        let births = born_where_a_feature_adds(0.99e-3);
        assert_eq!((births.waiting.len(), births.reduced.len()), (1, 0));
        assert!((births.waiting[0].weight() - 0.75 / 1.000_99).abs() < 1e-14);

        let births = born_where_a_feature_adds(1.01e-3);
        assert_eq!((births.waiting.len(), births.reduced.len()), (0, 1));
        assert!((births.reduced[0].weight() - 0.75 / 1.001_01).abs() < 1e-14);
    }

    #[test]
    fn moving_births_wait_like_static_ones() {
        for share in [0.0, 1.0] {
            let still = born_where_a_feature_adds(share);
            let moving = still.set_in_motion(1.5);
            let expected =
                |births: &[Component]| births.iter().map(|birth| set_in_motion(birth, 1.5)).collect::<Vec<_>>();
            assert_eq!((&moving.waiting, &moving.reduced), (&expected(&still.waiting), &expected(&still.reduced)));
        }
    }

    #[test]
    fn a_moving_birth_has_an_unknown_velocity() {
        let birth = moving(0.3, 5.0);
        let still = feature(0.3, 5.0);
        assert_eq!((birth.ln_weight, birth.position()), (still.ln_weight, still.mean));
        assert_eq!(birth.mean[2..], [0.0, 0.0]);
        let expected = [[0.2, 0.05, 0.0, 0.0], [0.05, 0.1, 0.0, 0.0], [0.0, 0.0, 2.25, 0.0], [0.0, 0.0, 0.0, 2.25]];
        assert_eq!(birth.covariance, expected);
    }

    #[test]
    fn a_missed_feature_keeps_its_position_and_loses_weight() {
        let before = feature(0.8, 5.0);
        let after = persisting(&sight(&[before], &[], &[], UNEXPLAINED).still, &[], Remembering::NOTHING, 0.0);
        assert_eq!(after.len(), 1);
        assert!((after[0].weight() - 0.8 * (1.0 - WIDE_VIEW.p_near)).abs() < 1e-15);
        assert_eq!((after[0].mean, after[0].covariance), (before.mean, before.covariance));
    }

    #[test]
    fn confirmed_components_keep_a_least_weight_after_misses_and_others_do_not() {
        let remembering = Remembering { detections: 3.0, weight: 0.2 };
        let missed = |weight, measurements: u32| {
            // The covariance after this number of measurements from here.
            let covariance = SENSOR.inverse([5.0, 0.0], POSE).unwrap().1;
            let covariance = scaled(1.0 / f64::from(measurements), &covariance);
            let before = Component { covariance, ..feature(weight, 5.0) };
            persisting(&sight(&[before], &[], &[], UNEXPLAINED).still, &[], remembering, 0.0)[0].weight()
        };
        let left = 1.0 - WIDE_VIEW.p_near;
        assert!(0.8 * left < 0.2, "a miss takes it below what is remembered");
        for (weight, measurements, after) in [(0.8, 4, 0.2), (0.8, 3, 0.8 * left), (0.1, 4, 0.1), (0.1, 3, 0.1 * left)]
        {
            assert!((missed(weight, measurements) - after).abs() < 1e-15, "{weight} {measurements}");
        }
    }

    #[test]
    fn a_detected_component_has_no_least_weight_of_its_missed_part() {
        let remembering = Remembering { detections: 3.0, weight: 0.2 };
        let covariance = scaled(0.25, &SENSOR.inverse([5.0, 0.0], POSE).unwrap().1);
        let before = Component { covariance, ..feature(0.8, 5.0) };
        // The second one is so far away that it explains only a part of the measurement.
        for (z, hardly) in [([5.0, 0.0], false), ([5.95, 0.0], true)] {
            let (map, scan) = ([before], [z]);
            let sight = sight(&map, &[], &scan, UNEXPLAINED);
            let after = persisting(&sight.still, &sight.ln_eta, remembering, 0.0);
            let (left, detected) = (0.8 * (1.0 - WIDE_VIEW.p_near), after[1].weight());
            assert_eq!(0.2 - detected > left, hardly, "{detected}");
            assert!((after[0].weight() - left.max(0.2 - detected)).abs() < 1e-14);
        }
    }

    #[test]
    fn every_measurement_has_exactly_the_mass_one() {
        let measurements = [[5.1, 0.02], [5.0, -0.01], [9.0, 2.0]];
        let map = [feature(0.8, 5.0), feature(0.3, 5.6)];
        let sight = sight(&map, &[moving(0.5, 5.2)], &measurements, UNEXPLAINED);
        let (still, moving) = (
            persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0),
            persisting(&sight.moving, &sight.ln_eta, Remembering::NOTHING, 0.0),
        );
        assert_eq!((still.len(), moving.len()), (8, 4));
        for (z, eta) in sight.ln_eta.iter().enumerate() {
            let detected: f64 = still[2 + 2 * z..4 + 2 * z].iter().map(Component::weight).sum();
            let detected = detected + moving[1 + z].weight();
            assert!((detected + UNEXPLAINED / eta.exp() - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn static_and_moving_features_explain_a_measurement_alike() {
        // Position and velocity are independent, so that the predicted measurement is the same for both.
        let measurements = [[5.1, 0.02]];
        let sight = sight(&[feature(0.5, 5.0)], &[moving(0.5, 5.0)], &measurements, UNEXPLAINED);
        let still = persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0)[1];
        let moving = persisting(&sight.moving, &sight.ln_eta, Remembering::NOTHING, 0.0)[1];
        assert!((still.ln_weight - moving.ln_weight).abs() < 1e-14);
        for k in 0..2 {
            assert!((still.mean[k] - moving.mean[k]).abs() < 1e-14);
            assert_eq!(moving.mean[k + 2], 0.0);
        }
        assert_eq!(moving.covariance[2], [0.0, 0.0, 2.25, 0.0]);
    }

    #[test]
    fn the_velocity_is_updated_by_its_correlation_with_the_position() {
        // The second of two scans updates the velocity: m_v⁺ = P_vp P_pp⁻¹ (p⁺ − p) for a measurement of p.
        let mut before = moving(0.5, 5.0);
        for k in 0..2 {
            before.covariance[k][k + 2] = 0.2;
            before.covariance[k + 2][k] = 0.2;
        }
        let measurements = [[5.3, -0.03]];
        let sight = sight(&[], &[before], &measurements, UNEXPLAINED);
        let after = persisting(&sight.moving, &sight.ln_eta, Remembering::NOTHING, 0.0)[1];
        let shift = [after.mean[0] - before.mean[0], after.mean[1] - before.mean[1]];
        // P_pp⁻¹ of [[0.2, 0.05], [0.05, 0.1]] by hand: 1/0.0175 [[0.1, −0.05], [−0.05, 0.2]].
        let velocity =
            [0.2 * (0.1 * shift[0] - 0.05 * shift[1]) / 0.0175, 0.2 * (0.2 * shift[1] - 0.05 * shift[0]) / 0.0175];
        for (k, expected) in velocity.iter().enumerate() {
            assert!((after.mean[k + 2] - expected).abs() < 1e-13, "{after:?}");
            assert!(after.covariance[k + 2][k + 2] < before.covariance[k + 2][k + 2]);
        }
    }

    #[test]
    fn a_measurement_of_likelihood_zero_updates_nothing() {
        let measurements = [[5.0, 0.0]];
        let weightless = feature(0.0, 5.0);
        let sight = sight(&[weightless], &[], &measurements, 0.0);
        assert_eq!(persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0), [weightless]);
        assert_eq!(born(&sight, &WIDE_VIEW, 0.0), NONE);
    }

    #[test]
    fn a_measurement_without_inverse_has_no_birth_but_is_weighed() {
        let measurements = [[0.0, 0.0]];
        let sight = sight(&[], &[], &measurements, UNEXPLAINED);
        assert!((sight.ln_eta[0] - UNEXPLAINED.ln()).abs() < 1e-15);
        assert_eq!(born(&sight, &WIDE_VIEW, 0.03), NONE);
    }

    #[test]
    fn covariance_shrinks_and_stays_positive() {
        fn shrinks<const N: usize>(mut component: Component<N>, see: impl Fn(Component<N>) -> Component<N>) {
            let mut volume = f64::INFINITY;
            for _ in 0..1000 {
                component = see(component);
                for k in 0..N {
                    assert!(component.covariance[k][k] > 0.0);
                    assert!((0..N).all(|l| component.covariance[k][l] == component.covariance[l][k]));
                }
                let smaller = determinant(&component.covariance);
                assert!(smaller > 0.0 && smaller < volume);
                volume = smaller;
            }
        }
        let measurements = [[5.0, 0.0]];
        shrinks(feature(1.0, 5.0), |c| {
            let sight = sight(&[c], &[], &measurements, UNEXPLAINED);
            Component { covariance: sight.still.in_view[0].covariance, ..c }
        });
        shrinks(moving(1.0, 5.0), |c| {
            let sight = sight(&[], &[c], &measurements, UNEXPLAINED);
            Component { covariance: sight.moving.in_view[0].covariance, ..c }
        });
    }
}
