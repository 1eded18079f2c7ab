//! Fault injection into a filter with static features: all data that is kept between steps.

use super::scphd::ScPhd;
use crate::filter::state::Memory;
use crate::map::PAGE_LEN;
use crate::numerics::flip::{Each, Word, flip_one, of_symmetric};
use crate::particles::cursor::Cursor;
use crate::{Motion, Noise, PlanarPose};

impl<M: Motion<Pose = PlanarPose<f32>>> ScPhd<'_, M> {
    /// Flips one bit of the data that is kept between steps, without moving features; every bit has the same probability. Returns
    /// the name of the data and the index of the bit in its word. For tests of memory faults on a board or a desk computer, with
    /// the feature `flips`; `draws` selects the bit, so that the same seed flips the same bits everywhere.
    ///
    /// ```
    /// # use scphd::diagnostics::Scrubber;
    /// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
    /// # use scphd::numerics::Noise;
    /// # use scphd::{Config, ScPhd, memory};
    /// # memory! {
    /// #     type Memory: Unicycle<f32> { particles: 4, samples: 1, features { pages: 16, pages_per_map: 4, in_view: 32 } }
    /// # }
    /// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
    /// # let mut state = Box::new(Memory::new());
    /// # let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
    /// # slam.reset(PlanarPose::new(3.0, 0.0, 1.5), 1)?;
    /// let before = slam.digest();
    /// let mut draws = Noise::seeded(5);
    /// while slam.flip_bit(&mut draws).0 != "pose" {}
    /// assert_ne!(slam.digest(), before);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn flip_bit(&mut self, draws: &mut Noise) -> (&'static str, usize) {
        flip_one(|each| self.words(each), draws)
    }

    fn words(&mut self, each: &mut Each<'_>) {
        let Memory { cursor, pose_covariances, candidates, static_maps, ln_likelihoods, survivors, waiting, .. } =
            &mut self.memory;
        let held = cursor.candidates().min(candidates.len());
        let particles = cursor.particles.min(pose_covariances.len());
        let Cursor {
            particles: count,
            children,
            predicted,
            waited_s,
            refused,
            weighed,
            heaviest,
            next_label,
            noise,
            watch,
        } = &mut **cursor;
        [count, children, weighed, heaviest].into_iter().for_each(|count| each("counts", Word::Count(count)));
        each("counts", Word::Truth(predicted));
        each("counts", Word::Real(waited_s));
        each("counts", Word::Short(refused));
        each("counts", Word::Long(next_label));
        noise.iter_mut().for_each(|noise| each("random stream", Word::Stream(noise)));
        watch.words(each);
        for candidate in candidates.iter_mut().take(held) {
            let PlanarPose { x_m, y_m, heading_rad } = &mut candidate.pose;
            [x_m, y_m, heading_rad].into_iter().for_each(|number| each("pose", Word::Real(number)));
            candidate.remainder.iter_mut().for_each(|number| each("pose", Word::Real(number)));
            each("weight", Word::Real(&mut candidate.ln_weight));
        }
        for pose_covariance in pose_covariances.iter_mut().take(particles) {
            of_symmetric("pose covariance", pose_covariance, each);
        }
        waiting.words(particles, each);
        ln_likelihoods.iter_mut().take(held).for_each(|number| each("scratch", Word::Real(number)));
        survivors.iter_mut().take(particles).for_each(|word| each("scratch", Word::Short(word)));
        for page in static_maps.pool.held_mut() {
            let fields = page.fields();
            let len = usize::from(*fields.len).min(PAGE_LEN);
            each("page", Word::Short(fields.len));
            for corner in [&mut fields.bounds.low, &mut fields.bounds.high] {
                corner.iter_mut().for_each(|number| each("page", Word::Real(number)));
            }
            for (component, weight) in fields.components.iter_mut().zip(fields.weights.iter_mut()).take(len) {
                each("component", Word::Long(&mut component.label));
                each("component", Word::Real(&mut component.ln_weight));
                each("component", Word::Real(weight));
                component.mean.iter_mut().for_each(|number| each("component", Word::Real(number)));
                of_symmetric("component", &mut component.covariance, each);
            }
        }
        static_maps.pool.words().for_each(|word| each("page counts", Word::Short(word)));
        static_maps.table.corners().for_each(|number| each("page lists", Word::Real(number)));
        static_maps.table.words().for_each(|word| each("page lists", Word::Short(word)));
    }
}
