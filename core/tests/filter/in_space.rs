//! The filter in three dimensions: what stands and what moves over pages, reduction and extraction, with either proposal.

use crate::alone::{Alone, Models};
use crate::*;
use nalgebra::{Matrix3, Vector3, Vector4, Vector6};

type Still<const N: usize> = MapMemory<Static<Vector3<f64>>, N, 512, 32, 512>;
type Moving<const N: usize> = MapMemory<Dynamic<Vector3<f64>>, N, 256, 8, 256>;
type Memory<const N: usize, V> = State<AuvPose<f64>, N, N, Still<N>, V>;
type Filter<'s> = Alone<'s, Auv<f64>, Camera>;

const LIMITS: FrustumLimits<f64> = FrustumLimits {
    width_px: 800.0,
    height_px: 600.0,
    edge_px: 10.0,
    near_m: 0.6,
    far_m: 4.0,
    depth_edge_m: 0.3,
    probability: 0.9,
};
const PIXEL_SIGMA: f64 = 2.0;

type Camera = Sensing<StereoCamera<f64>, StereoFrustum<f64>, UniformClutter<f64>>;

fn models() -> Models<Auv<f64>, Camera> {
    let calibration = Matrix3::new(500.0, 0.0, 400.0, 0.0, 500.0, 300.0, 0.0, 0.0, 1.0);
    let down = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    let side = |y| projection(&calibration, &down, &Vector3::new(0.0, y, 0.0));
    let sensor = StereoCamera::new(side(0.1), side(-0.1), pixel_noise([PIXEL_SIGMA; 4], [0.0; 2]), 16.0).unwrap();
    let field_of_view = StereoFrustum::new(&sensor, LIMITS).unwrap();
    let measure = field_of_view.measure(20.0, 170.0, 10.0);
    let clutter = UniformClutter::of_scan(5.0, measure).unwrap();
    Models { motion: Auv::new(0.3, 0.0).unwrap(), sensing: Sensing { sensor, field_of_view, clutter } }
}

fn births(moving: f64) -> Births<f64> {
    let clutter = models().sensing.clutter.intensity();
    Births { of_static: 0.05 * clutter, of_moving: moving * clutter }
}

fn config(particles: usize) -> Config<f64> {
    Config {
        particles,
        prune_weight: 5e-4,
        merge_distance: 2.0,
        extraction_weight: 0.5,
        moving: MovingConfig { spread_max_m: 1.0, ..MovingConfig::walkers() },
        ..Config::default()
    }
}

/// Features on a bumpy floor at z = 0, where a vehicle 2 m above it passes.
fn floor() -> Vec<Vector3<f64>> {
    let mut noise = Noise::seeded(77);
    let mut uniform = |low: f64, high: f64| low + (high - low) * noise.uniform::<f64>();
    (0..60).map(|_| Vector3::new(uniform(-1.0, 4.0), uniform(-1.2, 1.2), uniform(0.0, 0.4))).collect()
}

struct Dive {
    noise: Noise,
    pose: AuvPose<f64>,
}

impl Dive {
    /// Forwards for four seconds and back again: 0.8 m/s, swaying. Returns what the vehicle is told.
    fn advance(&mut self, step: usize) -> AuvControl<f64> {
        let t = 0.1 * step as f64;
        let velocity = Vector3::new(if step < 40 { 0.8 } else { -0.8 }, 0.1 * t.sin(), 0.05 * t.cos());
        let rate = 0.1 * (0.7 * t).sin();
        let frame = BodyFrame::of(&self.pose);
        let moved = frame.rotation * velocity * 0.1;
        self.pose = AuvPose {
            x_m: self.pose.x_m + moved.x,
            y_m: self.pose.y_m + moved.y,
            z_m: self.pose.z_m + moved.z,
            yaw_rad: self.pose.yaw_rad + 0.1 * rate,
            yaw_rate_radps: rate,
            roll_rad: 0.05 * t.sin(),
            pitch_rad: 0.05 * t.cos(),
        };
        let mut normal = || self.noise.normal::<f64>();
        AuvControl {
            velocity_mps: velocity + Vector3::new(normal(), normal(), normal()) * 0.1,
            velocity_covariance: Symmetric::from_diagonal([0.01; 3]),
            roll_rad: self.pose.roll_rad,
            pitch_rad: self.pose.pitch_rad,
            yaw_rate_radps: Some(Reading { value: rate + 0.03 * normal(), sigma: 0.03 }),
            z_m: Some(Reading { value: self.pose.z_m + 0.02 * normal(), sigma: 0.02 }),
        }
    }

    /// What the camera reports of these features, and five pairs that nothing caused.
    fn look(&mut self, features: impl Iterator<Item = Vector3<f64>>) -> Vec<Vector4<f64>> {
        let models = models();
        let frame = models.sensing.sensor.frame(&self.pose);
        let mut scan = Vec::new();
        for feature in features {
            let Some(seen) = models.sensing.sensor.expect(&frame, &feature) else { continue };
            let p = models.sensing.field_of_view.detection_probability(&frame, &feature, &seen.measurement);
            if self.noise.uniform::<f64>() < p {
                scan.push(seen.measurement + Vector4::from_fn(|_, _| PIXEL_SIGMA * self.noise.normal::<f64>()));
            }
        }
        let mut uniform = |low: f64, high: f64| low + (high - low) * self.noise.uniform::<f64>();
        for _ in 0..5 {
            let (u, v, disparity) = (uniform(0.0, 800.0), uniform(0.0, 600.0), uniform(20.0, 170.0));
            scan.push(Vector4::new(u, v, u - disparity, v + uniform(-9.0, 9.0)));
        }
        scan
    }
}

fn dive() -> Dive {
    Dive { noise: Noise::seeded(3), pose: AuvPose::new(0.0, 0.0, 2.0, 0.2) }
}

fn run<const N: usize>(proposal: Proposal<f64>) {
    let mut state = Box::new(Memory::<N, NoMoving>::new());
    let mut filter: Filter = Alone::new(models(), births(0.0), Config { proposal, ..config(N) }, &mut *state).unwrap();
    let (mut dive, features) = (dive(), floor());
    filter.reset(dive.pose, 1).unwrap();
    let (mut no_birth, mut ever_seen) = (0, vec![false; features.len()]);
    let (mut told, mut error): (AuvPose<f64>, f64) = (dive.pose, 0.0);
    for step in 0..80 {
        let control = dive.advance(step);
        told = models().motion.propagate(&told, &control, 0.1);
        filter.predict(&control, 0.1).unwrap();
        let report = filter.scan(&dive.look(features.iter().copied())).unwrap();
        no_birth += report.no_birth;
        assert!(!report.health.contains(Health::COMPONENTS_LOST), "{step}: {report:?}");
        let frame = models().sensing.sensor.frame(&dive.pose);
        for (seen, feature) in ever_seen.iter_mut().zip(&features) {
            let expected = models().sensing.sensor.expect(&frame, feature).unwrap().measurement;
            *seen |= models().sensing.field_of_view.detection_probability(&frame, feature, &expected) > 0.8;
        }
        let mean = filter.estimate_pose().unwrap().mean;
        error = error.max((mean.position() - dive.pose.position()).norm());
    }
    let astray = (told.position() - dive.pose.position()).norm();
    let mean = filter.estimate_pose().unwrap().mean;
    assert!(error < 0.08, "{proposal:?}: {error}, told {astray}");
    assert!(mean.difference(&dive.pose)[3].abs() < 0.02);
    // False pairs with rows too far apart, and those nearer or farther than anything in view.
    assert!(no_birth > 0);
    let mut buffer = [Component::ZERO; 96];
    let map = filter.estimate_map(&mut buffer);
    let (found, wanted) = (&buffer[..map.features], ever_seen.iter().filter(|&&seen| seen).count());
    let near = |feature: &Vector3<f64>| found.iter().any(|f| (f.mean - feature).norm() < 0.1);
    let right = features.iter().zip(&ever_seen).filter(|&(feature, &seen)| seen && near(feature)).count();
    println!("{proposal:?}: {error:.3} m (told {astray:.3} m), {right} of {wanted} found, {} in all", found.len());
    assert!(wanted > 30 && right * 10 >= wanted * 8 && found.len() <= wanted + 6, "{right} of {wanted}");
}

#[test]
fn a_blind_filter_maps_a_floor_in_space() {
    run::<200>(Proposal::Blind);
}

#[test]
fn an_informed_filter_does_as_well_with_a_tenth_of_the_particles() {
    run::<20>(Proposal::Informed(Informed::default()));
}

/// A feature that crosses the view is found among those that stand, with its velocity, in space.
#[test]
fn what_moves_in_space_is_told_from_what_stands() {
    let mut state = Box::new(Memory::<50, Moving<50>>::new());
    let informed = Proposal::Informed(Informed::default());
    let mut filter: Filter =
        Alone::new(models(), births(0.05), Config { proposal: informed, ..config(50) }, &mut *state).unwrap();
    let (mut dive, features) = (dive(), floor());
    filter.reset(dive.pose, 1).unwrap();
    let velocity = Vector3::new(0.3, 0.2, 0.1);
    let mut last = Vector3::zeros();
    for step in 0..30 {
        let control = dive.advance(step);
        filter.predict(&control, 0.1).unwrap();
        last = Vector3::new(0.2, -0.4, 0.5) + velocity * (0.1 * f64::from(step as u16));
        let scan = dive.look(features.iter().copied().chain([last]));
        filter.scan(&scan).unwrap();
    }
    let mut buffer = [Component::ZERO; 32];
    let moving = filter.estimate_moving(&mut buffer);
    let mover = buffer[..moving.features].iter().min_by(|a, b| {
        let off = |c: &Component<Vector6<f64>>| (c.position::<Vector3<f64>>() - last).norm();
        off(a).total_cmp(&off(b))
    });
    let mover = mover.expect("something moves");
    let found: Vector3<f64> = mover.mean.fixed_rows::<3>(3).into();
    assert!((mover.position::<Vector3<f64>>() - last).norm() < 0.15, "{} {last}", mover.mean);
    assert!((found - velocity).norm() < 0.25, "{found}");
}

/// Roll and pitch are no coordinates of the pose, and count between a row of the instruments and its frame.
#[test]
fn a_snapshot_before_a_frame_has_roll_and_pitch() {
    let mut states = [(); 2].map(|()| Box::new(Memory::<8, Moving<8>>::new()));
    let mut filters = states.each_mut().map(|state| {
        let proposal = Proposal::Informed(Informed::default());
        let config = Config { proposal, ..config(8) };
        Filter::new(models(), births(0.05), config, &mut **state).unwrap()
    });
    let [unbroken, broken] = &mut filters;
    let (mut dive, features) = (dive(), floor());
    unbroken.reset(dive.pose, 1).unwrap();
    let mut bytes = vec![0; 200_000];
    for step in 0..30 {
        let control = dive.advance(step);
        let scan = dive.look(features.iter().copied());
        unbroken.predict(&control, 0.1).unwrap();
        if step % 10 == 5 {
            let len = unbroken.save(3, into_slice(&mut bytes)).unwrap();
            broken.restore(3, from_slice(&bytes[..len])).unwrap();
            assert!(broken.candidates()[0].pose.pitch_rad == control.pitch_rad && control.pitch_rad != 0.0);
        } else if step > 5 {
            broken.predict(&control, 0.1).unwrap();
        }
        let report = unbroken.scan(&scan).unwrap();
        if step >= 5 {
            assert_eq!(broken.scan(&scan).unwrap(), report);
            assert_eq!(broken.digest(), unbroken.digest(), "{step}");
        }
    }
}

/// A camera looks down from 2 m: it expects nothing of what lies above it, and cannot confirm that. A good landmark in view is confirmed.
#[test]
fn what_the_camera_cannot_expect_is_not_confirmed_by_it() {
    for (height, sigma, features) in [(0.3, 10.0, 0), (2.5, 10.0, 0), (3.5, 10.0, 0), (0.3, 1e-3, 1)] {
        let config = Config { extraction: Extraction::Confirmed, confirming_detections: 3.0, ..Config::default() };
        let mut memory = Box::new(State::<AuvPose<f64>, 1, 1, Still<1>>::new());
        let mut filter = Filter::new(models(), births(0.0), Config { particles: 1, ..config }, &mut *memory).unwrap();
        filter.reset(AuvPose { z_m: 2.0, ..AuvPose::ZERO }, 1).unwrap();
        let covariance = Symmetric::from_diagonal([sigma * sigma; 3]);
        let mean = Vector3::new(0.1, 0.1, height);
        filter.load_map(&[Component { label: 1, ln_weight: 0.01_f64.ln(), mean, covariance }]).unwrap();
        assert_eq!(filter.estimate_map(&mut [Component::ZERO; 2]).features, features, "{height} {sigma}");
    }
}
