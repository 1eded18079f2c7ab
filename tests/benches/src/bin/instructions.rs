//! Instructions of ten steps, each a motion and a scan, as callgrind counts them: `cargo xtask counts`. Without an argument it prints
//! the names of the cases, with a name it runs one.

use scphd_benches::cases::{CURVES, NAMED};
use scphd_benches::{Case, Input};
use std::hint::black_box;

/// Number of steps that are counted together.
const STEPS: usize = 10;

/// Cases of [`NAMED`].
const SCANS: [&str; 2] = ["rfs_slam_like", "gmphd_20_targets"];
/// Points of [`CURVES`].
const POINTS: [(&str, usize); 5] =
    [("map", 100), ("map", 10_000), ("measurements", 20), ("measurements", 200), ("clutter", 20)];

fn named(name: &str) -> Box<dyn Case> {
    let (_, case) = NAMED.iter().find(|(found, _)| *found == name).expect("a case of this name");
    case()
}

fn on_curve(name: &str, point: usize) -> Box<dyn Case> {
    let curve = CURVES.iter().find(|curve| curve.name == name).expect("a curve of this name");
    (curve.case)(point)
}

/// Callgrind counts in this function alone.
#[inline(never)]
fn counted_steps(case: &mut dyn Case, inputs: &[Input]) {
    case.play(black_box(inputs));
}

fn main() {
    let point_name = |(name, point): (&str, usize)| format!("{name}_{point}");
    let Some(wanted) = std::env::args().nth(1) else {
        SCANS.iter().for_each(|name| println!("{name}"));
        POINTS.iter().for_each(|&point| println!("{}", point_name(point)));
        return;
    };
    let point = POINTS.into_iter().find(|&point| point_name(point) == wanted);
    let mut case = point.map_or_else(|| named(&wanted), |(name, point)| on_curve(name, point));
    let inputs = case.record(STEPS);
    counted_steps(&mut *case, &inputs);
}
