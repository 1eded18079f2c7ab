//! Loading a map: one of an earlier drive, or a surveyed one.

use super::archive::Archive;
use super::existence::Existence;
use super::filter::JointSlam;
use super::landmark::Landmark;
use super::movers::Movers;
use super::state::Memory;
use crate::{Component, LoadMapError, Motion, Pose, PositionOf, Real, Vector};

/// Number of detections that is assumed for a loaded feature: that of an established feature.
const DETECTIONS: f64 = 2.0;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// The greatest label that a loaded feature may have.
    pub const GREATEST_LOADED_LABEL: u32 = u32::MAX / 2;

    /// Replaces the map by these features, from an earlier drive or a survey. Their errors have the given covariances
    /// and are independent of each other and of the pose, which is unchanged. The weight of a feature is its existence
    /// probability. Labels are kept; if several features have the same label, the first keeps it and the others get new
    /// ones. Tracks of moving objects are removed, and an archive is emptied.
    ///
    /// # Errors
    /// The filter has not been reset; a feature is not finite, beyond 1e8 m, heavier than a million, or its covariance is not
    /// positive definite; its label is too great; or there are more features than the state can store. The state is unchanged.
    pub fn load_map(&mut self, features: &[Component<PositionOf<M::Pose>>]) -> Result<(), LoadMapError> {
        let Memory { header, landmarks, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(LoadMapError::NotStarted);
        }
        if features.len() > landmarks.len() {
            return Err(LoadMapError::TooManyComponents { components: features.len(), capacity: landmarks.len() });
        }
        if let Some(index) = features.iter().position(|feature| !feature.is_usable()) {
            return Err(LoadMapError::Component { index });
        }
        if let Some(index) = features.iter().position(|feature| feature.label > Self::GREATEST_LOADED_LABEL) {
            return Err(LoadMapError::Tag { index });
        }
        let greatest = features.iter().map(|feature| feature.label).max();
        let mut next_label = header.next_label.max(greatest.map_or(0, |label| label.saturating_add(1)));
        for (index, (feature, landmark)) in features.iter().zip(landmarks.iter_mut()).enumerate() {
            let mut label = feature.label;
            // This compares at most half as many pairs as the square of the capacity.
            if features.iter().take(index).any(|before| before.label == label) {
                label = next_label;
                next_label = next_label.wrapping_add(1);
            }
            let existence = Existence::of(feature.ln_weight.exp().at_most(T::ONE));
            let detections = T::from_f64(DETECTIONS);
            *landmark = Landmark { label, mean: feature.mean, existence, detections, ..Landmark::ZERO };
            joint.put_alone(index);
            joint.put_block(index, index, |row, column| feature.covariance.get(row, column));
        }
        (header.len, header.next_label) = (features.len(), next_label);
        header.watch.know_below(next_label);
        if let Some(mut tracks) = self.movers.tracks() {
            tracks.clear();
        }
        if let Some(mut view) = self.archive.view() {
            view.clear();
        }
        Ok(())
    }
}
