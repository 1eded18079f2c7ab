//! The head of a stream from the description of a vehicle.

use super::{Models, Odometry, Planar, Sensor, SensorModels, Vehicle};
use crate::header::{Extraction, Header, Joint, Moving, Proposal, UNKNOWN};
use crate::numbers::Numbers;
use crate::onboard::{config, moving_config};
use crate::scalar::Scalar;
use core::fmt;
use scphd::settings::{self, Informed, MovingConfig};
use scphd::{Config, Real};
use scphd_vehicle::{Control, Description, Filter, JointSettings, SensorModel, VehicleKind};

/// The error of a description with a part that streams do not record: a replay would end in another state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotRecorded {
    /// The setting, or the group of settings.
    pub setting: &'static str,
}

impl fmt::Display for NotRecorded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "streams do not record {}", self.setting)
    }
}

impl core::error::Error for NotRecorded {}

fn recorded(is_recorded: bool, setting: &'static str) -> Result<(), NotRecorded> {
    if is_recorded { Ok(()) } else { Err(NotRecorded { setting }) }
}

impl Header<Planar> {
    /// The head for the recording of a filter that is built from a description, with numbers of type `scalar` in the records. Its
    /// sensor is the first one; the others are recorded with [`Writer::detector`](crate::Writer::detector). A start with a covariance,
    /// and what a monitor of fixes decides, is recorded with [`Writer::place`](crate::Writer::place).
    ///
    /// # Errors
    /// The first part that streams do not record.
    pub fn of<T: Real>(description: &Description<T>, scalar: Scalar) -> Result<Self, NotRecorded> {
        let Description { vehicle, start, .. } = description;
        let kind = match vehicle.kind {
            VehicleKind::Ackermann => Vehicle::Ackermann,
            VehicleKind::UnicycleEuler => Vehicle::Unicycle,
            VehicleKind::Unicycle => Vehicle::UnicycleArc,
            VehicleKind::Holonomic => return Err(NotRecorded { setting: "a holonomic vehicle" }),
        };
        let first = description.sensors.iter().flatten().next().map(Sensor::of).transpose()?.unwrap_or(Sensor::ZERO);
        let noise = vehicle.noise;
        let mut models = Models {
            start_x_m: start.pose.x_m.to_f64(),
            start_y_m: start.pose.y_m.to_f64(),
            start_heading_rad: start.pose.heading_rad.to_f64(),
            speed_sigma_mps: noise.speed_sigma_mps.to_f64(),
            speed_sigma_ratio: noise.speed_sigma_ratio.to_f64(),
            turn_sigma: noise.turn_sigma.to_f64(),
            turn_sigma_ratio: noise.turn_sigma_ratio.to_f64(),
            noise_interval_s: noise.interval_s.to_f64(),
            sensor: first.models,
            ..Models::ZERO
        };
        if kind == Vehicle::Ackermann {
            models.wheelbase_m = vehicle.geometry.wheelbase_m.to_f64();
            models.encoder_offset_m = vehicle.geometry.encoder_offset_m.to_f64();
            models.sensor_forward_m = vehicle.geometry.sensor_forward_m.to_f64();
            models.sensor_left_m = vehicle.geometry.sensor_left_m.to_f64();
        }
        let mut head = Self { scalar, vehicle: kind, models, seed: start.seed, ..Self::EMPTY };
        match &description.filter {
            Filter::Mixture(config) => head.tune(config)?,
            Filter::Joint(joint) => head.tune_joint(joint)?,
        }
        head.recursion.birth_intensity = first.birth_intensity;
        head.moving.birth_intensity = first.moving_birth_intensity;
        let moving = match &description.filter {
            Filter::Mixture(config) => Some(config.moving),
            Filter::Joint(joint) => joint.movers,
        };
        // A head whose own sensor bears none does not record them.
        let bears = description.sensors.iter().flatten().any(|sensor| sensor.births.of_moving > T::ZERO);
        recorded(!bears || moving.is_none_or(|moving| moving == moving_config(&head.moving)), "sensor.births_moving")?;
        Ok(head)
    }

    /// Sets the tuning of a mixture.
    fn tune<T: Real>(&mut self, of: &Config<T>) -> Result<(), NotRecorded> {
        let count = |number: usize| u32::try_from(number).unwrap_or(UNKNOWN);
        (self.particles, self.samples) = (count(of.particles), count(of.samples));
        self.max_components = count(of.max_components);
        self.births_wait = of.births_wait;
        self.extraction = match of.extraction {
            settings::Extraction::Heaviest => Extraction::Heaviest,
            settings::Extraction::Peaks => Extraction::Peaks,
            settings::Extraction::Confirmed => Extraction::Confirmed,
        };
        let recursion = &mut self.recursion;
        if let settings::Proposal::Informed(Informed { rounds, sampled_fraction, min_responsibility }) = of.proposal {
            self.proposal = Proposal::Informed;
            recursion.proposal_rounds = rounds as f64;
            recursion.proposal_sampled_fraction = sampled_fraction.to_f64();
            recursion.proposal_min_responsibility = min_responsibility.to_f64();
        }
        recursion.resample_threshold = of.resample_threshold.to_f64();
        recursion.prune_weight = of.prune_weight.to_f64();
        recursion.confirming_detections = of.confirming_detections.to_f64();
        recursion.unconfirmed_weight = of.unconfirmed_weight.to_f64();
        recursion.confirmed_weight = of.confirmed_weight.to_f64();
        recursion.merge_distance = of.merge_distance.to_f64();
        recursion.extraction_weight = of.extraction_weight.to_f64();
        self.moving = Moving::of(&of.moving);
        let read = Config { max_components: of.max_components, moving: of.moving, ..config(self) };
        recorded(read == *of, "mixture.negligible and plausible")
    }

    /// Sets the tuning of a joint map.
    fn tune_joint<T: Real>(&mut self, of: &JointSettings<T>) -> Result<(), NotRecorded> {
        recorded(of.odometry.is_none(), "joint.odometry")?;
        self.joint = Joint {
            archive_reach_m: of.archive_reach_m.map_or(0.0, T::to_f64),
            ..Joint::of(&of.config, &of.hypotheses.unwrap_or_default())
        };
        self.moving = of.movers.as_ref().map_or(Moving::ZERO, Moving::of);
        recorded(self.joint.config() == of.config, "plausible")
    }
}

impl Moving {
    /// The tuning for moving features, without births.
    fn of<T: Real>(config: &MovingConfig<T>) -> Self {
        Self {
            birth_intensity: 0.0,
            velocity_sigma_mps: config.velocity_sigma_mps.to_f64(),
            acceleration_psd: config.motion.acceleration_psd.to_f64(),
            lifetime_s: config.motion.lifetime_s.to_f64(),
            spread_max_m: config.spread_max_m.to_f64(),
            extraction_weight: config.extraction_weight.to_f64(),
        }
    }
}

impl Sensor {
    /// A sensor of a description.
    ///
    /// # Errors
    /// It measures bearings only, or its noise grows with the range.
    pub fn of<T: Real>(sensor: &scphd_vehicle::Sensor<T>) -> Result<Self, NotRecorded> {
        recorded(sensor.model == SensorModel::RangeBearing, "bearings")?;
        recorded(sensor.range_sigma_ratio == T::ZERO, "sensor.range_sigma_ratio")?;
        let (window, [forward_m, left_m]) = (sensor.window, sensor.seat_m);
        Ok(Self {
            models: SensorModels {
                mounted_forward_m: forward_m.to_f64(),
                mounted_left_m: left_m.to_f64(),
                mounted_yaw_rad: sensor.yaw_rad.to_f64(),
                range_sigma_m: sensor.range_sigma_m.to_f64(),
                bearing_sigma_rad: sensor.bearing_sigma_rad.to_f64(),
                range_min_m: window.range_min_m.to_f64(),
                range_max_m: window.range_max_m.to_f64(),
                range_edge_m: window.range_edge_m.to_f64(),
                bearing_center_rad: window.bearing_center_rad.to_f64(),
                bearing_half_width_rad: window.bearing_half_width_rad.to_f64(),
                bearing_edge_rad: window.bearing_edge_rad.to_f64(),
                detection_near: window.probability_near.to_f64(),
                detection_far: window.probability_far.to_f64(),
                clutter_per_scan: sensor.clutter_per_scan.to_f64(),
            },
            birth_intensity: sensor.births.of_static.to_f64(),
            moving_birth_intensity: sensor.births.of_moving.to_f64(),
        })
    }
}

impl Odometry {
    /// A prediction with this control. The lateral speed of a holonomic vehicle is not recorded.
    #[must_use]
    pub fn of<T: Real>(control: Control<T>, dt_s: T) -> Self {
        Self { control: [control.speed_mps, control.turn].map(T::to_f64), dt_s: dt_s.to_f64() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::models::{OdometryCorrection, OdometryPrior};
    use std::string::ToString;

    fn robot() -> Description<f32> {
        let mut robot = Description::robot();
        robot.sensors[2] = Some(scphd_vehicle::Sensor::range_bearing(12.0, 0.9, [0.1, 0.01]));
        robot
    }

    fn refused(change: impl FnOnce(&mut Description<f32>)) -> &'static str {
        let mut robot = robot();
        change(&mut robot);
        Header::of(&robot, Scalar::F32).map(drop).expect_err("a replay would end in another state").setting
    }

    #[test]
    fn the_tuning_of_a_mixture_is_recorded() {
        let mut robot = robot();
        let tuned = Config { births_wait: true, samples: 3, ..Config::informed(5) };
        robot.filter = Filter::Mixture(tuned);
        let head = Header::of(&robot, Scalar::F32).unwrap();
        let read: Config<f32> = config(&head);
        assert_eq!(Config { max_components: tuned.max_components, ..read }, Config { moving: read.moving, ..tuned });
        assert_eq!((head.models.sensor.range_max_m, head.seed), (12.0, 1));
    }

    #[test]
    fn what_streams_do_not_record_is_refused_by_name() {
        let joint = |description: &mut Description<f32>, change: fn(&mut JointSettings<f32>)| {
            let Filter::Joint(joint) = &mut description.filter else { unreachable!() };
            change(joint);
        };
        assert_eq!(refused(|d| d.vehicle.kind = VehicleKind::Holonomic), "a holonomic vehicle");
        assert_eq!(refused(|d| d.sensors[2].as_mut().unwrap().model = SensorModel::Bearing), "bearings");
        let growing = refused(|d| d.sensors[2].as_mut().unwrap().range_sigma_ratio = 0.1);
        assert_eq!(growing, "sensor.range_sigma_ratio");
        let calibrated = refused(|d| {
            joint(d, |joint| {
                joint.odometry = Some(OdometryPrior {
                    sigma: OdometryCorrection { speed_scale: 0.1, turn_scale: 0.1, turn_offset: 0.1 },
                    lasts_s: 60.0,
                })
            })
        });
        assert_eq!(calibrated, "joint.odometry");
        let slow = refused(|d| joint(d, |joint| joint.config.plausible.speed_max_mps = 7.0));
        assert_eq!(slow, "plausible");
        let negligible = Config { negligible: 1e-9, ..Config::informed(1) };
        assert!(refused(|d| d.filter = Filter::Mixture(negligible)).contains("negligible"));
        let elsewhere = |d: &mut Description<f32>| {
            let bears = scphd_vehicle::Sensor {
                births: scphd::Births { of_static: 0.1, of_moving: 0.1 },
                ..d.sensors[2].unwrap()
            };
            d.sensors[3] = Some(bears);
            joint(d, |joint| joint.movers = Some(MovingConfig { velocity_sigma_mps: 9.0, ..MovingConfig::walkers() }));
        };
        assert_eq!(refused(elsewhere), "sensor.births_moving");
        assert_eq!(NotRecorded { setting: "bearings" }.to_string(), "streams do not record bearings");
    }
}
