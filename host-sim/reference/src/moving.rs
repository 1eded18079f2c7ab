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

#[cfg(test)]
mod tests {
    use super::super::algebra::identity;
    use super::super::config::MovingConfig;
    use super::super::tests::CONFIG;
    use super::*;

    const MOVING: MovingConfig =
        MovingConfig { acceleration_psd: 0.7, lifetime_s: 20.0, spread_max_m: 50.0, ..CONFIG.moving };

    fn config(moving: MovingConfig) -> Config {
        Config { moving, ..CONFIG }
    }

    fn component() -> Component<4> {
        let covariance = [[0.9, 0.2, 0.3, -0.1], [0.2, 0.7, 0.05, 0.4], [0.3, 0.05, 0.8, 0.1], [-0.1, 0.4, 0.1, 1.1]];
        Component { ln_weight: 0.6f64.ln(), mean: [3.0, -2.0, 0.5, 1.5], covariance }
    }

    #[test]
    fn light_or_uncertain_components_are_dropped_after_the_step_only() {
        let light = Component { ln_weight: (1.01 * CONFIG.prune_weight).ln(), ..component() };
        assert_eq!(predicted(&[light], 0.1, &config(MOVING)).len(), 1);
        assert_eq!(predicted(&[light], 1.0, &config(MOVING)).len(), 0);
        // One coordinate of the position suffices: √(0.7 + …) of y; the velocity does not count.
        let mut wide = Component { covariance: identity(), ..component() };
        wide.covariance[1][1] = 2500.1;
        wide.covariance[2][2] = 1e6;
        assert_eq!(predicted(&[wide], 1e-9, &config(MOVING)).len(), 0);
        wide.covariance[1][1] = 2499.9;
        assert_eq!(predicted(&[wide], 1e-9, &config(MOVING)).len(), 1);
        // For zero time there is no step.
        wide.covariance[1][1] = 1e4;
        let lighter = Component { ln_weight: -99.0, ..component() };
        assert_eq!(predicted(&[wide, lighter], 0.0, &config(MOVING)), [wide, lighter]);
    }
}
