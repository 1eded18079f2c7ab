//! Settings of a run over an underwater log.

use crate::settings::{Extraction, FileProblem, FilterSettings, Likelihood, Origin, OutOfRange, Proposal, file};
use scphd_log::underwater::Log;
use serde::{Deserialize, Serialize};

/// Settings of a run; every field is required here, and optional in the TOML file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The recursion; the birth intensity is per px⁴.
    pub filter: FilterSettings,
    pub vehicle: VehicleSettings,
    pub camera: CameraSettings,
}

/// `[vehicle]`: see [`scphd::models::Auv`] and [`scphd::navigation::VelocityNoise`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSettings {
    /// Random walk of each velocity, (m/s)/√s.
    pub velocity_walk_mps_rts: f64,
    /// Standard deviation of each velocity of the Doppler log, m/s.
    pub velocity_sigma_mps: f64,
    /// Standard deviation of z, m.
    pub z_sigma_m: f64,
    /// Gate of the Doppler log and the pressure sensor, standard deviations.
    pub gate_sigmas: f64,
    /// Number of consecutive outliers after which the Doppler log is used again.
    pub outliers_believed: u16,
    /// Correlation time of the error of the filtered velocity, s.
    pub velocity_interval_s: f64,
    /// Standard deviation of the angular acceleration about the vertical, rad/s².
    pub yaw_acceleration_sigma_radps2: f64,
    /// Standard deviation of the gyroscope's yaw rate, rad/s.
    pub yaw_rate_sigma_radps: f64,
}

/// `[camera]`: see [`scphd::models::StereoCamera`] and [`scphd::models::StereoFrustum`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSettings {
    /// Independent standard deviations of (u_l, v_l, u_r, v_r), px.
    pub pixel_sigmas: [f64; 4],
    /// Standard deviations of the errors that the columns and the rows of both images have in common, px.
    pub common_sigmas: [f64; 2],
    /// Greatest squared distance of a pair from the epipolar constraint, in standard deviations.
    pub epipolar_gate: f64,
    /// Half width of the soft edge around the images, px.
    pub edge_px: f64,
    /// Least depth, m.
    pub near_m: f64,
    /// Greatest depth, m.
    pub far_m: f64,
    /// Half width of the soft edge at either depth, m.
    pub depth_edge_m: f64,
    /// p_D.
    pub detection: f64,
    /// λ, false keypoints a frame.
    pub clutter_per_scan: f64,
}

/// The fields with values stated by a log folder or a scenario: all of instruments and camera for a simulated log, otherwise
/// those of data sheets.
pub fn stated(scenario: bool, log: &Log) -> Vec<(&'static str, Origin)> {
    let by_both =
        ["camera.pixel_sigmas", "camera.common_sigmas", "vehicle.velocity_sigma_mps", "vehicle.yaw_rate_sigma_radps"];
    let by_scenario = ["camera.near_m", "camera.far_m", "vehicle.z_sigma_m", "vehicle.velocity_walk_mps_rts"];
    let by_simulation = ["camera.detection", "camera.clutter_per_scan", "vehicle.yaw_acceleration_sigma_radps2"];
    let all = by_both
        .into_iter()
        .chain(by_scenario.into_iter().filter(|_| scenario))
        .chain(by_simulation.into_iter().filter(|_| scenario && log.simulated));
    all.map(|field| (field, Origin::Stated)).collect()
}

/// κ / w_b: Table 7.1 has 20 false keypoints a frame and a birth intensity of 0.05 features, 400 times less.
const CLUTTER_OVER_BIRTH: f64 = 400.0;

impl Settings {
    /// Table 7.1 with the noise that the log states.
    pub fn for_log(log: &Log) -> Self {
        let nominal = &log.nominal;
        let camera = CameraSettings {
            pixel_sigmas: log.camera.pixel_sigmas,
            common_sigmas: log.camera.common_sigmas,
            epipolar_gate: 16.0,
            edge_px: 4.0 * log.camera.pixel_sigmas[0],
            near_m: log.camera.depth_m[0],
            far_m: log.camera.depth_m[1],
            depth_edge_m: 0.1,
            detection: nominal.detection_probability,
            clutter_per_scan: nominal.clutter_per_scan,
        };
        let mut settings = Self {
            filter: FilterSettings {
                particles: 400,
                samples: 1,
                birth_intensity: 0.0,
                resample_threshold: 0.5,
                prune_weight: 0.0005,
                confirming_detections: 1.0,
                unconfirmed_weight: 0.0,
                confirmed_weight: 0.0,
                merge_distance: 0.5,
                max_components: 12_000,
                extraction: Extraction::Heaviest,
                extraction_weight: 0.5,
                proposal: Proposal::Blind,
                births_wait: false,
                proposal_rounds: 3,
                proposal_sampled_fraction: 1.0,
                proposal_min_responsibility: 0.05,
                interval_margin: 1.0,
                likelihood: Likelihood::SingleCluster,
            },
            vehicle: VehicleSettings {
                velocity_walk_mps_rts: nominal.velocity_walk_mps_rts,
                velocity_sigma_mps: nominal.velocity_sigma_mps,
                z_sigma_m: nominal.z_sigma_m,
                gate_sigmas: 4.0,
                outliers_believed: 5,
                velocity_interval_s: 0.0,
                yaw_acceleration_sigma_radps2: nominal.yaw_acceleration_sigma_radps2,
                yaw_rate_sigma_radps: nominal.yaw_rate_sigma_radps,
            },
            camera,
        };
        settings.filter.birth_intensity = settings.clutter_intensity(log) / CLUTTER_OVER_BIRTH;
        settings.vehicle.velocity_interval_s = settings.velocity_error_lasts_s(log);
        settings
    }

    /// Default settings for a log of a real vehicle: one particle whose pose is the Gaussian of motion and scan. If few landmarks
    /// are in view for long, blind particles spread over the uncertainty of the instruments at random and resampling keeps one of
    /// them; the mean of all is nearer the truth.
    pub fn for_real_log(log: &Log) -> Self {
        let mut settings = Self::for_log(log);
        settings.filter.particles = 1;
        settings.filter.proposal = Proposal::Informed;
        settings.filter.proposal_sampled_fraction = 0.0;
        settings
    }

    /// Correlation time of the velocity error, s, for [`scphd::models::Auv::new`]: twice the time constant of the velocity
    /// filter, σ √Δ / q, for a velocity with noise σ that is measured with the interval Δ and changes by q √t; and at least Δ,
    /// the time for which a measurement is used.
    fn velocity_error_lasts_s(&self, log: &Log) -> f64 {
        let measured = || log.instruments.iter().filter(|row| row.velocity_mps.is_some()).map(|row| row.t_s);
        let mut intervals: Vec<f64> = measured().zip(measured().skip(1)).map(|(from, to)| to - from).collect();
        intervals.sort_by(f64::total_cmp);
        let interval_s = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        let vehicle = &self.vehicle;
        let time_constant_s = vehicle.velocity_sigma_mps * libm::sqrt(interval_s) / vehicle.velocity_walk_mps_rts;
        (2.0 * time_constant_s).max(interval_s)
    }

    /// Disparities at the bounds of the depths, px, the smaller first.
    pub fn disparities_px(&self, log: &Log) -> [f64; 2] {
        [self.camera.far_m, self.camera.near_m].map(|depth| log.camera.focal_baseline / depth)
    }

    /// κ, 1/px⁴: false pairs are uniform over the left image, the disparities, and the row differences within the matcher's
    /// tolerance.
    pub fn clutter_intensity(&self, log: &Log) -> f64 {
        let [least, greatest] = self.disparities_px(log);
        let [width, height] = log.camera.size_px;
        self.camera.clutter_per_scan / (width * height * (greatest - least) * 2.0 * log.camera.row_tolerance_px)
    }

    /// These settings, overridden by the fields in `text`.
    pub fn with_toml(&self, text: &str) -> Result<Self, FileProblem> {
        let settings: Self = file::laid_over(self, file::parsed(text)?)?;
        settings.check()?;
        Ok(settings)
    }

    /// The settings as TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Checks that all fields are in range.
    pub fn check(&self) -> Result<(), OutOfRange> {
        let Self { filter, vehicle, camera } = self;
        let require = |field: &'static str, found: f64, range, holds: bool| {
            if holds { Ok(()) } else { Err(OutOfRange { field: field.into(), found, range }) }
        };
        let positive =
            |field, found: f64| require(field, found, "more than 0 and at most 1e6", found > 0.0 && found <= 1e6);
        let size = |field, found: f64| require(field, found, "0 to 1e6", (0.0..=1e6).contains(&found));
        filter.check()?;
        positive("vehicle.velocity_walk_mps_rts", vehicle.velocity_walk_mps_rts)?;
        positive("vehicle.velocity_sigma_mps", vehicle.velocity_sigma_mps)?;
        positive("vehicle.z_sigma_m", vehicle.z_sigma_m)?;
        positive("vehicle.gate_sigmas", vehicle.gate_sigmas)?;
        positive("vehicle.outliers_believed", f64::from(vehicle.outliers_believed))?;
        size("vehicle.velocity_interval_s", vehicle.velocity_interval_s)?;
        positive("vehicle.yaw_acceleration_sigma_radps2", vehicle.yaw_acceleration_sigma_radps2)?;
        positive("vehicle.yaw_rate_sigma_radps", vehicle.yaw_rate_sigma_radps)?;
        for sigma in camera.pixel_sigmas {
            require("camera.pixel_sigmas", sigma, "1e-3 to 1000 px each", (1e-3..=1e3).contains(&sigma))?;
        }
        for sigma in camera.common_sigmas {
            require("camera.common_sigmas", sigma, "0 to 1000 px each", (0.0..=1e3).contains(&sigma))?;
        }
        positive("camera.epipolar_gate", camera.epipolar_gate)?;
        size("camera.edge_px", camera.edge_px)?;
        size("camera.depth_edge_m", camera.depth_edge_m)?;
        let near = camera.near_m;
        require("camera.near_m", near, "more than camera.depth_edge_m", near > camera.depth_edge_m)?;
        require("camera.far_m", camera.far_m, "more than camera.near_m", camera.far_m > near && camera.far_m <= 1e6)?;
        let detection = camera.detection;
        let holds = detection > 0.0 && detection <= 0.9999;
        require("camera.detection", detection, "more than 0 and at most 0.9999", holds)?;
        positive("camera.clutter_per_scan", camera.clutter_per_scan)
    }

    /// Checks that a feature can be born from this log's pairs of keypoints.
    pub fn check_births(&self, log: &Log) -> Result<(), OutOfRange> {
        self.filter.check_births(self.clutter_intensity(log), 0.0)
    }
}
