//! What the images share: the joint map, the clock, the stack's paint, the place of the stream, the report, the serial port.
#![no_std]

pub mod board;
pub mod clock;
pub mod images;
pub mod joint;
pub mod report;
pub mod uart;
