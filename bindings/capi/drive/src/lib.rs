//! A robot with a lidar, a radar, a satellite receiver and a compass, and a diver with a sonar: what they measure, event by event, and what
//! the library itself makes of it.

mod filters;
mod world;

pub use filters::{Filters, Memory};
pub use world::{SCANS, events};

/// One input, or the place where states are compared.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The robot's odometry: m/s, rad/s, s.
    Predict([f32; 3]),
    /// The lidar's scan: m, rad.
    Lidar(Vec<[f32; 2]>),
    /// The radar's scan.
    Radar(Vec<[f32; 2]>),
    /// Bearings of a camera, rad.
    Camera(Vec<f32>),
    /// A measured position, m.
    Position([f32; 2]),
    /// A measured heading, rad.
    Heading(f32),
    /// The diver's step: velocity along its axes, m/s; yaw rate, rad/s; z, m; s.
    Dive([f32; 6]),
    /// The sonar's scan: m, rad, rad.
    Sonar(Vec<[f32; 3]>),
    /// A measured height of the diver, m.
    Height(f32),
    /// Whoever has taken in all before should be in the states that the library is in.
    Compare,
}

impl Event {
    /// The event in one line: a letter, how many numbers follow, and the numbers by their bits, in hexadecimal digits.
    #[must_use]
    pub fn line(&self) -> String {
        let (letter, numbers): (char, Vec<f32>) = match self {
            Self::Predict(numbers) => ('p', numbers.to_vec()),
            Self::Lidar(scan) => ('l', scan.concat()),
            Self::Radar(scan) => ('r', scan.concat()),
            Self::Camera(scan) => ('c', scan.clone()),
            Self::Position(numbers) => ('g', numbers.to_vec()),
            Self::Heading(number) => ('h', vec![*number]),
            Self::Dive(numbers) => ('d', numbers.to_vec()),
            Self::Sonar(scan) => ('s', scan.concat()),
            Self::Height(number) => ('z', vec![*number]),
            Self::Compare => ('=', Vec::new()),
        };
        let numbers: String = numbers.iter().map(|number| format!(" {:08x}", number.to_bits())).collect();
        format!("{letter} {}{numbers}", numbers.len() / 9)
    }
}
