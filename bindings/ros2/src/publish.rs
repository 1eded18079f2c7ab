//! Plays logs, scenarios of the simulator and MCAP files as messages.

use crate::describe;
use crate::middleware::{Arguments, Failure, IN, any_publisher, latched, node, reliable};
use crate::raw::{HEAD, Raw};
use crate::setup::Setup;
use ros2_client::qos::History;
use ros2_client::{Node, NodeOptions, Publisher};
use scphd_exchange::mcap::shape::{covariance, pose};
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Filter, Precision};
use scphd_log::dimensions::Planar;
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_ros::{Channel, Reader, Record, Time};
use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

/// Maximum waiting time for readers.
const READERS: Duration = Duration::from_secs(10);
/// Waiting times after discovery, because readers may not yet have discovered the publisher, and after the last message.
const SETTLE: Duration = Duration::from_secs(1);
const LINGER: Duration = Duration::from_millis(500);

/// Arguments of the command line.
struct Task {
    source: String,
    seed: u64,
    rate: f64,
    params: Option<String>,
    poses: Option<String>,
    file: Option<String>,
    log: Option<String>,
    play: bool,
}

const USAGE: &str = "scphd-publish SOURCE [--rate R] [--seed N] [--params FILE] [--poses FILE] [--file FILE] [--log DIR] [--no-play]\n\
    SOURCE: a folder of a log, an MCAP file, or a scenario of the simulator\n\
    --rate R       so many times as fast as it was recorded [default: 1]\n\
    --params FILE  writes the parameters for scphd-node, as `scphd-sim replay` has them (logs and scenarios)\n\
    --poses FILE   writes the poses of `scphd-sim replay` (logs and scenarios)\n\
    --file FILE    writes the messages as MCAP\n\
    --log DIR      writes the log\n\
    --no-play      writes files alone";

impl Task {
    fn of(words: &[String]) -> Result<Self, Failure> {
        let mut task = Self {
            source: String::new(),
            seed: 1,
            rate: 1.0,
            params: None,
            poses: None,
            file: None,
            log: None,
            play: true,
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let mut next = || words.next().cloned().ok_or_else(|| Failure(format!("{word} needs a value\n{USAGE}")));
            let number = |text: String| text.parse().map_err(|_| Failure(format!("{word}: '{text}' is no number")));
            match word.as_str() {
                "--rate" => task.rate = number(next()?)?,
                "--seed" => task.seed = next()?.parse().map_err(|_| Failure(format!("{word} needs a number")))?,
                "--params" => task.params = Some(next()?),
                "--poses" => task.poses = Some(next()?),
                "--file" => task.file = Some(next()?),
                "--log" => task.log = Some(next()?),
                "--no-play" => task.play = false,
                _ if word.starts_with("--") || !task.source.is_empty() => {
                    return Err(Failure(format!("'{word}' is not understood\n{USAGE}")));
                }
                _ => task.source.clone_from(word),
            }
        }
        if task.source.is_empty() || !(task.rate > 0.0) {
            return Err(Failure(USAGE.into()));
        }
        Ok(task)
    }
}

/// A message with its time, ns, and the index of its channel.
struct Message {
    at_ns: u64,
    place: usize,
    data: Vec<u8>,
}

/// Runs the program.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let task = Task::of(&arguments.rest)?;
    let path = Path::new(&task.source);
    let bytes = if path.is_file() {
        fs::read(path).map_err(|error| Failure(format!("{}: {error}", task.source)))?
    } else {
        let log = log(&task)?;
        let settings = Settings::for_log(&log);
        if let Some(dir) = &task.log {
            let written = log_folder::write(&log, Path::new(dir));
            written.map_err(|error| Failure(format!("{dir}: {error}")))?;
        }
        if let Some(file) = &task.params {
            let (description, wiring) = (scphd_filters::describe::description(&log, &settings), describe::wiring(&log));
            write(file, &Setup::parameters(&description, &wiring).text("scphd"))?;
        }
        if let Some(file) = &task.poses {
            write(file, &poses(&log, &settings)?)?;
        }
        scphd_exchange::mcap::inputs(&log, &settings).map_err(|error| Failure(error.to_string()))?
    };
    if let Some(file) = &task.file {
        fs::write(file, &bytes).map_err(|error| Failure(format!("{file}: {error}")))?;
    }
    if !task.play {
        return Ok(());
    }
    let (channels, messages) = read(&bytes).map_err(|error| Failure(format!("{}: {error}", task.source)))?;
    play(arguments, &channels, messages, task.rate)
}

fn write(file: &str, text: &str) -> Result<(), Failure> {
    fs::write(file, text).map_err(|error| Failure(format!("{file}: {error}")))
}

fn log(task: &Task) -> Result<Log, Failure> {
    let path = Path::new(&task.source);
    if path.is_dir() {
        return log_folder::read(path).map_err(|error| Failure(error.to_string()));
    }
    scphd_worlds::scenario::by_name(&task.source, task.seed)
        .ok_or_else(|| Failure(format!("'{}' is no folder, no file and no scenario in the plane", task.source)))
}

/// The poses of a replay after every scan, with times rounded to stamps: stamp, position, orientation and covariance as in a
/// message.
fn poses(log: &Log, settings: &Settings) -> Result<String, Failure> {
    let mut log = log.clone();
    let times = log.odometry.iter_mut().map(|row| &mut row.t_s);
    let times = times.chain(log.scans.iter_mut().map(|scan| &mut scan.t_s));
    let times = times.chain(log.fixes.iter_mut().map(|fix| &mut fix.t_s));
    for t_s in times {
        let at = Time::from_seconds(*t_s).map_err(|error| Failure(error.to_string()))?;
        // The double nearest to the decimal number.
        *t_s = at.nanoseconds() as f64 / 1e9;
    }
    let filter = Filter::Joint(Precision::F32);
    let session = scphd_run::session::run::<Planar>(&log, settings, filter, 1, &mut |_| {});
    let session = session.map_err(|error| Failure(error.to_string()))?;
    let mut text = String::from("sec,nanosec,x,y,qz,qw,xx,xy,xyaw,yy,yyaw,yawyaw\n");
    for scan in &session.record.scans {
        let [x, y, heading_rad] = scan.pose;
        let pose = pose(&[x, y], heading_rad);
        let of = covariance(2, |row, column| scan.pose_covariance[row][column]);
        let at = Time::from_seconds(scan.t_s).map_err(|error| Failure(error.to_string()))?;
        let numbers =
            [x, y, pose.orientation.z, pose.orientation.w, of[0][0], of[0][1], of[0][5], of[1][1], of[1][5], of[5][5]];
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{},{}", at.sec, at.nanosec, numbers.join(","));
    }
    Ok(text)
}

/// The messages of an MCAP file that the middleware can send, in the order of time.
fn read(bytes: &[u8]) -> Result<(Vec<Channel>, Vec<Message>), String> {
    let (mut channels, mut messages): (Vec<Channel>, Vec<Message>) = (Vec::new(), Vec::new());
    let mut reader = Reader::new(Cursor::new(bytes));
    while let Some(record) = reader.next().map_err(|error| error.to_string())? {
        let Record::Message { channel, log_time_ns, data } = record else { continue };
        let Some(of) = reader.channel(channel).filter(|of| of.encoding == "cdr") else { continue };
        let data = scphd_ros::unpacked_message(&data)?.into_owned();
        if data.get(..2) != HEAD.get(..2) {
            return Err(format!("{}: a message is not in little-endian CDR", of.topic));
        }
        let place = channels.iter().position(|known| known == of).unwrap_or_else(|| {
            channels.push(of.clone());
            channels.len() - 1
        });
        messages.push(Message { at_ns: log_time_ns, place, data });
    }
    messages.sort_by_key(|message| message.at_ns);
    Ok((channels, messages))
}

fn play(arguments: &Arguments, channels: &[Channel], messages: Vec<Message>, rate: f64) -> Result<(), Failure> {
    let mut node = node(arguments, NodeOptions::new().enable_rosout(false).start_parameter_services(false))?;
    let spinner = node.spinner().map_err(|error| Failure(format!("{error:?}")))?;
    thread::spawn(move || futures::executor::block_on(spinner.spin()));
    let publishers = channels.iter().map(|channel| {
        let quality = if channel.topic.ends_with("tf_static") {
            latched()
        } else {
            reliable().history(History::KeepLast { depth: IN })
        };
        any_publisher(&mut node, &arguments.resolved(&channel.topic), &channel.kind, &quality)
    });
    let publishers: Vec<Publisher<Raw>> = publishers.collect::<Result<_, _>>()?;
    wait(&node, &publishers, channels);
    let (begun, from_ns) = (Instant::now(), messages.first().map_or(0, |message| message.at_ns));
    let count = messages.len();
    for Message { at_ns, place, data } in messages {
        let due = Duration::from_secs_f64((at_ns - from_ns) as f64 / 1e9 / rate);
        thread::sleep(due.saturating_sub(begun.elapsed()));
        let Some(publisher) = publishers.get(place) else { continue };
        publisher.publish(Raw(data)).map_err(|error| Failure(format!("a message is not sent: {error:?}")))?;
    }
    thread::sleep(LINGER);
    println!("{count} messages sent in {:.1} s", begun.elapsed().as_secs_f64());
    Ok(())
}

/// Waits until every topic has a reader.
fn wait(node: &Node, publishers: &[Publisher<Raw>], channels: &[Channel]) {
    let begun = Instant::now();
    loop {
        let lonely =
            publishers.iter().zip(channels).filter(|(publisher, _)| publisher.get_subscription_count(node) == 0);
        let lonely: Vec<&str> = lonely.map(|(_, channel)| channel.topic.as_str()).collect();
        if lonely.is_empty() {
            thread::sleep(SETTLE);
            return;
        }
        if begun.elapsed() > READERS {
            println!("nobody reads {}", lonely.join(", "));
            return;
        }
        thread::sleep(Duration::from_millis(20));
    }
}
