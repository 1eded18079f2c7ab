//! Several hypotheses: against closed forms, against one, and where they must not break.

use super::super::report::Tally;
use super::super::state::Header;
use super::causes::{Cause, causes_of, start};
use super::gated::Gated;
use super::slot::Weight;
use crate::tests::linear::{Drift, Everywhere, Offset, linear_sensing};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::convert::Infallible;
use std::vec::Vec;

const ROOM: usize = 24;
const NUMBERS: usize = joint_numbers(3, 2, ROOM);
type Window = RangeBearingWindow<f32>;
type Eyes = Detector<Sensing<RangeBearing<f32>, Window, UniformClutter<f32>>>;
type Pose32 = PlanarPose<f32>;
type Memory = JointState<Pose32, Vector2<f32>, ROOM, NUMBERS, 16>;
type Tracks = JointMovers<Pose32, 8>;
type Others = JointHypotheses<Pose32, 7, ROOM, NUMBERS, 8>;
type Several<'s> = MultiHypothesisSlam<'s, Unicycle<f32>, Vector2<f32>, Tracked<'s, Pose32>, 7>;

/// The memory of one filter in single precision.
struct Room {
    state: Memory,
    tracks: Tracks,
    others: Others,
}

impl Room {
    fn new() -> Box<Self> {
        Box::new(Self { state: Memory::new(), tracks: Tracks::new(), others: Others::new() })
    }

    fn one(&mut self) -> JointSlam<'_, Unicycle<f32>, Vector2<f32>, NoArchive, Tracked<'_, Pose32>> {
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.3)).unwrap();
        let slam = JointSlam::new(motion, JointConfig::default(), &mut self.state).unwrap();
        slam.with_movers(&mut self.tracks, MovingConfig::walkers()).unwrap()
    }

    fn several(&mut self, most: usize) -> Several<'_> {
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.3)).unwrap();
        let slam = JointSlam::new(motion, JointConfig::default(), &mut self.state).unwrap();
        let slam = slam.with_movers(&mut self.tracks, MovingConfig::walkers()).unwrap();
        slam.with_hypotheses(&mut self.others, HypothesesConfig { most, ..HypothesesConfig::default() }).unwrap()
    }
}

fn eyes() -> Eyes {
    let window = RangeBearingWindow::full_circle(12.0, 0.8).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.02], window, 0.5).unwrap();
    Detector::new(sensing, Births { of_static: 1e-3, of_moving: 5e-4 }).unwrap()
}

/// A robot on a circle among twelve landmarks, which now and then sees none for a while.
struct World {
    draws: Noise,
    truth: [f32; 3],
    step: usize,
}

impl World {
    fn new(seed: u64) -> Self {
        Self { draws: Noise::seeded(seed), truth: [0.0; 3], step: 0 }
    }

    /// The odometry of the next step of 0.2 s, and the scan at its end.
    fn next(&mut self) -> (UnicycleControl<f32>, Vec<Vector2<f32>>) {
        self.step += 1;
        let [x, y, heading] = &mut self.truth;
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.2 + 0.25 * self.draws.normal::<f32>() };
        *heading += 0.04;
        (*x, *y) = (*x + 0.2 * heading.cos(), *y + 0.2 * heading.sin());
        let mut scan = Vec::new();
        if self.step % 100 < 60 {
            for k in 0..12 {
                let (sine, cosine) = (k as f32 * core::f32::consts::TAU / 12.0).sin_cos();
                let radius = if k % 3 == 0 { 9.0 } else { 7.0 };
                let off = [radius * cosine - *x, 5.0 + radius * sine - *y];
                if self.draws.uniform::<f32>() < 0.5 {
                    let noise = [0.1 * self.draws.normal::<f32>(), 0.02 * self.draws.normal::<f32>()];
                    let bearing = wrap(off[1].atan2(off[0]) - *heading + noise[1]);
                    scan.push(Vector2::new(off[0].hypot(off[1]) + noise[0], bearing));
                }
            }
        }
        scan.retain(|z| z.x < 12.0);
        (control, scan)
    }
}

fn step(slam: &mut Several<'_>, world: &mut World) -> JointReport<f32> {
    let (control, scan) = world.next();
    slam.predict(&control, 0.2).unwrap();
    slam.scan(&eyes(), &scan).unwrap()
}

#[test]
fn one_hypothesis_is_the_filter_without_to_the_bit() {
    let [mut one, mut several] = [(); 2].map(|()| Room::new());
    let (mut one, mut several) = (one.one(), several.several(1));
    one.reset(PlanarPose::ZERO).unwrap();
    several.reset(PlanarPose::ZERO).unwrap();
    let (mut world, eyes) = (World::new(3), eyes());
    for _ in 0..300 {
        let (control, scan) = world.next();
        assert_eq!(one.predict(&control, 0.2), several.predict(&control, 0.2));
        let (report, of_several) = (one.scan(&eyes, &scan).unwrap(), several.scan(&eyes, &scan).unwrap());
        assert_eq!(report, of_several);
        assert_eq!((one.digest(), one.estimate_pose()), (several.digest(), several.estimate_pose()));
    }
    assert!(one.held() > 8);
}

const LANDMARKS: [[f64; 2]; 3] = [[10.0, 0.0], [16.0, 0.0], [16.0, 9.0]];
type Linear = JointState<PlanarPose<f64>, Vector2<f64>, 4, { joint_numbers(3, 2, 4) }, 4>;
type LinearOthers = JointHypotheses<PlanarPose<f64>, 3, 4, { joint_numbers(3, 2, 4) }, 0>;

fn linear(detection: f64) -> Detector<Sensing<Offset, Everywhere, UniformClutter<f64>>> {
    let sensing = linear_sensing([0.01, 0.01], detection, 0.01);
    Detector::new(sensing, Births::of_static(1e-3)).unwrap()
}

/// Two landmarks 6 m apart, and a vehicle whose position is uncertain by about as much: a measurement of one of them has two
/// possible causes, and a later measurement of a third landmark decides.
#[test]
fn two_landmarks_are_told_apart_by_a_later_one_as_by_bayes() {
    for (seed, detection) in (0..20).zip([0.5, 0.8].into_iter().cycle()) {
        let (mut state, mut others) = (Box::new(Linear::new()), Box::new(LinearOthers::new()));
        let config = HypothesesConfig { least_ratio: 1e-9, least_share: 1e-9, ..HypothesesConfig::default() };
        let slam = JointSlam::new(Drift { sigmas: [0.0; 2] }, JointConfig::default(), &mut *state).unwrap();
        let mut slam = slam.with_hypotheses(&mut others, HypothesesConfig { most: 4, ..config }).unwrap();
        let prior = Symmetric::from_diagonal([9.0, 0.04, 0.0]);
        slam.reset_within(PlanarPose::ZERO, &prior).unwrap();
        let map: Vec<Component<Vector2<f64>>> = (0..3)
            .map(|k| Component {
                label: k,
                mean: Vector2::from(LANDMARKS[k as usize]),
                covariance: Symmetric::from_diagonal([1e-4; 2]),
                ..Component::ZERO
            })
            .collect();
        slam.load_map(&map).unwrap();
        let mut draws = Noise::seeded(seed);
        let mut noise = || Vector2::new(0.1 * draws.normal::<f64>(), 0.1 * draws.normal::<f64>());
        // The vehicle is 3 m ahead of or behind its estimated position.
        let at = if seed % 2 == 0 { 3.0 } else { -3.0 };
        let seen = if seed % 2 == 0 { 1 } else { 0 };
        let z = Vector2::from(LANDMARKS[seen]) - Vector2::new(at, 0.0) + noise();
        let report = slam.scan(&linear(detection), &[z]).unwrap();
        // Bayes by hand: the odds of each landmark, and those of clutter or a new one.
        let variance = [9.0 + 1e-4 + 0.01, 0.04 + 1e-4 + 0.01];
        let odds = LANDMARKS.map(|m| {
            let off = z - Vector2::from(m);
            let distance = off.x * off.x / variance[0] + off.y * off.y / variance[1];
            let density = (-0.5 * distance).exp() / (core::f64::consts::TAU * (variance[0] * variance[1]).sqrt());
            if distance <= 25.0 { detection / (1.0 - detection) * density } else { 0.0 }
        });
        let all = odds.iter().sum::<f64>() + 0.011;
        assert_eq!(report.hypotheses, 3, "{seed}");
        assert!((report.share - odds[0].max(odds[1]) / all).abs() < 1e-6, "{seed}: {report:?} {odds:?}");
        let evidence = (all * (1.0 - detection).powi(3)).ln();
        assert!((report.ln_evidence - evidence).abs() < 1e-6, "{seed}: {} {evidence}", report.ln_evidence);
        let pose = slam.estimate_pose().unwrap();
        let gain = 9.0 / variance[0];
        let mean = (odds[0] * gain * (LANDMARKS[0][0] - z.x) + odds[1] * gain * (LANDMARKS[1][0] - z.x)) / all;
        assert!((pose.mean.x_m - mean).abs() < 1e-6, "{seed}: {pose:?} {mean}");
        assert!(pose.covariance.get(0, 0) > 1.0, "{seed}: {pose:?}");
        // The third landmark is 9 m from only one of the two.
        for _ in 0..3 {
            let z = Vector2::from(LANDMARKS[2]) - Vector2::new(at, 0.0) + noise();
            slam.scan(&linear(detection), &[z]).unwrap();
        }
        let pose = slam.likeliest().estimate_pose().unwrap();
        assert!(slam.share() > 0.95, "{seed}: {}", slam.share());
        assert!((pose.mean.x_m - at).abs() < 0.3 && pose.covariance.get(0, 0) < 0.1, "{seed}: {pose:?}");
    }
}

/// Two hypotheses of which landmark was detected, in a map that is not changed afterwards: the next scan decides.
#[test]
fn localisation_weighs_the_hypotheses_as_a_scan_does() {
    let (mut state, mut others) = (Box::new(Linear::new()), Box::new(LinearOthers::new()));
    let slam = JointSlam::new(Drift { sigmas: [0.0; 2] }, JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_hypotheses(&mut others, HypothesesConfig::default()).unwrap();
    slam.reset_within(PlanarPose::ZERO, &Symmetric::from_diagonal([9.0, 0.04, 0.0])).unwrap();
    let map = [0, 1, 2].map(|k| Component {
        label: k,
        mean: Vector2::from(LANDMARKS[k as usize]),
        covariance: Symmetric::from_diagonal([1e-4; 2]),
        ..Component::ZERO
    });
    slam.load_map(&map).unwrap();
    let from = |k: usize, at: f64| Vector2::from(LANDMARKS[k]) - Vector2::new(at, 0.0);
    // Landmark 0 from -3 m looks as landmark 1 from 3 m.
    assert_eq!(slam.scan(&linear(0.8), &[from(0, -3.0)]).unwrap().hypotheses, 3);
    let labels = |slam: &MultiHypothesisSlam<'_, _, _, _, 3>| {
        slam.likeliest().features().map(|feature| feature.label).collect::<Vec<_>>()
    };
    let report = slam.localise(&linear(0.8), &[from(2, 3.0)]).unwrap();
    assert!(report.share > 0.9 && report.share == slam.share(), "{report:?}");
    assert!((slam.likeliest().estimate_pose().unwrap().mean.x_m - 3.0).abs() < 0.3);
    assert!(labels(&slam) == [0, 1, 2] && slam.audit().is_ok());
}

/// Two estimates of the pose agree but for rounding errors.
fn agree(one: &PoseEstimate<Pose32>, other: &PoseEstimate<Pose32>) {
    let off = one.mean.difference(&other.mean);
    let sigma = |k| one.covariance.get(k, k).max(1e-12).sqrt();
    for row in 0..3 {
        assert!(off[row].abs() <= 1e-4 * sigma(row), "{one:?} {other:?}");
        for column in 0..3 {
            let off = one.covariance.get(row, column) - other.covariance.get(row, column);
            assert!(off.abs() <= 1e-4 * sigma(row) * sigma(column), "{one:?} {other:?}");
        }
    }
}

/// What is computed before a measurement is used must be what its use gives: the pose after a correction, by which children are
/// joined, and that a measurement in no gate has no cause.
#[test]
fn what_is_foreseen_comes_true() {
    let (mut causes, mut without) = (0, 0);
    for seed in 0..4 {
        let mut room = Room::new();
        let mut slam = room.several(8);
        slam.reset(PlanarPose::ZERO).unwrap();
        let (mut world, eyes) = (World::new(seed), eyes());
        let models = eyes.on_vehicle();
        for _ in 0..120 {
            step(&mut slam, &mut world);
            let (control, scan) = world.next();
            slam.predict(&control, 0.2).unwrap();
            let before = saved(&slam);
            let JointSlam { config, memory, movers, .. } = &mut slam.slam;
            start(&models, config.occlusion_factor, memory, movers, &scan);
            for (index, z) in scan.iter().enumerate() {
                let JointSlam { config, memory, movers, .. } = &slam.slam;
                let gated = Gated::of(&models, config.gate, memory, movers, &scan, index);
                let [found, all] = [gated, Gated::ALL]
                    .map(|gated| causes_of(&models, config, memory, movers, &gated, index, z).all().to_vec());
                assert_eq!(found, all);
                assert!(gated.has(index) || all.is_empty());
                without += usize::from(!gated.has(index));
                let Some(&(cause, _)) = all.first() else { continue };
                let measurement = &scan[index..=index];
                let foreseen = slam.slam.pose_after(cause, &models, measurement);
                cause.store(index, &mut slam.slam.memory, &mut slam.slam.movers);
                let mut tally = Tally::NOTHING;
                slam.slam.correct_by(cause, &models, measurement, &mut tally);
                agree(&slam.slam.pose_after(Cause::NEW, &models, measurement), &foreseen);
                causes += 1;
            }
            let foreseen = slam.slam.pose_after(Cause::NEW, &models, &[]);
            slam.slam.memory.reset_error_frame(&Serial);
            agree(&slam.slam.estimate_pose().unwrap(), &foreseen);
            slam.restore(7, from_slice(&before)).unwrap();
        }
    }
    assert!(causes > 500 && without > 20, "{causes} {without}");
}

#[test]
fn they_are_bounded_and_one_too_many_is_reported() {
    for most in [2, 4, 8] {
        let (mut saturated, mut greatest, mut joined) = (0, 0, 0);
        for seed in 0..8 {
            let mut room = Room::new();
            let mut slam = room.several(most);
            slam.reset(PlanarPose::ZERO).unwrap();
            let mut world = World::new(seed);
            for _ in 0..300 {
                let report = step(&mut slam, &mut world);
                assert!(report.hypotheses <= most && report.hypotheses == slam.hypotheses());
                assert!(report.share > 0.0 && report.share <= 1.0 && slam.audit().is_ok(), "{report:?}");
                (saturated, greatest) = (saturated + report.saturated, greatest.max(report.hypotheses));
                joined += report.joined;
            }
        }
        assert!(greatest > most / 2 && saturated > 0 && joined > 0, "{most}: {greatest} {saturated} {joined}");
    }
}

#[test]
fn eight_of_24_features_and_8_tracks_take_64_kib() {
    assert!(size_of::<Room>() <= 65_536, "{}", size_of::<Room>());
}

fn saved(slam: &Several<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let sink = |part: &[u8]| -> Result<(), Infallible> {
        bytes.extend_from_slice(part);
        Ok(())
    };
    slam.save(7, sink).unwrap();
    bytes
}

#[test]
fn a_snapshot_goes_on_to_the_bit() {
    let [mut rooms, mut other] = [(); 2].map(|()| Room::new());
    let mut slam = rooms.several(8);
    slam.reset(PlanarPose::ZERO).unwrap();
    let (mut world, mut several) = (World::new(6), 0);
    for _ in 0..120 {
        step(&mut slam, &mut world);
        let bytes = saved(&slam);
        // Over what another one has left.
        let mut restored = other.several(8);
        restored.restore(7, from_slice(&bytes)).unwrap();
        assert_eq!((restored.digest(), restored.seal()), (slam.digest(), slam.seal()));
        assert_eq!((restored.hypotheses(), saved(&restored)), (slam.hypotheses(), bytes.clone()));
        let mut copy = World { draws: world.draws.clone(), ..world };
        let report = step(&mut restored, &mut copy);
        let mut again = Room::new();
        let mut again = again.several(8);
        again.restore(7, from_slice(&bytes)).unwrap();
        let mut copy = World { draws: world.draws.clone(), ..world };
        assert_eq!(step(&mut again, &mut copy), report);
        several += usize::from(slam.hypotheses() > 1);
        for cut in [0, 40, bytes.len() / 2, bytes.len() - 1] {
            assert!(again.restore(7, from_slice(&bytes[..cut])).is_err());
        }
        let mut one = Room::new();
        assert!(one.one().restore(7, from_slice(&bytes)).is_err());
    }
    assert!(several > 20, "{several}");
}

/// A filter with several hypotheses.
fn ambiguous(room: &mut Room) -> Several<'_> {
    let mut slam = room.several(8);
    slam.reset(PlanarPose::ZERO).unwrap();
    let mut world = World::new(6);
    while world.step < 70 || slam.hypotheses() < 3 {
        step(&mut slam, &mut world);
        assert!(world.step < 2000);
    }
    slam
}

#[test]
fn every_number_of_every_hypothesis_is_in_the_digest() {
    let mut room = Room::new();
    let mut slam = ambiguous(&mut room);
    let place = slam.alive().last().unwrap();
    let other = |slam: &mut Several<'_>, change: fn(&mut super::slot::Slot<'_, Pose32, Tracked<'_, Pose32>>)| {
        let (before, seal) = (slam.digest(), slam.seal());
        let bytes = saved(slam);
        change(&mut slam.others[place - 1]);
        assert_ne!(slam.digest(), before);
        assert_ne!(saved(slam), bytes);
        let sealed = slam.seal() != seal;
        slam.restore(7, from_slice(&bytes)).unwrap();
        assert_eq!((slam.digest(), slam.seal()), (before, seal));
        sealed
    };
    assert!(other(&mut slam, |slot| slot.weight.ln -= 1e-3));
    assert!(other(&mut slam, |slot| slot.header.pose.x_m += 1e-3));
    assert!(other(&mut slam, |slot| slot.numbers[0] *= 1.001));
    assert!(other(&mut slam, |slot| *slot.weight = Weight::NONE));
    assert!(!other(&mut slam, |slot| slot.landmarks[1].mean.x += 1e-3));
    assert!(!other(&mut slam, |slot| slot.landmarks[0].existence.visible *= 0.5));
    let last = slam.others[place - 1].header.len;
    assert!(last > 4);
    assert!(!other(&mut slam, |slot| slot.numbers[40] *= 1.001));
}

#[test]
fn damage_is_found_or_survived() {
    let mut draws = Noise::seeded(9);
    let bad = [f32::NAN, f32::INFINITY, -1.0, 1e30, 0.0];
    for round in 0..60 {
        let mut room = Room::new();
        let mut slam = ambiguous(&mut room);
        let mut pick = |n: usize| ((draws.uniform::<f32>() * n as f32) as usize).min(n - 1);
        let value = bad[pick(bad.len())];
        for slot in &mut slam.others {
            match round % 6 {
                0 => slot.weight.ln = value,
                1 => slot.header.len = 10_000,
                2 => slot.numbers[pick(200)] = value,
                3 => slot.landmarks[pick(8)].mean.x = value,
                4 => *slot.header = Header { waited_s: value, ..Header::ZERO },
                _ => slot.landmarks[0].measurement = pick(70_000) as u16,
            }
            slot.weight.alive = true;
        }
        let mut scrubber = HypothesesScrubber::new();
        if round % 2 == 0 {
            for _ in 0..100 {
                let _ = slam.scrub(&mut scrubber, 3);
            }
        }
        let mut world = World::new(round);
        let _ = (slam.audit(), slam.estimate_pose(), slam.digest(), slam.seal());
        for _ in 0..20 {
            let report = step(&mut slam, &mut world);
            assert!(report.hypotheses <= 8);
        }
        let pose = slam.likeliest().estimate_pose().unwrap();
        assert!(pose.mean.is_finite(), "{round}: {pose:?}");
    }
}

#[test]
fn scrubbing_leaves_what_is_sound_and_goes_round_all() {
    let [mut room, mut other] = [(); 2].map(|()| Room::new());
    let (mut slam, mut left) = (ambiguous(&mut room), ambiguous(&mut other));
    let parts: usize = slam.alive().map(|place| slam.estimate_of(place).unwrap().header.len + 1).sum();
    let (mut scrubber, mut rounds) = (HypothesesScrubber::new(), 0);
    for _ in 0..3 * parts + 60 {
        let scrubbed = slam.scrub(&mut scrubber, 1).unwrap();
        assert!(scrubbed.is_clean(), "{scrubbed:?}");
        rounds += usize::from(scrubbed.round);
    }
    assert!((1..=4).contains(&rounds), "{rounds}");
    assert_eq!(slam.digest(), left.digest());
    left.others[0].weight.alive = true;
    left.others[0].weight.ln = f32::NAN;
    assert!(left.audit().is_err());
    assert_eq!(left.scrub(&mut HypothesesScrubber::new(), 1).unwrap().isolated, 1);
    assert!(left.audit().is_ok());
}

/// A fix at one of two places that two hypotheses are at.
#[test]
fn a_fix_decides_between_hypotheses() {
    let mut room = Room::new();
    let mut slam = ambiguous(&mut room);
    let places: Vec<_> = slam.alive().map(|place| slam.estimate_of(place).unwrap().header.pose).collect();
    let target = *places.last().unwrap();
    let fix = PositionFix::new(0.01).unwrap();
    let report = slam.observe(&fix, &Vector2::new(target.x_m, target.y_m)).unwrap();
    assert!(report.accepted && report.ln_evidence.is_finite());
    let pose = slam.estimate_pose().unwrap().mean;
    assert!((pose.x_m - target.x_m).hypot(pose.y_m - target.y_m) < 0.1, "{pose:?} {target:?}");
    slam.relocate(target, &Symmetric::from_diagonal([0.1, 0.1, 0.1])).unwrap();
    assert_eq!(slam.hypotheses(), 1);
}

#[test]
fn what_is_out_of_range_is_refused() {
    let usual = HypothesesConfig::<f32>::default();
    for (config, field) in [
        (HypothesesConfig { most: 0, ..usual }, "most"),
        (HypothesesConfig { most: 17, ..usual }, "most"),
        (HypothesesConfig { joined_sigmas: f32::NAN, ..usual }, "joined_sigmas"),
        (HypothesesConfig { least_ratio: 1.5, ..usual }, "least_ratio"),
        (HypothesesConfig { least_share: -0.1, ..usual }, "least_share"),
    ] {
        assert_eq!(config.check().unwrap_err().field, field);
        let mut room = Room::new();
        assert!(room.several(2).configure_hypotheses(config).is_err());
        let Room { state, tracks, others } = &mut *room;
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.3)).unwrap();
        let slam = JointSlam::new(motion, JointConfig::default(), state).unwrap();
        let slam = slam.with_movers(tracks, MovingConfig::walkers()).unwrap();
        assert!(slam.with_hypotheses(others, config).is_err());
    }
    let mut room = Room::new();
    let mut slam = room.several(8);
    assert_eq!(slam.scan(&eyes(), &[]), Err(ScanError::NotStarted));
    slam.reset(PlanarPose::ZERO).unwrap();
    let before = slam.digest();
    assert!(slam.scan(&eyes(), &[Vector2::new(f32::NAN, 0.0)]).is_err());
    assert!(slam.scan(&eyes(), &[Vector2::new(1.0, 0.0); 17]).is_err());
    assert_eq!(slam.digest(), before);
    // Of other capacities.
    let mut few = JointMovers::<Pose32, 4>::new();
    let Room { state, others, .. } = &mut *room;
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.3)).unwrap();
    let slam = JointSlam::new(motion, JointConfig::default(), state).unwrap();
    let slam = slam.with_movers(&mut few, MovingConfig::walkers()).unwrap();
    assert!(slam.with_hypotheses(others, usual).is_err());
}
