//! Tests of the public interface of the sequencer.

mod bias;
mod extremes;
mod faults;
mod memory;
mod order;
mod smooth;
mod split;
mod underwater;
mod world;
