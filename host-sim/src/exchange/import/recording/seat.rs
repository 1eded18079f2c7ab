//! Where sensors sit on the vehicle, by the transforms that do not change.

use super::sight::is_optical;
use crate::log::Mounting;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use scphd_ros::messages::TFMessage;
use std::collections::BTreeMap;

/// Frames between a sensor and its vehicle, at most.
const DEPTH: usize = 16;

/// By frame: the frame that it sits in, where, and how it is turned.
#[derive(Debug, Default)]
pub(super) struct Seats(BTreeMap<String, (String, Vector3<f64>, UnitQuaternion<f64>)>);

impl Seats {
    pub(super) fn take(&mut self, message: &TFMessage) {
        for link in &message.transforms {
            let (shift, turn) = (link.transform.translation, link.transform.rotation.unit());
            let Some(turn) = turn else { continue };
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(turn.w, turn.x, turn.y, turn.z));
            let seat = (link.header.frame_id.clone(), Vector3::new(shift.x, shift.y, shift.z), turn);
            self.0.insert(link.child_frame_id.clone(), seat);
        }
    }

    /// Where a sensor's frame sits on the vehicle, seen from above; `None` where the transforms do not say.
    pub(super) fn find(&self, base: &str, frame: &str) -> Option<Mounting> {
        let ahead = if is_optical(frame) { Vector3::z() } else { Vector3::x() };
        let (mut at, mut place, mut ahead) = (frame, Vector3::zeros(), ahead);
        for _ in 0..DEPTH {
            if at == base {
                let known = place.iter().chain(ahead.iter()).all(|number: &f64| number.is_finite());
                let yaw_rad = libm::atan2(ahead.y, ahead.x);
                return known.then_some(Mounting { forward_m: place.x, left_m: place.y, yaw_rad });
            }
            let (parent, shift, turn) = self.0.get(at)?;
            place = turn * place + shift;
            ahead = turn * ahead;
            at = parent;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_ros::messages::{Header, Transform, TransformStamped, Vector3 as Shift};

    fn link(parent: &str, child: &str, [x, y]: [f64; 2], turn: scphd_ros::messages::Quaternion) -> TransformStamped {
        TransformStamped {
            header: Header { frame_id: parent.into(), ..Header::default() },
            child_frame_id: child.into(),
            transform: Transform { translation: Shift { x, y, z: 0.5 }, rotation: turn },
        }
    }

    #[test]
    fn seats_add_up_and_circles_end() {
        let quarter = scphd_ros::messages::Quaternion::of_yaw(std::f64::consts::FRAC_PI_2);
        // From the axes of a body to those of an image: x to the right, y down, z ahead.
        let image = scphd_ros::messages::Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
        let mut seats = Seats::default();
        seats.take(&TFMessage {
            transforms: vec![
                link("base", "mast", [1.0, 2.0], quarter),
                link("mast", "camera", [0.5, 0.0], quarter),
                link("camera", "camera_optical_frame", [0.0, 0.0], image),
                link("a", "b", [0.0, 0.0], quarter),
                link("b", "a", [0.0, 0.0], quarter),
            ],
        });
        for frame in ["camera", "camera_optical_frame"] {
            let Mounting { forward_m, left_m, yaw_rad } = seats.find("base", frame).unwrap();
            assert!((forward_m - 1.0).abs() < 1e-12 && (left_m - 2.5).abs() < 1e-12, "{frame}");
            assert!((yaw_rad.abs() - std::f64::consts::PI).abs() < 1e-12, "{frame}: {yaw_rad}");
        }
        assert_eq!(seats.find("base", "base"), Some(Mounting::NONE));
        assert_eq!(seats.find("base", "a"), None);
        assert_eq!(seats.find("base", "nowhere"), None);
    }
}
