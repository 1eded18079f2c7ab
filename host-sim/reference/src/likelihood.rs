//! The particle likelihood: the only difference between single-cluster PHD SLAM and RB-PHD SLAM.

use super::algebra::{inverse, quadratic};
use super::config::Likelihood;
use super::gaussian::{Density, Vector};
use super::log_domain::log_sum_exp;
use super::pre_update::{InView, PreUpdate};
use super::reduce::heaviest_first;
use super::sensor::Sensor;
use super::sight::Sight;

/// ln L of a pose, without the clutter rate λ, which is the same for all poses.
pub(super) fn ln_likelihood<S: Sensor>(kind: Likelihood, sight: &Sight<'_, S>) -> f64 {
    match kind {
        Likelihood::SingleCluster => single_cluster(sight),
        Likelihood::RbEmpty => empty_map(sight),
        Likelihood::RbSingle => single_feature(sight),
        Likelihood::RbMulti => several_features(sight),
    }
}

/// ln L = −Σ p_D w + Σ ln η_z (4.52): the mass in view lowers the likelihood; the sign in (5.24) is a misprint.
fn single_cluster<S: Sensor>(sight: &Sight<'_, S>) -> f64 {
    sight.ln_eta.iter().sum::<f64>() - expected_detections(sight)
}

/// RB-PHD SLAM with the empty map: ln L = Σ ln κ(z) + N̂ − N̂⁻.
fn empty_map<S: Sensor>(sight: &Sight<'_, S>) -> f64 {
    ln_all_clutter(sight, sight.measurements.len()) + gained_mass(sight)
}

/// RB-PHD SLAM with a single feature at m, the mean of the first static component in view: the likelihood of the scan for this
/// map, divided by the ratio of the intensities at m after and before the update, v(m)/v⁻(m), times e^(N̂ − N̂⁻).
fn single_feature<S: Sensor>(sight: &Sight<'_, S>) -> f64 {
    let first = sight.still.in_view.iter().min_by(|a, b| heaviest_first(&a.prior, &b.prior));
    let Some(feature) = first else {
        return empty_map(sight);
    };
    // p_D is below 1: otherwise both ratios could be 0/0.
    let detection = feature.detection_probability.min(1.0 - f64::EPSILON);
    let ln_missed = (-detection).ln_1p();
    let ln_detected: Vec<f64> = ln_at_mean(feature, sight).iter().map(|ln_g| detection.ln() + ln_g).collect();

    // Either all measurements are clutter, or all except that of the feature. In this form there is no division by κ = 0.
    let all = sight.measurements.len();
    let mut hypotheses = vec![ln_all_clutter(sight, all) + ln_missed];
    hypotheses.extend(ln_detected.iter().map(|ln_one| ln_all_clutter(sight, all - 1) + ln_one));
    let mut intensity_ratio = vec![ln_missed];
    intensity_ratio.extend(ln_detected.iter().zip(&sight.ln_eta).map(|(ln_one, ln_eta)| ln_one - ln_eta));
    log_sum_exp(&hypotheses) - log_sum_exp(&intensity_ratio) + gained_mass(sight)
}

/// A feature of the map M = {m, …} of RB-PHD SLAM with several features.
struct Point {
    /// ln(1 − p_D).
    ln_missed: f64,
    /// The measurements that the feature may have caused, each with ln(p_D g(z|m)).
    caused: Vec<(usize, f64)>,
}

/// Bounds of M: number of features, weight of each, squared Mahalanobis distance and number of the measurements of a feature, and
/// number of features connected by measurements.
const MOST_POINTS: usize = 16;
const LEAST_WEIGHT: f64 = 0.75;
const FARTHEST: f64 = 32.0;
const MOST_CAUSED: usize = 8;
const MOST_LINKED: usize = 6;

/// RB-PHD SLAM with a map of several features: as with one, summed over all associations.
fn several_features<S: Sensor>(sight: &Sight<'_, S>) -> f64 {
    let groups = groups(sight);
    let made_of_it = |point: &Point| {
        let detected = point.caused.iter().map(|&(z, ln_one)| ln_one - sight.ln_eta[z]);
        log_sum_exp(&std::iter::once(point.ln_missed).chain(detected).collect::<Vec<_>>())
    };
    let intensity_ratios: f64 = groups.iter().flatten().map(made_of_it).sum();
    // Measurements that no feature of M may have caused are clutter; of those of a group, the ones without an association.
    let mut clutter_alone = sight.measurements.len();
    let mut ln_of_scan = 0.0;
    for group in &groups {
        let mut theirs: Vec<usize> = group.iter().flat_map(|point| point.caused.iter().map(|&(z, _)| z)).collect();
        theirs.sort_unstable();
        theirs.dedup();
        clutter_alone -= theirs.len();
        let mut hypotheses = Vec::new();
        associations(group, &mut Vec::new(), 0.0, &mut |taken, ln_weight| {
            hypotheses.push(ln_weight + ln_all_clutter(sight, theirs.len() - taken));
        });
        ln_of_scan += log_sum_exp(&hypotheses);
    }
    ln_of_scan + ln_all_clutter(sight, clutter_alone) - intensity_ratios + gained_mass(sight)
}

/// Enumerates the assignments of a different measurement, or none, to each of the points. Calls `tell` with the number of
/// assigned measurements and the weight.
fn associations(points: &[Point], taken: &mut Vec<usize>, ln_weight: f64, tell: &mut impl FnMut(usize, f64)) {
    let Some((point, rest)) = points.split_first() else {
        tell(taken.len(), ln_weight);
        return;
    };
    associations(rest, taken, ln_weight + point.ln_missed, tell);
    for &(z, ln_one) in &point.caused {
        if !taken.contains(&z) {
            taken.push(z);
            associations(rest, taken, ln_weight + ln_one, tell);
            taken.pop();
        }
    }
}

/// M in groups without common measurements: the first static components in view with enough weight, without those that too many
/// measurements may belong to, or that would make a group too large.
fn groups<S: Sensor>(sight: &Sight<'_, S>) -> Vec<Vec<Point>> {
    let mut first: Vec<&InView<2>> =
        sight.still.in_view.iter().filter(|feature| feature.prior.weight() >= LEAST_WEIGHT).collect();
    first.sort_by(|a, b| heaviest_first(&a.prior, &b.prior));
    let mut groups: Vec<Vec<Point>> = Vec::new();
    for feature in first.into_iter().take(MOST_POINTS) {
        let point = seen_as_point(feature, sight);
        let shares = |group: &Vec<Point>| {
            let mut theirs = group.iter().flat_map(|other| &other.caused);
            theirs.any(|(z, _)| point.caused.iter().any(|(own, _)| own == z))
        };
        let linked: usize = groups.iter().filter(|group| shares(group)).map(Vec::len).sum();
        if point.caused.len() > MOST_CAUSED || linked + 1 > MOST_LINKED {
            continue;
        }
        let (joined, mut apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(shares);
        apart.push(joined.into_iter().flatten().chain([point]).collect());
        groups = apart;
    }
    groups
}

/// A component with all measurements that a feature at its mean may have caused.
fn seen_as_point<S: Sensor>(feature: &InView<2>, sight: &Sight<'_, S>) -> Point {
    let detection = feature.detection_probability.min(1.0 - f64::EPSILON);
    let (predicted, _) = sight.sensor.predicted(feature.prior.mean, sight.pose).expect("in view is observable");
    let noise = sight.sensor.noise(predicted);
    let precision = inverse(&noise);
    let near = |z: Vector| quadratic(&precision, sight.sensor.innovation(z, predicted)) <= FARTHEST;
    let all = ln_at_mean(feature, sight).into_iter().enumerate();
    let caused = all.filter(|&(z, _)| near(sight.measurements[z])).map(|(z, ln_g)| (z, detection.ln() + ln_g));
    Point { ln_missed: (-detection).ln_1p(), caused: caused.collect() }
}

/// ln g(z|m) = ln N(z; h(m, x), R) of every measurement, for the mean of a component.
fn ln_at_mean<S: Sensor>(feature: &InView<2>, sight: &Sight<'_, S>) -> Vec<f64> {
    let (predicted, _) = sight.sensor.predicted(feature.prior.mean, sight.pose).expect("in view is observable");
    let density = Density::new(&sight.sensor.noise(predicted));
    sight.measurements.iter().map(|&z| density.ln(sight.sensor.innovation(z, predicted))).collect()
}

/// ln κ of `count` false measurements together.
fn ln_all_clutter<S>(sight: &Sight<'_, S>, count: usize) -> f64 {
    if count == 0 { 0.0 } else { count as f64 * sight.clutter_intensity.ln() }
}

/// N̂ − N̂⁻ = −Σ p_D w + Σ (1 − κ/η_z): the change of the map's mass by the update, with births.
fn gained_mass<S>(sight: &Sight<'_, S>) -> f64 {
    let clutter =
        |ln_eta: f64| if sight.clutter_intensity > 0.0 { sight.clutter_intensity / ln_eta.exp() } else { 0.0 };
    sight.ln_eta.iter().map(|&ln_eta| 1.0 - clutter(ln_eta)).sum::<f64>() - expected_detections(sight)
}

/// Σ p_D w over the components of both kinds in view.
fn expected_detections<S>(sight: &Sight<'_, S>) -> f64 {
    fn of<const N: usize>(view: &PreUpdate<N>) -> f64 {
        view.in_view.iter().map(|j| j.detection_probability * j.prior.weight()).sum()
    }
    of(&sight.still) + of(&sight.moving)
}

#[cfg(test)]
mod tests {
    use super::super::algebra::{minus, scaled};
    use super::super::gaussian::Component;
    use super::super::oracles::Linear;
    use super::super::tests::{CONFIG, SENSOR, WIDE_VIEW};
    use super::super::update::{born, persisting, set_in_motion};
    use super::super::{Config, RangeBearing, Remembering};
    use super::*;
    use Likelihood::{RbEmpty, RbMulti, RbSingle, SingleCluster};

    const POSE: [f64; 3] = [0.0; 3];
    const DETECTION: f64 = WIDE_VIEW.p_near;
    const KAPPA: f64 = CONFIG.clutter_intensity;
    const LINEAR: Linear = Linear { noise: [[0.04, 0.01], [0.01, 0.09]] };

    /// Births of both kinds.
    fn config() -> Config {
        let mut config = CONFIG;
        config.moving.birth_intensity = 0.02;
        config
    }

    fn feature(weight: f64, mean: Vector) -> Component {
        Component { ln_weight: weight.ln(), mean, covariance: [[0.3, 0.1], [0.1, 0.2]] }
    }

    fn see<'a, S: Sensor>(
        sensor: &'a S,
        map: &[Component],
        moving: &[Component<4>],
        measurements: &'a [Vector],
    ) -> Sight<'a, S> {
        Sight::new(POSE, map, moving, measurements, sensor, &WIDE_VIEW, &config())
    }

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-13 * expected.abs().max(1.0), "{found} instead of {expected}");
    }

    #[test]
    fn undetected_mass_in_view_lowers_the_likelihood() {
        let map = [feature(0.8, [5.0, 0.0]), feature(0.3, [9.0, 0.0])];
        let moving = [set_in_motion(&feature(0.5, [7.0, 0.0]), 1.0)];
        let sight = see(&SENSOR, &map, &moving, &[]);
        // Without measurements, both terms of a map with features cancel.
        for kind in [SingleCluster, RbEmpty, RbSingle, RbMulti] {
            close(ln_likelihood(kind, &sight), -DETECTION * 1.6);
        }
    }

    #[test]
    fn with_the_empty_map_clutter_and_births_explain_the_scan() {
        let measurements = [[4.0, 0.1], [7.0, -1.0]];
        let sight = see(&SENSOR, &[], &[], &measurements);
        let eta: f64 = KAPPA + 0.03 + 0.02;
        close(ln_likelihood(SingleCluster, &sight), 2.0 * eta.ln());
        close(ln_likelihood(RbEmpty, &sight), 2.0 * (KAPPA.ln() + 1.0 - KAPPA / eta));
        // There is no feature for the map.
        assert_eq!(ln_likelihood(RbSingle, &sight), ln_likelihood(RbEmpty, &sight));
        close(ln_likelihood(RbMulti, &sight), ln_likelihood(RbEmpty, &sight));
    }

    #[test]
    fn one_component_and_one_measurement_by_hand() {
        // A feature straight ahead with a diagonal covariance: S = diag(0.05 + 0.2², 0.5/5² + 0.02²).
        let map = [Component { covariance: [[0.05, 0.0], [0.0, 0.5]], ..feature(0.6, [5.0, 0.0]) }];
        let measurements = [[5.2, 0.1]];
        let sight = see(&SENSOR, &map, &[], &measurements);
        let normal = |range_variance: f64, bearing_variance: f64| {
            (-0.5 * (0.2f64.powi(2) / range_variance + 0.1f64.powi(2) / bearing_variance)).exp()
                / (std::f64::consts::TAU * (range_variance * bearing_variance).sqrt())
        };
        let eta = 0.06 + 0.9 * 0.6 * normal(0.09, 0.0204);
        let gained = -0.9 * 0.6 + 1.0 - 0.01 / eta;
        let g = normal(0.04, 0.0004);
        close(ln_likelihood(SingleCluster, &sight), eta.ln() - 0.9 * 0.6);
        close(ln_likelihood(RbEmpty, &sight), 0.01f64.ln() + gained);
        let single = 0.01f64.ln() + gained + (0.1 + 0.9 * g / 0.01).ln() - (0.1 + 0.9 * g / eta).ln();
        close(ln_likelihood(RbSingle, &sight), single);
    }

    fn intensity(mixture: &[Component], point: Vector) -> f64 {
        mixture.iter().map(|c| (c.ln_weight + Density::new(&c.covariance).ln(minus(point, c.mean))).exp()).sum()
    }

    /// RB-PHD SLAM's likelihood with features by its definition: the likelihood of the scan for the map of these features, by
    /// enumeration of all associations, times v⁻(m)/v(m) for all features and e^(N̂ − N̂⁻), from the mixtures themselves.
    fn by_definition<S: Sensor>(sight: &Sight<'_, S>, prior: &[Component], born_mass: f64, map: &[Vector]) -> f64 {
        let posterior = persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0);
        let moving = persisting(&sight.moving, &sight.ln_eta, Remembering::NOTHING, 0.0);
        let mass = |mixture: &[Component]| mixture.iter().map(Component::weight).sum::<f64>();
        let gained = mass(&posterior) - mass(prior) + moving.iter().map(Component::weight).sum::<f64>()
            - sight.moving.in_view.iter().map(|j| j.prior.weight()).sum::<f64>()
            + born_mass;
        let g = |z: Vector, m: Vector| {
            let (predicted, _) = sight.sensor.predicted(m, POSE).expect("observable");
            Density::new(&sight.sensor.noise(predicted)).ln(sight.sensor.innovation(z, predicted)).exp()
        };
        let all = sight.measurements.len();
        // Enumerates numbers with a digit for each feature: the index of its measurement, `all` for none.
        let mut sum = 0.0;
        for number in 0..(all + 1).pow(map.len() as u32) {
            let digits: Vec<usize> = (0..map.len()).map(|k| number / (all + 1).pow(k as u32) % (all + 1)).collect();
            let times = |z: usize| digits.iter().filter(|&&digit| digit == z).count();
            if (0..all).all(|z| times(z) <= 1) {
                let of = |(&z, &m): (&usize, &Vector)| {
                    if z == all { 1.0 - DETECTION } else { DETECTION * g(sight.measurements[z], m) }
                };
                let left_over = (0..all).filter(|&z| times(z) == 0).count();
                sum += digits.iter().zip(map).map(of).product::<f64>() * KAPPA.powi(left_over as i32);
            }
        }
        let ratios = map.iter().map(|&m| (intensity(prior, m) / intensity(&posterior, m)).ln());
        sum.ln() + gained + ratios.sum::<f64>()
    }

    #[test]
    fn single_feature_by_definition_with_a_linear_sensor() {
        // With a linear sensor N(z; ẑ, S) N(m; m⁺, P⁺) = g(z|m) N(m; m̂, P) is exact for any covariance. The heaviest component
        // gives m, in any order, and the moving one contributes to every η.
        let measurements = [[5.1, 2.2], [5.6, 1.9], [-3.0, 0.4]];
        let map = [feature(0.4, [5.5, 2.1]), feature(0.7, [5.0, 2.0]), feature(0.2, [-2.8, 0.0])];
        let moving = [set_in_motion(&feature(0.5, [5.3, 1.8]), 1.0)];
        let sight = see(&LINEAR, &map, &moving, &measurements);
        let births: f64 = sight.ln_eta.iter().map(|eta| (0.03 + 0.02) / eta.exp()).sum();
        close(ln_likelihood(RbSingle, &sight), by_definition(&sight, &map, births, &[[5.0, 2.0]]));
    }

    #[test]
    fn several_features_by_definition_with_a_linear_sensor() {
        // Two features with two common measurements, one separate feature, and two with too little weight.
        let measurements = [[5.1, 2.2], [5.6, 1.9], [-3.0, 0.4], [1.0, 1.0]];
        let places = [(0.8, [5.5, 2.1]), (0.9, [5.0, 2.0]), (0.76, [-2.8, 0.0]), (0.74, [5.2, 2.0]), (0.1, [1.0, 1.1])];
        let map = places.map(|(weight, mean)| feature(weight, mean));
        let moving = [set_in_motion(&feature(0.9, [5.3, 1.8]), 1.0)];
        let sight = see(&LINEAR, &map, &moving, &measurements);
        let births: f64 = sight.ln_eta.iter().map(|eta| (0.03 + 0.02) / eta.exp()).sum();
        let taken: Vec<Vector> = places[..3].iter().map(|&(_, mean)| mean).collect();
        close(ln_likelihood(RbMulti, &sight), by_definition(&sight, &map, births, &taken));
        assert!((ln_likelihood(RbMulti, &sight) - ln_likelihood(RbSingle, &sight)).abs() > 0.1);
    }

    #[test]
    fn one_established_feature_gives_the_single_feature_likelihood() {
        let measurements = [[5.1, 2.2], [5.6, 1.9]];
        let map = [feature(0.8, [5.5, 2.1])];
        let sight = see(&LINEAR, &map, &[], &measurements);
        close(ln_likelihood(RbMulti, &sight), ln_likelihood(RbSingle, &sight));
    }

    #[test]
    fn the_map_of_several_features_is_bounded() {
        let near = |count: usize| -> Vec<Vector> { (0..count).map(|k| [5.0 + 0.01 * k as f64, 2.0]).collect() };
        let features = |means: &[Vector]| -> Vec<Component> {
            means.iter().enumerate().map(|(k, &mean)| feature(0.99 - 0.01 * k as f64, mean)).collect()
        };
        let sizes = |map: &[Component], measurements: &[Vector]| -> Vec<usize> {
            let mut sizes: Vec<usize> = groups(&see(&LINEAR, map, &[], measurements)).iter().map(Vec::len).collect();
            sizes.sort_unstable();
            sizes
        };
        // Of eight with a common measurement the two lightest are left out.
        assert_eq!(sizes(&features(&near(8)), &near(1)), [6]);
        // A feature with nine measurements is left out, one with eight is not.
        assert!(sizes(&features(&near(1)), &near(9)).is_empty());
        assert_eq!(sizes(&features(&near(1)), &near(8)), [1]);
        // Of twenty separate ones, sixteen.
        let apart: Vec<Vector> = (0..20).map(|k| [2.0 * f64::from(k) - 20.0, 3.0]).collect();
        assert_eq!(sizes(&features(&apart), &apart).iter().sum::<usize>(), 16);
    }

    #[test]
    fn single_feature_by_definition_where_the_map_is_sharp() {
        // Range and bearing are linear over a millimetre.
        let measurements = [[5.2, 0.03], [5.0, -0.02], [8.0, 1.0]];
        let sharp = scaled(1e-6, &[[1.0, 0.2], [0.2, 0.5]]);
        let map = [Component { covariance: sharp, ..feature(0.7, [5.0, 0.1]) }];
        let sight = see(&SENSOR, &map, &[], &measurements);
        let births = |intensity| -> f64 {
            let births = born(&sight, &WIDE_VIEW, intensity);
            births.reduced.iter().chain(&births.waiting).map(Component::weight).sum()
        };
        let expected = by_definition(&sight, &map, births(0.03) + births(0.02), &[[5.0, 0.1]]);
        let found = ln_likelihood(RbSingle, &sight);
        assert!((found - expected).abs() < 1e-3, "{found} instead of {expected}");
        // The difference of the two is not small.
        assert!((found - ln_likelihood(RbEmpty, &sight)).abs() > 1.0);
    }

    #[test]
    fn without_clutter_only_one_feature_explains_one_measurement() {
        let mut none = config();
        none.clutter_intensity = 0.0;
        let map = [feature(0.9, [5.0, 0.0])];
        let of = |kind, measurements: &[Vector]| {
            let sight: Sight<'_, RangeBearing> = Sight::new(POSE, &map, &[], measurements, &SENSOR, &WIDE_VIEW, &none);
            ln_likelihood(kind, &sight)
        };
        assert_eq!(of(RbEmpty, &[[5.0, 0.0]]), f64::NEG_INFINITY);
        for kind in [RbSingle, RbMulti] {
            assert!(of(kind, &[[5.0, 0.0]]).is_finite());
            assert_eq!(of(kind, &[[5.0, 0.0], [5.1, 0.0]]), f64::NEG_INFINITY);
        }
        none.birth_intensity = 0.0;
        none.moving.birth_intensity = 0.0;
        let nothing: Sight<'_, RangeBearing> = Sight::new(POSE, &[], &[], &[[5.0, 0.0]], &SENSOR, &WIDE_VIEW, &none);
        for kind in [SingleCluster, RbEmpty, RbSingle, RbMulti] {
            assert_eq!(ln_likelihood(kind, &nothing), f64::NEG_INFINITY);
        }
    }
}
