//! The particle likelihood, the one part in which SC-PHD and RB-PHD SLAM differ (5.3.2).

use crate::detection::scan::Scan;
use crate::detection::seen::Seen;
use crate::detection::view::{View, below_one};
use crate::numerics::ln_sum::ln_product;
use crate::{FieldOfView, Likelihood, LnSum, MeasurementModel, Pose, PositionOf, Real, Sensor};

/// ln L of the scan, up to the clutter rate λ, from what the candidate saw and the complete η_z; of the likelihood with several
/// features what it has in common with that of the empty map. Once for all who ask: it is not small.
#[inline(never)]
pub(crate) fn ln_likelihood<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    likelihood: Likelihood,
    view: &View<'_, X>,
    seen: &Seen<PositionOf<X::Pose>>,
    scan: &Scan<'_, X::Measurement>,
    eta: &[LnSum<T>],
) -> T {
    let eta = || scan.iter().zip(eta);
    if likelihood == Likelihood::SingleCluster {
        return ln_product(eta().map(|(_, eta)| eta)) - seen.expected_detections;
    }
    // N̂ − N̂⁻: what every measurement adds less what is missed.
    let (mut clutter, mut gained) = (T::ZERO, T::ZERO);
    for (measurement, eta) in eta() {
        clutter += measurement.ln_clutter;
        gained += T::ONE - (measurement.ln_clutter - eta.ln()).exp();
    }
    let empty = clutter + gained - seen.expected_detections;
    let anchor = if likelihood == Likelihood::SingleFeature { seen.heaviest.as_ref() } else { None };
    empty + anchor.and_then(|feature| single_feature(view, feature, eta())).unwrap_or(T::ZERO)
}

/// ln[ 1 − p_D + p_D Σ g/κ ] − ln[ 1 − p_D + p_D Σ g/η ] at the mean of a feature: by how much the scan speaks for it,
/// less by how much the update has made of that already, v(m)/v⁻(m).
fn single_feature<'e, T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    feature: &crate::Component<PositionOf<X::Pose>>,
    eta: impl Iterator<Item = (&'e crate::detection::scan::Measurement<X::Measurement>, &'e LnSum<T>)>,
) -> Option<T> {
    let expected = view.sensor.expect(&view.frame, &feature.mean)?.measurement;
    let detection = view.field_of_view.detection_probability(&view.frame, &feature.mean, &expected);
    // Written so that NaN is out of view too.
    if !(detection > T::ZERO) {
        return None;
    }
    let detection = below_one(detection);
    let noise = view.sensor.noise().factor()?;
    let (ln_missed, ln_detected) = ((T::ONE - detection).ln(), detection.ln());
    let (mut for_it, mut made_of_it) = (LnSum::of(ln_missed), LnSum::of(ln_missed));
    for (measurement, eta) in eta {
        let innovation = view.sensor.innovation(&measurement.z, &expected);
        let ln_g = noise.ln_peak() - T::from_f64(0.5) * noise.mahalanobis(&innovation);
        for_it.add(ln_detected + ln_g - measurement.ln_clutter);
        made_of_it.add(ln_detected + ln_g - eta.ln());
    }
    Some(for_it.ln() - made_of_it.ln())
}
