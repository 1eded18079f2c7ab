//! Detects posts and reflectors, as range and bearing, in a planar laser scan or in the bytes of a rotating lidar.
//!
//! [`PostFinder`] finds in a [`Scan`] isolated objects with the width of a post or the intensity of a reflector. A filter gets
//! the detections, with the noise and the probability of detection that [`Resolution`] computes for such posts. A [`LaserScan`]
//! is a scan of ranges with a constant angle between beams. [`Receiver`] finds the packets of an LD06 or LD19 in a stream of
//! bytes and rejects damaged ones; [`Assembler`] assembles them to revolutions, which are scans too.
//!
//! Angles of an LD06 are clockwise, seen from above, from the arrow on its housing; all bearings here are in rad to the left.
//! Every loop is bounded by the number of beams, and data without room is counted.
//!
//! ```
//! use scphd_lidar::{LaserScan, PostFinder, PostSettings, Sweep};
//!
//! // 270° from the right to the left in 25 ms, a beam every quarter of a degree; a post on the left, 3 m away.
//! let step = 0.25_f32.to_radians();
//! let sweep = Sweep { start_rad: -540.0 * step, increment_rad: step, range_min_m: 0.05, range_max_m: 30.0, duration_s: 0.025 };
//! let mut ranges = [f32::INFINITY; 1081];
//! ranges[896..=904].fill(2.91);
//! let finder = PostFinder::new(PostSettings::of_radius(0.06))?;
//! let found = finder.find::<32, _>(&LaserScan::new(sweep, &ranges, &[])?);
//! assert!((found.posts[0].bearing_rad.to_degrees() - 90.0).abs() < 0.1 && (found.posts[0].range_m - 2.96).abs() < 0.02);
//! # Ok::<(), scphd_lidar::SettingsError>(())
//! ```
//!
//! Bytes of an LD06:
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
mod laser_scan;
mod packet;
mod post;
mod receiver;
mod resolution;
mod scan;
mod settings;

pub use assembler::{Assembler, Revolution};
pub use finder::{Found, PostFinder};
pub use laser_scan::{LaserScan, Sweep};
pub use packet::{Packet, PacketError, Point, Reading};
pub use post::Post;
pub use receiver::{Receiver, ReceiverReport};
pub use resolution::Resolution;
pub use scan::{Beam, Scan};
pub use settings::{PostSettings, SettingsError};
