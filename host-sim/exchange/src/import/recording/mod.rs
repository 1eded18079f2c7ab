//! Logs of MCAP files with messages of ROS 2; docs/logs.md lists the supported types.
//!
//! | file | |
//! |---|---|
//! | `options.rs` | options |
//! | `files.rs` | files, and folders of them |
//! | `topics.rs` | choice of the topics |
//! | `told.rs` | a message, and its place in the file |
//! | `clocks.rs` | times that go back |
//! | `sight.rs` | detections of messages |
//! | `seat.rs` | frames, and transformation of their points into the view from the vehicle |
//! | `motion.rs`, `twist.rs` | odometry of messages; comparison of speeds and poses |
//! | `place.rs` | fixes and true poses of messages |

mod clocks;
mod files;
mod motion;
mod options;
mod place;
mod seat;
mod sight;
mod told;
mod topics;
mod twist;

pub use files::is_bag;
pub use motion::{Moved, moved};
pub use options::{Clock, Options};
pub use place::east_north;
pub use seat::{Seats, View};
pub use sight::{Seen, Sight, of as sight};
pub use told::Told;
pub use twist::Sample;

use super::{Draft, ImportError, Imported};
use crate::calendar;
use clocks::Clocks;
use motion::Motion;
use place::{Fixes, OfFixes, True};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Mounting, Odometry, Scan, TruePose, Vehicle};
use scphd_log::{log_folder, truth};
use scphd_ros::messages::{PointCloud2, TFMessage};
use scphd_ros::{Channel, Cloud, Record, Time};
use std::path::Path;
use topics::{Chosen, Content};
use twist::Rows;

/// The type of messages with transforms between frames.
const TF_MESSAGE: &str = "tf2_msgs/msg/TFMessage";
/// Names of world frames (REP 105, and those of simulators).
const WORLDS: [&str; 7] = ["map", "odom", "world", "earth", "utm", "global", "local_origin"];
/// Beyond this number of nanoseconds double precision is not exact: times are relative to the first message.
const EXACT_NS: u64 = 1 << 53;

/// Reads the log in a file, or in a folder of `ros2 bag record`.
///
/// # Errors
/// A file is damaged, data are missing, stamps go back, or a message cannot be read: see [`ImportError`].
pub fn read(path: &Path, options: &Options) -> Result<Imported, ImportError> {
    let files = files::of(path)?;
    let mut told = Vec::new();
    let mut content = Content::default();
    for (file, error) in files::each(&files, |reader, record| content.take(reader, record))? {
        if !options.partial {
            return Err(ImportError::at(file.display(), format_args!("{error}; --partial takes what lies before")));
        }
        told.push(format!("{error}: what lies before is taken"));
    }
    let head = match (&options.head, content.attached("log.toml")) {
        (Some((place, text)), _) => {
            Some(log_folder::of_head(text).map_err(|error| ImportError::Head(place.clone(), error))?)
        }
        (None, Some(text)) => {
            told.push("log.toml is that in the file".to_owned());
            let place = format!("{}, attached", path.display());
            Some(log_folder::of_head(text).map_err(|error| ImportError::Head(place, error))?)
        }
        (None, None) => None,
    };
    let ackermann = matches!(head, Some(Log { vehicle: Vehicle::Ackermann { .. }, .. }));
    let chosen = Chosen::of(&content, options, ackermann).map_err(|what| ImportError::at(path.display(), what))?;
    told.extend(chosen.told(&content));

    let mut gathered = Gathered::new(&chosen, options.clock);
    let mut failed = None;
    files::each(&files, |reader, record| {
        let Record::Message { channel, log_time_ns, data } = record else { return };
        let Some(channel) = reader.channel(channel).filter(|_| failed.is_none()) else { return };
        failed = gathered.take(channel, log_time_ns, &data).err();
    })?;
    if let Some(error) = failed {
        let ImportError::At { place, what } = error else { return Err(error) };
        return Err(ImportError::at(format_args!("{}, {place}", path.display()), what));
    }
    let name = path.file_stem().map_or_else(|| "log".to_owned(), |name| name.to_string_lossy().into_owned());
    // Of a name such as `drive.mcap.zstd`.
    let name = name.strip_suffix(".mcap").unwrap_or(&name).to_owned();
    let draft = gathered.draft(name, head, options.part, told);
    let draft = draft.map_err(|what| ImportError::at(path.display(), what))?;
    Draft { range_below_m: options.range_below_m, ..draft }.finish()
}

/// A scan as in its message.
struct Raw {
    ns: u64,
    /// Index of the message in its topic.
    message: usize,
    sensor: usize,
    frame: String,
    seen: Vec<Seen>,
    labels: Vec<i64>,
}

/// Data of the chosen topics; times are in nanoseconds.
struct Gathered<'c> {
    chosen: &'c Chosen,
    clock: Clock,
    counts: Vec<(String, usize)>,
    /// Topics without time stamps in the headers.
    unstamped: Vec<String>,
    clocks: Clocks,
    motion: Motion,
    scans: Vec<Raw>,
    left_out: usize,
    fixes: Fixes,
    truth: True,
    landmarks: Vec<[f64; 2]>,
    seats: Seats,
}

impl<'c> Gathered<'c> {
    fn new(chosen: &'c Chosen, clock: Clock) -> Self {
        Self {
            chosen,
            clock,
            counts: Vec::new(),
            unstamped: Vec::new(),
            clocks: Clocks::default(),
            motion: Motion::default(),
            scans: Vec::new(),
            left_out: 0,
            fixes: Fixes::default(),
            truth: True::default(),
            landmarks: Vec::new(),
            seats: Seats::default(),
        }
    }

    fn take(&mut self, channel: &Channel, log_time_ns: u64, data: &[u8]) -> Result<(), ImportError> {
        let topic = &channel.topic;
        let number = match self.counts.iter_mut().find(|(known, _)| known == topic) {
            Some((_, count)) => {
                *count += 1;
                *count
            }
            None => {
                self.counts.push((topic.clone(), 1));
                1
            }
        };
        let told = Told { channel, data, log_time_ns, number };
        // A topic may have several roles.
        let mut time = None;
        if *topic == self.chosen.odometry {
            let stamp = self.motion.take(&told)?;
            let ns = self.time(&told, stamp, &mut time);
            self.motion.at(ns);
        }
        if let Some(sensor) = self.chosen.detections.iter().position(|(_, of)| of == topic) {
            let Sight { stamp, frame, seen, labels, left_out } = sight(&told)?;
            self.left_out += left_out;
            let ns = self.time(&told, stamp, &mut time);
            self.scans.push(Raw { ns, message: number - 1, sensor, frame, seen, labels });
        }
        if self.chosen.fixes.as_ref() == Some(topic) {
            let stamp = self.fixes.take(&told)?;
            let ns = self.time(&told, stamp, &mut time);
            self.fixes.at(ns);
        }
        if self.chosen.truth.as_ref() == Some(topic) {
            let stamp = self.truth.take(&told)?;
            let ns = self.time(&told, stamp, &mut time);
            self.truth.at(ns);
        }
        match topic.trim_start_matches('/') {
            "tf_static" if channel.kind == TF_MESSAGE => self.seats.take(&told.decode::<TFMessage>()?),
            "tf" if channel.kind == TF_MESSAGE => {
                self.seats.take_moving(self.clocks.count(), &told.decode::<TFMessage>()?);
            }
            _ if topic == crate::mcap::topic::LANDMARKS => self.landmarks = landmarks(&told)?,
            _ => {}
        }
        Ok(())
    }

    /// The time of a message, ns, by the chosen clock; `known` if it was computed before.
    fn time(&mut self, told: &Told, stamp: Time, known: &mut Option<u64>) -> u64 {
        if let Some(ns) = *known {
            return ns;
        }
        let header = self.clock == Clock::Header && stamp != Time::default();
        let ns = if header { stamp.nanoseconds() } else { told.log_time_ns };
        let topic = &told.channel.topic;
        if self.clock == Clock::Header && !header && told.log_time_ns > 0 && !self.unstamped.contains(topic) {
            self.unstamped.push(topic.clone());
        }
        self.clocks.note(topic, ns, told.log_time_ns);
        *known = Some(ns);
        ns
    }

    /// Keeps the requested piece, in order of time.
    fn keep(&mut self, part: Option<usize>, told: &mut Vec<String>) -> Result<(), String> {
        let pieces = self.clocks.pieces();
        let piece = pieces.chosen(part, self.clock == Clock::Header)?;
        if pieces.count() > 1 {
            told.push(format!("part {} of {} is taken", piece + 1, pieces.count()));
        }
        told.extend(pieces.told.iter().cloned());
        let chosen = self.chosen;
        self.motion.keep(|message| pieces.has(piece, &chosen.odometry, message));
        self.scans.retain(|scan| pieces.has(piece, &chosen.detections[scan.sensor].1, scan.message));
        self.scans.sort_by_key(|scan| scan.ns);
        if let Some(topic) = &chosen.fixes {
            self.fixes.keep(|message| pieces.has(piece, topic, message));
        }
        if let Some(topic) = &chosen.truth {
            self.truth.keep(|message| pieces.has(piece, topic, message));
        }
        self.seats.settle(|place| pieces.has_place(piece, place));
        Ok(())
    }

    fn draft(
        mut self,
        name: String,
        head: Option<Log>,
        part: Option<usize>,
        mut told: Vec<String>,
    ) -> Result<Draft, String> {
        for topic in &self.unstamped {
            told.push(format!("{topic}: headers have no time, the time of the recording counts"));
        }
        self.keep(part, &mut told)?;
        if self.scans.is_empty() {
            return Err("no scan: no message of detections".into());
        }
        let all = self.motion.times().chain(self.scans.iter().map(|scan| scan.ns));
        let (least, most) = all.fold((u64::MAX, 0), |(least, most), ns| (least.min(ns), most.max(ns)));
        let zero = if most > EXACT_NS { least / 1_000_000_000 * 1_000_000_000 } else { 0 };
        if zero > 0 {
            let zero_s = zero / 1_000_000_000;
            let date = calendar::utc(zero_s as f64).map_or_else(String::new, |date| format!(" ({date})"));
            told.push(format!("times are counted from {zero_s} s on{date}"));
        }
        // Whole nanoseconds, exact in double precision, divided by 10⁹ give the number nearest to the decimal.
        let seconds = |ns: u64| if ns < zero { -((zero - ns) as f64 / 1e9) } else { (ns - zero) as f64 / 1e9 };
        if self.left_out > 0 {
            told.push(format!("{} points without a place are left out", self.left_out));
        }
        let (sensors, scans) = self.scans(head.as_ref(), &seconds, &mut told)?;
        let known = head.as_ref().map(|head| head.vehicle);
        let Rows { rows: odometry, aside, told: of_motion } = self.motion.rows(&self.chosen.odometry, &seconds, known);
        told.extend(of_motion);
        let truth = self.truth.rows(&seconds);

        let vehicle = known.unwrap_or(if aside { Vehicle::Holonomic } else { Vehicle::UnicycleArc });
        let from = head.as_ref().map(|head| head.initial_pose);
        let reckoned = Reckoned::of(vehicle, &odometry, from.unwrap_or_default());
        let stated = head.as_ref().map(|head| (head.fix_noise, head.initial_pose));
        let known = place::Known {
            stated,
            truth: &|t_s| truth::at(&truth, t_s).map(|row| row.position),
            reckoned: &|t_s| {
                let ([x, y, _], way_m) = reckoned.at(t_s);
                ([x, y], way_m)
            },
        };
        let OfFixes { fixes, noise, start, told: of_fixes } = self.fixes.rows(&seconds, &known)?;
        told.extend(of_fixes);
        let initial_pose = truth.first().map(|first| start_of(first, &truth, &odometry, &reckoned));
        if head.is_none() && initial_pose.is_some() {
            told.push("the vehicle starts at the first true pose".to_owned());
        }
        let (initial_pose, landmarks) = (initial_pose.or(start), self.landmarks);
        Ok(Draft {
            name,
            head,
            sensors,
            aside,
            initial_pose,
            odometry,
            scans,
            fixes,
            fix_noise: noise,
            truth,
            landmarks,
            told,
            ..Draft::default()
        })
    }

    /// The sensors, and their scans as range and bearing.
    #[expect(clippy::type_complexity, reason = "two lists of a draft")]
    fn scans(
        &self,
        head: Option<&Log>,
        seconds: &dyn Fn(u64) -> f64,
        told: &mut Vec<String>,
    ) -> Result<(Vec<(String, Option<Mounting>)>, Vec<Scan>), String> {
        let mut sensors = Vec::new();
        let mut scans: Vec<(u64, Scan)> = Vec::new();
        for (place, (sensor, topic)) in self.chosen.detections.iter().enumerate() {
            let of_sensor = || self.scans.iter().filter(|scan| scan.sensor == place);
            let mut frames: Vec<&str> = Vec::new();
            for scan in of_sensor() {
                if !frames.contains(&scan.frame.as_str()) {
                    frames.push(&scan.frame);
                }
            }
            let several = frames.len() > 1;
            let mut views = Vec::new();
            for frame in &frames {
                views.push((*frame, self.axes(topic, frame, head, several, told)?));
            }
            if several {
                told.push(format!(
                    "{topic}: detections are in {} frames: all are seen from where the vehicle's pose is",
                    frames.len()
                ));
            }
            let seat = match &views[..] {
                [(_, Axes::OfSensor(view))] => Some(view.mounting),
                _ => None,
            };
            sensors.push((sensor.clone(), seat));
            for scan in of_sensor() {
                let axes = views.iter().find(|(frame, _)| *frame == scan.frame).map(|(_, axes)| axes);
                let see = |seen: &Seen| match axes {
                    Some(Axes::OfSensor(view)) => Some(view.see(*seen)),
                    Some(Axes::OfWorld(world)) => self.pose_in(world, scan.ns).map(|pose| seat::from(pose, *seen)),
                    None => None,
                };
                let detections: Option<Vec<[f64; 2]>> = scan.seen.iter().map(see).collect();
                let detections = detections.ok_or_else(|| {
                    format!(
                        "{topic}, message {}: the vehicle's pose in frame '{}' is not known",
                        scan.message + 1,
                        scan.frame
                    )
                })?;
                let labels = scan.labels.clone();
                scans.push((scan.ns, Scan { t_s: seconds(scan.ns), sensor: place, detections, labels }));
            }
        }
        scans.sort_by_key(|(ns, _)| *ns);
        Ok((sensors, scans.into_iter().map(|(_, scan)| scan).collect()))
    }

    /// The axes of a frame of detections.
    fn axes(
        &self,
        topic: &str,
        frame: &str,
        head: Option<&Log>,
        several: bool,
        told: &mut Vec<String>,
    ) -> Result<Axes, String> {
        let base = self.motion.base();
        let found = self.seats.between(base, frame).map(|place| (base.to_owned(), place));
        if found.is_none() && self.is_world(frame) {
            return self.world(topic, frame, told).map(Axes::OfWorld);
        }
        // The vehicle may have two frame names; the transforms of the sensor end at one of them.
        let above = || self.seats.above(frame).filter(|(top, _)| !self.is_world(top));
        let Some((top, place)) = found.or_else(above) else {
            if head.is_none() {
                let called = if frame.is_empty() { "its frame".to_owned() } else { format!("its frame '{frame}'") };
                told.push(format!("{topic}: no transform from {base} to {called}; it is taken to be the vehicle's"));
            }
            return Ok(Axes::OfSensor(View::unknown(frame)));
        };
        let (view, unlike) = View::of(frame, &place);
        if unlike {
            told.push(format!(
                "{topic}: {frame} is called optical, but its transform does not turn it: points are taken to have z ahead and x to the right"
            ));
        }
        if head.is_none() {
            told.push(format!(
                "{topic}: {frame} sits {:.3} m ahead and {:.3} m to the left of {top}, turned by {:.4} rad",
                view.mounting.forward_m, view.mounting.left_m, view.mounting.yaw_rad
            ));
        }
        if top != base {
            told.push(format!("{topic}: no transform leads from {base} to {top}: they are taken to be the same"));
        }
        if view.is_tilted() {
            told.push(format!("{topic}: {frame} is turned by more than about the vertical: points are carried through the whole rotation"));
        }
        Ok(Axes::OfSensor(if several { view.relative_to_pose() } else { view }))
    }

    fn is_world(&self, frame: &str) -> bool {
        let Some(odometry) = self.motion.world() else { return WORLDS.contains(&frame) };
        frame == odometry
            || WORLDS.contains(&frame)
            || self.seats.is_above(frame, odometry)
            || (self.truth.world() == Some(frame) && !frame.is_empty() && frame != self.motion.base())
    }

    fn world(&self, topic: &str, frame: &str, told: &mut Vec<String>) -> Result<String, String> {
        let odometry = self.motion.world().unwrap_or_default();
        let ns = self.motion.times().next().unwrap_or(0);
        if !self.motion.has_poses() {
            return Err(format!(
                "{topic}: detections are in the frame '{frame}', not in one of the vehicle, and the odometry has no poses that bring them back:                  record them in the frame of the sensor"
            ));
        }
        if self.seats.world(frame, odometry, ns).is_none() {
            return Err(format!(
                "{topic}: detections are in the frame '{frame}', not in one of the vehicle, and neither /tf nor /tf_static says where '{odometry}' of                  the odometry is in it: record them in the frame of the sensor"
            ));
        }
        told.push(format!(
            "{topic}: detections are in the frame '{frame}': the pose of the odometry at their time brings them back to the vehicle"
        ));
        Ok(frame.to_owned())
    }

    fn pose_in(&self, world: &str, ns: u64) -> Option<[f64; 3]> {
        let [x, y, turn] = self.motion.pose(ns)?;
        let [east, north, more] = self.seats.world(world, self.motion.world()?, ns)?;
        let (s, c) = (libm::sin(more), libm::cos(more));
        Some([east + c * x - s * y, north + s * x + c * y, turn + more])
    }
}

enum Axes {
    OfSensor(View),
    /// The axes of a world frame with this name.
    OfWorld(String),
}

/// Dead reckoning by rows of odometry.
struct Reckoned<'r> {
    vehicle: Vehicle,
    rows: &'r [Odometry],
    start: [f64; 3],
    /// At each row: the pose, and the distance driven until then, m.
    at: Vec<([f64; 3], f64)>,
}

impl<'r> Reckoned<'r> {
    fn of(vehicle: Vehicle, rows: &'r [Odometry], start: [f64; 3]) -> Self {
        let (mut pose, mut way_m, mut at) = (start, 0.0, Vec::new());
        for (k, row) in rows.iter().enumerate() {
            at.push((pose, way_m));
            let dt_s = rows.get(k + 1).map_or(0.0, |next| next.t_s - row.t_s);
            pose = vehicle.step(pose, row.control, dt_s);
            way_m += row.speed_mps().abs() * dt_s;
        }
        Self { vehicle, rows, start, at }
    }

    /// The pose and the distance driven, m; the vehicle stands before the first row.
    fn at(&self, t_s: f64) -> ([f64; 3], f64) {
        let after = self.rows.partition_point(|row| row.t_s <= t_s);
        let Some(k) = after.checked_sub(1) else { return (self.start, 0.0) };
        let ((pose, way_m), row) = (self.at[k], &self.rows[k]);
        let dt_s = t_s - row.t_s;
        (self.vehicle.step(pose, row.control, dt_s), way_m + row.speed_mps().abs() * dt_s)
    }
}

/// The true pose at the first row of odometry. If the truth begins later, it is extrapolated back by odometry.
fn start_of(first: &TruePose, truth: &[TruePose], odometry: &[Odometry], reckoned: &Reckoned) -> [f64; 3] {
    let begin_s = odometry.first().map_or(first.t_s, |row| row.t_s);
    let pose = |row: &TruePose| [row.position[0], row.position[1], row.heading_rad.unwrap_or(0.0)];
    if first.t_s <= begin_s {
        return truth::at(truth, begin_s).as_ref().map_or(pose(first), pose);
    }
    let ([x, y, turn], way_m) = reckoned.at(first.t_s);
    let ([fx, fy, heading], [sx, sy, start]) = (pose(first), reckoned.start);
    if way_m == 0.0 && turn == start {
        return [fx, fy, heading];
    }
    // The motion by odometry since then, reversed from the first true pose.
    let began = heading - (turn - start);
    let (s, c) = (libm::sin(began - start), libm::cos(began - start));
    let (dx, dy) = (x - sx, y - sy);
    [fx - (c * dx - s * dy), fy - (s * dx + c * dy), wrap(began)]
}

/// True landmarks in the format of an exported run.
fn landmarks(told: &Told) -> Result<Vec<[f64; 2]>, ImportError> {
    let message: PointCloud2 = told.decode()?;
    let cloud = Cloud::of(&message).map_err(|error| told.error(error))?;
    let column = |name| cloud.column(name).map_err(|error| told.error(error));
    let (Some(x), Some(y)) = (column("x_m")?, column("y_m")?) else { return Ok(Vec::new()) };
    (0..cloud.points())
        .map(|point| Ok([told.finite("x_m", cloud.number(point, x))?, told.finite("y_m", cloud.number(point, y))?]))
        .collect()
}
