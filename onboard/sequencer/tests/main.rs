//! The sequencer and what comes with it, by what a vehicle sees of them.

mod bias;
mod extremes;
mod faults;
mod memory;
mod order;
mod smooth;
mod split;
mod underwater;
mod world;
