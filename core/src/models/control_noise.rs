//! Noise of a planar vehicle's two controls.

use super::{ModelError, Pose, TangentOf, require};
use crate::numerics::vector::applied;
use crate::{Linear, Noise, Real, Symmetric, Vector};
use nalgebra::Vector2;

/// Zero-mean Gaussian noise on a speed and on a second control (steering angle or turn rate), section 5.3.1.
///
/// Odometry errors of real vehicles persist (scale, offset, slip); noise drawn anew for every sample averages
/// itself away the faster the odometry comes. `interval_s` says for how long an error lasts: a prediction draws
/// with a standard deviation multiplied by √(interval/dt), which spreads the poses exactly as far as errors held
/// over the interval each would, whatever the rate of the odometry. What is drawn so is an error of the displacement,
/// and is added as one: as a control it may be far beyond what a vehicle can have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlNoise<T> {
    /// Standard deviation of the speed, m/s, whatever the speed is.
    pub speed_sigma_mps: T,
    /// Standard deviation of the speed as a share of it: scale error and slip. Adds in quadrature.
    pub speed_sigma_ratio: T,
    /// Standard deviation of the second control, whatever it is: steering angle, rad, or turn rate, rad/s.
    pub turn_sigma: T,
    /// Standard deviation of the second control as a share of it. Adds in quadrature.
    pub turn_sigma_ratio: T,
    /// How long an error lasts, s. Zero: one independent draw a prediction, as the thesis has it.
    pub interval_s: T,
}

impl<T: Real> ControlNoise<T> {
    /// No noise at all.
    pub const NONE: Self = Self::white(T::ZERO, T::ZERO);

    /// Independent noise of constant standard deviations, one draw a prediction, as the thesis has it: of the speed, m/s,
    /// and of the second control (steering angle, rad, or turn rate, rad/s).
    #[must_use]
    pub const fn white(speed_sigma_mps: T, turn_sigma: T) -> Self {
        Self { speed_sigma_mps, speed_sigma_ratio: T::ZERO, turn_sigma, turn_sigma_ratio: T::ZERO, interval_s: T::ZERO }
    }

    /// The preset for a wheeled vehicle whose noise nobody has measured: 0.02 m/s and 10 % of the speed, 0.02 rad/s (or rad of steering) and
    /// 10 % of it, each for half a second. The constant parts matter on straight ways, where the share of a turn rate near zero is
    /// nothing. The simulator, C and Python start from the same numbers.
    #[must_use]
    pub fn wheeled() -> Self {
        let of = T::from_f64;
        Self {
            speed_sigma_ratio: of(0.1),
            turn_sigma_ratio: of(0.1),
            interval_s: of(0.5),
            ..Self::white(of(0.02), of(0.02))
        }
    }

    /// Whether there is no noise at all: the pose then follows the odometry blindly.
    #[must_use]
    pub fn is_none(&self) -> bool {
        [self.speed_sigma_mps, self.speed_sigma_ratio, self.turn_sigma, self.turn_sigma_ratio]
            .iter()
            .all(|&sigma| sigma == T::ZERO)
    }

    /// The field that is out of range, if any.
    ///
    /// # Errors
    /// Every field must be finite and not negative.
    pub fn check(&self) -> Result<(), ModelError> {
        let usable = |x: T| x >= T::ZERO && x.is_finite();
        require(usable(self.speed_sigma_mps), "speed_sigma_mps", "finite and not negative")?;
        require(usable(self.speed_sigma_ratio), "speed_sigma_ratio", "finite and not negative")?;
        require(usable(self.turn_sigma), "turn_sigma", "finite and not negative")?;
        require(usable(self.turn_sigma_ratio), "turn_sigma_ratio", "finite and not negative")?;
        require(usable(self.interval_s), "interval_s", "finite and not negative")
    }

    /// Whether errors last for longer than a prediction.
    pub(super) fn lasts(&self) -> bool {
        self.interval_s > T::ZERO
    }

    /// Standard deviations of one draw, for controls of this size.
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

    /// A draw from the transition density of a prediction over `dt` seconds: for [`Motion::sample`](crate::Motion::sample) of a model of
    /// one's own. `moved` is f(x, u) of both controls, `by_control` its derivative ∂f/∂u at these.
    ///
    /// Errors that last are added to the pose, f(x, u) ⊕ (∂f/∂u) n, as [`covariance`](Self::covariance) has them. Where `interval_s` is 0
    /// they are errors of the controls, f(x, u + n), and `by_control` is not asked.
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

    /// Covariance Σ_u of one draw: for [`Motion::linearise`](crate::Motion::linearise) of a model of one's own.
    #[must_use]
    pub fn covariance(&self, control: [T; 2], dt: T) -> Symmetric<Vector2<T>> {
        Symmetric::from_diagonal(self.sigmas(control, dt).map(|sigma| sigma * sigma))
    }
}

/// A draw with errors of these standard deviations, added to the pose where they last, otherwise to the control.
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

    /// How far a vehicle that stands has come after `seconds`: standard deviation over many draws.
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

    /// By longer predictions than the error lasts, too.
    #[test]
    fn spread_does_not_hang_on_the_rate() {
        let noise = ControlNoise { interval_s: 0.4, ..ControlNoise::white(0.5, 0.0) };
        // Five independent errors of 0.5 m/s held for 0.4 s each.
        let expected = 0.5 * 0.4 * 5.0_f64.sqrt();
        for dt in [0.025, 0.1, 0.4, 1.0, 2.0] {
            let measured = spread_after(noise, dt, 2.0);
            assert!((measured / expected - 1.0).abs() < 0.08, "dt {dt}: {measured} against {expected}");
        }
    }

    /// In the order of the control's numbers.
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
    fn shares_add_in_quadrature() {
        let noise = ControlNoise { speed_sigma_ratio: 0.2, turn_sigma_ratio: 0.5, ..ControlNoise::white(0.3, 0.0) };
        let covariance = noise.covariance([2.0, -0.1], 0.1);
        assert!((covariance.get(0, 0) - 0.25_f64).abs() < 1e-15 && (covariance.get(1, 1) - 0.0025).abs() < 1e-15);
        // At rest only the constant part is left.
        assert!((noise.covariance([0.0, 0.0], 0.1).get(0, 0) - 0.09).abs() < 1e-15);
    }

    #[test]
    fn fields_are_checked() {
        assert!(ControlNoise::<f32>::NONE.check().is_ok());
        let bad = ControlNoise { turn_sigma: f32::NAN, ..ControlNoise::NONE };
        assert_eq!(bad.check().unwrap_err().field, "turn_sigma");
    }
}
