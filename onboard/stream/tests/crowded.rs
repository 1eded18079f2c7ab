//! Streams with more components near measurements than an update on board has room for, with the informed proposal: the replay
//! ends, and the scans report the components left out. A replay that does not end fails after a minute.

use nalgebra::Vector3;
use scphd::models::{AuvPose, ControlNoise, Reading, Sensor};
use scphd::navigation::Instruments;
use scphd::settings::{Extraction, Informed, Proposal};
use scphd::{Births, Config, Health};
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::underwater::{Navigation, Underwater};
use scphd_stream::{Aboard, Header, Kind, Monitor, Numbers, Scalar, ScanCost, Seen, Writer, replay, underwater};
use scphd_vehicle::{self as vehicle, Description};
use std::sync::mpsc;
use std::time::Duration;

/// Far more time than a replay of these streams takes.
const PATIENCE: Duration = Duration::from_secs(60);
/// An unoptimised build constructs the memory on the stack first.
const STACK_BYTES: usize = 64 << 20;

/// Stores the results of every scan.
#[derive(Default)]
struct Scans(Vec<Seen>);

impl Monitor for Scans {
    fn scanned(&mut self, _: &ScanCost, seen: &Seen, _: u64) {
        self.0.push(*seen);
    }
}

/// Replays a stream in single precision.
fn replayed<K: Aboard<f32>>(stream: Vec<u8>) -> Vec<Seen> {
    let (sender, receiver) = mpsc::channel();
    let work = move || {
        let mut memory = Box::new(K::MEMORY);
        let mut scans = Scans::default();
        let result = replay::<K, f32>(&stream, &mut memory, u32::MAX, &mut scans).map(|_| ());
        let _ = sender.send((result, scans.0));
    };
    std::thread::Builder::new().stack_size(STACK_BYTES).spawn(work).unwrap();
    let (result, scans) = receiver.recv_timeout(PATIENCE).expect("the replay comes to an end");
    result.unwrap();
    scans
}

/// A prediction and the scan at its end.
type Step<K> = (<K as Kind>::Input, Vec<<K as Kind>::Measurement>);

fn written<K: Kind>(header: &Header<K>, steps: &[Step<K>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::start(header, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), ()>(())
    })
    .unwrap();
    for (input, scan) in steps {
        writer.predict(input).unwrap();
        writer.scan(scan).unwrap();
    }
    writer.end().unwrap();
    bytes
}

/// A vehicle with four particles, an informed proposal, and maps without merging and nearly without pruning.
fn described(sensor: vehicle::Sensor<f64>) -> Description<f64> {
    let informed = Informed { rounds: 3, sampled_fraction: 1.0, min_responsibility: 1e-6 };
    let filter = vehicle::Filter::Mixture(Config {
        particles: 4,
        samples: 1,
        proposal: Proposal::Informed(informed),
        resample_threshold: 0.5,
        prune_weight: 1e-6,
        confirming_detections: 1.0,
        unconfirmed_weight: 0.0,
        confirmed_weight: 0.0,
        merge_distance: 0.0,
        max_components: usize::MAX,
        extraction: Extraction::Heaviest,
        extraction_weight: 0.0,
        ..Config::default()
    });
    let mut described = Description { filter, ..Description::robot() };
    described.vehicle.noise = ControlNoise::white(0.01, 0.01);
    described.sensors[0] = Some(sensor);
    described.start.seed = 0;
    described
}

/// The last scan sees two places together, which the previous scans have filled with components one after the other.
fn ends_crowded(scans: &[Seen], count: usize, view: u32) {
    assert_eq!(scans.len(), count);
    let last = scans[count - 1];
    assert!(last.in_view > view, "{last:?}");
    assert_ne!(last.health & Health::PRUNING_TIGHTENED.bits(), 0, "{last:?}");
}

#[test]
fn scans_of_a_planar_vehicle() {
    let mut sensor = vehicle::Sensor::range_bearing(1.5, 0.5, [0.02, 0.02]);
    sensor.births = Births::of_static(0.1);
    let header = Header::<Planar>::of(&described(sensor), Scalar::F64).unwrap();
    // A place around x = 1 m and one around x = 2 m, with 32 features each.
    let place = |x: f64| (0..32).map(move |k| [x + 0.12 * (f64::from(k % 4) - 1.5), 0.1 * (f64::from(k / 4) - 3.5)]);
    let seen_from = |x: f64, features: &mut dyn Iterator<Item = [f64; 2]>| -> Vec<[f64; 2]> {
        features.map(|[along, left]| [(along - x).hypot(left), left.atan2(along - x)]).collect()
    };
    let mut steps = Vec::new();
    let mut before = 0.0;
    // With smaller workspaces the maps have fewer components of a place: the second one is then scanned once more.
    let few = cfg!(feature = "few-particles");
    let way = if few { &[0.0, 0.0, 0.0, 3.0, 3.0, 1.5][..] } else { &[0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 1.5] };
    for &x in way {
        let control = [(x - before) / 3.0, 0.0, 0.0];
        let scan = match x {
            0.0 => seen_from(x, &mut place(1.0)),
            3.0 => seen_from(x, &mut place(2.0)),
            _ => seen_from(x, &mut place(1.0).chain(place(2.0))),
        };
        steps.push((Odometry { control, dt_s: 3.0 }, scan));
        before = x;
    }
    // More components than an update has room for.
    let view = if few { 256 } else { 96 };
    ends_crowded(&replayed::<Planar>(written(&header, &steps)), way.len(), view);
}

#[test]
fn seven_scans_of_an_underwater_vehicle() {
    // A camera at a height of 2 m that looks down, with a lateral baseline.
    let projection = |y: f64| {
        let (focal, [u, v]) = (890.0, [400.0, 300.0]);
        // Columns of the image to the right, rows aft, depth downwards.
        [[0.0, -focal, -u, focal * y], [-focal, 0.0, -v, 0.0], [0.0, 0.0, -1.0, 0.0]]
    };
    let numbers = underwater::Models {
        start_m: [0.0, 0.0, 2.0],
        velocity_walk_mps_rts: 0.01,
        velocity_sigma_mps: 0.01,
        z_sigma_m: 0.01,
        gate_sigmas: 4.0,
        outliers_believed: 5.0,
        yaw_acceleration_sigma_radps2: 0.01,
        projections: [projection(0.1), projection(-0.1)],
        pixel_sigmas: [2.0; 4],
        epipolar_gate: 16.0,
        size_px: [800.0, 600.0],
        edge_px: 2.0,
        near_m: 0.5,
        far_m: 5.0,
        depth_edge_m: 0.1,
        detection: 0.5,
        clutter_per_scan: 1.0,
        disparities_px: [10.0, 300.0],
        row_tolerance_px: 10.0,
        ..underwater::Models::ZERO
    };
    let models = numbers.of_filter::<f64>().unwrap().sensing;
    let births = Births::of_static(1e-9);
    let camera = vehicle::Sensor { births, ..vehicle::Sensor::range_bearing(1.0, 0.5, [1.0; 2]) };
    let header = Header::<Underwater>::with(&described(camera), numbers, Scalar::F64);
    // Pitched aft or ahead the camera sees one patch of the floor, level it sees both.
    let patch = |x: f64| {
        (0..48).map(move |k| Vector3::new(x + 0.1 * (f64::from(k % 3) - 1.0), 0.08 * (f64::from(k / 3) - 7.5), 0.0))
    };
    let seen_at = |pitch_rad: f64, features: &mut dyn Iterator<Item = Vector3<f64>>| -> Vec<[f64; 4]> {
        let frame = models.sensor.frame(&AuvPose { pitch_rad, ..AuvPose::new(0.0, 0.0, 2.0, 0.0) });
        features
            .filter_map(|feature| models.sensor.expect(&frame, &feature))
            .map(|seen| seen.measurement.into())
            .collect()
    };
    let mut steps = Vec::new();
    for pitch_rad in [0.35, 0.35, 0.35, -0.35, -0.35, -0.35, 0.0] {
        let row = Instruments {
            roll_rad: 0.0,
            pitch_rad,
            yaw_rate_radps: Reading { value: 0.0, sigma: 0.01 },
            velocity_mps: Some([0.0; 3]),
            z_m: Some(2.0),
        };
        let scan = if pitch_rad > 0.0 {
            seen_at(pitch_rad, &mut patch(-0.45))
        } else if pitch_rad < 0.0 {
            seen_at(pitch_rad, &mut patch(0.45))
        } else {
            seen_at(pitch_rad, &mut patch(-0.45).chain(patch(0.45)))
        };
        assert!(scan.len() >= 48, "{pitch_rad}: {}", scan.len());
        steps.push((Navigation { dt_s: 0.1, instruments: Some(row) }, scan));
    }
    ends_crowded(&replayed::<Underwater>(written(&header, &steps)), 7, 512);
}
