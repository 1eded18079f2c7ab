//! Streams, black boxes and links of the filter on board, and whole runs of the simulator.

mod black_box;
mod flips;
mod link;
mod logs;
mod stream;
mod worn_wheels;
