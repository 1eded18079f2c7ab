//! Models and tuning of a run as plain numbers, and the filter's types made from them.

use crate::motion::Vehicle;
use bytemuck::{Pod, Zeroable};
use scphd::models::{
    Ackermann, AckermannGeometry, ConstantVelocity, ControlNoise, Mounting, PlanarPose, RangeBearing,
    RangeBearingLimits, RangeBearingWindow, Sensing, Step, Unicycle, UniformClutter,
};
use scphd::settings::{Extraction, Informed, MovingConfig, Plausible, Proposal};
use scphd::{Births, Config, Detector};

/// Values of [`Setup::vehicle`].
pub mod vehicle {
    /// A car: [`scphd::models::Ackermann`].
    pub const ACKERMANN: u32 = 0;
    /// [`scphd::models::Unicycle`] with [`scphd::models::Step::Euler`].
    pub const UNICYCLE: u32 = 1;
    /// [`scphd::models::Unicycle`] with [`scphd::models::Step::Arc`].
    pub const UNICYCLE_ARC: u32 = 2;
}

/// Values of [`Setup::extraction`].
pub mod extraction {
    /// [`scphd::settings::Extraction::Heaviest`].
    pub const HEAVIEST: u32 = 0;
    /// [`scphd::settings::Extraction::Peaks`].
    pub const PEAKS: u32 = 1;
    /// [`scphd::settings::Extraction::Confirmed`].
    pub const CONFIRMED: u32 = 2;
}

/// Value of [`Setup::is_mounted`] if the sensor has its own pose on the vehicle.
pub const MOUNTED: u32 = 1;

/// Models and tuning. Every field corresponds to the field of the same name in `scphd`'s own types. There is no padding.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the types of the library document them")]
pub struct Setup {
    /// The vehicle, one of [`vehicle`].
    pub vehicle: u32,
    pub wheelbase_m: f32,
    pub encoder_offset_m: f32,
    pub sensor_forward_m: f32,
    pub sensor_left_m: f32,
    pub speed_sigma_mps: f32,
    pub speed_sigma_ratio: f32,
    pub turn_sigma: f32,
    pub turn_sigma_ratio: f32,
    pub noise_interval_s: f32,
    /// Pose at the start: x, y, m, and heading, rad.
    pub start: [f32; 3],
    pub range_sigma_m: f32,
    pub bearing_sigma_rad: f32,
    pub range_min_m: f32,
    pub range_max_m: f32,
    pub range_edge_m: f32,
    pub bearing_center_rad: f32,
    pub bearing_half_width_rad: f32,
    pub bearing_edge_rad: f32,
    pub probability_near: f32,
    pub probability_far: f32,
    pub clutter_per_scan: f32,
    /// [`MOUNTED`], or 0.
    pub is_mounted: u32,
    /// Pose of the sensor: forward, left, m, and its rotation to the left, rad.
    pub mounting: [f32; 3],
    pub births_of_static: f32,
    pub births_of_moving: f32,
    pub particles: u32,
    pub samples: u32,
    /// Number of linearisations of the informed proposal; 0 for the blind proposal.
    pub proposal_rounds: u32,
    pub sampled_fraction: f32,
    pub min_responsibility: f32,
    pub resample_threshold: f32,
    pub prune_weight: f32,
    pub confirming_detections: f32,
    pub unconfirmed_weight: f32,
    pub confirmed_weight: f32,
    pub merge_distance: f32,
    pub max_components: u32,
    /// The extraction, one of [`extraction`].
    pub extraction: u32,
    pub extraction_weight: f32,
    pub velocity_sigma_mps: f32,
    pub acceleration_psd: f32,
    pub lifetime_s: f32,
    pub spread_max_m: f32,
    pub moving_extraction_weight: f32,
    pub negligible: f32,
    pub step_max_s: f32,
    pub speed_max_mps: f32,
    pub turn_rate_max_radps: f32,
    pub jump_max_m: f32,
}

/// The sensor of a run.
pub(crate) type Models = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// The parts of a filter.
pub(crate) struct Made {
    pub(crate) vehicle: Vehicle,
    pub(crate) config: Config<f32>,
    pub(crate) detector: Detector<Models>,
    pub(crate) start: PlanarPose<f32>,
}

impl Setup {
    /// The models and the tuning; `None` if one of them is out of range.
    pub(crate) fn make(&self) -> Option<Made> {
        let [x_m, y_m, heading_rad] = self.start;
        Some(Made {
            vehicle: self.motion()?,
            config: self.config()?,
            detector: self.detector()?,
            start: PlanarPose::new(x_m, y_m, heading_rad),
        })
    }

    fn motion(&self) -> Option<Vehicle> {
        let noise = ControlNoise {
            speed_sigma_mps: self.speed_sigma_mps,
            speed_sigma_ratio: self.speed_sigma_ratio,
            turn_sigma: self.turn_sigma,
            turn_sigma_ratio: self.turn_sigma_ratio,
            interval_s: self.noise_interval_s,
        };
        let step = match self.vehicle {
            vehicle::ACKERMANN => {
                let geometry = AckermannGeometry {
                    wheelbase_m: self.wheelbase_m,
                    encoder_offset_m: self.encoder_offset_m,
                    sensor_forward_m: self.sensor_forward_m,
                    sensor_left_m: self.sensor_left_m,
                };
                return Ackermann::new(geometry, noise).ok().map(Vehicle::Car);
            }
            vehicle::UNICYCLE => Step::Euler,
            vehicle::UNICYCLE_ARC => Step::Arc,
            _ => return None,
        };
        Unicycle::new(step, noise).ok().map(Vehicle::Robot)
    }

    fn detector(&self) -> Option<Detector<Models>> {
        let limits = RangeBearingLimits {
            range_min_m: self.range_min_m,
            range_max_m: self.range_max_m,
            range_edge_m: self.range_edge_m,
            bearing_center_rad: self.bearing_center_rad,
            bearing_half_width_rad: self.bearing_half_width_rad,
            bearing_edge_rad: self.bearing_edge_rad,
            probability_near: self.probability_near,
            probability_far: self.probability_far,
        };
        let field_of_view = RangeBearingWindow::new(limits).ok()?;
        let sensing = Sensing {
            sensor: RangeBearing::new(self.range_sigma_m, self.bearing_sigma_rad).ok()?,
            field_of_view,
            clutter: UniformClutter::of_scan(self.clutter_per_scan, field_of_view.measure()).ok()?,
        };
        let births = Births { of_static: self.births_of_static, of_moving: self.births_of_moving };
        let detector = Detector::new(sensing, births).ok()?;
        if self.is_mounted != MOUNTED {
            return Some(detector);
        }
        let [forward_m, left_m, yaw_rad] = self.mounting;
        detector.mounted(Mounting::in_plane(forward_m, left_m, yaw_rad).ok()?).ok()
    }

    fn config(&self) -> Option<Config<f32>> {
        let whole = |number: u32| usize::try_from(number).ok();
        Some(Config {
            particles: whole(self.particles)?,
            samples: whole(self.samples)?,
            proposal: match whole(self.proposal_rounds)? {
                0 => Proposal::Blind,
                rounds => Proposal::Informed(Informed {
                    rounds,
                    sampled_fraction: self.sampled_fraction,
                    min_responsibility: self.min_responsibility,
                }),
            },
            resample_threshold: self.resample_threshold,
            prune_weight: self.prune_weight,
            confirming_detections: self.confirming_detections,
            unconfirmed_weight: self.unconfirmed_weight,
            confirmed_weight: self.confirmed_weight,
            merge_distance: self.merge_distance,
            max_components: whole(self.max_components)?,
            extraction: match self.extraction {
                extraction::HEAVIEST => Extraction::Heaviest,
                extraction::PEAKS => Extraction::Peaks,
                extraction::CONFIRMED => Extraction::Confirmed,
                _ => return None,
            },
            extraction_weight: self.extraction_weight,
            moving: MovingConfig {
                velocity_sigma_mps: self.velocity_sigma_mps,
                motion: ConstantVelocity { acceleration_psd: self.acceleration_psd, lifetime_s: self.lifetime_s },
                spread_max_m: self.spread_max_m,
                extraction_weight: self.moving_extraction_weight,
            },
            negligible: self.negligible,
            births_wait: false,
            plausible: Plausible {
                step_max_s: self.step_max_s,
                speed_max_mps: self.speed_max_mps,
                turn_rate_max_radps: self.turn_rate_max_radps,
                jump_max_m: self.jump_max_m,
            },
        })
    }
}
