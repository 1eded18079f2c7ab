//! scphd for a page: a simulated world, the filter in it, and what there is to see of both as plain numbers.
//!
//! A scan is read from top to bottom in `session.rs`: drive, measure, filter, view. `module.rs` has the functions that the page
//! calls and all `unsafe` code; the rest is the same on a desk, where it is tested. `docs/web.md` says how the page is made.
#![cfg_attr(not(test), no_std)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod drive;
mod world;

mod sensor;

mod filter;
mod view;

mod session;

#[cfg(all(feature = "module", not(test)))]
mod module;

pub use drive::Wish;
pub use filter::{PARTICLES, Refused};
pub use sensor::{MEASUREMENTS, Scan, Surroundings};
pub use session::Session;
pub use view::{HEAD, View};
pub use world::{INTERVAL_S, LANDMARKS, MOVERS, World};
