//! Joint maps: one Gaussian over the pose and all features, with their cross-covariances.
//!
//! A particle of a [`ScPhd`](crate::ScPhd) is a sample of the pose, and its map is a mixture whose features are independent given
//! the pose. With few particles, the correlations between features are therefore lost, and the covariance of the estimate is too
//! small. The joint Gaussian keeps the correlations. Data association is probabilistic: a measurement is associated with clutter,
//! births and the features in its gate, with probabilities that follow from its likelihood under each. Every feature has an
//! existence probability. `docs/joint.md` has the equations; `scan.rs` has the steps of a scan in order.

mod ambiguity;
mod archive;
#[cfg(test)]
mod archive_tests;
mod archiving;
mod associate;
mod associations;
mod conditioning;
mod config;
mod correct;
#[cfg(test)]
mod course;
mod covariance;
mod data_association;
mod difference;
mod existence;
mod filter;
mod hypotheses;
mod innovation_statistics;
mod invariant_error;
mod joint_filter;
mod landmark;
mod load;
mod localise;
mod loop_closure;
mod map_management;
mod movers;
#[cfg(test)]
mod movers_tests;
mod observe;
mod pending;
mod position_update;
mod reactivation;
mod relocate;
mod report;
mod rows;
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
pub use hypotheses::{HypothesesConfig, HypothesesScrubber, JointHypotheses, MoversOf, MultiHypothesisSlam};
pub use joint_filter::JointFilter;
pub use landmark::Landmark;
pub use movers::{JointMovers, Movers, NoMovers, Tracked};
pub use pending::{FeatureRows, Pending};
pub use report::JointReport;
pub use rows::{FeaturePass, FeatureTask, RowExecutor};
pub use state::JointState;
