//! Recordings are imported as logs, exported runs become the same logs again, and errors are reported in one line.

use crate::place::Place;
use scphd_log::log::{FixNoise, Log, PoseFix};
use scphd_log::log_folder;
use scphd_ros::messages::{
    AckermannDriveStamped, Detection3D, Detection3DArray, Header, JointState, NavSatFix, Odometry, PointCloud2,
    PoseArray, PoseStamped, PoseWithCovarianceStamped, Quaternion, RadarReturn, RadarScan, TFMessage, TransformStamped,
};
use scphd_ros::{Message, Time, Writer, cloud};
use scphd_worlds::scenario;
use std::fs;
use std::io::Cursor;

/// The last line of the output of a command that must fail because of its input.
fn fails(place: &Place, args: &[&str]) -> String {
    let output = place.run(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {output:?}");
    String::from_utf8(output.stderr).unwrap().lines().last().unwrap_or_default().to_owned()
}

/// Times as in a recording: whole nanoseconds.
fn decimal(log: &mut Log) {
    let round = |t_s: &mut f64| *t_s = (*t_s * 1e6).round() / 1e6;
    log.odometry.iter_mut().for_each(|row| round(&mut row.t_s));
    log.scans.iter_mut().for_each(|scan| round(&mut scan.t_s));
    log.fixes.iter_mut().for_each(|fix| round(&mut fix.t_s));
    log.truth.iter_mut().for_each(|row| round(&mut row.t_s));
}

/// A car, a car with fixes, two sensors and a unicycle, each as a folder and with its run as an MCAP file.
#[test]
fn an_exported_run_is_imported_as_its_log() {
    for name in ["survey", "survey-fixes", "two-sensors", "worlds-exact"] {
        let place = Place::new();
        let mut log = scenario::by_name(name, 5).unwrap();
        // A part of it with the first fix, for a run of a minute without optimisation.
        log.scans.truncate(130);
        decimal(&mut log);
        log_folder::write(&log, &place.path("log")).unwrap();
        place.tells(&["replay", "log", "--mcap", "run.mcap", "--json", "then.json"]);
        place.tells(&["import", "run.mcap", "--out", "back"]);
        let back = log_folder::read(&place.path("back")).unwrap();
        // Exactly equal, except for true headings, which were converted to quaternions, and moving landmarks, which have no
        // message.
        let near = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).sin().abs() < 1e-12,
            (a, b) => a == b,
        };
        assert_eq!(back.truth.len(), log.truth.len(), "{name}");
        for (a, b) in back.truth.iter().zip(&log.truth) {
            assert!(a.t_s == b.t_s && a.position == b.position && near(a.heading_rad, b.heading_rad), "{name}");
        }
        assert_eq!(Log { truth: log.truth.clone(), moving: log.moving.clone(), ..back }, log, "{name}");
        place.tells(&["replay", "back", "--json", "now.json"]);
        let (then, now) = (place.json("then.json"), place.json("now.json"));
        assert_eq!((&then["digest"], &then["position_rmse_m"]), (&now["digest"], &now["position_rmse_m"]), "{name}");
        assert!(then["digest"].is_string(), "{name}");
    }
}

const TIMES: u32 = 30;

fn stamp(k: u32) -> Time {
    Time { sec: 1_700_000_000 + (k / 10).cast_signed(), nanosec: k % 10 * 100_000_000 }
}

fn header(k: u32, frame: &str) -> Header {
    Header::new(stamp(k), frame)
}

/// A recording; every topic has a message at each time.
struct Recording(Writer<Cursor<Vec<u8>>>);

impl Recording {
    fn new() -> Self {
        Self(Writer::new(Cursor::new(Vec::new()), "test").unwrap())
    }

    fn with<M: Message>(mut self, topic: &str, message: impl Fn(u32) -> M) -> Self {
        (0..TIMES).for_each(|k| self.0.write(topic, stamp(k), &message(k)).unwrap());
        self
    }

    /// A robot that drives a curve at 1 m/s.
    fn with_odometry(self) -> Self {
        self.with("/robot/odom", odometry)
    }

    fn bytes(self) -> Vec<u8> {
        self.0.finish().unwrap().into_inner()
    }
}

fn odometry(k: u32) -> Odometry {
    let mut message = Odometry { header: header(k, "odom"), child_frame_id: "base".into(), ..Odometry::default() };
    message.twist.twist.linear.x = 1.0;
    message.twist.twist.angular.z = 0.25;
    message
}

fn radar(k: u32) -> RadarScan {
    let seen = |range, azimuth, elevation| RadarReturn { range, azimuth, elevation, ..RadarReturn::default() };
    RadarScan { header: header(k, "radar"), returns: vec![seen(5.0, 0.5, 0.0), seen(8.0, -0.25, 0.5)] }
}

#[test]
fn a_radar_and_its_mounting_are_found() {
    let place = Place::new();
    let mut link = TransformStamped { child_frame_id: "radar".into(), header: header(0, "base"), ..Default::default() };
    link.transform.translation.x = 1.5;
    link.transform.rotation = Quaternion::of_yaw(0.25);
    let recording = Recording::new().with_odometry().with("/radar/scan", radar);
    let recording = recording.with("/tf_static", |_| TFMessage { transforms: vec![link.clone()] });
    place.write("drive.mcap", recording.bytes());
    let told = place.tells(&["import", "drive.mcap", "--out", "log"]);
    for words in [
        "odometry: /robot/odom, 30 messages",
        "detections: /radar/scan",
        "1.500 m ahead",
        "counted from 1700000000 s",
        "a guess",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.name.as_str(), log.odometry.len(), log.scans.len()), ("drive", 30, 30));
    assert_eq!((log.odometry[7].t_s, log.odometry[7].control), (0.7, [1.0, 0.25, 0.0]));
    let [[range, bearing], [level, _]] = log.scans[29].detections[..] else { panic!("{log:?}") };
    assert_eq!((range, bearing), (5.0, 0.5));
    assert!((level - 8.0 * 0.5_f64.cos()).abs() < 1e-6);
    assert!((log.sensor.mounting.forward_m, log.sensor.mounting.left_m) == (1.5, 0.0));
    assert!((log.sensor.mounting.yaw_rad - 0.25).abs() < 1e-12);
    place.tells(&["replay", "log"]);
}

#[test]
fn landmarks_of_images_and_clouds_are_converted_to_range_and_bearing() {
    let place = Place::new();
    // Two metres ahead and one to the left, in the axes of a body and of an image.
    let images = |k| {
        let mut seen = Detection3D::default();
        let at = &mut seen.bbox.center.position;
        (at.x, at.y, at.z) = (-1.0, 0.7, 2.0);
        Detection3DArray { header: header(k, "camera_optical_frame"), detections: vec![seen] }
    };
    let poses = |k| {
        let mut array = PoseArray { header: header(k, "lidar"), ..PoseArray::default() };
        let mut pose = scphd_ros::messages::Pose::default();
        (pose.position.x, pose.position.y) = (2.0, 1.0);
        array.poses = vec![pose];
        array
    };
    let clouds =
        |k| cloud(header(k, "lidar"), ["x", "y", "z"], [], [([2.0, 1.0, 0.0], []), ([f64::NAN, 0.0, 0.0], [])]);
    let bytes = [
        Recording::new().with_odometry().with("/objects", images).bytes(),
        Recording::new().with_odometry().with("/objects", poses).bytes(),
        // A whole laser scan is not chosen as landmarks.
        Recording::new().with_odometry().with("/clusters", clouds).with("/velodyne_points", clouds).bytes(),
    ];
    for (k, bytes) in bytes.iter().enumerate() {
        place.write("a.mcap", bytes);
        let told = place.tells(&["import", "a.mcap", "--out", &k.to_string()]);
        let log = log_folder::read(&place.path(&k.to_string())).unwrap();
        let [[range, bearing]] = log.scans[3].detections[..] else { panic!("{log:?}") };
        assert!((range - 5.0_f64.sqrt()).abs() < 1e-6 && (bearing - 0.5_f64.atan()).abs() < 1e-6, "{range} {bearing}");
        assert_eq!(told.contains("30 points without a place"), k == 2, "{told}");
    }
}

#[test]
fn fixes_and_truth_are_read() {
    let place = Place::new();
    let gps = |k: u32| {
        let mut fix = NavSatFix { header: header(k, "gps"), latitude: 47.0, longitude: 8.0, ..NavSatFix::default() };
        // A receiver without satellites, then driving north: a second of arc is 30.88 m here.
        fix.status.status = if k == 4 { -1 } else { 0 };
        fix.latitude += f64::from(k) / 3600.0;
        fix.position_covariance_type = 2;
        (fix.position_covariance[0], fix.position_covariance[4]) = (4.0, 4.0);
        fix
    };
    let truth = |k: u32| {
        let mut pose = PoseStamped { header: header(k, "world"), ..PoseStamped::default() };
        (pose.pose.position.x, pose.pose.orientation) = (f64::from(k), Quaternion::of_yaw(1.0));
        pose
    };
    let both =
        Recording::new().with_odometry().with("/radar", radar).with("/gps/fix", gps).with("/ground_truth", truth);
    place.write("a.mcap", both.bytes());
    let told = place.tells(&["import", "a.mcap", "--out", "gps"]);
    assert!(told.contains("1 fixes without a place") && told.contains("47.000000000°"), "{told}");
    let log = log_folder::read(&place.path("gps")).unwrap();
    assert_eq!((log.fixes.len(), log.fix_noise.position_sigma_m), (29, Some(2.0)));
    let PoseFix::Position([east, north]) = log.fixes[28].measured else { panic!("a place") };
    assert!(east.abs() < 1e-6 && (north / 29.0 - 30.88).abs() < 0.01, "{east} {north}");
    assert_eq!((log.truth.len(), log.truth[2].position, log.initial_pose[0]), (30, [2.0, 0.0], 0.0));
    assert!((log.initial_pose[2] - 1.0).abs() < 1e-12);
    place.tells(&["import", "a.mcap", "--out", "none", "--fixes", "none", "--truth", "none"]);
    let log = log_folder::read(&place.path("none")).unwrap();
    assert!(log.fixes.is_empty() && log.truth.is_empty() && log.fix_noise == FixNoise::default());

    // Poses without covariance need a head with their noise.
    let poses = |k| PoseWithCovarianceStamped { header: header(k, "map"), ..PoseWithCovarianceStamped::default() };
    place.write("b.mcap", Recording::new().with_odometry().with("/radar", radar).with("/pose", poses).bytes());
    let error = fails(&place, &["import", "b.mcap", "--out", "b", "--fixes", "/pose"]);
    assert!(error.contains("position_sigma_m") && !place.path("b").exists(), "{error}");
}

#[test]
fn cars_need_a_head_and_velocities_are_derived_from_poses() {
    let place = Place::new();
    let drive = |k| {
        let mut message = AckermannDriveStamped { header: header(k, ""), ..AckermannDriveStamped::default() };
        (message.drive.speed, message.drive.steering_angle) = (2.0, 0.125);
        message
    };
    let joints = |k| JointState {
        header: header(k, ""),
        name: vec!["steering".into(), "drive".into()],
        position: vec![0.1, 0.0],
        velocity: vec![0.0, 2.5],
        effort: vec![],
    };
    place.write("car.mcap", Recording::new().with("/drive", drive).with("/radar", radar).bytes());
    place.write("joints.mcap", Recording::new().with("/joints", joints).with("/radar", radar).bytes());
    let error = fails(&place, &["import", "car.mcap", "--out", "log"]);
    assert!(error.contains("/drive needs --head") && error.contains("ackermann"), "{error}");
    log_folder::write(&scenario::survey(1), &place.path("like")).unwrap();
    let head = place.path("like/log.toml");
    let head = head.to_str().unwrap();
    for (file, control) in [("car.mcap", [2.0, 0.125, 0.0]), ("joints.mcap", [2.5, 0.1, 0.0])] {
        place.tells(&["import", file, "--out", file.trim_end_matches(".mcap"), "--head", head]);
        let log = log_folder::read(&place.path(file.trim_end_matches(".mcap"))).unwrap();
        assert_eq!((log.odometry[3].control, log.vehicle), (control, scenario::survey(1).vehicle));
    }

    // Odometry with poses only: half a metre in a tenth of a second, then standstill.
    let poses = |k: u32| {
        let mut message = odometry(k);
        message.twist = Default::default();
        message.pose.pose.position.x = 0.5 * f64::from(k.min(20));
        message
    };
    place.write("poses.mcap", Recording::new().with("/odom", poses).with("/radar", radar).bytes());
    let told = place.tells(&["import", "poses.mcap", "--out", "poses"]);
    assert!(told.contains("made of its poses"), "{told}");
    let log = log_folder::read(&place.path("poses")).unwrap();
    assert!((log.odometry[3].control[0] - 5.0).abs() < 1e-6 && log.odometry[25].control == [0.0; 3]);
}

#[test]
fn missing_or_invalid_data_are_reported_in_one_line() {
    let place = Place::new();
    let good = Recording::new().with_odometry().with("/radar", radar).bytes();
    place.write("good.mcap", &good);
    place.write("torn.mcap", &good[..good.len() / 2]);
    place.write("text.mcap", b"no recording at all");
    place.write("empty.mcap", b"");
    place.write("still.mcap", Recording::new().with_odometry().bytes());
    place.write("blind.mcap", Recording::new().with("/radar", radar).bytes());
    place.write(
        "two.mcap",
        Recording::new().with("/a/odom", odometry).with("/b/odom", odometry).with("/radar", radar).bytes(),
    );
    let nan = |k| {
        let mut message = odometry(k);
        message.twist.twist.linear.x = if k == 9 { f64::NAN } else { 1.0 };
        message
    };
    place.write("nan.mcap", Recording::new().with("/odom", nan).with("/radar", radar).bytes());
    let big = |k| PointCloud2 { width: 9, height: 9, ..cloud(header(k, ""), ["x", "y"], [], [([1.0, 1.0], [])]) };
    place.write("cloud.mcap", Recording::new().with_odometry().with("/landmarks", big).bytes());
    let unnamed = |k| cloud(header(k, ""), ["a"], [], [([1.0], [])]);
    place.write("fields.mcap", Recording::new().with_odometry().with("/landmarks", unnamed).bytes());
    let cases: &[(&[&str], &[&str])] = &[
        (&["gone.mcap"], &["gone.mcap"]),
        (&["text.mcap"], &["text.mcap: no MCAP file"]),
        (&["empty.mcap"], &["empty.mcap: no MCAP file"]),
        (&["torn.mcap"], &["torn.mcap: torn off at byte", "--partial"]),
        (&["still.mcap"], &["no detections", "/robot/odom (nav_msgs/msg/Odometry)"]),
        (&["blind.mcap"], &["no odometry", "/radar (radar_msgs/msg/RadarScan)"]),
        (&["two.mcap"], &["/a/odom, /b/odom; say --odometry TOPIC"]),
        (&["good.mcap", "--odometry", "/odometry"], &["no topic '/odometry' for the odometry; there are /radar"]),
        (&["good.mcap", "--odometry", "/radar"], &["'/radar' for the odometry has messages radar_msgs/msg/RadarScan"]),
        (&["good.mcap", "--detections", "/robot/odom"], &["understood are radar_msgs/msg/RadarScan"]),
        (&["nan.mcap"], &["nan.mcap, /odom, message 10: twist.linear.x is NaN"]),
        (&["cloud.mcap"], &["/landmarks, message 1: 9 rows of 9 points"]),
        (&["fields.mcap"], &["neither range and bearing nor x and y"]),
        (&["good.mcap", "--head", "no.toml"], &["--head no.toml"]),
        (&["good.mcap", "--head", "text.mcap"], &["text.mcap: log.toml"]),
    ];
    for (words, expected) in cases {
        let error = fails(&place, &[&["import", "--out", "log"], *words].concat());
        assert!(error.starts_with("error: "), "{error}");
        expected.iter().for_each(|part| assert!(error.contains(part), "{words:?}: {error}"));
        assert!(!place.path("log").exists(), "{words:?}");
    }
    let told = place.tells(&["import", "good.mcap", "--out", "log", "--clock", "log"]);
    assert!(told.contains("odometry: /robot/odom"), "{told}");
    assert!(fails(&place, &["import", "good.mcap", "--out", "log"]).contains("not empty"));
}

/// For any damage of a recording, the program reports an error, or reads the same log.
#[test]
fn damaged_recordings_never_panic() {
    use scphd_exchange::import::recording::{Options, read};
    let place = Place::new();
    let good = Recording::new().with_odometry().with("/radar", radar).bytes();
    let path = place.path("damaged.mcap");
    let import = |bytes: &[u8], partial: bool| {
        fs::write(&path, bytes).unwrap();
        read(&path, &Options { partial, ..Options::default() }).map_err(|error| error.to_string())
    };
    let whole = import(&good, false).unwrap().log;
    let (mut refused, mut same) = (0, 0);
    for k in 0..2000_usize {
        let mut bytes = good.clone();
        let at = k * 7919 % bytes.len();
        match k % 4 {
            0 => bytes.truncate(at),
            1 => bytes[at] ^= 1 << (k / 4 % 8),
            2 => bytes[at..].iter_mut().take(8).for_each(|byte| *byte = 0xff),
            _ => drop(bytes.drain(at..(at + 1 + k % 50).min(good.len()))),
        }
        match import(&bytes, k % 3 == 0) {
            Ok(imported) if imported.log == whole => same += 1,
            Ok(imported) => assert!(k % 3 == 0 && imported.told.iter().any(|told| told.contains("what lies before"))),
            Err(error) => {
                assert!(error.contains("damaged.mcap"), "{error}");
                refused += 1;
            }
        }
    }
    println!("{refused} refused, {same} the same");
    assert!(refused > 1000, "{refused}");
}

#[test]
fn the_files_of_mrclam_are_read() {
    let place = Place::new();
    let folder = place.path("data");
    fs::create_dir(&folder).unwrap();
    let put = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    put("Barcodes.dat", "# Subject #    Barcode #\n1\t5\n2\t14\n6\t63\n7\t25\n".into());
    put(
        "Landmark_Groundtruth.dat",
        "# Subject # x y x-sd y-sd\n6\t2.5\t-1.0\t0.0001\t0.0001\n7\t3.5\t1.5\t0.0001\t0.0001\n".into(),
    );
    let times: Vec<String> = (0..200).map(|k| format!("{:.3}", 1_248_272_263.103 + 0.015 * f64::from(k))).collect();
    let rows = |of: &dyn Fn(usize) -> String| {
        times.iter().enumerate().map(|(k, t)| format!("{t}    {}\n", of(k))).collect::<String>()
    };
    put("Robot1_Odometry.dat", format!("# Time [s] v w\n{}", rows(&|_| "0.100    0.050".into())));
    put(
        "Robot1_Groundtruth.dat",
        format!("# Time x y theta\n{}", rows(&|k| format!("{}  -0.5  0.25", 0.0015 * k as f64))),
    );
    put("Robot2_Groundtruth.dat", rows(&|_| "1.0 2.0 3.0".into()));
    // Two detections in one image, and an unknown barcode.
    let seen = format!("{0} 63 2.5 -0.25\n{0} 14 1.0 0.5\n{1} 99 2.0 0.1\n", times[20], times[40]);
    put("Robot1_Measurement.dat", format!("# Time barcode r b\n{seen}"));
    let told = place.tells(&["import", "data", "--out", "log"]);
    assert!(told.contains("1248272263 s on") && told.contains("1 detections have a barcode"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.odometry.len(), log.truth.len(), log.landmarks.len(), log.moving.len()), (200, 200, 2, 200));
    assert_eq!((log.odometry[0].t_s, log.initial_pose), (0.103, [0.0, -0.5, 0.25]));
    let found: Vec<_> = log.scans.iter().map(|scan| (scan.t_s, scan.detections.clone(), scan.labels.clone())).collect();
    assert_eq!(found, [(0.403, vec![[2.5, -0.25], [1.0, 0.5]], vec![6, 2]), (0.703, vec![[2.0, 0.1]], vec![-1])]);
    assert_eq!((log.name.as_str(), log.nominal.range_sigma_m), ("UTIAS MRCLAM robot 1", Some(0.16)));
    place.tells(&["replay", "log"]);

    assert!(fails(&place, &["import", "data", "--robot", "3", "--out", "no"]).contains("Robot3_Odometry.dat"));
    put("Robot1_Measurement.dat", format!("# Time barcode r b\n{} 63 far -0.25\n", times[20]));
    let error = fails(&place, &["import", "data", "--out", "no"]);
    assert!(error.contains("Robot1_Measurement.dat, line 2, column 2: not a finite number: 'far'"), "{error}");
    fs::create_dir(place.path("other")).unwrap();
    assert!(fails(&place, &["import", "other", "--out", "no"]).contains("neither the files of MRCLAM"));
    assert!(fails(&place, &["import", "data", "--out", "no", "--truth", "none"]).contains("of MCAP files alone"));
}

/// A MAT-file of level 4 with matrices of doubles, by columns, and one of 16 bits.
fn mat(matrices: &[(&str, usize, Vec<f64>)]) -> Vec<u8> {
    let mut file = Vec::new();
    for (name, rows, numbers) in matrices {
        let kind = if *name == "LASER" { 40_u32 } else { 0 };
        let head = [kind, *rows as u32, (numbers.len() / rows) as u32, 0, name.len() as u32 + 1];
        head.iter().for_each(|word| file.extend(word.to_le_bytes()));
        file.extend(name.as_bytes());
        file.push(0);
        for number in numbers {
            if kind == 40 { file.extend((*number as u16).to_le_bytes()) } else { file.extend(number.to_le_bytes()) }
        }
    }
    file
}

#[test]
fn the_files_of_victoria_park_are_read() {
    let place = Place::new();
    let folder = place.path("park");
    fs::create_dir(&folder).unwrap();
    let put = |name: &str, bytes: Vec<u8>| fs::write(folder.join(name), bytes).unwrap();
    let list = |count: usize, of: fn(f64) -> f64| (0..count).map(|k| of(k as f64)).collect::<Vec<f64>>();
    let dr = [
        ("time", 80, list(80, |k| 21_940.0 + 25.0 * k)),
        ("speed", 80, list(80, |_| 1.5)),
        ("steering", 80, list(80, |_| -0.003)),
    ];
    put("aa3_dr.mat", mat(&dr));
    // A trunk of three rays 8 m straight ahead; the highest bits are the intensity.
    let beam = |k: f64| if ((k / 8.0).floor() - 180.0).abs() <= 1.0 { 800.0 + 8192.0 } else { 8191.0 };
    put(
        "aa3_lsr2.mat",
        mat(&[
            ("TLsr", 8, list(8, |k| 22_000.0 + 200.0 * k)),
            ("LASER", 8, (0..361 * 8).map(|k| beam(f64::from(k))).collect()),
        ]),
    );
    put(
        "aa3_gpsx.mat",
        mat(&[
            ("timeGps", 9, list(9, |k| 21_900.0 + 200.0 * k)),
            ("Lo_m", 9, list(9, |k| k - 67.0)),
            ("La_m", 9, list(9, |_| -41.0)),
        ]),
    );
    let told = place.tells(&["import", "park", "--out", "log"]);
    assert!(told.contains("80 rows of odometry, 8 scans"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.odometry[1].t_s, log.odometry[1].control), (21.965, [1.5, -0.003, 0.0]));
    let thick = 8.0 * 3.0 * std::f64::consts::PI / 360.0;
    for scan in &log.scans {
        let [[range, bearing]] = scan.detections[..] else { panic!("{scan:?}") };
        assert!((range - 8.0 - 0.5 * thick).abs() < 1e-12 && bearing == 0.0, "{range} {bearing}");
    }
    assert_eq!((log.truth.len(), log.initial_pose), (9, [-67.0, -41.0, 0.6196]));
    place.tells(&["replay", "log"]);

    put("aa3_dr.mat", mat(&dr[..2]));
    let error = fails(&place, &["import", "park", "--out", "no"]);
    assert!(error.contains("aa3_dr.mat: no matrix steering; there are speed, time"), "{error}");
    put("aa3_dr.mat", mat(&dr)[..300].to_vec());
    assert!(
        fails(&place, &["import", "park", "--out", "no"]).contains("aa3_dr.mat: it ends in the middle of a matrix")
    );
}

#[test]
fn tables_are_read_with_assigned_columns() {
    let place = Place::new();
    let rows = |of: fn(i32) -> String| (0..50).map(of).collect::<String>();
    place.write("wheels.csv", format!("ms;kmh;yaw\n{}", rows(|k| format!("{};3.6;90\n", 1000 + 100 * k))).as_bytes());
    place.write("seen.txt", rows(|k| format!("{}.05 2.0 -1.0 {k}\n", 1 + k / 10)).as_bytes());
    place.write("all.csv", rows(|k| format!("{}\n", 1.0 + 0.1 * f64::from(k))).as_bytes());
    place.write("gps.csv", b"t,e,n,h\n1.0,5,6,\n1.5,5,6,45\n");
    let map = r#"
name = "mine"
[odometry]
file = "wheels.csv"
delimiter = ";"
time = { column = "ms", unit = "ms" }
speed = { column = "kmh", unit = "kmph" }
turn = { column = "yaw", unit = "degps", factor = -1 }
[detections]
file = "seen.txt"
delimiter = "space"
header = false
time = 0
ahead = 1
left = 2
label = 3
[scans]
file = "all.csv"
header = false
time = 0
[truth]
file = "gps.csv"
time = "t"
x = "e"
y = "n"
heading = { column = "h", unit = "deg" }
"#;
    place.write("map.toml", map.as_bytes());
    place.tells(&["import", "map.toml", "--out", "log"]);
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.name.as_str(), log.odometry[3].t_s), ("mine", 1.3));
    let [speed, rate, _] = log.odometry[3].control;
    assert!((speed - 1.0).abs() < 1e-12 && (rate + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    // Ten rows of each second are one scan, and 50 scans are listed, most of them empty.
    assert_eq!((log.scans.len(), log.scans.iter().filter(|scan| scan.detections.len() == 10).count()), (55, 5));
    let full = log.scans.iter().find(|scan| !scan.detections.is_empty()).unwrap();
    assert!((full.detections[0][0] - 5.0_f64.sqrt()).abs() < 1e-12 && full.detections[0][1] < 0.0);
    assert_eq!(full.labels[..3], [0, 1, 2]);
    assert_eq!((log.truth[0].heading_rad, log.truth.len()), (None, 2));
    assert!((log.truth[1].heading_rad.unwrap() - 0.25 * std::f64::consts::PI).abs() < 1e-12);

    let wrong: [(&str, &str, &str); 7] = [
        ("speed = ", "sped = ", "missing field `speed`"),
        ("left = 2", "left = 2\nlabels = 3", "[detections] has no key 'labels'"),
        ("\"ms\", unit = \"ms\"", "\"t\"", "wheels.csv: no column 't'; there are ms, kmh, yaw"),
        ("unit = \"kmph\"", "unit = \"knots\"", "unit 'knots': unknown, there are s, ms"),
        ("ahead = 1", "range = 1", "either range and bearing or ahead and left"),
        ("wheels.csv", "gone.csv", "gone.csv"),
        ("left = 2", "left = 7", "seen.txt, line 1, column 7: not a finite number: ''"),
    ];
    for (old, new, expected) in wrong {
        place.write("wrong.toml", map.replacen(old, new, 1).as_bytes());
        let error = fails(&place, &["import", "wrong.toml", "--out", "no"]);
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// Writes a topic's message with this number.
type Topic<'a> = &'a dyn Fn(&mut Writer<Cursor<Vec<u8>>>, u32);

/// Poles around a square of 16 m.
fn posts() -> Vec<[f64; 2]> {
    (0..16)
        .map(f64::from)
        .map(|k| [9.0 * (0.7 * k).cos() + 2.0 * (2.9 * k).sin(), 9.0 * (0.7 * k).sin() + 4.0])
        .collect()
}

/// A robot among poles: its poses every tenth of a second, with speed and turn rate until the next.
struct Drive {
    poses: Vec<[f64; 3]>,
    controls: Vec<[f64; 3]>,
}

impl Drive {
    /// A minute of curves at 1 m/s.
    fn new() -> Self {
        let mut drive = Self { poses: vec![[0.0; 3]], controls: Vec::new() };
        for k in 0..600 {
            let control = [1.0, 0.25 + 0.3 * (0.05 * f64::from(k)).sin(), 0.0];
            let pose = scphd_log::log::Vehicle::UnicycleArc.step(drive.poses[k as usize], control, 0.1);
            drive.poses.push(pose);
            drive.controls.push(control);
        }
        drive
    }

    /// Poles within 12 m of the robot, in its axes: ahead, left, up.
    fn seen(&self, k: u32) -> Vec<[f64; 3]> {
        let [x, y, heading] = self.poses[k as usize];
        let (s, c) = heading.sin_cos();
        let body = |[px, py]: [f64; 2]| [c * (px - x) + s * (py - y), -s * (px - x) + c * (py - y), 0.4];
        posts().into_iter().map(body).filter(|[ahead, left, _]| ahead.hypot(*left) < 12.0).collect()
    }

    fn odometry(&self, k: u32) -> Odometry {
        let [x, y, heading] = self.poses[k as usize];
        let [speed, rate, _] = self.controls[k as usize];
        let mut message = Odometry { header: header(k, "odom"), child_frame_id: "base".into(), ..Odometry::default() };
        (message.twist.twist.linear.x, message.twist.twist.angular.z) = (speed, rate);
        (message.pose.pose.position.x, message.pose.pose.position.y) = (x, y);
        message.pose.pose.orientation = Quaternion::of_yaw(heading);
        message
    }

    fn array(&self, k: u32, frame: &str, axes: impl Fn([f64; 3]) -> [f64; 3]) -> PoseArray {
        let mut array = PoseArray { header: header(k, frame), ..PoseArray::default() };
        for place in self.seen(k) {
            let mut pose = scphd_ros::messages::Pose::default();
            let at = &mut pose.position;
            [at.x, at.y, at.z] = axes(place);
            array.poses.push(pose);
        }
        array
    }

    /// A recording with every message of some topics.
    fn recording(&self, topics: &[Topic]) -> Vec<u8> {
        let mut writer = Writer::new(Cursor::new(Vec::new()), "test").unwrap();
        (0..600).for_each(|k| topics.iter().for_each(|topic| topic(&mut writer, k)));
        writer.finish().unwrap().into_inner()
    }

    /// With odometry and detections, and a change of the odometry.
    fn with_odometry(&self, change: impl Fn(u32, &mut Odometry)) -> Vec<u8> {
        self.recording(&[
            &|writer, k| {
                let mut message = self.odometry(k);
                change(k, &mut message);
                writer.write("/odom", stamp(k), &message).unwrap();
            },
            &|writer, k| writer.write("/landmarks", stamp(k), &self.array(k, "base", |place| place)).unwrap(),
        ])
    }

    /// With odometry and these detections.
    fn with_detections(&self, links: &[TransformStamped], of: impl Fn(u32) -> PoseArray) -> Vec<u8> {
        self.recording(&[
            &|writer, k| writer.write("/odom", stamp(k), &self.odometry(k)).unwrap(),
            &|writer, k| writer.write("/landmarks", stamp(k), &of(k)).unwrap(),
            &|writer, k| {
                if k == 0 {
                    writer.write("/tf_static", stamp(k), &TFMessage { transforms: links.to_vec() }).unwrap();
                }
            },
        ])
    }

    /// Checks that every detection of a log is at a pole, as seen from the robot's true pose.
    fn fits(&self, log: &Log, name: &str) {
        assert_eq!(log.scans.len(), 600, "{name}");
        for (k, scan) in log.scans.iter().enumerate() {
            let seen = self.seen(k as u32);
            assert_eq!(scan.detections.len(), seen.len(), "{name}");
            for ([range, bearing], [ahead, left, _]) in scan.detections.iter().zip(seen) {
                let angle = bearing + log.sensor.mounting.yaw_rad;
                let off = [range * angle.cos() - ahead, range * angle.sin() - left];
                assert!(off[0].hypot(off[1]) < 1e-6, "{name}, scan {k}: {off:?}");
            }
        }
    }
}

#[test]
fn points_in_any_frame_are_transformed_to_the_vehicle() {
    let (place, drive) = (Place::new(), Drive::new());
    let link = |parent: &str, child: &str, rotation| {
        let mut link =
            TransformStamped { child_frame_id: child.into(), header: header(0, parent), ..Default::default() };
        link.transform.rotation = rotation;
        link
    };
    let over = Quaternion { x: 1.0, y: 0.0, z: 0.0, w: 0.0 };
    let image = Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
    let upside_down = |k| drive.array(k, "/lidar", |[x, y, z]| [x, -y, -z]);
    let camera = |k| drive.array(k, "camera", |[x, y, z]| [-y, -z, x]);
    let in_odom = |frame: &'static str, shift: f64| {
        let drive = &drive;
        move |k: u32| {
            let [x, y, heading] = drive.poses[k as usize];
            let (s, c) = heading.sin_cos();
            drive.array(k, frame, |[a, l, up]| [x + c * a - s * l + shift, y + s * a + c * l, up])
        }
    };
    let mut map = link("map", "odom", Quaternion::default());
    map.transform.translation.x = 7.0;
    let cases: [(&str, &str, Vec<u8>); 4] = [
        ("upside down", "whole rotation", drive.with_detections(&[link("/base", "lidar", over)], upside_down)),
        ("camera", "whole rotation", drive.with_detections(&[link("base", "/camera", image)], camera)),
        ("odom", "pose of the odometry", drive.with_detections(&[], in_odom("odom", 0.0))),
        ("map", "pose of the odometry", drive.with_detections(&[map], in_odom("/map", 7.0))),
    ];
    for (name, words, bytes) in cases {
        place.write("a.mcap", &bytes);
        let told = place.tells(&["import", "a.mcap", "--out", name]);
        assert!(told.contains(words) && !told.contains("warning"), "{name}: {told}");
        drive.fits(&log_folder::read(&place.path(name)).unwrap(), name);
    }
    place.write("a.mcap", drive.with_detections(&[], in_odom("map", 7.0)));
    let error = fails(&place, &["import", "a.mcap", "--out", "no"]);
    assert!(
        error.contains("detections are in the frame 'map'") && error.contains("neither /tf nor /tf_static"),
        "{error}"
    );
}

#[test]
fn decreasing_stamps_divide_a_recording() {
    let (place, drive) = (Place::new(), Drive::new());
    // The computer's clock is set back by three seconds.
    let set_back = |k: u32| stamp(if k < 300 { k } else { k - 30 });
    let bytes = drive.recording(&[
        &|writer, k| {
            let mut message = drive.odometry(k);
            message.header.stamp = set_back(k);
            writer.write("/odom", set_back(k), &message).unwrap();
        },
        &|writer, k| {
            let mut message = drive.array(k, "base", |place| place);
            message.header.stamp = set_back(k);
            writer.write("/landmarks", set_back(k), &message).unwrap();
        },
    ]);
    place.write("a.mcap", &bytes);
    let error = fails(&place, &["import", "a.mcap", "--out", "no"]);
    for words in [
        "/odom by 2.900 s back at message 301 (from 2023-11-14 22:13:49.900 UTC to 2023-11-14 22:13:47 UTC)",
        "/landmarks by 2.900 s back at message 301",
        "--part N takes one of the 2 parts, which last 29.9 s, 29.9 s",
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
    assert!(!error.contains("--clock") && !place.path("no").exists(), "{error}");
    for part in ["1", "2"] {
        let told = place.tells(&["import", "a.mcap", "--out", part, "--part", part]);
        assert!(told.contains(&format!("part {part} of 2 is taken")), "{told}");
        let log = log_folder::read(&place.path(part)).unwrap();
        assert_eq!((log.odometry.len(), log.scans.len()), (300, 300));
        let first = 300 * (part.parse::<usize>().unwrap() - 1);
        assert_eq!(log.odometry[0].control, drive.controls[first]);
    }
    assert!(fails(&place, &["import", "a.mcap", "--out", "no", "--part", "3"]).contains("into 2 parts"));
    place.write("good.mcap", drive.with_odometry(|_, _| {}));
    let told = place.tells(&["import", "good.mcap", "--out", "good"]);
    assert!(told.contains("counted from 1700000000 s on (2023-11-14 22:13:20 UTC)"), "{told}");
}

/// A degree to the north is 111.2 km here, a degree to the east 74.4 km.
fn fix_at(k: u32, [x, y]: [f64; 2]) -> NavSatFix {
    let mut fix = NavSatFix { header: header(k, "gps"), latitude: 48.0, longitude: 11.0, ..NavSatFix::default() };
    fix.latitude += y / 111_200.0;
    fix.longitude += x / 74_629.0;
    fix.position_covariance_type = 2;
    (fix.position_covariance[0], fix.position_covariance[4]) = (0.04, 0.04);
    fix
}

#[test]
fn invalid_positions_are_not_the_origin() {
    let (place, drive) = (Place::new(), Drive::new());
    let recording = |fix: &dyn Fn(u32) -> NavSatFix, truth: bool| {
        drive.recording(&[
            &|writer, k| writer.write("/odom", stamp(k), &drive.odometry(k)).unwrap(),
            &|writer, k| writer.write("/landmarks", stamp(k), &drive.array(k, "base", |place| place)).unwrap(),
            &|writer, k| {
                if k % 5 == 0 {
                    writer.write("/gps/fix", stamp(k), &fix(k)).unwrap();
                }
            },
            &|writer, k| {
                let mut pose = PoseStamped { header: header(k, "map"), ..PoseStamped::default() };
                let [x, y, heading] = drive.poses[k as usize];
                (pose.pose.position.x, pose.pose.position.y) = (x, y);
                pose.pose.orientation = Quaternion::of_yaw(heading);
                if truth {
                    writer.write("/ground_truth", stamp(k), &pose).unwrap();
                }
            },
        ])
    };
    let at = |k: u32| [drive.poses[k as usize][0], drive.poses[k as usize][1]];
    let near = |log: &Log, pose: &dyn Fn([f64; 2]) -> [f64; 2]| {
        for fix in &log.fixes {
            let PoseFix::Position([x, y]) = fix.measured else { panic!("a place") };
            let right = pose(at((fix.t_s * 10.0).round() as u32));
            assert!((x - right[0]).hypot(y - right[1]) < 0.1, "{fix:?} {right:?}");
        }
    };
    type Fix<'a> = &'a dyn Fn(u32) -> NavSatFix;
    let cases: [(&str, &str, Fix, usize); 4] = [
        (
            "zero",
            "20 fixes at 0°, 0° are left out",
            &|k| {
                if k < 100 { NavSatFix { latitude: 0.0, longitude: 0.0, ..fix_at(k, at(k)) } } else { fix_at(k, at(k)) }
            },
            100,
        ),
        (
            "far",
            "by 5",
            &|k| if k < 20 { NavSatFix { longitude: 90.0, ..fix_at(k, at(k)) } } else { fix_at(k, at(k)) },
            116,
        ),
        (
            "late",
            "20 fixes without a place",
            &|k| {
                let mut fix = fix_at(k, at(k));
                if k < 100 {
                    (fix.status.status, fix.latitude) = (-1, f64::NAN);
                }
                fix
            },
            100,
        ),
        (
            "turned",
            "the fixes are turned by -0.5",
            &|k| {
                let ([x, y], (s, c)) = (at(k), 0.5_f64.sin_cos());
                fix_at(k, [c * x - s * y, s * x + c * y])
            },
            120,
        ),
    ];
    for (name, words, fix, count) in cases {
        place.write("a.mcap", recording(fix, true));
        let told = place.tells(&["import", "a.mcap", "--out", name]);
        assert!(told.contains(words) && told.contains("lie on the true positions"), "{name}: {told}");
        let log = log_folder::read(&place.path(name)).unwrap();
        assert_eq!(log.fixes.len(), count, "{name}");
        near(&log, &|place| place);
        assert!(log.initial_pose[0].abs() < 1e-9 && log.initial_pose[2].abs() < 1e-9);
    }
    // Without truth, dead reckoning gives the initial pose in the frame of the fixes.
    place.write(
        "a.mcap",
        recording(
            &|k| {
                let mut fix = fix_at(k, [-at(k)[1], at(k)[0]]);
                fix.status.status = if k < 100 { -1 } else { 0 };
                fix
            },
            false,
        ),
    );
    let told = place.tells(&["import", "a.mcap", "--out", "start"]);
    assert!(told.contains("the vehicle starts at"), "{told}");
    let log = log_folder::read(&place.path("start")).unwrap();
    let [x, y, heading] = log.initial_pose;
    assert!((heading - std::f64::consts::FRAC_PI_2).abs() < 0.01, "{:?}", log.initial_pose);
    near(&log, &|[px, py]| [x - py, y + px]);
}

#[test]
fn bag_folders_and_compressed_recordings_are_read() {
    let (place, drive) = (Place::new(), Drive::new());
    let whole = drive.with_odometry(|_, _| {});
    let part = |from: u32, to: u32| {
        drive.recording(&[&|writer, k| {
            if (from..to).contains(&k) {
                writer.write("/odom", stamp(k), &drive.odometry(k)).unwrap();
                writer.write("/landmarks", stamp(k), &drive.array(k, "base", |place| place)).unwrap();
            }
        }])
    };
    place.write("whole.mcap", &whole);
    place.tells(&["import", "whole.mcap", "--out", "log"]);
    let right = log_folder::read(&place.path("log")).unwrap();
    fs::create_dir(place.path("bag")).unwrap();
    place.write("bag/bag_10.mcap", part(400, 600));
    place.write("bag/bag_9.mcap", part(0, 400));
    place.tells(&["import", "bag", "--out", "by_numbers"]);
    let list =
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag/bag_9.mcap\n    - bag_10.mcap\n  duration:\n";
    place.write("bag/metadata.yaml", list.as_bytes());
    place.tells(&["import", "bag", "--out", "listed"]);
    for name in ["by_numbers", "listed"] {
        let log = log_folder::read(&place.path(name)).unwrap();
        assert_eq!(Log { name: right.name.clone(), ..log }, right, "{name}");
    }
    place.write("bag/metadata.yaml", list.replace("bag_9", "bag_8").as_bytes());
    assert!(
        place
            .fails(&["import", "bag", "--out", "no"])
            .contains("bag_8.mcap: metadata.yaml lists it, but it is not there")
    );
    // The file extensions of zstd and lz4; the compression is recognised by the content.
    for end in ["zstd", "zst", "lz4"] {
        let (folder, out) = (format!("bag_{end}"), format!("of_{end}"));
        fs::create_dir(place.path(&folder)).unwrap();
        place.write(&format!("{folder}/bag_0.mcap.{end}"), &whole);
        place.tells(&["import", &folder, "--out", &out]);
        let log = log_folder::read(&place.path(&out)).unwrap();
        assert_eq!(Log { name: right.name.clone(), ..log }, right, "{end}");
    }
    place.write("a.db3", b"SQLite format 3\0and more");
    place.write("a.bag", b"#ROSBAG V2.0\nand more");
    for (name, words) in [("a.db3", "a recording in SQLite"), ("a.bag", "a recording of ROS 1")] {
        let error = fails(&place, &["import", name, "--out", "no"]);
        assert!(error.contains(words) && error.contains("rosbags-convert"), "{error}");
    }
}

#[test]
fn invalid_bearings_and_ranges_are_corrected_or_reported() {
    let (place, drive) = (Place::new(), Drive::new());
    // Azimuths from 0, and rays without a return at 30 m.
    let rays = |k: u32| {
        let seen = drive.seen(k);
        let rays = seen
            .iter()
            .map(|[ahead, left, _]| [ahead.hypot(*left), left.atan2(*ahead).rem_euclid(std::f64::consts::TAU)]);
        let nothing = (0..4).map(|ray| [30.0, 1.5 * f64::from(ray) + 0.01 * f64::from(k % 100)]);
        let points = rays.chain(nothing).map(|[range, azimuth]| ([range, azimuth], []));
        cloud(header(k, "base"), ["range", "azimuth"], [], points)
    };
    let bytes = drive
        .recording(&[&|writer, k| writer.write("/odom", stamp(k), &drive.odometry(k)).unwrap(), &|writer, k| {
            writer.write("/landmarks", stamp(k), &rays(k)).unwrap()
        }]);
    place.write("a.mcap", &bytes);
    let told = place.tells(&["import", "a.mcap", "--out", "named"]);
    assert!(told.contains("have bearings beyond half a turn") && told.contains("2400 of "), "{told}");
    assert!(told.contains("--range-below 29.997"), "{told}");
    let told = place.tells(&["import", "a.mcap", "--out", "log", "--range-below", "29.997"]);
    assert!(told.contains("2400 detections are left out whose range is not below 29.997 m"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert!(
        log.scans
            .iter()
            .flat_map(|scan| &scan.detections)
            .all(|[range, bearing]| *range < 12.0 && bearing.abs() <= std::f64::consts::PI)
    );
}

#[test]
fn tables_with_windows_line_ends_and_decimal_commas_are_read() {
    let place = Place::new();
    let odometry = |wrong: &str| -> String {
        let row = |k: i32| format!("{},{};1,5;{}\r\n", k / 10, k % 10, if k == 48 { wrong } else { "0,1" });
        "t;v;w\r\n".to_owned() + &(0..100).map(row).collect::<String>()
    };
    let seen: String = (0..90).map(|k| format!("{}\t{},5\t-0,25\r\n", k / 10, 4 + k % 3)).collect();
    place.write("d.csv", format!("t\tr\tb\r\n{seen}").as_bytes());
    let map = "[odometry]\nfile = \"o.csv\"\ntime = \"t\"\nspeed = \"v\"\nturn = \"w\"\n[detections]\nfile = \"d.csv\"\n\
               time = \"t\"\nrange = \"r\"\nbearing = \"b\"\n";
    place.write("map.toml", map.as_bytes());
    place.write("o.csv", odometry("0,1").as_bytes());
    let told = place.tells(&["import", "map.toml", "--out", "log"]);
    assert!(told.contains("o.csv: numbers have decimal commas") && told.contains("d.csv: numbers"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!(
        (log.odometry[12].t_s, log.odometry[12].control, log.scans[0].detections[1]),
        (1.2, [1.5, 0.1, 0.0], [5.5, -0.25])
    );
    place.write("o.csv", odometry("abc").as_bytes());
    let error = fails(&place, &["import", "map.toml", "--out", "no"]);
    assert!(error.contains("o.csv, line 50, column w: not a finite number: 'abc'"), "{error}");
    place.write("o.csv", odometry("0,1").replacen("5,0;", "3,0;", 1).as_bytes());
    let error = fails(&place, &["import", "map.toml", "--out", "no"]);
    assert!(error.contains("o.csv, line 52, column t: time goes back by 1.900 s"), "{error}");
    place.write("map.toml", map.replace("speed", "sped").replace("range", "rage").as_bytes());
    let error = fails(&place, &["import", "map.toml", "--out", "no"]);
    for words in ["no key 'sped'", "no key 'rage'", "missing field `speed`"] {
        assert!(error.contains(words), "{words}: {error}");
    }
}
