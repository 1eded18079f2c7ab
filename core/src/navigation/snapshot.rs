//! Snapshots of the navigator.

use super::Navigator;
use super::kalman::Kalman;
use super::velocity_filter::Outliers;
use crate::snapshot::frame::{Content, Head, Shape};
use crate::snapshot::read::{Reader, checked};
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Flaw, Reading, Real, RestoreError, SaveError, Symmetric};

/// Properties that all snapshots of navigators have in common.
fn shape<T: Real>(kind: u32) -> Shape {
    // A velocity and z.
    Shape { content: Content::Navigator, scalar: size_of::<T>() as u8, dimensions: [0, 4, 0], kind }
}

impl<T: Real> Navigator<T> {
    /// Writes a snapshot of about a hundred bytes, as [`ScPhd::save`](crate::ScPhd::save) does for the filter.
    ///
    /// ```
    /// # use scphd::navigation::{Navigator, VelocityNoise};
    /// use scphd::snapshot::{from_slice, into_slice};
    ///
    /// # let noise = VelocityNoise {
    /// #     walk_mps_rts: 0.1_f64, dvl_sigma_mps: 0.1, z_sigma_m: 0.02, gate_sigmas: 4.0, outliers_believed: 5,
    /// # };
    /// let mut navigator = Navigator::new(noise, -2.0, [0.0; 2])?;
    /// navigator.onward(0.1)?;
    /// let mut bytes = [0; 256];
    /// let len = navigator.save(7, into_slice(&mut bytes))?;
    /// let mut restored = Navigator::new(noise, 0.0, [0.0; 2])?;
    /// restored.restore(7, from_slice(&bytes[..len]))?;
    /// assert_eq!(restored, navigator);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The state is damaged, or the sink returns an error.
    pub fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        if !self.is_sound() {
            return Err(SaveError::Damaged(Flaw::Pose));
        }
        let head = Head { shape: shape::<T>(kind), flags: 0, len: 0, sizes: [0; 3] };
        write(head, self, [&mut [], &mut []], sink)
    }

    /// Continues from a [snapshot](Self::save), with the noise of this navigator.
    ///
    /// # Errors
    /// The bytes are not a snapshot of a navigator, or they are damaged or truncated; the navigator is unchanged.
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let head = checked(&mut source, shape::<T>(kind))?;
        let mut reader = Reader::behind(&head, &mut source);
        let mut restored = *self;
        let [outliers, z_outliers, turns] = core::array::from_fn(|_| reader.word());
        // The counts have 16 bits; the snapshot stores them in 32.
        let [outliers, z_outliers] = [outliers, z_outliers].map(|count| Outliers(count as u16));
        (restored.velocity.outliers, restored.velocity.z_outliers) = (outliers, z_outliers);
        restored.velocity.state =
            Kalman { mean: reader.vector(), covariance: Symmetric::from_fn(|_, _| reader.scalar()) };
        (restored.roll_rad, restored.pitch_rad) = (reader.scalar(), reader.scalar());
        let rate = Reading { value: reader.scalar(), sigma: reader.scalar() };
        restored.yaw_rate_radps = (turns != 0).then_some(rate);
        reader.end()?;
        if !restored.is_sound() {
            return Err(RestoreError::Flawed(Flaw::Pose));
        }
        *self = restored;
        Ok(head.len())
    }

    /// Whether all numbers are finite and no variance is negative.
    fn is_sound(&self) -> bool {
        let Kalman { mean, covariance } = &self.velocity.state;
        let rate = self.yaw_rate_radps.unwrap_or(Reading { value: T::ZERO, sigma: T::ZERO });
        let numbers = [self.roll_rad, self.pitch_rad, rate.value, rate.sigma];
        let variances = (0..4).all(|k| covariance.get(k, k) >= T::ZERO);
        variances && covariance.is_finite() && numbers.iter().chain(mean.as_slice()).all(|number| number.is_finite())
    }
}

/// The state that changes during operation.
impl<T: Real> Walk for Navigator<T> {
    fn walk(&self, visit: &mut impl Visit) {
        let state = &self.velocity.state;
        visit.word(u32::from(self.velocity.outliers.0));
        visit.word(u32::from(self.velocity.z_outliers.0));
        visit.word(u32::from(self.yaw_rate_radps.is_some()));
        for &number in state.mean.as_slice().iter().chain(state.covariance.as_lower()) {
            visit.scalar(number);
        }
        let rate = self.yaw_rate_radps.unwrap_or(Reading { value: T::ZERO, sigma: T::ZERO });
        for number in [self.roll_rad, self.pitch_rad, rate.value, rate.sigma] {
            visit.scalar(number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::velocity_filter::tests::NOISE;
    use crate::{Instruments, Navigator, Reading, RestoreError, VelocityNoise, from_slice, into_slice};

    /// A navigator after several rows, one of them with an outlier.
    fn under_way() -> Navigator<f64> {
        let mut navigator = Navigator::new(NOISE, -2.0, [0.1, 0.0]).unwrap();
        for (step, velocity) in [0.3, 0.31, 5.0, 0.32].into_iter().enumerate() {
            let row = Instruments {
                roll_rad: 0.01 * step as f64,
                pitch_rad: -0.02,
                yaw_rate_radps: Reading { value: 0.1, sigma: 0.02 },
                velocity_mps: (step < 3).then_some([velocity, 0.01, 0.0]),
                z_m: (step > 1).then_some(-2.0 - 0.01 * step as f64),
            };
            navigator.instruments(&row, 0.1).unwrap();
        }
        navigator
    }

    #[test]
    fn a_restored_navigator_continues_with_the_same_bits_and_every_changed_bit_is_detected() {
        let navigator = under_way();
        let mut bytes = [0; 256];
        let len = navigator.save(5, into_slice(&mut bytes)).unwrap();
        // Head, three words, four numbers and ten of their covariance, four of the attitude, checksum.
        assert_eq!(len, 36 + 12 + 8 * (4 + 10 + 4) + 4);
        // The noise is not part of the snapshot.
        let fresh = Navigator::new(VelocityNoise { z_sigma_m: NOISE.z_sigma_m, ..NOISE }, 0.0, [0.0; 2]).unwrap();
        let mut restored = fresh;
        assert_eq!(restored.restore(5, from_slice(&bytes[..len])), Ok(len));
        assert_eq!(restored, navigator);
        for bit in 0..8 * len {
            let mut damaged = bytes;
            damaged[bit / 8] ^= 1 << (bit % 8);
            let mut other = fresh;
            assert!(other.restore(5, from_slice(&damaged[..len])).is_err(), "bit {bit}");
            assert_eq!(other, fresh);
        }
        let mut other = fresh;
        assert_eq!(other.restore(6, from_slice(&bytes[..len])), Err(RestoreError::Kind { found: 5 }));
    }
}
