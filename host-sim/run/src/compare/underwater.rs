//! Lockstep in space.

use super::joint::drive as drive_joint;
use super::{Comparable, Comparison, JointComparison, Lockstep, drive};
use scphd::models::{AuvControl, Reading};
use scphd_filters::slam::{
    Precision, Refusal, full, joint_config_of, underwater_core_filter as core_filter, underwater_joint_config,
    underwater_joint_filter as joint_filter,
};
use scphd_filters::underwater::settings::Settings;
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::Log;
use scphd_reference::joint;
use scphd_reference::space::{self, Space};
use scphd_reference::{Config, MovingConfig, Remembering};

impl Comparable<Underwater, 3, 6> for Space {
    fn control(control: &AuvControl<f64>) -> space::Control {
        let reading = |reading: Reading<f64>| [reading.value, reading.sigma];
        space::Control {
            velocity: control.velocity_mps.into(),
            covariance: full(&control.velocity_covariance),
            tilt: [control.roll_rad, control.pitch_rad],
            yaw_rate: control.yaw_rate_radps.map(reading),
            z: control.z_m.map(reading),
        }
    }

    fn coordinates(pose: &space::Pose) -> [f64; 5] {
        let [x, y, z] = pose.position;
        [x, y, z, pose.yaw, pose.yaw_rate]
    }
}

impl Lockstep for Underwater {
    fn lockstep(
        log: &Log,
        settings: &Settings,
        precision: Precision,
        seed: u64,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Comparison, Refusal> {
        let space = reference_of(log, settings);
        let mut filter = core_filter(log, settings, precision, seed)?;
        drive(log, settings, std::slice::from_ref(&space), &mut *filter, progress)
    }

    fn joint_lockstep(
        log: &Log,
        settings: &Settings,
        precision: Precision,
        progress: &mut dyn FnMut(usize),
    ) -> Result<JointComparison, Refusal> {
        let models = reference_of(log, settings);
        let config = joint_config_of(&underwater_joint_config(), settings.filter.birth_intensity);
        let reference = joint::Joint { config, models };
        let mut filter = joint_filter(log, settings, precision)?;
        drive_joint::<Self, _>(
            log,
            settings,
            std::slice::from_ref(&reference),
            <Space as Comparable<Self, 3, 6>>::control,
            &mut *filter,
            progress,
        )
    }
}

/// The reference with the models and settings of the filter.
fn reference_of(log: &Log, settings: &Settings) -> Space {
    let Settings { filter, vehicle, camera } = settings;
    let mut noise = [[0.0; 4]; 4];
    for (row, entries) in noise.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            let own = if row == column { camera.pixel_sigmas[row].powi(2) } else { 0.0 };
            let common = if row % 2 == column % 2 { camera.common_sigmas[row % 2].powi(2) } else { 0.0 };
            *entry = own + common;
        }
    }
    Space {
        config: Config {
            particles: filter.particles,
            samples: filter.samples,
            birth_intensity: filter.birth_intensity,
            clutter_intensity: settings.clutter_intensity(log),
            resample_threshold: filter.resample_threshold,
            prune_weight: filter.prune_weight,
            merge_distance: filter.merge_distance,
            max_components: filter.max_components,
            remembering: Remembering { detections: filter.confirming_detections, weight: filter.confirmed_weight },
            extraction_weight: filter.extraction_weight,
            likelihood: filter.likelihood,
            moving: MovingConfig {
                birth_intensity: 0.0,
                velocity_sigma_mps: 1.0,
                acceleration_psd: 0.1,
                lifetime_s: 100.0,
                spread_max_m: 1.0,
                extraction_weight: 0.5,
            },
        },
        yaw_acceleration_sigma: vehicle.yaw_acceleration_sigma_radps2,
        velocity_interval_s: vehicle.velocity_interval_s,
        cameras: log.camera.projections,
        noise,
        epipolar_gate: camera.epipolar_gate,
        image: [log.camera.size_px[0], log.camera.size_px[1], camera.edge_px],
        depth: [camera.near_m, camera.far_m, camera.depth_edge_m],
        detection: camera.detection,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Differences, compare, compare_joint, scan};
    use crate::session::with_roomy_stack;
    use scphd_filters::settings::{FilterSettings, Proposal};
    use scphd_worlds::underwater::tank::girona_tank;

    fn short(scans: usize) -> Log {
        let mut log = girona_tank(1);
        log.scans.truncate(scans);
        log
    }

    fn compared(precision: Precision, change: impl FnOnce(&mut Settings)) -> Differences {
        let log = short(30);
        let mut settings = Settings::for_log(&log);
        (settings.filter.particles, settings.filter.samples) = (4, 2);
        change(&mut settings);
        let compared = with_roomy_stack(|| compare::<Underwater>(&log, &settings, precision, 3, |_| ()));
        compared.unwrap().unwrap().overall
    }

    #[test]
    fn every_step_agrees_with_the_reference_to_a_thousand_millionth() {
        for velocity_interval_s in [0.0, 0.5] {
            let differences = compared(Precision::F64, |settings| {
                settings.vehicle.velocity_interval_s = velocity_interval_s;
                settings.camera.common_sigmas = [2.0 * velocity_interval_s, 1.0];
            });
            println!("{differences:?}");
            assert_eq!((differences.scans, differences.other_survivors, differences.unmatched), (30, 0, 0));
            assert!(differences.components > 2000, "{differences:?}");
            let d = &differences;
            let poses = [d.predicted_position_m, d.predicted_heading_rad];
            let weights = [d.ln_likelihood, d.particle_weight, d.component_weight];
            let estimates = [d.estimated_position_m, d.estimated_heading_rad, d.mass];
            for figure in poses.into_iter().chain(weights).chain(estimates).chain([d.mean, d.covariance]) {
                assert!(figure < 1e-9, "{differences:?}");
            }
        }
    }

    #[test]
    fn every_step_of_the_joint_filter_agrees_too() {
        let log = short(12);
        for velocity_interval_s in [0.0, 0.5] {
            let mut settings = Settings::for_log(&log);
            settings.vehicle.velocity_interval_s = velocity_interval_s;
            settings.camera.common_sigmas = [2.0 * velocity_interval_s, 1.0];
            let compared = with_roomy_stack(|| compare_joint::<Underwater>(&log, &settings, Precision::F64, |_| ()));
            let d = compared.unwrap().unwrap().overall;
            assert_eq!((d.scans, d.unmatched, d.other_views, d.capacity_events), (12, 0, 0, 0), "{d:?}");
            assert!(d.features > 200, "{d:?}");
            let poses =
                [d.predicted_position_m, d.predicted_heading_rad, d.estimated_position_m, d.estimated_heading_rad];
            let covariances = [d.predicted_covariance, d.pose_covariance, d.feature_covariance, d.cross_covariance];
            let rest = [d.mean, d.existence, d.ln_evidence, d.innovation, d.own_way_position_m, d.own_way_heading_rad];
            for figure in poses.into_iter().chain(covariances).chain(rest) {
                assert!(figure < 1e-9, "{d:?}");
            }
        }
    }

    #[test]
    fn a_different_model_is_detected() {
        let log = short(5);
        let mut settings = Settings::for_log(&log);
        (settings.filter.particles, settings.filter.samples) = (2, 1);
        let mut space = reference_of(&log, &settings);
        space.cameras[1][0][3] += 1e-3;
        let overall = with_roomy_stack(|| {
            let mut filter = core_filter(&log, &settings, Precision::F64, 3).unwrap();
            let mut overall = Differences::default();
            for frame in &log.scans {
                overall.merge(&scan(std::slice::from_ref(&space), &mut *filter, false, frame).unwrap());
            }
            overall
        })
        .unwrap();
        assert!(overall.mean > 1e-6 || overall.ln_likelihood > 1e-6, "{overall:?}");
    }

    #[test]
    fn settings_without_a_reference_are_refused() {
        let log = short(1);
        for change in [
            (|filter| filter.proposal = Proposal::Informed) as fn(&mut FilterSettings),
            |filter| filter.unconfirmed_weight = 0.5,
            |filter| filter.likelihood = scphd_filters::settings::Likelihood::RbEmpty,
        ] {
            let mut settings = Settings::for_log(&log);
            change(&mut settings.filter);
            assert!(compare::<Underwater>(&log, &settings, Precision::F64, 3, |_| ()).is_err());
        }
    }
}
