//! Bit flips in the state during a replay, as in the firmware's image `flips`: the filter continues, with reproducible results.

use scphd_boards::stream::{self, Recorded};
use scphd_filters::settings::Settings;
use scphd_stream::planar::{Planar, PlanarJoint};
use scphd_stream::{Aboard, Failing, Monitor, Round, Scalar, ScanCost, Seen, replay_with_flips};
use scphd_tests::with_roomy_stack;
use scphd_worlds::scenario;

const SCANS: usize = 260;
const SEEDS: std::ops::Range<u64> = 0..30;

struct NoClock;

impl Monitor for NoClock {
    fn scanned(&mut self, _: &ScanCost, _: &Seen, _: u64) {}
}

/// The outcome of every round of a replay.
fn rounds<A: Aboard<f32>>(stream: &[u8], seed: u64) -> Vec<Round>
where
    for<'m> A::Filter<'m>: Failing<A::Kind>,
{
    let (mut memory, mut room, mut rounds) = (Box::new(A::MEMORY), vec![0; 256 << 10], Vec::new());
    replay_with_flips::<A>(stream, &mut memory, &mut room, seed, &mut NoClock, |round| rounds.push(*round)).unwrap();
    rounds
}

fn goes_on<A: Aboard<f32>>(stream: &[u8])
where
    for<'m> A::Filter<'m>: Failing<A::Kind>,
{
    let all: Vec<Vec<Round>> = SEEDS.map(|seed| rounds::<A>(stream, seed)).collect();
    assert!(all.iter().all(|all| all.len() == 20 && all.iter().map(|round| round.flips).sum::<u32>() == 3200));
    assert!(all.iter().all(|all| all.iter().any(|round| round.mended > 0)), "{all:?}");
    // Some flips are beyond what scrubbing can repair.
    assert!(all.iter().flatten().any(|round| round.refused > 0), "{all:?}");
    assert_eq!(rounds::<A>(stream, SEEDS.start), all[0]);
}

#[test]
fn a_replay_goes_on_whatever_flips_and_does_the_same_twice() {
    with_roomy_stack(|| {
        let log = scenario::survey(1);
        let settings = Settings::for_scenario("survey", &log);
        let settings = settings.with_toml(include_str!("../../firmware/informed.toml")).unwrap();
        let of = |filter| stream::write(&log, &settings, filter, 1, Scalar::F32, SCANS).unwrap().bytes;
        goes_on::<Planar>(&of(Recorded::Mixture));
        goes_on::<PlanarJoint>(&of(Recorded::Joint));
    });
}
