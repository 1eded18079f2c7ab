//! Steps that are short beside the spacing of single precision, far from the origin: what both filters make of them.

use crate::*;
use nalgebra::{Vector2, Vector3};

const SECONDS: usize = 60;
const SPEED_MPS: f32 = 0.04;
/// Places far from the origin, m. At the last one the spacing is not the same on both sides of it.
const PLACES: [[f32; 2]; 5] =
    [[5000.0, 0.0], [3000.0, -4000.0], [50_000.0, 0.0], [-30_000.0, 40_000.0], [-0.01, 32_768.0]];
const KIND: u32 = 5;

type Particles<P> = State<P, 2, 4, MapMemory<Static<PositionOf<P>>, 2, 4, 2, 8>>;
type Joint<P, const NUMBERS: usize> = JointState<P, Vector2<f32>, 1, NUMBERS, 1>;

/// Where each filter says that a vehicle is after a drive: blind particles, informed ones, the joint map. Halfway each is saved, and another one goes on from
/// the snapshot; it must come to the same digest.
fn driven<M, const NUMBERS: usize>(motion: M, start: M::Pose, hertz: usize, control: &M::Control) -> [M::Pose; 3]
where
    M: Motion<Pose: Pose<Scalar = f32>> + Copy,
{
    let (half, dt) = (SECONDS * hertz / 2, 1.0 / hertz as f32);
    let particles = [Config::blind(2, 2), Config::informed(2)].map(|config| {
        let [mut state, mut other] = [(); 2].map(|()| Box::new(Particles::<M::Pose>::new()));
        let mut slam = ScPhd::new(motion, config, &mut *state).unwrap();
        slam.reset(start, 1).unwrap();
        for _ in 0..half {
            slam.predict(control, dt).unwrap();
        }
        let mut bytes = [0; 1000];
        let len = slam.save(KIND, into_slice(&mut bytes)).unwrap();
        let mut restored = ScPhd::new(motion, config, &mut *other).unwrap();
        restored.restore(KIND, from_slice(&bytes[..len])).unwrap();
        for _ in 0..half {
            slam.predict(control, dt).unwrap();
            restored.predict(control, dt).unwrap();
        }
        assert_eq!(slam.digest(), restored.digest());
        slam.candidates()[0].pose
    });
    let [mut state, mut other] = [(); 2].map(|()| Box::new(Joint::<M::Pose, NUMBERS>::new()));
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    slam.reset(start).unwrap();
    for _ in 0..half {
        slam.predict(control, dt).unwrap();
    }
    let mut bytes = [0; 1000];
    let len = slam.save(KIND, into_slice(&mut bytes)).unwrap();
    let mut restored = JointSlam::new(motion, JointConfig::default(), &mut *other).unwrap();
    restored.restore(KIND, from_slice(&bytes[..len])).unwrap();
    for _ in 0..half {
        slam.predict(control, dt).unwrap();
        restored.predict(control, dt).unwrap();
    }
    assert_eq!(slam.digest(), restored.digest());
    let [blind, informed] = particles;
    [blind, informed, slam.estimate_pose().unwrap().mean]
}

/// Drives a planar vehicle from far away, and from the origin in double precision; what it ends at there is where it must end here.
fn check<M, E>(motion: M, exact: E, turns: &[f32], controls: impl Fn(f32) -> (M::Control, E::Control))
where
    M: Motion<Pose = PlanarPose<f32>> + Copy,
    E: Motion<Pose = PlanarPose<f64>>,
{
    for (place, (hertz, &turn)) in PLACES.iter().flat_map(|place| {
        let drives = [200, 50].into_iter().flat_map(|hertz| turns.iter().map(move |turn| (hertz, turn)));
        drives.map(move |drive| (place, drive))
    }) {
        let (control, told) = controls(turn);
        let [x, y] = *place;
        let ends = driven::<M, { joint_numbers(3, 2, 1) }>(motion, PlanarPose::new(x, y, 0.7), hertz, &control);
        let dt = f64::from(1.0 / hertz as f32);
        let begin = PlanarPose::new(f64::from(x), f64::from(y), f64::from(0.7_f32));
        let end = (0..SECONDS * hertz).fold(begin, |pose, _| exact.propagate(&pose, &told, dt));
        for (filter, pose) in ends.iter().enumerate() {
            let found = PlanarPose::new(f64::from(pose.x_m), f64::from(pose.y_m), f64::from(pose.heading_rad));
            let (off, turned) = (found.distance_m(&end), wrap(found.heading_rad - end.heading_rad));
            let way = f64::from(SPEED_MPS) * SECONDS as f64;
            assert!(off < 0.01 * way, "filter {filter} at {place:?}, {hertz} Hz, turn {turn}: off by {off} m");
            assert!(turned.abs() < 1e-3, "filter {filter} at {place:?}, {hertz} Hz, turn {turn}: off by {turned} rad");
        }
    }
}

#[test]
fn a_slow_robot_moves_far_from_the_origin() {
    for step in [Step::Arc, Step::Euler] {
        let motion = Unicycle::new(step, ControlNoise::NONE).unwrap();
        let exact = Unicycle::new(step, ControlNoise::NONE).unwrap();
        check(motion, exact, &[0.0, 0.05], |rate| {
            let told = UnicycleControl { speed_mps: f64::from(SPEED_MPS), rate_radps: f64::from(rate) };
            (UnicycleControl { speed_mps: SPEED_MPS, rate_radps: rate }, told)
        });
    }
}

#[test]
fn a_slow_car_moves_far_from_the_origin() {
    let geometry =
        AckermannGeometry { wheelbase_m: 2.8_f32, encoder_offset_m: 0.7, sensor_forward_m: 3.7, sensor_left_m: 0.5 };
    let exact = AckermannGeometry {
        wheelbase_m: f64::from(geometry.wheelbase_m),
        encoder_offset_m: f64::from(geometry.encoder_offset_m),
        sensor_forward_m: f64::from(geometry.sensor_forward_m),
        sensor_left_m: f64::from(geometry.sensor_left_m),
    };
    let motion = Ackermann::new(geometry, ControlNoise::NONE).unwrap();
    check(motion, Ackermann::new(exact, ControlNoise::NONE).unwrap(), &[0.0, -0.4], |steering| {
        let told = AckermannControl { speed_mps: f64::from(SPEED_MPS), steering_rad: f64::from(steering) };
        (AckermannControl { speed_mps: SPEED_MPS, steering_rad: steering }, told)
    });
}

/// Backwards and aside.
#[test]
fn a_slow_vehicle_that_moves_aside_moves_far_from_the_origin() {
    let motion = Holonomic::new(ControlNoise::NONE).unwrap();
    let exact = Holonomic::new(ControlNoise::NONE).unwrap();
    check(motion, exact, &[0.0, 0.05], |rate| {
        let [forward_mps, left_mps] = [-0.6 * SPEED_MPS, 0.8 * SPEED_MPS];
        let (forward, left) = (f64::from(forward_mps), f64::from(left_mps));
        let told = HolonomicControl { forward_mps: forward, left_mps: left, rate_radps: f64::from(rate) };
        (HolonomicControl { forward_mps, left_mps, rate_radps: rate }, told)
    });
}

#[test]
fn a_slow_vehicle_in_space_moves_far_from_the_origin() {
    let control = |rate: f32| AuvControl {
        velocity_mps: Vector3::new(SPEED_MPS, 0.0, 0.0),
        velocity_covariance: Symmetric::ZERO,
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rate_radps: Some(Reading { value: rate, sigma: 1e-6 }),
        z_m: Some(Reading { value: -3.0, sigma: 0.1 }),
    };
    let (motion, exact) = (Auv::new(1e-6_f32, 0.0).unwrap(), Auv::new(f64::from(1e-6_f32), 0.0).unwrap());
    for ([x, y], rate) in PLACES.into_iter().flat_map(|place| [(place, 0.0), (place, 0.05)]) {
        let turning = AuvPose { yaw_rate_radps: rate, ..AuvPose::new(x, y, -3.0, 0.7) };
        let ends = driven::<_, { joint_numbers(5, 3, 1) }>(motion, turning, 200, &control(rate));
        let wide = |x: f32| f64::from(x);
        let begin = AuvPose { yaw_rate_radps: wide(rate), ..AuvPose::new(wide(x), wide(y), -3.0, wide(0.7)) };
        let (told, dt) = (control(rate).rounded::<f64>(), wide(1.0 / 200.0));
        let end = (0..SECONDS * 200).fold(begin, |pose, _| exact.propagate(&pose, &told, dt));
        for (filter, pose) in ends.iter().enumerate() {
            let found = AuvPose::new(wide(pose.x_m), wide(pose.y_m), wide(pose.z_m), wide(pose.yaw_rad));
            let (off, turned) = (found.distance_m(&end), wrap(found.yaw_rad - end.yaw_rad));
            assert!(off < 0.024, "filter {filter} at {x}, {y}, rate {rate}: off by {off} m");
            assert!(turned.abs() < 1e-3, "filter {filter} at {x}, {y}, rate {rate}: off by {turned} rad");
        }
    }
}

/// What the noise adds up to, too, of steps of which most are rounded away: √(Σ σ² dt²) along the heading.
#[test]
fn a_slow_robot_spreads_far_from_the_origin() {
    const N: usize = 400;
    type Many = State<PlanarPose<f32>, N, N, MapMemory<Static<Vector2<f32>>, N, 4, 2, 8>>;
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.01_f32, 0.0)).unwrap();
    let mut state = Box::new(Many::new());
    let mut slam = ScPhd::new(motion, Config::blind(N, 1), &mut *state).unwrap();
    slam.reset(PlanarPose::new(5000.0, 0.0, 0.0), 1).unwrap();
    for _ in 0..12_000 {
        slam.predict(&UnicycleControl { speed_mps: SPEED_MPS, rate_radps: 0.0 }, 0.005).unwrap();
    }
    let [x, y] = [0, 1].map(|axis| {
        let of = |candidate: &Candidate<PlanarPose<f32>>| f64::from(candidate.pose.coordinates()[axis]);
        let mean = slam.candidates().iter().map(of).sum::<f64>() / N as f64;
        let squares: f64 = slam.candidates().iter().map(|candidate| (of(candidate) - mean).powi(2)).sum();
        (mean, (squares / N as f64).sqrt())
    });
    let sigma = 0.01 * 0.005 * 12_000_f64.sqrt();
    assert!((x.0 - 5002.4).abs() < 5.0 * sigma / 20.0 && (x.1 / sigma - 1.0).abs() < 0.15, "{x:?} of {sigma}");
    assert_eq!(y, (0.0, 0.0));
}

/// Steps with nothing between them, as encoders of few lines count them.
#[test]
fn what_is_left_over_waits_while_the_vehicle_stands() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut state = Box::new(Joint::<PlanarPose<f32>, { joint_numbers(3, 2, 1) }>::new());
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::new(50_000.0, 0.0, 0.0)).unwrap();
    let control = |speed_mps| UnicycleControl { speed_mps, rate_radps: 0.0 };
    for step in 0..12_000 {
        slam.predict(&control(if step % 5 == 0 { 5.0 * SPEED_MPS } else { 0.0 }), 0.005).unwrap();
    }
    assert!((slam.estimate_pose().unwrap().mean.x_m - 50_002.4).abs() < 0.01);
}

/// A pose that is set is that pose.
#[test]
fn nothing_is_left_over_where_the_vehicle_is_put_elsewhere() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let start = PlanarPose::new(5000.0, 0.0, 0.0);
    let crawl = UnicycleControl { speed_mps: SPEED_MPS, rate_radps: 0.0 };
    let [mut state, mut fresh] = [(); 2].map(|()| Box::new(Particles::<PlanarPose<f32>>::new()));
    let mut slam = ScPhd::new(motion, Config::informed(2), &mut *state).unwrap();
    let mut other = ScPhd::new(motion, Config::informed(2), &mut *fresh).unwrap();
    other.reset(start, 1).unwrap();
    slam.reset(start, 1).unwrap();
    slam.predict(&crawl, 0.005).unwrap();
    // It has not moved yet, and is not what it was all the same.
    assert_eq!(slam.candidates()[0].pose, start);
    slam.reset(start, 1).unwrap();
    assert_eq!(slam.digest(), other.digest());
    slam.predict(&crawl, 0.005).unwrap();
    slam.relocate(start, &Symmetric::ZERO).unwrap();
    let moved = |slam: &mut ScPhd<'_, Unicycle<f32>>| {
        (0..100)
            .filter(|_| {
                slam.predict(&crawl, 0.005).unwrap();
                slam.candidates()[0].pose.x_m > 5000.0
            })
            .count()
    };
    assert_eq!(moved(&mut slam), moved(&mut other));
}
