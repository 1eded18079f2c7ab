//! Memory of the queues: the figures of `docs/time.md`, on a host.

use heapless::Vec;
use scphd::models::{AuvPose, PlanarPose, UnicycleControl};
use scphd::numerics::nalgebra::Vector2;
use scphd_sequencer::{Sequencer, SmoothOdometry};

#[allow(dead_code, reason = "only its size counts")]
#[allow(clippy::large_enum_variant, reason = "a vehicle has no heap to box a scan on")]
enum Event {
    Lidar(Vec<Vector2<f32>, 32>),
    Gps(Vector2<f32>),
}
type Inputs<const CONTROLS: usize, const EVENTS: usize> = Sequencer<UnicycleControl<f32>, Event, CONTROLS, EVENTS>;

#[test]
fn every_element_of_a_queue_has_its_size() {
    let size = size_of::<Inputs<16, 8>>();
    // 16 bytes for time, source and number, in addition to the input.
    let [control, event] = [size_of::<Inputs<17, 8>>() - size, size_of::<Inputs<16, 9>>() - size];
    assert_eq!((control, event), (16 + size_of::<UnicycleControl<f32>>(), 16 + size_of::<Event>()));
    assert_eq!((size, control, event, size - 16 * control - 8 * event), (2968, 24, 288, 280));
}

#[test]
fn smooth_odometry_takes_less_than_a_hundred_bytes() {
    assert_eq!(size_of::<SmoothOdometry<PlanarPose<f32>>>(), 36);
    assert_eq!(size_of::<SmoothOdometry<AuvPose<f32>>>(), 56);
}
