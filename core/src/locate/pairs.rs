//! Association of the vehicle's landmarks with those of the map, for a given alignment.

use super::alignment::Alignment;
use super::state::{Memory, NONE};
use crate::Real;

impl<T: Real> Memory<'_, T> {
    /// Associates each landmark with the nearest unassociated one of the map within the gate, by the Mahalanobis distance, which
    /// includes the covariance of the alignment. Returns the number of pairs. Compares all landmarks with all of the map.
    pub(super) fn pair_up(&mut self, alignment: &Alignment<T>, inflation: T, gate: T) -> usize {
        let turned = alignment.turned();
        let known = |row, column| alignment.covariance.get(row, column);
        let (maps, seen) = (self.known.map, self.known.seen);
        self.taken.iter_mut().take(maps).for_each(|taken| *taken = false);
        let mut paired = 0;
        let all = self.seen.iter().take(seen).zip(self.pairs.iter_mut());
        for (landmark, pair) in all {
            *pair = NONE;
            let own = landmark.covariance.get(0, 0) + landmark.covariance.get(1, 1);
            let mut nearest = (usize::MAX, T::INFINITY);
            for (place, of_map) in self.map.iter().enumerate().take(maps) {
                let off = landmark.mean - turned.of(&of_map.mean);
                let lever = turned.lever(&of_map.mean);
                // The trace of a covariance is not below any variance.
                let two = T::ONE + T::ONE;
                let of_alignment = known(0, 0)
                    + known(1, 1)
                    + two * (known(2, 0) * lever.x + known(2, 1) * lever.y)
                    + known(2, 2) * lever.dot(&lever);
                let trace =
                    (own + of_map.covariance.get(0, 0) + of_map.covariance.get(1, 1)) * inflation + of_alignment;
                if !(off.dot(&off) <= gate * trace) || self.taken.get(place).is_none_or(|&taken| taken) {
                    continue;
                }
                let by_alignment = nalgebra::Matrix2x3::new(T::ONE, T::ZERO, lever.x, T::ZERO, T::ONE, lever.y);
                let covariance = turned.relative_covariance(landmark, of_map).scaled(inflation);
                let covariance =
                    covariance.plus(&alignment.covariance.congruence::<nalgebra::Vector2<T>>(&by_alignment));
                let Some(factor) = covariance.factor() else { continue };
                let distance = factor.mahalanobis(&off);
                let unlikely = distance + factor.ln_determinant();
                if distance <= gate && unlikely < nearest.1 {
                    nearest = (place, unlikely);
                }
            }
            if let Some(taken) = self.taken.get_mut(nearest.0) {
                *taken = true;
                *pair = nearest.0 as u16 + 1;
                paired += 1;
            }
        }
        paired
    }
}
