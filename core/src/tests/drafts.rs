//! Maps updated in drafts whose label assumptions turn out wrong.

use crate::tests::alone::{Alone, Models};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Memory = State<PlanarPose<f32>, 8, 16, MapMemory<Static<Vector2<f32>>, 8, 256, 32, 256>>;

/// A map of `count` features on a ring around the vehicle, most of which cause two measurements in the scans, and of as many on
/// a ring out of view, whose pages are kept.
fn features(count: u32) -> Vec<Component<Vector2<f32>>> {
    (0..2 * count)
        .map(|label| {
            let radius = if label < count { 10.0 } else { 60.0 };
            let (sine, cosine) = (core::f32::consts::TAU * label as f32 / count as f32).sin_cos();
            Component {
                label,
                ln_weight: 0.0,
                mean: Vector2::new(radius * cosine, radius * sine),
                covariance: Symmetric::from_diagonal([0.2, 0.2]),
            }
        })
        .collect()
}

/// Labels wrap around, and components that were split get new ones. For any start of the labels, also when they collide with
/// labels in the map, drafts give the same labels as updates in sequence.
#[test]
fn wrapped_labels_are_assigned_in_the_same_order() {
    const FEATURES: u32 = 40;
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    let models = Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::white(0.3, 0.05)).unwrap(),
        sensing: Sensing::range_bearing([0.2, 0.02], window, 5.0).unwrap(),
    };
    let config = Config { particles: 8, samples: 2, merge_distance: 0.01, ..Config::default() };
    let measurements: Vec<_> = (0..60)
        .map(|k| {
            Vector2::new(9.7 + 0.6 * (k % 2) as f32, wrap(core::f32::consts::TAU * (k / 2) as f32 / FEATURES as f32))
        })
        .collect();
    let mut met = 0;
    for next_label in (0..FEATURES).map(|k| k.wrapping_mul(3).wrapping_sub(64)) {
        let [alone, drafted] = [false, true].map(|drafts| {
            let mut state = Box::new(Memory::new());
            let mut updates = Box::new(UpdateMemory::<Memory, 3>::new());
            let mut filter = Alone::new(models, Births::of_static(0.01), config, &mut state).unwrap();
            filter.slam.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
            filter.slam.load_map(&features(FEATURES)).unwrap();
            filter.slam.memory.cursor.next_label = next_label;
            for _ in 0..3 {
                filter.slam.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
                if drafts {
                    let Alone { slam, detector } = &mut filter;
                    slam.scan_on(detector, &measurements, &Serial, &mut updates.drafts(), &mut ()).unwrap();
                } else {
                    filter.scan(&measurements).unwrap();
                }
            }
            (filter.slam.digest(), filter.slam.memory.cursor.next_label)
        });
        assert_eq!(alone, drafted, "from {next_label} on");
        // More than one label per measurement: some were given to copies of a component.
        met += usize::from(alone.1.wrapping_sub(next_label) > 3 * 60);
    }
    assert_eq!(met, FEATURES as usize);
}
