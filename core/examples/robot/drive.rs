//! The robot and its world: a lidar 0.22 m ahead of the axle and turned by 30°, a radar at the back, a position every ten seconds, and
//! wheels that are worn. Without std, so that a board runs the same.

use nalgebra::Vector2;
use scphd::errors::SetupError;
use scphd::models::{
    ControlNoise, ModelError, Motion, Mounting, PlanarPose, Pose, PositionFix, RangeBearing, RangeBearingLimits,
    RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl, UniformClutter,
};
use scphd::numerics::{Noise, wrap};
use scphd::{Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, Real, ScPhd, joint_memory, memory};

memory! {
    type Mixture: Unicycle<f32> { particles: 4, samples: 1, features { pages: 96, pages_per_map: 24, in_view: 256 } }
}
joint_memory! { type Map: Unicycle<f32> { measurement: Vector2<f32>, features: 48, measurements: 32 } }

/// All memory of both filters and of their detectors, for a static.
pub struct Memory {
    mixture: Mixture,
    joint: Map,
    lidar: DetectorMemory<Vector2<f32>, 32>,
    radar: DetectorMemory<Vector2<f32>, 16>,
}

impl Memory {
    pub const NEW: Self =
        Self { mixture: Mixture::new(), joint: Map::new(), lidar: DetectorMemory::new(), radar: DetectorMemory::new() };
}

/// How it went, by the mixture and by the joint map.
#[derive(Debug)]
pub struct Outcome {
    pub rmse_m: [f32; 2],
    pub dead_reckoning_m: f32,
    pub digests: [u64; 2],
}

/// What a sensor on this robot is like: noise (m, rad), range (m), half width of its view (rad), false measurements a scan.
struct Kind {
    sigmas: [f32; 2],
    range_m: f32,
    half_width_rad: f32,
    clutter: f32,
}

const LIDAR: Kind = Kind { sigmas: [0.05, 0.01], range_m: 12.0, half_width_rad: 2.0, clutter: 2.0 };
const RADAR: Kind = Kind { sigmas: [0.2, 0.03], range_m: 20.0, half_width_rad: 0.8, clutter: 1.0 };
type Eye = Detector<Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>>;

impl Kind {
    fn detector(&self, mounting: Mounting<f32>) -> Result<Eye, ModelError> {
        let full = RangeBearingLimits::full_circle(self.range_m, 0.85);
        let (range_edge_m, bearing_edge_rad) = (3.0 * self.sigmas[0], 3.0 * self.sigmas[1]);
        let limits =
            RangeBearingLimits { bearing_half_width_rad: self.half_width_rad, range_edge_m, bearing_edge_rad, ..full };
        let field_of_view = RangeBearingWindow::new(limits)?;
        let sensing = Sensing::range_bearing([self.sigmas[0], self.sigmas[1]], field_of_view, self.clutter)?;
        Detector::new(sensing, Births::of_static(0.1 / field_of_view.measure()))?.mounted(mounting)
    }

    /// Writes what it reports from its seat, and returns how many that are.
    fn scan(&self, seat: &PlanarPose<f32>, posts: &[[f32; 2]], draws: &mut Noise, into: &mut [Vector2<f32>]) -> usize {
        let (mut slots, mut reported) = (into.iter_mut(), 0);
        let mut report = |z| slots.next().map_or((), |slot| (*slot, reported) = (z, reported + 1));
        for [x, y] in posts {
            let (dx, dy) = (x - seat.x_m, y - seat.y_m);
            let (range, bearing) = (Real::sqrt(dx * dx + dy * dy), wrap(Real::atan2(dy, dx) - seat.heading_rad));
            let noise = self.sigmas.map(|sigma| sigma * draws.normal::<f32>());
            if range < self.range_m && bearing.abs() < self.half_width_rad && draws.uniform::<f32>() < 0.85 {
                report(Vector2::new(range + noise[0], bearing + noise[1]));
            }
        }
        let aside = self.half_width_rad * (2.0 * draws.uniform::<f32>() - 1.0);
        report(Vector2::new(0.1 + (self.range_m - 0.1) * draws.uniform::<f32>(), aside));
        reported
    }
}

/// Drives for two minutes.
pub fn drive(memory: &mut Memory) -> Result<Outcome, SetupError> {
    let seats = [Mounting::in_plane(0.22, 0.0, f32::PI / 6.0)?, Mounting::in_plane(-0.3, 0.1, f32::PI)?];
    let mut lidar = LIDAR.detector(seats[0])?.over(&mut memory.lidar)?;
    let mut radar = RADAR.detector(seats[1])?.over(&mut memory.radar)?;
    let gps = PositionFix::new(0.3)?.gated(25.0)?;
    let config = Config { prune_weight: 1e-3, ..Config::informed(4) };
    let noise = ControlNoise::wheeled();
    let mut mixture = ScPhd::new(Unicycle::new(Step::Arc, noise)?, config, &mut memory.mixture)?;
    let mut joint = JointSlam::new(Unicycle::new(Step::Arc, noise)?, JointConfig::default(), &mut memory.joint)?;
    let (mut truth, mut draws) = (PlanarPose::new(5.0, 0.0, 0.5 * f32::PI), Noise::seeded(5));
    let _finite = (mixture.reset(truth, 1), joint.reset(truth));

    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    let (mut told, mut scan, mut squares) = (truth, [Vector2::zeros(); 32], [0.0; 2]);
    let mut posts = [[0.0; 2]; 24];
    posts.as_flattened_mut().iter_mut().for_each(|x| *x = 24.0 * draws.uniform::<f32>() - 12.0);
    for step in 1..=1200 {
        truth = exact.propagate(&truth, &UnicycleControl { speed_mps: 1.0, rate_radps: 0.2 }, 0.1);
        let odometry = UnicycleControl { speed_mps: 1.04, rate_radps: 0.206 };
        told = exact.propagate(&told, &odometry, 0.1);
        let _left_out = (mixture.predict(&odometry, 0.1), joint.predict(&odometry, 0.1));
        let seen = LIDAR.scan(&truth.mounted(&seats[0]).0, &posts, &mut draws, &mut scan);
        let _refused = (mixture.scan(&mut lidar, &scan[..seen]), joint.scan(&lidar, &scan[..seen]));
        if step % 4 == 0 {
            let seen = RADAR.scan(&truth.mounted(&seats[1]).0, &posts, &mut draws, &mut scan[..16]);
            let _refused = (mixture.scan(&mut radar, &scan[..seen]), joint.scan(&radar, &scan[..seen]));
        }
        if step % 100 == 0 {
            let z = Vector2::new(truth.x_m + 0.3 * draws.normal::<f32>(), truth.y_m + 0.3 * draws.normal::<f32>());
            let _refused = (mixture.observe(&gps, &z), joint.observe(&gps, &z));
        }
        for (square, estimate) in squares.iter_mut().zip([mixture.estimate_pose(), joint.estimate_pose()]) {
            let off = estimate.map_or(f32::INFINITY, |pose| pose.mean.distance_m(&truth));
            *square += off * off;
        }
    }
    let rmse_m = squares.map(|square| Real::sqrt(square / 1200.0));
    Ok(Outcome { rmse_m, dead_reckoning_m: told.distance_m(&truth), digests: [mixture.digest(), joint.digest()] })
}
