//! Memory scrubbing: a check of the state in slices between steps, which repairs damage by memory faults.

use crate::filter::state::Memory;
use crate::numerics::ln_sum::ln_sum;
use crate::numerics::range::{is_within_range, is_within_square};
use crate::particles::candidate::Candidate;
use crate::snapshot::visit::Sealing;
use crate::{Flaw, Health, Motion, Pose, Proposal, Real, ScPhd, Symmetric};

/// Position at which [`ScPhd::scrub`] or [`JointSlam::scrub`](crate::JointSlam::scrub) continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scrubber {
    /// The next part: first the particles, the page lists, and the pages of either kind. For a joint map: the pose, the features,
    /// and the features in the archive.
    pub(crate) next: usize,
}

impl Scrubber {
    /// A scrubber that starts at the first part.
    pub const fn new() -> Self {
        Self { next: 0 }
    }
}

/// Damage that a call of `scrub` has found and repaired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Scrubbed {
    /// Candidates that were isolated: they get the pose of the heaviest candidate and a negligible weight, until resampling removes
    /// them.
    pub isolated: usize,
    /// Whether the weights did not sum to one and were normalised.
    pub rescaled: bool,
    /// Kinds of maps, static or moving, whose page lists or reference counts were repaired. A page that cannot be assigned to a
    /// list is left out.
    pub lists: usize,
    /// Pages of which components were removed, or weights or bounding box were recomputed.
    pub pages: usize,
    /// Features of a joint map that were removed.
    pub features: usize,
    /// Whether the covariance of the pose of a joint map was increased.
    pub widened: bool,
    /// Whether births that were delayed until the next scan were removed.
    pub waiting: bool,
    /// Whether the scrubber has finished a round: all parts were checked since the end of the previous round.
    pub round: bool,
}

impl Scrubbed {
    /// Whether no damage was found.
    pub fn is_clean(&self) -> bool {
        let Self { isolated, rescaled, lists, pages, features, widened, waiting, round: _ } = *self;
        isolated == 0 && !rescaled && lists == 0 && pages == 0 && features == 0 && !widened && !waiting
    }

    /// [`Health::STATE_REPAIRED`] if damage was found: for a vehicle that stores the health of a scan and of the following
    /// scrubbing in one field.
    pub fn health(&self) -> Health {
        Health::STATE_REPAIRED.when(!self.is_clean())
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Checks `parts` parts of the state and repairs values that the filter cannot have produced: for memory without error
    /// correction, between steps, when there is time. The particles are one part, the page lists with their reference counts
    /// another, and every page one more. Valid data is unchanged to the bit.
    ///
    /// A damaged particle is isolated; a damaged component is removed from all maps that share its page. A value that was changed
    /// to another valid value, for example by a flip of a low bit of a mean, is not found; to find it, compare
    /// [digests](Self::digest) or go back to a [snapshot](Self::save).
    ///
    /// ```
    /// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
    /// # use scphd::{Config, ScPhd, memory};
    /// use scphd::diagnostics::Scrubber;
    /// # memory! {
    /// #     type Memory: Unicycle<f32> { particles: 4, samples: 1, features { pages: 16, pages_per_map: 4, in_view: 32 } }
    /// # }
    /// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
    /// # let mut state = Box::new(Memory::new());
    /// # let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
    /// # slam.reset(PlanarPose::new(3.0, 0.0, 1.5), 1)?;
    /// let mut scrubber = Scrubber::new();
    /// // Eight parts after every scan: the third call completes all 18 parts.
    /// for scan in 0..3 {
    ///     let scrubbed = slam.scrub(&mut scrubber, 8)?;
    ///     assert!(scrubbed.is_clean() && scrubbed.round == (scan == 2));
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Damage that cannot be repaired: invalid counts or times, no valid pose, or no weight. [Restore](Self::restore) a snapshot,
    /// or [reset](Self::reset).
    pub fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw> {
        let informed = matches!(self.config.proposal, Proposal::Informed(_));
        let memory = &mut self.memory;
        let mut scrubbed = Scrubbed::default();
        if memory.cursor.particles == 0 && memory.cursor.noise.is_none() {
            return Ok(scrubbed);
        }
        memory.check_cursor()?;
        memory.check_counts(&self.config)?;
        let (static_pages, moving_pages) = (memory.static_maps.pool.capacity(), memory.moving_maps.pool.capacity());
        let all = 2 + static_pages + moving_pages;
        for _ in 0..parts.min(all) {
            match scrubber.next {
                0 => memory.mend_particles(informed, &mut scrubbed)?,
                1 => {
                    let particles = memory.cursor.particles;
                    let mended = [memory.static_maps.mend_lists(particles), memory.moving_maps.mend_lists(particles)];
                    scrubbed.lists += mended.into_iter().filter(|&mended| mended).count();
                }
                part => {
                    let page = part - 2;
                    let of_static = memory.static_maps.pool.mend_page(page);
                    let mended =
                        of_static || page >= static_pages && memory.moving_maps.pool.mend_page(page - static_pages);
                    scrubbed.pages += usize::from(mended);
                }
            }
            scrubber.next += 1;
            if scrubber.next >= all {
                (scrubber.next, scrubbed.round) = (0, true);
            }
        }
        Ok(scrubbed)
    }

    /// A hash of the data that is small and vital: the counts, the time since the last scan, the next label, the random stream and
    /// the divergence monitor. If a vehicle computes it after a step and gets another value before the next step, memory has failed
    /// in between, even where scrubbing cannot find it.
    pub fn seal(&self) -> u64 {
        let cursor = &*self.memory.cursor;
        let mut seal = Sealing::EMPTY;
        self.memory.walk_cursor(&mut seal);
        [cursor.particles, cursor.children, cursor.heaviest, cursor.weighed]
            .into_iter()
            .for_each(|count| seal.count(count));
        seal.value()
    }
}

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Limits counts to the capacities, so that every step ends, whatever memory faults have occurred.
    pub(crate) fn clamp(&mut self) {
        let Self { cursor, pose_covariances, candidates, ln_likelihoods, .. } = self;
        cursor.particles = cursor.particles.min(pose_covariances.len());
        cursor.children = cursor.children.min(candidates.len() / cursor.particles.max(1));
        cursor.weighed = cursor.weighed.min(ln_likelihoods.len());
        cursor.heaviest = cursor.heaviest.min(cursor.particles.saturating_sub(1));
    }

    /// Isolates invalid particles, and normalises weights that do not sum to one. Covariances of poses must be zero if the
    /// proposal is not `informed`.
    fn mend_particles(&mut self, informed: bool, scrubbed: &mut Scrubbed) -> Result<(), Flaw> {
        let Self { cursor, pose_covariances, candidates, .. } = &mut *self;
        let children = cursor.children.max(1);
        let candidates = candidates.get_mut(..cursor.candidates()).unwrap_or(&mut []);
        let certain = |pose_covariance: &Symmetric<P::Tangent>| *pose_covariance == Symmetric::ZERO;
        let may_be = |pose_covariance: &Symmetric<P::Tangent>| {
            if informed { is_within_square(pose_covariance) } else { certain(pose_covariance) }
        };
        // The first of the heaviest valid candidates.
        let mut best: Option<(usize, Candidate<P>)> = None;
        for (particle, family) in candidates.chunks(children).enumerate() {
            if !pose_covariances.get(particle).is_some_and(may_be) {
                continue;
            }
            for candidate in family.iter().filter(|candidate| is_sound(candidate)) {
                if best.is_none_or(|(_, best)| candidate.ln_weight > best.ln_weight) {
                    best = Some((particle, *candidate));
                }
            }
        }
        let Some((particle, healthy)) = best else { return Err(Flaw::Pose) };
        let pose_covariance = pose_covariances.get(particle).copied().unwrap_or(Symmetric::ZERO);
        let isolated = Candidate { ln_weight: healthy.ln_weight + T::LN_VANISHING, ..healthy };
        for (family, known) in candidates.chunks_mut(children).zip(pose_covariances.iter_mut()) {
            let whole = may_be(known);
            for candidate in family.iter_mut().filter(|candidate| !(whole && is_sound(candidate))) {
                *candidate = isolated;
                scrubbed.isolated += 1;
            }
            if !whole {
                *known = pose_covariance;
            }
        }
        if !Self::is_one(candidates) {
            let total = ln_sum(candidates.iter().map(|candidate| candidate.ln_weight));
            if !total.is_finite() {
                return Err(Flaw::Weights);
            }
            candidates.iter_mut().for_each(|candidate| candidate.ln_weight -= total);
            scrubbed.rescaled = true;
        }
        scrubbed.waiting |= self.waiting.mend(self.cursor.particles);
        Ok(())
    }
}

/// Whether a candidate is valid: its pose within range, and its weight at most one.
fn is_sound<T: Real, P: Pose<Scalar = T>>(candidate: &Candidate<P>) -> bool {
    let pose = &candidate.pose;
    candidate.ln_weight <= T::from_f64(1e-3) && pose.is_finite() && is_within_range(&pose.coordinates())
}
