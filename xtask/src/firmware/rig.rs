//! The filters of the firmware: their streams and images.

use super::board::{Board, EMULATED};

/// Number type of a filter: single or double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    F32,
    F64,
}

impl Precision {
    /// Its name on the command line and in names of images.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// A filter, for a type of vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Part of the names of its configurations and streams before the precision.
    pub mark: &'static str,
    /// Whether it has moving-object tracks; `None` if the scenario decides.
    pub moving: Option<&'static str>,
    /// Part of the names of its images between `replay-` and the precision.
    vehicle: &'static str,
    /// The filter in the argument of the replay on the host, before the precision.
    filter: &'static str,
    /// Features of `proof` that select it.
    features: &'static [&'static str],
    /// Features of its images that select the capacities of a joint map; on the host `filter` does.
    choice: &'static [&'static str],
    /// Features that select the capacities, in every image and on the host.
    pub room: &'static [&'static str],
    /// Particles and samples of its streams; the firmware has memory for these.
    pub particles: usize,
    pub samples: usize,
    /// Settings of its streams that differ from the simulator's defaults.
    pub settings: Option<&'static str>,
    /// Further arguments of the simulator for its streams.
    pub more: &'static [&'static str],
    pub precisions: &'static [Precision],
    /// Boards that replay its streams in the step `firmware`.
    pub boards: &'static [Board],
}

/// A vehicle in the plane.
pub const PLANAR: Rig = Rig {
    mark: "",
    moving: None,
    vehicle: "",
    filter: "",
    features: &[],
    choice: &[],
    room: &[],
    particles: 32,
    samples: 2,
    settings: Some("firmware/blind.toml"),
    more: &[],
    precisions: &[Precision::F32, Precision::F64],
    boards: &EMULATED,
};

/// As `PLANAR`, but all features are assumed static, including moving ones.
const STATIC: Rig = Rig { mark: "-static", moving: Some("off"), ..PLANAR };

/// As `PLANAR`, with few informed particles instead of many blind ones.
pub const FEW: Rig = Rig {
    mark: "-informed",
    room: &["few-particles"],
    particles: 4,
    samples: 1,
    settings: Some("firmware/informed.toml"),
    precisions: &[Precision::F32],
    ..PLANAR
};

/// One informed particle, of which nothing is drawn, in the image of [`FEW`].
const GAUSSIAN: Rig = Rig { mark: "-gaussian", particles: 1, settings: Some("firmware/gaussian.toml"), ..FEW };

/// The joint map with the settings of [`FEW`].
pub const FEW_JOINT: Rig = Rig { mark: "-informed-joint", filter: "joint-", features: &["joint"], ..FEW };

/// A vehicle in the plane with a joint map.
pub const JOINT: Rig = Rig {
    mark: "-joint",
    moving: Some("off"),
    vehicle: "joint-",
    filter: "joint-",
    features: &["joint"],
    particles: 1,
    samples: 1,
    settings: None,
    precisions: &[Precision::F32],
    ..PLANAR
};

/// [`JOINT`] with moving-object tracks.
pub const JOINT_MOVERS: Rig = Rig {
    mark: "-joint-movers",
    moving: Some("on"),
    filter: "joint-movers-",
    features: &["joint", "movers"],
    choice: &["movers"],
    ..JOINT
};

/// Both with capacity for 40 features; the code is the same, so that one board is enough.
const JOINT_40: Rig = Rig {
    mark: "-joint-40",
    filter: "joint-40-",
    choice: &["forty-features"],
    boards: EMULATED.split_at(1).0,
    ..JOINT
};
const JOINT_40_MOVERS: Rig = Rig {
    mark: "-joint-40-movers",
    filter: "joint-40-movers-",
    choice: &["forty-features", "movers"],
    boards: EMULATED.split_at(1).0,
    ..JOINT_MOVERS
};

/// [`JOINT`] with eight hypotheses, each with capacity for 24 features, and moving-object tracks.
pub const JOINT_HYPOTHESES: Rig = Rig {
    mark: "-joint-hypotheses",
    moving: Some("on"),
    filter: "joint-hypotheses-",
    features: &["joint", "hypotheses"],
    choice: &["hypotheses"],
    more: &["--hypotheses", "8"],
    // On one board only, to save minutes.
    boards: EMULATED.split_at(1).0,
    ..JOINT
};

/// Mixture and joint map with a quarter of the capacities, to test a lack of memory; on one board.
pub const SMALL: Rig = Rig {
    mark: "-small",
    room: &["small-pools"],
    precisions: &[Precision::F32],
    boards: EMULATED.split_at(1).0,
    ..PLANAR
};
pub const SMALL_JOINT: Rig =
    Rig { mark: "-few-features", room: &["small-pools"], boards: EMULATED.split_at(1).0, ..JOINT };

/// A vehicle under water.
pub const UNDERWATER: Rig = Rig {
    vehicle: "underwater-",
    features: &["underwater"],
    particles: 64,
    samples: 1,
    settings: Some("firmware/girona-tank.toml"),
    precisions: &[Precision::F32],
    // On one board only, to save minutes: the others are tested with a planar vehicle.
    boards: EMULATED.split_at(1).0,
    ..PLANAR
};

/// [`UNDERWATER`] with a joint map.
pub const UNDERWATER_JOINT: Rig = Rig { vehicle: "underwater-joint-", features: &["underwater", "joint"], ..JOINT };

/// The filters that a budget can name, of planar and of underwater vehicles.
const IN_THE_PLANE: [Rig; 10] =
    [PLANAR, STATIC, FEW, GAUSSIAN, JOINT, JOINT_MOVERS, JOINT_40, JOINT_40_MOVERS, JOINT_HYPOTHESES, SMALL];
const UNDER_WATER: [Rig; 2] = [UNDERWATER, UNDERWATER_JOINT];

/// The scenario of underwater vehicles.
pub const DIVE: &str = "girona-tank";

impl Rig {
    /// The filter, and its number type, with this name of a configuration in a scenario.
    pub fn named(configuration: &str, scenario: &str) -> Option<(Self, Precision)> {
        let rigs = if scenario == DIVE { &UNDER_WATER[..] } else { &IN_THE_PLANE };
        let mut each = rigs.iter().flat_map(|rig| rig.precisions.iter().map(|&precision| (*rig, precision)));
        each.find(|(rig, precision)| rig.configuration(*precision) == configuration)
    }

    /// Whether its filter is a joint map.
    pub fn is_joint(&self) -> bool {
        self.features.contains(&"joint")
    }

    /// The argument of the replay on the host: filter and precision.
    pub fn replay(&self, precision: Precision) -> String {
        format!("{}{}", self.filter, precision.name())
    }

    /// Name of the image that replays its streams.
    pub fn image(&self, precision: Precision) -> String {
        format!("replay-{}{}", self.vehicle, precision.name())
    }

    /// Features of the image that replays its streams.
    pub fn image_features(&self) -> Vec<&'static str> {
        self.choice.iter().chain(self.room).copied().collect()
    }

    /// Features of `proof` for it.
    pub fn proof_features(&self, precision: Precision) -> Vec<&'static str> {
        let double = (precision == Precision::F64).then_some("double");
        self.features.iter().chain(self.room).copied().chain(double).collect()
    }

    /// Name of its configuration, such as `1x1-joint-f32`.
    fn configuration(&self, precision: Precision) -> String {
        format!("{}x{}{}-{}", self.particles, self.samples, self.mark, precision.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_from_vehicle_and_precision() {
        assert_eq!(UNDERWATER.image(Precision::F32), "replay-underwater-f32");
        assert_eq!(UNDERWATER.proof_features(Precision::F64), ["underwater", "double"]);
        let small = JOINT_40_MOVERS;
        assert_eq!(
            (small.image(Precision::F32), small.replay(Precision::F32)),
            ("replay-joint-f32".into(), "joint-40-movers-f32".into())
        );
        // The code does not depend on the capacity for features.
        assert_eq!(small.image_features(), ["forty-features", "movers"]);
        assert_eq!(small.proof_features(Precision::F32), JOINT_MOVERS.proof_features(Precision::F32));
        assert_eq!(UNDERWATER_JOINT.image(Precision::F32), "replay-underwater-joint-f32");
        assert_eq!(UNDERWATER_JOINT.replay(Precision::F32), "joint-f32");
        assert_eq!(PLANAR.image(Precision::F64), "replay-f64");
    }

    #[test]
    fn filters_are_found_by_configuration_and_scenario() {
        assert_eq!(Rig::named("64x1-f32", DIVE), Some((UNDERWATER, Precision::F32)));
        assert_eq!(Rig::named("1x1-joint-f32", DIVE), Some((UNDERWATER_JOINT, Precision::F32)));
        assert_eq!(Rig::named("1x1-joint-f32", "survey"), Some((JOINT, Precision::F32)));
        assert_eq!(Rig::named("4x1-informed-f32", "survey"), Some((FEW, Precision::F32)));
        assert_eq!(Rig::named("32x2-f64", "survey"), Some((PLANAR, Precision::F64)));
        assert_eq!(Rig::named("32x2-joint-f32", "survey"), None);
    }
}
