//! Learning for underwater vehicles.
//!
//! All pixels have a common factor, and so have noises that belong together: the random walk of the velocity and the noise of the
//! Doppler log; the angular acceleration and the noise of the gyroscope. Nothing is learnt about the pressure sensor, whose
//! readings scans do not correct, nor about the turn if the log states the gyroscope's noise in each row.

use super::learn::{Added, CoreEye, Eye, Learn, NoiseOf};
use nalgebra::{Matrix3, Vector3};
use scphd::models::{AuvControl, AuvPose, rotation};
use scphd_filters::slam::{Refusal, refusal};
use scphd_filters::underwater::models::models;
use scphd_filters::underwater::settings::Settings;
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::{Camera, Log};

impl Learn for Underwater {
    const ODOMETRY: [&'static [&'static str]; 2] = [
        &["vehicle.velocity_walk_mps_rts", "vehicle.velocity_sigma_mps"],
        &["vehicle.yaw_acceleration_sigma_radps2", "vehicle.yaw_rate_sigma_radps"],
    ];
    const NOISE: &'static [NoiseOf] =
        &[NoiseOf { fields: &["camera.pixel_sigmas", "camera.common_sigmas"], coordinates: &[0, 1, 2, 3] }];
    const DETECTION: &'static [&'static str] = &["camera.detection"];
    const CLUTTER: &'static str = "camera.clutter_per_scan";

    fn is_simulated(log: &Log) -> bool {
        log.simulated
    }

    /// If the log states the gyroscope's noise in each row, the noise of the turn has no effect.
    fn decides(log: &Log, field: &str) -> bool {
        let stated = log.instruments.iter().all(|row| row.yaw_rate_sigma_radps.is_some());
        !(stated && Self::ODOMETRY[1].contains(&field))
    }

    fn states(_log: &Log, field: &str) -> bool {
        matches!(field, "camera.pixel_sigmas" | "camera.common_sigmas")
    }

    fn scheme(log: &Log) -> Settings {
        Settings::for_log(log)
    }

    /// The volume of the left camera's view between its depths.
    fn view_measure(log: &Log) -> f64 {
        let Camera { projections: [left, _], size_px: [width, height], depth_m: [near, far], .. } = &log.camera;
        let [u, v, ahead] = left.map(|row| Vector3::new(row[0], row[1], row[2]));
        let focal = |row: Vector3<f64>| (row - ahead * row.dot(&ahead)).norm();
        width * height / (focal(u) * focal(v)) * (far.powi(3) - near.powi(3)) / 3.0
    }

    fn reach_m(_log: &Log, settings: &Settings) -> f64 {
        settings.camera.far_m
    }

    fn added(_log: &Log, settings: &Settings, control: &AuvControl<f64>, dt_s: f64) -> Added {
        let noise = &settings.vehicle;
        let level: Matrix3<f64> = rotation(control.roll_rad, control.pitch_rad, 0.0);
        let velocity = level * control.velocity_covariance.to_matrix() * level.transpose();
        // The variance of the turn rate from the angular acceleration after reading the gyroscope, during the step.
        let free = (noise.yaw_acceleration_sigma_radps2 * dt_s).powi(2);
        let read = control.yaw_rate_radps.map_or(f64::INFINITY, |reading| reading.sigma.powi(2));
        let rate = if read.is_finite() { free * read / (free + read) } else { free };
        Added {
            along: velocity[(0, 0)]
                * dt_s
                * if noise.velocity_interval_s > 0.0 { noise.velocity_interval_s } else { dt_s },
            turned: [0.0, rate * dt_s * dt_s],
        }
    }

    fn eye<'a>(log: &'a Log, settings: &'a Settings) -> Result<Box<dyn Eye<Self> + 'a>, Refusal> {
        let sensing = models(log, settings)?.of_filter::<f64>().map_err(refusal)?.sensing;
        Ok(Box::new(CoreEye {
            sensor: sensing.sensor,
            seat: Box::new(|scan: usize, &[x_m, y_m, z_m, yaw_rad, yaw_rate_radps]: &[f64; 5]| {
                // The tilt is that of the last row of the instruments until then, or of the first row.
                let row = log.instruments.partition_point(|row| row.t_s <= log.scans[scan].t_s);
                let tilt = log.instruments.get(row.saturating_sub(1));
                let (roll_rad, pitch_rad) = tilt.map_or((0.0, 0.0), |tilt| (tilt.roll_rad, tilt.pitch_rad));
                (AuvPose { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, roll_rad, pitch_rad }, None)
            }),
            inside: Box::new(|pixels: &[f64; 4]| depth_inside(&log.camera, settings, pixels)),
        }))
    }
}

/// The depth at these pixels, m; `None` near the edges of both images and of the range of depths, or outside.
fn depth_inside(camera: &Camera, settings: &Settings, &[u_l, v_l, u_r, v_r]: &[f64; 4]) -> Option<f64> {
    let own = &settings.camera;
    let edge = own.edge_px.max(2.0 * own.pixel_sigmas[0].hypot(own.common_sigmas[0]));
    let within = |pixel: f64, size: f64| pixel > edge && pixel < size - edge;
    let [width, height] = camera.size_px;
    let depth = camera.focal_baseline / (u_l - u_r);
    let shown = within(u_l, width) && within(u_r, width) && within(v_l, height) && within(v_r, height);
    let deep = depth > own.near_m + own.depth_edge_m && depth < own.far_m - own.depth_edge_m;
    (shown && deep).then_some(depth)
}
