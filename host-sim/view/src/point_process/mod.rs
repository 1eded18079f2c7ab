//! Simulated point processes over a rectangle (thesis, subsections 3.1.5 and 3.1.6).
//!
//! An [`IidProcess`] draws a number of points from a [`Cardinality`] and places them independently by a [`Spatial`]
//! distribution; with a Poisson number it is a Poisson process ([`poisson`]). A cluster process ([`cluster`]) draws
//! parents and then daughters that depend on their parent: [`SegmentCox`] places them on segments, [`Matern`] in discs.
//! Every draw comes from a seeded [`Noise`](scphd_log::noise::Noise), so that a realisation is the same to the bit on every
//! machine.
//!
//! Lengths are in metres, intensities in 1/m².
//!
//! ```
//! use scphd_log::noise::Noise;
//! use scphd_view::point_process::{Border, Matern, Poisson, Rectangle, cluster, poisson};
//!
//! let region = Rectangle::new([-100.0, 100.0], [-100.0, 100.0])?;
//! let mut noise = Noise::new(1);
//! let points = poisson::homogeneous(region, 100.0)?.simulate(&mut noise);
//! assert!(points.iter().all(|&point| region.contains(point)));
//!
//! let matern = Matern::new(region, Poisson::new(5.0)?, 20.0, Poisson::new(20.0)?, Border::Clipped)?;
//! let clusters = matern.simulate(&mut noise);
//! assert!(cluster::points(&clusters).all(|point| region.contains(point)));
//! # Ok::<(), scphd_view::point_process::ProcessError>(())
//! ```

pub mod cardinality;
pub mod cluster;
pub mod figures;
pub mod iid;
pub mod matern;
pub mod poisson;
pub mod region;
pub mod segment_cox;
pub mod spatial;
#[cfg(test)]
mod statistics;

pub use cardinality::{Binomial, Cardinality, Fixed, Geometric, Poisson};
pub use cluster::{Border, Cluster};
pub use iid::IidProcess;
pub use matern::Matern;
pub use region::Rectangle;
pub use segment_cox::SegmentCox;
pub use spatial::{Disc, Normal, Segment, Spatial};

/// A position (x, y), m.
pub type Point = [f64; 2];

/// Why a process cannot be simulated.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProcessError {
    /// The limits of a region.
    #[error(
        "a region from ({}, {}) to ({}, {}) m has no area that can be computed with", low[0], low[1], high[0], high[1]
    )]
    Region {
        /// Lower limits of x and y.
        low: Point,
        /// Upper limits of x and y.
        high: Point,
    },
    /// The mean of a Poisson number.
    #[error("a mean number of {0} points is not within 0 and {max}", max = cardinality::MAX_MEAN)]
    Mean(f64),
    /// A probability.
    #[error("{0} is not a probability this distribution can have")]
    Probability(f64),
    /// A radius or a length.
    #[error("a cluster cannot have a size of {0} m")]
    Size(f64),
    /// A covariance.
    #[error("[[{}, {}], [{}, {}]] is not the covariance of a normal distribution", .0[0][0], .0[0][1], .0[1][0], .0[1][1])]
    Covariance([[f64; 2]; 2]),
    /// A mean of a normal distribution or a centre.
    #[error("({}, {}) is not a position", .0[0], .0[1])]
    Position(Point),
    /// An intensity function that is not within 0 and its bound.
    #[error("the intensity {intensity} at ({}, {}) is not within 0 and its bound {bound}", at[0], at[1])]
    Intensity {
        /// Where it was evaluated.
        at: Point,
        /// Its value there, 1/m².
        intensity: f64,
        /// The bound it was said to have, 1/m².
        bound: f64,
    },
}
