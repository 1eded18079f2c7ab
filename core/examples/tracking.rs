//! Tracking from a known place: with one particle and a known pose the filter is a Gaussian-mixture PHD filter. Three targets that move
//! among false measurements, told by their velocities and by labels that last.

use core::f32::consts::PI;
use nalgebra::{Vector2, Vector4};
use scphd::models::{KnownPose, PlanarPose, Pose, RangeBearingWindow, Sensing};
use scphd::numerics::Noise;
use scphd::settings::MovingConfig;
use scphd::{Births, Component, Config, Detector, DetectorMemory, ScPhd, memory};

memory! {
    type Memory: KnownPose<PlanarPose<f32>> {
        particles: 1, samples: 1,
        features { pages: 16, pages_per_map: 16, in_view: 64 },
        moving { pages: 64, pages_per_map: 32, in_view: 512 },
    }
}

/// Where a target is at the start, m, and its velocity, m/s.
const TARGETS: [[f32; 4]; 3] = [[-20.0, 10.0, 2.0, 0.0], [15.0, 15.0, -1.0, -1.5], [5.0, -20.0, 0.0, 1.5]];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let window = RangeBearingWindow::full_circle(40.0, 0.95)?;
    let sensing = Sensing::range_bearing([0.3, 0.01], window, 5.0)?;
    let (mut state, mut scratch) = (Box::new(Memory::new()), DetectorMemory::<Vector2<f32>, 32>::new());
    // Everything moves.
    let births = Births { of_static: 0.0, of_moving: 0.1 / window.measure() };
    let mut radar = Detector::new(sensing, births)?.over(&mut scratch)?;
    let moving = MovingConfig { velocity_sigma_mps: 2.0, ..MovingConfig::walkers() };
    let config = Config { moving, prune_weight: 1e-5, ..Config::tracking() };
    let mut tracker = ScPhd::new(KnownPose::new(), config, &mut *state)?;
    tracker.reset(PlanarPose::ZERO, 1)?;
    tracker.check(&radar)?;

    let mut draws = Noise::seeded(4);
    let mut tracks = [Component::ZERO; 16];
    let (mut found, mut squares) = (0, 0.0);
    for step in 1..=100 {
        let t_s = 0.1 * step as f32;
        let places = TARGETS.map(|[x, y, vx, vy]| [x + vx * t_s, y + vy * t_s]);
        let mut scan = Vec::new();
        for [x, y] in places {
            let noise = Vector2::new(0.3 * draws.normal::<f32>(), 0.01 * draws.normal::<f32>());
            if draws.uniform::<f32>() < 0.95 {
                scan.push(Vector2::new(x.hypot(y), y.atan2(x)) + noise);
            }
        }
        for _ in 0..5 {
            scan.push(Vector2::new(40.0 * draws.uniform::<f32>(), PI * (2.0 * draws.uniform::<f32>() - 1.0)));
        }
        tracker.predict(&PlanarPose::ZERO, 0.1)?;
        tracker.scan(&mut radar, &scan)?;
        let estimate = tracker.estimate_moving(&mut tracks);
        for [x, y] in places.iter().filter(|_| step > 20) {
            let off = |track: &Component<Vector4<f32>>| (track.mean.x - x).hypot(track.mean.y - y);
            let nearest = tracks.iter().take(estimate.features).map(off).fold(f32::MAX, f32::min);
            if nearest < 1.5 {
                (found, squares) = (found + 1, squares + nearest * nearest);
            }
        }
    }
    let estimate = tracker.estimate_moving(&mut tracks);
    for track in tracks.iter().take(estimate.features) {
        let [x, y, vx, vy] = track.mean.into();
        println!("track {}: {x:.1} m, {y:.1} m, {vx:.2} m/s, {vy:.2} m/s", track.label);
    }
    let share = found as f32 / 240.0;
    println!("found {:.0} % of the time, {:.2} m off", 100.0 * share, (squares / found as f32).sqrt());
    assert!(share > 0.95 && estimate.features == TARGETS.len());
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
