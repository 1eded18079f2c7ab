//! What the filters of a black box share.

use crate::kind::Kind;
use crate::onboard::{Filter, Refusal};
use crate::record::Place;
use crate::writer::Writer;
use scphd::models::{Pose, TangentOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::snapshot::{RestoreError, SaveError};
use scphd::{Component, Real};

/// Type id of the snapshots of this crate's filters; readers accept any.
pub(crate) const KIND: u32 = 0;

/// A filter of a black box on the host, which also writes snapshots.
pub trait Saves<K: Kind>: Filter<K> {
    /// Writes a snapshot of the present state.
    ///
    /// # Errors
    /// The error of the sink, or the state is damaged.
    fn save<E, F: FnMut(&[u8]) -> Result<(), E>>(&mut self, log: &mut Writer<K, F>) -> Result<(), SaveError<E>>;
}

/// Pose, covariance and seed of a record.
pub(crate) fn placed<K: Kind, T: Real, P: Pose<Scalar = T>>(place: &Place<'_, K>) -> (P, Symmetric<TangentOf<P>>, u64) {
    let (full, lower, seed) = place.get();
    let mut numbers = full.as_ref().iter();
    let pose = P::of_numbers(|| numbers.next().map_or(T::ZERO, |&number| T::from_f64(number)));
    let covariance = Symmetric::from_fn(|row, column| {
        let (row, column) = (row.max(column), row.min(column));
        lower.as_ref().get(row * (row + 1) / 2 + column).map_or(T::ZERO, |&number| T::from_f64(number))
    });
    (pose, covariance, seed)
}

/// Copies the features of a map into `slots`. Returns their number.
pub(crate) fn loaded<T: Real, D: Vector<Scalar = T>, N: AsRef<[f64]>>(
    features: impl ExactSizeIterator<Item = N>,
    slots: &mut [Component<D>],
) -> Result<usize, Refusal> {
    let count = features.len();
    if count > slots.len() {
        let (components, capacity) = (count, slots.len());
        return Err(Refusal::Map(scphd::errors::LoadMapError::TooManyComponents { components, capacity }));
    }
    for (slot, feature) in slots.iter_mut().zip(features) {
        let mut numbers = feature.as_ref().iter();
        let mut next = || numbers.next().copied().unwrap_or(0.0);
        let label = next() as u32;
        let mut real = || T::from_f64(next());
        let (ln_weight, mean) = (real(), D::with(|_| real()));
        *slot = Component { label, ln_weight, mean, covariance: Symmetric::from_fn(|_, _| real()) };
    }
    Ok(count)
}

/// The reason for which a filter cannot be restored from a snapshot.
pub(crate) fn unrestored<E>(error: RestoreError<E>) -> Refusal {
    let why = match error {
        RestoreError::Source(_) => "a slice of the snapshot is missing or damaged",
        RestoreError::Foreign => "this is not a snapshot",
        RestoreError::Version { .. } => "the snapshot has another format version",
        RestoreError::Damaged => "the snapshot is damaged",
        RestoreError::Content => "the snapshot is of another filter, scalar, pose or measurement",
        RestoreError::Kind { .. } => "the snapshot is of another type of vehicle",
        RestoreError::NoRoom { .. } => "the snapshot does not fit the memory",
        RestoreError::Setup(_) => "the snapshot does not fit the tuning",
        RestoreError::Flawed(_) => "the snapshot is not a valid state",
        _ => "the snapshot cannot be used",
    };
    Refusal::Unusable { why }
}
