//! The difference of two features, and the equality constraint that merges them.
//!
//! That two features are the same landmark is used as a measurement without noise. The constraint holds at any
//! distance: a rotation of vehicle and map by δθ moves a position p by V(δθ) e, with e its displacement to first order
//! and V the mean of all rotations from 0 to δθ. Features that were measured together thus keep their relative
//! positions. As in [`invariant_error`](super::invariant_error), errors refer to the corrected positions: the error of
//! the difference δ of two features that become one is e_b − e_a − δθ ê × δ.

use super::covariance::{Joint, first, symmetric};
use super::rows::lever;
use super::state::Memory;
use crate::{Factor, Linear, Matrix, Pose, PositionOf, Real, Vector, Zero};

/// Maximum number of iterations for δθ, which depends on itself.
const ROUNDS: usize = 8;

/// The difference of two features.
pub(super) struct Difference<P: Pose> {
    pub(super) indices: [usize; 2],
    /// ê × δ of the difference δ; 0 without a heading.
    across: PositionOf<P>,
    /// δ.
    pub(super) difference: PositionOf<P>,
    /// C: the covariance of e_b − e_a − δθ ê × δ, with an allowance for rounding errors.
    pub(super) covariance: Linear<PositionOf<P>, PositionOf<P>>,
    /// h: the covariance of the same with the heading.
    pub(super) heading: PositionOf<P>,
}

impl<T: Real, P: Pose<Scalar = T>> Difference<P> {
    /// The difference of two features; `None` if there is no feature with one of the indices.
    pub(super) fn of<Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>, [one, other]: [usize; 2]) -> Option<Self> {
        let difference = memory.landmarks.get(other)?.mean - memory.landmarks.get(one)?.mean;
        let (of_one, of_other) = (memory.joint.between(one, one), memory.joint.between(other, other));
        let (cross, both) = (memory.joint.between(one, other), of_one + of_other);
        let rounding = both * (T::EPSILON * T::from_f64(64.0));
        let straight: Linear<P::Position, P::Position> = Matrix::with(|row, column| {
            both.at(row, column) - cross.at(row, column) - cross.at(column, row) + rounding.at(row, column)
        });
        let across = across::<P>(&difference);
        let zero: P::Position = Zero::ZERO;
        let mut apart = Self { indices: [one, other], across: zero, difference, covariance: straight, heading: zero };
        if let Some(heading) = P::HEADING {
            let (with, variance) = (apart.with_row(&memory.joint, heading), memory.joint.get(heading, heading));
            apart.across = across;
            apart.heading = P::Position::with(|k| with.at(k) - across.at(k) * variance);
            apart.covariance = Matrix::with(|row, column| {
                straight.at(row, column) - with.at(row) * across.at(column) - across.at(row) * apart.heading.at(column)
            });
        }
        Some(apart)
    }

    /// The covariance of the difference with a coordinate of the pose or of a feature.
    pub(super) fn with_row(&self, joint: &Joint<'_, P>, row: usize) -> P::Position {
        let [one, other] = self.indices.map(first::<P>);
        let turned = P::HEADING.map_or(T::ZERO, |heading| joint.get(row, heading));
        P::Position::with(|k| joint.get(row, other + k) - joint.get(row, one + k) - turned * self.across.at(k))
    }

    /// The covariance of another difference (rows) with this one (columns).
    pub(super) fn with_other(&self, joint: &Joint<'_, P>, other: &Self) -> Linear<P::Position, P::Position> {
        let [from, to] = other.indices.map(first::<P>);
        let turned = P::HEADING.map_or(Zero::ZERO, |heading| self.with_row(joint, heading));
        let mut rows = <P::Position as Vector>::Array::<P::Position>::ZERO;
        for (k, row) in rows.as_mut().iter_mut().enumerate() {
            *row = self.with_row(joint, to + k) - self.with_row(joint, from + k) - turned * other.across.at(k);
        }
        Matrix::with(|row, column| rows.as_ref().get(row).map_or(T::ZERO, |row| row.at(column)))
    }

    /// Whether |δ|² is above this multiple of the trace of C. As |y| ≥ |δ| at any δθ, yᵀ C⁻¹ y is then above it too.
    pub(super) fn is_beyond(&self, squared: T) -> bool {
        let variances = (0..P::Position::DIMENSION).fold(T::ZERO, |sum, k| sum + self.covariance.at(k, k));
        // Written so that NaN is beyond.
        !(self.difference.dot(&self.difference) <= variances * squared)
    }

    /// The factor of C; `None` if it is not positive definite.
    pub(super) fn factor(&self) -> Option<Factor<P::Position>> {
        symmetric::<P::Position>(&self.covariance).factor()
    }
}

/// The equality constraint of two features with the difference δ.
pub(super) struct Fusion<D: Vector> {
    /// C⁻¹ y, with y = V(δθ)⁻¹ δ + δθ ê × δ.
    pub(super) step: D,
    /// yᵀ C⁻¹ y.
    pub(super) distance: D::Scalar,
    /// δθ: the correction of the heading.
    pub(super) turn: D::Scalar,
}

impl<T: Real, D: Vector<Scalar = T>> Fusion<D> {
    /// The constraint for a difference δ, the factor of its covariance C, and its covariance h with the heading.
    pub(super) fn of<P: Pose<Scalar = T, Position = D>>(difference: &D, factor: &Factor<D>, heading: &D) -> Self {
        let (gain, across) = (factor.solve(heading), across::<P>(difference));
        let (mut turn, mut off) = (T::ZERO, *difference);
        for _ in 0..ROUNDS {
            let before = turn;
            turn = -gain.dot(&off);
            if turn == before {
                break;
            }
            off = unbent(turn, difference) + across * turn;
        }
        let step = factor.solve(&off);
        Self { distance: step.dot(&off), step, turn }
    }

    /// The displacement V(δθ) e of the pose or of a feature, the coordinates of which start at `first`.
    pub(super) fn moves<P: Pose<Scalar = T, Position = D>, V: Vector<Scalar = T>>(
        &self,
        joint: &Joint<'_, P>,
        apart: &Difference<P>,
        first: usize,
    ) -> V {
        bent(self.turn, &V::with(|k| -apart.with_row(joint, first + k).dot(&self.step)))
    }
}

/// ê × δ, as a position; 0 without a heading.
fn across<P: Pose>(difference: &PositionOf<P>) -> PositionOf<P> {
    let lever = P::HEADING.map(|_| lever(difference.as_slice()));
    Vector::with(|k| lever.and_then(|lever| lever.get(k).copied()).unwrap_or(Zero::ZERO))
}

/// V(δθ) e.
fn bent<T: Real, V: Vector<Scalar = T>>(turn: T, by: &V) -> V {
    let (along, across) = mean_turn(turn);
    V::with(|k| match k {
        0 => along * by.at(0) - across * by.at(1),
        1 => across * by.at(0) + along * by.at(1),
        _ => by.at(k),
    })
}

/// V(δθ)⁻¹ e.
fn unbent<T: Real, V: Vector<Scalar = T>>(turn: T, by: &V) -> V {
    let (along, across) = mean_turn(turn);
    let square = along * along + across * across;
    V::with(|k| match k {
        0 => (along * by.at(0) + across * by.at(1)) / square,
        1 => (along * by.at(1) - across * by.at(0)) / square,
        _ => by.at(k),
    })
}

/// sin δθ/δθ and (1 − cos δθ)/δθ, with δθ limited to half a turn.
fn mean_turn<T: Real>(turn: T) -> (T, T) {
    let half = turn.at_most(T::PI).at_least(-T::PI) * T::from_f64(0.5);
    if half * half < T::EPSILON {
        return (T::ONE, half);
    }
    let (sine, cosine) = half.sin_cos();
    (sine * cosine / half, sine * sine / half)
}
