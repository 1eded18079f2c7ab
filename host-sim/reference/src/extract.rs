//! State extraction (5.2.7).

use super::angle::wrap;
use super::gaussian::Component;
use super::log_domain::normalised;
use super::reduce::heaviest_first;
use super::state::State;

/// The estimate of pose and map.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Weighted mean pose: x m, y m, heading rad.
    pub pose: [f64; 3],
    /// Weighted covariance about that mean, in m, m, rad.
    pub pose_covariance: [[f64; 3]; 3],
    /// N̂, the mass of the static map.
    pub expected_features: f64,
    /// The round(N̂) heaviest components of the map, heaviest first, without those that weigh too little.
    pub features: Vec<Component>,
    /// The mass of the moving part of the map.
    pub expected_moving: f64,
    /// Likewise the heaviest components of the moving part, at the time of the last prediction.
    pub moving: Vec<Component<4>>,
}

/// The mean pose over the candidates (after a scan, over the particles), with the map of the particle that descends from the
/// heaviest candidate of the last scan. `moving` is the moving part of that map, predicted. Estimated static and moving features
/// have at least the weights `least_weights`.
pub(super) fn estimate(state: &State, moving: &[Component<4>], least_weights: [f64; 2]) -> Estimate {
    let candidates = state.current();
    let ln_weights: Vec<f64> = candidates.iter().map(|c| c.ln_weight).collect();
    let weights: Vec<f64> =
        normalised(&ln_weights).expect("some candidate weighs something").iter().map(|w| w.exp()).collect();
    let mean_of = |value: &dyn Fn([f64; 3]) -> f64| -> f64 {
        candidates.iter().zip(&weights).map(|(c, w)| w * value(c.pose)).sum()
    };
    let sin = mean_of(&|pose| pose[2].sin());
    let cos = mean_of(&|pose| pose[2].cos());
    let pose = [mean_of(&|p| p[0]), mean_of(&|p| p[1]), sin.atan2(cos)];
    let away = |p: [f64; 3]| [p[0] - pose[0], p[1] - pose[1], wrap(p[2] - pose[2])];
    let pose_covariance =
        std::array::from_fn(|row| std::array::from_fn(|column| mean_of(&|p| away(p)[row] * away(p)[column])));

    let (expected_features, features) = heaviest(&state.particles[state.heaviest].map, least_weights[0]);
    let (expected_moving, moving) = heaviest(moving, least_weights[1]);
    Estimate { pose, pose_covariance, expected_features, features, expected_moving, moving }
}

/// The mass of a mixture, and its heaviest components, as many as the rounded mass, without those below `least_weight`.
fn heaviest<const N: usize>(mixture: &[Component<N>], least_weight: f64) -> (f64, Vec<Component<N>>) {
    let mass: f64 = mixture.iter().map(Component::weight).sum();
    let mut features = mixture.to_vec();
    features.sort_by(heaviest_first);
    features.truncate(mass.round() as usize);
    features.retain(|feature| feature.weight() >= least_weight);
    (mass, features)
}

#[cfg(test)]
mod tests {
    use super::super::algebra::identity;
    use super::super::state::{Candidate, Particle};
    use super::*;
    use std::f64::consts::{LN_2, PI};

    fn particle(pose: [f64; 3], weight: f64, map: &[f64]) -> Particle {
        let component = |(i, w): (usize, &f64)| Component {
            ln_weight: w.ln(),
            mean: [i as f64, 0.0],
            covariance: [[1.0, 0.0], [0.0, 1.0]],
        };
        let map = map.iter().enumerate().map(component).collect();
        Particle { pose, ln_weight: weight.ln(), map, moving: Vec::new() }
    }

    fn state() -> State {
        State {
            particles: vec![
                particle([1.0, 2.0, PI - 0.1], 0.25, &[0.9; 5]),
                particle([3.0, 6.0, -PI + 0.1], 0.75, &[0.1, 0.9, 0.5, 1.1]),
            ],
            candidates: None,
            waited_s: 0.0,
            heaviest: 1,
        }
    }

    #[test]
    fn mean_and_covariance_across_heading_pi() {
        let estimate = estimate(&state(), &[], [0.0; 2]);
        assert!((estimate.pose[0] - 2.5).abs() < 1e-15);
        assert!((estimate.pose[1] - 5.0).abs() < 1e-15);
        // tan of the mean's distance from π is (0.75 − 0.25) sin 0.1 / cos 0.1.
        let off = (0.5 * 0.1f64.tan()).atan();
        assert!((estimate.pose[2] - (-PI + off)).abs() < 1e-14);
        let cov = estimate.pose_covariance;
        assert!((cov[0][0] - 0.75).abs() < 1e-14);
        assert!((cov[0][1] - 1.5).abs() < 1e-14);
        assert!((cov[1][1] - 3.0).abs() < 1e-14);
        let square = 0.25 * (0.1 + off).powi(2) + 0.75 * (0.1 - off).powi(2);
        assert!((cov[2][2] - square).abs() < 1e-14);
        let cross = 0.25 * -1.5 * (-0.1 - off) + 0.75 * 0.5 * (0.1 - off);
        assert!((cov[0][2] - cross).abs() < 1e-14);
        assert_eq!(cov[0][2], cov[2][0]);
    }

    #[test]
    fn the_expected_number_of_features_the_heaviest_first() {
        let estimate = estimate(&state(), &[], [0.0; 2]);
        assert!((estimate.expected_features - 2.6).abs() < 1e-14);
        let places: Vec<f64> = estimate.features.iter().map(|c| c.mean[0]).collect();
        assert_eq!(places, [3.0, 1.0, 2.0]);
    }

    #[test]
    fn light_features_are_not_estimated_but_count_in_the_mass() {
        let estimate = estimate(&state(), &[], [0.8; 2]);
        assert!((estimate.expected_features - 2.6).abs() < 1e-14);
        let places: Vec<f64> = estimate.features.iter().map(|c| c.mean[0]).collect();
        assert_eq!(places, [3.0, 1.0]);
    }

    #[test]
    fn moving_features_are_from_their_own_mixture() {
        let at = |weight: f64, x: f64| Component {
            ln_weight: weight.ln(),
            mean: [x, 0.0, 1.0, 0.0],
            covariance: identity(),
        };
        let estimate = estimate(&state(), &[at(0.4, 1.0), at(0.3, 2.0), at(0.9, 3.0)], [0.35; 2]);
        assert!((estimate.expected_moving - 1.6).abs() < 1e-14);
        assert_eq!(estimate.moving, [at(0.9, 3.0), at(0.4, 1.0)]);
        assert_eq!(estimate.features.len(), 3);
    }

    #[test]
    fn between_prediction_and_scan_the_candidates_are_the_estimate() {
        let mut predicted = state();
        predicted.candidates = Some(
            [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
                .map(|pose| Candidate { pose, ln_weight: -2.0 * LN_2 })
                .to_vec(),
        );
        assert!((estimate(&predicted, &[], [0.0; 2]).pose[0] - 1.5).abs() < 1e-15);
    }
}
