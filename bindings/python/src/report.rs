//! Reports of predictions, scans and fixes.

use crate::error::InputError;
use pyo3::prelude::*;
use scphd::Real;
use scphd_vehicle::Watched;
use std::fmt;

/// Warnings of a report.
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

/// The name of a warning.
fn name(condition: scphd::Health) -> String {
    format!("{condition:?}").trim_matches(['{', '"', '}']).to_owned()
}

#[pymethods]
impl Health {
    /// bool: whether there is no warning.
    #[getter]
    fn is_good(&self) -> bool {
        self.0 == 0
    }

    /// int: the warnings as bits, as the firmware reports them.
    #[getter]
    fn bits(&self) -> u16 {
        self.0
    }

    /// list of str: the names of the warnings, such as 'LOST'. `docs/health.md` explains them.
    #[getter]
    fn names(&self) -> Vec<String> {
        scphd::Health::all().filter(|condition| self.0 & condition.bits() != 0).map(name).collect()
    }

    /// Whether there is a warning of this name, as in ``'LOST' in report.health``.
    ///
    /// Raises InputError if no warning has this name.
    fn __contains__(&self, condition: &str) -> PyResult<bool> {
        let known = scphd::Health::all().find(|&known| name(known) == condition);
        let known = known.ok_or_else(|| InputError::new_err(format!("there is no condition '{condition}'")))?;
        Ok(self.0 & known.bits() != 0)
    }

    fn __repr__(&self) -> String {
        format!("{self:?}")
    }
}

/// Defines a class with the fields of a report of the library, in either precision.
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
    /// The report of a prediction.
    PredictReport [] of scphd::PredictReport {
        /// int: candidates after the prediction.
        candidates: usize,
        /// int: candidates that were not moved because their predicted pose was out of the range of single precision.
        rejected: usize,
        /// int: predictions that were refused since the last scan.
        refused: usize,
        /// Health: warnings.
        health: Health,
    }
}

report! {
    /// The report of a scan of a mixture.
    ScanReport [T: Real + Into<f64>] of scphd::ScanReport<T> {
        /// int: measurements in the scan.
        measurements: usize,
        /// int: measurements that could not become a component.
        no_birth: usize,
        /// int: predictions that were refused since the last scan.
        refused: usize,
        /// int: candidates that were weighted.
        candidates: usize,
        /// int: greatest number of components in view of any candidate.
        in_view: usize,
        /// int: particles after the scan.
        particles: usize,
        /// bool: whether the particles were resampled.
        resampled: bool,
        /// int: new components, before merging.
        births: usize,
        /// int: components that were merged into another one.
        merged: usize,
        /// int: components that were discarded because of too little memory.
        lost: usize,
        /// int: pages of static features in use after the scan.
        pages_used: usize,
        /// int: total number of pages for static features.
        pages: usize,
        /// int: pages of moving features in use after the scan.
        moving_pages_used: usize,
        /// int: total number of pages for moving features.
        moving_pages: usize,
        /// float: effective number of candidates before resampling.
        n_eff: f64,
        /// float: logarithm of the scan's likelihood, up to a constant; minus infinity if no candidate explains the scan.
        ln_evidence: f64,
        /// float: expected number of detections of the features in view.
        expected_detections: f64,
        /// float: expected number of measurements that come from features in view.
        detections: f64,
        /// float: normalised innovation squared per dimension; about 1 for a consistent filter.
        innovation: f64,
        /// Health: warnings.
        health: Health,
    }
}

report! {
    /// The report of a scan of a joint map.
    JointReport [T: Real + Into<f64>] of scphd::JointReport<T> {
        /// int: measurements in the scan.
        measurements: usize,
        /// int: features in view before the scan.
        in_view: usize,
        /// int: predictions that were refused since the last scan.
        refused: usize,
        /// int: new features.
        births: usize,
        /// int: measurements that could not become a feature.
        no_birth: usize,
        /// int: features that were removed because their existence probability was too low.
        dropped: usize,
        /// int: features that were merged with another one.
        merged: usize,
        /// int: new features for which there was no room, or features that they replaced.
        lost: usize,
        /// int: features after the scan.
        features: usize,
        /// int: hypotheses of data association after the scan.
        hypotheses: usize,
        /// float: probability of the likeliest, of which the other fields are.
        share: f64,
        /// float: logarithm of the scan's likelihood, up to a constant.
        ln_evidence: f64,
        /// float: expected number of detections of the features in view.
        expected_detections: f64,
        /// float: expected number of measurements that come from features in view.
        detections: f64,
        /// float: normalised innovation squared per dimension; about 1 for a consistent filter.
        innovation: f64,
        /// Health: warnings.
        health: Health,
    }
}

/// The report of a fix.
#[pyclass(frozen, get_all, module = "scphd")]
#[derive(Debug, Clone, Copy)]
pub struct FixReport {
    /// bool: whether the fix was used; one beyond the gate is not.
    accepted: bool,
    /// float: squared Mahalanobis distance of the innovation.
    distance: f64,
    /// float: logarithm of the likelihood of the fix; 0 if it was not used.
    ln_evidence: f64,
    /// float: effective number of candidates after the fix.
    n_eff: f64,
    /// bool: whether the filter was moved because rejected fixes agree with each other.
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
