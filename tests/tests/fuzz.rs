//! More than a million operations with plausible and hostile numbers. Twenty million of all targets: `cargo xtask fuzz`.

use scphd_tests::fuzz::{self, Target, counts};
use scphd_tests::with_roomy_stack;
use std::collections::BTreeSet;

/// Runs this number of operations, from the first seed on, and requires that these outcomes occur.
fn sound(target: Target, operations: u64, outcomes: &[(&str, &str)]) {
    with_roomy_stack(|| {
        counts::take();
        match fuzz::run(target, operations, 1, &mut |_| ()) {
            Ok(done) => println!("{}: {} operations, the longest {:?}", target.name(), done.operations, done.longest),
            Err(failed) => panic!("{failed}"),
        }
        let counts = counts::take();
        let came_up: BTreeSet<(&str, &str)> = counts.keys().map(|(what, to)| (*what, to.as_str())).collect();
        for outcome in outcomes {
            assert!(came_up.contains(outcome), "{outcome:?} is missing of {counts:?}");
        }
    });
}

#[test]
fn whatever_is_asked_of_a_filter_it_stays_sound() {
    sound(
        Target::Mixture,
        1_000_000,
        &[
            ("scan", "ok"),
            ("scan", "NonFinite"),
            ("scan", "TooManyMeasurements"),
            ("predict", "Control"),
            ("predict", "TimeStep"),
            ("predict", "Implausible Jump"),
            ("load a map", "TooManyComponents"),
            ("load a map", "Tag"),
            ("observe", "NonFinite"),
            ("relocate", "Covariance"),
            ("restore", "ok"),
            ("restore", "Kind"),
            ("save", "NotStarted"),
            ("scrub", "ok"),
        ],
    );
}

#[test]
fn whatever_is_asked_of_a_joint_map_it_stays_sound() {
    sound(
        Target::Joint,
        300_000,
        &[
            ("scan", "ok"),
            ("scan", "NonFinite"),
            ("scan", "TooManyMeasurements"),
            ("scan of the other", "ok"),
            ("localise", "ok"),
            ("predict", "Implausible TurnRate"),
            ("load a map", "ok"),
            ("load a map", "TooManyComponents"),
            ("load a map", "Component"),
            ("configure", "ConfigError"),
            ("observe", "ok"),
            ("reset within", "Covariance"),
            ("restore", "ok"),
            ("restore", "Source SliceEnd"),
            ("scrub", "ok"),
        ],
    );
}

#[test]
fn whatever_a_locator_is_shown_it_is_not_sure_of_nonsense() {
    let outcomes =
        [("look", "ok"), ("look and find", "ok"), ("load a map", "Component"), ("load a map", "TooManyComponents")];
    sound(Target::Locator, 15_000, &outcomes);
}

#[test]
fn no_bytes_make_a_filter_unsound() {
    sound(
        Target::Snapshots,
        25_000,
        &[
            ("mixture", "ok"),
            ("mixture", "Version"),
            ("mixture", "Content"),
            ("mixture", "Damaged"),
            ("mixture", "NoRoom"),
            ("mixture", "Flawed Weights"),
            ("mixture", "Flawed Pages"),
            ("joint map", "ok"),
            ("joint map", "NoRoom"),
            ("joint map", "Flawed Component"),
            ("map", "Flawed Component"),
            ("navigator", "Flawed Pose"),
            ("mixture under water", "ok"),
        ],
    );
}

#[test]
fn no_stream_makes_a_replay_panic_or_lie() {
    sound(
        Target::Streams,
        6_000,
        &[
            ("replay", "ok"),
            ("replay", "Start Model ModelError"),
            ("record with snapshots", "ok"),
            ("replay what is left", "ok"),
            ("replay what is left", "Stream HeaderDamaged"),
            ("replay what is left", "Stream RecordDamaged"),
            ("replay what is left", "Stream Truncated"),
        ],
    );
}

/// Under water, the noise of the velocity filter is that of a header among the records; a replay from the next snapshot on has to
/// read it.
#[test]
fn sessions_that_failed_before_pass() {
    let failed = [(Target::Streams, 685, &[175][..]), (Target::Mixture, 10_072, &[102, 103, 110, 119, 120, 126])];
    for (target, session, operations) in failed {
        with_roomy_stack(move || {
            fuzz::replay(target, session, operations).unwrap_or_else(|failed| panic!("{failed}"));
        });
    }
}
