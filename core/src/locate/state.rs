//! The state of a locator, in memory of a fixed size.

use super::alignment::{Alignment, Landmark};
use super::views::Views;
use crate::{Component, Real, Zero};
use nalgebra::Vector2;

/// No landmark of the map.
pub(super) const NONE: u16 = 0;

/// A hypothesis of the alignment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hypothesis<T: Real> {
    pub(super) alignment: Alignment<T>,
    /// Logarithm of prior times likelihood, divided by the likelihood of "elsewhere".
    pub(super) ln_weight: T,
    /// Number of associated landmarks.
    pub(super) matched: usize,
}

/// Two landmarks that are compared with all pairs of the map, and the progress of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sweep<T: Real> {
    /// Whether there is such a pair.
    pub(super) under_way: bool,
    pub(super) pair: [Landmark<T>; 2],
    /// Index of the next ordered pair of the map.
    pub(super) next: usize,
    /// Index of the next pair of landmarks.
    pub(super) turn: usize,
    /// Number of pairs that have been compared with the whole map.
    pub(super) done: usize,
}

/// Memory of a [`Locator`](super::Locator): for maps of up to `FEATURES` landmarks, as many landmarks of the vehicle, and
/// `HYPOTHESES` pose hypotheses. All zero, and meant to be a `static`.
#[derive(Debug)]
pub struct LocatorState<T: Real, const FEATURES: usize, const HYPOTHESES: usize> {
    known: Known<T>,
    map: [Landmark<T>; FEATURES],
    seen: [Landmark<T>; FEATURES],
    pairs: [u16; FEATURES],
    taken: [bool; FEATURES],
    hypotheses: [Hypothesis<T>; HYPOTHESES],
}

/// The fields of fixed size.
#[derive(Debug)]
pub(super) struct Known<T: Real> {
    /// Number of landmarks of the map.
    pub(super) map: usize,
    /// Number of landmarks of the vehicle.
    pub(super) seen: usize,
    pub(super) hypotheses: usize,
    /// The centre of the map, m: its landmarks are stored relative to it.
    pub(super) middle: Vector2<T>,
    /// The area of its bounding box, m².
    pub(super) area: T,
    /// The area that the vehicle has observed since the start of the search, m².
    pub(super) observed_area: T,
    pub(super) views: Views<T>,
    pub(super) sweep: Sweep<T>,
}

/// A borrowed state of any capacity.
#[derive(Debug)]
pub(super) struct Memory<'s, T: Real> {
    pub(super) known: &'s mut Known<T>,
    pub(super) map: &'s mut [Landmark<T>],
    pub(super) seen: &'s mut [Landmark<T>],
    /// For each landmark of the vehicle, the index of its landmark of the map plus one, or [`NONE`].
    pub(super) pairs: &'s mut [u16],
    /// Which landmarks of the map are associated.
    pub(super) taken: &'s mut [bool],
    pub(super) hypotheses: &'s mut [Hypothesis<T>],
}

impl<T: Real, const FEATURES: usize, const HYPOTHESES: usize> LocatorState<T, FEATURES, HYPOTHESES> {
    /// A state without a map. Invalid capacities do not compile.
    pub const fn new() -> Self {
        const {
            assert!(FEATURES >= 3, "a pose is determined by three landmarks or more");
            assert!(FEATURES < u16::MAX as usize, "landmarks are counted in 16 bits");
            assert!(HYPOTHESES >= 2, "at least two hypotheses are needed, to find an alternative pose");
        }
        Self {
            known: Known {
                map: 0,
                seen: 0,
                hypotheses: 0,
                middle: Zero::ZERO,
                area: T::ZERO,
                observed_area: T::ZERO,
                views: Views::NONE,
                sweep: Sweep::NONE,
            },
            map: [Component::ZERO; FEATURES],
            seen: [Component::ZERO; FEATURES],
            pairs: [NONE; FEATURES],
            taken: [false; FEATURES],
            hypotheses: [Hypothesis::ZERO; HYPOTHESES],
        }
    }

    pub(super) fn memory(&mut self) -> Memory<'_, T> {
        Memory {
            known: &mut self.known,
            map: &mut self.map,
            seen: &mut self.seen,
            pairs: &mut self.pairs,
            taken: &mut self.taken,
            hypotheses: &mut self.hypotheses,
        }
    }
}

impl<T: Real> Hypothesis<T> {
    pub(super) const ZERO: Self = Self { alignment: Alignment::ZERO, ln_weight: T::ZERO, matched: 0 };
}

impl<T: Real> Sweep<T> {
    pub(super) const NONE: Self = Self { under_way: false, pair: [Component::ZERO; 2], next: 0, turn: 0, done: 0 };
}

impl<T: Real> Memory<'_, T> {
    pub(super) fn map(&self) -> &[Landmark<T>] {
        self.map.get(..self.known.map).unwrap_or(&[])
    }

    pub(super) fn seen(&self) -> &[Landmark<T>] {
        self.seen.get(..self.known.seen).unwrap_or(&[])
    }

    pub(super) fn hypotheses(&self) -> &[Hypothesis<T>] {
        self.hypotheses.get(..self.known.hypotheses).unwrap_or(&[])
    }

    /// The associated pairs.
    pub(super) fn paired(&self) -> impl Iterator<Item = (&Landmark<T>, &Landmark<T>)> {
        let map = self.map();
        self.seen().iter().zip(self.pairs.iter()).filter_map(move |(seen, &pair)| {
            let place = usize::from(pair).checked_sub(1)?;
            Some((seen, map.get(place)?))
        })
    }
}
