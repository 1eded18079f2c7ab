//! Landmark SLAM in fixed memory: a filter with a joint map, and the single-cluster PHD filter.
//!
//! The filters estimate the pose of a vehicle and a map of the landmarks around it. Their inputs are odometry and detections; a
//! detection does not say which landmark caused it, and may be false (clutter). There are two filters:
//!
//! * [`JointSlam`], recommended: one Gaussian over the pose and all landmarks, with probabilistic data association and existence
//!   probabilities;
//! * [`ScPhd`], the filter of C. S. Lee's thesis (*SLAM using Single Cluster PHD Filters*, Girona 2014): particles for the vehicle
//!   (the parent process), and for every particle a Gaussian mixture for the map (the daughter process). The map is a random finite
//!   set, so that no data association is needed.
//!
//! It is written for vehicle computers:
//!
//! * `no_std`, no heap, no `unsafe`. All data is in one [`JointState`] or [`State`], whose size is known at compile time;
//! * no panics: invalid input returns an error and leaves the state unchanged. If a capacity is exhausted, data is discarded in a
//!   defined order, which the [`JointReport`] or [`ScanReport`] shows;
//! * the same inputs give the same bits on every machine ([`JointSlam::digest`]), so that a log of a vehicle can be replayed on a
//!   desk computer.
//!
//! # How to use it
//!
//! Choose the motion model ([`Motion`]), the tuning ([`JointConfig`]) and the capacities ([`joint_memory!`]), and construct a
//! [`JointSlam`] from them. Every sensor on the vehicle is a [`Detector`]: its models ([`Sensor`], [`FieldOfView`], [`Clutter`];
//! the crate has several of each), its mounting on the vehicle ([`Mounting`]) and the initiation of landmarks ([`Births`]). Call
//! [`predict`](JointSlam::predict) with every odometry sample, [`scan`](JointSlam::scan) with every scan of any detector, and
//! [`observe`](JointSlam::observe) with every measurement of the pose itself ([`Fix`]); read
//! [`estimate_pose`](JointSlam::estimate_pose) and the map. [`JointSlam`] has a complete example. A [`ScPhd`] is used in the same
//! way, with [`Config`] and [`memory!`]. `examples/` has a robot with two sensors and satellite fixes, and tracking.
//!
//! With one particle and [`KnownPose`] a [`ScPhd`] is a Gaussian-mixture PHD filter, which tracks objects from a known pose.
//!
//! # Structure of the source
//!
//! Every folder depends only on those above it:
//!
//! | folder | content |
//! |---|---|
//! | `numerics/` | scalars, vectors, symmetric matrices, random numbers, sums of logarithms |
//! | `map/` | Gaussian components, the copy-on-write pages that store them, working memory of an update, mixture reduction |
//! | `models/` | poses, motion models, sensors, fields of view, clutter, mountings, fixes |
//! | `report/` | errors, health, reports, probes |
//! | `settings/` | the tuning |
//! | `detection/` | a scan and the map of one particle: predicted detections, association, likelihood of the scan |
//! | `particles/` | candidate poses, prediction, proposals, resampling |
//! | `snapshot/` | the state as bytes |
//! | `filter/` | the memory, the steps and the queries of a [`ScPhd`] |
//! | `joint/` | the filter with a joint map |
//! | `fixes/` | monitors of rejected fixes: are the fixes wrong, or has the filter diverged? |
//! | `locate/` | global localisation in the map of an earlier drive |
//!
//! `joint/scan.rs` has a scan of a [`JointSlam`] from top to bottom, `filter/step.rs` one of a [`ScPhd`]: propose poses, weight,
//! resample, update, reduce. `docs/joint.md` and `docs/recursion.md` have the equations. `navigation/` estimates the velocity of an
//! underwater vehicle.
//!
//! # Features
//!
//! * `defmt`: `Format` for configuration, reports, health and errors.
//! * `embedded-hal`: `StagePins`, a probe of the stages over output pins.
//! * `flips`: [`ScPhd`] and [`JointSlam`] can flip a bit of their own state (`flip_bit`), to test memory faults on a board.
//!
//! # When memory runs short
//!
//! If the map of a [`ScPhd`] has too little memory for an update, the update first raises its pruning threshold in factors of four,
//! up to a weight of half a feature; then it leaves out the births; then it keeps the predicted map without the update. Confirmed
//! features are discarded last, and only if the working memory of one update (`VIEW`) is too small. The [`ScanReport`] counts each
//! of these steps, and each sets a flag in [`Health`].
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
pub use filter::scphd::ScPhd;
pub use filter::state::State;
pub use joint::{JointConfig, JointReport, JointSlam, JointState, MultiHypothesisSlam};
pub use map::component::Component;
pub use numerics::real::Real;
pub use report::health::Health;
pub use report::reports::{PredictReport, ScanReport};
pub use settings::config::Config;

/// Errors of the operations. An operation that returns an error leaves the state unchanged.
pub mod errors {
    pub use crate::report::any_error::Error;
    pub use crate::report::config_error::ConfigError;
    pub use crate::report::error::{
        Flaw, Implausible, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError,
    };
}

/// Probes of the stages of a scan, and memory scrubbing.
pub mod diagnostics {
    pub use crate::filter::scrub::{Scrubbed, Scrubber};
    pub use crate::joint::HypothesesScrubber;
    #[cfg(feature = "embedded-hal")]
    pub use crate::report::probe::StagePins;
    pub use crate::report::probe::{Probe, Stage};
    pub use crate::report::reports::Peak;
}

/// Types that appear in the expansion of [`memory!`] and [`joint_memory!`], what optional parts have in common, and executors for
/// several cores.
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
        Archive, Archived, JointArchive, JointFilter, JointHypotheses, JointMovers, Movers, MoversOf, NoArchive,
        NoMovers, Tracked, joint_numbers,
    };
    #[doc(hidden)]
    pub use crate::joint::{FeaturePass, FeatureRows, FeatureTask, Landmark, Pending, RowExecutor};
    pub use crate::map::component::Correction;
    pub use crate::map::{Dynamic, Feature, MapMemory, MapStorage, NoMoving, PAGE_LEN, Static};
    #[doc(hidden)]
    pub use crate::map::{Lists, Page, PageId, Row};
    pub use crate::particles::candidate::Candidate;
    #[doc(hidden)]
    pub use crate::particles::candidate::{PART, PartSums};
    #[doc(hidden)]
    pub use crate::particles::propose::Family;
}

// Names that the files of the library import from the root of the crate.
pub(crate) use diagnostics::*;
pub(crate) use errors::*;
pub(crate) use fixes::FixReport;
pub(crate) use models::*;
pub(crate) use numerics::*;
pub(crate) use settings::*;
pub(crate) use snapshot::{RestoreError, SaveError};
pub(crate) use storage::*;
#[cfg(test)]
use {locate::*, navigation::*, snapshot::*};
