//! The archive of a joint map: reactivation of a submap, and memory.

use super::*;
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;

type Window = JointState<PlanarPose<f64>, Vector2<f64>, 40, { joint_numbers(3, 2, 40) }, 40>;

const REACH_M: f64 = 12.0;
/// Standard deviations of the sensor, m and rad.
const SENSOR: [f64; 2] = [0.1, 0.02];

/// Only one landmark of a submap within reach is left, so that the submap is not confirmed. The measurements of this
/// landmark initiate a new one.
#[test]
fn measurements_are_not_lost_to_a_submap_that_is_not_confirmed() {
    let window = RangeBearingWindow::full_circle(REACH_M, 0.9).unwrap();
    let sensing = Sensing::range_bearing([SENSOR[0], SENSOR[1]], window, 0.5).unwrap();
    let lidar = Detector::new(sensing, Births::of_static(1e-3)).unwrap();
    let (mut state, mut archive) = (Box::new(Window::new()), Box::new(JointArchive::<_, 8>::new()));
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02)).unwrap();
    let slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    {
        use super::archive::{Archive, Entry, Split};
        let mut view = slam.archive.view().unwrap();
        view.index.next_submap = 1;
        for label in 0..8 {
            let known = Split { own: Symmetric::from_diagonal([0.01; 2]), ..Split::ZERO };
            let mean = Vector2::new(5.0, label as f64 - 4.0);
            let existence = existence::Existence::of(1.0);
            view.put(Entry { label, mean, alone: known, given: known, existence, detections: 9.0, ..Entry::ZERO });
        }
    }
    slam.memory.header.next_label = 8;
    let mut detections = 0.0;
    for _ in 0..50 {
        let report = slam.scan(&lidar, &[Vector2::new(5.0, 0.0)]).unwrap();
        assert_eq!(report.reactivated, 0);
        detections += report.detections;
    }
    assert!(detections > 45.0, "{detections} of 50");
}

#[test]
fn the_memory_of_an_archived_feature_is_as_documented() {
    assert!(size_of::<archive::Entry<PlanarPose<f32>>>() == 344, "{}", size_of::<archive::Entry<PlanarPose<f32>>>());
}
