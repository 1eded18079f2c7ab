//! The pose of the filter to send, and the motion that a flight stack sends.

use crate::axes::{MapFrame, TRIANGLE, attitude, quaternion};
use crate::bytes::Reader;
use crate::frame::{Outgoing, Payload};

/// `MAV_FRAME_BODY_FRD`.
const BODY: u8 = 12;
/// `MAV_ESTIMATOR_TYPE_VISION`: PX4 refuses `LIDAR`.
const VISION: u8 = 2;

/// A pose in the map, in our axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// x, y, z (up), m.
    pub position_m: [f32; 3],
    /// Roll, pitch (nose down) and heading (to the left from x), rad.
    pub attitude_rad: [f32; 3],
    /// Covariance of x, y, z, roll, pitch and heading; `None` if it is unknown.
    pub covariance: Option<[[f32; 6]; 6]>,
}

/// The components of a pose that a planar filter does not estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffPlane {
    /// Height, m.
    pub z_m: f32,
    /// Its standard deviation, m.
    pub z_sigma_m: f32,
    /// Standard deviation of roll and pitch, rad; their values are 0.
    pub tilt_sigma_rad: f32,
}

impl OffPlane {
    /// On flat ground. ArduPilot adds the variances of the axes, so that a large one hides the others.
    pub const FLAT: Self = Self { z_m: 0.0, z_sigma_m: 0.1, tilt_sigma_rad: 0.05 };
}

impl Pose {
    /// The pose of a planar filter: x, y (m) and heading (rad), and their covariance.
    pub fn planar([x, y, heading]: [f32; 3], covariance: &[[f32; 3]; 3], off: OffPlane) -> Self {
        let [tilt, z] = [off.tilt_sigma_rad, off.z_sigma_m].map(|sigma| sigma * sigma);
        let [[xx, xy, xh], [yx, yy, yh], [hx, hy, hh]] = *covariance;
        let covariance = [
            [xx, xy, 0.0, 0.0, 0.0, xh],
            [yx, yy, 0.0, 0.0, 0.0, yh],
            [0.0, 0.0, z, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, tilt, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, tilt, 0.0],
            [hx, hy, 0.0, 0.0, 0.0, hh],
        ];
        Self { position_m: [x, y, off.z_m], attitude_rad: [0.0, 0.0, heading], covariance: Some(covariance) }
    }
}

/// Velocity and rates in the vehicle's axes: x ahead, y left, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Velocity, m/s.
    pub velocity_mps: [f32; 3],
    /// Rates about x, y (nose down) and z (to the left), rad/s.
    pub rates_radps: [f32; 3],
    /// Covariance of both, in this order; `None` if it is unknown.
    pub covariance: Option<[[f32; 6]; 6]>,
}

/// ODOMETRY: pose, velocity and rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    /// Time of the pose by the sender's clock, µs.
    pub time_us: u64,
    /// The axes of the map.
    pub frame: MapFrame,
    /// The pose.
    pub pose: Pose,
    /// Velocity and rates; `None` if one of them is unknown.
    pub twist: Option<Twist>,
    /// Its value changes if the pose has jumped.
    pub reset_counter: u8,
}

/// Vectors of the vehicle are transformed like positions in the local frame.
const VEHICLE: MapFrame = MapFrame::Local;

fn triangle(frame: MapFrame, covariance: Option<&[[f32; 6]; 6]>) -> [f32; TRIANGLE] {
    covariance.map_or([f32::NAN; TRIANGLE], |covariance| frame.triangle(covariance))
}

impl Outgoing for Odometry {
    const NUMBER: u32 = 331;
    const EXTRA: u8 = 91;

    fn write(&self, payload: &mut Payload) {
        let Self { time_us, frame, pose, twist, reset_counter } = self;
        let [velocity, rates] = twist.map_or([[f32::NAN; 3]; 2], |twist| {
            [twist.velocity_mps, twist.rates_radps].map(|vector| VEHICLE.place(vector))
        });
        let twist = twist.as_ref().and_then(|twist| twist.covariance.as_ref());
        payload
            .0
            .bytes(&time_us.to_le_bytes())
            .floats(&frame.place(pose.position_m))
            .floats(&quaternion(frame.attitude(pose.attitude_rad)))
            .floats(&velocity)
            .floats(&rates)
            .floats(&triangle(*frame, pose.covariance.as_ref()))
            .floats(&triangle(VEHICLE, twist))
            .bytes(&[frame.number(), BODY, *reset_counter, VISION]);
    }
}

impl Odometry {
    /// `None` if the message is in an unsupported frame, or a number is not finite where it must be.
    pub(crate) fn read(mut payload: Reader<'_>) -> Option<Self> {
        let time_us = payload.u64();
        let (position, turned) = (payload.floats::<3>(), payload.floats::<4>());
        let [velocity, rates] = [payload.floats::<3>(), payload.floats::<3>()];
        let [of_pose, of_twist] = [payload.floats(), payload.floats()];
        let (frame, body, reset_counter) = (MapFrame::of(payload.u8())?, payload.u8(), payload.u8());
        let is_pose = position.iter().chain(&turned).all(|number| number.is_finite());
        let length = turned.iter().map(|number| number * number).sum::<f32>();
        if body != BODY || !is_pose || !(length > 0.25 && length < 4.0) {
            return None;
        }
        let is_twist = velocity.iter().chain(&rates).all(|number| number.is_finite());
        let twist = is_twist.then(|| Twist {
            velocity_mps: VEHICLE.place(velocity),
            rates_radps: VEHICLE.place(rates),
            covariance: VEHICLE.covariance(&of_twist),
        });
        let pose = Pose {
            position_m: frame.place(position),
            attitude_rad: frame.attitude(attitude(turned)),
            covariance: frame.covariance(&of_pose),
        };
        Some(Self { time_us, frame, pose, twist, reset_counter })
    }
}

/// VISION_POSITION_ESTIMATE: the pose only. The message does not contain its frame: PX4 assumes north and east.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisionPosition {
    /// Time of the pose by the sender's clock, µs.
    pub time_us: u64,
    /// The axes of the map.
    pub frame: MapFrame,
    /// The pose.
    pub pose: Pose,
    /// Its value changes if the pose has jumped.
    pub reset_counter: u8,
}

impl Outgoing for VisionPosition {
    const NUMBER: u32 = 102;
    const EXTRA: u8 = 158;

    fn write(&self, payload: &mut Payload) {
        let Self { time_us, frame, pose, reset_counter } = self;
        payload
            .0
            .bytes(&time_us.to_le_bytes())
            .floats(&frame.place(pose.position_m))
            .floats(&frame.attitude(pose.attitude_rad))
            .floats(&triangle(*frame, pose.covariance.as_ref()))
            .bytes(&[*reset_counter]);
    }
}
