use super::{Association, Ekf};
use crate::slam::Slam;
use scphd_log::log::{FixNoise, Log, Mounting, Nominal, PoseFix, Scan, Sensor, Vehicle};

fn log(simulated: bool) -> Log {
    Log {
        name: "straight".into(),
        initial_pose: [0.0; 3],
        vehicle: Vehicle::UnicycleArc,
        sensor: Sensor {
            range_min_m: 0.0,
            range_max_m: 10.0,
            bearing_min_rad: -3.0,
            bearing_max_rad: 3.0,
            mounting: Mounting::NONE,
        },
        sensor_name: String::new(),
        others: Vec::new(),
        fixes: Vec::new(),
        fix_noise: FixNoise::default(),
        nominal: Nominal {
            range_sigma_m: Some(0.1),
            bearing_sigma_rad: Some(0.01),
            speed_sigma_mps: Some(0.2),
            rate_sigma_radps: Some(1e-9),
            ..Nominal::default()
        },
        simulated,
        odometry: Vec::new(),
        scans: vec![Scan { t_s: 0.0, sensor: 0, detections: vec![[1.0, 0.0]], labels: vec![-1] }],
        truth: Vec::new(),
        truth_sigma_m: 0.0,
        landmarks: Vec::new(),
        moving: Vec::new(),
    }
}

/// A vehicle on a line towards a landmark: the filter is a linear one of a scalar position and a scalar landmark.
#[test]
fn on_a_line_the_filter_is_the_kalman_filter() {
    let mut ekf = Ekf::start(&log(true), Association::NearestNeighbour).unwrap();
    let (mut x, mut m) = (0.0_f64, 0.0_f64);
    let (mut pxx, mut pxm, mut pmm) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (q, r) = (0.2_f64.powi(2), 0.1_f64.powi(2));
    for step in 0..20_u32 {
        if step > 0 {
            ekf.predict([0.3, 0.0, 0.0], 1.0).unwrap();
            x += 0.3;
            pxx += q;
        }
        let z = 8.0 - 0.31 * f64::from(step) + if step % 2 == 0 { 0.05 } else { -0.05 };
        ekf.scan(0, &[[z, 0.0]]).unwrap();
        if step == 0 {
            (m, pmm, pxm) = (x + z, pxx + r, pxx);
        } else {
            let s = pxx - 2.0 * pxm + pmm + r;
            let (kx, km) = ((pxm - pxx) / s, (pmm - pxm) / s);
            let innovation = z - (m - x);
            x += kx * innovation;
            m += km * innovation;
            (pxx, pxm, pmm) = (pxx - kx * kx * s, pxm - kx * km * s, pmm - km * km * s);
        }
        let (pose, covariance) = ekf.pose().unwrap();
        assert!((pose[0] - x).abs() < 1e-9, "step {step}: {} is not {x}", pose[0]);
        assert!((covariance[0][0] - pxx).abs() < 1e-9, "step {step}: {} is not {pxx}", covariance[0][0]);
    }
    let (_, map) = ekf.map().unwrap();
    assert!((map[0].mean[0] - m).abs() < 1e-9 && (map[0].covariance[0][0] - pmm).abs() < 1e-9);
}

#[test]
fn landmarks_detected_once_are_removed_and_detected_again_kept() {
    let mut ekf = Ekf::start(&log(true), Association::NearestNeighbour).unwrap();
    ekf.scan(0, &[[5.0, 0.0], [5.0, 1.5]]).unwrap();
    for _ in 0..60 {
        ekf.scan(0, &[[5.0, 0.0]]).unwrap();
    }
    assert_eq!(ekf.landmarks(), 1);
}

#[test]
fn the_noise_of_a_data_sheet_is_increased() {
    let covariance = |simulated| {
        let mut ekf = Ekf::start(&log(simulated), Association::NearestNeighbour).unwrap();
        for _ in 0..4 {
            ekf.scan(0, &[[5.0, 0.0]]).unwrap();
        }
        ekf.map().unwrap().1[0].covariance[0][0]
    };
    // Four detections from a certain pose.
    assert!((covariance(true) - 0.0025).abs() < 1e-9 && (covariance(false) - 1.5 * 1.5 * 0.0025).abs() < 1e-9);
}

#[test]
fn noise_grows_with_the_range() {
    let mut log = log(true);
    log.nominal.range_sigma_ratio = 0.02;
    let mut ekf = Ekf::start(&log, Association::NearestNeighbour).unwrap();
    for _ in 0..4 {
        ekf.scan(0, &[[5.0, 0.0]]).unwrap();
    }
    assert!((ekf.map().unwrap().1[0].covariance[0][0] - (0.01 + 0.01) / 4.0).abs() < 1e-9);
}

#[test]
fn known_labels_distinguish_two_landmarks_at_one_position() {
    let mut log = log(true);
    let scan = Scan { t_s: 0.0, sensor: 0, detections: vec![], labels: vec![4, 9, -1, 2] };
    log.scans = vec![scan; 5];
    log.moving = vec![scphd_log::log::MovingLandmark { subject: 2, t_s: 0.0, position: [0.0; 2] }];
    let mut ekf = Ekf::start(&log, Association::Known).unwrap();
    for _ in 0..5 {
        ekf.scan(0, &[[5.0, 0.0], [5.01, 0.0], [2.0, 1.0], [3.0, 1.0]]).unwrap();
    }
    // Detections labelled as clutter, or of moving objects, are not landmarks.
    assert_eq!(ekf.landmarks(), 2);
    log.scans = vec![Scan::default()];
    assert!(Ekf::start(&log, Association::Known).is_err());
}

/// On a line, with an antenna ahead of the pose: the Kalman filter of a scalar position.
#[test]
fn a_fix_is_the_kalman_update_of_the_pose_and_may_be_gated() {
    let mut log = log(true);
    log.fix_noise = FixNoise { position_sigma_m: Some(0.5), forward_m: 2.0, gate: Some(9.0), ..FixNoise::default() };
    let mut ekf = Ekf::start(&log, Association::NearestNeighbour).unwrap();
    ekf.predict([1.0, 0.0, 0.0], 1.0).unwrap();
    let (before, r) = (0.2_f64.powi(2), 0.5_f64.powi(2));
    assert_eq!(ekf.observe(&PoseFix::Position([8.0, 0.0])), Ok(false));
    assert_eq!(ekf.pose().unwrap().0[0], 1.0);
    assert_eq!(ekf.observe(&PoseFix::Position([3.6, 0.0])), Ok(true));
    let (pose, covariance) = ekf.pose().unwrap();
    assert!((pose[0] - (1.0 + 0.6 * before / (before + r))).abs() < 1e-9, "{pose:?}");
    assert!((covariance[0][0] - before * r / (before + r)).abs() < 1e-9, "{covariance:?}");
    assert!(ekf.observe(&PoseFix::Heading(0.1)).is_err(), "its noise is not stated");
    let covariance = [[0.25, 0.01, 0.0], [0.01, 0.16, 0.0], [0.0, 0.0, 0.04]];
    ekf.relocate(&[7.0, 8.0, 0.5], &covariance).unwrap();
    assert_eq!(ekf.pose().unwrap(), ([7.0, 8.0, 0.5], covariance));
}

/// As in the other filters: one wrong row must not decide a comparison.
#[test]
fn implausible_odometry_is_left_out() {
    let mut ekf = Ekf::start(&log(true), Association::NearestNeighbour).unwrap();
    let garbage = [[400.0, 0.0, 0.0], [0.3, 100.0, 0.0], [f64::NAN, 0.0, 0.0]];
    for control in garbage {
        assert!(ekf.predict(control, 0.1).unwrap().is_some(), "{control:?}");
    }
    assert!(ekf.predict([0.3, 0.0, 0.0], 301.0).unwrap().is_some());
    assert_eq!(ekf.pose().unwrap(), ([0.0; 3], [[0.0; 3]; 3]));
    assert_eq!(ekf.predict([0.3, 0.0, 0.0], 1.0).unwrap(), None);
}

/// Ten scans from true poses, of a pole with label 4, of a moving object with label 7, and once of another object with label 4.
#[test]
fn moving_objects_are_not_landmarks_of_a_known_association() {
    let mut log = log(true);
    let places = |k: u32| {
        let drives = 2.0 + 0.4 * f64::from(k);
        let post = if k == 6 { [8.0, 1.0] } else { [5.0, 0.0] };
        vec![post, [drives, 0.8]]
    };
    log.scans =
        (0..10).map(|k| Scan { t_s: f64::from(k), sensor: 0, detections: places(k), labels: vec![4, 7] }).collect();
    let row = |t_s| scphd_log::log::TruePose { t_s, position: [0.0; 2], heading_rad: Some(0.0) };
    log.truth = (0..=10).map(|k| row(f64::from(k))).collect();
    let run = |log: &Log| {
        let mut ekf = Ekf::start(log, Association::Known).unwrap();
        log.scans.iter().for_each(|scan| _ = ekf.scan(0, &scan.detections).unwrap());
        ekf
    };
    let mut told = run(&log);
    assert_eq!(told.landmarks(), 1);
    let (_, map) = told.map().unwrap();
    assert!((map[0].mean[0] - 5.0).abs() < 1e-9 && map[0].mean[1].abs() < 1e-9, "{map:?}");
    // Without truth they cannot be distinguished.
    log.truth.clear();
    assert_eq!(run(&log).landmarks(), 2);
}

/// Landmarks are mapped relative to the vehicle, so that no scan has information on the initial heading of vehicle and map together.
#[test]
fn told_the_labels_it_gains_no_information_on_the_heading() {
    let mut log = log(true);
    let posts = [[4.0, 1.0], [1.0, 4.0], [-3.0, 2.0], [2.0, -3.0]];
    log.scans = vec![Scan { t_s: 0.0, sensor: 0, detections: vec![], labels: vec![0, 1, 2, 3] }; 60];
    let least_heading_variance = |association| {
        let mut ekf = Ekf::start(&log, association).unwrap();
        ekf.relocate(&[0.0; 3], &[[0.0; 3], [0.0; 3], [0.0, 0.0, 0.04]]).unwrap();
        let mut pose = [0.0; 3];
        let mut least = f64::INFINITY;
        for scan in 0..60_u32 {
            // The scale of the odometry is off by a fifth, so that every scan moves vehicle and map.
            ekf.predict([0.6, 0.2, 0.0], 0.5).unwrap();
            pose = log.vehicle.step(pose, [0.5, 0.2, 0.0], 0.5);
            let off = if scan % 2 == 0 { 0.1 } else { -0.1 };
            let seen = posts.map(|[x, y]| {
                let (dx, dy) = (x - pose[0], y - pose[1]);
                [libm::hypot(dx, dy) + off, scphd_log::angle::wrap(libm::atan2(dy, dx) - pose[2])]
            });
            ekf.scan(0, &seen).unwrap();
            least = f64::min(least, ekf.pose().unwrap().1[2][2]);
        }
        least
    };
    let (told, plain) = [Association::Known, Association::NearestNeighbour].map(least_heading_variance).into();
    assert!(told > 0.04 - 1e-9, "{told}");
    assert!(plain < 0.039, "{plain}");
}
