//! Definitions of the figures of `cargo xtask bench`.

/// Name and definition of every figure.
const DEFINITIONS: [&str; 9] = [
    "rfs_slam_like_scan_us: time of a scan on the host (here and below the median of criterion's samples), f32, one \
     thread: 200 particles of one sample, 50 landmarks, 9.8 measurements a scan, 37 components a particle, range and \
     bearing, known statistics; motion not included",
    "gmphd_20_targets_step_us: time of a scan on the host, f32, with the targets' motion: one particle whose pose is \
     known, 20 targets, 20 false measurements a scan, 100 to 140 components",
    "map_growth_ratio: time of a scan with a map of 10 000 features over that with 100, of which 20 are in view \
     either way; 32 x 2, 20 false measurements",
    "measurement_growth_ratio: time of a scan with 200 measurements over that with 20, of which 19 are of the 20 \
     features in view; 32 x 2, with room for the births of all to wait",
    "victoria_park_times_real_time: time from the first to the last scan of the log victoria_park over the time that \
     all its predictions, scans and estimated poses take, 100 particles, f32, one thread",
    "victoria_park_blind_times_real_time: the same by the blind proposal",
    "victoria_park_default_times_real_time: the same with the settings that follow from the log, which have 16 \
     particles",
    "threads_speedup: thesis-dynamic with 512 particles x 2, f32, first 40 scans: mean time of a scan on one thread \
     over that on all cores",
    "threads: the cores of the figure before",
];

/// Names of the figures, with their definitions.
pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    DEFINITIONS.iter().filter_map(|line| line.split_once(": "))
}

pub fn text() -> String {
    let lines = all().map(|(name, definition)| format!("  {name}\n      {definition}"));
    format!("Figures of `cargo xtask bench --json FILE`:\n{}", lines.collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_unique_and_in_the_text() {
        let names: BTreeSet<&str> = all().map(|(name, _)| name).collect();
        assert_eq!(names.len(), DEFINITIONS.len());
        assert!(names.iter().all(|name| text().contains(name)));
    }
}
