//! `PreUpdate` of appendix A: the Kalman update of every component in view with every measurement.

use super::field_of_view::FieldOfView;
use super::gaussian::{
    Component, IDENTITY, Matrix, Vector, apply, difference, inverse, ln_density, plus, product, sum, symmetrised,
    transformed, transpose,
};
use super::sensor::Sensor;

/// A component in view and what each measurement would make of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InView {
    /// The predicted component.
    pub(super) prior: Component,
    /// p_D at its mean.
    pub(super) detection_probability: f64,
    /// P⁺, the same for every measurement (5.21).
    pub(super) covariance: Matrix,
    /// For each measurement: m⁺ (5.20) and ln N(z; ẑ, S).
    pub(super) updated: Vec<(Vector, f64)>,
}

impl InView {
    /// ln(p_D w N(z; ẑ, S)) for one measurement: its share of η_z.
    pub(super) fn ln_detection(&self, measurement: usize) -> f64 {
        self.detection_probability.ln() + self.prior.ln_weight + self.updated[measurement].1
    }
}

/// A map as seen from one pose.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PreUpdate {
    /// V: the components that may be detected.
    pub(super) in_view: Vec<InView>,
    /// All others.
    pub(super) out_of_view: Vec<Component>,
}

/// Splits a map by the field of view and updates each component in it with each measurement.
pub(super) fn pre_update<S: Sensor>(
    map: &[Component],
    pose: [f64; 3],
    measurements: &[Vector],
    sensor: &S,
    field_of_view: &FieldOfView,
) -> PreUpdate {
    let mut result = PreUpdate { in_view: Vec::new(), out_of_view: Vec::new() };
    for &prior in map {
        let detection_probability = field_of_view.detection_probability(prior.mean, pose);
        match sensor.predicted(prior.mean, pose) {
            Some((predicted, jacobian)) if detection_probability > 0.0 => {
                let (covariance, updated) = kalman(&prior, predicted, &jacobian, measurements, sensor);
                result.in_view.push(InView { prior, detection_probability, covariance, updated });
            }
            _ => result.out_of_view.push(prior),
        }
    }
    result
}

/// P⁺ and, for each measurement, m⁺ and ln N(z; ẑ, S) (5.20–5.22).
fn kalman<S: Sensor>(
    prior: &Component,
    predicted: Vector,
    jacobian: &Matrix,
    measurements: &[Vector],
    sensor: &S,
) -> (Matrix, Vec<(Vector, f64)>) {
    let innovation_covariance = sum(&transformed(jacobian, &prior.covariance), &sensor.noise());
    let gain = product(&product(&prior.covariance, &transpose(jacobian)), &inverse(&innovation_covariance));
    let covariance = symmetrised(&product(&difference(&IDENTITY, &product(&gain, jacobian)), &prior.covariance));
    let updated = measurements
        .iter()
        .map(|&measurement| {
            let innovation = sensor.innovation(measurement, predicted);
            (plus(prior.mean, apply(&gain, innovation)), ln_density(innovation, &innovation_covariance))
        })
        .collect();
    (covariance, updated)
}
