//! `PreUpdate` of appendix A: the Kalman update of every component in view with every measurement.

use super::algebra::{apply, difference, identity, inverse, plus, product, sum, symmetrised, transformed, transpose};
use super::field_of_view::FieldOfView;
use super::gaussian::{Component, Density, Matrix, Vector};
use super::sensor::Sensor;
use std::array::from_fn;

/// A component in view with its update by each measurement.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InView<const N: usize> {
    /// The predicted component.
    pub(super) prior: Component<N>,
    /// p_D at its mean.
    pub(super) detection_probability: f64,
    /// P⁺, the same for every measurement (5.21).
    pub(super) covariance: [[f64; N]; N],
    /// For each measurement: m⁺ (5.20) and ln N(z; ẑ, S).
    pub(super) updated: Vec<([f64; N], f64)>,
    /// ln(p_D w).
    ln_detected: f64,
}

impl<const N: usize> InView<N> {
    pub(super) fn new(
        prior: Component<N>,
        detection_probability: f64,
        covariance: [[f64; N]; N],
        updated: Vec<([f64; N], f64)>,
    ) -> Self {
        let ln_detected = detection_probability.ln() + prior.ln_weight;
        Self { prior, detection_probability, covariance, updated, ln_detected }
    }

    /// ln(p_D w N(z; ẑ, S)) for a measurement: the component's part of η_z.
    pub(super) fn ln_detection(&self, measurement: usize) -> f64 {
        self.ln_detected + self.updated[measurement].1
    }
}

/// The static or the moving part of a map as seen from a pose.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PreUpdate<const N: usize> {
    /// V: the components that may be detected.
    pub(super) in_view: Vec<InView<N>>,
    pub(super) out_of_view: Vec<Component<N>>,
}

/// Splits a map by the field of view and updates each component in it with each measurement.
pub(super) fn pre_update<const N: usize, S: Sensor>(
    map: &[Component<N>],
    pose: [f64; 3],
    measurements: &[Vector],
    sensor: &S,
    field_of_view: &FieldOfView,
) -> PreUpdate<N> {
    let mut result = PreUpdate { in_view: Vec::new(), out_of_view: Vec::new() };
    for &prior in map {
        let detection_probability = field_of_view.detection_probability(prior.position(), pose);
        match sensor.predicted(prior.position(), pose) {
            Some((predicted, by_position)) if detection_probability > 0.0 => {
                let jacobian = by_state(&by_position);
                let (covariance, gain, innovation_covariance) = kalman(&prior, &jacobian, &sensor.noise(predicted));
                let density = Density::new(&innovation_covariance);
                let updated = measurements.iter().map(|&measurement| {
                    let innovation = sensor.innovation(measurement, predicted);
                    (plus(prior.mean, apply(&gain, innovation)), density.ln(innovation))
                });
                result.in_view.push(InView::new(prior, detection_probability, covariance, updated.collect()));
            }
            _ => result.out_of_view.push(prior),
        }
    }
    result
}

/// H = [∂h/∂p, 0]: only the position is measured.
fn by_state<const N: usize>(by_position: &Matrix) -> [[f64; N]; 2] {
    by_position.map(|row| from_fn(|column| if column < 2 { row[column] } else { 0.0 }))
}

/// P⁺, the gain K and S.
pub(super) type Kalman<const N: usize, const M: usize> = ([[f64; N]; N], [[f64; M]; N], [[f64; M]; M]);

/// P⁺, the gain K and S (5.20–5.22).
pub(super) fn kalman<const N: usize, const M: usize>(
    prior: &Component<N>,
    jacobian: &[[f64; N]; M],
    noise: &[[f64; M]; M],
) -> Kalman<N, M> {
    let innovation_covariance = sum(&transformed(jacobian, &prior.covariance), noise);
    let gain = product(&product(&prior.covariance, &transpose(jacobian)), &inverse(&innovation_covariance));
    let covariance = symmetrised(&product(&difference(&identity(), &product(&gain, jacobian)), &prior.covariance));
    (covariance, gain, innovation_covariance)
}
