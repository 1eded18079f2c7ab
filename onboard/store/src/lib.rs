//! Snapshots in NOR flash, of which a brown-out at any time leaves a whole one.
//!
//! The flash is divided into banks, each with room for a snapshot. A new one is written over the oldest, and its head, which says how
//! long it is and what its bytes sum up to, last. What has no such head is none, whatever else is in the bank: of a page whose erasing
//! was cut off, nothing is known. So the newest one stays until the next one is whole, and every bank is worn alike.
//!
//! The functions are `async`, as the flash's are. Where the flash does not let others work meanwhile, any executor that polls will do,
//! and a filter can write into the flash and read out of it without a buffer:
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
//! A vehicle that must not wait saves into a buffer in RAM, and pushes that while it goes on.
//!
//! No heap. Nothing panics but, as the compiler has it, a future that is polled after its end.
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
