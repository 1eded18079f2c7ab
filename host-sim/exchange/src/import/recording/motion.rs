//! Odometry of messages.

use super::sight::frame;
use super::told::Told;
use super::twist::{self, Sample};
use crate::import::ImportError;
use crate::mcap::{BASE, JOINTS, UNKNOWN};
use scphd_log::angle::wrap;
use scphd_log::log::Vehicle;
use scphd_ros::Time;
use scphd_ros::messages::{AckermannDriveStamped, JointState, Odometry};

/// Rows in the order of the recording; their times are set afterwards.
#[derive(Debug, Default)]
pub(super) struct Motion {
    rows: Vec<(u64, Sample)>,
    base: Option<String>,
    world: Option<String>,
}

/// A message of odometry.
#[derive(Debug, Default)]
pub struct Moved {
    pub stamp: Time,
    pub sample: Sample,
    /// The frame of the vehicle; empty if the message does not name it.
    pub base: String,
    /// The frame of the pose; empty if the message does not name it.
    pub world: String,
    /// Whether the covariance says that the pose is unknown.
    pub unplaced: bool,
}

/// Reads a message of odometry: `Odometry`, `JointState` or `AckermannDriveStamped`.
pub fn moved(told: &Told) -> Result<Moved, ImportError> {
    match told.channel.kind.as_str() {
        "nav_msgs/msg/Odometry" => {
            let message: Odometry = told.decode()?;
            let (twist, pose) = (message.twist.twist, message.pose.pose);
            let speed = told.finite("twist.linear.x", twist.linear.x)?;
            // Most vehicles have no sideways speed, and some drivers then write NaN.
            let left_mps = if twist.linear.y.is_finite() { twist.linear.y } else { 0.0 };
            let rate = told.finite("twist.angular.z", twist.angular.z)?;
            let turn = pose.orientation.unit().map(|turn| turn.yaw_rad());
            let pose = turn.map(|turn| [pose.position.x, pose.position.y, turn]);
            let pose = pose.filter(|pose| pose.iter().all(|number| number.is_finite()));
            let [base, world] = [&message.child_frame_id, &message.header.frame_id].map(|name| frame(name).to_owned());
            let sample = Sample { control: [speed, rate, left_mps], pose };
            let unplaced = message.pose.covariance[0][0] >= UNKNOWN;
            Ok(Moved { stamp: message.header.stamp, sample, base, world, unplaced })
        }
        "sensor_msgs/msg/JointState" => {
            let message: JointState = told.decode()?;
            let number = |joint: &str, numbers: &[f64]| {
                let place = message.name.iter().position(|name| name == joint);
                let number = place.and_then(|place| numbers.get(place)).copied();
                let number = number.ok_or_else(|| {
                    told.error(format_args!(
                        "no velocity of a joint '{}' and position of a joint '{}'",
                        JOINTS[0], JOINTS[1]
                    ))
                })?;
                told.finite(joint, number)
            };
            let control = [number(JOINTS[0], &message.velocity)?, number(JOINTS[1], &message.position)?, 0.0];
            let sample = Sample { control, ..Sample::default() };
            Ok(Moved { stamp: message.header.stamp, sample, ..Moved::default() })
        }
        _ => {
            let message: AckermannDriveStamped = told.decode()?;
            let speed = told.finite("speed", f64::from(message.drive.speed))?;
            let steering = told.finite("steering_angle", f64::from(message.drive.steering_angle))?;
            let sample = Sample { control: [speed, steering, 0.0], ..Sample::default() };
            Ok(Moved { stamp: message.header.stamp, sample, ..Moved::default() })
        }
    }
}

impl Motion {
    /// Adds a message; [`at`](Self::at) sets its time.
    pub(super) fn take(&mut self, told: &Told) -> Result<Time, ImportError> {
        let Moved { stamp, sample, base, world, .. } = moved(told)?;
        let named = |known: &mut Option<String>, name: String| {
            if known.is_none() && !name.is_empty() {
                *known = Some(name);
            }
        };
        named(&mut self.base, base);
        named(&mut self.world, world);
        self.rows.push((0, sample));
        Ok(stamp)
    }

    /// Sets the time of the last message, ns.
    pub(super) fn at(&mut self, ns: u64) {
        self.rows.iter_mut().last().into_iter().for_each(|(at, _)| *at = ns);
    }

    pub(super) fn times(&self) -> impl Iterator<Item = u64> + '_ {
        self.rows.iter().map(|(ns, _)| *ns)
    }

    pub(super) fn base(&self) -> &str {
        self.base.as_deref().unwrap_or(BASE)
    }

    /// The frame of the poses, if they have one.
    pub(super) fn world(&self) -> Option<&str> {
        self.world.as_deref()
    }

    /// Keeps some of the messages, by index, in order of time.
    pub(super) fn keep(&mut self, kept: impl Fn(usize) -> bool) {
        let rows = std::mem::take(&mut self.rows).into_iter().enumerate();
        self.rows = rows.filter(|(k, _)| kept(*k)).map(|(_, row)| row).collect();
        self.rows.sort_by_key(|(ns, _)| *ns);
    }

    /// The pose of the messages at a time, ns, linearly interpolated; `None` without poses.
    pub(super) fn pose(&self, ns: u64) -> Option<[f64; 3]> {
        let after = self.rows.partition_point(|(at, _)| *at <= ns);
        let (from_ns, from) = self.rows.get(after.saturating_sub(1))?;
        let Some((to_ns, to)) = self.rows.get(after).filter(|(to_ns, _)| to_ns > from_ns && ns > *from_ns) else {
            return from.pose;
        };
        let share = (ns - from_ns) as f64 / (to_ns - from_ns) as f64;
        let (from, to) = (from.pose?, to.pose?);
        let turn = wrap(from[2] + share * wrap(to[2] - from[2]));
        Some([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1]), turn])
    }

    pub(super) fn has_poses(&self) -> bool {
        let poses: Option<Vec<_>> =
            self.rows.iter().map(|(ns, sample)| Some((*ns as f64 / 1e9, sample.pose?))).collect();
        poses.is_some_and(|poses| twist::moves(&poses))
    }

    /// The rows and messages to the user, for a given vehicle or any; messages are in order of time.
    pub(super) fn rows(&self, topic: &str, seconds: &dyn Fn(u64) -> f64, vehicle: Option<Vehicle>) -> twist::Rows {
        let samples: Vec<(f64, Sample)> = self.rows.iter().map(|(ns, sample)| (seconds(*ns), *sample)).collect();
        twist::rows(topic, &samples, vehicle)
    }
}
