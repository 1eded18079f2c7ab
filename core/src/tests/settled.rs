//! Number of iterations of the informed proposal.

use crate::tests::alone::{Alone, Models};
use crate::tests::linear::{Drift, linear_sensing};
use crate::*;
use core::sync::atomic::{AtomicUsize, Ordering};
use nalgebra::Vector2;
use std::boxed::Box;

static LOOKS: AtomicUsize = AtomicUsize::new(0);

/// A constant p_D that counts its calls.
struct Counted;

impl FieldOfView<Vector2<f64>, Vector2<f64>, Vector2<f64>> for Counted {
    fn detection_probability(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Vector2<f64>) -> f64 {
        LOOKS.fetch_add(1, Ordering::Relaxed);
        0.9
    }
    fn bounds(&self, _: &Vector2<f64>) -> Bounds<Vector2<f64>> {
        Bounds::EVERYWHERE
    }
}

/// Number of calls in a scan of two features, and the estimated pose.
fn scanned(rounds: usize) -> (usize, Vector2<f64>) {
    type Memory = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 8, 8, 32>>;
    let Sensing { sensor, clutter, .. } = linear_sensing([0.09, 0.16], 0.9, 1e-12);
    let sensing = Sensing { sensor, field_of_view: Counted, clutter };
    let models = Models { motion: Drift { sigmas: [0.5, 0.2] }, sensing };
    let proposal = Proposal::Informed(Informed { rounds, sampled_fraction: 0.0, ..Informed::default() });
    let config = Config { particles: 1, samples: 1, proposal, ..Config::default() };
    let mut memory = Box::new(Memory::new());
    let mut filter = Alone::new(models, Births::NONE, config, &mut memory).unwrap();
    filter.reset(PlanarPose::new(1.0, -2.0, 0.0), 1).unwrap();
    let feature = |label: u32, x: f64, y: f64| {
        let covariance = Symmetric::from_diagonal([0.04, 0.04]);
        Component { label, ln_weight: 0.7_f64.ln(), mean: Vector2::new(x, y), covariance }
    };
    filter.load_map(&[feature(0, 10.0, 5.0), feature(1, -8.0, 14.0)]).unwrap();
    filter.predict(&Vector2::new(3.0, 1.0), 1.0).unwrap();
    LOOKS.store(0, Ordering::Relaxed);
    // Measurements from a pose with a Mahalanobis distance of 0.9 from the predicted one.
    filter.scan(&[Vector2::new(5.6, 6.1), Vector2::new(-12.4, 15.1)]).unwrap();
    let pose = filter.estimate_pose().unwrap().mean;
    (LOOKS.load(Ordering::Relaxed), Vector2::new(pose.x_m, pose.y_m))
}

/// In a linear model the first iteration finds the pose, the second confirms it, and there is no third one. Each iteration but
/// the first evaluates every feature twice.
#[test]
fn a_converged_iteration_is_the_last() {
    let [(once, first), (twice, second), (often, last)] = [1, 2, 16].map(scanned);
    assert_eq!((twice - once, often), (4, twice));
    assert_eq!(second, last);
    assert!((second - first).norm() < 0.01 && (first.x - 4.0).abs() > 0.2, "{first} {second}");
}
