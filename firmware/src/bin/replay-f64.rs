//! Replays a planar vehicle's stream in double precision and reports every scan.
#![no_std]
#![no_main]

scphd_firmware::replay_image!(scphd_stream::planar::Planar, f64);
