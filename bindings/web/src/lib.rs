//! scphd in a web page: a simulated world, a filter in it, and a view of both as plain numbers; or a described filter alone.
//!
//! `session.rs` has the order of a scan: drive, measure, filter, view. `module.rs` has the functions that the page calls and all
//! `unsafe` code; everything else also runs, and is tested, on the host. `docs/web.md` describes how the page is built.
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
pub use filter::{Filter, PARTICLES, Refused};
pub use sensor::{MEASUREMENTS, Scan, Surroundings};
pub use session::Session;
pub use view::{HEAD, View};
pub use world::{INTERVAL_S, LANDMARKS, MOVERS, World};
