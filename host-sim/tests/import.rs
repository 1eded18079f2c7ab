//! Recordings become logs, a run that was written becomes the log that it was of, and what is wrong is told in one line.

use scphd_ros::messages::{
    AckermannDriveStamped, Detection3D, Detection3DArray, Header, JointState, NavSatFix, Odometry, PointCloud2,
    PoseArray, PoseStamped, PoseWithCovarianceStamped, Quaternion, RadarReturn, RadarScan, TFMessage, TransformStamped,
};
use scphd_ros::{Message, Time, Writer, cloud};
use scphd_sim::log::{FixNoise, Log, PoseFix};
use scphd_sim::{log_folder, scenario};
use serde_json::Value;
use std::fs;
use std::io::Cursor;
use std::path::PathBuf;
use std::process::{Command, Output};
use tempfile::TempDir;

struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_scphd-sim")).args(args).current_dir(self.0.path()).output().unwrap()
    }

    /// What is told on stderr.
    fn succeeds(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {output:?}");
        String::from_utf8(output.stderr).unwrap()
    }

    fn fails(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {output:?}");
        let error = String::from_utf8(output.stderr).unwrap();
        error.lines().last().unwrap_or_default().to_owned()
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }
}

/// Times as a recorder has them: whole nanoseconds.
fn decimal(log: &mut Log) {
    let round = |t_s: &mut f64| *t_s = (*t_s * 1e6).round() / 1e6;
    log.odometry.iter_mut().for_each(|row| round(&mut row.t_s));
    log.scans.iter_mut().for_each(|scan| round(&mut scan.t_s));
    log.fixes.iter_mut().for_each(|fix| round(&mut fix.t_s));
    log.truth.iter_mut().for_each(|row| round(&mut row.t_s));
}

/// A car, a car with fixes, two sensors and a unicycle, each as a folder and its run as a file.
#[test]
fn a_run_that_was_written_is_read_as_the_log_that_it_was_of() {
    for name in ["survey", "survey-fixes", "two-sensors", "worlds-exact"] {
        let place = Place::new();
        let mut log = scenario::by_name(name, 5).unwrap();
        // A part of it, with the first fix, that a build without optimisation runs in a minute.
        log.scans.truncate(130);
        decimal(&mut log);
        log_folder::write(&log, &place.path("log")).unwrap();
        place.succeeds(&["replay", "log", "--mcap", "run.mcap", "--json", "then.json"]);
        place.succeeds(&["import", "run.mcap", "--out", "back"]);
        let back = log_folder::read(&place.path("back")).unwrap();
        // To the bit, but true headings, which come through quaternions, and tracks of movers, which no message has.
        let near = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).sin().abs() < 1e-12,
            (a, b) => a == b,
        };
        assert_eq!(back.truth.len(), log.truth.len(), "{name}");
        for (a, b) in back.truth.iter().zip(&log.truth) {
            assert!(a.t_s == b.t_s && a.position == b.position && near(a.heading_rad, b.heading_rad), "{name}");
        }
        assert_eq!(Log { truth: log.truth.clone(), moving: log.moving.clone(), ..back }, log, "{name}");
        place.succeeds(&["replay", "back", "--json", "now.json"]);
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

/// A recording; every topic gets the message of each time.
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
fn a_radar_and_its_seat_are_found() {
    let place = Place::new();
    let mut link = TransformStamped { child_frame_id: "radar".into(), header: header(0, "base"), ..Default::default() };
    link.transform.translation.x = 1.5;
    link.transform.rotation = Quaternion::of_yaw(0.25);
    let recording = Recording::new().with_odometry().with("/radar/scan", radar);
    let recording = recording.with("/tf_static", |_| TFMessage { transforms: vec![link.clone()] });
    place.write("drive.mcap", &recording.bytes());
    let told = place.succeeds(&["import", "drive.mcap", "--out", "log"]);
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
    place.succeeds(&["replay", "log"]);
}

#[test]
fn landmarks_of_images_and_clouds_are_seen_from_above() {
    let place = Place::new();
    // Two metres ahead and one to the left, by the axes of a body and of an image.
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
        // A laser's whole cloud is not taken for landmarks.
        Recording::new().with_odometry().with("/clusters", clouds).with("/velodyne_points", clouds).bytes(),
    ];
    for (k, bytes) in bytes.iter().enumerate() {
        place.write("a.mcap", bytes);
        let told = place.succeeds(&["import", "a.mcap", "--out", &k.to_string()]);
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
        // A receiver that loses its satellites, then drives north: a second of arc is 30.88 m here.
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
    place.write("a.mcap", &both.bytes());
    let told = place.succeeds(&["import", "a.mcap", "--out", "gps"]);
    assert!(told.contains("1 fixes without a place") && told.contains("47.000000000°"), "{told}");
    let log = log_folder::read(&place.path("gps")).unwrap();
    assert_eq!((log.fixes.len(), log.fix_noise.position_sigma_m), (29, Some(2.0)));
    let PoseFix::Position([east, north]) = log.fixes[28].measured else { panic!("a place") };
    assert!(east.abs() < 1e-6 && (north / 29.0 - 30.88).abs() < 0.01, "{east} {north}");
    assert_eq!((log.truth.len(), log.truth[2].position, log.initial_pose[0]), (30, [2.0, 0.0], 0.0));
    assert!((log.initial_pose[2] - 1.0).abs() < 1e-12);
    place.succeeds(&["import", "a.mcap", "--out", "none", "--fixes", "none", "--truth", "none"]);
    let log = log_folder::read(&place.path("none")).unwrap();
    assert!(log.fixes.is_empty() && log.truth.is_empty() && log.fix_noise == FixNoise::default());

    // Poses that say nothing of their quality need a head that does.
    let poses = |k| PoseWithCovarianceStamped { header: header(k, "map"), ..PoseWithCovarianceStamped::default() };
    place.write("b.mcap", &Recording::new().with_odometry().with("/radar", radar).with("/pose", poses).bytes());
    let error = place.fails(&["import", "b.mcap", "--out", "b", "--fixes", "/pose"]);
    assert!(error.contains("position_sigma_m") && !place.path("b").exists(), "{error}");
}

#[test]
fn cars_need_a_head_and_poses_make_velocities() {
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
    place.write("car.mcap", &Recording::new().with("/drive", drive).with("/radar", radar).bytes());
    place.write("joints.mcap", &Recording::new().with("/joints", joints).with("/radar", radar).bytes());
    let error = place.fails(&["import", "car.mcap", "--out", "log"]);
    assert!(error.contains("/drive needs --head") && error.contains("ackermann"), "{error}");
    log_folder::write(&scenario::survey(1), &place.path("like")).unwrap();
    let head = place.path("like/log.toml");
    let head = head.to_str().unwrap();
    for (file, control) in [("car.mcap", [2.0, 0.125, 0.0]), ("joints.mcap", [2.5, 0.1, 0.0])] {
        place.succeeds(&["import", file, "--out", file.trim_end_matches(".mcap"), "--head", head]);
        let log = log_folder::read(&place.path(file.trim_end_matches(".mcap"))).unwrap();
        assert_eq!((log.odometry[3].control, log.vehicle), (control, scenario::survey(1).vehicle));
    }

    // Odometry that has poses alone: half a metre in a tenth of a second, then a standstill.
    let poses = |k: u32| {
        let mut message = odometry(k);
        message.twist = Default::default();
        message.pose.pose.position.x = 0.5 * f64::from(k.min(20));
        message
    };
    place.write("poses.mcap", &Recording::new().with("/odom", poses).with("/radar", radar).bytes());
    let told = place.succeeds(&["import", "poses.mcap", "--out", "poses"]);
    assert!(told.contains("made of its poses"), "{told}");
    let log = log_folder::read(&place.path("poses")).unwrap();
    assert!((log.odometry[3].control[0] - 5.0).abs() < 1e-6 && log.odometry[25].control == [0.0; 3]);
}

#[test]
fn what_is_missing_or_wrong_is_told_in_one_line() {
    let place = Place::new();
    let good = Recording::new().with_odometry().with("/radar", radar).bytes();
    place.write("good.mcap", &good);
    place.write("torn.mcap", &good[..good.len() / 2]);
    place.write("text.mcap", b"no recording at all");
    place.write("empty.mcap", b"");
    place.write("still.mcap", &Recording::new().with_odometry().bytes());
    place.write("blind.mcap", &Recording::new().with("/radar", radar).bytes());
    place.write(
        "two.mcap",
        &Recording::new().with("/a/odom", odometry).with("/b/odom", odometry).with("/radar", radar).bytes(),
    );
    let nan = |k| {
        let mut message = odometry(k);
        message.twist.twist.linear.x = if k == 9 { f64::NAN } else { 1.0 };
        message
    };
    place.write("nan.mcap", &Recording::new().with("/odom", nan).with("/radar", radar).bytes());
    let big = |k| PointCloud2 { width: 9, height: 9, ..cloud(header(k, ""), ["x", "y"], [], [([1.0, 1.0], [])]) };
    place.write("cloud.mcap", &Recording::new().with_odometry().with("/landmarks", big).bytes());
    let unnamed = |k| cloud(header(k, ""), ["a"], [], [([1.0], [])]);
    place.write("fields.mcap", &Recording::new().with_odometry().with("/landmarks", unnamed).bytes());
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
        let error = place.fails(&[&["import", "--out", "log"], *words].concat());
        assert!(error.starts_with("error: "), "{error}");
        expected.iter().for_each(|part| assert!(error.contains(part), "{words:?}: {error}"));
        assert!(!place.path("log").exists(), "{words:?}");
    }
    let told = place.succeeds(&["import", "good.mcap", "--out", "log", "--clock", "log"]);
    assert!(told.contains("odometry: /robot/odom"), "{told}");
    assert!(place.fails(&["import", "good.mcap", "--out", "log"]).contains("not empty"));
}

/// Wherever a recording is damaged, the program ends by itself and says so, or reads the same log.
#[test]
fn damaged_recordings_never_panic() {
    use scphd_sim::exchange::import::recording::{Options, read};
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
    // Two of one image, and a barcode that nobody has.
    let seen = format!("{0} 63 2.5 -0.25\n{0} 14 1.0 0.5\n{1} 99 2.0 0.1\n", times[20], times[40]);
    put("Robot1_Measurement.dat", format!("# Time barcode r b\n{seen}"));
    let told = place.succeeds(&["import", "data", "--out", "log"]);
    assert!(told.contains("1248272263 s on") && told.contains("1 detections have a barcode"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.odometry.len(), log.truth.len(), log.landmarks.len(), log.moving.len()), (200, 200, 2, 200));
    assert_eq!((log.odometry[0].t_s, log.initial_pose), (0.103, [0.0, -0.5, 0.25]));
    let found: Vec<_> = log.scans.iter().map(|scan| (scan.t_s, scan.detections.clone(), scan.labels.clone())).collect();
    assert_eq!(found, [(0.403, vec![[2.5, -0.25], [1.0, 0.5]], vec![6, 2]), (0.703, vec![[2.0, 0.1]], vec![-1])]);
    assert_eq!((log.name.as_str(), log.nominal.range_sigma_m), ("UTIAS MRCLAM robot 1", Some(0.16)));
    place.succeeds(&["replay", "log"]);

    assert!(place.fails(&["import", "data", "--robot", "3", "--out", "no"]).contains("Robot3_Odometry.dat"));
    put("Robot1_Measurement.dat", format!("# Time barcode r b\n{} 63 far -0.25\n", times[20]));
    let error = place.fails(&["import", "data", "--out", "no"]);
    assert!(error.contains("Robot1_Measurement.dat, line 2, column 2: not a finite number: 'far'"), "{error}");
    fs::create_dir(place.path("other")).unwrap();
    assert!(place.fails(&["import", "other", "--out", "no"]).contains("neither the files of MRCLAM"));
    assert!(place.fails(&["import", "data", "--out", "no", "--truth", "none"]).contains("of MCAP files alone"));
}

/// A MAT-file of level 4 with matrices of doubles, column by column, and one of 16 bits.
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
    // A trunk of three rays 8 m straight ahead; the highest bits say how bright it is.
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
    let told = place.succeeds(&["import", "park", "--out", "log"]);
    assert!(told.contains("80 rows of odometry, 8 scans"), "{told}");
    let log = log_folder::read(&place.path("log")).unwrap();
    assert_eq!((log.odometry[1].t_s, log.odometry[1].control), (21.965, [1.5, -0.003, 0.0]));
    let thick = 8.0 * 3.0 * std::f64::consts::PI / 360.0;
    for scan in &log.scans {
        let [[range, bearing]] = scan.detections[..] else { panic!("{scan:?}") };
        assert!((range - 8.0 - 0.5 * thick).abs() < 1e-12 && bearing == 0.0, "{range} {bearing}");
    }
    assert_eq!((log.truth.len(), log.initial_pose), (9, [-67.0, -41.0, 0.6196]));
    place.succeeds(&["replay", "log"]);

    put("aa3_dr.mat", mat(&dr[..2]));
    let error = place.fails(&["import", "park", "--out", "no"]);
    assert!(error.contains("aa3_dr.mat: no matrix steering; there are speed, time"), "{error}");
    put("aa3_dr.mat", mat(&dr)[..300].to_vec());
    assert!(place.fails(&["import", "park", "--out", "no"]).contains("aa3_dr.mat: it ends in the middle of a matrix"));
}

#[test]
fn tables_are_read_by_a_map_of_their_columns() {
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
    place.succeeds(&["import", "map.toml", "--out", "log"]);
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
        let error = place.fails(&["import", "wrong.toml", "--out", "no"]);
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
