//! A snapshot of the joint filter in the types of the reference. The order of its values is that of `core/src/joint/walk.rs`.

use nalgebra::{DMatrix, DVector};
use scphd_reference::joint::{Feature, Mover, State};

/// Size of the header and its checksum, bytes.
const HEAD: usize = 36;

/// Reads words and numbers in order.
struct Reader<'a> {
    rest: &'a [u8],
    /// Size of a number, bytes.
    scalar: u8,
}

impl Reader<'_> {
    fn word(&mut self) -> u32 {
        let (word, rest) = self.rest.split_first_chunk::<4>().expect("a whole snapshot");
        self.rest = rest;
        u32::from_le_bytes(*word)
    }

    fn number(&mut self) -> f64 {
        let low = self.word();
        if self.scalar == 4 {
            return f64::from(f32::from_bits(low));
        }
        let high = self.word();
        f64::from_bits(u64::from(high) << 32 | u64::from(low))
    }

    fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.number()).collect()
    }

    /// A symmetric matrix, stored as its lower triangle.
    fn symmetric(&mut self, rows: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(rows, rows);
        for row in 0..rows {
            for column in 0..=row {
                let number = self.number();
                matrix[(row, column)] = number;
                matrix[(column, row)] = number;
            }
        }
        matrix
    }
}

/// The state in a complete snapshot of a started filter.
pub(super) fn read(bytes: &[u8]) -> State {
    let [uncertain, each, numbers] = [12, 13, 14].map(|at| usize::from(bytes[at]));
    let mut features = Reader { rest: &bytes[20..], scalar: 4 };
    let [count, _archived, others] = [(); 3].map(|()| features.word());
    let (count, movers) = (count as usize, others >> 16);
    let mut from = Reader { rest: &bytes[HEAD..], scalar: bytes[7] };
    let _started = from.word();
    let pose = from.numbers(numbers);
    let _remainder = from.numbers(2);
    let mut state = State::new(pose, uncertain);
    state.waited_s = from.number();
    state.next_label = from.word();
    let _refused = from.word();
    // The divergence monitor: four words and six numbers.
    let _counts: [u32; 4] = std::array::from_fn(|_| from.word());
    let _watch = from.numbers(6);
    let _moved = from.numbers(2);
    state.process_noise = from.symmetric(uncertain);
    for _ in 0..count {
        let label = from.word();
        state.places.push(from.numbers(each));
        let [in_sight, hidden, absent, detections] = [(); 4].map(|()| from.number());
        state.features.push(Feature { label, in_sight, hidden, absent, detections });
        let _moved = from.numbers(each);
    }
    let len = uncertain + each * count;
    state.covariance = from.symmetric(len);
    if movers > 0 {
        state.process_noise = from.symmetric(uncertain);
    }
    for _ in 1..movers {
        let (label, weight) = (from.word(), from.number().exp());
        let mean = DVector::from_vec(from.numbers(2 * each));
        state.movers.push(Mover { label, weight, mean, covariance: from.symmetric(2 * each) });
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use scphd::models::{
        ControlNoise, PlanarPose, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
        UniformClutter,
    };
    use scphd::numerics::{Noise, wrap};
    use scphd::settings::Persistence;
    use scphd::storage::joint_numbers;
    use scphd::{Births, Component, Detector, JointConfig, JointSlam, JointState};
    use scphd_reference as reference;
    use scphd_reference::FieldOfView;
    use scphd_reference::joint::{Config, Joint, Planar};
    use std::convert::Infallible;

    const ROOM: usize = 6;
    const NUMBERS: usize = joint_numbers(3, 2, ROOM);
    const BIRTHS: f64 = 1e-3;

    /// The reference with the parameters of the filter below.
    fn reference(config: &JointConfig<f64>) -> Joint<Planar> {
        let field_of_view = FieldOfView {
            range_min_m: 0.0,
            range_max_m: 20.0,
            range_edge_m: 0.0,
            bearing_center_rad: 0.0,
            bearing_half_width_rad: std::f64::consts::PI,
            bearing_edge_rad: 0.0,
            p_near: 0.9,
            p_far: 0.9,
        };
        let noise = reference::ControlNoise {
            speed_sigma_mps: 0.1,
            second_sigma: 0.05,
            speed_ratio: 0.0,
            second_ratio: 0.0,
            interval_s: 0.0,
        };
        let models = Planar {
            motion: reference::Motion { vehicle: reference::Vehicle::UnicycleArc, noise },
            mounting: [0.0; 3],
            sensor: reference::RangeBearing { range_sigma_m: 0.1, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.01 },
            field_of_view,
            clutter_intensity: field_of_view.clutter_intensity(2.0),
        };
        let config = Config { capacity: ROOM, ..super::super::reference_filter::joint_config_of(config, BIRTHS) };
        Joint { config, models }
    }

    /// A circle with a dozen landmarks, with capacity for half of them: births replace features of low existence probability, and
    /// in the end filter and reference, which run independently, have the same six.
    #[test]
    fn a_full_state_continues_as_the_reference() {
        let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
        let sensing = Sensing {
            sensor: RangeBearing::new(0.1, 0.01).unwrap(),
            field_of_view: window,
            clutter: UniformClutter::of_scan(2.0, window.measure()).unwrap(),
        };
        let detector = Detector::new(sensing, Births::of_static(BIRTHS)).unwrap();
        let persistence = Persistence { visible_s: 5.0, occluded_s: 2.0, lifetime_s: 100.0 };
        let config = JointConfig { persistence, occlusion_factor: 0.5, ..JointConfig::default() };
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
        let mut memory = Box::new(JointState::<PlanarPose<f64>, Vector2<f64>, ROOM, NUMBERS, 32>::new());
        let mut slam = JointSlam::new(motion, config, &mut *memory).unwrap();
        slam.reset(PlanarPose::new(8.0, 0.0, 1.5)).unwrap();
        let reference = reference(&config);
        let mut state = reference.initial(vec![8.0, 0.0, 1.5]);
        let (mut draws, mut truth, mut lost) = (Noise::seeded(5), [8.0, 0.0, 1.5], 0);
        for _ in 0..200 {
            truth = reference.models.motion.step(truth, &[2.0, 0.25, 0.0], 0.1);
            let control = [2.0 + 0.1 * draws.normal::<f64>(), 0.25 + 0.05 * draws.normal::<f64>(), 0.0];
            slam.predict(&UnicycleControl { speed_mps: control[0], rate_radps: control[1] }, 0.1).unwrap();
            reference.predict(&mut state, &control, 0.1);
            let mut scan = Vec::new();
            for k in 0..12 {
                let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
                let radius = if k % 2 == 0 { 12.0 } else { 4.0 };
                let (dx, dy) = (radius * angle.cos() - truth[0], radius * angle.sin() - truth[1]);
                let noise = [0.1 * draws.normal::<f64>(), 0.01 * draws.normal::<f64>()];
                if draws.uniform::<f64>() < 0.9 {
                    scan.push(Vector2::new(dx.hypot(dy) + noise[0], wrap(dy.atan2(dx) - truth[2] + noise[1])));
                }
            }
            scan.push(Vector2::new(20.0 * draws.uniform::<f64>(), 3.0 * draws.normal::<f64>()));
            let report = slam.scan(&detector, &scan).unwrap();
            let outcome = reference.scan(&mut state, &scan.iter().map(|z| z.as_slice()).collect::<Vec<_>>());
            let ours = [report.births, report.no_birth, report.lost, report.merged, report.dropped];
            assert_eq!(ours, [outcome.births, outcome.no_birth, outcome.lost, outcome.merged, outcome.dropped]);
            lost += report.lost;
        }
        assert!(lost > 100 && slam.held() == ROOM, "{lost}");
        let mut bytes = Vec::new();
        let sink = |part: &[u8]| -> Result<(), Infallible> {
            bytes.extend_from_slice(part);
            Ok(())
        };
        slam.save(0, sink).unwrap();
        let ours = read(&bytes);
        let labels = |state: &State| state.features.iter().map(|feature| feature.label).collect::<Vec<_>>();
        assert_eq!((ours.next_label, labels(&ours)), (state.next_label, labels(&state)));
        assert!((&ours.covariance - &state.covariance).amax() < 1e-9);
        for (a, b) in ours
            .pose
            .iter()
            .chain(ours.places.iter().flatten())
            .zip(state.pose.iter().chain(state.places.iter().flatten()))
        {
            assert!((a - b).abs() < 1e-9 || (wrap(a - b)).abs() < 1e-9, "{ours:?} {state:?}");
        }
        for (a, b) in ours.features.iter().zip(&state.features) {
            assert!((a.in_sight - b.in_sight).abs() + (a.hidden - b.hidden).abs() < 1e-9, "{a:?} {b:?}");
        }
        // The features read from the snapshot are those of the public interface.
        for feature in slam.features() {
            let Component { label, mean, covariance, .. } = feature;
            let place = labels(&ours).iter().position(|&other| other == label).unwrap();
            assert_eq!(mean.as_slice(), ours.places[place]);
            let first = 3 + 2 * place;
            assert_eq!(covariance.get(1, 0), ours.covariance[(first + 1, first)]);
        }
    }
}
