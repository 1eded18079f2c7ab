//! Single-cluster PHD SLAM in fixed memory.
//!
//! Where is the vehicle, and what is around it? This crate answers with the single-cluster PHD filter of C. S. Lee's
//! thesis (*SLAM using Single Cluster PHD Filters*, Girona 2014): particles for the vehicle (the parent process), and
//! for every particle a Gaussian mixture for the map (the daughter process). Features are a random finite set: there is
//! no data association to get wrong, and clutter and missed detections are part of the model.
//!
//! It is written for vehicle computers:
//!
//! * `no_std`, no heap, no `unsafe`. Everything lives in one [`State`], whose size is known before the build;
//! * nothing panics: bad input is an error that leaves the state as it was, want of room is handled in a defined order
//!   and reported in the [`ScanReport`];
//! * the same inputs give the same bits on every machine ([`ScPhd::digest`]): a vehicle's log replays on a desk.
//!
//! # How to use it
//!
//! Choose how the vehicle moves ([`Motion`]), a tuning ([`Config`]) and capacities ([`memory!`]), and put a [`ScPhd`] over them. Every
//! sensor on the vehicle is a [`Detector`]: its models ([`Sensor`], [`FieldOfView`], [`Clutter`]; some come with the crate), where it
//! sits ([`Mounting`]) and what it gives birth to. Then [`predict`](ScPhd::predict) with every odometry sample,
//! [`scan`](ScPhd::scan) with every scan of any detector, [`observe`](ScPhd::observe) with every measurement of the pose itself ([`Fix`]),
//! and read [`estimate_pose`](ScPhd::estimate_pose) and [`estimate_map`](ScPhd::estimate_map). [`ScPhd`] has a complete example, and
//! `examples/` has a robot with a lidar, two radars on a car, satellite fixes, and tracking.
//!
//! With one particle and [`KnownPose`] it is a Gaussian-mixture PHD filter for tracking from a known place.
//!
//! # Where things are
//!
//! One scan, from top to bottom, is `step.rs`: propose poses (`propose.rs`), weigh (`weigh.rs`, over the map as one pose sees it,
//! `view.rs`, on as many cores as `executor.rs` has), select (`select.rs`, `resample.rs`; as many as needed, `adaptive.rs`, and set apart, `rejuvenate.rs`), learn
//! (`online.rs`), update (`update.rs`), reduce (`reduce.rs`). `predict.rs` comes before it, `extract.rs`
//! after it. `map/` holds the copy-on-write pages, `models/` the models. The recursion with all its choices is written
//! out in `docs/recursion.md`.
//!
//! # Features
//!
//! * `adaptive`: regularised resampling, an adapted number of particles, p_D and clutter learnt while running
//!   ([`Config::regularisation`], [`Config::adaptive`], [`Detector::learning`]). Without it they are refused, and take no flash.
//! * `defmt`: `Format` for configuration, reports, health and errors.
//! * `embedded-hal`: `StagePins`, a probe of the stages over output pins.
//! * `multi-feature`: the likelihood of RB-PHD SLAM with several features, `Likelihood::MultiFeature`, a yardstick for studies.
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

mod adaptive;
#[cfg(test)]
mod alone;
mod angle;
mod audit;
mod bounds;
mod candidate;
mod component;
mod config;
mod confirmed;
mod detector;
mod digest;
mod drift;
mod error;
mod executor;
mod expected_map;
mod extract;
#[cfg(test)]
mod faults;
mod filter;
mod health;
#[cfg(test)]
mod in_space;
#[cfg(test)]
mod informed;
mod joint;
mod likelihood;
#[cfg(test)]
mod linear;
mod ln_sum;
#[cfg(test)]
mod lying;
mod map;
mod memory;
#[cfg(all(test, feature = "adaptive"))]
mod mismatch;
mod models;
#[cfg(test)]
mod movers;
#[cfg(feature = "multi-feature")]
mod multi_feature;
mod navigation;
mod neighbours;
mod noise;
mod observe;
#[cfg(test)]
mod observing;
mod online;
#[cfg(test)]
mod oracles;
mod plausible;
mod predict;
mod probe;
mod propose;
mod real;
mod reduce;
mod rejuvenate;
mod relocate;
mod report;
mod resample;
mod scan;
mod select;
mod single;
#[cfg(test)]
mod smallest;
mod sort;
mod state;
mod step;
mod symmetric;
#[cfg(test)]
mod taken_over;
mod tally;
#[cfg(test)]
mod unconfirmed;
mod update;
mod vector;
mod view;
mod weigh;
mod work;
mod workspace;

pub use adaptive::Adaptive;
pub use angle::wrap;
pub use audit::Flaw;
pub use bounds::Bounds;
pub use candidate::Candidate;
pub use component::{Component, Correction};
pub use config::{Config, ConfigError, Extraction, MovingConfig};
pub use detector::{Births, Detector, DetectorMemory, ScanRoom};
pub use error::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
pub use executor::{Executor, Serial};
pub use extract::{MapEstimate, PoseEstimate};
pub use filter::ScPhd;
pub use health::Health;
pub use joint::{JointConfig, JointReport, JointSlam, JointState, Persistence, joint_numbers};
pub use likelihood::Likelihood;
pub use ln_sum::LnSum;
pub use map::{Dynamic, Feature, MapMemory, MapStorage, NoMoving, PAGE_LEN, Static};
pub use models::*;
/// The linear algebra that the interface is written in.
pub use nalgebra;
pub use navigation::{DeadReckoning, Instruments, Navigator, Outcome, VelocityFilter, VelocityNoise};
pub use noise::Noise;
pub use observe::FixReport;
pub use online::Online;
pub use plausible::{Implausible, Plausible, Rates};
#[cfg(feature = "embedded-hal")]
pub use probe::StagePins;
#[cfg(feature = "defmt")]
pub use probe::StageTrace;
pub use probe::{Probe, Stage};
pub use propose::{Informed, Proposal};
pub use real::Real;
pub use reduce::Reduction;
pub use report::{PredictReport, ScanReport};
pub use state::State;
pub use symmetric::{Factor, Symmetric};
pub use vector::{Array, Linear, Matrix, Place, Vector, Zero};
