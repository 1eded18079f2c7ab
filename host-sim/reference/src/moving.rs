//! Motion of features between scans: constant velocity with white noise acceleration.

use super::algebra::{apply, sum, transformed};
use super::config::Config;
use super::gaussian::Component;
use super::reduce::heavy_enough;
use std::array::from_fn;

/// The moving part of a map after `dt` seconds: all components predicted, without those that are too light or too uncertain (5.14
/// with F, Q and p_S = exp(−dt/τ)). For `dt` = 0 it is not changed.
pub(super) fn predicted(map: &[Component<4>], dt: f64, config: &Config) -> Vec<Component<4>> {
    if dt == 0.0 {
        return map.to_vec();
    }
    let moving = &config.moving;
    let (transition, noise) = (transition(dt), noise(moving.acceleration_psd, dt));
    map.iter()
        .map(|component| Component {
            ln_weight: component.ln_weight - dt / moving.lifetime_s,
            mean: apply(&transition, component.mean),
            covariance: sum(&transformed(&transition, &component.covariance), &noise),
        })
        .filter(|c| heavy_enough(c, config.prune_weight))
        .filter(|c| (0..2).all(|k| c.covariance[k][k].sqrt() <= moving.spread_max_m))
        .collect()
}

/// F = [I, dt·I; 0, I].
fn transition(dt: f64) -> [[f64; 4]; 4] {
    blocks([[1.0, dt], [0.0, 1.0]])
}

/// Q = q [dt³/3·I, dt²/2·I; dt²/2·I, dt·I].
fn noise(density: f64, dt: f64) -> [[f64; 4]; 4] {
    let cross = density * dt.powi(2) / 2.0;
    blocks([[density * dt.powi(3) / 3.0, cross], [cross, density * dt]])
}

/// The matrix of 2×2 blocks with these multiples of I.
fn blocks(factors: [[f64; 2]; 2]) -> [[f64; 4]; 4] {
    from_fn(|row| from_fn(|column| if row % 2 == column % 2 { factors[row / 2][column / 2] } else { 0.0 }))
}
