//! Detections of messages, as range (m) and bearing (rad).

use super::told::Told;
use crate::exchange::import::ImportError;
use scphd_ros::messages::{Detection3DArray, Point, PointCloud2, PoseArray, RadarScan};
use scphd_ros::{Cloud, Time};

/// A scan.
#[derive(Debug)]
pub(super) struct Sight {
    pub(super) stamp: Time,
    pub(super) frame: String,
    pub(super) detections: Vec<[f64; 2]>,
    pub(super) labels: Vec<i64>,
    /// Points that are nowhere.
    pub(super) left_out: usize,
}

/// Whether a frame's axes are those of an image: z ahead, x to the right.
pub(super) fn is_optical(frame: &str) -> bool {
    frame.ends_with("_optical_frame") || frame.ends_with("_optical")
}

impl Sight {
    fn new(stamp: Time, frame: &str) -> Self {
        Self { stamp, frame: frame.to_owned(), detections: Vec::new(), labels: Vec::new(), left_out: 0 }
    }

    /// A place in the sensor's frame, seen from above.
    fn place(&mut self, [x, y, z]: [f64; 3]) {
        let (ahead, left) = if is_optical(&self.frame) { (z, -x) } else { (x, y) };
        self.seen(ahead.hypot(left), left.atan2(ahead));
    }

    fn seen(&mut self, range: f64, bearing: f64) {
        // What has no range has no bearing.
        self.told(range, bearing, range > 0.0);
    }

    /// A range and a bearing, which count if they are numbers and `kept`; whether they do.
    fn told(&mut self, range: f64, bearing: f64, kept: bool) -> bool {
        let kept = kept && range.is_finite() && bearing.is_finite();
        if kept {
            self.detections.push([range, bearing]);
        } else {
            self.left_out += 1;
        }
        kept
    }
}

/// The scan in a message.
pub(super) fn of(told: &Told) -> Result<Sight, ImportError> {
    match told.channel.kind.as_str() {
        "radar_msgs/msg/RadarScan" => {
            let message: RadarScan = told.decode()?;
            let mut sight = Sight::new(message.header.stamp, &message.header.frame_id);
            for seen in &message.returns {
                // The way over ground.
                let level = f64::from(seen.range) * f64::from(seen.elevation).cos();
                sight.seen(level, f64::from(seen.azimuth));
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

/// Fields `range` and `bearing` (or `azimuth`) where there are such, otherwise x, y and z.
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
        let label = column("label")?;
        for point in 0..cloud.points() {
            // Simulated noise may make a short range negative.
            let kept = sight.told(cloud.number(point, range), cloud.number(point, bearing), true);
            // A whole number in double precision; what is none counts as unknown.
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
