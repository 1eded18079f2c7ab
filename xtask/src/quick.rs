//! `cargo xtask test` without `--all`: one check of every kind, in minutes.

use crate::steps::{Step, step};
use crate::{capi, firmware, python, unit};

/// Steps of the quick run, fastest first.
pub const STEPS: &[Step] = &[
    step(
        "libraries",
        "unit tests, closed forms and oracles of every library; filter and reference in lockstep; digests",
        |_| unit::quick(),
    ),
    step("examples", "the examples of the documentation compile and run", |_| unit::examples()),
    step("c", "C programs with the library on this machine", |_| capi::quick()),
    step("wheel", "the Python package: its wheel, its tests", |_| python::step(false)),
    step("board", "both filters on a Cortex-M7 in QEMU, with the host's digests", |_| firmware::robot()),
];
