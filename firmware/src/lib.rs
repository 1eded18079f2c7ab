//! Code shared by the images: joint map, clock, stack paint, stream region, report, serial port.
#![no_std]

pub mod board;
pub mod clock;
pub mod images;
pub mod joint;
pub mod report;
pub mod uart;
