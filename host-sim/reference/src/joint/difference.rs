//! The difference of two features that are the same, and the correction that makes their positions equal.

use super::models::Models;
use super::state::State;
use nalgebra::{DMatrix, DVector};

/// Iterations for the rotation.
const ROUNDS: usize = 8;
/// Greatest rotation for which V is computed by the first two terms of its series, rad.
const SMALL_RAD: f64 = 1e-5;

/// The position of the second feature relative to the first.
pub(super) struct Difference {
    /// δ.
    pub(super) difference: DVector<f64>,
    /// H of e_b − e_a − δθ ê × δ with respect to all coordinates.
    pub(super) h: DMatrix<f64>,
    /// The coordinates on which it depends, the heading first.
    of: Vec<usize>,
}

/// The innovation of the constraint that makes the positions equal.
pub(super) struct Closed {
    /// y.
    pub(super) off: DVector<f64>,
    /// C.
    pub(super) covariance: DMatrix<f64>,
    /// yᵀ C⁻¹ y.
    pub(super) distance: f64,
    /// δθ.
    turn: f64,
}

impl Difference {
    pub(super) fn of<M: Models>(state: &State, one: usize, other: usize) -> Self {
        let difference = place_of(state, other) - place_of(state, one);
        let (mut h, heading) = (Self::straight::<M>(state, one, other), M::FEATURE);
        (h[(0, heading)], h[(1, heading)]) = (difference[1], -difference[0]);
        let coordinates = |place: usize| state.first(place)..state.first(place) + M::FEATURE;
        let of = std::iter::once(heading).chain(coordinates(one)).chain(coordinates(other)).collect();
        Self { difference, h, of }
    }

    /// H of e_b − e_a.
    pub(super) fn straight<M: Models>(state: &State, one: usize, other: usize) -> DMatrix<f64> {
        let mut h = DMatrix::zeros(M::FEATURE, state.covariance.nrows());
        for k in 0..M::FEATURE {
            h[(k, state.first(one) + k)] = -1.0;
            h[(k, state.first(other) + k)] = 1.0;
        }
        h
    }

    /// The innovation for this difference, with the covariance of all coordinates.
    pub(super) fn closed(&self, difference: &DVector<f64>, all: &DMatrix<f64>) -> Option<Closed> {
        let h = self.h.select_columns(&self.of);
        let common = &h * all.select_rows(&self.of).select_columns(&self.of);
        let covariance = &common * h.transpose();
        let inverse = covariance.clone().cholesky()?.inverse();
        let with_heading = common.column(0).clone_owned();
        let mut across = DVector::zeros(difference.len());
        (across[0], across[1]) = (-difference[1], difference[0]);
        let (mut off, mut turn) = (difference.clone(), 0.0);
        for _ in 0..ROUNDS {
            turn = -with_heading.dot(&(&inverse * &off));
            let back = mean_turn(turn, difference.len()).try_inverse()?;
            off = back * difference + turn * &across;
        }
        let distance = off.dot(&(inverse * &off));
        Some(Closed { off, covariance, distance, turn })
    }
}

impl Closed {
    /// The correction of all coordinates.
    pub(super) fn moved(&self, state: &State, apart: &Difference) -> DVector<f64> {
        let inverse = self.covariance.clone().try_inverse().expect("it was factored");
        let mut moved = -&state.covariance * apart.h.transpose() * inverse * &self.off;
        let by_turn = mean_turn(self.turn, 2);
        let firsts = (0..state.places.len()).map(|place| state.first(place));
        for first in std::iter::once(0).chain(firsts) {
            let on_ground = &by_turn * moved.rows(first, 2);
            moved.rows_mut(first, 2).copy_from(&on_ground);
        }
        moved
    }
}

/// V, the mean of the rotations about the vertical by all angles from zero to `turn`.
fn mean_turn(turn: f64, dimension: usize) -> DMatrix<f64> {
    let turn = turn.clamp(-std::f64::consts::PI, std::f64::consts::PI);
    let (along, across) = if turn.abs() < SMALL_RAD {
        (1.0 - turn * turn / 6.0, turn / 2.0)
    } else {
        (turn.sin() / turn, (1.0 - turn.cos()) / turn)
    };
    let mut mean = DMatrix::identity(dimension, dimension);
    (mean[(0, 0)], mean[(0, 1)], mean[(1, 0)], mean[(1, 1)]) = (along, -across, across, along);
    mean
}

pub(super) fn place_of(state: &State, place: usize) -> DVector<f64> {
    DVector::from_column_slice(&state.places[place])
}
