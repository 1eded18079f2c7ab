//! Ordering of time-stamped inputs before a filter, and an odometry pose without jumps behind it.
//!
//! A filter such as [`ScPhd`](scphd::ScPhd) or [`JointSlam`](scphd::JointSlam) needs its inputs in the order of their
//! measurement. On a vehicle they arrive in another order: a radar needs more computing time than a lidar, a bus delays, a
//! receiver repeats messages. The [`Sequencer`] accepts inputs in any order within a window, and outputs them in the order of
//! their time stamps, with the predictions between them: the filter has the same digest for any order of arrival. Inputs that are
//! too late, missing, duplicate, or from a clock that jumps or stands still raise a [flag](Flags) and are counted.
//!
//! A corrected pose jumps with every correction. [`SmoothOdometry`] provides a pose without jumps, for controllers, and its
//! transformation to the map, for planners. [`OdometryWatch`] detects from the corrections that odometry has a bias: wheels that
//! slip, a gyroscope with an offset.
//!
//! No heap, no panics, and every loop is bounded by the capacity for queued inputs. Times are integers in nanoseconds in a `u64`;
//! an [`Interval`] is converted to seconds once.
//!
//! ```
//! use heapless::Vec;
//! use scphd::numerics::nalgebra::Vector2;
//! use scphd::models::{
//!     ControlNoise, PlanarPose, PositionFix, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
//! };
//! use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, memory};
//! use scphd_sequencer::{Action, Sequencer, Settings, Stamp};
//!
//! /// All inputs of this vehicle except odometry.
//! enum Event {
//!     Lidar(Vec<Vector2<f32>, 32>),
//!     Gps(Vector2<f32>),
//! }
//! const WHEELS: u8 = 0;
//! const LIDAR: u8 = 1;
//! const GPS: u8 = 2;
//!
//! memory! {
//!     type Memory: Unicycle<f32> { particles: 4, samples: 1, features { pages: 64, pages_per_map: 16, in_view: 256 } }
//! }
//! # let (mut state, mut scratch) = (Box::new(Memory::new()), DetectorMemory::<Vector2<f32>, 32>::new());
//! # let window = RangeBearingWindow::full_circle(12.0, 0.9)?;
//! # let sensing = Sensing::range_bearing([0.1, 0.01], window, 2.0)?;
//! # let mut lidar = Detector::new(sensing, Births::of_static(0.002))?.over(&mut scratch)?;
//! # let gps = PositionFix::new(0.5)?;
//! # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
//! # let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
//! // On a vehicle it is a static, as the memories of the filter are: room for 16 controls and 8 events.
//! let mut sequencer = Sequencer::<UnicycleControl<f32>, Event, 16, 8>::new();
//! let (start_ns, standing) = (5_000_000_000, UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 });
//! slam.reset(PlanarPose::new(0.0, 0.0, 0.0), 1)?;
//! sequencer.start(Settings::DEFAULT, start_ns, standing)?;
//!
//! // Wherever inputs arrive:
//! sequencer.push_event(Stamp::new(GPS, start_ns + 200_000_000), Event::Gps(Vector2::new(0.1, 0.0)))?;
//! let driving = UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 };
//! sequencer.push_control(Stamp::new(WHEELS, start_ns + 100_000_000), driving)?;
//! let scan = Vec::from_slice(&[Vector2::new(5.0, 0.3)])?;
//! sequencer.push_event(Stamp::new(LIDAR, start_ns + 150_000_000), Event::Lidar(scan))?;
//!
//! // In the loop of the filter:
//! sequencer.tick(start_ns + 500_000_000);
//! while let Some(action) = sequencer.next_action() {
//!     match action {
//!         Action::Predict { control, dt } => {
//!             slam.predict(&control, dt.seconds())?;
//!         }
//!         // No odometry arrives. The vehicle must react; docs/time.md has advice.
//!         Action::Gap { control, dt } => {
//!             slam.predict(&control, dt.seconds())?;
//!         }
//!         Action::Event(Event::Lidar(scan)) => {
//!             slam.scan(&mut lidar, scan)?;
//!         }
//!         Action::Event(Event::Gps(position)) => {
//!             slam.observe(&gps, position)?;
//!         }
//!     }
//! }
//! assert!(sequencer.report().flags.is_empty());
//! assert_eq!(sequencer.time_ns(), start_ns + 200_000_000);
//! assert!((slam.estimate_pose().ok_or("not started")?.mean.x_m - 0.1).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod ahead;
mod odometry;
mod odometry_watch;
mod queue;
mod report;
mod sequencer;
mod settings;
mod stamp;
mod timeline;

pub use ahead::Ahead;
pub use odometry::{Correction, MapFromOdom, SmoothOdometry};
pub use odometry_watch::{OdometryBias, OdometryWatch};
pub use report::{Flags, PushError, Report};
pub use sequencer::{Action, Sequencer};
pub use settings::{Settings, SettingsError};
pub use stamp::{Interval, Stamp};
