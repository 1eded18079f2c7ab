//! Two radars on one car, at its front left and at its back, with other noise, other views and other times: each is a detector with a
//! mounting of its own, and every scan says whose it is.

use nalgebra::Vector2;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Motion, Mounting, PlanarPose, Pose, RangeBearing,
    RangeBearingLimits, RangeBearingWindow, Sensing, UniformClutter,
};
use scphd::numerics::{Noise, wrap};
use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, memory};
use std::f64::consts::PI;

memory! {
    type Memory: Ackermann<f64> {
        particles: 4, samples: 1,
        features { pages: 256, pages_per_map: 48, in_view: 512 },
    }
}
type Radar = Detector<Sensing<RangeBearing<f64>, RangeBearingWindow<f64>, UniformClutter<f64>>>;

/// A radar with this noise, that sees so far and so far aside, where it is mounted.
fn radar(
    sigmas: [f64; 2],
    range_m: f64,
    half_width_rad: f64,
    seat: Mounting<f64>,
) -> Result<Radar, scphd::models::ModelError> {
    let view = RangeBearingWindow::new(RangeBearingLimits {
        bearing_half_width_rad: half_width_rad,
        range_edge_m: 3.0 * sigmas[0],
        bearing_edge_rad: 3.0 * sigmas[1],
        ..RangeBearingLimits::full_circle(range_m, 0.8)
    })?;
    let sensing = Sensing::range_bearing([sigmas[0], sigmas[1]], view, 1.0)?;
    Detector::new(sensing, Births::of_static(0.1 / view.measure()))?.mounted(seat)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seats = [Mounting::in_plane(3.8, 0.5, 0.3)?, Mounting::in_plane(-0.6, 0.0, PI)?];
    let (sigmas, ranges_m, widths_rad) = ([[0.2, 0.01], [0.5, 0.03]], [40.0, 25.0], [1.2, 0.9]);
    let mut rooms = [(); 2].map(|()| DetectorMemory::<Vector2<f64>, 32>::new());
    let [front_room, rear_room] = &mut rooms;
    let mut front = radar(sigmas[0], ranges_m[0], widths_rad[0], seats[0])?.over(front_room)?;
    let mut rear = radar(sigmas[1], ranges_m[1], widths_rad[1], seats[1])?.over(rear_room)?;

    // The pose is the middle of the rear axle: the lever arms are the radars'.
    let geometry =
        AckermannGeometry { wheelbase_m: 2.8, encoder_offset_m: 0.0, sensor_forward_m: 0.0, sensor_left_m: 0.0 };
    let mut state = Box::new(Memory::new());
    // Odometry whose errors last: wheels that are worn, a steering angle that is off.
    let car = Ackermann::new(geometry, ControlNoise::wheeled())?;
    let mut slam = ScPhd::new(car, Config::informed(4), &mut *state)?;
    slam.reset(PlanarPose::ZERO, 1)?;

    let exact = Ackermann::new(geometry, ControlNoise::NONE)?;
    let mut draws = Noise::seeded(3);
    let landmarks: Vec<[f64; 2]> =
        (0..40).map(|_| [80.0 * draws.uniform::<f64>() - 40.0, 80.0 * draws.uniform::<f64>() - 15.0]).collect();
    let (mut truth, mut told) = (PlanarPose::ZERO, PlanarPose::ZERO);
    for step in 0..1200 {
        let control = AckermannControl { speed_mps: 5.0, steering_rad: 0.11 };
        truth = exact.propagate(&truth, &control, 0.05);
        let odometry = AckermannControl {
            speed_mps: 5.2 + 0.3 * draws.normal::<f64>(),
            steering_rad: 0.115 + 0.02 * draws.normal::<f64>(),
        };
        told = exact.propagate(&told, &odometry, 0.05);
        slam.predict(&odometry, 0.05)?;
        // The front at 10 Hz, the rear at 4 Hz.
        for (which, due) in [(0, step % 2 == 0), (1, step % 5 == 0)] {
            let (seat, _) = truth.mounted(&seats[which]);
            let mut scan = Vec::new();
            for [x, y] in landmarks.iter().filter(|_| due) {
                let (dx, dy) = (x - seat.x_m, y - seat.y_m);
                let (range, bearing) = (dx.hypot(dy), wrap(dy.atan2(dx) - seat.heading_rad));
                let noise =
                    Vector2::new(sigmas[which][0] * draws.normal::<f64>(), sigmas[which][1] * draws.normal::<f64>());
                if range < ranges_m[which] && bearing.abs() < widths_rad[which] && draws.uniform::<f64>() < 0.8 {
                    scan.push(Vector2::new(range, bearing) + noise);
                }
            }
            if due {
                let wide = widths_rad[which] * (2.0 * draws.uniform::<f64>() - 1.0);
                scan.push(Vector2::new(ranges_m[which] * draws.uniform::<f64>(), wide));
                let detector = if which == 0 { &mut front } else { &mut rear };
                slam.scan(detector, &scan)?;
            }
        }
    }
    let pose = slam.estimate_pose().ok_or("not started")?.mean;
    let off = |pose: &PlanarPose<f64>| (pose.x_m - truth.x_m).hypot(pose.y_m - truth.y_m);
    println!("after a minute {:.2} m off; dead reckoning {:.2} m", off(&pose), off(&told));
    assert!(off(&pose) < 0.5 && off(&pose) < off(&told));
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
