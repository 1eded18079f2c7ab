//! Underwater vehicles with a stereo camera.

use super::{Kind, View};
use crate::settings::{FileProblem, FilterSettings, OutOfRange};
use crate::slam::{
    Filter, NoFixes, Refusal, Slam, WatchesFixes, refusal, underwater_core_filter, underwater_joint_filter,
};
use crate::underwater::models::models;
use crate::underwater::settings::Settings;
use crate::underwater::timeline::{Step, Timeline};
use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};
use scphd::models::rotation;
use scphd::navigation::DeadReckoning;
use scphd_log::dimensions::Underwater;
use scphd_log::events::Event;
use scphd_log::log::{MovingLandmark, Scan, TruePose};
use scphd_log::underwater::{Instruments, Log};

impl Kind for Underwater {
    type Log = Log;
    type Settings = Settings;

    /// Comparing a map of hundreds of features takes long.
    const SCANS_A_MAP_ERROR: usize = 200;

    fn name(log: &Log) -> &str {
        &log.name
    }

    fn scans(log: &Log) -> &[Scan<Self>] {
        &log.scans
    }

    fn truth(log: &Log) -> &[TruePose<Self>] {
        &log.truth
    }

    fn truth_sigma_m(_log: &Log) -> f64 {
        0.0
    }

    fn landmarks(log: &Log) -> Vec<[f64; 3]> {
        log.stable().collect()
    }

    fn seldom(log: &Log) -> Vec<[f64; 3]> {
        let seldom = log.landmarks.iter().filter(|landmark| !landmark.is_stable());
        seldom.map(|landmark| landmark.position).collect()
    }

    fn moving(_log: &Log) -> Option<&[MovingLandmark<Self>]> {
        None
    }

    fn start(log: &Log) -> [f64; 3] {
        log.start.0
    }

    /// A landmark is in view if it is in both images, in the range of depths, with the roll and pitch of the instruments.
    fn view<'a>(log: &'a Log, _settings: &Settings) -> View<'a, Self> {
        let cameras: [SMatrix<f64, 3, 4>; 2] =
            log.camera.projections.map(|p| SMatrix::from_fn(|row, column| p[row][column]));
        let ([width, height], [near, far]) = (log.camera.size_px, log.camera.depth_m);
        Box::new(move |pose, point| {
            let row = log.instruments.partition_point(|row| row.t_s <= pose.t_s);
            let tilt = &log.instruments[row.checked_sub(1)?];
            let turned: Matrix3<f64> = rotation(tilt.roll_rad, tilt.pitch_rad, pose.heading_rad?);
            let point = turned.tr_mul(&(Vector3::from(point) - Vector3::from(pose.position)));
            Some(cameras.iter().all(|camera| {
                let pixel = camera * Vector4::new(point.x, point.y, point.z, 1.0);
                let (u, v) = (pixel.x / pixel.z, pixel.y / pixel.z);
                (near..=far).contains(&pixel.z) && (0.0..=width).contains(&u) && (0.0..=height).contains(&v)
            }))
        })
    }

    /// For two cameras side by side: the disparity gives the depth, and the left pixel the direction.
    fn place(
        log: &Log,
        _settings: &Settings,
        scan: usize,
        pose: &[f64; 5],
        pixels: &[f64; 4],
    ) -> Option<([f64; 3], f64)> {
        let [x, y, z, yaw, _] = *pose;
        let camera = &log.camera;
        let row = log.instruments.partition_point(|row| row.t_s <= log.scans[scan].t_s);
        let tilt = &log.instruments[row.checked_sub(1)?];
        let depth_m = camera.focal_baseline / (pixels[0] - pixels[2]);
        if !(depth_m > 0.0 && depth_m < 10.0 * camera.depth_m[1]) {
            return None;
        }
        let left = &camera.projections[0];
        let turn: Matrix3<f64> = Matrix3::from_fn(|row, column| left[row][column]);
        let seen = depth_m * Vector3::new(pixels[0], pixels[1], 1.0) - Vector3::from_fn(|row, _| left[row][3]);
        let place = rotation(tilt.roll_rad, tilt.pitch_rad, yaw) * (turn.try_inverse()? * seen) + Vector3::new(x, y, z);
        let of_disparity = libm::hypot(camera.pixel_sigmas[0], camera.pixel_sigmas[2]);
        let across = libm::hypot(camera.pixel_sigmas[0], camera.common_sigmas[0])
            .max(libm::hypot(camera.pixel_sigmas[1], camera.common_sigmas[1]));
        // A row of the calibration is a rotation times (fu, cu): the two parts are orthogonal.
        let focal = libm::sqrt((turn.row(0).norm_squared() - turn.row(0).dot(&turn.row(2)).powi(2)).max(1.0));
        let sigma_m = (depth_m * depth_m / camera.focal_baseline * of_disparity).max(depth_m / focal * across);
        Some((place.into(), sigma_m))
    }

    fn events(log: &Log, settings: &Settings) -> Result<Vec<Event<Self>>, Refusal> {
        let mut navigator = models(log, settings)?.navigator().map_err(refusal)?;
        let mut timeline = Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps);
        let (mut events, mut row) = (Vec::new(), 0);
        for (index, scan) in log.scans.iter().enumerate() {
            for step in timeline.steps_to(scan.t_s) {
                if let Some((control, dt_s)) = step.navigation.control(&mut navigator).map_err(refusal)? {
                    events.push(Event::Predict { row, control, dt_s });
                }
                row = timeline.row();
            }
            events.push(Event::Scan { index });
        }
        Ok(events)
    }

    fn row_t_s(log: &Log, row: usize) -> f64 {
        log.instruments[row].t_s
    }

    fn dead_reckoning(log: &Log, settings: &Settings) -> Result<Vec<[f64; 3]>, Refusal> {
        let models = models(log, settings)?;
        let start = Vector3::from(models.start_m);
        let mut reckoning = DeadReckoning::new(models.velocity_noise(), start).map_err(refusal)?;
        let mut timeline = Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps);
        let mut last: Option<&Instruments> = None;
        let place = |scan: &Scan<Self>| {
            for Step { navigation, row } in timeline.steps_to(scan.t_s) {
                if let Some(last) = last {
                    reckoning.predict(last.roll_rad, last.pitch_rad, last.yaw_rad, navigation.dt_s);
                }
                if let Some(row) = row {
                    if let Some(velocity) = row.velocity_mps {
                        reckoning.dvl(&Vector3::from(velocity));
                    }
                    if let Some(z_m) = row.z_m {
                        reckoning.z(z_m);
                    }
                    last = Some(row);
                }
            }
            reckoning.position_m().into()
        };
        Ok(log.scans.iter().map(place).collect())
    }

    fn slam(filter: Filter, log: &Log, settings: &Settings, seed: u64) -> Result<Box<dyn Slam<Self>>, Refusal> {
        match filter {
            Filter::Core(precision) => Ok(underwater_core_filter(log, settings, precision, seed)?),
            Filter::Joint(precision) => Ok(underwater_joint_filter(log, settings, precision)?),
            Filter::Reference => Err(Refusal("in space the reference runs in lockstep only: scphd-sim compare".into())),
            Filter::Ekf(_) => Err(Refusal("the EKF is of the plane alone".into())),
        }
    }

    fn fix_watch(_settings: &Settings) -> Result<Box<dyn WatchesFixes<Self>>, Refusal> {
        Ok(Box::new(NoFixes))
    }

    fn recursion(settings: &Settings) -> &FilterSettings {
        &settings.filter
    }

    fn recursion_mut(settings: &mut Settings) -> &mut FilterSettings {
        &mut settings.filter
    }

    fn unexplained_per_scan(log: &Log, settings: &Settings) -> f64 {
        // Births per px⁴, over the same pixels as uniform clutter.
        let measure = settings.camera.clutter_per_scan / settings.clutter_intensity(log);
        settings.camera.clutter_per_scan + settings.filter.birth_intensity * measure
    }

    fn of_reference(log: &Log) -> Settings {
        Settings::for_log(log)
    }

    fn with_toml(settings: &Settings, text: &str) -> Result<Settings, FileProblem> {
        settings.with_toml(text)
    }

    fn check(log: &Log, settings: &Settings) -> Result<(), OutOfRange> {
        settings.check()?;
        settings.check_births(log)
    }
}
