//! Noise of the two controls of a planar vehicle.

use super::{ModelError, Pose, TangentOf, require};
use crate::numerics::vector::applied;
use crate::{Linear, Noise, Real, Symmetric, Vector};
use nalgebra::Vector2;

/// Zero-mean Gaussian noise of a speed and of a second control (steering angle or turn rate), section 5.3.1.
///
/// Odometry errors of real vehicles (scale, offset, slip) are correlated in time; noise that is drawn independently for every
/// sample averages out, the faster the higher the rate of the odometry. `interval_s` is the correlation time: a prediction
/// multiplies the standard deviation by √(interval/dt), so that the poses spread exactly as with errors that are constant over each
/// interval, at any rate. The drawn value is an error of the displacement and is added to it, because as a control it may be far
/// beyond the limits of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlNoise<T> {
    /// Standard deviation of the speed, m/s, independent of the speed.
    pub speed_sigma_mps: T,
    /// Standard deviation of the speed relative to the speed: scale error and slip. Adds in quadrature.
    pub speed_sigma_ratio: T,
    /// Standard deviation of the second control, independent of its value: steering angle, rad, or turn rate, rad/s.
    pub turn_sigma: T,
    /// Standard deviation of the second control relative to its value. Adds in quadrature.
    pub turn_sigma_ratio: T,
    /// Correlation time of an error, s. Zero: one independent draw per prediction, as in the thesis.
    pub interval_s: T,
}

impl<T: Real> ControlNoise<T> {
    /// No noise.
    pub const NONE: Self = Self::white(T::ZERO, T::ZERO);

    /// White noise with constant standard deviations, one draw per prediction, as in the thesis: of the speed, m/s, and of the
    /// second control (steering angle, rad, or turn rate, rad/s).
    pub const fn white(speed_sigma_mps: T, turn_sigma: T) -> Self {
        Self { speed_sigma_mps, speed_sigma_ratio: T::ZERO, turn_sigma, turn_sigma_ratio: T::ZERO, interval_s: T::ZERO }
    }

    /// Preset for a wheeled vehicle whose noise is unknown: 0.02 m/s and 10 % of the speed, 0.02 rad/s (or rad of steering) and 10
    /// % of it, each with a correlation time of half a second. The constant parts matter on straight paths, where the relative
    /// noise of a turn rate near zero vanishes. The simulator, C and Python have the same defaults.
    pub fn wheeled() -> Self {
        let of = T::from_f64;
        Self {
            speed_sigma_ratio: of(0.1),
            turn_sigma_ratio: of(0.1),
            interval_s: of(0.5),
            ..Self::white(of(0.02), of(0.02))
        }
    }

    /// Whether there is no noise: the predicted pose is then that of the odometry.
    pub fn is_none(&self) -> bool {
        [self.speed_sigma_mps, self.speed_sigma_ratio, self.turn_sigma, self.turn_sigma_ratio]
            .iter()
            .all(|&sigma| sigma == T::ZERO)
    }

    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// Every field must be finite and not negative.
    #[inline(never)]
    pub fn check(&self) -> Result<(), ModelError> {
        require(self.speed_sigma_mps.is_amount(), "speed_sigma_mps", "finite and not negative")?;
        require(self.speed_sigma_ratio.is_amount(), "speed_sigma_ratio", "finite and not negative")?;
        require(self.turn_sigma.is_amount(), "turn_sigma", "finite and not negative")?;
        require(self.turn_sigma_ratio.is_amount(), "turn_sigma_ratio", "finite and not negative")?;
        require(self.interval_s.is_amount(), "interval_s", "finite and not negative")
    }

    /// Whether errors are correlated in time.
    pub(super) fn lasts(&self) -> bool {
        self.interval_s > T::ZERO
    }

    /// Standard deviations of one draw, for these controls.
    pub(super) fn sigmas(&self, [speed, turn]: [T; 2], dt: T) -> [T; 2] {
        let raise = if self.lasts() && dt > T::ZERO { (self.interval_s / dt).sqrt() } else { T::ONE };
        let sigma = |constant: T, ratio: T, control: T| {
            let share = ratio * control;
            (constant * constant + share * share).sqrt() * raise
        };
        [
            sigma(self.speed_sigma_mps, self.speed_sigma_ratio, speed),
            sigma(self.turn_sigma, self.turn_sigma_ratio, turn),
        ]
    }

    /// Draws from the transition density of a prediction over `dt` seconds: for [`Motion::sample`](crate::Motion::sample) of a
    /// user's model. `moved` is f(x, u) for given controls, `by_control` its derivative ∂f/∂u there.
    ///
    /// Correlated errors are added to the pose, f(x, u) ⊕ (∂f/∂u) n, with [`covariance`](Self::covariance). If `interval_s` is 0,
    /// errors are added to the controls, f(x, u + n), and `by_control` is not called.
    #[must_use]
    pub fn sample<P: Pose<Scalar = T>>(
        &self,
        control: [T; 2],
        dt: T,
        noise: &mut Noise,
        moved: impl FnOnce([T; 2]) -> P,
        by_control: impl FnOnce() -> Linear<TangentOf<P>, Vector2<T>>,
    ) -> P {
        let (control, sigmas) = (Vector2::from(control), Vector2::from(self.sigmas(control, dt)));
        drawn(self.lasts(), control, &sigmas, noise, |control| moved(control.into()), by_control)
    }

    /// Covariance Σ_u of one draw: for [`Motion::linearise`](crate::Motion::linearise) of a user's model.
    #[must_use]
    pub fn covariance(&self, control: [T; 2], dt: T) -> Symmetric<Vector2<T>> {
        Symmetric::from_diagonal(self.sigmas(control, dt).map(|sigma| sigma * sigma))
    }
}

/// Draws errors with these standard deviations, and adds them to the pose if they are correlated, otherwise to the control.
pub(super) fn drawn<P: Pose, C: Vector<Scalar = P::Scalar>>(
    lasts: bool,
    control: C,
    sigmas: &C,
    noise: &mut Noise,
    moved: impl FnOnce(C) -> P,
    by_control: impl FnOnce() -> Linear<P::Tangent, C>,
) -> P {
    let errors = C::with(|k| sigmas.at(k) * noise.normal::<P::Scalar>());
    if lasts {
        moved(control).displaced(&applied::<P::Tangent, C>(&by_control(), &errors))
    } else {
        moved(control + errors)
    }
}

#[cfg(test)]
mod tests {
    use super::ControlNoise;
    use crate::{Motion, Noise, PlanarPose, Step, Unicycle, UnicycleControl};

    /// Standard deviation of the position of a vehicle at rest after `seconds`, over many draws.
    fn spread_after(noise: ControlNoise<f64>, dt: f64, seconds: f64) -> f64 {
        let mut stream = Noise::seeded(3);
        let robot = Unicycle::new(Step::Euler, noise).unwrap();
        let (steps, runs) = ((seconds / dt).round() as usize, 2000);
        let stands = UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 };
        let start = PlanarPose::new(0.0, 0.0, 0.0);
        let mut driven = || (0..steps).fold(start, |pose, _| robot.sample(&pose, &stands, dt, &mut stream)).x_m;
        let sum: f64 = (0..runs).map(|_| driven().powi(2)).sum();
        (sum / f64::from(runs)).sqrt()
    }

    /// Also for predictions that are longer than the correlation time.
    #[test]
    fn spread_does_not_depend_on_the_rate() {
        let noise = ControlNoise { interval_s: 0.4, ..ControlNoise::white(0.5, 0.0) };
        // Five independent errors of 0.5 m/s with a duration of 0.4 s each.
        let expected = 0.5 * 0.4 * 5.0_f64.sqrt();
        for dt in [0.025, 0.1, 0.4, 1.0, 2.0] {
            let measured = spread_after(noise, dt, 2.0);
            assert!((measured / expected - 1.0).abs() < 0.08, "dt {dt}: {measured} against {expected}");
        }
    }

    /// In the order of the control's elements.
    #[test]
    fn errors_are_added_to_the_control() {
        let (sigmas, start, dt) = ([0.5, 0.2], PlanarPose::new(1.0, 2.0, 0.3), 0.1);
        let robot = Unicycle::new(Step::Arc, ControlNoise::white(sigmas[0], sigmas[1])).unwrap();
        let control = UnicycleControl { speed_mps: 2.0, rate_radps: 0.4 };
        let mut stream = Noise::seeded(5);
        let [speed, rate] = sigmas.map(|sigma| sigma * stream.normal::<f64>());
        let wrong = UnicycleControl { speed_mps: 2.0 + speed, rate_radps: 0.4 + rate };
        assert_eq!(robot.sample(&start, &control, dt, &mut Noise::seeded(5)), robot.propagate(&start, &wrong, dt));
    }

    #[test]
    fn constant_and_relative_noise_add_in_quadrature() {
        let noise = ControlNoise { speed_sigma_ratio: 0.2, turn_sigma_ratio: 0.5, ..ControlNoise::white(0.3, 0.0) };
        let covariance = noise.covariance([2.0, -0.1], 0.1);
        assert!((covariance.get(0, 0) - 0.25_f64).abs() < 1e-15 && (covariance.get(1, 1) - 0.0025).abs() < 1e-15);
        // At rest only the constant part remains.
        assert!((noise.covariance([0.0, 0.0], 0.1).get(0, 0) - 0.09).abs() < 1e-15);
    }

    #[test]
    fn fields_are_checked() {
        assert!(ControlNoise::<f32>::NONE.check().is_ok());
        let bad = ControlNoise { turn_sigma: f32::NAN, ..ControlNoise::NONE };
        assert_eq!(bad.check().unwrap_err().field, "turn_sigma");
    }
}
