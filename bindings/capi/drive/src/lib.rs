//! The inputs of two vehicles, event by event, and the states of the library after them: a robot with lidar, radar, satellite
//! receiver and compass, and a diver with a sonar.

mod described;
mod filters;
mod world;

pub use described::{control, descriptions, take};
pub use filters::{Filters, Memory};
pub use world::{SCANS, events};

/// An input, or a point where states are compared.
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
    /// Point where the states have to be equal to those of the library.
    Compare,
}

impl Event {
    /// The event in one line: a letter, the number of numbers, and their bits in hexadecimal digits.
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
