//! Tests of streams, black boxes and links of the vehicle's filter, and of whole runs of the simulator.

mod black_box;
mod flips;
mod flown_box;
mod link;
mod logs;
mod stream;
mod twelve_kinds;
mod twelve_logs;
mod worn_wheels;
