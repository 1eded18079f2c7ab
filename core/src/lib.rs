//! Landmark SLAM in fixed memory: a filter with a joint map, and the single-cluster PHD filter.
//!
//! Where is the vehicle, and which landmarks are around it? Two filters answer, from odometry and detections without labels, some of them
//! false:
//!
//! * [`JointSlam`], recommended: one Gaussian over the pose and all landmarks, with probabilistic data association and existence
//!   probabilities;
//! * [`ScPhd`], the filter of C. S. Lee's thesis (*SLAM using Single Cluster PHD Filters*, Girona 2014): particles for the vehicle (the
//!   parent process), and for every particle a Gaussian mixture for the map (the daughter process). Landmarks are a random finite set, which
//!   needs no data association.
//!
//! It is written for vehicle computers:
//!
//! * `no_std`, no heap, no `unsafe`. Everything lives in one [`JointState`] or [`State`], whose size is known before the build;
//! * nothing panics: bad input is an error that leaves the state as it was, want of room is handled in a defined order
//!   and reported in the [`JointReport`] or [`ScanReport`];
//! * the same inputs give the same bits on every machine ([`JointSlam::digest`]): a vehicle's log replays on a desk.
//!
//! # How to use it
//!
//! Choose how the vehicle moves ([`Motion`]), a tuning ([`JointConfig`]) and capacities ([`joint_memory!`]), and put a [`JointSlam`] over
//! them. Every sensor on the vehicle is a [`Detector`]: its models ([`Sensor`], [`FieldOfView`], [`Clutter`]; some come with the crate),
//! where it sits ([`Mounting`]) and how landmarks are initiated ([`Births`]). Then [`predict`](JointSlam::predict) with every odometry
//! sample, [`scan`](JointSlam::scan) with every scan of any detector, [`observe`](JointSlam::observe) with every measurement of the pose
//! itself ([`Fix`]), and read [`estimate_pose`](JointSlam::estimate_pose) and the map. [`JointSlam`] has a complete example. A [`ScPhd`] is
//! used the same way, with [`Config`] and [`memory!`]. `examples/` has a robot with a lidar, two radars on a car, satellite fixes, and
//! tracking.
//!
//! With one particle and [`KnownPose`] a [`ScPhd`] is a Gaussian-mixture PHD filter for tracking from a known place.
//!
//! # Where things are
//!
//! Every folder depends on those before it alone:
//!
//! | folder | what is in it |
//! |---|---|
//! | `numerics/` | scalars, vectors, symmetric matrices, random numbers, sums of logarithms |
//! | `map/` | components, the copy-on-write pages that hold them, the scratch of an update, reduction |
//! | `models/` | poses, motions, sensors, views, clutter, mountings, fixes |
//! | `report/` | errors, health, reports, probes |
//! | `settings/` | what a user tunes |
//! | `detection/` | a scan as one pose sees its map: what to expect, what it meets, how well it is explained |
//! | `particles/` | candidates, prediction, proposals, selection |
//! | `snapshot/` | the state as bytes |
//! | `filter/` | the memory, the steps, and all that can be asked of a filter |
//! | `joint/` | the filter with a joint map |
//! | `fixes/` | whether fixes that are refused are wrong, or the filter |
//! | `locate/` | where the vehicle is in a map of an earlier drive |
//!
//! `filter/step.rs` is one scan from top to bottom: propose poses, weigh, select, update, reduce. `joint/` is the filter with a
//! joint map, `navigation/` what an underwater vehicle knows of its velocity. The recursion with all its choices is written out in
//! `docs/recursion.md`.
//!
//! # Features
//!
//! * `defmt`: `Format` for configuration, reports, health and errors.
//! * `embedded-hal`: `StagePins`, a probe of the stages over output pins.
//! * `flips`: [`ScPhd`] and [`JointSlam`] flip a bit of their own state (`flip_bit`), for tests of failing memory on a board.
//!
//! # When memory runs short
//!
//! A map's update first tightens its pruning, in factors of four up to half a feature, then leaves out births, then
//! leaves the map as it was predicted; confirmed features are given up last, and only where the scratch of one update
//! (`VIEW`) itself is too small. Every step down is counted in the [`ScanReport`] and raises a flag in [`Health`].
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod detection;
mod filter;
pub mod fixes;
mod joint;
pub mod locate;
mod map;
mod memory;
pub mod models;
pub mod navigation;
pub mod numerics;
mod particles;
mod report;
pub mod settings;
pub mod snapshot;
#[cfg(test)]
mod tests;

pub use filter::detector::{Births, Detector, DetectorMemory};
pub use filter::extract::{MapEstimate, PoseEstimate};
pub use filter::observe::FixReport;
pub use filter::scphd::ScPhd;
pub use filter::state::State;
pub use joint::{JointConfig, JointReport, JointSlam, JointState};
pub use map::component::Component;
pub use numerics::real::Real;
pub use report::health::Health;
pub use report::reports::{PredictReport, ScanReport};
pub use settings::config::Config;

/// What operations return where they fail; the state is then as it was.
pub mod errors {
    pub use crate::report::any_error::Error;
    pub use crate::report::config_error::ConfigError;
    pub use crate::report::error::{
        Flaw, Implausible, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError,
    };
}

/// Observers of the stages of a scan, and the search for bits that flipped in the state's memory.
pub mod diagnostics {
    pub use crate::filter::scrub::{Scrubbed, Scrubber};
    #[cfg(feature = "embedded-hal")]
    pub use crate::report::probe::StagePins;
    #[cfg(feature = "defmt")]
    pub use crate::report::probe::StageTrace;
    pub use crate::report::probe::{Probe, Stage};
    pub use crate::report::reports::Peak;
}

/// The parts that [`memory!`] and [`joint_memory!`] name, and the threads that share an update.
pub mod storage {
    pub use crate::filter::detector::ScanRoom;
    pub use crate::filter::draft::{Capacities, Draft, UpdateMemory};
    pub use crate::filter::executor::{Executor, Serial};
    #[doc(hidden)]
    pub use crate::filter::sampling::Samples;
    #[doc(hidden)]
    pub use crate::filter::scanning::{AllPages, Scanning};
    #[doc(hidden)]
    pub use crate::filter::together::{AllLists, COUNTS, Lent, Placed, TERMS};
    pub use crate::joint::{
        Archive, Archived, JointArchive, JointMovers, Movers, NoArchive, NoMovers, Tracked, joint_numbers,
    };
    pub use crate::map::component::Correction;
    pub use crate::map::{Dynamic, Feature, MapMemory, MapStorage, NoMoving, PAGE_LEN, Static};
    #[doc(hidden)]
    pub use crate::map::{Lists, Page, PageId, Row};
    pub use crate::particles::candidate::Candidate;
    #[doc(hidden)]
    pub use crate::particles::candidate::{PART, PartSums};
}

// What the files of the library import by its name alone.
pub(crate) use diagnostics::*;
pub(crate) use errors::*;
pub(crate) use models::*;
pub(crate) use numerics::*;
pub(crate) use settings::*;
pub(crate) use snapshot::{RestoreError, SaveError};
pub(crate) use storage::*;
#[cfg(test)]
use {locate::*, navigation::*, snapshot::*};
