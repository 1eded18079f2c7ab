//! Replays an underwater vehicle's stream in single precision and reports every scan.
#![no_std]
#![no_main]

scphd_firmware::replay_image!(scphd_stream::underwater::Underwater, f32);
