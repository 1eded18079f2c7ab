//! The stages that update the maps of the survivors and allocate their pages. Sums are computed in parts, and one thread adds the
//! parts up. Lent data is either written by the single thread at its place, or only read.

use super::group::{Group, part, whole};
use super::room::{Between, Claimed, DraftOf, Kind, Lending, Listed, Many};
use crate::launches::{LANES, WEIGHT, page_parts, pages_together};
use crate::memory::Particles;
use core::mem::MaybeUninit;
use core::ops::Range;
use core::ptr;
use core::sync::atomic::Ordering;
use scphd::storage::{COUNTS, Feature, PART, Page, PageId, Placed};

/// Safety: maps are only read; each draft, sight and number belongs to one place.
pub(super) unsafe fn make<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.drafts) else { return };
    let draft = group.draft(place);
    between.scanning.make(draft, &mut *group.sights.add(place));
    between.scanning.line_up(draft);
    let [_, copies] = draft.particles();
    let (kept, kept_moving) = draft.kept();
    let moving = kept_moving.iter().map(|id| M::PAGES[0] + id.index());
    for page in kept.iter().map(|id| id.index()).chain(moving) {
        if page < M::ALL_PAGES {
            (*group.held.add(page)).fetch_add(copies as u32, Ordering::Relaxed);
        }
    }
    for (column, term) in draft.terms().into_iter().enumerate() {
        *group.columns.add(column * group.stride + place) = term;
    }
    let (counts, in_view) = draft.counts();
    let (sums, most) = between.counts.split_at(COUNTS);
    for (sum, count) in sums.iter().zip(counts).filter(|(_, count)| *count > 0) {
        sum.fetch_add(count as u32, Ordering::Relaxed);
    }
    let pages = draft.map_pages().into_iter().zip(draft.pages()).map(|(kept, [taken, _])| kept + taken);
    for (most, count) in most.iter().zip(in_view.into_iter().chain(pages)) {
        most.fetch_max(count as u32, Ordering::Relaxed);
    }
}

/// Safety: drafts are only read, and only this thread uses the sums of the part.
pub(super) unsafe fn claim<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let mut sum = Claimed::default();
    for number in part(place, between.drafts).unwrap_or(0..0) {
        let draft = group.draft(number);
        if !draft.is_ready() {
            between.crowded.store(1, Ordering::Relaxed);
        }
        sum.add(draft);
    }
    (*group.parts.add(place)).claimed = sum;
}

impl Claimed {
    fn add(&mut self, draft: &DraftOf) {
        let [[pages, regained], [moving, moving_regained]] = draft.pages();
        self.plus(Self {
            labels: draft.labels(),
            pages: [pages as u32, moving as u32],
            regained: [regained as u32, moving_regained as u32],
        });
    }

    fn plus(&mut self, other: Self) {
        self.labels = self.labels.wrapping_add(other.labels);
        let pairs = self.pages.iter_mut().chain(&mut self.regained).zip(other.pages.iter().chain(&other.regained));
        pairs.for_each(|(sum, other)| *sum = sum.saturating_add(*other));
    }
}

/// Indices of the pages of a part, counted from the first static one, and whether they are pages of moving features.
fn pages_of_part<M: Particles>(place: usize) -> (Range<usize>, bool) {
    let [of_static, _] = page_parts(M::PAGES);
    let is_moving = place >= of_static;
    let (first, end, part) =
        if is_moving { (M::PAGES[0], M::ALL_PAGES, place - of_static) } else { (0, M::PAGES[0], place) };
    let at = |part: usize| end.min(first + part * pages_together(end - first));
    (at(part)..at(part + 1), is_moving)
}

/// Safety: counts are only read, and only this thread uses the sum of the part.
pub(super) unsafe fn unheld<M: Particles>(place: usize, group: &Group<'_, M>) {
    if group.between().is_some() {
        let (pages, _) = pages_of_part::<M>(place);
        let free = pages.filter(|&page| (*group.held.add(page)).load(Ordering::Relaxed) == 0).count();
        *group.firsts.add(place) = free as u32;
    }
}

/// Safety: no other thread runs.
pub(super) unsafe fn add_up<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let mut sum = Claimed::default();
    for part in 0..between.drafts.div_ceil(PART) {
        let part = &mut *group.parts.add(part);
        let own = core::mem::replace(&mut part.claimed, sum);
        sum.plus(own);
    }
    between.labels = sum.labels;
    between.wanted = sum.pages.map(whole);
    let mut first = 0;
    for (parts, free) in page_parts(M::PAGES).into_iter().zip(&mut between.free) {
        let mut before = 0;
        for part in first..first + parts {
            let of_part = &mut *group.firsts.add(part);
            (*of_part, before) = (before, before + *of_part);
        }
        first += parts;
        *free = whole(before);
    }
}

/// Finds the positions of the labels and pages of a part's drafts, and checks that each draft would get all its pages if the drafts
/// were stored one after the other. Safety: drafts are only read, and each position belongs to one draft.
pub(super) unsafe fn judge<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let mut before = (*group.parts.add(place)).claimed;
    let free = between.scanning.free_pages();
    for number in part(place, between.drafts).unwrap_or(0..0) {
        let draft = group.draft(number);
        *group.wholes.add(group.stride + number) = before.labels;
        let claims = draft.pages();
        let kinds = free.iter().zip(&claims).zip(before.pages.iter().zip(&before.regained));
        for (kind, ((free, [pages, regained]), (&taken, &given_back))) in kinds.enumerate() {
            *group.wholes.add((2 + kind) * group.stride + number) = taken;
            // At least this number of pages is free then, and this share of them is for this draft.
            let left = (free + whole(given_back)).saturating_sub(whole(taken));
            let share = left.checked_div(draft.remaining()).unwrap_or(0) + regained;
            if *pages > share {
                between.crowded.store(1, Ordering::Relaxed);
            }
        }
        before.add(draft);
    }
}

/// Lends the lists of pages, or stores the drafts one after the other. Safety: no other thread runs.
pub(super) unsafe fn commit<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let scanning = &mut between.scanning;
    let enough = between.wanted.iter().zip(&between.free).all(|(wanted, free)| wanted <= free);
    between.in_turn = !(enough && scanning.stores_together()) || between.crowded.load(Ordering::Relaxed) != 0;
    if between.in_turn {
        scanning.store_in_turn(group.all_drafts(between.drafts), between.eta);
    } else {
        let (of_static, of_moving) = scanning.lend_lists();
        between.lists = [Listed::of(of_static), Listed::of(of_moving)];
    }
    let (pages, moving_pages) = scanning.lend_pages();
    (between.pages, between.moving_pages) = (Many::lent(pages), Many::lent(moving_pages));
    between.lent = Lending::of(scanning.lend_particles());
}

/// Lists the free pages of a part, and stores the numbers of maps that hold the others. Safety: the lists are lent, and each
/// element belongs to one part.
pub(super) unsafe fn list<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(Between { lists, in_turn: false, .. }) = group.between() else { return };
    let (pages, is_moving) = pages_of_part::<M>(place);
    let [of_static, of_moving] = lists;
    let (lists, first) = if is_moving { (of_moving, M::PAGES[0]) } else { (of_static, 0) };
    let mut next = whole(*group.firsts.add(place));
    for page in pages {
        let held = (*group.held.add(page)).load(Ordering::Relaxed);
        let page = page - first;
        if let Some(references) = lists.references.one(page) {
            *references = held.min(u32::from(u16::MAX)) as u16;
        }
        if held == 0
            && let Some(free) = lists.free.one(next)
        {
            *free = PageId::of(page as u16);
            next += 1;
        }
    }
}

/// Safety: the lists are lent, and no two drafts get the same page; each draft belongs to one place.
pub(super) unsafe fn take<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.drafts) else { return };
    let draft = group.draft(place);
    if !between.in_turn {
        let [_, copies] = draft.particles();
        let noted = |column: usize| *group.wholes.add(column * group.stride + place);
        let next = |lists: Listed, free: usize, before: u32| {
            move |number: usize| {
                // The page that was freed last is allocated first.
                let last = free.checked_sub(1 + whole(before) + number)?;
                let id = *lists.free.all().get(last)?;
                *lists.references.one(id.index())? = copies.min(usize::from(u16::MAX)) as u16;
                Some(id)
            }
        };
        let ([of_static, of_moving], [free, free_moving]) = (between.lists, between.free);
        let (next, next_moving) = (next(of_static, free, noted(2)), next(of_moving, free_moving, noted(3)));
        draft.take(between.first_fresh, noted(1), next, next_moving);
    }
    draft.rename();
}

/// Writes the pages of one draft, together with other threads. Safety: the pages are lent, and no two drafts have the same page;
/// each word belongs to one place.
pub(super) unsafe fn fill<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let (number, lane) = (place / LANES, place % LANES);
    if number < between.drafts {
        let (of_static, of_moving) = (*group.drafts.add(number)).assume_init_ref().placed();
        copy_all(of_static, between.pages, lane);
        copy_all(of_moving, between.moving_pages, lane);
    }
}

/// Writes the words number `lane`, `lane + LANES`, ... of each page.
unsafe fn copy_all<F: Feature>((ids, pages): Placed<'_, F>, to: Many<Page<F>>, lane: usize) {
    const { assert!(size_of::<Page<F>>().is_multiple_of(size_of::<u32>())) };
    for (id, page) in ids.iter().zip(pages) {
        if let Some(to) = to.at(id.index()) {
            let (from, to) = (ptr::from_ref(page).cast::<MaybeUninit<u32>>(), to.cast::<MaybeUninit<u32>>());
            for word in (lane..size_of::<Page<F>>() / size_of::<u32>()).step_by(LANES) {
                // SAFETY: both have this word, and no other thread writes it.
                unsafe { to.add(word).write(from.add(word).read()) };
            }
        }
    }
}

/// Gives one particle the list of its pages, and moves its selected candidate to the particle's place. Safety: rows and candidates
/// are lent, and each belongs to one place.
pub(super) unsafe fn share<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.scanning.particles()[0]) else { return };
    if !between.in_turn {
        let [of_static, of_moving] = &between.lists;
        let rows = |lists: &Listed| lists.ids.some(place * lists.map_pages..(place + 1) * lists.map_pages);
        if let Some(head) = of_static.rows.one(place)
            && let Some(moving_head) = of_moving.rows.one(place)
        {
            let draft = group.draft(whole(*group.wholes.add(place)));
            draft.write_rows((rows(of_static), head), (rows(of_moving), moving_head));
        }
        for row in [of_static, of_moving].into_iter().filter_map(|lists| lists.row_of.one(place)) {
            *row = place as u16;
        }
    }
    let lent = &between.lent;
    if let Some(candidate) = lent.candidates.one(place)
        && let Some(selected) = lent.selected.all().get(place)
    {
        *candidate = *selected;
        *group.columns.add(WEIGHT * group.stride + place) = scphd::Real::exp(candidate.ln_weight);
    }
    if let Some(covariance) = lent.pose_covariances.one(place)
        && let Some(selected) = lent.selected_covariances.all().get(place)
    {
        *covariance = *selected;
    }
}
