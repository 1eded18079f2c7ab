//! Random bytes and damaged messages are rejected or used: the node does not panic, and the filter continues.

use scphd_node::engine::Engine;
use scphd_node::inputs::{Inputs, Role};
use scphd_node::parameters::Parameters;
use scphd_node::setup::{DETECTIONS, ODOMETRY, Setup};
use scphd_ros::messages::{
    AckermannDrive, AckermannDriveStamped, Detection3D, Detection3DArray, Header, JointState, LaserScan, Odometry,
    Pose, PoseArray, PoseWithCovarianceStamped, RadarReturn, RadarScan, TFMessage, TransformStamped,
};
use scphd_ros::{Time, cloud, encode};

/// xorshift64*, so that failures are reproducible.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % bound.max(1)
    }
}

fn header(at_ns: u64) -> Header {
    Header::new(Time::from_nanoseconds(at_ns), "base_link")
}

/// A valid message of a type.
fn good(kind: &str, at_ns: u64) -> Vec<u8> {
    let header = header(at_ns);
    let bytes = match kind {
        "nav_msgs/msg/Odometry" => encode(&Odometry { header, ..Odometry::default() }),
        "sensor_msgs/msg/JointState" => encode(&JointState {
            header,
            name: vec!["drive".into(), "steering".into()],
            position: vec![0.0, 0.1],
            velocity: vec![1.0, 0.0],
            effort: Vec::new(),
        }),
        "ackermann_msgs/msg/AckermannDriveStamped" => {
            encode(&AckermannDriveStamped { header, drive: AckermannDrive { speed: 1.0, ..AckermannDrive::default() } })
        }
        "sensor_msgs/msg/PointCloud2" => encode(&cloud(
            header,
            ["x", "y", "z"],
            ["range", "bearing"],
            (0..9).map(|k| ([1.0; 3], [f64::from(k), 0.1])),
        )),
        "vision_msgs/msg/Detection3DArray" => {
            encode(&Detection3DArray { header, detections: vec![Detection3D::default(); 3] })
        }
        "sensor_msgs/msg/LaserScan" => encode(&LaserScan {
            header,
            angle_min: -1.0,
            angle_increment: 0.1,
            range_max: 10.0,
            ranges: (0..20_u8).map(|k| if k == 9 { 3.0 } else { 9.0 }).collect(),
            ..LaserScan::default()
        }),
        "geometry_msgs/msg/PoseArray" => encode(&PoseArray { header, poses: vec![Pose::default(); 3] }),
        "radar_msgs/msg/RadarScan" => {
            encode(&RadarScan { header, returns: vec![RadarReturn { range: 3.0, ..RadarReturn::default() }; 3] })
        }
        "geometry_msgs/msg/PoseWithCovarianceStamped" => {
            encode(&PoseWithCovarianceStamped { header, ..PoseWithCovarianceStamped::default() })
        }
        _ => encode(&TFMessage { transforms: vec![TransformStamped { header, ..TransformStamped::default() }; 2] }),
    };
    bytes.unwrap()
}

#[test]
fn damaged_messages_never_stop_the_node() {
    let work = || {
        let mut random = Random(1);
        for (odometry, detections) in [0, 1, 2, 0, 0].into_iter().map(|of| ODOMETRY[of]).zip(DETECTIONS) {
            let mut parameters = Parameters::default();
            let car = if odometry == ODOMETRY[0] { "unicycle" } else { "ackermann" };
            for word in [
                format!("odometry.type:={odometry}"),
                format!("sensor.type:={detections}"),
                format!("vehicle.kind:={car}"),
                "position:=yes".into(),
                "heading:=yes".into(),
            ] {
                parameters.assign(&word).unwrap();
            }
            let mut engine = Engine::new(Setup::of(&parameters).unwrap()).unwrap();
            let mut inputs = Inputs::new(engine.setup());
            let kinds: Vec<(Role, String)> =
                inputs.topics.iter().map(|input| (input.role, input.channel.kind.clone())).collect();
            let (mut taken, mut refused) = (0, 0);
            for round in 0..20_000_u64 {
                let place = random.below(kinds.len());
                let mut bytes = good(&kinds[place].1, round * 10_000_000);
                match random.below(4) {
                    0 => bytes.truncate(random.below(bytes.len())),
                    1 => {
                        for _ in 0..=random.below(8) {
                            let at = random.below(bytes.len());
                            bytes[at] = random.below(256) as u8;
                        }
                    }
                    2 => bytes = (0..random.below(200)).map(|_| random.below(256) as u8).collect(),
                    _ => {}
                }
                match inputs.take(place, &bytes, &mut engine) {
                    Ok(_) => taken += 1,
                    Err(_) => refused += 1,
                }
                engine.work(&mut |_| {});
            }
            assert!(taken > 5_000 && refused > 5_000, "{odometry}, {detections}: {taken} taken, {refused} refused");
            assert!(engine.slam().audit().is_ok());
            assert!(engine.counts().scans > 100, "{detections}: {:?}", engine.counts());
        }
    };
    scphd_run::session::with_roomy_stack(work).unwrap();
}
