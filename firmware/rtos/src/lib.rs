//! Code of the images with an operating system: interrupts, timers and lights of the board, simulated instruments, the estimator,
//! and counters.
//!
//! There are three tasks: odometry arrives in a timer's interrupt at the highest priority, scans of a sensor at a lower one; the
//! estimator has the lowest, and both others preempt it. Inputs pass through bounded queues without waiting: if a queue is full,
//! the input is lost and counted.
#![no_std]

pub mod device;
pub mod drive;
pub mod estimator;
pub mod leds;
pub mod tally;
pub mod timer;
