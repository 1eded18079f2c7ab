//! A log replayed from a stream by the code that vehicles run ends in the state that the simulator's session ends in.

use scphd::Real;
use scphd_sim::log::Log;
use scphd_sim::session::{self, Filter};
use scphd_sim::settings::Settings;
use scphd_sim::slam::Precision;
use scphd_sim::{scenario, stream};
use scphd_stream::{Memory, Monitor, Reader, ReplayError, Scalar, ScanCost, Seen, StreamError, memory, replay};
use scphd_tests::with_roomy_stack;

const SEED: u64 = 5;
/// Few enough for every map to fit the smaller memory on board, in which case its capacities change nothing.
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
    // So that the vehicle's memory is as good as the desk's.
    (settings.filter.particles, settings.filter.samples) = (32, 2);
    (log, settings)
}

fn replayed<T: Real>(bytes: &[u8], scans: u32) -> Result<Digests, ReplayError> {
    with_roomy_stack(|| {
        let mut place: Box<Memory<T>> = Box::new(memory());
        let mut digests = Digests::default();
        replay(bytes, &mut place, scans, &mut digests).map(|_| digests)
    })
}

#[test]
fn a_replay_ends_where_the_session_ends() {
    let (log, settings) = short_log();
    for (precision, scalar) in [(Precision::F32, Scalar::F32), (Precision::F64, Scalar::F64)] {
        let session = session::run(&log, &settings, Filter::Core(precision), SEED, &mut |_| ()).unwrap();
        let bytes = stream::write(&log, &settings, SEED, scalar, usize::MAX).bytes;
        let digests = match precision {
            Precision::F32 => replayed::<f32>(&bytes, u32::MAX),
            Precision::F64 => replayed::<f64>(&bytes, u32::MAX),
        }
        .unwrap();
        assert!(!digests.full);
        assert_eq!(digests.all.len(), SCANS);
        assert_eq!(digests.all.last().copied(), session.summary.digest, "{precision:?}");
    }
}

#[test]
fn a_stream_of_some_scans_is_the_beginning_of_the_whole() {
    let (log, settings) = short_log();
    let whole = stream::write(&log, &settings, SEED, Scalar::F32, usize::MAX);
    let part = stream::write(&log, &settings, SEED, Scalar::F32, 10);
    assert_eq!((whole.scans as usize, part.scans), (SCANS, 10));
    let expected = replayed::<f32>(&whole.bytes, 10).unwrap().all;
    assert_eq!(expected.len(), 10);
    assert_eq!(replayed::<f32>(&part.bytes, u32::MAX).unwrap().all, expected);
}

#[test]
fn a_stream_that_breaks_off_is_replayed_up_to_there_and_then_refused() {
    let (log, settings) = short_log();
    let bytes = stream::write(&log, &settings, SEED, Scalar::F32, 10).bytes;
    let cut = &bytes[..bytes.len() - 20];
    assert!(matches!(replayed::<f32>(cut, u32::MAX), Err(ReplayError::Stream(StreamError::Truncated))));
    assert_eq!(replayed::<f32>(cut, 9).unwrap().all.len(), 9);
}

#[test]
fn what_does_not_fit_on_board_is_refused_by_name() {
    let (log, mut settings) = short_log();
    settings.filter.particles = 1000;
    let bytes = stream::write(&log, &settings, SEED, Scalar::F32, 2).bytes;
    let error = replayed::<f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "the filter refuses the head of the stream: 1000 particles do not fit a state for 32");
    let (mut log, settings) = short_log();
    log.scans[1].detections = vec![[5.0, 0.0]; 65];
    let bytes = stream::write(&log, &settings, SEED, Scalar::F32, 2).bytes;
    let error = replayed::<f32>(&bytes, u32::MAX).err().unwrap().to_string();
    assert_eq!(error, "scan 1: the filter refuses: 65 measurements do not fit a state for 64");
}

/// The worst case is one: every page in use, every map written, the most measurements, pruning tightened for want of
/// room.
#[test]
fn the_worst_case_fills_the_memory() {
    #[derive(Default)]
    struct Fullness(usize);
    impl Monitor for Fullness {
        fn start(&mut self) {}
        fn elapsed(&mut self) -> u64 {
            0
        }
        fn scanned(&mut self, cost: &ScanCost, seen: &Seen, _: u64) {
            let tightened = scphd::Health::PRUNING_TIGHTENED.bits();
            let full = seen.pages_used == seen.pages && seen.maps_updated == 32 && seen.health & tightened != 0;
            assert_eq!(cost.measurements as usize, scphd_stream::MEASUREMENTS);
            self.0 += usize::from(full);
        }
    }
    let (log, settings) = stream::worst_case(32, 2, scphd_stream::MEASUREMENTS);
    let bytes = stream::write(&log, &settings, SEED, Scalar::F32, 8).bytes;
    let full = with_roomy_stack(|| {
        let mut place: Box<Memory<f32>> = Box::new(memory());
        let mut fullness = Fullness::default();
        replay(&bytes, &mut place, u32::MAX, &mut fullness).unwrap();
        fullness.0
    });
    assert_eq!(full, 7, "all but the first scan, before which the map is empty");
}

#[test]
fn the_head_says_what_the_stream_holds() {
    let (log, settings) = short_log();
    let stream = stream::write(&log, &settings, SEED, Scalar::F64, usize::MAX);
    let reader = Reader::open(&stream.bytes).unwrap();
    let header = reader.header();
    let most = log.scans.iter().map(|scan| scan.detections.len()).max().unwrap();
    assert_eq!((header.scans as usize, header.most_measurements as usize), (SCANS, most));
    assert_eq!((header.particles, header.samples, header.seed), (32, 2, SEED));
    assert!((header.scan_interval_s - 0.1).abs() < 1e-9);
    assert_eq!(header.range_sigma_m.to_bits(), settings.sensor.range_sigma_m.to_bits());
}
