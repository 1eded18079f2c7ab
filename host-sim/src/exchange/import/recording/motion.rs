//! Odometry of messages.

use super::told::Told;
use crate::angle::wrap;
use crate::exchange::import::ImportError;
use crate::exchange::mcap::{BASE, JOINTS};
use crate::log::Odometry as Row;
use scphd_ros::Time;
use scphd_ros::messages::{AckermannDriveStamped, JointState, Odometry};

/// A share of the speed ahead: what goes sideways faster is no car and no unicycle.
const SIDEWAYS: f64 = 0.1;
/// Way, m, and turn, rad, beyond which a vehicle has moved.
const MOVED: f64 = 1e-3;

/// Rows as they come; times are put to them afterwards.
#[derive(Debug, Default)]
pub(super) struct Motion {
    rows: Vec<(u64, Sample)>,
    base: Option<String>,
}

/// What a message says.
#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    control: [f64; 2],
    sideways_mps: f64,
    /// x m, y m, heading rad, where the message has a pose.
    pose: Option<[f64; 3]>,
}

impl Motion {
    /// Takes a message; its time is told by [`at`](Self::at).
    pub(super) fn take(&mut self, told: &Told) -> Result<Time, ImportError> {
        let (stamp, sample) = match told.channel.kind.as_str() {
            "nav_msgs/msg/Odometry" => {
                let message: Odometry = told.decode()?;
                let (twist, pose) = (message.twist.twist, message.pose.pose);
                let speed = told.finite("twist.linear.x", twist.linear.x)?;
                let rate = told.finite("twist.angular.z", twist.angular.z)?;
                let turn = pose.orientation.unit().map(|turn| turn.yaw_rad());
                let pose = turn.map(|turn| [pose.position.x, pose.position.y, turn]);
                let pose = pose.filter(|pose| pose.iter().all(|number| number.is_finite()));
                if self.base.is_none() && !message.child_frame_id.is_empty() {
                    self.base = Some(message.child_frame_id);
                }
                (message.header.stamp, Sample { control: [speed, rate], sideways_mps: twist.linear.y, pose })
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
                let control = [number(JOINTS[0], &message.velocity)?, number(JOINTS[1], &message.position)?];
                (message.header.stamp, Sample { control, ..Sample::default() })
            }
            _ => {
                let message: AckermannDriveStamped = told.decode()?;
                let speed = told.finite("speed", f64::from(message.drive.speed))?;
                let steering = told.finite("steering_angle", f64::from(message.drive.steering_angle))?;
                (message.header.stamp, Sample { control: [speed, steering], ..Sample::default() })
            }
        };
        self.rows.push((0, sample));
        Ok(stamp)
    }

    /// The time of the last message, ns.
    pub(super) fn at(&mut self, ns: u64) {
        self.rows.iter_mut().last().into_iter().for_each(|(at, _)| *at = ns);
    }

    pub(super) fn times(&self) -> impl Iterator<Item = u64> + '_ {
        self.rows.iter().map(|(ns, _)| *ns)
    }

    /// The frame of the vehicle.
    pub(super) fn base(&self) -> &str {
        self.base.as_deref().unwrap_or(BASE)
    }

    /// The rows, and what has to be told.
    pub(super) fn rows(mut self, seconds: &dyn Fn(u64) -> f64) -> Result<(Vec<Row>, Vec<String>), String> {
        self.rows.sort_by_key(|(ns, _)| *ns);
        let mut told = Vec::new();
        let still = self.rows.iter().all(|(_, sample)| sample.control == [0.0; 2]);
        let poses: Option<Vec<(f64, [f64; 3])>> =
            self.rows.iter().map(|(ns, sample)| Some((seconds(*ns), sample.pose?))).collect();
        if let Some(poses) = poses.filter(|poses| still && moves(poses)) {
            told.push("the odometry has no velocities: they are made of its poses".to_owned());
            return Ok((of_poses(&poses), told));
        }
        let greatest =
            |of: fn(&Sample) -> f64| self.rows.iter().map(|(_, sample)| of(sample).abs()).fold(0.0, f64::max);
        if greatest(|sample| sample.sideways_mps) > SIDEWAYS * greatest(|sample| sample.control[0]) {
            told.push("the vehicle moves sideways, which no vehicle model here does: that is left out".to_owned());
        }
        let row = |(ns, sample): &(u64, Sample)| {
            let [speed, turn] = sample.control;
            Row { t_s: seconds(*ns), control: [speed, turn, 0.0] }
        };
        Ok((self.rows.iter().map(row).collect(), told))
    }
}

fn moves(poses: &[(f64, [f64; 3])]) -> bool {
    let Some((_, first)) = poses.first() else { return false };
    poses.iter().any(|(_, pose)| {
        (pose[0] - first[0]).hypot(pose[1] - first[1]) > MOVED || wrap(pose[2] - first[2]).abs() > MOVED
    })
}

/// Speed and turn rate of the arcs from pose to pose.
fn of_poses(poses: &[(f64, [f64; 3])]) -> Vec<Row> {
    let row = |pair: &[(f64, [f64; 3])]| {
        let [(t_s, from), (next_s, to)] = *pair else { return None };
        let dt_s = next_s - t_s;
        let turn = wrap(to[2] - from[2]);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        // The chord lies along the heading half way.
        let middle = from[2] + 0.5 * turn;
        let chord = dx * libm::cos(middle) + dy * libm::sin(middle);
        let half = 0.5 * turn;
        let arc = if half.abs() < 1e-6 { chord } else { chord * half / libm::sin(half) };
        (dt_s > 0.0).then(|| Row { t_s, control: [arc / dt_s, turn / dt_s, 0.0] })
    };
    poses.windows(2).filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Vehicle;

    #[test]
    fn arcs_lead_from_pose_to_pose() {
        let poses =
            [(0.0, [0.0, 0.0, 3.0]), (0.5, [-1.0, 0.3, -3.0]), (1.0, [-1.2, 0.25, -2.9]), (2.0, [-1.2, 0.25, -2.9])];
        let rows = of_poses(&poses);
        assert_eq!(rows.len(), 3);
        let driven = Vehicle::UnicycleArc.step([0.0, 0.0, 0.0], [2.0, 0.5, 0.0], 0.4);
        let [row] = of_poses(&[(1.0, [0.0; 3]), (1.4, driven)])[..] else { panic!("one row") };
        assert!((row.control[0] - 2.0).abs() < 1e-12 && (row.control[1] - 0.5).abs() < 1e-12, "{row:?}");
        assert_eq!(rows[2].control, [0.0; 3]);
    }
}
