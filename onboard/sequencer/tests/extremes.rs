//! For any time stamps nothing panics, and the output is in order.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scphd_sequencer::{Action, Flags, Sequencer, Settings, Stamp};

#[derive(Debug, Clone)]
enum Call {
    Control(Stamp),
    Event(Stamp),
    Tick(u64),
    Drain,
    Flush,
    Start(Settings, u64),
}

/// Times near critical values of the clock, and arbitrary ones.
fn time() -> impl Strategy<Value = u64> {
    let corner = prop_oneof![Just(0), Just(u64::MAX), Just(1 << 62), Just(1 << 63), Just(u64::MAX / 3)];
    let near = (corner, -2_000_i64..2_000).prop_map(|(corner, by): (u64, i64)| corner.wrapping_add_signed(by));
    prop_oneof![9 => near, 1 => any::<u64>()]
}

fn stamp() -> impl Strategy<Value = Stamp> {
    (time(), 0..3_u8, 0..3_u32).prop_map(|(time_ns, source, number)| Stamp { time_ns, source, number })
}

fn settings() -> impl Strategy<Value = Settings> {
    let greatest = 1_u64 << 62;
    let window = prop_oneof![0..2_000_u64, 0..=greatest];
    (window, prop_oneof![1..500_u64, Just(u64::MAX)], prop_oneof![1_000..9_000_u64, Just(greatest)], 1..4_u32, 1..9_u32)
        .prop_map(|(window_ns, gap_ns, jump_ns, jumps_believed, frozen_inputs)| Settings {
            window_ns,
            gap_ns,
            jump_ns,
            jumps_believed,
            frozen_inputs,
        })
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        8 => stamp().prop_map(Call::Control),
        8 => stamp().prop_map(Call::Event),
        3 => time().prop_map(Call::Tick),
        4 => Just(Call::Drain),
        1 => Just(Call::Flush),
        1 => (settings(), time()).prop_map(|(settings, time)| Call::Start(settings, time)),
    ]
}

/// Counts of added and output events, and the output time, since the start.
#[derive(Default)]
struct Account {
    events: [u32; 2],
    passed_ns: u64,
}

fn drain(inputs: &mut Sequencer<u8, u32, 3, 2>, account: &mut Account) {
    // Between two inputs there are at most a prediction and a gap.
    for _ in 0..3 * (3 + 2) + 1 {
        match inputs.next_action() {
            Some(Action::Event(_)) => account.events[1] += 1,
            Some(Action::Predict { dt, .. } | Action::Gap { dt, .. }) => {
                assert!(dt.ns() > 0);
                account.passed_ns = account.passed_ns.checked_add(dt.ns()).expect("time has passed more than once");
            }
            None => return,
        }
    }
    panic!("it does not end");
}

#[test]
fn no_panic_no_lost_input_and_no_step_back_in_time() {
    let config = ProptestConfig {
        cases: 10_000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(18),
        ..ProptestConfig::default()
    };
    proptest!(config, |(settings in settings(), start in time(), calls in vec(call(), 0..60))| {
        let mut inputs = Sequencer::<u8, u32, 3, 2>::new();
        let mut account = Account::default();
        let _refused = inputs.start(settings, start, 0);
        for call in calls {
            let (waited, before) = (inputs.waiting().1, account.events[0]);
            let pushes = matches!(call, Call::Control(_) | Call::Event(_));
            match call {
                Call::Control(stamp) => _ = inputs.push_control(stamp, 1),
                Call::Event(stamp) => account.events[0] += u32::from(inputs.push_event(stamp, 7).is_ok()),
                Call::Tick(now) => inputs.tick(now),
                Call::Drain => drain(&mut inputs, &mut account),
                Call::Flush => {
                    inputs.flush();
                    drain(&mut inputs, &mut account);
                    prop_assert_eq!(inputs.waiting(), (0, 0));
                    prop_assert_eq!(account.events[0], account.events[1]);
                }
                Call::Start(settings, time) => {
                    if inputs.start(settings, time, 0).is_ok() {
                        account = Account::default();
                    }
                }
            }
            // Queued inputs are removed only by an input that contradicts them, and are counted then.
            if pushes {
                let dropped = waited as u32 + account.events[0] - before - inputs.waiting().1 as u32;
                prop_assert!(dropped <= inputs.report().count(Flags::JUMP_FORWARD));
                account.events[1] += dropped;
            }
            // At most the queued controls and the one in force.
            prop_assert!(inputs.ahead(start).count() <= 4);
        }
    });
}
