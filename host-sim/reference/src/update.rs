//! `Update` of appendix A: the posterior mixture of one pose.

use super::algebra::{determinant, identity, scaled};
use super::config::{Config, Remembering};
use super::field_of_view::FieldOfView;
use super::gaussian::Component;
use super::pre_update::{InView, PreUpdate};
use super::reduce::{heavy_enough, prune_and_merge};
use super::sensor::RangeBearing;
use super::sight::Sight;

/// The persisting components in view after the update: first the missed ones, with w (1 − p_D) or their least weight, then for
/// each measurement the detected ones, with p_D w N(z; ẑ, S)/η_z (5.17, 5.18, corrected).
pub(super) fn persisting<const N: usize>(
    view: &PreUpdate<N>,
    ln_eta: &[f64],
    remembering: Remembering,
    prune_weight: f64,
) -> Vec<Component<N>> {
    let missed = view.in_view.iter().map(|j| {
        let faded = j.prior.weight() * (1.0 - j.detection_probability);
        let explaining = ln_eta.iter().enumerate().filter(|(_, eta)| **eta > f64::NEG_INFINITY);
        let weights = explaining.map(|(z, eta)| (j.ln_detection(z) - eta).exp());
        // Components that are pruned do not count as detected.
        let detected: f64 = weights.filter(|weight| *weight >= prune_weight).sum();
        let least = remembering.weight.min(j.prior.weight()) - detected;
        if faded < least && is_confirmed(j, remembering.detections) {
            Component { ln_weight: least.ln(), ..j.prior }
        } else {
            Component { ln_weight: j.prior.ln_weight + (-j.detection_probability).ln_1p(), ..j.prior }
        }
    });
    let detected = ln_eta
        .iter()
        .enumerate()
        // η_z = 0 if z has the likelihood zero; then it updates no component.
        .filter(|(_, eta)| **eta > f64::NEG_INFINITY)
        .flat_map(|(z, eta)| {
            view.in_view.iter().map(move |j| Component {
                ln_weight: j.ln_detection(z) - eta,
                mean: j.updated[z].0,
                covariance: j.covariance,
            })
        });
    missed.chain(detected).collect()
}

/// Whether a component is better known than after this number of measurements from this pose: det S / det R, which is det P / det
/// P⁺, is below the mean of its values after k and k + 1 measurements, for every dimension of the position.
fn is_confirmed<const N: usize>(j: &InView<N>, detections: f64) -> bool {
    let half_way = 1.0 + 0.5 / detections + 0.5 / (detections + 1.0);
    determinant(&j.prior.covariance) < determinant(&j.covariance) * half_way.powi(N as i32)
}

/// Greatest part of features in η_z of an unexplained measurement, relative to that of clutter and births.
const UNEXPLAINED_SHARE: f64 = 1e-3;

/// The births of the static or the moving part in a scan, in the order of the measurements.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Births<const N: usize> {
    /// Births on measurements explained by features: reduced together with the components in view.
    pub(super) reduced: Vec<Component<N>>,
    /// Births on unexplained measurements: not changed in this scan.
    pub(super) waiting: Vec<Component<N>>,
}

impl Births<2> {
    /// The same births of moving features.
    pub(super) fn set_in_motion(&self, velocity_sigma_mps: f64) -> Births<4> {
        let moving =
            |births: &[Component]| births.iter().map(|birth| set_in_motion(birth, velocity_sigma_mps)).collect();
        Births { reduced: moving(&self.reduced), waiting: moving(&self.waiting) }
    }
}

/// The static births on the measurements, at h⁻¹(z, x) with R*, if that is in view (5.9, 5.10, 5.17).
pub(super) fn born(sight: &Sight<'_, RangeBearing>, field_of_view: &FieldOfView, birth_intensity: f64) -> Births<2> {
    let in_view = |mean| field_of_view.detection_probability(mean, sight.pose) > 0.0;
    let places =
        sight.measurements.iter().map(|&z| sight.sensor.inverse(z, sight.pose).filter(|&(mean, _)| in_view(mean)));
    born_at(places, &sight.ln_eta, sight.ln_unexplained, birth_intensity)
}

/// The births on measurements with these positions and covariances, or none: w/η_z.
pub(super) fn born_at<const N: usize>(
    places: impl Iterator<Item = Option<([f64; N], [[f64; N]; N])>>,
    ln_eta: &[f64],
    ln_unexplained: f64,
    birth_intensity: f64,
) -> Births<N> {
    let mut births = Births { reduced: Vec::new(), waiting: Vec::new() };
    if birth_intensity == 0.0 {
        return births;
    }
    for (place, &eta) in places.zip(ln_eta) {
        let Some((mean, covariance)) = place else { continue };
        let unexplained = eta <= ln_unexplained + UNEXPLAINED_SHARE.ln_1p();
        let kind = if unexplained { &mut births.waiting } else { &mut births.reduced };
        kind.push(Component { ln_weight: birth_intensity.ln() - eta, mean, covariance });
    }
    births
}

/// One part of a map after the scan: unchanged components out of view; the reduced others, heaviest first; then waiting births in
/// the order of the measurements, without those that are too light.
pub(super) fn after_scan<const N: usize>(
    out_of_view: Vec<Component<N>>,
    persisting: Vec<Component<N>>,
    births: Births<N>,
    config: &Config,
) -> Vec<Component<N>> {
    let reduced = prune_and_merge(&[persisting, births.reduced].concat(), config);
    let waiting = births.waiting.into_iter().filter(|birth| heavy_enough(birth, config.prune_weight));
    out_of_view.into_iter().chain(reduced).chain(waiting).collect()
}

/// A birth that may move: the same position, and an unknown velocity with this standard deviation, m/s.
pub(super) fn set_in_motion(birth: &Component, velocity_sigma_mps: f64) -> Component<4> {
    let [x, y] = birth.mean;
    let mut covariance = scaled(velocity_sigma_mps.powi(2), &identity());
    for (row, entries) in birth.covariance.iter().enumerate() {
        covariance[row][..2].copy_from_slice(entries);
    }
    Component { ln_weight: birth.ln_weight, mean: [x, y, 0.0, 0.0], covariance }
}

#[cfg(test)]
mod tests {
    use super::super::gaussian::Vector;
    use super::super::tests::{CONFIG, SENSOR, WIDE_VIEW};
    use super::*;

    const POSE: [f64; 3] = [1.0, -2.0, 0.4];
    const UNEXPLAINED: f64 = 0.04;
    const NONE: Births<2> = Births { reduced: Vec::new(), waiting: Vec::new() };

    fn feature(weight: f64, forward: f64) -> Component {
        Component {
            ln_weight: weight.ln(),
            mean: [POSE[0] + forward * POSE[2].cos(), POSE[1] + forward * POSE[2].sin()],
            covariance: [[0.2, 0.05], [0.05, 0.1]],
        }
    }

    /// The components in view, with `unexplained` as the sum of κ and the birth intensities.
    fn sight<'a>(
        map: &[Component],
        moving: &[Component<4>],
        measurements: &'a [Vector],
        unexplained: f64,
    ) -> Sight<'a, RangeBearing> {
        let config = Config { clutter_intensity: unexplained, birth_intensity: 0.0, ..CONFIG };
        Sight::new(POSE, map, moving, measurements, &SENSOR, &WIDE_VIEW, &config)
    }

    #[test]
    fn a_measurement_of_likelihood_zero_updates_nothing() {
        let measurements = [[5.0, 0.0]];
        let weightless = feature(0.0, 5.0);
        let sight = sight(&[weightless], &[], &measurements, 0.0);
        assert_eq!(persisting(&sight.still, &sight.ln_eta, Remembering::NOTHING, 0.0), [weightless]);
        assert_eq!(born(&sight, &WIDE_VIEW, 0.0), NONE);
    }

    #[test]
    fn a_measurement_without_inverse_has_no_birth_but_is_weighed() {
        let measurements = [[0.0, 0.0]];
        let sight = sight(&[], &[], &measurements, UNEXPLAINED);
        assert!((sight.ln_eta[0] - UNEXPLAINED.ln()).abs() < 1e-15);
        assert_eq!(born(&sight, &WIDE_VIEW, 0.03), NONE);
    }
}
