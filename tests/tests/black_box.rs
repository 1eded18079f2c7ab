//! A replay of a black box from any of its snapshots ends in the same state, bit for bit, as a replay of all of it.

use nalgebra::Vector2;
use scphd::models::{PlanarPose, Pose};
use scphd::numerics::Symmetric;
use scphd::{Component, Real};
use scphd_boards::stream::{self, Recorded, Stream};
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions;
use scphd_log::log::{Fix, Log, Mounting, NamedSensor, PoseFix, Scan, Sensor};
use scphd_run::session::{self, Filter};
use scphd_stream::planar::{self, BlackBox, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers, Odometry, Planar};
use scphd_stream::underwater::{self, Underwater};
use scphd_stream::{
    Aboard, Header, How, Kind, Monitor, Reader, Record, Recovered, Refusal, ReplayError, Saves, Scalar, ScanCost, Seen,
    Which, Writer, find_snapshot, find_whole_snapshot, recover, rerecord,
};
use scphd_tests::with_roomy_stack;
use scphd_worlds::scenario;
use scphd_worlds::underwater::tank;
use std::f64::consts::{FRAC_PI_2, PI};

const SEED: u64 = 5;

#[derive(Debug, Default, PartialEq)]
pub(crate) struct Told {
    /// Index of the scan and digest.
    pub(crate) digests: Vec<(u32, u64)>,
    /// Number of scans before the snapshot, and whether its digest agrees.
    snapshots: Vec<(u32, bool)>,
    refused: Vec<(u32, Refusal)>,
}

impl Monitor for Told {
    fn scanned(&mut self, cost: &ScanCost, _seen: &Seen, digest: u64) {
        self.digests.push((cost.scan, digest));
    }

    fn snapshot(&mut self, scans: u32, agrees: bool) {
        self.snapshots.push((scans, agrees));
    }

    fn refused(&mut self, scan: u32, refusal: &Refusal) -> bool {
        self.refused.push((scan, *refusal));
        true
    }
}

/// Replays the readable part of a black box.
pub(crate) fn replayed<A: Aboard<T>, T: Real>(bytes: &[u8]) -> Result<(Recovered<A::Kind>, Told), ReplayError> {
    let (mut memory, mut told) = (Box::new(A::MEMORY), Told::default());
    recover::<A, T>(bytes, &mut memory, &mut told).map(|recovered| (recovered, told))
}

/// The stream with snapshots.
pub(crate) fn recorded<A: Aboard<T>, T: Real>(bytes: &[u8], every: u32) -> Vec<u8>
where
    for<'m> A::Filter<'m>: Saves<A::Kind>,
{
    let (mut memory, mut with_snapshots) = (Box::new(A::MEMORY), Vec::new());
    let sink = |piece: &[u8]| {
        with_snapshots.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    };
    rerecord::<A, T, _>(bytes, &mut memory, every, sink).unwrap();
    with_snapshots
}

/// Replays a black box with snapshots every `every` scans, completely and from each snapshot on.
pub(crate) fn ends_alike_from_every_snapshot<A: Aboard<T>, T: Real>(bytes: &[u8], every: u32) -> Told {
    let (whole, all) = replayed::<A, T>(bytes).unwrap();
    assert!(whole.ended && whole.gaps == 0);
    let scans = whole.totals.scans;
    let marks: Vec<u32> = (1..=scans / every).map(|k| k * every).collect();
    assert!(!marks.is_empty());
    assert_eq!(all.snapshots, marks.iter().map(|&scans| (scans, true)).collect::<Vec<_>>());
    let mut place = 0;
    for &mark in &marks {
        place = find_whole_snapshot::<A::Kind>(bytes, place + 1).unwrap();
        let (left, told) = replayed::<A, T>(&bytes[place..]).unwrap();
        assert!(left.ended && left.gaps == 0 && left.totals.scans == scans - mark);
        let from = all.digests.partition_point(|&(scan, _)| scan < mark);
        assert_eq!(told.digests, all.digests[from..], "from {mark}");
        assert_eq!(told.snapshots[0], (mark, true));
        if mark < scans {
            assert_eq!((left.totals.pose, left.totals.features), (whole.totals.pose, whole.totals.features));
        }
    }
    assert_eq!(find_snapshot::<A::Kind>(bytes, place + 1), None);
    all
}

/// A log and settings with this number of particles, which fit the capacities of the vehicle's filter.
fn with_room(mut log: Log, scans: usize, particles: usize, samples: usize) -> (Log, Settings) {
    log.scans.truncate(scans);
    let mut settings = Settings::for_log(&log);
    (settings.filter.particles, settings.filter.samples) = (particles, samples);
    (log, settings)
}

fn plain(log: &Log, settings: &Settings, filter: Recorded, scalar: Scalar) -> Stream {
    stream::write(log, settings, filter, SEED, scalar, usize::MAX).unwrap()
}

#[test]
fn cut_at_every_50th_scan_the_mixture_ends_alike() {
    with_roomy_stack(|| {
        let (log, settings) = with_room(scenario::survey(1), 201, 32, 2);
        let single = plain(&log, &settings, Recorded::Mixture, Scalar::F32).with_snapshots(Scalar::F32, 50).unwrap();
        ends_alike_from_every_snapshot::<BlackBox, f32>(&single.bytes, 50);
        let (log, settings) = with_room(scenario::by_name("thesis-dynamic", 1).unwrap(), 301, 16, 2);
        let moving = plain(&log, &settings, Recorded::Mixture, Scalar::F64).with_snapshots(Scalar::F64, 50).unwrap();
        ends_alike_from_every_snapshot::<BlackBox, f64>(&moving.bytes, 50);
    });
}

#[test]
fn cut_at_every_50th_scan_the_joint_map_ends_alike() {
    with_roomy_stack(|| {
        let (log, settings) = with_room(scenario::survey(1), 401, 1, 1);
        let single = plain(&log, &settings, Recorded::Joint, Scalar::F32).with_snapshots(Scalar::F32, 50).unwrap();
        let told = ends_alike_from_every_snapshot::<BlackBoxJoint, f32>(&single.bytes, 50);
        // Snapshots do not change the state: the filter without a black box has the same digests.
        let bare = replayed::<planar::PlanarJoint, f32>(&plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes)
            .unwrap()
            .1;
        assert_eq!(bare.digests, told.digests);
        let double = plain(&log, &settings, Recorded::Joint, Scalar::F64).with_snapshots(Scalar::F64, 50).unwrap();
        ends_alike_from_every_snapshot::<BlackBoxJoint, f64>(&double.bytes, 50);
    });
}

/// Moving-object tracks, and several hypotheses with tracks.
#[test]
fn cut_at_every_50th_scan_tracks_and_hypotheses_end_alike() {
    with_roomy_stack(|| {
        let (log, mut settings) = with_room(scenario::by_name("thesis-dynamic", 1).unwrap(), 201, 1, 1);
        settings.set_moving(true);
        let tracks = recorded::<BlackBoxMovers, f32>(&plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes, 50);
        ends_alike_from_every_snapshot::<BlackBoxMovers, f32>(&tracks, 50);
        // Ten times the noise of the odometry, so that detections have several possible causes.
        settings.vehicle.speed_sigma_mps *= 10.0;
        settings.vehicle.turn_sigma *= 10.0;
        let one = plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes;
        settings.joint.hypotheses = 8;
        let bytes = plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes;
        let several = recorded::<BlackBoxHypotheses, f32>(&bytes, 50);
        let told = ends_alike_from_every_snapshot::<BlackBoxHypotheses, f32>(&several, 50);
        assert_ne!(told.digests, replayed::<BlackBoxMovers, f32>(&one).unwrap().1.digests);
    });
}

/// A short dive that fits the capacities of the vehicle's filter, with the settings of the firmware's stream.
fn dive(scans: usize) -> Stream {
    let mut log = tank::girona_tank(1);
    log.scans.truncate(scans);
    // A frame between two samples of the instruments.
    log.scans[7].t_s += 0.03;
    let settings = scphd_filters::underwater::settings::Settings::for_log(&log);
    let mut settings = settings.with_toml(include_str!("../../firmware/girona-tank.toml")).unwrap();
    settings.filter.particles = 16;
    stream::write_underwater(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, usize::MAX).unwrap()
}

/// Snapshots under water include the velocity filter.
#[test]
fn a_dive_ends_alike_from_every_snapshot() {
    with_roomy_stack(|| {
        let dive = dive(25).with_snapshots_under_water(Scalar::F32, 5).unwrap();
        ends_alike_from_every_snapshot::<underwater::BlackBox, f32>(&dive.bytes, 5);
    });
}

/// The survey with two sensors, which look to the left and to the right, and with fixes of position and heading.
fn two_sensors_and_fixes(scans: usize) -> (Log, Settings) {
    let mut log = scenario::survey(1);
    log.scans.truncate(scans);
    let half = |yaw_rad| Sensor {
        bearing_min_rad: -FRAC_PI_2,
        bearing_max_rad: FRAC_PI_2,
        mounting: Mounting { yaw_rad, ..Mounting::NONE },
        ..log.sensor
    };
    let scans = log.scans.iter().flat_map(|scan| {
        [(0, 1.0), (1, -1.0)].map(|(sensor, side)| {
            let own = scan.detections.iter().filter(|[_, bearing]| side * bearing > 0.0);
            let detections = own.map(|&[range, bearing]| [range, bearing - side * FRAC_PI_2]).collect();
            Scan { t_s: scan.t_s, sensor, detections, ..Scan::default() }
        })
    });
    assert!(log.sensor.bearing_max_rad == PI && log.others.is_empty());
    let (left, right, scans) = (half(FRAC_PI_2), half(-FRAC_PI_2), scans.collect());
    log.others = vec![NamedSensor { name: "right".into(), sensor: right, nominal: log.nominal }];
    (log.sensor, log.sensor_name, log.scans) = (left, "left".into(), scans);
    let fixes = log.truth.iter().step_by(8).enumerate().map(|(k, truth)| Fix {
        t_s: truth.t_s,
        measured: match truth.heading_rad {
            Some(heading) if k % 2 == 1 => PoseFix::Heading(heading + 0.01),
            _ => PoseFix::Position([truth.position[0] + 0.2, truth.position[1]]),
        },
    });
    log.fixes = fixes.collect();
    log.fix_noise.position_sigma_m = Some(0.5);
    log.fix_noise.heading_sigma_rad = Some(0.05);
    (log.fix_noise.gate, log.fix_noise.forward_m, log.fix_noise.left_m) = (Some(30.0), -0.5, 0.25);
    let mut settings = Settings::for_log(&log);
    (settings.filter.particles, settings.filter.samples) = (16, 2);
    (log, settings)
}

#[test]
fn several_sensors_and_fixes_end_where_the_session_ends() {
    with_roomy_stack(|| {
        let (log, mut settings) = two_sensors_and_fixes(25);
        // Features outside of the reference are off, so that the vehicle's capacities do not change the state.
        settings.restrict_to_reference();
        assert!(!log.fixes.is_empty());
        let of = |filter| plain(&log, &settings, filter, Scalar::F32);
        let mixture = of(Recorded::Mixture);
        // A vehicle's filter without a black box refuses fixes.
        let refusal = scphd_stream::replay::<Planar, f32>(
            &mixture.bytes,
            &mut Box::new(<Planar as Aboard<f32>>::MEMORY),
            u32::MAX,
            &mut Strict,
        );
        assert_eq!(refusal.err(), Some(ReplayError::Step { scan: 0, refusal: Refusal::NotAboard }));
        let filter = Filter::Core(Precision::F32);
        let session = session::run::<dimensions::Planar>(&log, &settings, filter, SEED, &mut |_| ()).unwrap();
        let bytes = mixture.with_snapshots(Scalar::F32, 10).unwrap().bytes;
        let told = ends_alike_from_every_snapshot::<BlackBox, f32>(&bytes, 10);
        assert_eq!((told.digests.len(), told.digests.last().map(|&(_, digest)| digest)), (50, session.summary.digest));
        let bytes = of(Recorded::Joint).with_snapshots(Scalar::F32, 10).unwrap().bytes;
        assert_eq!(ends_alike_from_every_snapshot::<BlackBoxJoint, f32>(&bytes, 10).digests.len(), 50);
    });
}

/// Stops at the first refusal.
struct Strict;

impl Monitor for Strict {
    fn scanned(&mut self, _: &ScanCost, _: &Seen, _: u64) {}
}

/// The map of an earlier drive.
fn map() -> Vec<Component<Vector2<f32>>> {
    let post = |(label, [x, y]): (u32, [f32; 2])| Component {
        label,
        ln_weight: -0.125,
        mean: Vector2::new(x, y),
        covariance: Symmetric::from_fn(|row, column| if row == column { 0.0625 } else { 0.01 }),
    };
    (3..).zip([[4.0, 2.0], [8.0, -3.0], [2.0, 7.0]]).map(post).collect()
}

/// A stream with all kinds of records, whose first scans and predictions are those of another stream. One prediction and one scan
/// are such that filters refuse them.
fn with_everything(of: &Stream, localising: bool) -> Vec<u8> {
    let mut reader = Reader::<Planar>::open(&of.bytes).unwrap();
    let header = reader.header();
    let mut described = header.description::<f64>().unwrap();
    let first = described.sensors[0].unwrap();
    let mut bytes = Vec::new();
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    };
    let Ok(mut log) = Writer::start(&header, sink);
    let second = Which::number(1).unwrap();
    let doubt = Symmetric::from_diagonal([0.04_f32, 0.04, 0.0004]);
    let mut scans = 0;
    let write = || -> Result<(), std::convert::Infallible> {
        while let Some(record) = reader.read().unwrap() {
            match record {
                Record::Predict(input) => log.predict(&input)?,
                Record::Scan(measurements) => {
                    let measurements: Vec<_> = measurements.collect();
                    scans += 1;
                    match scans {
                        4 => log.map(&map())?,
                        7 => {
                            let (pose, sigma_m) = (PlanarPose::new(0.5_f32, 0.25, 0.1), 0.0);
                            log.place(How::Relocate, &pose, &doubt, 0)?;
                            // Without any noise: refused by the filter on the vehicle and by that of the replay.
                            log.fix(&planar::Fix::Position {
                                place_m: [0.0; 2],
                                sigma_m,
                                gate: 9.0,
                                antenna_m: [0.0; 2],
                            })?;
                        }
                        11 => {
                            let mut sensor = first;
                            (sensor.seat_m[0], sensor.window.range_max_m) = (0.5, 12.0);
                            log.detector(second, &sensor.numbers())?;
                        }
                        12..=15 => log.scan_of(second, &measurements)?,
                        16 => {
                            let mut sensor = first;
                            (sensor.seat_m[0], sensor.clutter_per_scan) = (0.5, 7.0);
                            described.sensors[1] = Some(sensor);
                            log.detector(second, &sensor.numbers())?;
                        }
                        18 => {
                            described.sensors[0].as_mut().unwrap().range_sigma_m *= 1.5;
                            described.vehicle.noise.speed_sigma_mps *= 2.0;
                            match &mut described.filter {
                                scphd_vehicle::Filter::Mixture(config) => config.merge_distance = 3.0,
                                scphd_vehicle::Filter::Joint(joint) => joint.config.occlusion_factor = 0.25,
                            }
                            log.retune(&Header::of(&described, Scalar::F32).unwrap())?;
                        }
                        22 => log.place(How::Scatter, &PlanarPose::<f32>::ZERO, &doubt, 0)?,
                        26 => log.scan(&[[f64::NAN, 0.0]])?,
                        28 if localising => log.localise(second, &measurements)?,
                        30 => log.fix(&planar::Fix::Beacon {
                            measured: [5.0, 0.25],
                            sigmas: [0.5, 0.1],
                            gate: f64::INFINITY,
                            place_m: [5.0, 1.5],
                            mounted: [0.5, 0.0, 0.1],
                        })?,
                        33 => log.predict(&Odometry { control: [f64::INFINITY, 0.0, 0.0], dt_s: 0.1 })?,
                        35 => log.place(How::ResetWithin, &PlanarPose::new(1.0_f32, 2.0, 0.5), &doubt, 1 << 60)?,
                        _ => {}
                    }
                    log.scan(&measurements)?;
                }
                other => panic!("{other:?}"),
            }
        }
        log.end()
    };
    let Ok(()) = write();
    bytes
}

#[test]
fn every_input_that_changes_the_state_is_replayed() {
    with_roomy_stack(|| {
        let (log, settings) = with_room(scenario::survey(1), 40, 32, 2);
        let of = |filter| plain(&log, &settings, filter, Scalar::F32);
        let mixture = recorded::<BlackBox, f32>(&with_everything(&of(Recorded::Mixture), false), 5);
        let told = ends_alike_from_every_snapshot::<BlackBox, f32>(&mixture, 5);
        let refused = |told: &Told| {
            let [(_, fix), (_, scan), (_, moved)] = told.refused[..] else { panic!("{:?}", told.refused) };
            assert!(matches!((fix, scan, moved), (Refusal::Model(_), Refusal::Scan(_), Refusal::Predict(_))));
        };
        refused(&told);
        let joint = recorded::<BlackBoxJoint, f32>(&with_everything(&of(Recorded::Joint), true), 5);
        refused(&ends_alike_from_every_snapshot::<BlackBoxJoint, f32>(&joint, 5));
    });
}

/// Missing, duplicated and swapped records are detected, although records have no numbers.
#[test]
fn missing_duplicated_and_swapped_records_are_detected() {
    let (log, settings) = with_room(scenario::survey(1), 2, 4, 1);
    let bytes = plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes;
    let mut reader = Reader::<Planar>::open(&bytes).unwrap();
    let mut places = vec![bytes.len() - reader.left()];
    while reader.read().unwrap().is_some() {
        places.push(bytes.len() - reader.left());
    }
    let record = |k: usize| &bytes[places[k]..places[k + 1]];
    let read = |bytes: &[u8]| {
        let mut reader = Reader::<Planar>::open(bytes).unwrap();
        while reader.read()?.is_some() {}
        Ok::<(), scphd_stream::StreamError>(())
    };
    assert_eq!(read(&bytes), Ok(()));
    let last = places.len() - 1;
    assert!(last > 3);
    for k in 0..last - 1 {
        let front = &bytes[..places[k]];
        let missing = [front, &bytes[places[k + 1]..]].concat();
        let doubled = [front, record(k), &bytes[places[k]..]].concat();
        let swapped = [front, record(k + 1), record(k), &bytes[places[k + 2]..]].concat();
        for (what, bytes) in [("missing", missing), ("doubled", doubled), ("swapped", swapped)] {
            // Predictions with equal controls are equal records, so that swapping them changes nothing.
            let same =
                what == "swapped" && record(k)[..record(k).len() - 4] == record(k + 1)[..record(k + 1).len() - 4];
            assert!(same || read(&bytes).is_err(), "{what} {k}");
        }
    }
}

/// The survey with a joint map and a snapshot every ten scans, and its digests.
fn small() -> (Vec<u8>, Told) {
    let (log, settings) = with_room(scenario::survey(1), 60, 1, 1);
    let bytes = recorded::<BlackBoxJoint, f32>(&plain(&log, &settings, Recorded::Joint, Scalar::F32).bytes, 10);
    let told = replayed::<BlackBoxJoint, f32>(&bytes).unwrap().1;
    (bytes, told)
}

fn snapshots<K: Kind>(bytes: &[u8]) -> Vec<usize> {
    let mut places = Vec::new();
    let mut from = 0;
    while let Some(place) = find_snapshot::<K>(bytes, from) {
        places.push(place);
        from = place + 1;
    }
    places
}

#[test]
fn a_torn_off_beginning_is_replayed_from_the_next_snapshot() {
    with_roomy_stack(|| {
        let (bytes, all) = small();
        let places = snapshots::<Planar>(&bytes);
        assert_eq!(places.len(), 6);
        // Torn off at various bytes.
        for torn in (1..bytes.len()).step_by(997) {
            let next = places.iter().position(|&place| place >= torn);
            match (replayed::<BlackBoxJoint, f32>(&bytes[torn..]), next) {
                (Ok((left, told)), Some(next)) => {
                    assert_eq!(told.digests, all.digests[10 * (next + 1)..], "torn at {torn}");
                    assert!(left.ended && left.gaps == u32::from(places[next] > torn));
                }
                (Err(error), None) => assert!(matches!(error, ReplayError::Stream(_))),
                (other, _) => panic!("torn at {torn}: {other:?}"),
            }
        }
    });
}

#[test]
fn after_damage_the_replay_continues_at_the_next_snapshot() {
    with_roomy_stack(|| {
        let (bytes, all) = small();
        let places = snapshots::<Planar>(&bytes);
        for damaged in (Header::<Planar>::LENGTH..bytes.len()).step_by(1499) {
            let mut bytes = bytes.clone();
            // A burst error, such as a page of flash that was not written.
            bytes.iter_mut().skip(damaged).take(40).for_each(|byte| *byte = !*byte);
            let (left, told) = replayed::<BlackBoxJoint, f32>(&bytes).unwrap();
            let next = places.iter().position(|&place| place >= damaged + 40);
            let from = next.map_or(60, |next| 10 * (next as u32 + 1));
            // Up to the damage, and from the next snapshot on, all states are correct.
            let (before, after): (Vec<_>, Vec<_>) = told.digests.iter().copied().partition(|(scan, _)| *scan < from);
            assert!(all.digests.starts_with(&before) && from < before.len() as u32 + 21, "damaged at {damaged}");
            assert_eq!(after, all.digests[from as usize..], "damaged at {damaged}");
            assert_eq!((left.ended, left.gaps > 0), (next.is_some(), next.is_some()));
            assert!(told.snapshots.iter().all(|&(_, agrees)| agrees));
        }
    });
}

#[test]
fn a_snapshot_of_another_filter_is_refused_by_name() {
    with_roomy_stack(|| {
        let (bytes, _) = small();
        let place = find_whole_snapshot::<Planar>(&bytes, 1).unwrap();
        let error = replayed::<BlackBox, f32>(&bytes[place..]).unwrap_err();
        assert_eq!(error.to_string(), "the filter refuses the stream header: the memory is not for what filter says");
        let error = replayed::<underwater::BlackBox, f32>(&bytes).unwrap_err();
        assert_eq!(error.to_string(), "the stream is for another type of vehicle: 0");
        assert_eq!(find_snapshot::<Underwater>(&bytes, 0), None);
    });
}
