//! Choice of the filter.

use crate::ekf::association::Association;
use crate::settings::{FilterSettings, Likelihood};

/// Scalar of the fixed-capacity filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    F32,
    /// Double precision, if the Cargo feature `f64` is on.
    F64,
}

impl Precision {
    /// Whether the filters are compiled for it.
    pub const fn is_built(self) -> bool {
        match self {
            Self::F32 => true,
            Self::F64 => cfg!(any(feature = "f64", test)),
        }
    }
}

/// Evaluates `$start`, where `$T` is the number type of a precision, or refuses one that is not compiled.
macro_rules! in_precision {
    ($precision:expr, $T:ident => $start:expr) => {
        match $precision {
            $crate::slam::Precision::F32 => {
                type $T = f32;
                $start
            }
            #[cfg(any(feature = "f64", test))]
            $crate::slam::Precision::F64 => {
                type $T = f64;
                $start
            }
            #[cfg(not(any(feature = "f64", test)))]
            $crate::slam::Precision::F64 => Err($crate::slam::contract::not_built()),
        }
    };
}
pub(super) use in_precision;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// The fixed-capacity filter.
    Core(Precision),
    Joint(Precision),
    /// The brute-force reference, in double precision.
    Reference,
    /// EKF SLAM, in double precision: a baseline.
    Ekf(Association),
}

impl Filter {
    /// Name in tables and files: `scphd`, `joint`, `ekf` or `ekf-known`, or that of the reference with this particle likelihood:
    /// `reference`, `rb-empty`, `rb-single` or `rb-multi`.
    pub fn name(self, likelihood: Likelihood) -> &'static str {
        match (self, likelihood) {
            (Self::Core(_), _) => "scphd",
            (Self::Joint(_), _) => "joint",
            (Self::Reference, Likelihood::SingleCluster) => "reference",
            (Self::Reference, Likelihood::RbEmpty) => "rb-empty",
            (Self::Reference, Likelihood::RbSingle) => "rb-single",
            (Self::Reference, Likelihood::RbMulti) => "rb-multi",
            (Self::Ekf(Association::NearestNeighbour), _) => "ekf",
            (Self::Ekf(Association::Known), _) => "ekf-known",
        }
    }

    /// Its scalar: `f32` or `f64`.
    pub fn precision(self) -> &'static str {
        match self {
            Self::Core(Precision::F32) | Self::Joint(Precision::F32) => "f32",
            Self::Core(Precision::F64) | Self::Joint(Precision::F64) | Self::Reference | Self::Ekf(_) => "f64",
        }
    }

    /// Number of particles with these settings: one for a single Gaussian.
    pub fn particles(self, settings: &FilterSettings) -> usize {
        match self {
            Self::Core(_) | Self::Reference => settings.particles,
            Self::Joint(_) | Self::Ekf(_) => 1,
        }
    }
}
