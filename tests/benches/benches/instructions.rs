//! Instructions of ten steps, each a motion and a scan, as callgrind counts them:
//! `cargo bench -p scphd-benches --bench instructions`; needs valgrind and gungraun-runner.

// For the code of the macros, which cannot be changed here.
#![allow(unused_qualifications, missing_debug_implementations)]

use gungraun::{library_benchmark, library_benchmark_group, main};
use scphd_benches::cases::{CURVES, NAMED};
use scphd_benches::{Case, Input};
use std::hint::black_box;

/// Number of steps that are counted together.
const STEPS: usize = 10;

type Prepared = (Box<dyn Case>, Vec<Input>);

fn prepared(mut case: Box<dyn Case>) -> Prepared {
    let inputs = case.record(STEPS);
    (case, inputs)
}

fn named(name: &str) -> Prepared {
    let (_, case) = NAMED.iter().find(|(found, _)| *found == name).expect("a case of this name");
    prepared(case())
}

fn on_curve(name: &str, point: usize) -> Prepared {
    let curve = CURVES.iter().find(|curve| curve.name == name).expect("a curve of this name");
    prepared((curve.case)(point))
}

#[library_benchmark]
#[bench::rfs_slam_like(named("rfs_slam_like"))]
#[bench::gmphd_20_targets(named("gmphd_20_targets"))]
#[bench::map_100(on_curve("map", 100))]
#[bench::map_10000(on_curve("map", 10_000))]
#[bench::measurements_20(on_curve("measurements", 20))]
#[bench::measurements_200(on_curve("measurements", 200))]
#[bench::waiting_20(on_curve("waiting", 20))]
#[bench::waiting_200(on_curve("waiting", 200))]
#[bench::clutter_20(on_curve("clutter", 20))]
fn steps((mut case, inputs): Prepared) -> Prepared {
    case.play(black_box(&inputs));
    // Returned, so that freeing them is not counted.
    (case, inputs)
}

library_benchmark_group!(name = scans, benchmarks = steps);
main!(library_benchmark_groups = scans);
