//! The kinds of features: static and moving.

use crate::{Place, Vector};
use core::fmt::Debug;
use core::marker::PhantomData;

mod sealed {
    pub trait Sealed {}
}

/// A kind of features: [`Static`] or [`Dynamic`].
pub trait Feature: sealed::Sealed + Debug {
    /// Position of a feature.
    type Position: Place;
    /// Estimated state of a feature.
    type State: Vector<Scalar = <Self::Position as Vector>::Scalar>;

    /// Whether features of this kind move between scans.
    const MOVES: bool;
}

/// Static features with positions `D`, for example `Vector2<f32>`: their state is the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static<D>(PhantomData<D>);

/// Moving features with positions `D`: their state is position and velocity (5.19).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dynamic<D>(PhantomData<D>);

impl<D> sealed::Sealed for Static<D> {}
impl<D> sealed::Sealed for Dynamic<D> {}

impl<D: Place> Feature for Static<D> {
    type Position = D;
    type State = D;

    const MOVES: bool = false;
}

impl<D: Place> Feature for Dynamic<D> {
    type Position = D;
    type State = D::Moving;

    const MOVES: bool = true;
}
