//! The reference over a planar log: one reference for each sensor, with a common state.

use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Slam, no_sensor};
use super::joint_room::{FEATURES, MOVERS};
use super::planar::joint_config;
use crate::settings::{SensorSettings, Settings};
use scphd::JointConfig;
use scphd_log::log::Vehicle;
use scphd_reference as reference;
use scphd_reference::{OwnDraws, Recursion, Reference, joint};
use scphd_score::record::{MapFeature, MovingFeature};

/// The f64 reference with its state and its random number generator.
#[derive(Debug)]
pub struct ReferenceFilter {
    /// The reference of every sensor.
    references: Vec<Reference>,
    state: reference::State,
    draws: OwnDraws,
}

impl ReferenceFilter {
    /// Starts the reference for a log's vehicle at `initial_pose`.
    pub fn start(settings: &Settings, vehicle: &Vehicle, initial_pose: [f64; 3], seed: u64) -> Self {
        let references = references_of(settings, vehicle);
        let state = references[0].initial(initial_pose);
        Self { references, state, draws: OwnDraws::new(seed) }
    }
}

/// The references for all sensors, of which there is at least one.
pub fn references_of(settings: &Settings, vehicle: &Vehicle) -> Vec<Reference> {
    settings.sensors().map(|sensor| of_sensor(settings, sensor, vehicle)).collect()
}

fn of_sensor(settings: &Settings, sensor: &SensorSettings, vehicle: &Vehicle) -> Reference {
    let Settings { filter, vehicle: noise, moving, .. } = settings;
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
            birth_intensity: sensor.birth_factor * filter.birth_intensity,
            clutter_intensity: field_of_view.clutter_intensity(sensor.clutter_per_scan),
            resample_threshold: filter.resample_threshold,
            prune_weight: filter.prune_weight,
            merge_distance: filter.merge_distance,
            max_components: filter.max_components,
            remembering: reference::Remembering {
                detections: filter.confirming_detections,
                weight: filter.confirmed_weight,
            },
            extraction_weight: filter.extraction_weight,
            likelihood: filter.likelihood,
            moving: reference::MovingConfig {
                birth_intensity: sensor.birth_factor * moving.birth_intensity,
                velocity_sigma_mps: moving.velocity_sigma_mps,
                acceleration_psd: moving.acceleration_psd,
                lifetime_s: moving.lifetime_s,
                spread_max_m: moving.spread_max_m,
                extraction_weight: moving.extraction_weight,
            },
        },
        motion: reference::Motion {
            vehicle: vehicle_of(vehicle),
            noise: reference::ControlNoise {
                speed_sigma_mps: noise.speed_sigma_mps,
                second_sigma: noise.turn_sigma,
                speed_ratio: noise.speed_sigma_ratio,
                second_ratio: noise.turn_sigma_ratio,
                interval_s: noise.noise_interval_s * settings.filter.interval_margin,
            },
        },
        mounting: [sensor.forward_m, sensor.left_m, sensor.yaw_rad],
        sensor: reference::RangeBearing {
            range_sigma_m: sensor.range_sigma_m,
            range_sigma_ratio: sensor.range_sigma_ratio,
            bearing_sigma_rad: sensor.bearing_sigma_rad,
        },
        field_of_view,
    }
}

/// Converts the vehicle, because the reference shares no type with the simulator.
fn vehicle_of(vehicle: &Vehicle) -> reference::Vehicle {
    match *vehicle {
        Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            reference::Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m }
        }
        Vehicle::Unicycle => reference::Vehicle::Unicycle,
        Vehicle::UnicycleArc => reference::Vehicle::UnicycleArc,
        Vehicle::Holonomic => reference::Vehicle::Holonomic,
    }
}

/// The references of the joint filter with these settings, one for every sensor.
pub fn joint_references_of(settings: &Settings, vehicle: &Vehicle) -> Vec<joint::Joint<joint::Planar>> {
    let of = |reference| {
        let Reference { config, mut motion, mounting, sensor, field_of_view } = reference;
        motion.noise.interval_s = settings.vehicle.noise_interval_s;
        let clutter_intensity = config.clutter_intensity;
        let moving = config.moving;
        let moving = (moving.birth_intensity > 0.0).then_some(joint::Moving {
            birth_intensity: moving.birth_intensity,
            velocity_sigma_mps: moving.velocity_sigma_mps,
            acceleration_psd: moving.acceleration_psd,
            lifetime_s: moving.lifetime_s,
            spread_max_m: moving.spread_max_m,
            capacity: MOVERS,
        });
        joint::Joint {
            config: joint::Config { moving, ..joint_config_of(&joint_config(&settings.joint), config.birth_intensity) },
            models: joint::Planar { motion, mounting, sensor, field_of_view, clutter_intensity },
        }
    };
    references_of(settings, vehicle).into_iter().map(of).collect()
}

/// The configuration for the reference, with the capacity of the host's state.
pub fn joint_config_of(config: &JointConfig<f64>, birth_intensity: f64) -> joint::Config {
    joint::Config {
        birth_intensity,
        birth_probability_min: config.birth_probability_min,
        gate: config.gate,
        visible_s: config.persistence.visible_s,
        occluded_s: config.persistence.occluded_s,
        lifetime_s: config.persistence.lifetime_s,
        occlusion_factor: config.occlusion_factor,
        least_existence: config.least_existence,
        least_tentative: config.least_tentative,
        merge_distance: config.merge_distance,
        capacity: FEATURES,
        moving: None,
    }
}

impl Slam for ReferenceFilter {
    fn predict(&mut self, control: [f64; 3], dt_s: f64) -> Result<Option<scphd::errors::Implausible>, Refusal> {
        self.references[0].predict(&mut self.state, &control, dt_s, &mut self.draws);
        Ok(None)
    }

    fn scan(&mut self, sensor: usize, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let reference = self.references.get(sensor).ok_or_else(|| no_sensor(sensor))?;
        let outcome = reference.scan(&mut self.state, detections, &mut self.draws);
        let (n_eff, resampled) = (outcome.weighing.n_eff, outcome.selection.resampled);
        Ok(ScanOutcome { n_eff, resampled, ..ScanOutcome::SILENT })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let estimate = self.references[0].estimate(&self.state);
        Ok((estimate.pose, estimate.pose_covariance))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let estimate = self.references[0].estimate(&self.state);
        let features = estimate.features.iter().map(|feature| MapFeature {
            id: 0,
            weight: feature.weight(),
            mean: feature.mean,
            covariance: feature.covariance,
        });
        Ok((estimate.expected_features, features.collect()))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        let estimate = self.references[0].estimate(&self.state);
        let features = estimate.moving.iter().map(|feature| {
            let [x, y, vx, vy] = feature.mean;
            let covariance = std::array::from_fn(|r| std::array::from_fn(|c| feature.covariance[r][c]));
            MovingFeature { id: 0, weight: feature.weight(), position: [x, y], velocity: [vx, vy], covariance }
        });
        Ok(features.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Likelihood;
    use scphd_worlds::scenario;

    #[test]
    fn settings_are_passed_to_the_reference() {
        let mut settings = Settings::for_log(&scenario::survey(1));
        settings.filter.likelihood = Likelihood::RbSingle;
        settings.filter.extraction_weight = 0.4;
        settings.moving.birth_intensity = 0.01;
        settings.moving.spread_max_m = 7.0;
        settings.moving.extraction_weight = 0.6;
        let config = of_sensor(&settings, &settings.sensor, &Vehicle::Unicycle).config;
        assert_eq!((config.likelihood, config.extraction_weight), (Likelihood::RbSingle, 0.4));
        let expected = reference::MovingConfig {
            birth_intensity: 0.01,
            velocity_sigma_mps: 1.0,
            acceleration_psd: 0.1,
            lifetime_s: 100.0,
            spread_max_m: 7.0,
            extraction_weight: 0.6,
        };
        assert_eq!(config.moving, expected);
    }

    #[test]
    fn moving_features_are_reported_at_the_present_time() {
        let mut settings = Settings::for_log(&scenario::survey(1));
        settings.filter.particles = 1;
        settings.moving.birth_intensity = settings.filter.birth_intensity;
        (settings.vehicle.speed_sigma_mps, settings.vehicle.turn_sigma) = (0.0, 0.0);
        let mut filter = ReferenceFilter::start(&settings, &Vehicle::Unicycle, [0.0; 3], 1);
        // A landmark straight ahead that moves away at 1 m/s.
        for k in 0..14 {
            filter.predict([0.0, 0.0, 0.0], 0.5).unwrap();
            filter.scan(0, &[[3.0 + 0.5 * f64::from(k), 0.0]]).unwrap();
        }
        let before = filter.moving().unwrap();
        filter.predict([0.0, 0.0, 0.0], 0.5).unwrap();
        let after = filter.moving().unwrap();
        assert_eq!((before.len(), after.len()), (1, 1));
        let speed = before[0].velocity[0].hypot(before[0].velocity[1]);
        assert!((speed - 1.0).abs() < 0.2, "{before:?}");
        for k in 0..2 {
            let expected = before[0].position[k] + 0.5 * before[0].velocity[k];
            assert!((after[0].position[k] - expected).abs() < 1e-12);
        }
        assert!(after[0].weight < before[0].weight && after[0].covariance[0][0] > before[0].covariance[0][0]);
    }
}
