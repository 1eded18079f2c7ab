//! Joint maps: one Gaussian over the pose and all features, with everything that they have in common.
//!
//! The mixture of a [`ScPhd`](crate::ScPhd) particle takes its features for independent given the pose, and a particle is a
//! sample of the pose. Where few particles must do, what the features have in common is lost, and with it the
//! covariance of the estimate. Here it is kept. Association stays as soft as in the recursion: clutter, births and
//! all features in view share every measurement by its likelihood under each, and whether a feature is there is a probability.
//! `docs/joint.md` has the equations.

mod ambiguity;
mod archive;
mod archiving;
mod associate;
mod associations;
mod conditioning;
mod config;
mod correct;
mod covariance;
mod data_association;
mod difference;
mod existence;
mod filter;
mod innovation_statistics;
mod invariant_error;
#[cfg(test)]
mod laps_tests;
mod load;
mod localise;
mod loop_closure;
mod map_management;
mod movers;
#[cfg(test)]
mod movers_tests;
mod observe;
mod position_update;
mod reactivation;
mod relocate;
mod report;
mod scan;
mod scrub;
#[cfg(test)]
mod scrub_tests;
mod snapshot;
mod state;
#[cfg(test)]
mod tests;
mod track;
mod walk;
#[cfg(test)]
mod walker_tests;
#[cfg(test)]
mod window_tests;
#[cfg(any(test, feature = "flips"))]
mod words;

pub use archive::{Archive, Archived, JointArchive, NoArchive};
pub use config::JointConfig;
pub use covariance::joint_numbers;
pub use existence::Persistence;
pub use filter::JointSlam;
pub use movers::{JointMovers, Movers, NoMovers, Tracked};
pub use report::JointReport;
pub use state::JointState;
