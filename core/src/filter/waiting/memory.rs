//! Storage of delayed births.

use crate::detection::scan::Scan;
use crate::numerics::fnv::Fnv;
use crate::{Config, CovarianceOf, MeasurementModel, Pose, Real, ScalarOf, Sensor, Symmetric, TangentOf, Vector, Zero};

/// Number of measurements in one word of a bit set.
pub(super) const PER_WORD: usize = u64::BITS as usize;
/// Maximum number of words. Births of measurements beyond the words are not delayed.
pub(crate) const MOST_WORDS: usize = 4;
/// Maximum dimension of a measurement with delayed births.
const COORDINATES: usize = 4;
/// Births with at least this weight are not delayed, because they may be extracted immediately.
const HEAVY: f64 = 0.1;

/// A measurement with delayed births.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Awaited<T> {
    /// z, padded with zeros.
    pub(super) z: [T; COORDINATES],
    /// ln( κ(z) + Σ w_b ), the reference for the weights of its births.
    pub(super) ln_reference: T,
    /// Scratch: p_D w of the static and of the moving birth, for births that a miss removes.
    pub(super) missed: [T; 2],
}

/// The scan with the delayed births.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Awaiting {
    /// Number of stored measurements; zero without delayed births.
    pub(super) len: u16,
    /// Whether several sensors had scans since the reset. Births would then have to wait for the next scan of the same sensor; so
    /// no birth is delayed.
    pub(super) several: bool,
    /// The label of the births of the first measurement.
    pub(super) first_label: u32,
    /// Identifies the sensor: a hash of the position of the first measurement, seen from the origin.
    pub(super) sensor: u64,
}

impl Awaiting {
    pub(super) const NOTHING: Self = Self { len: 0, several: false, first_label: 0, sensor: 0 };
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

/// Sets the bit of a measurement.
fn mark(words: &mut [u64], index: usize) {
    if let Some(word) = words.get_mut(index / PER_WORD) {
        *word |= 1 << (index % PER_WORD);
    }
}

/// Whether the bit of a measurement is set.
fn is_marked(words: &[u64], index: usize) -> bool {
    words.get(index / PER_WORD).is_some_and(|word| word & (1 << (index % PER_WORD)) != 0)
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

    /// Whether any particle has a delayed birth of a measurement.
    pub(super) fn is_anywhere(&self, index: usize) -> bool {
        self.births.chunks(self.words.max(1)).any(|births| is_marked(births, index))
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

    /// The words of a particle, for static and for moving births.
    pub(super) fn words(&self, particle: usize) -> impl Iterator<Item = [u64; 2]> {
        let of = |kind| {
            let start = self.start(particle, kind);
            self.births.get(start..start + self.words).unwrap_or(&[]).iter()
        };
        of(0).zip(of(1)).map(|(&still, &moving)| [still, moving])
    }
}

/// The pose from which a particle's delayed births were measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Birthplace<P: Pose> {
    pub(super) pose: P,
    /// Covariance of the pose, or zero.
    pub(super) covariance: CovarianceOf<P>,
}

/// Memory of the delayed births of all particles.
#[derive(Debug)]
pub(crate) struct WaitingMemory<P: Pose, const PARTICLES: usize, const CANDIDATES: usize, const WORDS: usize> {
    awaiting: Awaiting,
    awaited: [[Awaited<P::Scalar>; PER_WORD]; WORDS],
    births: [[u64; WORDS]; PARTICLES],
    weights: [[P::Scalar; 2]; PARTICLES],
    birthplaces: [Birthplace<P>; PARTICLES],
    missed: [P::Scalar; PARTICLES],
    met: [[[u64; WORDS]; 2]; PARTICLES],
    steps: [TangentOf<P>; CANDIDATES],
}

impl<T: Real, P: Pose<Scalar = T>, const PARTICLES: usize, const CANDIDATES: usize, const WORDS: usize>
    WaitingMemory<P, PARTICLES, CANDIDATES, WORDS>
{
    /// All zero: no delayed births.
    pub(crate) const ZERO: Self = Self {
        awaiting: Awaiting::NOTHING,
        awaited: [[Awaited { z: [T::ZERO; COORDINATES], ln_reference: T::ZERO, missed: [T::ZERO; 2] }; PER_WORD];
            WORDS],
        births: [[0; WORDS]; PARTICLES],
        weights: [[T::ZERO; 2]; PARTICLES],
        birthplaces: [Birthplace { pose: P::ZERO, covariance: Symmetric::ZERO }; PARTICLES],
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
    pub(super) awaiting: &'s mut Awaiting,
    pub(super) awaited: &'s mut [Awaited<ScalarOf<P>>],
    pub(crate) noted: Notes<'s, ScalarOf<P>>,
    pub(super) birthplaces: &'s mut [Birthplace<P>],
    /// For every particle, Σ p_D w of the births that the scan has missed.
    pub(crate) missed: &'s mut [ScalarOf<P>],
    /// Scratch: the births that the scan may have detected.
    pub(super) met: Met<'s>,
    /// Scratch: the difference of the motion of every candidate since its birthplace from that of the reference candidate.
    pub(super) steps: &'s mut [TangentOf<P>],
}

impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Removes all delayed births, and the record of sensors.
    pub(crate) fn clear(&mut self) {
        *self.awaiting = Awaiting::NOTHING;
        self.forget();
    }

    /// Removes all delayed births.
    pub(crate) fn forget(&mut self) {
        self.awaiting.len = 0;
        self.noted.forget();
    }

    /// Σ w of a particle's static and moving births.
    pub(crate) fn weights(&self, particle: usize) -> [T; 2] {
        self.noted.weights.get(particle).copied().unwrap_or([T::ZERO; 2])
    }

    /// Stores the measurements of a scan, whose first label is `first_label`, after the births of the last scan [have
    /// entered](super::enter) the maps. Returns the number of measurements whose births will be delayed.
    pub(crate) fn await_scan<X: MeasurementModel<Pose = P>>(
        &mut self,
        config: &Config<T>,
        sensor: &impl Sensor<Pose = P, Measurement = X::Measurement>,
        scan: &Scan<'_, X::Measurement>,
        first_label: u32,
    ) -> usize {
        let may_wait =
            config.births_wait && !self.awaiting.several && const { X::Measurement::DIMENSION <= COORDINATES };
        let first = scan.iter().next().and_then(|measurement| of_sensor(sensor, &measurement.z));
        let Some(sensor) = first.filter(|_| may_wait) else { return 0 };
        for (slot, measurement) in self.awaited.iter_mut().zip(scan.iter()) {
            slot.z.iter_mut().zip(measurement.z.as_slice()).for_each(|(slot, &coordinate)| *slot = coordinate);
            slot.ln_reference = measurement.ln_reference();
        }
        let len = scan.len().min(self.awaited.len());
        *self.awaiting = Awaiting { len: len as u16, first_label, sensor, ..*self.awaiting };
        len
    }

    /// Stores the pose from which a particle has seen the scan.
    pub(crate) fn place(&mut self, particle: usize, pose: P, covariance: CovarianceOf<P>) {
        if let Some(slot) = self.birthplaces.get_mut(particle) {
            *slot = Birthplace { pose, covariance };
        }
    }
}

impl<T: Real> Awaited<T> {
    /// z.
    pub(super) fn measurement<Z: Vector<Scalar = T>>(&self) -> Z {
        Z::with(|k| self.z.get(k).copied().unwrap_or(T::ZERO))
    }

    /// ln of the weight of its birth with this birth intensity; `None` if it is below the floor, or too heavy to have been delayed.
    pub(super) fn ln_weight(&self, ln_intensity: T, ln_floor: T) -> Option<T> {
        let ln_weight = ln_intensity - self.ln_reference;
        // The weight by the complete η_z was a little smaller, and below `HEAVY`.
        let ln_most = T::from_f64(HEAVY).ln() + T::from_f64(0.01);
        (ln_weight >= ln_floor && ln_weight <= ln_most).then_some(ln_weight)
    }
}

/// Identifies a sensor by a hash of the position of a measurement, seen from the origin; `None` if the measurement has no inverse.
pub(super) fn of_sensor<S: Sensor<Pose: Pose<Scalar: Real>>>(sensor: &S, measured: &S::Measurement) -> Option<u64> {
    let inverse = sensor.invert(&sensor.frame(&S::Pose::ZERO), measured)?;
    let mut hash = Fnv::EMPTY;
    inverse.feature.as_slice().iter().for_each(|&coordinate| hash.take_scalar(coordinate));
    Some(hash.value())
}
