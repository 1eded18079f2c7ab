//! Snapshots in NOR flash: after a power failure at any time, a complete one is found.
//!
//! The flash is divided into banks, each with room for one snapshot. A new snapshot overwrites the oldest one; its head, with its
//! length and checksum, is written last. Without a valid head the content of a bank is ignored, because the content of a page is
//! undefined if its erasure was interrupted. The newest snapshot therefore remains until the next one is complete, and all banks
//! wear equally.
//!
//! The functions are `async`, like those of the flash. If the flash blocks during an operation, any executor that polls is
//! sufficient, and a filter can write to the flash and read from it without a buffer:
//!
//! ```
//! use embassy_futures::block_on;
//! use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
//! use scphd::{Config, ScPhd, memory};
//! use scphd_store::Store;
//! # mod flash {
//! #     include!("../tests/common/flash.rs");
//! # }
//! # use flash::Flash;
//!
//! memory! {
//!     type Memory: Unicycle<f32> { particles: 4, samples: 1, features { pages: 16, pages_per_map: 4, in_view: 32 } }
//! }
//! const KIND: u32 = 7;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut chip = Flash::new();
//! let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
//! let mut state = Box::new(Memory::new());
//! let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
//! slam.reset(PlanarPose::new(3.0, 0.0, 1.5), 1)?;
//!
//! // Four banks, all over the flash.
//! let mut store = Store::<_, 4>::new(&mut chip, 0..Flash::LEN)?;
//! let mut draft = block_on(store.begin())?;
//! slam.save(KIND, |bytes| block_on(draft.push(bytes)))?;
//! block_on(draft.commit())?;
//!
//! // After a brown-out.
//! let mut state = Box::new(Memory::new());
//! let mut restored = ScPhd::new(motion, Config::informed(4), &mut *state)?;
//! let mut store = Store::<_, 4>::new(&mut chip, 0..Flash::LEN)?;
//! let found = block_on(store.found())?;
//! let newest = found.newest().ok_or("there is none")?;
//! restored.restore(KIND, |at, into| block_on(store.read(newest, at, into)))?;
//! assert_eq!(restored.digest(), slam.digest());
//! # Ok(())
//! # }
//! ```
//!
//! A vehicle that must not wait saves to a buffer in RAM, and pushes that while it continues.
//!
//! No heap. The only panic is the one that the compiler generates for a future that is polled after its end.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod draft;
mod error;
mod found;
mod store;

pub use draft::Draft;
pub use error::StoreError;
pub use found::{Found, Snapshot};
pub use store::Store;
