//! Noise of the range that grows with the range.

use super::{ModelError, NoiseModel, RangeBearing, Sensor, require};
use crate::{Real, Symmetric};
use nalgebra::Vector2;

/// The noise of a [`RangeBearing`] sensor in [`WithNoise`](super::WithNoise) whose standard deviation of the range grows with the
/// predicted range r: the variance is that of the sensor and (ratio r)². With a ratio of 0 it is the sensor alone, to the bit.
///
/// Occlusion is decided with the noise of the sensor, without the ratio.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{RangeBearing, RangeNoise, Sensor, WithNoise};
///
/// let radar = WithNoise { sensor: RangeBearing::new(0.3_f32, 0.02)?, noise: RangeNoise::new(0.02)? };
/// let far = radar.noise_of(&Vector2::new(19.0, 0.1), &Vector2::new(20.0, 0.1)).unwrap();
/// assert!((far.get(0, 0) - (0.3 * 0.3 + 0.4 * 0.4)).abs() < 1e-6);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeNoise<T> {
    ratio: T,
}

impl<T: Real> RangeNoise<T> {
    /// A standard deviation of this ratio to the range, dimensionless, which adds to that of the sensor in quadrature.
    ///
    /// # Errors
    /// The ratio must lie between 0 and 1.
    pub fn new(ratio: T) -> Result<Self, ModelError> {
        require(ratio >= T::ZERO && ratio <= T::ONE, "range_sigma_ratio", "between 0 and 1")?;
        Ok(Self { ratio })
    }
}

impl<T: Real> NoiseModel<RangeBearing<T>> for RangeNoise<T> {
    /// `None` with a ratio of 0.
    fn covariance(
        &self,
        sensor: &RangeBearing<T>,
        _measured: &Vector2<T>,
        expected: &Vector2<T>,
    ) -> Option<Symmetric<Vector2<T>>> {
        if self.ratio == T::ZERO {
            return None;
        }
        let growing = self.ratio * expected.x;
        Some(sensor.noise().plus(&Symmetric::from_diagonal([growing * growing, T::ZERO])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::WithNoise;

    fn sensor(ratio: f64) -> WithNoise<RangeBearing<f64>, RangeNoise<f64>> {
        WithNoise { sensor: RangeBearing::new(0.3, 0.02).unwrap(), noise: RangeNoise::new(ratio).unwrap() }
    }

    #[test]
    fn variances_add_at_the_predicted_range() {
        for range in [0.1, 2.0, 40.0] {
            let noise = sensor(0.05).noise_of(&Vector2::new(7.0, 1.0), &Vector2::new(range, -2.0)).unwrap();
            assert!((noise.get(0, 0) - (0.09 + 0.0025 * range * range)).abs() < 1e-13);
            assert_eq!((noise.get(0, 1), noise.get(1, 1)), (0.0, sensor(0.0).noise().get(1, 1)));
        }
    }

    #[test]
    fn a_ratio_of_0_is_the_sensor_alone() {
        let z = Vector2::new(7.0, 1.0);
        assert_eq!(sensor(0.0).noise_of(&z, &z), None);
    }

    #[test]
    fn a_ratio_out_of_range_is_refused() {
        for ratio in [-0.01, 1.01, f64::NAN, f64::INFINITY] {
            let error = RangeNoise::new(ratio).unwrap_err();
            assert_eq!((error.field, error.range), ("range_sigma_ratio", "between 0 and 1"));
        }
        assert!(RangeNoise::new(1.0).is_ok());
    }
}
