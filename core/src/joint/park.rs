//! What the vehicle has left behind leaves the window for the archive.

use super::archive::{Entry, PAGE, Shelf};
use super::covariance::{first, symmetric};
use super::state::{Memory, Slot};
use super::tidy::TENTATIVE;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// Only what is farther off than this many times the vehicle sees may go.
const BEYOND: f64 = 1.25;

/// What parking did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Parked {
    /// Features that went into the archive.
    pub(super) parked: usize,
    /// Features that the archive has no room for: those, or others in their place.
    pub(super) forgotten: usize,
    /// Features that were hardly there and far away.
    pub(super) dropped: usize,
    /// Features whose covariance rounding had spoilt.
    pub(super) spoilt: usize,
}

/// Features of a page in a window of so many: a page and as many births must find room at once.
pub(super) fn page_len(window: usize) -> usize {
    PAGE.min(window / 5)
}

/// How far from there a feature is on the ground, squared, m².
pub(super) fn squared_m<T: Real, D: Vector<Scalar = T>>(from: [T; 2], mean: &D) -> T {
    let [x, y] = from;
    let (dx, dy) = (mean.at(0) - x, mean.at(1) - y);
    dx * dx + dy * dy
}

/// Makes room where there is little: first of what was seen once and is far away, then by pages of what is farthest.
pub(super) fn park<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    shelf: &mut Shelf<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) -> Parked {
    let mut parked = Parked::default();
    let window = memory.slots.len();
    let page = page_len(window);
    let little = |memory: &Memory<'_, P, Z>| window - memory.known.len.min(window) < 2 * page;
    let beyond_m = shelf.reach_m * T::from_f64(BEYOND);
    let [x, y, _] = memory.known.pose.on_ground();
    let beyond = |slot: &Slot<P::Position>| squared_m([x, y], &slot.mean) > beyond_m * beyond_m;
    if !little(memory) {
        return parked;
    }
    for place in (0..memory.known.len).rev() {
        let Some(slot) = memory.slots.get(place) else { continue };
        if slot.detections < T::from_f64(TENTATIVE) && beyond(slot) {
            memory.drop_feature(place);
            parked.dropped += 1;
        }
    }
    for _ in 0..2 {
        if !little(memory) {
            break;
        }
        let far = |slot: &Slot<P::Position>| squared_m([x, y], &slot.mean);
        let Some(mut seed) = most(memory, |slot| beyond(slot).then(|| far(slot))) else { break };
        let Some(mean) = memory.slots.get(seed).map(|slot| slot.mean) else { break };
        let frame = Frame::of(memory, seed);
        let name = shelf.index.next_page;
        shelf.index.next_page = name.wrapping_add(1);
        let around = [mean.at(0), mean.at(1)];
        for _ in 1..page {
            let near = |slot: &Slot<P::Position>| {
                let squared = squared_m(around, &slot.mean);
                let other = slot.label != memory.slots.get(seed).map_or(0, |seed| seed.label);
                (other && beyond(slot) && squared < shelf.reach_m * shelf.reach_m).then_some(-squared)
            };
            let Some(place) = most(memory, near) else { break };
            put(shelf, memory, place, &frame, seed, name, &mut parked);
            if seed == memory.known.len {
                seed = place;
            }
        }
        put(shelf, memory, seed, &frame, seed, name, &mut parked);
    }
    parked
}

/// The feature with the most of something.
fn most<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &Memory<'_, P, Z>,
    of: impl Fn(&Slot<P::Position>) -> Option<T>,
) -> Option<usize> {
    let mut best = None;
    for (place, slot) in memory.slots.iter().take(memory.known.len).enumerate() {
        if let Some(value) = of(slot)
            && best.is_none_or(|(_, known)| value > known)
        {
            best = Some((place, value));
        }
    }
    best.map(|(place, _)| place)
}

/// What a page has in common.
struct Frame<P: Pose> {
    /// A root of its covariance.
    root: Linear<TangentOf<P>, TangentOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Frame<P> {
    /// The rows of the joint covariance that make it up.
    fn row(seed: usize, k: usize) -> usize {
        if k < P::Position::DIMENSION { first::<P>(seed) + k } else { k }
    }

    fn of<Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>, seed: usize) -> Self {
        let own = |row, column| memory.joint.get(Self::row(seed, row), Self::row(seed, column));
        Self { root: Symmetric::<TangentOf<P>>::from_fn(own).root() }
    }
}

/// Puts a feature into the archive.
fn put<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    shelf: &mut Shelf<'_, P>,
    memory: &mut Memory<'_, P, Z>,
    place: usize,
    frame: &Frame<P>,
    seed: usize,
    page: u32,
    parked: &mut Parked,
) {
    let Some(slot) = memory.slots.get(place).copied() else { return };
    let at = first::<P>(place);
    let mut rows = <PositionOf<P> as Vector>::Array::<TangentOf<P>>::ZERO;
    for (d, row) in rows.as_mut().iter_mut().enumerate() {
        let with = TangentOf::<P>::with(|k| memory.joint.get(at + d, Frame::<P>::row(seed, k)));
        *row = whitened::<T, TangentOf<P>>(&frame.root, &with);
    }
    let common: Linear<PositionOf<P>, TangentOf<P>> =
        Matrix::with(|d, k| rows.as_ref().get(d).map_or(T::ZERO, |row| row.at(k)));
    let full = memory.joint.between(place, place);
    let rounding = T::EPSILON * T::from_f64(64.0);
    let own: Linear<PositionOf<P>, PositionOf<P>> = Matrix::with(|row, column| {
        let shared =
            (0..TangentOf::<P>::DIMENSION).fold(T::ZERO, |sum, k| sum + common.at(row, k) * common.at(column, k));
        full.at(row, column) - shared + if row == column { full.at(row, row) * rounding } else { T::ZERO }
    });
    memory.drop_feature(place);
    let sound = symmetric::<PositionOf<P>>(&own).kept_positive_definite();
    let Some((own, _)) = sound else {
        parked.spoilt += 1;
        return;
    };
    let Slot { label, mean, existence, detections, .. } = slot;
    let since_us = shelf.index.clock_us;
    parked.forgotten += shelf.put(Entry { label, page, mean, common, own, existence, detections, since_us });
    parked.parked += 1;
}

/// L⁻¹ v for a [root](Symmetric::root), whose columns of zeros give zero.
pub(super) fn whitened<T: Real, V: Vector<Scalar = T>>(root: &Linear<V, V>, v: &V) -> V {
    let mut y = V::ZERO;
    for k in 0..V::DIMENSION {
        let rest = (0..k).fold(v.at(k), |rest, j| rest - root.at(k, j) * y.at(j));
        if let Some(slot) = y.as_mut_slice().get_mut(k)
            && root.at(k, k) > T::ZERO
        {
            *slot = rest / root.at(k, k);
        }
    }
    y
}
