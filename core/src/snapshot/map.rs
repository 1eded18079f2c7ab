//! A map as bytes, which a vehicle stores for its next drive.

use super::frame::{Content, Head, Shape};
use super::read::{Reader, checked};
use super::visit::{Visit, Walk};
use super::write::write;
use super::{RestoreError, SaveError};
use crate::{Component, Flaw, Real, Symmetric, Vector};

/// Properties that all maps of this type of features have in common.
fn shape<D: Vector>(kind: u32) -> Shape {
    let dimensions = [0, D::DIMENSION as u8, 0];
    Shape { content: Content::Map, scalar: size_of::<D::Scalar>() as u8, dimensions, kind }
}

/// Writes a map from [`JointSlam::features`](crate::JointSlam::features) or [`ScPhd::estimate_map`](crate::ScPhd::estimate_map) in
/// the format of a [snapshot](crate::ScPhd::save). `kind` identifies the area or the type of vehicle. Returns the number of bytes.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::numerics::Symmetric;
/// use scphd::snapshot::{from_slice, into_slice, restore_map, save_map};
/// use scphd::Component;
///
/// let post = Component {
///     mean: Vector2::new(4.0_f32, 1.0),
///     covariance: Symmetric::from_diagonal([0.01, 0.01]),
///     ..Component::ZERO
/// };
/// let mut bytes = [0; 256];
/// let len = save_map(7, [post].into_iter(), into_slice(&mut bytes))?;
/// let mut map = [Component::<Vector2<f32>>::ZERO; 40];
/// assert_eq!(restore_map(7, &mut map, from_slice(&bytes[..len]))?, 1);
/// assert_eq!(map[0], post);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A feature is not finite, its covariance is not positive definite, or the sink returns an error.
pub fn save_map<T: Real, D: Vector<Scalar = T>, E>(
    kind: u32,
    features: impl Iterator<Item = Component<D>> + Clone,
    sink: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<usize, SaveError<E>> {
    if !features.clone().all(|feature| feature.is_usable()) {
        return Err(SaveError::Damaged(Flaw::Component));
    }
    let count = u32::try_from(features.clone().count()).unwrap_or(u32::MAX);
    let head = Head { shape: shape::<D>(kind), flags: 0, len: 0, sizes: [count, 0, 0] };
    write(head, &Features(features), [&mut [], &mut []], sink)
}

/// Reads a map that [`save_map`] wrote. Returns the number of features.
///
/// # Errors
/// The bytes are not a map of this kind, they are damaged, or the map has more features than fit: then `features` is unchanged. If
/// the source returns other bytes in the second pass, or the bytes have correct checksums but are not a map, the content of
/// `features` is undefined.
pub fn restore_map<T: Real, D: Vector<Scalar = T>, E>(
    kind: u32,
    features: &mut [Component<D>],
    mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
) -> Result<usize, RestoreError<E>> {
    let head = checked(&mut source, shape::<D>(kind))?;
    let [count, ..] = head.sizes.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
    RestoreError::check_room("features", count, features.len())?;
    let mut reader = Reader::behind(&head, &mut source);
    let mut sound = true;
    for slot in features.iter_mut().take(count) {
        let (label, ln_weight) = (reader.word(), reader.scalar());
        let mean = reader.vector();
        *slot = Component { label, ln_weight, mean, covariance: Symmetric::from_fn(|_, _| reader.scalar()) };
        sound &= slot.is_usable();
    }
    reader.end()?;
    if sound { Ok(count) } else { Err(RestoreError::Flawed(Flaw::Component)) }
}

/// Writes label, ln w, mean and the lower triangle of the covariance of each feature.
struct Features<I>(I);

impl<T: Real, D: Vector<Scalar = T>, I: Iterator<Item = Component<D>> + Clone> Walk for Features<I> {
    fn walk(&self, visit: &mut impl Visit) {
        for feature in self.0.clone() {
            visit.word(feature.label);
            visit.scalar(feature.ln_weight);
            feature.mean.as_slice().iter().for_each(|&number| visit.scalar(number));
            feature.covariance.as_lower().iter().for_each(|&number| visit.scalar(number));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::*;
    use nalgebra::Vector2;

    fn post(x: f64, y: f64) -> Component<Vector2<f64>> {
        let covariance = Symmetric::from_fn(|row, column| if row == column { 0.25 } else { 0.125 });
        Component { label: 5, ln_weight: -0.5, mean: Vector2::new(x, y), covariance }
    }

    #[test]
    fn every_changed_bit_of_a_map_is_detected() {
        let map = [post(1.0, -2.0), post(7.0, 4.5)];
        let mut bytes = [0; 256];
        let len = save_map(3, map.into_iter(), into_slice(&mut bytes)).unwrap();
        // Head and checksum, then label, weight, mean and three numbers of each feature, then the checksum of the whole.
        assert_eq!(len, 36 + 2 * (4 + 8 + 16 + 24) + 4);
        let mut read = [Component::ZERO; 3];
        assert_eq!(restore_map(3, &mut read, from_slice(&bytes[..len])), Ok(2));
        assert_eq!(read[..2], map);
        for bit in 0..8 * len {
            let mut damaged = bytes;
            damaged[bit / 8] ^= 1 << (bit % 8);
            let mut none = [Component::<Vector2<f64>>::ZERO; 3];
            assert!(restore_map(3, &mut none, from_slice(&damaged[..len])).is_err(), "bit {bit}");
            assert_eq!(none, [Component::ZERO; 3]);
        }
    }

    #[test]
    fn other_content_is_refused() {
        let mut bytes = [0; 256];
        let len = save_map(3, [post(1.0, 2.0), post(3.0, 4.0)].into_iter(), into_slice(&mut bytes)).unwrap();
        let read = |kind, room: &mut [Component<Vector2<f64>>]| restore_map(kind, room, from_slice(&bytes[..len]));
        assert_eq!(read(4, &mut [Component::ZERO; 2]), Err(RestoreError::Kind { found: 3 }));
        let no_room = RestoreError::NoRoom { what: "features", needed: 2, capacity: 1 };
        assert_eq!(read(3, &mut [Component::ZERO; 1]), Err(no_room));
        let single = restore_map(3, &mut [Component::<Vector2<f32>>::ZERO; 2], from_slice(&bytes[..len]));
        assert_eq!(single, Err(RestoreError::Content));
        let flat = Component { covariance: Symmetric::ZERO, ..post(0.0, 0.0) };
        let saved = save_map(3, [flat].into_iter(), into_slice(&mut bytes));
        assert_eq!(saved, Err(SaveError::Damaged(Flaw::Component)));
    }
}
