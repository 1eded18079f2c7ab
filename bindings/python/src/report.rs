//! What a step did.

use crate::error::InputError;
use pyo3::prelude::*;
use scphd::Real;
use scphd_vehicle::Watched;
use std::fmt;

/// The conditions that a report tells of.
#[pyclass(frozen, eq, hash, module = "scphd")]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Health(u16);

impl fmt::Debug for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Health({})", self.names().join(", "))
    }
}

impl From<scphd::Health> for Health {
    fn from(health: scphd::Health) -> Self {
        Self(health.bits())
    }
}

/// The name of one condition.
fn name(condition: scphd::Health) -> String {
    format!("{condition:?}").trim_matches(['{', '"', '}']).to_owned()
}

#[pymethods]
impl Health {
    /// bool: no condition at all.
    #[getter]
    fn is_good(&self) -> bool {
        self.0 == 0
    }

    /// int: the conditions as the bits that the firmware reports.
    #[getter]
    fn bits(&self) -> u16 {
        self.0
    }

    /// list of str: the names of the conditions that hold, such as 'LOST'. `docs/health.md` explains them.
    #[getter]
    fn names(&self) -> Vec<String> {
        scphd::Health::all().filter(|condition| self.0 & condition.bits() != 0).map(name).collect()
    }

    /// Whether the condition of this name holds, as in ``'LOST' in report.health``.
    ///
    /// Raises InputError where there is no such condition.
    fn __contains__(&self, condition: &str) -> PyResult<bool> {
        let known = scphd::Health::all().find(|&known| name(known) == condition);
        let known = known.ok_or_else(|| InputError::new_err(format!("there is no condition '{condition}'")))?;
        Ok(self.0 & known.bits() != 0)
    }

    fn __repr__(&self) -> String {
        format!("{self:?}")
    }
}

/// A class that shows the fields of a report of the library, in either precision.
macro_rules! report {
    (
        $(#[doc = $about:literal])+ $name:ident [$($scalar:tt)*] of $report:ty { $($(#[doc = $text:literal])+ $field:ident: $kind:ty,)+ }
    ) => {
        $(#[doc = $about])+
        #[pyclass(frozen, get_all, module = "scphd")]
        #[derive(Debug, Clone, Copy)]
        pub struct $name { $($(#[doc = $text])+ $field: $kind,)+ }

        impl<$($scalar)*> From<$report> for $name {
            fn from(report: $report) -> Self {
                Self { $($field: report.$field.into(),)+ }
            }
        }

        #[pymethods]
        impl $name {
            fn __repr__(&self) -> String {
                format!("{self:?}")
            }
        }
    };
}

report! {
    /// What a prediction did.
    PredictReport [] of scphd::PredictReport {
        /// int: candidates after it.
        candidates: usize,
        /// int: candidates that stayed where they were, for their pose left the range of single precision.
        rejected: usize,
        /// int: predictions refused since the last scan.
        refused: usize,
        /// Health: the conditions that hold.
        health: Health,
    }
}

report! {
    /// What a scan of a mixture did.
    ScanReport [T: Real + Into<f64>] of scphd::ScanReport<T> {
        /// int: measurements in the scan.
        measurements: usize,
        /// int: measurements that could not give birth.
        no_birth: usize,
        /// int: predictions refused since the scan before.
        refused: usize,
        /// int: candidates weighed.
        candidates: usize,
        /// int: most components in view of a candidate.
        in_view: usize,
        /// int: particles that go on.
        particles: usize,
        /// bool: whether they were resampled.
        resampled: bool,
        /// int: components born and kept.
        births: usize,
        /// int: components merged into another.
        merged: usize,
        /// int: components that found no room.
        lost: usize,
        /// int: pages of features in use after the scan.
        pages_used: usize,
        /// int: pages of features in all.
        pages: usize,
        /// int: pages of moving features in use after the scan.
        moving_pages_used: usize,
        /// int: pages of moving features in all.
        moving_pages: usize,
        /// float: effective number of candidates before any resampling.
        n_eff: f64,
        /// float: logarithm of the scan's likelihood, up to a constant; minus infinity where no candidate explains it.
        ln_evidence: f64,
        /// float: detections to be expected of the features in view.
        expected_detections: f64,
        /// float: measurements that the features in view explain.
        detections: f64,
        /// float: mean squared innovation by its covariance, per dimension; about 1 for a consistent filter.
        innovation: f64,
        /// Health: the conditions that hold.
        health: Health,
    }
}

report! {
    /// What a scan of a joint map did.
    JointReport [T: Real + Into<f64>] of scphd::JointReport<T> {
        /// int: measurements in the scan.
        measurements: usize,
        /// int: features in view before it.
        in_view: usize,
        /// int: predictions refused since the scan before.
        refused: usize,
        /// int: features born.
        births: usize,
        /// int: measurements that could not give birth.
        no_birth: usize,
        /// int: features dropped.
        dropped: usize,
        /// int: features that turned out to be another one.
        merged: usize,
        /// int: features for which there was no room.
        lost: usize,
        /// int: features after the scan.
        features: usize,
        /// float: logarithm of the scan's likelihood, up to a constant.
        ln_evidence: f64,
        /// float: detections to be expected of the features in view.
        expected_detections: f64,
        /// float: measurements that the features in view explain.
        detections: f64,
        /// float: mean squared innovation by its covariance, per dimension; about 1 for a consistent filter.
        innovation: f64,
        /// Health: the conditions that hold.
        health: Health,
    }
}

/// What a fix did.
#[pyclass(frozen, get_all, module = "scphd")]
#[derive(Debug, Clone, Copy)]
pub struct FixReport {
    /// bool: whether it was taken in; it is not where it lies beyond the gate.
    accepted: bool,
    /// float: its squared Mahalanobis distance from what the filter expected.
    distance: f64,
    /// float: logarithm of its likelihood; 0 where it was not taken in.
    ln_evidence: f64,
    /// float: effective number of candidates after it.
    n_eff: f64,
    /// bool: whether outliers that agree with each other have moved the filter to where they say.
    relocated: bool,
}

impl<T: Real> From<Watched<T>> for FixReport {
    fn from(Watched { report, relocated }: Watched<T>) -> Self {
        let [distance, ln_evidence, n_eff] = [report.distance, report.ln_evidence, report.n_eff].map(Real::to_f64);
        Self { accepted: report.accepted, distance, ln_evidence, n_eff, relocated }
    }
}

#[pymethods]
impl FixReport {
    fn __repr__(&self) -> String {
        format!("{self:?}")
    }
}
