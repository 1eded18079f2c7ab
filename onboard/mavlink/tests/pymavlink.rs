//! pymavlink reads our messages, and its messages are read here; over UDP it simulates a vehicle beside a filter.
//!
//! `cargo xtask mavlink` installs it in an environment and runs these tests, which are skipped without it.

#[path = "../examples/companion.rs"]
mod companion;

use nalgebra::{Matrix3, Matrix6, Quaternion, Rotation3, UnitQuaternion, Vector3};
use scphd_mavlink::{
    Heartbeat, Incoming, MapFrame, Odometry, OffPlane, Pose, Receiver, Sender, TimeSync, Twist, VisionPosition,
};
use std::io::Write;
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// The environment variable with the path of that Python.
const PYTHON: &str = "SCPHD_MAVLINK_PYTHON";

/// Passes lines to the peer, and returns the lines that it prints.
fn peer(words: &[&str], input: &str) -> Vec<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peer.py");
    let mut python = Command::new(std::env::var_os(PYTHON).expect(PYTHON));
    python.arg(script).args(words).stdin(Stdio::piped()).stdout(Stdio::piped()).env("PYTHONDONTWRITEBYTECODE", "1");
    let mut child = python.spawn().unwrap();
    let (mut lines, input) = (child.stdin.take().unwrap(), input.to_owned());
    let writer = std::thread::spawn(move || lines.write_all(input.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success(), "{words:?}");
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// A line of fields: name and numbers.
fn fields(line: &str) -> (&str, Vec<f64>) {
    let (name, numbers) = line.split_once(' ').unwrap();
    (name, numbers.split(' ').map(|number| number.parse().unwrap()).collect())
}

/// The rotation from our axes of the map to theirs; with `Local`, also that of the vehicle's axes.
fn axes(frame: MapFrame) -> Matrix3<f64> {
    match frame {
        MapFrame::Local => Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
        MapFrame::EastNorth => Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0),
    }
}

/// Signs of roll, pitch and heading in their axes.
const TURNED: [f64; 3] = [1.0, -1.0, -1.0];

/// The covariance in their axes.
fn covariance(frame: MapFrame, ours: &[[f32; 6]; 6]) -> Matrix6<f64> {
    let mut change = Matrix6::zeros();
    change.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes(frame));
    change.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_diagonal(&TURNED.into()));
    change * Matrix6::from_fn(|row, column| f64::from(ours[row][column])) * change.transpose()
}

fn is_triangle(triangle: &[f64], of: Option<Matrix6<f64>>) {
    let Some(of) = of else {
        assert!(triangle[0].is_nan());
        return;
    };
    let pairs = (0..6).flat_map(|row| (row..6).map(move |column| (row, column)));
    for (number, (row, column)) in triangle.iter().zip(pairs) {
        assert_eq!(*number, of[(row, column)], "{row} {column}");
    }
}

/// The rotation of roll, pitch and heading.
fn turn([roll, pitch, heading]: [f64; 3]) -> Matrix3<f64> {
    Rotation3::from_euler_angles(roll, pitch, heading).into_inner()
}

fn is_near(one: impl IntoIterator<Item = f64>, other: impl IntoIterator<Item = f64>, tolerance: f64) {
    let (one, other): (Vec<f64>, Vec<f64>) = (one.into_iter().collect(), other.into_iter().collect());
    assert!(
        one.len() == other.len() && one.iter().zip(&other).all(|(a, b)| (a - b).abs() <= tolerance),
        "{one:?} {other:?}"
    );
}

/// Checks their rotation for an attitude of ours, roll, pitch and heading.
fn is_turned(frame: MapFrame, theirs: Matrix3<f64>, ours: [f32; 3]) {
    let expected = axes(frame) * turn(ours.map(f64::from)) * axes(MapFrame::Local);
    is_near(theirs.iter().copied(), expected.iter().copied(), 3e-6);
}

fn quaternion(numbers: &[f64]) -> Matrix3<f64> {
    let [w, x, y, z] = *numbers else { panic!("{numbers:?}") };
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
}

/// Checks an ODOMETRY of theirs against ours.
fn is_odometry(theirs: &[f64], ours: &Odometry) {
    let frame = ours.frame;
    assert_eq!(theirs[0], ours.time_us as f64);
    assert_eq!(theirs[1..3], [if frame == MapFrame::Local { 20.0 } else { 1.0 }, 12.0]);
    is_near(
        theirs[3..6].iter().copied(),
        (axes(frame) * Vector3::from(ours.pose.position_m.map(f64::from))).iter().copied(),
        0.0,
    );
    is_turned(frame, quaternion(&theirs[6..10]), ours.pose.attitude_rad);
    is_triangle(&theirs[16..37], ours.pose.covariance.map(|ours| covariance(frame, &ours)));
    let Some(twist) = ours.twist else {
        assert!(theirs[10..16].iter().any(|number| number.is_nan()));
        return;
    };
    let vehicle = axes(MapFrame::Local);
    let speeds = [twist.velocity_mps, twist.rates_radps].map(|speed| vehicle * Vector3::from(speed.map(f64::from)));
    is_near(theirs[10..16].iter().copied(), speeds.iter().flat_map(|speed| speed.iter().copied()), 0.0);
    is_triangle(&theirs[37..58], twist.covariance.map(|ours| covariance(MapFrame::Local, &ours)));
    assert_eq!(theirs[58], f64::from(ours.reset_counter));
}

/// Random numbers from −1 to 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn some<const N: usize>(&mut self, size: f32) -> [f32; N] {
        [(); N].map(|()| size * self.next())
    }

    fn covariance(&mut self) -> Option<[[f32; 6]; 6]> {
        let half: [[f32; 6]; 6] = [(); 6].map(|()| self.some(10.0));
        let whole = core::array::from_fn(|row| core::array::from_fn(|column| half[row.min(column)][row.max(column)]));
        (self.next() > -0.5).then_some(whole)
    }
}

#[test]
#[ignore = "needs Python packages: cargo xtask mavlink"]
fn pymavlink_reads_what_is_sent() {
    let (mut draws, mut sender) = (Draws(1), Sender::new(7, Sender::VISUAL_ODOMETRY));
    let (mut lines, mut sent) = (String::new(), Vec::new());
    let mut line = |frame: &[u8]| {
        lines.extend(frame.iter().map(|byte| format!("{byte:02x}")));
        lines.push('\n');
    };
    for k in 0..200_u64 {
        let frame = if k % 2 == 0 { MapFrame::Local } else { MapFrame::EastNorth };
        let pose =
            Pose { position_m: draws.some(100.0), attitude_rad: draws.some(1.5), covariance: draws.covariance() };
        let twist =
            Twist { velocity_mps: draws.some(9.0), rates_radps: draws.some(9.0), covariance: draws.covariance() };
        let (twist, reset_counter) = (Some(twist).filter(|_| k % 3 > 0), k as u8);
        let odometry = Odometry { time_us: 1_000_003 * k, frame, pose, twist, reset_counter };
        line(&sender.frame(&odometry));
        line(&sender.frame(&VisionPosition { time_us: odometry.time_us, frame, pose, reset_counter }));
        line(&sender.frame(&TimeSync { answered_ns: -(k as i64), asked_ns: i64::MAX - k as i64 }));
        sent.push(odometry);
    }
    line(&sender.frame(&Heartbeat));
    let read = peer(&["read"], &lines);
    assert_eq!(read.len(), 3 * sent.len() + 1);
    for (lines, sent) in read.chunks_exact(3).zip(&sent) {
        let [(one, odometry), (two, vision), (three, _)] = [0, 1, 2].map(|k| fields(&lines[k]));
        assert_eq!([one, two, three], ["ODOMETRY", "VISION_POSITION_ESTIMATE", "TIMESYNC"]);
        is_odometry(&odometry, sent);
        assert_eq!(odometry[58..60], [f64::from(sent.reset_counter), 2.0]);
        is_near(vision[1..4].iter().copied(), odometry[3..6].iter().copied(), 0.0);
        is_turned(sent.frame, turn([vision[4], vision[5], vision[6]]), sent.pose.attitude_rad);
        is_triangle(&vision[7..28], sent.pose.covariance.map(|ours| covariance(sent.frame, &ours)));
        assert_eq!(vision[28], f64::from(sent.reset_counter));
        assert_eq!(
            lines[2],
            format!("TIMESYNC {} {}", -(i64::from(sent.reset_counter)), i64::MAX - i64::from(sent.reset_counter))
        );
    }
    assert_eq!(read.last().unwrap(), "HEARTBEAT 18 8 0 0 4 3");
}

#[test]
#[ignore = "needs Python packages: cargo xtask mavlink"]
fn messages_of_pymavlink_are_read() {
    let (mut receiver, mut read, mut positions) = (Receiver::new(), 0, 0);
    for line in peer(&["write"], "") {
        let (bytes, line) = line.split_once(' ').unwrap();
        let bytes: Vec<u8> =
            (0..bytes.len()).step_by(2).map(|at| u8::from_str_radix(&bytes[at..at + 2], 16).unwrap()).collect();
        let (name, theirs) = fields(line);
        let received = receiver.read(&mut &bytes[..]);
        if name == "GPS_RAW_INT" && theirs[1] < 2.0 {
            assert_eq!(received, None);
            continue;
        }
        let received = received.unwrap();
        assert_eq!((received.system, received.component), (3, 1));
        match received.message {
            Incoming::Odometry(ours) => is_odometry(&theirs, &ours),
            Incoming::Target(ours) => {
                assert_eq!([theirs[0], theirs[1]], [ours.time_us as f64, f64::from(ours.number)]);
                let [right, down] = [theirs[3].tan(), theirs[4].tan()];
                let ahead = if theirs[16] > 0.0 {
                    Vector3::new(theirs[8], -theirs[9], -theirs[10])
                } else {
                    Vector3::new(1.0, -right, -down).normalize() * theirs[5]
                };
                let distance = f64::from(ours.distance_m.unwrap());
                let [bearing, elevation] = [ours.bearing_rad, ours.elevation_rad].map(f64::from);
                let found = turn([0.0, -elevation, bearing]) * Vector3::x() * distance;
                is_near(found.iter().copied(), ahead.iter().copied(), 1e-4);
                let [range, _] = ours.in_plane().unwrap();
                assert!((f64::from(range) - ahead.xy().norm()).abs() < 1e-4);
            }
            Incoming::Satellite(ours) => {
                let sigma = ours.sigma_m.map_or(0.0, |sigma| f64::from(sigma) * 1e3);
                let numbers =
                    [ours.time_us as f64, f64::from(ours.latitude_e7), f64::from(ours.longitude_e7), sigma.round()];
                assert_eq!(numbers, [theirs[0], theirs[2], theirs[3], theirs[11]]);
                positions += 1;
            }
            Incoming::TimeSync(ours) => assert_eq!([ours.answered_ns as f64, ours.asked_ns as f64], theirs[..2]),
            other => panic!("{other:?}"),
        }
        read += 1;
    }
    assert!(read > 700 && positions > 100, "{read} {positions}");
    assert_eq!((receiver.report().messages, receiver.report().damaged, receiver.report().skipped), (read, 0, 0));
}

#[test]
#[ignore = "needs Python packages: cargo xtask mavlink"]
fn a_vehicle_over_udp_is_informed_of_its_jump() {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = socket.local_addr().unwrap().port().to_string();
    let companion = std::thread::spawn(move || {
        companion::accompany(&socket, Duration::from_secs(3)).map_err(|error| error.to_string())
    });
    let lines = peer(&["drive", &port], "");
    let sent = companion.join().unwrap().unwrap();
    assert_eq!(lines.len(), 2 * sent.len());
    for (lines, sent) in lines.chunks_exact(2).zip(&sent) {
        let [(_, odometry), (_, vision)] = [0, 1].map(|k| fields(&lines[k]));
        let pose = Pose::planar(sent.pose, &sent.covariance, OffPlane::FLAT);
        let (time_us, frame, reset_counter) = (sent.time_us, MapFrame::Local, sent.reset_counter);
        is_odometry(&odometry, &Odometry { time_us, frame, pose, twist: None, reset_counter });
        is_triangle(&vision[7..28], pose.covariance.map(|ours| covariance(frame, &ours)));
        assert_eq!([odometry[58], vision[28]], [f64::from(reset_counter); 2]);
    }
    let jumps = sent.last().unwrap().reset_counter;
    println!("{} poses over UDP, {jumps} jumps", sent.len());
}
