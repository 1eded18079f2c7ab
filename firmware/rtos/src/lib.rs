//! What the images with an operating system share: the board's interrupts, timers and lights, what the sensors deliver, the
//! estimator, and what is counted.
//!
//! Three tasks: odometry arrives by a timer's interrupt, at the highest priority; a sensor's scans arrive at a lower one; the
//! estimator has the lowest, and either of the others interrupts it wherever it is. They hand over through bounded queues that
//! nobody waits for: where one is full, what came is lost and counted.
#![no_std]

pub mod device;
pub mod drive;
pub mod estimator;
pub mod leds;
pub mod tally;
pub mod timer;
