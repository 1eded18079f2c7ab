//! A planar vehicle with online calibration of its odometry.

use super::{CalibratedPose, Linearised, ModelError, Motion, OdometryCorrection, PlanarPose, ScalarOf, require};
use crate::{Matrix, Noise, Rates, Real, Symmetric};
use nalgebra::{Matrix3, SVector};

/// A planar motion model with derivatives with respect to the odometry correction, as [`SelfCalibrating`] needs it.
pub trait ByOdometry: Motion {
    /// The corrected control.
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<ScalarOf<Self::Pose>>) -> Self::Control;

    /// Derivatives of x, y and heading of f(x, u) with respect to `speed_scale`, `turn_scale` and `turn_offset`, at this correction
    /// of the control.
    fn by_odometry(
        &self,
        pose: &Self::Pose,
        control: &Self::Control,
        corrected: &Self::Control,
        dt: ScalarOf<Self::Pose>,
    ) -> Matrix3<ScalarOf<Self::Pose>>;
}

/// Prior of the odometry correction, and how constant it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryPrior<T> {
    /// Initial standard deviations of the correction.
    pub sigma: OdometryCorrection<T>,
    /// Time in which the random walk of the correction reaches the standard deviation `sigma`, s; infinite for a constant
    /// correction.
    pub lasts_s: T,
}

/// A planar vehicle with online calibration of its odometry: `M` with corrected controls. Scales and offset are coordinates of the
/// state, which follow a slow random walk; a joint map ([`JointSlam`](crate::JointSlam)) estimates them together with pose and
/// features. The noise of `M` is that of the remaining errors, for example slip. Sensors and fixes are those of a [`PlanarPose`] in
/// a [`Calibrated`](super::Calibrated).
///
/// ```
/// use scphd::models::{
///     Calibrated, CalibratedPose, ControlNoise, OdometryCorrection, OdometryPrior, PlanarPose, Pose, RangeBearing,
///     SelfCalibrating, Step, Unicycle, UnicycleControl,
/// };
/// use scphd::{JointConfig, JointSlam, joint_memory};
/// use nalgebra::Vector2;
///
/// joint_memory! { type Memory: SelfCalibrating<Unicycle<f64>, f64> { measurement: Vector2<f64>, features: 20, measurements: 16 } }
///
/// let robot = Unicycle::new(Step::Arc, ControlNoise { speed_sigma_ratio: 0.05, ..ControlNoise::white(0.01, 0.005) })?;
/// // Wheels within 5 % of their size, a gyroscope within 0.02 rad/s.
/// let sigma = OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 };
/// let robot = SelfCalibrating::new(robot, OdometryPrior { sigma, lasts_s: 3600.0 })?;
/// let mut memory = Memory::new();
/// let mut slam: JointSlam<'_, _, Vector2<f64>> = JointSlam::new(robot, JointConfig::default(), &mut memory)?;
/// slam.reset_within(CalibratedPose::at(PlanarPose::ZERO), &robot.prior())?;
/// slam.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 }, 0.1)?;
/// let lidar = Calibrated(RangeBearing::new(0.1, 0.01)?);
/// # let _ = lidar;
/// let scale = slam.estimate_pose().ok_or("not started")?.mean.odometry.speed_scale;
/// assert_eq!(scale, 0.0); // nothing measured yet
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfCalibrating<M, T> {
    vehicle: M,
    prior: OdometryPrior<T>,
}

impl<T: Real, M: ByOdometry<Pose = PlanarPose<T>>> SelfCalibrating<M, T> {
    /// A vehicle with this prior.
    ///
    /// # Errors
    /// Standard deviations must be finite and not negative, the time above 0.
    pub fn new(vehicle: M, prior: OdometryPrior<T>) -> Result<Self, ModelError> {
        let usable = |x: T| x >= T::ZERO && x.is_finite();
        require(usable(prior.sigma.speed_scale), "speed_scale", "finite and not negative")?;
        require(usable(prior.sigma.turn_scale), "turn_scale", "finite and not negative")?;
        require(usable(prior.sigma.turn_offset), "turn_offset", "finite and not negative")?;
        require(prior.lasts_s > T::ZERO, "lasts_s", "above 0")?;
        Ok(Self { vehicle, prior })
    }

    /// Initial covariance for `reset_within`: that of the prior for the odometry correction, zero for the pose.
    pub fn prior(&self) -> Symmetric<SVector<T, 6>> {
        let OdometryCorrection { speed_scale, turn_scale, turn_offset } = self.prior.sigma;
        let square = |x: T| x * x;
        Symmetric::from_diagonal([
            T::ZERO,
            T::ZERO,
            T::ZERO,
            square(speed_scale),
            square(turn_scale),
            square(turn_offset),
        ])
    }

    fn corrected(&self, pose: &CalibratedPose<T>, control: &M::Control) -> M::Control {
        M::corrected(control, &pose.odometry)
    }
}

impl<T: Real, M: ByOdometry<Pose = PlanarPose<T>>> Motion for SelfCalibrating<M, T> {
    type Pose = CalibratedPose<T>;
    type Control = M::Control;

    const TRANSLATION_INVARIANT: bool = M::TRANSLATION_INVARIANT;

    fn check(&self) -> Result<(), ModelError> {
        self.vehicle.check()
    }

    fn admits(&self, control: &M::Control) -> bool {
        self.vehicle.admits(control)
    }

    fn rates(&self, control: &M::Control) -> Rates<T> {
        self.vehicle.rates(control)
    }

    fn propagate(&self, pose: &CalibratedPose<T>, control: &M::Control, dt: T) -> CalibratedPose<T> {
        let control = self.corrected(pose, control);
        CalibratedPose { vehicle: self.vehicle.propagate(&pose.vehicle, &control, dt), odometry: pose.odometry }
    }

    fn sample(&self, pose: &CalibratedPose<T>, control: &M::Control, dt: T, noise: &mut Noise) -> CalibratedPose<T> {
        let control = self.corrected(pose, control);
        let vehicle = self.vehicle.sample(&pose.vehicle, &control, dt, noise);
        let walk = (dt / self.prior.lasts_s).sqrt();
        let OdometryCorrection { speed_scale, turn_scale, turn_offset } = self.prior.sigma;
        let mut walked = |from: T, sigma: T| from + sigma * walk * noise.normal();
        let odometry = OdometryCorrection {
            speed_scale: walked(pose.odometry.speed_scale, speed_scale),
            turn_scale: walked(pose.odometry.turn_scale, turn_scale),
            turn_offset: walked(pose.odometry.turn_offset, turn_offset),
        };
        CalibratedPose { vehicle, odometry }
    }

    fn linearise(&self, pose: &CalibratedPose<T>, control: &M::Control, dt: T) -> Linearised<SVector<T, 6>> {
        let corrected = self.corrected(pose, control);
        let Linearised { transition, noise } = self.vehicle.linearise(&pose.vehicle, &corrected, dt);
        let by_odometry = self.vehicle.by_odometry(&pose.vehicle, control, &corrected, dt);
        let (one, zero) = (T::ONE, T::ZERO);
        let at = |row: usize, column: usize| match (row < 3, column < 3) {
            (true, true) => Matrix::at(&transition, row, column),
            (true, false) => Matrix::at(&by_odometry, row, column - 3),
            (false, _) => {
                if row == column {
                    one
                } else {
                    zero
                }
            }
        };
        let walk = dt / self.prior.lasts_s;
        let prior = self.prior();
        let noise = Symmetric::from_fn(
            |row, column| {
                if row < 3 { noise.get(row, column) } else { prior.get(row, column) * walk }
            },
        );
        Linearised { transition: Matrix::with(at), noise }
    }
}

#[cfg(test)]
mod tests {
    use super::{OdometryPrior, SelfCalibrating};
    use crate::models::testing::off_by;
    use crate::{
        Ackermann, AckermannControl, AckermannGeometry, CalibratedPose, ControlNoise, Holonomic, HolonomicControl,
        Matrix, Motion, Noise, OdometryCorrection, PlanarPose, Pose, Step, Unicycle, UnicycleControl, Vector,
    };
    use nalgebra::SVector;

    const PRIOR: OdometryPrior<f64> = OdometryPrior {
        sigma: OdometryCorrection { speed_scale: 0.05, turn_scale: 0.04, turn_offset: 0.02 },
        lasts_s: 100.0,
    };

    fn pose() -> CalibratedPose<f64> {
        let odometry = OdometryCorrection { speed_scale: 0.03, turn_scale: -0.02, turn_offset: 0.01 };
        CalibratedPose { vehicle: PlanarPose::new(2.0, -1.0, 0.7), odometry }
    }

    fn check<M: Motion<Pose = CalibratedPose<f64>>>(motion: &M, control: &M::Control) {
        const STEP: f64 = 1e-6;
        let linearised = motion.linearise(&pose(), control, 0.2);
        for k in 0..6 {
            let at = |step: f64| {
                let by = <SVector<f64, 6> as Vector>::with(|row| if row == k { step } else { 0.0 });
                motion.propagate(&pose().displaced(&by), control, 0.2)
            };
            let slope = at(STEP).difference(&at(-STEP)) * (0.5 / STEP);
            let error = off_by(&slope, |row| Matrix::at(&linearised.transition, row, k));
            assert!(error < 1e-8, "column {k}: off by {error}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_motion() {
        let noise = ControlNoise { speed_sigma_ratio: 0.05, ..ControlNoise::white(0.1, 0.02) };
        let robot = SelfCalibrating::new(Unicycle::new(Step::Arc, noise).unwrap(), PRIOR).unwrap();
        check(&robot, &UnicycleControl { speed_mps: 1.5, rate_radps: -0.4 });
        let geometry =
            AckermannGeometry { wheelbase_m: 2.8, encoder_offset_m: 0.7, sensor_forward_m: 3.0, sensor_left_m: 0.5 };
        let car = SelfCalibrating::new(Ackermann::new(geometry, noise).unwrap(), PRIOR).unwrap();
        check(&car, &AckermannControl { speed_mps: 4.0, steering_rad: 0.3 });
        let mecanum = SelfCalibrating::new(Holonomic::new(noise).unwrap(), PRIOR).unwrap();
        check(&mecanum, &HolonomicControl { forward_mps: 0.9, left_mps: -1.2, rate_radps: 0.4 });
    }

    #[test]
    fn draws_have_the_covariance_of_the_linearised_motion() {
        let noise = ControlNoise::white(0.1, 0.05);
        let robot = SelfCalibrating::new(Unicycle::new(Step::Arc, noise).unwrap(), PRIOR).unwrap();
        let control = UnicycleControl { speed_mps: 1.5, rate_radps: -0.4 };
        let mean = robot.propagate(&pose(), &control, 0.2);
        let linearised = robot.linearise(&pose(), &control, 0.2);
        let (mut draws, mut squares) = (Noise::seeded(11), [0.0; 6]);
        let runs = 20_000;
        for _ in 0..runs {
            let off = robot.sample(&pose(), &control, 0.2, &mut draws).difference(&mean);
            squares.iter_mut().zip(off.iter()).for_each(|(sum, off)| *sum += off * off);
        }
        for (k, sum) in squares.iter().enumerate() {
            // The variance of this number of draws has a standard deviation of 1 %.
            let ratio = sum / f64::from(runs) / linearised.noise.get(k, k);
            assert!((ratio - 1.0).abs() < 0.05, "{k}: {ratio}");
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        let robot = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
        let bad = |prior: OdometryPrior<f64>| SelfCalibrating::new(robot, prior).unwrap_err().field;
        let sigma = |speed_scale| OdometryCorrection { speed_scale, ..PRIOR.sigma };
        assert_eq!(bad(OdometryPrior { sigma: sigma(f64::NAN), ..PRIOR }), "speed_scale");
        assert_eq!(bad(OdometryPrior { sigma: sigma(-0.1), ..PRIOR }), "speed_scale");
        assert_eq!(bad(OdometryPrior { lasts_s: 0.0, ..PRIOR }), "lasts_s");
    }
}
