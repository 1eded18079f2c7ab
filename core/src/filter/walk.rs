//! Traversal of all data that influences later results, for digests and snapshots, and restoring it from a snapshot.

use crate::filter::state::Memory;
use crate::map::{Maps, PAGE_LEN, PageId};
use crate::particles::candidate::Candidate;
use crate::report::watch::Watch;
use crate::snapshot::read::Reader;
use crate::snapshot::visit::Visit;
use crate::snapshot::write::NEW_PAGE;
use crate::{Bounds, Component, Feature, Flaw, Noise, Pose, Real, RestoreError, Symmetric, Vector};

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Visits the state, with the covariances of poses if the proposal is `informed`.
    pub(crate) fn walk(&self, informed: bool, visit: &mut impl Visit) {
        self.walk_cursor(visit);
        for candidate in self.candidates() {
            visit.scalar(candidate.ln_weight);
            visit.pose(&candidate.pose);
            visit.remainder(&candidate.remainder);
        }
        if informed {
            for pose_covariance in self.pose_covariances.iter().take(self.cursor.particles) {
                pose_covariance.as_lower().iter().for_each(|&x| visit.scalar(x));
            }
        }
        for particle in 0..self.cursor.particles {
            self.static_maps.walk(particle, visit);
            self.moving_maps.walk(particle, visit);
        }
        self.waiting.walk(self.cursor.particles, visit);
    }

    /// Visits the small and vital data.
    pub(crate) fn walk_cursor(&self, visit: &mut impl Visit) {
        let cursor = &*self.cursor;
        for count in [cursor.particles, cursor.children, usize::from(cursor.predicted), cursor.heaviest] {
            visit.word(count as u32);
        }
        visit.word(cursor.next_label);
        visit.scalar(cursor.waited_s);
        visit.snapshot_word(u32::from(cursor.refused));
        cursor.watch.walk(visit);
        if let Some(noise) = &cursor.noise {
            let words = noise.bytes();
            words.as_chunks().0.iter().for_each(|&word| visit.word(u32::from_be_bytes(word)));
        }
    }

    /// Fills an empty state with what `walk` has written, in the same order. The caller must audit the result.
    ///
    /// # Errors
    /// The source fails, or its data is inconsistent: the state is then undefined.
    pub(crate) fn fill<S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(
        &mut self,
        informed: bool,
        has_moving: bool,
        has_waiting: bool,
        from: &mut Reader<'_, S, E>,
    ) -> Result<(), RestoreError<E>> {
        let [particles, children, predicted, heaviest] = core::array::from_fn(|_| from.word() as usize);
        let cursor = &mut *self.cursor;
        (cursor.particles, cursor.children, cursor.predicted, cursor.heaviest) =
            (particles, children, predicted != 0, heaviest);
        cursor.next_label = from.word();
        cursor.waited_s = from.scalar();
        cursor.refused = from.word().min(u32::from(u16::MAX)) as u16;
        cursor.watch = Watch::next(from);
        let mut stream = [0; 16];
        stream.as_chunks_mut().0.iter_mut().for_each(|word| *word = from.word().to_be_bytes());
        cursor.noise = Some(Noise::from_bytes(stream));
        for slot in self.candidates.iter_mut().take(cursor.candidates()) {
            *slot = Candidate {
                ln_weight: from.scalar(),
                pose: from.pose(),
                remainder: core::array::from_fn(|_| from.scalar()),
            };
        }
        for pose_covariance in self.pose_covariances.iter_mut().take(particles).filter(|_| informed) {
            *pose_covariance = Symmetric::from_fn(|_, _| from.scalar());
        }
        for particle in 0..particles.min(self.pose_covariances.len()) {
            from.so_far()?;
            self.static_maps.fill(true, particle, from)?;
            self.moving_maps.fill(has_moving, particle, from)?;
        }
        if has_waiting {
            self.waiting.fill(particles, from);
        }
        Ok(())
    }
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'_, F> {
    /// Visits one particle's map, component by component. A snapshot also stores its pages.
    fn walk(&self, particle: usize, visit: &mut impl Visit) {
        let pages = self.table.pages(particle);
        if !self.table.is_none() {
            visit.snapshot_word(pages.len() as u32);
            let (far, vicinity) = self.table.far(particle);
            visit.snapshot_word(far as u32);
            let corners = [vicinity.low, vicinity.high];
            corners.iter().flat_map(Vector::as_slice).for_each(|&x| visit.snapshot_scalar(x));
        }
        for &id in pages {
            let Some(page) = self.pool.get(id) else { continue };
            if visit.page(F::MOVES, id, page.components().len()) {
                page.components().iter().for_each(|component| walk_component(component, visit));
            }
        }
        visit.word(u32::MAX);
    }

    /// Restores a map, if there was one. Pages are allocated in the order of their first visit.
    fn fill<S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(
        &mut self,
        was_there: bool,
        particle: usize,
        from: &mut Reader<'_, S, E>,
    ) -> Result<(), RestoreError<E>> {
        let flawed = Err(RestoreError::Flawed(Flaw::Pages));
        if was_there {
            let (len, far) = (from.word() as usize, from.word() as usize);
            let vicinity = Bounds { low: from.vector(), high: from.vector() };
            if far > len || len > self.table.map_pages() {
                return flawed;
            }
            for _ in 0..len {
                let Some(id) = self.next_page(from) else { return flawed };
                // A map has each page at most once.
                if self.table.pages(particle).contains(&id) || !self.table.push(particle, id) {
                    return flawed;
                }
            }
            self.table.set_far(particle, far, vicinity);
        }
        if from.word() == u32::MAX { Ok(()) } else { flawed }
    }

    /// The next page of a map, with one more reference.
    fn next_page<S, E>(&mut self, from: &mut Reader<'_, S, E>) -> Option<PageId>
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        let word = from.word();
        if word & NEW_PAGE == 0 {
            let id = self.pool.taken(word)?;
            self.pool.share(id);
            return Some(id);
        }
        let components = (word & !NEW_PAGE) as usize;
        let (id, page) = self.pool.take()?;
        page.fill(core::iter::empty());
        if components > PAGE_LEN {
            return None;
        }
        for _ in 0..components {
            page.push(&next_component(from));
        }
        Some(id)
    }
}

fn walk_component<T: Real, N: Vector<Scalar = T>>(component: &Component<N>, visit: &mut impl Visit) {
    visit.word(component.label);
    visit.scalar(component.ln_weight);
    component.mean.as_slice().iter().for_each(|&x| visit.scalar(x));
    component.covariance.as_lower().iter().for_each(|&x| visit.scalar(x));
}

/// Restores a component.
fn next_component<T: Real, N: Vector<Scalar = T>, S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(
    from: &mut Reader<'_, S, E>,
) -> Component<N> {
    Component {
        label: from.word(),
        ln_weight: from.scalar(),
        mean: from.vector(),
        covariance: Symmetric::from_fn(|_, _| from.scalar()),
    }
}
