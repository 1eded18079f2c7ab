//! The order of arrival has no effect.

use crate::world::{Input, MS, Outcome, SETTINGS, STANDING, START_NS, STEPS, filtered, log, sequenced, truth_at};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scphd::models::Pose;
use scphd_sequencer::{Action, Flags, Interval, PushError, Sequencer, Stamp};

/// Offsets of lidar, radar and satellite receiver from the wheels, ms; lidar and receiver are simultaneous.
const PHASES_MS: [u64; 3] = [37, 61, 37];
const INPUTS: usize = 150 + 75 + 50 + 15;

/// The log in the order of arrival with these delays.
fn delayed(delays: &[u64], with_clock: bool) -> Vec<(Option<u64>, Stamp, Input)> {
    let since_start = |stamp: &Stamp| stamp.time_ns.wrapping_sub(START_NS);
    let mut arrivals: Vec<_> = log(PHASES_MS)
        .into_iter()
        .zip(delays)
        .map(|((stamp, input), delay)| (since_start(&stamp) + delay, stamp, input))
        .collect();
    arrivals.sort_by_key(|(at, ..)| *at);
    let clock = |at| with_clock.then_some(START_NS.wrapping_add(at));
    arrivals.into_iter().map(|(at, stamp, input)| (clock(at), stamp, input)).collect()
}

/// A fixed seed, so that failures are reproducible.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(18), ..ProptestConfig::default() }
}

#[test]
fn a_hundred_orders_of_arrival_have_one_digest() {
    let (in_order, report) = sequenced(&delayed(&[0; INPUTS], false));
    assert!(report.flags.is_empty(), "{report:?}");
    // The true pose at the last scan of the log.
    let end = truth_at((STEPS - 1) * 100 + 37);
    assert!(in_order.pose.distance_m(&end) < 0.15, "{:?} {end:?}", in_order.pose);
    proptest!(config(100), |(delays in vec(0..=SETTINGS.window_ns, INPUTS), with_clock: bool)| {
        let (outcome, report) = sequenced(&delayed(&delays, with_clock));
        prop_assert!(report.flags.is_empty(), "{report:?}");
        prop_assert_eq!(&outcome, &in_order);
    });
}

/// The log processed by a loop in its own order.
fn by_hand(log: &[(Stamp, Input)]) -> Outcome {
    filtered(|filters| {
        let (mut held, mut time_ns) = (STANDING, START_NS);
        for (stamp, input) in log {
            let passed_ns = stamp.time_ns.wrapping_sub(time_ns);
            if passed_ns > 0 {
                filters.predict(&held, Interval::of_ns(passed_ns).seconds());
            }
            time_ns = stamp.time_ns;
            match input {
                Input::Control(control) => held = *control,
                Input::Event(event) => filters.event(event),
            }
        }
    })
}

/// Predictions are split at the times of scans; and the order of two events at the same time matters to the filters.
#[test]
fn predictions_are_split_at_the_scans_and_ties_have_an_order() {
    let (in_order, _) = sequenced(&delayed(&[0; INPUTS], false));
    let mut log = log(PHASES_MS);
    assert_eq!(by_hand(&log), in_order);
    let tie = log.windows(2).position(|two| two[0].0.time_ns == two[1].0.time_ns).unwrap();
    log.swap(tie, tie + 1);
    assert_ne!(by_hand(&log).digests, in_order.digests);
    let swapped: Vec<_> = log.into_iter().map(|(stamp, input)| (None, stamp, input)).collect();
    assert_eq!(sequenced(&swapped).0, in_order);
}

#[test]
fn without_delays_the_bits_equal_those_of_a_plain_loop() {
    let log = log([0; 3]);
    let plain = filtered(|filters| {
        let mut control = None;
        for (stamp, input) in &log {
            match input {
                Input::Control(next) => {
                    assert_eq!(stamp.time_ns.wrapping_sub(START_NS) % (100 * MS), 0);
                    if let Some(control) = control.replace(next) {
                        filters.predict(control, 0.1);
                    }
                }
                Input::Event(event) => filters.event(event),
            }
        }
    });
    let arrivals: Vec<_> = log.iter().map(|(stamp, input)| (None, *stamp, input.clone())).collect();
    let (outcome, report) = sequenced(&arrivals);
    assert!(report.flags.is_empty(), "{report:?}");
    assert_eq!(outcome, plain);
}

#[test]
fn inputs_later_than_the_window_are_left_out_and_counted() {
    let log = log(PHASES_MS);
    let arrivals: Vec<_> = log.iter().map(|(stamp, input)| (None, *stamp, input.clone())).collect();
    // The input at 3.6 s.
    let late = 70;
    let without: Vec<_> = arrivals.iter().enumerate().filter(|(at, _)| *at != late).map(|(_, a)| a.clone()).collect();
    let mut delayed = without.clone();
    let too_late_ns = arrivals[late].1.time_ns + SETTINGS.window_ns;
    let newer = arrivals.iter().skip(late).position(|(_, stamp, _)| stamp.time_ns > too_late_ns).unwrap();
    delayed.insert(late + newer, arrivals[late].clone());
    let (expected, clean) = sequenced(&without);
    let (outcome, report) = sequenced(&delayed);
    assert!(clean.flags.is_empty());
    assert_eq!((report.flags, report.count(Flags::LATE)), (Flags::LATE, 1));
    assert_eq!(outcome, expected);
}

#[test]
fn complete_inputs_are_output_at_once_and_more_of_the_same_time_may_follow() {
    let mut sequencer = Sequencer::<u8, u8, 8, 8>::new();
    sequencer.start(SETTINGS, 0, 0).unwrap();
    let mut seen = Vec::new();
    let mut work = |sequencer: &mut Sequencer<u8, u8, 8, 8>| {
        while let Some(action) = sequencer.next_action() {
            seen.push(match action {
                Action::Predict { control, dt } | Action::Gap { control, dt } => (control, dt.ns() / MS),
                Action::Event(event) => (*event, 0),
            });
        }
    };
    sequencer.push_event(Stamp::new(2, 30 * MS), 20).unwrap();
    sequencer.push_control(Stamp::new(0, 10 * MS), 1).unwrap();
    work(&mut sequencer);
    sequencer.push_control(Stamp::new(0, 40 * MS), 2).unwrap();
    sequencer.complete_until(30 * MS);
    work(&mut sequencer);
    // One with the same time and another source, and one before it.
    sequencer.push_event(Stamp::new(1, 30 * MS), 10).unwrap();
    assert_eq!(sequencer.push_event(Stamp::new(1, 29 * MS), 11), Err(PushError::Late));
    work(&mut sequencer);
    sequencer.flush();
    work(&mut sequencer);
    assert_eq!(seen, [(0, 10), (1, 20), (20, 0), (10, 0), (1, 10)]);
    assert!(sequencer.report().flags == Flags::LATE);
}
