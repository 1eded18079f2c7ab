//! The table of `docs/languages.md`: every mark stands for an existing test of that feature through that interface.

use std::fs;
use std::path::Path;

const INTERFACES: [&str; 5] = ["Rust", "C", "Python", "streams", "simulator"];

const VEHICLE: &str = "onboard/vehicle/tests/assembled.rs";
const C: &str = "bindings/capi/tests/c/replay.c";
const C_SERVICES: &str = "bindings/capi/tests/c/all_that_a_filter_can.c";
const PYTHON: &str = "bindings/python/tests/test_filters.py";
const PYTHON_JOINT: &str = "bindings/python/tests/test_joint.py";
const PYTHON_DIGESTS: &str = "bindings/python/tests/test_digests.py";
const BLACK_BOX: &str = "tests/tests/black_box.rs";
const MIXTURE: &str = "tests/lockstep/mixture.rs";
const JOINT: &str = "tests/lockstep/joint.rs";
const LOGS: &str = "tests/tests/twelve_logs.rs";
const SEVERAL: &str = "host-sim/run/src/session/several.rs";
const MAPS: &str = "host-sim/tests/program/maps.rs";
const UNDER_WATER: &str = "host-sim/run/src/compare/underwater.rs";

/// A test: its file and its name.
type Test = (&'static str, &'static str);
/// A vehicle that records what its filter gets, with every optional part of a joint map except several hypotheses.
const STREAM: &str = "tests/tests/stream.rs";
const FLOWN: Test = ("tests/tests/flown_box.rs", "a_strict_map_with_tracks_archive_and_watch_replays_as_it_flew");
/// No such feature.
const NO: Test = ("", "");

const FEATURES: [(&str, [Test; 5]); 23] = [
    (
        "`JointSlam`, in the plane",
        [
            (VEHICLE, "a_joint_map"),
            (C, "start_filters"),
            (PYTHON_DIGESTS, "test_eleven_filters_over_300_scans"),
            (BLACK_BOX, "cut_at_every_50th_scan_the_joint_map_ends_alike"),
            (JOINT, "survey_in_single_precision"),
        ],
    ),
    (
        "its moving-object tracks",
        [
            (VEHICLE, "a_joint_map_with_movers"),
            (C_SERVICES, "movers"),
            (PYTHON_JOINT, "test_features_that_move"),
            (BLACK_BOX, "cut_at_every_50th_scan_tracks_and_hypotheses_end_alike"),
            (JOINT, "what_moves"),
        ],
    ),
    (
        "its odometry calibration",
        [
            (VEHICLE, "a_joint_map_that_learns_its_odometry"),
            (C_SERVICES, "learning"),
            (PYTHON_JOINT, "test_learnt_odometry"),
            (STREAM, "calibrated_odometry_ends_where_the_session_ends"),
            ("host-sim/tests/program/cli.rs", "a_log_gets_a_joint_map_where_nothing_asks_for_what_it_has_not"),
        ],
    ),
    (
        "its archive of submaps",
        [
            ("core/src/joint/window_tests.rs", "a_window_of_forty_is_consistent_over_three_rounds"),
            (C_SERVICES, "movers"),
            (PYTHON_JOINT, "test_an_archive_keeps_what_the_window_cannot"),
            FLOWN,
            NO,
        ],
    ),
    (
        "its several hypotheses",
        [
            (VEHICLE, "a_joint_map_with_several_hypotheses"),
            (C, "start_filters"),
            (PYTHON_DIGESTS, "test_eleven_filters_over_300_scans"),
            (BLACK_BOX, "cut_at_every_50th_scan_tracks_and_hypotheses_end_alike"),
            (LOGS, "nine_filters_of_the_drive_run_in_the_simulator"),
        ],
    ),
    (
        "`ScPhd`, in the plane",
        [
            (VEHICLE, "a_mixture"),
            (C, "start_filters"),
            (PYTHON_DIGESTS, "test_eleven_filters_over_300_scans"),
            (BLACK_BOX, "cut_at_every_50th_scan_the_mixture_ends_alike"),
            (MIXTURE, "survey_in_single_precision"),
        ],
    ),
    (
        "its moving features",
        [
            ("core/tests/filter/movers.rs", "what_moves_and_what_stands_are_told_apart_and_keep_their_names"),
            (C, "start_filters"),
            (PYTHON, "test_a_tracker"),
            (BLACK_BOX, "cut_at_every_50th_scan_the_mixture_ends_alike"),
            (MIXTURE, "moving_features"),
        ],
    ),
    (
        "underwater vehicle",
        [
            ("core/tests/filter/in_space.rs", "a_blind_filter_maps_a_floor_in_space"),
            (C, "start_filters"),
            NO,
            (BLACK_BOX, "a_dive_ends_alike_from_every_snapshot"),
            (UNDER_WATER, "every_step_agrees_with_the_reference_to_a_thousand_millionth"),
        ],
    ),
    (
        "vehicle with sideways speed",
        [
            ("core/src/models/holonomic.rs", "without_a_speed_to_the_side_it_is_a_unicycle"),
            (C_SERVICES, "watch"),
            (PYTHON, "test_a_vehicle_that_moves_sideways"),
            (STREAM, "a_vehicle_with_sideways_speed_ends_where_the_session_ends"),
            ("host-sim/log/src/vehicle.rs", "a_holonomic_vehicle_goes_any_way_while_it_turns"),
        ],
    ),
    (
        "several sensors, each with its mounting",
        [
            (VEHICLE, "a_mixture"),
            (C, "describe_sensors"),
            (PYTHON, "test_two_detectors_and_their_seats"),
            (BLACK_BOX, "several_sensors_and_fixes_end_where_the_session_ends"),
            (SEVERAL, "two_half_views_estimate_what_the_full_view_does"),
        ],
    ),
    (
        "bearings",
        [
            ("core/src/models/bearing_only.rs", "bearings_from_many_places_make_a_map"),
            (C, "describe_camera"),
            (PYTHON_DIGESTS, "take"),
            NO,
            NO,
        ],
    ),
    (
        "stereo camera",
        [
            ("core/tests/filter/in_space.rs", "a_blind_filter_maps_a_floor_in_space"),
            NO,
            NO,
            (BLACK_BOX, "a_dive_ends_alike_from_every_snapshot"),
            (UNDER_WATER, "every_step_of_the_joint_filter_agrees_too"),
        ],
    ),
    (
        "position and heading fixes",
        [
            ("core/tests/filter/observing.rs", "a_joint_map_learns_of_a_fix"),
            (C, "take"),
            (PYTHON, "test_fixes"),
            (BLACK_BOX, "several_sensors_and_fixes_end_where_the_session_ends"),
            (SEVERAL, "fixes_are_counted_and_one_far_off_is_left_out"),
        ],
    ),
    (
        "watch over fixes",
        [
            (VEHICLE, "a_watch_moves_a_vehicle_that_is_elsewhere"),
            (C_SERVICES, "watch"),
            (PYTHON_JOINT, "test_a_watch_moves_a_filter_that_is_wrong"),
            FLOWN,
            (SEVERAL, "a_filter_that_is_wrong_is_put_to_fixes_that_agree_and_only_if_it_may_be"),
        ],
    ),
    (
        "relocate and scatter",
        [
            ("core/tests/lost/reports.rs", "a_joint_map"),
            (C_SERVICES, "maps_and_snapshots"),
            (PYTHON_JOINT, "test_what_to_do_when_lost"),
            (BLACK_BOX, "every_input_that_changes_the_state_is_replayed"),
            (SEVERAL, "a_filter_that_is_wrong_is_put_to_fixes_that_agree_and_only_if_it_may_be"),
        ],
    ),
    (
        "map of an earlier drive",
        [
            ("core/tests/lost/reports.rs", "a_surveyed_map_is_known_at_once"),
            (C_SERVICES, "maps_and_snapshots"),
            (PYTHON_JOINT, "test_the_map_of_an_earlier_drive"),
            (BLACK_BOX, "every_input_that_changes_the_state_is_replayed"),
            (MAPS, "a_second_drive_finds_itself_in_the_map_of_the_first"),
        ],
    ),
    (
        "search of the pose in it",
        [
            ("core/src/locate/tests/trials.rs", "a_second_drive_finds_its_place"),
            NO,
            NO,
            NO,
            (MAPS, "a_second_drive_finds_itself_in_the_map_of_the_first"),
        ],
    ),
    (
        "snapshots",
        [
            (VEHICLE, "a_snapshot_goes_on_to_the_bit_with_movers_and_an_archive"),
            (C_SERVICES, "maps_and_snapshots"),
            (PYTHON_DIGESTS, "test_from_snapshots_in_fresh_filters"),
            (BLACK_BOX, "cut_at_every_50th_scan_the_joint_map_ends_alike"),
            NO,
        ],
    ),
    (
        "double precision",
        [
            ("core/src/joint/tests.rs", "both_precisions_agree_and_a_full_state_goes_on"),
            NO,
            (PYTHON_JOINT, "test_double_precision"),
            (BLACK_BOX, "cut_at_every_50th_scan_the_joint_map_ends_alike"),
            (JOINT, "survey_in_double_precision"),
        ],
    ),
    (
        "noise that grows with the range",
        [
            (VEHICLE, "noise_that_grows_with_the_range"),
            (C, "describe_sensors"),
            (PYTHON_DIGESTS, "test_eleven_filters_over_300_scans"),
            (STREAM, "noise_that_grows_with_the_range_ends_where_the_session_ends"),
            (JOINT, "noise_that_grows_with_the_range"),
        ],
    ),
    (
        "noise of each measurement",
        [("core/tests/varying_noise.rs", "what_a_driver_reports_with_each_measurement_counts"), NO, NO, NO, NO],
    ),
    (
        "3-D sonar",
        [
            ("core/src/models/sonar.rs", "derivatives_agree_with_differences_and_the_inverse_inverts"),
            (C, "start_filters"),
            NO,
            NO,
            NO,
        ],
    ),
    ("your own models", [("tests/documents/src/guide.rs", "OwnModels"), NO, NO, NO, NO]),
];

#[test]
fn every_mark_of_the_table_has_a_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (feature, tests) in FEATURES {
        for ((file, name), interface) in tests.into_iter().zip(INTERFACES).filter(|&(test, _)| test != NO) {
            let text = fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
            let defines = ["fn ", "def ", "void "].iter().any(|word| text.contains(&format!("{word}{name}(")))
                || text.contains(&format!("struct {name};"));
            assert!(defines, "{feature} in {interface}: {file} has no test {name}");
        }
    }
}

#[test]
fn the_page_has_this_table() {
    let mut table = format!("|feature|{}|\n|---|{}\n", INTERFACES.join("|"), ":-:|".repeat(INTERFACES.len()));
    for (feature, tests) in FEATURES {
        let marks = tests.map(|test| if test == NO { "" } else { "✓" });
        table.push_str(&format!("|{feature}|{}|\n", marks.join("|")));
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/languages.md");
    let text = fs::read_to_string(page).unwrap();
    let reasons = text.split_once(&table).map(|(_, reasons)| reasons);
    let reasons = reasons.unwrap_or_else(|| panic!("docs/languages.md should have this table:\n{table}"));
    for (feature, _) in FEATURES.iter().filter(|(_, tests)| tests.contains(&NO)) {
        assert!(reasons.contains(feature), "no reason why a cell is empty: {feature}");
    }
}
