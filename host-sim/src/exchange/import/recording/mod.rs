//! Logs of MCAP files with messages of ROS 2; docs/logs.md lists what is understood.
//!
//! | file | |
//! |---|---|
//! | `options.rs` | what is asked for |
//! | `topics.rs` | what there is, and which of it is meant |
//! | `told.rs` | a message, and where it is |
//! | `sight.rs` | detections of messages |
//! | `motion.rs` | odometry of messages |
//! | `place.rs` | fixes and true poses of messages |
//! | `seat.rs` | where sensors sit |

mod motion;
mod options;
mod place;
mod seat;
mod sight;
mod told;
mod topics;

pub use options::{Clock, Options};

use super::{Draft, ImportError, Imported};
use crate::log::{Log, Scan, Vehicle};
use crate::log_folder;
use motion::Motion;
use place::{Fixes, True};
use scphd_ros::messages::{PointCloud2, TFMessage};
use scphd_ros::{Channel, Cloud, ReadError, Reader, Record, Time};
use seat::Seats;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use told::Told;
use topics::{Chosen, Content};

/// Beyond so many nanoseconds not every number is one of double precision: times are counted from the first message on.
const EXACT_NS: u64 = 1 << 53;

/// Reads the log in a file.
///
/// # Errors
/// The file is damaged, something is missing in it, or a message cannot be read: see [`ImportError`].
pub fn read(path: &Path, options: &Options) -> Result<Imported, ImportError> {
    let mut told = Vec::new();
    let mut content = Content::default();
    let torn = each(path, |reader, record| content.take(reader, record))?;
    if let Some(error) = torn {
        if !options.partial {
            return Err(ImportError::at(path.display(), format_args!("{error}; --partial takes what lies before")));
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
    each(path, |reader, record| {
        let Record::Message { channel, log_time_ns, data } = record else { return };
        let Some(channel) = reader.channel(channel).filter(|_| failed.is_none()) else { return };
        failed = gathered.take(channel, log_time_ns, &data).err();
    })?;
    if let Some(error) = failed {
        let ImportError::At { place, what } = error else { return Err(error) };
        return Err(ImportError::at(format_args!("{}, {place}", path.display()), what));
    }
    let name = path.file_stem().map_or_else(|| "log".to_owned(), |name| name.to_string_lossy().into_owned());
    let draft = gathered.draft(name, head, told).map_err(|what| ImportError::at(path.display(), what))?;
    draft.finish()
}

/// Shows every record of a file; what cut it short, if anything did.
fn each(path: &Path, mut show: impl FnMut(&Reader<BufReader<File>>, Record)) -> Result<Option<ReadError>, ImportError> {
    let file = File::open(path).map_err(|error| ImportError::io(path, error))?;
    let mut reader = Reader::new(BufReader::new(file));
    loop {
        match reader.next() {
            Ok(Some(record)) => show(&reader, record),
            Ok(None) => return Ok(None),
            Err(error) => return Ok(Some(error)),
        }
    }
}

/// What is read of the chosen topics; times are in nanoseconds.
struct Gathered<'c> {
    chosen: &'c Chosen,
    clock: Clock,
    counts: Vec<(String, usize)>,
    /// Topics whose headers have no time.
    unstamped: Vec<String>,
    motion: Motion,
    scans: Vec<(u64, Scan, String)>,
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
        if *topic == self.chosen.odometry {
            let stamp = self.motion.take(&told)?;
            let ns = self.time(&told, stamp);
            self.motion.at(ns);
        }
        if let Some(sensor) = self.chosen.detections.iter().position(|(_, of)| of == topic) {
            let sight = sight::of(&told)?;
            self.left_out += sight.left_out;
            let ns = self.time(&told, sight.stamp);
            let scan = Scan { t_s: 0.0, sensor, detections: sight.detections, labels: sight.labels };
            self.scans.push((ns, scan, sight.frame));
        }
        if self.chosen.fixes.as_ref() == Some(topic) {
            let stamp = self.fixes.take(&told)?;
            let ns = self.time(&told, stamp);
            self.fixes.at(ns);
        }
        if self.chosen.truth.as_ref() == Some(topic) {
            let stamp = self.truth.take(&told)?;
            let ns = self.time(&told, stamp);
            self.truth.at(ns);
        }
        match topic.as_str() {
            crate::exchange::mcap::topic::LANDMARKS => self.landmarks = landmarks(&told)?,
            crate::exchange::mcap::topic::TF_STATIC if channel.kind == "tf2_msgs/msg/TFMessage" => {
                self.seats.take(&told.decode::<TFMessage>()?);
            }
            _ => {}
        }
        Ok(())
    }

    /// The time that counts of a message, ns.
    fn time(&mut self, told: &Told, stamp: Time) -> u64 {
        if self.clock == Clock::Header && stamp != Time::default() {
            return stamp.nanoseconds();
        }
        if self.clock == Clock::Header && told.log_time_ns > 0 && !self.unstamped.contains(&told.channel.topic) {
            self.unstamped.push(told.channel.topic.clone());
        }
        told.log_time_ns
    }

    fn draft(self, name: String, head: Option<Log>, mut told: Vec<String>) -> Result<Draft, String> {
        for topic in &self.unstamped {
            told.push(format!("{topic}: headers have no time, the time of the recording counts"));
        }
        if self.scans.is_empty() {
            return Err("no scan: no message of detections".into());
        }
        let all = self.motion.times().chain(self.scans.iter().map(|(ns, ..)| *ns));
        let (least, most) = all.fold((u64::MAX, 0), |(least, most), ns| (least.min(ns), most.max(ns)));
        let zero = if most > EXACT_NS { least / 1_000_000_000 * 1_000_000_000 } else { 0 };
        if zero > 0 {
            told.push(format!("times are counted from {} s on", zero / 1_000_000_000));
        }
        // Whole nanoseconds that double precision has, over 10⁹: the nearest number to the decimal.
        let seconds = |ns: u64| if ns < zero { -((zero - ns) as f64 / 1e9) } else { (ns - zero) as f64 / 1e9 };
        if self.left_out > 0 {
            told.push(format!("{} points without a place are left out", self.left_out));
        }
        let mut sensors = Vec::new();
        for (place, (sensor, topic)) in self.chosen.detections.iter().enumerate() {
            let frame = self.scans.iter().find(|(_, scan, _)| scan.sensor == place).map(|(_, _, frame)| frame.as_str());
            let base = self.motion.base();
            let seat = frame.and_then(|frame| self.seats.find(base, frame));
            if head.is_none() {
                told.push(match (seat, frame) {
                    (Some(seat), Some(frame)) => format!(
                        "{topic}: {frame} sits {:.3} m ahead and {:.3} m to the left of {base}, turned by {:.4} rad",
                        seat.forward_m, seat.left_m, seat.yaw_rad
                    ),
                    _ => format!("{topic}: no transform from {base} to its frame; it is taken to be the vehicle's"),
                });
            }
            sensors.push((sensor.clone(), seat));
        }
        let truth = self.truth.rows(&seconds);
        let (fixes, fix_noise, of_fixes) = self.fixes.rows(&seconds, head.as_ref().map(|head| head.fix_noise))?;
        told.extend(of_fixes);
        let (odometry, of_motion) = self.motion.rows(&seconds)?;
        told.extend(of_motion);
        let initial_pose = truth.first().map(|row| [row.position[0], row.position[1], row.heading_rad.unwrap_or(0.0)]);
        if head.is_none() && initial_pose.is_some() {
            told.push("the vehicle starts at the first true pose".to_owned());
        }
        let scans = self.scans.into_iter().map(|(ns, scan, _)| Scan { t_s: seconds(ns), ..scan }).collect();
        let landmarks = self.landmarks;
        Ok(Draft {
            name,
            head,
            sensors,
            initial_pose,
            odometry,
            scans,
            fixes,
            fix_noise,
            truth,
            landmarks,
            told,
            ..Draft::default()
        })
    }
}

/// True landmarks, as an exported run has them.
fn landmarks(told: &Told) -> Result<Vec<[f64; 2]>, ImportError> {
    let message: PointCloud2 = told.decode()?;
    let cloud = Cloud::of(&message).map_err(|error| told.error(error))?;
    let column = |name| cloud.column(name).map_err(|error| told.error(error));
    let (Some(x), Some(y)) = (column("x_m")?, column("y_m")?) else { return Ok(Vec::new()) };
    (0..cloud.points())
        .map(|point| Ok([told.finite("x_m", cloud.number(point, x))?, told.finite("y_m", cloud.number(point, y))?]))
        .collect()
}
