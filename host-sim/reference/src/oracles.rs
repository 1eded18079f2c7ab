//! Results of independent implementations: Stone Soup's PHD updater, a Monte Carlo estimate of the particle likelihood, Vo & Ma's
//! reduction, FilterPy's resampling.

use super::algebra::{identity, minus};
use super::gaussian::{Component, Matrix, Vector};
use super::likelihood::ln_likelihood;
use super::reduce::prune_and_merge;
use super::sensor::{RangeBearing, Sensor};
use super::sight::Sight;
use super::tests::{CONFIG, WIDE_VIEW};
use super::{Config, FieldOfView, Remembering, update};
use crate::Likelihood;
use scphd_shared_data::oracle;
use serde_json::Value;

const BOUND: f64 = 1e-9;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

pub(super) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(number).collect()
}

fn vector(value: &Value) -> Vector {
    numbers(value).try_into().expect("two numbers")
}

fn matrix(value: &Value) -> Matrix {
    [vector(&value[0]), vector(&value[1])]
}

fn vectors(value: &Value) -> Vec<Vector> {
    value.as_array().expect("an array").iter().map(vector).collect()
}

fn mixture(value: &Value) -> Vec<Component> {
    value
        .as_array()
        .expect("an array")
        .iter()
        .map(|component| Component {
            ln_weight: number(&component["weight"]).ln(),
            mean: vector(&component["mean"]),
            covariance: matrix(&component["cov"]),
        })
        .collect()
}

/// A sensor that measures the position directly.
pub(super) struct Linear {
    pub(super) noise: Matrix,
}

impl Sensor for Linear {
    fn predicted(&self, mean: Vector, _pose: [f64; 3]) -> Option<(Vector, Matrix)> {
        Some((mean, identity()))
    }

    fn innovation(&self, measurement: Vector, predicted: Vector) -> Vector {
        minus(measurement, predicted)
    }

    fn noise(&self, _predicted: Vector) -> Matrix {
        self.noise
    }
}

/// A field of view with all features of the oracles, with a constant probability of detection.
fn everywhere(detection_probability: f64) -> FieldOfView {
    FieldOfView { p_near: detection_probability, p_far: detection_probability, ..WIDE_VIEW }
}

/// The posterior in the oracle's order (detected components by measurement, then missed ones) and ln L, without births.
fn updated<S: Sensor>(case: &Value, measurements: &[Vector], sensor: &S) -> (Vec<Component>, f64) {
    let prior = mixture(&case["prior"]);
    let config = Config { clutter_intensity: number(&case["clutter_density"]), birth_intensity: 0.0, ..CONFIG };
    let view = everywhere(number(&case["pd"]));
    let sight = Sight::new([0.0; 3], &prior, &[], measurements, sensor, &view, &config);
    let mut posterior = update::persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0);
    posterior.rotate_left(prior.len());
    (posterior, ln_likelihood(Likelihood::SingleCluster, &sight))
}

fn assert_close(found: &[Component], expected: &[Component]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        // Relative difference: some weights are as small as 1e-209.
        let difference = (a.weight() / b.weight() - 1.0).abs();
        assert!(difference < BOUND, "weight {} for {}", a.weight(), b.weight());
        for row in 0..2 {
            assert!((a.mean[row] - b.mean[row]).abs() < BOUND, "{a:?} for {b:?}");
            for column in 0..2 {
                let difference = (a.covariance[row][column] - b.covariance[row][column]).abs();
                assert!(difference < BOUND, "{a:?} for {b:?}");
            }
        }
    }
}

#[test]
fn gaussian_mixture_update_with_a_linear_sensor() {
    let oracle = oracle("gmphd_update.json");
    let case = &oracle["cases"][0];
    let sensor = Linear { noise: matrix(&case["R"]) };
    let (posterior, ln_likelihood) = updated(case, &vectors(&case["measurements"]), &sensor);
    assert_close(&posterior, &mixture(&case["posterior"]));

    // The oracle includes the clutter rate λ, which is the same for all poses and omitted here.
    let particle = &oracle["single_cluster_likelihood"];
    let with_rate = ln_likelihood - number(&particle["lambda_c"]);
    assert!((with_rate - number(&particle["log_likelihood"])).abs() < BOUND);
}

#[test]
fn gaussian_mixture_update_by_range_and_bearing() {
    let oracle = oracle("gmphd_update.json");
    let case = &oracle["cases"][1];
    let noise = matrix(&case["R_bearing_range"]);
    let [range_sigma_m, bearing_sigma_rad] = [noise[1][1].sqrt(), noise[0][0].sqrt()];
    let sensor = RangeBearing { range_sigma_m, range_sigma_ratio: 0.0, bearing_sigma_rad };
    let measurements: Vec<Vector> =
        vectors(&case["measurements_bearing_range"]).iter().map(|[bearing, range]| [*range, *bearing]).collect();
    let (posterior, _) = updated(case, &measurements, &sensor);
    assert_close(&posterior, &mixture(&case["posterior"]));
}

#[test]
fn reduction_agrees_with_vo_and_ma() {
    let oracle = oracle("gm_merge_prune.json");
    let config = Config {
        prune_weight: number(&oracle["prune_T"]),
        merge_distance: number(&oracle["merge_U"]),
        max_components: 100,
        ..CONFIG
    };
    let reduced = prune_and_merge(&mixture(&oracle["input"]), &config);
    assert_close(&reduced, &mixture(&oracle["vo_ma"]));
}
