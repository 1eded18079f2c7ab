//! Archiving of distant landmarks: they leave the window for the archive in submaps (pages).

use super::archive::{ANCHORS, Anchor, ArchiveView, Entry, PAGE, Split};
use super::conditioning::Conditioning;
use super::covariance::{Joint, first};
use super::map_management::TENTATIVE;
use super::state::{Landmark, Memory};
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// Only what is farther off than this many times the vehicle sees may go.
const BEYOND: f64 = 1.25;

/// A window has room for one anchor in so many features.
const WINDOW_PER_ANCHOR: usize = 3;

/// Free places of the window below which anchors go.
const SPARE: usize = 2;

/// Anchors within reach of a page that are enough.
const NEAR_ANCHORS: usize = 4;

/// What archiving did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Archiving {
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
pub(super) fn archive_distant<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &mut ArchiveView<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) -> Archiving {
    let mut parked = Archiving::default();
    let window = memory.landmarks.len();
    let page = page_len(window);
    let little = |memory: &Memory<'_, P, Z>| window - memory.known.len.min(window) < 2 * page;
    let beyond_m = view.reach_m * T::from_f64(BEYOND);
    let [x, y, _] = memory.known.pose.on_ground();
    let beyond = |slot: &Landmark<P::Position>| squared_m([x, y], &slot.mean) > beyond_m * beyond_m;
    if !little(memory) {
        return parked;
    }
    for place in (0..memory.known.len).rev() {
        let Some(slot) = memory.landmarks.get(place) else { continue };
        if slot.detections < T::from_f64(TENTATIVE) && !slot.is_anchor && beyond(slot) {
            memory.drop_feature(place);
            parked.dropped += 1;
        }
    }
    for _ in 0..2 {
        if !little(memory) {
            break;
        }
        let far = |slot: &Landmark<P::Position>| squared_m([x, y], &slot.mean);
        // Where nothing else may go, anchors go.
        let others = memory.landmarks.iter().take(memory.known.len).any(|slot| beyond(slot) && !slot.is_anchor);
        if !others && window - memory.known.len.min(window) >= SPARE {
            break;
        }
        let is_free = |slot: &Landmark<P::Position>| beyond(slot) && !(others && slot.is_anchor);
        let Some(seed) = most(memory, |_, slot| is_free(slot).then(|| far(slot))) else { break };
        let Some(mean) = memory.landmarks.get(seed).map(|slot| slot.mean) else { break };
        let around = [mean.at(0), mean.at(1)];
        let within = |slot: &Landmark<P::Position>| {
            let squared = squared_m(around, &slot.mean);
            (squared < view.reach_m * view.reach_m).then_some(-squared)
        };
        if let Some(slot) = memory.landmarks.get_mut(seed) {
            slot.is_anchor = false;
        }
        let anchors =
            anchors(memory, seed, within, |slot| squared_m(around, &slot.mean), view.reach_m * T::from_f64(3.0));
        let mut members = [seed; PAGE];
        let mut count = 1;
        for _ in 1..page {
            let chosen = members.get(..count).unwrap_or(&[]);
            let near = |place: usize, slot: &Landmark<P::Position>| {
                let other = is_free(slot) && !chosen.contains(&place) && !anchors.places().contains(&place);
                within(slot).filter(|_| other)
            };
            let Some(place) = most(memory, near) else { break };
            if let Some(slot) = members.get_mut(count) {
                *slot = place;
            }
            count += 1;
        }
        let members = members.get_mut(..count).unwrap_or(&mut []);
        let name = view.index.next_page;
        view.index.next_page = name.wrapping_add(1);
        let page = Leaving::of(memory, seed, anchors.places());
        members.iter().for_each(|&place| page.put(view, memory, place, name, &mut parked));
        members.sort_unstable();
        members.iter().rev().for_each(|&place| memory.drop_feature(place));
    }
    parked
}

/// Places of the window.
struct Chosen {
    places: [usize; ANCHORS],
    len: usize,
}

impl Chosen {
    fn places(&self) -> &[usize] {
        self.places.get(..self.len).unwrap_or(&[])
    }

    fn add(&mut self, place: usize) {
        if let Some(slot) = self.places.get_mut(self.len) {
            *slot = place;
            self.len += 1;
        }
    }
}

/// The anchors of a page around a feature: those that there are nearest to it. Where few are within reach, as long as the window has room for more,
/// what is known best there becomes one.
fn anchors<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
    seed: usize,
    within: impl Fn(&Landmark<P::Position>) -> Option<T>,
    distance: impl Fn(&Landmark<P::Position>) -> T,
    far: T,
) -> Chosen {
    let known = || memory.landmarks.iter().take(memory.known.len);
    let room =
        (memory.landmarks.len() / WINDOW_PER_ANCHOR).saturating_sub(known().filter(|slot| slot.is_anchor).count());
    let near = known().filter(|slot| slot.is_anchor && within(slot).is_some()).count();
    for _ in 0..NEAR_ANCHORS.saturating_sub(near).min(room) {
        let place = most(memory, |place, slot| {
            let other = place != seed && !slot.is_anchor && slot.existence.total() >= T::from_f64(0.5);
            within(slot).filter(|_| other && slot.detections >= T::from_f64(TENTATIVE)).map(|_| slot.detections)
        });
        let Some(slot) = place.and_then(|place| memory.landmarks.get_mut(place)) else { break };
        slot.is_anchor = true;
    }
    let mut chosen = Chosen { places: [0; ANCHORS], len: 0 };
    for _ in 0..ANCHORS {
        let other = |place: usize, slot: &Landmark<P::Position>| slot.is_anchor && !chosen.places().contains(&place);
        let place = most(memory, |place, slot| other(place, slot).then(|| -distance(slot)));
        let Some(place) = place else { break };
        let is_near = memory.landmarks.get(place).is_some_and(|slot| distance(slot) <= far * far);
        if chosen.len == 0 && !is_near {
            break;
        }
        chosen.add(place);
    }
    chosen
}

/// Marks the features of the window that pages are conditioned on.
pub(super) fn mark_anchors<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &ArchiveView<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) {
    let landmarks = memory.landmarks.get_mut(..memory.known.len).unwrap_or(&mut []);
    landmarks.iter_mut().for_each(|slot| slot.is_anchor = false);
    let mut last = None;
    for entry in view.entries.iter().take(view.index.len) {
        // The features of a page have the same anchors, and mostly follow each other.
        if last.replace(entry.page) == Some(entry.page) {
            continue;
        }
        for anchor in entry.anchors() {
            let of = landmarks.iter_mut().filter(|slot| slot.label == anchor.label);
            of.for_each(|slot| slot.is_anchor = true);
        }
    }
}

/// The feature with the most of something.
fn most<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &Memory<'_, P, Z>,
    of: impl Fn(usize, &Landmark<P::Position>) -> Option<T>,
) -> Option<usize> {
    let mut best = None;
    for (place, slot) in memory.landmarks.iter().take(memory.known.len).enumerate() {
        if let Some(value) = of(place, slot)
            && best.is_none_or(|(_, known)| value > known)
        {
            best = Some((place, value));
        }
    }
    best.map(|(place, _)| place)
}

/// A page that leaves the window.
struct Leaving<P: Pose> {
    anchors: [Anchor<P>; ANCHORS],
    anchored: usize,
    given: Common<P>,
    alone: Common<P>,
}

/// What a page has in common: its seed's position and the heading, given some features.
struct Common<P: Pose> {
    given: Conditioning<P>,
    seed: usize,
    /// A root of their covariance.
    root: Linear<TangentOf<P>, TangentOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Common<P> {
    fn of(joint: &Joint<'_, P>, seed: usize, places: &[usize]) -> Self {
        let given = Conditioning::on(joint, places);
        let own = |row, column| given.covariance(joint, Self::row(seed, row), Self::row(seed, column));
        let root = Symmetric::<TangentOf<P>>::from_fn(own).root();
        Self { given, seed, root }
    }

    /// The rows of the joint covariance that make it up.
    fn row(seed: usize, k: usize) -> usize {
        if k < P::Position::DIMENSION { first::<P>(seed) + k } else { k }
    }

    /// The covariance of a feature; `None` where rounding has spoilt it.
    fn split(&self, joint: &Joint<'_, P>, place: usize) -> Option<Split<P>> {
        let (given, at) = (&self.given, first::<P>(place));
        let mut rows = <PositionOf<P> as Vector>::Array::<TangentOf<P>>::ZERO;
        for (d, row) in rows.as_mut().iter_mut().enumerate() {
            let with = TangentOf::<P>::with(|k| given.covariance(joint, at + d, Self::row(self.seed, k)));
            *row = whitened::<T, TangentOf<P>>(&self.root, &with);
        }
        let common: Linear<PositionOf<P>, TangentOf<P>> =
            Matrix::with(|d, k| rows.as_ref().get(d).map_or(T::ZERO, |row| row.at(k)));
        let rounding = T::EPSILON * T::from_f64(64.0);
        let own = Symmetric::<PositionOf<P>>::from_fn(|row, column| {
            let shared =
                (0..TangentOf::<P>::DIMENSION).fold(T::ZERO, |sum, k| sum + common.at(row, k) * common.at(column, k));
            let least = if row == column { joint.get(at + row, at + row) * rounding } else { T::ZERO };
            given.covariance(joint, at + row, at + column) - shared + least
        });
        let (own, _) = own.kept_positive_definite()?;
        Some(Split { common, own })
    }
}

impl<T: Real, P: Pose<Scalar = T>> Leaving<P> {
    fn of<Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>, seed: usize, places: &[usize]) -> Self {
        let mut anchors = Entry::<P>::ZERO.anchors;
        let of_places = places.iter().filter_map(|&place| memory.landmarks.get(place));
        let of_places = anchors.iter_mut().zip(of_places).map(|(anchor, slot)| {
            (anchor.label, anchor.mean) = (slot.label, slot.mean);
        });
        let anchored = of_places.count();
        let [given, alone] = [places, &[]].map(|places| Common::of(&memory.joint, seed, places));
        Self { anchors, anchored, given, alone }
    }

    /// Puts one of its features into the archive.
    fn put<Z: Vector<Scalar = T>>(
        &self,
        view: &mut ArchiveView<'_, P>,
        memory: &Memory<'_, P, Z>,
        place: usize,
        page: u32,
        parked: &mut Archiving,
    ) {
        let joint = &memory.joint;
        let Some(slot) = memory.landmarks.get(place).copied() else { return };
        let (Some(given), Some(alone)) = (self.given.split(joint, place), self.alone.split(joint, place)) else {
            parked.spoilt += 1;
            return;
        };
        let mut anchors = self.anchors;
        self.given.given.fill(joint, place, anchors.get_mut(..self.anchored).unwrap_or(&mut []));
        let Landmark { label, mean, existence, detections, .. } = slot;
        let (since_us, anchored) = (view.index.clock_us, self.anchored);
        let entry = Entry { label, page, mean, alone, anchored, anchors, given, existence, detections, since_us };
        parked.forgotten += view.put(entry);
        parked.parked += 1;
    }
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
