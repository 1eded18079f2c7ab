//! A replay of a stream by the code of vehicles ends in the same state as the simulator's session with the log.

use scphd::Real;
use scphd_boards::stream::{self, Recorded};
use scphd_filters::settings::{CalibrationSettings, Settings};
use scphd_filters::slam::Precision;
use scphd_log::dimensions;
use scphd_log::log::{Log, Vehicle};
use scphd_run::session::{self, Filter};
use scphd_stream::planar::{
    BlackBoxCalibrated, Planar, PlanarJoint, PlanarJoint40, PlanarJoint40Movers, PlanarJointMovers,
};
use scphd_stream::underwater::{Underwater, UnderwaterJoint};
use scphd_stream::{
    Aboard, Filter as _, Monitor, Reader, Record, ReplayError, Scalar, ScanCost, Seen, StreamError, planar, replay,
};
use scphd_tests::with_roomy_stack;
use scphd_worlds::scenario;
use scphd_worlds::underwater::tank;

const SEED: u64 = 5;
/// Few enough for every map to fit the smaller memory on board, so that its capacities have no effect.
const SCANS: usize = 40;

/// Collects digests; its clock counts calls.
#[derive(Default)]
struct Digests {
    all: Vec<u64>,
    full: bool,
}

impl Monitor for Digests {
    fn start(&mut self) {}

    fn elapsed(&mut self) -> u64 {
        1
    }

    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64) {
        assert_eq!((cost.scan as usize, cost.update), (self.all.len(), 1));
        self.all.push(digest);
        self.full |= seen.pages_used == seen.pages;
    }
}

fn short_log() -> (Log, Settings) {
    let mut log = scenario::survey(1);
    log.scans.truncate(SCANS);
    let mut settings = Settings::for_log(&log);
    settings.restrict_to_reference();
    // Few enough particles that the vehicle's capacities do not change the state.
    (settings.filter.particles, settings.filter.samples) = (32, 2);
    (log, settings)
}

fn replayed_as<K: Aboard<T>, T: Real>(bytes: &[u8], scans: u32) -> Result<Digests, ReplayError> {
    with_roomy_stack(|| {
        let mut memory = Box::new(K::MEMORY);
        let mut digests = Digests::default();
        replay::<K, T>(bytes, &mut memory, scans, &mut digests).map(|_| digests)
    })
}

/// A replay by this filter of a log with these settings ends where the session ends. Returns the stream and the digests.
fn ends_alike<A: Aboard<T, Kind = Planar>, T: Real>(
    log: &Log,
    settings: &Settings,
    of: Recorded,
) -> (Vec<u8>, Digests) {
    let (precision, scalar) = precision::<T>();
    let filter = match of {
        Recorded::Mixture => Filter::Core(precision),
        Recorded::Joint => Filter::Joint(precision),
    };
    let session = session::run::<dimensions::Planar>(log, settings, filter, SEED, &mut |_| ()).unwrap();
    let bytes = stream::write(log, settings, of, SEED, scalar, usize::MAX).unwrap().bytes;
    let digests = replayed_as::<A, T>(&bytes, u32::MAX).unwrap();
    assert_eq!((digests.all.len(), digests.all.last()), (log.scans.len(), session.summary.digest.as_ref()));
    (bytes, digests)
}

fn precision<T: Real>() -> (Precision, Scalar) {
    if size_of::<T>() == 4 { (Precision::F32, Scalar::F32) } else { (Precision::F64, Scalar::F64) }
}

/// A short dive with the settings of the firmware's stream, with few particles and frames that fit the memory on board.
fn short_dive() -> (scphd_log::underwater::Log, scphd_filters::underwater::settings::Settings) {
    let mut log = tank::girona_tank(1);
    log.scans.truncate(25);
    let settings = scphd_filters::underwater::settings::Settings::for_log(&log);
    let mut settings = settings.with_toml(include_str!("../../firmware/girona-tank.toml")).unwrap();
    settings.filter.particles = 16;
    (log, settings)
}

#[test]
fn a_replay_ends_in_the_state_of_the_session() {
    let (log, settings) = short_log();
    assert!(!ends_alike::<Planar, f32>(&log, &settings, Recorded::Mixture).1.full);
    assert!(!ends_alike::<Planar, f64>(&log, &settings, Recorded::Mixture).1.full);
}

/// A joint map has the same state with every sufficient capacity, and another one with moving-object tracks.
#[test]
fn a_joint_map_ends_where_its_session_ends() {
    let mut log = scenario::faults(1);
    log.scans.truncate(12);
    let mut settings = Settings::for_log(&log);
    let mut ended = |moving: bool| {
        settings.set_moving(moving);
        let of = Recorded::Joint;
        let replays = if moving {
            [
                ends_alike::<PlanarJointMovers, f32>(&log, &settings, of),
                ends_alike::<PlanarJoint40Movers, f32>(&log, &settings, of),
            ]
        } else {
            [ends_alike::<PlanarJoint, f32>(&log, &settings, of), ends_alike::<PlanarJoint40, f32>(&log, &settings, of)]
        };
        replays.map(|(_, digests)| (digests.full, digests.all.last().copied()))
    };
    let (still, moving) = (ended(false), ended(true));
    assert!(still.iter().chain(&moving).all(|(full, _)| !full));
    assert_ne!(still, moving);
}

/// Mean position error of a replay, m. The log has a true pose for every scan.
fn position_error_m<A: Aboard<f32, Kind = Planar>>(log: &Log, bytes: &[u8]) -> f64 {
    with_roomy_stack(|| {
        let (mut reader, mut memory) = (Reader::<Planar>::open(bytes).unwrap(), Box::new(A::MEMORY));
        let mut filter = A::start(&reader.header(), &mut memory).unwrap();
        let (mut sum_m, mut truth) = (0.0, log.truth.iter());
        while let Some(record) = reader.read().unwrap() {
            match record {
                Record::Predict(odometry) => filter.predict(&odometry).unwrap(),
                Record::Scan(measurements) => {
                    let scan = filter.receive(measurements);
                    filter.scan(scan).unwrap();
                    let ([x_m, y_m, _], _) = filter.estimate_pose();
                    let [true_x_m, true_y_m] = truth.next().unwrap().position;
                    sum_m += (x_m - true_x_m).hypot(y_m - true_y_m);
                }
                record => panic!("{record:?}"),
            }
        }
        sum_m / log.scans.len() as f64
    })
}

/// A scan has far more births than the capacity; those that matter are kept.
#[test]
fn on_board_there_is_room_for_what_moves_in_the_thesis() {
    let log = scenario::thesis_dynamic(900_000);
    let mut settings = Settings::for_log(&log);
    settings.set_moving(true);
    let bytes = stream::write(&log, &settings, Recorded::Joint, SEED, Scalar::F32, usize::MAX).unwrap().bytes;
    let error_m = position_error_m::<PlanarJointMovers>(&log, &bytes);
    assert!(error_m < 0.15, "{error_m} m");
}

fn dive_ends_alike<A: Aboard<T>, T: Real>(
    log: &scphd_log::underwater::Log,
    settings: &scphd_filters::underwater::settings::Settings,
    (of, filter): (Recorded, fn(Precision) -> Filter),
) {
    let (precision, scalar) = precision::<T>();
    let filter = filter(precision);
    let session = session::run::<dimensions::Underwater>(log, settings, filter, SEED, &mut |_| ()).unwrap();
    let bytes = stream::write_underwater(log, settings, of, SEED, scalar, usize::MAX).unwrap().bytes;
    let digests = replayed_as::<A, T>(&bytes, u32::MAX).unwrap();
    assert!(!digests.full);
    assert_eq!((digests.all.len(), digests.all.last()), (log.scans.len(), session.summary.digest.as_ref()));
}

#[test]
fn a_dive_with_a_joint_map_ends_where_its_session_ends() {
    let (log, settings) = short_dive();
    dive_ends_alike::<UnderwaterJoint, f32>(&log, &settings, (Recorded::Joint, Filter::Joint));
}

/// An odometry row beyond the speed limit that moves the vehicle little in its short time: only the check of the speed can refuse
/// it.
#[test]
fn an_implausible_row_is_refused_on_board_and_in_the_session() {
    let drive = |speed: f64| {
        let (mut log, settings) = short_log();
        log.odometry[7].control = [speed, 0.0, 0.0];
        let (_, mixture) = ends_alike::<Planar, f32>(&log, &settings, Recorded::Mixture);
        let bytes = stream::write(&log, &settings, Recorded::Joint, SEED, Scalar::F32, usize::MAX).unwrap().bytes;
        let joint = replayed_as::<PlanarJoint, f32>(&bytes, u32::MAX).unwrap();
        [mixture, joint].map(|digests| digests.all.last().copied())
    };
    // All speeds beyond the limit leave the same state, and others a different one.
    let left_out = drive(400.0);
    assert_eq!(drive(-600.0), left_out);
    // Not so fast that all landmarks are new, for which the memory on board is too small.
    let taken = drive(10.0);
    assert!(taken[0] != left_out[0] && taken[1] != left_out[1]);
}

#[test]
fn a_dive_ends_in_the_state_of_its_session() {
    let (mut log, settings) = short_dive();
    // A frame between two samples of the instruments, and one before the first.
    log.scans[10].t_s += 0.03;
    log.scans[0].t_s -= 0.5;
    dive_ends_alike::<Underwater, f32>(&log, &settings, (Recorded::Mixture, Filter::Core));
    dive_ends_alike::<Underwater, f64>(&log, &settings, (Recorded::Mixture, Filter::Core));
}

#[test]
fn a_dive_that_cannot_be_replayed_is_refused_by_name() {
    let (log, settings) = short_dive();
    let refused = |log: &scphd_log::underwater::Log, settings: &scphd_filters::underwater::settings::Settings| {
        let bytes = stream::write_underwater(log, settings, Recorded::Mixture, SEED, Scalar::F32, 3).unwrap().bytes;
        replayed_as::<Underwater, f32>(&bytes, u32::MAX).err().map(|error| error.to_string())
    };
    assert_eq!(refused(&log, &settings), None);
    let mut astray = log.clone();
    astray.instruments[2].roll_rad = f64::NAN;
    let error = "scan 2: the filter refuses: the control is not finite or outside the motion model's domain";
    assert_eq!(refused(&astray, &settings).as_deref(), Some(error));
    let mut crowded = log.clone();
    crowded.scans[1].detections = vec![[400.0, 300.0, 320.0, 300.0]; 97];
    let error = "scan 1: the filter refuses: 97 measurements do not fit a state for 96";
    assert_eq!(refused(&crowded, &settings).as_deref(), Some(error));
    let mut blind = log.clone();
    blind.camera.projections[1] = [[0.0; 4]; 3];
    let error = "the filter refuses the stream header: right must be finite, with a 3 x 3 part that is not singular";
    assert_eq!(refused(&blind, &settings).as_deref(), Some(error));
    // Each kind refuses streams of the other.
    let bytes = stream::write_underwater(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, 3).unwrap().bytes;
    let error = replayed_as::<Planar, f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "the stream is for another type of vehicle: 3");
    let mut unmanned = log;
    unmanned.instruments.clear();
    assert!(stream::write_underwater(&unmanned, &settings, Recorded::Mixture, SEED, Scalar::F32, 3).is_err());
}

#[test]
fn a_stream_of_fewer_scans_is_the_beginning_of_the_whole_one() {
    let (log, settings) = short_log();
    let whole = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, usize::MAX).unwrap();
    let part = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, 10).unwrap();
    assert_eq!((whole.scans as usize, part.scans), (SCANS, 10));
    let expected = replayed_as::<Planar, f32>(&whole.bytes, 10).unwrap().all;
    assert_eq!(expected.len(), 10);
    assert_eq!(replayed_as::<Planar, f32>(&part.bytes, u32::MAX).unwrap().all, expected);
}

#[test]
fn a_truncated_stream_is_replayed_up_to_its_end_and_then_refused() {
    let (log, settings) = short_log();
    let bytes = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, 10).unwrap().bytes;
    let cut = &bytes[..bytes.len() - 20];
    assert!(matches!(replayed_as::<Planar, f32>(cut, u32::MAX), Err(ReplayError::Stream(StreamError::Truncated))));
    assert_eq!(replayed_as::<Planar, f32>(cut, 9).unwrap().all.len(), 9);
}

#[test]
fn a_stream_beyond_the_capacities_on_board_is_refused_by_name() {
    let (log, mut settings) = short_log();
    settings.filter.particles = 1000;
    let bytes = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, 2).unwrap().bytes;
    let error = replayed_as::<Planar, f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "the filter refuses the stream header: 1000 particles do not fit a state for 32");
    let (mut log, settings) = short_log();
    log.scans[1].detections = vec![[5.0, 0.0]; 65];
    let bytes = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F32, 2).unwrap().bytes;
    let error = replayed_as::<Planar, f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "scan 1: the filter refuses: 65 measurements do not fit a state for 64");
}

/// Counts the scans that fill the memory, as decided by `is_full`; each has the maximum number of measurements.
struct Fullness {
    is_full: fn(&Seen) -> bool,
    scans: usize,
}

impl Monitor for Fullness {
    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, _: u64) {
        assert_eq!(cost.measurements as usize, planar::MEASUREMENTS);
        self.scans += usize::from((self.is_full)(seen));
    }
}

/// Number of the first scans that fill the memory.
fn full_scans<A: Aboard<f32>>(
    (log, settings): &(Log, Settings),
    filter: Recorded,
    scans: usize,
    is_full: fn(&Seen) -> bool,
) -> usize {
    let bytes = stream::write(log, settings, filter, SEED, Scalar::F32, scans).unwrap().bytes;
    with_roomy_stack(|| {
        let (mut memory, mut fullness) = (Box::new(A::MEMORY), Fullness { is_full, scans: 0 });
        replay::<A, f32>(&bytes, &mut memory, u32::MAX, &mut fullness).unwrap();
        fullness.scans
    })
}

/// The worst case has all pages in use, all maps written, the maximum number of measurements, and pruning tightened because of
/// too little memory.
#[test]
fn the_worst_case_fills_the_memory() {
    let full = full_scans::<Planar>(&stream::worst_case(32, 2, planar::MEASUREMENTS), Recorded::Mixture, 8, |seen| {
        let tightened = scphd::Health::PRUNING_TIGHTENED.bits();
        seen.pages_used == seen.pages && seen.maps_updated == 32 && seen.health & tightened != 0
    });
    assert_eq!(full, 8, "all scans: the births of the first are enough");
}

/// The worst case of a joint map has all features in view, and the maximum number of measurements.
#[test]
fn the_worst_case_of_a_joint_map_fills_it() {
    let (log, mut settings) = stream::worst_case_joint(planar::MEASUREMENTS);
    settings.set_moving(false);
    let full = full_scans::<PlanarJoint>(&(log, settings), Recorded::Joint, 24, |seen| {
        seen.pages_used == seen.pages && seen.in_view == seen.pages
    });
    assert!(full >= 18, "{full}");
}

/// A log whose map fits every memory on board.
fn few_features() -> (Log, Settings) {
    let mut log = scenario::faults(1);
    log.scans.truncate(12);
    let mut settings = Settings::for_log(&log);
    settings.restrict_to_reference();
    (settings.filter.particles, settings.filter.samples) = (4, 1);
    (log, settings)
}

#[test]
fn noise_that_grows_with_the_range_ends_where_the_session_ends() {
    let (log, mut settings) = few_features();
    settings.sensor.range_sigma_ratio = 0.01;
    ends_alike::<Planar, f32>(&log, &settings, Recorded::Mixture);
    ends_alike::<PlanarJoint, f32>(&log, &settings, Recorded::Joint);
}

#[test]
fn calibrated_odometry_ends_where_the_session_ends() {
    let (log, mut settings) = few_features();
    settings.calibration = Some(CalibrationSettings {
        speed_scale_sigma: 0.05,
        turn_scale_sigma: 0.05,
        turn_offset_sigma: 0.02,
        lasts_s: 3600.0,
    });
    let (bytes, _) = ends_alike::<BlackBoxCalibrated, f32>(&log, &settings, Recorded::Joint);
    let error = replayed_as::<PlanarJoint, f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "the filter refuses the stream header: the memory is not for what joint.odometry says");
}

#[test]
fn a_vehicle_with_sideways_speed_ends_where_the_session_ends() {
    let (mut log, _) = few_features();
    log.vehicle = Vehicle::Holonomic;
    log.odometry.iter_mut().for_each(|row| row.control = [0.5, 0.1, -0.25]);
    let mut settings = Settings::for_log(&log);
    settings.restrict_to_reference();
    (settings.filter.particles, settings.filter.samples) = (4, 1);
    ends_alike::<Planar, f32>(&log, &settings, Recorded::Mixture);
    let (bytes, _) = ends_alike::<PlanarJoint, f32>(&log, &settings, Recorded::Joint);
    let mut reader = Reader::<Planar>::open(&bytes).unwrap();
    let sideways = std::iter::from_fn(|| reader.read().unwrap())
        .filter(|record| matches!(record, Record::Predict(odometry) if odometry.control[2] == -0.25));
    assert!(sideways.count() > 10);
}

#[test]
fn the_header_describes_the_contents_of_the_stream() {
    let (log, settings) = short_log();
    let stream = stream::write(&log, &settings, Recorded::Mixture, SEED, Scalar::F64, usize::MAX).unwrap();
    let reader = Reader::<Planar>::open(&stream.bytes).unwrap();
    let header = reader.header();
    let most = log.scans.iter().map(|scan| scan.detections.len()).max().unwrap();
    assert_eq!((header.scans as usize, header.most_measurements as usize), (SCANS, most));
    let description = header.description::<f64>().unwrap();
    let scphd_vehicle::Filter::Mixture(config) = description.filter else { unreachable!() };
    assert_eq!((config.particles, config.samples, description.start.seed), (32, 2, SEED));
    assert!((header.scan_interval_s - 0.1).abs() < 1e-9);
    assert_eq!(description.sensors[0].unwrap().range_sigma_m.to_bits(), settings.sensor.range_sigma_m.to_bits());
}
