//! The sets of capacities: a type and a line for each.
//!
//! The byte numbers are the same for every target: the largest one, rounded up. On a target where the memory does not fit, or is
//! smaller by more than a sixteenth and 256 bytes, the crate does not compile.

/// The memories of the sets.
pub(crate) mod memories {
    use nalgebra::Vector3;
    use scphd::models::Auv;
    use scphd::{DetectorMemory, memory};
    pub(crate) use scphd_vehicle::sets::*;

    memory! {
        pub(crate) type WaterInformed16: Auv<f32> {
            particles: 16, samples: 1, features { pages: 160, pages_per_map: 24, in_view: 256 },
        }
    }
    pub(crate) type Sonar64 = DetectorMemory<Vector3<f32>, 64>;
}

/// A set of capacities, with its name in the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Set {
    /// Name after `SCPHD_SIZE_`.
    pub name: &'static str,
    /// Number; the hundreds are the kind.
    pub number: u32,
    /// Size of the memory, bytes.
    pub bytes: usize,
    /// Description of the capacities.
    pub about: &'static str,
    /// The functions that start a filter in this memory, resume one, and give its services.
    pub functions: Option<[&'static str; 3]>,
}

/// A mixture under water.
pub(crate) const WATER_INFORMED_16: Set = Set {
    name: "WATER_INFORMED_16",
    number: 201,
    bytes: 94_208,
    about: " Mixture under water: 16 informed particles, 160 pages of features, 24 to a map, 256 in view; none that move.",
    functions: None,
};
/// A sonar.
pub(crate) const SONAR_64: Set = Set {
    name: "SONAR_64",
    number: 301,
    bytes: 1_792,
    about: " Detector of range, bearing and elevation: scans of 64 measurements.",
    functions: None,
};
/// A description.
pub(crate) const DESCRIPTION: Set =
    Set { name: "DESCRIPTION", number: 401, bytes: 656, about: " A description of a vehicle.", functions: None };

/// Passes the table of the sets for described filters to another macro.
macro_rules! table {
    ($then:ident) => {
        $then! {
            /// Joint map: 40 features, scans of 32 measurements.
            JOINT_40 = 101, 23_552 bytes of Joint40: scphd_start_joint_40, scphd_resume_joint_40, scphd_services_joint_40;
            /// Joint map: 100 features, scans of 32 measurements.
            JOINT_100 = 102, 99_328 bytes of Joint100: scphd_start_joint_100, scphd_resume_joint_100, scphd_services_joint_100;
            /// Joint map: 60 static and 16 moving features, scans of 32 measurements.
            JOINT_60_MOVERS = 103, 44_032 bytes of Joint60Movers: scphd_start_joint_60_movers, scphd_resume_joint_60_movers, scphd_services_joint_60_movers;
            /// Joint map: 100 static and 32 moving features, scans of 32 measurements.
            JOINT_100_MOVERS = 104, 102_400 bytes of Joint100Movers: scphd_start_joint_100_movers, scphd_resume_joint_100_movers, scphd_services_joint_100_movers;
            /// Joint map: 40 static and 16 moving features, and an archive of 1000 distant features; scans of 32 measurements.
            JOINT_40_ARCHIVE = 105, 368_640 bytes of Joint40Archive: scphd_start_joint_40_archive, scphd_resume_joint_40_archive, scphd_services_joint_40_archive;
            /// Joint map that estimates the odometry error: 60 features, scans of 32 measurements.
            JOINT_60_LEARNING = 106, 44_032 bytes of Joint60Learning: scphd_start_joint_60_learning, scphd_resume_joint_60_learning, scphd_services_joint_60_learning;
            /// Joint map with eight hypotheses of data association, each with 24 static and 8 moving features; scans of 16
            /// measurements.
            JOINT_24_HYPOTHESES = 107, 65_536 bytes of Joint24Hypotheses: scphd_start_joint_24_hypotheses, scphd_resume_joint_24_hypotheses, scphd_services_joint_24_hypotheses;
            /// Mixture: 32 particles of two samples, 320 pages of features, 32 to a map, 256 in view; 128 pages of moving ones;
            /// scans of 128 measurements, of range and bearing or of bearings alone.
            MIXTURE_32X2 = 111, 206_848 bytes of Mixture32x2: scphd_start_mixture_32x2, scphd_resume_mixture_32x2, scphd_services_mixture_32x2;
            /// Mixture: four informed particles, 128 pages of features, 32 to a map, 256 in view; no moving ones; scans of 64
            /// measurements.
            MIXTURE_INFORMED_4 = 112, 55_296 bytes of MixtureInformed4: scphd_start_mixture_informed_4, scphd_resume_mixture_informed_4, scphd_services_mixture_informed_4;
            /// As the previous one, with 64 pages of moving features, 16 to a map, 128 in view.
            MIXTURE_INFORMED_4_MOVING = 113, 102_400 bytes of MixtureInformed4Moving: scphd_start_mixture_informed_4_moving, scphd_resume_mixture_informed_4_moving, scphd_services_mixture_informed_4_moving;
        }
    };
}
pub(crate) use table;

macro_rules! sets {
    ($($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident: $start:ident, $resume:ident, $services:ident;)+) => {
        $(
            pub(crate) const $name: Set = Set {
                name: stringify!($name),
                number: $number,
                bytes: $bytes,
                about: concat!($($about),+),
                functions: Some([stringify!($start), stringify!($resume), stringify!($services)]),
            };
        )+

        /// All sets.
        pub const SETS: &[Set] = &[$($name,)+ WATER_INFORMED_16, SONAR_64, DESCRIPTION];
    };
}
table!(sets);

#[cfg(test)]
mod tests {
    use super::SETS;

    #[test]
    fn names_and_numbers_of_sets_are_unique() {
        for (place, set) in SETS.iter().enumerate() {
            assert!(SETS[..place].iter().all(|other| other.name != set.name && other.number != set.number));
        }
    }
}
