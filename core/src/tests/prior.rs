//! A prior with an invalid covariance.

use crate::tests::alone::{Alone, Models};
use crate::tests::linear::{Drift, linear_sensing};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;

/// A very small variance with a covariance that is too large for it.
#[test]
fn a_prior_with_an_invalid_covariance_leaves_the_state_valid() {
    type Memory = State<PlanarPose<f64>, 1, 4, MapMemory<Static<Vector2<f64>>, 1, 64, 16, 128>>;
    for sampled_fraction in [0.0, 0.4] {
        let models = Models { motion: Drift { sigmas: [0.5, 0.2] }, sensing: linear_sensing([0.09, 0.16], 0.9, 1e-12) };
        let proposal = Proposal::Informed(Informed { sampled_fraction, ..Informed::default() });
        let config = Config { particles: 1, samples: 4, proposal, ..Config::default() };
        let mut memory = Box::new(Memory::new());
        let mut filter = Alone::new(models, Births::NONE, config, &mut memory).unwrap();
        filter.reset(PlanarPose::new(1.0, -2.0, 0.3), 1).unwrap();
        let feature = |x: f64, y: f64| Component {
            label: x as u32,
            ln_weight: 0.7_f64.ln(),
            mean: Vector2::new(x, y),
            covariance: Symmetric::from_fn(|row, column| if row == column { 0.04 } else { 0.01 }),
        };
        filter.load_map(&[feature(10.0, 5.0), feature(-8.0, 14.0)]).unwrap();
        filter.predict(&Vector2::new(3.0, 1.0), 1.0).unwrap();
        filter.slam.memory.pose_covariances[0] = Symmetric::from_fn(|row, column| match (row, column) {
            (0, 0) => 1e-300,
            (1, 0) => 1e12,
            (1, 1) => 1.0,
            _ => 0.0,
        });
        filter.scan(&[Vector2::new(5.3, 6.4), Vector2::new(-12.4, 14.7)]).unwrap();
        assert_eq!(filter.audit(), Ok(()));
        assert!(filter.estimate_pose().unwrap().covariance.is_finite());
    }
}
