//! Random worlds under water as seen by filters.

use super::settings::Settings;
use crate::kind::Kind as _;
use nalgebra::Vector3;
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::Log;
use scphd_worlds::underwater::worlds::{Kind, Misbehaviour, misbehaving, size_m, world};

fn dead_reckoning_rmse(log: &Log) -> f64 {
    let settings = Settings::for_real_log(log);
    let places = Underwater::dead_reckoning(log, &settings).unwrap();
    let squares: f64 = log
        .scans
        .iter()
        .zip(&places)
        .map(|(scan, &place)| {
            let row = log.truth.partition_point(|row| row.t_s <= scan.t_s) - 1;
            (Vector3::from(place) - Vector3::from(log.truth[row].position)).norm_squared()
        })
        .sum();
    (squares / places.len() as f64).sqrt()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn keypoints(log: &Log) -> usize {
    log.scans.iter().map(|scan| scan.detections.len()).sum()
}

/// Most features detected in the first third are detected in the last.
#[test]
fn landmarks_are_seen_again_and_a_frame_shows_some() {
    let (mut again, mut shown) = (Vec::new(), Vec::new());
    for seed in 0..30 {
        let log = world(Kind::DataSheet, seed);
        let settings = Settings::for_real_log(&log);
        let view = Underwater::view(&log, &settings);
        let seen = |part: usize| -> Vec<usize> {
            let rows = log.truth.len() / 3;
            let poses = || log.truth[part * rows..(part + 1) * rows].iter().step_by(10);
            let in_view = |index: &usize| poses().any(|pose| view(pose, log.landmarks[*index].position) == Some(true));
            (0..log.landmarks.len()).filter(in_view).collect()
        };
        let (first, last) = (seen(0), seen(2));
        again.push(first.iter().filter(|index| last.contains(index)).count() as f64 / first.len() as f64);
        shown.push(keypoints(&log) as f64 / log.scans.len() as f64);
    }
    assert!(again.iter().all(|share| *share > 0.1) && median(again.clone()) > 0.5, "{again:?}");
    assert!(shown.iter().all(|count| (1.0..20.0).contains(count)) && median(shown.clone()) > 4.0, "{shown:?}");
}

#[test]
fn instrument_faults_increase_the_error_of_dead_reckoning() {
    let worlds = |misbehaviour| -> f64 {
        median((0..20).map(|seed| dead_reckoning_rmse(&misbehaving(seed, misbehaviour)) / size_m(seed)).collect())
    };
    let (with, without) = (worlds(Misbehaviour::ALL), worlds(Misbehaviour::NONE));
    assert!(with > 2.0 * without && with < 0.3, "{with} {without}");
}
