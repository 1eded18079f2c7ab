//! The simulated world.

use crate::Event;
use scphd::Real;
use scphd::models::{AuvPose, BodyFrame, Mounting, PlanarPose, Pose};
use scphd::numerics::{Noise, wrap};

/// Number of lidar scans; the other sensors have fewer.
pub const SCANS: usize = 300;

/// A sensor in the plane: greatest range, m, half width of the view, rad, and standard deviations of range and bearing.
struct Eye {
    seat: Mounting<f32>,
    range_m: f32,
    half_width_rad: f32,
    sigmas: [f32; 2],
}

impl Eye {
    fn scan(&self, robot: &PlanarPose<f32>, features: &[[f32; 2]], draws: &mut Noise) -> Vec<[f32; 2]> {
        let (seat, _) = robot.mounted(&self.seat);
        let mut scan = Vec::new();
        for [x, y] in features {
            let (dx, dy) = (x - seat.x_m, y - seat.y_m);
            let (range, bearing) = (Real::sqrt(dx * dx + dy * dy), wrap(Real::atan2(dy, dx) - seat.heading_rad));
            let noise = self.sigmas.map(|sigma| sigma * draws.normal::<f32>());
            if range < self.range_m && bearing.abs() < self.half_width_rad && draws.uniform::<f32>() < 0.85 {
                scan.push([range + noise[0], wrap(bearing + noise[1])]);
            }
        }
        let aside = self.half_width_rad * (2.0 * draws.uniform::<f32>() - 1.0);
        scan.push([0.1 + (self.range_m - 0.1) * draws.uniform::<f32>(), aside]);
        scan
    }
}

/// A robot drives in circles among posts and past two walkers; a diver swims among rocks. The same in every run.
///
/// # Panics
/// Never: the mountings are in range.
#[must_use]
pub fn events() -> Vec<Event> {
    let lidar = Eye {
        seat: Mounting::in_plane(0.22, 0.0, 0.5).expect("a place"),
        range_m: 12.0,
        half_width_rad: 2.0,
        sigmas: [0.05, 0.01],
    };
    let radar = Eye {
        seat: Mounting::in_plane(-0.3, 0.1, 3.0).expect("a place"),
        range_m: 20.0,
        half_width_rad: 0.8,
        sigmas: [0.2, 0.03],
    };
    let mut draws = Noise::seeded(5);
    let mut features = [[0.0; 2]; 22];
    features.as_flattened_mut().iter_mut().for_each(|x| *x = 24.0 * draws.uniform::<f32>() - 12.0);
    let mut rocks = [[0.0; 3]; 14];
    rocks.as_flattened_mut().iter_mut().for_each(|x| *x = 12.0 * draws.uniform::<f32>() - 6.0);

    let mut robot = PlanarPose::new(5.0_f32, 0.0, 0.5 * f32::PI);
    let mut diver = AuvPose::new(2.0_f32, 0.0, -1.0, 0.5 * f32::PI);
    let mut events = Vec::new();
    for step in 1..=SCANS {
        let dt = 0.1;
        robot = turned(robot, 1.0, 0.2, dt);
        for (walker, speed) in features.iter_mut().zip([0.7, -0.9]) {
            walker[0] += speed * dt;
        }
        events.push(Event::Predict([1.04, 0.206, dt]));
        // Fixes before scans of the same time, as in logs.
        if step % 50 == 0 {
            events.push(Event::Position([robot.x_m, robot.y_m].map(|x| x + 0.3 * draws.normal::<f32>())));
        }
        if step % 70 == 0 {
            events.push(Event::Heading(wrap(robot.heading_rad + 0.05 * draws.normal::<f32>())));
        }
        events.push(Event::Lidar(lidar.scan(&robot, &features, &mut draws)));
        if step % 4 == 0 {
            events.push(Event::Radar(radar.scan(&robot, &features, &mut draws)));
        }
        if step % 10 == 0 {
            let scan = lidar.scan(&robot, &features, &mut draws);
            events.push(Event::Camera(scan.into_iter().map(|[_, bearing]| bearing).collect()));
        }
        if step % 3 == 0 {
            let ground = turned(PlanarPose::new(diver.x_m, diver.y_m, diver.yaw_rad), 0.6, 0.3, 0.3);
            diver = AuvPose { x_m: ground.x_m, y_m: ground.y_m, yaw_rad: ground.heading_rad, ..diver };
            let noise: [f32; 3] = core::array::from_fn(|_| draws.normal());
            events.push(Event::Dive([
                0.6 + 0.05 * noise[0],
                0.02,
                0.0,
                0.3 + 0.02 * noise[1],
                diver.z_m + 0.05 * noise[2],
                0.3,
            ]));
            events.push(Event::Sonar(sonar(&diver, &rocks, &mut draws)));
        }
        if step % 90 == 0 {
            events.push(Event::Height(diver.z_m + 0.1 * draws.normal::<f32>()));
        }
        events.push(Event::Compare);
    }
    events
}

/// The true pose after a step.
fn turned(from: PlanarPose<f32>, speed: f32, rate: f32, dt: f32) -> PlanarPose<f32> {
    let along = from.heading_rad + 0.5 * rate * dt;
    let (sine, cosine) = along.sin_cos();
    let way = speed * dt;
    PlanarPose::new(from.x_m + way * cosine, from.y_m + way * sine, wrap(from.heading_rad + rate * dt))
}

fn sonar(diver: &AuvPose<f32>, rocks: &[[f32; 3]], draws: &mut Noise) -> Vec<[f32; 3]> {
    let frame = BodyFrame::of(diver);
    let mut scan = Vec::new();
    for rock in rocks {
        let [x, y, z]: [f32; 3] = frame.to_body(&(*rock).into()).into();
        let across = Real::sqrt(x * x + y * y);
        let range = Real::sqrt(across * across + z * z);
        let noise = [0.05, 0.02, 0.02].map(|sigma| sigma * draws.normal::<f32>());
        if range < 8.0 && draws.uniform::<f32>() < 0.9 {
            let bearing = wrap(Real::atan2(y, x) + noise[1]);
            scan.push([range + noise[0], bearing, Real::atan2(z, across) + noise[2]]);
        }
    }
    scan
}
