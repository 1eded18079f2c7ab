//! The effect of messages on the filter, for each type.

use scphd::numerics::nalgebra::Vector2;
use scphd_node::engine::{Engine, Estimate};
use scphd_node::inputs::{Inputs, Role};
use scphd_node::maps;
use scphd_node::parameters::Parameters;
use scphd_node::setup::Setup;
use scphd_ros::messages::{
    Header, Imu, LaserScan, NavSatFix, Odometry, Quaternion, TFMessage, Transform, TransformStamped, Vector3,
};
use scphd_ros::{Message, Time, encode};

struct Robot {
    engine: Engine,
    inputs: Inputs,
    last: Option<Estimate>,
}

impl Robot {
    fn new(words: &[&str]) -> Self {
        let mut parameters = Parameters::default();
        words.iter().for_each(|word| parameters.assign(word).unwrap());
        let engine = Engine::new(Setup::of(&parameters).unwrap()).unwrap();
        let inputs = Inputs::new(engine.setup());
        Self { engine, inputs, last: None }
    }

    fn take<M: Message>(&mut self, role: Role, message: &M) -> Result<(), String> {
        let place = self.inputs.topics.iter().position(|input| input.role == role).unwrap();
        self.inputs.take(place, &encode(message).unwrap(), &mut self.engine)?;
        self.engine.work(&mut |estimate| self.last = Some(estimate.clone()));
        Ok(())
    }

    fn odometry(&mut self, at_ms: u64, speed: f64, rate: f64) {
        let mut message = Odometry { header: header(at_ms, "odom"), ..Odometry::default() };
        (message.twist.twist.linear.x, message.twist.twist.angular.z) = (speed, rate);
        self.take(Role::Odometry, &message).unwrap();
    }

    fn only_feature(&mut self) -> Vector2<f32> {
        let features = maps::known(self.engine.slam());
        assert_eq!(features.len(), 1, "{:?}", self.engine.counts());
        features[0].mean
    }
}

fn header(at_ms: u64, frame: &str) -> Header {
    Header::new(Time::from_nanoseconds(at_ms * 1_000_000), frame)
}

/// A scan from 135° right to 135° left, a beam every quarter of a degree: a post 3 m to the left.
fn scan(at_ms: u64) -> LaserScan {
    let step = 0.25_f32.to_radians();
    let mut ranges = vec![f32::INFINITY; 1081];
    ranges[896..=904].fill(2.91);
    LaserScan {
        header: header(at_ms, "laser"),
        angle_min: -540.0 * step,
        angle_max: 540.0 * step,
        angle_increment: step,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.05,
        range_max: 30.0,
        ranges,
        intensities: Vec::new(),
    }
}

/// Runs with a large stack, because without optimisation the memory of a filter is built on the stack.
fn roomy(work: impl FnOnce() + Send) {
    scphd_run::session::with_roomy_stack(work).unwrap();
}

#[test]
fn a_post_in_a_laser_scan_is_a_landmark_at_its_transformed_position() {
    roomy(|| {
        let words = ["sensor.type:=sensor_msgs/msg/LaserScan", "sensor.topic:=/scan", "sensor.posts.radius_m:=0.06"];
        let mut robot = Robot::new(&words);
        robot.odometry(0, 0.0, 0.0);
        let refused = robot.take(Role::Scan(0), &scan(0)).unwrap_err();
        assert!(refused.contains("no transform from base_link to laser"), "{refused}");
        // One metre ahead, facing left.
        let link = TransformStamped {
            header: header(0, "base_link"),
            child_frame_id: "laser".into(),
            transform: Transform {
                translation: Vector3 { x: 1.0, y: 0.0, z: 0.4 },
                rotation: Quaternion::of_yaw(std::f64::consts::FRAC_PI_2),
            },
        };
        robot.take(Role::Seats, &TFMessage { transforms: vec![link] }).unwrap();
        for k in 1..10 {
            robot.odometry(100 * k, 0.0, 0.0);
            robot.take(Role::Scan(0), &scan(100 * k)).unwrap();
        }
        let place = robot.only_feature();
        assert!((place - Vector2::new(1.0 - 2.96, 0.0)).norm() < 0.05, "{place}");
    });
}

#[test]
fn the_inertial_unit_gives_the_turn_rate() {
    roomy(|| {
        let mut robot = Robot::new(&["imu.topic:=/imu", "sensor.left_m:=0.0"]);
        for k in 0..=50_u64 {
            robot.odometry(20 * k, 1.0, 0.0);
            let message = Imu {
                header: header(20 * k, "imu"),
                angular_velocity: Vector3 { z: 0.5, ..Vector3::default() },
                ..Imu::default()
            };
            robot.take(Role::Turns, &message).unwrap();
        }
        let cloud = scphd_ros::cloud(header(1000, "base_link"), ["x", "y", "z"], [], []);
        robot.take(Role::Scan(0), &cloud).unwrap();
        let pose = robot.last.unwrap().pose.mean;
        assert!((pose.heading_rad - 0.5).abs() < 0.011 && pose.x_m > 0.9, "{pose:?}");
    });
}

#[test]
fn satellite_fixes_are_metres_east_and_north_of_the_origin() {
    roomy(|| {
        let words = [
            "position:=yes",
            "position.sigma:=0.1",
            "fixes.type:=sensor_msgs/msg/NavSatFix",
            "fixes.latitude_deg:=52.0",
            "fixes.longitude_deg:=13.0",
            "start.position_sigma_m:=100.0",
            "start.heading_sigma_rad:=0.1",
        ];
        let mut robot = Robot::new(&words);
        for k in 0..5_u64 {
            robot.odometry(100 * k, 0.0, 0.0);
            let message = NavSatFix {
                header: header(100 * k, "gps"),
                latitude: 52.0001,
                longitude: 13.0002,
                ..NavSatFix::default()
            };
            robot.take(Role::Fixes, &message).unwrap();
        }
        // One degree is 111 265 m and 68 677 m there.
        let pose = robot.last.as_ref().unwrap().pose.mean;
        assert!((pose.y_m - 11.13).abs() < 0.05 && (pose.x_m - 13.74).abs() < 0.05, "{pose:?}");
        let lost = NavSatFix { latitude: f64::NAN, ..NavSatFix::default() };
        assert!(robot.take(Role::Fixes, &lost).is_err());
    });
}
