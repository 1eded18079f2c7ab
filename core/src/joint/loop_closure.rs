//! Loop closure: finds landmarks that were initiated twice, and merges them, by the joint consistency of the landmarks around them.
//!
//! After a section of the trajectory without landmarks the pose is so uncertain that many landmarks are in the gate of a
//! measurement, and a wrong association cannot be undone. A loop is therefore not closed by single measurements. Landmarks that are
//! much less certain than others in view are excluded from the association ([`exclude_weakly_determined`]), and the measurements
//! initiate new landmarks. These are accurate relative to each other, and are matched with the old map as a whole ([`close_loop`]).

use super::associations::AssociationRow;
use super::config::JointConfig;
use super::covariance::{first, symmetric};
use super::difference::{Difference, Fusion};
use super::landmark::Landmark;
use super::map_management::fuse;
use super::state::Memory;
use crate::numerics::vector::{applied, product, transposed};
use crate::{Linear, LnSum, Matrix, Pose, PositionOf, Real, Vector};

/// A landmark is weakly determined if the standard deviation of its innovation, per coordinate, is more than this many
/// times the smallest one of the scan.
const WEAK_RATIO: f64 = 3.0;
/// Detections of an established landmark, at least. Only established landmarks are matched.
const ESTABLISHED_DETECTIONS: f64 = 3.0;
/// Prior probability that a landmark near a matched one is a duplicate too.
const OLD_FRACTION: f64 = 0.5;
/// Least posterior probability of a match.
const LEAST_PROBABILITY: f64 = 0.99;
/// Greatest number of candidates for a match of one landmark: the nearest ones.
const CANDIDATES: usize = 8;
/// Number of candidates for each of the other landmarks in view: the nearest ones after the fusion of the pair.
const NEIGHBOURS: usize = 3;
/// Number of landmarks in view for which a match is searched: those detected most often. One is not enough, because it
/// may be a new landmark without a match.
const SEEDS: usize = 6;

/// The threshold below which ln of the peak of the innovation's density means that a landmark is weakly determined;
/// `ln_peak` is the highest of the scan.
pub(super) fn least_of<Y: Vector>(ln_peak: Y::Scalar) -> Y::Scalar {
    ln_peak - Y::Scalar::from_f64(WEAK_RATIO).ln() * Y::Scalar::from_usize(Y::DIMENSION)
}

/// Removes the associations of weakly determined landmarks, which then count as out of view: those whose `scratch`, ln
/// of the peak of the innovation's density, is below `least`. Returns their number, and Σ ln(1 − p_D v) over them.
pub(super) fn exclude_weakly_determined<T: Real, D: Vector<Scalar = T>>(
    landmarks: &mut [Landmark<D>],
    table: &mut [AssociationRow<T>],
    least: T,
) -> (usize, T) {
    let (mut weak, mut ln_missed) = (0, T::ZERO);
    for landmark in landmarks.iter().filter(|landmark| landmark.scratch < least) {
        weak += 1;
        ln_missed += (T::ONE - landmark.detection * landmark.existence.visible).ln();
    }
    if weak > 0 {
        let is_weak = |index: u16| landmarks.get(usize::from(index)).is_some_and(|landmark| landmark.scratch < least);
        table.iter_mut().for_each(|row| row.retract(is_weak));
        landmarks
            .iter_mut()
            .filter(|landmark| landmark.scratch < least)
            .for_each(|landmark| landmark.detection = T::ZERO);
    }
    (weak, ln_missed)
}

/// Fuses the two landmarks with the greatest evidence that they are duplicates, if it is certain enough. One of the two
/// is among the landmarks in view that were detected most often. Returns the number of fused pairs.
pub(super) fn close_loop<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
) -> usize {
    let mut seeds = Nearest::<T, SEEDS>::NONE;
    for (index, landmark) in memory.landmarks.iter().enumerate().take(memory.header.len) {
        if landmark.detection > T::ZERO && is_established(landmark) {
            seeds.take(index, -landmark.detections);
        }
    }
    let mut best: Option<([usize; 2], T)> = None;
    for one in seeds.indices() {
        if let Some((other, ln_evidence)) = match_of(config, memory, one)
            && best.is_none_or(|(_, most)| ln_evidence > most)
        {
            best = Some(([one, other], ln_evidence));
        }
    }
    usize::from(best.is_some_and(|([one, other], _)| fuse(config, memory, one, other)))
}

/// Whether a landmark was detected often enough and exists with a probability of at least one half.
fn is_established<D: Vector>(landmark: &Landmark<D>) -> bool {
    landmark.detections >= D::Scalar::from_f64(ESTABLISHED_DETECTIONS)
        && landmark.existence.total() >= D::Scalar::from_f64(0.5)
}

/// The landmark that `one` is a duplicate of, if the match is certain enough, and ln of its evidence Λ.
fn match_of<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
    one: usize,
) -> Option<(usize, T)> {
    let ln_density = ln_density(memory)?;
    let mut candidates = Nearest::<T, CANDIDATES>::NONE;
    for other in (0..memory.header.len).filter(|&other| other != one) {
        if let Some(pair) = Pair::of(memory, one, other, config.merge_distance) {
            candidates.take(other, pair.fusion.distance);
        }
    }
    // The hypothesis that it is none of them has the evidence 1.
    let (mut all, mut best) = (LnSum::of(T::ZERO), None);
    for other in candidates.indices() {
        let Some(pair) = Pair::of(memory, one, other, config.merge_distance) else { continue };
        let ln_evidence = pair.ln_evidence(memory, ln_density);
        all.add(ln_evidence);
        if best.is_none_or(|(_, most)| ln_evidence > most) {
            best = Some((other, ln_evidence));
        }
    }
    best.filter(|&(_, ln_evidence)| ln_evidence - all.ln() >= T::from_f64(LEAST_PROBABILITY).ln())
}

/// ln ρ: the density of established landmarks, their number divided by the volume of their bounding box.
fn ln_density<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>) -> Option<T> {
    let established = || {
        memory
            .landmarks
            .iter()
            .take(memory.header.len)
            .filter(|landmark| is_established(landmark))
            .map(|landmark| &landmark.mean)
    };
    let mut ln_density = T::from_usize(established().count()).ln();
    for d in 0..PositionOf::<P>::DIMENSION {
        let ends = |(least, most): (T, T), mean: &P::Position| (least.at_most(mean.at(d)), most.at_least(mean.at(d)));
        let (least, most) = established().fold((T::INFINITY, T::NEG_INFINITY), ends);
        ln_density -= (most - least).ln();
    }
    // The density is undefined without landmarks, or if all are on a line.
    ln_density.is_finite().then_some(ln_density)
}

/// A hypothesis of loop closure: two landmarks are the same one.
struct Pair<P: Pose> {
    apart: Difference<P>,
    /// C⁻¹.
    inverse: Linear<PositionOf<P>, PositionOf<P>>,
    fusion: Fusion<PositionOf<P>>,
    /// ln e + ln N(y; 0, C), with e the existence probability of the other landmark.
    ln_pair: P::Scalar,
}

impl<T: Real, P: Pose<Scalar = T>> Pair<P> {
    /// `None` unless the other one is established and within this squared Mahalanobis distance.
    fn of<Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>, one: usize, other: usize, within: T) -> Option<Self> {
        let existence = memory.landmarks.get(other).filter(|landmark| is_established(landmark))?.existence.total();
        let apart = Difference::of(memory, [one, other]).filter(|apart| !apart.is_beyond(within))?;
        let factor = apart.factor()?;
        let fusion = Fusion::of::<P>(&apart.difference, &factor, &apart.heading);
        if !(fusion.distance <= within) {
            return None;
        }
        let ln_pair = existence.ln() + factor.ln_peak() - fusion.distance * T::from_f64(0.5);
        Some(Self { apart, inverse: factor.inverse().to_matrix(), fusion, ln_pair })
    }

    /// ln Λ: the likelihood ratio of the hypothesis, against the one that all landmarks in view are new.
    fn ln_evidence<Z: Vector<Scalar = T>>(&self, memory: &mut Memory<'_, P, Z>, ln_density: T) -> T {
        let (ln_old_fraction, old_fraction) = (T::from_f64(OLD_FRACTION).ln(), T::from_f64(OLD_FRACTION));
        // The positions of all landmarks after this fusion, in the rows of `pending`, which are not in use here.
        for index in 0..memory.header.len {
            let Some(landmark) = memory.landmarks.get(index).filter(|landmark| is_established(landmark)) else {
                continue;
            };
            let by: P::Position = self.fusion.moves(&memory.joint, &self.apart, first::<P>(index));
            let moved = landmark.mean + by;
            let Some(rows) = memory.pending.features.get_mut(index).map(|[rows, ..]| rows) else { break };
            for (d, row) in rows.as_mut().iter_mut().enumerate() {
                *row = Z::with(|z| if z == 0 { moved.at(d) } else { T::ZERO });
            }
        }
        let mut ln_evidence = ln_old_fraction + self.ln_pair - ln_density;
        for around in (0..memory.header.len).filter(|&around| self.is_other_established(memory, around)) {
            if !memory.landmarks.get(around).is_some_and(|landmark| landmark.detection > T::ZERO) {
                continue;
            }
            let mut near = Nearest::<T, NEIGHBOURS>::NONE;
            for index in
                (0..memory.header.len).filter(|&index| index != around && self.is_other_established(memory, index))
            {
                near.take(index, {
                    let apart = difference_after(memory, around, index);
                    apart.dot(&apart)
                });
            }
            let mut likelihood = T::ONE - old_fraction;
            for index in near.indices() {
                likelihood += old_fraction * self.ln_pair_evidence(memory, around, index, ln_density).exp();
            }
            ln_evidence += likelihood.ln();
        }
        ln_evidence
    }

    /// Whether a landmark is established and neither of these two.
    fn is_other_established<Z: Vector<Scalar = T>>(&self, memory: &Memory<'_, P, Z>, index: usize) -> bool {
        !self.apart.indices.contains(&index) && memory.landmarks.get(index).is_some_and(is_established)
    }

    /// ln( e_d N_cd / ρ ) of another pair, given that the two landmarks of this hypothesis are the same.
    fn ln_pair_evidence<Z: Vector<Scalar = T>>(
        &self,
        memory: &Memory<'_, P, Z>,
        one: usize,
        other: usize,
        ln_density: T,
    ) -> T {
        let Some(apart) = Difference::of(memory, [one, other]) else { return T::NEG_INFINITY };
        let with = self.apart.with_other(&memory.joint, &apart);
        let gain = product::<P::Position, P::Position, P::Position>(&with, &self.inverse);
        let statistics =
            product::<P::Position, P::Position, P::Position>(&gain, &transposed::<P::Position, P::Position>(&with));
        let own = &apart.covariance;
        let left = symmetric::<P::Position>(&Matrix::with(|r, c| own.at(r, c) - statistics.at(r, c)));
        let heading = apart.heading - applied::<P::Position, P::Position>(&gain, &self.apart.heading);
        let existence = memory.landmarks.get(other).map_or(T::ZERO, |landmark| landmark.existence.total());
        left.factor().map_or(T::NEG_INFINITY, |factor| {
            let fusion = Fusion::of::<P>(&difference_after(memory, one, other), &factor, &heading);
            existence.ln() + factor.ln_peak() - fusion.distance * T::from_f64(0.5) - ln_density
        })
    }
}

/// The difference of two landmarks after the fusion, from their positions in the rows of `pending`.
fn difference_after<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &Memory<'_, P, Z>,
    one: usize,
    other: usize,
) -> P::Position {
    let at = |index: usize, d: usize| {
        let row = memory.pending.features.get(index).and_then(|[rows, ..]| rows.as_ref().get(d));
        row.map_or(T::ZERO, |row| row.at(0))
    };
    P::Position::with(|d| at(other, d) - at(one, d))
}

/// The indices with the least distances, in ascending order; of equal distances the first.
struct Nearest<T, const N: usize> {
    indices: [(usize, T); N],
    len: usize,
}

impl<T: Real, const N: usize> Nearest<T, N> {
    const NONE: Self = Self { indices: [(0, T::ZERO); N], len: 0 };

    fn take(&mut self, index: usize, distance: T) {
        // Written so that NaN is not near.
        if !(distance < T::INFINITY) {
            return;
        }
        let (mut taken, mut found) = ((index, distance), false);
        for slot in self.indices.iter_mut().take(self.len) {
            found |= distance < slot.1;
            if found {
                core::mem::swap(slot, &mut taken);
            }
        }
        if let Some(slot) = self.indices.get_mut(self.len) {
            *slot = taken;
            self.len += 1;
        }
    }

    fn indices(&self) -> impl Iterator<Item = usize> {
        self.indices.iter().take(self.len).map(|&(index, _)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::super::existence::Existence;
    use super::super::{JointConfig, JointSlam, JointState, joint_numbers};
    use super::{Nearest, OLD_FRACTION, Pair, close_loop};
    use crate::*;
    use nalgebra::Vector2;
    use std::boxed::Box;
    use std::vec::Vec;

    type Room<T, const N: usize, const L: usize> = JointState<PlanarPose<T>, Vector2<T>, N, L, 16>;
    type Six = Room<f64, 6, { joint_numbers(3, 2, 6) }>;

    /// Variances of each coordinate, m²: of the common displacement of all new landmarks, and of each landmark's own error.
    const COMMON: f64 = 4.0;
    const OWN: f64 = 0.01;
    /// Positions of the old landmarks, m.
    const OLD: [[f64; 2]; 3] = [[0.0, 0.0], [30.0, 0.0], [0.0, 50.0]];

    /// Three old landmarks out of view, and three new ones in view. `apart` has the differences of the old ones from the new ones.
    fn map(apart: [[f64; 2]; 3]) -> Box<Six> {
        let mut state = Box::new(Six::new());
        let memory = state.memory();
        memory.header.len = 6;
        for index in 0..6 {
            let (of, is_new) = (index % 3, index >= 3);
            let old = Vector2::from(OLD[of]);
            let landmark = &mut memory.landmarks[index];
            landmark.label = index as u32;
            landmark.mean = if is_new { old - Vector2::from(apart[of]) } else { old };
            landmark.existence = Existence::of(0.8);
            landmark.detections = if index == 3 { 9.0 } else { 5.0 };
            landmark.detection = if is_new { 0.9 } else { 0.0 };
        }
        let mut joint = memory.joint;
        for (row, column) in (0..15).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            let same_axis = row >= 3 && column >= 3 && (row - column) % 2 == 0;
            let common = if same_axis && row >= 9 && column >= 9 { COMMON } else { 0.0 };
            joint.set(row, column, common + if row == column && row >= 3 { OWN } else { 0.0 });
        }
        state
    }

    fn ln_normal([x, y]: [f64; 2], variance: f64) -> f64 {
        -(x * x + y * y) / (2.0 * variance) - (core::f64::consts::TAU * variance).ln()
    }

    #[test]
    fn the_evidence_is_that_of_the_differences_given_the_first_match() {
        let apart = [[1.0, -0.5], [1.1, -0.4], [0.8, -0.6]];
        let mut state = map(apart);
        let mut memory = state.memory();
        let (ln_density, of_old) = (-3.0, 0.8_f64.ln());
        let pair = Pair::of(&memory, 3, 0, 9.0).unwrap();
        let one = COMMON + 2.0 * OWN;
        assert!((pair.fusion.distance - 1.25 / one).abs() < 1e-9);
        let found = pair.ln_evidence(&mut memory, ln_density);
        let mut ln_evidence = OLD_FRACTION.ln() + of_old + ln_normal(apart[0], one) - ln_density;
        // For each other new landmark: its differences from the old ones and from the other new one, given the first
        // match.
        let left = one - COMMON * COMMON / one;
        let moved = |[x, y]: [f64; 2]| {
            let probability = COMMON / one;
            [x - probability * apart[0][0], y - probability * apart[0][1]]
        };
        for around in [1, 2] {
            let mut sum = 1.0 - OLD_FRACTION;
            for old in [1, 2] {
                let [x, y] = [0, 1].map(|d| OLD[old][d] - OLD[around][d] + apart[around][d]);
                sum += OLD_FRACTION * (of_old + ln_normal(moved([x, y]), left) - ln_density).exp();
            }
            let other = 3 - around;
            let [x, y] = [0, 1].map(|d| OLD[other][d] - apart[other][d] - OLD[around][d] + apart[around][d]);
            sum += OLD_FRACTION * (of_old + ln_normal([x, y], 2.0 * OWN) - ln_density).exp();
            ln_evidence += sum.ln();
        }
        assert!((found - ln_evidence).abs() < 1e-6, "{found} {ln_evidence}");
    }

    #[test]
    fn a_pair_is_fused_only_if_the_other_landmarks_fit() {
        let merged = |apart, config: &JointConfig<f64>| {
            let mut state = map(apart);
            let merged = close_loop(config, &mut state.memory());
            (merged, state.memory().header.len)
        };
        let fits = [[1.0, -0.5], [1.1, -0.4], [0.9, -0.6]];
        let config = JointConfig::default();
        assert_eq!(merged(fits, &config), (1, 5));
        // The other new landmarks do not fit.
        assert_eq!(merged([[1.0, -0.5], [-1.0, 2.5], [-0.9, -2.6]], &config), (0, 6));
        // Beyond the covariance of the difference.
        assert_eq!(merged(fits.map(|[x, y]| [x + 9.0, y]), &config), (0, 6));
        assert_eq!(merged(fits, &JointConfig { merge_distance: 0.0, ..config }), (0, 6));
    }

    #[test]
    fn the_nearest_are_in_ascending_order() {
        let mut nearest = Nearest::<f64, 3>::NONE;
        for (index, distance) in [(0, 4.0), (1, f64::NAN), (2, 1.0), (3, 4.0), (4, 0.5), (5, 9.0)] {
            nearest.take(index, distance);
        }
        assert_eq!(nearest.indices().collect::<Vec<_>>(), [4, 2, 0]);
    }

    /// Two and a half laps of a circle with landmarks along half of it, and odometry with a fifth of the noise that the filter
    /// assumes. Returns the RMSE of the position, m, and the number of features at the end; there are twenty landmarks.
    fn rounds(seed: u64) -> (f64, usize) {
        let mut draws = Noise::seeded(seed);
        let radius = 20.0;
        let landmarks: Vec<[f64; 2]> = (0..20)
            .map(|_| {
                let turn = core::f64::consts::PI * draws.uniform::<f64>();
                let out = radius + 12.0 * (draws.uniform::<f64>() - 0.5);
                [out * turn.cos(), out * turn.sin()]
            })
            .collect();
        let window = RangeBearingWindow::full_circle(8.0_f32, 0.9).unwrap();
        let sensing = Sensing::range_bearing([0.05, 0.01], window, 0.2).unwrap();
        let lidar = Detector::new(sensing, Births::of_static(2e-4)).unwrap();
        // Five times the actual noise.
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.25, 0.1)).unwrap();
        let real = Unicycle::<f64>::new(Step::Arc, ControlNoise::NONE).unwrap();
        let mut state = Box::new(Room::<f32, 100, { joint_numbers(3, 2, 100) }>::new());
        let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
        let mut pose = PlanarPose::new(radius, 0.0, core::f64::consts::FRAC_PI_2);
        slam.reset(PlanarPose::new(radius as f32, 0.0, core::f32::consts::FRAC_PI_2)).unwrap();
        let (mut squares, steps) = (0.0, 1570);
        for _ in 0..steps {
            let control = UnicycleControl { speed_mps: 1.0, rate_radps: 1.0 / radius };
            pose = real.propagate(&pose, &control, 0.2);
            let odometry = UnicycleControl {
                speed_mps: (control.speed_mps + 0.05 * draws.normal::<f64>()) as f32,
                rate_radps: (control.rate_radps + 0.02 * draws.normal::<f64>()) as f32,
            };
            slam.predict(&odometry, 0.2).unwrap();
            let mut seen = Vec::new();
            let mut see = |range: f64, bearing: f64| seen.push(Vector2::new(range, wrap(bearing)).map(|x| x as f32));
            for [x, y] in &landmarks {
                let (dx, dy) = (x - pose.x_m, y - pose.y_m);
                if dx.hypot(dy) < 8.0 && draws.uniform::<f64>() < 0.9 {
                    let noise = [0.05 * draws.normal::<f64>(), 0.01 * draws.normal::<f64>()];
                    see(dx.hypot(dy) + noise[0], dy.atan2(dx) - pose.heading_rad + noise[1]);
                }
            }
            if draws.uniform::<f64>() < 0.2 {
                see(0.1 + 7.9 * draws.uniform::<f64>(), core::f64::consts::TAU * draws.uniform::<f64>());
            }
            slam.scan(&lidar, &seen).unwrap();
            let mean = slam.estimate_pose().unwrap().mean;
            squares += (f64::from(mean.x_m) - pose.x_m).powi(2) + (f64::from(mean.y_m) - pose.y_m).powi(2);
        }
        ((squares / f64::from(steps)).sqrt(), slam.features().count())
    }

    /// If single measurements decided the association, most landmarks would be in the map twice.
    #[test]
    fn loops_are_closed_with_overestimated_odometry_noise() {
        let mut runs: Vec<(f64, usize)> = (40..49).map(rounds).collect();
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(runs[4].0 < 2.0, "{runs:?}");
        assert!(runs.iter().filter(|run| run.1 <= 21).count() >= 6, "{runs:?}");
    }
}
