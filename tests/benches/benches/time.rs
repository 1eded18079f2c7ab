//! Time of a scan: the named cases and the curves, `cargo bench -p scphd-benches --bench time [NAME]`.

use criterion::{BenchmarkId, Criterion};
use scphd_benches::Case;
use scphd_benches::cases::{CURVES, NAMED};
use std::time::{Duration, Instant};

/// Measures scans only, without the motion before each and the generation of its measurements.
fn scans(case: &mut dyn Case, scans: u64) -> Duration {
    let mut time = Duration::ZERO;
    for _ in 0..scans {
        case.prepare();
        let started = Instant::now();
        case.scan();
        time += started.elapsed();
    }
    time
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .configure_from_args();
    let mut group = criterion.benchmark_group("scan");
    for (name, case) in NAMED {
        let mut made = None;
        group.bench_function(name, |bencher| {
            let case = made.get_or_insert_with(case);
            bencher.iter_custom(|iterations| scans(&mut **case, iterations));
        });
    }
    group.finish();
    for curve in CURVES {
        let mut group = criterion.benchmark_group(curve.name);
        for &point in curve.points {
            let mut made = None;
            group.bench_function(BenchmarkId::from_parameter(point), |bencher| {
                let case = made.get_or_insert_with(|| (curve.case)(point));
                bencher.iter_custom(|iterations| scans(&mut **case, iterations));
            });
        }
        group.finish();
    }
    criterion.final_summary();
}
