//! The sets of capacities that memory comes in: a type and a line each.
//!
//! The numbers of bytes are the same for every target: those of the largest, rounded up. A set that is smaller than its memory on some
//! target, or larger by more than a sixteenth and 256, does not compile there.

/// The memories of the sets.
pub(crate) mod memories {
    use nalgebra::{Vector1, Vector2, Vector3};
    use scphd::models::{Auv, Unicycle};
    use scphd::{DetectorMemory, joint_memory, memory};

    memory! {
        pub(crate) type Plane32x2: Unicycle<f32> {
            particles: 32, samples: 2, features { pages: 320, pages_per_map: 32, in_view: 256 },
            moving { pages: 128, pages_per_map: 16, in_view: 128 },
        }
    }
    memory! {
        pub(crate) type PlaneInformed4: Unicycle<f32> {
            particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
        }
    }
    memory! {
        pub(crate) type PlaneInformed4Moving: Unicycle<f32> {
            particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
            moving { pages: 64, pages_per_map: 16, in_view: 128 },
        }
    }
    memory! {
        pub(crate) type WaterInformed16: Auv<f32> {
            particles: 16, samples: 1, features { pages: 160, pages_per_map: 24, in_view: 256 },
        }
    }
    joint_memory! {
        pub(crate) type Joint40: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 }
    }
    joint_memory! {
        pub(crate) type Joint100: Unicycle<f32> { measurement: Vector2<f32>, features: 100, measurements: 32 }
    }
    pub(crate) type RangeBearing32 = DetectorMemory<Vector2<f32>, 32>;
    pub(crate) type RangeBearing128 = DetectorMemory<Vector2<f32>, 128>;
    pub(crate) type Bearing64 = DetectorMemory<Vector1<f32>, 64>;
    pub(crate) type Sonar64 = DetectorMemory<Vector3<f32>, 64>;
}

/// A set of capacities, as the header names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Set {
    /// Its name, after `SCPHD_SET_`.
    pub name: &'static str,
    /// Its number: hundreds for each kind.
    pub number: u32,
    /// The memory it takes, bytes.
    pub bytes: usize,
    /// What there is room for.
    pub about: &'static str,
}

macro_rules! sets {
    ($d:tt $($choose:ident, $handle:ident {
        $($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident;)+
    })+) => {
        /// All sets there are.
        pub const SETS: &[Set] = &[$($(
            Set { name: stringify!($name), number: $number, bytes: $bytes, about: concat!($($about),+) },
        )+)+];

        $(
            /// Makes a handle in a memory of whatever set of its kind it is.
            macro_rules! $choose {
                ($d memory:expr, |$d state:ident| $d make:expr) => {
                    match $d memory.set.number {
                        $($number => $d memory.make::<$handle, $crate::sets::memories::$memory>(|$d state| $d make),)+
                        _ => Err($crate::scphd_status::UnknownSet),
                    }
                };
            }
            pub(crate) use $choose;
        )+
    };
}

/// Hands the table of the sets, behind whatever `first` is, to another macro.
macro_rules! table {
    ($then:ident $($first:tt)?) => {
        $then! { $($first)?
            in_plane, scphd_plane {
                /// Mixture in the plane: 32 particles of two samples, 320 pages of features, 32 to a map, 256 in view; 128 pages of moving ones.
                PLANE_32X2 = 101, 203_776 bytes of Plane32x2;
                /// Mixture in the plane: four informed particles, 128 pages of features, 32 to a map, 256 in view; none that move.
                PLANE_INFORMED_4 = 102, 53_248 bytes of PlaneInformed4;
                /// The same with 64 pages of moving features, 16 to a map, 128 in view.
                PLANE_INFORMED_4_MOVING = 103, 100_352 bytes of PlaneInformed4Moving;
            }
            in_joint, scphd_joint {
                /// Joint map in the plane: 40 features, scans of 32 measurements.
                JOINT_40 = 201, 20_480 bytes of Joint40;
                /// Joint map in the plane: 100 features, scans of 32 measurements.
                JOINT_100 = 202, 93_184 bytes of Joint100;
            }
            in_water, scphd_water {
                /// Mixture under water: 16 informed particles, 160 pages of features, 24 to a map, 256 in view; none that move.
                WATER_INFORMED_16 = 301, 94_208 bytes of WaterInformed16;
            }
            in_range_bearing, scphd_range_bearing_detector {
                /// Detector of range and bearing: scans of 32 measurements.
                RANGE_BEARING_32 = 401, 1_024 bytes of RangeBearing32;
                /// Detector of range and bearing: scans of 128 measurements.
                RANGE_BEARING_128 = 402, 2_816 bytes of RangeBearing128;
            }
            in_bearing, scphd_bearing_detector {
                /// Detector of bearings alone: scans of 64 measurements.
                BEARING_64 = 501, 1_280 bytes of Bearing64;
            }
            in_sonar, scphd_sonar_detector {
                /// Detector of range, bearing and elevation: scans of 64 measurements.
                SONAR_64 = 601, 2_048 bytes of Sonar64;
            }
        }
    };
}
pub(crate) use table;

table!(sets $);

/// The set of this number.
pub(crate) fn find(number: u32) -> Option<&'static Set> {
    SETS.iter().find(|set| set.number == number)
}

/// How much memory a set needs, bytes: `SCPHD_SIZE_...` of its name. 0 for a set that is not known.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_memory_size(set: u32) -> usize {
    find(set).map_or(0, |set| set.bytes)
}

#[cfg(test)]
mod tests {
    use super::SETS;

    #[test]
    fn names_and_numbers_are_of_one_set_each() {
        for (place, set) in SETS.iter().enumerate() {
            assert!(SETS[..place].iter().all(|other| other.name != set.name && other.number != set.number));
            assert_eq!(crate::scphd_memory_size(set.number), set.bytes);
        }
        assert_eq!(crate::scphd_memory_size(0), 0);
    }
}
