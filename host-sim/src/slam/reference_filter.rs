//! The reference over a planar log.

use super::{PoseAndCovariance, Refusal, ScanOutcome, Slam};
use crate::log::Vehicle;
use crate::record::{MapFeature, MovingFeature};
use crate::reference::{self, OwnDraws, Reference};
use crate::settings::Settings;

/// The f64 reference with its state and its own random numbers.
#[derive(Debug)]
pub struct ReferenceFilter {
    reference: Reference,
    state: reference::State,
    draws: OwnDraws,
}

impl ReferenceFilter {
    /// The reference for a log's vehicle, started at `initial_pose`.
    #[must_use]
    pub fn start(settings: &Settings, vehicle: &Vehicle, initial_pose: [f64; 3], seed: u64) -> Self {
        let reference = reference_of(settings, vehicle);
        let state = reference.initial(initial_pose);
        Self { reference, state, draws: OwnDraws::new(seed) }
    }
}

/// The reference with the same models and tuning as the filter that the settings describe.
#[must_use]
pub fn reference_of(settings: &Settings, vehicle: &Vehicle) -> Reference {
    let Settings { filter, vehicle: noise, sensor, moving } = settings;
    let field_of_view = reference::FieldOfView {
        range_min_m: sensor.range_min_m,
        range_max_m: sensor.range_max_m,
        range_edge_m: sensor.range_edge_m,
        bearing_center_rad: sensor.bearing_center_rad(),
        bearing_half_width_rad: sensor.bearing_half_width_rad(),
        bearing_edge_rad: sensor.bearing_edge_rad,
        p_near: sensor.detection_near,
        p_far: sensor.detection_far,
    };
    Reference {
        config: reference::Config {
            particles: filter.particles,
            samples: filter.samples,
            birth_intensity: filter.birth_intensity,
            clutter_intensity: field_of_view.clutter_intensity(sensor.clutter_per_scan),
            resample_threshold: filter.resample_threshold,
            prune_weight: filter.prune_weight,
            merge_distance: filter.merge_distance,
            max_components: filter.max_components,
            extraction_weight: filter.extraction_weight,
            likelihood: filter.likelihood,
            reduction: filter.reduction,
            merge_cost: filter.merge_cost,
            moving: reference::MovingConfig {
                birth_intensity: moving.birth_intensity,
                velocity_sigma_mps: moving.velocity_sigma_mps,
                acceleration_psd: moving.acceleration_psd,
                lifetime_s: moving.lifetime_s,
                spread_max_m: moving.spread_max_m,
            },
        },
        motion: reference::Motion {
            vehicle: *vehicle,
            noise: reference::ControlNoise {
                speed_sigma_mps: noise.speed_sigma_mps,
                second_sigma: noise.turn_sigma,
                speed_ratio: noise.speed_sigma_ratio,
                second_ratio: noise.turn_sigma_ratio,
                interval_s: noise.noise_interval_s,
            },
        },
        sensor: reference::RangeBearing {
            range_sigma_m: sensor.range_sigma_m,
            bearing_sigma_rad: sensor.bearing_sigma_rad,
        },
        field_of_view,
    }
}

impl Slam for ReferenceFilter {
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<(), Refusal> {
        self.reference.predict(&mut self.state, &control, dt_s, &mut self.draws);
        Ok(())
    }

    fn scan(&mut self, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let outcome = self.reference.scan(&mut self.state, detections, &mut self.draws);
        Ok(ScanOutcome {
            n_eff: outcome.weighing.n_eff,
            resampled: outcome.selection.resampled,
            health: scphd::Health::GOOD,
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let estimate = self.reference.estimate(&self.state);
        Ok((estimate.pose, estimate.pose_covariance))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let estimate = self.reference.estimate(&self.state);
        let features = estimate.features.iter().map(|feature| MapFeature {
            id: 0,
            weight: feature.weight(),
            mean: feature.mean,
            covariance: feature.covariance,
        });
        Ok((estimate.expected_features, features.collect()))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        let estimate = self.reference.estimate(&self.state);
        let features = estimate.moving.iter().map(|feature| {
            let [x, y, vx, vy] = feature.mean;
            let covariance = std::array::from_fn(|r| std::array::from_fn(|c| feature.covariance[r][c]));
            MovingFeature { id: 0, weight: feature.weight(), position: [x, y], velocity: [vx, vy], covariance }
        });
        Ok(features.collect())
    }

    fn digest(&mut self) -> Option<u64> {
        None
    }

    fn state_bytes(&self) -> Option<u64> {
        None
    }
}
