//! Which measurements of a scan are within a gate of a hypothesis: those of clutter, most of a scan, are within none.

use super::super::associate::{Predicted, greatest_square};
use super::super::movers::Movers;
use super::super::state::Memory;
use super::super::track::Along;
use crate::models::{OwnNoise, noise_at};
use crate::{MeasurementModel, Pose, PositionOf, Real, Sensor, Symmetric, Vector};

/// The measurements in a gate of a hypothesis, and the pairs of a landmark, or a track, and a measurement in its gate. It is valid
/// as long as the hypothesis is not corrected. Both are sets of bits that several may share: what has no bit is in no gate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gated {
    measurements: u32,
    pairs: u64,
}

impl Gated {
    /// Everything is in a gate.
    #[cfg(test)]
    pub(super) const ALL: Self = Self { measurements: u32::MAX, pairs: u64::MAX };

    /// Those of the measurements from index `first` on. A measurement counts as in a gate if it is along every coordinate.
    pub(super) fn of<
        T: Real,
        X: MeasurementModel<Pose: Pose<Scalar = T>>,
        Z: Vector<Scalar = T>,
        V: Movers<X::Pose>,
    >(
        models: &X,
        gate: T,
        memory: &Memory<'_, X::Pose, Z>,
        movers: &V,
        measurements: &[X::Measurement],
        first: usize,
    ) -> Self {
        let sensor = models.sensor();
        let frame = sensor.frame(&memory.header.pose);
        let mut gated = Self { measurements: 0, pairs: 0 };
        let rest = || measurements.iter().enumerate().skip(first);
        for (index, landmark) in memory.landmarks.iter().enumerate().take(memory.header.len) {
            if !landmark.may_be_cause() {
                continue;
            }
            let Some(predicted) = Predicted::of_corrected(sensor, &frame, memory.header, landmark) else { continue };
            let blocks = memory.joint.blocks(index);
            let of_state = X::Measurement::with(|k| predicted.along(k).covariance(&blocks).get(0, 0));
            let greatest = |noise: &Symmetric<X::Measurement>| {
                X::Measurement::with(|k| greatest_square(of_state.at(k) + noise.get(k, k), gate))
            };
            let usual = greatest(sensor.noise());
            let expected = &predicted.measurement;
            let is_within = |z: &X::Measurement| match OwnNoise::of(sensor, z, expected) {
                Some(own) => is_within(sensor, z, expected, &greatest(&own.covariance)),
                None => is_within(sensor, z, expected, &usual),
            };
            gated.mark(index, rest(), is_within);
        }
        let process_noise = movers.common().map_or(Symmetric::ZERO, |(common, _)| common.process_noise);
        for (index, mover) in movers.kept().iter().enumerate() {
            let free =
                memory.landmarks.get(usize::from(mover.static_index)).is_none_or(|landmark| landmark.may_be_cause());
            if !(mover.may_be_cause() && free) {
                continue;
            }
            let Some(predicted) = Predicted::of(sensor, &frame, &mover.component.position()) else { continue };
            let place = mover.component.covariance.leading::<PositionOf<X::Pose>>();
            let along = Along {
                predicted: &predicted,
                place: &place,
                noise: &noise_at(sensor, &predicted.measurement),
                process_noise: &process_noise,
            };
            let greatest = X::Measurement::with(|k| greatest_square(along.variance(k), gate));
            // A landmark and its track are one cause.
            let index = mover.static_index().map_or(index, usize::from);
            gated.mark(index, rest(), |z| is_within(sensor, z, &predicted.measurement, &greatest));
        }
        gated
    }

    /// Adds the measurements in the gate of the landmark, or of the track without one, that has this index.
    #[inline(always)]
    fn mark<'m, Y: 'm>(
        &mut self,
        feature: usize,
        rest: impl Iterator<Item = (usize, &'m Y)>,
        is_within: impl Fn(&Y) -> bool,
    ) {
        for (measurement, z) in rest {
            if is_within(z) {
                self.measurements |= 1 << (measurement % 32);
                self.pairs |= pair(feature, measurement);
            }
        }
    }

    pub(super) fn has(&self, measurement: usize) -> bool {
        self.measurements & (1 << (measurement % 32)) != 0
    }

    pub(super) fn has_pair(&self, feature: usize, measurement: usize) -> bool {
        self.pairs & pair(feature, measurement) != 0
    }
}

/// The bit of a pair. That of one feature's neighbour is far from its own, so that few of those in a gate share one.
fn pair(feature: usize, measurement: usize) -> u64 {
    1 << (feature.wrapping_mul(13).wrapping_add(measurement) % 64)
}

/// Whether the squared innovation is at most the greatest one along every coordinate.
#[inline(always)]
fn is_within<S: Sensor>(sensor: &S, z: &S::Measurement, expected: &S::Measurement, greatest: &S::Measurement) -> bool {
    let is_far = |k: usize, apart| apart * apart > greatest.at(k);
    // Without wrapping, the innovation is the difference.
    if S::SIFTED_BY.is_some_and(|k| is_far(k, z.at(k) - expected.at(k))) {
        return false;
    }
    let innovation = sensor.innovation(z, expected);
    !(0..S::Measurement::DIMENSION).any(|k| is_far(k, innovation.at(k)))
}
