//! Random scans: detections of landmarks and false measurements.

use super::draw::Draw;
use super::worlds::{FeatureOf, MeasurementOf, World};
use scphd::models::{MeasurementModel, Pose, Sensor};
use scphd::numerics::Vector;
use scphd::{Detector, Real};

/// Detections of the landmarks from a pose, and false measurements; at most one more than the capacity.
pub(super) fn seen<W: World, R>(
    draw: &mut Draw,
    eye: &Detector<W::Sensing, R>,
    landmarks: &[FeatureOf<W>],
    pose: Option<W::Pose>,
    room: usize,
) -> Vec<MeasurementOf<W>> {
    let mut measurements: Vec<MeasurementOf<W>> = Vec::new();
    if let Some(pose) = pose {
        let seat = eye.mounting().map_or(pose, |mounting| pose.mounted(mounting).0);
        let sensor = eye.sensing().sensor();
        let frame = sensor.frame(&seat);
        for expected in landmarks.iter().filter_map(|landmark| sensor.expect(&frame, landmark)) {
            measurements.push(Vector::with(|axis| {
                let error = W::SPREAD[axis] * draw.even(-1.7, 1.7);
                W::Scalar::from_f64(draw.spoilt(expected.measurement.at(axis).to_f64() + error))
            }));
        }
        measurements.retain(|_| draw.chance(0.85));
    }
    for _ in 0..draw.below(4) {
        measurements.push(W::clutter(draw));
    }
    if draw.chance(0.05) {
        // Duplicates of all measurements, one of them with a rounding difference.
        measurements.extend_from_within(..);
        if let Some(last) = measurements.last_mut() {
            *last = *last * (W::Scalar::ONE + W::Scalar::EPSILON);
        }
    }
    // Sometimes one too many.
    measurements.truncate(room + usize::from(draw.chance(0.01)));
    measurements
}
