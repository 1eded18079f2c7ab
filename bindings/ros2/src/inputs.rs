//! Converts messages to inputs of the filter.

use crate::engine::{Engine, Event};
use crate::setup::{Earth, FIXES, LASER_SCAN, Setup, Topic};
use nalgebra::Vector2;
use scphd_exchange::import::recording::{Moved, Seats, Seen, Sight, Told, View, east_north, moved, sight};
use scphd_exchange::mcap::UNKNOWN;
use scphd_lidar::{Post, PostFinder, PostSettings, SettingsError, Sweep};
use scphd_ros::messages::{Imu, LaserScan, NavSatFix, PoseWithCovarianceStamped, TFMessage};
use scphd_ros::{Channel, Time};
use scphd_vehicle::{Control, VehicleKind};
use std::time::Duration;

/// Maximum number of posts in a laser scan: that of measurements in the filter.
const POSTS: usize = 256;

/// The role of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Motion of the vehicle.
    Odometry,
    /// Detections of the sensor with this index in the description.
    Scan(usize),
    /// Turn rates, which replace those of the odometry.
    Turns,
    /// Measurements of the pose.
    Fixes,
    /// Transforms between frames.
    Seats,
}

/// A topic that a node reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    pub role: Role,
    /// Topic, type and encoding.
    pub channel: Channel,
}

/// A pose from odometry: time, ns, and x m, y m, heading rad.
pub type Placed = (u64, [f64; 3]);

/// Reads messages and passes them to an engine.
#[derive(Debug)]
pub struct Inputs {
    pub topics: Vec<Input>,
    seats: Seats,
    base: String,
    /// For each sensor: whether parameters give its mounting; the frame of its view, and the view.
    seated: Vec<bool>,
    views: Vec<Option<(String, View)>>,
    counts: Vec<usize>,
    /// The last control, for a vehicle with an inertial measurement unit.
    control: Option<Control<f32>>,
    posts: Vec<PostSettings>,
    earth: Earth,
}

/// The reason why a message is rejected, for example a missing transform.
pub type Refused = String;

impl Inputs {
    pub fn new(setup: &Setup) -> Self {
        let wiring = &setup.wiring;
        let channel = |Topic { name, kind }: &Topic| {
            let (topic, kind) = (name.clone(), kind.clone());
            Channel { topic, kind, encoding: "cdr".into() }
        };
        let mut topics = vec![Input { role: Role::Odometry, channel: channel(&wiring.odometry) }];
        for (place, source) in wiring.sensors.iter().enumerate() {
            topics.push(Input { role: Role::Scan(place), channel: channel(&source.topic) });
        }
        topics.extend(wiring.fixes.iter().map(|fixes| Input { role: Role::Fixes, channel: channel(fixes) }));
        if !wiring.imu.is_empty() {
            let imu = Topic::new(&wiring.imu, "sensor_msgs/msg/Imu");
            topics.push(Input { role: Role::Turns, channel: channel(&imu) });
        }
        let seats = Topic::new("/tf_static", "tf2_msgs/msg/TFMessage");
        topics.push(Input { role: Role::Seats, channel: channel(&seats) });
        Self {
            control: (!wiring.imu.is_empty()).then_some(Control::STILL),
            posts: wiring.sensors.iter().map(|source| source.posts).collect(),
            earth: wiring.earth,
            counts: vec![0; topics.len()],
            topics,
            seats: Seats::default(),
            base: wiring.frames[2].clone(),
            seated: wiring.sensors.iter().map(|source| source.seated).collect(),
            views: vec![None; wiring.sensors.len()],
        }
    }

    /// Reads a message of the topic with this index. Returns the pose, if it is odometry with a pose.
    pub fn take(&mut self, place: usize, data: &[u8], engine: &mut Engine) -> Result<Option<Placed>, Refused> {
        let Some(Input { role, channel }) = self.topics.get(place) else { return Err("no such topic".into()) };
        let count = self.counts.get_mut(place);
        let number = count.map_or(0, |count| {
            *count += 1;
            *count
        });
        let told = Told { channel, data, log_time_ns: 0, number };
        let said = |error: scphd_exchange::import::ImportError| error.to_string();
        match *role {
            Role::Odometry => {
                let Moved { stamp, sample, unplaced, .. } = moved(&told).map_err(said)?;
                let stamp_ns = checked(stamp)?;
                let [speed, turn, left] = sample.control;
                let aside = engine.setup().description.vehicle.kind == VehicleKind::Holonomic;
                let left_mps = if aside { left as f32 } else { 0.0 };
                let control = Control { speed_mps: speed as f32, left_mps, turn: turn as f32 };
                match &mut self.control {
                    // Keeps the turn rate until the next one arrives.
                    Some(last) => *last = Control { turn: last.turn, ..control },
                    None => engine.control(stamp_ns, control),
                }
                Ok(sample.pose.filter(|_| !unplaced).map(|pose| (stamp_ns, pose)))
            }
            Role::Turns => {
                let message: Imu = told.decode().map_err(said)?;
                let stamp_ns = checked(message.header.stamp)?;
                let rate = told.finite("angular_velocity.z", message.angular_velocity.z).map_err(said)?;
                if let Some(control) = &mut self.control {
                    control.turn = rate as f32;
                    engine.control(stamp_ns, *control);
                }
                Ok(None)
            }
            Role::Scan(sensor) => {
                let (stamp_ns, scan) = match self.posts.get(sensor) {
                    Some(posts) if channel.kind == LASER_SCAN => {
                        let message: LaserScan = told.decode().map_err(said)?;
                        laser(&message, posts, engine.motion())?
                    }
                    _ => {
                        let scan = sight(&told).map_err(said)?;
                        (checked(scan.stamp)?, scan)
                    }
                };
                let detections = self.detections(sensor, &scan, engine)?;
                engine.event(stamp_ns, Event::Scan(sensor, detections));
                Ok(None)
            }
            Role::Fixes if channel.kind == FIXES[1] => {
                let message: NavSatFix = told.decode().map_err(said)?;
                let stamp_ns = checked(message.header.stamp)?;
                let place = [message.latitude, message.longitude, message.altitude];
                if message.status.status < 0 || !place.iter().take(2).all(|angle| angle.is_finite()) {
                    return Err("the satellite receiver does not know where it is".into());
                }
                let height = self.earth.origin.map_or(0.0, |[.., height]| height);
                let place = [place[0], place[1], if place[2].is_finite() { place[2] } else { height }];
                let origin = *self.earth.origin.get_or_insert(place);
                let radians =
                    |[latitude, longitude, height]: [f64; 3]| [latitude.to_radians(), longitude.to_radians(), height];
                let [east, north] = east_north(radians(origin), radians(place));
                let (sine, cosine) = self.earth.turn_rad.sin_cos();
                let [x, y] = [cosine * east + sine * north, cosine * north - sine * east];
                if engine.setup().description.position.is_some() {
                    engine.event(stamp_ns, Event::Position([x as f32, y as f32]));
                }
                Ok(None)
            }
            Role::Fixes => {
                let message: PoseWithCovarianceStamped = told.decode().map_err(said)?;
                let stamp_ns = checked(message.header.stamp)?;
                let (pose, covariance) = (message.pose.pose, message.pose.covariance);
                let description = &engine.setup().description;
                let has = [description.position.is_some(), description.heading.is_some()];
                if has[0] && covariance[0][0] < UNKNOWN {
                    engine.event(stamp_ns, Event::Position([pose.position.x as f32, pose.position.y as f32]));
                }
                if let Some(turn) = pose.orientation.unit().filter(|_| has[1] && covariance[5][5] < UNKNOWN) {
                    engine.event(stamp_ns, Event::Heading(turn.yaw_rad() as f32));
                }
                Ok(None)
            }
            Role::Seats => {
                self.seats.take(&told.decode::<TFMessage>().map_err(said)?);
                self.views.fill(None);
                Ok(None)
            }
        }
    }

    /// Ranges and bearings of the detections, relative to the sensor.
    fn detections(&mut self, sensor: usize, scan: &Sight, engine: &mut Engine) -> Result<Vec<Vector2<f32>>, Refused> {
        let known = self.views.get(sensor).and_then(Option::as_ref).filter(|(frame, _)| *frame == scan.frame);
        let view = match known {
            Some((_, view)) => *view,
            None => {
                let view = self.view(sensor, &scan.frame, engine)?;
                self.views.get_mut(sensor).into_iter().for_each(|place| *place = Some((scan.frame.clone(), view)));
                view
            }
        };
        let see = |seen| {
            let [range, bearing] = view.see(seen);
            Vector2::new(range as f32, bearing as f32)
        };
        Ok(scan.seen.iter().copied().map(see).collect())
    }

    /// The view of a frame; sets the sensor's mounting in the filter, unless parameters give it.
    fn view(&self, sensor: usize, frame: &str, engine: &mut Engine) -> Result<View, Refused> {
        let seated = self.seated.get(sensor).copied().unwrap_or(true);
        let Some(place) = self.seats.between(&self.base, frame) else {
            return if seated || frame.is_empty() {
                Ok(View::unknown(frame))
            } else {
                Err(format!(
                    "no transform from {} to {frame} on /tf_static; parameters of the sensor can say where it sits, too",
                    self.base
                ))
            };
        };
        let (view, _) = View::of(frame, &place);
        if !seated {
            let seat = [view.mounting.forward_m, view.mounting.left_m, view.mounting.yaw_rad];
            engine.seat(sensor, seat.map(|number| number as f32)).map_err(|error| error.to_string())?;
        }
        Ok(view)
    }
}

/// The posts of a laser scan, corrected to the time of its end for a vehicle with this speed, m/s, and turn rate, rad/s.
fn laser(message: &LaserScan, posts: &PostSettings, [speed, rate]: [f32; 2]) -> Result<(u64, Sight), Refused> {
    let begin_ns = checked(message.header.stamp)?;
    let steps = message.ranges.len().saturating_sub(1) as f32;
    let of_steps_s = message.time_increment * steps;
    let duration_s = if of_steps_s.is_finite() { of_steps_s } else { 0.0 };
    let sweep = Sweep {
        start_rad: message.angle_min,
        increment_rad: message.angle_increment,
        range_min_m: message.range_min,
        range_max_m: message.range_max,
        duration_s,
    };
    let refused = |error: SettingsError| format!("the laser scan: {error}");
    let scan = scphd_lidar::LaserScan::new(sweep, &message.ranges, &message.intensities).map_err(refused)?;
    let found = PostFinder::new(*posts).map_err(refused)?.find::<POSTS, _>(&scan);
    let ray = |post: &Post| {
        let [range, bearing] = post.at_end(speed, rate);
        Seen::Ray([f64::from(range), f64::from(bearing), 0.0])
    };
    let end_ns = begin_ns.saturating_add(Duration::from_secs_f32(duration_s.clamp(0.0, 10.0)).as_nanos() as u64);
    let sight = Sight {
        stamp: Time::from_nanoseconds(end_ns),
        frame: message.header.frame_id.trim_start_matches('/').to_owned(),
        seen: found.posts.iter().map(ray).collect(),
        labels: Vec::new(),
        left_out: 0,
    };
    Ok((end_ns, sight))
}

/// Checks that a stamp is valid.
fn checked(stamp: Time) -> Result<u64, Refused> {
    let good = stamp.sec >= 0 && stamp.nanosec < 1_000_000_000;
    if good { Ok(stamp.nanoseconds()) } else { Err(format!("{stamp:?} is no time")) }
}
