//! Clutter: false measurements of a sensor.

use super::{ModelError, require};
use crate::{Real, Vector, Zero};

/// The intensity κ(z) of clutter (4.51).
pub trait Clutter<Z: Vector> {
    /// Checks the parameters of the model. [`Detector::new`](crate::Detector::new) and
    /// [`Detector::retune`](crate::Detector::retune) call it.
    ///
    /// # Errors
    /// Names the first parameter out of range, and its range. No errors by default.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// ln κ(z), with κ per unit of measurement space (1/(m·rad) for range and bearing); −∞ for no clutter.
    fn ln_intensity(&self, measurement: &Z) -> Z::Scalar;

    /// λ, the expected number of false measurements per scan; zero if unknown.
    fn per_scan(&self) -> Z::Scalar {
        Z::Scalar::ZERO
    }
}

/// Whether this is a valid number of expected false measurements: sums over all scans must stay finite.
fn is_rate<T: Real>(per_scan: T) -> bool {
    per_scan >= T::ZERO && per_scan <= T::from_f64(1e9)
}

/// Uniform clutter: the same intensity everywhere in the window.
///
/// ```
/// use scphd::models::{RangeBearingWindow, UniformClutter};
///
/// let window = RangeBearingWindow::full_circle(15.0_f64, 0.95)?;
/// let clutter = UniformClutter::of_scan(20.0, window.measure())?;
/// let kappa = 20.0 / (15.0 * core::f64::consts::TAU);
/// assert!((clutter.intensity() - kappa).abs() < 1e-15);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UniformClutter<T> {
    ln_intensity: T,
    per_scan: T,
}

impl<T: Real> UniformClutter<T> {
    /// λ false measurements per scan, uniform over a window of this measure in measurement space
    /// ([`RangeBearingWindow::measure`](super::RangeBearingWindow::measure), m·rad).
    ///
    /// # Errors
    /// λ must be at most 1e9 and not negative, the measure finite, positive, and large enough for a finite intensity.
    pub fn of_scan(clutter_per_scan: T, window_measure: T) -> Result<Self, ModelError> {
        let (rate, measure) = (clutter_per_scan, window_measure);
        require(is_rate(rate), "clutter_per_scan", "between 0 and 1e9")?;
        require(measure > T::ZERO && measure.is_amount(), "window_measure", "finite and positive")?;
        let intensity = rate / measure;
        require(intensity.is_finite(), "window_measure", "large enough for a finite intensity")?;
        Ok(Self { ln_intensity: intensity.ln(), per_scan: rate })
    }

    /// κ, per unit of measurement space.
    pub fn intensity(&self) -> T {
        self.ln_intensity.exp()
    }
}

impl<T: Real, Z: Vector<Scalar = T>> Clutter<Z> for UniformClutter<T> {
    fn ln_intensity(&self, _measurement: &Z) -> T {
        self.ln_intensity
    }

    fn per_scan(&self) -> T {
        self.per_scan
    }
}

#[cfg(test)]
mod tests {
    use super::UniformClutter;

    #[test]
    fn invalid_rates_are_refused() {
        assert!(UniformClutter::of_scan(20.0_f32, 94.0).is_ok() && UniformClutter::of_scan(0.0_f32, 94.0).is_ok());
        for rate in [-1.0, f32::NAN, f32::INFINITY, f32::MAX] {
            assert_eq!(UniformClutter::of_scan(rate, 94.0).unwrap_err().field, "clutter_per_scan");
        }
        for measure in [0.0, -1.0, f32::NAN, 1e-40] {
            assert_eq!(UniformClutter::of_scan(20.0, measure).unwrap_err().field, "window_measure");
        }
    }
}
