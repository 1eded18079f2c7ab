//! A filter on a companion computer of a flight stack: receives speeds and targets over UDP, and sends poses. `companion
//! 0.0.0.0:14560` listens there and answers the sender. Without arguments it checks itself with a simulated vehicle, over loopback.

use nalgebra::Vector2;
use scphd::models::{ControlNoise, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
use scphd::{Births, Detector, JointConfig, JointSlam, joint_memory};
use scphd_mavlink::{
    Heartbeat, Incoming, MapFrame, Odometry, OffPlane, Pose, Received, Receiver, ResetCounter, Sender, Twist,
    VisionPosition,
};
use std::error::Error;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

joint_memory! { type Map: Unicycle<f32> { measurement: Vector2<f32>, features: 32, measurements: 16 } }

/// Correction of the pose above which the reset counter increases, m and rad.
const JUMP: (f32, f32) = (0.5, 0.1);
/// Greatest distance of a target, m; farther ones are left out.
const FAR_M: f32 = 15.0;

/// A pose that was sent: its time, x, y, heading, covariance, and the reset counter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sent {
    pub time_us: u64,
    pub pose: [f32; 3],
    pub covariance: [[f32; 3]; 3],
    pub reset_counter: u8,
}

/// Serves until there was no message for the time `silence`. Returns the poses that were sent.
pub fn accompany(socket: &UdpSocket, silence: Duration) -> Result<Vec<Sent>, Box<dyn Error>> {
    let view = RangeBearingWindow::full_circle(FAR_M, 0.95)?;
    let sensing = Sensing::range_bearing([0.05, 0.01], view, 0.1)?;
    let detector = Detector::new(sensing, Births::of_static(0.1 / view.measure()))?;
    let mut memory = Box::new(Map::new());
    let motion = Unicycle::new(Step::Arc, ControlNoise::wheeled())?;
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut memory)?;
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;

    let (mut receiver, mut sender) = (Receiver::new(), Sender::new(1, Sender::VISUAL_ODOMETRY));
    let mut resets = ResetCounter::new(JUMP.0, JUMP.1);
    let (mut last_us, mut seen_us, mut scan) = (None, 0, Vec::new());
    let (begun, mut beat_s, mut sent) = (Instant::now(), 0, Vec::new());
    socket.set_read_timeout(Some(silence))?;
    let mut datagram = [0; 2048];
    while let Ok((len, peer)) = socket.recv_from(&mut datagram) {
        if begun.elapsed().as_secs() >= beat_s {
            beat_s = begun.elapsed().as_secs() + 1;
            socket.send_to(&sender.frame(&Heartbeat), peer)?;
        }
        let mut bytes = &datagram[..len];
        while let Some(Received { message, .. }) = receiver.read(&mut bytes) {
            match message {
                Incoming::Odometry(Odometry { time_us, twist: Some(twist), .. }) => {
                    let dt_s = time_us.saturating_sub(last_us.unwrap_or(time_us)) as f32 * 1e-6;
                    last_us = Some(time_us);
                    let control =
                        UnicycleControl { speed_mps: twist.velocity_mps[0], rate_radps: twist.rates_radps[2] };
                    if dt_s > 0.0 {
                        slam.predict(&control, dt_s)?;
                    }
                }
                Incoming::Target(target) => {
                    seen_us = target.time_us;
                    scan.extend(target.in_plane().map(Vector2::from));
                    continue;
                }
                Incoming::TimeSync(question) => {
                    if let Some(answer) = question.answer(begun.elapsed().as_nanos() as i64 + 1) {
                        socket.send_to(&sender.frame(&answer), peer)?;
                    }
                    continue;
                }
                _ => continue,
            }
            // The targets before this sample, which have the same time, are one scan.
            let place = |pose: PlanarPose<f32>| [pose.x_m, pose.y_m, pose.heading_rad];
            if !scan.is_empty() && last_us.is_some_and(|last_us| last_us >= seen_us) {
                let before = slam.estimate_pose().map(|estimate| place(estimate.mean));
                slam.scan(&detector, &scan)?;
                scan.clear();
                let after = slam.estimate_pose().map(|estimate| place(estimate.mean));
                if let (Some(before), Some(after)) = (before, after) {
                    resets.between(before, after);
                }
            }
            let (Some(time_us), Some(estimate)) = (last_us, slam.estimate_pose()) else { continue };
            let (pose, covariance) = (place(estimate.mean), estimate.covariance.to_matrix().into());
            sent.push(Sent { time_us, pose, covariance, reset_counter: resets.value() });
            let reset_counter = resets.value();
            let (pose, frame) = (Pose::planar(pose, &covariance, OffPlane::FLAT), MapFrame::Local);
            socket.send_to(&sender.frame(&Odometry { time_us, frame, pose, twist: None, reset_counter }), peer)?;
            socket.send_to(&sender.frame(&VisionPosition { time_us, frame, pose, reset_counter }), peer)?;
        }
    }
    Ok(sent)
}

#[cfg_attr(test, allow(dead_code))]
fn main() -> Result<(), Box<dyn Error>> {
    match std::env::args().nth(1) {
        Some(address) => {
            let sent = accompany(&UdpSocket::bind(address)?, Duration::from_secs(3600))?;
            println!("{} poses", sent.len());
            Ok(())
        }
        None => check(),
    }
}

/// Simulates a vehicle that drives an arc for two seconds, and checks the poses that it receives and their covariance.
fn check() -> Result<(), Box<dyn Error>> {
    let companion = UdpSocket::bind("127.0.0.1:0")?;
    let address = companion.local_addr()?;
    let beside =
        std::thread::spawn(move || accompany(&companion, Duration::from_secs(1)).map_err(|error| error.to_string()));
    let vehicle = UdpSocket::bind("127.0.0.1:0")?;
    vehicle.set_read_timeout(Some(Duration::from_secs(1)))?;
    let (mut sender, mut receiver) = (Sender::new(1, 1), Receiver::new());
    let twist = Twist { velocity_mps: [1.0, 0.0, 0.0], rates_radps: [0.0, 0.0, 0.5], covariance: None };
    let still = Pose { position_m: [0.0; 3], attitude_rad: [0.0; 3], covariance: None };
    let mut poses = Vec::new();
    for sample in 0..=40 {
        let odometry = Odometry {
            time_us: 50_000 * sample,
            frame: MapFrame::Local,
            pose: still,
            twist: Some(twist),
            reset_counter: 0,
        };
        vehicle.send_to(&sender.frame(&odometry), address)?;
        let mut datagram = [0; 2048];
        while poses.len() as u64 <= sample {
            let len = vehicle.recv(&mut datagram)?;
            let mut bytes = &datagram[..len];
            while let Some(received) = receiver.read(&mut bytes) {
                if let Incoming::Odometry(odometry) = received.message {
                    poses.push(odometry);
                }
            }
        }
    }
    let sent = beside.join().map_err(|_| "the companion has stopped")??;
    let last = poses.last().ok_or("no pose")?;
    let ([x, y, _], [_, _, heading]) = (last.pose.position_m, last.pose.attitude_rad);
    println!("{} poses; after 2 s x {x:.3} m, y {y:.3} m, heading {heading:.3} rad", poses.len());
    // An arc of radius 2 m and 1 rad to the left.
    let off = (x - 2.0 * 1_f32.sin()).hypot(y - 2.0 * (1.0 - 1_f32.cos()));
    assert!(off < 0.01 && (heading - 1.0).abs() < 1e-3 && sent.len() == poses.len());
    let variance = last.pose.covariance.map(|covariance| covariance[0][0]);
    assert_eq!(variance, sent.last().map(|sent| sent.covariance[0][0]));
    Ok(())
}

#[cfg(test)]
#[test]
fn a_vehicle_gets_its_pose() {
    check().unwrap();
}
