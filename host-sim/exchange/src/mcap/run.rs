//! The file of a run.

use super::kind::Exported;
use super::names::{BASE, MAP, ODOM, UNKNOWN, topic};
use super::shape::{between, covariance, ellipse, point, pose, transform};
use scphd_filters::settings::Settings;
use scphd_log::dimensions::{Coordinates, Dimensions, Planar};
use scphd_log::log::Log;
use scphd_ros::messages::{
    ColorRGBA, Header, Marker, MarkerArray, Odometry, PointCloud2, Pose, PoseStamped, TFMessage, TransformStamped,
    Vector3,
};
use scphd_ros::{Time, TimeError, WriteError, Writer, cloud};
use scphd_run::film::{Film, Frame};
use scphd_score::record::{MapFeature, MovingFeature, ScanRecord};
use std::io::Cursor;

/// Colours of static and moving features.
const STATIC: [f32; 3] = [0.1, 0.4, 0.9];
const MOVING: [f32; 3] = [0.9, 0.4, 0.1];
/// Diameter of the arrows of velocities, m.
const ARROW_M: f64 = 0.1;

#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Invalid time in the log.
    #[error("a time of the log: {0}")]
    Time(#[from] TimeError),
    #[error("{0}")]
    Write(#[from] WriteError),
}

/// An attached file: its name, its type and its text.
pub type Attached<'a> = (&'a str, &'a str, &'a str);

/// Checks that the times of a log can be written.
pub fn check<K: Exported>(log: &K::Log) -> Result<(), ExportError> {
    let times = K::scans(log).iter().map(|scan| scan.t_s).chain(K::truth(log).iter().map(|row| row.t_s));
    times.chain(K::told_at(log)).try_for_each(|t_s| Ok(Time::from_seconds(t_s).map(drop)?))
}

/// Kinds of entries; at equal times in this order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Truth(usize),
    Told(usize),
    Scan(usize),
}

/// The bytes of a file with a recorded run.
pub fn write<K: Exported>(
    log: &K::Log,
    settings: &K::Settings,
    scans: &[ScanRecord<K>],
    film: &Film<K>,
    attached: &[Attached<'_>],
) -> Result<Vec<u8>, ExportError> {
    let stamp = |t_s: f64| Time::from_seconds(t_s);
    let mut events = Vec::new();
    for (k, row) in K::truth(log).iter().enumerate() {
        events.push((stamp(row.t_s)?.nanoseconds(), What::Truth(k)));
    }
    for (k, t_s) in K::told_at(log).into_iter().enumerate() {
        events.push((stamp(t_s)?.nanoseconds(), What::Told(k)));
    }
    for (k, scan) in scans.iter().enumerate() {
        events.push((stamp(scan.t_s)?.nanoseconds(), What::Scan(k)));
    }
    events.sort_unstable();
    let begin = Time::from_nanoseconds(events.first().map_or(0, |(ns, _)| *ns));

    let mut file = Writer::new(Cursor::new(Vec::new()), concat!("scphd-sim ", env!("CARGO_PKG_VERSION")))?;
    for (name, media_type, text) in attached {
        file.attach(name, media_type, text.as_bytes())?;
    }
    topics::<K>(log, &mut file)?;
    let sensors = K::sensors(log);
    if !sensors.is_empty() {
        file.topic::<TFMessage>(topic::TF_STATIC, true)?;
        file.write(topic::TF_STATIC, begin, &TFMessage { transforms: sensors })?;
    }
    let landmarks: Vec<K::Position> = K::landmarks(log).into_iter().chain(K::seldom(log)).collect();
    if !landmarks.is_empty() {
        file.topic::<PointCloud2>(topic::LANDMARKS, true)?;
        file.write(topic::LANDMARKS, begin, &places(Header::new(begin, MAP), &landmarks))?;
    }
    let mut frames = film.frames.iter().peekable();
    for (ns, what) in events {
        let at = Time::from_nanoseconds(ns);
        match what {
            What::Truth(k) => {
                let row = &K::truth(log)[k];
                let pose = pose(row.position.as_ref(), row.heading_rad.unwrap_or(0.0));
                file.write(topic::TRUTH, at, &PoseStamped { header: Header::new(at, MAP), pose })?;
            }
            What::Told(k) => K::tell(log, k, at, &mut file)?,
            What::Scan(k) => {
                scan::<K>(&scans[k], at, &mut file)?;
                let detections = K::detections(log, settings, k, &scans[k].pose, at);
                file.write(&K::topic(log, k), at, &detections)?;
                if let Some(frame) = frames.next_if(|frame| frame.scan == k) {
                    file.write(topic::FEATURES, at, &features(&frame.map, &frame.moving, MAP, at))?;
                    file.write(topic::MAP, at, &map(frame, at))?;
                }
            }
        }
    }
    Ok(file.finish()?.into_inner())
}

/// The bytes of a file with the inputs of a log in the plane: odometry, fixes, detections of all sensors, and the mountings of
/// the sensors.
pub fn inputs(log: &Log, settings: &Settings) -> Result<Vec<u8>, ExportError> {
    let stamp = |t_s: f64| Time::from_seconds(t_s).map(|at| at.nanoseconds());
    let told = Planar::told_at(log).into_iter().enumerate().map(|(k, t_s)| Ok((stamp(t_s)?, What::Told(k))));
    let scans = log.scans.iter().enumerate().map(|(k, scan)| Ok((stamp(scan.t_s)?, What::Scan(k))));
    let mut events = told.chain(scans).collect::<Result<Vec<_>, TimeError>>()?;
    events.sort_unstable();
    let begin = Time::from_nanoseconds(events.first().map_or(0, |(ns, _)| *ns));
    let mut file = Writer::new(Cursor::new(Vec::new()), concat!("scphd ", env!("CARGO_PKG_VERSION")))?;
    Planar::topics(log, &mut file)?;
    let sensors = Planar::sensors(log);
    if !sensors.is_empty() {
        file.topic::<TFMessage>(topic::TF_STATIC, true)?;
        file.write(topic::TF_STATIC, begin, &TFMessage { transforms: sensors })?;
    }
    for (ns, what) in events {
        let at = Time::from_nanoseconds(ns);
        match what {
            What::Told(k) => Planar::tell(log, k, at, &mut file)?,
            What::Scan(k) => {
                file.write(&Planar::topic(log, k), at, &Planar::detections(log, settings, k, &[0.0; 3], at))?;
            }
            What::Truth(_) => {}
        }
    }
    Ok(file.finish()?.into_inner())
}

/// Declares all topics, also those without messages.
fn topics<K: Exported>(log: &K::Log, file: &mut Writer<Cursor<Vec<u8>>>) -> Result<(), WriteError> {
    file.topic::<PoseStamped>(topic::ESTIMATE, false)?;
    file.topic::<Odometry>(topic::ODOMETRY, false)?;
    file.topic::<TFMessage>(topic::TF, false)?;
    file.topic::<MarkerArray>(topic::FEATURES, false)?;
    file.topic::<PointCloud2>(topic::MAP, false)?;
    if !K::truth(log).is_empty() {
        file.topic::<PoseStamped>(topic::TRUTH, false)?;
    }
    K::topics(log, file)
}

/// Writes the estimate after a scan.
fn scan<K: Exported>(scan: &ScanRecord<K>, at: Time, file: &mut Writer<Cursor<Vec<u8>>>) -> Result<(), WriteError> {
    let header = Header::new(at, MAP);
    let (place, heading_rad) = (K::position(&scan.pose), K::heading(&scan.pose));
    let estimate = pose(place.as_ref(), heading_rad);
    file.write(topic::ESTIMATE, at, &PoseStamped { header: header.clone(), pose: estimate })?;

    let mut odometry = Odometry { header: header.clone(), child_frame_id: BASE.to_owned(), ..Odometry::default() };
    odometry.pose.pose = estimate;
    let entry = |row: usize, column: usize| scan.pose_covariance.as_ref()[row].as_ref()[column];
    odometry.pose.covariance = covariance(K::Position::COUNT, entry);
    // The filter does not estimate a velocity.
    odometry.twist.covariance =
        std::array::from_fn(|row| std::array::from_fn(|column| if row == column { UNKNOWN } else { 0.0 }));
    file.write(topic::ODOMETRY, at, &odometry)?;

    let of = |parent: &str, child: &str, [x, y, heading_rad]: [f64; 3]| TransformStamped {
        header: Header::new(at, parent),
        child_frame_id: child.to_owned(),
        transform: transform(&[x, y], heading_rad),
    };
    let transforms = match (K::smooth(&scan.dead_reckoning), place.as_ref()) {
        (Some(smooth), &[x, y, ..]) => {
            vec![of(MAP, ODOM, between([x, y, heading_rad], smooth)), of(ODOM, BASE, smooth)]
        }
        (_, place) => {
            vec![TransformStamped { header, child_frame_id: BASE.to_owned(), transform: transform(place, heading_rad) }]
        }
    };
    file.write(topic::TF, at, &TFMessage { transforms })
}

/// Static and moving features as ellipses of 95 % probability; removes all earlier ones.
pub fn features<D: Dimensions>(
    map: &[MapFeature<D>],
    moving: &[MovingFeature<D>],
    frame: &str,
    at: Time,
) -> MarkerArray {
    let marker = |ns: &str, id: u32, shape: i32, pose: Pose, scale: Vector3, [r, g, b]: [f32; 3], a: f64| Marker {
        header: Header::new(at, frame),
        ns: ns.to_owned(),
        // The identifier is the same from scan to scan; its sign has no meaning.
        id: id.cast_signed(),
        r#type: shape,
        pose,
        scale,
        color: ColorRGBA { r, g, b, a: a.clamp(0.1, 0.9) as f32 },
        ..Marker::default()
    };
    let sphere = |ns: &str, id, place: &D::Position, covariance: &[_], color, weight| {
        let rows: Vec<&[f64]> = covariance.iter().map(|row: &D::Position| row.as_ref()).collect();
        let (orientation, scale) = ellipse(&rows);
        let pose = Pose { position: point(place.as_ref()), orientation };
        marker(ns, id, Marker::SPHERE, pose, scale, color, weight)
    };
    let clear =
        Marker { header: Header::new(at, frame), action: Marker::DELETE_ALL, ns: "static".into(), ..Marker::default() };
    let mut markers = vec![clear];
    for feature in map {
        let covariance = feature.covariance.as_ref();
        markers.push(sphere("static", feature.id, &feature.mean, covariance, STATIC, feature.weight));
    }
    for feature in moving {
        let covariance = feature.covariance.as_ref();
        markers.push(sphere("moving", feature.id, &feature.position, covariance, MOVING, feature.weight));
        let velocity = feature.velocity.as_ref();
        let (east, north) = (velocity[0], velocity[1]);
        let arrow = pose(feature.position.as_ref(), north.atan2(east));
        let scale = Vector3 { x: east.hypot(north), y: ARROW_M, z: ARROW_M };
        markers.push(marker("velocity", feature.id, Marker::ARROW, arrow, scale, MOVING, feature.weight));
    }
    MarkerArray { markers }
}

/// Positions of static features with their weights and identifiers.
fn map<D: Dimensions>(frame: &Frame<D>, at: Time) -> PointCloud2 {
    let points = frame.map.iter().map(|feature| {
        let place = point(feature.mean.as_ref());
        ([place.x, place.y, place.z], [feature.weight, f64::from(feature.id)])
    });
    cloud(Header::new(at, MAP), ["x", "y", "z"], ["weight", "id"], points)
}

/// Positions, also in double precision.
fn places<P: Coordinates>(header: Header, places: &[P]) -> PointCloud2 {
    let points = places.iter().map(|place| {
        let place = point(place.as_ref());
        let place = [place.x, place.y, place.z];
        (place, place)
    });
    cloud(header, ["x", "y", "z"], ["x_m", "y_m", "z_m"], points)
}
