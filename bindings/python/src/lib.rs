//! The Python package of [`scphd`].
//!
//! Each Python class wraps a Rust type: vehicles (`vehicle.rs`), detectors (`detector.rs`), fixes (`fix.rs`), `ScPhd` with its
//! memory (`filter.rs`, `memory.rs`), and the joint map of `scphd-vehicle` (`joint.rs`, `joint_memory.rs`). Numbers are NumPy
//! arrays (`array.rs`, `estimate.rs`), errors are exceptions (`error.rs`).
//!
//! The doc comments of the classes and methods are their docstrings in Python; their types are in `scphd/_native.pyi`.

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
