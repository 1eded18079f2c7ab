//! Replays an underwater vehicle's stream with a joint map, in single precision, and reports every scan.
#![no_std]
#![no_main]

scphd_firmware::replay_image!(scphd_stream::underwater::UnderwaterJoint, f32);
