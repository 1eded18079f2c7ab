//! Fault injection into a joint map: all data that is kept between steps, and the working memory.

use super::associations::AssociationRow;
use super::existence::Existence;
use super::filter::JointSlam;
use super::landmark::Landmark;
use super::state::{Header, Memory};
use crate::numerics::flip::{Each, Word, flip_one};
use crate::{Motion, Noise, PlanarPose};
use nalgebra::Vector2;

impl<M: Motion<Pose = PlanarPose<f32>>> JointSlam<'_, M, Vector2<f32>> {
    /// Flips one bit of the data that is kept between steps or of the working memory, as
    /// [`ScPhd::flip_bit`](crate::ScPhd::flip_bit) does.
    pub fn flip_bit(&mut self, draws: &mut Noise) -> (&'static str, usize) {
        flip_one(|each| self.words(each), draws)
    }

    fn words(&mut self, each: &mut Each<'_>) {
        let Memory { header, landmarks, joint, pending, association_table } = &mut self.memory;
        let Header { started, pose, remainder, moved, len, waited_s, motion_noise, refused, next_label, watch } =
            &mut **header;
        each("counts", Word::Truth(started));
        let PlanarPose { x_m, y_m, heading_rad } = pose;
        [x_m, y_m, heading_rad].into_iter().for_each(|number| each("pose", Word::Real(number)));
        let two = remainder.iter_mut().chain(moved);
        two.chain(motion_noise.as_lower_mut()).for_each(|number| each("pose", Word::Real(number)));
        each("counts", Word::Real(waited_s));
        let features = (*len).min(landmarks.len());
        [len, refused].into_iter().for_each(|count| each("counts", Word::Count(count)));
        each("counts", Word::Long(next_label));
        watch.words(each);
        for landmark in landmarks.iter_mut().take(features) {
            let Landmark { label, mean, moved, existence, detections, detection, is_anchor, measurement: _, scratch } =
                landmark;
            each("feature", Word::Long(label));
            each("feature", Word::Truth(is_anchor));
            let [x, y] = &mut mean.data.0[0];
            let [moved_x, moved_y] = &mut moved.data.0[0];
            let Existence { visible, occluded, absent } = existence;
            for number in [x, y, moved_x, moved_y, visible, occluded, absent, detections] {
                each("feature", Word::Real(number));
            }
            [detection, scratch].into_iter().for_each(|number| each("scratch", Word::Real(number)));
        }
        // The first six elements are the covariance of the pose.
        for (index, number) in joint.used_mut(features).iter_mut().enumerate() {
            each(if index < 6 { "pose covariance" } else { "covariance" }, Word::Real(number));
        }
        for row in pending.features.iter_mut().take(features).flatten().flatten() {
            row.iter_mut().for_each(|number| each("scratch", Word::Real(number)));
        }
        association_table.iter_mut().for_each(|row| row.words(each));
    }
}

impl AssociationRow<f32> {
    fn words(&mut self, each: &mut Each<'_>) {
        let (first, len) = self.parts();
        first.into_iter().for_each(|number| each("scratch", Word::Real(number)));
        each("scratch", Word::Count(len));
        for association in self.associations_mut() {
            each("scratch", Word::Short(&mut association.feature));
            for number in [&mut association.odds, &mut association.nu, &mut association.probability] {
                each("scratch", Word::Real(number));
            }
        }
    }
}
