//! Every fault of the times raises its flag and is counted, and the sequencer continues.

use scphd_sequencer::{Action, Flags, Interval, PushError, Sequencer, Settings, Stamp};

const MS: u64 = 1_000_000;
const START: u64 = 7_000_000 * MS;
const SETTINGS: Settings =
    Settings { window_ns: 50 * MS, gap_ns: 300 * MS, jump_ns: 1000 * MS, jumps_believed: 3, frozen_inputs: 12 };

type Inputs = Sequencer<char, &'static str, 4, 3>;

fn started() -> Inputs {
    let mut inputs = Inputs::new();
    inputs.start(SETTINGS, START, '0').unwrap();
    inputs
}

fn at(source: u8, ms: u64) -> Stamp {
    Stamp::new(source, START + ms * MS)
}

/// The output as text: control and ms of a prediction, with `?` for a gap, and events by name.
fn drained(inputs: &mut Inputs) -> String {
    let mut out = Vec::new();
    while let Some(action) = inputs.next_action() {
        out.push(match action {
            Action::Predict { control, dt } => format!("{control}{}", dt.ns() / MS),
            Action::Gap { control, dt } => format!("?{control}{}", dt.ns() / MS),
            Action::Event(event) => event.to_string(),
        });
    }
    out.join(" ")
}

fn only(inputs: &Inputs, expected: &[(Flags, u32)]) {
    for condition in Flags::all() {
        let count = expected.iter().find(|(of, _)| *of == condition).map_or(0, |(_, count)| *count);
        assert_eq!(inputs.report().count(condition), count, "{condition:?}");
        assert_eq!(inputs.report().flags.contains(condition), count > 0, "{condition:?}");
    }
}

#[test]
fn inputs_before_the_start_are_refused() {
    let mut inputs = Inputs::new();
    assert_eq!(inputs.push_control(at(0, 0), 'a'), Err(PushError::NotStarted));
    inputs.tick(5);
    inputs.flush();
    assert!(inputs.next_action().is_none() && inputs.report().flags.is_empty());
    let wrong = Settings { gap_ns: 0, ..SETTINGS };
    assert_eq!(inputs.start(wrong, START, '0').unwrap_err().field, "gap_ns");
    inputs.start(SETTINGS, START, '0').unwrap();
    assert_eq!(inputs.push_event(Stamp::new(1, START - 1), "before"), Err(PushError::Late));
    assert_eq!(inputs.push_event(at(1, 0), "at once"), Ok(()));
    inputs.flush();
    assert_eq!(drained(&mut inputs), "at once");
    only(&inputs, &[(Flags::LATE, 1)]);
}

#[test]
fn inputs_wait_for_the_window_by_time_stamps_or_ticks() {
    let mut inputs = started();
    inputs.push_event(at(1, 30), "scan").unwrap();
    inputs.push_control(at(0, 20), 'a').unwrap();
    assert_eq!(drained(&mut inputs), "");
    // The first 20 ms are closed when the newest time is above 70 ms.
    inputs.push_control(at(0, 70), 'b').unwrap();
    assert_eq!(drained(&mut inputs), "");
    inputs.tick(START + 75 * MS);
    assert_eq!(drained(&mut inputs), "020");
    inputs.tick(START + 81 * MS);
    assert_eq!((drained(&mut inputs).as_str(), inputs.time_ns()), ("a10 scan", START + 30 * MS));
    assert_eq!((inputs.push_event(at(1, 30), "late"), inputs.waiting()), (Err(PushError::Late), (1, 0)));
    inputs.push_event(at(1, 31), "in time").unwrap();
    inputs.flush();
    assert_eq!(drained(&mut inputs), "a1 in time a39");
    only(&inputs, &[(Flags::LATE, 1)]);
}

#[test]
fn at_equal_times_controls_precede_sources_and_numbers() {
    let mut inputs = started();
    inputs.push_event(at(9, 20).numbered(4), "c").unwrap();
    inputs.push_event(at(9, 20).numbered(3), "b").unwrap();
    inputs.push_event(at(2, 20), "a").unwrap();
    inputs.push_control(at(200, 20).numbered(2), 'y').unwrap();
    inputs.push_control(at(200, 20).numbered(1), 'x').unwrap();
    assert_eq!(inputs.push_event(at(9, 20).numbered(4), "again"), Err(PushError::Duplicate));
    inputs.push_control(at(200, 40), 'z').unwrap();
    inputs.flush();
    assert_eq!(drained(&mut inputs), "020 a b c y20");
    only(&inputs, &[(Flags::DUPLICATE, 1)]);
}

#[test]
fn full_queues_refuse_inputs_and_continue() {
    let mut inputs = started();
    for (ms, expected) in [(10, Ok(())), (11, Ok(())), (12, Ok(())), (13, Err(PushError::Full))] {
        assert_eq!(inputs.push_event(at(1, ms), "event"), expected);
    }
    for (ms, expected) in [(10, Ok(())), (11, Ok(())), (12, Ok(())), (13, Ok(())), (14, Err(PushError::Full))] {
        assert_eq!(inputs.push_control(at(0, ms), 'a'), expected);
    }
    // An input without room has still advanced the time.
    assert_eq!(inputs.push_event(at(1, 64), "refused"), Err(PushError::Full));
    assert_eq!(drained(&mut inputs), "010 event a1 event a1 event a1");
    assert_eq!(inputs.push_event(at(1, 65), "again"), Ok(()));
    only(&inputs, &[(Flags::EVENTS_FULL, 2), (Flags::CONTROLS_FULL, 1)]);
}

#[test]
fn a_gap_in_the_controls_is_reported_once_and_output() {
    let mut inputs = started();
    inputs.push_control(at(0, 10), 'a').unwrap();
    for ms in [100, 200, 310, 350] {
        inputs.tick(START + ms * MS);
    }
    assert_eq!(drained(&mut inputs), "010");
    // The time before 310 ms is closed: the control was not alone for too long.
    inputs.tick(START + 360 * MS);
    only(&inputs, &[]);
    inputs.tick(START + 361 * MS);
    only(&inputs, &[(Flags::GAP, 1)]);
    inputs.push_event(at(1, 390), "scan").unwrap();
    inputs.push_control(at(0, 400), 'b').unwrap();
    inputs.push_event(at(1, 410), "scan").unwrap();
    inputs.flush();
    assert_eq!(drained(&mut inputs), "a300 ?a80 scan ?a10 b10 scan");
    only(&inputs, &[(Flags::GAP, 1)]);
    // Detected from the time stamps only.
    inputs.push_control(at(0, 1000), 'c').unwrap();
    inputs.flush();
    assert_eq!(drained(&mut inputs), "b290 ?b300");
    only(&inputs, &[(Flags::GAP, 2)]);
}

#[test]
fn one_wrong_time_stamp_is_refused() {
    let mut inputs = started();
    for (ms, wild) in [(10, u64::MAX / 2), (30, 0), (50, START + 2_000 * MS), (70, START - 2_000 * MS)] {
        inputs.push_control(at(0, ms), 'a').unwrap();
        assert_eq!(inputs.push_control(Stamp::new(0, wild), 'x'), Err(PushError::Jump));
    }
    inputs.flush();
    assert_eq!(drained(&mut inputs), "010 a20 a20 a20");
    only(&inputs, &[(Flags::JUMP_FORWARD, 2), (Flags::JUMP_BACK, 2)]);
}

#[test]
fn wrong_time_stamps_that_disagree_never_set_the_clock() {
    let mut inputs = started();
    for k in 1..40 {
        assert_eq!(inputs.push_control(Stamp::new(0, START + k * 5_000 * MS), 'x'), Err(PushError::Jump));
    }
    assert_eq!(inputs.push_control(at(0, 10), 'a'), Ok(()));
    only(&inputs, &[(Flags::JUMP_FORWARD, 39)]);
}

/// Sets the clock while inputs are queued: two inputs are lost, but the time between them is not.
fn set_by(shift_ms: i64) -> Inputs {
    let mut inputs = started();
    let after = |ms: u64| Stamp::new(0, (START + ms * MS).wrapping_add_signed(shift_ms * 1_000_000));
    inputs.push_control(at(0, 20), 'a').unwrap();
    inputs.push_event(at(1, 20), "scan").unwrap();
    assert_eq!(inputs.push_control(after(40), 'b'), Err(PushError::Jump));
    assert_eq!(inputs.push_control(after(60), 'c'), Err(PushError::Jump));
    assert_eq!(inputs.push_control(after(80), 'd'), Ok(()));
    assert_eq!(inputs.push_control(after(100), 'e'), Ok(()));
    inputs.flush();
    // The first input after the jump is assumed to be at the newest time before it.
    assert_eq!(drained(&mut inputs), "020 scan a40 d20");
    assert_eq!(inputs.time_ns(), after(100).time_ns);
    assert_eq!(inputs.push_control(at(0, 140), 'f'), Err(PushError::Jump));
    inputs
}

#[test]
fn a_clock_that_is_set_is_believed_at_last() {
    only(&set_by(90_000_000), &[(Flags::JUMP_FORWARD, 3), (Flags::CLOCK_SET, 1), (Flags::JUMP_BACK, 1)]);
    only(&set_by(-6_000_000), &[(Flags::JUMP_BACK, 3), (Flags::CLOCK_SET, 1), (Flags::JUMP_FORWARD, 1)]);
    // A counter of microseconds with 32 bits that has wrapped.
    only(&set_by(-4_294_967), &[(Flags::JUMP_BACK, 3), (Flags::CLOCK_SET, 1), (Flags::JUMP_FORWARD, 1)]);
}

#[test]
fn a_silence_with_ticks_is_no_jump() {
    let mut inputs = started();
    (1..=100).for_each(|step| inputs.tick(START + step * 100 * MS));
    inputs.push_control(at(0, 10_010), 'a').unwrap();
    inputs.flush();
    assert_eq!(drained(&mut inputs), "0300 ?09710");
    only(&inputs, &[(Flags::GAP, 1)]);
}

#[test]
fn frozen_stamps_are_told() {
    let mut inputs = started();
    inputs.push_control(at(0, 10), 'a').unwrap();
    for number in 1..12 {
        let _full = inputs.push_event(at(1, 10).numbered(number), "scan");
    }
    assert!(!inputs.report().flags.contains(Flags::FROZEN));
    assert_eq!(inputs.push_control(at(0, 10), 'a'), Err(PushError::Duplicate));
    only(&inputs, &[(Flags::FROZEN, 1), (Flags::EVENTS_FULL, 8), (Flags::DUPLICATE, 1)]);
    // A clock that advances does not make frozen time stamps valid; they are late then.
    inputs.tick(START + 100 * MS);
    assert_eq!(drained(&mut inputs), "010 scan scan scan");
    assert_eq!(inputs.push_control(at(0, 10), 'a'), Err(PushError::Late));
    // It advances, freezes again, and is reported again.
    inputs.push_control(at(0, 120), 'b').unwrap();
    (1..=12).for_each(|number| _ = inputs.push_control(at(0, 120).numbered(number), 'b'));
    assert_eq!(inputs.report().count(Flags::FROZEN), 2);
}

#[test]
fn a_tick_that_stays_behind_has_no_effect_and_is_reported() {
    let mut inputs = started();
    for step in 1..=10 {
        inputs.push_control(at(0, step * 20), 'a').unwrap();
        inputs.tick(START + 20 * MS);
        drained(&mut inputs);
    }
    only(&inputs, &[(Flags::TICK_BEHIND, 1)]);
    inputs.tick(START + 200 * MS);
    inputs.tick(0);
    only(&inputs, &[(Flags::TICK_BEHIND, 2)]);
    inputs.tick(START + 5_000 * MS);
    only(&inputs, &[(Flags::TICK_BEHIND, 2), (Flags::JUMP_FORWARD, 1)]);
    assert_eq!(inputs.push_control(at(0, 220), 'a'), Ok(()));
}

#[test]
fn a_taken_report_keeps_the_counts() {
    let mut inputs = started();
    inputs.push_control(at(0, 10), 'a').unwrap();
    assert_eq!(inputs.push_control(at(0, 10), 'a'), Err(PushError::Duplicate));
    assert_eq!(inputs.take_report().flags, Flags::DUPLICATE);
    assert_eq!((inputs.report().flags, inputs.report().count(Flags::DUPLICATE)), (Flags::NONE, 1));
    inputs.start(SETTINGS, START, '0').unwrap();
    assert_eq!((inputs.report().count(Flags::DUPLICATE), inputs.waiting()), (0, (0, 0)));
}

#[test]
fn queued_controls_give_the_current_pose() {
    let mut inputs = started();
    inputs.push_control(at(0, 40), 'b').unwrap();
    inputs.push_control(at(0, 20), 'a').unwrap();
    let ahead = |inputs: &Inputs, ms: u64| {
        inputs.ahead(START + ms * MS).map(|(control, dt)| (control, dt.ns() / MS)).collect::<Vec<_>>()
    };
    assert_eq!(ahead(&inputs, 50), [('0', 20), ('a', 20), ('b', 10)]);
    assert_eq!(ahead(&inputs, 30), [('0', 20), ('a', 10)]);
    assert_eq!(ahead(&inputs, 0), []);
    inputs.push_event(at(1, 75), "scan").unwrap();
    assert_eq!(drained(&mut inputs), "020");
    assert_eq!(ahead(&inputs, 50), [('a', 20), ('b', 10)]);
    // The control is too old at 340 ms.
    assert_eq!(ahead(&inputs, 900), [('a', 20), ('b', 300)]);
    assert!(Inputs::new().ahead(5).next().is_none());
    // An interval of one nanosecond is valid.
    assert_eq!(inputs.ahead(START + 20 * MS + 1).next(), Some(('a', Interval::of_ns(1))));
}

/// A single time stamp far ahead affects only its own input, not all others until that time.
#[test]
fn a_time_stamp_in_the_future_does_not_block_others() {
    for ticks in [false, true] {
        for ahead_ms in [150, 500, 900] {
            let mut inputs = started();
            let (mut refused, mut predicted_ms, mut scans) = (0, 0, 0);
            for ms in (20..5000).step_by(20) {
                refused += usize::from(inputs.push_control(at(0, ms), 'a').is_err());
                if ms % 100 == 0 {
                    let stamp = if ms == 2000 { ms + ahead_ms } else { ms };
                    refused += usize::from(inputs.push_event(at(1, stamp), "scan").is_err());
                }
                if ticks {
                    inputs.tick(START + ms * MS);
                }
                while let Some(action) = inputs.next_action() {
                    match action {
                        Action::Predict { dt, .. } => predicted_ms += dt.ns() / MS,
                        Action::Gap { .. } => panic!("no control was missing"),
                        Action::Event(_) => scans += 1,
                    }
                }
            }
            assert_eq!(refused, 0, "{ahead_ms} ms ahead, ticks {ticks}");
            assert!(predicted_ms > 4900, "{predicted_ms}");
            assert_eq!(
                (scans, inputs.report().count(Flags::JUMP_FORWARD)),
                (48, 1),
                "{ahead_ms} ms ahead, ticks {ticks}"
            );
        }
    }
}

/// After a silence the first input is ahead by more than the window, and valid.
#[test]
fn after_a_silence_nothing_is_lost() {
    let mut inputs = started();
    inputs.push_control(at(0, 20), 'a').unwrap();
    inputs.push_event(at(1, 900), "first").unwrap();
    assert_eq!(inputs.push_control(at(0, 910), 'b'), Ok(()));
    inputs.push_control(at(0, 955), 'c').unwrap();
    assert_eq!(drained(&mut inputs), "020 a300 ?a580 first");
    only(&inputs, &[(Flags::GAP, 1)]);
}
