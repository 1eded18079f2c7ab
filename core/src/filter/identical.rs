//! Identical particles, of which one is updated for all.
//!
//! The informed proposal without sampling makes the same of the same particle. Particles that a reset has made equal then stay so.

use crate::filter::state::Memory;
use crate::particles::candidate::Candidate;
use crate::{Config, Pose, Proposal, Real};

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Leaves only the first particle if the scan would make the same of all; how many there were.
    pub(crate) fn join_identical(&mut self, config: &Config<T>) -> usize {
        let particles = self.cursor.particles;
        let samples_nothing =
            matches!(config.proposal, Proposal::Informed(informed) if informed.sampled_fraction == T::ZERO);
        let joins = samples_nothing && config.samples == 1 && self.cursor.children == 1;
        if joins && (1..particles).all(|other| self.is_like_first(other)) {
            for other in 1..particles {
                self.static_maps.table.release(other, &mut self.static_maps.pool);
                self.moving_maps.table.release(other, &mut self.moving_maps.pool);
            }
            (self.cursor.particles, self.cursor.heaviest) = (particles.min(1), 0);
            self.weigh_equally(particles.min(1));
        }
        particles
    }

    /// Makes the first particle so many, if it is the only one.
    pub(crate) fn split_identical(&mut self, particles: usize) {
        if self.cursor.particles >= particles {
            return;
        }
        let Self { cursor, pose_covariances, candidates, ln_likelihoods, survivors, .. } = self;
        copy_to_all(candidates, particles);
        copy_to_all(pose_covariances, particles);
        copy_to_all(ln_likelihoods, particles);
        copy_to_all(survivors, particles);
        cursor.particles = particles;
        if cursor.weighed > 0 {
            cursor.weighed = particles;
        }
        for other in 1..particles {
            self.static_maps.table.share(0, other, &mut self.static_maps.pool);
            self.moving_maps.table.share(0, other, &mut self.moving_maps.pool);
            self.waiting.copy(0, other);
        }
        self.weigh_equally(particles);
        let Self { candidates, selected, .. } = self;
        selected.iter_mut().zip(candidates.iter()).take(particles).for_each(|(slot, particle)| *slot = *particle);
    }

    fn weigh_equally(&mut self, particles: usize) {
        let ln_weight = -T::from_usize(particles).ln();
        for slot in self.candidates.iter_mut().take(particles) {
            *slot = Candidate { ln_weight, ..*slot };
        }
    }

    fn is_like_first(&self, other: usize) -> bool {
        let Self { candidates, pose_covariances, static_maps, moving_maps, waiting, .. } = self;
        candidates.get(other) == candidates.first()
            && pose_covariances.get(other) == pose_covariances.first()
            && static_maps.table.pages(other) == static_maps.table.pages(0)
            && moving_maps.table.pages(other) == moving_maps.table.pages(0)
            && waiting.are_alike(0, other)
    }
}

fn copy_to_all<X: Copy>(slots: &mut [X], count: usize) {
    if let Some((first, others)) = slots.get_mut(..count).and_then(|slots| slots.split_first_mut()) {
        others.fill(*first);
    }
}
