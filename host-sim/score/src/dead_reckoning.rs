//! Errors of dead reckoning over recorded and simulated logs.

use crate::trajectory;
use scphd_log::vehicle::dead_reckoning;
use scphd_log::{log_folder, truth};

/// Checks that the position RMSE of dead reckoning is within bounds, m.
fn check_rmse(name: &str, least: f64, most: f64) {
    let Some(dir) = scphd_shared_data::find(name) else {
        return;
    };
    let log = log_folder::read(&dir).unwrap();
    let poses = dead_reckoning(&log);
    assert_eq!(poses.len(), log.scans.len());
    let score = trajectory::score(poses.iter().zip(&log.scans).filter_map(|(&pose, scan)| {
        let truth = truth::at(&log.truth, scan.t_s)?;
        Some((pose, truth.position, truth.heading_rad))
    }))
    .unwrap();
    println!("{name}: {} of {} scans, {score:?}", score.scans, poses.len());
    assert!((least..most).contains(&score.position_rmse_m), "{name}: {score:?}");
}

#[test]
fn dead_reckoning_errors_are_as_published() {
    check_rmse("victoria_park", 149.2, 149.4);
    check_rmse("car_park", 2.5, 2.6);
    check_rmse("mrclam_ds6_robot1", 2.9, 3.1);
    check_rmse("mrclam_ds6_robot2", 2.8, 3.0);
    check_rmse("mrclam_ds6_robot3", 4.2, 4.4);
}

#[test]
fn dead_reckoning_errors_are_those_of_the_simulated_noise() {
    for (run, rmse) in [73.67, 161.27, 113.47, 83.94, 374.61, 124.77].into_iter().enumerate() {
        check_rmse(&format!("phd_slam3_a0{run}"), rmse - 0.1, rmse + 0.1);
    }
    for (run, rmse) in [3.466, 5.037, 6.724, 5.604, 2.602].into_iter().enumerate() {
        check_rmse(&format!("thesis_cmp_a0{run}"), rmse - 0.01, rmse + 0.01);
    }
}
