//! Single-cluster PHD SLAM in fixed memory.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
