//! The loops of a correction over the features and over the rows of the covariance. Their passes are independent of each other, so
//! that the threads of a device can share them.

use super::covariance::{Joint, first, get, run};
use super::landmark::Landmark;
use super::pending::{EachBy, FeatureRows, Pending, TERMS, h_times, set_rows};
use crate::numerics::vector::applied;
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Serial, TangentOf, Vector, Zero};

/// Executes the passes of these loops, in any order; the state does not depend on it.
pub trait RowExecutor<P: Pose, Z: Vector<Scalar = ScalarOf<P>>> {
    /// Calls [`FeaturePass::run`] for every feature, with its rows and its landmark.
    fn each_feature(
        &self,
        pass: &impl FeaturePass<P, Z>,
        numbers: &[ScalarOf<P>],
        rows: &mut [FeatureRows<P, Z>],
        landmarks: &mut [Landmark<PositionOf<P>>],
    );

    /// Calls [`Pending::add_to`] for every [part](Pending::part) of a covariance with so many features.
    #[inline]
    fn each_part(&self, pending: &Pending<'_, P, Z>, numbers: &mut [ScalarOf<P>], features: usize) {
        pending.add_to_all(numbers, features);
    }
}

impl<P: Pose, Z: Vector<Scalar = ScalarOf<P>>> RowExecutor<P, Z> for Serial {
    #[inline]
    fn each_feature(
        &self,
        pass: &impl FeaturePass<P, Z>,
        numbers: &[ScalarOf<P>],
        rows: &mut [FeatureRows<P, Z>],
        landmarks: &mut [Landmark<PositionOf<P>>],
    ) {
        for (feature, (rows, landmark)) in rows.iter_mut().zip(landmarks).enumerate() {
            pass.run(numbers, feature, rows, landmark);
        }
    }
}

/// Executes the passes for one feature alone, whose index it is, so that only this feature and the pose are corrected.
#[derive(Debug)]
pub(super) struct OneFeature(pub(super) usize);

impl<P: Pose, Z: Vector<Scalar = ScalarOf<P>>> RowExecutor<P, Z> for OneFeature {
    #[inline]
    fn each_feature(
        &self,
        pass: &impl FeaturePass<P, Z>,
        numbers: &[ScalarOf<P>],
        rows: &mut [FeatureRows<P, Z>],
        landmarks: &mut [Landmark<PositionOf<P>>],
    ) {
        if let (Some(rows), Some(landmark)) = (rows.get_mut(self.0), landmarks.get_mut(self.0)) {
            pass.run(numbers, self.0, rows, landmark);
        }
    }
}

/// The pass of a loop over the features.
pub trait FeaturePass<P: Pose, Z: Vector<Scalar = ScalarOf<P>>> {
    /// The pass for one feature.
    fn run(
        &self,
        numbers: &[ScalarOf<P>],
        feature: usize,
        rows: &mut FeatureRows<P, Z>,
        landmark: &mut Landmark<PositionOf<P>>,
    );

    /// The same pass without references, for another thread.
    fn to_task(&self) -> FeatureTask<P, Z>;
}

/// Sets the rows of the next term to P Hᵀ.
pub(super) struct Measure<'a, P: Pose, Y: Vector, Z: Vector> {
    /// Index of the next term.
    pub(super) next: usize,
    /// What the pending terms contribute.
    pub(super) gains: &'a EachBy<Z>,
    /// The first coordinate of the measured feature.
    pub(super) first: usize,
    /// Hx.
    pub(super) by_pose: &'a Linear<Y, TangentOf<P>>,
    /// Hm.
    pub(super) by_feature: &'a Linear<Y, PositionOf<P>>,
}

/// Sets the rows of the next term to the levers of corrected positions, and to P e + c eᵀ P e/2.
pub(super) struct Turn<'a, Z: Vector> {
    pub(super) next: usize,
    pub(super) gains: &'a EachBy<Z>,
    /// The coordinate of the heading.
    pub(super) heading: usize,
    /// Half its variance.
    pub(super) half: Z::Scalar,
}

/// Corrects the position by the rows of the next term.
pub(super) struct Inject<'a, Z: Vector> {
    pub(super) next: usize,
    /// The step of the correction.
    pub(super) step: &'a Z,
    /// Its δθ.
    pub(super) turn: Z::Scalar,
}

/// A pass over the features as numbers.
#[derive(Debug, Clone, Copy)]
pub struct FeatureTask<P: Pose, Z: Vector> {
    kind: Kind,
    next: usize,
    gains: EachBy<Z>,
    /// The first coordinate of the measured feature, or that of the heading.
    at: usize,
    by_pose: Linear<Z, TangentOf<P>>,
    by_feature: Linear<Z, PositionOf<P>>,
    step: Z,
    /// Half the variance of the heading, or δθ.
    number: Z::Scalar,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Measure,
    Turn,
    Inject,
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> FeatureTask<P, Z> {
    fn new(kind: Kind, next: usize, gains: &EachBy<Z>, at: usize, number: T) -> Self {
        let (by_pose, by_feature) = (Zero::ZERO, Zero::ZERO);
        Self { kind, next, gains: *gains, at, by_pose, by_feature, step: Z::ZERO, number }
    }

    /// The pass for one feature.
    #[inline]
    pub fn run(
        &self,
        numbers: &[T],
        feature: usize,
        rows: &mut FeatureRows<P, Z>,
        landmark: &mut Landmark<PositionOf<P>>,
    ) {
        let Self { next, gains, by_pose, by_feature, step, .. } = self;
        let (next, at, number) = (*next, self.at, self.number);
        match self.kind {
            Kind::Measure => {
                let pass = Measure::<P, Z, Z> { next, gains, first: at, by_pose, by_feature };
                pass.run(numbers, feature, rows, landmark);
            }
            Kind::Turn => {
                let pass = Turn { next, gains, heading: at, half: number };
                FeaturePass::<P, Z>::run(&pass, numbers, feature, rows, landmark);
            }
            Kind::Inject => {
                FeaturePass::<P, Z>::run(&Inject { next, step, turn: number }, numbers, feature, rows, landmark);
            }
        }
    }
}

impl<T: Real, P: Pose<Scalar = T>, Y: Vector<Scalar = T>, Z: Vector<Scalar = T>> Measure<'_, P, Y, Z> {
    /// The row of P Hᵀ for one coordinate, without the pending terms.
    #[inline(always)]
    pub(super) fn row(&self, numbers: &[T], coordinate: usize) -> Z {
        let pose = run::<T, P::Tangent>(numbers, coordinate, 0);
        let own = run::<T, P::Position>(numbers, coordinate, self.first);
        let of_measurement =
            applied::<Y, P::Tangent>(self.by_pose, &pose) + applied::<Y, P::Position>(self.by_feature, &own);
        Z::with(|z| of_measurement.at(z))
    }
}

impl<T: Real, P: Pose<Scalar = T>, Y: Vector<Scalar = T>, Z: Vector<Scalar = T>> FeaturePass<P, Z>
    for Measure<'_, P, Y, Z>
{
    #[inline(always)]
    fn run(&self, numbers: &[T], feature: usize, rows: &mut FeatureRows<P, Z>, _: &mut Landmark<PositionOf<P>>) {
        let first = first::<P>(feature);
        set_rows(rows, self.next, self.gains, |d| self.row(numbers, first + d));
    }

    fn to_task(&self) -> FeatureTask<P, Z> {
        FeatureTask {
            by_pose: Matrix::with(|row, column| self.by_pose.at(row, column)),
            by_feature: Matrix::with(|row, column| self.by_feature.at(row, column)),
            ..FeatureTask::new(Kind::Measure, self.next, self.gains, self.first, T::ZERO)
        }
    }
}

impl<T: Real, Z: Vector<Scalar = T>> Turn<'_, Z> {
    /// The row of one coordinate with this lever, without the pending terms.
    #[inline(always)]
    pub(super) fn row(&self, numbers: &[T], coordinate: usize, lever: T) -> Z {
        let with_heading = get(numbers, coordinate, self.heading) + lever * self.half;
        Z::with(|z| [lever, with_heading].get(z).copied().unwrap_or(T::ZERO))
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> FeaturePass<P, Z> for Turn<'_, Z> {
    #[inline(always)]
    fn run(&self, numbers: &[T], feature: usize, rows: &mut FeatureRows<P, Z>, landmark: &mut Landmark<P::Position>) {
        let (first, levers) = (first::<P>(feature), lever(landmark.moved.as_slice()));
        set_rows(rows, self.next, self.gains, |d| {
            self.row(numbers, first + d, levers.get(d).copied().unwrap_or(T::ZERO))
        });
        landmark.moved = Zero::ZERO;
    }

    fn to_task(&self) -> FeatureTask<P, Z> {
        FeatureTask::new(Kind::Turn, self.next, self.gains, self.heading, self.half)
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> FeaturePass<P, Z> for Inject<'_, Z> {
    #[inline(always)]
    fn run(&self, _: &[T], _: usize, rows: &mut FeatureRows<P, Z>, landmark: &mut Landmark<P::Position>) {
        let Some(rows) = rows.get(self.next) else { return };
        let counted = P::Position::with(|d| rows.as_ref().get(d).map_or(T::ZERO, |row| row.dot(self.step)));
        let by = turned(counted, self.turn, landmark.moved.as_slice());
        landmark.mean += by;
        landmark.moved += by;
    }

    fn to_task(&self) -> FeatureTask<P, Z> {
        let gains = [Zero::ZERO; TERMS];
        FeatureTask { step: *self.step, ..FeatureTask::new(Kind::Inject, self.next, &gains, 0, self.turn) }
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Pending<'_, P, Z> {
    /// Sets the rows of the next term to P Hᵀ, for the pose and these landmarks. H consists of Hx = ∂h/∂x and Hm = ∂h/∂m of
    /// the landmark `index`; P includes the pending terms.
    pub(super) fn measure<Y: Vector<Scalar = T>>(
        &mut self,
        joint: &Joint<'_, P>,
        landmarks: &mut [Landmark<P::Position>],
        index: usize,
        by_pose: &Linear<Y, P::Tangent>,
        by_feature: &Linear<Y, P::Position>,
        rows: &impl RowExecutor<P, Z>,
    ) {
        let own = self.features.get(index).copied().unwrap_or([Zero::ZERO; TERMS]);
        let mut gains: EachBy<Z> = [Zero::ZERO; TERMS];
        for (((gain, by), pose), own) in gains.iter_mut().zip(&self.by).zip(&self.pose).zip(&own).take(self.count) {
            let of_measurement: Linear<Y, Z> = h_times::<Y, P::Tangent, Z>(by_pose, pose.as_ref())
                + h_times::<Y, P::Position, Z>(by_feature, own.as_ref());
            *gain = Matrix::with(|y, z| {
                (0..Z::DIMENSION).fold(T::ZERO, |sum, k| sum + of_measurement.at(y, k) * by.at(k, z))
            });
        }
        let first = first::<P>(index);
        let pass = Measure::<P, Y, Z> { next: self.count, gains: &gains, first, by_pose, by_feature };
        set_rows(&mut self.pose, self.count, &gains, |coordinate| pass.row(joint.numbers, coordinate));
        rows.each_feature(&pass, joint.numbers, self.features, landmarks);
    }

    /// Adds the next term for P ← (I + c eᵀ) P (I + c eᵀ)ᵀ, for the pose and these landmarks. It accounts for an uncertain
    /// heading at positions that corrections have moved, which become unmoved. e is the direction of the coordinate `heading`;
    /// c has the levers of the other coordinates of the pose (0 of the heading itself) and those of each feature. With
    /// w = P e + c eᵀ P e/2 the result is P + c wᵀ + w cᵀ.
    pub(super) fn push_turn(
        &mut self,
        joint: &Joint<'_, P>,
        landmarks: &mut [Landmark<P::Position>],
        heading: usize,
        of_pose: &P::Tangent,
        rows: &impl RowExecutor<P, Z>,
    ) {
        let (mut variance, mut gains) = (joint.get(heading, heading), [Zero::ZERO; TERMS]);
        for ((gain, by), pose) in gains.iter_mut().zip(&self.by).zip(&self.pose).take(self.count) {
            let Some(of_heading) = pose.as_ref().get(heading) else { return };
            let weighed = applied::<Z, Z>(by, of_heading);
            variance += weighed.dot(of_heading);
            *gain = Matrix::with(|row, column| if row == 1 { weighed.at(column) } else { T::ZERO });
        }
        let pass = Turn { next: self.count, gains: &gains, heading, half: variance * T::from_f64(0.5) };
        set_rows(&mut self.pose, self.count, &gains, |row| pass.row(joint.numbers, row, of_pose.at(row)));
        rows.each_feature(&pass, joint.numbers, self.features, landmarks);
        self.push(&Matrix::with(|row, column| if row + column == 1 { T::ONE } else { T::ZERO }));
    }

    /// Moves these landmarks by their rows of the next term times `step`, and by a turn.
    pub(super) fn inject(
        &mut self,
        joint: &Joint<'_, P>,
        landmarks: &mut [Landmark<P::Position>],
        (step, turn): (&Z, T),
        rows: &impl RowExecutor<P, Z>,
    ) {
        let pass = Inject { next: self.count, step, turn };
        rows.each_feature(&pass, joint.numbers, self.features, landmarks);
    }
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Applies the pending terms for this number of features; none is pending afterwards. Every variance is increased by 4 ε of its
    /// value for rounding errors: otherwise the matrix would lose its definiteness in a hundred thousand updates.
    pub(super) fn apply<Z: Vector<Scalar = T>>(
        &mut self,
        pending: &mut Pending<'_, P, Z>,
        features: usize,
        rows: &impl RowExecutor<P, Z>,
    ) {
        if pending.count > 2 && !pending.is_full() {
            pending.fill(features, |_| Z::ZERO);
        }
        if pending.count > 0 {
            rows.each_part(pending, self.numbers, features);
        }
        pending.count = 0;
    }
}

/// ê × Δ with the vertical unit vector ê: the first two coordinates; the third one is 0.
pub(super) fn lever<T: Real>(moved: &[T]) -> [T; 2] {
    match *moved {
        [x, y, ..] => [-y, x],
        _ => [T::ZERO; 2],
    }
}

/// e = ξ + δθ × Δ.
pub(super) fn turned<T: Real, V: Vector<Scalar = T>>(counted: V, turn: T, moved: &[T]) -> V {
    let lever = lever(moved);
    V::with(|k| counted.at(k) + lever.get(k).map_or(T::ZERO, |&by| turn * by))
}

#[cfg(test)]
mod tests {
    use super::super::course::{self, Course, motion};
    use super::super::covariance::row_start;
    use super::*;
    use crate::*;
    use nalgebra::Vector2;

    /// Executes the passes in the opposite order.
    struct Backwards;

    impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> RowExecutor<P, Z> for Backwards {
        fn each_feature(
            &self,
            pass: &impl FeaturePass<P, Z>,
            numbers: &[T],
            rows: &mut [FeatureRows<P, Z>],
            landmarks: &mut [Landmark<PositionOf<P>>],
        ) {
            let task = pass.to_task();
            for (feature, landmark) in landmarks.iter_mut().enumerate().rev() {
                task.run(numbers, feature, &mut rows[feature], landmark);
            }
        }

        fn each_part(&self, pending: &Pending<'_, P, Z>, numbers: &mut [T], features: usize) {
            let parts = (0..).map_while(|part| Pending::<P, Z>::part(features, part)).count();
            assert_eq!(Pending::<P, Z>::part(features, parts - 1).unwrap().end, row_start(first::<P>(features)));
            for part in (0..parts).rev() {
                let of_part = Pending::<P, Z>::part(features, part).unwrap();
                pending.add_to(features, part, &mut numbers[of_part]);
            }
        }
    }

    #[test]
    fn the_order_of_the_passes_changes_no_bit() {
        type State = JointState<PlanarPose<f32>, Vector2<f32>, 24, { joint_numbers(3, 2, 24) }, 32>;
        let (mut states, mut movers) = ([State::new(), State::new()], [JointMovers::<_, 8>::new(), JointMovers::new()]);
        let digests = [false, true].map(|backwards| {
            let (state, movers) = (&mut states[usize::from(backwards)], &mut movers[usize::from(backwards)]);
            let slam = JointSlam::new(motion::<f32>(), JointConfig::default(), state).unwrap();
            let mut slam = slam.with_movers(movers, MovingConfig::walkers()).unwrap();
            slam.reset(PlanarPose::new(8.0, 0.0, f32::PI / 2.0)).unwrap();
            let detector = course::lidar::<f32>(1.0, Births { of_static: 1e-3, of_moving: 1e-3 });
            let mut place = Course::new(5, true, 1);
            (0..150)
                .map(|_| {
                    let (odometry, seen) = place.step(|_| false);
                    let [speed_mps, rate_radps] = [odometry.speed_mps, odometry.rate_radps].map(|x| x as f32);
                    slam.predict(&UnicycleControl { speed_mps, rate_radps }, 0.1).unwrap();
                    let seen: std::vec::Vec<_> = seen.iter().map(|z| z.map(|x| x as f32)).collect();
                    if backwards { slam.scan_on(&detector, &seen, &Backwards) } else { slam.scan(&detector, &seen) }
                        .unwrap();
                    slam.digest()
                })
                .collect::<std::vec::Vec<_>>()
        });
        assert!(digests[0] == digests[1]);
    }
}
