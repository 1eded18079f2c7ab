//! Frames: transforms between them, and points as seen from the vehicle.

use super::sight::{Seen, frame};
use nalgebra::{Isometry3, Point3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use scphd_log::angle::wrap;
use scphd_log::log::Mounting;
use scphd_ros::messages::TFMessage;
use std::collections::BTreeMap;

/// Greatest number of frames between a sensor and its vehicle.
const DEPTH: usize = 16;
/// A rotation with a smaller sine counts as none: a calibration has rounding errors.
const UPRIGHT: f64 = 1e-9;
/// Transforms that differ by less, m and rad, are equal.
const SAME: f64 = 1e-6;

/// The transform of a frame into its parent.
#[derive(Debug, Clone, PartialEq)]
struct Link {
    parent: String,
    place: Isometry3<f64>,
}

/// Transforms by frame.
#[derive(Debug, Default)]
pub struct Seats {
    fixed: BTreeMap<String, Link>,
    /// Transforms of `/tf`, with the indices of their messages among all, and their times, ns.
    moving: BTreeMap<String, Vec<(usize, u64, Link)>>,
}

impl Seats {
    /// Adds static transforms.
    pub fn take(&mut self, message: &TFMessage) {
        links(message).for_each(|(child, _, link)| {
            self.fixed.insert(child, link);
        });
    }

    /// Adds transforms with a time.
    pub(super) fn take_moving(&mut self, place: usize, message: &TFMessage) {
        links(message).for_each(|(child, ns, link)| self.moving.entry(child).or_default().push((place, ns, link)));
    }

    /// Keeps the transforms of the piece, and makes those static that never change; `in_piece` tells from a message's index
    /// whether it belongs to the piece.
    pub(super) fn settle(&mut self, in_piece: impl Fn(usize) -> bool) {
        for (child, links) in &mut self.moving {
            links.retain(|(place, ..)| in_piece(*place));
            links.sort_by_key(|(_, ns, _)| *ns);
            let Some((_, _, first)) = links.first() else { continue };
            let same = |link: &Link| {
                let apart = first.place.inv_mul(&link.place);
                link.parent == first.parent && apart.translation.vector.norm() < SAME && apart.rotation.angle() < SAME
            };
            if links.iter().all(|(.., link)| same(link)) && !self.fixed.contains_key(child) {
                self.fixed.insert(child.clone(), first.clone());
            }
        }
    }

    /// The last parent by static transforms, and the transform into it.
    fn root(&self, from: &str) -> Option<(String, Isometry3<f64>)> {
        let (mut at, mut place) = (from.to_owned(), Isometry3::identity());
        for _ in 0..DEPTH {
            let Some(link) = self.fixed.get(&at) else { return Some((at, place)) };
            place = link.place * place;
            at.clone_from(&link.parent);
        }
        None
    }

    /// The transform of `frame` into `base`; `None` unless static transforms connect them.
    pub fn between(&self, base: &str, frame: &str) -> Option<Isometry3<f64>> {
        let ((top, base), (other, frame)) = (self.root(base)?, self.root(frame)?);
        let place = if base == Isometry3::identity() { frame } else { base.inv_mul(&frame) };
        (top == other && place.to_homogeneous().iter().all(|number| number.is_finite())).then_some(place)
    }

    /// The last parent of a sensor by static transforms, and the transform into it, for vehicles with another frame name.
    pub fn above(&self, frame: &str) -> Option<(String, Isometry3<f64>)> {
        self.root(frame).filter(|(top, _)| top != frame)
    }

    /// Whether `below` is a descendant of `world`, by static transforms or those of `/tf`.
    pub(super) fn is_above(&self, world: &str, below: &str) -> bool {
        let mut at = below.to_owned();
        for _ in 0..DEPTH {
            let link = self.fixed.get(&at).or_else(|| self.moving.get(&at).and_then(|links| Some(&links.first()?.2)));
            match link {
                Some(link) if link.parent == world => return true,
                Some(link) => at.clone_from(&link.parent),
                None => return false,
            }
        }
        false
    }

    /// The odometry's frame in another one at a time, ns: x m, y m, heading rad.
    pub(super) fn world(&self, world: &str, odometry: &str, ns: u64) -> Option<[f64; 3]> {
        let place = self.between(world, odometry).or_else(|| {
            let links = self.moving.get(odometry)?;
            let after = links.partition_point(|(_, at, _)| *at <= ns);
            let (_, _, link) = links.get(after.saturating_sub(1))?;
            Some(self.between(world, &link.parent)? * link.place)
        })?;
        let ahead = place.rotation * Vector3::x();
        Some([place.translation.x, place.translation.y, libm::atan2(ahead.y, ahead.x)])
    }
}

fn links(message: &TFMessage) -> impl Iterator<Item = (String, u64, Link)> + '_ {
    message.transforms.iter().filter_map(|link| {
        let (shift, turn) = (link.transform.translation, link.transform.rotation.unit()?);
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(turn.w, turn.x, turn.y, turn.z));
        let place = Isometry3::from_parts(Translation3::new(shift.x, shift.y, shift.z), turn);
        let parent = frame(&link.header.frame_id).to_owned();
        Some((frame(&link.child_frame_id).to_owned(), link.header.stamp.nanoseconds(), Link { parent, place }))
    })
}

/// The view of a frame's points from above, from a place on the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The place, and the direction of bearing 0.
    pub mounting: Mounting,
    /// The rotation from the axes of the frame to forward, left and up; `None` if they are equal.
    turn: Option<Rotation3<f64>>,
    /// Position of the frame's origin relative to the place, m.
    origin: Vector3<f64>,
}

/// Whether a frame name has the suffix of image axes: z ahead, x to the right, y down (REP 103).
pub(super) fn is_optical(frame: &str) -> bool {
    frame.ends_with("_optical_frame") || frame.ends_with("_optical")
}

/// The rotation from the axes of an image to those of a body.
fn image() -> Rotation3<f64> {
    let columns = [-Vector3::y(), -Vector3::z(), Vector3::x()];
    Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&columns))
}

impl View {
    /// Creates the view of points in axes of the vehicle, or of a sensor without a transform, from the name of the frame only.
    pub fn unknown(frame: &str) -> Self {
        let turn = is_optical(frame).then(image);
        Self { mounting: Mounting::NONE, turn, origin: Vector3::zeros() }
    }

    /// Creates the view from the transform into the vehicle's frame. Returns also whether the frame's name contradicts the
    /// transform.
    pub fn of(frame: &str, place: &Isometry3<f64>) -> (Self, bool) {
        let mut turn = place.rotation.to_rotation_matrix();
        // In a body frame z is vertical, in an image frame y. A frame with an optical name but without the rotation still has
        // points in axes of an image.
        let unlike = is_optical(frame) && turn[(2, 1)].abs() < turn[(2, 2)].abs();
        if unlike {
            turn *= image();
        }
        let ahead =
            if turn[(2, 2)].abs() < turn[(2, 1)].abs() { turn.matrix().column(2) } else { turn.matrix().column(0) };
        let yaw_rad = libm::atan2(ahead[1], ahead[0]);
        let mounting = Mounting { forward_m: place.translation.x, left_m: place.translation.y, yaw_rad };
        let upright = 1.0 - turn[(2, 2)] < UPRIGHT * UPRIGHT && turn[(2, 0)].hypot(turn[(2, 1)]) < UPRIGHT;
        let level = Rotation3::from_axis_angle(&Vector3::z_axis(), -yaw_rad) * turn;
        (Self { mounting, turn: (!upright).then_some(level), origin: Vector3::zeros() }, unlike)
    }

    /// The same view from the origin of the vehicle's frame.
    pub(super) fn relative_to_pose(self) -> Self {
        let Mounting { forward_m, left_m, yaw_rad } = self.mounting;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_rad) * self.turn.unwrap_or_default();
        Self { mounting: Mounting::NONE, turn: Some(turn), origin: Vector3::new(forward_m, left_m, 0.0) }
    }

    /// Whether the frame is rotated about more than the vertical.
    pub fn is_tilted(&self) -> bool {
        self.turn.is_some()
    }

    /// Horizontal range, m, and bearing, rad.
    pub fn see(&self, seen: Seen) -> [f64; 2] {
        match (seen, &self.turn) {
            // The horizontal range.
            (Seen::Ray([range, bearing, elevation]), None) => [range * elevation.cos(), bearing],
            (Seen::Place([x, y, _]), None) => [x.hypot(y), y.atan2(x)],
            (Seen::Ray([range, bearing, elevation]), Some(_)) => {
                let level = range * elevation.cos();
                self.turned([level * bearing.cos(), level * bearing.sin(), range * elevation.sin()])
            }
            (Seen::Place(place), Some(_)) => self.turned(place),
        }
    }

    fn turned(&self, place: [f64; 3]) -> [f64; 2] {
        let place = self.turn.unwrap_or_default() * Point3::from(place) + self.origin;
        [place.x.hypot(place.y), place.y.atan2(place.x)]
    }
}

/// Range and bearing, from a vehicle at this pose, of a point in the frame of the pose.
pub(super) fn from(pose: [f64; 3], seen: Seen) -> [f64; 2] {
    let [x, y] = match seen {
        Seen::Place([x, y, _]) => [x, y],
        Seen::Ray([range, bearing, elevation]) => {
            let level = range * elevation.cos();
            [level * bearing.cos(), level * bearing.sin()]
        }
    };
    let (dx, dy) = (x - pose[0], y - pose[1]);
    [dx.hypot(dy), wrap(libm::atan2(dy, dx) - pose[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_ros::messages::{Header, Transform, TransformStamped, Vector3 as Shift};
    use std::f64::consts::{FRAC_PI_2, PI};

    type Turn = scphd_ros::messages::Quaternion;

    fn link(parent: &str, child: &str, [x, y]: [f64; 2], turn: Turn) -> TransformStamped {
        TransformStamped {
            header: Header { frame_id: parent.into(), ..Header::default() },
            child_frame_id: child.into(),
            transform: Transform { translation: Shift { x, y, z: 0.5 }, rotation: turn },
        }
    }

    fn seats(transforms: Vec<TransformStamped>) -> Seats {
        let mut seats = Seats::default();
        seats.take(&TFMessage { transforms });
        seats
    }

    const IMAGE: Turn = Turn { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
    const OVER: Turn = Turn { x: 1.0, y: 0.0, z: 0.0, w: 0.0 };

    #[test]
    fn transforms_are_composed_and_cycles_end() {
        let quarter = Turn::of_yaw(FRAC_PI_2);
        let seats = seats(vec![
            link("/base", "mast", [1.0, 2.0], quarter),
            link("mast", "/camera", [0.5, 0.0], quarter),
            link("camera", "camera_optical_frame", [0.0, 0.0], IMAGE),
            link("a", "b", [0.0, 0.0], quarter),
            link("b", "a", [0.0, 0.0], quarter),
        ]);
        for frame in ["camera", "camera_optical_frame"] {
            let (view, unlike) = View::of(frame, &seats.between("base", frame).unwrap());
            let Mounting { forward_m, left_m, yaw_rad } = view.mounting;
            assert!(!unlike && (forward_m - 1.0).abs() < 1e-12 && (left_m - 2.5).abs() < 1e-12, "{frame}");
            assert!((yaw_rad.abs() - PI).abs() < 1e-12, "{frame}: {yaw_rad}");
        }
        // From a frame beside the sensor's, or below it.
        let down = seats.between("camera", "base").unwrap();
        assert!((down.translation.x - 1.0).abs() < 1e-12 && (down.translation.y - 2.5).abs() < 1e-12, "{down}");
        assert_eq!(seats.between("base", "base"), Some(Isometry3::identity()));
        assert_eq!(seats.between("base", "a"), None);
        assert_eq!(seats.between("base", "nowhere"), None);
        assert_eq!(seats.above("camera").unwrap().0, "base");
    }

    /// Points 3 m ahead, 1 m to the left and 0.5 m up of a vehicle, in the axes of sensors with various rotations.
    #[test]
    fn points_are_transformed_by_the_full_rotation() {
        let half = |angle: f64| (0.5 * angle).sin_cos();
        let about = |axis: usize, angle: f64| {
            let (s, c) = half(angle);
            let mut parts = [0.0; 3];
            parts[axis] = s;
            Turn { x: parts[0], y: parts[1], z: parts[2], w: c }
        };
        let point = Vector3::new(3.0, 1.0, 0.5);
        for (name, turn) in [
            ("body", Turn::default()),
            ("left", Turn::of_yaw(1.0)),
            ("over", OVER),
            ("pitch", about(1, 0.7)),
            ("roll", about(0, -0.4)),
            ("side", about(0, FRAC_PI_2)),
            ("camera", IMAGE),
            ("down", about(1, FRAC_PI_2)),
            ("camera_optical_frame", IMAGE),
        ] {
            let seats = seats(vec![link("base", name, [0.5, -0.25], turn)]);
            let place = seats.between("base", name).unwrap();
            let (view, unlike) = View::of(name, &place);
            assert!(!unlike, "{name}");
            let inside = place.inverse_transform_point(&Point3::from(point));
            let flat = inside.x.hypot(inside.y);
            let ray = [inside.coords.norm(), inside.y.atan2(inside.x), inside.z.atan2(flat)];
            for seen in [Seen::Place(inside.coords.into()), Seen::Ray(ray)] {
                let [range, bearing] = view.see(seen);
                let angle = view.mounting.yaw_rad + bearing;
                let found = [view.mounting.forward_m + range * angle.cos(), view.mounting.left_m + range * angle.sin()];
                assert!((found[0] - 3.0).abs() < 1e-9 && (found[1] - 1.0).abs() < 1e-9, "{name}: {found:?}");
                let [range, bearing] = view.relative_to_pose().see(seen);
                assert!(
                    (range - 10.0_f64.sqrt()).abs() < 1e-9 && (bearing - 1.0_f64.atan2(3.0)).abs() < 1e-9,
                    "{name}"
                );
            }
            assert_eq!(view.is_tilted(), !["body", "left"].contains(&name), "{name}");
        }
        // A frame with an optical name, but without the rotation.
        let seats = seats(vec![link("base", "cam_optical", [0.0, 0.0], Turn::default())]);
        let (view, unlike) = View::of("cam_optical", &seats.between("base", "cam_optical").unwrap());
        let [range, bearing] = view.see(Seen::Place([-1.0, -0.5, 3.0]));
        assert!(unlike && (range - 10.0_f64.sqrt()).abs() < 1e-12 && (bearing - 1.0_f64.atan2(3.0)).abs() < 1e-12);
    }

    #[test]
    fn the_frame_of_odometry_in_the_map_is_that_of_tf_at_the_time() {
        let mut seats = Seats::default();
        for k in 0..3_u32 {
            let mut moved = link("map", "odom", [f64::from(k), 0.0], Turn::of_yaw(0.5));
            moved.header.stamp.sec = k.cast_signed();
            seats.take_moving(
                k as usize,
                &TFMessage { transforms: vec![moved, link("mast", "lamp", [1.0, 0.0], OVER)] },
            );
        }
        seats.settle(|place| place < 2);
        let at = |ns| seats.world("map", "odom", ns).unwrap();
        assert_eq!((at(500_000_000)[0], at(1_000_000_000)[0], at(9_000_000_000)[0]), (0.0, 1.0, 1.0));
        assert!((at(0)[2] - 0.5).abs() < 1e-12 && seats.is_above("map", "odom") && !seats.is_above("odom", "map"));
        // A transform that never changes is static, on any topic.
        assert!(seats.between("mast", "lamp").is_some() && seats.between("map", "odom").is_none());
        let [range, bearing] = from([1.0, 1.0, FRAC_PI_2], Seen::Place([1.0, 3.0, 9.0]));
        assert!((range - 2.0).abs() < 1e-12 && bearing.abs() < 1e-12);
    }
}
