//! Finds posts with an LD06 or LD19: `posts RADIUS_M FILE` or `posts RADIUS_M tcp:HOST:PORT` reads the bytes of the lidar.
//!
//! A serial port is a file once its speed is set: `stty -F /dev/ttyUSB0 230400 raw`, then `posts 0.05 /dev/ttyUSB0`. Without
//! arguments the example simulates a room with three posts, and checks that they are found.

use embedded_io::{ErrorKind, ErrorType};
use scphd_lidar::{Assembler, Found, Packet, PostFinder, PostSettings, Reading, Receiver, ReceiverReport, Resolution};
use std::error::Error;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::net::TcpStream;

/// Capacity for the points of a revolution at 5 Hz.
const POINTS: usize = 1024;
/// Capacity for posts.
const POSTS: usize = 32;

/// A reader of the standard library as one of `embedded_io`.
struct Line<R>(R);

/// An error of the reader.
#[derive(Debug)]
struct Broken(std::io::Error);

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for Broken {}

impl embedded_io::Error for Broken {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl<R> ErrorType for Line<R> {
    type Error = Broken;
}

impl<R: Read> embedded_io::Read for Line<R> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Broken> {
        self.0.read(bytes).map_err(Broken)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [] => check(),
        [radius, place] => {
            let settings = PostSettings::of_radius(radius.parse()?);
            let source: Box<dyn Read> = match place.strip_prefix("tcp:") {
                Some(address) => Box::new(TcpStream::connect(address)?),
                None => Box::new(File::open(place)?),
            };
            println!("half of all posts are detected up to {:.2} m", Resolution::LD06.reach_m(&settings, 0.5));
            let report = look(Line(source), settings, print)?;
            println!("{report:?}");
            Ok(())
        }
        _ => Err("posts RADIUS_M FILE, posts RADIUS_M tcp:HOST:PORT, or nothing".into()),
    }
}

/// Finds posts in the bytes of a reader until it ends.
fn look(
    mut line: impl embedded_io::Read<Error: 'static>,
    settings: PostSettings,
    mut tell: impl FnMut(&Found<POSTS>),
) -> Result<ReceiverReport, Box<dyn Error>> {
    let (mut receiver, mut assembler) = (Receiver::new(), Assembler::<POINTS>::new());
    let finder = PostFinder::new(settings)?;
    while let Some(packet) = receiver.read(&mut line)? {
        if let Some(revolution) = assembler.push(&packet) {
            tell(&finder.find(revolution));
        }
    }
    Ok(receiver.report())
}

fn print(found: &Found<POSTS>) {
    for post in &found.posts {
        let degrees = post.bearing_rad.to_degrees();
        println!("{:.3} m {degrees:7.2}° {} points, intensity {}", post.range_m, post.points, post.intensity);
    }
    let Found { beyond, small, misshapen, hidden, cut, .. } = found;
    println!(
        "{} posts; beyond {beyond}, small {small}, misshapen {misshapen}, hidden {hidden}, cut {cut}",
        found.posts.len()
    );
}

/// Range (m) and bearing (degrees) of three posts with a radius of 5 cm in a round room of 6 m; the lidar does not move.
const SEEN: [(f32, f32); 3] = [(1.5, 0.0), (2.0, 60.0), (1.0, -100.0)];

/// The simulated reading at this angle, degrees clockwise.
fn reading(angle: f32) -> Reading {
    let range_m = SEEN.iter().fold(6.0_f32, |nearest, (range, bearing)| {
        let aside = (-angle - bearing).to_radians();
        let past = range * aside.sin();
        let is_hit = past.abs() < 0.05 && aside.cos() > 0.0;
        if is_hit { nearest.min(range * aside.cos() - (0.05 * 0.05 - past * past).sqrt()) } else { nearest }
    });
    Reading { range_mm: (1000.0 * range_m).round() as u16, intensity: 100 }
}

fn check() -> Result<(), Box<dyn Error>> {
    let angle = |k: u32| (k * 80 + 7) % 36_000;
    let bytes: Vec<u8> = (0..120)
        .flat_map(|packet: u32| {
            let angles = core::array::from_fn::<u32, 12, _>(|k| angle(12 * packet + k as u32));
            let packet = Packet {
                speed_degps: 3600,
                start_cdeg: angles[0] as u16,
                readings: angles.map(|angle| reading(angle as f32 * 0.01)),
                end_cdeg: angles[11] as u16,
                time_ms: (packet * 8 / 3) as u16,
            };
            packet.to_bytes()
        })
        .collect();
    let mut revolutions = 0;
    let report = look(&bytes[..], PostSettings::of_radius(0.05), |found| {
        print(found);
        revolutions += 1;
        assert_eq!(found.posts.len(), SEEN.len());
        for (range_m, degrees) in SEEN {
            let near = |post: &&scphd_lidar::Post| (post.bearing_rad.to_degrees() - degrees).abs() < 0.5;
            let post = found.posts.iter().find(near).expect("a post at this bearing");
            assert!((post.range_m - range_m).abs() < 0.01, "{} m for {range_m} m", post.range_m);
        }
    });
    println!("{:?}", report?);
    assert!(revolutions >= 2);
    Ok(())
}

#[cfg(test)]
#[test]
fn three_posts_are_found() {
    check().unwrap();
}
