//! Detections of messages, in the frame of their message.

use super::told::Told;
use crate::import::ImportError;
use scphd_ros::messages::{Detection3DArray, Point, PointCloud2, PoseArray, RadarScan};
use scphd_ros::{Cloud, Time};

#[derive(Debug)]
pub struct Sight {
    pub stamp: Time,
    pub frame: String,
    pub seen: Vec<Seen>,
    /// Labels of the detections, if the message has them.
    pub labels: Vec<i64>,
    /// Number of points without a valid position.
    pub left_out: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seen {
    /// A position, m.
    Place([f64; 3]),
    /// Range, m, bearing to the left and elevation, rad.
    Ray([f64; 3]),
}

/// The name of a frame; names of ROS 1 began with a slash.
pub fn frame(name: &str) -> &str {
    name.trim_start_matches('/')
}

impl Sight {
    fn new(stamp: Time, name: &str) -> Self {
        Self { stamp, frame: frame(name).to_owned(), seen: Vec::new(), labels: Vec::new(), left_out: 0 }
    }

    /// Adds a position if it is valid.
    fn place(&mut self, place: [f64; 3]) {
        let somewhere = place.iter().all(|number| number.is_finite()) && place != [0.0; 3];
        self.told(Seen::Place(place), somewhere);
    }

    /// Adds a detection if `kept`.
    fn told(&mut self, seen: Seen, kept: bool) {
        if kept {
            self.seen.push(seen);
        } else {
            self.left_out += 1;
        }
    }
}

/// The scan in a message.
pub fn of(told: &Told) -> Result<Sight, ImportError> {
    match told.channel.kind.as_str() {
        "radar_msgs/msg/RadarScan" => {
            let message: RadarScan = told.decode()?;
            let mut sight = Sight::new(message.header.stamp, &message.header.frame_id);
            for seen in &message.returns {
                let ray = [seen.range, seen.azimuth, seen.elevation].map(f64::from);
                // Without a range there is no bearing.
                sight.told(Seen::Ray(ray), ray.iter().all(|number| number.is_finite()) && ray[0] > 0.0);
            }
            Ok(sight)
        }
        "vision_msgs/msg/Detection3DArray" => {
            let message: Detection3DArray = told.decode()?;
            let mut sight = Sight::new(message.header.stamp, &message.header.frame_id);
            let places = message.detections.iter().map(|seen| seen.bbox.center.position);
            places.for_each(|Point { x, y, z }| sight.place([x, y, z]));
            Ok(sight)
        }
        "geometry_msgs/msg/PoseArray" => {
            let message: PoseArray = told.decode()?;
            let mut sight = Sight::new(message.header.stamp, &message.header.frame_id);
            let places = message.poses.iter().map(|pose| pose.position);
            places.for_each(|Point { x, y, z }| sight.place([x, y, z]));
            Ok(sight)
        }
        _ => cloud(told),
    }
}

/// Fields `range` and `bearing` (or `azimuth`) if present, otherwise x, y and z.
fn cloud(told: &Told) -> Result<Sight, ImportError> {
    let message: PointCloud2 = told.decode()?;
    let mut sight = Sight::new(message.header.stamp, &message.header.frame_id);
    let cloud = Cloud::of(&message).map_err(|error| told.error(error))?;
    let column = |name: &str| cloud.column(name).map_err(|error| told.error(error));
    let bearing = match column("bearing")? {
        None => column("azimuth")?,
        found => found,
    };
    if let (Some(range), Some(bearing)) = (column("range")?, bearing) {
        let (elevation, label) = (column("elevation")?, column("label")?);
        for point in 0..cloud.points() {
            let elevation = elevation.map_or(0.0, |elevation| cloud.number(point, elevation));
            let ray = [cloud.number(point, range), cloud.number(point, bearing), elevation];
            let kept = ray.iter().all(|number| number.is_finite());
            // Simulated noise may make a short range negative.
            sight.told(Seen::Ray(ray), kept);
            // A whole number in double precision; other values mean "unknown".
            let label = label.map(|label| cloud.number(point, label));
            sight.labels.extend(label.filter(|_| kept).map(|label| if label.is_finite() { label as i64 } else { -1 }));
        }
        return Ok(sight);
    }
    let (Some(x), Some(y)) = (column("x")?, column("y")?) else {
        return Err(told.error("points have neither range and bearing nor x and y"));
    };
    let z = column("z")?;
    for point in 0..cloud.points() {
        let z = z.map_or(0.0, |z| cloud.number(point, z));
        sight.place([cloud.number(point, x), cloud.number(point, y), z]);
    }
    Ok(sight)
}
