//! `cargo xtask test` without `--all`: one check of every kind, in minutes.

use crate::capi;
use crate::firmware;
use crate::python;
use crate::steps::Step;
use crate::unit;

/// Steps of the quick run, fastest first.
pub const STEPS: &[Step] = &[
    Step {
        name: "libraries",
        what: "unit tests, closed forms and oracles of every library; filter and reference in lockstep; digests",
        run: |_| unit::quick(),
    },
    Step { name: "examples", what: "the examples of the documentation compile and run", run: |_| unit::examples() },
    Step { name: "c", what: "C programs with the library on this machine", run: |_| capi::quick() },
    Step { name: "wheel", what: "the Python package: its wheel, its tests", run: |_| python::step(false) },
    Step {
        name: "board",
        what: "both filters on a Cortex-M7 in QEMU, with the host's digests",
        run: |_| firmware::robot(),
    },
];
