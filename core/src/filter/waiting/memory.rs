//! Storage of delayed births.

use crate::detection::scan::Scan;
use crate::filter::newborn::{Carried, Newborn};
use crate::{Births, Config, Place, Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};
use core::ops::Range;

/// Number of measurements in one word of a bit set.
pub(super) const PER_WORD: usize = u64::BITS as usize;
/// Maximum number of words. Births of measurements beyond the words are not delayed.
pub(crate) const MOST_WORDS: usize = 4;
/// Births with at least this weight are not delayed, because they may be extracted immediately.
const HEAVY: f64 = 0.1;

/// A measurement with delayed births.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Awaited<D: Vector, T = <D as Vector>::Scalar> {
    /// The position of its births for the pose of [`Awaiting::origin`].
    pub(super) position: D,
    /// Its covariance.
    pub(super) covariance: Symmetric<D>,
    /// ln( κ(z) + Σ w_b ), the reference for the weights of its births.
    pub(super) ln_reference: T,
    /// Scratch: p_D w of the static and of the moving birth, for births that a miss removes.
    pub(super) missed: [T; 2],
}

/// The scan with the delayed births.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Awaiting<P: Pose> {
    /// Number of stored measurements; zero without delayed births.
    pub(super) len: u16,
    /// The label of the births of the first measurement.
    pub(super) first_label: u32,
    /// ln of the intensities of static and of moving births.
    pub(super) ln_births: [ScalarOf<P>; 2],
    /// The pose of one particle at the scan.
    pub(super) origin: P,
}

/// The delayed births of one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noted<T> {
    /// A bit for each measurement.
    births: [u64; MOST_WORDS],
    /// Σ w of the static and of the moving births.
    weights: [T; 2],
}

impl<T: Real> Noted<T> {
    pub(crate) const NOTHING: Self = Self { births: [0; MOST_WORDS], weights: [T::ZERO; 2] };

    /// Adds the births of a measurement, a static and a moving one; `false` if they must not be delayed. `last` holds ln w and w of
    /// the last ones: with uniform clutter, most births have the same.
    pub(crate) fn note(&mut self, index: usize, ln_weights: [Option<T>; 2], last: &mut [(T, T); 2]) -> bool {
        let ln_heavy = T::from_f64(HEAVY).ln();
        if ln_weights.iter().flatten().any(|&ln_weight| !(ln_weight < ln_heavy)) {
            return false;
        }
        mark(&mut self.births, index);
        for ((sum, ln_weight), last) in self.weights.iter_mut().zip(ln_weights).zip(last) {
            let Some(ln_weight) = ln_weight else { continue };
            if last.0 != ln_weight {
                *last = (ln_weight, ln_weight.exp());
            }
            *sum += last.1;
        }
        true
    }
}

/// The bit of a measurement in its word.
pub(super) fn bit(index: usize) -> u64 {
    1 << (index % PER_WORD)
}

/// Sets the bit of a measurement.
fn mark(words: &mut [u64], index: usize) {
    if let Some(word) = words.get_mut(index / PER_WORD) {
        *word |= bit(index);
    }
}

/// Whether only bits of the first `measurements` measurements are set.
pub(super) fn are_below(words: &[u64], measurements: usize) -> bool {
    words.iter().enumerate().all(|(place, word)| {
        let bits = measurements.saturating_sub(place * PER_WORD).min(PER_WORD);
        word.checked_shr(bits as u32).unwrap_or(0) == 0
    })
}

/// Number of words for this number of measurements.
pub(super) fn words_for(measurements: usize) -> usize {
    measurements.div_ceil(PER_WORD)
}

/// The delayed births of all particles.
#[derive(Debug)]
pub(crate) struct Notes<'n, T> {
    /// Number of words for each particle.
    pub(super) words: usize,
    pub(super) births: &'n mut [u64],
    pub(super) weights: &'n mut [[T; 2]],
}

impl<T: Real> Notes<'_, T> {
    /// A mutable reborrow.
    pub(crate) fn reborrow(&mut self) -> Notes<'_, T> {
        Notes { words: self.words, births: self.births, weights: self.weights }
    }

    /// Sets the delayed births of a particle.
    pub(crate) fn set(&mut self, particle: usize, noted: &Noted<T>) {
        if let Some(weights) = self.weights.get_mut(particle) {
            *weights = noted.weights;
        }
        for (slot, &word) in self.births_mut(particle).iter_mut().zip(&noted.births) {
            *slot = word;
        }
    }

    /// Copies the delayed births of a particle to another one.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        if let Some(&weights) = self.weights.get(from)
            && let Some(slot) = self.weights.get_mut(to)
        {
            *slot = weights;
        }
        for word in 0..self.words {
            let birth = self.births.get(from * self.words + word).copied();
            if let Some((birth, slot)) = birth.zip(self.births.get_mut(to * self.words + word)) {
                *slot = birth;
            }
        }
    }

    /// The measurements with delayed births of a particle, as a bit set.
    pub(super) fn births(&self, particle: usize) -> &[u64] {
        self.births.get(particle * self.words..(particle + 1) * self.words).unwrap_or(&[])
    }

    /// The measurements at the index of a word with a delayed birth of any particle.
    pub(super) fn anywhere(&self, place: usize) -> u64 {
        self.births.chunks(self.words.max(1)).filter_map(|births| births.get(place)).fold(0, |any, word| any | word)
    }

    /// Removes the births of a measurement, which have these weights. Calls `removed` with each particle that had them.
    fn remove(&mut self, index: usize, ln_weights: [Option<T>; 2], mut removed: impl FnMut(usize)) {
        let of_all = self.births.chunks_mut(self.words.max(1)).zip(self.weights.iter_mut());
        for (particle, (births, weights)) in of_all.enumerate() {
            let Some(word) = births.get_mut(index / PER_WORD).filter(|word| **word & bit(index) != 0) else { continue };
            *word &= !bit(index);
            for (sum, ln_weight) in weights.iter_mut().zip(ln_weights) {
                *sum = (*sum - ln_weight.map_or(T::ZERO, Real::exp)).at_least(T::ZERO);
            }
            removed(particle);
        }
    }

    fn births_mut(&mut self, particle: usize) -> &mut [u64] {
        self.births.get_mut(particle * self.words..(particle + 1) * self.words).unwrap_or(&mut [])
    }

    fn forget(&mut self) {
        self.births.fill(0);
        self.weights.fill([T::ZERO; 2]);
    }
}

/// The delayed births that the scan may have detected, for all particles.
#[derive(Debug)]
pub(crate) struct Met<'m> {
    /// Number of words for the static births of each particle, and for its moving births.
    words: usize,
    births: &'m mut [u64],
}

impl Met<'_> {
    pub(super) fn clear(&mut self) {
        self.births.fill(0);
    }

    fn start(&self, particle: usize, kind: usize) -> usize {
        (2 * particle + kind) * self.words
    }

    /// Sets a bit of the word at this index.
    pub(super) fn mark(&mut self, particle: usize, kind: usize, place: usize, bit: u64) {
        let start = self.start(particle, kind);
        if let Some(word) = self.births.get_mut(start + place) {
            *word |= bit;
        }
    }

    /// The births at the index of a word that any of these particles may have detected, static and moving ones.
    pub(super) fn word(&self, particles: Range<usize>, place: usize) -> [u64; 2] {
        particles.fold([0; 2], |met, particle| {
            let of = |kind| self.births.get(self.start(particle, kind) + place).copied().unwrap_or(0);
            [met[0] | of(0), met[1] | of(1)]
        })
    }
}

/// Memory of the delayed births of all particles.
#[derive(Debug)]
pub(crate) struct WaitingMemory<P: Pose, const PARTICLES: usize, const CANDIDATES: usize, const WORDS: usize> {
    awaiting: Awaiting<P>,
    awaited: [[Awaited<P::Position>; PER_WORD]; WORDS],
    births: [[u64; WORDS]; PARTICLES],
    weights: [[P::Scalar; 2]; PARTICLES],
    birthplaces: [P; PARTICLES],
    missed: [P::Scalar; PARTICLES],
    met: [[[u64; WORDS]; 2]; PARTICLES],
    steps: [TangentOf<P>; CANDIDATES],
}

impl<T: Real, P: Pose<Scalar = T>, const PARTICLES: usize, const CANDIDATES: usize, const WORDS: usize>
    WaitingMemory<P, PARTICLES, CANDIDATES, WORDS>
{
    /// All zero: no delayed births.
    pub(crate) const ZERO: Self = Self {
        awaiting: Awaiting { len: 0, first_label: 0, ln_births: [T::ZERO; 2], origin: P::ZERO },
        awaited: [[Awaited::ZERO; PER_WORD]; WORDS],
        births: [[0; WORDS]; PARTICLES],
        weights: [[T::ZERO; 2]; PARTICLES],
        birthplaces: [P::ZERO; PARTICLES],
        missed: [T::ZERO; PARTICLES],
        met: [[[0; WORDS]; 2]; PARTICLES],
        steps: [TangentOf::<P>::ZERO; CANDIDATES],
    };

    /// The delayed births in this memory.
    pub(crate) fn view(&mut self) -> Waiting<'_, P> {
        let Self { awaiting, awaited, births, weights, birthplaces, missed, met, steps } = self;
        Waiting {
            awaiting,
            awaited: awaited.as_flattened_mut(),
            noted: Notes { words: WORDS, births: births.as_flattened_mut(), weights },
            birthplaces,
            missed,
            met: Met { words: WORDS, births: met.as_flattened_mut().as_flattened_mut() },
            steps,
        }
    }
}

/// The delayed births, with any capacity.
#[derive(Debug)]
pub(crate) struct Waiting<'s, P: Pose> {
    pub(super) awaiting: &'s mut Awaiting<P>,
    pub(super) awaited: &'s mut [Awaited<PositionOf<P>>],
    pub(crate) noted: Notes<'s, ScalarOf<P>>,
    /// For every particle, the pose from which its births were measured.
    pub(super) birthplaces: &'s mut [P],
    /// For every particle, Σ p_D w of the births that the scan has missed.
    pub(crate) missed: &'s mut [ScalarOf<P>],
    /// Scratch: the births that the scan may have detected.
    pub(super) met: Met<'s>,
    /// Scratch: the difference of the motion of every candidate since its birthplace from that of the reference candidate.
    pub(super) steps: &'s mut [TangentOf<P>],
}

impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Removes all delayed births.
    pub(crate) fn forget(&mut self) {
        self.awaiting.len = 0;
        self.noted.forget();
    }

    /// Σ w of a particle's static and moving births.
    pub(crate) fn weights(&self, particle: usize) -> [T; 2] {
        self.noted.weights.get(particle).copied().unwrap_or([T::ZERO; 2])
    }

    /// Prepares to delay births of a scan, whose first label is `first_label`, after the births of the last scan [have
    /// entered](super::enter) the maps. Returns the number of measurements whose births will be delayed.
    pub(crate) fn await_scan<Z: Vector<Scalar = T>>(
        &mut self,
        config: &Config<T>,
        births: &Births<T>,
        scan: &Scan<'_, Z>,
        first_label: u32,
    ) -> usize {
        let len = if config.births_wait { scan.len().min(self.awaited.len()) } else { 0 };
        self.awaiting.len = len as u16;
        self.awaiting.first_label = first_label;
        self.awaiting.ln_births = [births.of_static, births.of_moving].map(Real::ln);
        len
    }

    /// Stores the pose from which a particle has seen the scan.
    pub(crate) fn place(&mut self, particle: usize, pose: P) {
        if let Some(slot) = self.birthplaces.get_mut(particle) {
            *slot = pose;
        }
    }

    /// After the updates, stores the positions of the delayed births for the pose `origin`, from where `newborn` returns that of a
    /// measurement. Calls `without` with the particles whose birth is removed, because there is no such feature in view, and the number
    /// of its kinds.
    pub(crate) fn complete<Z: Vector<Scalar = T>>(
        &mut self,
        config: &Config<T>,
        scan: &Scan<'_, Z>,
        origin: P,
        newborn: impl Fn(&Z) -> Option<Newborn<PositionOf<P>>>,
        mut without: impl FnMut(usize, usize),
    ) {
        let Self { awaiting, awaited, noted, .. } = self;
        awaiting.origin = origin;
        let ln_floor = config.prune_weight.ln();
        let slots = awaited.iter_mut().take(usize::from(awaiting.len));
        let (mut anywhere, mut waits) = (0, false);
        for (index, (slot, measurement)) in slots.zip(scan.iter()).enumerate() {
            if index % PER_WORD == 0 {
                anywhere = noted.anywhere(index / PER_WORD);
                waits |= anywhere != 0;
            }
            // Without births, zero: digests and snapshots have all measurements.
            *slot = Awaited { ln_reference: measurement.ln_reference(), ..Awaited::ZERO };
            if anywhere & bit(index) == 0 {
                continue;
            }
            if let Some(Newborn { position, covariance, .. }) = newborn(&measurement.z) {
                (slot.position, slot.covariance) = (position, covariance);
                continue;
            }
            let ln_weights = awaiting.ln_births.map(|ln_intensity| slot.ln_weight(ln_intensity, ln_floor));
            noted.remove(index, ln_weights, |particle| without(particle, ln_weights.iter().flatten().count()));
        }
        if !waits {
            awaiting.len = 0;
        }
    }
}

impl<T: Real, D: Place<Scalar = T>> Awaited<D> {
    /// All zero.
    pub(super) const ZERO: Self =
        Self { position: D::ZERO, covariance: Symmetric::ZERO, ln_reference: T::ZERO, missed: [T::ZERO; 2] };

    /// ln of the weight of its birth with this birth intensity; `None` if it is below the floor, or too heavy to have been delayed.
    pub(super) fn ln_weight(&self, ln_intensity: T, ln_floor: T) -> Option<T> {
        let ln_weight = ln_intensity - self.ln_reference;
        // The weight by the complete η_z was a little smaller, and below `HEAVY`.
        let ln_most = T::from_f64(HEAVY).ln() + T::from_f64(0.01);
        (ln_weight >= ln_floor && ln_weight <= ln_most).then_some(ln_weight)
    }

    /// Its feature for another pose.
    pub(super) fn newborn(&self, carried: &Carried<D>) -> Option<Newborn<D>> {
        carried.newborn(&self.position, &self.covariance)
    }
}
