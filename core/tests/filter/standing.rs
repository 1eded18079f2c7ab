//! A vehicle that stands still among a few landmarks, with models that are right or not: how many landmarks the map counts, and which
//! conditions a scan raises.

use crate::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;

type Memory = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 64, 64, 256>>;
type JointMemory = JointState<PlanarPose<f64>, Vector2<f64>, 40, { joint_numbers(3, 2, 40) }, 64>;

const SIGMAS: [f64; 2] = [0.1, 0.01];
const RANGE_M: f64 = 20.0;

/// What is stated of the sensor, and how it is.
#[derive(Clone, Copy)]
struct World {
    landmarks: usize,
    stated_detection: f64,
    detection: f64,
    /// Times the noise that is stated.
    noisier: f64,
    clutter: f64,
}

const RIGHT: World = World { landmarks: 10, stated_detection: 0.98, detection: 0.98, noisier: 1.0, clutter: 1.0 };

impl World {
    fn sensing(&self) -> Lidar<f64> {
        let window = RangeBearingWindow::full_circle(RANGE_M, self.stated_detection).unwrap();
        Sensing::range_bearing(SIGMAS, window, self.clutter).unwrap()
    }

    fn births(&self) -> Births<f64> {
        Births::of_static(0.02 * self.sensing().clutter.intensity())
    }

    /// What is measured by the vehicle where it is taken to be, or turned from there.
    fn scan(&self, turned_rad: f64, noise: &mut Noise) -> Vec<Vector2<f64>> {
        let mut scan = Vec::new();
        for landmark in 0..self.landmarks {
            let place = Vector2::new(5.0 + landmark as f64, 0.6 * landmark as f64 - 3.0 + turned_rad);
            if noise.uniform::<f64>() < self.detection {
                let [range, bearing] = SIGMAS.map(|sigma| self.noisier * sigma * noise.normal::<f64>());
                scan.push(place + Vector2::new(range, bearing));
            }
        }
        // Binomial, which is near enough to Poisson.
        for _ in 0..(4.0 * self.clutter) as usize {
            if noise.uniform::<f64>() < 0.25 {
                let bearing = core::f64::consts::TAU * (noise.uniform::<f64>() - 0.5);
                scan.push(Vector2::new(RANGE_M * noise.uniform::<f64>(), bearing));
            }
        }
        scan
    }
}

fn remembering(confirmed_weight: f64) -> Config<f64> {
    Config {
        particles: 1,
        prune_weight: 1e-3,
        confirming_detections: 3.0,
        unconfirmed_weight: 1.0,
        confirmed_weight,
        ..Config::default()
    }
}

/// Scans of the mixture, after the first hundred: N̂ and the health.
fn scans(world: World, confirmed_weight: f64, seed: u64, scans: usize, mut each: impl FnMut(f64, &ScanReport<f64>)) {
    let models = Models { motion: KnownPose::new(), sensing: world.sensing() };
    let mut memory = Box::new(Memory::new());
    let mut filter = Alone::new(models, world.births(), remembering(confirmed_weight), &mut *memory).unwrap();
    filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
    let mut noise = Noise::seeded(seed);
    for scan in 0..scans + 100 {
        let report = filter.scan(&world.scan(0.0, &mut noise)).unwrap();
        if scan >= 100 {
            each(filter.map(0).map(|component| component.ln_weight.exp()).sum(), &report);
        }
    }
}

/// One landmark, seen in every scan, is one landmark whatever misses would leave of it.
#[test]
fn what_is_detected_is_not_counted_as_hidden_beside() {
    let world = World { landmarks: 1, detection: 1.0, clutter: 0.0, ..RIGHT };
    let sensing = World { clutter: 1.0, ..world };
    let weigh = |confirmed_weight: f64, missed: usize| {
        let models = Models { motion: KnownPose::new(), sensing: sensing.sensing() };
        let mut memory = Box::new(Memory::new());
        let mut filter = Alone::new(models, sensing.births(), remembering(confirmed_weight), &mut *memory).unwrap();
        filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
        let mut noise = Noise::seeded(5);
        (0..40).for_each(|_| _ = filter.scan(&world.scan(0.0, &mut noise)).unwrap());
        (0..missed).for_each(|_| _ = filter.scan(&[]).unwrap());
        filter.map(0).map(|component| component.ln_weight.exp()).sum::<f64>()
    };
    let thesis = weigh(0.0, 0);
    assert!((thesis - 1.02).abs() < 0.002, "{thesis}");
    for confirmed_weight in [0.05, 0.2, 1.0] {
        assert!((weigh(confirmed_weight, 0) - thesis.max(confirmed_weight)).abs() < 1e-9, "{confirmed_weight}");
        assert!((weigh(confirmed_weight, 6) - confirmed_weight).abs() < 0.021, "{confirmed_weight}");
    }
}

#[test]
fn ten_landmarks_are_ten_and_a_twentieth_that_is_missing_is_no_condition() {
    for seed in 1..=3 {
        let (mut sum, mut low) = (0.0, 0);
        scans(RIGHT, 0.2, seed, 1000, |expected, _| sum += expected);
        assert!((9.95..10.2).contains(&(sum / 1000.0)), "seed {seed}: {}", sum / 1000.0);
        scans(World { detection: 0.93, ..RIGHT }, 0.2, seed, 1000, |_, report| {
            low += usize::from(report.health.contains(Health::DETECTIONS_LOW));
        });
        assert!(low < 20, "seed {seed}: {low} of 1000 scans");
        scans(World { detection: 0.6, ..RIGHT }, 0.2, seed, 200, |_, report| {
            low += usize::from(report.health.contains(Health::DETECTIONS_LOW));
        });
        assert!(low > 150, "seed {seed}: {low} of 200 scans");
    }
}

/// Two sensors by turns, with as much clutter as each states: nothing is crowded; and a vehicle that was turned is told it is lost by the
/// one that sees clearly, however crowded the other one is.
#[test]
fn a_crowded_sensor_beside_a_clear_one_neither_alarms_nor_hides_that_the_vehicle_is_lost() {
    type Roomy = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 96, 96, 640>>;
    for (crowd, seed) in [30.0, 100.0].into_iter().flat_map(|crowd| (1..=5).map(move |seed| (crowd, seed))) {
        let worlds = [RIGHT, World { clutter: crowd, ..RIGHT }];
        let mut memory = Box::new(Roomy::new());
        let mut slam = ScPhd::new(KnownPose::new(), remembering(0.0), &mut *memory).unwrap();
        slam.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
        let mut scratch = [(); 2].map(|()| Box::new(DetectorMemory::<Vector2<f64>, 256>::new()));
        let [clear, crowded] = &mut scratch;
        let detector = |world: &World| Detector::new(world.sensing(), world.births()).unwrap();
        let mut detectors = [detector(&worlds[0]).over(clear).unwrap(), detector(&worlds[1]).over(crowded).unwrap()];
        let mut noise = Noise::seeded(seed);
        for scan in 0..400 {
            let which = scan % 2;
            let report = slam.scan(&mut detectors[which], &worlds[which].scan(0.0, &mut noise)).unwrap();
            let alarms = Health::CLUTTER_HIGH | Health::LOST | Health::DIVERGENCE_SUSPECTED;
            assert!(report.health.bits() & alarms.bits() == 0, "{crowd} {seed}, scan {scan}: {:?}", report.health);
        }
        let lost = (0..20).any(|scan| {
            let which = scan % 2;
            let report = slam.scan(&mut detectors[which], &worlds[which].scan(2.0, &mut noise)).unwrap();
            report.health.contains(Health::LOST)
        });
        assert!(lost, "{crowd} {seed}");
    }
}

/// Shares of scans with INNOVATION_HIGH, of a mixture and of a joint map.
fn high_innovations(world: World, seed: u64) -> [f64; 2] {
    const SCANS: usize = 1000;
    let mut high = [0; 2];
    scans(world, 0.0, seed, SCANS, |_, report| high[0] += usize::from(report.health.contains(Health::INNOVATION_HIGH)));
    let mut memory = Box::new(JointMemory::new());
    let mut joint = JointSlam::new(KnownPose::new(), JointConfig::default(), &mut *memory).unwrap();
    joint.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let detector = Detector::new(world.sensing(), world.births()).unwrap();
    let mut noise = Noise::seeded(seed);
    for scan in 0..SCANS + 100 {
        let report = joint.scan(&detector, &world.scan(0.0, &mut noise)).unwrap();
        high[1] += usize::from(scan >= 100 && report.health.contains(Health::INNOVATION_HIGH));
    }
    high.map(|high| high as f64 / SCANS as f64)
}

#[test]
fn few_innovations_are_large_by_chance_and_noise_that_is_stated_too_low_is_told() {
    for (landmarks, told) in [(1, 0.05), (2, 0.1), (4, 0.2), (10, 0.5)] {
        let mean = |world: World| {
            let [first, second] = [1, 2].map(|seed| high_innovations(world, seed));
            [0, 1].map(|filter| 0.5 * (first[filter] + second[filter]))
        };
        let right = mean(World { landmarks, ..RIGHT });
        assert!(right.iter().all(|&share| share < 0.01), "{landmarks} landmarks: {right:?}");
        let wrong = mean(World { landmarks, noisier: 2.0, ..RIGHT });
        assert!(wrong.iter().all(|&share| share > told), "{landmarks} landmarks: {wrong:?}");
    }
}
