//! From the bytes of a turning lidar to posts and reflectors, as range and bearing.
//!
//! [`Receiver`] finds the packets of an LD06 or LD19 in a stream of bytes and refuses those that are damaged; [`Assembler`] makes
//! revolutions of them; [`PostFinder`] finds what stands alone and is as thick as a post, or reflects as a reflector does. The
//! detections go to a filter with the noise and the probability that [`Resolution`] says of such posts.
//!
//! Angles of the lidar run clockwise, seen from above, from the arrow on its housing; all bearings here are the field's, rad to the
//! left. Every loop ends after as many rounds as there are points, and what there is no room for is counted.
//!
//! ```
//! use scphd_lidar::{Assembler, PostFinder, PostSettings, Receiver};
//!
//! // From the manual's example: an object 22 cm away, ahead on the left.
//! const BYTES: [u8; 47] = [
//!     0x54, 0x2c, 0x68, 0x08, 0xab, 0x7e, 0xe0, 0x00, 0xe4, 0xdc, 0x00, 0xe2, 0xd9, 0x00, 0xe5, 0xd5, 0x00, 0xe3, 0xd3, 0x00,
//!     0xe4, 0xd0, 0x00, 0xe9, 0xcd, 0x00, 0xe4, 0xca, 0x00, 0xe2, 0xc7, 0x00, 0xe9, 0xc5, 0x00, 0xe5, 0xc2, 0x00, 0xe5, 0xc0,
//!     0x00, 0xe5, 0xbe, 0x82, 0x3a, 0x1a, 0x50,
//! ];
//! let mut receiver = Receiver::new();
//! let mut assembler = Assembler::<1024>::new();
//! let finder = PostFinder::new(PostSettings::of_radius(0.05))?;
//! for byte in BYTES {
//!     if let Some(packet) = receiver.push(byte)
//!         && let Some(revolution) = assembler.push(&packet)
//!     {
//!         let found = finder.find::<32, _>(revolution);
//!         for post in &found.posts {
//!             let (_range, _bearing) = (post.range_m, post.bearing_rad);
//!         }
//!     }
//! }
//! assert_eq!((receiver.report().packets, receiver.report().damaged), (1, 0));
//! # Ok::<(), scphd_lidar::SettingsError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod assembler;
mod finder;
mod packet;
mod post;
mod receiver;
mod resolution;
mod settings;

pub use assembler::{Assembler, Revolution};
pub use finder::{Found, PostFinder};
pub use packet::{Packet, PacketError, Point, Reading};
pub use post::Post;
pub use receiver::{Receiver, ReceiverReport};
pub use resolution::Resolution;
pub use settings::{PostSettings, SettingsError};
