//! Dimensions of the positions, poses and measurements of a kind of vehicle: records, scores and tables are generic over them.

use scphd::models::AuvControl;
use std::convert::Infallible;
use std::fmt::Debug;

/// An array of numbers of any length.
pub trait Coordinates: Copy + Debug + PartialEq + AsRef<[f64]> + Send + Sync + 'static {
    /// A matrix with this number of rows and columns, row by row.
    type Square: Copy + Debug + PartialEq + AsRef<[Self]> + Send + Sync;

    const COUNT: usize;

    /// The array with these numbers.
    fn with(number: impl FnMut(usize) -> f64) -> Self;

    /// The matrix with these entries, by row and column.
    fn square(entry: impl Fn(usize, usize) -> f64) -> Self::Square;
}

impl<const N: usize> Coordinates for [f64; N] {
    type Square = [[f64; N]; N];

    const COUNT: usize = N;

    fn with(number: impl FnMut(usize) -> f64) -> Self {
        std::array::from_fn(number)
    }

    fn square(entry: impl Fn(usize, usize) -> f64) -> [[f64; N]; N] {
        std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
    }
}

pub type Covariance<C> = <C as Coordinates>::Square;

/// Distance of two positions, or of a position and a pose.
pub fn distance(a: &impl AsRef<[f64]>, b: &impl AsRef<[f64]>) -> f64 {
    a.as_ref().iter().zip(b.as_ref()).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// A measurement of the pose itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseFix {
    /// Position of the antenna, m.
    Position([f64; 2]),
    /// The heading, rad, from the x axis towards the y axis.
    Heading(f64),
}

/// The types of a kind of vehicle.
pub trait Dimensions: Debug + Clone + Copy + PartialEq + Default + Send + Sync + 'static {
    type Position: Coordinates;
    /// A pose: a position, then the heading, rad, then other coordinates, if any.
    type Pose: Coordinates;
    /// Result of dead reckoning: a position, then the heading if it has one of its own.
    type Reckoned: Coordinates;
    type Measurement: Coordinates;
    type Control: Debug + Copy + PartialEq + Send + Sync;
    /// A measurement of the pose itself.
    type Fix: Debug + Copy + PartialEq + Send + Sync;

    /// Names and units of the coordinates of a pose.
    const POSE: &'static [(&'static str, &'static str)];

    /// Whether features of the map may move.
    const MOVING: bool;
    /// Pairs of axes for drawing maps: from above and, in space, from the side.
    const LOOKS: &'static [[usize; 2]];

    fn position(pose: &Self::Pose) -> Self::Position {
        Self::Position::with(|k| pose.as_ref()[k])
    }

    fn heading(pose: &Self::Pose) -> f64 {
        pose.as_ref()[Self::Position::COUNT]
    }
}

/// A vehicle in the plane with a range-bearing sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Planar;

impl Dimensions for Planar {
    type Position = [f64; 2];
    /// x m, y m, heading rad.
    type Pose = [f64; 3];
    type Reckoned = [f64; 3];
    /// Range m, bearing rad.
    type Measurement = [f64; 2];
    /// Speed m/s, then steering angle rad or turn rate rad/s, then speed to the left m/s.
    type Control = [f64; 3];
    type Fix = PoseFix;

    const POSE: &'static [(&'static str, &'static str)] = &[("x", "m"), ("y", "m"), ("heading", "rad")];
    const MOVING: bool = true;
    const LOOKS: &'static [[usize; 2]] = &[[0, 1]];
}

/// An underwater vehicle in space with a stereo camera (chapter 7).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Underwater;

impl Dimensions for Underwater {
    type Position = [f64; 3];
    /// x, y, z m, yaw rad, yaw rate rad/s.
    type Pose = [f64; 5];
    type Reckoned = [f64; 3];
    /// (u_l, v_l, u_r, v_r), px.
    type Measurement = [f64; 4];
    type Control = AuvControl<f64>;
    /// There are no fixes in logs of such vehicles.
    type Fix = Infallible;

    const POSE: &'static [(&'static str, &'static str)] =
        &[("x", "m"), ("y", "m"), ("z", "m"), ("yaw", "rad"), ("yaw_rate", "radps")];
    const MOVING: bool = false;
    const LOOKS: &'static [[usize; 2]] = &[[0, 1], [0, 2]];
}
