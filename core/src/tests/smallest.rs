//! The smallest capacities with every proposal and option: the loop iterations of every step are counted, and within the bounds
//! of `docs/performance.md`.

use crate::numerics::work::limited;
use crate::tests::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Filter<'s> = Alone<'s, Unicycle<f32>, Lidar<f32>>;

const AHEAD: UnicycleControl<f32> = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };

fn models(clutter_per_scan: f32) -> Models<Unicycle<f32>, Lidar<f32>> {
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::white(0.3, 0.05)).unwrap(),
        sensing: Sensing::range_bearing([0.2, 0.02], window, clutter_per_scan).unwrap(),
    }
}

/// The capacities on which the number of loop iterations in a step depends.
#[derive(Debug, Clone, Copy)]
struct Capacities {
    particles: usize,
    candidates: usize,
    /// Pages of a map, of each kind.
    map_pages: usize,
    /// Components in an update, of each kind.
    view: usize,
    measurements: usize,
}

impl Capacities {
    /// The bound on loop iterations of a scan by the table of `docs/performance.md`.
    fn rounds(&self) -> u64 {
        let Self { particles: n, candidates: c, map_pages, view, measurements: z } = *self;
        // Both kinds of features.
        let (j, v) = (2 * map_pages * PAGE_LEN, 2 * view);
        // Every search covers a circle of measurements once or twice.
        let looks = c * j + n * (j + 16 * 2 * (v + j) + j) + 2 * j;
        let pushes = j * (z + 1) + z;
        // Merging: two searches of every component in the lists of all cells; sorting; cheapest merges; lists of members and of
        // pages.
        let a_map = 21 + pushes + 2 * v * v + 2 * v * v + 2 * v + 3 * v;
        (2 * looks + n * a_map + 2 * c + 4 * n) as u64
    }
}

/// Features on a ring around the initial pose, all in view.
fn ring(count: usize) -> Vec<Component<Vector2<f32>>> {
    let place = |k: usize| (core::f32::consts::TAU * k as f32 / count as f32).sin_cos();
    let feature = |k| {
        let (sine, cosine) = place(k);
        Component {
            label: k as u32,
            ln_weight: 0.0,
            mean: Vector2::new(10.0 * cosine, 10.0 * sine),
            covariance: Symmetric::from_diagonal([0.01, 0.01]),
        }
    };
    (0..count).map(feature).collect()
}

fn measurements(count: usize) -> Vec<Vector2<f32>> {
    (0..count).map(|k| Vector2::new(10.0, wrap(core::f32::consts::TAU * k as f32 / count as f32))).collect()
}

/// More features near measurements than an update has room for: the proposal uses as many as fit, and reports it.
#[test]
fn an_informed_proposal_with_too_many_features_in_view_ends() {
    type Memory = State<PlanarPose<f32>, 4, 4, MapMemory<Static<Vector2<f32>>, 4, 64, 16, 24>>;
    let capacities = Capacities { particles: 4, candidates: 4, map_pages: 16, view: 24, measurements: 64 };
    for features in [24, 25, 100] {
        let mut state = Box::new(Memory::new());
        let proposal = Proposal::Informed(Informed::default());
        let config = Config { particles: 4, proposal, ..Config::default() };
        let mut filter = Filter::new(models(2.0), Births::of_static(0.01), config, &mut *state).unwrap();
        filter.reset(PlanarPose::ZERO, 1).unwrap();
        filter.load_map(&ring(features)).unwrap();
        filter.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
        let scan = measurements(features.min(64));
        let (report, rounds) = limited(capacities.rounds(), || filter.scan(&scan).unwrap());
        assert!(rounds > 0);
        // Every map lacks room in its update. If the proposal lacks room too, the map is counted twice.
        assert!(report.health.contains(Health::PRUNING_TIGHTENED), "{features}: {report:?}");
        assert_eq!(report.tightened > report.survivors, features > 24, "{features}: {report:?}");
    }
}

fn proposals() -> Vec<Proposal<f32>> {
    let informed =
        |drawn, rounds| Proposal::Informed(Informed { sampled_fraction: drawn, rounds, ..Informed::default() });
    std::vec![Proposal::Blind, informed(1.0, 1), informed(0.5, 3), informed(0.0, 16)]
}

/// All options of a configuration, with numbers at the ends of their ranges.
fn configurations(particles: usize, samples: usize, moves: bool) -> Vec<(Births<f32>, Config<f32>)> {
    let mut all = Vec::new();
    let ends = [
        // Nothing is pruned or born; or everything is.
        (f32::MIN_POSITIVE, f32::MIN_POSITIVE, 0.0),
        (2.5e-3, f32::EPSILON, 0.01),
        (0.9, 0.9, 1e30),
    ];
    for proposal in proposals() {
        for merge_distance in [0.0, 1e30] {
            for (prune_weight, negligible, still) in ends {
                let births = Births { of_static: still, of_moving: if moves { still } else { 0.0 } };
                let config = Config {
                    particles,
                    samples,
                    proposal,
                    merge_distance,
                    prune_weight,
                    negligible,
                    max_components: if still > 1.0 { 1 } else { usize::MAX },
                    resample_threshold: 1.0,
                    confirmed_weight: 0.3,
                    unconfirmed_weight: 0.2,
                    extraction: if moves { Extraction::Confirmed } else { Extraction::Peaks },
                    ..Config::default()
                };
                all.push((births, config));
            }
        }
    }
    all
}

/// Runs steps of every kind on one state. Returns the largest number of loop iterations in a scan.
fn run<
    const N: usize,
    const C: usize,
    const Z: usize,
    const P: usize,
    const MP: usize,
    const V: usize,
    VM: MapStorage<Dynamic<Vector2<f32>>>,
>(
    moves: bool,
) -> u64 {
    let capacities = Capacities { particles: N, candidates: C, map_pages: MP, view: V, measurements: Z };
    let mut state = Box::new(State::<PlanarPose<f32>, N, C, MapMemory<Static<Vector2<f32>>, N, P, MP, V>, VM>::new());
    let mut most = 0;
    for (births, config) in configurations(N, C / N, moves) {
        for clutter in [0.0, 3.0] {
            state.clear();
            let mut filter = Filter::new(models(clutter), births, config, &mut *state).unwrap();
            filter.reset(PlanarPose::ZERO, 7).unwrap();
            filter.load_map(&ring(MP * PAGE_LEN)).unwrap();
            for step in 0..6 {
                let scan = measurements(if step == 4 { 0 } else { Z });
                let work = || {
                    if step != 2 {
                        filter.predict(&AHEAD, 0.1).unwrap();
                    }
                    let report = filter.scan(&scan).unwrap();
                    let peak = report.peak;
                    assert!(peak.pages <= P && peak.map_pages <= MP && peak.in_view <= V, "{peak:?}");
                    assert!(peak.pages >= report.pages_used, "{peak:?}");
                    let features = &mut [Component::ZERO; 3];
                    filter.estimate_map(features);
                    filter.estimate_moving(&mut [Component::ZERO; 1]);
                    filter.estimate_pose().unwrap();
                    report
                };
                let (report, rounds) = limited(2 * capacities.rounds(), work);
                most = most.max(rounds);
                assert!(report.maps_updated + report.not_updated == report.survivors, "{config:?}: {report:?}");
                let total: f32 = filter.candidates().iter().map(|candidate| candidate.ln_weight.exp()).sum();
                assert!((total - 1.0).abs() < 1e-4, "{config:?}: weights sum to {total}");
                assert_eq!(filter.audit(), Ok(()), "{config:?}");
            }
        }
    }
    most
}

#[test]
fn capacities_of_one() {
    assert!(run::<1, 1, 1, 1, 1, 8, NoMoving>(false) > 0);
    assert!(run::<1, 1, 1, 1, 1, 8, MapMemory<Dynamic<Vector2<f32>>, 1, 1, 1, 8>>(true) > 0);
}

#[test]
fn one_particle_with_several_samples() {
    assert!(run::<1, 3, 2, 2, 1, 8, NoMoving>(false) > 0);
}

#[test]
fn many_particles_with_one_page() {
    assert!(run::<4, 4, 8, 1, 1, 8, NoMoving>(false) > 0);
    assert!(run::<3, 6, 8, 3, 2, 9, MapMemory<Dynamic<Vector2<f32>>, 3, 2, 1, 8>>(true) > 0);
}

#[test]
fn a_long_map_with_a_small_view() {
    assert!(run::<2, 2, 24, 64, 16, 8, NoMoving>(false) > 0);
    assert!(run::<2, 2, 24, 64, 16, 24, MapMemory<Dynamic<Vector2<f32>>, 2, 16, 8, 8>>(true) > 0);
}
