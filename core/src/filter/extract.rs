//! State extraction (5.2.7).

use crate::detection::confirmed::is_confirmed;
use crate::filter::state::Memory;
use crate::map::reduce::heavier;
use crate::particles::candidate::{moments, total_weight};
use crate::settings::config::Extraction;
use crate::{
    Component, Config, CovarianceOf, Detector, MeasurementModel, Motion, MovingOf, Pose, PositionOf, Proposal, Real,
    ScPhd, Sensor, Symmetric, Vector,
};

/// The estimated pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseEstimate<P: Pose> {
    /// Weighted mean over the candidates; angles by their circular mean.
    pub mean: P,
    /// Weighted covariance of the candidates' differences from the mean.
    pub covariance: CovarianceOf<P>,
}

/// Result of a map extraction; the features themselves are in the caller's buffer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapEstimate<T> {
    /// N̂ = Σ w: the expected number of features.
    pub expected_features: T,
    /// Features written: the first round(N̂) components in the order of the extraction, or fewer if the map has fewer; or all
    /// confirmed components.
    pub features: usize,
    /// Features left out because the buffer was too small for them.
    pub left_out: usize,
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Mean and covariance of the pose of the vehicle over all candidates; `None` before the first reset.
    pub fn estimate_pose(&self) -> Option<PoseEstimate<M::Pose>> {
        let candidates = self.candidates();
        if candidates.is_empty() {
            return None;
        }
        // The sum of the weights differs from one by rounding errors, which far from the origin would change the mean.
        let total = total_weight(candidates);
        let (mean, mut covariance) = moments(candidates, total);
        if matches!(self.config.proposal, Proposal::Informed(_)) {
            for (candidate, pose_covariance) in candidates.iter().zip(self.memory.pose_covariances.iter()) {
                covariance = covariance.plus(&pose_covariance.scaled(candidate.ln_weight.exp() / total));
            }
        }
        // With a very small covariance, rounding errors can make a variance negative.
        let covariance = Symmetric::from_fn(|row, column| {
            let element = covariance.get(row, column);
            if row == column { element.at_least(T::ZERO) } else { element }
        });
        Some(PoseEstimate { mean, covariance })
    }

    /// The components of one particle's static map, in no particular order.
    pub fn map(&self, particle: usize) -> impl Iterator<Item = &Component<PositionOf<M::Pose>>> {
        self.memory.static_maps.of(particle)
    }

    /// The components of one particle's moving map, in no particular order, at the time of the last scan.
    pub fn moving_map(&self, particle: usize) -> impl Iterator<Item = &Component<MovingOf<M::Pose>>> {
        self.memory.moving_maps.of(particle)
    }

    /// Time since the last scan, s: the sum of the predictions since then, by which the moving features are still to be predicted.
    pub fn waited_s(&self) -> T {
        self.memory.cursor.waited_s
    }

    /// The particle whose map is the estimate: the one that continues the candidate with the greatest weight in the last scan.
    pub fn heaviest(&self) -> usize {
        self.memory.cursor.heaviest
    }

    /// Writes the estimated map to `features`: the first round(N̂) components of the static map of the [heaviest](Self::heaviest)
    /// particle in the order of [`extraction`](crate::Config::extraction), without those whose weight is below
    /// [`extraction_weight`](crate::Config::extraction_weight). If the extraction is [`Confirmed`](Extraction::Confirmed), the
    /// detection model of `detector` decides which components are confirmed.
    pub fn estimate_map<X: MeasurementModel<Pose = M::Pose>, R>(
        &self,
        detector: &Detector<X, R>,
        features: &mut [Component<PositionOf<M::Pose>>],
    ) -> MapEstimate<T> {
        let Self { config, memory, .. } = self;
        let admits = admits(detector, memory, config);
        let map = || self.map(self.heaviest()).filter(|component| admits(component)).copied();
        let [waiting, _] = memory.waiting.weights(self.heaviest());
        first_of(map, waiting, config.extraction, config.extraction_weight, features)
    }

    /// [`estimate_map`](Self::estimate_map) for the moving features of the heaviest particle: (position, velocity), predicted to
    /// the present.
    pub fn estimate_moving(&self, features: &mut [Component<MovingOf<M::Pose>>]) -> MapEstimate<T> {
        let (motion, waited_s) = (&self.config.moving.motion, self.waited_s());
        let now = |component: &Component<MovingOf<M::Pose>>| {
            if waited_s > T::ZERO {
                motion.advance::<PositionOf<M::Pose>>(component, waited_s)
            } else {
                Some(*component)
            }
        };
        let [_, waiting] = self.memory.waiting.weights(self.heaviest());
        first_of(
            || self.moving_map(self.heaviest()).filter_map(now),
            waiting,
            Extraction::Heaviest,
            self.config.moving.extraction_weight,
            features,
        )
    }
}

/// Returns a function that tells whether a static component may be extracted, independent of its weight. With
/// [`Confirmed`](Extraction::Confirmed) the component must be confirmed as seen from the pose of the heaviest particle, or, if
/// the sensor cannot measure it from there (behind a camera), from that pose with the opposite heading. It is not extracted if
/// neither can measure it.
fn admits<'d, T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>, R>(
    detector: &'d Detector<X, R>,
    memory: &Memory<'_, P>,
    config: &Config<T>,
) -> impl Fn(&Component<PositionOf<P>>) -> bool + use<'d, T, P, X, R> {
    let heaviest = memory.cursor.heaviest;
    let asked = config.extraction == Extraction::Confirmed;
    let candidate = memory.candidates().get(heaviest * memory.cursor.children).filter(|_| asked);
    let sensor = detector.on_vehicle().sensor;
    let frames = candidate.map(|candidate| {
        let half_a_turn = P::Tangent::with(|k| if P::HEADING == Some(k) { T::PI } else { T::ZERO });
        [candidate.pose, candidate.pose.displaced(&half_a_turn)].map(|pose| sensor.frame(&pose))
    });
    let pose_covariance = memory.pose_covariances.get(heaviest).copied();
    let detections = config.confirming_detections;
    move |component| {
        let from = |frame| is_confirmed(&sensor, frame, pose_covariance.as_ref(), component, detections);
        frames.as_ref().is_none_or(|frames| frames.iter().find_map(from).unwrap_or(false))
    }
}

/// Writes the first round(N̂) components in the order of the extraction, or all of them, to `features`, without those below the
/// least weight. `waiting` is the weight of delayed births, which are in no map.
fn first_of<T: Real, N: Vector<Scalar = T>, I: Iterator<Item = Component<N>>>(
    map: impl Fn() -> I,
    waiting: T,
    extraction: Extraction,
    least_weight: T,
    features: &mut [Component<N>],
) -> MapEstimate<T> {
    let ln_least = least_weight.ln();
    let (expected_features, heavy_enough) = map().fold((waiting, 0), |(sum, count), component| {
        (sum + component.ln_weight.exp(), count + usize::from(component.ln_weight >= ln_least))
    });
    let rounded = (expected_features + T::from_f64(0.5)).floor().to_i32();
    let expected = match extraction {
        Extraction::Heaviest | Extraction::Peaks => usize::try_from(rounded).unwrap_or(0),
        Extraction::Confirmed => usize::MAX,
    };
    let wanted = expected.min(heavy_enough);
    let buffer = features.len().min(wanted);
    let features = features.get_mut(..buffer).unwrap_or(&mut []);
    // Insertion sort into the buffer needs no other memory.
    let mut held = 0;
    for component in map().filter(|component| component.ln_weight >= ln_least) {
        let peak = ln_peak(extraction, &component);
        let place = features.get(..held).unwrap_or(&[]).partition_point(|slot| {
            let of_slot = ln_peak(extraction, slot);
            !(peak > of_slot || (peak == of_slot && heavier(&component, slot)))
        });
        held = (held + 1).min(buffer);
        let mut carried = component;
        for slot in features.get_mut(place..held).unwrap_or(&mut []) {
            carried = core::mem::replace(slot, carried);
        }
    }
    MapEstimate { expected_features, features: held, left_out: wanted - held }
}

/// The sorting key of the extraction; components with equal keys are sorted by weight.
fn ln_peak<T: Real, N: Vector<Scalar = T>>(extraction: Extraction, component: &Component<N>) -> T {
    match extraction {
        Extraction::Heaviest => T::ZERO,
        Extraction::Peaks | Extraction::Confirmed => {
            component.covariance.factor().map_or(T::NEG_INFINITY, |factor| component.ln_weight + factor.ln_peak())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{first_of, ln_peak};
    use crate::settings::config::Extraction;
    use crate::{Component, Noise, Symmetric};
    use nalgebra::Vector2;
    use std::vec::Vec;

    fn mixture(len: usize) -> Vec<Component<Vector2<f32>>> {
        let mut noise = Noise::seeded(5);
        let mut uniform = || noise.uniform::<f32>();
        (0..len)
            .map(|label| Component {
                label: label as u32,
                // Several components have the same weight.
                ln_weight: -(4.0 * uniform()).floor(),
                mean: Vector2::new(uniform(), uniform()),
                covariance: Symmetric::from_diagonal([0.1 + uniform(), 0.1 + uniform()]),
            })
            .collect()
    }

    /// The output is the beginning of the sorted mixture; components beyond the buffer are counted.
    #[test]
    fn extraction_returns_the_first_components_of_its_order() {
        let all = mixture(200);
        for (extraction, least_weight) in
            [(Extraction::Heaviest, 0.3), (Extraction::Peaks, 0.0), (Extraction::Confirmed, 0.1)]
        {
            let mut sorted: Vec<_> =
                all.iter().filter(|component| component.ln_weight >= f32::ln(least_weight)).collect();
            let key = |component: &Component<Vector2<f32>>| {
                (-ln_peak(extraction, component), -component.ln_weight, component.mean.x)
            };
            sorted.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap());
            let total: f32 = all.iter().map(|component| component.ln_weight.exp()).sum();
            let expected = if extraction == Extraction::Confirmed { usize::MAX } else { (total + 0.5) as usize };
            let wanted = sorted.len().min(expected);
            assert!(wanted > 40, "{wanted}");
            for room in [0, 1, 17, wanted, 300] {
                let mut features = std::vec![Component::ZERO; room];
                let estimate = first_of(|| all.iter().copied(), 0.0, extraction, least_weight, &mut features);
                assert_eq!((estimate.features, estimate.left_out), (wanted.min(room), wanted.saturating_sub(room)));
                let labels = |component: &Component<Vector2<f32>>| component.label;
                let extracted: Vec<u32> = features.iter().take(estimate.features).map(labels).collect();
                let first: Vec<u32> =
                    sorted.iter().take(estimate.features).map(|component| labels(component)).collect();
                assert_eq!(extracted, first, "{extraction:?}, room for {room}");
            }
        }
    }
}
