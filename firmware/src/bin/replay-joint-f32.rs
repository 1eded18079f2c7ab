//! Replays a planar vehicle's stream with a joint map, in single precision, and reports every scan.
#![no_std]
#![no_main]

scphd_firmware::replay_image!(scphd_firmware::joint::Joint, f32);
