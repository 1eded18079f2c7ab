//! What a scan shows of how often features are detected, and how much clutter there is.

use crate::detection::confirmed::is_confirmed;
use crate::detection::maps::{DynamicMaps, StaticMaps};
use crate::detection::online::{Ratio, Shown};
use crate::detection::scan::Scan;
use crate::detection::seen::reset_eta;
use crate::detection::view::View;
use crate::map::within;
use crate::{LnSum, MeasurementModel, Pose, Real, Symmetric, TangentOf};

/// A feature was there before the scan if it weighed this much.
const THERE: f64 = 0.5;

/// What a scan shows to a pose, of that covariance if it is uncertain, over the map of a particle as it was before.
#[inline(never)]
pub(crate) fn seen<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    pose_covariance: Option<&Symmetric<TangentOf<X::Pose>>>,
    (static_maps, moving_maps, particle): (&StaticMaps<'_, X::Pose>, &DynamicMaps<'_, X::Pose>, usize),
    scan: &Scan<'_, X::Measurement>,
    confirming_detections: T,
    eta: &mut [LnSum<T>],
) -> Shown<T> {
    reset_eta(eta, scan);
    let bounds = view.bounds();
    for component in within(static_maps, particle, &bounds) {
        if let Some(expectation) = view.expect_blurred(pose_covariance, component) {
            view.add_terms(&expectation, scan, eta);
        }
    }
    for component in within(moving_maps, particle, &bounds) {
        if let Some(expectation) = view.expect_blurred(pose_covariance, component) {
            view.add_terms(&expectation, scan, eta);
        }
    }
    let mut detections = Ratio::ZERO;
    let ln_there = T::from_f64(THERE).ln();
    for component in within(static_maps, particle, &bounds).filter(|component| component.ln_weight >= ln_there) {
        if !is_confirmed(view.sensor, &view.frame, pose_covariance, component, confirming_detections) {
            continue;
        }
        let Some(expectation) = view.expect_blurred(pose_covariance, component) else { continue };
        let mut share = T::ZERO;
        view.matches(&expectation, scan, |found| {
            share += eta.get(found.index).map_or(T::ZERO, |eta| (found.ln_term - eta.ln()).exp());
        });
        detections.happened += share.at_most(T::ONE);
        detections.expected += expectation.detection.modelled;
    }
    let clutter = scan.iter().zip(eta.iter());
    let clutter = clutter.fold(T::ZERO, |sum, (measurement, eta)| sum + (measurement.ln_clutter - eta.ln()).exp());
    Shown { detections, clutter }
}
