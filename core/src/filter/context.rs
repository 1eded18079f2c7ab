//! Inputs of a scan update: those that are the same for all particles, and those of each survivor.

use crate::detection::scan::Scan;
use crate::detection::view::{View, Views};
use crate::filter::stages::ParticleLayout;
use crate::filter::survivor::ScanView;
use crate::models::{Mounted, MountedView, OnVehicle};
use crate::particles::candidate::Candidate;
use crate::{Births, Config, CovarianceOf, MeasurementModel, Pose, Real, ScalarOf};

/// Inputs of a scan update that no stage changes.
pub(crate) struct ScanContext<'a, X: MeasurementModel> {
    pub(crate) config: &'a Config<ScalarOf<X::Pose>>,
    pub(crate) births: &'a Births<ScalarOf<X::Pose>>,
    pub(crate) sensor: Mounted<'a, X::Sensor>,
    pub(crate) field_of_view: MountedView<'a, X::FieldOfView>,
    pub(crate) scan: Scan<'a, X::Measurement>,
    /// Number of measurements.
    pub(crate) measured: usize,
    /// Mean number of false measurements that the detector states, or zero.
    pub(crate) clutter_per_scan: ScalarOf<X::Pose>,
    /// As in [`Views`].
    pub(crate) ln_negligible: ScalarOf<X::Pose>,
    pub(crate) ln_sharpest: ScalarOf<X::Pose>,
    pub(crate) most_births: usize,
}

impl<'a, T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>> + 'a> ScanContext<'a, X> {
    /// Common data of all views of the scan.
    #[inline]
    pub(crate) fn views(&self) -> Views<'_, OnVehicle<'a, X>> {
        Views {
            sensor: &self.sensor,
            field_of_view: &self.field_of_view,
            ln_negligible: self.ln_negligible,
            ln_sharpest: self.ln_sharpest,
            most_births: self.most_births,
        }
    }
}

/// Inputs of the map updates, which are the same for all survivors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UpdateContext<T> {
    /// The label of the scan's first measurement.
    pub(crate) first_label: u32,
    /// Maximum number of births of a survivor: the number of labels.
    pub(crate) most_births: usize,
    /// Landmarks with labels from this one on are not [known](crate::report::watch::is_known).
    pub(crate) known_below: u32,
    /// ln of [`Config::confirmed_weight`].
    pub(crate) ln_confirmed: T,
    /// Number of the scan's measurements whose unexplained births are delayed until the next scan.
    pub(crate) births_wait: usize,
}

impl<T: Real> UpdateContext<T> {
    /// The placeholder before the update.
    pub(crate) const NONE: Self =
        Self { first_label: 0, most_births: 0, known_below: 0, ln_confirmed: T::ZERO, births_wait: 0 };
}

/// The measurement contexts of all survivors of a scan.
pub(crate) struct SurvivorViews<'b, 'a, X: MeasurementModel> {
    pub(crate) context: &'b ScanContext<'a, X>,
    pub(crate) views: Views<'b, OnVehicle<'a, X>>,
    pub(crate) layout: ParticleLayout,
    pub(crate) update_context: UpdateContext<ScalarOf<X::Pose>>,
    pub(crate) candidates: &'b [Candidate<X::Pose>],
    pub(crate) pose_covariances: &'b [CovarianceOf<X::Pose>],
    /// For every particle, Σ p_D w of the delayed births that the scan has missed.
    pub(crate) missed: &'b [ScalarOf<X::Pose>],
}

impl<'b, 'a, T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>> + 'a> SurvivorViews<'b, 'a, X> {
    /// The view from a survivor's pose, before the births of the sensor are counted.
    pub(crate) fn view(&self, survivor: u16) -> Option<View<'b, OnVehicle<'a, X>>> {
        let survivor = usize::from(survivor);
        let missed = self.missed.get(self.layout.parent_of(survivor)).copied().unwrap_or(T::ZERO);
        Some(View { missed, ..self.views.from(&self.candidates.get(survivor)?.pose) })
    }

    /// The measurement context of one survivor.
    #[inline]
    pub(crate) fn of(&self, survivor: u16) -> Option<ScanView<'b, OnVehicle<'a, X>>> {
        let UpdateContext { first_label, most_births, known_below, ln_confirmed, births_wait } = self.update_context;
        let view = View { most_births, ..self.view(survivor)? };
        let bounds = view.bounds();
        let parent = self.layout.parent_of(usize::from(survivor));
        let ScanContext { scan, config, births, .. } = self.context;
        Some(ScanView {
            view,
            pose_covariance: self.pose_covariances.get(parent).filter(|_| self.layout.has_pose_covariances).copied(),
            bounds,
            scan,
            config,
            births,
            ln_confirmed,
            first_label,
            known_below,
            births_wait,
        })
    }
}
