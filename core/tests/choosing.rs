//! The memories of docs/choosing.md take what it says.

use nalgebra::Vector2;
use scphd::models::{Ackermann, KnownPose, PlanarPose, Unicycle};
use scphd::{DetectorMemory, joint_memory, memory};

joint_memory! { type Hall: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 } }
joint_memory! { type Court: Unicycle<f32> { measurement: Vector2<f32>, features: 64, measurements: 32 } }
joint_memory! { type Yard: Unicycle<f32> { measurement: Vector2<f32>, features: 100, measurements: 32 } }
memory! {
    type Few: Unicycle<f32> { particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 } }
}
memory! {
    type FewAndMoving: Ackermann<f32> {
        particles: 4, samples: 1,
        features { pages: 128, pages_per_map: 32, in_view: 256 },
        moving { pages: 64, pages_per_map: 16, in_view: 128 },
    }
}
memory! {
    type Many: Ackermann<f32> {
        particles: 32, samples: 2, features { pages: 192, pages_per_map: 32, in_view: 256 },
        moving { pages: 112, pages_per_map: 16, in_view: 128 },
    }
}
memory! {
    type Mast: KnownPose<PlanarPose<f32>> {
        particles: 1, samples: 1,
        features { pages: 8, pages_per_map: 8, in_view: 64 }, moving { pages: 48, pages_per_map: 32, in_view: 256 },
    }
}

#[test]
fn the_table_says_how_much_they_take() {
    let page = include_str!("../../docs/choosing.md");
    let memories = [
        ("Hall", size_of::<Hall>()),
        ("Court", size_of::<Court>()),
        ("Yard", size_of::<Yard>()),
        ("Few", size_of::<Few>()),
        ("FewAndMoving", size_of::<FewAndMoving>()),
        ("Many", size_of::<Many>()),
        ("Mast", size_of::<Mast>()),
    ];
    let said = memories.map(|(name, bytes)| format!("`{name}`: {} KiB", bytes.div_ceil(1024)));
    assert!(said.iter().all(|said| page.contains(said)), "docs/choosing.md should say {said:?}");
    let detector = size_of::<DetectorMemory<Vector2<f32>, 64>>();
    let each = detector.div_ceil(64);
    assert!(page.contains(&format!("some {each} bytes a measurement")), "{detector} bytes for 64 measurements");
}
