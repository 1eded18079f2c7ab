//! Streams: with all kinds of records and hostile numbers under correct checksums, with snapshots; also damaged,
//! truncated and concatenated. A replay finishes or reports an error; the states that it reaches from a damaged stream are those
//! from the undamaged one.

use super::counts::count;
use super::draw::Draw;
use super::session::Seeded;
use super::{Failure, Operations, Run, Watch, named, require};
use nalgebra::Vector2;
use scphd::models::{OdometryCorrection, OdometryPrior};
use scphd::models::{PlanarPose, Reading};
use scphd::navigation::Instruments;
use scphd::numerics::Symmetric;
use scphd::settings::{Extraction, HypothesesConfig, Informed, MovingConfig, Persistence, Proposal};
use scphd::{Births, Component, Config, Real};
use scphd_stream::planar::{
    self, BlackBox, BlackBoxArchive, BlackBoxCalibrated, BlackBoxHypotheses, BlackBoxJoint, Odometry, Planar,
    PlanarJoint, PlanarJointMovers,
};
use scphd_stream::underwater::{self, Navigation, Underwater, UnderwaterJoint};
use scphd_stream::{
    Aboard, Header, How, Kind, Monitor, Numbers, Refusal, ReplayError, Saves, Scalar, ScanCost, Seen, Which, Writer,
    recover, replay, rerecord,
};
use scphd_vehicle::{Description, Filter, JointSettings, Sensor, Setting, VehicleKind};
use std::convert::Infallible;

/// Maximum number of scans in a stream.
const SCANS: usize = 12;

#[derive(Debug, Default, PartialEq)]
struct Told {
    /// Index of the scan and digest.
    digests: Vec<(u32, u64)>,
    /// Number of snapshots whose digest agrees, and number of others.
    agree: [usize; 2],
    refused: usize,
}

impl Monitor for Told {
    fn scanned(&mut self, cost: &ScanCost, _: &Seen, digest: u64) {
        self.digests.push((cost.scan, digest));
    }

    fn snapshot(&mut self, _: u32, agrees: bool) {
        self.agree[usize::from(!agrees)] += 1;
    }

    fn refused(&mut self, _: u32, _: &Refusal) -> bool {
        self.refused += 1;
        true
    }
}

/// A filter with streams for it.
trait Vessel<T: Real>: Aboard<T> {
    const NAME: &'static str;
    /// A random stream without snapshots.
    fn stream(draw: &mut Draw) -> Vec<u8>;
    /// The stream with snapshots at this interval of scans, if the filter supports it.
    fn with_snapshots(bytes: &[u8], memory: &mut Self::Memory, every: u32) -> Option<Vec<u8>>;
}

fn kept<A: Aboard<T>, T: Real>(bytes: &[u8], memory: &mut A::Memory, every: u32) -> Option<Vec<u8>>
where
    for<'m> A::Filter<'m>: Saves<A::Kind>,
{
    let mut kept = Vec::new();
    let sink = |piece: &[u8]| {
        kept.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let recorded = rerecord::<A, T, _>(bytes, memory, every, sink);
    count("record with snapshots", &recorded);
    recorded.ok().map(|()| kept)
}

macro_rules! vessels {
    ($($vessel:ty: $name:literal, $stream:ident of $filter:ident, $snapshots:ident;)*) => {$(
        impl<T: Real> Vessel<T> for $vessel {
            const NAME: &'static str = $name;

            fn stream(draw: &mut Draw) -> Vec<u8> {
                let filter = $filter(draw);
                $stream::<T>(draw, filter)
            }

            fn with_snapshots(bytes: &[u8], memory: &mut Self::Memory, every: u32) -> Option<Vec<u8>> {
                vessels!(@$snapshots $vessel, bytes, memory, every)
            }
        }
    )*};
    (@keeps $vessel:ty, $bytes:ident, $memory:ident, $every:ident) => { kept::<$vessel, T>($bytes, $memory, $every) };
    (@bare $vessel:ty, $bytes:ident, $memory:ident, $every:ident) => {{
        let _ = ($bytes, $memory, $every);
        None
    }};
}

vessels! {
    Planar: "in the plane", drive of mixture, bare;
    PlanarJoint: "joint map", drive of joint, bare;
    PlanarJointMovers: "joint map with movers", drive of with_movers, bare;
    BlackBox: "black box", drive of mixture, keeps;
    BlackBoxJoint: "black box of a joint map", drive of joint, keeps;
    BlackBoxArchive: "black box of a joint map with an archive", drive of with_archive, keeps;
    BlackBoxHypotheses: "black box of several hypotheses", drive of with_hypotheses, keeps;
    BlackBoxCalibrated: "black box with calibrated odometry", drive of calibrated, keeps;
    Underwater: "under water", dive of mixture, bare;
    UnderwaterJoint: "joint map under water", dive of joint, bare;
    underwater::BlackBox: "black box under water", dive of mixture, keeps;
}

fn scalar<T: Real>(draw: &mut Draw) -> Scalar {
    let own = if size_of::<T>() == 4 { Scalar::F32 } else { Scalar::F64 };
    let other = if size_of::<T>() == 4 { Scalar::F64 } else { Scalar::F32 };
    if draw.chance(0.9) { own } else { other }
}

/// The same numbers, each possibly replaced by a hostile one.
fn spoilt<N: Numbers>(draw: &mut Draw, numbers: &N) -> N {
    let mut all = Vec::with_capacity(N::COUNT);
    numbers.put(&mut |number| all.push(number));
    let mut all = all.into_iter();
    N::take(&mut || all.next().map(|number| draw.spoilt(number))).unwrap_or(N::ZERO)
}

/// A mixture with random tuning.
fn mixture(draw: &mut Draw) -> Filter<f64> {
    let informed =
        Informed { rounds: 1 + draw.below(4), sampled_fraction: draw.even(0.0, 1.0), min_responsibility: 1e-3 };
    Filter::Mixture(Config {
        particles: if draw.chance(0.05) { draw.word() as u32 as usize } else { 1 + draw.below(4) },
        samples: if draw.chance(0.05) { draw.word() as u32 as usize } else { 1 + draw.below(2) },
        proposal: [Proposal::Blind, Proposal::Informed(informed)][draw.below(2)],
        extraction: [Extraction::Heaviest, Extraction::Peaks, Extraction::Confirmed][draw.below(3)],
        prune_weight: draw.magnitude(1e-6, 0.05),
        confirming_detections: draw.even(1.0, 4.0),
        merge_distance: draw.even(0.0, 9.0),
        births_wait: draw.chance(0.1),
        ..Config::default()
    })
}

fn joint_settings(draw: &mut Draw) -> JointSettings<f64> {
    let mut joint = JointSettings::default();
    joint.config.persistence = Persistence { visible_s: draw.magnitude(1.0, 1e3), occluded_s: 5.0, lifetime_s: 1e4 };
    joint.config.occlusion_factor = draw.even(0.0, 1.0);
    joint
}

/// Joint maps with random tuning.
fn joint(draw: &mut Draw) -> Filter<f64> {
    Filter::Joint(joint_settings(draw))
}

fn with_movers(draw: &mut Draw) -> Filter<f64> {
    Filter::Joint(JointSettings { movers: Some(MovingConfig::walkers()), ..joint_settings(draw) })
}

fn with_archive(draw: &mut Draw) -> Filter<f64> {
    let (movers, archive_reach_m) = (Some(MovingConfig::walkers()), Some(draw.magnitude(1.0, 100.0)));
    Filter::Joint(JointSettings { movers, archive_reach_m, ..joint_settings(draw) })
}

fn with_hypotheses(draw: &mut Draw) -> Filter<f64> {
    let hypotheses = HypothesesConfig { most: 1 + draw.below(9), ..HypothesesConfig::default() };
    let (movers, hypotheses) = (Some(MovingConfig::walkers()), Some(hypotheses));
    Filter::Joint(JointSettings { movers, hypotheses, ..joint_settings(draw) })
}

fn calibrated(draw: &mut Draw) -> Filter<f64> {
    let sigma = OdometryCorrection { speed_scale: 0.1, turn_scale: 0.1, turn_offset: draw.even(0.0, 0.1) };
    let odometry = Some(OdometryPrior { sigma, lasts_s: draw.magnitude(1.0, 1e4) });
    Filter::Joint(JointSettings { odometry, ..joint_settings(draw) })
}

/// A head with these models; some numbers are hostile, as in the tuning of a change.
fn header<K: Kind>(draw: &mut Draw, of: &Description<f64>, models: &K::Models, scalar: Scalar) -> Header<K> {
    let mut header = Header { scan_interval_s: 0.1, ..Header::with(of, spoilt(draw, models), scalar) };
    let seed = Setting::of_name("start.seed").unwrap().place();
    header.settings[seed] = f64::from_bits(draw.word());
    header.settings.iter_mut().filter(|setting| **setting != 0.0).for_each(|setting| *setting = draw.spoilt(*setting));
    if draw.chance(0.02) {
        // Also a choice, or a number that the description does not have.
        let place = draw.below(header.settings.len());
        header.settings[place] = draw.real(-1.0, 9.0);
    }
    header
}

type Log<'a, K> = Writer<K, &'a mut dyn FnMut(&[u8]) -> Result<(), Infallible>>;

/// Writes a stream to a vector.
fn written<K: Kind>(header: &Header<K>, write: impl FnOnce(&mut Log<'_, K>) -> Result<(), Infallible>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok(())
    };
    let sink: &mut dyn FnMut(&[u8]) -> Result<(), Infallible> = &mut sink;
    let Ok(mut log) = Writer::start(header, sink);
    let Ok(()) = write(&mut log);
    let Ok(()) = log.end();
    bytes
}

fn drive<T: Real>(draw: &mut Draw, filter: Filter<f64>) -> Vec<u8> {
    let mut sensor = Sensor::range_bearing(12.0, 0.9, [0.1, 0.01]);
    sensor.window.bearing_half_width_rad = draw.even(1.0, 3.5);
    sensor.window.probability_far = 0.8;
    sensor.clutter_per_scan = draw.even(0.1, 5.0);
    sensor.births =
        Births { of_static: draw.magnitude(1e-4, 0.1), of_moving: if draw.chance(0.3) { 1e-3 } else { 0.0 } };
    sensor.range_sigma_ratio = if draw.chance(0.3) { 0.02 } else { 0.0 };
    sensor.seat_m = [draw.even(0.0, 1.0), 0.0];
    let mut robot = Description { filter, ..Description::robot() };
    robot.vehicle.kind =
        [VehicleKind::Ackermann, VehicleKind::UnicycleEuler, VehicleKind::Unicycle, VehicleKind::Holonomic]
            [draw.below(4)];
    robot.vehicle.geometry.wheelbase_m = 2.0;
    robot.sensors[0] = Some(sensor);
    if draw.chance(0.3) {
        (robot.start.position_sigma_m, robot.start.heading_sigma_rad) = (0.5, 0.1);
    }
    let scalar = scalar::<T>(draw);
    let header: Header<Planar> = header(draw, &robot, &[], scalar);
    written(&header, |log| {
        for _ in 0..1 + draw.below(SCANS) {
            for _ in 0..draw.below(3) {
                let left_mps = if draw.chance(0.2) { draw.real(-0.5, 0.5) } else { 0.0 };
                let control = [draw.real(-1.0, 3.0), draw.real(-0.4, 0.4), left_mps];
                log.predict(&Odometry { control, dt_s: draw.real(0.0, 0.2) })?;
            }
            let scan: Vec<[f64; 2]> =
                (0..draw.below(9)).map(|_| [draw.real(0.5, 12.0), draw.real(-3.1, 3.1)]).collect();
            let which = Which::number(draw.below(4) as u8).unwrap_or(Which::FIRST);
            match draw.below(24) {
                0 => log.map(&map(draw))?,
                1 => {
                    let how = [How::Reset, How::ResetWithin, How::Relocate, How::Scatter][draw.below(4)];
                    let pose = PlanarPose::<f64>::new(draw.real(-9.0, 9.0), draw.real(-9.0, 9.0), draw.real(-3.0, 3.0));
                    let doubt =
                        Symmetric::from_diagonal([draw.real(0.0, 1.0), draw.real(0.0, 1.0), draw.real(0.0, 0.1)]);
                    log.place(how, &pose, &doubt, draw.word())?;
                }
                2 | 3 => {
                    let sensor = spoilt(draw, &sensor.numbers());
                    log.detector(which, &sensor)?;
                }
                4 | 5 => log.scan_of(which, &scan)?,
                6 => log.localise(which, &scan)?,
                8 => {
                    let retuned = super::streams::header(draw, &robot, &[], scalar);
                    log.retune(&retuned)?;
                }
                9..12 => log.fix(&fix(draw))?,
                _ => (),
            }
            log.scan(&scan)?;
        }
        Ok(())
    })
}

fn fix(draw: &mut Draw) -> planar::Fix {
    let gate = if draw.chance(0.5) { f64::INFINITY } else { draw.real(1.0, 30.0) };
    match draw.below(3) {
        0 => planar::Fix::Position {
            place_m: [draw.real(-9.0, 9.0), draw.real(-9.0, 9.0)],
            sigma_m: draw.real(0.1, 1.0),
            gate,
            antenna_m: [draw.real(-1.0, 1.0), draw.real(-1.0, 1.0)],
        },
        1 => planar::Fix::Heading { heading_rad: draw.real(-3.0, 3.0), sigma_rad: draw.real(0.01, 0.1), gate },
        _ => planar::Fix::Beacon {
            measured: [draw.real(1.0, 9.0), draw.real(-3.0, 3.0)],
            sigmas: [draw.real(0.1, 1.0), draw.real(0.01, 0.1)],
            gate,
            place_m: [draw.real(-9.0, 9.0), draw.real(-9.0, 9.0)],
            mounted: [draw.real(-1.0, 1.0), draw.real(-1.0, 1.0), draw.real(-3.0, 3.0)],
        },
    }
}

fn map(draw: &mut Draw) -> Vec<Component<Vector2<f64>>> {
    (0..draw.below(12))
        .map(|label| Component {
            label: if draw.chance(0.1) { draw.word() as u32 } else { label as u32 },
            ln_weight: draw.real(-1.0, 0.0),
            mean: Vector2::new(draw.real(-9.0, 9.0), draw.real(-9.0, 9.0)),
            covariance: Symmetric::from_fn(|row, column| {
                let variance: f64 = draw.real(0.01, 0.04);
                if row == column { variance } else { 0.1 * variance }
            }),
        })
        .collect()
}

fn dive<T: Real>(draw: &mut Draw, filter: Filter<f64>) -> Vec<u8> {
    let mut models = underwater::Models::ZERO;
    (models.start_m, models.velocity_walk_mps_rts, models.velocity_sigma_mps) = ([0.0, 0.0, 2.0], 0.1, 0.1);
    (models.z_sigma_m, models.gate_sigmas, models.outliers_believed) = (0.02, 4.0, 5.0);
    (models.yaw_acceleration_sigma_radps2, models.velocity_interval_s) = (0.05, 1.0);
    // Both cameras look down, side by side.
    models.projections =
        [0.06, -0.06].map(|y| [[0.0, -500.0, -400.0, 500.0 * y], [-500.0, 0.0, -300.0, 0.0], [0.0, 0.0, -1.0, 0.0]]);
    (models.pixel_sigmas, models.common_sigmas, models.epipolar_gate) = ([1.0; 4], [0.5; 2], 16.0);
    (models.size_px, models.edge_px, models.near_m, models.far_m) = ([800.0, 600.0], 5.0, 0.5, 4.0);
    (models.depth_edge_m, models.detection, models.clutter_per_scan) = (0.1, 0.8, 3.0);
    (models.disparities_px, models.row_tolerance_px) = ([10.0, 200.0], 5.0);
    let scalar = scalar::<T>(draw);
    let births = Births::of_static(draw.magnitude(1e-4, 0.1));
    let mut vehicle = Description { filter, ..Description::robot() };
    vehicle.sensors[0] = Some(Sensor { births, ..Sensor::range_bearing(1.0, 0.5, [1.0; 2]) });
    let header: Header<Underwater> = header(draw, &vehicle, &models, scalar);
    written(&header, |log| {
        for _ in 0..1 + draw.below(SCANS / 2) {
            let row = Instruments {
                roll_rad: draw.real(-0.1, 0.1),
                pitch_rad: draw.real(-0.1, 0.1),
                yaw_rate_radps: Reading { value: draw.real(-0.2, 0.2), sigma: draw.real(0.01, 0.05) },
                velocity_mps: draw.chance(0.7).then(|| [draw.real(-1.0, 1.0), draw.real(-0.1, 0.1), 0.0]),
                z_m: draw.chance(0.7).then(|| draw.real(1.5, 2.5)),
            };
            log.predict(&Navigation { dt_s: draw.real(0.0, 0.2), instruments: draw.chance(0.8).then_some(row) })?;
            let frame: Vec<[f64; 4]> = (0..draw.below(7))
                .map(|_| {
                    let (u, v) = (draw.real(0.0, 800.0), draw.real(0.0, 600.0));
                    [u, v, u - draw.even(15.0, 60.0), v + draw.even(-2.0, 2.0)]
                })
                .collect();
            match draw.below(12) {
                1 => log.scan(&frame)?,
                2 => {
                    let retuned = super::streams::header(draw, &vehicle, &models, scalar);
                    log.retune(&retuned)?;
                }
                _ => (),
            }
            log.scan(&frame)?;
        }
        Ok(())
    })
}

/// Damages a stream. Returns a description.
fn damage(draw: &mut Draw, bytes: &mut Vec<u8>, other: &[u8]) -> &'static str {
    let len = bytes.len().max(1);
    match draw.below(8) {
        0 => {
            for _ in 0..1 + draw.below(8) {
                let bit = draw.below(8 * len);
                bytes.iter_mut().skip(bit / 8).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
            }
            "bits flipped"
        }
        1 => {
            bytes.truncate(draw.below(len));
            "cut"
        }
        2 => {
            bytes.drain(..draw.below(len));
            "torn off"
        }
        3 => {
            let from = draw.below(len);
            let to = (from + 1 + draw.below(400)).min(bytes.len());
            bytes.drain(from.min(to)..to);
            "a piece left out"
        }
        4 => {
            let from = draw.below(len);
            let piece: Vec<u8> = bytes.iter().skip(from).take(1 + draw.below(400)).copied().collect();
            bytes.splice(from..from, piece);
            "a piece twice"
        }
        5 => {
            let at = draw.below(len);
            bytes.splice(at.., other.iter().skip(draw.below(other.len().max(1))).copied());
            "glued to another"
        }
        6 => {
            let from = draw.below(len);
            bytes.iter_mut().skip(from).take(1 + draw.below(64)).for_each(|byte| *byte = 0xff);
            "a page that was not written"
        }
        _ => {
            let from = draw.below(len);
            bytes.iter_mut().skip(from).for_each(|byte| *byte = draw.word() as u8);
            "noise from there on"
        }
    }
}

/// An operation on a stream: replay, record with snapshots, replay, damage, replay.
fn operation<A: Vessel<T>, T: Real>(draw: &mut Draw, memory: &mut A::Memory, told: &mut String) -> Result<(), String> {
    let bytes = A::stream(draw);
    *told = format!("{}: {} bytes", A::NAME, bytes.len());
    let mut plain = Told::default();
    let replayed = replay::<A, T>(&bytes, memory, u32::MAX, &mut plain);
    count("replay", &replayed);
    let start = matches!(replayed, Err(ReplayError::Start(_)));
    require(replayed.is_ok() || start, || format!("a whole stream: {replayed:?}"))?;
    if start {
        return Ok(());
    }
    let every = 1 + draw.below(4) as u32;
    let with_snapshots = A::with_snapshots(&bytes, memory, every);
    let (mut bytes, mut whole, kept) = (bytes, plain, with_snapshots.is_some());
    if let Some(kept) = with_snapshots {
        let mut told_then = Told::default();
        let recovered = recover::<A, T>(&kept, memory, &mut told_then);
        let recovered = recovered.map_err(|error| format!("a black box: {error}"))?;
        require(recovered.ended && recovered.gaps == 0, || format!("gaps in a whole black box: {recovered:?}"))?;
        require(told_then.digests == whole.digests, || "snapshots change the states".into())?;
        require(told_then.agree[1] == 0, || "a snapshot of another state".into())?;
        (bytes, whole) = (kept, told_then);
    }
    let other = A::stream(draw);
    let glued = [&bytes[..], &other].concat();
    let behind = if draw.chance(0.5) { &other } else { &glued };
    let damaged = damage(draw, &mut bytes, behind);
    told.push_str(&format!(", {damaged}"));
    if !kept {
        // A filter without a black box requires cleared memory.
        *memory = A::MEMORY;
    }
    let mut left = Told::default();
    let recovered = recover::<A, T>(&bytes, memory, &mut left);
    count("replay what is left", &recovered);
    require(left.agree[1] == 0, || "a damaged snapshot was taken".into())?;
    // After concatenation the scans may be of either stream.
    let known = |told: &(u32, u64)| whole.digests.contains(told);
    let of_either = damaged == "glued to another";
    require(of_either || left.digests.iter().all(known), || format!("{damaged}: a state that never was"))?;
    require(of_either || left.digests.len() <= 2 * whole.digests.len(), || "more scans than there were".into())
}

fn run<A: Vessel<T>, T: Real>(seeded: Seeded, operations: &Operations<'_>, watch: &Watch) -> Result<(), Failure> {
    let mut memory = Box::new(A::MEMORY);
    for &index in operations.indices {
        watch.at(seeded.seed, index);
        // A filter with other sizes does not continue with the previous state.
        *memory = A::MEMORY;
        let mut draw = seeded.draw(index);
        let mut told = String::new();
        let done = operation::<A, T>(&mut draw, &mut memory, &mut told);
        if operations.tell {
            println!("  {index}: {told}");
        }
        done.map_err(|what| Failure { operation: index, what: format!("{told}: {what}") })?;
    }
    Ok(())
}

/// The kind of session of a seed.
pub(super) fn kind_of(seed: u64) -> (String, Run) {
    let (seeded, mut draw) = Seeded::of(seed, 0x57e4);
    type Session = fn(Seeded, &Operations<'_>, &Watch) -> Result<(), Failure>;
    fn of<A: Vessel<T>, T: Real>() -> (&'static str, Session) {
        (A::NAME, run::<A, T>)
    }
    let kinds = [
        of::<Planar, f32>(),
        of::<PlanarJoint, f32>(),
        of::<PlanarJointMovers, f32>(),
        of::<BlackBox, f32>(),
        of::<BlackBox, f64>(),
        of::<BlackBoxJoint, f32>(),
        of::<BlackBoxJoint, f64>(),
        of::<BlackBoxCalibrated, f32>(),
        of::<BlackBoxArchive, f32>(),
        of::<BlackBoxHypotheses, f32>(),
        of::<Underwater, f32>(),
        of::<UnderwaterJoint, f32>(),
        of::<underwater::BlackBox, f32>(),
    ];
    let (name, run) = kinds[draw.below(kinds.len())];
    named(&format!("streams, {name}"), seeded, run)
}
