//! Identical particles: one is updated for all.

use crate::tests::snapshots::world::{Scratch, detector, motion, start, world};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Still = MapMemory<Static<Vector2<f64>>, 4, 256, 64, 256>;
type Moving = MapMemory<Dynamic<Vector2<f64>>, 4, 256, 64, 256>;
type Memory = State<PlanarPose<f64>, 4, 4, Still, Moving>;

#[test]
fn four_are_each_the_one_that_a_single_particle_is() {
    for births_wait in [false, true] {
        let mut memory = [(); 2].map(|()| (Box::new(Memory::new()), Scratch::new()));
        let [(alone, scratch), (four, of_four)] = &mut memory;
        let mut slam = [(alone, 1), (four, 4)].map(|(memory, particles)| {
            let config = Config { births_wait, prune_weight: 0.01, ..Config::informed(particles) };
            let mut slam = ScPhd::new(motion(), config, &mut **memory).unwrap();
            slam.reset(start(), 5).unwrap();
            slam
        });
        let mut eyes = [detector(scratch, true), detector(of_four, true)];
        for step in world::<f64>(60) {
            let mut reports = slam.iter_mut().zip(&mut eyes).map(|(slam, eyes)| {
                slam.predict(&step.odometry, 0.1).unwrap();
                slam.scan(eyes, &step.scan).unwrap()
            });
            let [one, all] = [reports.next().unwrap(), reports.next().unwrap()];
            assert_eq!((all.particles, all.candidates, all.maps_updated, all.survivors), (4, 4, 1, 1));
            assert_eq!((all.n_eff, all.ln_evidence, all.pages_used), (4.0, one.ln_evidence, one.pages_used));
            let [alone, four] = &slam;
            assert_eq!((four.particles(), four.survivors(), four.ln_likelihoods().len()), (4, &[0; 4][..], 4));
            for particle in 0..4 {
                assert_eq!(four.candidates()[particle].pose, alone.candidates()[0].pose);
                assert_eq!(four.candidates()[particle].ln_weight, -(4_f64.ln()));
                assert_eq!(four.map(particle).collect::<Vec<_>>(), alone.map(0).collect::<Vec<_>>());
                assert_eq!(four.moving_map(particle).collect::<Vec<_>>(), alone.moving_map(0).collect::<Vec<_>>());
            }
        }
        assert!(slam[0].map(0).count() > 5);
    }
}

#[test]
fn particles_that_differ_are_each_updated() {
    let (mut memory, mut scratch) = (Box::new(Memory::new()), Scratch::new());
    let mut slam = ScPhd::new(motion(), Config::informed(4), &mut *memory).unwrap();
    slam.reset(start(), 5).unwrap();
    let mut eyes = detector(&mut scratch, true);
    for (index, step) in world::<f64>(10).into_iter().enumerate() {
        slam.predict(&step.odometry, 0.1).unwrap();
        if index == 5 {
            slam.memory.candidates[2].pose.x_m += 0.01;
        }
        let report = slam.scan(&mut eyes, &step.scan).unwrap();
        assert_eq!((report.particles, report.maps_updated), (4, if index < 5 { 1 } else { 4 }));
        assert!(slam.audit().is_ok());
    }
}
