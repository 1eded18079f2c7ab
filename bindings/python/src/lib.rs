//! The Python package of [`scphd`].
//!
//! A class of Python holds what is one in Rust: vehicles (`vehicle.rs`), detectors (`detector.rs`), fixes (`fix.rs`), a mixture with its
//! memory (`filter.rs`, `memory.rs`), and a joint map as `scphd-vehicle` assembles it (`joint.rs`, `joint_memory.rs`). Numbers come in and go out as NumPy arrays (`array.rs`, `estimate.rs`), and what is refused
//! is an exception (`error.rs`).
//!
//! The documentation of the classes is what Python shows as their docstrings; `scphd/_native.pyi` has their types.

mod array;
mod error;
mod keywords;
mod made;

mod vehicle;

mod detector;
mod fix;
mod mounting;

mod estimate;
mod report;
mod setting_name;

mod joint_memory;
mod memory;
mod tuning;

mod filter;
mod joint;

use pyo3::pymodule;

/// The compiled part of the package.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::detector::{BearingOnly, RangeBearing};
    #[pymodule_export]
    use crate::error::{InputError, NotStartedError, SettingError, SnapshotError};
    #[pymodule_export]
    use crate::estimate::{Map, Movers, Odometry, Pose};
    #[pymodule_export]
    use crate::filter::Filter;
    #[pymodule_export]
    use crate::fix::{HeadingFix, PositionFix};
    #[pymodule_export]
    use crate::joint::JointFilter;
    #[pymodule_export]
    use crate::made::_resume;
    #[pymodule_export]
    use crate::mounting::Mounting;
    #[pymodule_export]
    use crate::report::{FixReport, Health, JointReport, PredictReport, ScanReport};
    #[pymodule_export]
    use crate::tuning::_joint_settings;
    #[pymodule_export]
    use crate::vehicle::{Ackermann, Holonomic, KnownPose, Unicycle};
}
